//! A small body of two regions whose every answer is a dense solve: `M = ρ_0 M_0 + ρ_1 M_1`,
//! `K = κ_0 K_0 + κ_1 K_1` on a few dozen dofs, nominal mass the identity. Its separated file is exact at the
//! nodes of a tensor grid: one term per grid point, with Lagrange's cardinal functions as factors.

use crate::synthetic::{Layout, Random, encode, orthonormal};
use vademecum_format::scheme::{SchemeTable, StepParameters, theta};
use vademecum_format::{
    Axis, AxisKind, AxisRole, Certificate, Element, MAX_AXES, MAX_PARAMETERS, MAX_REGIONS, Metadata,
    Parameter, ParameterRole, SectionKind,
};

/// Grid of nodes: 3 by 3 on the surface, two rows loadable, three interior.
pub const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: 4 };
/// Dofs.
pub const N: usize = 36;
/// Modes.
pub const R: usize = 4;

/// The two regions' scales.
#[derive(Clone, Copy, Debug)]
pub struct Scales {
    /// `κ_q`.
    pub stiffness: [f64; 2],
    /// `ρ_q`.
    pub density: [f64; 2],
}

/// Both regions as built.
pub const NOMINAL: Scales = Scales { stiffness: [1.0; 2], density: [1.0; 2] };

/// The body.
pub struct TwoRegions {
    /// `(N, R)`, orthonormal.
    pub basis: Vec<f64>,
    /// Diagonals of `M_q`.
    pub mass: [Vec<f64>; 2],
    /// `(N, N)`: `K_q`.
    pub stiffness: [Vec<f64>; 2],
}

/// `E` of one place, `(R, R)`, and `H − B`, `(N, R)`.
pub struct Response {
    /// `E = BᵀM_0 (M + θK)⁻¹ M B − I`, `M_0` the nominal mass: row, then column.
    pub state: Vec<f64>,
    /// `(M + θK)⁻¹ M_0 B − B`.
    pub load: Vec<f64>,
}

/// One term of a separated file: where it stands (`θ`, scales) and what its factors are.
struct Term {
    response: Response,
    /// Per axis, the grid point at which the factor is one.
    points: Vec<usize>,
}

/// Solves `a x = b` for the columns of `b`, by elimination with pivots.
#[must_use]
pub fn solve(mut a: Vec<f64>, mut b: Vec<f64>, n: usize) -> Vec<f64> {
    let columns = b.len() / n;
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())).expect("rows");
        (0..n).for_each(|j| a.swap(k * n + j, pivot * n + j));
        (0..columns).for_each(|j| b.swap(k * columns + j, pivot * columns + j));
        for i in (0..n).filter(|&i| i != k) {
            let share = a[i * n + k] / a[k * n + k];
            (k..n).for_each(|j| a[i * n + j] -= share * a[k * n + j]);
            (0..columns).for_each(|j| b[i * columns + j] -= share * b[k * columns + j]);
        }
    }
    (0..n * columns).map(|i| b[i] / a[i / columns * n + i / columns]).collect()
}

impl TwoRegions {
    /// From a seed. The regions overlap in a third of the dofs; natural frequencies from about 20 to 400
    /// rad/s.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let share = |i: usize| (1.5 - 3.0 * i as f64 / N as f64 + 0.5).clamp(0.0, 1.0);
        let mass = [(0..N).map(share).collect(), (0..N).map(|i| 1.0 - share(i)).collect()];
        let stiffness = [true, false].map(|first| {
            // Gᵀ diag(share of the region) G with a diagonally dominant G.
            let mut k = vec![0.0; N * N];
            for row in 0..N {
                let weight = if first { share(row) } else { 1.0 - share(row) };
                let mut g: Vec<f64> = random.numbers(N).iter().map(|x| 3.0 * x).collect();
                g[row] += 20.0 + 10.0 * row as f64;
                (0..N * N).for_each(|ij| k[ij] += weight * g[ij / N] * g[ij % N]);
            }
            k
        });
        let basis = orthonormal(N, R, |k| {
            let mut column: Vec<f64> = random.numbers(N).iter().map(|x| 0.3 * x).collect();
            column[k * N / R] += 1.0;
            column
        });
        Self { basis, mass, stiffness }
    }

    /// `E` and `H − B` by one dense solve.
    #[must_use]
    pub fn response(&self, theta: f64, scales: &Scales) -> Response {
        let mass = |i: usize| scales.density[0] * self.mass[0][i] + scales.density[1] * self.mass[1][i];
        let a = (0..N * N)
            .map(|ij| {
                let k =
                    scales.stiffness[0] * self.stiffness[0][ij] + scales.stiffness[1] * self.stiffness[1][ij];
                theta * k + if ij / N == ij % N { mass(ij / N) } else { 0.0 }
            })
            .collect();
        // Right sides: M B, then B.
        let right: Vec<f64> = (0..N * 2 * R)
            .map(|i| {
                let (row, column) = (i / (2 * R), i % (2 * R));
                let b = self.basis[row * R + column % R];
                if column < R { mass(row) * b } else { b }
            })
            .collect();
        let x = solve(a, right, N);
        let state = (0..R * R)
            .map(|ij| {
                let (i, j) = (ij / R, ij % R);
                let c: f64 = (0..N).map(|n| self.basis[n * R + i] * x[n * 2 * R + j]).sum();
                c - f64::from(u8::from(i == j))
            })
            .collect();
        let load = (0..N * R).map(|i| x[i / R * 2 * R + R + i % R] - self.basis[i]).collect();
        Response { state, load }
    }

    /// `BᵀK_qB` of both regions, one after the other.
    #[must_use]
    pub fn reduced_stiffness(&self) -> Vec<f64> {
        let entry = |q: usize, i: usize, j: usize| -> f64 {
            (0..N * N)
                .map(|ab| self.basis[ab / N * R + i] * self.stiffness[q][ab] * self.basis[ab % N * R + j])
                .sum()
        };
        (0..2 * R * R).map(|qij| entry(qij / (R * R), qij / R % R, qij % R)).collect()
    }

    /// `BᵀM_qB` of both regions, one after the other.
    #[must_use]
    pub fn reduced_mass(&self) -> Vec<f64> {
        let entry = |q: usize, i: usize, j: usize| -> f64 {
            (0..N).map(|n| self.basis[n * R + i] * self.mass[q][n] * self.basis[n * R + j]).sum()
        };
        (0..2 * R * R).map(|qij| entry(qij / (R * R), qij / R % R, qij % R)).collect()
    }

    /// A file for these scales and nothing else: one term per stage.
    #[must_use]
    pub fn fixed(&self, scheme: &SchemeTable, step: &StepParameters, scales: &Scales) -> Vec<u8> {
        let n_stages = scheme.active().len();
        let terms: Vec<Term> = (0..n_stages)
            .map(|i| {
                let response = self.response(theta(scheme, step, i).expect("scheme"), scales);
                Term { response, points: vec![i] }
            })
            .collect();
        let axis = crate::synthetic::stage_axis(n_stages)[0];
        let points: Vec<f64> = (0..n_stages).map(|i| i as f64).collect();
        self.file(scheme, step, &[(axis, points)], &[], &terms)
    }

    /// A file over `θ √(κ_0 κ_1)`, `√(κ_0/κ_1)` and, with `density` points, `ρ_1`; exact at the points. Its
    /// parameters are named `soft` (`κ_0`), `hard` (`κ_1`), `dense` (`ρ_1`, if it has points) and `step`
    /// (`Δt`).
    #[must_use]
    pub fn separated(
        &self,
        scheme: &SchemeTable,
        step: &StepParameters,
        common: &[f64],
        contrast: &[f64],
        density: &[f64],
    ) -> Vec<u8> {
        let exponents = |a: f64, b: f64| [a, b, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let axis = |name, log, role, points: &[f64]| {
            let (lower, upper) = (points[0], points[points.len() - 1]);
            let n_points = points.len() as u32;
            let axis = Axis { name, unit: "", role, kind: AxisKind::Chebyshev, log, lower, upper, n_points };
            (axis, points.to_vec())
        };
        let monomial = |theta, stiffness, density| AxisRole::Monomial { theta, stiffness, density };
        let none = [0.0; MAX_REGIONS];
        let mut axes = vec![
            axis("common", true, monomial(1.0, exponents(0.5, 0.5), none), common),
            axis("contrast", true, monomial(0.0, exponents(0.5, -0.5), none), contrast),
        ];
        let parameter = |name, role, lower, upper, nominal| Parameter {
            name,
            unit: "",
            role,
            log: true,
            lower,
            upper,
            nominal,
        };
        let mut parameters = vec![
            parameter("soft", ParameterRole::RegionStiffness { region: 0 }, 0.5, 2.0, 1.0),
            parameter("hard", ParameterRole::RegionStiffness { region: 1 }, 0.5, 2.0, 1.0),
            parameter(
                "step",
                ParameterRole::TimeStep,
                0.5 * step.time_step,
                2.0 * step.time_step,
                step.time_step,
            ),
        ];
        if !density.is_empty() {
            axes.push(axis("density", false, monomial(0.0, none, exponents(0.0, 1.0)), density));
            parameters.push(parameter("dense", ParameterRole::RegionDensity { region: 1 }, 0.5, 2.0, 1.0));
        }
        let one = [1.0];
        let densities = if density.is_empty() { &one[..] } else { density };
        let mut terms = Vec::new();
        for (i, &c) in common.iter().enumerate() {
            for (j, &s) in contrast.iter().enumerate() {
                for (k, &rho) in densities.iter().enumerate() {
                    let scales = Scales { stiffness: [s, 1.0 / s], density: [1.0, rho] };
                    terms.push(Term { response: self.response(c, &scales), points: vec![i, j, k] });
                }
            }
        }
        self.file(scheme, step, &axes, &parameters, &terms)
    }

    fn file(
        &self,
        scheme: &SchemeTable,
        step: &StepParameters,
        axes: &[(Axis<'_>, Vec<f64>)],
        parameters: &[Parameter<'_>],
        terms: &[Term],
    ) -> Vec<u8> {
        let (n_surface, n_load) = (LAYOUT.n_surface(), LAYOUT.load_rows * LAYOUT.columns);
        let rows = |node: usize| 3 * node * R..3 * (node + 1) * R;
        let block_load: Vec<f64> = (0..n_load)
            .flat_map(|node| terms.iter().flat_map(move |t| t.response.load[rows(node)].to_vec()))
            .collect();
        // The pattern: one newton along x on every node.
        let pattern = |all: &[f64]| -> Vec<f64> {
            (0..R).map(|k| (0..N).step_by(3).map(|dof| all[dof * R + k]).sum()).collect()
        };
        let pattern_block: Vec<f64> = terms.iter().flat_map(|t| pattern(&t.response.load)).collect();
        let mut factors = Vec::new();
        for (place, (axis, _)) in axes.iter().enumerate() {
            for term in terms {
                factors.extend(
                    (0..axis.n_points as usize).map(|j| f64::from(u8::from(j == term.points[place]))),
                );
            }
        }
        let points: Vec<f64> = axes.iter().flat_map(|(_, points)| points.clone()).collect();
        let regions = self.reduced_stiffness();
        let stiffness: Vec<f64> = (0..R * R).map(|i| regions[i] + regions[R * R + i]).collect();
        let state: Vec<f64> = terms.iter().flat_map(|t| t.response.state.clone()).collect();
        use SectionKind as S;
        let numbers: Vec<(SectionKind, Vec<f64>)> = vec![
            (S::ReducedStiffness, stiffness),
            (S::SurfaceBasis, self.basis[..3 * n_surface * R].to_vec()),
            (S::InteriorBasis, self.basis[3 * n_surface * R..].to_vec()),
            (S::BlockState, state),
            (S::BlockLoad, block_load),
            (S::PatternBasis, pattern(&self.basis)),
            (S::PatternBlock, pattern_block),
            (S::AxisPoints, points),
            (S::Factors, factors),
            (S::RegionStiffness, regions),
            (S::RegionMass, self.reduced_mass()),
        ];
        let bytes = |numbers: &[f64]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let contents: Vec<_> = numbers.iter().map(|(kind, x)| (*kind, Element::F64, bytes(x))).collect();
        let mut metadata = Metadata {
            program: "two regions 1",
            problem: "",
            units: "m, kg, s",
            mesh_hash: [9; 16],
            n_nodes: LAYOUT.n_nodes() as u32,
            n_surface_nodes: n_surface as u32,
            n_load_nodes: n_load as u32,
            n_triangles: 0,
            n_load_triangles: 0,
            n_modes: R as u32,
            n_patterns: 1,
            n_probes: 0,
            scheme_name: "scheme",
            scheme: *scheme,
            time_step: step.time_step,
            alpha: step.alpha,
            beta: step.beta,
            n_regions: 2,
            n_parameters: parameters.len() as u32,
            parameters: [Parameter::UNUSED; MAX_PARAMETERS],
            axes: [Axis::UNUSED; MAX_AXES],
            n_axes: axes.len() as u32,
            n_terms: terms.len() as u32,
            diagonal: false,
            block: true,
            certificate: Certificate::default(),
        };
        metadata.parameters[..parameters.len()].copy_from_slice(parameters);
        metadata.axes.iter_mut().zip(axes).for_each(|(out, (axis, _))| *out = *axis);
        encode(&metadata, &contents)
    }
}

/// `n` Chebyshev points of the second kind from `lower` to `upper`, in the logarithm if asked; the ends are
/// exact.
#[must_use]
pub fn chebyshev(n: usize, lower: f64, upper: f64, log: bool) -> Vec<f64> {
    let place = |x: f64| if log { x.ln() } else { x };
    let (a, b) = (place(lower), place(upper));
    let mut points: Vec<f64> = (0..n)
        .map(|j| {
            let angle = std::f64::consts::PI * j as f64 / (n - 1) as f64;
            let x = 0.5 * (a + b) - 0.5 * (b - a) * angle.cos();
            if log { x.exp() } else { x }
        })
        .collect();
    (points[0], points[n - 1]) = (lower, upper);
    points
}
