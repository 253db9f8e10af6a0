//! The bodies: where their meshes are, what they are made of, where they are held and pushed.

use std::path::PathBuf;

use vademecum_build::input::Problem;

use crate::program::repository;
use crate::shared::shared;

/// A body without its time step, which follows from its first period.
#[derive(Clone, Debug)]
pub struct RealBody {
    /// As `--body` names it.
    pub name: &'static str,
    /// What it is, in a few words.
    pub what: &'static str,
    /// Vectors of the reference for a force, at most.
    pub vectors: usize,
    /// Tables of the problem file: mesh, material, support, load.
    pub text: String,
}

impl RealBody {
    /// The problem with so many natural modes, moved exactly at `step` \[s\], of so much damping, and with
    /// the factor of the stiffness in the file.
    ///
    /// # Panics
    /// If the text is no problem.
    #[must_use]
    pub fn problem(&self, step: f64, modes: usize, ratio: f64) -> Problem {
        let damping = if ratio > 0.0 { format!("[damping]\nratio = {ratio}\n") } else { String::new() };
        let text = format!(
            "{}\n[time]\nscheme = {{ name = \"exact\" }}\nstep = {step:e}\n{damping}[basis]\nkind = \"modes\"\n\
             modes = {modes}\n[tolerance]\nsteps = 200\n[output]\nstatic_fields = true\n",
            self.text
        );
        let folder: PathBuf = repository();
        Problem::parse(&text, &format!("{}.toml", self.name), folder)
            .unwrap_or_else(|error| panic!("{error}"))
    }
}

/// Those of the five bodies whose meshes are there.
#[must_use]
pub fn real_bodies() -> Vec<RealBody> {
    let demo = RealBody {
        name: "demo",
        what: "the demo's beam of quadratic tetrahedra, clamped at one end, pushed on its upper side",
        vectors: 200,
        text:
            "[mesh]\nblock = { lengths = [1.0, 0.08, 0.1], divisions = [32, 3, 4], order = \"quadratic\" }\n\
               [[material]]\nyoung = 2.1e9\npoisson = 0.3\ndensity = 1200.0\n\
               [[support]]\non = { group = \"x_min\" }\n[load]\nsurface = { group = \"z_max\" }\n"
                .into(),
    };
    let read = |name, what, vectors, mesh, scale, material, held| {
        let file = shared(&format!("meshes/{mesh}"))?;
        let text = format!(
            "[mesh]\nfile = {:?}\nscale = {scale}\n[[material]]\n{material}\n\
             [[support]]\non = {{ fraction = {{ {held}, fraction = 0.25 }} }}\n[load]\n",
            file.to_str()?
        );
        Some(RealBody { name, what, vectors, text })
    };
    let files = [
        read(
            "liver",
            "`liverFine.vtu` of SOFA, 19 cm wide, 5 kPa, clamped at its 25 % of largest x",
            200,
            "vtu/liverFine.vtu",
            0.03,
            "young = 5e3\npoisson = 0.3\ndensity = 1000.0",
            "axis = \"x\", side = \"max\"",
        ),
        read(
            "sphere_p2",
            "`sphere_p2.msh`, quadratic tetrahedra, rubber of 1 MPa, clamped at its lowest 25 %",
            400,
            "gmsh41_binary/sphere_p2.msh",
            1.0,
            "young = 1e6\npoisson = 0.3\ndensity = 1100.0",
            "axis = \"z\", side = \"min\"",
        ),
        read(
            "screw",
            "`screw.msh`, steel of 210 GPa, clamped at its 25 % of lowest z",
            400,
            "gmsh41_ascii/screw.msh",
            1e-3,
            "young = 2.1e11\npoisson = 0.3\ndensity = 7850.0",
            "axis = \"z\", side = \"min\"",
        ),
        read(
            "raptor",
            "`raptorTetra_8418.vtu` of SOFA, 1 MPa, clamped at its 25 % of smallest x",
            200,
            "vtu/raptorTetra_8418.vtu",
            1.0,
            "young = 1e6\npoisson = 0.3\ndensity = 1000.0",
            "axis = \"x\", side = \"min\"",
        ),
    ];
    std::iter::once(demo).chain(files.into_iter().flatten()).collect()
}
