//! `vademecum mesh`: what a mesh file holds and what is wrong with it.

use std::path::PathBuf;

use vademecum_build::mesh::{inspect, parse};

use crate::failure::{Cause, Failure};
use crate::print::print_json;

/// Reads a mesh file and prints counts, groups, bounding box, quality and every problem found.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum mesh liver.vtu
  vademecum mesh beam.msh --json
Formats: Gmsh 1, 2.2 and 4.1, Abaqus/CalculiX, Nastran, Ansys (.cdb), UNV, VTK, VTU, TetGen, Medit, MFEM;
surfaces that are filled with tetrahedra: STL, OBJ, PLY, OFF, GLB")]
pub(crate) struct MeshCommand {
    /// The mesh file, or a surface.
    file: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl MeshCommand {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let report = inspect(&parse(&self.file)?);
        if self.json {
            print_json(&report);
        } else {
            println!("{report}");
        }
        if report.problems.is_empty() {
            return Ok(());
        }
        let count = report.problems.len();
        let keep = if count == 1 { "problem keeps" } else { "problems keep" };
        Err(Failure::new(Cause::Mesh, format!("{}: {count} {keep} it from being built", self.file.display())))
    }
}
