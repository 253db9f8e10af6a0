//! Kinds of sections: one table, a row for each kind, from which every lookup follows.
//!
//! A row holds name, number, the minor version that first has the kind, whether the writer marks it
//! required, the element types it may have, and its shape. The table is a macro and not a constant, so that a
//! program contains the columns it uses: a microcontroller has no room for 72 names.

use crate::element::Element;
use crate::metadata::Metadata;

/// Numbers in a row of the table of axes: role, index, lower, upper, points, factor.
pub const CHAPTER_AXIS: usize = 6;
/// Numbers of the certificate before those of the stages: the seven of a structure, and the step the
/// trajectory left at.
pub const CHAPTER_CERTIFICATE: usize = 8;

/// The width that a table of quadrangles of this width should have: two numbers, then four, eight or nine
/// nodes a row.
pub(crate) const fn quadrangle_width(found: u64) -> u64 {
    match found {
        0..=6 => 6,
        7..=10 => 10,
        _ => 11,
    }
}

/// One number of a shape.
#[derive(Clone, Copy)]
enum Extent {
    /// Any number will do.
    Any,
    /// This number.
    Of(u8),
    Nodes,
    SurfaceNodes,
    InteriorNodes,
    LoadNodes,
    Triangles,
    Modes,
    /// Three for each mode.
    ModeComponents,
    Terms,
    Patterns,
    Probes,
    Regions,
    AxisPoints,
    /// A number for each term and axis point.
    Factors,
    /// A value for each parameter, and a radius.
    RadiusSample,
    /// Eleven, and six for each pattern.
    RigidBody,
    /// [`CHAPTER_CERTIFICATE`], and three for each stage.
    ChapterCertificate,
}

impl Extent {
    fn count(self, m: &Metadata<'_>) -> Option<u64> {
        Some(match self {
            Self::Any => return None,
            Self::Of(count) => u64::from(count),
            Self::Nodes => u64::from(m.n_nodes),
            Self::SurfaceNodes => u64::from(m.n_surface_nodes),
            Self::InteriorNodes => u64::from(m.n_nodes.saturating_sub(m.n_surface_nodes)),
            Self::LoadNodes => u64::from(m.n_load_nodes),
            Self::Triangles => u64::from(m.n_triangles),
            Self::Modes => u64::from(m.n_modes),
            Self::ModeComponents => 3 * u64::from(m.n_modes),
            Self::Terms => u64::from(m.n_terms),
            Self::Patterns => u64::from(m.n_patterns),
            Self::Probes => u64::from(m.n_probes),
            Self::Regions => u64::from(m.n_regions),
            Self::AxisPoints => m.n_axis_points(),
            Self::Factors => u64::from(m.n_terms).saturating_mul(m.n_axis_points()),
            Self::RadiusSample => u64::from(m.n_parameters) + 1,
            Self::RigidBody => 11 + 6 * u64::from(m.n_patterns),
            Self::ChapterCertificate => CHAPTER_CERTIFICATE as u64 + 3 * u64::from(m.scheme.n_stages),
        })
    }
}

/// Sets of element types, a bit for each.
const U8: u8 = bit(Element::U8);
const U32: u8 = bit(Element::U32);
const U64: u8 = bit(Element::U64);
const F64: u8 = bit(Element::F64);
const REAL: u8 = bit(Element::F32) | F64;
const FIELD: u8 = REAL | bit(Element::I16);

const fn bit(element: Element) -> u8 {
    1 << element as u8
}

macro_rules! shape {
    ($a:expr) => {
        [$a, Extent::Of(1), Extent::Of(1)]
    };
    ($a:expr, $b:expr) => {
        [$a, $b, Extent::Of(1)]
    };
    ($a:expr, $b:expr, $c:expr) => {
        [$a, $b, $c]
    };
}

macro_rules! required {
    (required) => {
        true
    };
    (optional) => {
        false
    };
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident = $number:literal: $since:literal, $required:ident, $elements:ident,
        [$($extent:expr),+];)+) => {
        /// The kind of a section. Shapes use `r = n_modes`; row-major, last number fastest.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        #[non_exhaustive]
        pub enum SectionKind {
            $($(#[$doc])* $kind = $number,)+
        }

        impl SectionKind {
            /// All kinds, by number.
            pub const ALL: [Self; [$($number),+].len()] = [$(Self::$kind),+];

            /// The minor version of the format that first has this kind.
            #[must_use]
            pub const fn since(self) -> u16 {
                match self {
                    $(Self::$kind => $since,)+
                }
            }

            /// True for a kind that a reader has to know: the writer marks it required.
            pub(crate) const fn is_required(self) -> bool {
                match self {
                    $(Self::$kind => required!($required),)+
                }
            }

            pub(crate) const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => stringify!($kind),)+
                }
            }

            const fn elements(self) -> u8 {
                match self {
                    $(Self::$kind => $elements,)+
                }
            }

            const fn extents(self) -> [Extent; 3] {
                use Extent::{
                    Any, AxisPoints, ChapterCertificate, Factors, InteriorNodes, LoadNodes, ModeComponents,
                    Modes, Nodes, Of, Patterns, Probes, RadiusSample, Regions, RigidBody, SurfaceNodes, Terms,
                    Triangles,
                };
                match self {
                    $(Self::$kind => shape!($($extent),+),)+
                }
            }
        }
    };
}

kinds! {
    /// Node ids of the mesh file, `u64 (n_nodes)`, in the file's node order.
    NodeIds = 1: 0, optional, U64, [Nodes];
    /// Coordinates \[m\], `f32|f64 (n_nodes, 3)`.
    NodeCoordinates = 2: 0, optional, REAL, [Nodes, Of(3)];
    /// Surface triangles, `u32 (n_triangles, 3)`, outward, over surface nodes, loadable ones first.
    Triangles = 3: 0, optional, U32, [Triangles, Of(3)];
    /// `BᵀKB` \[1/s²\], `f64 (r, r)`.
    ReducedStiffness = 4: 0, optional, F64, [Modes, Modes];
    /// Ritz values `λ_k` \[rad²/s²\], `f64 (r)`.
    Eigenvalues = 5: 0, optional, F64, [Modes];
    /// Rows of `B` \[kg^-½\] at surface nodes, `f32|f64|i16 (n_surface_nodes, 3, r)`.
    SurfaceBasis = 6: 0, optional, FIELD, [SurfaceNodes, Of(3), Modes];
    /// Rows of `B` at interior nodes, `f32|f64|i16 (n_nodes − n_surface_nodes, 3, r)`.
    InteriorBasis = 7: 0, optional, FIELD, [InteriorNodes, Of(3), Modes];
    /// Space part `E_t` of `C − I`, `C = BᵀM_0 (M + θK)⁻¹ M B`, `f64 (n_terms, r, r)`, row-major; not
    /// symmetric once a region's density differs from what the basis was normalised with (`M_0`).
    BlockState = 8: 0, optional, F64, [Terms, Modes, Modes];
    /// Space part of `H − B`, `H = (M + θK)⁻¹ M_0 B`, at loadable dofs,
    /// `f32|f64|i16 (n_load_nodes, n_terms, 3·r)`: the components, then the columns.
    BlockLoad = 9: 0, optional, FIELD, [LoadNodes, Terms, ModeComponents];
    /// `BᵀF_p`, `f64 (n_patterns, r)`.
    PatternBasis = 10: 0, optional, F64, [Patterns, Modes];
    /// Space part of `(H − B)ᵀF_p`, `f64 (n_patterns, n_terms, r)`.
    PatternBlock = 11: 0, optional, F64, [Patterns, Terms, Modes];
    /// Names of the patterns, UTF-8, one a line.
    PatternNames = 12: 0, optional, U8, [Any];
    /// Names of the probes, UTF-8, one a line.
    ProbeNames = 13: 0, optional, U8, [Any];
    /// Row of `B` that gives each probe's value, `f64 (n_probes, r)`.
    ProbeRows = 14: 0, optional, F64, [Probes, Modes];
    /// Singular values of the snapshots, `f64 (any)`.
    SingularValues = 15: 0, optional, F64, [Any];
    /// Per mode: frequency \[Hz\], Rayleigh quotient \[rad²/s²\], energy share, physical damping ratio,
    /// numerical damping ratio, period elongation; `f64 (r, 6)`.
    ModeTable = 16: 0, optional, F64, [Modes, Of(6)];
    /// Points of all axes, one after the other, `f64 (Σ n_points)`.
    AxisPoints = 17: 0, optional, F64, [AxisPoints];
    /// Factors of all axes, one after the other, each `(n_terms, n_points)`; `f64 (n_terms · Σ n_points)`.
    Factors = 18: 0, optional, F64, [Factors];
    /// `BᵀK_qB` \[1/s²\] of each region at scale 1, `f64 (n_regions, r, r)`; they sum to `BᵀKB`.
    RegionStiffness = 19: 0, optional, F64, [Regions, Modes, Modes];
    /// `BᵀM_qB` of each region at scale 1, `f64 (n_regions, r, r)`; they sum to the identity.
    RegionMass = 20: 0, optional, F64, [Regions, Modes, Modes];
    /// Terms, and the error they leave at fresh points, after each enrichment of the separated solution;
    /// `f64 (any, 2)`. Since 1.1.
    EnrichmentHistory = 21: 1, optional, F64, [Any, Of(2)];
    /// Points of the parameters' box, each its values and the spectral radius of the fused block step there;
    /// `f64 (any, n_parameters + 1)`. Since 1.1.
    RadiusSamples = 22: 1, optional, F64, [Any, RadiusSample];
    /// Parts of the canonical structure: stage, number of axes, number of terms; `u32 (any, 3)`. Version 1.1,
    /// as all below.
    CanonicalParts = 23: 1, required, U32, [Any, Of(3)];
    /// Axes of the parts, one part after the other: role, index, lower, upper, points, factor;
    /// `f64 (any, 6)`.
    CanonicalAxes = 24: 1, required, F64, [Any, Of(CHAPTER_AXIS as u8)];
    /// Factors of the parts' axes, each `(n_points, n_terms)`; `f64 (any)`.
    CanonicalFactors = 25: 1, required, F64, [Any];
    /// `ΠF_t` of the parts' terms, `f64 (any, r)`.
    CanonicalTerms = 26: 1, required, F64, [Any, Modes];
    /// Loadable nodes the load can stand at, `u32 (any)`.
    CanonicalPositions = 27: 1, required, U32, [Any];
    /// Direction of the load, `f64 (3)`; absent when its components are axes.
    CanonicalDirection = 28: 1, required, F64, [Of(3)];
    /// Its certificate: the numbers of a structure's certificate, the step at which the
    /// trajectory left a range (NaN: never), and per stage the relative error of the map, of its state and of
    /// its load part; `f64 (8 + 3 n_stages)`.
    CanonicalCertificate = 29: 1, required, F64, [ChapterCertificate];
    /// Errors of rewriting, for people: kind, relative error of displacement fields, of velocity fields,
    /// largest of any mode; `f64 (any, 4)`. Since version 1.1.
    Losses = 30: 1, optional, F64, [Any, Of(4)];
    /// Repairs by which a build made an unstable step stable, for people: UTF-8, one repair a line. Since
    /// version 1.1.
    Repairs = 31: 1, optional, U8, [Any];
    /// Measurements of the structures besides the certificate, for people: largest error ÷ floor of
    /// any run, defect of reciprocity, growth of energy; `f64 (3, 3)`, a row for the diagonal, the block and
    /// the canonical structure, NaN where it was not measured. Since version 1.2.
    StructureFigures = 32: 2, optional, F64, [Of(3), Of(3)];
    /// Damping ratio of each mode beside Rayleigh's, `f64 (r)`. Only exact steps know it. Since version 1.3.
    DampingRatios = 33: 3, optional, F64, [Modes];
    /// `R = K⁻¹ − B Λ⁻¹ Bᵀ` between each loadable node and itself \[m/N\]: xx, xy, xz, yy, yz, zz;
    /// `f32|f64 (n_load_nodes, 6)`. Since version 1.3, as all below.
    ContactResidual = 34: 3, optional, REAL, [LoadNodes, Of(6)];
    /// Pairs of loadable nodes that share a loadable triangle, first below second, ascending;
    /// `u32 (any, 2)`.
    ResidualPairs = 35: 3, optional, U32, [Any, Of(2)];
    /// `R` of each pair: row the component of displacement at the first node, column that of force at the
    /// second; `f32|f64 (any, 9)`.
    PairResidual = 36: 3, optional, REAL, [Any, Of(9)];
    /// A probe's value of `R` under a unit force at a loadable node, `f32|f64 (n_probes, n_load_nodes, 3)`.
    ProbeResidual = 37: 3, optional, REAL, [Probes, LoadNodes, Of(3)];
    /// `R F_p` at loadable nodes \[m\], `f32|f64 (n_patterns, n_load_nodes, 3)`.
    PatternResidual = 38: 3, optional, REAL, [Patterns, LoadNodes, Of(3)];
    /// A probe's value of `R F_p`, `f64 (n_patterns, n_probes)`.
    PatternProbeResidual = 39: 3, optional, F64, [Patterns, Probes];
    /// 1 if the bound is rigorous, 0 if it is an estimate; then the worst, the median and the 95th percentile
    /// of `‖R F‖_M / ‖K⁻¹F‖_M` over loadable nodes and directions; `f64 (4)`.
    StaticBound = 40: 3, optional, F64, [Of(4)];
    /// `G = Rᵀ M R` of each loadable node \[kg m²/N²\]: xx, xy, xz, yy, yz, zz; then its largest relative
    /// bound; `f32|f64 (n_load_nodes, 7)`.
    BoundMap = 41: 3, optional, REAL, [LoadNodes, Of(7)];
    /// Columns of the factor `L` of `K = L Lᵀ` in the order in which they are eliminated: the displacement,
    /// `3 node + component`, that each stands for; held ones are absent. `u32 (any)`. Since version 1.4, as
    /// all below.
    FactorOrder = 42: 4, optional, U32, [Any];
    /// Groups of columns of `L` with the same rows below them: columns, and rows below; `u32 (any, 2)`.
    FactorGroups = 43: 4, optional, U32, [Any, Of(2)];
    /// Rows of `L` below each group, ascending, one group after the other; `u32 (any)`.
    FactorRows = 44: 4, optional, U32, [Any];
    /// `L` \[(N/m)^½\], group by group, each column by column from the group's first row on, so that what
    /// stands above the diagonal is zero; `f32|f64 (any)`.
    FactorValues = 45: 4, optional, REAL, [Any];
    /// `K⁻¹F_p` \[m\] in the order of the factor, `f32|f64 (n_patterns, any)`.
    PatternAnswer = 46: 4, optional, REAL, [Patterns, Any];
    /// Points of known stress: node, in the file's order, and region; `u32 (any, 2)`. Since version 1.5,
    /// as all below.
    StressPoints = 47: 5, optional, U32, [Any, Of(2)];
    /// Stress of each mode at these points: xx, yy, zz, xy, yz, zx, with the regions' moduli as built;
    /// `f32|f64|i16 (any, 6, r)`.
    StressBasis = 48: 5, optional, FIELD, [Any, Of(6), Modes];
    /// Stress of `R` under a unit force at a loadable node \[Pa/N\]: row the component of stress, column that
    /// of the force; `f32|f64 (any, n_load_nodes, 18)`.
    StressResidual = 49: 5, optional, REAL, [Any, LoadNodes, Of(18)];
    /// Stress of `R F_p` \[Pa\], `f64 (n_patterns, any, 6)`.
    PatternStress = 50: 5, optional, F64, [Patterns, Any, Of(6)];
    /// Young's modulus \[Pa\] and Poisson's ratio of each region of the mesh as built,
    /// `f64 (any, 2)`.
    ElasticConstants = 51: 5, optional, F64, [Any, Of(2)];
    /// Unit of each probe's value, UTF-8, one a line; metres where the section is missing.
    ProbeUnits = 52: 5, optional, U8, [Any];
    /// Names of the supports, UTF-8, one a line.
    SupportNames = 53: 5, optional, U8, [Any];
    /// Point about which the moment of each support is taken \[m\], `f64 (any, 3)`.
    SupportPoints = 54: 5, optional, F64, [Any, Of(3)];
    /// Contribution of each mode's acceleration to the force and the moment of each support,
    /// `f64 (any, 6, r)`.
    ReactionBasis = 55: 5, optional, F64, [Any, Of(6), Modes];
    /// Force and moment of each support under a unit force at a loadable node that stays: row the component
    /// of the reaction, column that of the force; `f64 (any, n_load_nodes, 18)`.
    ReactionLoads = 56: 5, optional, F64, [Any, LoadNodes, Of(18)];
    /// Force and moment of each support under each pattern that stays, `f64 (n_patterns, any, 6)`.
    PatternReaction = 57: 5, optional, F64, [Patterns, Any, Of(6)];
    /// Point about which a moving base turns \[m\], `f64 (3)`. The last twelve patterns are its motions.
    BaseFrame = 58: 5, optional, F64, [Of(3)];
    /// A free body: mass \[kg\], centre \[m\] (3), moments of inertia about it \[kg m²\] (xx, xy, xz, yy,
    /// yz, zz), and the first of the six patterns of its angular velocity; then force \[N\] and moment about
    /// the centre \[N m\] of each pattern; `f64 (11 + 6 n_patterns)`.
    RigidBody = 59: 5, optional, F64, [RigidBody];
    /// The strain structure: `n` coordinates that interact, `n₁` that couple with them, `m` strain rows,
    /// and the sub-steps of a step as built; `u32 (4)`. Since version 1.6, as all below.
    StrainSizes = 60: 6, required, U32, [Of(4)];
    /// Linear part `L` of the first `r` strain rows \[J^½/(m kg^½)\] over the first `n + n₁` coordinates;
    /// `f64 (r, n + n₁)`.
    StrainLinear = 61: 6, required, F64, [Modes, Any];
    /// Frequency \[rad/s\] of each tail coordinate, which its row has beside these; `f64 (r − n − n₁)`.
    StrainTail = 62: 6, required, F64, [Any];
    /// Quadratic part of the strain rows, a number for each product of coordinates
    /// ([`StrainSizes::pair_list`](crate::StrainSizes::pair_list)); `f32|f64 (m, n(n+1)/2 + n n₁)`.
    StrainQuadratic = 63: 6, required, REAL, [Any, Any];
    /// `W`: how far from rest coordinates were in training, `|W q|`; `f64 (any, r)`.
    StrainBox = 64: 6, optional, F64, [Any, Modes];
    /// The largest `|W q|` and the largest energy \[J\] met in training; `f64 (2)`.
    StrainLimits = 65: 6, optional, F64, [Of(2)];
    /// Natural frequency \[rad/s\] of each coordinate that is a natural mode, 0 of the others: a step fits
    /// their inertia to it; `f64 (r)`. Since version 1.7.
    StrainModes = 66: 7, required, F64, [Modes];
    /// Discretisation error of the lowest natural frequencies, for people: on this mesh \[Hz\], as estimated
    /// without discretisation error \[Hz\], and what the relative error does not exceed in 95 %;
    /// `f64 (any, 3)`. Since version 1.8.
    MeshError = 67: 8, optional, F64, [Any, Of(3)];
    /// Compliance of each region of the mesh as built, over the stresses xx, yy, zz, xy, yz, zx to the
    /// strains with engineering shear, its upper triangle row by row \[1/Pa\]; in place of
    /// [`SectionKind::ElasticConstants`] where a region is not isotropic; `f64 (any, 21)`. Since version 1.9.
    Compliance = 75: 9, optional, F64, [Any, Of(21)];
    /// The embedded surface, which is drawn in place of the surface of the mesh: the four nodes, among those
    /// of the surface, that each vertex follows; `u32 (any, 4)`. Since version 1.9, as all below.
    EmbeddedNodes = 76: 9, optional, U32, [Any, Of(4)];
    /// Weights of these nodes: a vertex lies at `Σ w x` and moves by `Σ w u`; `f32|f64 (any, 4)`.
    EmbeddedWeights = 77: 9, optional, REAL, [Any, Of(4)];
    /// Triangles of the embedded surface, outward, over its vertices; `u32 (any, 3)`.
    EmbeddedTriangles = 78: 9, optional, U32, [Any, Of(3)];
    /// Rows `d` over the modes of the dashpots that couple them: their damping matrix is `Σ dᵀd`, besides the
    /// damping of each mode \[s^-½\], `f64 (any, r)`. Only exact steps know it. Since version 1.10.
    DampingRows = 79: 10, optional, F64, [Any, Modes];
    /// Quadrangular facets that may be loaded, in the order of their triangles: the first of the loadable
    /// triangles by which a facet is found, how many there are of them, one after the other, and its four,
    /// eight or nine nodes ([`Quadrangle::nodes`](crate::Quadrangle::nodes)), `u32::MAX` where it has fewer
    /// than others; `u32 (any, 6 | 10 | 11)`. Since version 1.11.
    Quadrangles = 80: 11, optional, U32, [Any, Any];
    /// Names of the ports, by which an assembly joins the body to others, UTF-8, one a line. Since version
    /// 1.12, as all below.
    PortNames = 95: 12, optional, U8, [Any];
    /// Each port: its kind (0 a patch, 1 a frame), its first row and number of rows in sections 100 to 105,
    /// its first node and number of nodes in section 98, its first facet and number of facets in section 99;
    /// `u32 (any, 7)`.
    PortTable = 96: 12, optional, U32, [Any, Of(7)];
    /// Origin \[m\] and three axes of each port, along and about which the rows of a frame are;
    /// `f64 (any, 12)`.
    PortFrames = 97: 12, optional, F64, [Any, Of(12)];
    /// Nodes of the patches, among those of the surface, `u32 (any)`; three rows for each.
    PortNodes = 98: 12, optional, U32, [Any];
    /// Facets of the patches, over the nodes of their port: three, four, six, eight or nine nodes, corners
    /// first, and `u32::MAX` behind them; `u32 (any, 9)`.
    PortFacets = 99: 12, optional, U32, [Any, Of(9)];
    /// Rows `G B` of the ports, `f64 (any, r)`.
    PortRows = 100: 12, optional, F64, [Any, Modes];
    /// `G R Gᵀ`, `f64 (any, any)`.
    PortCompliance = 101: 12, optional, F64, [Any, Any];
    /// `G R M R Gᵀ`, `f64 (any, any)`.
    PortInertia = 102: 12, optional, F64, [Any, Any];
    /// Displacement `R Gᵀ` of surface nodes under a unit force along each row,
    /// `f32|f64 (any, n_surface_nodes, 3)`.
    PortResidual = 103: 12, optional, REAL, [Any, SurfaceNodes, Of(3)];
    /// A probe's value of `R Gᵀ`, `f64 (any, n_probes)`.
    PortProbes = 104: 12, optional, F64, [Any, Probes];
    /// `G R F_p` of each pattern, `f64 (any, n_patterns)`.
    PortPatterns = 105: 12, optional, F64, [Any, Patterns];
    /// Values of the probes of a free body as it moves by a metre along each axis, and turns by a radian
    /// about each through its centre; `f64 (n_probes, 6)`.
    ProbeMotions = 106: 12, optional, F64, [Probes, Of(6)];
    /// Loadable nodes along further modes, each over the root of its λ \[m/N^½\]: they answer forces
    /// by `Σ row (row·F)`; `f32|f64 (n_load_nodes, 3, any)`. Since version 1.13, as all below.
    ContactModes = 107: 13, optional, REAL, [LoadNodes, Of(3), Any];
    /// Pairs of loadable nodes near each other, the first at most the second, ascending, with each node and
    /// itself; `u32 (any, 2)`.
    PatchPairs = 108: 13, optional, U32, [Any, Of(2)];
    /// `R` of each of these pairs less the static answer of the further modes \[m/N\]: row the component of
    /// displacement at the first node, column that of force at the second; `f32|f64 (any, 9)`.
    PatchResidual = 109: 13, optional, REAL, [Any, Of(9)];
    /// Distance `h` of two contacts from which on section 109 adds nothing between them \[m\], `f64 (1)`.
    ContactPatch = 110: 13, optional, F64, [Of(1)];
    /// Live parameters of a parametric reduced-order model: role, live region, 1 if its range is walked in
    /// the logarithm, smallest and largest value, value as built
    /// ([`LiveParameters`](crate::LiveParameters)); `f64 (any, 6)`. Since version 1.14, as all below.
    LiveParameters = 111: 14, required, F64, [Any, Of(6)];
    /// Names of the live parameters, UTF-8, one a line.
    LiveNames = 112: 14, required, U8, [Any];
    /// `BᵀK_qB` \[1/s²\] of what is not live and of each live region at scale 1, the lower triangle row by
    /// row; they sum to the diagonal matrix of the eigenvalues; `f64 (1 + live regions, r(r+1)/2)`.
    LiveStiffness = 113: 14, required, F64, [Any, Any];
    /// `BᵀM_qB` of the same, if a density is live; they sum to the identity;
    /// `f64 (1 + live regions, r(r+1)/2)`.
    LiveMass = 114: 14, required, F64, [Any, Any];
    /// Live region of each region of the mesh, counted from 1; 0 of those that are not live; `u32 (any)`.
    LiveRegions = 115: 14, required, U32, [Any];
    /// Terms of the scale of the residual flexibility at each loadable node: node, two live regions, share of
    /// the second, and weight; `f64 (any, 5)`.
    LiveResidual = 116: 14, optional, F64, [Any, Of(5)];
    /// Points of the parameters' box at which a build measured: each its values, 1 if it trained the basis,
    /// and the relative error of trajectories there; `f64 (any, parameters + 2)`.
    LiveCertificate = 117: 14, optional, F64, [Any, Any];
    /// `Bᵀ(K_q,ff Φ + K_q,fs T)` \[N kg^-½\] of the static shape `Φ` of each support as built and its rigid
    /// motions `T`, of what is not live and of each live region; absent where all shapes are rigid motions;
    /// `f64 (supports · (1 + live regions), 6, r)`.
    LiveReactionStiffness = 118: 14, optional, F64, [Any, Of(6), Modes];
    /// `Bᵀ(M_q,ff Φ + M_q,fs T)` \[kg^½\] of the same, if a density is live; they sum to section 55;
    /// `f64 (supports · (1 + live regions), 6, r)`.
    LiveReactionMass = 119: 14, optional, F64, [Any, Of(6), Modes];
    /// Ratio of the damping of every mode that no loss factor makes, then the loss factor of each live
    /// region; what is not live has none; `f64 (1 + live regions)`.
    LiveLoss = 120: 14, required, F64, [Any];
    /// Group of dashpots of each row of section 79, counted from 1; 0 of those that are not live;
    /// `u32 (any)`.
    LiveDampers = 121: 14, required, U32, [Any];
    /// The centre of the parameters' box and the worst point of section 117: each its values, the relative
    /// error of trajectories there, the distance of their reference from a march at full order, and where
    /// the file has residual flexibility the median, the 95 % quantile and the largest truncation of a point
    /// load; `f64 (any, parameters + 2 or 5)`.
    LiveWitnesses = 122: 14, optional, F64, [Any, Any];
}

impl SectionKind {
    /// The kind with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.number() == number)
    }

    /// True for a kind of the chapter's structure, which the file format calls canonical.
    #[must_use]
    pub const fn is_chapter(self) -> bool {
        self.is_required() && (self as u32) < Self::StrainSizes as u32
    }

    /// True for a kind that the strain structure cannot be stepped without.
    #[must_use]
    pub const fn is_strain(self) -> bool {
        self.is_required() && !self.is_chapter() && !self.is_live()
    }

    /// True for a kind of a parametric reduced-order model.
    #[must_use]
    pub const fn is_live(self) -> bool {
        self.is_required() && self as u32 >= Self::LiveParameters as u32
    }

    /// Its number in the file.
    #[must_use]
    pub const fn number(self) -> u32 {
        self as u32
    }

    /// The shape the metadata ask for; `None` where any number will do. Places past the rank are 1.
    #[must_use]
    pub fn shape(self, metadata: &Metadata<'_>) -> [Option<u64>; 3] {
        self.extents().map(|extent| extent.count(metadata))
    }

    /// True if the kind may have this element type.
    #[must_use]
    pub const fn allows(self, element: Element) -> bool {
        self.elements() & bit(element) != 0
    }
}
