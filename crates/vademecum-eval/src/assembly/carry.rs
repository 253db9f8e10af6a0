//! The state of a joined body from those of its parts, and back; forces and energy of its joints.

use crate::assembly::counts::with_firsts;
use crate::assembly::error::{AssemblyError, JointFault};
use crate::assembly::joint::{Joint, of_joint};
use crate::assembly::part::Part;
use crate::assembly::states::{PartState, check_states};
use crate::assembly::synthesis::{Synthesis, along_modes, from_modes, short};
use crate::base::lend::Lender;
use crate::base::vec3::{add, cross, minus};
use crate::kernels::dense::{apply, at, dot, row, set, solve_lower, solve_upper};
use crate::kernels::eigen::{eigen_work, of_matrix, symmetric_eigen};
use vademecum_format::PortKind;

/// Forces of a joint on its first port.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointForce {
    /// Origin of the first port in space \[m\].
    pub origin: [f64; 3],
    /// Resultant force \[N\].
    pub force: [f64; 3],
    /// Moment about the origin \[N m\].
    pub moment: [f64; 3],
}

/// Energy of the joints: of what the modes of the parts leave out, and of bushings and springs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointEnergy {
    /// `½ fᵀS f` \[J\], which is lost if all joints break.
    pub stored: f64,
    /// `½ ḟᵀN ḟ` \[J\]: the kinetic energy of what the modes of the parts leave out.
    pub moving: f64,
}

/// Numbers of work of [`join`] and [`part_states`] for so many coordinates.
pub(crate) const fn carry_work(r: usize) -> usize {
    2 * r * r + 4 * r + eigen_work(r)
}

/// `M'^½`, as eigenvalues and eigenvectors.
struct Root<'w> {
    values: &'w mut [f64],
    vectors: &'w mut [f64],
    between: &'w mut [f64],
}

impl<'w> Root<'w> {
    fn new(mass: &[f64], r: usize, work: &mut Lender<&'w mut [f64]>) -> Result<Self, AssemblyError> {
        let of_work = short("numbers of work");
        let copy = work.take(r * r).map_err(&of_work)?;
        let vectors = work.take(r * r).map_err(&of_work)?;
        let (values, between) = (work.take(r).map_err(&of_work)?, work.take(r).map_err(&of_work)?);
        let eigen = work.take(eigen_work(r)).map_err(&of_work)?;
        copy.iter_mut().zip(mass).for_each(|(to, from)| *to = *from);
        symmetric_eigen(copy, r, values, vectors, eigen).map_err(|_| AssemblyError::NoConvergence)?;
        Ok(Self { values, vectors, between })
    }

    fn times(&mut self, x: &[f64], out: &mut [f64]) {
        of_matrix((self.values, self.vectors), libm::sqrt, x, self.between, out);
    }
}

fn check(what: &'static str, found: usize, expected: usize) -> Result<(), AssemblyError> {
    if found == expected { Ok(()) } else { Err(AssemblyError::Length { what, found, expected }) }
}

/// Coordinates of the joined body and their rates, `η = YᵀM'q` and `η̇ = YᵀM'^½ q̇`.
pub(crate) fn join(
    parts: &[Part<'_>],
    synthesis: &Synthesis<'_>,
    states: &[PartState<'_>],
    [displacement, velocity]: [&mut [f64]; 2],
    work: &mut [f64],
) -> Result<(), AssemblyError> {
    let r = synthesis.eigenvalues.len();
    check_states(parts, states)?;
    check("a displacement", displacement.len(), r)?;
    check("a velocity", velocity.len(), r)?;
    let mut work = Lender::new(work);
    let of_work = short("numbers of work");
    let (q, moved) = (work.take(r).map_err(&of_work)?, work.take(r).map_err(&of_work)?);
    let mut root = Root::new(synthesis.mass, r, &mut work)?;
    let stack = |q: &mut [f64], rates: bool| {
        for ((first, _), state) in with_firsts(parts).zip(states) {
            let from = if rates { state.velocity } else { state.displacement };
            q.iter_mut().skip(first).zip(from).for_each(|(to, from)| *to = *from);
        }
    };
    stack(q, false);
    apply(synthesis.mass, q, moved);
    along_modes(synthesis.shapes, moved, displacement);
    stack(q, true);
    root.times(q, moved);
    along_modes(synthesis.shapes, moved, velocity);
    Ok(())
}

/// Coordinates of all parts, one after the other, and their rates, `q = Y η` and `q̇ = M'^½ Y η̇`.
pub(crate) fn part_states(
    synthesis: &Synthesis<'_>,
    [displacement, velocity]: [&[f64]; 2],
    [q, rates]: [&mut [f64]; 2],
    work: &mut [f64],
) -> Result<(), AssemblyError> {
    let r = synthesis.eigenvalues.len();
    for (what, found) in [
        ("a displacement", displacement.len()),
        ("a velocity", velocity.len()),
        ("displacements of the parts", q.len()),
        ("velocities of the parts", rates.len()),
    ] {
        check(what, found, r)?;
    }
    let mut work = Lender::new(work);
    let of_work = short("numbers of work");
    let moved = work.take(r).map_err(&of_work)?;
    let mut root = Root::new(synthesis.mass, r, &mut work)?;
    from_modes(synthesis.shapes, displacement, q);
    from_modes(synthesis.shapes, velocity, moved);
    root.times(moved, rates);
    Ok(())
}

/// Forces of the rows of all joints, `−L q + S⁻¹(g₀ − G R F)`; `q` are coordinates of the parts.
pub(crate) fn forces(
    synthesis: &Synthesis<'_>,
    q: &[f64],
    port_motions: &[&[f64]],
    out: &mut [f64],
) -> Result<(), AssemblyError> {
    let m = synthesis.rows.len();
    check("forces of joints", out.len(), m)?;
    check("coordinates of the parts", q.len(), synthesis.eigenvalues.len())?;
    for (i, out) in out.iter_mut().enumerate() {
        let moved = synthesis.rows.terms(i).map(|(part, port_row, weight)| {
            weight * port_motions.get(part).map_or(0.0, |motion| at(motion, port_row))
        });
        *out = at(synthesis.offsets, i) - moved.sum::<f64>();
    }
    solve_lower(synthesis.compliance, m, out);
    solve_upper(synthesis.compliance, m, out);
    for (i, out) in out.iter_mut().enumerate() {
        *out -= dot(row(synthesis.answers, i, q.len()), q);
    }
    Ok(())
}

/// Energy of the joints under their forces and the rates of the coordinates of the parts.
pub(crate) fn energy(synthesis: &Synthesis<'_>, forces: &[f64], rates: &[f64]) -> JointEnergy {
    let m = synthesis.rows.len();
    // |L_Sᵀ f|², a row of the factor at a time.
    let mut stored = 0.0;
    for j in 0..m {
        let sum: f64 = (j..m).map(|i| at(synthesis.compliance, i * m + j) * at(forces, i)).sum();
        stored += 0.5 * sum * sum;
    }
    let r = rates.len();
    let mut moving = 0.0;
    for (k, rate) in rates.iter().enumerate() {
        let own = row(synthesis.mass, k, r);
        moving += 0.5 * rate * (dot(own, rates) - rate);
    }
    JointEnergy { stored, moving }
}

/// The rows of a joint: the first one, and their number.
pub(crate) fn joint_rows(
    (parts, joints): (&[Part<'_>], &[Joint<'_>]),
    joint: usize,
) -> Result<(usize, usize), AssemblyError> {
    let unknown = AssemblyError::Joint { joint, fault: JointFault::Unknown };
    let mut first = 0;
    for (index, own) in joints.iter().enumerate() {
        let count = own.n_rows(parts).map_err(of_joint(index))?;
        if index == joint {
            return Ok((first, count));
        }
        first += count;
    }
    Err(unknown)
}

/// Resultant of the forces of a joint on its first port, and the force on each node of a patch if `nodal` is
/// given, three numbers each \[N\].
pub(crate) fn resultant(
    (parts, joints): (&[Part<'_>], &[Joint<'_>]),
    index: usize,
    forces: &[f64],
    nodal: Option<&mut [f64]>,
) -> Result<JointForce, AssemblyError> {
    let (first, _) = joint_rows((parts, joints), index)?;
    let refused = of_joint(index);
    let joint = joints.get(index).ok_or(refused(JointFault::Unknown))?;
    let sides = joint.ports(parts).map_err(&refused)?;
    let (part, port) = (sides.first.part, sides.first.port);
    let mut sum = JointForce { origin: sides.first.origin(), ..JointForce::default() };
    let mut nodal = nodal;
    if let Some(nodal) = nodal.as_deref_mut() {
        let expected = if port.kind == PortKind::Patch { 3 * port.count } else { 0 };
        check("forces on nodes", nodal.len(), expected)?;
        nodal.fill(0.0);
    }
    let mut next = first;
    let of_rows = joint.each_row(&sides, |place| {
        let force = at(forces, next);
        next += 1;
        if place.turns {
            sum.moment = add(sum.moment, force, place.along);
            return;
        }
        sum.force = add(sum.force, force, place.along);
        if port.kind == PortKind::Patch {
            let arm = minus(part.place(port.node(place.node)), sum.origin);
            sum.moment = add(sum.moment, force, cross(arm, place.along));
            if let Some(nodal) = nodal.as_deref_mut() {
                for (c, along) in place.along.into_iter().enumerate() {
                    let at_node = at(nodal, 3 * place.node + c) + force * along;
                    set(nodal, 3 * place.node + c, at_node);
                }
            }
        }
    });
    of_rows.map_err(&refused)?;
    Ok(sum)
}
