//! The golden files: small files of format version 1 made from numbers alone, the same bytes on every machine with IEEE 754
//! arithmetic. No logarithm, power or cosine is taken on the way: libraries round those differently; `+ − × ÷ √` they do not.

use crate::canonical::Terms;
use crate::regions::TwoRegions;
use crate::synthetic::{Body, Layout, bathe, newmark};
use vademecum_build::rewrite::{Keep, strip};
use vademecum_format::Element;
use vademecum_format::scheme::StepParameters;

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
    let canonical = crate::canonical::file(&body(1), &bathe(), &undamped, &[0, 2, 5], Terms::Apart);
    vec![
        ("canonical.vdm", canonical),
        ("fixed-f64.vdm", fixed),
        ("fixed-f32.vdm", body(2).file(&newmark(0.25, 0.5), &STEP, Element::F32)),
        ("parameters.vdm", parameters),
        ("probes.vdm", probes),
    ]
}
