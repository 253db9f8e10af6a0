//! The lengths everything of a scene agrees on, and the choice of the structure.

use crate::axes::Axes;
use crate::error::BindError;
use crate::kernel::{LANES, TILE};
use crate::options::{SceneOptions, Sizes, Structure, StructureChoice};
use vademecum_format::scheme::fuse_work_len;
use vademecum_format::{AxisRole, Chapter, File, Metadata, StructureCertificate};

/// Largest certified spectral radius of a step that counts as stable: rounding of eigenvalues at 1, as the build judges it.
const STABLE: f64 = 1.0 + 1e-12;

/// The lengths a scene, its states and its loads agree on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    pub structure: Structure,
    pub r: usize,
    pub n_stages: usize,
    /// Terms in use; of the canonical structure the most of a part.
    pub n_terms: usize,
    /// Points of all axes; of the canonical structure all numbers of its factors and terms.
    pub n_points: usize,
}

impl Shape {
    /// Distance between ζ, Δt ζ̇ and Δt² ζ̈ in a state.
    pub const fn stride(&self) -> usize {
        match self.structure {
            Structure::Diagonal => self.r.next_multiple_of(LANES),
            Structure::Block | Structure::Canonical => self.r,
        }
    }

    /// Length of one state, padded for the kernel.
    pub const fn padded(&self) -> usize {
        match self.structure {
            Structure::Diagonal | Structure::Canonical => 3 * self.stride(),
            Structure::Block => (3 * self.r).next_multiple_of(TILE),
        }
    }

    /// A state: old and new, and what a step needs beside them.
    pub const fn state_len(&self) -> usize {
        2 * self.padded() + self.scratch_len()
    }

    /// The stages of a step and the weights of a part's terms, of the canonical structure.
    const fn scratch_len(&self) -> usize {
        match self.structure {
            Structure::Diagonal | Structure::Block => 0,
            Structure::Canonical => self.n_stages * self.r + self.n_terms,
        }
    }

    /// Weights of the terms kept in a scene, and room for those of one contact in the loads.
    const fn weight_lens(&self) -> (usize, usize) {
        match self.structure {
            Structure::Diagonal | Structure::Block => (self.n_stages * self.n_terms, 0),
            Structure::Canonical => (0, self.n_terms),
        }
    }

    /// Length of loads.
    pub const fn loads_len(&self) -> usize {
        self.padded() + (2 + self.n_stages) * self.r + self.weight_lens().1
    }

    /// Length of the step map.
    pub const fn map_len(&self) -> usize {
        match self.structure {
            Structure::Diagonal => 9 * self.stride(),
            Structure::Block => self.padded() * 3 * self.r,
            Structure::Canonical => self.n_points,
        }
    }

    /// Length of one stage's load map.
    pub const fn load_map_len(&self) -> usize {
        match self.structure {
            Structure::Diagonal => self.padded(),
            Structure::Block => self.padded() * self.r,
            Structure::Canonical => 0,
        }
    }

    /// Numbers of `f64` that fusing wants.
    pub const fn work_len(&self) -> usize {
        let (r, n) = (self.r, self.n_stages);
        match self.structure {
            Structure::Diagonal => (9 + 3 * n) * r,
            Structure::Block => {
                (n + 9 + 3 * n) * r * r + n * self.n_terms + Axes::WORK * self.n_points + fuse_work_len(r)
            }
            Structure::Canonical => 0,
        }
    }

    pub const fn sizes(&self) -> Sizes {
        Sizes {
            scene: self.map_len() + self.n_stages * self.load_map_len() + self.weight_lens().0,
            work: self.work_len(),
            state: self.state_len(),
            loads: self.loads_len(),
        }
    }
}

/// The shape of a scene of these options.
pub(crate) fn shape(file: &File<'_>, options: &SceneOptions) -> Result<Shape, BindError> {
    check(options)?;
    let (metadata, canonical) = (file.metadata(), Chapter::read(file)?);
    let structure = choose(metadata, canonical.is_some(), options)?;
    let (n_terms, n_points) = match structure {
        Structure::Canonical => canonical.map_or((0, 0), |canonical| {
            let (factors, terms) = canonical.lengths();
            (canonical.max_terms(), factors.saturating_add(terms))
        }),
        Structure::Block => (terms(metadata, options)?, metadata.n_axis_points() as usize),
        Structure::Diagonal => (0, 0),
    };
    let n_stages = metadata.scheme.active().len();
    Ok(Shape { structure, r: metadata.n_modes as usize, n_stages, n_terms, n_points })
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

/// What does not depend on the file.
pub(crate) fn check(options: &SceneOptions) -> Result<(), BindError> {
    for value in [options.tolerance, options.rest_below] {
        if value.is_nan() || value < 0.0 {
            return Err(BindError::BadOption { value });
        }
    }
    Ok(())
}

fn choose(metadata: &Metadata<'_>, canonical: bool, options: &SceneOptions) -> Result<Structure, BindError> {
    let canonical = canonical.then_some(Structure::Canonical);
    let block = metadata.block.then_some(Structure::Block);
    let diagonal = metadata.diagonal.then_some(Structure::Diagonal);
    if options.moves_a_region() {
        return match options.structure {
            StructureChoice::Diagonal => Err(BindError::NotDiagonal),
            StructureChoice::Canonical => Err(BindError::FixedStep),
            _ => block.ok_or(BindError::NotDiagonal),
        };
    }
    let structure = match options.structure {
        StructureChoice::Diagonal => diagonal,
        StructureChoice::Block => block,
        StructureChoice::Canonical => canonical,
        StructureChoice::Auto if diagonal.is_some() && block.is_some() => {
            let [a, b] = [&metadata.certificate.diagonal, &metadata.certificate.block];
            // An unstable structure is no better than one whose error was never measured.
            let error = |c: &StructureCertificate| {
                let unknown = c.trajectory_error.is_nan() || c.spectral_radius > STABLE;
                if unknown { f64::MAX } else { c.trajectory_error }
            };
            let keeps = |c| error(c) <= options.tolerance || error(c) <= 1.1 * c.projection_floor + 1e-6;
            if keeps(a) || (!keeps(b) && error(a) <= error(b)) { diagonal } else { block }
        }
        StructureChoice::Auto => diagonal.or(block).or(canonical),
    };
    structure.ok_or(BindError::NoStructure)
}
