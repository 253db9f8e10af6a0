//! The state-space model itself, and what is asked of a file for it.

use faer::Mat;
use serde::Serialize;

use super::signal::OutputSignal;
use crate::frf::Channel;

/// Signals of a state-space model.
#[derive(Clone, Debug, Default)]
pub struct StateSpaceRequest {
    /// Points of forces of 1 N, and load patterns of amplitude 1; all load patterns if empty.
    pub inputs: Vec<Channel>,
    /// Outputs; all probes and reactions of the file if empty.
    pub outputs: Vec<OutputSignal>,
}

/// Name and unit of a state, an input or an output. The unit is empty where it is not known.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Signal {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
}

/// State-space model of a file, with `n` states, `m` inputs and `p` outputs.
#[derive(Clone, Debug)]
pub struct StateSpace {
    /// States: `r` coordinates, their velocities, then filtered inputs.
    pub states: Vec<Signal>,
    /// Inputs.
    pub inputs: Vec<Signal>,
    /// Outputs.
    pub outputs: Vec<Signal>,
    /// `A`, (n, n).
    pub a: Mat<f64>,
    /// `B`, (n, m).
    pub b: Mat<f64>,
    /// `C`, (p, n).
    pub c: Mat<f64>,
    /// `D`, (p, m).
    pub d: Mat<f64>,
    /// `Δt` \[s\].
    pub time_step: f64,
    /// State after a step, by the state before, (n, n).
    pub ad: Mat<f64>,
    /// The same by the inputs at the start of the step, (n, m).
    pub start: Mat<f64>,
    /// The same by the inputs at its end, (n, m).
    pub end: Mat<f64>,
    /// Natural frequency \[Hz\] and damping ratio of each mode.
    pub modes: Vec<[f64; 2]>,
    /// Displacements without residual flexibility: numbers of output and input.
    pub by_modes_alone: Vec<[usize; 2]>,
    /// Remarks on what the export leaves out, in sentences.
    pub notes: Vec<String>,
}

impl StateSpace {
    /// `Bd_held`, (n, m): the map of a step whose inputs are held.
    pub fn held(&self) -> Mat<f64> {
        &self.start + &self.end
    }

    /// `Bd_linear`, (n, m), and `Dd_linear`, (p, m): the map of a step whose inputs are linear, over the
    /// state `w = x − Bd_end u`, which needs no input of the future.
    pub fn linear(&self) -> [Mat<f64>; 2] {
        [&self.ad * &self.end + &self.start, &self.d + &self.c * &self.end]
    }

    /// All matrices with their names in files.
    pub fn matrices(&self) -> Vec<(&'static str, Mat<f64>)> {
        let [linear, through] = self.linear();
        vec![
            ("A", self.a.clone()),
            ("B", self.b.clone()),
            ("C", self.c.clone()),
            ("D", self.d.clone()),
            ("Ad", self.ad.clone()),
            ("Bd_start", self.start.clone()),
            ("Bd_end", self.end.clone()),
            ("Bd_held", self.held()),
            ("Bd_linear", linear),
            ("Dd_linear", through),
        ]
    }
}
