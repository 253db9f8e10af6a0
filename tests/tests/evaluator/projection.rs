//! Is "solve at full order, project with `BᵀM`" stable for every basis? The statements of
//! `docs/explanation/4-basis.md`, tested.
//!
//! With the mass projection a stage is the Galerkin stage of the stiffness `X(θ) = (C(θ)⁻¹ − I)/θ`, symmetric
//! and positive. One θ for all stages: one oscillator per eigenvector of `X`, stable as the scheme is. Two θ
//! (Bathe): two stiffnesses that need not commute, and there the search below finds steps that grow by up to
//! 1.1e-7.

use proptest::prelude::*;
use vademecum_build::Matrix;
use vademecum_build::certificate::{Figures, StructureReport};
use vademecum_build::dynamics::SchemeKind;
use vademecum_build::fem::{Pencil, Symbolic};
use vademecum_build::report::CertificateReport;
use vademecum_build::response::StageResponse;
use vademecum_format::StructureCertificate;
use vademecum_format::scheme::{SchemeTable, StepParameters, theta};
use vademecum_tests::fused::fused_radius;
use vademecum_tests::synthetic::Random;

/// The most the search finds for Bathe, less one.
const BATHE_EXCESS: f64 = 1.0993789e-7;

/// Frequencies times Δt the random pencils hold. Beyond, eigenvalues of the step near 1 and −1 lie so close
/// together that rounding hides what is asked.
const OMEGA: (f64, f64) = (1e-2, 1e2);

/// What rounding may do to a radius there: an error ε of the map moves eigenvalues that lie Ω (near 1) or 1/Ω
/// (near −1) apart by ε/Ω and εΩ, each times the map's few dozen entries and the condition of its
/// eigenvectors, again up to 1/Ω and Ω.
const ROUNDING: f64 = 100.0 * f64::EPSILON * OMEGA.1 * OMEGA.1;

fn table(scheme: SchemeKind) -> SchemeTable {
    scheme.table().expect("a scheme in its range")
}

fn at(time_step: f64, alpha: f64, beta: f64) -> StepParameters {
    StepParameters { time_step, alpha, beta, density: 1.0, stiffness: 1.0 }
}

/// Schemes all of whose stages have one θ: ρ∞-Bathe's default splitting makes them equal.
fn one_theta() -> Vec<SchemeKind> {
    use SchemeKind as S;
    let mut all = vec![
        S::Newmark { beta: 0.25, gamma: 0.5 },
        S::Newmark { beta: 0.4, gamma: 0.7 },
        S::HhtAlpha { alpha: -0.1 },
        S::HhtAlpha { alpha: -1.0 / 3.0 },
    ];
    for rho_infinity in [0.0, 0.5, 1.0] {
        all.extend([S::RhoBathe { rho_infinity }, S::GeneralizedAlpha { rho_infinity }]);
    }
    all
}

/// A pencil of random SPD matrices with given `Ω = ωΔt`, and a random M-orthonormal basis of it.
#[derive(Debug)]
struct Body {
    pencil: Pencil,
    basis: Matrix,
}

/// Orthonormal columns, `(n, columns)`.
fn orthonormal(n: usize, columns: usize, random: &mut Random) -> Matrix {
    let noise = Matrix::from_fn(n, columns, |_, _| random.number());
    noise.qr().compute_thin_Q()
}

impl Body {
    /// `M = G Gᵀ`, `K = G Q diag(ω²) Qᵀ Gᵀ`, `B = G⁻ᵀ W` with `G` lower triangular, `Q` orthogonal and `W`
    /// orthonormal.
    fn random(omega: &[f64], modes: usize, seed: u64) -> Self {
        let (n, mut random) = (omega.len(), Random::new(seed));
        let g = Matrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => 1.0 + 0.5 * random.number(),
            std::cmp::Ordering::Greater => 0.5 * random.number(),
        });
        let q = orthonormal(n, n, &mut random);
        let spectrum = Matrix::from_fn(n, n, |i, j| if i == j { omega[i] * omega[i] } else { 0.0 });
        let mass = &g * g.transpose();
        let half = &g * &q;
        let stiffness = &half * &spectrum * half.transpose();
        let mut basis = orthonormal(n, modes, &mut random);
        // Back substitution with Gᵀ.
        for j in 0..modes {
            for i in (0..n).rev() {
                let known: f64 = (i + 1..n).map(|k| g[(k, i)] * basis[(k, j)]).sum();
                basis[(i, j)] = (basis[(i, j)] - known) / g[(i, i)];
            }
        }
        Self { pencil: pencil(&mass, &stiffness), basis }
    }

    fn responses(&self, table: &SchemeTable, step: &StepParameters) -> Vec<Matrix> {
        let symbolic = Symbolic::analyze(&self.pencil).expect("a pattern");
        let stage = |i| {
            let theta = theta(table, step, i).expect("a sound scheme");
            StageResponse::solve(&self.pencil, &symbolic, self.basis.as_ref(), theta).expect("definite").state
        };
        (0..table.active().len()).map(stage).collect()
    }

    /// Spectral radius of the block step, less one.
    fn excess(&self, scheme: SchemeKind, step: &StepParameters) -> f64 {
        let table = table(scheme);
        fused_radius(&table, step, &self.responses(&table, step)).expect("fused") - 1.0
    }
}

/// Exactly symmetric, lower triangle mirrored.
fn pencil(mass: &Matrix, stiffness: &Matrix) -> Pencil {
    let triplets = |a: &Matrix| -> Vec<(u32, u32, f64)> {
        let n = a.nrows();
        (0..n * n)
            .map(|k| (k / n, k % n))
            .map(|(i, j)| (i as u32, j as u32, a[(i.max(j), i.min(j))]))
            .collect()
    };
    Pencil::from_triplets(mass.nrows(), &triplets(mass), &triplets(stiffness)).expect("symmetric")
}

prop_compose! {
    /// Frequencies, number of modes, seed.
    fn body()(n in 2usize..8)(
        omega in prop::collection::vec(OMEGA.0.ln()..OMEGA.1.ln(), n),
        modes in 1..=n,
        seed in any::<u64>(),
    ) -> (usize, Body) {
        let omega: Vec<f64> = omega.into_iter().map(f64::exp).collect();
        (modes, Body::random(&omega, modes, seed))
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn schemes_of_one_theta_are_stable_on_any_basis(
        (_, body) in body(),
        damped in any::<bool>(),
        share in 0.0..1.0f64,
    ) {
        let step = if damped { at(1.0, share, 1.0 - share) } else { at(1.0, 0.0, 0.0) };
        for scheme in one_theta() {
            let excess = body.excess(scheme, &step);
            prop_assert!(excess <= ROUNDING, "{scheme}: 1 + {excess:e}");
        }
    }

    #[test]
    fn bathe_is_stable_on_one_mode_and_nearly_so_on_any_basis((modes, body) in body()) {
        let excess = body.excess(SchemeKind::Bathe {}, &at(1.0, 0.0, 0.0));
        let allowed = if modes == 1 { ROUNDING } else { BATHE_EXCESS + ROUNDING };
        prop_assert!(excess <= allowed, "{modes} modes: 1 + {excess:e}");
    }

    #[test]
    fn galerkin_stages_are_stable_with_every_scheme((_, body) in body()) {
        let mut image = Matrix::zeros(body.basis.nrows(), body.basis.ncols());
        body.pencil.stiffness().mul_into(body.basis.as_ref(), image.as_mut());
        let stiffness = body.basis.transpose() * image;
        let step = at(1.0, 0.0, 0.0);
        for scheme in one_theta().into_iter().chain([SchemeKind::Bathe {}]) {
            let table = table(scheme);
            let stage = |i| {
                let theta = theta(&table, &step, i).expect("a sound scheme");
                StageResponse::galerkin(body.basis.as_ref(), stiffness.as_ref(), theta).state
            };
            let states: Vec<Matrix> = (0..table.active().len()).map(stage).collect();
            let excess = fused_radius(&table, &step, &states).expect("fused") - 1.0;
            prop_assert!(excess <= ROUNDING, "{scheme}: 1 + {excess:e}");
        }
    }
}

/// Two stage stiffnesses of two modes: `X₂ = diag(Ω₁², Ω₂²)` and `X₁ = X₂ + 7/9 τ X₂^½ q qᵀ X₂^½`,
/// `q = (cos φ, sin φ)`. Every such pair is that of a pencil and a basis (docs/explanation/4-basis.md).
#[derive(Clone, Copy, Debug)]
struct Pair {
    omega: [f64; 2],
    phi: f64,
    tau: f64,
}

impl Pair {
    /// `E = (I + θX)⁻¹ − I` of both stages at Δt = 1.
    fn excess(&self) -> f64 {
        let ([a, b], [c, s]) = (self.omega, [self.phi.cos(), self.phi.sin()]);
        let k = 7.0 / 9.0 * self.tau;
        let first = [a * a * (1.0 + k * c * c), k * a * b * c * s, b * b * (1.0 + k * s * s)];
        let states = [increment(1.0 / 16.0, first), increment(1.0 / 9.0, [a * a, 0.0, b * b])];
        fused_radius(&table(SchemeKind::Bathe {}), &at(1.0, 0.0, 0.0), &states).expect("fused") - 1.0
    }
}

/// `(I + θX)⁻¹ − I` of a symmetric 2 × 2 matrix given by its lower triangle.
fn increment(theta: f64, [x, y, z]: [f64; 3]) -> Matrix {
    let (x, y, z) = (theta * x, theta * y, theta * z);
    let determinant = (1.0 + x) * (1.0 + z) - y * y;
    // −θX (I + θX)⁻¹, entry by entry.
    let entries = [-(x * (1.0 + z) - y * y), -y, -y, -(z * (1.0 + x) - y * y)];
    Matrix::from_fn(2, 2, |i, j| entries[2 * i + j] / determinant)
}

#[test]
fn search_finds_steps_that_grow_and_none_that_grows_faster() {
    let mut random = Random::new(5);
    let mut best = f64::NEG_INFINITY;
    for _ in 0..12 {
        let mut draw = || 10f64.powf(2.0 * random.number());
        let mut pair = Pair { omega: [0.1 * draw(), draw()], phi: 3.0 * random.number(), tau: 1.0 };
        let (mut excess, mut width) = (pair.excess(), 0.5);
        for _ in 0..3000 {
            let omega = pair.omega.map(|o| o * (width * random.number()).exp());
            let tau = (pair.tau + width * random.number()).clamp(0.0, 1.0);
            let moved = Pair { omega, phi: pair.phi + width * random.number(), tau };
            let found = moved.excess();
            if found > excess {
                (pair, excess, width) = (moved, found, (1.5 * width).min(1.0));
            } else {
                width = (0.98 * width).max(1e-6);
            }
        }
        if excess > best {
            best = excess;
            println!("1 + {excess:.7e} at {pair:?}");
        }
    }
    // Digits of the radius: eigenvalues of a 6 × 6 map of size 1.
    assert!((best - BATHE_EXCESS).abs() < 1e-13, "{best:e}");
}

/// The pair found, as three dofs with unit masses and a basis of the first two: with `d` large the third dof
/// is stiff, and `X(θ) = S + P/(1 + θd)`.
fn counterexample() -> Body {
    let (omega, phi, tau, d) = ([0.0745_f64, 10.46], 1.2808_f64, 0.999, 1e5);
    let q = [phi.cos(), phi.sin()];
    let soft = |i: usize, j: usize| omega[i] * omega[j] * (f64::from(i == j) - tau * q[i] * q[j]);
    let g = |i: usize| (d * (1.0 + d / 9.0) * tau).sqrt() * omega[i] * q[i];
    let stiffness = Matrix::from_fn(3, 3, |i, j| match (i, j) {
        (2, 2) => d,
        (2, k) | (k, 2) => g(k),
        _ => soft(i, j) + g(i) * g(j) / d,
    });
    let unit = |n: usize, r: usize| Matrix::from_fn(n, r, |i, j| f64::from(i == j));
    Body { pencil: pencil(&unit(3, 3), &stiffness), basis: unit(3, 2) }
}

#[test]
fn the_certificate_refuses_the_counterexample_and_other_schemes_take_it() {
    let (body, step) = (counterexample(), at(1.0, 0.0, 0.0));
    let excess = body.excess(SchemeKind::Bathe {}, &step);
    println!("Bathe: 1 + {excess:e}");
    assert!(excess > 1e-7, "{excess:e}");
    for scheme in one_theta() {
        let excess = body.excess(scheme, &step);
        // The stiff eigenvalue, 1.2e6, is far outside `OMEGA`; the digits it takes are those of the entries.
        assert!(excess <= f64::EPSILON * 1.2e6, "{scheme}: 1 + {excess:e}");
    }
    // All else perfect, and the energy of a short run shows nothing.
    let certificate = |spectral_radius| {
        let measured = StructureCertificate {
            trajectory_error: 1e-4,
            projection_floor: 1e-4,
            spectral_radius,
            energy_ratio: 1.0,
            map_error_rms: 0.0,
            map_error_max: 0.0,
            steps: 500.0,
        };
        let block = Some(StructureReport::new(&measured, &Figures::default()));
        CertificateReport {
            diagonal: None,
            block,
            chapter: None,
            large: false,
            parametric: false,
            floor_ratio: 1.1,
            absolute: 1e-6,
            error: 5e-2,
            map: 1e-6,
        }
    };
    assert!(certificate(1.0).holds());
    assert!(!certificate(1.0 + excess).holds());
}
