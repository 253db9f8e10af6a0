//! From a file to the numbers of a step: sections, parameters, and the fused maps of the diagonal and the
//! block structure.
//!
//! Everything is fused in `f64` in lent work memory first and laid out in the scene afterwards, so that a
//! refusal leaves a bound scene as it was.

use crate::base::error::BindError;
use crate::base::lend::{Lender, Short, put};
use crate::base::options::{RegionScales, SceneOptions, Structure};
use crate::base::scalar::Scalar;
use crate::kernels::kernel::{LANES, TILE};
use crate::kernels::strain::numbers::StrainSections;
use crate::scene::coupled::step_of;
use crate::scene::equation::{Matrices, Stiffness};
use crate::scene::shape::Shape;
use crate::sections::axes::{Axes, StagePlace};
use crate::sections::factor::Factor;
use crate::sections::residual::Residual;
use crate::sections::rows::Rows;
use crate::sections::stress_rows::StressRows;
use crate::sections::supports::Supports;
use vademecum_format::coupled::{CoupledModes, CoupledResponses};
use vademecum_format::exact::{Propagator, product_error};
use vademecum_format::scheme::{
    MAX_STAGES, StageCoefficients, StepParameters, TableError, fuse_into, fuse_work_len,
};
use vademecum_format::{File, FormatError, MAX_REGIONS, Metadata, Numbers, ParameterRole, SectionKind};

/// Sections a scene reads while it runs; `None` if absent or compressed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sections<'m> {
    /// Rows of the basis.
    pub rows: Rows<'m>,
    /// The reduced matrices.
    pub matrices: Matrices<'m>,
    pub block_load: Option<Numbers<'m>>,
    pub pattern_basis: Option<Numbers<'m>>,
    pub pattern_block: Option<Numbers<'m>>,
    /// `ζ_k` beside Rayleigh's, for exact steps.
    pub damping_ratios: Option<&'m [[u8; 8]]>,
    /// Rows of dashpots that couple modes, for exact steps.
    pub damping_rows: Option<&'m [[u8; 8]]>,
    /// The residual flexibility.
    pub residual: Residual<'m>,
    /// The reactions of the supports.
    pub supports: Supports<'m>,
    /// Centre about which a moving base turns.
    pub base: Option<&'m [[u8; 8]]>,
    /// The factor of the stiffness.
    pub factor: Factor<'m>,
    /// Mass and moments of a free body.
    pub rigid_body: Option<&'m [[u8; 8]]>,
    /// Rows of the stress.
    pub stress: StressRows<'m>,
    /// The separated solution of the block structure; empty for the diagonal one.
    pub separated: Separated<'m>,
    /// The strain map; empty for the other structures.
    pub strain: StrainSections<'m>,
}

/// `E_t`, points and factors as the file stores them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Separated<'m> {
    pub terms: &'m [[u8; 8]],
    pub points: &'m [[u8; 8]],
    pub factors: &'m [[u8; 8]],
}

/// The parameters that a scene is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Asked {
    pub step: StepParameters,
    pub regions: RegionScales,
}

impl Asked {
    /// The file's parameters where the options leave them alone.
    pub fn new(metadata: &Metadata<'_>, options: &SceneOptions) -> Self {
        let step = StepParameters {
            time_step: options.time_step.unwrap_or(metadata.time_step),
            alpha: options.alpha.unwrap_or(metadata.alpha),
            beta: options.beta.unwrap_or(metadata.beta),
            density: options.density,
            stiffness: options.stiffness,
        };
        Self { step, regions: options.regions }
    }

    /// Refuses parameters of which the precision cannot hold what a step makes.
    fn check<T: Scalar>(&self) -> Result<(), BindError> {
        let StepParameters { time_step, alpha, beta, density, stiffness } = self.step;
        let most = T::LARGEST.to_f64();
        let least = most.recip();
        let bounds = [(time_step, least), (alpha, 0.0), (beta, 0.0), (density, least), (stiffness, least)];
        for (index, (value, least)) in bounds.into_iter().enumerate() {
            if !(least..=most).contains(&value) {
                return Err(TableError::BadParameter { index, value }.into());
            }
        }
        Ok(())
    }

    /// Every region's scales, as the roles of the parameters that move them.
    fn scales(&self) -> impl Iterator<Item = (ParameterRole, f64)> {
        use ParameterRole as R;
        let stiffness =
            (0..).zip(self.regions.stiffness()).map(|(region, &x)| (R::RegionStiffness { region }, x));
        stiffness
            .chain((0..).zip(self.regions.density()).map(|(region, &x)| (R::RegionDensity { region }, x)))
    }
}

/// Looks the sections up; only the reduced stiffness and the separated solution must be there.
pub(crate) fn sections<'m>(file: &File<'m>, structure: Structure) -> Result<Sections<'m>, BindError> {
    use SectionKind as S;
    let optional = |kind| file.section(kind).and_then(|section| section.numbers().ok());
    let (stiffness, separated) = match structure {
        Structure::Diagonal | Structure::Exact => {
            (Stiffness::Diagonal(needed(file, S::Eigenvalues)?), Separated::default())
        }
        Structure::Strain => (Stiffness::Diagonal(&[]), Separated::default()),
        Structure::Block => (
            Stiffness::Dense(needed(file, S::ReducedStiffness)?),
            Separated {
                terms: needed(file, S::BlockState)?,
                points: needed(file, S::AxisPoints)?,
                factors: needed(file, S::Factors)?,
            },
        ),
    };
    let strain = match structure {
        Structure::Strain => StrainSections::of(file)?,
        _ => StrainSections::default(),
    };
    Ok(Sections {
        strain,
        rows: Rows::of(file),
        matrices: matrices(file, stiffness),
        block_load: optional(S::BlockLoad),
        pattern_basis: optional(S::PatternBasis),
        pattern_block: optional(S::PatternBlock),
        residual: Residual::of(file),
        supports: Supports::of(file),
        base: file.section(S::BaseFrame).and_then(|section| section.f64s().ok()),
        factor: Factor::of(file),
        rigid_body: file.section(S::RigidBody).and_then(|section| section.f64s().ok()),
        stress: StressRows::of(file),
        damping_ratios: file.section(S::DampingRatios).map(|section| section.f64s()).transpose()?,
        damping_rows: file.section(S::DampingRows).map(|section| section.f64s()).transpose()?,
        separated,
    })
}

/// The reduced matrices of a file beside its stiffness.
pub(crate) fn matrices<'m>(file: &File<'m>, stiffness: Stiffness<'m>) -> Matrices<'m> {
    let optional = |kind| file.section(kind).and_then(|section| section.f64s().ok());
    Matrices {
        stiffness,
        n_regions: file.metadata().n_regions as usize,
        region_stiffness: optional(SectionKind::RegionStiffness),
        region_mass: optional(SectionKind::RegionMass),
    }
}

/// Numbers of a section the file cannot be without.
pub(crate) fn needed<'m>(file: &File<'m>, kind: SectionKind) -> Result<&'m [[u8; 8]], BindError> {
    Ok(file.section(kind).ok_or(missing(kind))?.f64s()?)
}

fn missing(kind: SectionKind) -> FormatError {
    FormatError::Missing { kind: kind.number() }
}

/// A fused step in `f64`, not yet laid out.
pub(crate) struct Fused<'w> {
    /// `D`: `(3r, 3r)` column-major, or nine numbers a mode, column-major.
    d: &'w [f64],
    /// Load maps, stage by stage `(3r, r)` column-major, or `(n_stages, 3)` a mode.
    loads: &'w [f64],
    /// `(n_stages, n_terms)`: the terms' weights.
    weights: &'w [f64],
}

/// Fuses the step a scene is asked for. `work` has the length [`Shape::work_len`].
pub(crate) fn fuse<'w, T: Scalar>(
    metadata: &Metadata<'_>,
    sections: &Sections<'_>,
    asked: &Asked,
    shape: Shape,
    work: &'w mut [f64],
) -> Result<Fused<'w>, BindError> {
    asked.check::<T>()?;
    let fused = match shape.structure() {
        Structure::Diagonal => fuse_modes(metadata, sections, asked, shape, work)?,
        Structure::Exact if shape.is_coupled() => fuse_coupled(sections, asked, shape, work)?,
        Structure::Exact => fuse_exact(sections, asked, shape, work)?,
        Structure::Block => fuse_block(metadata, sections, asked, shape, work)?,
        // The strain structure has no map of its state.
        Structure::Strain => Fused { d: &[], loads: &[], weights: &[] },
    };
    let mut all = fused.d.iter().chain(fused.loads).chain(fused.weights);
    if all.any(|&value| !T::from_f64(value).to_f64().is_finite()) {
        return Err(BindError::NotFinite);
    }
    Ok(fused)
}

/// The 3×3 block and the load vectors of each mode: `E = −θλ/(1 + θλ)`, and `H = B/(1 + θλ)` goes into the
/// load map.
fn fuse_modes<'w>(
    metadata: &Metadata<'_>,
    sections: &Sections<'_>,
    asked: &Asked,
    shape: Shape,
    work: &'w mut [f64],
) -> Result<Fused<'w>, BindError> {
    let scheme = &metadata.scheme;
    let mut theta = [0.0; MAX_STAGES];
    for (stage, theta) in theta.iter_mut().take(shape.n_stages).enumerate() {
        *theta = StageCoefficients::new(scheme, &asked.step, stage)?.theta;
    }
    let mut work = Lender::new(work);
    let (d, loads) = (work.take(9 * shape.r)?, work.take(3 * shape.n_stages * shape.r)?);
    let mut small = [0.0; fuse_work_len(1)];
    let per_mode = shape.n_stages.saturating_mul(3).max(1);
    // `next` in the loops, not `zip`: zipped chunks divide by their sizes, and the compiler cannot see that
    // they are not zero. For its sake, too, chunk sizes are saturated products.
    let (mut blocks, mut load_vectors) = (d.chunks_exact_mut(9), loads.chunks_exact_mut(per_mode));
    let Stiffness::Diagonal(lambdas) = sections.matrices.stiffness else {
        return Err(missing(SectionKind::Eigenvalues).into());
    };
    for &lambda in lambdas {
        let lambda = f64::from_le_bytes(lambda);
        let (Some(d), Some(loads)) = (blocks.next(), load_vectors.next()) else {
            return Err(Short { found: shape.r, needed: lambdas.len() }.into());
        };
        let e = theta.map(|theta| -theta * lambda / (1.0 + theta * lambda));
        let e = Lender::new(&e[..]).take(shape.n_stages)?;
        fuse_into(scheme, &asked.step, 1, e, d, loads, &mut small)?;
        for (loads, e) in loads.chunks_exact_mut(3).zip(e) {
            loads.iter_mut().for_each(|value| *value *= 1.0 + e);
        }
    }
    Ok(Fused { d, loads, weights: &[] })
}

/// The 2×2 block of each mode, and its answers to the parts of a load that grows from its start to its end:
/// `P₀ − P₁` and `P₁`.
fn fuse_exact<'w>(
    sections: &Sections<'_>,
    asked: &Asked,
    shape: Shape,
    work: &'w mut [f64],
) -> Result<Fused<'w>, BindError> {
    let StepParameters { time_step, density, .. } = asked.step;
    let mut work = Lender::new(work);
    let (d, loads) = (work.take(4 * shape.r)?, work.take(4 * shape.r)?);
    let blocks = d.as_chunks_mut().0.iter_mut().zip(loads.as_chunks_mut().0);
    for ([lambda, sigma], (d, loads)) in modes(sections, asked)?.zip(blocks) {
        let mode = Propagator::new(lambda, sigma, time_step);
        // Column by column, as the other structures have it.
        *d = [mode.d[0], mode.d[2], mode.d[1], mode.d[3]];
        let [held, rising] = [mode.held, mode.rising].map(|p| p.map(|p| p / density));
        *loads = [held[0] - rising[0], held[1] - rising[1], rising[0], rising[1]];
    }
    Ok(Fused { d, loads, weights: &[] })
}

/// Stiffness `λ` \[rad²/s²\] and decay `σ` \[1/s\] of each mode, without what couples modes.
fn modes<'m>(
    sections: &Sections<'m>,
    asked: &Asked,
) -> Result<impl Iterator<Item = [f64; 2]> + use<'m>, BindError> {
    let StepParameters { alpha, beta, density, stiffness, .. } = asked.step;
    asked.step.check()?;
    let Stiffness::Diagonal(lambdas) = sections.matrices.stiffness else {
        return Err(missing(SectionKind::Eigenvalues).into());
    };
    let mut ratios = sections.damping_ratios.unwrap_or(&[]).iter();
    Ok(lambdas.iter().map(move |&lambda| {
        let lambda = f64::from_le_bytes(lambda) * stiffness / density;
        let ratio = ratios.next().map_or(0.0, |&ratio| f64::from_le_bytes(ratio));
        [lambda, 0.5 * (alpha + beta * lambda) + ratio * libm::sqrt(lambda)]
    }))
}

/// The dense map of modes that dashpots couple, and their answers to the parts of a load as above.
fn fuse_coupled<'w>(
    sections: &Sections<'_>,
    asked: &Asked,
    shape: Shape,
    work: &'w mut [f64],
) -> Result<Fused<'w>, BindError> {
    let StepParameters { time_step, density, .. } = asked.step;
    let Some(stored) = sections.damping_rows else {
        return Err(missing(SectionKind::DampingRows).into());
    };
    let (r, square) = (shape.r, shape.r.saturating_mul(shape.r));
    let mut work = Lender::new(work);
    let d = work.take(square.saturating_mul(4))?;
    let [impulse, step, ramp] = [work.take(square)?, work.take(square)?, work.take(square)?];
    let (w2, own) = (work.take(r)?, work.take(r)?);
    let rows = work.take(shape.damping_rows.saturating_mul(r))?;
    for (([lambda, sigma], w2), own) in modes(sections, asked)?.zip(&mut *w2).zip(&mut *own) {
        *w2 = lambda * time_step * time_step;
        *own = 2.0 * sigma * time_step;
    }
    // A dashpot stays the same where the density changes.
    let scale = libm::sqrt(time_step / density);
    rows.iter_mut().zip(stored).for_each(|(row, &d)| *row = scale * f64::from_le_bytes(d));
    let rest = work.rest();
    let coupled = CoupledModes { stiffness: w2, own, rows };
    let out = CoupledResponses { impulse: &mut *impulse, step: &mut *step, ramp: &mut *ramp };
    coupled.respond(out, rest).ok_or(BindError::NotFinite)?;
    let loads = Lender::new(rest).take(square.saturating_mul(4))?;
    let responses = [&*impulse, &*step, &*ramp];
    step_of(&coupled, responses, time_step * time_step / density, [&mut *d, &mut *loads])?;
    Ok(Fused { d, loads, weights: &[] })
}

/// The dense map: `E_i = Σ_t g_t E_t` at each stage's place on the axes, fused.
fn fuse_block<'w>(
    metadata: &Metadata<'_>,
    sections: &Sections<'_>,
    asked: &Asked,
    shape: Shape,
    work: &'w mut [f64],
) -> Result<Fused<'w>, BindError> {
    check_moved(metadata, sections, asked)?;
    let (square, n_stages) = (shape.r * shape.r, shape.n_stages);
    let mut work = Lender::new(work);
    let (d, loads) = (work.take(9 * square)?, work.take(3 * n_stages * square)?);
    let (weights, e) = (work.take(shape.weights_len())?, work.take(n_stages * square)?);
    let (axes, work) = (work.take(Axes::WORK * shape.n_points)?, work.rest());
    stage_responses(metadata, sections, asked, shape, weights, e, axes)?;
    fuse_into(&metadata.scheme, &asked.step, shape.r, e, d, loads, work)?;
    Ok(Fused { d, loads, weights })
}

/// `E_i = Σ_t g_t E_t` at each stage's place on the axes, `(n_stages, r, r)`, and the weights `g_t`,
/// `(n_stages, n_terms)`.
fn stage_responses(
    metadata: &Metadata<'_>,
    sections: &Sections<'_>,
    asked: &Asked,
    shape: Shape,
    weights: &mut [f64],
    e: &mut [f64],
    axes: &mut [f64],
) -> Result<(), BindError> {
    let square = shape.r * shape.r;
    let Separated { terms, points, factors } = sections.separated;
    let mut axes = Axes::new(metadata, points, axes)?;
    e.fill(0.0);
    let mut stages = Lender::new(weights);
    let short = Short { found: terms.len(), needed: shape.n_terms.saturating_mul(square) };
    for (stage, e) in e.chunks_exact_mut(square.max(1)).enumerate() {
        let weights = stages.take(shape.n_terms)?;
        let theta = allowed_theta(metadata, &asked.step, stage)?;
        let place = StagePlace {
            stage,
            theta,
            stiffness: asked.regions.stiffness(),
            density: asked.regions.density(),
        };
        axes.stand(metadata, &place)?;
        axes.term_weights(metadata, factors, weights)?;
        let mut terms = terms.chunks_exact(square.max(1));
        for &weight in &*weights {
            let term = terms.next().ok_or(short)?;
            if weight != 0.0 {
                e.iter_mut().zip(term).for_each(|(e, &bytes)| *e += weight * f64::from_le_bytes(bytes));
            }
        }
    }
    Ok(())
}

/// Scales of regions: positive, and moved only where the file has a parameter and an axis for it.
fn check_moved(metadata: &Metadata<'_>, sections: &Sections<'_>, asked: &Asked) -> Result<(), BindError> {
    use ParameterRole as R;
    for (role, value) in asked.scales().filter(|&(_, value)| value != 1.0) {
        if !(value > 0.0 && value.in_range()) {
            return Err(BindError::BadScale { role, value });
        }
        let declared = metadata.active_parameters().iter().any(|p| p.role == role);
        if !declared || !on_an_axis(metadata, role) {
            return Err(BindError::FixedRegion { role, value });
        }
        let (section, kind) = match role {
            R::RegionStiffness { .. } => (sections.matrices.region_stiffness, SectionKind::RegionStiffness),
            _ => (sections.matrices.region_mass, SectionKind::RegionMass),
        };
        section.ok_or(missing(kind))?;
    }
    Ok(())
}

/// `true` if the coordinate of some axis depends on what this parameter moves: a region's scale, or `θ`.
fn on_an_axis(metadata: &Metadata<'_>, role: ParameterRole) -> bool {
    use ParameterRole as R;
    use vademecum_format::AxisRole as A;
    let at = |exponents: &[f64; MAX_REGIONS], region: u32| {
        exponents.get(region as usize).is_some_and(|&e| e != 0.0)
    };
    metadata.active_axes().iter().any(|axis| match (&axis.role, role) {
        (A::Monomial { stiffness, .. }, R::RegionStiffness { region }) => at(stiffness, region),
        (A::Monomial { density, .. }, R::RegionDensity { region }) => at(density, region),
        (A::Monomial { theta, .. }, _) => *theta != 0.0,
        _ => false,
    })
}

/// `θ` of a stage, if the block structure was built for it: without a parameter that moves `θ` and an axis
/// that carries it, `θ` must be the file's, up to rounding (a few operations: 1e-12).
fn allowed_theta(metadata: &Metadata<'_>, asked: &StepParameters, stage: usize) -> Result<f64, BindError> {
    use ParameterRole as R;
    let requested = StageCoefficients::new(&metadata.scheme, asked, stage)?.theta;
    let built = StepParameters {
        time_step: metadata.time_step,
        alpha: metadata.alpha,
        beta: metadata.beta,
        density: 1.0,
        stiffness: 1.0,
    };
    let built = StageCoefficients::new(&metadata.scheme, &built, stage)?.theta;
    let uniform = |role: R| !matches!(role, R::RegionStiffness { .. } | R::RegionDensity { .. });
    let mut moves = metadata.active_parameters().iter().filter(|p| uniform(p.role));
    let carried = moves.any(|p| on_an_axis(metadata, p.role));
    if carried || (requested - built).abs() <= 1e-12 * built {
        return Ok(requested);
    }
    Err(BindError::Fixed { stage, requested, built })
}

/// Rounds a fused step and puts it where the kernels want it; padding is left alone.
pub(crate) fn lay_out<T: Scalar>(
    fused: &Fused<'_>,
    shape: Shape,
    map: &mut [T],
    load_maps: &mut [T],
    weights: &mut [T],
) -> Result<(), Short> {
    match shape.structure() {
        Structure::Diagonal => lay_out_modes::<T, 3>(fused, shape, map, load_maps),
        Structure::Exact if shape.is_coupled() => {
            lay_out_dense(fused, shape, map, load_maps)?;
            contract_coupled(shape, map)
        }
        Structure::Exact => {
            lay_out_modes::<T, 2>(fused, shape, map, load_maps)?;
            contract(map);
            Ok(())
        }
        Structure::Strain => Ok(()),
        Structure::Block => {
            lay_out_dense(fused, shape, map, load_maps)?;
            let weights = Lender::new(weights).take(fused.weights.len())?;
            weights.iter_mut().zip(fused.weights).for_each(|(out, &value)| *out = T::from_f64(value));
            Ok(())
        }
    }
}

/// A dense step and its load maps, column-major, to tiles.
fn lay_out_dense<T: Scalar>(
    fused: &Fused<'_>,
    shape: Shape,
    map: &mut [T],
    load_maps: &mut [T],
) -> Result<(), Short> {
    let rows = shape.columns();
    lay_out_columns(fused.d, rows, map)?;
    let (mut columns, mut load_maps) = (Lender::new(fused.loads), Lender::new(load_maps));
    for _ in 0..shape.n_stages {
        let columns = columns.take(rows.saturating_mul(shape.r))?;
        lay_out_columns(columns, rows, load_maps.take(shape.load_map_len())?)?;
    }
    Ok(())
}

/// Column-major N×N to row-major, one row of [`LANES`] modes per coefficient; load vectors like a state.
fn lay_out_modes<T: Scalar, const N: usize>(
    fused: &Fused<'_>,
    shape: Shape,
    map: &mut [T],
    load_maps: &mut [T],
) -> Result<(), Short> {
    for (k, d) in fused.d.chunks_exact(N * N).enumerate() {
        for (entry, &value) in d.iter().enumerate() {
            put(map, place_in_modes::<N>(k, entry % N, entry / N), T::from_f64(value))?;
        }
    }
    for (k, loads) in fused.loads.chunks_exact(shape.n_stages.saturating_mul(N).max(1)).enumerate() {
        for (place, &value) in loads.iter().enumerate() {
            let (stage, row) = (place / N, place % N);
            let at = stage * shape.load_map_len() + row * shape.stride() + k;
            put(load_maps, at, T::from_f64(value))?;
        }
    }
    Ok(())
}

/// Makes the step of every mode one that does not grow: rounding its coefficients can leave the determinant
/// of `I + D` a little above 1, and an undamped mode would then gain energy for ever. The two coefficients
/// beside the diagonal are moved by a few units in their last place, so that the determinant comes as near to
/// 1 from below as their numbers allow. The trace, which is the frequency, stays.
fn contract<T: Scalar>(map: &mut [T]) {
    for block in map.as_chunks_mut::<LANES>().0.as_chunks_mut::<2>().0.as_chunks_mut::<2>().0 {
        let [[d11, d12], [d21, d22]] = block;
        for k in 0..LANES {
            [d11[k], d12[k], d21[k], d22[k]] = contracted([d11[k], d12[k], d21[k], d22[k]]);
        }
    }
}

/// The same of the block that each mode has on the diagonal of a step of coupled modes: one that the dashpots
/// leave alone gains no energy. A mode that they brake loses more than rounding gives.
fn contract_coupled<T: Scalar>(shape: Shape, map: &mut [T]) -> Result<(), Short> {
    let r = shape.r;
    for k in 0..r {
        let places = [(k, k), (k, r + k), (r + k, k), (r + k, r + k)];
        let places = places.map(|(row, column)| place_in_tiles(row, column, shape.columns()));
        let block = places.map(|at| map.get(at).copied().unwrap_or(T::ZERO));
        for (at, value) in places.into_iter().zip(contracted(block)) {
            put(map, at, value)?;
        }
    }
    Ok(())
}

/// The step of one mode that does not grow.
fn contracted<T: Scalar>(mut block: [T; 4]) -> [T; 4] {
    let d = block.map(T::to_f64);
    let excess = growth(d);
    // Damping takes more than rounding gives.
    if excess <= -64.0 * T::EPSILON || excess.is_nan() {
        return block;
    }
    let [_, b, c, _] = nearest_to_one::<T>(d);
    (block[1], block[2]) = (T::from_f64(b), T::from_f64(c));
    // Near half a turn the two have no leverage; there the diagonal gives way.
    for push in 0..16 {
        let d = block.map(T::to_f64);
        let excess = growth(d);
        if excess <= 0.0 {
            break;
        }
        block[0] = T::from_f64(d[0] - 1.05 * excess * f64::from(1u16 << push) / (1.0 + d[3]));
    }
    block
}

/// A 2×2 `D` whose numbers beside the diagonal are moved by at most sixteen units in the last place of `T`,
/// so that `det(I + D)` is the largest that is not above 1; as it is, where they do not reach.
fn nearest_to_one<T: Scalar>(d: [f64; 4]) -> [f64; 4] {
    const UNITS: i8 = 16;
    // A unit of a number between powers of two, and of 1 for zero.
    let unit = |x: f64| {
        let power = f64::from_bits(x.to_bits() & f64::INFINITY.to_bits());
        if power == 0.0 { T::EPSILON } else { 2.0 * power * T::EPSILON }
    };
    let ([a, b, c, e], excess) = (d, growth(d));
    let (unit_b, unit_c) = (unit(b), unit(c));
    // What a unit of each does to the determinant.
    let (by_b, by_c) = (-c * unit_b, -b * unit_c);
    let (mut best, mut least) = (d, f64::INFINITY);
    for n in -UNITS..=UNITS {
        let wanted = -(excess + f64::from(n) * by_b);
        let ratio = wanted / by_c;
        // Rounded down or up, so that no more than what is wanted is taken away; zero for one out of reach.
        let cut = f64::from(ratio as i32);
        let m = match by_c > 0.0 {
            true if cut > ratio => cut - 1.0,
            false if cut < ratio => cut + 1.0,
            _ => cut,
        };
        let left = wanted - m * by_c;
        if left < least && ratio.abs() < 1e3 && m.abs() <= f64::from(UNITS) {
            let moved = [a, b + f64::from(n) * unit_b, c + m * unit_c, e];
            if growth(moved) <= 0.0 {
                (best, least) = (moved, left);
            }
        }
    }
    best
}

/// `det(I + D) − 1` of a 2×2 `D`, to twice the digits of its numbers.
fn growth([a, b, c, d]: [f64; 4]) -> f64 {
    let (kept, turned) = (a * d, b * c);
    let terms = [a, d, kept, -turned, product_error(a, d), -product_error(b, c)];
    let (mut sum, mut lost) = (0.0f64, 0.0);
    for term in terms {
        let next = sum + term;
        lost += if sum.abs() >= term.abs() { (sum - next) + term } else { (term - next) + sum };
        sum = next;
    }
    sum + lost
}

/// Index at which the kernels want number `(row, column)` of the N×N block of mode `k`.
pub(crate) const fn place_in_modes<const N: usize>(k: usize, row: usize, column: usize) -> usize {
    (k / LANES * N * N + N * row + column) * LANES + k % LANES
}

/// Index at which the dense kernel wants number `(row, column)` of a matrix of `n_columns`.
pub(crate) const fn place_in_tiles(row: usize, column: usize, n_columns: usize) -> usize {
    (row / TILE * n_columns + column) * TILE + row % TILE
}

/// Column-major `(rows, any)` to tiles of [`TILE`] rows, each tile column by column.
fn lay_out_columns<T: Scalar>(columns: &[f64], rows: usize, tiles: &mut [T]) -> Result<(), Short> {
    let n_columns = columns.len() / rows.max(1);
    for (c, column) in columns.chunks_exact(rows.max(1)).enumerate() {
        for (tile, part) in column.chunks(TILE).enumerate() {
            let at = place_in_tiles(tile * TILE, c, n_columns);
            let short = Short { found: tiles.len(), needed: at.saturating_add(part.len()) };
            let place = tiles.get_mut(at..at.saturating_add(part.len())).ok_or(short)?.iter_mut().zip(part);
            place.for_each(|(out, &value)| *out = T::from_f64(value));
        }
    }
    Ok(())
}
