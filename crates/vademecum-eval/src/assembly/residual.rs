//! Residual flexibility of the joined body under contacts, at probes and under patterns:
//! `H R Hᵀ − H R Gᵀ S⁻¹ G R Hᵀ`.

use crate::assembly::counts::Counts;
use crate::assembly::inputs::{Inputs, of_spin, spin_moments};
use crate::assembly::part::{Part, SPIN, number};
use crate::assembly::synthesis::Synthesis;
use crate::base::vec3::{add, cross, minus};
use crate::kernels::dense::{dot, row, row_mut, solve_lower};
use vademecum_format::{Numbers, SectionKind as S};

/// Entries of a symmetric block in the order of [`S::ContactResidual`].
const UPPER: [[usize; 2]; 6] = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];

/// Residual flexibility of the joined body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residual<'w> {
    /// `H R Gᵀ L_S⁻ᵀ` of the loadable nodes, three rows each over the rows of the joints.
    nodes: &'w [f64],
}

/// Writes numbers one after the other.
pub(crate) struct Doubles<'b>(core::slice::IterMut<'b, [u8; 8]>);

impl<'b> Doubles<'b> {
    /// Into these bytes.
    pub fn new(bytes: &'b mut [u8]) -> Self {
        Self(bytes.as_chunks_mut().0.iter_mut())
    }

    /// Writes the next number.
    pub fn push(&mut self, value: f64) {
        if let Some(place) = self.0.next() {
            *place = value.to_le_bytes();
        }
    }
}

impl<'w> Residual<'w> {
    /// Of the parts; `nodes` has three times as many rows as there are loadable nodes.
    pub fn new(parts: &[Part<'_>], synthesis: &Synthesis<'_>, nodes: &'w mut [f64]) -> Self {
        let m = synthesis.rows.len();
        let mut next = 0;
        for (index, part) in parts.iter().enumerate() {
            for node in 0..part.n_load {
                let out = row_mut(nodes, next, 3 * m);
                residual_rows(part, index, synthesis, node, out);
                (0..3).for_each(|c| solve_lower(synthesis.compliance, m, row_mut(out, c, m)));
                next += 1;
            }
        }
        Self { nodes }
    }

    /// Writes a section; `first` is the number of the first input of its kind.
    pub fn write(
        &self,
        kind: S,
        (parts, counts): (&[Part<'_>], &Counts),
        inputs: &Inputs<'_>,
        bytes: &mut [u8],
    ) {
        let m = counts.m;
        let node = |node: usize, c: usize| row(self.nodes, 3 * node + c, m);
        let mut out = Doubles::new(bytes);
        let mut first = 0;
        match kind {
            S::ContactResidual => {
                for part in parts {
                    for own in 0..part.n_load {
                        let value = |k: usize| number(part.contact_residual, 6 * own + k);
                        let [xx, xy, xz, yy, yz, zz] =
                            [value(0), value(1), value(2), value(3), value(4), value(5)];
                        let block = part.pose.turn_matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
                        for [i, j] in UPPER {
                            let value = entry(&block, i, j) - dot(node(first + own, i), node(first + own, j));
                            // A node of a port that is welded has no residual but rounding.
                            out.push(if i == j { value.max(0.0) } else { value });
                        }
                    }
                    first += part.n_load;
                }
            }
            S::PairResidual => {
                for part in parts {
                    for (pair, nodes) in part.pairs.as_chunks::<2>().0.iter().enumerate() {
                        let [a, b] = nodes.map(|node| u32::from_le_bytes(node) as usize);
                        let value = |k: usize| number(part.pair_residual, 9 * pair + k);
                        let local = [0, 3, 6].map(|i| [value(i), value(i + 1), value(i + 2)]);
                        let block = part.pose.turn_matrix(local);
                        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                            out.push(entry(&block, i, j) - dot(node(first + a, i), node(first + b, j)));
                        }
                    }
                    first += part.n_load;
                }
            }
            S::ProbeResidual => {
                for_each(
                    parts,
                    |part| part.n_probes,
                    |source, own, input| {
                        let numbers = parts.get(source).and_then(|part| part.probe_residual);
                        self.write_input((parts, m), (source, numbers, own), &mut out, |node, c| {
                            dot(
                                row(inputs.ports, counts.patterns + input, m),
                                row(self.nodes, 3 * node + c, m),
                            )
                        });
                    },
                );
            }
            _ => {
                let given = |input: usize| {
                    move |node: usize, c: usize| {
                        dot(row(inputs.ports, input, m), row(self.nodes, 3 * node + c, m))
                    }
                };
                let end = for_each(
                    parts,
                    |part| part.n_patterns,
                    |source, own, input| {
                        let numbers = parts.get(source).and_then(|part| part.pattern_residual);
                        self.write_input((parts, m), (source, numbers, own), &mut out, given(input));
                    },
                );
                if counts.glued {
                    self.write_input((parts, m), (usize::MAX, None, 0), &mut out, given(end));
                }
                let end = end + usize::from(counts.glued);
                for kind in (0..SPIN).filter(|_| counts.free) {
                    let mut at = 0;
                    for part in parts {
                        for own in 0..part.n_load {
                            let value = |c: usize| {
                                let place = |pattern: usize| 3 * (pattern * part.n_load + own) + c;
                                of_spin(part, kind, |pattern| number(part.pattern_residual, place(pattern)))
                            };
                            let moved = part.pose.turn([value(0), value(1), value(2)]);
                            for (c, moved) in moved.into_iter().enumerate() {
                                out.push(moved - given(end + kind)(at + own, c));
                            }
                        }
                        at += part.n_load;
                    }
                }
            }
        }
    }

    /// Displacement of every loadable node by one input of a part.
    fn write_input(
        &self,
        (parts, _): (&[Part<'_>], usize),
        (source, numbers, own): (usize, Option<Numbers<'_>>, usize),
        out: &mut Doubles<'_>,
        given: impl Fn(usize, usize) -> f64,
    ) {
        let mut at = 0;
        for (target, part) in parts.iter().enumerate() {
            for node in 0..part.n_load {
                let value = |c: usize| number(numbers, 3 * (own * part.n_load + node) + c);
                let moved = match target == source {
                    true => part.pose.turn([value(0), value(1), value(2)]),
                    false => [0.0; 3],
                };
                moved.into_iter().enumerate().for_each(|(c, moved)| out.push(moved - given(at + node, c)));
            }
            at += part.n_load;
        }
    }
}

/// Calls `with` for each input of each part: part, number in the part, number of all. Gives their number.
fn for_each(
    parts: &[Part<'_>],
    count: impl Fn(&Part<'_>) -> usize,
    mut with: impl FnMut(usize, usize, usize),
) -> usize {
    let mut next = 0;
    for (index, part) in parts.iter().enumerate() {
        for own in 0..count(part) {
            with(index, own, next);
            next += 1;
        }
    }
    next
}

/// Values of the probes under patterns.
pub(crate) fn write_pattern_probes(
    parts: &[Part<'_>],
    counts: &Counts,
    inputs: &Inputs<'_>,
    bytes: &mut [u8],
) {
    let mut out = Doubles::new(bytes);
    let m = counts.m;
    let mut write = |pattern: usize, own: &dyn Fn(usize, &Part<'_>, usize) -> f64| {
        let mut probe = counts.patterns;
        for (target, part) in parts.iter().enumerate() {
            for at in 0..part.n_probes {
                let given = dot(row(inputs.ports, pattern, m), row(inputs.ports, probe, m));
                out.push(own(target, part, at) - given);
                probe += 1;
            }
        }
    };
    let end = for_each(
        parts,
        |part| part.n_patterns,
        |source, own, pattern| {
            write(pattern, &|target, part, probe| match target == source {
                true => number(part.pattern_probes, own * part.n_probes + probe),
                false => 0.0,
            });
        },
    );
    if counts.glued {
        write(end, &|_, _, _| 0.0);
    }
    let end = end + usize::from(counts.glued);
    for kind in (0..SPIN).filter(|_| counts.free) {
        write(end + kind, &|_, part, probe| {
            of_spin(part, kind, |pattern| number(part.pattern_probes, pattern * part.n_probes + probe))
        });
    }
}

/// `H R Gᵀ` of a surface node over the rows of the joints, three rows.
pub(crate) fn residual_rows(
    part: &Part<'_>,
    index: usize,
    synthesis: &Synthesis<'_>,
    node: usize,
    out: &mut [f64],
) {
    let m = synthesis.rows.len();
    out.fill(0.0);
    for i in 0..m {
        for (_, port_row, weight) in synthesis.rows.terms(i).filter(|term| term.0 == index) {
            for (c, value) in part.node_residual(node, port_row).into_iter().enumerate() {
                if let Some(out) = out.get_mut(c * m + i) {
                    *out += weight * value;
                }
            }
        }
    }
}

fn entry(block: &[[f64; 3]; 3], i: usize, j: usize) -> f64 {
    block.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0)
}

/// Mass, centre, moments of inertia, and force and moment of each pattern, of a free body.
pub(crate) fn write_rigid(parts: &[Part<'_>], counts: &Counts, synthesis: &Synthesis<'_>, bytes: &mut [u8]) {
    let Some(rigid) = &synthesis.rigid else { return };
    let mut out = Doubles::new(bytes);
    out.push(rigid.mass);
    rigid.centre.into_iter().for_each(|x| out.push(x));
    UPPER.into_iter().for_each(|[i, j]| out.push(entry(&rigid.inertia, i, j)));
    let first = counts.patterns.saturating_sub(SPIN);
    out.push(first as f64);
    for part in parts {
        for pattern in 0..part.n_patterns {
            let [force, moment] = part.pattern_wrench(pattern).map(|v| part.pose.turn(v));
            let centre = part.rigid.map_or([0.0; 3], |own| part.pose.place(own.centre));
            let about = add(moment, 1.0, cross(minus(centre, rigid.centre), force));
            force.into_iter().chain(about).for_each(|x| out.push(x));
        }
    }
    // Forces of a joint are in equilibrium.
    (0..6).filter(|_| counts.glued).for_each(|_| out.push(0.0));
    for moment in spin_moments(rigid.inertia) {
        [0.0; 3].into_iter().chain(moment).for_each(|x| out.push(x));
    }
}
