//! A free body in play: its elastic motion as of any body, and its rigid motion beside it.

use vademecum_build::dynamics::INSTANTS;
use vademecum_build::progress::Listener;
use vademecum_eval::{
    Contact, Field, FreeBody, Loads, RigidBody, RigidMotion, Scalar, Scene, State, SurfacePoint, Tensor,
};
use vademecum_format::{File, SectionKind};

use super::body::{Body, Loadable, Playable};
use super::{PlayOptions, Track, march, with_scene};
use crate::contents::numbers;
use crate::error::{FileError, StudyError};
use crate::scenario::FreeEntry;

/// A body with supports, as [`Body`] plays it.
type Elastic<'a, 's, 't, 'l, T> = Body<&'a Scene<'s, T>, &'a mut State<'t, T>, &'a mut Loads<'l, T>>;

/// A free body in a scenario.
struct Flying<'a, 's, 't, 'l, T> {
    elastic: Elastic<'a, 's, 't, 'l, T>,
    free: FreeBody,
    /// Acceleration of gravity in space \[m/s²\].
    gravity: [f64; 3],
    /// Coordinates of the file, three a node.
    coordinates: &'a [f64],
    contacts: Vec<(SurfacePoint, [f64; 3])>,
    patterns: Vec<(usize, f64)>,
}

/// Plays a scenario with a free body that is thrown: forces are those of space, patterns turn with the body.
/// A load acts over each step as it does on the mean of its start and its end.
///
/// # Errors
/// As [`play`](super::play); [`FileError::NotFree`]: a body with supports.
pub(crate) fn play_free(
    file: &File<'_>,
    options: &PlayOptions,
    (track, entry): (&Track, &FreeEntry),
    steps: usize,
    listener: &dyn Listener,
    mut observe: impl FnMut(usize, &dyn Playable<Number = f64>) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    // A file of probes alone has no coordinates, and no contacts.
    let there = file.section(SectionKind::NodeCoordinates).is_some();
    let coordinates = if there { numbers(file, SectionKind::NodeCoordinates)? } else { vec![] };
    with_scene::<f64, _>(file, &options.scene, |scene, state, loads| {
        let thrown = |body: &RigidBody| RigidMotion::thrown(body, entry.velocity, entry.spin);
        let free = FreeBody::new(scene, thrown).ok_or(FileError::NotFree)?;
        let mut body = Flying {
            elastic: Body { scene, state, loads },
            free,
            gravity: entry.gravity,
            coordinates: &coordinates,
            contacts: vec![],
            patterns: vec![],
        };
        march(&mut body, track, steps, listener, Playable::step, |step, body| observe(step, body))
    })
}

/// What acts over a step under a load that is linear in it.
fn mean(amplitudes: &[f64; INSTANTS]) -> f64 {
    0.5 * (amplitudes[0] + amplitudes[1])
}

impl<T: Scalar> Loadable for Flying<'_, '_, '_, '_, T> {
    fn clear_loads(&mut self) {
        self.elastic.clear_loads();
        self.contacts.clear();
        self.patterns.clear();
    }

    fn add_contact(&mut self, contact: &Contact, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError> {
        let at = |node: u32, c: usize| self.coordinates.get(3 * node as usize + c).copied().unwrap_or(0.0);
        let along = |c: usize| contact.place.entries().map(|(n, w)| w * at(n, c)).sum();
        let position = [along(0), along(1), along(2)];
        let Contact { place, force, .. } = *contact;
        let point = SurfacePoint { place, position, distance: 0.0 };
        self.contacts.push((point, force.map(|f| mean(amplitudes) * f)));
        Ok(())
    }

    fn add_pattern(&mut self, index: usize, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError> {
        self.patterns.push((index, mean(amplitudes)));
        Ok(())
    }
}

impl<T: Scalar> Playable for Flying<'_, '_, '_, '_, T> {
    type Number = T;

    fn structure(&self) -> &'static str {
        self.elastic.structure()
    }

    fn time_step(&self) -> f64 {
        self.elastic.time_step()
    }

    fn instants(&self) -> [f64; INSTANTS] {
        self.elastic.instants()
    }

    fn start(&mut self) -> Result<(), FileError> {
        self.elastic.start()
    }

    fn is_exact(&self) -> bool {
        // A step is not cut where a load jumps: the rigid motion takes it whole.
        false
    }

    fn step_parts(
        &mut self,
        _: f64,
        _: usize,
        _: &dyn Fn(usize, &mut dyn Loadable) -> Result<(), FileError>,
    ) -> Result<(), FileError> {
        self.step()
    }

    fn step(&mut self) -> Result<(), FileError> {
        let Self { elastic: Body { scene, state, loads }, free, gravity, contacts, patterns, .. } = self;
        let mass = free.body().mass;
        free.pull(gravity.map(|g| mass * g));
        for (point, force) in contacts.iter() {
            free.push(scene, loads, point, *force)?;
        }
        for &(index, amplitude) in patterns.iter() {
            free.push_pattern(scene, loads, index, amplitude)?;
        }
        free.step(scene, state, loads)?;
        Ok(())
    }

    fn zeta(&self) -> &[T] {
        self.elastic.zeta()
    }

    fn energy(&self) -> Result<f64, FileError> {
        self.elastic.energy()
    }

    fn probe(&self, index: usize) -> Result<f64, FileError> {
        self.elastic.probe(index)
    }

    fn node(&self, node: usize) -> Result<[f64; 3], FileError> {
        self.elastic.node(node)
    }

    fn point(&self, point: &SurfacePoint) -> Result<[f64; 3], FileError> {
        self.elastic.point(point)
    }

    fn surface_into(&self, field: Field, out: &mut [T]) -> Result<(), FileError> {
        self.elastic.surface_into(field, out)
    }

    fn body_into(&self, field: Field, out: &mut [T]) -> Result<(), FileError> {
        self.elastic.body_into(field, out)
    }

    fn stress(&self, point: usize) -> Result<Tensor, FileError> {
        self.elastic.stress(point)
    }

    fn reaction(&self, support: usize) -> Result<[f64; 6], FileError> {
        self.elastic.reaction(support)
    }

    fn flight(&self) -> Option<(&RigidBody, &RigidMotion)> {
        Some((self.free.body(), self.free.motion()))
    }
}
