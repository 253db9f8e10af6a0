//! Metadata of a file: its origin, its counts, the scheme, the axes, the
//! certificate.
//!
//! Encoded by bincode 2.0.1 with fixed-width little-endian integers, under a size limit; strings are borrowed
//! from the file. [`Metadata::check`] holds the numbers to their ranges and runs in the reader and in the
//! writer alike.

use crate::error::{FormatError, Quantity};
use crate::parameter::{Parameter, ParameterRole};
use crate::scheme::{SchemeTable, TableError};
use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use bincode::de::BorrowDecoder;
use bincode::error::DecodeError;
use bincode::{BorrowDecode, Encode};

/// Most axes a separated solution can have.
pub const MAX_AXES: usize = if cfg!(feature = "full") { STORED_AXES } else { 0 };
/// Axes as a file stores them, used or not.
const STORED_AXES: usize = 12;
/// Most bytes of encoded metadata (the problem file's text is in them).
pub const MAX_METADATA: usize = 1 << 20;
/// Most modes.
pub const MAX_MODES: u32 = 4096;
/// Most regions: stiffness and density of each can have a scale of its own.
pub const MAX_REGIONS: usize = 8;
/// Most parameters a scene can be set to.
pub const MAX_PARAMETERS: usize = 16;
/// Most terms of a separated solution.
pub const MAX_TERMS: u32 = 65_536;
/// Most nodes: three dofs each must stay countable in 32 bits.
pub const MAX_NODES: u32 = u32::MAX / 4;
/// Most triangles, patterns, probes and axis points.
pub const MAX_ITEMS: u32 = u32::MAX / 4;

/// Everything a file says about itself. Counts are items, not dofs.
///
/// Node order: loadable surface nodes first, then the other surface nodes, then the interior ones. Triangles
/// whose three nodes are loadable come first.
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct Metadata<'a> {
    /// Name and version of the program that wrote the file.
    pub program: &'a str,
    /// The problem file's text, as it was built.
    pub problem: &'a str,
    /// Units, e.g. `m, kg, s`.
    pub units: &'a str,
    /// XXH3-128 of the mesh the file belongs to.
    pub mesh_hash: [u8; 16],
    /// Nodes of the body.
    pub n_nodes: u32,
    /// Nodes on its surface, the first of all nodes.
    pub n_surface_nodes: u32,
    /// Nodes a contact may load, the first of the surface nodes.
    pub n_load_nodes: u32,
    /// Surface triangles.
    pub n_triangles: u32,
    /// Triangles a contact may lie in, the first of all triangles.
    pub n_load_triangles: u32,
    /// `r`: modes of the basis.
    pub n_modes: u32,
    /// Distributed load patterns.
    pub n_patterns: u32,
    /// Named probes.
    pub n_probes: u32,
    /// Name of the time scheme.
    pub scheme_name: &'a str,
    /// The time scheme.
    pub scheme: SchemeTable,
    /// `Δt` \[s\] the file was built for.
    pub time_step: f64,
    /// Rayleigh `α` \[1/s\].
    pub alpha: f64,
    /// Rayleigh `β` \[s\].
    pub beta: f64,
    /// Regions of the body, 1 to [`MAX_REGIONS`].
    pub n_regions: u32,
    /// Number of parameters in use.
    pub n_parameters: u32,
    /// Parameters of a scene; those past `n_parameters` are [`Parameter::UNUSED`].
    pub parameters: [Parameter<'a>; MAX_PARAMETERS],
    /// Axes of the block structure's separated solution; those past `n_axes` are [`Axis::UNUSED`].
    pub axes: [Axis<'a>; MAX_AXES],
    /// Number of axes in use.
    pub n_axes: u32,
    /// Terms of the block structure; 0 without it.
    pub n_terms: u32,
    /// The diagonal structure is present (Ritz basis, `BᵀKB` diagonal).
    pub diagonal: bool,
    /// The block structure is present.
    pub block: bool,
    /// Error certificate of the build.
    pub certificate: Certificate,
}

// By hand what the derive would write, for the sake of `axes` and `parameters`: bincode's own array of
// borrowing items leaves a panic in the library that the compiler cannot rule out, and `tests/bare-metal`
// allows none.
impl<'a, 'de: 'a, Context> BorrowDecode<'de, Context> for Metadata<'a> {
    fn borrow_decode<D: BorrowDecoder<'de, Context = Context>>(decoder: &mut D) -> Result<Self, DecodeError> {
        Ok(Self {
            program: BorrowDecode::borrow_decode(decoder)?,
            problem: BorrowDecode::borrow_decode(decoder)?,
            units: BorrowDecode::borrow_decode(decoder)?,
            mesh_hash: BorrowDecode::borrow_decode(decoder)?,
            n_nodes: BorrowDecode::borrow_decode(decoder)?,
            n_surface_nodes: BorrowDecode::borrow_decode(decoder)?,
            n_load_nodes: BorrowDecode::borrow_decode(decoder)?,
            n_triangles: BorrowDecode::borrow_decode(decoder)?,
            n_load_triangles: BorrowDecode::borrow_decode(decoder)?,
            n_modes: BorrowDecode::borrow_decode(decoder)?,
            n_patterns: BorrowDecode::borrow_decode(decoder)?,
            n_probes: BorrowDecode::borrow_decode(decoder)?,
            scheme_name: BorrowDecode::borrow_decode(decoder)?,
            scheme: BorrowDecode::borrow_decode(decoder)?,
            time_step: BorrowDecode::borrow_decode(decoder)?,
            alpha: BorrowDecode::borrow_decode(decoder)?,
            beta: BorrowDecode::borrow_decode(decoder)?,
            n_regions: BorrowDecode::borrow_decode(decoder)?,
            n_parameters: BorrowDecode::borrow_decode(decoder)?,
            parameters: items(decoder, Parameter::UNUSED, MAX_PARAMETERS)?,
            axes: items(decoder, Axis::UNUSED, STORED_AXES)?,
            n_axes: BorrowDecode::borrow_decode(decoder)?,
            n_terms: BorrowDecode::borrow_decode(decoder)?,
            diagonal: BorrowDecode::borrow_decode(decoder)?,
            block: BorrowDecode::borrow_decode(decoder)?,
            certificate: BorrowDecode::borrow_decode(decoder)?,
        })
    }
}

/// The first `N` of so many stored items.
fn items<'de, T, const N: usize, D>(decoder: &mut D, filler: T, stored: usize) -> Result<[T; N], DecodeError>
where
    T: Copy + BorrowDecode<'de, D::Context>,
    D: BorrowDecoder<'de>,
{
    let mut items = [filler; N];
    for place in 0..stored {
        let item = BorrowDecode::borrow_decode(decoder)?;
        if let Some(place) = items.get_mut(place) {
            *place = item;
        }
    }
    Ok(items)
}

/// Error certificate, per structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Encode, BorrowDecode)]
pub struct Certificate {
    /// Of the diagonal structure.
    pub diagonal: StructureCertificate,
    /// Of the block structure.
    pub block: StructureCertificate,
}

/// Error certificate of one structure; NaN where it was not measured.
#[derive(Clone, Copy, Debug, PartialEq, Encode, BorrowDecode)]
pub struct StructureCertificate {
    /// Relative L2 error over all dofs and steps at unseen loads, mass norm.
    pub trajectory_error: f64,
    /// The same norm of what the basis cannot show of the full-order trajectory.
    pub projection_floor: f64,
    /// Spectral radius of the fused step.
    pub spectral_radius: f64,
    /// Largest energy after release over the energy at release.
    pub energy_ratio: f64,
    /// Relative error of the stage maps at fresh parameter points, root of the mean square.
    pub map_error_rms: f64,
    /// The largest of them.
    pub map_error_max: f64,
    /// Steps of the trajectory behind these numbers.
    pub steps: f64,
}

impl Default for StructureCertificate {
    /// Nothing measured.
    fn default() -> Self {
        Self::from_numbers([f64::NAN; 7])
    }
}

impl StructureCertificate {
    /// Its numbers in the order of the file.
    #[must_use]
    pub const fn numbers(&self) -> [f64; 7] {
        [
            self.trajectory_error,
            self.projection_floor,
            self.spectral_radius,
            self.energy_ratio,
            self.map_error_rms,
            self.map_error_max,
            self.steps,
        ]
    }

    /// From its numbers in the order of the file.
    #[must_use]
    pub const fn from_numbers(numbers: [f64; 7]) -> Self {
        let [
            trajectory_error,
            projection_floor,
            spectral_radius,
            energy_ratio,
            map_error_rms,
            map_error_max,
            steps,
        ] = numbers;
        Self {
            trajectory_error,
            projection_floor,
            spectral_radius,
            energy_ratio,
            map_error_rms,
            map_error_max,
            steps,
        }
    }
}

/// One coordinate of the separated solution.
#[derive(Clone, Copy, Debug, PartialEq, Encode, BorrowDecode)]
pub struct Axis<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its unit; empty for a pure number.
    pub unit: &'a str,
    /// Coordinate along the axis.
    pub role: AxisRole,
    /// Storage of its factors.
    pub kind: AxisKind,
    /// The factors are functions of the natural logarithm of the parameter; `lower` is then positive.
    pub log: bool,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Number of points.
    pub n_points: u32,
}

impl Axis<'_> {
    /// The filler of unused places.
    pub const UNUSED: Axis<'static> = Axis {
        name: "",
        unit: "",
        role: AxisRole::Stage,
        kind: AxisKind::Index,
        log: false,
        lower: 0.0,
        upper: 0.0,
        n_points: 0,
    };

    fn is_sound(&self, n_stages: u8, n_regions: u32) -> bool {
        let ordered = self.lower.is_finite() && self.upper.is_finite() && self.lower <= self.upper;
        let points = self.n_points >= 1 && self.n_points <= MAX_ITEMS;
        let logarithm = !self.log || self.lower > 0.0;
        let role = match self.role {
            AxisRole::Stage => matches!(self.kind, AxisKind::Index) && self.n_points == u32::from(n_stages),
            AxisRole::Monomial { theta, stiffness, density } => {
                let used = |exponents: &[f64; MAX_REGIONS]| {
                    let mut places = (0..).zip(exponents);
                    places.all(|(q, e): (u32, &f64)| e.is_finite() && (q < n_regions || *e == 0.0))
                };
                theta.is_finite() && used(&stiffness) && used(&density)
            }
        };
        ordered && points && logarithm && role
    }
}

/// Coordinate of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Encode, BorrowDecode)]
#[non_exhaustive]
pub enum AxisRole {
    /// The stage of the scheme, counted from 0.
    Stage,
    /// `θ^theta Π_q κ_q^stiffness[q] Π_q ρ_q^density[q]`: `θ` \[s²\] of the stage (uniform stiffness and
    /// density, `Δt`, `α` and `β` are in it, see [`crate::scheme::theta`]), `κ_q` and `ρ_q` the stiffness and
    /// density scales of region `q`.
    Monomial {
        /// Exponent of the stage's `θ`.
        theta: f64,
        /// Exponents of the regions' stiffness scales.
        stiffness: [f64; MAX_REGIONS],
        /// Exponents of the regions' density scales.
        density: [f64; MAX_REGIONS],
    },
}

/// Interpolation of an axis's factors between its points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, BorrowDecode)]
#[non_exhaustive]
pub enum AxisKind {
    /// Values at the integers 0, 1, …, `n_points − 1`; nothing between.
    Index,
    /// Piecewise linear between increasing points.
    Hat,
    /// The polynomial through the points (barycentric formula), which lie at Chebyshev places.
    Chebyshev,
}

/// Encoding of the metadata.
pub(crate) fn configuration() -> Configuration<LittleEndian, Fixint, Limit<MAX_METADATA>> {
    bincode::config::standard().with_little_endian().with_fixed_int_encoding().with_limit::<MAX_METADATA>()
}

impl<'a> Metadata<'a> {
    /// The axes in use.
    #[must_use]
    pub fn active_axes(&self) -> &[Axis<'a>] {
        usize::try_from(self.n_axes).ok().and_then(|n| self.axes.get(..n)).unwrap_or(&self.axes)
    }

    /// The parameters in use.
    #[must_use]
    pub fn active_parameters(&self) -> &[Parameter<'a>] {
        usize::try_from(self.n_parameters)
            .ok()
            .and_then(|n| self.parameters.get(..n))
            .unwrap_or(&self.parameters)
    }

    /// Points of all axes together.
    #[must_use]
    pub fn n_axis_points(&self) -> u64 {
        self.active_axes().iter().map(|axis| u64::from(axis.n_points)).sum()
    }

    /// Holds every number to its range. The flags say whether the canonical and the strain structure are in
    /// the file, of which the metadata do not tell.
    ///
    /// # Errors
    /// Refusals 13 to 17 and 31.
    pub fn check(&self, [canonical, strain]: [bool; 2]) -> Result<(), FormatError> {
        self.check_counts()?;
        self.check_numbers()?;
        self.scheme.check()?;
        let without_stages = self.diagonal || strain;
        if self.scheme.is_exact() && (!without_stages || self.block || canonical) {
            // What is moved by stages needs a scheme that has some.
            return Err(TableError::StageCount { found: 0 }.into());
        }
        if strain && !self.scheme.is_exact() {
            // The strain structure has a step of its own.
            return Err(TableError::StagesBesideStrain { found: self.scheme.n_stages }.into());
        }
        for (place, axis) in self.axes.iter().enumerate() {
            let used = place < self.active_axes().len();
            let sound = if used {
                axis.is_sound(self.scheme.n_stages, self.n_regions)
            } else {
                *axis == Axis::UNUSED
            };
            if !sound {
                return Err(FormatError::Axis { axis: place as u32 });
            }
        }
        self.check_parameters()?;
        if !self.diagonal && !self.block && !canonical && !strain {
            return Err(FormatError::NoStructure);
        }
        Ok(())
    }

    fn check_counts(&self) -> Result<(), FormatError> {
        let least = u32::from(self.block);
        let (terms, axes) = if self.block { (MAX_TERMS, MAX_AXES as u32) } else { (0, 0) };
        let counts = [
            (Quantity::Nodes, self.n_nodes, 1, MAX_NODES),
            (Quantity::SurfaceNodes, self.n_surface_nodes, 0, self.n_nodes),
            (Quantity::LoadNodes, self.n_load_nodes, 0, self.n_surface_nodes),
            (Quantity::Triangles, self.n_triangles, 0, MAX_ITEMS),
            (Quantity::LoadTriangles, self.n_load_triangles, 0, self.n_triangles),
            (Quantity::Modes, self.n_modes, 1, MAX_MODES),
            (Quantity::Patterns, self.n_patterns, 0, MAX_ITEMS),
            (Quantity::Probes, self.n_probes, 0, MAX_ITEMS),
            (Quantity::Terms, self.n_terms, least, terms),
            (Quantity::Axes, self.n_axes, least, axes),
            (Quantity::Regions, self.n_regions, 1, MAX_REGIONS as u32),
            (Quantity::Parameters, self.n_parameters, 0, MAX_PARAMETERS as u32),
        ];
        for (what, found, lower, upper) in counts {
            if found < lower || found > upper {
                return Err(FormatError::Count { what, found, lower, upper });
            }
        }
        Ok(())
    }

    fn check_parameters(&self) -> Result<(), FormatError> {
        let used = self.active_parameters();
        for (place, parameter) in self.parameters.iter().enumerate() {
            let mut before = used.iter().take(place);
            let sound = if place < used.len() {
                let twice = before.any(|p| p.name == parameter.name || p.role == parameter.role);
                // Those of a parametric model alone are in a section.
                use ParameterRole as R;
                let other = matches!(parameter.role, R::LossFactor { .. } | R::Damping { .. });
                parameter.is_sound(self.n_regions) && !other && !twice
            } else {
                *parameter == Parameter::UNUSED
            };
            if !sound {
                return Err(FormatError::Parameter { parameter: place as u32 });
            }
        }
        Ok(())
    }

    fn check_numbers(&self) -> Result<(), FormatError> {
        let numbers = [
            (Quantity::TimeStep, self.time_step, f64::MIN_POSITIVE),
            (Quantity::Alpha, self.alpha, 0.0),
            (Quantity::Beta, self.beta, 0.0),
        ];
        for (what, found, lower) in numbers {
            if !found.is_finite() || found < lower {
                return Err(FormatError::Number { what, found });
            }
        }
        let certificates = [self.certificate.diagonal.numbers(), self.certificate.block.numbers()];
        for &found in certificates.iter().flatten() {
            if found.is_infinite() || found < 0.0 {
                return Err(FormatError::Number { what: Quantity::Certificate, found });
            }
        }
        Ok(())
    }
}
