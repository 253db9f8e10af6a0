//! A state-space model as files: a NumPy archive, a MATLAB file, Matrix Market files and a description.
//!
//! Normative: `formats/state-space-1.md`.

use std::io::{self, Write};

use faer::Mat;
use serde::Serialize;
use vademecum_build::field::{DenseMatrix, MatValue, mat_into};

use super::model::{Signal, StateSpace};
use crate::npz::NpzArchive;
use crate::parameters::ParameterValue;

/// Description of a model beside its matrices.
#[derive(Debug, Serialize)]
pub struct ModelDescription<'a> {
    version: u32,
    units: &'a str,
    /// Step \[s\].
    time_step: f64,
    states: &'a [Signal],
    inputs: &'a [Signal],
    outputs: &'a [Signal],
    parameters: &'a [ParameterValue],
    modes: Vec<Mode>,
    by_modes_alone: Vec<Pair<'a>>,
    matrices: Vec<Size>,
}

#[derive(Debug, Serialize)]
struct Mode {
    frequency_hz: f64,
    damping_ratio: f64,
}

/// An output and an input.
#[derive(Debug, Serialize)]
struct Pair<'a> {
    output: &'a str,
    input: &'a str,
}

#[derive(Debug, Serialize)]
struct Size {
    name: &'static str,
    rows: usize,
    columns: usize,
}

impl StateSpace {
    /// Description of the model, with the units of its file and the values of its live parameters.
    pub fn description<'a>(
        &'a self,
        units: &'a str,
        parameters: &'a [ParameterValue],
    ) -> ModelDescription<'a> {
        let mode = |&[frequency_hz, damping_ratio]: &[f64; 2]| Mode { frequency_hz, damping_ratio };
        let pair = |&[output, input]: &[usize; 2]| Pair {
            output: &self.outputs[output].name,
            input: &self.inputs[input].name,
        };
        let size = |(name, matrix): (&'static str, Mat<f64>)| Size {
            name,
            rows: matrix.nrows(),
            columns: matrix.ncols(),
        };
        ModelDescription {
            version: 1,
            units,
            time_step: self.time_step,
            states: &self.states,
            inputs: &self.inputs,
            outputs: &self.outputs,
            parameters,
            modes: self.modes.iter().map(mode).collect(),
            by_modes_alone: self.by_modes_alone.iter().map(pair).collect(),
            matrices: self.matrices().into_iter().map(size).collect(),
        }
    }

    /// All matrices with their names in files, and the step.
    pub fn dense(&self) -> Vec<(&'static str, DenseMatrix)> {
        let step = DenseMatrix { rows: 1, columns: 1, data: vec![self.time_step] };
        let all = self.matrices().into_iter().map(|(name, matrix)| (name, dense(&matrix)));
        all.chain([("time_step", step)]).collect()
    }

    /// Names and units of states, inputs and outputs, by their names in files.
    fn texts(&self) -> [(&'static str, Vec<&str>); 6] {
        fn names(signals: &[Signal]) -> Vec<&str> {
            signals.iter().map(|signal| &*signal.name).collect()
        }
        fn units(signals: &[Signal]) -> Vec<&str> {
            signals.iter().map(|signal| &*signal.unit).collect()
        }
        [
            ("state_names", names(&self.states)),
            ("state_units", units(&self.states)),
            ("input_names", names(&self.inputs)),
            ("input_units", units(&self.inputs)),
            ("output_names", names(&self.outputs)),
            ("output_units", units(&self.outputs)),
        ]
    }

    /// Writes the archive of arrays.
    ///
    /// # Errors
    /// Of the output.
    pub fn npz_into(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut archive = NpzArchive::default();
        for (name, matrix) in self.dense() {
            archive.matrix(name, &matrix)?;
        }
        for (name, texts) in self.texts() {
            archive.texts(name, &texts)?;
        }
        out.write_all(&archive.finish()?)
    }

    /// Writes the MATLAB file of level 5.
    ///
    /// # Errors
    /// As [`mat_into`].
    pub fn mat_into(&self, out: &mut dyn Write) -> io::Result<()> {
        let (matrices, texts) = (self.dense(), self.texts());
        let numbers = matrices.iter().map(|(name, matrix)| (*name, MatValue::Matrix(matrix)));
        let names = texts.iter().map(|(name, texts)| (*name, MatValue::Texts(texts)));
        mat_into(out, &numbers.chain(names).collect::<Vec<_>>())
    }
}

fn dense(matrix: &Mat<f64>) -> DenseMatrix {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let data = (0..columns).flat_map(|j| (0..rows).map(move |i| matrix[(i, j)])).collect();
    DenseMatrix { rows, columns, data }
}
