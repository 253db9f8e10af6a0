//! `vademecum`: from a mesh to a stepped vademecum, on the command line.
//!
//! The crate is a program. Its library is there for other front ends of the same program, such as the Python
//! package: what the program says of a file ([`contents_json`]), its page in the browser ([`page`]), its
//! report ([`report`]), and its words for what went wrong ([`Failure`]).

/// Prints a line of results. Shadows the standard macro, which panics when the reader has gone
/// (`vademecum info | head`).
macro_rules! println {
    () => { $crate::console::show(format_args!("")) };
    ($($text:tt)*) => { $crate::console::show(format_args!($($text)*)) };
}

/// Prints a line on standard error. Shadows the standard macro, which panics when nobody reads it any more.
macro_rules! eprintln {
    ($($text:tt)*) => { $crate::console::tell(format_args!($($text)*)) };
}

mod accuracy;
mod arguments;
mod assets;
mod cmd;
mod console;
mod failure;
mod files;
mod given;
mod html;
mod looks;
mod mesh_error;
mod outline;
#[cfg(test)]
mod page_commands;
mod pictures;
mod print;
mod reference;
mod sha256;
mod surface_picture;
mod words;

use std::ffi::OsString;

use clap::{CommandFactory, Parser, Subcommand};
use vademecum_build::limits::bound_threads;
use vademecum_build::progress::Listener;

pub use arguments::Limit;
pub use cmd::info::contents_json;
pub use cmd::report::report;
pub use cmd::view::page;
pub use failure::{Cause, Failure};
pub use files::{is_stepped, open_or_map, usable_bytes};

/// The console, outputs and charts of the program, for programs of its kind.
pub mod front {
    pub use crate::arguments::{OutputArguments, positive, problem_or_demo, scenario_or_demo};
    pub use crate::console::{Console, show, tell};
    pub use crate::files::{outputs, write_bytes, write_picture};
    pub use crate::pictures::{Anchor, Axis, COLORS, Chart, Color, DrawResult, Frame, Picture, Shape};
    pub use crate::print::{json, print_json};
}

/// Real-time solid dynamics: build a vademecum offline, step it online.
#[derive(Parser)]
#[command(name = "vademecum", version, about, after_help = EXAMPLES, disable_help_subcommand = true)]
struct Arguments {
    /// Show results and errors only.
    #[arg(long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  vademecum demo -o demo                            the whole road, once, with pictures
  vademecum init liver.vtu --view                   from a mesh to the moving body
  vademecum mesh liver.vtu                          what a mesh file holds and what is wrong with it
  vademecum static bracket.inp                      the static steps of a deck, at full order
  vademecum build problem.toml -o body.vdm          compute a vademecum
  vademecum info body.vdm --json                    what a file holds
  vademecum run body.vdm --scenario s.toml -o out/  step it; CSV for probes, VTU for fields
  vademecum verify body.vdm --problem problem.toml --scenario s.toml
  vademecum frf body.vdm --in 1,0,0,z --out tip --range 1,500 --plot tip.svg
  vademecum sensors body.vdm --count 6 --modes 4    where a test should measure
  vademecum calibrate body.vdm --data tap.csv --scenario tap.toml -o fitted.vdm
  vademecum view body.vdm                           push it in the browser
  vademecum report body.vdm -o report.html          one page about a build, with figures
  vademecum assemble assembly.toml -o whole.vdm     join bodies that were built apart to one
  vademecum export matrices body.toml -o matrices   mass, stiffness, loads and basis for other programs
  vademecum export craig-bampton rod.toml -o rod    the body reduced to its interfaces, for multibody programs
  vademecum plan sweep.toml -o sweep                many builds as jobs; `collect` gathers them
  vademecum strip body.vdm --keep probes -o p.vdm   only what stepping and probes need
  vademecum pack body.vdm -o small.vdm              compress it for shipping; `unpack` gives it back
  vademecum verify body.vdm --file-only             is the file whole and sound
  vademecum help problem                            every key of the problem file; also `help scenario`

Exit codes: 0 done, 1 the machine failed, 2 wrong usage, 3 problem or scenario file, 4 mesh, 5 numerics,
6 a tolerance is missed, 7 vademecum file, 130 stopped on request.";

#[derive(Subcommand)]
enum Command {
    Init(cmd::init::Init),
    Build(cmd::build::Build),
    Info(cmd::info::Info),
    Mesh(cmd::mesh::MeshCommand),
    Modes(cmd::modes::Modes),
    Static(cmd::statics::Static),
    Frf(cmd::frf::Frf),
    Sensors(cmd::sensors::Sensors),
    Calibrate(cmd::calibrate::Calibrate),
    Run(cmd::run::Run),
    Verify(cmd::verify::Verify),
    Demo(cmd::demo::Demo),
    View(cmd::view::View),
    Report(cmd::report::Report),
    #[command(hide = true)]
    Bench(cmd::bench::Bench),
    Assemble(cmd::assemble::Assemble),
    Export(cmd::export::Export),
    Plan(cmd::plan::Plan),
    Collect(cmd::collect::Collect),
    Strip(cmd::strip::Strip),
    Pack(cmd::pack::Pack),
    Unpack(cmd::unpack::Unpack),
    Help(cmd::help::Help),
    Schema(cmd::schema::Schema),
    Completions(cmd::completions::Completions),
    Man(cmd::man::Man),
}

/// Runs the program with the arguments of a command line, its own name first, and gives its exit code. Wrong
/// usage ends the process, and so does a second Ctrl-C.
pub fn program(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = Arguments::parse_from(arguments);
    run_command(arguments.quiet, |console| run(&arguments.command, console))
}

/// Runs a command of this or another program and gives the exit code: shows progress, listens for Ctrl-C, and
/// prints what failed.
pub fn run_command(quiet: bool, command: impl FnOnce(&console::Console) -> Result<(), Failure>) -> u8 {
    console::listen_for_ctrl_c();
    failure::end_where_memory_is_refused();
    let console = console::Console::new(quiet);
    if let Some(note) = bound_threads() {
        console.note(&note);
    }
    let result = command(&console);
    console.clear();
    match result {
        Ok(()) => 0,
        Err(failure) => failure.tell(),
    }
}

fn run(command: &Command, console: &console::Console) -> Result<(), failure::Failure> {
    match command {
        Command::Init(command) => {
            // One command may go on to others.
            command
                .run(console)?
                .into_iter()
                .try_for_each(|line| run(&Arguments::parse_from(line).command, console))
        }
        Command::Build(command) => command.run(console),
        Command::Info(command) => command.run(),
        Command::Mesh(command) => command.run(),
        Command::Modes(command) => command.run(console),
        Command::Static(command) => command.run(console),
        Command::Frf(command) => command.run(console),
        Command::Sensors(command) => command.run(console),
        Command::Calibrate(command) => command.run(console),
        Command::Run(command) => command.run(console),
        Command::Verify(command) => command.run(console),
        Command::Demo(command) => command.run(console),
        Command::View(command) => command.run(console),
        Command::Report(command) => command.run(console),
        Command::Bench(command) => command.run(),
        Command::Assemble(command) => command.run(console),
        Command::Export(command) => command.run(console),
        Command::Plan(command) => command.run(),
        Command::Collect(command) => command.run(),
        Command::Strip(command) => command.run(),
        Command::Pack(command) => command.run(),
        Command::Unpack(command) => command.run(),
        Command::Help(command) => command.run(Arguments::command()),
        Command::Man(command) => command.run(Arguments::command()),
        Command::Schema(command) => {
            command.run();
            Ok(())
        }
        Command::Completions(command) => {
            command.run(Arguments::command());
            Ok(())
        }
    }
}
