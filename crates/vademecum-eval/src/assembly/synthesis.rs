//! Component mode synthesis with residual flexibility, the forces of the joints eliminated.
//!
//! With the coordinates `q` of all parts, `u = B q + R F`, and rows `g = Γ q + G R F + S f` of the joints
//! that are zero, or the offset `g₀` of a joint made as it stands, `S = G R Gᵀ + C` and `N = G R M R Gᵀ`:
//!
//! ```text
//! f  = −S⁻¹(Γ q + G R F − g₀)    L = S⁻¹Γ
//! K' = Λ + ΓᵀL                   M' = I + LᵀN L
//! K' Y = M' Y Ω                  YᵀM'Y = I          q = Y η
//! ```
//!
//! With `N` this is Rubin's synthesis (1975), without it MacNeal's (1971). `K'` is positive semidefinite,
//! since the forces are eliminated and are no unknowns (compare Rixen 2004).

use crate::assembly::counts::{Counts, with_firsts};
use crate::assembly::error::{AssemblyError, JointFault};
use crate::assembly::joint::{Joint, Offset, of_joint};
use crate::assembly::part::{MOTIONS, Part};
use crate::assembly::rows::{ROW, RowWriter, Rows};
use crate::assembly::states::{PartState, check_states};
use crate::base::lend::{Lender, Short};
use crate::base::principal::principal;
use crate::base::vec3::{add, cross, dot, minus};
use crate::kernels::dense::{
    add_product, add_scaled, add_transposed, add_transposed_product, at, factor, row, row_mut, set,
    solve_lower, solve_lower_rows, solve_upper, solve_upper_rows, symmetrise, transpose,
};
use crate::kernels::eigen::{eigen_work, symmetric_eigen};

/// An eigenvalue that is a smaller share of the largest one is that of a motion without stiffness.
const RIGID: f64 = 1e-12;

/// A pivot of `S` that is a smaller share of its entry is that of a row that follows from others.
const DEPENDENT: f64 = 1e-11;

/// A part moves in a motion if one of its coordinates is larger.
const MOVES: f64 = 1e-3;

/// The joined body in the coordinates of its parts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Synthesis<'m> {
    /// Largest distance between the ports of each joint \[m\].
    pub distances: &'m [f64],
    /// Rows of the joints.
    pub rows: Rows<'m>,
    /// Factor of `S` in the lower half, `S` above it.
    pub compliance: &'m [f64],
    /// `L`, shape (rows, coordinates).
    pub answers: &'m [f64],
    /// `Yᵀ`, shape (modes, coordinates).
    pub shapes: &'m [f64],
    /// `M'`, shape (coordinates, coordinates).
    pub mass: &'m [f64],
    /// `g₀`.
    pub offsets: &'m [f64],
    /// `Ω` \[rad²/s²\], ascending; six zeros first of a free body.
    pub eigenvalues: &'m [f64],
    /// True if the inertia of what the parts leave out is in it.
    pub rubin: bool,
    /// Mass, centre and moments of inertia of a free body.
    pub rigid: Option<RigidNumbers>,
}

/// Mass, centre and moments of inertia about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidNumbers {
    pub mass: f64,
    pub centre: [f64; 3],
    pub inertia: [[f64; 3]; 3],
}

/// Memory of the assembly for work of the given lengths.
pub(crate) fn short(what: &'static str) -> impl Fn(Short) -> AssemblyError {
    move |Short { found, needed }| AssemblyError::LentMemory { what, found, needed }
}

impl<'m> Synthesis<'m> {
    /// Joins parts.
    pub fn new(
        (parts, joints): (&[Part<'_>], &[Joint<'_>]),
        counts: &Counts,
        (with_inertia, states): (bool, &[PartState<'_>]),
        memory: &'m mut [f64],
        work: &mut [f64],
    ) -> Result<Self, AssemblyError> {
        let Counts { r, m, .. } = *counts;
        let of_memory = short("numbers of memory");
        let mut memory = Lender::new(memory);
        let mut take = |n: usize| memory.take(n).map_err(&of_memory);
        let (distances, numbers, compliance) = (take(joints.len())?, take(m * ROW)?, take(m * m)?);
        let (answers, shapes, mass) = (take(m * r)?, take(r * r)?, take(r * r)?);
        let (offsets, eigenvalues) = (take(m)?, take(r)?);
        let of_work = short("numbers of work");
        let mut work = Lender::new(work);
        let mut scratch = |n: usize| work.take(n).map_err(&of_work);
        let (stiffness, lower, eigen) = (scratch(r * r)?, scratch(r * r)?, scratch(eigen_work(r))?);
        let (joint_mass, pulled, coordinates) = (scratch(m * m)?, scratch(m * r)?, scratch(r)?);

        let mut writer = RowWriter::new(numbers);
        for (index, joint) in joints.iter().enumerate() {
            let distance = joint.write(parts, &mut writer).map_err(of_joint(index))?;
            set(distances, index, distance);
        }
        let rows = Rows::new(numbers);
        joint_matrix(parts, rows, |_| [1.0, 0.0], compliance);
        for i in 0..m {
            let own = at(compliance, i * m + i) + rows.compliance(i);
            set(compliance, i * m + i, own);
        }
        if !compliance.iter().all(|x| x.is_finite()) {
            return Err(AssemblyError::NoConvergence);
        }
        factor(compliance, m, DEPENDENT).map_err(|row| redundant(parts, joints, row))?;
        port_rows(parts, rows, answers, coordinates);
        set_offsets((parts, joints), (rows, compliance, answers), states, coordinates, offsets)?;

        // K' = Λ + (L_S⁻¹Γ)ᵀ(L_S⁻¹Γ).
        solve_lower_rows(compliance, m, answers, r);
        stiffness.fill(0.0);
        add_transposed_product(stiffness, answers, r, answers, r);
        solve_upper_rows(compliance, m, answers, r);
        for (first, part) in with_firsts(parts) {
            for k in 0..part.n_coordinates() {
                let place = (first + k) * r + first + k;
                let own = at(stiffness, place) + part.eigenvalue(k);
                set(stiffness, place, own);
            }
        }
        let rubin = with_inertia && parts.iter().all(Part::has_inertia);
        mass.fill(0.0);
        if rubin {
            joint_matrix(parts, rows, |_| [0.0, 1.0], joint_mass);
            add_congruence(joint_mass, (answers, m, r), pulled, mass);
        }
        (0..r).for_each(|k| set(mass, k * r + k, at(mass, k * r + k) + 1.0));
        symmetrise(mass, r);

        lower.copy_from_slice(mass);
        factor(lower, r, 0.0).map_err(|_| AssemblyError::NoConvergence)?;
        solve_lower_rows(lower, r, stiffness, r);
        transpose(stiffness, r);
        solve_lower_rows(lower, r, stiffness, r);
        symmetrise(stiffness, r);
        symmetric_eigen(stiffness, r, eigenvalues, shapes, eigen)
            .map_err(|_| AssemblyError::NoConvergence)?;
        shapes.chunks_exact_mut(r.max(1)).for_each(|shape| solve_upper(lower, r, shape));
        check_motions(parts, counts, shapes, eigenvalues)?;
        let rigid = if counts.free { Some(whole(parts)?) } else { None };
        if let Some(rigid) = &rigid {
            set_rigid(parts, rigid, r, shapes);
            eigenvalues.iter_mut().take(MOTIONS).for_each(|value| *value = 0.0);
        }
        let (answers, mass): (&[f64], &[f64]) = (answers, mass);
        Ok(Self { distances, rows, compliance, answers, shapes, mass, offsets, eigenvalues, rubin, rigid })
    }

    /// `Σ weight · value` of the terms of a part, for each row of the joints.
    pub fn over_joints(&self, part: usize, value: impl Fn(usize) -> f64, out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            let own = self.rows.terms(i).filter(|term| term.0 == part);
            *out = own.map(|(_, row, weight)| weight * value(row)).sum();
        }
    }

    /// Takes off a row over the coordinates the part that the forces of the joints give; `ports` is the same
    /// of `R Gᵀ` over the rows of the joints.
    pub fn take_forces(&self, ports: &[f64], row_of: &mut [f64]) {
        let r = row_of.len();
        for (i, &value) in ports.iter().enumerate() {
            if value != 0.0 {
                add_scaled(row_of, -value, row(self.answers, i, r));
            }
        }
    }
}

/// The joint of a row follows from others.
fn redundant(parts: &[Part<'_>], joints: &[Joint<'_>], row: usize) -> AssemblyError {
    let mut end = 0;
    let own = joints.iter().position(|joint| {
        end += joint.n_rows(parts).unwrap_or(0);
        row < end
    });
    AssemblyError::Joint { joint: own.unwrap_or(0), fault: JointFault::Redundant }
}

/// `Σ G (a R + b R M R) Gᵀ` over the rows of the joints, with the weights `[a, b]` of each part.
pub(crate) fn joint_matrix(
    parts: &[Part<'_>],
    rows: Rows<'_>,
    weights: impl Fn(&Part<'_>) -> [f64; 2],
    out: &mut [f64],
) {
    let m = rows.len();
    for i in 0..m {
        for j in 0..=i {
            let mut sum = 0.0;
            for (part, a, weight) in rows.terms(i) {
                let Some(own) = parts.get(part) else { continue };
                let [of_r, of_n] = weights(own);
                for (_, b, other) in rows.terms(j).filter(|term| term.0 == part) {
                    let mut entry = 0.0;
                    if of_r != 0.0 {
                        entry += of_r * own.compliance(a, b);
                    }
                    if of_n != 0.0 {
                        entry += of_n * own.inertia(a, b);
                    }
                    sum += weight * other * entry;
                }
            }
            set(out, i * m + j, sum);
            set(out, j * m + i, sum);
        }
    }
}

/// `out += LᵀN L`; `pulled` takes as many numbers as `L` has.
pub(crate) fn add_congruence(
    n: &[f64],
    (answers, m, r): (&[f64], usize, usize),
    pulled: &mut [f64],
    out: &mut [f64],
) {
    pulled.fill(0.0);
    add_product(pulled, n, m, answers, r);
    add_transposed_product(out, answers, r, pulled, r);
}

/// `Γ`, shape (rows of joints, coordinates).
fn port_rows(parts: &[Part<'_>], rows: Rows<'_>, out: &mut [f64], scratch: &mut [f64]) {
    out.fill(0.0);
    let r = scratch.len();
    for i in 0..rows.len() {
        let own = row_mut(out, i, r);
        for (index, port_row, weight) in rows.terms(i) {
            let Some((first, part)) = with_firsts(parts).nth(index) else { continue };
            let ports = (0..part.ports.len()).filter_map(|port| part.ports.get(port));
            let Some(port) =
                ports.clone().find(|port| port_row >= port.first && port_row - port.first < port.rows())
            else {
                continue;
            };
            let n = part.n_coordinates();
            let of_part = scratch.get_mut(..n).unwrap_or_default();
            part.port_row(&port, port_row - port.first, of_part);
            add_scaled(own.get_mut(first..first + n).unwrap_or_default(), weight, of_part);
        }
    }
}

/// `Γ q + G R F` of the states of the parts; `gamma` is `Γ`.
fn gaps(
    parts: &[Part<'_>],
    (rows, gamma): (Rows<'_>, &[f64]),
    states: &[PartState<'_>],
    coordinates: &mut [f64],
    out: &mut [f64],
) {
    let r = coordinates.len();
    coordinates.fill(0.0);
    for ((first, part), state) in with_firsts(parts).zip(states) {
        let own = coordinates.get_mut(first..first + part.n_coordinates()).unwrap_or_default();
        own.iter_mut().zip(state.displacement).for_each(|(to, from)| *to = *from);
    }
    for (i, out) in out.iter_mut().enumerate() {
        let moved = rows.terms(i).map(|(part, port_row, weight)| {
            weight * states.get(part).map_or(0.0, |state| at(state.port_motion, port_row))
        });
        *out = moved.sum::<f64>() + crate::kernels::dense::dot(row(gamma, i, r), coordinates);
    }
}

/// `g₀` of each row; `gamma` is `Γ`, and `compliance` has the factor of `S` below its diagonal, `S` above.
fn set_offsets(
    (parts, joints): (&[Part<'_>], &[Joint<'_>]),
    (rows, compliance, gamma): (Rows<'_>, &[f64], &[f64]),
    states: &[PartState<'_>],
    coordinates: &mut [f64],
    offsets: &mut [f64],
) -> Result<(), AssemblyError> {
    let m = rows.len();
    let standing = joints.iter().any(|joint| joint.offset == Offset::AsItStands);
    if standing {
        check_states(parts, states)?;
        gaps(parts, (rows, gamma), states, coordinates, offsets);
    }
    // Rows before those made as they stand have their own offsets: their forces are −S⁻¹(g − g₀).
    let (mut first, mut before) = (0, m);
    for (index, joint) in joints.iter().enumerate() {
        let count = joint.n_rows(parts).map_err(of_joint(index))?;
        let own = offsets.get_mut(first..first + count).unwrap_or_default();
        match joint.offset {
            Offset::AsItStands => before = before.min(first),
            Offset::None if standing => {}
            Offset::None => own.fill(0.0),
            Offset::Of(given) if standing => own.iter_mut().zip(given).for_each(|(own, given)| *own -= given),
            Offset::Of(given) => own.iter_mut().zip(given).for_each(|(own, given)| *own = *given),
        }
        first += count;
    }
    if standing {
        let mismatch = AssemblyError::Length { what: "offsets", found: m, expected: before };
        let (forces, gap) = offsets.split_at_mut_checked(before).ok_or(mismatch)?;
        solve_lower(compliance, m, forces);
        solve_upper(compliance, m, forces);
        for (k, gap) in gap.iter_mut().enumerate() {
            let i = before + k;
            *gap -= forces.iter().enumerate().map(|(j, f)| at(compliance, j * m + i) * f).sum::<f64>();
        }
        let mut first = 0;
        for joint in joints {
            let count = joint.n_rows(parts).unwrap_or(0);
            let own = offsets.get_mut(first..first + count).unwrap_or_default();
            match joint.offset {
                Offset::AsItStands => {}
                Offset::None => own.fill(0.0),
                Offset::Of(given) => own.iter_mut().zip(given).for_each(|(own, given)| *own = *given),
            }
            first += count;
        }
    }
    if offsets.iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(AssemblyError::Number { what: "offsets" })
    }
}

/// Refuses motions without stiffness other than the six of a free body.
fn check_motions(
    parts: &[Part<'_>],
    counts: &Counts,
    shapes: &[f64],
    eigenvalues: &[f64],
) -> Result<(), AssemblyError> {
    let largest = eigenvalues.last().copied().unwrap_or(0.0);
    let motions = eigenvalues.iter().filter(|value| **value <= RIGID * largest).count();
    if motions == counts.first_mode {
        return Ok(());
    }
    let mut bits = 0;
    for (index, (first, part)) in with_firsts(parts).enumerate() {
        let own =
            |shape: &[f64]| shape.iter().skip(first).take(part.n_coordinates()).any(|q| q.abs() > MOVES);
        if shapes.chunks_exact(counts.r.max(1)).take(motions).any(own) {
            bits |= 1 << index.min(63);
        }
    }
    Err(AssemblyError::Moves { motions, parts: bits })
}

/// Mass, centre and moments of inertia of free parts at their places.
fn whole(parts: &[Part<'_>]) -> Result<RigidNumbers, AssemblyError> {
    let own = |part: &Part<'_>| part.rigid.map(|rigid| (rigid.mass, part.pose.place(rigid.centre)));
    let (mut mass, mut first) = (0.0, [0.0; 3]);
    for (share, centre) in parts.iter().filter_map(own) {
        mass += share;
        first = add(first, share, centre);
    }
    let centre = first.map(|x| x / mass);
    let mut inertia = [[0.0; 3]; 3];
    for part in parts {
        let Some((share, at)) = own(part) else { continue };
        let arm = minus(at, centre);
        let square = dot(arm, arm);
        let turned = part.inertia_tensor();
        for (i, (row, turned)) in inertia.iter_mut().zip(turned).enumerate() {
            for (j, (entry, turned)) in row.iter_mut().zip(turned).enumerate() {
                let diagonal = if i == j { square } else { 0.0 };
                let product = arm.get(i).zip(arm.get(j)).map_or(0.0, |(a, b)| a * b);
                *entry += turned + share * (diagonal - product);
            }
        }
    }
    let finite = mass.is_finite() && mass > 0.0 && inertia.as_flattened().iter().all(|x| x.is_finite());
    if finite { Ok(RigidNumbers { mass, centre, inertia }) } else { Err(AssemblyError::NoConvergence) }
}

/// Displacements along x, y, z and rotations about the principal axes in place of the first six shapes, which
/// are any six motions of the body as a whole.
fn set_rigid(parts: &[Part<'_>], rigid: &RigidNumbers, r: usize, shapes: &mut [f64]) {
    let (moments, axes) = principal(rigid.inertia);
    for k in 0..MOTIONS {
        let unit = |k: usize| crate::assembly::part::SPACE.get(k).copied().unwrap_or_default();
        let axis = k.checked_sub(3).and_then(|k| axes.get(k).zip(moments.get(k)));
        let turned = axis.map_or([0.0; 3], |(axis, moment)| axis.map(|a| a / libm::sqrt(*moment)));
        let moved = if k < 3 { unit(k).map(|e| e / libm::sqrt(rigid.mass)) } else { [0.0; 3] };
        let shape = row_mut(shapes, k, r);
        shape.fill(0.0);
        for (first, part) in with_firsts(parts) {
            let Some(own) = &part.rigid else { continue };
            let arm = minus(part.pose.place(own.centre), rigid.centre);
            let at_centre = add(moved, 1.0, cross(turned, arm));
            let local = [at_centre, turned].map(|v| part.pose.turn_back(v));
            let coordinates = part.rigid_coordinates(local[0], local[1]);
            shape.iter_mut().skip(first).zip(coordinates).for_each(|(to, from)| *to = from);
        }
    }
}

/// `out = Yᵀ x` of coordinates of the parts.
pub(crate) fn along_modes(shapes: &[f64], x: &[f64], out: &mut [f64]) {
    crate::kernels::dense::apply(shapes, x, out);
}

/// `out = Y η`.
pub(crate) fn from_modes(shapes: &[f64], eta: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    add_transposed(shapes, eta, out);
}
