//! A stage as the engine takes it: axes, one-axis functions, and the span of all exact answers.

use super::stage::ChapterStage;
use faer::{Mat, MatRef};
use vademecum_build::separated::Separated;
use vademecum_build::separated::{Axis, AxisKind};
use vademecum_build::separated::{DenseSpace, Space};
use vademecum_build::separated::{Energy, EnergyBasis};
use vademecum_build::separated::{KroneckerProblem, Source};
use vademecum_build::separated::{SeparatedError, check_len};
use vademecum_build::separated::{product, transposed_product};

/// Axes, and for every right-hand side its functions on them (one where none is named).
pub(super) struct Inputs {
    pub(super) axes: Vec<Axis>,
    pub(super) n_state: usize,
    /// `(axis, values at its points)` of each source.
    pub(super) functions: Vec<Vec<(usize, Vec<f64>)>>,
    /// `(n_rows, n_sources)`.
    pub(super) columns: Mat<f64>,
}

impl Inputs {
    pub(super) fn new(stage: &ChapterStage, scaled: bool) -> Result<Inputs, SeparatedError> {
        let (mut axes, mut functions, mut columns) = (Vec::new(), Vec::new(), Vec::new());
        let kind = AxisKind::Hat { points: stage.points };
        for family in &stage.families {
            check_len("ranges of a family, one per mode", family.columns.ncols(), family.ranges.len())?;
            let (scale, rest) = if scaled { (family.scale, 1.0) } else { (1.0, family.scale) };
            for (j, range) in family.ranges.iter().enumerate() {
                let name = format!("{}{}", family.name, j + 1);
                let unit = if scaled { "scaled" } else { &family.unit };
                axes.push(Axis::new(&name, unit, scale * range.0, scale * range.1, kind, false)?);
                functions.push(vec![(axes.len() - 1, axes[axes.len() - 1].nodes().to_vec())]);
                columns.push((&family.columns, j, rest));
            }
        }
        let n_state = axes.len();
        let two = AxisKind::Hat { points: 2 };
        axes.push(Axis::new("p", "N", stage.magnitude.0, stage.magnitude.1, two, false)?);
        for (c, range) in stage.components.iter().enumerate() {
            axes.push(Axis::new(&format!("d{}", c + 1), "1", range.0, range.1, two, false)?);
        }
        let per_position = stage.components.len().max(1);
        let positions = stage.loads.ncols() / per_position;
        check_len("load columns, modulo components", 0, stage.loads.ncols() % per_position)?;
        axes.push(Axis::new("s", "position", 0.0, positions as f64 - 1.0, AxisKind::Index, false)?);
        let last = axes.len() - 1;
        for k in 0..stage.loads.ncols() {
            let at = |j: usize| f64::from(j == k / per_position);
            let mut on =
                vec![(n_state, axes[n_state].nodes().to_vec()), (last, (0..positions).map(at).collect())];
            if !stage.components.is_empty() {
                let axis = n_state + 1 + k % per_position;
                on.push((axis, axes[axis].nodes().to_vec()));
            }
            functions.push(on);
            columns.push((&stage.loads, k, 1.0));
        }
        let n = stage.loads.nrows();
        columns.iter().try_for_each(|(m, _, _)| check_len("rows of a right-hand side", n, m.nrows()))?;
        let columns = Mat::from_fn(n, columns.len(), |i, s| columns[s].0[(i, columns[s].1)] * columns[s].2);
        Ok(Inputs { axes, n_state, functions, columns })
    }

    /// Values of source `s` at the points of axis `a`.
    pub(super) fn values(&self, s: usize, a: usize) -> Vec<f64> {
        match self.functions[s].iter().find(|(on, _)| *on == a) {
            Some((_, values)) => values.clone(),
            None => vec![1.0; self.axes[a].len()],
        }
    }

    pub(super) fn all(&self) -> Part {
        Part { axes: 0..self.axes.len(), sources: 0..self.functions.len() }
    }

    pub(super) fn state_part(&self) -> Part {
        Part { axes: 0..self.n_state, sources: 0..self.n_state }
    }

    pub(super) fn load_part(&self) -> Part {
        Part { axes: self.n_state..self.axes.len(), sources: self.n_state..self.functions.len() }
    }

    /// Value of each source's coefficient at a point of all axes; the points are on the axes by construction.
    pub(super) fn weights(&self, point: &[f64]) -> Vec<f64> {
        let value = |(a, f): &(usize, Vec<f64>)| self.axes[*a].evaluate(f, point[*a]).unwrap_or(f64::NAN);
        self.functions.iter().map(|on| on.iter().map(value).product()).collect()
    }
}

/// The span of all exact answers, orthonormal in `A`.
pub(super) struct Span {
    /// `Q`, `(n_rows, k)`.
    pub(super) basis: Mat<f64>,
    /// `Qᵀ b` of every source, which is also the answer's coordinates: `(k, n_sources)`.
    pub(super) sources: Mat<f64>,
    /// `Qᵀ M Q`.
    pub(super) energy: Mat<f64>,
}

impl Span {
    pub(super) fn new<S: Space>(
        space: &S,
        columns: &Mat<f64>,
        energy: &Energy<'_>,
    ) -> Result<Span, SeparatedError> {
        let answers = space.solve(&[1.0], columns.as_ref())?;
        let a = |x: MatRef<'_, f64>| space.apply(0, x);
        let mut basis = EnergyBasis::new(columns.nrows());
        for s in 0..answers.ncols() {
            // Families share their columns up to a factor; what rounding leaves of a repeated one is no new
            // direction.
            basis.append(answers.as_ref().subcols(s, 1), &a, 1e-12);
        }
        let basis = basis.into_vectors();
        let sources = transposed_product(basis.as_ref(), columns.as_ref());
        let energy = transposed_product(basis.as_ref(), energy(basis.as_ref()).as_ref());
        Ok(Span { basis, sources, energy })
    }

    /// Energy norm squared of a vector of coordinates.
    pub(super) fn size(&self, x: &Mat<f64>) -> f64 {
        transposed_product(x.as_ref(), product(self.energy.as_ref(), x.as_ref()).as_ref())[(0, 0)]
    }
}

/// Some axes and the sources that live on them.
pub(super) struct Part {
    pub(super) axes: std::ops::Range<usize>,
    pub(super) sources: std::ops::Range<usize>,
}

impl Part {
    pub(super) fn problem(
        &self,
        inputs: &Inputs,
        span: &Span,
    ) -> Result<KroneckerProblem<DenseSpace>, SeparatedError> {
        let axes = inputs.axes[self.axes.clone()].to_vec();
        let grams: Vec<_> = axes.iter().map(Axis::gram).collect();
        let source = |s: usize| {
            let vectors =
                self.axes.clone().map(|a| grams[a - self.axes.start].apply(&inputs.values(s, a))).collect();
            Source { vectors, block: span.sources.as_ref().subcols(s, 1).to_owned() }
        };
        let sources = self.sources.clone().map(source).collect();
        let k = span.sources.nrows();
        KroneckerProblem::new(axes, vec![grams.clone()], DenseSpace::new(vec![Mat::identity(k, k)])?, sources)
    }

    /// Every source's own answer, the largest `most` of them: exact when all are there.
    pub(super) fn one_axis_terms(
        &self,
        inputs: &Inputs,
        span: &Span,
        most: usize,
    ) -> Result<Separated, SeparatedError> {
        let axes = inputs.axes[self.axes.clone()].to_vec();
        let values: Vec<Vec<Vec<f64>>> =
            self.axes.clone().map(|a| self.sources.clone().map(|s| inputs.values(s, a)).collect()).collect();
        let factors = values.iter().map(|v| Mat::from_fn(v[0].len(), v.len(), |j, s| v[s][j])).collect();
        let blocks = span.sources.as_ref().subcols(self.sources.start, self.sources.len()).to_owned();
        Ok(Separated::new(axes, factors, blocks, span.sources.nrows())?.normalised().truncated(most))
    }

    /// The part's solution on all axes, constant on those it does not have.
    pub(super) fn embed(&self, inputs: &Inputs, u: &Separated) -> Result<Separated, SeparatedError> {
        let factor = |a: usize| {
            if self.axes.contains(&a) {
                u.factors(a - self.axes.start).to_owned()
            } else {
                Mat::from_fn(inputs.axes[a].len(), u.n_terms(), |_, _| 1.0)
            }
        };
        let factors = (0..inputs.axes.len()).map(factor).collect();
        Separated::new(inputs.axes.clone(), factors, u.blocks().to_owned(), u.n_rows())
    }
}
