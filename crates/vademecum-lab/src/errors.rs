//! The error of a method and its parts: a chain from the motion that is exact in time to the method, one
//! thing changed per link.
//!
//! ```text
//! exact motion ─time─ full order at Δt ─space─ on the basis ─separation─ from terms ─rounding─ in f32
//! ```
//!
//! Each part is the distance between two neighbours and the total that between the ends, all in the mass norm
//! over all dofs and instants and relative to the exact motion: the total is at most the sum of the parts,
//! and they may cancel.

use serde::Serialize;
use vademecum_build::Matrix;
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::progress::Listener;
use vademecum_study::parts::Study;

use super::march::March;
use super::method::{Group, Method, Part, Shipped, Way};
use super::trajectory::{Projection, Reference, distance, distance_on_bases};
use vademecum_study::StudyError;

/// Error of a method and its parts; the parts a method does not have are `None`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Errors {
    /// Relative L2 from full order with the same scheme and Δt.
    pub trajectory_error: f64,
    /// The same of the full-order march projected on the basis.
    pub projection_floor: f64,
    /// Relative L2 from the motion that is exact in time.
    pub error_total: f64,
    /// From the exact motion to full order at Δt; 0 where nothing is discrete in time.
    pub error_time: f64,
    /// From full order at Δt to the basis, in f64 and without terms; from the exact motion where nothing is
    /// discrete in time.
    pub error_space: Option<f64>,
    /// From solved responses to terms over the live parameters.
    pub error_separation: Option<f64>,
    /// From f64 to f32, or from the basis as built to one of 16 bits.
    pub error_rounding: Option<f64>,
}

/// Reference solutions of a scenario at one Δt.
pub(super) struct Marches {
    /// Exact in time, at the instants of `full`.
    pub truth: Reference,
    /// The scheme at Δt.
    pub full: Reference,
    /// `‖truth − full‖ ÷ ‖truth‖`.
    pub time: f64,
}

impl Marches {
    /// Measures the two.
    pub fn new(study: &Study, truth: Matrix, full: Matrix) -> Self {
        let mass = study.mass();
        let (truth, full) = (Reference::new(mass, truth), Reference::new(mass, full));
        let time = distance(mass, truth.displacement.as_ref(), full.displacement.as_ref()) / truth.norm;
        Self { truth, full, time }
    }

    /// Of the full-order march itself.
    pub fn of_full_order(&self) -> Errors {
        Errors {
            trajectory_error: 0.0,
            projection_floor: 0.0,
            error_total: self.time,
            error_time: self.time,
            error_space: None,
            error_separation: None,
            error_rounding: None,
        }
    }

    /// Of a full-order march with another scheme at the same Δt.
    pub fn of_other_scheme(&self, study: &Study, march: &Matrix) -> Errors {
        let apart =
            |from: &Reference| distance(study.mass(), march.as_ref(), from.displacement.as_ref()) / from.norm;
        let total = apart(&self.truth);
        Errors {
            trajectory_error: apart(&self.full),
            error_total: total,
            error_time: total,
            ..self.of_full_order()
        }
    }

    /// Of the `wanted` methods of a group, with their numbers in it, and why a march has no end.
    pub fn of_group(
        &self,
        study: &Study,
        group: &Group,
        march: &March<'_>,
        wanted: impl Fn(&Method) -> bool,
        listener: &dyn Listener,
    ) -> Result<Vec<(usize, Errors, Option<String>)>, StudyError> {
        let on_basis = OnBasis::new(self, study.mass(), &group.basis.vectors);
        let mut played: Vec<Option<(Matrix, Errors)>> = vec![];
        let mut found = vec![];
        for (index, method) in group.methods.iter().enumerate() {
            if !wanted(method) {
                played.push(None);
                continue;
            }
            match method.play(march, listener)? {
                Ok(coordinates) => {
                    let base = method.differs.and_then(|(part, index)| Some((part, played[index].as_ref()?)));
                    let errors = on_basis.errors(method, &coordinates, base);
                    found.push((index, errors, None));
                    played.push(Some((coordinates, errors)));
                }
                Err(why) => {
                    found.push((index, on_basis.none(), Some(why)));
                    played.push(None);
                }
            }
        }
        Ok(found)
    }
}

/// The full-order marches seen on a basis.
struct OnBasis<'a> {
    marches: &'a Marches,
    mass: &'a SymmetricMatrix,
    basis: &'a Matrix,
    truth: Projection,
    full: Projection,
}

impl<'a> OnBasis<'a> {
    fn new(marches: &'a Marches, mass: &'a SymmetricMatrix, basis: &'a Matrix) -> Self {
        let [truth, full] = [&marches.truth, &marches.full].map(|march| march.project(mass, basis.as_ref()));
        Self { marches, mass, basis, truth, full }
    }

    /// Of a march on it; `base` is the one it differs from in one part.
    fn errors(
        &self,
        method: &Method,
        coordinates: &Matrix,
        base: Option<(Part, &(Matrix, Errors))>,
    ) -> Errors {
        let Marches { truth, full, time } = self.marches;
        let [trajectory_error, error_total] = match &method.shipped {
            None => [self.full.error(coordinates), self.truth.error(coordinates)],
            Some(Shipped { basis, .. }) => {
                [full, truth].map(|march| march.error(self.mass, basis.as_ref(), coordinates))
            }
        };
        let exact_in_time = matches!(method.way, Way::ExactMotion | Way::Exact);
        // Of the full-order march's norm in that of the exact motion.
        let space = if exact_in_time { error_total } else { full.norm / truth.norm * trajectory_error };
        let own = Errors {
            trajectory_error,
            projection_floor: self.full.floor(),
            error_total,
            error_time: if exact_in_time { 0.0 } else { *time },
            error_space: Some(space),
            error_separation: None,
            error_rounding: None,
        };
        let Some((part, (base, of_base))) = base else { return own };
        let apart = match &method.shipped {
            None => (coordinates - base).norm_l2(),
            Some(shipped) => {
                distance_on_bases(self.mass, [(&shipped.basis, coordinates), (self.basis, base)])
            }
        } / truth.norm;
        let Errors { error_space, error_separation, error_rounding, .. } = *of_base;
        let known = Errors { error_space, error_separation, error_rounding, ..own };
        match part {
            Part::Separation => Errors { error_separation: Some(apart), ..known },
            Part::Rounding => Errors { error_rounding: Some(apart), ..known },
        }
    }

    /// Of a march that came to no end.
    fn none(&self) -> Errors {
        Errors {
            trajectory_error: f64::NAN,
            projection_floor: self.full.floor(),
            error_total: f64::NAN,
            error_time: self.marches.time,
            error_space: None,
            error_separation: None,
            error_rounding: None,
        }
    }
}
