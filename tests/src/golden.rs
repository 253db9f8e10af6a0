//! The golden files: small files of format version 1 made from numbers alone, the same bytes on every machine with IEEE 754
//! arithmetic. No logarithm, power or cosine is taken on the way: libraries round those differently; `+ − × ÷ √` they do not.

use crate::regions::TwoRegions;
use crate::synthetic::{Body, Layout, bathe, newmark};
use vademecum_build::rewrite::{Keep, strip};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Codec, Element, File, Section, SectionInput, SectionKind, encode_into, encoded_len};

const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 2, r: 3 };
const STEP: StepParameters =
    StepParameters { time_step: 1e-3, alpha: 0.5, beta: 1e-6, density: 1.0, stiffness: 1.0 };

/// A closed basis with eigenvalues that are written here, not computed.
fn body(seed: u64) -> Body {
    let mut body = Body::closed(LAYOUT, seed);
    body.lambda = vec![900.0, 40_000.0, 2_500_000.0];
    body
}

/// Name and bytes of every golden file.
///
/// # Panics
/// If the writer refuses one.
#[must_use]
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    let fixed = body(1).file(&bathe(), &STEP, Element::F64);
    let probes = strip(&fixed, Keep::Probes).expect("a file with probes");
    let undamped = StepParameters { alpha: 0.0, beta: 0.0, ..STEP };
    // θ of both stages at the file's Δt = 10⁻³ (Δt²/16 and Δt²/9) lies within the range of the first axis.
    let common = [2e-8, 1e-7, 3e-7];
    let parameters =
        TwoRegions::new(1).separated(&bathe(), &undamped, &common, &[0.5, 1.0, 2.0], &[0.5, 1.25, 2.0]);
    vec![
        ("fixed-f64.vdm", fixed),
        ("fixed-f32.vdm", body(2).file(&newmark(0.25, 0.5), &STEP, Element::F32)),
        ("parameters.vdm", parameters),
        ("probes.vdm", probes),
        ("quantised.vdm", quantised(&body(3).file(&bathe(), &STEP, Element::F64))),
    ]
}

/// The file with its space sections as 16-bit numbers, each column with a scale of its own. Scales have few bits, so every operation is exact but
/// for one division, and rounding half away from zero is the same everywhere.
fn quantised(bytes: &[u8]) -> Vec<u8> {
    use SectionKind as S;
    let file = File::parse(bytes).expect("a file");
    let space = |kind| matches!(kind, S::SurfaceBasis | S::InteriorBasis | S::BlockLoad);
    let stored: Vec<Vec<u8>> =
        file.sections().map(|s| if space(s.kind()) { quantise(&s) } else { s.stored().to_vec() }).collect();
    let inputs: Vec<SectionInput<'_>> = file
        .sections()
        .zip(&stored)
        .map(|(s, stored)| SectionInput {
            kind: s.kind(),
            element: if space(s.kind()) { Element::I16 } else { s.element() },
            codec: Codec::Raw,
            required: s.is_required(),
            shape: s.shape(),
            decoded_length: stored.len() as u64,
            stored,
        })
        .collect();
    let mut out = vec![0; encoded_len(file.metadata(), &inputs).expect("a length")];
    encode_into(file.metadata(), &inputs, &mut out).expect("written");
    out
}

fn quantise(section: &Section<'_>) -> Vec<u8> {
    let columns = (section.shape()[1] * section.shape()[2]) as usize;
    let scale = |column: usize| (4 + column % 3) as f32 / 65_536.0;
    let values = section.numbers().expect("numbers");
    let number = |(i, value): (usize, f64)| (value / f64::from(scale(i % columns))).round() as i16;
    let scales = (0..columns).flat_map(|column| scale(column).to_le_bytes());
    scales.chain(values.iter().enumerate().flat_map(|(i, x)| number((i, x)).to_le_bytes())).collect()
}
