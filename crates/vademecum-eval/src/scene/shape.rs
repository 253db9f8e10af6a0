//! The lengths everything of a scene agrees on, and the choice of the structure.

use crate::base::error::BindError;
use crate::base::options::{MAX_CONTACTS, SceneOptions, Sizes, Structure, StructureChoice};
use crate::base::scalar::Scalar;
use crate::kernels::coordinates::Parts;
use crate::kernels::kernel::{LANES, TILE};
use crate::kernels::strain::memory::StrainShape;
use crate::kernels::strain::numbers::strain_shape;
use crate::sections::axes::Axes;
use crate::sections::filter::filtered_room;
use crate::sections::residual::room;
use vademecum_format::coupled::CoupledModes;
use vademecum_format::policy::{STABLE_RADIUS, allowed_error};
use vademecum_format::scheme::fuse_work_len;
use vademecum_format::{AxisRole, File, Metadata, SectionKind, StructureCertificate};

/// The lengths a scene, its states and its loads agree on.
#[derive(Clone, Copy, Debug, Eq)]
pub(crate) struct Shape {
    /// As it was chosen; read by [`Shape::structure`].
    chosen: Structure,
    pub r: usize,
    /// Stages of the scheme; 2 of an exact step, which takes loads at its start and at its end.
    pub n_stages: usize,
    /// Terms in use.
    pub n_terms: usize,
    /// Points of all axes.
    pub n_points: usize,
    /// Nodes and patterns whose forces are remembered for the residual flexibility and for reactions.
    pub statics: [usize; 2],
    /// Nodes and patterns whose filtered forces a state keeps; zeros without a filter. A state knows its own.
    pub filtered: [usize; 2],
    /// Nodes that one contact takes of these at most.
    pub contact_nodes: usize,
    /// `true` with a filter.
    filters: bool,
    /// Of the strain structure.
    pub strain: StrainShape,
    /// Rows of dashpots that couple modes; 0 where every mode steps by itself. Read by
    /// [`Shape::is_coupled`].
    pub damping_rows: usize,
    /// Hash of all lengths but those of `filtered` (FNV-1a, word by word). Where two of different lengths met
    /// in one key, cutting their memory or an index would still be refused.
    key: u64,
}

/// Every step compares two of them with its own, by their keys.
impl PartialEq for Shape {
    #[inline(always)]
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}

impl Shape {
    fn hash(&self) -> u64 {
        const START: u64 = 0xCBF2_9CE4_8422_2325;
        const PRIME: u64 = 0x0000_0100_0000_01B3;
        let StrainShape { interacting, leading, tail, rows } = self.strain;
        let [nodes, patterns] = self.statics;
        let chosen =
            [self.chosen as usize, self.r, self.n_stages, self.n_terms, self.n_points, nodes, patterns];
        let others = [usize::from(self.filters), interacting, leading, tail, rows, self.damping_rows];
        let words = chosen.into_iter().chain(others);
        words.fold(START, |key, word| (key ^ word as u64).wrapping_mul(PRIME))
    }

    /// The structure. Without the feature `full` no other than the exact one is ever chosen, and the compiler
    /// learns it here: it leaves out of a program what the others need.
    pub const fn structure(&self) -> Structure {
        if cfg!(feature = "full") { self.chosen } else { Structure::Exact }
    }

    /// `true` for the strain structure.
    pub const fn is_strain(&self) -> bool {
        matches!(self.structure(), Structure::Strain)
    }

    /// `true` for the block structure.
    pub const fn is_block(&self) -> bool {
        matches!(self.structure(), Structure::Block)
    }

    /// `true` where the stiffness is diagonal: the coordinates are modes.
    pub const fn is_modal(&self) -> bool {
        matches!(self.structure(), Structure::Diagonal | Structure::Exact)
    }

    /// `true` where dashpots couple the modes: an exact step is one of all modes together.
    #[inline(always)]
    pub const fn is_coupled(&self) -> bool {
        cfg!(feature = "full") && self.damping_rows > 0
    }

    /// `true` where every mode steps by itself.
    pub const fn is_per_mode(&self) -> bool {
        self.is_modal() && !self.is_coupled()
    }

    /// `true` where a load reaches every coordinate.
    pub const fn is_dense(&self) -> bool {
        self.is_block() || self.is_coupled()
    }

    /// Numbers of a state without padding, the columns of a dense step.
    pub const fn columns(&self) -> usize {
        self.n_parts() * self.r
    }

    /// `true` where a step has no stages of a scheme, and a state no acceleration.
    pub const fn is_exact(&self) -> bool {
        matches!(self.structure(), Structure::Exact | Structure::Strain)
    }

    /// Number of parts of a state: ζ and Δt ζ̇, and Δt² ζ̈ with a scheme.
    pub const fn n_parts(&self) -> usize {
        if self.is_exact() { 2 } else { 3 }
    }

    /// Distance between ζ, Δt ζ̇ and Δt² ζ̈ in a state.
    pub const fn stride(&self) -> usize {
        match self.structure() {
            Structure::Exact if self.is_coupled() => self.r,
            Structure::Diagonal | Structure::Exact => self.r.next_multiple_of(LANES),
            Structure::Block | Structure::Strain => self.r,
        }
    }

    /// Length of one state, padded for the kernel.
    pub const fn padded(&self) -> usize {
        match self.structure() {
            Structure::Exact if self.is_coupled() => self.columns().next_multiple_of(TILE),
            Structure::Diagonal | Structure::Exact | Structure::Strain => self.n_parts() * self.stride(),
            Structure::Block => self.columns().next_multiple_of(TILE),
        }
    }

    /// Layout of the parts of a state.
    pub const fn parts(&self) -> Parts {
        Parts { count: self.n_parts(), r: self.r, stride: self.stride(), padded: self.padded() }
    }

    /// A state: old and new.
    pub const fn state_len(&self) -> usize {
        let forces = forces_len(self.statics).saturating_add(forces_len(self.filtered));
        forces.saturating_add(2 * self.padded()).saturating_add(self.scratch_len())
    }

    /// Length of the memory that a step works in, beside a state.
    pub const fn scratch_len(&self) -> usize {
        match self.structure() {
            Structure::Diagonal | Structure::Block | Structure::Exact => 0,
            Structure::Strain => self.strain.scratch_len(),
        }
    }

    /// Length of loads.
    pub const fn loads_len(&self) -> usize {
        let forces = forces_len(self.statics).saturating_add(forces_len(self.drive()));
        forces.saturating_add(self.padded() + (2 + self.n_stages) * self.r)
    }

    /// `true` where the residual follows forces with the time constant of the damping.
    #[inline(always)]
    pub const fn is_filtered(&self) -> bool {
        cfg!(feature = "filter") && self.filters
    }

    /// Nodes and patterns that loads keep their contribution to the filter of.
    pub const fn drive(&self) -> [usize; 2] {
        if self.is_filtered() { self.statics } else { [0; 2] }
    }

    /// Length of the step map.
    pub const fn map_len(&self) -> usize {
        match self.structure() {
            Structure::Exact if self.is_coupled() => self.padded().saturating_mul(self.columns()),
            Structure::Diagonal | Structure::Exact => self.n_parts() * self.padded(),
            Structure::Block => self.padded() * self.columns(),
            Structure::Strain => self.strain.map_len(),
        }
    }

    /// Length of one stage's load map.
    pub const fn load_map_len(&self) -> usize {
        match self.structure() {
            Structure::Exact if self.is_coupled() => self.padded().saturating_mul(self.r),
            Structure::Diagonal | Structure::Exact | Structure::Strain => self.padded(),
            Structure::Block => self.padded() * self.r,
        }
    }

    /// Length of the load maps of all stages.
    pub const fn load_maps_len(&self) -> usize {
        self.n_stages * self.load_map_len()
    }

    /// Weights of the terms in all stages.
    pub const fn weights_len(&self) -> usize {
        self.n_stages * self.n_terms
    }

    /// Numbers of work that the compliance at so many places wants.
    pub const fn compliance_work(&self, places: usize) -> usize {
        let own = match self.structure() {
            Structure::Diagonal | Structure::Block | Structure::Exact => self.r,
            Structure::Strain => self.padded().saturating_add(self.scratch_len()),
        };
        places.saturating_mul(3).saturating_mul(self.r).saturating_add(own)
    }

    /// Numbers of `f64` that fusing wants.
    pub const fn work_len(&self) -> usize {
        let (r, n) = (self.r, self.n_stages);
        match self.structure() {
            Structure::Diagonal => (9 + 3 * n) * r,
            Structure::Exact if self.is_coupled() => {
                // D and the load maps, the three responses, stiffness and damping of each mode, the rows. The
                // load maps come last, and their place is work before.
                let square = r.saturating_mul(r);
                let work = larger(square.saturating_mul(4), CoupledModes::work_len(r));
                let modes = square.saturating_mul(7).saturating_add(r.saturating_mul(2));
                modes.saturating_add(work).saturating_add(self.damping_rows.saturating_mul(r))
            }
            Structure::Exact => (4 + 2 * n) * r,
            Structure::Strain => 0,
            Structure::Block => {
                let dense = ((n + 9 + 3 * n) * r * r).saturating_add(fuse_work_len(r));
                let axes = self.n_points.saturating_mul(Axes::WORK);
                dense.saturating_add(axes).saturating_add(self.weights_len())
            }
        }
    }

    /// Numbers of memory. Modes, stages and terms are at most 4096, 3 and 65 536; what else grows without
    /// such a bound is added up so that it stops at the largest number, and [`shape`] refuses that.
    pub const fn sizes(&self) -> Sizes {
        Sizes {
            scene: self.map_len().saturating_add(self.load_maps_len()).saturating_add(self.weights_len()),
            work: self.work_len(),
            state: self.state_len(),
            loads: self.loads_len(),
        }
    }
}

/// The larger of two lengths.
pub(crate) const fn larger(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

/// Numbers of memory for forces on so many nodes and amplitudes of so many patterns.
const fn forces_len([nodes, patterns]: [usize; 2]) -> usize {
    nodes.saturating_mul(4).saturating_add(patterns)
}

/// Refuses more than `most`.
pub(crate) const fn at_most(what: &'static str, asked: usize, most: usize) -> Result<(), BindError> {
    if asked <= most { Ok(()) } else { Err(BindError::TooLarge { what, asked, most }) }
}

/// The shape of a scene of these options.
pub(crate) fn shape<T: Scalar>(file: &File<'_>, options: &SceneOptions) -> Result<Shape, BindError> {
    check(options)?;
    at_most("contacts", options.contacts, MAX_CONTACTS)?;
    let metadata = file.metadata();
    let strain = file.section(SectionKind::StrainSizes).is_some();
    let structure = choose(metadata, strain, options)?;
    let (n_terms, n_points) = match structure {
        Structure::Block => (terms(metadata, options)?, metadata.n_axis_points() as usize),
        Structure::Diagonal | Structure::Exact | Structure::Strain => (0, 0),
    };
    let n_stages = match structure {
        Structure::Exact | Structure::Strain => 2,
        Structure::Diagonal | Structure::Block => metadata.scheme.active().len(),
    };
    let damping_rows = damping_rows(file, structure)?;
    let residual = options.residual && structure != Structure::Block;
    let (statics, strain) = match structure {
        Structure::Strain => ([0; 2], strain_shape(file)?),
        _ => (room::<T>(file, options.contacts, residual), StrainShape::default()),
    };
    let filtered = filtered_room(file, options, statics);
    if !cfg!(feature = "filter") && filtered != [0; 2] {
        return Err(BindError::FilterLeftOut);
    }
    let mut shape = Shape {
        chosen: structure,
        r: metadata.n_modes as usize,
        n_stages,
        n_terms,
        n_points,
        statics,
        filtered,
        contact_nodes: file.contact_nodes(),
        filters: filtered != [0; 2],
        strain,
        damping_rows,
        key: 0,
    };
    shape.key = shape.hash();
    let Sizes { scene, work, state, loads } = shape.sizes();
    at_most(
        "numbers of memory",
        scene.max(work).max(state).max(loads),
        isize::MAX as usize / size_of::<f64>(),
    )?;
    Ok(shape)
}

/// Rows of dashpots that couple modes; refused where a step would leave them out.
fn damping_rows(file: &File<'_>, structure: Structure) -> Result<usize, BindError> {
    let kind = SectionKind::DampingRows;
    let rows = file.section(kind).map_or(0, |section| section.shape()[0]);
    match structure {
        _ if rows == 0 => Ok(0),
        Structure::Exact if cfg!(feature = "full") => Ok(usize::try_from(rows).unwrap_or(usize::MAX)),
        Structure::Exact => Err(BindError::LeftOut),
        Structure::Diagonal | Structure::Block | Structure::Strain => Err(BindError::OnlyExact { kind }),
    }
}

/// The terms a block scene of these options adds up: the first of the file's.
pub(crate) fn terms(metadata: &Metadata<'_>, options: &SceneOptions) -> Result<usize, BindError> {
    let found = metadata.n_terms as usize;
    let asked = options.terms.unwrap_or(found);
    // On a stage axis every term is a stage of its own.
    let fixed = metadata.active_axes().iter().any(|axis| matches!(axis.role, AxisRole::Stage));
    if asked == found || (!fixed && (1..found).contains(&asked)) {
        return Ok(asked);
    }
    Err(BindError::Terms { asked, found })
}

/// Checks what does not depend on the file.
pub(crate) fn check(options: &SceneOptions) -> Result<(), BindError> {
    for value in [options.tolerance, options.rest_below] {
        if value.is_nan() || value < 0.0 {
            return Err(BindError::BadOption { value });
        }
    }
    Ok(())
}

fn choose(metadata: &Metadata<'_>, strain: bool, options: &SceneOptions) -> Result<Structure, BindError> {
    let exact = metadata.diagonal.then_some(Structure::Exact);
    let block = metadata.block.then_some(Structure::Block);
    let diagonal = if metadata.scheme.is_exact() { None } else { exact.and(Some(Structure::Diagonal)) };
    let strain = strain.then_some(Structure::Strain);
    if exact.or(block).or(strain).is_none() {
        // A file without either opens only if it has the chapter's.
        return Err(BindError::OnlyChapter);
    }
    if !cfg!(feature = "full") {
        let asked = match options.structure {
            StructureChoice::Auto => metadata.scheme.is_exact() && strain.is_none(),
            StructureChoice::Exact => true,
            StructureChoice::Diagonal | StructureChoice::Block | StructureChoice::Strain => false,
        };
        return exact.filter(|_| asked && !options.moves_a_region()).ok_or(BindError::LeftOut);
    }
    if options.moves_a_region() {
        return match options.structure {
            StructureChoice::Diagonal | StructureChoice::Exact => Err(BindError::NotDiagonal),
            StructureChoice::Strain => Err(BindError::WholeBody),
            StructureChoice::Auto if strain.is_some() => Err(BindError::WholeBody),
            _ => block.ok_or(BindError::NotDiagonal),
        };
    }
    let structure = match options.structure {
        StructureChoice::Diagonal => diagonal,
        StructureChoice::Block => block,
        StructureChoice::Exact => exact,
        StructureChoice::Strain => strain,
        StructureChoice::Auto if strain.is_some() => strain,
        StructureChoice::Auto if metadata.scheme.is_exact() => exact,
        StructureChoice::Auto if diagonal.is_some() && block.is_some() => {
            let [a, b] = [&metadata.certificate.diagonal, &metadata.certificate.block];
            // An unstable structure is no better than one whose error was never measured.
            let error = |c: &StructureCertificate| {
                let unknown = c.trajectory_error.is_nan() || c.spectral_radius > STABLE_RADIUS;
                if unknown { f64::MAX } else { c.trajectory_error }
            };
            let keeps = |c| error(c) <= options.tolerance || error(c) <= allowed_error(c.projection_floor);
            if keeps(a) || (!keeps(b) && error(a) <= error(b)) { diagonal } else { block }
        }
        StructureChoice::Auto => diagonal.or(block),
    };
    structure.ok_or(BindError::NoStructure)
}
