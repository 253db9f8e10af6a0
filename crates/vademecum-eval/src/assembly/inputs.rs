//! Load patterns and probes of the joined body, over its coordinates and over the rows of its joints.

use crate::assembly::counts::{Counts, with_firsts};
use crate::assembly::error::AssemblyError;
use crate::assembly::part::{MOTIONS, Part, SPACE, SPIN, work as work_of};
use crate::assembly::synthesis::{Synthesis, short};
use crate::base::lend::Lender;
use crate::base::vec3::{add, cross, dot, minus};
use crate::kernels::dense::{row, row_mut, set, solve_lower};
use vademecum_format::{BASE_PATTERNS, base_field};

/// Components whose products the patterns of the angular velocity are of, in their order.
const PRODUCTS: [[usize; 2]; SPIN] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

/// Load patterns, then probes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs<'w> {
    /// `(W − V L)` over the coordinates, shape (patterns and probes, coordinates).
    pub rows: &'w [f64],
    /// `V L_S⁻ᵀ`: `G R F` of a pattern and `G R Hᵀ` of a probe, solved with the factor of `S`; shape
    /// (patterns and probes, rows of joints).
    pub ports: &'w [f64],
}

impl<'w> Inputs<'w> {
    /// Numbers of so many counts.
    pub const fn len(counts: &Counts) -> [usize; 2] {
        let n = counts.patterns + counts.probes;
        [n * counts.r, n * counts.m]
    }

    /// Inputs of the parts, of joints made as they stand, and of the angular velocity.
    pub fn new(
        parts: &[Part<'_>],
        counts: &Counts,
        synthesis: &Synthesis<'_>,
        memory: [&'w mut [f64]; 2],
        scratch: &mut [f64],
    ) -> Result<Self, AssemblyError> {
        let Counts { r, m, .. } = *counts;
        let [rows, ports] = memory;
        let mut scratch = Lender::new(scratch);
        let own = scratch.take(r).map_err(short("numbers of work"))?;
        rows.fill(0.0);
        ports.fill(0.0);
        let mut next = 0;
        let spread = |first: usize, own: &[f64], next: usize, rows: &mut [f64]| {
            let to = row_mut(rows, next, r).iter_mut().skip(first);
            to.zip(own).for_each(|(to, from)| *to = *from);
        };
        for (index, (first, part)) in with_firsts(parts).enumerate() {
            for pattern in 0..part.n_patterns {
                let own = own.get_mut(..part.n_coordinates()).unwrap_or_default();
                part.pattern_row(pattern, own);
                spread(first, own, next, rows);
                let out = row_mut(ports, next, m);
                synthesis.over_joints(index, |row| part.pattern_port(pattern, row), out);
                next += 1;
            }
        }
        if counts.glued {
            // A displacement of the joints: `G R F − g₀` for F of zero.
            let out = row_mut(ports, next, m).iter_mut();
            out.zip(synthesis.offsets).for_each(|(out, offset)| *out = -offset);
            next += 1;
        }
        if let Some(rigid) = &synthesis.rigid {
            for (kind, product) in PRODUCTS.into_iter().enumerate() {
                for (index, (first, part)) in with_firsts(parts).enumerate() {
                    let out = row_mut(rows, next, r).get_mut(first..first + part.n_coordinates());
                    add_spin(part, rigid.centre, product, own, out.unwrap_or_default());
                    let value = |row: usize| of_spin(part, kind, |pattern| part.pattern_port(pattern, row));
                    add_over_joints(synthesis, index, value, row_mut(ports, next, m));
                }
                next += 1;
            }
        }
        for (index, (first, part)) in with_firsts(parts).enumerate() {
            for probe in 0..part.n_probes {
                let own = own.get_mut(..part.n_coordinates()).unwrap_or_default();
                part.probe_row(probe, own);
                spread(first, own, next, rows);
                let out = row_mut(ports, next, m);
                synthesis.over_joints(index, |row| part.probe_port(probe, row), out);
                next += 1;
            }
        }
        for k in 0..next {
            synthesis.take_forces(row(ports, k, m), row_mut(rows, k, r));
            solve_lower(synthesis.compliance, m, row_mut(ports, k, m));
        }
        Ok(Self { rows, ports })
    }
}

fn add_over_joints(synthesis: &Synthesis<'_>, part: usize, value: impl Fn(usize) -> f64, out: &mut [f64]) {
    for (i, out) in out.iter_mut().enumerate() {
        let own = synthesis.rows.terms(i).filter(|term| term.0 == part);
        *out += own.map(|(_, row, weight)| weight * value(row)).sum::<f64>();
    }
}

/// Share of the product of components `p`, `q` in the part of that of `i`, `j` in space.
fn shares(part: &Part<'_>, [i, j]: [usize; 2]) -> [f64; SPIN] {
    let q = |i: usize, p: usize| part.pose.rotation.get(i).and_then(|row| row.get(p)).copied().unwrap_or(0.0);
    PRODUCTS.map(|[p, s]| if i == j { q(i, p) * q(i, s) } else { q(i, p) * q(j, s) + q(j, p) * q(i, s) })
}

/// `−ω × I ω` of a product of components of `ω`.
pub(crate) fn spin_moment(inertia: [[f64; 3]; 3], [i, j]: [usize; 2]) -> [f64; 3] {
    let unit = |k: usize| SPACE.get(k).copied().unwrap_or_default();
    let turned = |k: usize| inertia.map(|row| dot(row, unit(k)));
    let once = cross(unit(i), turned(j)).map(|x| -x);
    if i == j { once } else { add(once, -1.0, cross(unit(j), turned(i))) }
}

/// Moments of the patterns of the angular velocity about the centre of a body.
pub(crate) fn spin_moments(inertia: [[f64; 3]; 3]) -> [[f64; 3]; SPIN] {
    PRODUCTS.map(|product| spin_moment(inertia, product))
}

/// Adds the centrifugal force of a part about the centre of the body, for a product of components: that about
/// its own centre, and a uniform one, which only its rigid motions feel.
fn add_spin(part: &Part<'_>, centre: [f64; 3], product: [usize; 2], scratch: &mut [f64], out: &mut [f64]) {
    let Some(rigid) = &part.rigid else { return };
    let own = scratch.get_mut(..part.n_coordinates()).unwrap_or_default();
    for (k, share) in shares(part, product).into_iter().enumerate() {
        if share != 0.0 {
            part.pattern_row(rigid.first_pattern + k, own);
            crate::kernels::dense::add_scaled(out, share, own);
        }
    }
    let kind = PRODUCTS.iter().position(|other| *other == product).unwrap_or(0);
    let arm = minus(part.pose.place(rigid.centre), centre);
    let first = BASE_PATTERNS.len() - SPIN;
    let force = base_field(first + kind, arm).map(|a| -rigid.mass * a);
    let wrench = [part.pose.turn_back(force), [0.0; 3]];
    for k in 0..MOTIONS {
        let sum = out.get(k).copied().unwrap_or(0.0) + work_of(rigid, k, wrench);
        set(out, k, sum);
    }
}

/// A number of each of the patterns of the angular velocity of a part, summed for a product in space.
pub(crate) fn of_spin(part: &Part<'_>, kind: usize, value: impl Fn(usize) -> f64) -> f64 {
    let product = PRODUCTS.get(kind).copied().unwrap_or_default();
    let first = part.rigid.map_or(0, |rigid| rigid.first_pattern);
    let shares = shares(part, product).into_iter().enumerate();
    shares.filter(|(_, share)| *share != 0.0).map(|(k, share)| share * value(first + k)).sum()
}
