//! The golden files: small files of format versions 1.0 and 1.1 made from numbers alone, the same bytes on every machine with IEEE 754
//! arithmetic. No logarithm, power or cosine is taken on the way: libraries round those differently; `+ − × ÷ √` they do not.

use crate::regions::TwoRegions;
use crate::synthetic::{Body, Layout, bathe, newmark};
use vademecum_build::rewrite::{Keep, strip};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Codec, Element, File, SectionInput, SectionKind, encode_into, encoded_len};

const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 2, r: 3 };
const STEP: StepParameters =
    StepParameters { time_step: 1e-3, alpha: 0.5, beta: 1e-6, density: 1.0, stiffness: 1.0 };

/// A closed basis with eigenvalues that are written here, not computed.
fn body(seed: u64) -> Body {
    let mut body = Body::closed(LAYOUT, seed);
    body.lambda = vec![900.0, 40_000.0, 2_500_000.0];
    body
}

/// A raw section.
fn raw(
    kind: SectionKind,
    element: Element,
    required: bool,
    shape: [u64; 3],
    stored: &[u8],
) -> SectionInput<'_> {
    let decoded_length = stored.len() as u64;
    SectionInput { kind, element, codec: Codec::Raw, required, shape, decoded_length, stored }
}

/// A file with two sections more, of numbers written here: a history of the enrichment and samples of the spectral radius.
fn with_separation(bytes: &[u8]) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let history = [[1.0, 0.25], [2.0, 0.0625], [27.0, 1e-7]];
    let radii = [[0.5, 0.5, 0.5, 0.5, 0.75], [2.0, 2.0, 2.0, 2.0, 0.9375]];
    let little = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let (history, radii) = (little(history.as_flattened()), little(radii.as_flattened()));
    let mut sections: Vec<SectionInput<'_>> = vec![];
    for s in file.sections() {
        sections.push(raw(s.kind(), s.element(), s.is_required(), s.shape(), s.stored()));
    }
    sections.push(raw(SectionKind::EnrichmentHistory, Element::F64, false, [3, 2, 1], &history));
    sections.push(raw(SectionKind::RadiusSamples, Element::F64, false, [2, 5, 1], &radii));
    let mut out = vec![0; encoded_len(file.metadata(), &sections).expect("a length")];
    encode_into(file.metadata(), &sections, &mut out).expect("written");
    out
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
        ("separation.vdm", with_separation(&parameters)),
        ("parameters.vdm", parameters),
        ("probes.vdm", probes),
    ]
}
