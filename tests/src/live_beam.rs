//! A beam of equal regions along its axis, with live stiffness of each and live `β`, and the same beam
//! at fixed values.

use std::fmt::Write as _;
use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_format::File;
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;
use vademecum_study::verify::verify_linear;

/// `β` as built \[s\].
pub const BETA: f64 = 1e-4;

/// A beam of length 1 m.
#[derive(Clone, Copy, Debug)]
pub struct LiveBeam {
    /// Number of regions.
    pub regions: usize,
    /// Height; the width is 0.1 m, so that 0.1 makes pairs of equal frequencies.
    pub height: f64,
    /// Vectors of the basis, or modes.
    pub modes: usize,
    /// True of a beam that is held at both ends, false of a cantilever.
    pub both_ends: bool,
    /// Elements along a region, and one less over the height and the width.
    pub fine: usize,
    /// Time step \[s\].
    pub step: f64,
}

impl LiveBeam {
    /// Places of the sensors along the axis; each has three components.
    #[must_use]
    pub const fn sensors(&self) -> [f64; 3] {
        if self.both_ends { [0.25, 0.5, 0.75] } else { [0.35, 0.65, 1.0] }
    }

    /// The problem file: with live parameters, or at factors of the stiffness of each region and a `β`.
    #[must_use]
    pub fn text(&self, fixed: Option<(&[f64], f64)>) -> String {
        let Self { regions, height, modes, both_ends, fine, step } = *self;
        let more = if both_ends { "[[support]]\non = { group = \"x_max\" }\n" } else { "" };
        let beta = fixed.map_or(BETA, |(_, beta)| beta);
        let mut text = String::new();
        if fixed.is_none() {
            text += "representation = \"parametric\"\n";
        }
        let (along, across) = (fine * regions, fine - 1);
        let _ = write!(
            text,
            "[mesh]\nblock = {{ lengths = [1.0, 0.1, {height}], divisions = [{along}, {across}, {across}], order = \"quadratic\" }}\n"
        );
        for region in 1..regions {
            let share = 1.0 - region as f64 / regions as f64;
            let _ = write!(
                text,
                "[[mesh.region]]\nname = \"part{}\"\non = {{ fraction = {{ axis = \"x\", side = \"max\", fraction = {share:.12} }} }}\n",
                region + 1
            );
        }
        for region in 0..regions {
            let name = name(region);
            let factor = fixed.map_or(1.0, |(factors, _)| factors[region]);
            let _ = write!(
                text,
                "[[material]]\nregion = \"{name}\"\nyoung = {:.12e}\npoisson = 0.3\ndensity = 1200.0\n",
                2.1e9 * factor
            );
        }
        let _ = write!(
            text,
            "[damping]\nalpha = 1.0\nbeta = {beta:e}\n[[support]]\non = {{ group = \"x_min\" }}\n{more}\
             [load]\nsurface = {{ any = [{{ group = \"z_max\" }}, {{ group = \"y_max\" }}] }}\n[time]\nstep = {step:e}\n\
             [basis]\nmodes = {modes}\n[tolerance]\nsteps = 200\n"
        );
        for (place, x) in self.sensors().into_iter().enumerate() {
            for (axis, direction) in [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])]
            {
                let _ = write!(
                    text,
                    "[[output.probe]]\nname = \"s{place}{axis}\"\npoint = [{x}, 0.1, {height}]\ndirection = {direction:?}\n"
                );
            }
        }
        if fixed.is_none() {
            for region in 0..regions {
                let _ = write!(
                    text,
                    "[[parameter]]\nname = \"k{}\"\nkind = \"stiffness\"\nregion = \"{}\"\nrange = [0.5, 2.0]\nscale = \"log\"\n",
                    region + 1,
                    name(region)
                );
            }
            text +=
                "[[parameter]]\nname = \"beta\"\nkind = \"beta\"\nrange = [2e-5, 5e-4]\nscale = \"log\"\n";
        }
        text
    }

    /// Bytes of the file of [`LiveBeam::text`].
    ///
    /// # Panics
    /// If it is not built.
    #[must_use]
    pub fn build(&self, fixed: Option<(&[f64], f64)>) -> Vec<u8> {
        let problem = Problem::parse(&self.text(fixed), "beam.toml", PathBuf::new()).expect("a problem");
        build(&problem, &BuildOptions::default(), &Silent).expect("built").either().bytes
    }

    /// Histories of the nine probes at full order, exact in time, at factors of the stiffness and a `β`: a
    /// row for each step from the start on. Beside them the number of free dofs.
    ///
    /// # Panics
    /// If there are none.
    #[must_use]
    pub fn full_order(&self, fixed: (&[f64], f64), scenario: &Scenario) -> (Vec<[f64; 9]>, usize) {
        // The file is only what the loads of the scenario are found on.
        let few = Self { modes: 6, ..*self };
        let (text, bytes) = (few.text(Some(fixed)), few.build(Some(fixed)));
        let problem = Problem::parse(&text, "beam.toml", PathBuf::new()).expect("a problem");
        let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("prepared");
        let file = File::parse(&bytes).expect("a file");
        let options = PlayOptions::default();
        let found =
            verify_linear(&file, &options, &problem, &prepared, scenario, &Silent).expect("full order");
        assert!(found.figures.truth.truth_error < 1e-5, "{:e}", found.figures.truth.truth_error);
        let rows = found.probe_series[0].as_chunks().0.to_vec();
        (rows, prepared.body.n_dof())
    }
}

/// Name of a region.
fn name(region: usize) -> String {
    if region == 0 { "body".into() } else { format!("part{}", region + 1) }
}
