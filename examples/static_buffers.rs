//! The evaluator without heap: one fixed array, and a file that is part of the program.
//!
//! What you learn: how a program for a microcontroller holds a body. Only `main` uses the standard library,
//! to print; everything else compiles for a target that has none (`tests/bare-metal` does that).
//!
//! The length of the array: print `Body::len_for` of your file once, on your desk, and write the number down
//! as a constant. A larger file is refused at start and never cut short.

use core::fmt;

use vademecum_eval::format::{File, FormatError};
use vademecum_eval::{BindError, Body, BodyOptions, Field, LoadError, LocateError, OutputError, StepError};

/// The file, in flash beside the code.
static FILE: &[u8] = include_bytes!("../fixtures/golden/fixed-f32.vdm");

/// Numbers for the body: a little more than this file needs; the last line of the output prints the need.
const MEMORY: usize = 256;

/// Why the body cannot run. The errors of the library are small and `Copy`; one with numbers of its own is as
/// well.
#[derive(Clone, Copy, Debug)]
enum Fault {
    File(FormatError),
    Bind(BindError),
    Locate(LocateError),
    Load(LoadError),
    Step(StepError),
    Output(OutputError),
}

impl fmt::Display for Fault {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(error) => error.fmt(out),
            Self::Bind(error) => error.fmt(out),
            Self::Locate(error) => error.fmt(out),
            Self::Load(error) => error.fmt(out),
            Self::Step(error) => error.fmt(out),
            Self::Output(error) => error.fmt(out),
        }
    }
}

/// Pushes at the surface point nearest to `finger` for one step; displacement of that point \[m\].
fn tick(body: &mut Body<'_, f32>, finger: [f64; 3], force: [f64; 3]) -> Result<[f64; 3], Fault> {
    let touched = body.locate(finger).map_err(Fault::Locate)?;
    body.clear();
    body.push(&touched, force).map_err(Fault::Load)?;
    body.step().map_err(Fault::Step)?;
    body.point(&touched, Field::Displacement).map_err(Fault::Output)
}

fn main() {
    if let Err(fault) = run() {
        eprintln!("{fault}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), Fault> {
    // No compliance is asked for, so no memory is lent for it.
    let options = BodyOptions { places: 0, ..BodyOptions::default() };
    let file = File::parse(FILE).map_err(Fault::File)?;
    // On a device this is a `static` that is taken once at start; here the stack of `main` will do.
    let mut memory = [0.0; MEMORY];
    let mut body = Body::<f32>::bind(&file, &options, &mut memory).map_err(Fault::Bind)?;
    let mut moved = [0.0; 3];
    for _ in 0..10 {
        moved = tick(&mut body, [0.1, 0.05, 0.0], [0.0, 0.0, -1.0])?;
    }
    println!("{} bytes of memory, {} bytes of file", size_of::<[f64; MEMORY]>(), FILE.len());
    println!("after 10 steps the touched point is at {:+.3e} m", moved[2]);

    // Write this number down as the constant above.
    let needed = Body::<f32>::len_for(&file, &options).map_err(Fault::Bind)?;
    println!("it needs: {needed} numbers");
    Ok(())
}
