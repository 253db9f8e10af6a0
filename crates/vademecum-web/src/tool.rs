//! A tool to press with: a rigid sphere that cannot enter the body.
//!
//! A sphere that a spring held to the body would have to be soft, or the march would not be stable. This one
//! has no spring: before each step it asks where the body goes without it
//! ([`AnyBody::free_motion`]) and how it yields ([`AnyBody::compliance`]), and
//! finds the forces with which sphere and body just touch when the step ends, with Coulomb's friction. Every
//! step of the sphere is a step of the body; a hand gives the sphere a target, which it follows no faster
//! and no harder than its limits allow. It never goes into a place that the supports hold.
//!
//! Note: the gap is taken along the normal at the start of the step. A sphere curves away from every
//! tangent plane, so a body in front of the plane is outside of the sphere whichever normal was taken.

use vademecum_eval::format::{File, Numbers, SectionKind};
use vademecum_eval::{
    AnyBody, BodyOptions, Field, OutputError, Place, SceneOptions, Status, Structure, Surface, SurfacePoint,
};

use crate::friction::{ContactPoint, MOST, Operator, room, solve};
use crate::refusal::Refusal;
use crate::vectors::{Vector, dot, length, minus, plus, times};

/// Places of the body that are looked at in a step, and most that may be pushed.
pub const MAX_PLACES: usize = MOST;

/// Options of a body that a tool can press: room for the places it touches, and for the loads beside its own.
#[must_use]
pub fn body_options(scene: SceneOptions) -> BodyOptions {
    BodyOptions { scene, places: MAX_PLACES, keep_loads: true, flight: false, ..BodyOptions::default() }
}

/// Gaps are closed up to this part of the radius.
const TOLERANCE: f64 = 1e-10;

/// The tool in a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Radius \[m\].
    pub radius: f64,
    /// Coulomb's μ.
    pub friction: f64,
    /// Position of its centre \[m\].
    pub centre: Vector,
    /// Target position \[m\].
    pub target: Vector,
    /// Speed at which it follows \[m/s\].
    pub speed: f64,
    /// With how much force it follows at most \[N\]: where more would be needed it stays where it is.
    pub most: f64,
}

impl Sphere {
    /// Moves towards the target for one step; by how much.
    fn follow(&mut self, time_step: f64) -> Vector {
        let (way, most) = (minus(self.target, self.centre), self.speed * time_step);
        let far = length(way);
        let moves = if far > most { times(most / far, way) } else { way };
        self.centre = plus(self.centre, moves);
        moves
    }

    /// Places without forces, from where the touches are now (which `look` has left there) and where they go
    /// without the sphere.
    #[inline(never)]
    fn face(&self, places: &mut [ContactPoint], touches: &[Touch], free: &[Vector], moves: Vector) {
        for ((place, touch), free) in places.iter_mut().zip(touches).zip(free) {
            let away = minus(touch.place, self.centre);
            let normal = times(1.0 / length(away), away);
            let end = plus(touch.point.position, *free);
            let gap = dot(normal, minus(end, self.centre)) - self.radius;
            let slide = minus(minus(end, touch.place), moves);
            *place = ContactPoint { normal, gap, slide, force: [0.0; 3] };
        }
    }
}

/// A place of the body that the last step looked at.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// The place on the body at rest.
    pub point: SurfacePoint,
    /// Position after the step \[m\].
    pub place: Vector,
    /// Force of the sphere on the body over the step \[N\].
    pub force: Vector,
    /// Penetration into the sphere after the step \[m\]; below zero for a gap.
    pub depth: f64,
}

impl AsRef<Place> for Touch {
    fn as_ref(&self) -> &Place {
        &self.point.place
    }
}

const NOWHERE: Touch = Touch {
    point: SurfacePoint { place: Place::triangle([0; 3], [0.0; 3]), position: [0.0; 3], distance: 0.0 },
    place: [0.0; 3],
    force: [0.0; 3],
    depth: f64::NEG_INFINITY,
};

/// The loadable surface a sphere may touch.
#[derive(Clone, Copy, Debug)]
struct Ground<'m> {
    surface: Surface<'m>,
    coordinates: Numbers<'m>,
    n_nodes: usize,
    /// Places this far apart \[m\] share no facet: the operator leaves out what the modes leave out
    /// between two places.
    apart: f64,
}

impl<'m> Ground<'m> {
    /// Of a file; refused if it has no surface.
    #[inline(never)]
    fn new(file: &File<'m>) -> Result<Self, OutputError> {
        let missing = |kind| OutputError::Missing { kind };
        let kind = SectionKind::NodeCoordinates;
        let coordinates = file.section(kind).and_then(|section| section.numbers().ok());
        let coordinates = coordinates.ok_or(missing(kind))?;
        let kind = SectionKind::Triangles;
        let triangles = file.indices(kind).ok().flatten().ok_or(missing(kind))?;
        let n_nodes = file.metadata().n_load_nodes as usize;
        let mut ground = Self { surface: Surface::new(file)?, coordinates, n_nodes, apart: 0.0 };
        let loadable = file.metadata().n_load_triangles as usize;
        for triangle in triangles.as_chunks::<3>().0.iter().take(loadable) {
            ground.part(&triangle.map(u32::from_le_bytes));
        }
        let kind = SectionKind::Quadrangles;
        for facet in file.quadrangles().map_err(|_| missing(kind))?.iter() {
            ground.part(facet.nodes());
        }
        Ok(ground)
    }

    /// Keeps places apart that share a facet of these nodes.
    fn part(&mut self, nodes: &[u32]) {
        for (place, &a) in nodes.iter().enumerate() {
            for &b in nodes.iter().take(place) {
                let between = minus(self.node(a as usize), self.node(b as usize));
                self.apart = self.apart.max(2.0 * length(between));
            }
        }
    }

    /// A node at rest.
    fn node(&self, node: usize) -> Vector {
        [0, 1, 2].map(|i| self.coordinates.get(3 * node + i).unwrap_or(f64::NAN))
    }

    /// The node nearest to `centre` within `reach` that lies apart from all places taken.
    #[inline(never)]
    fn nearest(&self, centre: Vector, reach: f64, taken: &[Touch]) -> Option<SurfacePoint> {
        let mut best: Option<(f64, usize, Vector)> = None;
        for node in 0..self.n_nodes {
            let position = self.node(node);
            let distance = length(minus(position, centre));
            let nearer = distance < reach && best.is_none_or(|(known, ..)| distance < known);
            let is_apart =
                || taken.iter().all(|other| length(minus(position, other.point.position)) > self.apart);
            if nearer && is_apart() {
                best = Some((distance, node, position));
            }
        }
        best.map(|(distance, node, position)| SurfacePoint {
            place: Place::triangle([node as u32; 3], [1.0, 0.0, 0.0]),
            position,
            distance,
        })
    }
}

/// A sphere on a body.
#[derive(Clone, Copy, Debug)]
pub struct Tool<'m> {
    /// Position and target.
    pub sphere: Sphere,
    ground: Ground<'m>,
    touches: [Touch; MOST],
    count: usize,
    /// Displacement of the place that was nearest in the step before \[m\]; none before the first.
    shift: Option<Vector>,
    solved: bool,
}

impl<'m> Tool<'m> {
    /// A sphere before its first step, on a body bound with [`body_options`].
    ///
    /// # Errors
    /// [`Refusal::NoTool`], [`Refusal::BadTool`].
    pub fn new(sphere: Sphere, body: &AnyBody<'m>) -> Result<Self, Refusal> {
        let Sphere { radius, friction, speed, most, .. } = sphere;
        let ground = Ground::new(body.file()).map_err(|_| Refusal::NoTool)?;
        if body.structure() != Structure::Exact {
            return Err(Refusal::NoTool);
        }
        let places = sphere.centre.iter().chain(&sphere.target);
        let sound = radius > 0.0 && friction >= 0.0 && speed >= 0.0 && most > 0.0;
        if !sound || ![radius, friction, speed].iter().chain(places).all(|x| x.is_finite()) {
            return Err(Refusal::BadTool);
        }
        Ok(Self { sphere, ground, touches: [NOWHERE; MOST], count: 0, shift: None, solved: true })
    }

    /// The places that the last step looked at; those that are pushed have a force.
    #[must_use]
    pub fn touches(&self) -> &[Touch] {
        self.touches.get(..self.count).unwrap_or_default()
    }

    /// True if the forces of the last step close every gap.
    #[must_use]
    pub const fn is_solved(&self) -> bool {
        self.solved
    }

    /// Largest penetration of the body into the sphere after the last step \[m\]; below zero
    /// for a gap.
    #[must_use]
    pub fn deepest(&self) -> f64 {
        self.touches().iter().map(|touch| touch.depth).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Takes one step of sphere and body, the one it was made for.
    ///
    /// # Errors
    /// [`Refusal`]; the body is then where it was.
    pub fn step(&mut self, body: &mut AnyBody<'m>) -> Result<Status, Refusal> {
        let before = self.sphere.centre;
        let moves = self.sphere.follow(body.time_step());
        self.look(body, before)?;
        let touches = self.touches.get_mut(..self.count).unwrap_or_default();
        let n = touches.len();

        // How the places yield in the coming step, and where they go without the sphere.
        let (mut w, mut free) = (room(), [[0.0; 3]; MOST]);
        let w = w.get_mut(..9 * n * n).unwrap_or_default();
        let free = free.get_mut(..n).unwrap_or_default();
        body.compliance(touches, w)?;
        body.free_motion(touches, free)?;

        let mut places = [ContactPoint::default(); MOST];
        let places = places.get_mut(..n).unwrap_or_default();
        let (operator, tolerance) = (Operator::new(w, n), TOLERANCE * self.sphere.radius);
        // Moves a share of its way; how hard it pushes then, beyond all bounds where the supports hold a
        // place.
        let most = self.sphere.most;
        let mut attempt = |share: f64| {
            let way = times(share, moves);
            self.sphere.centre = plus(before, way);
            self.sphere.face(places, touches, free, way);
            self.solved = solve(&operator, self.sphere.friction, tolerance, places);
            let force: f64 = places.iter().map(|place| length(place.force)).sum();
            if operator.is_stuck(places, tolerance) { f64::INFINITY } else { force }
        };
        let all = attempt(1.0);
        if all >= most && moves != [0.0; 3] {
            let still = attempt(0.0);
            // The force grows at least in proportion, since more places touch the farther it goes.
            let share = (most - still) / (all - still);
            if share > 0.0 && share < 1.0 && attempt(share) > most * (1.0 + 1e-6) {
                attempt(0.0);
            }
        }

        for (place, touch) in places.iter().zip(&mut *touches) {
            touch.force = place.force;
        }
        // The forces act for this step alone.
        body.keep_loads()?;
        let status = pushed_step(body, touches);
        body.recall_loads()?;
        let status = status?;
        for touch in touches {
            let moved = body.point(&touch.point, Field::Displacement)?;
            touch.place = plus(touch.point.position, moved);
            touch.depth = self.sphere.radius - length(minus(touch.place, self.sphere.centre));
        }
        Ok(status)
    }

    /// Finds the places of the coming step: the one nearest to the sphere, and nodes that it may reach. The
    /// body is taken to be moved near the sphere as it is at the nearest place. A place that coincides with
    /// the centre has no normal and is left out.
    #[inline(never)]
    fn look(&mut self, body: &AnyBody<'_>, before: Vector) -> Result<(), Refusal> {
        let (Sphere { centre, radius, .. }, ground) = (self.sphere, self.ground);
        self.count = 0;
        // A sphere that was just laid down looks a few times, since it does not know how far the body moved.
        let looks = if self.shift.is_none() { 4 } else { 1 };
        let mut shift = self.shift.unwrap_or_default();
        let mut nearest = None;
        for _ in 0..looks {
            nearest = ground.surface.locate(minus(centre, shift));
            if let Some(point) = &nearest {
                shift = body.point(point, Field::Displacement)?;
            }
        }
        self.shift = Some(shift);
        // As far as the sphere and the body may come together in a step, and as far as places are apart.
        let reach = radius + ground.apart + length(minus(centre, before));
        let mut next = nearest.filter(|point| point.distance < reach);
        while let Some(point) = next {
            let moved = body.point(&point, Field::Displacement)?;
            let place = plus(point.position, moved);
            let Some(free) = self.touches.get_mut(self.count) else { break };
            if place == centre {
                break;
            }
            *free = Touch { point, place, ..NOWHERE };
            self.count += 1;
            next = ground.nearest(minus(centre, shift), reach, self.touches());
        }
        Ok(())
    }
}

/// A step under the forces of the sphere besides.
fn pushed_step(body: &mut AnyBody<'_>, touches: &[Touch]) -> Result<Status, Refusal> {
    for touch in touches.iter().filter(|touch| touch.force != [0.0; 3]) {
        body.push(touch, touch.force)?;
    }
    Ok(body.step()?)
}
