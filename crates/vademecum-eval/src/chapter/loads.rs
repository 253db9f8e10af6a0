//! Loads on the body during a step: forces in the direction, at the nodes and of the size the file was
//! built for.

use super::error::{ChapterBindError, ChapterLoadError};
use super::scene::{ChapterScene, Shape};
use super::terms::{Unknown, pieces, place};
use crate::base::error::{BindError, LoadError};
use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::scene::loads::Amplitudes;
use crate::sections::contact::Contact;
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{Chapter, ChapterAxis, ChapterRole};

/// Loads of a step, in lent memory.
#[derive(Debug)]
pub struct ChapterLoads<'m, T> {
    pub(super) shape: Shape,
    /// Additions of the loads to each stage where state and load are apart, `(n_stages, r)`.
    pub(super) increment: &'m mut [T],
    /// `BᵀF` at the start of the step, length r.
    pub(super) force: &'m mut [T],
    /// The load that stands in terms over state and load.
    pub(super) held: Held,
    pub(super) active: bool,
    /// Row of `B` of the contact that is being added, length r.
    direct: &'m mut [T],
    /// Additions of that contact to each stage, `(n_stages, r)`.
    stages: &'m mut [T],
    /// Weights of the terms of a part.
    weights: &'m mut [T],
}

/// The one load that terms over state *and* load can stand under.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    /// `true` if there is one.
    present: bool,
    position: usize,
    magnitudes: [f64; MAX_STAGES],
    components: [f64; 3],
}

impl Held {
    /// The coordinate of an axis of the load in this stage.
    pub fn value(&self, role: ChapterRole, stage: usize) -> Result<f64, Short> {
        let number = |numbers: &[f64], at: usize| {
            numbers.get(at).copied().ok_or(Short { found: numbers.len(), needed: at.saturating_add(1) })
        };
        match role {
            ChapterRole::Magnitude => number(&self.magnitudes, stage),
            ChapterRole::Component { component } => number(&self.components, component),
            _ => Ok(self.position as f64),
        }
    }
}

impl<'m, T: Scalar> ChapterLoads<'m, T> {
    /// No loads. `memory` holds at least [`Sizes::loads`](crate::Sizes::loads) numbers; what is in it does
    /// not matter.
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &ChapterScene<'_, T>, memory: &'m mut [T]) -> Result<Self, ChapterBindError> {
        let shape = scene.shape;
        let (found, needed) = (memory.len(), shape.loads_len());
        let memory = memory.get_mut(..needed).ok_or(BindError::LentMemory { found, needed })?;
        let mut memory = Lender::new(memory);
        let mut loads = Self {
            shape,
            increment: memory.take(shape.n_stages * shape.r)?,
            force: memory.take(shape.r)?,
            held: Held::default(),
            active: false,
            direct: memory.take(shape.r)?,
            stages: memory.take(shape.n_stages * shape.r)?,
            weights: memory.take(shape.n_terms)?,
        };
        loads.clear();
        Ok(loads)
    }

    /// Takes all loads away.
    pub fn clear(&mut self) {
        self.increment.fill(T::ZERO);
        self.force.fill(T::ZERO);
        self.held = Held::default();
        self.active = false;
    }

    /// `true` if anything was added since the loads were cleared.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        !self.active
    }

    /// Adds a contact held over the step.
    ///
    /// # Errors
    /// [`ChapterLoadError`]; the loads are then unchanged.
    pub fn add_contact(
        &mut self,
        scene: &ChapterScene<'_, T>,
        contact: &Contact,
    ) -> Result<(), ChapterLoadError> {
        self.contact(scene, contact, Amplitudes::held(1.0))
    }

    /// Adds a contact whose force is `contact.force` times an amplitude given at [`ChapterScene::instants`]
    /// of the step.
    ///
    /// # Errors
    /// [`ChapterLoadError`]; the loads are then unchanged.
    pub fn add_contact_staged(
        &mut self,
        scene: &ChapterScene<'_, T>,
        contact: &Contact,
        amplitudes: &[f64; 1 + MAX_STAGES],
    ) -> Result<(), ChapterLoadError> {
        self.contact(scene, contact, Amplitudes::staged(&scene.metadata.scheme, amplitudes))
    }

    fn contact(
        &mut self,
        scene: &ChapterScene<'_, T>,
        contact: &Contact,
        p: Amplitudes,
    ) -> Result<(), ChapterLoadError> {
        if self.shape != scene.shape {
            return Err(LoadError::Mismatch.into());
        }
        p.check()?;
        contact.check(scene.metadata.n_load_nodes)?;
        contact.project(&scene.rows, self.direct)?;
        self.held = self.add_to_stages(scene, contact, p)?;
        self.increment.iter_mut().zip(&*self.stages).for_each(|(sum, &x)| *sum += x);
        let start = T::from_f64(p.start);
        self.force.iter_mut().zip(&*self.direct).for_each(|(force, &g)| *force += start * g);
        self.active = true;
        Ok(())
    }

    /// Sums what a contact adds to each stage into `stages`; gives the load that is then held.
    fn add_to_stages(
        &mut self,
        scene: &ChapterScene<'_, T>,
        contact: &Contact,
        p: Amplitudes,
    ) -> Result<Held, ChapterLoadError> {
        let (magnitude, components) = along(&scene.chapter, contact.force)?;
        self.stages.fill(T::ZERO);
        let joint = scene.chapter.parts().any(|part| part.has_state() && part.has_load());
        let mut held = self.held;
        for (node, weight) in contact.place.entries().filter(|(_, weight)| *weight != 0.0) {
            let position = scene.chapter.positions().position(|known| known == node);
            let position = position.ok_or(ChapterLoadError::NotAPosition { node })?;
            let magnitudes = p.stages.map(|s| s * weight * magnitude);
            let own = Held { present: true, position, magnitudes, components };
            if !joint {
                self.add_apart(scene, &own)?;
                continue;
            }
            if held.present || weight != 1.0 {
                return Err(ChapterLoadError::OneContact);
            }
            check_on_axes(&scene.chapter, &own)?;
            held = own;
        }
        Ok(held)
    }

    /// Adds a load at one node to the stages, where state and load are apart.
    fn add_apart(&mut self, scene: &ChapterScene<'_, T>, own: &Held) -> Result<(), ChapterLoadError> {
        for piece in pieces(&scene.chapter, scene.factors, scene.terms) {
            let piece = piece?;
            if !piece.part.has_load() {
                continue;
            }
            let stage = piece.part.stage;
            let mut stages = Lender::new(&mut *self.stages);
            stages.take(stage.saturating_mul(self.shape.r))?;
            let out = stages.take(self.shape.r)?;
            piece.add(|role| own.value(role, stage), self.weights, out).map_err(refused)?;
        }
        Ok(())
    }
}

/// `true` if a load is on the axes that all parts have for it.
fn check_on_axes(chapter: &Chapter<'_>, own: &Held) -> Result<(), ChapterLoadError> {
    for part in chapter.parts().filter(|part| part.has_load()) {
        for axis in part.axes().filter(|axis| !axis.is_state()) {
            place(&axis, own.value(axis.role, part.stage)?).map_err(refused)?;
        }
    }
    Ok(())
}

fn refused(unknown: Unknown) -> ChapterLoadError {
    match unknown {
        Unknown::Outside(ChapterAxis { role, lower, upper, .. }, value) => {
            ChapterLoadError::OutsideAxis { role, value, lower, upper }
        }
        Unknown::Short(short) => short.into(),
    }
}

/// A force as the axes have it: magnitude and direction.
fn along(chapter: &Chapter<'_>, force: [f64; 3]) -> Result<(f64, [f64; 3]), ChapterLoadError> {
    let size = libm::sqrt(force.iter().map(|f| f * f).sum());
    let Some(direction) = chapter.direction() else {
        let unit = if size > 0.0 { force.map(|f| f / size) } else { [0.0; 3] };
        return Ok((size, unit));
    };
    let magnitude: f64 = force.iter().zip(direction).map(|(f, d)| f * d).sum();
    let mut across = force.iter().zip(direction).map(|(f, d)| f - magnitude * d);
    // A direction given in decimals is off by its last digits.
    if across.any(|x| x.abs() > 1e-9 * size) {
        return Err(ChapterLoadError::OtherDirection);
    }
    Ok((magnitude, direction))
}
