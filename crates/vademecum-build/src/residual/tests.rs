//! The residual of a small block against dense matrices, and its bound against the error it bounds.

use std::path::PathBuf;
use std::sync::LazyLock;

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, MatRef, Side};
use vademecum_format::exact::Propagator;

use super::small::{form, full};
use super::*;
use crate::dynamics::lowest_modes;
use crate::export::NodeOrder;
use crate::fem::SymmetricMatrix;
use crate::input::Problem;
use crate::linalg::Random;
use crate::linalg::symmetric_eigen;
use crate::prepared::{Prepared, prepare};
use crate::progress::{Silent, Stopwatch, is_cancelled};
use crate::store::CachedSolves;

const BLOCK: &str = r#"
[mesh]
block = { lengths = [0.5, 0.2, 0.3], divisions = [4, 2, 2], order = "linear" }
[[material]]
young = 2e6
poisson = 0.3
density = 1100.0
[[support]]
on = { group = "x_min" }
[[support]]
on = { box = { min = [0.49, -1.0, -0.01], max = [0.51, 1.0, 0.01] } }
components = ["y"]
[load]
surface = { group = "z_max" }
[[load.pattern]]
name = "gravity"
acceleration = [0.3, -1.0, -9.81]
[[load.pattern]]
name = "water"
pressure = 1e3
on = { group = "z_min" }
[time]
step = 1e-3
[[output.probe]]
name = "tip"
point = [0.5, 0.2, 0.3]
direction = [1.0, -2.0, 0.5]
[[output.probe]]
name = "middle"
point = [0.25, 0.1, 0.15]
direction = [0.0, 0.0, 1.0]
"#;

fn prepared(text: &str) -> Prepared {
    let problem = Problem::parse(text, "block.toml", PathBuf::new()).expect("a problem");
    prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model")
}

/// A block with its matrices as dense ones, its order, and all natural modes.
struct Block {
    prepared: Prepared,
    order: NodeOrder,
    mass: Mat<f64>,
    stiffness: Mat<f64>,
    lambda: Vec<f64>,
    modes: Mat<f64>,
}

static WHOLE: LazyLock<Block> =
    LazyLock::new(|| Block::new(&BLOCK.replace("surface = { group = \"z_max\" }", "")));
static TOP: LazyLock<Block> = LazyLock::new(|| Block::new(BLOCK));

impl Block {
    fn new(text: &str) -> Self {
        let prepared = prepared(text);
        let pencil = prepared.body.model.pencil();
        let n = pencil.n_dof();
        let dense = |matrix: &SymmetricMatrix| {
            let mut image = Mat::zeros(n, n);
            matrix.mul_into(Mat::identity(n, n).as_ref(), image.as_mut());
            image
        };
        let [mass, stiffness] = [dense(pencil.mass()), dense(pencil.stiffness())];
        // L⁻¹ K L⁻ᵀ y = λ y, φ = L⁻ᵀ y.
        let inverse = mass.llt(Side::Lower).expect("a mass").L().to_owned().partial_piv_lu().inverse();
        let turned = &inverse * &stiffness * inverse.transpose();
        let turned = crate::linalg::symmetric_part(turned.as_ref());
        let (lambda, vectors) = symmetric_eigen(turned.as_ref()).expect("finite");
        let modes = inverse.transpose() * vectors;
        let order = NodeOrder::new(&prepared.body);
        Self { prepared, order, mass, stiffness, lambda, modes }
    }

    /// The first natural modes.
    fn natural(&self, r: usize) -> (Mat<f64>, Vec<f64>) {
        (self.modes.subcols(0, r).to_owned(), self.lambda[..r].to_vec())
    }

    /// Ritz vectors of a space that no mode lies in.
    fn ritz(&self, r: usize) -> (Mat<f64>, Vec<f64>) {
        let (n, mut random) = (self.mass.nrows(), Random::new(3));
        let some = Mat::from_fn(n, r, |_, _| random.uniform() - 0.5);
        // Smoothed, so that a bound is neither 0 nor 1.
        let some = &self.modes
            * Mat::from_fn(n, r, |k, j| {
                (0..n).map(|i| self.modes[(i, k)] * some[(i, j)]).sum::<f64>() / self.lambda[k]
            });
        let gram = some.transpose() * &self.mass * &some;
        let lower = gram.llt(Side::Lower).expect("independent").L().to_owned();
        let orthonormal = some * lower.partial_piv_lu().inverse().transpose();
        let carried = orthonormal.transpose() * &self.stiffness * &orthonormal;
        let carried = crate::linalg::symmetric_part(carried.as_ref());
        let (values, rotation) = symmetric_eigen(carried.as_ref()).expect("finite");
        (orthonormal * rotation, values)
    }

    fn nodes(&self) -> &[u32] {
        &self.order.nodes[..self.order.n_load]
    }

    fn residual(
        &self,
        way: BlockMethod,
        (vectors, eigenvalues): &(Mat<f64>, Vec<f64>),
    ) -> ResidualFlexibility {
        self.residual_heard(way, vectors.as_ref(), eigenvalues, &Silent).expect("a residual")
    }

    fn residual_heard(
        &self,
        way: BlockMethod,
        vectors: MatRef<'_, f64>,
        eigenvalues: &[f64],
        listener: &dyn Listener,
    ) -> Result<ResidualFlexibility, ResidualError> {
        let Prepared { body, symbolic, .. } = &self.prepared;
        let reduced = ResidualBasis {
            body,
            pencil: body.model.pencil(),
            symbolic,
            vectors,
            eigenvalues,
            rigorous: true,
        };
        residual_flexibility(&reduced, way, self.nodes(), &self.order.load_pairs(), listener)
    }

    /// `R` as a dense matrix: `P K⁻¹ Pᵀ` with the projector `P = I − B Λ⁻¹ Bᵀ K`.
    fn dense(&self, (vectors, eigenvalues): &(Mat<f64>, Vec<f64>)) -> [Mat<f64>; 2] {
        let n = self.mass.nrows();
        let inverse = &self.modes * Mat::from_fn(n, n, |k, i| self.modes[(i, k)] / self.lambda[k]);
        let scaled = Mat::from_fn(n, eigenvalues.len(), |i, k| vectors[(i, k)] / eigenvalues[k]);
        let project = Mat::<f64>::identity(n, n) - scaled * (vectors.transpose() * &self.stiffness);
        [&project * &inverse * project.transpose(), inverse]
    }

    /// Force of a unit at a component of a node; nothing where it is held.
    fn unit(&self, node: u32, component: usize) -> Mat<f64> {
        let mut force = Mat::zeros(self.mass.nrows(), 1);
        if let Some(free) = self.prepared.body.model.dofs().free(3 * node as usize + component) {
            force[(free as usize, 0)] = 1.0;
        }
        force
    }

    /// `AᵀXB` of unit forces at two nodes.
    fn between(&self, matrix: &Mat<f64>, first: u32, second: u32) -> [f64; 9] {
        std::array::from_fn(|at| {
            let [a, b] = [self.unit(first, at / 3), self.unit(second, at % 3)];
            (a.transpose() * matrix * b)[(0, 0)]
        })
    }
}

/// Each with both ways.
fn both<T: Copy, const N: usize>(all: [T; N]) -> impl Iterator<Item = (T, BlockMethod)> {
    all.into_iter().flat_map(|one| [BlockMethod::Solves, BlockMethod::Selection].map(|way| (one, way)))
}

/// The largest difference over the largest of the second.
fn off(found: impl IntoIterator<Item = f64>, exact: impl IntoIterator<Item = f64>) -> f64 {
    let (mut found, mut difference, mut largest) = (found.into_iter(), 0.0_f64, 0.0_f64);
    for exact in exact {
        let found = found.next().expect("as many as are expected");
        difference = difference.max((found - exact).abs());
        largest = largest.max(exact.abs());
    }
    assert!(found.next().is_none() && largest > 0.0);
    difference / largest
}

#[test]
fn every_part_of_the_residual_is_that_of_dense_matrices() {
    for (block, way) in both([&*WHOLE, &*TOP]) {
        for basis in [block.natural(7), block.ritz(7)] {
            let (found, [dense, inverse]) = (block.residual(way, &basis), block.dense(&basis));
            let nodes = block.nodes();
            let nine = |a: &[Symmetric]| a.iter().flat_map(full).flatten().collect::<Vec<f64>>();
            let own = |matrix: &Mat<f64>| {
                nodes.iter().flat_map(|&node| block.between(matrix, node, node)).collect::<Vec<f64>>()
            };
            assert!(off(nine(&found.contact), own(&dense)) < 1e-10);

            let mut edges = std::collections::BTreeSet::new();
            for triangle in &block.order.triangles[..block.order.n_load_triangles] {
                for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                    edges.insert([triangle[a].min(triangle[b]), triangle[a].max(triangle[b])]);
                }
            }
            assert_eq!(found.pairs, edges.into_iter().collect::<Vec<_>>());
            let of_pair = |&[i, j]: &[u32; 2]| block.between(&dense, nodes[i as usize], nodes[j as usize]);
            let pairs = found.pairs.iter().flat_map(of_pair);
            assert!(off(found.pair_blocks.concat(), pairs) < 1e-10);

            let gram = &dense * &block.mass * &dense;
            let answer = &inverse * &block.mass * &inverse;
            assert!(off(nine(&found.gram), own(&gram)) < 1e-10);
            for (&node, &bound) in nodes.iter().zip(&found.at_nodes) {
                let [g, s] = [&gram, &answer].map(|m| small::symmetric(&block.between(m, node, node)));
                assert!((bound - relative_bound(&g, &s)).abs() <= 1e-8 * bound, "node {node}");
            }

            let body = &block.prepared.body;
            let column = |f: &[f64]| Mat::from_fn(f.len(), 1, |i, _| f[i]);
            let probe = |place: usize| {
                let [(node, weights)] = body.probes[place].nodes[..] else { panic!("a probe at one node") };
                (0..3).fold(Mat::zeros(block.mass.nrows(), 1), |sum: Mat<f64>, c| {
                    sum + faer::Scale(weights[c]) * block.unit(node, c)
                })
            };
            let at_nodes = |load: &Mat<f64>| -> Vec<f64> {
                let answer = &dense * load;
                let at = |node: u32, c| (block.unit(node, c).transpose() * &answer)[(0, 0)];
                nodes.iter().flat_map(|&node| [0, 1, 2].map(|c| at(node, c))).collect()
            };
            assert_eq!((found.probes.len(), found.patterns.len()), (2, 2));
            for place in 0..2 {
                let force = column(&body.patterns[place].1);
                assert!(off(found.probes[place].concat(), at_nodes(&probe(place))) < 1e-10);
                assert!(off(found.patterns[place].concat(), at_nodes(&force)) < 1e-10);
                let values = [0, 1].map(|p| (probe(p).transpose() * &dense * &force)[(0, 0)]);
                assert!(off(found.pattern_probes[place].iter().copied(), values) < 1e-10);
            }
        }
    }
}

#[test]
fn what_a_contact_needs_is_symmetric_and_stores_energy() {
    let block = &*WHOLE;
    let triangles = &block.order.triangles[..block.order.n_load_triangles];
    let found = [BlockMethod::Solves, BlockMethod::Selection].map(|way| block.residual(way, &block.ritz(9)));
    for (triangle, found) in triangles.iter().flat_map(|triangle| found.iter().map(move |f| (triangle, f))) {
        // The 9 × 9 matrix of a triangle, as a reader puts it together.
        let entry = |row: usize, column: usize| {
            let ([i, j], [a, b]) = ([triangle[row / 3], triangle[column / 3]], [row % 3, column % 3]);
            if i == j {
                return full(&found.contact[i as usize])[a][b];
            }
            let pair = found.pairs.binary_search(&[i.min(j), i.max(j)]).expect("an edge");
            found.pair_blocks[pair][if i < j { 3 * a + b } else { 3 * b + a }]
        };
        let matrix = Mat::from_fn(9, 9, entry);
        assert!((&matrix - matrix.transpose()).norm_max() == 0.0);
        let (values, _) = symmetric_eigen(matrix.as_ref()).expect("finite");
        assert!(values[0] > -1e-13 * values[8], "{values:?}");
    }
}

#[test]
fn the_bound_is_never_below_the_error_after_jumps_of_a_load() {
    let block = &*WHOLE;
    let (n, r) = (block.lambda.len(), 5);
    let found = block.residual(BlockMethod::Solves, &block.natural(r));
    let period = std::f64::consts::TAU / block.lambda[0].sqrt();
    let (dt, mut random) = (period / 97.0, Random::new(11));
    let first = block.lambda[0].sqrt();
    let mut nearest: f64 = 0.0;
    for [alpha, beta] in [[0.0, 0.0], [0.04 * first, 0.0], [0.0, 0.04 / first], [5.0 * first, 5.0 / first]] {
        let step = |lambda: &f64| Propagator::new(*lambda, 0.5 * (alpha + beta * lambda), dt);
        let steps: Vec<Propagator> = block.lambda.iter().map(step).collect();
        for _ in 0..6 {
            let place = random.below(found.gram.len());
            let node = block.nodes()[place];
            let mut state = vec![[0.0; 2]; n];
            let (mut force, mut bound) = ([0.0; 3], 0.0);
            for instant in 0..300 {
                // A jump now and then; the last one lets go.
                if instant % 60 == 0 {
                    let next = match instant {
                        240 => [0.0; 3],
                        _ => std::array::from_fn(|_| 2.0 * random.uniform() - 1.0),
                    };
                    let jump = std::array::from_fn(|c| next[c] - force[c]);
                    bound += form(&found.gram[place], jump).sqrt();
                    force = next;
                }
                let load: Mat<f64> =
                    (0..3).fold(Mat::zeros(n, 1), |sum, c| sum + faer::Scale(force[c]) * block.unit(node, c));
                let modal = block.modes.transpose() * load;
                for k in 0..n {
                    let (y, p) = (state[k], &steps[k]);
                    for i in 0..2 {
                        let change = p.d[2 * i] * y[0] + p.d[2 * i + 1] * y[1];
                        state[k][i] = y[i] + change + p.held[i] * modal[(k, 0)];
                    }
                }
                let left = |k: usize| state[k][0] - modal[(k, 0)] / block.lambda[k];
                let error = (r..n).map(|k| left(k).powi(2)).sum::<f64>().sqrt();
                assert!(error <= bound * (1.0 + 1e-10), "{error:e} above {bound:e} at step {instant}");
                nearest = nearest.max(error / bound);
            }
        }
    }
    // Just after the first jump nothing has moved, and the error is the bound.
    assert!(nearest > 0.5, "{nearest}");
}

#[test]
fn the_numbers_of_the_bound_are_in_order_and_fall_with_every_mode() {
    let block = &*TOP;
    for way in [BlockMethod::Solves, BlockMethod::Selection] {
        let mut before = f64::INFINITY;
        for r in 1..=12 {
            let bound = block.residual(way, &block.natural(r)).bound;
            assert!(bound.rigorous && 0.0 < bound.median);
            assert!(bound.median <= bound.most && bound.most <= bound.worst);
            // A mode that the worst place does not feel leaves it as it was, to rounding.
            let fall = before - bound.worst;
            assert!(fall >= -1e-12 * bound.worst, "{fall:e} with mode {r}");
            before = bound.worst;
        }
        // With all modes nothing is left but rounding.
        let all = block.residual(way, &block.natural(block.lambda.len()));
        assert!(all.bound.worst < 1e-10, "{}", all.bound.worst);
    }
}

#[test]
fn an_error_chooses_the_fewest_modes() {
    for (block, errors) in [(&*TOP, [0.2, 0.05, 0.02]), (&*WHOLE, [0.5, 0.1, 0.03])] {
        let Prepared { body, symbolic, .. } = &block.prepared;
        for error in errors {
            let ModeSearch::Modes(modes, reached) =
                modes_within(body, symbolic, error, &Silent, (&CachedSolves::new(None, &Silent), None))
                    .expect("modes")
            else {
                panic!("all modes reach any error")
            };
            let worst = |r: usize| {
                let vectors = modes.vectors.subcols(0, r);
                let found =
                    block.residual_heard(BlockMethod::Solves, vectors, &modes.eigenvalues[..r], &Silent);
                found.expect("a residual").bound.worst
            };
            let r = modes.eigenvalues.len();
            assert!(r > 1 && worst(r) <= error && worst(r - 1) > error, "{error}: {r} modes");
            assert!(r < block.lambda.len(), "a bound that takes all modes");
            let off = reached / worst(r) - 1.0;
            assert!(off.abs() < 1e-6, "{error}: {r} modes, off by {off:e}");
        }
    }
}

#[test]
fn no_number_of_modes_is_found_for_a_bound_out_of_reach() {
    let finer = BLOCK.replace("divisions = [4, 2, 2]", "divisions = [8, 4, 4]");
    let Prepared { body, symbolic, .. } = &prepared(&finer);
    match modes_within(body, symbolic, 1e-5, &Silent, (&CachedSolves::new(None, &Silent), None))
        .expect("an answer")
    {
        ModeSearch::Missed { modes: 512, reached } => assert!(reached > 1e-5 && reached < 1.0),
        ModeSearch::Missed { modes, .. } => panic!("{modes} modes were tried"),
        ModeSearch::Modes(modes, _) => panic!("{} modes", modes.eigenvalues.len()),
    }
}

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let block = &*WHOLE;
    // More than two batches of one thread.
    assert!(block.order.n_load > 2 * 8);
    let basis = block.ritz(5);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let found = || [BlockMethod::Solves, BlockMethod::Selection].map(|way| block.residual(way, &basis));
        format!("{:?}", pool.install(found))
    };
    let one = with(1);
    assert!([2, 3, 5].into_iter().all(|threads| with(threads) == one));
}

/// Stops at a batch.
struct Stop(usize);

impl Listener for Stop {
    fn stage(&self, _: &str) {}
    fn advance(&self, done: usize, total: usize) {
        assert!(done <= self.0 && total > 0, "work after the wish to stop");
    }
    fn note(&self, _: &str) {}
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn it_stops_on_request() {
    let (vectors, eigenvalues) = WHOLE.natural(2);
    for way in [BlockMethod::Solves, BlockMethod::Selection] {
        let stopped = WHOLE.residual_heard(way, vectors.as_ref(), &eigenvalues, &Stop(0));
        let error = stopped.expect_err("an end");
        assert!(is_cancelled(&crate::pipeline::BuildError::from(error)));
    }
}

/// A tip that moves ten thousand times as far as its dent.
const SLENDER: &str = r#"
[mesh]
block = { lengths = [1.0, 0.03, 0.04], divisions = [40, 2, 2], order = "quadratic" }
[[material]]
young = 2.1e9
poisson = 0.3
density = 1200.0
[[support]]
on = { group = "x_min" }
[load]
[time]
step = 1e-3
"#;

#[test]
fn rounding_of_slender_bodies_does_not_show() {
    let Prepared { body, symbolic, .. } = &prepared(SLENDER);
    let order = NodeOrder::new(body);
    let nodes = &order.nodes[..order.n_load];
    let pairs = &order.load_pairs();
    let modes = lowest_modes(body.model.pencil(), symbolic, 12).expect("modes");
    let (vectors, eigenvalues) = (modes.vectors.as_ref(), &modes.eigenvalues[..]);
    let reduced =
        ResidualBasis { body, pencil: body.model.pencil(), symbolic, vectors, eigenvalues, rigorous: true };
    let found = |way| residual_flexibility(&reduced, way, nodes, pairs, &Silent).expect("a residual");
    let [solved, selected] = [BlockMethod::Solves, BlockMethod::Selection].map(found);

    let largest = |a: &[f64]| a.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let off = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |off, (a, b)| off.max((a - b).abs()));
    // At each node relative to what is there.
    let at_nodes = |a: &[Symmetric], b: &[Symmetric]| -> f64 {
        let free = a.iter().zip(b).filter(|(_, b)| largest(*b) > 0.0);
        free.map(|(a, b)| off(a, b) / largest(b)).fold(0.0, f64::max)
    };
    assert!(at_nodes(&selected.contact, &solved.contact) < 1e-6);
    assert!(at_nodes(&selected.gram, &solved.gram) < 1e-3);
    let contact = &solved.contact;
    let pairs = selected.pair_blocks.iter().zip(&solved.pair_blocks).zip(&solved.pairs);
    for ((selected, solved), nodes) in pairs {
        let own = nodes.map(|node| largest(&contact[node as usize]));
        assert!(off(selected, solved) <= 1e-6 * (own[0] * own[1]).sqrt());
    }
    for (selected, solved) in selected.at_nodes.iter().zip(&solved.at_nodes) {
        assert!((selected - solved).abs() <= 1e-3 * solved);
    }

    // What is corrected: without it the error of the factor shows, because it is as large as the first mode.
    let factor = symbolic.factorize(body.model.pencil().stiffness().clone()).expect("a factor");
    let entries = factor.select(body.model.pencil().mass(), 0..symbolic.n(), &Silent).expect("no end");
    let free = (0..nodes.len()).filter(|&place| solved.at_nodes[place] > 0.0);
    let tip = free.min_by(|&a, &b| solved.at_nodes[a].total_cmp(&solved.at_nodes[b])).expect("a node");
    let free = |c: usize| body.model.dofs().free(3 * nodes[tip] as usize + c).expect("free") as usize;
    let plain = |c: usize| {
        let modal = (0..12).map(|k| vectors[(free(c), k)].powi(2) / eigenvalues[k]).sum::<f64>();
        entries.inverse(free(c), free(c)).expect("an entry") - modal
    };
    let exact = full(&solved.contact[tip]);
    let lost = (0..3).map(|c| (plain(c) - exact[c][c]).abs() / exact[c][c]).fold(0.0, f64::max);
    let left = at_nodes(&selected.contact, &solved.contact);
    assert!(lost > 100.0 * left, "a plain difference is off by {lost:e} only, and this by {left:e}");
}
