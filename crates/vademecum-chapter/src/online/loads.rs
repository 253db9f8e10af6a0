//! Loads on the body during a step: forces in the direction, at the nodes and of the size the file was
//! built for.

use super::error::ChapterLoadError;
use super::scene::{ChapterScene, Shape};
use super::terms::{Outside, place};
use vademecum_eval::{Contact, LoadError};
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{Chapter, ChapterAxis, ChapterRole, SectionKind};

/// Loads of a step.
#[derive(Clone, Debug)]
pub struct ChapterLoads {
    pub(super) shape: Shape,
    /// Additions of the loads to each stage where state and load are apart, `(n_stages, r)`.
    pub(super) increment: Vec<f64>,
    /// `BᵀF` at the start of the step, length r.
    pub(super) force: Vec<f64>,
    /// The load that stands in terms over state and load.
    pub(super) held: Held,
    pub(super) active: bool,
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
    pub fn value(&self, role: ChapterRole, stage: usize) -> f64 {
        match role {
            ChapterRole::Magnitude => self.magnitudes[stage],
            ChapterRole::Component { component } => self.components[component],
            _ => self.position as f64,
        }
    }
}

impl ChapterLoads {
    /// No loads.
    #[must_use]
    pub fn new(scene: &ChapterScene<'_>) -> Self {
        let shape = scene.shape;
        let (increment, force) = (vec![0.0; shape.n_stages * shape.r], vec![0.0; shape.r]);
        Self { shape, increment, force, held: Held::default(), active: false }
    }

    /// Takes all loads away.
    pub fn clear(&mut self) {
        self.increment.fill(0.0);
        self.force.fill(0.0);
        self.held = Held::default();
        self.active = false;
    }

    /// `true` if nothing was added since the loads were cleared.
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
        scene: &ChapterScene<'_>,
        contact: &Contact,
    ) -> Result<(), ChapterLoadError> {
        self.add(scene, contact, 1.0, [1.0; MAX_STAGES])
    }

    /// Adds a contact whose force is `contact.force` times an amplitude given at [`ChapterScene::instants`]
    /// of the step.
    ///
    /// # Errors
    /// [`ChapterLoadError`]; the loads are then unchanged.
    pub fn add_contact_staged(
        &mut self,
        scene: &ChapterScene<'_>,
        contact: &Contact,
        amplitudes: &[f64; 1 + MAX_STAGES],
    ) -> Result<(), ChapterLoadError> {
        let mut stages = [0.0; MAX_STAGES];
        for (out, stage) in stages.iter_mut().zip(scene.metadata.scheme.active()) {
            *out = stage.load.iter().zip(amplitudes).map(|(f, a)| f * a).sum();
        }
        self.add(scene, contact, amplitudes[0], stages)
    }

    /// Adds a contact with its amplitude at the start of the step and in each stage.
    fn add(
        &mut self,
        scene: &ChapterScene<'_>,
        contact: &Contact,
        start: f64,
        stages: [f64; MAX_STAGES],
    ) -> Result<(), ChapterLoadError> {
        if self.shape != scene.shape {
            return Err(LoadError::Mismatch.into());
        }
        if !start.is_finite() || stages.iter().any(|amplitude| !amplitude.is_finite()) {
            return Err(LoadError::NotFinite.into());
        }
        contact.check(scene.metadata.n_load_nodes)?;
        let direct = project(scene, contact)?;
        let mut increment = vec![0.0; self.increment.len()];
        self.held = add_to_stages(scene, contact, stages, self.held, &mut increment)?;
        self.increment.iter_mut().zip(increment).for_each(|(sum, x)| *sum += x);
        self.force.iter_mut().zip(direct).for_each(|(force, g)| *force += start * g);
        self.active = true;
        Ok(())
    }
}

/// `BᵀF` of a contact, length `r`.
fn project(scene: &ChapterScene<'_>, contact: &Contact) -> Result<Vec<f64>, LoadError> {
    let missing = LoadError::Missing { kind: SectionKind::SurfaceBasis };
    let (basis, r) = (scene.surface.ok_or(missing)?, scene.shape.r);
    let mut g = vec![0.0; r];
    for (node, weight) in contact.place.entries() {
        for (component, force) in contact.force.iter().enumerate() {
            let row = basis.row((3 * node as usize + component) * r, r).ok_or(missing)?;
            g.iter_mut().zip(row.iter()).for_each(|(g, b)| *g += weight * force * b);
        }
    }
    Ok(g)
}

/// Adds what a contact adds to each stage; gives the load that is then held.
fn add_to_stages(
    scene: &ChapterScene<'_>,
    contact: &Contact,
    amplitudes: [f64; MAX_STAGES],
    mut held: Held,
    increment: &mut [f64],
) -> Result<Held, ChapterLoadError> {
    let (magnitude, components) = along(&scene.chapter, contact.force)?;
    let joint = scene.pieces.iter().any(|piece| piece.part.has_state() && piece.part.has_load());
    for (node, weight) in contact.place.entries().filter(|(_, weight)| *weight != 0.0) {
        let position = scene.chapter.positions().position(|known| known == node);
        let position = position.ok_or(ChapterLoadError::NotAPosition { node })?;
        let magnitudes = amplitudes.map(|s| s * weight * magnitude);
        let own = Held { present: true, position, magnitudes, components };
        if !joint {
            add_apart(scene, &own, increment)?;
            continue;
        }
        if held.present || weight != 1.0 {
            return Err(ChapterLoadError::OneContact);
        }
        check_on_axes(scene, &own)?;
        held = own;
    }
    Ok(held)
}

/// Adds a load at one node to the stages, where state and load are apart.
fn add_apart(scene: &ChapterScene<'_>, own: &Held, increment: &mut [f64]) -> Result<(), ChapterLoadError> {
    let (r, mut weights) = (scene.shape.r, vec![]);
    for piece in scene.pieces.iter().filter(|piece| piece.part.has_load()) {
        let stage = piece.part.stage;
        let out = &mut increment[stage * r..(stage + 1) * r];
        piece.add(|role| own.value(role, stage), &mut weights, out).map_err(refused)?;
    }
    Ok(())
}

/// Refuses a load that is off the axes that all parts have for it.
fn check_on_axes(scene: &ChapterScene<'_>, own: &Held) -> Result<(), ChapterLoadError> {
    for piece in &scene.pieces {
        for axis in piece.axes.iter().filter(|axis| !axis.is_state()) {
            place(axis, own.value(axis.role, piece.part.stage)).map_err(refused)?;
        }
    }
    Ok(())
}

fn refused(outside: Outside) -> ChapterLoadError {
    let Outside { axis: ChapterAxis { role, lower, upper, .. }, value } = outside;
    ChapterLoadError::OutsideAxis { role, value, lower, upper }
}

/// A force as the axes have it: magnitude and direction.
fn along(chapter: &Chapter<'_>, force: [f64; 3]) -> Result<(f64, [f64; 3]), ChapterLoadError> {
    let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
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
