//! Capabilities of a stripped file.

use vademecum_format::SectionKind;

/// Capabilities of a stripped file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Stepping under load patterns, probe values, energy, live parameters. No fields, no contacts, no
    /// geometry.
    Probes,
    /// The same, and the surface: geometry, contacts, surface fields. No fields inside the body.
    Surface,
    /// Everything that is there.
    All,
}

/// As a sentence has it.
impl std::fmt::Display for Keep {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Probes => "the probes",
            Self::Surface => "the surface",
            Self::All => "everything",
        })
    }
}

impl Keep {
    /// True if a section stays.
    #[must_use]
    pub fn keeps(self, kind: SectionKind) -> bool {
        use SectionKind as S;
        let inside = kind == S::InteriorBasis;
        let for_people = matches!(
            kind,
            S::SingularValues
                | S::ModeTable
                | S::EnrichmentHistory
                | S::RadiusSamples
                | S::Losses
                | S::Repairs
                | S::StructureFigures
                | S::MeshError
                | S::LiveCertificate
                | S::LiveWitnesses
        );
        let surface = matches!(
            kind,
            S::NodeIds
                | S::NodeCoordinates
                | S::Triangles
                | S::Quadrangles
                | S::SurfaceBasis
                | S::BlockLoad
                | S::ContactResidual
                | S::ResidualPairs
                | S::PairResidual
                | S::ProbeResidual
                | S::PatternResidual
                | S::BoundMap
                | S::FactorOrder
                | S::FactorGroups
                | S::FactorRows
                | S::FactorValues
                | S::PatternAnswer
                | S::StressPoints
                | S::StressBasis
                | S::StressResidual
                | S::PatternStress
                | S::ElasticConstants
                | S::Compliance
                | S::EmbeddedNodes
                | S::EmbeddedWeights
                | S::EmbeddedTriangles
                | S::ReactionLoads
                | S::PortNames
                | S::PortTable
                | S::PortFrames
                | S::PortNodes
                | S::PortFacets
                | S::PortRows
                | S::PortCompliance
                | S::PortInertia
                | S::PortResidual
                | S::PortProbes
                | S::PortPatterns
                | S::ProbeMotions
                | S::ContactModes
                | S::PatchPairs
                | S::PatchResidual
                | S::ContactPatch
                | S::LiveResidual
        );
        match self {
            Self::Probes => !(inside || surface || for_people),
            Self::Surface => !inside,
            Self::All => true,
        }
    }

    /// Sections without which the promise would be empty.
    pub(crate) fn needs(self) -> &'static [SectionKind] {
        match self {
            Self::Probes => &[SectionKind::ProbeRows],
            Self::Surface => {
                &[SectionKind::SurfaceBasis, SectionKind::NodeCoordinates, SectionKind::Triangles]
            }
            Self::All => &[],
        }
    }
}
