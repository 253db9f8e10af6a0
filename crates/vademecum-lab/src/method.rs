//! Compared methods: a name for every row, and the parts of a method.

use std::fmt;
use std::rc::Rc;

use serde::{Serialize, Serializer};
use vademecum_build::Matrix;
use vademecum_build::basis::Basis;
use vademecum_build::dynamics::SchemeKind;
use vademecum_build::input::BasisKind;
use vademecum_eval::{Scalar, SceneOptions, StructureChoice};
use vademecum_format::File;
use vademecum_study::compare::coordinate_matrix;
use vademecum_study::player::{Track, play_in};

use super::chapter;
use super::march::{ChapterMarch, March};
use super::staged::{self, ReducedSolver};
use super::trajectory::thinned;
use vademecum_build::progress::Listener;
use vademecum_study::StudyError;

/// A way to step on a basis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Galerkin stages, each solved with a dense factor, without a file.
    DenseSolves,
    /// Each mode moved by its closed form, without a file and without a time scheme.
    ExactMotion,
    /// A file whose modes move exactly.
    Exact,
    /// The diagonal structure of a file.
    Diagonal,
    /// The same, the basis rounded to 16 bits.
    Quantised,
    /// Projected full-order responses, stage by stage, without a file.
    TwoStage,
    /// The block structure of a file.
    Block,
    /// The same, the responses summed from terms over a live stiffness.
    Separated,
    /// The chapter's maps, as the chapter finds them.
    Chapter,
    /// The chapter's maps with every repair.
    Repaired,
}

impl Way {
    /// True of methods that step with the chapter's maps.
    pub fn is_chapter(self) -> bool {
        matches!(self, Self::Chapter | Self::Repaired)
    }

    /// The structure of its file that is stepped.
    fn structure(self) -> StructureChoice {
        match self {
            Self::Diagonal | Self::Quantised => StructureChoice::Diagonal,
            Self::Exact => StructureChoice::Exact,
            _ => StructureChoice::Block,
        }
    }
}

/// Precision of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// binary32.
    Single,
    /// binary64.
    Double,
}

/// Method of a row. Its text is the row's name in every record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Identity {
    /// The full-order march with a scheme.
    FullOrder(SchemeKind),
    /// A reduced method.
    Reduced {
        /// Basis.
        basis: BasisKind,
        /// Kind of the step.
        way: Way,
        /// In which numbers.
        precision: Precision,
    },
}

impl Identity {
    /// Kind of the step, if it is reduced.
    pub fn way(self) -> Option<Way> {
        match self {
            Self::FullOrder(_) => None,
            Self::Reduced { way, .. } => Some(way),
        }
    }

    /// True of reduced methods on this basis.
    pub fn is_on(self, kind: BasisKind) -> bool {
        matches!(self, Self::Reduced { basis, .. } if basis == kind)
    }

    /// True of methods in binary32.
    pub fn is_single(self) -> bool {
        matches!(self, Self::Reduced { precision: Precision::Single, .. })
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (basis, way, precision) = match *self {
            Self::FullOrder(scheme) => return write!(out, "full order, {scheme}"),
            Self::Reduced { basis, way, precision } => (basis, way, precision),
        };
        let basis = match basis {
            BasisKind::Pod => "pod",
            BasisKind::Ritz => "ritz",
            BasisKind::Modes => "natural modes,",
        };
        let way = match way {
            Way::DenseSolves => "-galerkin, dense solves",
            Way::ExactMotion => " exact",
            Way::Exact => " exact steps",
            Way::Diagonal => " diagonal",
            Way::Quantised => " quantised",
            Way::TwoStage => " block two-stage",
            Way::Block => " block",
            Way::Separated => " separated",
            Way::Chapter => " canonical chapter",
            Way::Repaired => " canonical repaired",
        };
        let precision = match precision {
            Precision::Single => "f32",
            Precision::Double => "f64",
        };
        write!(out, "{basis}{way} {precision}")
    }
}

impl Serialize for Identity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A basis and the methods on it.
pub(super) struct Group {
    /// Kind of the basis.
    pub kind: BasisKind,
    /// The basis.
    pub basis: Basis,
    /// Wall time up to the basis \[s\], in the offline time of each of its methods.
    pub shared_seconds: f64,
    /// The methods; one that differs from another stands after it.
    pub methods: Vec<Method>,
}

impl Group {
    /// The files of its methods.
    pub fn files(&self) -> impl Iterator<Item = &[u8]> {
        self.methods.iter().filter_map(Method::bytes)
    }

    /// Identity of a method of the group.
    pub fn identity(&self, method: &Method) -> Identity {
        Identity::Reduced { basis: self.kind, way: method.way, precision: method.precision }
    }
}

/// One row of the table.
pub(super) struct Method {
    /// Kind of the step.
    pub way: Way,
    /// In which numbers.
    pub precision: Precision,
    /// Wall time of everything it needs \[s\].
    pub offline_seconds: f64,
    /// Solver or file.
    pub stepper: Stepper,
    /// Terms over the live parameters, where there are any.
    pub terms: Option<usize>,
    /// The method of the group it differs from in one thing.
    pub differs: Option<(Part, usize)>,
    /// Its file as it is shipped, where shipping rounds the basis.
    pub shipped: Option<Shipped>,
}

/// A packed file whose basis is rounded.
pub(super) struct Shipped {
    /// Bytes of the packed file.
    pub file_bytes: usize,
    /// The basis it holds, over the free dofs, shape (n, r).
    pub basis: Matrix,
}

/// Part of the error that tells a method from another one of its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Responses summed from terms instead of solved.
    Separation,
    /// f32 instead of f64, or a basis of 16 bits.
    Rounding,
}

/// Solver or file of a method.
pub(super) enum Stepper {
    /// A solver without a file.
    Solver(Box<dyn ReducedSolver>),
    /// A file through the evaluator.
    File(Rc<Vec<u8>>),
    /// A file of the chapter's maps through the evaluator, in f64.
    Chapter {
        /// The file.
        bytes: Vec<u8>,
        /// The loads of each march; the answer is the sum of the marches.
        tracks: Rc<Vec<Track>>,
    },
}

impl Method {
    /// A method on its own, in double precision.
    pub fn new(way: Way, offline_seconds: f64, stepper: Stepper) -> Self {
        let precision = Precision::Double;
        Self { way, precision, offline_seconds, stepper, terms: None, differs: None, shipped: None }
    }

    /// A solver without a file.
    pub fn solver(way: Way, offline_seconds: f64, solver: impl ReducedSolver + 'static) -> Self {
        Self::new(way, offline_seconds, Stepper::Solver(Box::new(solver)))
    }

    /// A file through the evaluator.
    pub fn file(way: Way, offline_seconds: f64, bytes: &Rc<Vec<u8>>) -> Self {
        Self::new(way, offline_seconds, Stepper::File(Rc::clone(bytes)))
    }

    /// The same in single precision; `exact` is the number of the method it rounds.
    pub fn rounded(self, exact: usize) -> Self {
        Self { precision: Precision::Single, differs: Some((Part::Rounding, exact)), ..self }
    }

    /// Its file, if it has one.
    pub fn bytes(&self) -> Option<&[u8]> {
        match &self.stepper {
            Stepper::Solver(_) => None,
            Stepper::File(bytes) => Some(bytes),
            Stepper::Chapter { bytes, .. } => Some(bytes),
        }
    }

    /// Bytes of the file as it is shipped.
    pub fn file_bytes(&self) -> Option<usize> {
        let shipped = self.shipped.as_ref().map(|shipped| shipped.file_bytes);
        shipped.or_else(|| self.bytes().map(<[u8]>::len))
    }

    /// Marches from rest whose sum is its answer.
    pub fn n_marches(&self) -> usize {
        match &self.stepper {
            Stepper::Chapter { tracks, .. } => tracks.len(),
            _ => 1,
        }
    }

    /// Scene options of its file.
    pub fn options(&self, time_step: Option<f64>) -> SceneOptions {
        SceneOptions { structure: self.way.structure(), time_step, ..SceneOptions::default() }
    }

    /// Its coordinates from rest at the instants kept, the start included; shape (r, instants). Or why it has
    /// none.
    pub fn play(&self, march: &March<'_>, listener: &dyn Listener) -> Result<ChapterMarch, StudyError> {
        let all = self.play_all(march, listener)?;
        Ok(if march.stride == 1 { all } else { all.map(|all| thinned(&all, march.stride)) })
    }

    fn play_all(&self, march: &March<'_>, listener: &dyn Listener) -> Result<ChapterMarch, StudyError> {
        Ok(Ok(match &self.stepper {
            Stepper::Solver(solver) => staged::play(solver.as_ref(), march.loads, march.steps),
            Stepper::File(bytes) => {
                let options = self.options(Some(march.time_step));
                let play = match self.precision {
                    Precision::Single => play_file::<f32>,
                    Precision::Double => play_file::<f64>,
                };
                play(bytes, &options, march.track, march.steps, listener)?
            }
            Stepper::Chapter { bytes, tracks } => return chapter::play(bytes, tracks, march, listener),
        }))
    }
}

/// Coordinates that a file shows from rest at every instant, the start included; shape (r, steps + 1).
pub(super) fn play_file<T: Scalar>(
    bytes: &[u8],
    options: &SceneOptions,
    track: &Track,
    steps: usize,
    listener: &dyn Listener,
) -> Result<Matrix, StudyError> {
    let file = File::parse(bytes)?;
    let mut coordinates = vec![];
    play_in::<T>(&file, options, track, steps, listener, |_, body| {
        coordinates.extend(body.zeta().iter().map(|z| z.to_f64()));
        Ok(())
    })?;
    Ok(coordinate_matrix(file.metadata().n_modes as usize, &coordinates))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_records() {
        let name = |basis, way, precision| Identity::Reduced { basis, way, precision }.to_string();
        use {BasisKind as B, Precision as P, Way as W};
        assert_eq!(name(B::Pod, W::DenseSolves, P::Double), "pod-galerkin, dense solves f64");
        assert_eq!(name(B::Ritz, W::Separated, P::Single), "ritz separated f32");
        assert_eq!(name(B::Modes, W::TwoStage, P::Double), "natural modes, block two-stage f64");
        assert_eq!(name(B::Pod, W::Chapter, P::Double), "pod canonical chapter f64");
        assert_eq!(Identity::FullOrder(SchemeKind::Bathe {}).to_string(), "full order, bathe");
    }
}
