//! Bodies made of random numbers whose every quantity is known in closed form, and files of them.
//!
//! A mass matrix `M = diag(μ)` and an orthogonal `Q` give eigenvectors `V = M^-½ Q` of
//! `K = M^½ Q diag(ω²) Qᵀ M^½`. A basis `B = V W` with orthonormal `W` that mixes all eigenvectors is
//! M-orthonormal and *not* closed under the dynamics, and still `BᵀM(M + θK)⁻¹MB = Wᵀ(1 + θω²)⁻¹W`: the
//! oracle needs no solver.

use vademecum_format::scheme::{SchemeTable, Stage, StepParameters, theta};
use vademecum_format::{
    Axis, AxisKind, AxisRole, Certificate, Codec, Element, File, MAX_AXES, MAX_PARAMETERS, Metadata,
    Parameter, SectionInput, SectionKind, encode_into, encoded_len,
};

/// A small linear congruential generator: the same numbers everywhere.
pub struct Random(u64);

impl Random {
    /// From a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5DEE_CE66)
    }

    /// Uniform in [−1, 1).
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64) / ((1u64 << 52) as f64) - 1.0
    }

    /// `length` of them.
    pub fn numbers(&mut self, length: usize) -> Vec<f64> {
        (0..length).map(|_| self.number()).collect()
    }
}

/// How a body is laid out: a plane grid of surface nodes, the first rows loadable, and interior nodes below
/// it.
#[derive(Clone, Copy)]
pub struct Layout {
    /// Surface rows; the first `load_rows` are loadable.
    pub rows: usize,
    /// Loadable rows.
    pub load_rows: usize,
    /// Surface columns.
    pub columns: usize,
    /// Interior nodes.
    pub n_interior: usize,
    /// Modes.
    pub r: usize,
}

/// A body and a basis of it.
pub struct Body {
    /// Its layout.
    pub layout: Layout,
    /// `(3n, r)`: the basis, row by row; diagonalises the stiffness.
    pub basis: Vec<f64>,
    /// `(r)`: `BᵀKB`.
    pub lambda: Vec<f64>,
    /// Squares of all natural frequencies; empty when the basis is closed.
    pub omega2: Vec<f64>,
    /// `(3n, 3n)`: all eigenvectors, row by row; empty when the basis is closed.
    pub eigenvectors: Vec<f64>,
    /// `(3n, r)`: the basis in eigenvectors; empty when the basis is closed.
    pub mixing: Vec<f64>,
}

/// Eigenvalues of a symmetric matrix by cyclic Jacobi rotations; the columns of `basis` (`(n, r)`, row by
/// row) turn along.
fn jacobi(a: &mut [f64], r: usize, basis: &mut [f64]) -> Vec<f64> {
    for _ in 0..60 {
        for p in 0..r {
            for q in p + 1..r {
                let (app, aqq, apq) = (a[p * r + p], a[q * r + q], a[p * r + q]);
                if apq.abs() < 1e-300 {
                    continue;
                }
                let tau = (aqq - app) / (2.0 * apq);
                let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
                let c = 1.0 / (1.0 + t * t).sqrt();
                let s = t * c;
                for k in 0..r {
                    let (kp, kq) = (a[k * r + p], a[k * r + q]);
                    (a[k * r + p], a[k * r + q]) = (c * kp - s * kq, s * kp + c * kq);
                }
                for k in 0..r {
                    let (pk, qk) = (a[p * r + k], a[q * r + k]);
                    (a[p * r + k], a[q * r + k]) = (c * pk - s * qk, s * pk + c * qk);
                }
                for row in basis.chunks_exact_mut(r) {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
            }
        }
    }
    (0..r).map(|k| a[k * r + k]).collect()
}

/// Columns of `n` made orthonormal one after the other by Gram–Schmidt, twice: `(n, columns)`, row by row.
pub(crate) fn orthonormal(n: usize, columns: usize, mut column: impl FnMut(usize) -> Vec<f64>) -> Vec<f64> {
    let mut q: Vec<Vec<f64>> = Vec::new();
    for k in 0..columns {
        let mut column = column(k);
        for _ in 0..2 {
            for known in &q {
                let along: f64 = known.iter().zip(&column).map(|(a, b)| a * b).sum();
                column.iter_mut().zip(known).for_each(|(c, k)| *c -= along * k);
            }
            let norm = column.iter().map(|c| c * c).sum::<f64>().sqrt();
            column.iter_mut().for_each(|c| *c /= norm);
        }
        q.push(column);
    }
    (0..n * columns).map(|i| q[i % columns][i / columns]).collect()
}

impl Layout {
    /// Surface nodes.
    #[must_use]
    pub fn n_surface(&self) -> usize {
        self.rows * self.columns
    }

    /// All nodes.
    #[must_use]
    pub fn n_nodes(&self) -> usize {
        self.n_surface() + self.n_interior
    }

    /// `(n_nodes, 3)`: grid points at unit distance, z = 0; interior nodes below.
    #[must_use]
    pub fn coordinates(&self) -> Vec<f64> {
        let surface =
            (0..self.n_surface()).map(|i| [(i % self.columns) as f64, (i / self.columns) as f64, 0.0]);
        surface.chain((0..self.n_interior).map(|i| [i as f64, 0.5, -1.0])).flatten().collect()
    }

    /// Two triangles per grid square, normals along +z, loadable ones first; with how many are loadable.
    #[must_use]
    pub fn triangles(&self) -> (Vec<u32>, usize) {
        let node = |row: usize, column: usize| (row * self.columns + column) as u32;
        let mut triangles = Vec::new();
        for row in 0..self.rows - 1 {
            for c in 0..self.columns - 1 {
                triangles.extend([node(row, c), node(row, c + 1), node(row + 1, c)]);
                triangles.extend([node(row + 1, c), node(row, c + 1), node(row + 1, c + 1)]);
            }
        }
        (triangles, 2 * (self.columns - 1) * self.load_rows.saturating_sub(1))
    }
}

impl Body {
    /// A body whose basis is not closed: natural frequencies spread over three decades from 30 rad/s.
    #[must_use]
    pub fn open(layout: Layout, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let (n, r) = (3 * layout.n_nodes(), layout.r);
        let omega2: Vec<f64> = (0..n).map(|i| (30.0 * 1e3f64.powf(i as f64 / n as f64)).powi(2)).collect();
        let mass: Vec<f64> = random.numbers(n).iter().map(|x| 0.02 + 0.01 * x).collect();
        let mut eigenvectors = orthonormal(n, n, |_| random.numbers(n));
        for (row, mass) in eigenvectors.chunks_exact_mut(n).zip(&mass) {
            row.iter_mut().for_each(|v| *v /= mass.sqrt());
        }
        // Mostly the lowest eigenvectors, with a little of all others: what a basis of snapshots looks like.
        let mut mixing = orthonormal_near_identity(n, r, &mut random);
        let mut stiffness = vec![0.0; r * r];
        for (row, omega2) in mixing.chunks_exact(r).zip(&omega2) {
            for i in 0..r * r {
                stiffness[i] += row[i / r] * omega2 * row[i % r];
            }
        }
        let lambda = jacobi(&mut stiffness, r, &mut mixing);
        let basis = product(&eigenvectors, n, &mixing, r);
        Self { layout, basis, lambda, omega2, eigenvectors, mixing }
    }

    /// A body of any size whose basis counts as closed (`H = B (1 + θλ)⁻¹`); its rows are random numbers.
    #[must_use]
    pub fn closed(layout: Layout, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let r = layout.r;
        let basis = random.numbers(3 * layout.n_nodes() * r);
        let lambda = (0..r).map(|k| (30.0 * 1e3f64.powf(k as f64 / r as f64)).powi(2)).collect();
        Self { layout, basis, lambda, omega2: vec![], eigenvectors: vec![], mixing: vec![] }
    }

    /// `E(θ) = BᵀM(M + θK)⁻¹MB − I`, `(r, r)`, as `−θ Wᵀ ω²/(1 + θω²) W`: no cancellation.
    #[must_use]
    pub fn increment(&self, theta: f64) -> Vec<f64> {
        let r = self.layout.r;
        let mut e = vec![0.0; r * r];
        if self.omega2.is_empty() {
            (0..r).for_each(|k| e[k * r + k] = -theta * self.lambda[k] / (1.0 + theta * self.lambda[k]));
        }
        for (row, omega2) in self.mixing.chunks_exact(r).zip(&self.omega2) {
            let weight = -theta * omega2 / (1.0 + theta * omega2);
            for i in 0..r * r {
                e[i] += row[i / r] * weight * row[i % r];
            }
        }
        e
    }

    /// `H(θ) − B`, `(3n, r)`, row by row.
    #[must_use]
    pub fn load_increment(&self, theta: f64) -> Vec<f64> {
        let r = self.layout.r;
        if self.omega2.is_empty() {
            return product(&self.basis, r, &self.increment(theta), r);
        }
        let weighted: Vec<f64> = self
            .mixing
            .iter()
            .enumerate()
            .map(|(i, w)| -w * theta * self.omega2[i / r] / (1.0 + theta * self.omega2[i / r]))
            .collect();
        product(&self.eigenvectors, self.omega2.len(), &weighted, r)
    }

    /// The file of this body with both structures and one load pattern (`1` on every dof of node 0 and `2` on
    /// those of the last node), one probe per component of node 0.
    #[must_use]
    pub fn file(&self, scheme: &SchemeTable, step: &StepParameters, element: Element) -> Vec<u8> {
        let Layout { rows: _, load_rows, columns, n_interior: _, r } = self.layout;
        let thetas: Vec<f64> =
            (0..scheme.active().len()).map(|i| theta(scheme, step, i).expect("scheme")).collect();
        let increments: Vec<Vec<f64>> = thetas.iter().map(|&theta| self.increment(theta)).collect();
        let loads: Vec<Vec<f64>> = thetas.iter().map(|&theta| self.load_increment(theta)).collect();
        let n_terms = thetas.len();
        let n_load = load_rows * columns;
        let surface = 3 * self.layout.n_surface() * r;
        let mut stiffness = vec![0.0; r * r];
        (0..r).for_each(|k| stiffness[k * r + k] = self.lambda[k]);
        let block_load: Vec<f64> = (0..n_load)
            .flat_map(|node| {
                loads.iter().flat_map(move |load| load[3 * node * r..3 * (node + 1) * r].iter().copied())
            })
            .collect();
        let pattern_block: Vec<f64> = loads.iter().flat_map(|load| self.pattern_of(load)).collect();
        let identity: Vec<f64> =
            (0..n_terms * n_terms).map(|i| f64::from(u8::from(i / n_terms == i % n_terms))).collect();
        let (triangles, n_load_triangles) = self.layout.triangles();
        let n_triangles = triangles.len() / 3;
        let points: Vec<f64> = (0..n_terms).map(|i| i as f64).collect();
        let f64s = |numbers: &[f64]| -> Vec<u8> { numbers.iter().flat_map(|x| x.to_le_bytes()).collect() };
        let reals = |numbers: &[f64]| match element {
            Element::F32 => numbers.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect(),
            _ => f64s(numbers),
        };
        use Element::{F64, U32, U64};
        use SectionKind as S;
        let ids: Vec<u8> = (0..self.layout.n_nodes() as u64).flat_map(|id| (id + 1).to_le_bytes()).collect();
        let contents: Vec<(SectionKind, Element, Vec<u8>)> = vec![
            (S::NodeIds, U64, ids),
            (S::NodeCoordinates, element, reals(&self.layout.coordinates())),
            (S::Triangles, U32, triangles.iter().flat_map(|t| t.to_le_bytes()).collect()),
            (S::ReducedStiffness, F64, f64s(&stiffness)),
            (S::Eigenvalues, F64, f64s(&self.lambda)),
            (S::SurfaceBasis, element, reals(&self.basis[..surface])),
            (S::InteriorBasis, element, reals(&self.basis[surface..])),
            (S::BlockState, F64, f64s(&increments.concat())),
            (S::BlockLoad, element, reals(&block_load)),
            (S::PatternBasis, F64, f64s(&self.pattern_of(&self.basis))),
            (S::PatternBlock, F64, f64s(&pattern_block)),
            (S::PatternNames, Element::U8, b"pull".to_vec()),
            (S::ProbeNames, Element::U8, b"x\ny\nz".to_vec()),
            (S::ProbeRows, F64, f64s(&self.basis[..3 * r])),
            (S::AxisPoints, F64, f64s(&points)),
            (S::Factors, F64, f64s(&identity)),
        ];
        let metadata = Metadata {
            program: "synthetic 1",
            problem: "[synthetic]\n",
            units: "m, kg, s",
            mesh_hash: [7; 16],
            n_nodes: self.layout.n_nodes() as u32,
            n_surface_nodes: self.layout.n_surface() as u32,
            n_load_nodes: n_load as u32,
            n_triangles: n_triangles as u32,
            n_load_triangles: n_load_triangles as u32,
            n_modes: r as u32,
            n_patterns: 1,
            n_probes: 3,
            scheme_name: "scheme",
            scheme: *scheme,
            time_step: step.time_step,
            alpha: step.alpha,
            beta: step.beta,
            n_regions: 1,
            n_parameters: 0,
            parameters: [Parameter::UNUSED; MAX_PARAMETERS],
            axes: stage_axis(n_terms),
            n_axes: 1,
            n_terms: n_terms as u32,
            diagonal: true,
            block: true,
            certificate: Certificate::default(),
        };
        encode(&metadata, &contents)
    }

    /// `RᵀF` of the pattern for rows `R`, `(3n, r)`.
    #[must_use]
    pub fn pattern_of(&self, rows: &[f64]) -> Vec<f64> {
        let r = self.layout.r;
        let last = rows.len() / r - 3;
        let column = |k: usize| (0..3).map(|c| rows[c * r + k] + 2.0 * rows[(last + c) * r + k]).sum();
        (0..r).map(column).collect()
    }
}

/// The one axis of version 1.0: the stage.
#[must_use]
pub fn stage_axis(n_stages: usize) -> [Axis<'static>; MAX_AXES] {
    let mut axes = [Axis::UNUSED; MAX_AXES];
    axes[0] = Axis {
        name: "stage",
        unit: "",
        role: AxisRole::Stage,
        kind: AxisKind::Index,
        log: false,
        lower: 0.0,
        upper: (n_stages - 1) as f64,
        n_points: n_stages as u32,
    };
    axes
}

/// A file of these contents, every section required and with the shape the metadata ask for (text: its
/// length).
///
/// # Panics
/// If the writer refuses it.
#[must_use]
pub fn encode(metadata: &Metadata<'_>, contents: &[(SectionKind, Element, Vec<u8>)]) -> Vec<u8> {
    let sections: Vec<SectionInput<'_>> = contents
        .iter()
        .map(|(kind, element, bytes)| SectionInput {
            kind: *kind,
            element: *element,
            codec: Codec::Raw,
            required: true,
            shape: kind.shape(metadata).map(|n| n.unwrap_or(bytes.len() as u64 / element.size())),
            decoded_length: bytes.len() as u64,
            stored: bytes,
        })
        .collect();
    let mut out = vec![0; encoded_len(metadata, &sections).expect("length")];
    encode_into(metadata, &sections, &mut out).expect("the writer takes the synthetic file");
    out
}

/// A file through the writer, with its metadata and sections changed and new sections after them.
///
/// # Panics
/// If the writer refuses it.
#[must_use]
pub fn rewritten<'a>(
    bytes: &'a [u8],
    metadata: impl FnOnce(&mut Metadata<'_>),
    section: impl FnMut(&mut SectionInput<'a>),
    more: &[SectionInput<'a>],
) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let mut inputs: Vec<SectionInput<'a>> = file.sections().map(SectionInput::from).collect();
    inputs.iter_mut().for_each(section);
    inputs.extend_from_slice(more);
    let mut changed = *file.metadata();
    metadata(&mut changed);
    let mut out = vec![0; encoded_len(&changed, &inputs).expect("a length")];
    encode_into(&changed, &inputs, &mut out).expect("the writer takes it");
    out
}

fn orthonormal_near_identity(n: usize, r: usize, random: &mut Random) -> Vec<f64> {
    orthonormal(n, r, |k| {
        let mut column: Vec<f64> = random.numbers(n).iter().map(|x| 0.02 * x).collect();
        column[k] += 1.0;
        column
    })
}

/// `A B`, `A` with `inner` columns, all row by row.
fn product(a: &[f64], inner: usize, b: &[f64], columns: usize) -> Vec<f64> {
    let row = |a: &[f64]| -> Vec<f64> {
        let mut out = vec![0.0; columns];
        for (a, b) in a.iter().zip(b.chunks_exact(columns)) {
            out.iter_mut().zip(b).for_each(|(out, b)| *out += a * b);
        }
        out
    };
    a.chunks_exact(inner).flat_map(row).collect()
}

/// Bathe's two-stage scheme, written by hand from its equations.
#[must_use]
pub fn bathe() -> SchemeTable {
    let first = Stage {
        mass: 16.0,
        damping: 4.0,
        stiffness: 1.0,
        time: 0.5,
        load: [0.0, 1.0, 0.0, 0.0],
        mass_history: [16.0, 8.0, 1.0, 0.0, 0.0, 0.0],
        damping_history: [4.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        stiffness_history: [0.0; 6],
    };
    let second = Stage {
        mass: 9.0,
        damping: 3.0,
        stiffness: 1.0,
        time: 1.0,
        load: [0.0, 0.0, 1.0, 0.0],
        mass_history: [-19.0, -5.0, 0.0, 28.0, 0.0, 0.0],
        damping_history: [-1.0, 0.0, 0.0, 4.0, 0.0, 0.0],
        stiffness_history: [0.0; 6],
    };
    let finish = [
        [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0, -4.0, 3.0, 0.0],
        // Δt² a = Δt v − 4 Δt v½ + 3 Δt v¹ with Δt v½ = 4 (u½ − u) − Δt v.
        [19.0, 5.0, 0.0, -28.0, 9.0, 0.0],
    ];
    SchemeTable { n_stages: 2, stages: [first, second, Stage::default()], finish }
}

/// Newmark's family, written by hand: one stage.
#[must_use]
pub fn newmark(beta: f64, gamma: f64) -> SchemeTable {
    let stage = Stage {
        mass: 1.0 / beta,
        damping: gamma / beta,
        stiffness: 1.0,
        time: 1.0,
        load: [0.0, 1.0, 0.0, 0.0],
        mass_history: [1.0 / beta, 1.0 / beta, 0.5 / beta - 1.0, 0.0, 0.0, 0.0],
        damping_history: [gamma / beta, gamma / beta - 1.0, 0.5 * gamma / beta - 1.0, 0.0, 0.0, 0.0],
        stiffness_history: [0.0; 6],
    };
    let acceleration = [-1.0 / beta, -1.0 / beta, 1.0 - 0.5 / beta, 1.0 / beta, 0.0, 0.0];
    let velocity = [-gamma / beta, 1.0 - gamma / beta, 1.0 - 0.5 * gamma / beta, gamma / beta, 0.0, 0.0];
    let finish = [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], velocity, acceleration];
    SchemeTable { n_stages: 1, stages: [stage, Stage::default(), Stage::default()], finish }
}
