//! The evaluator without heap: fixed arrays, and a file that is part of the program.
//!
//! What you learn: how a program for a microcontroller holds a body. Only `main` uses the standard library,
//! to print; [`Body`] and all it calls would compile for a target that has none (`tests/bare-metal` does
//! that).
//!
//! How do you know the lengths of the arrays? Print `Scene::sizes` of your file once, on your desk, and write
//! the numbers down as constants. At start the program asks the file again, so that a larger file is refused
//! and never cut short.

use core::fmt;

use vademecum_eval::format::{File, FormatError};
use vademecum_eval::{
    BindError, Contact, Field, LoadError, Loads, OutputError, Scene, SceneOptions, State, StepError, Surface,
};

/// The file, in flash beside the code.
static FILE: &[u8] = include_bytes!("../fixtures/golden/fixed-f32.vdm");

/// Floats for a bound scene. All four are a little more than this file needs; the last line of the output
/// tells the needs.
const SCENE: usize = 256;
/// Doubles for binding; not needed after it.
const WORK: usize = 1024;
/// Floats for one state.
const STATE: usize = 128;
/// Floats for the loads of one step.
const LOADS: usize = 128;

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

/// Why the body cannot run. The errors of the library are small and `Copy`; one with numbers of its own is as
/// well.
#[derive(Clone, Copy, Debug)]
enum Fault {
    File(FormatError),
    TooSmall { array: &'static str, found: usize, needed: usize },
    Bind(BindError),
    NoSurface,
    Load(LoadError),
    Step(StepError),
    Output(OutputError),
}

impl fmt::Display for Fault {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(error) => error.fmt(out),
            Self::TooSmall { array, found, needed } => {
                write!(out, "the array `{array}` has room for {found} numbers, and the file needs {needed}")
            }
            Self::Bind(error) => error.fmt(out),
            Self::NoSurface => write!(out, "the file has no surface to touch"),
            Self::Load(error) => error.fmt(out),
            Self::Step(error) => error.fmt(out),
            Self::Output(error) => error.fmt(out),
        }
    }
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
        let file = File::parse(bytes).map_err(Fault::File)?;
        let options = SceneOptions::default();
        // Ask the file what it needs before anything else.
        let sizes = Scene::<f32>::sizes(&file, &options).map_err(Fault::Bind)?;
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
        let scene = Scene::bind(&file, &options, scene, work).map_err(Fault::Bind)?;
        let state = State::new(&scene, state).map_err(Fault::Bind)?;
        let loads = Loads::new(&scene, loads).map_err(Fault::Bind)?;
        let surface = Surface::new(&file).map_err(Fault::Output)?;
        Ok(Self { scene, state, loads, surface })
    }

    /// Pushes at the surface point nearest to `finger` for one step; how that point has moved, m.
    fn tick(&mut self, finger: [f64; 3], force: [f64; 3]) -> Result<[f64; 3], Fault> {
        let touched = self.surface.locate(finger).ok_or(Fault::NoSurface)?;
        let contact = Contact::new(touched.place, force);
        self.loads.clear();
        self.loads.add_contact(&self.scene, &contact).map_err(Fault::Load)?;
        self.scene.step(&mut self.state, &self.loads).map_err(Fault::Step)?;
        self.scene.point(&self.state, &touched, Field::Displacement).map_err(Fault::Output)
    }
}

fn main() {
    if let Err(fault) = run() {
        eprintln!("{fault}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), Fault> {
    // On a device this is a `static` that is taken once at start; here the stack of `main` will do.
    let mut memory = Memory::new();
    let mut body = Body::start(FILE, &mut memory)?;
    let mut moved = [0.0; 3];
    for _ in 0..10 {
        moved = body.tick([0.1, 0.05, 0.0], [0.0, 0.0, -1.0])?;
    }
    println!("{} bytes of memory, {} bytes of file", size_of::<Memory>(), FILE.len());
    println!("after 10 steps the touched point is at {:+.3e} m", moved[2]);

    // Write these numbers down as the constants above.
    let file = File::parse(FILE).map_err(Fault::File)?;
    let sizes = Scene::<f32>::sizes(&file, &SceneOptions::default()).map_err(Fault::Bind)?;
    println!(
        "it needs: scene {}, work {}, state {}, loads {}",
        sizes.scene, sizes.work, sizes.state, sizes.loads
    );
    Ok(())
}
