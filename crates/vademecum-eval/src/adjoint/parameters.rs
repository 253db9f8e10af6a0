//! Gradients of a march with respect to parameters, from the sums of [`ModalMarch`].
//!
//! Parameters change the eigenvalues, the damping and the shapes of modes. With the couplings `N_ij` and
//! `D_ij` of a parameter (`docs/explanation/parametric-models.md`), a scalar `J` changes by
//!
//! ```text
//! Σ_i N_ii (G_ii : L_ii) − D_ii b̂_i·b_i                             of each mode
//! Σ_i≠j N_ij/(λ_j − λ_i) (c_i·ĉ_j + b_i·b̂_j − λ_i(0)·y_j(0))        of modes whose frequencies differ
//! Σ_i≠j N_ij (G_ij : L_ij) − D_ij b̂_i·b_j                           of modes of nearly one frequency
//! ```
//!
//! with `L_ij`, the change of a step when two modes are coupled. The second line is the derivative of shapes
//! (Fox and Kapoor 1968), which costs nothing in a step; the third has no difference to divide by. Modes
//! whose eigenvalues differ by less than [`NEAR`] are taken by it.

use crate::adjoint::cotangents::check_exact;
use crate::adjoint::error::AdjointError;
use crate::adjoint::modal::{Lengths, MarchRows, ModalMarch};
use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::kernels::dense::{at, dot};
use crate::parametric::coupling::{STEP, coupling, doublings, of_ends, step_of_ends, steps_into};
use crate::parametric::damped::Damped;
use crate::parametric::model::Parametric;
use crate::parametric::rows::along;
use crate::parametric::tangents::TangentSizes;
use crate::parametric::tuned::Tuned;
use crate::scene::equation::Stiffness;
use crate::scene::scene::Scene;
use vademecum_format::scheme::StepParameters;
use vademecum_format::{ParameterRole, SectionKind};

/// Share by which eigenvalues differ at most to count as a pair: a quotient by their difference keeps twelve
/// digits beyond it.
const NEAR: f64 = 1e-3;

/// Numbers of steps over halves of halves of one mode.
const HALVES: usize = STEP * 49;

/// A march of modes that is kept by checkpoints, and its gradients: with respect to live parameters, damping
/// and step, and to loads and the state at its start. Exact in time, in `f64`, in lent memory.
///
/// The march is that of [`Tangents`](crate::Tangents): of the stepped modes, without residual flexibility.
/// The gradient is to rounding that of all modes of the basis if all are stepped; with fewer it leaves out
/// that their span turns. With respect to the time step it is that at held numbers of steps and held
/// amplitudes: instants move. Modes of one frequency and different damping ratios beside Rayleigh's damping
/// have no derivative; the mean of the ratios is taken.
///
/// A march and its gradients cost less than four marches of a [`Body`](crate::Body), for any number of
/// parameters, beside `O(P m r²)` once.
///
/// ```
/// use vademecum_eval::format::File;
/// use vademecum_eval::{CheckpointedMarch, Field, MarchRows, Parametric};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let bytes = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/parametric.vdm"));
/// let file = File::parse(bytes)?;
/// let model = Parametric::new(&file)?;
/// let (r, steps) = (model.n_basis(), 100);
/// let (mut probe, mut load) = (vec![0.0; r], vec![0.0; r]);
/// model.probe_row(0, &mut probe)?;
/// model.node_row(4, [0.0, 0.0, 1.0], &mut load)?;
/// let rows = MarchRows { outputs: &probe, fields: &[Field::Displacement], loads: &load, steps };
///
/// // The modes at values of the parameters, and the march.
/// let sizes = model.sizes(r)?;
/// let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
/// let tuned = model.solve(&[1.0, 1.0, 1.0, 4e-5], r, &mut memory, &mut work)?;
/// let sizes = model.adjoint_sizes(r, &rows)?;
/// let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
/// let mut march = CheckpointedMarch::new(&model, tuned, &rows, &mut memory)?;
///
/// // A scalar: half the sum of the squares of the output, whose cotangents are the output itself.
/// let (loads, mut outputs) = (vec![1.0; 2 * steps], vec![0.0; steps]);
/// march.march([&[]; 2], &loads, &mut outputs)?;
/// march.back(&loads, &outputs, &mut [])?;
/// let mut gradient = vec![0.0; model.n_parameters()];
/// march.parameters_into(&mut gradient, &mut work)?;
/// assert!(gradient.iter().all(|slope| *slope != 0.0));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct CheckpointedMarch<'m, 'f> {
    march: ModalMarch<'m>,
    /// A parametric model and its modes; none of a scene.
    model: Option<(Parametric<'f>, Tuned<'m>)>,
    /// Factors on stiffness and density of a scene.
    scales: [f64; 2],
    modes: Modes<'m>,
}

/// Eigenvalues, ratios and damping.
#[derive(Debug)]
struct Modes<'m> {
    eigenvalues: &'m mut [f64],
    ratios: &'m mut [f64],
    alpha: f64,
    beta: f64,
    time_step: f64,
}

impl Modes<'_> {
    const fn damped(&self) -> Damped<'_, impl Fn(usize) -> f64> {
        let ratios: &[f64] = self.ratios;
        let ratio = move |k: usize| at(ratios, k);
        Damped { eigenvalues: self.eigenvalues, ratio, alpha: self.alpha, beta: self.beta }
    }

    /// Doublings of the steps of all of them.
    fn doublings(&self) -> i32 {
        let damped = self.damped();
        doublings((0..self.eigenvalues.len()).map(|k| damped.mode(k)), self.time_step)
    }
}

/// Lengths of a march of so many modes, with rows of `width` numbers.
fn lengths(rows: &MarchRows<'_>, modes: usize, width: usize, pairs: bool) -> Result<Lengths, AdjointError> {
    let outputs = rows.fields.len();
    let loads = rows.loads.len() / width.max(1);
    let needed = outputs.saturating_mul(width);
    if rows.outputs.len() != needed {
        return Err(AdjointError::Length { found: rows.outputs.len(), needed });
    }
    if rows.loads.len() != loads * width {
        return Err(AdjointError::Length { found: rows.loads.len(), needed: (loads + 1) * width });
    }
    Ok(Lengths { modes, outputs, loads, steps: rows.steps, pairs })
}

impl Parametric<'_> {
    /// Memory to lend for a [`CheckpointedMarch`] of so many stepped modes: states at `√N` of `N` steps and
    /// of `√N` steps in a row, sums of pairs of modes, and the rows. `work` is that of
    /// [`CheckpointedMarch::parameters_into`].
    ///
    /// # Errors
    /// [`AdjointError::Length`]: rows that are not whole.
    pub fn adjoint_sizes(&self, modes: usize, rows: &MarchRows<'_>) -> Result<TangentSizes, AdjointError> {
        let lengths = lengths(rows, modes, self.n_basis(), true)?;
        let memory = lengths.memory().saturating_add(2 * modes);
        Ok(TangentSizes { memory, work: 4 * modes * modes + modes + self.slope_work() })
    }
}

impl<T: Scalar> Scene<'_, T> {
    /// Memory to lend for a [`CheckpointedMarch`] of this scene; no work.
    ///
    /// # Errors
    /// [`AdjointError::Length`]: rows that are not whole; [`AdjointError::Structure`],
    /// [`AdjointError::Coupled`].
    pub fn march_sizes(&self, rows: &MarchRows<'_>) -> Result<TangentSizes, AdjointError> {
        check_uncoupled(self)?;
        let lengths = lengths(rows, self.shape.r, self.shape.r, false)?;
        Ok(TangentSizes { memory: lengths.memory().saturating_add(2 * self.shape.r), work: 0 })
    }
}

/// Refuses a scene whose modes do not step by themselves.
fn check_uncoupled<T: Scalar>(scene: &Scene<'_, T>) -> Result<(), AdjointError> {
    check_exact(scene)?;
    if scene.is_coupled() { Err(AdjointError::Coupled) } else { Ok(()) }
}

impl<'m, 'f> CheckpointedMarch<'m, 'f> {
    /// A march of a parametric model with its modes at given values; rows are over its basis. Lends
    /// [`Parametric::adjoint_sizes`]. `O(m r)` for each row.
    ///
    /// # Errors
    /// [`AdjointError::Length`], [`AdjointError::Bind`]; [`AdjointError::Parametric`]: loss factors,
    /// dashpots.
    pub fn new(
        model: &Parametric<'f>,
        tuned: Tuned<'m>,
        rows: &MarchRows<'m>,
        memory: &'m mut [f64],
    ) -> Result<Self, AdjointError> {
        model.check_derivatives()?;
        let (m, r) = (tuned.eigenvalues.len(), model.n_basis());
        let lengths = lengths(rows, m, r, true)?;
        let mut lender = Lender::new(memory);
        let mut march = ModalMarch::new(lengths, rows.fields, &mut lender)?;
        let (eigenvalues, ratios) = (lender.take(m)?, lender.take(m)?);
        eigenvalues.iter_mut().zip(tuned.eigenvalues).for_each(|(to, from)| *to = *from);
        let own = model.file.section(SectionKind::DampingRatios).and_then(|own| own.numbers().ok());
        for (k, ratio) in ratios.iter_mut().enumerate() {
            *ratio = own.and_then(|own| own.get(k)).unwrap_or(0.0);
        }
        let padded = lengths.padded().max(1);
        for (out, rows) in march.rows_mut().into_iter().zip([rows.outputs, rows.loads]) {
            for (out, own) in out.chunks_exact_mut(padded).zip(rows.chunks_exact(r.max(1))) {
                out.iter_mut().zip(along(tuned.shapes, own)).for_each(|(to, from)| *to = from);
            }
        }
        march.find_near(eigenvalues, NEAR);
        let scales = model.scales(tuned.values);
        let (alpha, beta, time_step) = (scales.alpha, scales.beta, scales.time_step);
        let modes = Modes { eigenvalues, ratios, alpha, beta, time_step };
        Ok(Self { march, model: Some((*model, tuned)), scales: [1.0; 2], modes }.with_steps())
    }

    /// A march of the modes of a scene at its parameters; rows are over its modes
    /// ([`Scene::probe_row_into`], [`Scene::node_row_into`], [`Scene::pattern_row_into`]). Lends
    /// [`Scene::march_sizes`]. `O(r)` for each row.
    ///
    /// # Errors
    /// As [`Scene::march_sizes`]; [`AdjointError::Bind`].
    pub fn of_scene<T: Scalar>(
        scene: &Scene<'_, T>,
        rows: &MarchRows<'m>,
        memory: &'m mut [f64],
    ) -> Result<Self, AdjointError> {
        check_uncoupled(scene)?;
        let r = scene.shape.r;
        let lengths = lengths(rows, r, r, false)?;
        let mut lender = Lender::new(memory);
        let mut march = ModalMarch::new(lengths, rows.fields, &mut lender)?;
        let (eigenvalues, ratios) = (lender.take(r)?, lender.take(r)?);
        let StepParameters { time_step, alpha, beta, density, stiffness } = scene.parameters;
        let Stiffness::Diagonal(stored) = scene.sections.matrices.stiffness else {
            return Err(AdjointError::Structure { found: scene.structure() });
        };
        for (out, &lambda) in eigenvalues.iter_mut().zip(stored) {
            *out = f64::from_le_bytes(lambda) * stiffness / density;
        }
        let own = scene.sections.damping_ratios.unwrap_or(&[]).iter();
        ratios.fill(0.0);
        ratios.iter_mut().zip(own).for_each(|(out, &ratio)| *out = f64::from_le_bytes(ratio));
        let padded = lengths.padded().max(1);
        let scaled = [(rows.outputs, 1.0), (rows.loads, 1.0 / density)];
        for (out, (rows, scale)) in march.rows_mut().into_iter().zip(scaled) {
            for (out, own) in out.chunks_exact_mut(padded).zip(rows.chunks_exact(r.max(1))) {
                out.iter_mut().zip(own).for_each(|(to, from)| *to = scale * from);
            }
        }
        let modes = Modes { eigenvalues, ratios, alpha, beta, time_step };
        Ok(Self { march, model: None, scales: [stiffness, density], modes }.with_steps())
    }

    fn with_steps(mut self) -> Self {
        for k in 0..self.n_modes() {
            let step = step_of_ends(self.modes.damped().mode(k), self.modes.time_step);
            self.march.set_step(k, &step);
        }
        self
    }

    /// Number of modes.
    #[must_use]
    pub const fn n_modes(&self) -> usize {
        self.modes.eigenvalues.len()
    }

    /// Takes all steps. `start` are the coordinates of the modes and their rates, or empty for a body at
    /// rest; `loads` has the shape (steps, 2, loads), the amplitudes at the start and at the end of each
    /// step, between which they are linear; `outputs` the shape (steps, outputs), what the rows read after
    /// each.
    ///
    /// # Errors
    /// [`AdjointError::Length`], [`AdjointError::NotFinite`].
    pub fn march(
        &mut self,
        start: [&[f64]; 2],
        loads: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), AdjointError> {
        for found in start.map(<[f64]>::len) {
            let needed = self.n_modes();
            if found != needed && found != 0 {
                return Err(AdjointError::Length { found, needed });
            }
        }
        self.march.march(|k| start.map(|part| at(part, k)), loads, outputs)
    }

    /// Goes back over the march that was taken last, under the same loads, with the cotangents of its
    /// outputs, shape (steps, outputs). `of_loads` gets the gradient with respect to the amplitudes, shape
    /// (steps, 2, loads), or is empty.
    ///
    /// # Errors
    /// [`AdjointError::NoMarch`], [`AdjointError::Length`], [`AdjointError::NotFinite`].
    pub fn back(
        &mut self,
        loads: &[f64],
        cotangents: &[f64],
        of_loads: &mut [f64],
    ) -> Result<(), AdjointError> {
        self.march.back(loads, cotangents, of_loads)
    }

    /// Writes the gradient with respect to the coordinates of the modes at the start and to their rates;
    /// after [`CheckpointedMarch::back`].
    ///
    /// # Errors
    /// [`AdjointError::Length`]; [`AdjointError::NoMarch`] before that.
    pub fn initial_into(&self, zeta: &mut [f64], zeta_dot: &mut [f64]) -> Result<(), AdjointError> {
        self.march.check_gone_back()?;
        let needed = self.n_modes();
        for found in [zeta.len(), zeta_dot.len()] {
            if found != needed {
                return Err(AdjointError::Length { found, needed });
            }
        }
        for (k, (zeta, rate)) in zeta.iter_mut().zip(zeta_dot).enumerate() {
            [*zeta, *rate] = self.march.of_start(k);
        }
        Ok(())
    }

    /// Derivative of the scalar as the row of a load gains this row, over the basis of the model or the modes
    /// of the scene: with rows of nodes it gives the gradient with respect to the direction of a force, and
    /// to the weights of its place. After [`CheckpointedMarch::back`]. `O(m r)`.
    ///
    /// # Errors
    /// [`AdjointError::Length`]: a row of another length; [`AdjointError::NoLoad`]; [`AdjointError::NoMarch`]
    /// before that.
    pub fn of_load_row(&self, load: usize, gained: &[f64]) -> Result<f64, AdjointError> {
        self.march.check_gone_back()?;
        let needed = self.model.as_ref().map_or(self.n_modes(), |(model, _)| model.n_basis());
        let found = gained.len();
        if found != needed {
            return Err(AdjointError::Length { found, needed });
        }
        let count = self.march.lengths.loads;
        if load >= count {
            return Err(AdjointError::NoLoad { index: load, count });
        }
        let own = |k: usize| self.march.of_load(load, k);
        if let Some((_, tuned)) = &self.model {
            return Ok(along(tuned.shapes, gained).enumerate().map(|(k, x)| x * own(k)).sum());
        }
        let [_, density] = self.scales;
        Ok(gained.iter().enumerate().map(|(k, x)| x * own(k)).sum::<f64>() / density)
    }

    /// Writes the gradient with respect to each live parameter of the model, in their order, the motion at
    /// the start held along the basis; of a scene with respect to stiffness, density, `α`, `β` and `Δt`, the
    /// coordinates at the start held. After [`CheckpointedMarch::back`]. Lends the work of
    /// [`Parametric::adjoint_sizes`].
    ///
    /// # Errors
    /// [`AdjointError::Length`], [`AdjointError::Bind`]; [`AdjointError::NoMarch`] before that.
    pub fn parameters_into(&self, out: &mut [f64], work: &mut [f64]) -> Result<(), AdjointError> {
        self.march.check_gone_back()?;
        let needed = self.model.as_ref().map_or(5, |(model, _)| model.n_parameters());
        let found = out.len();
        if found != needed {
            return Err(AdjointError::Length { found, needed });
        }
        if let Some((model, tuned)) = &self.model {
            return self.of_model(model, tuned, out, work);
        }
        self.of_scales(out);
        Ok(())
    }

    /// Derivatives with respect to the eigenvalue of a mode, its damping following, and to its damping rate.
    fn of_mode(&self, k: usize, count: i32) -> [f64; 2] {
        let (damped, h) = (self.modes.damped(), self.modes.time_step);
        let (mode, mut halves) = (damped.mode(k), [0.0; HALVES]);
        steps_into(mode, h, count, &mut halves);
        let (own, sums) = ((mode, &halves[..]), self.march.sums(k));
        [[1.0, damped.rate(k, k)], [0.0, 1.0]]
            .map(|source| along_sums(&of_ends(&coupling(own, own, source, h, count), h), &sums))
    }

    /// `G : L` of two modes that are near each other.
    fn of_pair(&self, (i, j): (usize, usize), count: i32) -> f64 {
        let (damped, h) = (self.modes.damped(), self.modes.time_step);
        let [mut of_i, mut of_j] = [[0.0; HALVES]; 2];
        steps_into(damped.mode(i), h, count, &mut of_i);
        steps_into(damped.mode(j), h, count, &mut of_j);
        let source = [1.0, damped.rate(i, j)];
        let l = coupling((damped.mode(i), &of_i), (damped.mode(j), &of_j), source, h, count);
        along_sums(&of_ends(&l, h), &self.march.pair(i, j))
    }

    /// With respect to the time step: a longer one moves on by the rates at its end, and its loads rise
    /// slower.
    fn of_step(&self) -> f64 {
        let (damped, h) = (self.modes.damped(), self.modes.time_step);
        let of_mode = |k: usize| {
            let mode = damped.mode(k);
            let [q, v] = step_of_ends(mode, h);
            let [of_q, of_v] = self.march.sums(k);
            let mut sum = 0.0;
            for b in 0..4 {
                // Of the load at the end, and of its rise.
                let (load, rise) = ([0.0, 0.0, 0.0, 1.0][b], [0.0, 0.0, -1.0, 1.0][b] / h);
                sum += of_q[b] * (v[b] - q[3] * rise);
                sum += of_v[b] * (load - mode.lambda * q[b] - mode.damping * v[b] - v[3] * rise);
            }
            sum
        };
        (0..self.n_modes()).map(of_mode).sum()
    }

    fn of_scales(&self, out: &mut [f64]) {
        let (mut of_lambda, mut of_alpha, mut of_beta, mut of_density) = (0.0, 0.0, 0.0, 0.0);
        let count = self.modes.doublings();
        for (k, value) in self.modes.eigenvalues.iter().enumerate() {
            let [of_value, of_rate] = self.of_mode(k, count);
            of_lambda += of_value * value;
            of_alpha += of_rate;
            of_beta += of_rate * value;
            // Loads along the modes fall as the density rises.
            of_density -= self.march.load_sum(k, k);
        }
        let [stiffness, density] = self.scales;
        let all =
            [of_lambda / stiffness, (of_density - of_lambda) / density, of_alpha, of_beta, self.of_step()];
        out.iter_mut().zip(all).for_each(|(out, value)| *out = value);
    }

    fn of_model(
        &self,
        model: &Parametric<'_>,
        tuned: &Tuned<'_>,
        out: &mut [f64],
        work: &mut [f64],
    ) -> Result<(), AdjointError> {
        let m = self.n_modes();
        let mut lender = Lender::new(work);
        let mut take = || lender.take(m * m);
        let [of_stiffness, of_mass, stiffness, mass] = [take()?, take()?, take()?, take()?];
        let rates = lender.take(m)?;
        self.weights_into([of_stiffness, of_mass], rates);
        let work = lender.rest();
        for (index, (parameter, out)) in model.parameters().zip(out.iter_mut()).enumerate() {
            *out = match parameter.role {
                ParameterRole::Alpha => rates.iter().sum(),
                ParameterRole::Beta => dot(rates, self.modes.eigenvalues),
                ParameterRole::TimeStep => self.of_step(),
                _ => {
                    tuned.couplings_into(model, index, stiffness, mass, work)?;
                    dot(of_stiffness, stiffness) + dot(of_mass, mass)
                }
            };
        }
        Ok(())
    }

    /// Derivatives with respect to each `N_ij`, each `D_ij` and the damping rate of each mode.
    fn weights_into(&self, [of_stiffness, of_mass]: [&mut [f64]; 2], of_rates: &mut [f64]) {
        let (m, count) = (self.n_modes(), self.modes.doublings());
        let rows = of_stiffness.chunks_exact_mut(m.max(1)).zip(of_mass.chunks_exact_mut(m.max(1)));
        for ((i, (of_stiffness, of_mass)), of_rate) in rows.enumerate().zip(of_rates) {
            for (j, (of_stiffness, of_mass)) in of_stiffness.iter_mut().zip(of_mass).enumerate() {
                let gap = at(self.modes.eigenvalues, j) - at(self.modes.eigenvalues, i);
                if !self.march.is_near(i, j) {
                    (*of_stiffness, *of_mass) = (self.march.turn_sum(i, j) / gap, 0.0);
                    continue;
                }
                *of_mass = -self.march.load_sum(i, j);
                if i == j {
                    [*of_stiffness, *of_rate] = self.of_mode(i, count);
                } else {
                    *of_stiffness = self.of_pair((i, j), count);
                }
            }
        }
    }
}

/// `G : L`.
fn along_sums(l: &[[f64; 4]; 2], sums: &[[f64; 4]; 2]) -> f64 {
    l.as_flattened().iter().zip(sums.as_flattened()).map(|(l, g)| l * g).sum()
}
