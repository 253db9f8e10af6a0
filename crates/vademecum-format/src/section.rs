//! Sections: what kinds there are, which shape and element each has, and how their numbers are read.
//!
//! Numbers are read with `from_le_bytes` from byte arrays (`as_chunks`), which vectorises like a slice and
//! needs neither alignment nor a cast. The odd thing: a section's checksum is not looked at when a file is
//! opened, so that opening does not touch every page of a mapped file; call [`Section::verify`] for that.

use crate::checksum::checksum;
use crate::error::FormatError;
use crate::metadata::Metadata;
use crate::quantised::{self, Quantised};

/// Numbers in a row of the table of axes: role, index, lower, upper, points, factor.
pub const CHAPTER_AXIS: usize = 6;
/// Numbers of the certificate before those of the stages: the seven of a structure, and the step the
/// trajectory left at.
pub const CHAPTER_CERTIFICATE: usize = 8;

/// The kind of a section. Shapes use `r = n_modes`; row-major, last number fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[non_exhaustive]
pub enum SectionKind {
    /// Node ids of the mesh file, `u64 (n_nodes)`, in the file's node order.
    NodeIds = 1,
    /// Coordinates \[m\], `f32|f64 (n_nodes, 3)`.
    NodeCoordinates = 2,
    /// Surface triangles, `u32 (n_triangles, 3)`, outward, over surface nodes, loadable ones first.
    Triangles = 3,
    /// `BᵀKB` \[1/s²\], `f64 (r, r)`.
    ReducedStiffness = 4,
    /// Ritz values `λ_k` \[rad²/s²\], `f64 (r)`.
    Eigenvalues = 5,
    /// Rows of `B` \[kg^-½\] at surface nodes, `f32|f64|i16 (n_surface_nodes, 3, r)`.
    SurfaceBasis = 6,
    /// Rows of `B` at interior nodes, `f32|f64|i16 (n_nodes − n_surface_nodes, 3, r)`.
    InteriorBasis = 7,
    /// Space part `E_t` of `C − I`, `C = BᵀM_0 (M + θK)⁻¹ M B`, `f64 (n_terms, r, r)`, row-major; not
    /// symmetric once a region's density differs from what the basis was normalised with (`M_0`).
    BlockState = 8,
    /// Space part of `H − B`, `H = (M + θK)⁻¹ M_0 B`, at loadable dofs,
    /// `f32|f64|i16 (n_load_nodes, n_terms, 3·r)`: the components, then the columns.
    BlockLoad = 9,
    /// `BᵀF_p`, `f64 (n_patterns, r)`.
    PatternBasis = 10,
    /// Space part of `(H − B)ᵀF_p`, `f64 (n_patterns, n_terms, r)`.
    PatternBlock = 11,
    /// Names of the patterns, UTF-8, one a line.
    PatternNames = 12,
    /// Names of the probes, UTF-8, one a line.
    ProbeNames = 13,
    /// Row of `B` that gives each probe's value, `f64 (n_probes, r)`.
    ProbeRows = 14,
    /// Singular values of the snapshots, `f64 (any)`.
    SingularValues = 15,
    /// Per mode: frequency \[Hz\], Rayleigh quotient \[rad²/s²\], energy share, physical damping ratio,
    /// numerical damping ratio, period elongation; `f64 (r, 6)`.
    ModeTable = 16,
    /// Points of all axes, one after the other, `f64 (Σ n_points)`.
    AxisPoints = 17,
    /// Factors of all axes, one after the other, each `(n_terms, n_points)`; `f64 (n_terms · Σ n_points)`.
    Factors = 18,
    /// `BᵀK_qB` \[1/s²\] of each region at scale 1, `f64 (n_regions, r, r)`; they sum to `BᵀKB`.
    RegionStiffness = 19,
    /// `BᵀM_qB` of each region at scale 1, `f64 (n_regions, r, r)`; they sum to the identity.
    RegionMass = 20,
    /// Terms, and the error they leave at fresh points, after each enrichment of the separated solution;
    /// `f64 (any, 2)`. Since 1.1.
    EnrichmentHistory = 21,
    /// Points of the parameters' box, each its values and the spectral radius of the fused block step there;
    /// `f64 (any, n_parameters + 1)`. Since 1.1.
    RadiusSamples = 22,
    /// Parts of the canonical structure: stage, number of axes, number of terms; `u32 (any, 3)`. Version 1.1,
    /// as all below.
    CanonicalParts = 23,
    /// Axes of the parts, one part after the other: role, index, lower, upper, points, factor;
    /// `f64 (any, 6)`.
    CanonicalAxes = 24,
    /// Factors of the parts' axes, each `(n_points, n_terms)`; `f64 (any)`.
    CanonicalFactors = 25,
    /// `ΠF_t` of the parts' terms, `f64 (any, r)`.
    CanonicalTerms = 26,
    /// Loadable nodes the load can stand at, `u32 (any)`.
    CanonicalPositions = 27,
    /// Direction of the load, `f64 (3)`; absent when its components are axes.
    CanonicalDirection = 28,
    /// What the build measured of it: the numbers of a structure's certificate, the step at which the
    /// trajectory left a range (NaN: never), and per stage the relative error of the map, of its state and of
    /// its load part; `f64 (8 + 3 n_stages)`.
    CanonicalCertificate = 29,
    /// What rewriting cost, for people: kind, relative error of displacement fields, of velocity fields,
    /// largest of any mode; `f64 (any, 4)`. Since version 1.1.
    Losses = 30,
    /// What a build did to make an unstable step stable, for people: UTF-8, one repair a line. Since
    /// version 1.1.
    Repairs = 31,
    /// What a build measured of its structures beside the certificate, for people: largest error ÷ floor of
    /// any run, defect of reciprocity, growth of energy; `f64 (3, 3)`, a row for the diagonal, the block and
    /// the canonical structure, NaN where it was not measured. Since version 1.2.
    StructureFigures = 32,
    /// Damping ratio of each mode beside Rayleigh's, `f64 (r)`. Only exact steps know it. Since version 1.3.
    DampingRatios = 33,
    /// `R = K⁻¹ − B Λ⁻¹ Bᵀ` between each loadable node and itself \[m/N\]: xx, xy, xz, yy, yz, zz;
    /// `f32|f64 (n_load_nodes, 6)`. Since version 1.3, as all below.
    ContactResidual = 34,
    /// Pairs of loadable nodes that share a loadable triangle, first below second, ascending;
    /// `u32 (any, 2)`.
    ResidualPairs = 35,
    /// `R` of each pair: row the component of displacement at the first node, column that of force at the
    /// second; `f32|f64 (any, 9)`.
    PairResidual = 36,
    /// A probe's value of `R` under a unit force at a loadable node, `f32|f64 (n_probes, n_load_nodes, 3)`.
    ProbeResidual = 37,
    /// `R F_p` at loadable nodes \[m\], `f32|f64 (n_patterns, n_load_nodes, 3)`.
    PatternResidual = 38,
    /// A probe's value of `R F_p`, `f64 (n_patterns, n_probes)`.
    PatternProbeResidual = 39,
    /// 1 if the bound is rigorous, 0 if it is an estimate; then the worst, the median and the 95th percentile
    /// of `‖R F‖_M / ‖K⁻¹F‖_M` over loadable nodes and directions; `f64 (4)`.
    StaticBound = 40,
    /// `G = Rᵀ M R` of each loadable node \[kg m²/N²\]: xx, xy, xz, yy, yz, zz; then its largest relative
    /// bound; `f32|f64 (n_load_nodes, 7)`.
    BoundMap = 41,
    /// Columns of the factor `L` of `K = L Lᵀ` in the order in which they are eliminated: the displacement,
    /// `3 node + component`, that each stands for; held ones are absent. `u32 (any)`. Since version 1.4, as
    /// all below.
    FactorOrder = 42,
    /// Groups of columns of `L` with the same rows below them: columns, and rows below; `u32 (any, 2)`.
    FactorGroups = 43,
    /// Rows of `L` below each group, ascending, one group after the other; `u32 (any)`.
    FactorRows = 44,
    /// `L` \[(N/m)^½\], group by group, each column by column from the group's first row on, so that what
    /// stands above the diagonal is zero; `f32|f64 (any)`.
    FactorValues = 45,
    /// `K⁻¹F_p` \[m\] in the order of the factor, `f32|f64 (n_patterns, any)`.
    PatternAnswer = 46,
    /// Where the stress is known: node, in the file's order, and region; `u32 (any, 2)`. Since version 1.5,
    /// as all below.
    StressPoints = 47,
    /// Stress of each mode at these points: xx, yy, zz, xy, yz, zx, with the regions' moduli as built;
    /// `f32|f64|i16 (any, 6, r)`.
    StressBasis = 48,
    /// Stress of `R` under a unit force at a loadable node \[Pa/N\]: row the component of stress, column that
    /// of the force; `f32|f64 (any, n_load_nodes, 18)`.
    StressResidual = 49,
    /// Stress of `R F_p` \[Pa\], `f64 (n_patterns, any, 6)`.
    PatternStress = 50,
    /// Young's modulus \[Pa\] and Poisson's ratio of each region of the mesh as built,
    /// `f64 (any, 2)`.
    ElasticConstants = 51,
    /// Unit of each probe's value, UTF-8, one a line; metres where the section is missing.
    ProbeUnits = 52,
    /// Names of the supports, UTF-8, one a line.
    SupportNames = 53,
    /// Point about which the moment of each support is taken \[m\], `f64 (any, 3)`.
    SupportPoints = 54,
    /// What the acceleration of each mode adds to the force and the moment of each support,
    /// `f64 (any, 6, r)`.
    ReactionBasis = 55,
    /// Force and moment of each support under a unit force at a loadable node that stays: row the component
    /// of the reaction, column that of the force; `f64 (any, n_load_nodes, 18)`.
    ReactionLoads = 56,
    /// Force and moment of each support under each pattern that stays, `f64 (n_patterns, any, 6)`.
    PatternReaction = 57,
    /// Point about which a moving base turns \[m\], `f64 (3)`. The last twelve patterns are its motions.
    BaseFrame = 58,
    /// A free body: mass \[kg\], centre \[m\] (3), moments of inertia about it \[kg m²\] (xx, xy, xz, yy,
    /// yz, zz), and the first of the six patterns of its angular velocity; then force \[N\] and moment about
    /// the centre \[N m\] of each pattern; `f64 (11 + 6 n_patterns)`.
    RigidBody = 59,
    /// The strain structure: `n` coordinates that interact, `n₁` that couple with them, `m` strain rows,
    /// and the sub-steps of a step as built; `u32 (4)`. Since version 1.6, as all below.
    StrainSizes = 60,
    /// Linear part `L` of the first `r` strain rows \[J^½/(m kg^½)\] over the first `n + n₁` coordinates;
    /// `f64 (r, n + n₁)`.
    StrainLinear = 61,
    /// Frequency \[rad/s\] of each tail coordinate, which its row has beside these; `f64 (r − n − n₁)`.
    StrainTail = 62,
    /// Quadratic part of the strain rows, a number for each product of coordinates
    /// ([`StrainSizes::pair_list`](crate::StrainSizes::pair_list)); `f32|f64 (m, n(n+1)/2 + n n₁)`.
    StrainQuadratic = 63,
    /// `W`: how far from rest coordinates were in training, `|W q|`; `f64 (any, r)`.
    StrainBox = 64,
    /// The largest `|W q|` and the largest energy \[J\] met in training; `f64 (2)`.
    StrainLimits = 65,
    /// Natural frequency \[rad/s\] of each coordinate that is a natural mode, 0 of the others: a step fits
    /// their inertia to it; `f64 (r)`. Since version 1.7.
    StrainModes = 66,
}

impl SectionKind {
    /// All kinds, by number.
    pub const ALL: [Self; 66] = [
        Self::NodeIds,
        Self::NodeCoordinates,
        Self::Triangles,
        Self::ReducedStiffness,
        Self::Eigenvalues,
        Self::SurfaceBasis,
        Self::InteriorBasis,
        Self::BlockState,
        Self::BlockLoad,
        Self::PatternBasis,
        Self::PatternBlock,
        Self::PatternNames,
        Self::ProbeNames,
        Self::ProbeRows,
        Self::SingularValues,
        Self::ModeTable,
        Self::AxisPoints,
        Self::Factors,
        Self::RegionStiffness,
        Self::RegionMass,
        Self::EnrichmentHistory,
        Self::RadiusSamples,
        Self::CanonicalParts,
        Self::CanonicalAxes,
        Self::CanonicalFactors,
        Self::CanonicalTerms,
        Self::CanonicalPositions,
        Self::CanonicalDirection,
        Self::CanonicalCertificate,
        Self::Losses,
        Self::Repairs,
        Self::StructureFigures,
        Self::DampingRatios,
        Self::ContactResidual,
        Self::ResidualPairs,
        Self::PairResidual,
        Self::ProbeResidual,
        Self::PatternResidual,
        Self::PatternProbeResidual,
        Self::StaticBound,
        Self::BoundMap,
        Self::FactorOrder,
        Self::FactorGroups,
        Self::FactorRows,
        Self::FactorValues,
        Self::PatternAnswer,
        Self::StressPoints,
        Self::StressBasis,
        Self::StressResidual,
        Self::PatternStress,
        Self::ElasticConstants,
        Self::ProbeUnits,
        Self::SupportNames,
        Self::SupportPoints,
        Self::ReactionBasis,
        Self::ReactionLoads,
        Self::PatternReaction,
        Self::BaseFrame,
        Self::RigidBody,
        Self::StrainSizes,
        Self::StrainLinear,
        Self::StrainTail,
        Self::StrainQuadratic,
        Self::StrainBox,
        Self::StrainLimits,
        Self::StrainModes,
    ];

    /// The kind with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.number() == number)
    }

    /// Whether it belongs to the chapter's structure, which the file format calls canonical. The writer marks
    /// these kinds required.
    #[must_use]
    pub const fn is_chapter(self) -> bool {
        self as u32 >= Self::CanonicalParts as u32 && self as u32 <= Self::CanonicalCertificate as u32
    }

    /// Whether it belongs to the strain structure. The writer marks these kinds required.
    #[must_use]
    pub const fn is_strain(self) -> bool {
        let sizes_to_quadratic =
            self as u32 >= Self::StrainSizes as u32 && self as u32 <= Self::StrainQuadratic as u32;
        sizes_to_quadratic || matches!(self, Self::StrainModes)
    }

    /// Its number in the file.
    #[must_use]
    pub const fn number(self) -> u32 {
        self as u32
    }

    /// The minor version of the format that first has this kind.
    #[must_use]
    pub const fn since(self) -> u16 {
        match self {
            Self::EnrichmentHistory | Self::RadiusSamples | Self::Losses | Self::Repairs => 1,
            Self::StructureFigures => 2,
            Self::StrainModes => 7,
            kind if kind.number() > Self::RigidBody.number() => 6,
            kind if kind.number() > Self::PatternAnswer.number() => 5,
            kind if kind.number() > Self::BoundMap.number() => 4,
            kind if kind.number() > Self::StructureFigures.number() => 3,
            kind if kind.is_chapter() => 1,
            _ => 0,
        }
    }

    /// The shape the metadata ask for; `None` where any number will do. Places past the rank are 1.
    #[must_use]
    pub fn shape(self, metadata: &Metadata<'_>) -> [Option<u64>; 3] {
        let m = metadata;
        let [nodes, surface, r, terms] = [m.n_nodes, m.n_surface_nodes, m.n_modes, m.n_terms].map(u64::from);
        let interior = nodes.saturating_sub(surface);
        let points = m.n_axis_points();
        let one = |a: u64| [Some(a), Some(1), Some(1)];
        let two = |a: u64, b: u64| [Some(a), Some(b), Some(1)];
        let three = |a: u64, b: u64, c: u64| [Some(a), Some(b), Some(c)];
        match self {
            Self::NodeIds => one(nodes),
            Self::NodeCoordinates => two(nodes, 3),
            Self::Triangles => two(u64::from(m.n_triangles), 3),
            Self::ReducedStiffness => two(r, r),
            Self::Eigenvalues | Self::DampingRatios | Self::StrainModes => one(r),
            Self::SurfaceBasis => three(surface, 3, r),
            Self::InteriorBasis => three(interior, 3, r),
            Self::BlockState => three(terms, r, r),
            Self::BlockLoad => three(u64::from(m.n_load_nodes), terms, 3 * r),
            Self::PatternBasis => two(u64::from(m.n_patterns), r),
            Self::PatternBlock => three(u64::from(m.n_patterns), terms, r),
            Self::PatternNames
            | Self::ProbeNames
            | Self::SingularValues
            | Self::Repairs
            | Self::ProbeUnits
            | Self::SupportNames => [None, Some(1), Some(1)],
            Self::ProbeRows => two(u64::from(m.n_probes), r),
            Self::ModeTable => two(r, 6),
            Self::AxisPoints => one(points),
            Self::Factors => one(terms.saturating_mul(points)),
            Self::Losses => [None, Some(4), Some(1)],
            Self::RegionStiffness | Self::RegionMass => three(u64::from(m.n_regions), r, r),
            Self::EnrichmentHistory => [None, Some(2), Some(1)],
            Self::StructureFigures => two(3, 3),
            Self::ContactResidual => two(u64::from(m.n_load_nodes), 6),
            Self::ResidualPairs => [None, Some(2), Some(1)],
            Self::PairResidual => [None, Some(9), Some(1)],
            Self::ProbeResidual => three(u64::from(m.n_probes), u64::from(m.n_load_nodes), 3),
            Self::PatternResidual => three(u64::from(m.n_patterns), u64::from(m.n_load_nodes), 3),
            Self::PatternProbeResidual => two(u64::from(m.n_patterns), u64::from(m.n_probes)),
            Self::StaticBound => one(4),
            Self::BoundMap => two(u64::from(m.n_load_nodes), 7),
            Self::FactorOrder | Self::FactorRows | Self::FactorValues => [None, Some(1), Some(1)],
            Self::FactorGroups => [None, Some(2), Some(1)],
            Self::PatternAnswer => [Some(u64::from(m.n_patterns)), None, Some(1)],
            Self::StressPoints | Self::ElasticConstants => [None, Some(2), Some(1)],
            Self::StressBasis | Self::ReactionBasis => [None, Some(6), Some(r)],
            Self::StressResidual | Self::ReactionLoads => [None, Some(u64::from(m.n_load_nodes)), Some(18)],
            Self::PatternStress | Self::PatternReaction => [Some(u64::from(m.n_patterns)), None, Some(6)],
            Self::SupportPoints => [None, Some(3), Some(1)],
            Self::BaseFrame => one(3),
            Self::StrainSizes => one(4),
            Self::StrainLinear => [Some(r), None, Some(1)],
            Self::StrainTail => [None, Some(1), Some(1)],
            Self::StrainQuadratic => [None, None, Some(1)],
            Self::StrainBox => [None, Some(r), Some(1)],
            Self::StrainLimits => one(2),
            Self::RigidBody => one(11 + 6 * u64::from(m.n_patterns)),
            Self::RadiusSamples => [None, Some(u64::from(m.n_parameters) + 1), Some(1)],
            Self::CanonicalParts => [None, Some(3), Some(1)],
            Self::CanonicalAxes => [None, Some(CHAPTER_AXIS as u64), Some(1)],
            Self::CanonicalFactors | Self::CanonicalPositions => [None, Some(1), Some(1)],
            Self::CanonicalTerms => [None, Some(r), Some(1)],
            Self::CanonicalDirection => one(3),
            Self::CanonicalCertificate => one(CHAPTER_CERTIFICATE as u64 + 3 * u64::from(m.scheme.n_stages)),
        }
    }

    /// Whether the kind may have this element type.
    #[must_use]
    pub fn allows(self, element: Element) -> bool {
        match self {
            Self::NodeIds => element == Element::U64,
            Self::Triangles
            | Self::CanonicalParts
            | Self::CanonicalPositions
            | Self::ResidualPairs
            | Self::StressPoints
            | Self::StrainSizes
            | Self::FactorOrder
            | Self::FactorGroups
            | Self::FactorRows => element == Element::U32,
            Self::PatternNames | Self::ProbeNames | Self::Repairs | Self::ProbeUnits | Self::SupportNames => {
                element == Element::U8
            }
            Self::NodeCoordinates
            | Self::ContactResidual
            | Self::PairResidual
            | Self::ProbeResidual
            | Self::PatternResidual
            | Self::BoundMap
            | Self::FactorValues
            | Self::PatternAnswer
            | Self::StrainQuadratic
            | Self::StressResidual => matches!(element, Element::F32 | Element::F64),
            Self::SurfaceBasis | Self::InteriorBasis | Self::BlockLoad | Self::StressBasis => {
                matches!(element, Element::F32 | Element::F64 | Element::I16)
            }
            _ => element == Element::F64,
        }
    }
}

/// Type of a section's numbers, all little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Element {
    /// Bytes.
    U8 = 0,
    /// 32-bit unsigned.
    U32 = 1,
    /// 64-bit unsigned.
    U64 = 2,
    /// IEEE binary32.
    F32 = 3,
    /// IEEE binary64.
    F64 = 4,
    /// 16-bit signed times a binary32 scale per block ([`Quantised`](crate::Quantised)). Since version 1.1.
    I16 = 5,
}

impl Element {
    /// The element with this code.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        let all = [Self::U8, Self::U32, Self::U64, Self::F32, Self::F64, Self::I16];
        all.into_iter().find(|element| *element as u8 == code)
    }

    /// Bytes of one number.
    #[must_use]
    pub const fn size(self) -> u64 {
        match self {
            Self::U8 => 1,
            Self::I16 => 2,
            Self::U32 | Self::F32 => 4,
            Self::U64 | Self::F64 => 8,
        }
    }

    /// Bytes of a section of this shape once decoded; `None` past 2⁶⁴. Quantised numbers bring their scales.
    #[must_use]
    pub fn decoded_length(self, shape: [u64; 3]) -> Option<u64> {
        let numbers = shape.iter().try_fold(self.size(), |bytes, &n| bytes.checked_mul(n))?;
        match self {
            Self::I16 => numbers.checked_add(quantised::scales_length(shape)?),
            _ => Some(numbers),
        }
    }
}

/// How a section's bytes are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Codec {
    /// As they are.
    Raw = 0,
    /// One zstd frame of them.
    Zstd = 1,
    /// By block: bytes grouped by their place in a number, then one zstd frame. Since version 1.1.
    Shuffled = 2,
    /// By block, 16-bit numbers only: differences to the node before, then as [`Codec::Shuffled`]. Since
    /// version 1.1.
    Delta = 3,
}

impl Codec {
    /// The codec with this code.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        let all = [Self::Raw, Self::Zstd, Self::Shuffled, Self::Delta];
        all.into_iter().find(|codec| *codec as u8 == code)
    }

    /// Whether numbers of this type may be stored so.
    #[must_use]
    pub fn codes(self, element: Element) -> bool {
        self != Self::Delta || element == Element::I16
    }
}

/// A section of an opened file; its place and shape have been checked, its bytes have not (see
/// [`Section::verify`]).
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    pub(crate) kind: SectionKind,
    pub(crate) element: Element,
    pub(crate) codec: Codec,
    pub(crate) required: bool,
    pub(crate) shape: [u64; 3],
    pub(crate) decoded_length: u64,
    pub(crate) crc32: u32,
    pub(crate) stored: &'a [u8],
}

/// Real numbers of a section, as bytes.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// binary32, little-endian.
    F32(&'a [[u8; 4]]),
    /// binary64, little-endian.
    F64(&'a [[u8; 8]]),
    /// 16-bit numbers with a scale per block.
    I16(Quantised<'a>),
}

impl<'a> Numbers<'a> {
    /// How many there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::F32(numbers) => numbers.len(),
            Self::F64(numbers) => numbers.len(),
            Self::I16(numbers) => numbers.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Quantised numbers of a section of this shape from its decoded bytes; `None` if they are not as many as
    /// the shape asks for.
    #[must_use]
    pub fn quantised(decoded: &'a [u8], shape: [u64; 3]) -> Option<Self> {
        Quantised::new(decoded, shape).map(Self::I16)
    }

    /// The number at `index`.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<f64> {
        match self {
            Self::F32(numbers) => numbers.get(index).map(|&bytes| f64::from(f32::from_le_bytes(bytes))),
            Self::F64(numbers) => numbers.get(index).map(|&bytes| f64::from_le_bytes(bytes)),
            Self::I16(numbers) => numbers.get(index),
        }
    }

    /// `length` numbers from `start`; of quantised ones within one node.
    #[must_use]
    pub fn row(&self, start: usize, length: usize) -> Option<Self> {
        let end = start.checked_add(length)?;
        match self {
            Self::F32(numbers) => numbers.get(start..end).map(Self::F32),
            Self::F64(numbers) => numbers.get(start..end).map(Self::F64),
            Self::I16(numbers) => numbers.row(start, length).map(Self::I16),
        }
    }

    /// All of them in order.
    pub fn iter(&self) -> impl Iterator<Item = f64> + 'a {
        let none = Quantised::default();
        let (single, double, quantised): (&'a [[u8; 4]], &'a [[u8; 8]], Quantised<'a>) = match *self {
            Self::F32(numbers) => (numbers, &[], none),
            Self::F64(numbers) => (&[], numbers, none),
            Self::I16(numbers) => (&[], &[], numbers),
        };
        let single = single.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes)));
        let double = double.iter().map(|&bytes| f64::from_le_bytes(bytes));
        single.chain(double).chain(quantised.iter())
    }
}

impl<'a> Section<'a> {
    /// Its kind.
    #[must_use]
    pub const fn kind(&self) -> SectionKind {
        self.kind
    }

    /// Its element type.
    #[must_use]
    pub const fn element(&self) -> Element {
        self.element
    }

    /// Its codec.
    #[must_use]
    pub const fn codec(&self) -> Codec {
        self.codec
    }

    /// Whether a reader that does not know it must refuse the file.
    #[must_use]
    pub const fn is_required(&self) -> bool {
        self.required
    }

    /// Its shape, last number fastest; places past its rank are 1.
    #[must_use]
    pub const fn shape(&self) -> [u64; 3] {
        self.shape
    }

    /// Its bytes as they are stored.
    #[must_use]
    pub const fn stored(&self) -> &'a [u8] {
        self.stored
    }

    /// Bytes once decoded.
    #[must_use]
    pub const fn decoded_length(&self) -> u64 {
        self.decoded_length
    }

    /// Compares the stored bytes with their checksum. Reads all of them.
    ///
    /// # Errors
    /// Refusal 27.
    pub fn verify(&self) -> Result<(), FormatError> {
        let found = checksum(self.stored);
        if found == self.crc32 {
            return Ok(());
        }
        Err(FormatError::SectionChecksum { kind: self.kind.number(), found, expected: self.crc32 })
    }

    /// Its bytes, if they are stored raw.
    ///
    /// # Errors
    /// Refusal 28.
    pub fn raw(&self) -> Result<&'a [u8], FormatError> {
        match self.codec {
            Codec::Raw => Ok(self.stored),
            codec => Err(FormatError::Compressed { kind: self.kind.number(), codec: codec as u8 }),
        }
    }

    /// Its real numbers.
    ///
    /// # Errors
    /// Refusals 28 (compressed), 19 (not real numbers) and 24 (not as many as its shape says, which opening
    /// has ruled out).
    pub fn numbers(&self) -> Result<Numbers<'a>, FormatError> {
        match self.element {
            Element::F32 => Ok(Numbers::F32(self.raw()?.as_chunks().0)),
            Element::F64 => Ok(Numbers::F64(self.raw()?.as_chunks().0)),
            Element::I16 => {
                let raw = self.raw()?;
                let (kind, found) = (self.kind.number(), raw.len() as u64);
                let wrong = FormatError::Length { kind, found, expected: self.decoded_length };
                Numbers::quantised(raw, self.shape).ok_or(wrong)
            }
            _ => Err(self.wrong_element()),
        }
    }

    /// Its numbers as binary64.
    ///
    /// # Errors
    /// Refusals 28 and 19.
    pub fn f64s(&self) -> Result<&'a [[u8; 8]], FormatError> {
        self.chunks(Element::F64)
    }

    /// Its numbers as 64-bit integers.
    ///
    /// # Errors
    /// Refusals 28 and 19.
    pub fn u64s(&self) -> Result<&'a [[u8; 8]], FormatError> {
        self.chunks(Element::U64)
    }

    /// Its numbers as 32-bit integers.
    ///
    /// # Errors
    /// Refusals 28 and 19.
    pub fn u32s(&self) -> Result<&'a [[u8; 4]], FormatError> {
        self.chunks(Element::U32)
    }

    /// Its text.
    ///
    /// # Errors
    /// Refusals 28, 19 and 29.
    pub fn text(&self) -> Result<&'a str, FormatError> {
        let bytes = self.chunks::<1>(Element::U8)?.as_flattened();
        core::str::from_utf8(bytes).map_err(|_| FormatError::Text { kind: self.kind.number() })
    }

    fn chunks<const N: usize>(&self, element: Element) -> Result<&'a [[u8; N]], FormatError> {
        if self.element == element { Ok(self.raw()?.as_chunks().0) } else { Err(self.wrong_element()) }
    }

    fn wrong_element(&self) -> FormatError {
        FormatError::Element { kind: self.kind.number(), found: self.element as u8 }
    }
}
