//! A separated solution with fewer terms: the last go first (the build puts the strongest in front), as long
//! as the maps stay within a tolerance. A scene bound to the first terms of the whole file
//! (`SceneOptions::terms`) is the same scene.
//!
//! At a point of the axes the maps are `Σ_t g_t E_t` and `Σ_t g_t F_t` (increments of the state's and of the
//! loads' map). Leaving out the terms `D` changes them by `Σ_D g_t E_t`; its Frobenius norm over that of the
//! whole sum is the error, measured with Gram matrices at every point of the axes' grid, or at 4096 of them
//! chosen without pattern; the state's mode by mode, as the build's certificate has it.

use vademecum_format::{Codec, Element, File, Metadata, Section, SectionInput, SectionKind};

use super::codec::{check_total, decode, default_limit};
use super::error::RewriteError;
use super::numbers::decoded_of;
use super::whole::{whole, write_with};

/// Most terms a file may have here: the Gram matrices hold their square.
const MAX_TERMS: usize = 4096;
/// Most points of the axes' grid the error is measured at.
const MAX_POINTS: u64 = 4096;

/// Result of dropping terms.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct TermReduction {
    /// Terms before.
    pub before: usize,
    /// Terms left.
    pub left: usize,
    /// Relative error of the increments of the maps, root of the mean square over the points of the axes.
    pub error_rms: f64,
    /// The largest of them.
    pub error_max: f64,
}

/// The fewest first terms that keep the maps within a tolerance of those of all terms.
///
/// # Errors
/// [`RewriteError::Tolerance`]; [`RewriteError::NoTerms`] if the file has no block structure or every term is
/// needed; [`RewriteError::Format`], [`RewriteError::Unknown`], [`RewriteError::Frame`],
/// [`RewriteError::TooLarge`].
pub fn fewest_terms(bytes: &[u8], tolerance: f64) -> Result<TermReduction, RewriteError> {
    fewest_terms_limited(bytes, tolerance, default_limit(bytes.len()))
}

fn fewest_terms_limited(bytes: &[u8], tolerance: f64, limit: u64) -> Result<TermReduction, RewriteError> {
    if !(1e-12..=0.1).contains(&tolerance) {
        return Err(RewriteError::Tolerance { tolerance });
    }
    let file = whole(bytes)?;
    check_total(&file, of_terms, limit)?;
    let terms = file.metadata().n_terms as usize;
    if !file.metadata().block || !(2..=MAX_TERMS).contains(&terms) {
        return Err(RewriteError::NoTerms { terms });
    }
    let maps = Maps::new(&file)?;
    // Errors fall with the number kept but for luck; the half-open range begins at a number that is too
    // small.
    let (mut too_few, mut enough) = (0, terms);
    while too_few + 1 < enough {
        let middle = too_few.midpoint(enough);
        let sound = maps.error(middle).1 <= tolerance;
        *(if sound { &mut enough } else { &mut too_few }) = middle;
    }
    if enough == terms {
        return Err(RewriteError::NoTerms { terms });
    }
    let (error_rms, error_max) = maps.error(enough);
    Ok(TermReduction { before: terms, left: enough, error_rms, error_max })
}

/// The file with the [`fewest_terms`] for a tolerance. The error is added to the map errors of the block
/// structure's certificate; its other figures are set to "not measured", since nothing was marched.
///
/// # Errors
/// Those of [`fewest_terms`].
pub fn drop_terms(bytes: &[u8], tolerance: f64) -> Result<(Vec<u8>, TermReduction), RewriteError> {
    drop_terms_limited(bytes, tolerance, default_limit(bytes.len()))
}

/// [`drop_terms`] of a file whose sections with terms decode to `limit` bytes at most.
///
/// # Errors
/// Those of [`fewest_terms`].
pub fn drop_terms_limited(
    bytes: &[u8],
    tolerance: f64,
    limit: u64,
) -> Result<(Vec<u8>, TermReduction), RewriteError> {
    let dropped = fewest_terms_limited(bytes, tolerance, limit)?;
    Ok((without(&whole(bytes)?, &dropped)?, dropped))
}

/// Sections that have terms.
fn of_terms(kind: SectionKind) -> bool {
    use SectionKind as S;
    matches!(kind, S::BlockState | S::BlockLoad | S::PatternBlock | S::Factors)
}

/// Gram matrices of the terms' space parts, and the products of factors at points of the axes.
struct Maps {
    terms: usize,
    grams: Vec<Vec<f64>>,
    points: Vec<Vec<f64>>,
}

impl Maps {
    fn new(file: &File<'_>) -> Result<Self, RewriteError> {
        let metadata = file.metadata();
        let (terms, r) = (metadata.n_terms as usize, metadata.n_modes as usize);
        let factors = decoded_of(file, SectionKind::Factors)?.unwrap_or_default();
        let points = grid(metadata, &factors);
        let mut states = decoded_of(file, SectionKind::BlockState)?.unwrap_or_default();
        scale_modes(&mut states, r, &points);
        let mut grams = vec![gram(terms, r * r, &states)];
        if let Some(loads) = decoded_of(file, SectionKind::BlockLoad)? {
            grams.push(gram(terms, 3 * r, &loads));
        }
        Ok(Self { terms, grams, points })
    }

    /// Root of the mean square and largest error of leaving out all but the first terms.
    fn error(&self, kept: usize) -> (f64, f64) {
        let (mut sum, mut largest, mut count) = (0.0, 0.0f64, 0.0f64);
        for (g, gram) in self.points.iter().flat_map(|g| self.grams.iter().map(move |gram| (g, gram))) {
            let (off, of) = (self.form(gram, g, kept), self.form(gram, g, 0));
            if of > 0.0 {
                sum += off / of;
                largest = largest.max((off / of).sqrt());
                count += 1.0;
            }
        }
        ((sum / count.max(1.0)).sqrt(), largest)
    }

    /// `|Σ_t g_t X_t|²` over the terms from `first` on.
    fn form(&self, gram: &[f64], g: &[f64], first: usize) -> f64 {
        let own = |s: usize| gram[s * self.terms..][first..self.terms].iter();
        let row = |s: usize| g[s] * own(s).zip(&g[first..]).map(|(x, g)| x * g).sum::<f64>();
        (first..self.terms).map(row).sum::<f64>().max(0.0)
    }
}

/// Divides entry `(k, l)` of every `E_t` by `s_k s_l`, with `s_k²` the mean of `|E_kk|` over the points: `E`
/// spans the decades between the lowest and the highest mode, and every mode gets the tolerance, as in the
/// build.
fn scale_modes(states: &mut [f64], r: usize, points: &[Vec<f64>]) {
    let entry = |g: &[f64], k: usize| -> f64 {
        states.chunks_exact(r * r).zip(g).map(|(e, g)| g * e[k * r + k]).sum::<f64>().abs()
    };
    let mean = |k: usize| points.iter().map(|g| entry(g, k)).sum::<f64>() / points.len() as f64;
    let scales: Vec<f64> =
        (0..r).map(|k| mean(k).sqrt()).map(|s| if s > 0.0 { s.recip() } else { 0.0 }).collect();
    for (place, value) in states.iter_mut().enumerate() {
        *value *= scales[place / r % r] * scales[place % r];
    }
}

/// `X_s · X_t`; the numbers are `(any, terms, width)`.
fn gram(terms: usize, width: usize, numbers: &[f64]) -> Vec<f64> {
    let mut gram = vec![0.0; terms * terms];
    for parts in numbers.chunks_exact(terms * width) {
        for (s, a) in parts.chunks_exact(width).enumerate() {
            for (t, b) in parts.chunks_exact(width).enumerate().take(s + 1) {
                gram[s * terms + t] += a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            }
        }
    }
    for s in 0..terms {
        (0..s).for_each(|t| gram[t * terms + s] = gram[s * terms + t]);
    }
    gram
}

/// Products of factors of all terms at points of the grid.
fn grid(metadata: &Metadata<'_>, factors: &[f64]) -> Vec<Vec<f64>> {
    let terms = metadata.n_terms as usize;
    let counts: Vec<u64> = metadata.active_axes().iter().map(|axis| u64::from(axis.n_points)).collect();
    let all = counts.iter().fold(1u64, |all, &n| all.saturating_mul(n));
    // Steps of a golden section through the grid: no two points in a row are alike.
    let stride = if all > MAX_POINTS { (all as f64 * 0.618_033_988_75) as u64 | 1 } else { 1 };
    let product = |point: u64| {
        let mut place = point.wrapping_mul(stride) % all;
        let (mut start, mut g) = (0, vec![1.0; terms]);
        for &n in &counts {
            let (i, points) = ((place % n) as usize, n as usize);
            place /= n;
            g.iter_mut().enumerate().for_each(|(t, g)| *g *= factors[start + t * points + i]);
            start += terms * points;
        }
        g
    };
    (0..all.min(MAX_POINTS)).map(product).collect()
}

/// The file with its first terms only.
fn without(file: &File<'_>, dropped: &TermReduction) -> Result<Vec<u8>, RewriteError> {
    let mut metadata = *file.metadata();
    metadata.n_terms = dropped.left as u32;
    let block = &mut metadata.certificate.block;
    block.map_error_rms += dropped.error_rms;
    block.map_error_max += dropped.error_max;
    for figure in [
        &mut block.trajectory_error,
        &mut block.projection_floor,
        &mut block.spectral_radius,
        &mut block.energy_ratio,
        &mut block.steps,
    ] {
        *figure = f64::NAN;
    }
    let mut parts = vec![];
    // What was measured of all terms is not of these.
    for section in file.sections().filter(|section| section.kind() != SectionKind::StructureFigures) {
        let changed = selected(file.metadata(), &section, dropped.left)?;
        parts.push((section, changed));
    }
    let mut inputs = vec![];
    for (section, changed) in &parts {
        let mut input = SectionInput::from(*section);
        if let Some(bytes) = changed {
            let asked = input.kind.shape(&metadata);
            input.shape = [0, 1, 2].map(|i| asked[i].unwrap_or(input.shape[i]));
            input.codec = Codec::Raw;
            input.decoded_length = bytes.len() as u64;
            input.stored = bytes;
        }
        inputs.push(input);
    }
    write_with(&metadata, &inputs)
}

/// The decoded bytes of a section that has terms, with the first only; `None` if it has none.
fn selected(
    metadata: &Metadata<'_>,
    section: &Section<'_>,
    kept: usize,
) -> Result<Option<Vec<u8>>, RewriteError> {
    use SectionKind as S;
    let (r, terms) = (metadata.n_modes as usize, metadata.n_terms as usize);
    let size = section.element().size() as usize;
    let width = match section.kind() {
        S::BlockState => r * r,
        S::BlockLoad => 3 * r,
        S::PatternBlock => r,
        S::Factors => 0,
        _ => return Ok(None),
    };
    let raw = decode(section, u64::MAX)?; // held to the limit before
    if section.kind() == S::Factors {
        let mut rest = &raw[..];
        let mut left = vec![];
        for axis in metadata.active_axes() {
            let points = axis.n_points as usize;
            let (own, others) = rest.split_at(terms * points * size);
            left.extend(take(own, terms, points * size, kept));
            rest = others;
        }
        return Ok(Some(left));
    }
    if section.element() == Element::I16 {
        let scales = raw.len() - section.shape().iter().product::<u64>() as usize * size;
        let (scales, numbers) = raw.split_at(scales);
        return Ok(Some(
            [take(scales, terms, 4 * width, kept), take(numbers, terms, 2 * width, kept)].concat(),
        ));
    }
    Ok(Some(take(&raw, terms, width * size, kept)))
}

/// Of bytes `(any, terms, width)`, those of the first terms.
fn take(bytes: &[u8], terms: usize, width: usize, kept: usize) -> Vec<u8> {
    bytes.chunks_exact(terms * width).flat_map(|all| &all[..kept * width]).copied().collect()
}
