//! Values of the variables of a body.

use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{Field, OutputError, State, SurfacePoint, Tensor};

use crate::body::Body;
use crate::flight;
use crate::names::line;
use crate::parameters::whole;
use crate::points::Point;
use crate::refusal::Refusal;
use crate::variables::Variable;

/// The motion of the point and the reaction of the support that were looked at last: their other components
/// follow, most of the time.
#[derive(Debug, Default)]
pub struct Seen {
    point: Option<(u32, Field, [f64; 3])>,
    support: Option<(u32, [f64; 6])>,
}

impl Body {
    /// Value of a variable other than the time. `seen` is what the same call has computed before.
    ///
    /// # Errors
    /// [`Refusal::Output`]: a file stripped of what shows it.
    pub fn value(&self, variable: Variable, seen: &mut Seen) -> Result<f64, Refusal> {
        use Variable as V;
        if let Some(value) = self.linear(self.body.state(), variable, seen)? {
            return Ok(value);
        }
        Ok(match variable {
            V::Step => self.internal_step,
            V::Energy => self.body.energy()?,
            V::Force(..) | V::Pattern(_) | V::BodyForce(_) => {
                let place = self.input(variable).and_then(|at| self.inputs.get(at));
                *place.ok_or(Refusal::NoVariable)?
            }
            V::Parameter(index) => self.parameter(index).ok_or(Refusal::NoVariable)?,
            V::Whole(index) => {
                whole(self.body.scene().options(), &self.file, index).ok_or(Refusal::NoVariable)?
            }
            V::VonMises(index) => self.governing_stress(index)?.map_or(0.0, |(_, stress)| stress.von_mises()),
            V::BodyPosition(_) | V::BodyAttitude(_) | V::BodyVelocity(_) | V::BodySpin(_) => self
                .body
                .flight()
                .and_then(|free| flight::value(free, variable))
                .ok_or(Refusal::NoVariable)?,
            V::Position(point, c) => {
                let point = self.points.get(point as usize).ok_or(Refusal::NoVariable)?;
                let position = placed(self.body.file(), &point).position;
                *position.get(c as usize).ok_or(Refusal::NoVariable)?
            }
            V::Total(index) => self.body.total(Variable::total(index).ok_or(Refusal::NoVariable)?)?,
            _ => return Err(Refusal::NoVariable),
        })
    }

    /// Value at a state of an output that is linear in it, unless the body flies; `None` of all others.
    pub(crate) fn linear(
        &self,
        state: &State<'_, f64>,
        variable: Variable,
        seen: &mut Seen,
    ) -> Result<Option<f64>, Refusal> {
        use Variable as V;
        let scene = self.body.scene();
        Ok(Some(match variable {
            V::Displacement(point, c) => self.at_point(state, point, c, Field::Displacement, seen)?,
            V::Velocity(point, c) => self.at_point(state, point, c, Field::Velocity, seen)?,
            V::Probe(probe) => scene.probe(state, probe as usize, Field::Displacement)?,
            V::ProbeVelocity(probe) => scene.probe(state, probe as usize, Field::Velocity)?,
            V::ReactionForce(support, c) => self.reaction(state, support, c, seen)?,
            V::ReactionMoment(support, c) => self.reaction(state, support, c.saturating_add(3), seen)?,
            _ => return Ok(None),
        }))
    }

    /// The point whose stress gives the equivalent stress of a place, and this stress: of a node between
    /// regions the one with the largest; `None` without stress.
    pub(crate) fn governing_stress(&self, index: u32) -> Result<Option<(usize, Tensor)>, Refusal> {
        let place = self.points.stress(index as usize).ok_or(Refusal::NoVariable)?;
        let (mut most, mut governing) = (0.0, None);
        let scene = self.body.scene();
        for point in 0..scene.n_stress_points() {
            if scene.stress_point(point).is_some_and(|point| point.node == place.node) {
                let stress = scene.stress(self.body.state(), point)?;
                let value = stress.von_mises();
                if value > most {
                    (most, governing) = (value, Some((point, stress)));
                }
            }
        }
        Ok(governing)
    }

    /// A component of a reaction: force, then moment.
    fn reaction(
        &self,
        state: &State<'_, f64>,
        support: u32,
        component: u32,
        seen: &mut Seen,
    ) -> Result<f64, Refusal> {
        let exerted = match seen.support {
            Some((known, exerted)) if known == support => exerted,
            _ => self.body.scene().reaction(state, support as usize)?.total(),
        };
        seen.support = Some((support, exerted));
        exerted.get(component as usize).copied().ok_or(Refusal::NoVariable)
    }

    fn at_point(
        &self,
        state: &State<'_, f64>,
        index: u32,
        component: u32,
        field: Field,
        seen: &mut Seen,
    ) -> Result<f64, Refusal> {
        let moved = match seen.point {
            Some((point, of, moved)) if (point, of) == (index, field) => moved,
            _ => {
                let missing = OutputError::OutOfRange { index: index as usize, count: self.points.len() };
                let place = placed(self.body.file(), &self.points.get(index as usize).ok_or(missing)?);
                let scene = self.body.scene();
                match (self.body.flight(), field) {
                    (None, _) => scene.point(state, &place, field)?,
                    // In space, the rigid motion included.
                    (Some(free), Field::Displacement) => {
                        let [x, y, z] = free.point(scene, state, &place)?;
                        let [a, b, c] = place.position;
                        [x - a, y - b, z - c]
                    }
                    (Some(free), Field::Velocity) => free.velocity(scene, state, &place)?,
                }
            }
        };
        seen.point = Some((index, field, moved));
        moved.get(component as usize).copied().ok_or(Refusal::NoVariable)
    }

    /// Name of the thing that a variable belongs to.
    #[must_use]
    pub fn name(&self, variable: Variable) -> &str {
        use Variable as V;
        match variable {
            V::Force(point, _) | V::Displacement(point, _) | V::Velocity(point, _) => {
                self.points.get(point as usize).map_or("", |point| point.name)
            }
            V::Pattern(pattern) => line(self.names.patterns, pattern),
            V::Probe(probe) | V::ProbeVelocity(probe) => line(self.names.probes, probe),
            V::Parameter(index) => {
                self.file.parameters().nth(index as usize).map_or("", |parameter| parameter.name)
            }
            V::VonMises(index) => self.points.stress(index as usize).map_or("", |place| place.name),
            V::ReactionForce(support, _) | V::ReactionMoment(support, _) => {
                line(self.names.supports, support)
            }
            V::Time | V::Step | V::Energy | V::Total(_) | V::Whole(_) | V::Position(..) => "",
            V::SurfaceNodes | V::SurfacePosition | V::SurfaceForce => "",
            V::SurfaceDisplacement | V::SurfaceVelocity => "",
            V::BodyForce(_) | V::BodyPosition(_) | V::BodyAttitude(_) => "",
            V::BodyVelocity(_) | V::BodySpin(_) => "",
        }
    }
}

/// A named point, and where it is at rest in a file that says so.
fn placed(file: &File<'_>, point: &Point<'_>) -> SurfacePoint {
    let place = point.place;
    let mut position = [0.0; 3];
    let section = file.section(SectionKind::NodeCoordinates);
    if let Some(coordinates) = section.and_then(|section| section.numbers().ok()) {
        for (node, weight) in place.entries() {
            for (component, sum) in position.iter_mut().enumerate() {
                *sum += weight * coordinates.get(3 * node as usize + component).unwrap_or(0.0);
            }
        }
    }
    SurfacePoint { place, position, distance: 0.0 }
}
