//! A file and what it shows of a push: with the modes alone, with the residual flexibility at contacts, and
//! with whole static fields.

use vademecum_build::Matrix;
use vademecum_build::export::NodeOrder;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::Prepared;
use vademecum_build::progress::Silent;
use vademecum_eval::{Contact, Field, Place, Scene, SceneOptions, State, StaticField, SurfacePoint};
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{File, SectionKind};
use vademecum_study::contents::numbers;
use vademecum_study::verify::free_basis;

use super::bodies::RealBody;
use super::push::{HISTORIES, Push, STEPS};
use crate::stage::with_scene;

/// A file of a body in memory.
pub(super) struct Built {
    pub modes: usize,
    bytes: Vec<u8>,
    /// `B` over the free dofs, shape (n, r).
    pub basis: Matrix,
    /// `λ` of its modes, ascending \[rad²/s²\].
    pub eigenvalues: Vec<f64>,
    /// `G` of each loadable node \[kg m²/N²\]: xx, xy, xz, yy, yz, zz.
    gram: Vec<[f64; 6]>,
}

/// What a file shows of a push under one history.
pub(super) struct Shown {
    /// ζ, shape (r, instants).
    pub coordinates: Matrix,
    /// The displacement under the force along it, shape (1, instants): with the modes alone, and with the
    /// residual flexibility.
    pub under: [Matrix; 2],
}

/// Static fields of a push: what is shown at the contact, and everywhere.
pub(super) const SHOWN: usize = 2;

impl Built {
    pub fn new(
        body: &RealBody,
        (prepared, order): (&Prepared, &NodeOrder),
        step: f64,
        modes: usize,
        ratio: f64,
    ) -> Built {
        let problem = body.problem(step, modes, ratio);
        // The record says how large the error is, whatever the tolerance.
        let built =
            build(&problem, &BuildOptions::default(), &Silent).unwrap_or_else(|error| panic!("{error}"));
        let bytes = built.either().bytes;
        let file = File::parse(&bytes).expect("a file");
        let basis = free_basis(&file, &prepared.body, &order.nodes).expect("the basis of a whole file");
        let eigenvalues = numbers(&file, SectionKind::Eigenvalues).expect("raw");
        let rows = numbers(&file, SectionKind::BoundMap).expect("raw");
        let gram =
            rows.as_chunks::<7>().0.iter().map(|&[xx, xy, xz, yy, yz, zz, _]| [xx, xy, xz, yy, yz, zz]);
        let gram = gram.collect();
        Built { modes, bytes, basis, eigenvalues, gram }
    }

    /// `‖RF‖_M` at most, as the file knows it: the sum over the corners of the place.
    pub fn bound(&self, push: &Push, order: &NodeOrder) -> f64 {
        let [x, y, z] = push.force;
        let squares = [x * x, 2.0 * x * y, 2.0 * x * z, y * y, 2.0 * y * z, z * z];
        let at = |node: u32| {
            let gram = &self.gram[order.file_node[node as usize] as usize];
            gram.iter().zip(squares).map(|(g, f)| g * f).sum::<f64>().max(0.0).sqrt()
        };
        push.nodes.iter().zip(push.weights).map(|(&node, weight)| weight * at(node)).sum()
    }

    /// Steps the push through the evaluator under one of the histories.
    pub fn show(&self, push: &Push, order: &NodeOrder, history: usize) -> Shown {
        let contact = contact(push, order);
        let alone = SceneOptions { residual: false, ..SceneOptions::default() };
        let (_, without) = self.step(&alone, &contact, history);
        let (coordinates, with) = self.step(&SceneOptions::default(), &contact, history);
        Shown { coordinates, under: [without, with] }
    }

    fn step(&self, options: &SceneOptions, contact: &Contact, history: usize) -> (Matrix, Matrix) {
        let point = SurfacePoint { place: contact.place, position: [0.0; 3], distance: 0.0 };
        with_scene::<f64, _>(&self.bytes, options, |scene, state, loads| {
            let time_step = scene.parameters().time_step;
            let when = HISTORIES[history].history(time_step);
            let mut coordinates = Matrix::zeros(self.modes, 1 + STEPS);
            let mut under = Matrix::zeros(1, 1 + STEPS);
            for step in 0..STEPS {
                let [start, end] = [step, step + 1].map(|n| n as f64 * time_step);
                let mut factors = [0.0; 1 + MAX_STAGES];
                (factors[0], factors[1]) = (when.just_after(start), when.just_before(end));
                loads.clear();
                if factors != [0.0; 1 + MAX_STAGES] {
                    loads.add_contact_staged(scene, contact, &factors).expect("a contact");
                }
                scene.step(state, loads).expect("a step");
                coordinates.col_as_slice_mut(step + 1).copy_from_slice(state.zeta());
                let moved = scene.point(state, &point, Field::Displacement).expect("a point");
                under[(0, step + 1)] = moved.iter().zip(contact.force).map(|(u, f)| u * f).sum();
            }
            (coordinates, under)
        })
    }

    /// What fields show beside the modes at factor 1 on the force, over the free dofs: at the contact, and
    /// everywhere.
    pub fn statics(&self, push: &Push, (prepared, order): (&Prepared, &NodeOrder)) -> [Vec<f64>; SHOWN] {
        let contact = &contact(push, order);
        with_scene::<f64, _>(&self.bytes, &SceneOptions::default(), |scene, state, loads| {
            loads.add_contact(scene, contact).expect("a contact");
            let zero = vec![0.0; self.modes];
            scene.set(state, &zero, &zero, loads).expect("a state");
            let mut shown = [vec![0.0; 3 * order.nodes.len()], vec![0.0; 3 * order.nodes.len()]];
            scene.body_into(state, Field::Displacement, &mut shown[0]).expect("a field");
            whole_into(scene, state, &mut shown[1]);
            let at = |field: &[f64], dof: u32| {
                field[3 * order.file_node[dof as usize / 3] as usize + dof as usize % 3]
            };
            let free = prepared.body.model.dofs().dof_of_free();
            shown.map(|field| free.iter().map(|&dof| at(&field, dof)).collect())
        })
    }
}

fn contact(push: &Push, order: &NodeOrder) -> Contact {
    let nodes = push.nodes.map(|node| order.file_node[node as usize]);
    Contact::new(Place::triangle(nodes, push.weights), push.force)
}

fn whole_into(scene: &Scene<'_, f64>, state: &State<'_, f64>, out: &mut [f64]) {
    let [answer, rest] = scene.static_field_sizes();
    let (mut answer, mut rest) = (vec![0.0; answer], vec![0.0; rest]);
    let mut statics = StaticField::new(scene, &mut answer, &mut rest).expect("room");
    scene.solve_static_field(state, &mut statics).expect("the factor");
    scene.body_with(state, Field::Displacement, &mut statics, out).expect("a field");
}
