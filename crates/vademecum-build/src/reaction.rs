//! Reactions: the force and the moment that each support exerts on the body.
//!
//! ```text
//! Φ_S = −K_ff⁻¹ K_fs T_S        L_S = Bᵀ(M_ff Φ_S + M_fs T_S)
//! r_S = −Φ_Sᵀ f_f − T_Sᵀ f_s + L_Sᵀ(ζ̈ + α ζ̇)
//! ```
//!
//! `T_S` are the six rigid motions of a support at the dofs that it holds. `Φ_S` is the shape that the body
//! takes at rest when the support is moved so and all others stay. Tested with `[Φ_S; T_S]`, the equation of
//! motion over all dofs has no elastic force, so that loads and inertia are all that is left of the reaction.
//!
//! With live regions `Φ_S` is the shape as built. The file keeps the force `K_q [Φ_S; T_S]` and the inertia
//! of each live region along the basis, from which the evaluator corrects shape and inertia.
//!
//! When all supports move alike the body moves as a rigid one. So the last support needs no solve: its shape
//! is the rigid motion less those of the others, and reactions are in equilibrium to rounding. A body with
//! attachments may be held by them too, and every support has its solve.

use faer::{Mat, MatRef};

use crate::fem::{FactorError, Solve, Symbolic};
use crate::linalg::vec3::cross;
use crate::prepared::{Body, LiveRegions, Support};

/// Reactions at the supports as stored in a file: force, then moment about the support's point.
#[derive(Clone, Debug)]
pub struct Reactions {
    /// `L_Sᵀ` of each support, shape (6, r).
    pub basis: Vec<Mat<f64>>,
    /// Of each support under a unit force at each loadable node that stays: row the component of the
    /// reaction, column that of the force.
    pub nodes: Vec<Vec<[f64; 18]>>,
    /// Of each support under each pattern that stays: a list for each pattern.
    pub patterns: Vec<Vec<[f64; 6]>>,
    /// `(K_q [Φ_S; T_S])ᵀB` and `(M_q [Φ_S; T_S])ᵀB` of what is not live and of each live region, shape (6,
    /// r), one support after the other; empty without live regions.
    pub(crate) regions: Vec<[Mat<f64>; 2]>,
    /// True if all shapes are rigid motions, which no stiffness resists.
    pub(crate) rigid: bool,
}

/// The reactions of a body with supports, in the basis `B` of shape (n, r), for forces at the loadable nodes
/// in the order given, with live regions or none. Six solves for each support but the last.
///
/// # Errors
/// [`FactorError`]: a stiffness that does not factorise.
pub(crate) fn reactions(
    body: &Body,
    symbolic: &Symbolic,
    vectors: MatRef<'_, f64>,
    nodes: &[u32],
    live: Option<&LiveRegions>,
) -> Result<Reactions, FactorError> {
    let model = &body.model;
    let (dofs, supports) = (model.dofs(), &body.supports);
    // All motions are about one point near the supports first, so that they can be added.
    let count = supports.len().max(1) as f64;
    let centre = std::array::from_fn(|c| supports.iter().map(|s| s.point[c] / count).sum());
    let place = |dof: u32| model.mesh().nodes[dof as usize / 3];
    let mut left = Mat::zeros(dofs.n_free(), 6);
    for motion in 0..6 {
        let of_dof = |dof: u32| rigid(place(dof), centre, motion)[dof as usize % 3];
        let whole: Vec<f64> = (0..dofs.n_dof() as u32).map(of_dof).collect();
        dofs.restrict_into(&whole, left.col_as_slice_mut(motion));
    }
    // Springs to the ground and held reference points do not move with the supports, and a body under loads
    // resists a turn.
    let alone = model.is_bare();
    let last = supports.iter().rposition(|support| alone && !support.dofs.is_empty());
    let patterns = vec![vec![]; body.patterns.len()];
    let mut found = Reactions {
        basis: vec![],
        nodes: vec![],
        patterns,
        regions: vec![],
        rigid: alone && supports.len() == 1,
    };
    for (index, support) in supports.iter().enumerate() {
        let mut held = Mat::zeros(dofs.n_dof(), 6);
        for &dof in &support.dofs {
            for motion in 0..6 {
                held[(dof as usize, motion)] = rigid(place(dof), centre, motion)[dof as usize % 3];
            }
        }
        let [stiff, heavy] = model.couple(held.as_ref());
        let shape = if Some(index) == last {
            left.clone()
        } else {
            let factor = symbolic.factor_of(model.pencil().stiffness())?;
            let mut shape = -stiff;
            Solve::new(symbolic, 6, true).solve_in_place(&factor, shape.as_mut());
            left -= &shape;
            shape
        };
        let shift = about(support, centre);
        let [shape, held, heavy] = [shape, held, heavy].map(|columns| columns * &shift);
        if let Some(live) = live {
            found.add_regions(body, vectors, live, [&shape, &held]);
        }
        found.add(body, vectors, nodes, [&shape, &held, &heavy]);
    }
    Ok(found)
}

impl Reactions {
    /// Adds what live regions have in a support, by its shape `Φ` and its motion `T` over all dofs.
    fn add_regions(
        &mut self,
        body: &Body,
        vectors: MatRef<'_, f64>,
        live: &LiveRegions,
        [shape, held]: [&Mat<f64>; 2],
    ) {
        let (model, pencil) = (&body.model, body.model.pencil());
        for own in 0..=live.count as u32 {
            let is_own = |region: usize| live.of_mesh[region] == own;
            let [mut stiff, mut heavy] = model.couple_regions(held.as_ref(), &is_own);
            let mut image = Mat::zeros(shape.nrows(), shape.ncols());
            for region in (0..live.of_mesh.len()).filter(|&region| is_own(region)) {
                pencil.region_stiffness(region).mul_into(shape.as_ref(), image.as_mut());
                stiff += &image;
                pencil.region_mass(region).mul_into(shape.as_ref(), image.as_mut());
                heavy += &image;
            }
            self.regions.push([stiff.transpose() * vectors, heavy.transpose() * vectors]);
        }
    }

    /// Adds a support by its shape `Φ`, its motion `T` over all dofs and `M_fs T`.
    fn add(
        &mut self,
        body: &Body,
        vectors: MatRef<'_, f64>,
        nodes: &[u32],
        [shape, held, heavy]: [&Mat<f64>; 3],
    ) {
        let dofs = body.model.dofs();
        let mut inertia = Mat::zeros(shape.nrows(), 6);
        body.model.pencil().mass().mul_into(shape.as_ref(), inertia.as_mut());
        inertia += heavy;
        self.basis.push(inertia.transpose() * vectors);
        // Row of a dof, as a load on it is carried.
        let carried = |dof: usize, motion: usize| match dofs.is_held(dof) {
            false => -dofs.value(dof, |free| shape[(free, motion)]),
            true => -held[(dof, motion)],
        };
        let at = |&node: &u32| std::array::from_fn(|k| carried(3 * node as usize + k % 3, k / 3));
        self.nodes.push(nodes.iter().map(at).collect());
        let loads = body.patterns.iter().zip(&body.held_loads);
        for (((_, force), on_held), out) in loads.zip(&mut self.patterns) {
            out.push(std::array::from_fn(|motion| {
                let free = shape.col_as_slice(motion).iter().zip(force).map(|(shape, f)| shape * f);
                let held = on_held.iter().map(|&(dof, f)| held[(dof as usize, motion)] * f);
                -(free.sum::<f64>() + held.sum::<f64>())
            }));
        }
    }
}

/// A rigid motion of the point `x`: along an axis, or about one through `centre`.
fn rigid(x: [f64; 3], centre: [f64; 3], motion: usize) -> [f64; 3] {
    let axis = motion % 3;
    let unit = std::array::from_fn(|c| if c == axis { 1.0 } else { 0.0 });
    if motion < 3 {
        return unit;
    }
    cross(unit, std::array::from_fn(|c| x[c] - centre[c]))
}

/// Takes motions about `centre` to those about the point of a support: columns are what each is made of.
fn about(support: &Support, centre: [f64; 3]) -> Mat<f64> {
    Mat::from_fn(6, 6, |row, column| {
        if row == column {
            1.0
        } else if row < 3 && column >= 3 {
            // e × (x − p) = e × (x − c) + e × (c − p).
            rigid(centre, support.point, column)[row]
        } else {
            0.0
        }
    })
}
