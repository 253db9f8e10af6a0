//! A rigid sphere is pressed on a beam, dragged over it with friction, and lifted off, at 1 kHz.
//!
//! What you learn: how a tool that is much stiffer than the body stays stable. A spring between tool and body
//! has to be softer than the body is within one step. This loop has no spring: it asks how the body yields at
//! the contacts (`compliance`) and where they go without force (`free_motion`), and solves for the forces
//! with which the sphere and the body just touch when the step ends.

use std::error::Error;
use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{Contact, Field, Loads, Place, Scene, SceneOptions, State, Surface, SurfacePoint};

/// A rigid sphere at the end of a step.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Radius \[m\].
    pub radius: f64,
    /// Coulomb's μ.
    pub friction: f64,
    /// Where its centre is at the end of the step \[m\].
    pub centre: [f64; 3],
    /// How far it moves in the step, without turning \[m\].
    pub moves: [f64; 3],
}

/// A place of the body that the sphere may touch, and what a step has found there.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// The place on the body at rest.
    pub point: SurfacePoint,
    /// From the sphere into the body.
    pub normal: [f64; 3],
    /// Its displacement at the start of the step \[m\].
    pub start: [f64; 3],
    /// Force of the sphere on the body, held over the step \[N\].
    pub force: [f64; 3],
}

/// What the loop has to know of the body's surface.
#[derive(Debug)]
pub struct Body<'m> {
    surface: Surface<'m>,
    /// The loadable nodes at rest.
    nodes: Vec<[f64; 3]>,
    /// Contacts this far apart \[m\] share no triangle.
    apart: f64,
}

impl<'m> Body<'m> {
    /// Reads the surface of a file.
    ///
    /// # Errors
    /// If it has none.
    pub fn new(file: &File<'m>) -> Result<Self, Box<dyn Error>> {
        let section = |kind| file.section(kind).ok_or("no surface");
        let numbers: Vec<f64> = section(SectionKind::NodeCoordinates)?.numbers()?.iter().collect();
        let count = file.metadata().n_load_nodes as usize;
        let nodes: Vec<[f64; 3]> = numbers.as_chunks().0.iter().copied().take(count).collect();
        let triangles = section(SectionKind::Triangles)?.u32s()?.as_chunks::<3>().0;
        let triangles = triangles.iter().take(file.metadata().n_load_triangles as usize);
        let edges = triangles.flat_map(|t| {
            let [a, b, c] = t.map(|node| nodes[u32::from_le_bytes(node) as usize]);
            [minus(a, b), minus(b, c), minus(c, a)]
        });
        let longest = edges.map(length).fold(0.0, f64::max);
        Ok(Self { surface: Surface::new(file)?, nodes, apart: 2.0 * longest })
    }

    /// The place nearest to the sphere, and nodes that the sphere may reach in the step. No two of them share
    /// a triangle, because `compliance` leaves out what the modes leave out between two contacts.
    fn candidates(
        &self,
        sphere: &Sphere,
        scene: &Scene<'_, f64>,
        state: &State<'_, f64>,
    ) -> Vec<SurfacePoint> {
        let mut taken: Vec<SurfacePoint> = self.surface.locate(sphere.centre).into_iter().collect();
        let reach = sphere.radius + self.apart;
        let mut near: Vec<(f64, usize)> = (0..self.nodes.len())
            .filter(|&node| length(minus(self.nodes[node], sphere.centre)) < 2.0 * reach)
            .filter_map(|node| {
                let moved = scene.node(state, node, Field::Displacement).ok()?;
                Some((length(minus(plus(self.nodes[node], moved), sphere.centre)), node))
            })
            .filter(|&(distance, _)| distance < reach)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (distance, node) in near {
            let position = self.nodes[node];
            let apart = taken.iter().all(|other| length(minus(position, other.position)) > self.apart);
            if apart && taken.len() < 16 {
                let weights = [1.0, 0.0, 0.0];
                taken.push(SurfacePoint {
                    place: Place::triangle([node as u32; 3], weights),
                    position,
                    distance,
                });
            }
        }
        taken
    }
}

/// One step of the body under the sphere.
///
/// # Errors
/// If the step is refused, or if the forces cannot be found.
pub fn press(
    body: &Body<'_>,
    sphere: &Sphere,
    scene: &Scene<'_, f64>,
    state: &mut State<'_, f64>,
    loads: &mut Loads<'_, f64>,
) -> Result<Vec<Touch>, Box<dyn Error>> {
    let points = body.candidates(sphere, scene, state);
    let contact = |point: &SurfacePoint, force| Contact::new(point.place, force);
    let contacts: Vec<Contact> = points.iter().map(|point| contact(point, [0.0; 3])).collect();

    // How the contacts yield in the coming step, and where they go without forces.
    let n = contacts.len();
    let (mut w, mut free) = (vec![0.0; 9 * n * n], vec![[0.0; 3]; n]);
    let mut work = vec![0.0; scene.compliance_work(n)];
    loads.clear();
    scene.compliance(&contacts, &mut w, &mut work)?;
    scene.free_motion(state, loads, &contacts, &mut free, &mut work)?;

    // Gap and slide at the end of the step, if no force acts. The gap is taken along the normal there, which
    // makes it a little smaller than it will be: a sphere curves away from its tangent plane.
    let mut touches = vec![];
    let (mut gaps, mut slides) = (vec![], vec![]);
    for (point, free) in points.into_iter().zip(&free) {
        let start = scene.point(state, &point, Field::Displacement)?;
        let away = minus(plus(point.position, *free), sphere.centre);
        let normal = times(1.0 / length(away), away);
        gaps.push(length(away) - sphere.radius);
        slides.push(minus(minus(*free, start), sphere.moves));
        touches.push(Touch { point, normal, start, force: [0.0; 3] });
    }
    solve(&w, &gaps, &slides, sphere, &mut touches)?;

    for touch in touches.iter().filter(|touch| touch.force != [0.0; 3]) {
        loads.add_contact(scene, &contact(&touch.point, touch.force))?;
    }
    scene.step(state, loads)?;
    Ok(touches)
}

/// Forces with `gap ≥ 0`, `f_n ≥ 0`, one of them zero, and `|f_t| ≤ μ f_n` against the slide: projected
/// Gauss-Seidel, contact by contact.
fn solve(
    w: &[f64],
    gaps: &[f64],
    slides: &[[f64; 3]],
    sphere: &Sphere,
    touches: &mut [Touch],
) -> Result<(), &'static str> {
    let width = 3 * touches.len();
    let row = |c: usize, i: usize| &w[(3 * c + i) * width..][..width];
    for _ in 0..10_000 {
        let mut changed = 0.0_f64;
        for c in 0..touches.len() {
            let normal = touches[c].normal;
            let own = [0, 1, 2].map(|i| [0, 1, 2].map(|j| row(c, i)[3 * c + j]));
            let yields = dot(normal, own.map(|row| dot(row, normal)));
            let yields_along = (own[0][0] + own[1][1] + own[2][2] - yields).max(f64::MIN_POSITIVE);

            // The force along the normal that closes the gap, if it pushes.
            let before = touches[c].force;
            let push = dot(before, normal);
            let gap = gaps[c] + dot(normal, moved(row, c, touches));
            let pushed = (push - gap / yields.max(f64::MIN_POSITIVE)).max(0.0);
            let force = plus(before, times(pushed - push, normal));
            touches[c].force = force;

            // Friction that stops the slide, or as much of it as the cone allows.
            let slide = plus(slides[c], moved(row, c, touches));
            let wanted = along(minus(force, times(1.0 / yields_along, along(slide, normal))), normal);
            let most = sphere.friction * pushed;
            let share = if length(wanted) > most { most / length(wanted) } else { 1.0 };
            touches[c].force = plus(times(pushed, normal), times(share, wanted));
            changed = changed.max(length(minus(touches[c].force, before)) * yields.max(yields_along));
        }
        if changed <= 1e-12 * sphere.radius {
            return Ok(());
        }
    }
    Err("the forces of the contacts were not found in 10 000 sweeps")
}

/// `Σ_d W_cd f_d`: how far all forces together move contact `c`.
fn moved<'w>(row: impl Fn(usize, usize) -> &'w [f64], c: usize, touches: &[Touch]) -> [f64; 3] {
    [0, 1, 2].map(|i| {
        let blocks = row(c, i).as_chunks::<3>().0;
        blocks.iter().zip(touches).map(|(&block, touch)| dot(block, touch.force)).sum()
    })
}

impl Touch {
    /// Force along the normal \[N\].
    #[must_use]
    pub fn push(&self) -> f64 {
        dot(self.force, self.normal)
    }

    /// Friction \[N\].
    #[must_use]
    pub fn friction(&self) -> f64 {
        length(along(self.force, self.normal))
    }

    /// `open`, `sticks` or `slips`.
    #[must_use]
    pub fn word(&self, sphere: &Sphere) -> &'static str {
        match self.push() {
            0.0 => "open",
            push if self.friction() < (1.0 - 1e-9) * sphere.friction * push => "sticks",
            _ => "slips",
        }
    }

    /// How deep the place is inside of the sphere after the step \[m\]; below zero for a gap.
    ///
    /// # Errors
    /// If the state is of another scene.
    pub fn depth(
        &self,
        sphere: &Sphere,
        scene: &Scene<'_, f64>,
        state: &State<'_, f64>,
    ) -> Result<f64, Box<dyn Error>> {
        let moved = scene.point(state, &self.point, Field::Displacement)?;
        Ok(sphere.radius - length(minus(plus(self.point.position, moved), sphere.centre)))
    }
}

/// The demo's beam on a coarser mesh, and without damping, so that the energy tells what the contacts do.
///
/// # Errors
/// If it cannot be built.
pub fn beam() -> Result<Vec<u8>, Box<dyn Error>> {
    let text = include_str!("../fixtures/problems/cantilever.toml").replace("[32, 3, 4]", "[16, 2, 2]");
    let problem = Problem::parse(&text, "cantilever.toml", PathBuf::new())?;
    Ok(build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes)
}

/// The sphere after so many steps of a millisecond: it comes down on the beam, is dragged to its tip side,
/// and is lifted.
#[must_use]
pub fn path(step: usize) -> Sphere {
    let at = |step: usize| {
        let share = |from: usize, steps: f64| ((step.saturating_sub(from)) as f64 / steps).min(1.0);
        let height = 1e-3 - 3e-3 * share(0, 100.0) + 12e-3 * share(400, 100.0);
        [0.5 + 0.2 * share(100, 300.0), 0.04, 0.1 + 0.05 + height]
    };
    let centre = at(step);
    Sphere { radius: 0.05, friction: 0.3, centre, moves: minus(centre, at(step.saturating_sub(1))) }
}

/// Presses, drags, lifts, and prints every fiftieth step.
///
/// # Errors
/// If the beam cannot be built or stepped.
pub fn main() -> Result<(), Box<dyn Error>> {
    let bytes = beam()?;
    let file = File::parse(&bytes)?;
    let options = SceneOptions { alpha: Some(0.0), beta: Some(0.0), ..SceneOptions::default() };
    let sizes = Scene::<f64>::sizes(&file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;
    let body = Body::new(&file)?;

    println!("   ms  depth/mm   push/N  contact  penetration/radius  energy/J");
    let (mut worst, mut hardest) = (f64::NEG_INFINITY, 0.0_f64);
    for step in 1..=600 {
        let sphere = path(step);
        let touches = press(&body, &sphere, &scene, &mut state, &mut loads)?;
        let mut inside = f64::NEG_INFINITY;
        for touch in &touches {
            inside = inside.max(touch.depth(&sphere, &scene, &state)? / sphere.radius);
        }
        let push: f64 = touches.iter().map(Touch::push).sum();
        (worst, hardest) = (worst.max(inside), hardest.max(push));
        if step % 50 == 0 {
            let word = touches.first().map_or("open", |touch| touch.word(&sphere));
            let (depth, energy) = (1e3 * (0.15 - sphere.centre[2]), scene.energy(&state)?);
            println!("{step:5}  {depth:8.3}  {push:7.1}  {word:7}  {inside:18.1e}  {energy:8.2e}");
        }
    }
    println!("600 steps: hardest push {hardest:.1} N, deepest penetration {worst:.1e} of the radius");
    Ok(())
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn times(factor: f64, a: [f64; 3]) -> [f64; 3] {
    a.map(|x| factor * x)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// What is left of `a` without its part along `normal`.
fn along(a: [f64; 3], normal: [f64; 3]) -> [f64; 3] {
    minus(a, times(dot(a, normal), normal))
}
