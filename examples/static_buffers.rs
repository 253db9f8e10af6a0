//! The evaluator without heap: fixed arrays, and a file that is part of the program.
//!
//! What you learn: how a program for a microcontroller holds a body. Only `main` uses the standard library,
//! to print; [`Body`] and all it calls would compile for a target that has none (`tests/bare-metal` does
//! that).
//!
//! How do you know the lengths of the arrays? Print `Scene::sizes` of your file once, on your desk, and write
//! the numbers down as constants. At start the program asks the file again, so that a larger file is refused
//! and never cut short.

use vademecum_eval::format::File;
use vademecum_eval::{Contact, Field, Loads, Scene, SceneOptions, State, Surface};

/// The file, in flash beside the code.
static FILE: &[u8] = include_bytes!("../fixtures/golden/fixed-f32.vdm");

/// Room for a scene of three modes and Newmark's scheme, diagonal or block structure.
const SCENE: usize = 512;
/// Room for binding, in double precision; needed while binding only.
const WORK: usize = 512;
/// Room for one state.
const STATE: usize = 64;
/// Room for the loads of one step.
const LOADS: usize = 64;

/// All memory the body ever needs.
struct Memory {
    scene: [f32; SCENE],
    work: [f64; WORK],
    state: [f32; STATE],
    loads: [f32; LOADS],
}

impl Memory {
    const fn new() -> Self {
        Self { scene: [0.0; SCENE], work: [0.0; WORK], state: [0.0; STATE], loads: [0.0; LOADS] }
    }
}

/// Why the body cannot run. A small device has no strings to build; a number and a place are enough.
#[derive(Debug)]
enum Fault {
    File,
    TooSmall { array: &'static str, found: usize, needed: usize },
    Scene,
}

/// A body and what acts on it, over memory that someone else owns.
struct Body<'m> {
    scene: Scene<'m, f32>,
    state: State<'m, f32>,
    loads: Loads<'m, f32>,
    surface: Surface<'m>,
}

impl<'m> Body<'m> {
    fn start(bytes: &'m [u8], memory: &'m mut Memory) -> Result<Self, Fault> {
        let file = File::parse(bytes).map_err(|_| Fault::File)?;
        let options = SceneOptions::default();
        // Ask the file what it needs before anything else.
        let sizes = Scene::<f32>::sizes(&file, &options).map_err(|_| Fault::Scene)?;
        let rooms = [
            ("scene", SCENE, sizes.scene),
            ("work", WORK, sizes.work),
            ("state", STATE, sizes.state),
            ("loads", LOADS, sizes.loads),
        ];
        if let Some(&(array, found, needed)) = rooms.iter().find(|(_, found, needed)| needed > found) {
            return Err(Fault::TooSmall { array, found, needed });
        }
        let Memory { scene, work, state, loads } = memory;
        let scene = Scene::bind(&file, &options, scene, work).map_err(|_| Fault::Scene)?;
        let state = State::new(&scene, state).map_err(|_| Fault::Scene)?;
        let loads = Loads::new(&scene, loads).map_err(|_| Fault::Scene)?;
        let surface = Surface::new(&file).map_err(|_| Fault::File)?;
        Ok(Self { scene, state, loads, surface })
    }

    /// Pushes at the surface point nearest to `finger` for one step; how that point has moved, m.
    fn tick(&mut self, finger: [f64; 3], force: [f64; 3]) -> Result<[f64; 3], Fault> {
        let touched = self.surface.locate(finger).ok_or(Fault::File)?;
        let contact = Contact { nodes: touched.nodes, weights: touched.weights, force };
        self.loads.clear();
        self.loads.add_contact(&self.scene, &contact).map_err(|_| Fault::Scene)?;
        self.scene.step(&mut self.state, &self.loads).map_err(|_| Fault::Scene)?;
        self.scene.point(&self.state, &touched, Field::Displacement).map_err(|_| Fault::Scene)
    }
}

fn main() -> Result<(), Fault> {
    // On a device this is a `static` that is taken once at start; here the stack of `main` will do.
    let mut memory = Memory::new();
    let mut body = Body::start(FILE, &mut memory)?;
    let mut moved = [0.0; 3];
    for _ in 0..10 {
        moved = body.tick([0.1, 0.05, 0.0], [0.0, 0.0, -1.0])?;
    }
    println!("{} bytes of memory, {} bytes of file", size_of::<Memory>(), FILE.len());
    println!("after 10 steps the touched point is at {:+.3e} m", moved[2]);

    // A file that needs more is refused at start, with the number to write down.
    let file = File::parse(FILE).map_err(|_| Fault::File)?;
    let sizes = Scene::<f32>::sizes(&file, &SceneOptions::default()).map_err(|_| Fault::Scene)?;
    println!(
        "this file needs {} + {} + {} floats and {} doubles",
        sizes.scene, sizes.state, sizes.loads, sizes.work
    );
    Ok(())
}
