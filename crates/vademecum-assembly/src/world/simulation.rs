//! A world that owns its parts: their files, their memory, and the world over them.

use self_cell::{MutBorrow, self_cell};
use vademecum_eval::{
    Body, Field, Member, Pose, RigidMotion, RigidShape, Touch, Touching, World, WorldBuffers, WorldError,
    WorldJoint, WorldOptions, WorldReport,
};
use vademecum_format::File;

use crate::entries::WorldEntry;
use crate::error::AssemblyError;
use crate::file::{AssemblyFile, GROUND};
use crate::world::bonds::{Bonds, bonds};
use crate::world::error::{WorldRunError, subject};
use crate::world::parts::{Bound, GivenPart, PartSurface, Source, read};
use crate::world::rows::{Shown, nodes_of, outputs, position, potential};

/// Files and rigid bodies, and memory of the bodies of the files.
struct Parts {
    sources: Vec<Source>,
    memory: MutBorrow<Vec<Vec<f64>>>,
}

type BoundParts<'m> = Vec<Bound<'m>>;

self_cell!(
    /// Parts that are bound, the ground behind them.
    struct PartsCell {
        owner: Parts,
        #[not_covariant]
        dependent: BoundParts,
    }
);

/// Pairs, joints, and memory of a world.
struct Lent {
    bonds: Bonds,
    buffers: MutBorrow<WorldBuffers>,
}

type Touched<'m> = World<'m, f64>;

self_cell!(
    /// A world in memory of its own.
    struct WorldCell {
        owner: Lent,
        #[not_covariant]
        dependent: Touched,
    }
);

/// A world of an assembly file with all that it borrows: parts, memory, pairs and joints.
///
/// Parts go by their numbers, in the order of the file; behind them is the ground, where a joint has one.
pub struct WorldSimulation {
    file: AssemblyFile,
    parts: PartsCell,
    world: WorldCell,
    shapes: Vec<PartSurface>,
    shown: Vec<(usize, Shown)>,
    time_step: f64,
    steps: u64,
}

impl WorldSimulation {
    /// Reads the parts of an assembly file with `[world]`, and binds them.
    ///
    /// # Errors
    /// [`WorldRunError`].
    pub fn open(file: AssemblyFile) -> Result<Self, WorldRunError> {
        let given = file.parts.iter().map(|_| GivenPart::Named).collect();
        Self::new(file, given)
    }

    /// Binds parts that are at hand, one for each entry of the file.
    ///
    /// # Errors
    /// [`WorldRunError`].
    pub fn new(file: AssemblyFile, given: Vec<GivenPart>) -> Result<Self, WorldRunError> {
        let expected = "`[world]`: bodies that move in a world";
        let entry = file.world.ok_or_else(|| file.refuse("world", "absent", expected))?;
        let each = given.into_iter().enumerate();
        let sources = each.map(|(i, given)| read(&file, i, given)).collect::<Result<Vec<_>, _>>()?;
        let opened = sources.iter().map(Source::open).collect::<Result<Vec<_>, _>>()?;
        let time_step = time_step(&file, &entry, &opened)?;
        let mut memory = vec![];
        for ((part, source), opened) in file.parts.iter().zip(&sources).zip(&opened) {
            let options = source.options(time_step, entry.contacts);
            let length = opened.as_ref().map_or(Ok(0), |opened| Body::<f64>::len_for(opened, &options));
            let bind = |source| WorldRunError::Bind { part: part.name.clone(), source };
            memory.push(vec![0.0; length.map_err(bind)?]);
        }
        let shapes =
            sources.iter().zip(&opened).map(|(source, opened)| PartSurface::of(source, opened.as_ref()));
        let shapes: Vec<PartSurface> = shapes.collect::<Result<_, _>>()?;
        let bonds = bonds(&file, &opened, &shapes)?;
        drop(opened);
        let parts = Parts { sources, memory: MutBorrow::new(memory) };
        let mut parts = PartsCell::try_new(parts, |parts| bind(&file, parts, time_step, entry.contacts))?;
        let shown = parts.with_dependent(|_, bound| outputs(&file, bound, &shapes))?;
        let options = options(&entry);
        let world = parts.with_dependent_mut(|_, bound| {
            let members: Vec<_> = bound.iter_mut().map(Bound::member).collect();
            let refused = |source| WorldRunError::World { subject: subject(&file, &source), source };
            let sizes = World::sizes(&members, &bonds.joints, &options).map_err(refused)?;
            let lent = Lent { bonds, buffers: MutBorrow::new(WorldBuffers::new(&sizes)) };
            WorldCell::try_new(lent, |lent| {
                let memory = lent.buffers.borrow_mut().lend();
                World::new(&members, &lent.bonds.pairs, &lent.bonds.joints, &options, memory).map_err(refused)
            })
        })?;
        let mut own = Self { file, parts, world, shapes, shown, time_step, steps: 0 };
        own.lead_ways(0.0);
        Ok(own)
    }

    /// Leads the parts with a way to where they are at an instant.
    fn lead_ways(&mut self, time: f64) {
        let parts = &self.file.parts;
        self.parts.with_dependent_mut(|_, bound| {
            for (part, bound) in parts.iter().zip(bound) {
                if let Some(way) = part.way() {
                    let by = way.at(time);
                    let position = std::array::from_fn(|k| part.position[k] + by[k]);
                    bound.lead(Pose::new(position, part.rotation)).expect("a part that is led");
                }
            }
        });
    }

    /// Runs a function on the world and its members.
    pub fn with<R>(
        &mut self,
        run: impl for<'a, 'w, 'm> FnOnce(&mut World<'a, f64>, &mut [Member<'w, 'm, f64>]) -> R,
    ) -> R {
        let world = &mut self.world;
        self.parts.with_dependent_mut(|_, bound| {
            let mut members: Vec<_> = bound.iter_mut().map(Bound::member).collect();
            world.with_dependent_mut(|_, world| run(world, &mut members))
        })
    }

    /// Runs a function on a member; `None` if there is no such part.
    pub fn with_member<R>(
        &mut self,
        part: usize,
        run: impl for<'w, 'm> FnOnce(&mut Member<'w, 'm, f64>) -> R,
    ) -> Option<R> {
        self.parts.with_dependent_mut(|_, bound| bound.get_mut(part).map(|bound| run(&mut bound.member())))
    }

    /// One step ([`World::step`]).
    ///
    /// # Errors
    /// [`WorldRunError::Step`].
    pub fn step(&mut self) -> Result<WorldReport, WorldRunError> {
        self.lead_ways((self.steps + 1) as f64 * self.time_step);
        let report = self.with(|world, members| world.step(members)).map_err(|source| {
            WorldRunError::Step { time: self.time(), subject: subject(&self.file, &source), source }
        })?;
        self.steps += 1;
        Ok(report)
    }

    /// The assembly file.
    #[must_use]
    pub const fn file(&self) -> &AssemblyFile {
        &self.file
    }

    /// Length of a step \[s\].
    #[must_use]
    pub const fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Time of the steps that were made \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.time_step
    }

    /// The surface of a part at rest; `None` if there is no such part.
    #[must_use]
    pub fn surface(&self, part: usize) -> Option<&PartSurface> {
        self.shapes.get(part)
    }

    /// Pairs that may touch, and joints, in the order of the file.
    pub fn with_bonds<R>(&self, run: impl FnOnce(&[Touching], &[WorldJoint]) -> R) -> R {
        self.world.with_dependent(|lent, _| run(&lent.bonds.pairs, &lent.bonds.joints))
    }

    /// Files and rigid bodies of the parts.
    pub(crate) fn sources(&self) -> &[Source] {
        &self.parts.borrow_owner().sources
    }

    /// Contacts of the last step.
    pub fn with_touches<R>(&self, run: impl FnOnce(&[Touch]) -> R) -> R {
        self.world.with_dependent(|_, world| run(world.touches()))
    }

    /// Kinetic and elastic energy of the parts and of their contacts \[J\], and the potential of gravity of
    /// the parts that move freely.
    ///
    /// # Errors
    /// [`WorldRunError::World`].
    pub fn energy(&mut self) -> Result<[f64; 2], WorldRunError> {
        let gravity = self.gravity();
        let found = self.with(|world, members| Ok([world.energy(members)?, potential(members, gravity)]));
        found.map_err(|source: WorldError| WorldRunError::World { subject: "the world".into(), source })
    }

    fn gravity(&self) -> [f64; 3] {
        self.file.world.map_or([0.0; 3], |entry| entry.gravity)
    }

    /// Positions in space \[m\] of the outputs of the file, in their order.
    ///
    /// # Errors
    /// [`WorldRunError::Output`].
    pub fn outputs(&mut self) -> Result<Vec<[f64; 3]>, WorldRunError> {
        let (file, shown) = (&self.file, &self.shown);
        self.parts.with_dependent_mut(|_, bound| {
            let each = shown.iter().map(|(part, shown)| {
                let failed = |source| WorldRunError::Output { part: file.parts[*part].name.clone(), source };
                position(&bound[*part].member(), shown).map_err(failed)
            });
            each.collect()
        })
    }

    /// Positions in space \[m\] of the nodes of the surface of a part.
    ///
    /// # Errors
    /// [`WorldRunError::Output`].
    ///
    /// # Panics
    /// If there is no such part, or `out` is not as long as its surface.
    pub fn nodes_into(&mut self, part: usize, out: &mut [[f64; 3]]) -> Result<(), WorldRunError> {
        let (shape, name) = (&self.shapes[part], &self.file.parts[part].name);
        assert_eq!(out.len(), shape.nodes.len(), "nodes of the surface");
        let read = self.parts.with_dependent_mut(|_, bound| nodes_of(&bound[part].member(), shape, out));
        read.map_err(|source| WorldRunError::Output { part: name.clone(), source })
    }

    /// Placement of a part: of the origin of its coordinates, and its rotation.
    pub fn pose(&mut self, part: usize) -> Option<Pose> {
        self.with_member(part, |member| pose_of(member))
    }

    /// Velocity in space \[m/s\] of a place of a free part or of a point of a rigid body that moves; of a
    /// held part that of its deformation alone.
    ///
    /// # Errors
    /// [`WorldRunError::Output`].
    pub fn velocity(&mut self, part: usize, at: &PartPoint) -> Result<[f64; 3], WorldRunError> {
        self.read_point(part, at, Field::Velocity)
    }

    /// Position in space \[m\] of a place of a part, deformed as it is.
    ///
    /// # Errors
    /// [`WorldRunError::Output`].
    pub fn position(&mut self, part: usize, at: &PartPoint) -> Result<[f64; 3], WorldRunError> {
        self.read_point(part, at, Field::Displacement)
    }

    fn read_point(&mut self, part: usize, at: &PartPoint, field: Field) -> Result<[f64; 3], WorldRunError> {
        let name = self.file.parts.get(part).map_or(String::new(), |part| part.name.clone());
        let read = self.with_member(part, |member| in_space(member, at, field)).unwrap_or(Ok([f64::NAN; 3]));
        read.map_err(|source| WorldRunError::Output { part: name, source })
    }

    /// Puts a held part elsewhere, or leads a rigid body that stands there to the end of the coming step.
    /// `None`, and nothing changes, of any other part, and if a number is not finite.
    pub fn lead(&mut self, part: usize, pose: Pose) -> Option<()> {
        self.parts.with_dependent_mut(|_, bound| bound.get_mut(part)?.lead(pose))
    }

    /// Rigid motion of a part that moves freely; `None` of any other.
    pub fn motion(&mut self, part: usize) -> Option<RigidMotion> {
        self.with_member(part, |member| match member {
            Member::Free(body) => body.motion().copied(),
            Member::Rigid(shape) => shape.body().map(|_| *shape.motion()),
            Member::Held(..) => None,
        })?
    }

    /// Puts a part that moves freely elsewhere, or lets it move otherwise. The contacts of the last step are
    /// forgotten. `None`, and nothing changes, of any other part, and if a number is not finite.
    pub fn set_motion(&mut self, part: usize, motion: RigidMotion) -> Option<()> {
        let set = self.with_member(part, |member| match member {
            Member::Free(body) => body.set_motion(motion),
            Member::Rigid(shape) => {
                shape.body().is_some().then_some(()).and_then(|()| shape.set_motion(motion))
            }
            Member::Held(..) => None,
        })?;
        set?;
        self.with(|world, _| world.forget());
        Some(())
    }

    /// The poses of the held parts, and the number of steps, beside what a step changes.
    pub(crate) fn kept(&self) -> (u64, Vec<Option<Pose>>) {
        (self.steps, self.parts.with_dependent(|_, bound| bound.iter().map(Bound::stand).collect()))
    }

    /// Takes them back.
    pub(crate) fn keep(&mut self, steps: u64, stands: &[Option<Pose>]) {
        self.steps = steps;
        self.parts.with_dependent_mut(|_, bound| {
            for (bound, stand) in bound.iter_mut().zip(stands) {
                if let Some(stand) = stand {
                    bound.set_stand(*stand);
                }
            }
        });
    }
}

/// A point of a part whose motion is read.
#[derive(Clone, Copy, Debug)]
pub enum PartPoint {
    /// A place of a body of a file.
    Place(vademecum_eval::Place),
    /// A point of a rigid body, in its own coordinates \[m\].
    Point([f64; 3]),
}

fn in_space(
    member: &Member<'_, '_, f64>,
    at: &PartPoint,
    field: Field,
) -> Result<[f64; 3], vademecum_eval::OutputError> {
    match (member, at, field) {
        (Member::Free(body), PartPoint::Place(place), _) => body.in_space(place, field),
        (Member::Held(body, stand), PartPoint::Place(place), Field::Velocity) => {
            Ok(stand.turn(body.point(place, field)?))
        }
        (Member::Held(body, _), PartPoint::Place(place), _) => {
            position(member, &Shown::Place(*place, body.position(place)?))
        }
        (Member::Rigid(shape), PartPoint::Point(point), Field::Velocity) => Ok(shape
            .body()
            .map_or([0.0; 3], |body| shape.motion().velocity(body, *point, [0.0; 3], [0.0; 3]))),
        (Member::Rigid(_), PartPoint::Point(point), _) => position(member, &Shown::Point(*point)),
        _ => Ok([f64::NAN; 3]),
    }
}

/// Placement of the origin of the coordinates of a member.
fn pose_of(member: &Member<'_, '_, f64>) -> Pose {
    let of = |motion: &RigidMotion, centre: [f64; 3]| {
        let arm = motion.to_space(centre);
        Pose::new(std::array::from_fn(|k| motion.position[k] - arm[k]), motion.attitude)
    };
    match member {
        Member::Held(_, stand) => *stand,
        Member::Free(body) => body
            .motion()
            .zip(body.rigid_body())
            .map_or(Pose::IDENTITY, |(motion, rigid)| of(motion, rigid.centre)),
        Member::Rigid(shape) => of(shape.motion(), shape.body().map_or([0.0; 3], |body| body.centre)),
    }
}

/// Options of the world of an entry.
fn options(entry: &WorldEntry) -> WorldOptions {
    WorldOptions {
        gravity: entry.gravity,
        reach: entry.reach,
        tolerance: entry.tolerance,
        sweeps: entry.sweeps,
        contacts: entry.contacts,
        ..WorldOptions::default()
    }
}

/// Binds the parts to their memory; the ground is behind them.
fn bind<'m>(
    file: &AssemblyFile,
    parts: &'m Parts,
    time_step: f64,
    contacts: usize,
) -> Result<BoundParts<'m>, WorldRunError> {
    let mut bound = vec![];
    for (i, (source, memory)) in parts.sources.iter().zip(parts.memory.borrow_mut()).enumerate() {
        let options = source.options(time_step, contacts);
        bound.push(Bound::new(file, i, source, &options, memory)?);
    }
    if file.joints.iter().any(|joint| joint.between[1] == GROUND) {
        let ground = RigidShape::led(&[], &[], Pose::IDENTITY);
        bound.extend(ground.map(|shape| Bound::Rigid(Box::new(shape))));
    }
    Ok(bound)
}

/// Step \[s\] of the world of a file.
fn time_step(
    file: &AssemblyFile,
    entry: &WorldEntry,
    opened: &[Option<File<'_>>],
) -> Result<f64, AssemblyError> {
    let own = opened.iter().flatten().map(|opened| opened.metadata().time_step);
    let smallest = own.fold(f64::INFINITY, f64::min);
    if smallest == f64::INFINITY {
        let expected = "at least one part with a `file`";
        return Err(file.refuse("part", "rigid bodies alone", expected).into());
    }
    Ok(entry.step.or(file.step).unwrap_or(smallest))
}
