//! Attachments of a problem as constraints and blocks over the dofs of its body.

use faer::Mat;

use super::body_error::BodyError;
use super::places::{facets, located, select};
use crate::fem::{
    Attachments, Block, BlockGroups, DampingBlock, Material, anchors, facet_matrix, mean_rows, over_gap,
    rigid_row,
};
use crate::input::{CouplingEntry, CouplingKind, EquationNode, EquationTerm, Problem};
use crate::linalg::vec3::{cross, norm, sub};
use crate::linalg::{from_upper, unit};
use crate::mesh::Mesh;
use crate::mesh::select::numbered;
use crate::mesh::surface::Surface;

/// Motions of a reference point: three displacements and three rotations.
const MOTIONS: usize = 6;

/// Largest stiffness of an attachment over that of the body: it is rigid then, and beyond it the rounding of
/// its numbers reaches the first natural frequency of slender bodies.
const STIFFEST: f64 = 1e6;

/// Share of the stiffness times the square of the arm that is the rounding of a product of directions.
const ROUNDING: f64 = 1e-24;

/// First dof of a reference point.
pub(super) fn first_dof(mesh: &Mesh, point: usize) -> u32 {
    (3 * mesh.nodes.len() + MOTIONS * point) as u32
}

/// The attachments of a problem.
///
/// # Errors
/// [`BodyError`]: a selection that fits nothing, a tie of nothing.
pub(super) fn attachments(
    problem: &Problem,
    mesh: &Mesh,
    surface: &Surface,
    materials: &[Material],
) -> Result<Attachments, BodyError> {
    let check = Stiffest::of(problem, mesh, materials);
    let mut found = Attachments { points: problem.reference_places(), ..Attachments::default() };
    let live = problem.live_attachments();
    let group = |name: &Option<String>| {
        let of = |name: &String| live.iter().position(|live| live == name);
        name.as_ref().and_then(of).map_or(0, |place| 1 + place)
    };
    let mut groups = vec![];
    let point = |name: &str| problem.reference_point(name).expect("a checked name of a reference point");
    for (i, coupling) in problem.couplings.iter().enumerate() {
        let (nodes, weights) = if let Some(own) = &coupling.weights {
            let key = || format!("coupling[{i}].weights");
            let ids: Vec<u64> = own.iter().map(|term| term.0).collect();
            let nodes = numbered(&ids, mesh).map_err(|source| located(problem, &key, source))?;
            (nodes, own.iter().map(|term| term.1).collect())
        } else {
            let on = coupling.on.as_ref().expect("a checked coupling has nodes");
            let nodes = select(problem, on, mesh, || format!("coupling[{i}].on"))?;
            let alike = vec![1.0; nodes.len()];
            (nodes, alike)
        };
        couple(problem, mesh, coupling, (&nodes, &weights), (point(&coupling.reference), &mut found));
    }
    for i in 0..problem.ties.len() {
        tie(problem, mesh, surface, i, &mut found)?;
    }
    for (i, ground) in problem.foundations.iter().enumerate() {
        for facet in facets(problem, &ground.on, mesh, surface, || format!("foundation[{i}].on"))? {
            let dofs: Vec<u32> =
                facet.nodes().iter().flat_map(|&node| (0..3).map(move |c| 3 * node + c)).collect();
            let n = dofs.len();
            let of = |normal, tangential| facet_matrix(mesh, &facet, normal, tangential);
            if ground.damping_normal > 0.0 || ground.damping_tangential > 0.0 {
                let damping = of(ground.damping_normal, ground.damping_tangential);
                found.dashpots.push(DampingBlock { dofs: dofs.clone(), damping, group: group(&ground.name) });
            }
            let stiffness = of(ground.normal, ground.tangential);
            check.block(&stiffness, false, || format!("foundation[{i}]"))?;
            groups.push(group(&ground.name));
            found.blocks.push(Block { dofs, stiffness, mass: Mat::zeros(n, n) });
        }
    }
    for (i, equation) in problem.equations.iter().enumerate() {
        let key = || format!("equation[{i}].terms");
        let dof = |term: &EquationTerm| -> Result<(u32, f64), BodyError> {
            let EquationTerm(node, component, coefficient) = term;
            let first = match node {
                EquationNode::Point(name) => first_dof(mesh, point(name)),
                EquationNode::Node(id) => {
                    let found = numbered(&[*id], mesh).map_err(|source| located(problem, &key, source))?;
                    3 * found[0]
                }
            };
            Ok((first + u32::from(component - 1), *coefficient))
        };
        let terms = equation.terms.iter().map(dof).collect::<Result<Vec<_>, _>>()?;
        found.constraints.equate(terms, format!("the equation {} of the problem", i + 1));
    }
    for mass in &problem.point_masses {
        let [xx, yy, zz, xy, xz, yz] = mass.inertia;
        let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        // Off the diagonal a tensor has the products with a minus.
        let of = |i: usize, j: usize| match (i.checked_sub(3), j.checked_sub(3)) {
            (None, None) if i == j => mass.mass,
            (Some(i), Some(j)) => {
                if i == j {
                    inertia[i][j]
                } else {
                    -inertia[i][j]
                }
            }
            _ => 0.0,
        };
        groups.push(group(&mass.name));
        let first = first_dof(mesh, point(&mass.reference));
        let n = if mass.inertia == [0.0; 6] { 3 } else { MOTIONS };
        found.blocks.push(Block {
            dofs: (first..first + n as u32).collect(),
            stiffness: Mat::zeros(n, n),
            mass: Mat::from_fn(n, n, of),
        });
    }
    for (i, spring) in problem.springs.iter().enumerate() {
        let ends = ends_of(problem, &spring.from, spring.to.as_deref());
        let (dofs, stiffness) = match (&spring.stiffness, &spring.matrix) {
            (Some(numbers), _) => between(problem, mesh, &ends, (numbers, spring.axes)),
            (None, matrix) => {
                let dofs = dofs_of(mesh, &ends);
                let triangle = matrix.as_ref().expect("a checked spring has a stiffness");
                let stiffness = from_upper(triangle, dofs.len());
                (dofs, stiffness)
            }
        };
        check.block(&stiffness, true, || {
            format!("spring[{i}].{}", if spring.matrix.is_some() { "matrix" } else { "stiffness" })
        })?;
        let mass = Mat::zeros(dofs.len(), dofs.len());
        groups.push(group(&spring.name));
        found.blocks.push(Block { dofs, stiffness, mass });
    }
    for dashpot in &problem.dashpots {
        let ends = ends_of(problem, &dashpot.from, dashpot.to.as_deref());
        let (dofs, damping) = between(problem, mesh, &ends, (&dashpot.damping, dashpot.axes));
        found.dashpots.push(DampingBlock { dofs, damping, group: group(&dashpot.name) });
    }
    for (i, point) in problem.reference_points.iter().enumerate() {
        let first = first_dof(mesh, i);
        point.held.iter().for_each(|&motion| found.constraints.hold(first + motion as u32, 0.0));
    }
    found.groups = problem.splits_regions().then_some(BlockGroups { count: live.len(), of_blocks: groups });
    hold_unmoved(problem, mesh, &mut found);
    Ok(found)
}

/// The stiffness of a body, which attachments are compared with.
struct Stiffest<'a> {
    problem: &'a Problem,
    /// Largest modulus times longest side \[N/m\], and that side \[m\].
    body: f64,
    side: f64,
}

impl<'a> Stiffest<'a> {
    fn of(problem: &'a Problem, mesh: &Mesh, materials: &[Material]) -> Self {
        let (low, high) = mesh.bounding_box();
        let side = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
        let modulus = materials.iter().map(|material| material.elasticity.modulus()).fold(0.0, f64::max);
        Self { problem, body: modulus * side, side }
    }

    /// Checks a stiffness over displacements of nodes, or over the six motions of points.
    fn block(
        &self,
        stiffness: &Mat<f64>,
        of_points: bool,
        key: impl Fn() -> String,
    ) -> Result<(), BodyError> {
        let turns = |i: usize| of_points && i % MOTIONS > 2;
        let entry = |i: usize| stiffness[(i, i)] / if turns(i) { self.side.powi(2) } else { 1.0 };
        let ratio = (0..stiffness.nrows()).map(entry).fold(0.0, f64::max) / self.body;
        if ratio <= STIFFEST {
            return Ok(());
        }
        let (path, key) = (self.problem.place(&key()), key());
        Err(BodyError::TooStiff { path, key, ratio, body: self.body, most: STIFFEST })
    }
}

/// Equations of a coupling.
fn couple(
    problem: &Problem,
    mesh: &Mesh,
    coupling: &CouplingEntry,
    (nodes, weights): (&[u32], &[f64]),
    (point, found): (usize, &mut Attachments),
) {
    let (at, first) = (problem.reference_points[point].at, first_dof(mesh, point));
    let origin = format!("a coupling of the reference point `{}`", coupling.reference);
    match coupling.kind {
        CouplingKind::Rigid => {
            let components: Vec<usize> = match &coupling.components {
                None => vec![0, 1, 2],
                Some(components) => components.iter().map(|component| *component as usize).collect(),
            };
            for &node in nodes {
                let d = sub(mesh.nodes[node as usize], at);
                for &c in &components {
                    let of_point = (first..).zip(rigid_row(d, c)).filter(|term| term.1 != 0.0);
                    let own = std::iter::once((3 * node + c as u32, 1.0));
                    let terms = own.chain(of_point.map(|(dof, a)| (dof, -a))).collect();
                    found.constraints.equate(terms, origin.as_str());
                }
            }
        }
        CouplingKind::Average => {
            let places = nodes.iter().map(|&node| mesh.nodes[node as usize]);
            let cloud: Vec<([f64; 3], f64)> = places.zip(weights.iter().copied()).collect();
            let rows = mean_rows(at, &cloud);
            for c in 0..MOTIONS {
                let of_nodes = nodes.iter().zip(&rows).flat_map(|(&node, row)| {
                    (0..3).map(move |k| (3 * node + k, -row[c][k as usize])).filter(|term| term.1 != 0.0)
                });
                let terms = std::iter::once((first + c as u32, 1.0)).chain(of_nodes).collect();
                found.constraints.equate(terms, origin.as_str());
            }
        }
    }
}

/// Equations of a tie.
fn tie(
    problem: &Problem,
    mesh: &Mesh,
    surface: &Surface,
    index: usize,
    found: &mut Attachments,
) -> Result<(), BodyError> {
    let entry = &problem.ties[index];
    let followers = select(problem, &entry.on, mesh, || format!("tie[{index}].on"))?;
    let facets = facets(problem, &entry.to, mesh, surface, || format!("tie[{index}].to"))?;
    let points: Vec<[f64; 3]> = followers.iter().map(|&node| mesh.nodes[node as usize]).collect();
    let mut tied = 0;
    for (&node, anchor) in followers.iter().zip(anchors(mesh, &facets, &points)) {
        let Some(anchor) = anchor.filter(|anchor| anchor.distance <= entry.distance) else { continue };
        if anchor.weights.iter().any(|(other, _)| *other == node) {
            continue;
        }
        tied += 1;
        let at = |node: u32| mesh.nodes[node as usize];
        let gap = if problem.is_free() { over_gap(at, at(node), &anchor) } else { vec![] };
        for c in 0..3 {
            let facet = anchor.weights.iter().map(|&(other, w)| (3 * other + c, -w));
            let turned = gap.iter().map(|&(dof, weights)| (dof, -weights[c as usize]));
            let terms = std::iter::once((3 * node + c, 1.0)).chain(facet).chain(turned);
            let origin = format!("the tie {} of the problem", index + 1);
            found.constraints.equate(terms.filter(|term| term.1 != 0.0).collect(), origin);
        }
    }
    if tied == 0 {
        let path = problem.place(&format!("tie[{index}]"));
        return Err(BodyError::LooseTie { path, distance: entry.distance });
    }
    Ok(())
}

/// Reference points of the ends of a spring or a dashpot.
fn ends_of(problem: &Problem, from: &str, to: Option<&str>) -> Vec<usize> {
    let place = |name| problem.reference_point(name).expect("a checked name of a reference point");
    [Some(from), to].into_iter().flatten().map(place).collect()
}

/// The six motions of each end.
fn dofs_of(mesh: &Mesh, ends: &[usize]) -> Vec<u32> {
    ends.iter().flat_map(|&end| (0..MOTIONS as u32).map(move |c| first_dof(mesh, end) + c)).collect()
}

/// Dofs and matrix of a spring or a dashpot, by its six numbers and its axes: it acts on the motion of the
/// second point against the first one, taken where the first one is.
fn between(
    problem: &Problem,
    mesh: &Mesh,
    ends: &[usize],
    (numbers, axes): (&[f64; 6], Option<[[f64; 3]; 2]>),
) -> (Vec<u32>, Mat<f64>) {
    let axes = match axes {
        None => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        Some([first, second]) => {
            let (first, second) = (unit(first), unit(second));
            [first, second, cross(first, second)]
        }
    };
    let k = |i: usize, j: usize| -> f64 {
        if i / 3 != j / 3 {
            return 0.0;
        }
        (0..3).map(|a| numbers[3 * (i / 3) + a] * axes[a][i % 3] * axes[a][j % 3]).sum()
    };
    let own = Mat::from_fn(MOTIONS, MOTIONS, k);
    // Motion of its place with each end.
    let places: Vec<[f64; 3]> = ends.iter().map(|&end| problem.reference_points[end].at).collect();
    let row = |end: usize, i: usize, j: usize| -> f64 {
        let sign = if end == 0 { -1.0 } else { 1.0 };
        let moved =
            if i < 3 { rigid_row(sub(places[0], places[end]), i)[j] } else { f64::from(u8::from(i == j)) };
        sign * moved
    };
    let n = MOTIONS * ends.len();
    let motion = Mat::from_fn(MOTIONS, n, |i, j| row(j / MOTIONS, i, j % MOTIONS));
    let product = motion.transpose() * &own * &motion;
    // A rotation about an arm along the spring moves it by rounding alone.
    let arm = places.iter().map(|&place| norm(sub(places[0], place))).fold(0.0, f64::max);
    let largest = numbers[..3].iter().fold(0.0, |most: f64, k| most.max(*k)) * arm * arm;
    let moves = |i: usize| i % MOTIONS < 3 || product[(i, i)] > ROUNDING * largest;
    (dofs_of(mesh, ends), {
        let entry = |i: usize, j: usize| 0.5 * (product[(i, j)] + product[(j, i)]);
        Mat::from_fn(n, n, |i, j| if moves(i) && moves(j) { entry(i, j) } else { 0.0 })
    })
}

/// Holds motions of reference points that nothing has a part in.
fn hold_unmoved(problem: &Problem, mesh: &Mesh, found: &mut Attachments) {
    let first = first_dof(mesh, 0);
    let mut moved = vec![false; MOTIONS * problem.reference_points.len()];
    let mut mark = |dof: u32| {
        if let Some(place) = dof.checked_sub(first) {
            moved[place as usize] = true;
        }
    };
    found.constraints.dofs().for_each(&mut mark);
    for block in &found.blocks {
        for (row, &dof) in block.dofs.iter().enumerate() {
            let matrices = [&block.stiffness, &block.mass];
            if matrices.iter().any(|matrix| matrix[(row, row)] != 0.0) {
                mark(dof);
            }
        }
    }
    let unmoved = (first..).zip(moved).filter(|(_, moved)| !moved);
    let unmoved: Vec<u32> = unmoved.map(|(dof, _)| dof).collect();
    unmoved.into_iter().for_each(|dof| found.constraints.hold(dof, 0.0));
}
