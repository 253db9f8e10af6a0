//! The reduced methods compared: bases, and on each basis the ways to step it.

use std::path::Path;
use std::rc::Rc;

use vademecum_build::Matrix;
use vademecum_build::bench::{DenseGalerkin, Study};
use vademecum_build::compare::coordinate_matrix;
use vademecum_build::march::TimedLoad;
use vademecum_build::pod::Basis;
use vademecum_build::problem::BasisKind;
use vademecum_build::progress::Listener;
use vademecum_eval::{Scalar, SceneOptions, StructureChoice};
use vademecum_format::File;

use crate::console::Console;
use crate::failure::Failure;
use crate::player::{Track, play_in};

/// A basis and the methods on it.
pub struct Group {
    /// The basis.
    pub basis: Basis,
    /// The methods.
    pub methods: Vec<Method>,
}

/// One row of the table.
pub struct Method {
    /// Basis, structure, precision.
    pub name: &'static str,
    /// Wall time of everything it needs \[s\].
    pub offline_seconds: f64,
    /// How it steps.
    pub stepper: Stepper,
}

/// How a method steps.
pub enum Stepper {
    /// Dense solves, stage by stage.
    Dense(Box<DenseGalerkin>),
    /// A file through the evaluator.
    File {
        /// The file.
        bytes: Rc<Vec<u8>>,
        /// Structure of the step.
        structure: StructureChoice,
        /// f32 instead of f64.
        single: bool,
    },
}

/// All groups, by modes.
pub fn groups(study: &Study, modes: &[usize], console: &Console) -> Result<Vec<Group>, Failure> {
    let mut groups = vec![];
    for &r in modes {
        console.stage(&format!("bases and files, {r} modes"));
        groups.push(pod(study, r)?);
        groups.push(ritz(study, r)?);
        groups.push(natural(study, r)?);
    }
    Ok(groups)
}

fn pod(study: &Study, modes: usize) -> Result<Group, Failure> {
    let basis = study.basis(BasisKind::Pod, modes)?;
    let shared = study.prepare_seconds() + study.snapshot_seconds() + basis.seconds;
    let (dense, file) = (study.galerkin(&basis.value)?, study.file(&basis.value, true)?);
    let galerkin = Method {
        name: "pod-galerkin, dense solves f64",
        offline_seconds: shared + dense.seconds,
        stepper: Stepper::Dense(Box::new(dense.value)),
    };
    let block =
        method("pod block f64", shared + file.seconds, &Rc::new(file.value), StructureChoice::Block, false);
    Ok(Group { basis: basis.value, methods: vec![galerkin, block] })
}

fn ritz(study: &Study, modes: usize) -> Result<Group, Failure> {
    let basis = study.basis(BasisKind::Ritz, modes)?;
    let shared = study.prepare_seconds() + study.snapshot_seconds() + basis.seconds;
    let (diagonal, block) = (study.file(&basis.value, false)?, study.file(&basis.value, true)?);
    let seconds = [shared + diagonal.seconds, shared + block.seconds];
    let (diagonal, block) = (Rc::new(diagonal.value), Rc::new(block.value));
    let methods = vec![
        method("ritz diagonal f64", seconds[0], &diagonal, StructureChoice::Diagonal, false),
        method("ritz diagonal f32", seconds[0], &diagonal, StructureChoice::Diagonal, true),
        method("ritz block f64", seconds[1], &block, StructureChoice::Block, false),
        method("ritz block f32", seconds[1], &block, StructureChoice::Block, true),
    ];
    Ok(Group { basis: basis.value, methods })
}

fn natural(study: &Study, modes: usize) -> Result<Group, Failure> {
    let basis = study.basis(BasisKind::Modes, modes)?;
    let file = study.file(&basis.value, false)?;
    let seconds = study.prepare_seconds() + basis.seconds + file.seconds;
    let bytes = Rc::new(file.value);
    let methods =
        vec![method("natural modes, diagonal f64", seconds, &bytes, StructureChoice::Diagonal, false)];
    Ok(Group { basis: basis.value, methods })
}

fn method(
    name: &'static str,
    offline_seconds: f64,
    bytes: &Rc<Vec<u8>>,
    structure: StructureChoice,
    single: bool,
) -> Method {
    Method { name, offline_seconds, stepper: Stepper::File { bytes: Rc::clone(bytes), structure, single } }
}

impl Group {
    /// The files of its methods.
    pub fn file(&self) -> impl Iterator<Item = &[u8]> {
        self.methods.iter().filter_map(Method::bytes)
    }

    /// Coordinates of every method over the scenario, each of shape (r, steps + 1).
    pub fn play(
        &self,
        name: &Path,
        track: &Track,
        loads: &[TimedLoad],
        steps: usize,
    ) -> Result<Vec<Matrix>, Failure> {
        let play = |method: &Method| match &method.stepper {
            Stepper::Dense(model) => Ok(model.play(loads, steps)),
            Stepper::File { bytes, structure, single: false } => {
                play_file::<f64>(name, bytes, *structure, track, steps)
            }
            Stepper::File { bytes, structure, single: true } => {
                play_file::<f32>(name, bytes, *structure, track, steps)
            }
        };
        self.methods.iter().map(play).collect()
    }
}

impl Method {
    /// Its file, if it has one.
    pub fn bytes(&self) -> Option<&[u8]> {
        match &self.stepper {
            Stepper::Dense(_) => None,
            Stepper::File { bytes, .. } => Some(bytes),
        }
    }
}

fn play_file<T: Scalar>(
    name: &Path,
    bytes: &[u8],
    structure: StructureChoice,
    track: &Track,
    steps: usize,
) -> Result<Matrix, Failure> {
    let file = File::parse(bytes).map_err(|error| Failure::file(name, error))?;
    let options = SceneOptions { structure, ..SceneOptions::default() };
    let mut coordinates = vec![];
    play_in::<T>(name, &file, &options, track, steps, |_, _, state| {
        coordinates.extend(state.zeta().iter().map(|z| z.to_f64()));
        Ok(())
    })?;
    Ok(coordinate_matrix(file.metadata().n_modes as usize, &coordinates))
}
