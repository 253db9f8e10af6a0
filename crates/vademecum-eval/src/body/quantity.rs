//! The outputs of a body, as one table: name, number, count, length and unit.
//!
//! A program that offers everything to its user goes through [`Quantity::ALL`] and asks [`Body::count`],
//! [`Body::length`] and [`Body::read`]; a row more here is then a quantity more there.

use crate::base::error::OutputError;
use crate::base::scalar::Scalar;
use crate::body::body::Body;
use crate::sections::place::Place;
use crate::sections::rows::Field;
use vademecum_format::SectionKind;

/// An output of a body. The number of a quantity stays; new ones come last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// A probe of the file.
    Probe = 0,
    /// A node, in file order.
    Node = 1,
    /// A place, [`At::Place`].
    Point = 2,
    /// The whole surface, node by node.
    Surface = 3,
    /// The whole body, node by node.
    Whole = 4,
    /// Stress at a point of the file: xx, yy, zz, xy, yz, zx.
    Stress = 5,
    /// Strain there, in the same order; shear strains are those of the tensor.
    Strain = 6,
    /// Von Mises' equivalent stress there.
    VonMises = 7,
    /// Force that a support exerts on the body.
    ReactionForce = 8,
    /// Moment that it exerts, about the point of the support.
    ReactionMoment = 9,
    /// Kinetic and strain energy together.
    Energy = 10,
    /// Kinetic energy of the elastic motion.
    KineticEnergy = 11,
    /// Strain energy, with that of the residual flexibility.
    StrainEnergy = 12,
    /// Position of the centre of a body that flies.
    FramePosition = 13,
    /// Its attitude: a quaternion, the real part first.
    FrameAttitude = 14,
    /// Velocity of its centre.
    FrameVelocity = 15,
    /// Its angular velocity in space.
    FrameSpin = 16,
}

/// A row of the table.
struct Row {
    quantity: Quantity,
    name: &'static str,
    text: &'static str,
    /// Unit, and that of its velocity where it has one.
    units: (&'static str, Option<&'static str>),
}

const fn row(
    quantity: Quantity,
    name: &'static str,
    unit: &'static str,
    rate: Option<&'static str>,
    text: &'static str,
) -> Row {
    Row { quantity, name, text, units: (unit, rate) }
}

/// In the order of their numbers.
const TABLE: [Row; 17] = [
    row(
        Quantity::Probe,
        "probe",
        "m",
        Some("m/s"),
        "Displacement along the direction of a probe, or the strain of a gauge",
    ),
    row(Quantity::Node, "node", "m", Some("m/s"), "Displacement of a node"),
    row(Quantity::Point, "point", "m", Some("m/s"), "Displacement of a place of the surface"),
    row(Quantity::Surface, "surface", "m", Some("m/s"), "Displacement of the surface"),
    row(Quantity::Whole, "whole", "m", Some("m/s"), "Displacement of the whole body"),
    row(Quantity::Stress, "stress", "Pa", None, "Stress at a point: xx, yy, zz, xy, yz, zx"),
    row(Quantity::Strain, "strain", "1", None, "Strain at a point: xx, yy, zz, xy, yz, zx"),
    row(Quantity::VonMises, "von_mises", "Pa", None, "Von Mises equivalent stress at a point"),
    row(Quantity::ReactionForce, "reaction_force", "N", None, "Force that a support exerts on the body"),
    row(
        Quantity::ReactionMoment,
        "reaction_moment",
        "N m",
        None,
        "Moment that a support exerts on the body, about the point of the support",
    ),
    row(Quantity::Energy, "energy", "J", None, "Kinetic plus elastic energy"),
    row(Quantity::KineticEnergy, "kinetic_energy", "J", None, "Kinetic energy of the elastic motion"),
    row(
        Quantity::StrainEnergy,
        "strain_energy",
        "J",
        None,
        "Strain energy, that of the residual flexibility included",
    ),
    row(Quantity::FramePosition, "frame_position", "m", None, "Centre of a body that flies"),
    row(
        Quantity::FrameAttitude,
        "frame_attitude",
        "1",
        None,
        "Attitude of a body that flies: a quaternion, real part first",
    ),
    row(
        Quantity::FrameVelocity,
        "frame_velocity",
        "m/s",
        None,
        "Velocity of the centre of a body that flies",
    ),
    row(Quantity::FrameSpin, "frame_spin", "rad/s", None, "Angular velocity in space of a body that flies"),
];

impl Quantity {
    /// All quantities, in the order of their numbers.
    pub const ALL: [Self; TABLE.len()] = {
        let mut all = [Self::Probe; TABLE.len()];
        let mut k = 0;
        while k < TABLE.len() {
            all[k] = TABLE[k].quantity;
            k += 1;
        }
        all
    };

    fn row(self) -> Option<&'static Row> {
        TABLE.get(self as usize)
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().map_or("", |row| row.name)
    }

    /// A line about it, for people.
    #[must_use]
    pub fn text(self) -> &'static str {
        self.row().map_or("", |row| row.text)
    }

    /// The quantity of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        TABLE.iter().find(|row| row.name == name).map(|row| row.quantity)
    }

    /// Its number, which stays from version to version.
    #[must_use]
    pub const fn number(self) -> u32 {
        self as u32
    }

    /// The quantity of this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        TABLE.get(number as usize).map(|row| row.quantity)
    }

    /// Its unit; `None` for the velocity of what has none.
    #[must_use]
    pub fn unit(self, field: Field) -> Option<&'static str> {
        let (unit, rate) = self.row()?.units;
        match field {
            Field::Displacement => Some(unit),
            Field::Velocity => rate,
        }
    }

    /// `true` if it has a velocity beside its value.
    #[must_use]
    pub fn has_velocity(self) -> bool {
        self.unit(Field::Velocity).is_some()
    }

    /// Scalars of the body as a whole, which are read without an index: energies. A front end that lists them
    /// offers a new one without a change of its own.
    pub fn totals() -> impl Iterator<Item = Self> {
        use Quantity as Q;
        Self::ALL
            .into_iter()
            .filter(|quantity| matches!(quantity, Q::Energy | Q::KineticEnergy | Q::StrainEnergy))
    }

    /// `true` if it is one number.
    #[must_use]
    pub const fn is_scalar(self) -> bool {
        use Quantity as Q;
        matches!(self, Q::Probe | Q::VonMises | Q::Energy | Q::KineticEnergy | Q::StrainEnergy)
    }
}

/// Of what a quantity is read: by its number, counted from 0, or at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum At<'p> {
    /// The probe, node, support or point of stress of this number; 0 of what there is one of.
    Index(usize),
    /// A place, of [`Quantity::Point`].
    Place(&'p Place),
}

impl From<usize> for At<'_> {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

impl<'p, P: AsRef<Place>> From<&'p P> for At<'p> {
    fn from(place: &'p P) -> Self {
        Self::Place(place.as_ref())
    }
}

impl<T: Scalar> Body<'_, T> {
    /// Number of outputs of a quantity; 0 where the file does not have it. Places have no numbers:
    /// [`Quantity::Point`] counts one.
    #[must_use]
    pub fn count(&self, quantity: Quantity) -> usize {
        use Quantity as Q;
        let metadata = &self.scene.metadata;
        let one_if = usize::from;
        let has = |kind| self.file.section(kind).is_some();
        match quantity {
            Q::Probe => metadata.n_probes as usize,
            Q::Node => metadata.n_nodes as usize,
            Q::Point | Q::Surface => one_if(has(SectionKind::SurfaceBasis)),
            Q::Whole => {
                let inside = metadata.n_nodes > metadata.n_surface_nodes;
                one_if(has(SectionKind::SurfaceBasis) && (!inside || has(SectionKind::InteriorBasis)))
            }
            Q::Stress | Q::VonMises => self.scene.n_stress_points(),
            Q::Strain if has(SectionKind::ElasticConstants) || has(SectionKind::Compliance) => {
                self.scene.n_stress_points()
            }
            Q::Strain => 0,
            Q::ReactionForce | Q::ReactionMoment => self.scene.n_supports(),
            Q::Energy | Q::KineticEnergy | Q::StrainEnergy => 1,
            Q::FramePosition | Q::FrameAttitude | Q::FrameVelocity | Q::FrameSpin => {
                one_if(self.flight.is_some())
            }
        }
    }

    /// Numbers of each.
    #[must_use]
    pub fn length(&self, quantity: Quantity) -> usize {
        use Quantity as Q;
        let metadata = &self.scene.metadata;
        match quantity {
            Q::Surface => 3 * metadata.n_surface_nodes as usize,
            Q::Whole => 3 * metadata.n_nodes as usize,
            Q::Stress | Q::Strain => 6,
            Q::FrameAttitude => 4,
            Q::Node | Q::Point | Q::ReactionForce | Q::ReactionMoment => 3,
            Q::FramePosition | Q::FrameVelocity | Q::FrameSpin => 3,
            Q::Probe | Q::VonMises | Q::Energy | Q::KineticEnergy | Q::StrainEnergy => 1,
        }
    }

    /// A scalar of the whole body, one of [`Quantity::totals`].
    ///
    /// # Errors
    /// [`OutputError`]; [`OutputError::OutOfRange`] for any other quantity.
    pub fn total(&self, quantity: Quantity) -> Result<f64, OutputError> {
        let (scene, state) = (&self.scene, &self.state);
        match quantity {
            Quantity::Energy => scene.energy(state),
            Quantity::KineticEnergy => scene.kinetic_energy(state),
            Quantity::StrainEnergy => scene.strain_energy(state),
            _ => Err(OutputError::OutOfRange { index: quantity.number() as usize, count: 0 }),
        }
    }

    /// Reads a quantity; `out` has its [`Body::length`].
    ///
    /// ```
    /// # use vademecum_eval::format::File;
    /// # use vademecum_eval::{Body, BodyOptions, Field, Quantity};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let bytes = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/fixed-f64.vdm"));
    /// # let (file, options) = (File::parse(bytes)?, BodyOptions::default());
    /// # let mut memory = vec![0.0; Body::<f32>::len_for(&file, &options)?];
    /// # let mut body = Body::<f32>::bind(&file, &options, &mut memory)?;
    /// body.push_pattern(0, 1.0)?;
    /// body.step()?;
    /// let mut all = [0.0];
    /// for quantity in Quantity::ALL.into_iter().filter(|quantity| quantity.is_scalar()) {
    ///     for index in 0..body.count(quantity) {
    ///         body.read(quantity, index, Field::Displacement, &mut all)?;
    ///         println!("{} {index}: {} {:?}", quantity.name(), all[0], quantity.unit(Field::Displacement));
    ///     }
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`]; [`OutputError::NoVelocity`] for the velocity of what has none,
    /// [`OutputError::NotAPlace`] where a number was given for a place or a place for a number.
    pub fn read<'p>(
        &self,
        quantity: Quantity,
        at: impl Into<At<'p>>,
        field: Field,
        out: &mut [f64],
    ) -> Result<(), OutputError> {
        use Quantity as Q;
        if field == Field::Velocity && !quantity.has_velocity() {
            return Err(OutputError::NoVelocity);
        }
        let (found, needed) = (out.len(), self.length(quantity));
        if found != needed {
            return Err(OutputError::Length { found, needed });
        }
        let index = match (at.into(), quantity) {
            (At::Place(place), Q::Point) => return fill(out, self.scene.point(&self.state, place, field)?),
            (At::Index(index), quantity) if quantity != Q::Point => index,
            _ => return Err(OutputError::NotAPlace),
        };
        let (scene, state) = (&self.scene, &self.state);
        let alone = |value: f64| if index == 0 { Ok([value]) } else { Err(beyond(index)) };
        match quantity {
            Q::Probe => fill(out, [scene.probe(state, index, field)?]),
            Q::Node => fill(out, scene.node(state, index, field)?),
            Q::Surface | Q::Whole if index > 0 => Err(beyond(index)),
            Q::Surface => widen(out, |numbers: &mut [T]| scene.surface_into(state, field, numbers)),
            Q::Whole => widen(out, |numbers: &mut [T]| scene.body_into(state, field, numbers)),
            Q::Stress => fill(out, scene.stress(state, index)?.0),
            Q::Strain => fill(out, scene.strain(state, index)?.0),
            Q::VonMises => fill(out, [scene.stress(state, index)?.von_mises()]),
            Q::ReactionForce => fill(out, scene.reaction(state, index)?.total()),
            Q::ReactionMoment => fill(out, scene.reaction(state, index)?.total().into_iter().skip(3)),
            Q::Energy | Q::KineticEnergy | Q::StrainEnergy => fill(out, alone(self.total(quantity)?)?),
            Q::FramePosition | Q::FrameAttitude | Q::FrameVelocity | Q::FrameSpin if index > 0 => {
                Err(beyond(index))
            }
            Q::FramePosition | Q::FrameAttitude | Q::FrameVelocity | Q::FrameSpin => {
                let kind = SectionKind::RigidBody;
                let free = self.flight.as_ref().ok_or(OutputError::Missing { kind })?;
                let (body, motion) = (free.body(), free.motion());
                match quantity {
                    Q::FramePosition => fill(out, motion.position),
                    Q::FrameAttitude => fill(out, motion.attitude),
                    Q::FrameVelocity => fill(out, motion.momentum.map(|share| share / body.mass)),
                    _ => fill(out, motion.to_space(motion.spin(body))),
                }
            }
            Q::Point => Err(OutputError::NotAPlace),
        }
    }
}

const fn beyond(index: usize) -> OutputError {
    OutputError::OutOfRange { index, count: 1 }
}

/// Writes as many numbers as there is room for.
fn fill(out: &mut [f64], numbers: impl IntoIterator<Item = f64>) -> Result<(), OutputError> {
    out.iter_mut().zip(numbers).for_each(|(out, number)| *out = number);
    Ok(())
}

/// Has numbers of the body's precision written at the start of `out` and makes each of them one of `f64`.
fn widen<T: Scalar>(
    out: &mut [f64],
    write: impl FnOnce(&mut [T]) -> Result<(), OutputError>,
) -> Result<(), OutputError> {
    let count = out.len();
    let numbers = T::of_words(out).get_mut(..count);
    write(numbers.ok_or(OutputError::Length { found: count, needed: count })?)?;
    // From the back: a number is never behind the place where it goes.
    for k in (0..count).rev() {
        let number = T::of_words(out).get(k).map_or(0.0, |number| number.to_f64());
        out.get_mut(k).into_iter().for_each(|out| *out = number);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_and_a_name_are_those_of_one_quantity() {
        for (k, quantity) in Quantity::ALL.into_iter().enumerate() {
            assert_eq!(quantity.number() as usize, k);
            assert_eq!(Quantity::from_number(quantity.number()), Some(quantity));
            assert_eq!(Quantity::find(quantity.name()), Some(quantity));
        }
        assert_eq!(Quantity::from_number(17), None);
        assert_eq!(Quantity::find("heat"), None);
    }
}
