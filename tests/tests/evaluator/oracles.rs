//! Published problems, reproduced to their printed digits by a vademecum: matrices → full basis → file →
//! evaluator.
//!
//! With a full basis nothing is projected away, so the file must repeat what the scheme prints, whatever the
//! basis. The numbers are those of `vademecum-build`'s full-order oracles (Bathe 2014, the two-dof system;
//! Bathe and Noh 2012, stiff and soft springs), and a number printed with d decimals is met when the error is
//! below half a unit of the last. The full-order oracles check the schemes; these check what becomes of a
//! scheme in a file and in the evaluator, in files of the builder's parts and in files of numbers worked out
//! by hand.

use vademecum_build::Matrix;
use vademecum_build::dynamics::{SchemeKind, lowest_modes};
use vademecum_build::fem::{Pencil, Symbolic};
use vademecum_eval::{Contact, Field, Loads, Place, Scene, SceneOptions, Structure, StructureChoice};
use vademecum_format::scheme::SchemeTable;
use vademecum_tests::matrices::MatrixFile;
use vademecum_tests::stage::with_scene;
use vademecum_tests::{by_hand, synthetic};

fn matrix(rows: [[f64; 2]; 2]) -> Matrix {
    Matrix::from_fn(2, 2, |i, j| rows[i][j])
}

fn pencil(mass: [[f64; 2]; 2], stiffness: [[f64; 2]; 2]) -> Pencil {
    Pencil::from_matrices(matrix(mass).as_ref(), matrix(stiffness).as_ref()).expect("symmetric matrices")
}

fn bathe() -> SchemeTable {
    SchemeKind::default().table().expect("a scheme without parameters")
}

fn trapezoidal() -> SchemeTable {
    SchemeKind::Newmark { beta: 0.25, gamma: 0.5 }.table().expect("unconditionally stable")
}

fn two_dof() -> Pencil {
    pencil([[2.0, 0.0], [0.0, 1.0]], [[6.0, -2.0], [-2.0, 4.0]])
}

/// A file in the exact eigenvectors, or in a basis that mixes them, and the structure to march.
#[derive(Clone, Copy, Debug)]
enum Road {
    EigenvectorsDiagonal,
    EigenvectorsBlock,
    /// `M^-½` turned by 0.6 rad: full, M-orthonormal, and `BᵀKB` is full too.
    MixedBlock,
}

const ROADS: [Road; 3] = [Road::EigenvectorsDiagonal, Road::EigenvectorsBlock, Road::MixedBlock];

impl Road {
    fn basis(self, pencil: &Pencil) -> Matrix {
        if matches!(self, Road::MixedBlock) {
            let scale = |i: usize| 1.0 / pencil.mass().diagonal(i).sqrt();
            let (sine, cosine) = 0.6f64.sin_cos();
            let turn = [[cosine, -sine], [sine, cosine]];
            return Matrix::from_fn(2, 2, |i, j| scale(i) * turn[i][j]);
        }
        let symbolic = Symbolic::analyze(pencil).expect("a pattern");
        lowest_modes(pencil, &symbolic, 2).expect("two modes").vectors
    }

    fn structure(self) -> (StructureChoice, Structure) {
        match self {
            Road::EigenvectorsDiagonal => (StructureChoice::Diagonal, Structure::Diagonal),
            _ => (StructureChoice::Block, Structure::Block),
        }
    }

    fn file(self, pencil: &Pencil, scheme: &SchemeTable, time_step: f64, drive: &[f64]) -> Vec<u8> {
        let basis = self.basis(pencil);
        let diagonal = !matches!(self, Road::MixedBlock);
        MatrixFile { pencil, basis: &basis, diagonal, scheme, time_step, drive }.bytes()
    }
}

/// Where a file of the two-dof problem comes from.
#[derive(Clone, Copy, Debug)]
enum TwoDof {
    /// The builder's parts; R is a contact.
    Built(Road),
    /// Numbers worked out by hand, the scheme's table among them; R is a load pattern.
    ByHand(StructureChoice),
}

const TWO_DOF: [TwoDof; 5] = [
    TwoDof::Built(ROADS[0]),
    TwoDof::Built(ROADS[1]),
    TwoDof::Built(ROADS[2]),
    TwoDof::ByHand(StructureChoice::Diagonal),
    TwoDof::ByHand(StructureChoice::Block),
];

#[derive(Clone, Copy, Debug)]
enum Scheme {
    Bathe,
    Trapezoidal,
}

impl TwoDof {
    fn file(self, scheme: Scheme, time_step: f64) -> Vec<u8> {
        match (self, scheme) {
            (Self::Built(road), Scheme::Bathe) => road.file(&two_dof(), &bathe(), time_step, &[0.0; 2]),
            (Self::Built(road), Scheme::Trapezoidal) => {
                road.file(&two_dof(), &trapezoidal(), time_step, &[0.0; 2])
            }
            (Self::ByHand(_), Scheme::Bathe) => by_hand::file(&synthetic::bathe(), time_step),
            (Self::ByHand(_), Scheme::Trapezoidal) => {
                by_hand::file(&synthetic::newmark(0.25, 0.5), time_step)
            }
        }
    }

    fn structure(self) -> (StructureChoice, Structure) {
        match self {
            Self::Built(road) => road.structure(),
            Self::ByHand(StructureChoice::Diagonal) => (StructureChoice::Diagonal, Structure::Diagonal),
            Self::ByHand(choice) => (choice, Structure::Block),
        }
    }

    fn load(self, scene: &Scene<'_, f64>, loads: &mut Loads<'_, f64>) {
        let contact = Contact::new(Place::triangle([0; 3], [1.0, 0.0, 0.0]), [0.0, 10.0, 0.0]);
        match self {
            Self::Built(_) => loads.add_contact(scene, &contact).expect("a loadable node"),
            Self::ByHand(_) => loads.add_pattern(scene, 0, 1.0).expect("a pattern"),
        }
    }

    /// Displacements after each step under the held load, the start included; `changed` is a time step that
    /// the file is bound with.
    fn march(self, scheme: Scheme, time_step: f64, changed: Option<f64>, steps: usize) -> Vec<[f64; 2]> {
        let bytes = self.file(scheme, time_step);
        let (structure, expected) = self.structure();
        let options = SceneOptions { structure, time_step: changed, ..SceneOptions::default() };
        with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
            assert_eq!(scene.structure(), expected);
            self.load(scene, loads);
            scene.set(state, &[0.0; 2], &[0.0; 2], loads).expect("the initial acceleration");
            let mut path = vec![[0.0; 2]];
            for _ in 0..steps {
                scene.step(state, loads).expect("a step");
                let [u1, u2, none] = scene.node(state, 0, Field::Displacement).expect("a node");
                assert_eq!(none, 0.0, "the third component has no dof");
                path.push([u1, u2]);
            }
            path
        })
    }

    fn assert_printed(self, found: [f64; 2], printed: [f64; 2], unit: f64) {
        for (found, printed) in found.into_iter().zip(printed) {
            assert!(
                (found - printed).abs() <= 0.5 * unit * (1.0 + 1e-9),
                "{self:?}: {found} is not the printed {printed}"
            );
        }
    }
}

#[test]
fn two_dof_problem_by_bathe_matches_the_printed_digits() {
    for file in TWO_DOF {
        let path = file.march(Scheme::Bathe, 0.28, None, 12);
        file.assert_printed(path[1], [0.004576, 0.373228], 1e-6);
        file.assert_printed(path[6], [1.618358, 5.312445], 1e-6);
        file.assert_printed(path[12], [1.279425, 2.397547], 1e-6);
    }
}

#[test]
fn two_dof_problem_by_the_trapezoidal_rule_matches_the_published_step() {
    for file in TWO_DOF {
        let path = file.march(Scheme::Trapezoidal, 0.28, None, 12);
        file.assert_printed(path[12], [1.40, 2.31], 1e-2);
    }
}

#[test]
fn two_dof_problem_with_a_huge_step_goes_to_the_static_answer() {
    for file in TWO_DOF {
        let built = file.march(Scheme::Bathe, 28.0, None, 30);
        // The diagonal structure takes another time step when it is bound.
        let changed = (file.structure().1 == Structure::Diagonal)
            .then(|| file.march(Scheme::Bathe, 0.28, Some(28.0), 30));
        for path in std::iter::once(built).chain(changed) {
            file.assert_printed(path[1], [1.041138, 3.064947], 1e-6);
            // Each step leaves about 2 % of the distance; 30 steps leave nothing above rounding.
            file.assert_printed(path[30], [1.0, 3.0], 1e-9);
        }
    }
}

/// What a vademecum of the stiff and the soft spring tells at each step: u3 and the acceleration of the
/// second mass.
///
/// The evaluator reads displacements and velocities; the acceleration comes from its saved state, `Δt² ζ̈`.
fn springs_march(road: Road, scheme: &SchemeTable) -> Vec<(f64, f64)> {
    const DT: f64 = 0.2618;
    let (k1, k2) = (1e7, 1.0);
    let pencil = pencil([[1.0, 0.0], [0.0, 1.0]], [[k1 + k2, -k2], [-k2, k2]]);
    let bytes = road.file(&pencil, scheme, DT, &[k1, 0.0]);
    let basis = road.basis(&pencil);
    let options = SceneOptions { structure: road.structure().0, ..SceneOptions::default() };
    with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
        let instants = scene.instants();
        let drive = |step: usize| instants.map(|c| (1.2 * (step as f64 + c) * DT).sin());
        loads.add_pattern_staged(scene, 0, &drive(0)).expect("a pattern");
        scene.set(state, &[0.0; 2], &[0.0; 2], loads).expect("the initial acceleration");
        let mut path = vec![];
        for step in 0..40 {
            loads.clear();
            loads.add_pattern_staged(scene, 0, &drive(step)).expect("a pattern");
            scene.step(state, loads).expect("a step");
            let u3 = scene.node(state, 0, Field::Displacement).expect("a node")[1];
            let scaled = state.scaled_acceleration();
            let a2 = (0..2).map(|k| basis[(0, k)] * scaled[k]).sum::<f64>() / (DT * DT);
            path.push((u3, a2));
        }
        path
    })
}

#[test]
fn bathe_damps_the_stiff_spring_at_once() {
    for road in ROADS {
        let path = springs_march(road, &bathe());
        assert!((path[39].0 + 2.269068).abs() <= 0.5e-6, "{road:?}: u3 = {}", path[39].0);
        assert!((path[0].1 + 23.3).abs() <= 0.05, "{road:?}: a2 = {}", path[0].1);
        // u2 follows u1, whose acceleration is at most 1.44; the method's own transient is over after a few
        // steps.
        assert!(path[4..].iter().all(|(_, a2)| a2.abs() < 2.0 * 1.44), "{road:?}");
    }
}

#[test]
fn the_trapezoidal_rule_lets_the_stiff_spring_ring() {
    for road in ROADS {
        let path = springs_march(road, &trapezoidal());
        let largest = path.iter().map(|(_, a2)| a2.abs()).fold(0.0, f64::max);
        assert!((largest - 735.0).abs() <= 0.5, "{road:?}: {largest}");
    }
}
