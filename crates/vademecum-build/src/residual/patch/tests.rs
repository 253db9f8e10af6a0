//! The residual between near nodes against dense inverses, and against the blocks of a single contact.

use std::fmt::Write as _;
use std::path::PathBuf;

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use faer::prelude::Solve as _;

use super::*;
use crate::dynamics::lowest_modes;
use crate::export::NodeOrder;
use crate::input::Problem;
use crate::prepared::{Prepared, prepare};
use crate::progress::{Silent, Stopwatch};
use crate::residual::near::Reaches;
use crate::residual::{BlockMethod, residual_flexibility};

const BLOCK: &str = r#"
[mesh]
block = { lengths = [0.5, 0.2, 0.3], divisions = [4, 2, 2], order = "linear" }
[[material]]
young = 2e6
poisson = 0.3
density = 1100.0
SUPPORT
[load]
[time]
step = 1e-3
"#;

fn block(support: &str) -> Prepared {
    prepared(&BLOCK.replace("SUPPORT", support), PathBuf::new())
}

fn prepared(text: &str, folder: PathBuf) -> Prepared {
    let problem = Problem::parse(text, "block.toml", folder).expect("a problem");
    prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model")
}

/// A bar of eight-node hexahedra with a square section, held at one end: bending modes come in pairs.
fn square_bar() -> Prepared {
    let (nx, ny) = (6, 3);
    let node = |i: usize, j: usize, k: usize| 1 + i + (nx + 1) * (j + ny * k);
    let mut text = String::from("*NODE\n");
    for (k, j, i) in (0..ny).flat_map(|k| (0..ny).flat_map(move |j| (0..=nx).map(move |i| (k, j, i)))) {
        let [x, y, z] = [0.1 * i as f64, 0.05 * j as f64 - 0.05, 0.05 * k as f64 - 0.05];
        writeln!(text, "{}, {x}, {y}, {z}", node(i, j, k)).expect("a text");
    }
    text.push_str("*ELEMENT, TYPE=C3D8\n");
    for (k, j, i) in (0..2).flat_map(|k| (0..2).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
        let around = |k| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
        let corners = [around(k), around(k + 1)].concat();
        let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
        writeln!(text, "{}, {}", 1 + i + nx * (j + 2 * k), corners.join(", ")).expect("a text");
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("bar.inp"), text).expect("a mesh");
    let support = "[[support]]\non = { box = { min = [-0.01, -1, -1], max = [0.01, 1, 1] } }";
    let mesh = "block = { lengths = [0.5, 0.2, 0.3], divisions = [4, 2, 2], order = \"linear\" }";
    let text = BLOCK.replace("SUPPORT", support).replace(mesh, "file = \"bar.inp\"");
    prepared(&text, folder.path().to_path_buf())
}

/// `K⁻¹` at the components of the loadable nodes; of a free body that of inertia relief.
fn flexibility(prepared: &Prepared, nodes: &[u32]) -> Mat<f64> {
    let (pencil, dofs) = (prepared.body.model.pencil(), prepared.body.model.dofs());
    let n = pencil.n_dof();
    let dense = |matrix: &crate::fem::SymmetricMatrix| {
        let mut image = Mat::zeros(n, n);
        matrix.mul_into(Mat::identity(n, n).as_ref(), image.as_mut());
        image
    };
    let [mass, stiffness] = [dense(pencil.mass()), dense(pencil.stiffness())];
    let inverse = if pencil.rigid().is_none() {
        stiffness.partial_piv_lu().inverse()
    } else {
        // Rigid motions Φ, orthonormal in the mass: (K + s MΦΦᵀM)⁻¹ = K⁺ + ΦΦᵀ/s.
        let places = &prepared.body.model.mesh().nodes;
        let motions = Mat::from_fn(n, 6, |row, k| {
            let (p, c) = (places[row / 3], row % 3);
            match k {
                0..3 => f64::from(u8::from(k == c)),
                _ if c == (k + 1) % 3 => -p[(k + 2) % 3],
                _ if c == (k + 2) % 3 => p[(k + 1) % 3],
                _ => 0.0,
            }
        });
        let gram = motions.transpose() * &mass * &motions;
        let lower = gram.llt(faer::Side::Lower).expect("independent motions").L().to_owned();
        let motions = lower.partial_piv_lu().solve(motions.transpose()).transpose().to_owned();
        let momenta = &mass * &motions;
        let size = stiffness.norm_max() / mass.norm_max();
        let held = stiffness + faer::Scale(size) * (&momenta * momenta.transpose());
        held.partial_piv_lu().inverse() - faer::Scale(1.0 / size) * (&motions * motions.transpose())
    };
    let count = 3 * nodes.len();
    Mat::from_fn(count, count, |i, j| {
        let column = |row: usize| dofs.value(3 * nodes[j / 3] as usize + j % 3, |free| inverse[(row, free)]);
        dofs.value(3 * nodes[i / 3] as usize + i % 3, column)
    })
}

/// A patch of all pairs of loadable nodes beside `r` modes, and the matrices of its parts.
struct Patch<'a> {
    prepared: &'a Prepared,
    order: NodeOrder,
    pairs: Vec<[u32; 2]>,
    known: (Mat<f64>, Vec<f64>),
    found: PatchFlexibility,
}

impl<'a> Patch<'a> {
    fn new(prepared: &'a Prepared, known: (Mat<f64>, Vec<f64>), found: &Modes) -> Self {
        let order = NodeOrder::new(&prepared.body);
        let mesh = &prepared.body.model.mesh().nodes;
        let places: Vec<_> = order.nodes[..order.n_load].iter().map(|&node| mesh[node as usize]).collect();
        let points = Reaches { places: &places, reach: &order.load_reach(mesh) };
        let pairs = points.pairs(10.0, usize::MAX).expect("no limit");
        assert_eq!(pairs.len(), places.len() * (places.len() + 1) / 2);
        let reduced = reduced(prepared, &known);
        let nodes = &order.nodes[..order.n_load];
        let found = patch_flexibility(&reduced, Some(found), nodes, &pairs, &Silent).expect("a patch");
        Self { prepared, order, pairs, known, found }
    }

    fn nodes(&self) -> &[u32] {
        &self.order.nodes[..self.order.n_load]
    }

    /// `Σ row rowᵀ` of the further modes.
    fn fixed(&self) -> Mat<f64> {
        let (m, count) = (self.found.n_modes, 3 * self.nodes().len());
        let rows = Mat::from_fn(count, m, |i, k| self.found.modes[i * m + k]);
        &rows * rows.transpose()
    }

    /// The blocks of all pairs as a matrix.
    fn blocks(&self) -> Mat<f64> {
        let mut matrix = Mat::zeros(3 * self.nodes().len(), 3 * self.nodes().len());
        for (&[a, b], block) in self.pairs.iter().zip(&self.found.blocks) {
            for at in 0..9 {
                let [i, j] = [3 * a as usize + at / 3, 3 * b as usize + at % 3];
                (matrix[(i, j)], matrix[(j, i)]) = (block[at], block[at]);
            }
        }
        matrix
    }

    /// `B Λ⁻¹ Bᵀ` of the modes of the file.
    fn modal(&self) -> Mat<f64> {
        let dofs = self.prepared.body.model.dofs();
        let (vectors, eigenvalues) = &self.known;
        let rows = Mat::from_fn(3 * self.nodes().len(), eigenvalues.len(), |i, k| {
            let dof = 3 * self.nodes()[i / 3] as usize + i % 3;
            dofs.value(dof, |free| vectors[(free, k)]) / eigenvalues[k].sqrt()
        });
        &rows * rows.transpose()
    }
}

fn reduced<'a>(prepared: &'a Prepared, known: &'a (Mat<f64>, Vec<f64>)) -> ResidualBasis<'a> {
    let Prepared { body, symbolic, .. } = prepared;
    let (pencil, vectors, eigenvalues) = (body.model.pencil(), known.0.as_ref(), &known.1[..]);
    ResidualBasis { body, pencil, symbolic, vectors, eigenvalues, rigorous: true }
}

fn modes(prepared: &Prepared, count: usize) -> Modes {
    lowest_modes(prepared.body.model.pencil(), &prepared.symbolic, count).expect("modes")
}

fn first(modes: &Modes, r: usize) -> (Mat<f64>, Vec<f64>) {
    (modes.vectors.subcols(0, r).to_owned(), modes.eigenvalues[..r].to_vec())
}

const HELD: &str = "[[support]]\non = { group = \"x_min\" }";

#[test]
fn modes_further_modes_and_pairs_are_the_whole_flexibility() {
    for support in [HELD, ""] {
        let prepared = &block(support);
        assert_eq!(prepared.body.model.pencil().rigid().is_some(), support.is_empty());
        let patch = Patch::new(prepared, first(&modes(prepared, 7), 7), &modes(prepared, 18));
        assert_eq!(patch.found.n_modes, 11);
        let exact = flexibility(prepared, patch.nodes());
        let (modal, fixed, blocks) = (patch.modal(), patch.fixed(), patch.blocks());
        let off = (&modal + &fixed + &blocks - &exact).norm_max() / exact.norm_max();
        assert!(off < 1e-9, "{support}: {off:e}");
        // None of the parts is too small to be missed.
        for part in [&modal, &fixed, &blocks] {
            assert!(part.norm_max() > 1e-3 * exact.norm_max());
        }
    }
}

#[test]
fn a_single_contact_has_the_residual_that_it_has_without_a_patch() {
    for support in [HELD, ""] {
        let prepared = &block(support);
        let patch = Patch::new(prepared, first(&modes(prepared, 7), 7), &modes(prepared, 18));
        let (nodes, pairs) = (patch.nodes(), patch.order.load_pairs());
        let reduced = reduced(prepared, &patch.known);
        let alone = residual_flexibility(&reduced, BlockMethod::Solves, nodes, &pairs, &Silent);
        let alone = alone.expect("a residual");
        let whole = patch.fixed() + patch.blocks();
        for triangle in &patch.order.triangles[..patch.order.n_load_triangles] {
            let mut found = [0.0; 9];
            let mut expected = [0.0; 9];
            for (a, b) in (0..9).map(|at| (triangle[at / 3], triangle[at % 3])) {
                let block = match alone.pairs.binary_search(&[a.min(b), a.max(b)]) {
                    _ if a == b => flat(full(&alone.contact[a as usize])),
                    Ok(pair) if a < b => alone.pair_blocks[pair],
                    Ok(pair) => std::array::from_fn(|at| alone.pair_blocks[pair][3 * (at % 3) + at / 3]),
                    Err(_) => panic!("an edge without a pair"),
                };
                for at in 0..9 {
                    found[at] += whole[(3 * a as usize + at / 3, 3 * b as usize + at % 3)] / 9.0;
                    expected[at] += block[at] / 9.0;
                }
            }
            let largest = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let off = (0..9).map(|at| (found[at] - expected[at]).abs()).fold(0.0, f64::max);
            assert!(largest > 0.0 && off < 1e-9 * largest, "{support} {triangle:?}: {off:e} of {largest:e}");
        }
    }
}

#[test]
fn further_modes_are_those_left_where_the_basis_ends_inside_a_pair() {
    let prepared = &square_bar();
    let pencil = prepared.body.model.pencil();
    let found = modes(prepared, 9);
    let [one, other] = [found.eigenvalues[0], found.eigenvalues[1]];
    assert!((other / one - 1.0).abs() < 1e-8, "no pair: {one} and {other}");
    // Any mode of the pair may be that of the file: this one is none of those found.
    let (cosine, sine) = (0.6, 0.8);
    let n = pencil.n_dof();
    let turned = Mat::from_fn(n, 1, |i, _| cosine * found.vectors[(i, 0)] + sine * found.vectors[(i, 1)]);
    let mut weighed = Mat::zeros(n, 1);
    pencil.mass().mul_into(turned.as_ref(), weighed.as_mut());
    assert!((weighed.transpose() * found.vectors.col(1)).norm_max() > 0.5, "nothing would be missed");

    let (further, values) = modes_beside(pencil, turned.as_ref(), &found).expect("modes");
    assert_eq!(values.len(), 8);
    assert!((weighed.transpose() * &further).norm_max() < 1e-12);
    for (value, expected) in values.iter().zip(&found.eigenvalues[1..]) {
        assert!((value / expected - 1.0).abs() < 1e-8, "{value} for {expected}");
    }
    let mut image = Mat::zeros(n, 8);
    pencil.mass().mul_into(further.as_ref(), image.as_mut());
    assert!((further.transpose() * image - Mat::<f64>::identity(8, 8)).norm_max() < 1e-12);

    let patch = Patch::new(prepared, (turned, vec![one]), &found);
    let exact = flexibility(prepared, patch.nodes());
    let off = (patch.modal() + patch.fixed() + patch.blocks() - &exact).norm_max() / exact.norm_max();
    assert!(off < 1e-9, "{off:e}");
}
