//! Names of what a file is made of: the words of `formats/vademecum-1.md`, for messages and reports.
//!
//! Reports print them as JSON, so they are part of what other programs read, unlike the text of `Debug`.

use core::fmt;

use crate::element::{Codec, Element};
use crate::kind::SectionKind;
use crate::metadata::{AxisKind, AxisRole};
use crate::parameter::ParameterRole;

impl fmt::Display for SectionKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(self.name())
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
            Self::LossFactor { region } => write!(out, "LossFactor {region}"),
            Self::Damping { group } => write!(out, "Damping {group}"),
        }
    }
}
