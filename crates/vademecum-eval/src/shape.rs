//! The lengths everything of a scene agrees on, and the choice of the structure.

use crate::error::BindError;
use crate::kernel::{LANES, TILE};
use crate::options::{SceneOptions, Sizes, Structure, StructureChoice};
use vademecum_format::scheme::fuse_work_len;
use vademecum_format::{Metadata, StructureCertificate};

/// The lengths a scene, its states and its loads agree on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    pub structure: Structure,
    pub r: usize,
    pub n_stages: usize,
    pub n_terms: usize,
}

impl Shape {
    /// Distance between ζ, Δt ζ̇ and Δt² ζ̈ in a state.
    pub const fn stride(&self) -> usize {
        match self.structure {
            Structure::Diagonal => self.r.next_multiple_of(LANES),
            Structure::Block => self.r,
        }
    }

    /// Length of one state, padded for the kernel.
    pub const fn padded(&self) -> usize {
        match self.structure {
            Structure::Diagonal => 3 * self.stride(),
            Structure::Block => (3 * self.r).next_multiple_of(TILE),
        }
    }

    /// A state: old and new.
    pub const fn state_len(&self) -> usize {
        2 * self.padded()
    }

    /// Length of the step map.
    pub const fn map_len(&self) -> usize {
        match self.structure {
            Structure::Diagonal => 9 * self.stride(),
            Structure::Block => self.padded() * 3 * self.r,
        }
    }

    /// Length of one stage's load map.
    pub const fn load_map_len(&self) -> usize {
        match self.structure {
            Structure::Diagonal => self.padded(),
            Structure::Block => self.padded() * self.r,
        }
    }

    pub const fn sizes(&self) -> Sizes {
        let (r, n) = (self.r, self.n_stages);
        let work = match self.structure {
            Structure::Diagonal => 0,
            Structure::Block => (n + 9 + 3 * n) * r * r + fuse_work_len(r),
        };
        Sizes {
            scene: self.map_len() + n * self.load_map_len() + n * self.n_terms,
            work,
            state: self.state_len(),
            loads: self.padded() + (2 + n) * r,
        }
    }
}

/// The shape of a scene of these options.
pub(crate) fn shape(metadata: &Metadata<'_>, options: &SceneOptions) -> Result<Shape, BindError> {
    for value in [options.tolerance, options.rest_below] {
        if value.is_nan() || value < 0.0 {
            return Err(BindError::BadOption { value });
        }
    }
    let structure = choose(metadata, options).ok_or(BindError::NoStructure)?;
    let n_terms = if structure == Structure::Block {
        metadata.n_terms as usize
    } else {
        0
    };
    let n_stages = metadata.scheme.active().len();
    Ok(Shape {
        structure,
        r: metadata.n_modes as usize,
        n_stages,
        n_terms,
    })
}

fn choose(metadata: &Metadata<'_>, options: &SceneOptions) -> Option<Structure> {
    let diagonal = metadata.diagonal.then_some(Structure::Diagonal);
    let block = metadata.block.then_some(Structure::Block);
    match options.structure {
        StructureChoice::Diagonal => diagonal,
        StructureChoice::Block => block,
        StructureChoice::Auto if diagonal.is_some() && block.is_some() => {
            let [a, b] = [&metadata.certificate.diagonal, &metadata.certificate.block];
            let error = |c: &StructureCertificate| {
                if c.trajectory_error.is_nan() {
                    f64::MAX
                } else {
                    c.trajectory_error
                }
            };
            let keeps =
                |c| error(c) <= options.tolerance || error(c) <= 1.1 * c.projection_floor + 1e-6;
            if keeps(a) || (!keeps(b) && error(a) <= error(b)) {
                diagonal
            } else {
                block
            }
        }
        StructureChoice::Auto => diagonal.or(block),
    }
}
