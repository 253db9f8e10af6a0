//! Names of what a file is made of: the words of `formats/vademecum-1.md`, for messages and reports.
//!
//! Reports print them as JSON, so they are part of what other programs read, unlike the text of `Debug`.

use core::fmt;

use crate::metadata::{AxisKind, AxisRole};
use crate::parameter::ParameterRole;
use crate::section::{Codec, Element, SectionKind};

impl fmt::Display for SectionKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::NodeIds => "NodeIds",
            Self::NodeCoordinates => "NodeCoordinates",
            Self::Triangles => "Triangles",
            Self::ReducedStiffness => "ReducedStiffness",
            Self::Eigenvalues => "Eigenvalues",
            Self::SurfaceBasis => "SurfaceBasis",
            Self::InteriorBasis => "InteriorBasis",
            Self::BlockState => "BlockState",
            Self::BlockLoad => "BlockLoad",
            Self::PatternBasis => "PatternBasis",
            Self::PatternBlock => "PatternBlock",
            Self::PatternNames => "PatternNames",
            Self::ProbeNames => "ProbeNames",
            Self::ProbeRows => "ProbeRows",
            Self::SingularValues => "SingularValues",
            Self::ModeTable => "ModeTable",
            Self::AxisPoints => "AxisPoints",
            Self::Factors => "Factors",
            Self::RegionStiffness => "RegionStiffness",
            Self::RegionMass => "RegionMass",
            Self::EnrichmentHistory => "EnrichmentHistory",
            Self::RadiusSamples => "RadiusSamples",
            Self::CanonicalParts => "CanonicalParts",
            Self::CanonicalAxes => "CanonicalAxes",
            Self::CanonicalFactors => "CanonicalFactors",
            Self::CanonicalTerms => "CanonicalTerms",
            Self::CanonicalPositions => "CanonicalPositions",
            Self::CanonicalDirection => "CanonicalDirection",
            Self::CanonicalCertificate => "CanonicalCertificate",
            Self::Losses => "Losses",
            Self::Repairs => "Repairs",
            Self::StructureFigures => "StructureFigures",
            Self::DampingRatios => "DampingRatios",
            Self::ContactResidual => "ContactResidual",
            Self::ResidualPairs => "ResidualPairs",
            Self::PairResidual => "PairResidual",
            Self::ProbeResidual => "ProbeResidual",
            Self::PatternResidual => "PatternResidual",
            Self::PatternProbeResidual => "PatternProbeResidual",
            Self::StaticBound => "StaticBound",
            Self::BoundMap => "BoundMap",
            Self::FactorOrder => "FactorOrder",
            Self::FactorGroups => "FactorGroups",
            Self::FactorRows => "FactorRows",
            Self::FactorValues => "FactorValues",
            Self::PatternAnswer => "PatternAnswer",
            Self::StressPoints => "StressPoints",
            Self::StressBasis => "StressBasis",
            Self::StressResidual => "StressResidual",
            Self::PatternStress => "PatternStress",
            Self::ElasticConstants => "ElasticConstants",
            Self::ProbeUnits => "ProbeUnits",
            Self::SupportNames => "SupportNames",
            Self::SupportPoints => "SupportPoints",
            Self::ReactionBasis => "ReactionBasis",
            Self::ReactionLoads => "ReactionLoads",
            Self::PatternReaction => "PatternReaction",
            Self::BaseFrame => "BaseFrame",
            Self::RigidBody => "RigidBody",
            Self::StrainSizes => "StrainSizes",
            Self::StrainLinear => "StrainLinear",
            Self::StrainTail => "StrainTail",
            Self::StrainQuadratic => "StrainQuadratic",
            Self::StrainBox => "StrainBox",
            Self::StrainLimits => "StrainLimits",
            Self::StrainModes => "StrainModes",
        })
    }
}

impl fmt::Display for Element {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::U8 => "U8",
            Self::U32 => "U32",
            Self::U64 => "U64",
            Self::F32 => "F32",
            Self::F64 => "F64",
            Self::I16 => "I16",
        })
    }
}

impl fmt::Display for Codec {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::Raw => "Raw",
            Self::Zstd => "Zstd",
            Self::Shuffled => "Shuffled",
            Self::Delta => "Delta",
        })
    }
}

impl fmt::Display for AxisKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::Index => "Index",
            Self::Hat => "Hat",
            Self::Chebyshev => "Chebyshev",
        })
    }
}

/// The exponents of a monomial are left out.
impl fmt::Display for AxisRole {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::Stage => "Stage",
            Self::Monomial { .. } => "Monomial",
        })
    }
}

/// The role of one region has the number of the region behind it, counted from 0.
impl fmt::Display for ParameterRole {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stiffness => out.pad("Stiffness"),
            Self::RegionStiffness { region } => write!(out, "RegionStiffness {region}"),
            Self::Density => out.pad("Density"),
            Self::RegionDensity { region } => write!(out, "RegionDensity {region}"),
            Self::Alpha => out.pad("Alpha"),
            Self::Beta => out.pad("Beta"),
            Self::TimeStep => out.pad("TimeStep"),
        }
    }
}
