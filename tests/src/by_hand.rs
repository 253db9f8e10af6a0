//! The published two-dof problem as a file of numbers worked out by hand: M = diag(2, 1), K = [6 −2; −2 4], R
//! = (0, 10), so λ = 2 and 5 with the modes (1, 1)/√3 and (1, −2)/√6. Nothing of the builder is in it.

use vademecum_format::scheme::{SchemeTable, StepParameters, theta};
use vademecum_format::{
    Axis, Certificate, Element, MAX_AXES, MAX_PARAMETERS, Metadata, Parameter, SectionKind,
};

use crate::synthetic::{encode, stage_axis};

/// One node whose x and y are the two dofs, with both structures; its one load pattern is R.
///
/// # Panics
/// If the scheme has no `θ` or the writer refuses the file.
#[must_use]
pub fn file(scheme: &SchemeTable, dt: f64) -> Vec<u8> {
    let (a, b) = (1.0 / 3f64.sqrt(), 1.0 / 6f64.sqrt());
    let lambda = [2.0, 5.0];
    let step = StepParameters { time_step: dt, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let n = scheme.active().len();
    let thetas: Vec<f64> = (0..n).map(|i| theta(scheme, &step, i).expect("theta")).collect();
    let load = [10.0 * a, -20.0 * b];
    let h = |theta: f64, k: usize| -theta * lambda[k] / (1.0 + theta * lambda[k]);
    let state: Vec<f64> = thetas.iter().flat_map(|&t| [h(t, 0), 0.0, 0.0, h(t, 1)]).collect();
    let pattern: Vec<f64> = thetas.iter().flat_map(|&t| [h(t, 0) * load[0], h(t, 1) * load[1]]).collect();
    let identity: Vec<f64> = (0..n * n).map(|i| f64::from(u8::from(i / n == i % n))).collect();
    let points: Vec<f64> = (0..n).map(|i| i as f64).collect();
    let basis = [a, b, a, -2.0 * b, 0.0, 0.0];
    let f64s = |kind, numbers: &[f64]| {
        (kind, Element::F64, numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    };
    use SectionKind as S;
    let contents = [
        f64s(S::ReducedStiffness, &[2.0, 0.0, 0.0, 5.0]),
        f64s(S::Eigenvalues, &lambda),
        f64s(S::SurfaceBasis, &basis),
        f64s(S::BlockState, &state),
        f64s(S::PatternBasis, &load),
        f64s(S::PatternBlock, &pattern),
        f64s(S::AxisPoints, &points),
        f64s(S::Factors, &identity),
    ];
    let mut axes = [Axis::UNUSED; MAX_AXES];
    axes[0] = stage_axis(n)[0];
    let metadata = Metadata {
        program: "two dofs",
        problem: "",
        units: "",
        mesh_hash: [0; 16],
        n_nodes: 1,
        n_surface_nodes: 1,
        n_load_nodes: 1,
        n_triangles: 0,
        n_load_triangles: 0,
        n_modes: 2,
        n_patterns: 1,
        n_probes: 0,
        scheme_name: "by hand",
        scheme: *scheme,
        time_step: dt,
        alpha: 0.0,
        beta: 0.0,
        n_regions: 1,
        n_parameters: 0,
        parameters: [Parameter::UNUSED; MAX_PARAMETERS],
        axes,
        n_axes: 1,
        n_terms: n as u32,
        diagonal: true,
        block: true,
        certificate: Certificate::default(),
    };
    encode(&metadata, &contents)
}
