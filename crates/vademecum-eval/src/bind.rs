//! From a file to the numbers of a step: sections, parameters, and the fused maps of both structures.

use crate::axes::{Factors, StagePlace};
use crate::error::BindError;
use crate::kernel::{LANES, TILE};
use crate::options::{SceneOptions, Structure};
use crate::scalar::Scalar;
use crate::shape::Shape;
use vademecum_format::scheme::{
    MAX_STAGES, SchemeTable, StageCoefficients, StepParameters, fuse_into, fuse_work_len,
};
use vademecum_format::{File, Metadata, Numbers, SectionKind};

/// Sections a scene reads while it runs; `None` if absent or compressed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sections<'m> {
    pub surface: Option<Numbers<'m>>,
    pub interior: Option<Numbers<'m>>,
    pub block_load: Option<Numbers<'m>>,
    pub pattern_basis: Option<Numbers<'m>>,
    pub pattern_block: Option<Numbers<'m>>,
    pub probes: Option<Numbers<'m>>,
    /// `BᵀKB`: `(r)` for the diagonal structure, `(r, r)` for the block structure.
    pub stiffness: Numbers<'m>,
}

/// The file's parameters where the options leave them alone.
pub(crate) fn step_parameters(metadata: &Metadata<'_>, options: &SceneOptions) -> StepParameters {
    StepParameters {
        time_step: options.time_step.unwrap_or(metadata.time_step),
        alpha: options.alpha.unwrap_or(metadata.alpha),
        beta: options.beta.unwrap_or(metadata.beta),
        density: options.density,
        stiffness: options.stiffness,
    }
}

/// Looks the sections up; only the reduced stiffness must be there.
pub(crate) fn sections<'m>(
    file: &File<'m>,
    structure: Structure,
) -> Result<Sections<'m>, BindError> {
    use SectionKind as S;
    let optional = |kind| {
        file.section(kind)
            .and_then(|section| section.numbers().ok())
    };
    let kind = if structure == Structure::Diagonal {
        S::Eigenvalues
    } else {
        S::ReducedStiffness
    };
    Ok(Sections {
        surface: optional(S::SurfaceBasis),
        interior: optional(S::InteriorBasis),
        block_load: optional(S::BlockLoad),
        pattern_basis: optional(S::PatternBasis),
        pattern_block: optional(S::PatternBlock),
        probes: optional(S::ProbeRows),
        stiffness: Numbers::F64(needed(file, kind)?),
    })
}

/// Numbers of a section the file cannot be without.
fn needed<'m>(file: &File<'m>, kind: SectionKind) -> Result<&'m [[u8; 8]], BindError> {
    let missing = vademecum_format::FormatError::Missing {
        kind: kind.number(),
    };
    Ok(file.section(kind).ok_or(missing)?.f64s()?)
}

/// The 3×3 block and the load vectors of each mode: `E = −θλ/(1 + θλ)`, and `H = B/(1 + θλ)` goes into the load map.
pub(crate) fn fuse_modes<T: Scalar>(
    scheme: &SchemeTable,
    parameters: &StepParameters,
    lambdas: &Numbers<'_>,
    shape: Shape,
    map: &mut [T],
    load_maps: &mut [T],
) -> Result<(), BindError> {
    let mut theta = [0.0; MAX_STAGES];
    for (stage, theta) in theta.iter_mut().take(shape.n_stages).enumerate() {
        *theta = StageCoefficients::new(scheme, parameters, stage)?.theta;
    }
    let (mut d, mut loads, mut work) = ([0.0; 9], [0.0; 3 * MAX_STAGES], [0.0; fuse_work_len(1)]);
    for (k, lambda) in lambdas.iter().enumerate() {
        let e = theta.map(|theta| -theta * lambda / (1.0 + theta * lambda));
        let e = e.get(..shape.n_stages).unwrap_or_default();
        let loads = loads.get_mut(..3 * shape.n_stages).unwrap_or_default();
        fuse_into(scheme, parameters, 1, e, &mut d, loads, &mut work)?;
        for (place, &value) in d.iter().enumerate() {
            // Column-major 3×3 to row-major, one row of LANES modes per coefficient.
            let row_major = 3 * (place % 3) + place / 3;
            let at = (k / LANES * 9 + row_major) * LANES + k % LANES;
            map.iter_mut()
                .skip(at)
                .take(1)
                .for_each(|out| *out = T::from_f64(value));
        }
        for (place, &value) in loads.iter().enumerate() {
            let (stage, row) = (place / 3, place % 3);
            let h = value * (1.0 + e.get(stage).copied().unwrap_or_default());
            let at = stage * shape.load_map_len() + row * shape.stride() + k;
            load_maps
                .iter_mut()
                .skip(at)
                .take(1)
                .for_each(|out| *out = T::from_f64(h));
        }
    }
    Ok(())
}

/// Memory lent to [`fuse_block`].
pub(crate) struct Lent<'l, T> {
    pub map: &'l mut [T],
    pub load_maps: &'l mut [T],
    pub weights: &'l mut [T],
    pub work: &'l mut [f64],
}

/// The dense map: `E_i = Σ_t g_t E_t` at each stage's parameters, fused, rounded and laid out in tiles.
pub(crate) fn fuse_block<T: Scalar>(
    file: &File<'_>,
    parameters: &StepParameters,
    shape: Shape,
    lent: Lent<'_, T>,
) -> Result<(), BindError> {
    let metadata = file.metadata();
    let square = shape.r * shape.r;
    let factors = Factors {
        points: needed(file, SectionKind::AxisPoints)?,
        factors: needed(file, SectionKind::Factors)?,
    };
    let terms = needed(file, SectionKind::BlockState)?;
    let (e, rest) = lent
        .work
        .split_at_mut_checked(shape.n_stages * square)
        .unwrap_or_default();
    let (d, rest) = rest.split_at_mut_checked(9 * square).unwrap_or_default();
    let (loads, work) = rest
        .split_at_mut_checked(3 * shape.n_stages * square)
        .unwrap_or_default();
    e.fill(0.0);
    // `next` in the loop, not `zip`: zipped chunks divide by their sizes, and the compiler cannot see that they are not zero.
    let mut weights = lent.weights.chunks_exact_mut(shape.n_terms.max(1));
    for (stage, e) in e.chunks_exact_mut(square.max(1)).enumerate() {
        let weights = weights.next().unwrap_or_default();
        let theta = allowed_theta(metadata, parameters, stage)?;
        let place = StagePlace {
            stage,
            theta,
        };
        for (t, (term, out)) in terms.chunks_exact(square.max(1)).zip(weights).enumerate() {
            let weight = factors.weight(metadata, t, &place)?;
            *out = T::from_f64(weight);
            e.iter_mut()
                .zip(term)
                .for_each(|(e, &bytes)| *e += weight * f64::from_le_bytes(bytes));
        }
    }
    fuse_into(&metadata.scheme, parameters, shape.r, e, d, loads, work)?;
    lay_out(d, 3 * shape.r, lent.map);
    let mut load_maps = lent.load_maps.chunks_exact_mut(shape.load_map_len().max(1));
    for columns in loads.chunks_exact(square.saturating_mul(3).max(1)) {
        let out = load_maps.next().unwrap_or_default();
        lay_out(columns, 3 * shape.r, out);
    }
    Ok(())
}

/// `θ` of a stage, if the block structure was built for it: parameters without an axis must be the file's, up to rounding
/// (a few operations: 1e-12).
fn allowed_theta(
    metadata: &Metadata<'_>,
    asked: &StepParameters,
    stage: usize,
) -> Result<f64, BindError> {
    use vademecum_format::AxisRole as R;
    let requested = StageCoefficients::new(&metadata.scheme, asked, stage)?.theta;
    let reference = StepParameters {
        time_step: metadata.time_step,
        alpha: metadata.alpha,
        beta: metadata.beta,
        density: 1.0,
        stiffness: 1.0,
    };
    let built = StageCoefficients::new(&metadata.scheme, &reference, stage)?.theta;
    let carried = |role: R| matches!(role, R::Monomial { theta, .. } if theta != 0.0);
    if metadata.active_axes().iter().any(|axis| carried(axis.role)) || (requested - built).abs() <= 1e-12 * built {
        return Ok(requested);
    }
    Err(BindError::Fixed {
        stage,
        requested,
        built,
    })
}

/// Column-major `(rows, any)` to tiles of [`TILE`] rows, each tile column by column; the padding stays zero.
fn lay_out<T: Scalar>(columns: &[f64], rows: usize, tiles: &mut [T]) {
    let n_columns = columns.len() / rows.max(1);
    for (c, column) in columns.chunks_exact(rows.max(1)).enumerate() {
        for (tile, part) in column.chunks(TILE).enumerate() {
            let at = (tile * n_columns + c) * TILE;
            let place = tiles.iter_mut().skip(at).zip(part);
            place.for_each(|(out, &value)| *out = T::from_f64(value));
        }
    }
}
