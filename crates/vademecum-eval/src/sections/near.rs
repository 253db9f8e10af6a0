//! Residual flexibility of a file with a contact patch.
//!
//! ```text
//! u_c = H_c (S + ψ(|x_c − x_d|/h) R') H_dᵀ f_d          S = Σ_k s_k s_kᵀ
//! ```
//!
//! `s_k` are the further modes, `R'` what is left between near nodes, `ψ` Wendland's function of the distance
//! of two places at rest. `S` is positive semidefinite, and so is the matrix of the tapered blocks, by Schur's
//! product theorem (1911); that of the blocks cut off would not be. At one place `ψ = 1`: there the blocks of
//! the file's own sections are taken where it has them, so that one contact alone has the bits that it has
//! without a patch.

use crate::base::scalar::Scalar;
use crate::base::vec3::{add, dot, minus};
use crate::sections::contact::Shares;
use crate::sections::place::Place;
use crate::sections::residual::{Block, Residual, Statics, times};
use vademecum_format::{ContactPatch, File, Numbers, SectionKind, taper};

/// Further modes that are summed at once.
const GROUP: usize = 16;

/// The patch, and where its nodes are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near<'m> {
    patch: ContactPatch<'m>,
    coordinates: Numbers<'m>,
}

impl<'m> Near<'m> {
    /// The patch of a file; `None` without one, and where it is compressed or has no coordinates.
    pub fn of(file: &File<'m>) -> Option<Self> {
        let there = file.section(SectionKind::ContactResidual)?.numbers().is_ok();
        let patch = file.contact_patch().ok().flatten()?;
        let coordinates = file.section(SectionKind::NodeCoordinates)?.numbers().ok()?;
        let sound = there && patch.distance > 0.0 && patch.distance.is_finite();
        sound.then_some(Self { patch, coordinates })
    }

    /// Number of further modes.
    pub const fn n_modes(&self) -> usize {
        self.patch.n_modes
    }

    /// A place at rest \[m\].
    pub fn position(&self, entries: impl Iterator<Item = (usize, f64)>) -> [f64; 3] {
        entries.fold([0.0; 3], |sum, (node, weight)| add(sum, weight, self.node(node)))
    }

    fn node(&self, node: usize) -> [f64; 3] {
        core::array::from_fn(|c| self.coordinates.get(3 * node + c).unwrap_or(0.0))
    }

    /// `ψ` of two places.
    pub fn share(&self, a: [f64; 3], b: [f64; 3]) -> f64 {
        let away = minus(a, b);
        taper(libm::sqrt(dot(away, away)) / self.patch.distance)
    }

    /// `R'` between two nodes; zero of nodes that are no pair.
    fn rest(&self, a: usize, b: usize) -> Block {
        let [a, b] = [a as u32, b as u32];
        let block = self.patch.between(a, b).unwrap_or_default();
        core::array::from_fn(|i| core::array::from_fn(|j| block[3 * i + j]))
    }

    /// Row of the further modes of a node along a component.
    fn row(&self, node: usize, component: usize) -> Option<Numbers<'m>> {
        let m = self.patch.n_modes;
        self.patch.modes?.row((3 * node + component).checked_mul(m)?, m)
    }

    /// The modes `first` on of a node along a component, as many as [`GROUP`]; zeros past the last.
    fn some(&self, node: usize, component: usize, first: usize) -> [f64; GROUP] {
        let row = self.row(node, component);
        core::array::from_fn(|k| row.and_then(|row| row.get(first + k)).unwrap_or(0.0))
    }

    /// Amplitudes of the modes `first` on under forces.
    fn amplitudes<T: Scalar>(&self, first: usize, acting: &Statics<'_, T>) -> [f64; GROUP] {
        let mut sum = [0.0; GROUP];
        for (node, force) in acting.forces() {
            for (component, force) in force.into_iter().enumerate().filter(|(_, force)| *force != 0.0) {
                let row = self.some(node, component, first);
                sum.iter_mut().zip(row).for_each(|(sum, row)| *sum += force * row);
            }
        }
        sum
    }

    /// Displacement of a place at `at` under the forces of a state.
    pub fn answer<T: Scalar>(
        &self,
        residual: &Residual<'_>,
        entries: impl Iterator<Item = (usize, f64)> + Clone,
        at: [f64; 3],
        acting: &Statics<'_, T>,
    ) -> [f64; 3] {
        // As the places of the forces are rounded.
        let at = at.map(|x| T::from_f64(x).to_f64());
        let mut sum = [0.0; 3];
        let mut all_known = true;
        for ((by, force), from) in acting.forces().zip(acting.places()) {
            let share = self.share(at, from);
            for (of, weight) in entries.clone() {
                let known = if at == from { residual.known(of, by) } else { None };
                all_known &= known.is_some();
                if let Some(known) = known {
                    sum = add(sum, weight, times(known, force));
                } else if share > 0.0 {
                    sum = add(sum, weight * share, times(self.rest(of, by), force));
                }
            }
        }
        if all_known {
            return sum;
        }
        for first in (0..self.patch.n_modes).step_by(GROUP) {
            let mut amplitudes = self.amplitudes(first, acting);
            self.of_places(residual, &entries, at, (first, &mut amplitudes), acting, &mut sum);
        }
        sum
    }

    /// Adds the displacement of a place by the modes `first` on, without the forces whose block is known.
    fn of_places<T: Scalar>(
        &self,
        residual: &Residual<'_>,
        entries: &(impl Iterator<Item = (usize, f64)> + Clone),
        at: [f64; 3],
        (first, amplitudes): (usize, &mut [f64; GROUP]),
        acting: &Statics<'_, T>,
        sum: &mut [f64; 3],
    ) {
        for (of, weight) in entries.clone() {
            let mut others = *amplitudes;
            for ((by, force), from) in acting.forces().zip(acting.places()) {
                if at != from || residual.known(of, by).is_none() {
                    continue;
                }
                for (component, force) in force.into_iter().enumerate() {
                    let row = self.some(by, component, first);
                    others.iter_mut().zip(row).for_each(|(sum, row)| *sum -= force * row);
                }
            }
            for (component, sum) in sum.iter_mut().enumerate() {
                let row = self.some(of, component, first);
                *sum += weight * row.iter().zip(others).map(|(row, z)| row * z).sum::<f64>();
            }
        }
    }

    /// `½ fᵀ (S + ψ R') f` \[J\].
    pub fn energy<T: Scalar>(&self, residual: &Residual<'_>, acting: &Statics<'_, T>) -> f64 {
        let work = acting.forces().zip(acting.places()).map(|((node, force), at)| {
            dot(force, self.answer(residual, core::iter::once((node, 1.0)), at, acting))
        });
        0.5 * work.sum::<f64>()
    }

    /// Adds the displacements of all loadable nodes, `out` of shape `(any, 3)`.
    pub fn add_to_surface<T: Scalar>(
        &self,
        residual: &Residual<'_>,
        n_load_nodes: usize,
        acting: &Statics<'_, T>,
        scale: f64,
        out: &mut [T],
    ) {
        if acting.forces().next().is_none() {
            return;
        }
        let nodes = || 0..n_load_nodes;
        for (node, out) in nodes().zip(out.as_chunks_mut::<3>().0) {
            let at = self.node(node).map(|x| T::from_f64(x).to_f64());
            let mut sum = [0.0; 3];
            for ((by, force), from) in acting.forces().zip(acting.places()) {
                let share = self.share(at, from);
                if share > 0.0 {
                    let known = if at == from { residual.known(node, by) } else { None };
                    let more = match known {
                        // Less what the further modes add below.
                        Some(known) => minus(times(known, force), self.by_modes(node, by, force)),
                        None => times(self.rest(node, by), force).map(|x| share * x),
                    };
                    sum = add(sum, 1.0, more);
                }
            }
            out.iter_mut().zip(sum).for_each(|(out, sum)| *out += T::from_f64(scale * sum));
        }
        for first in (0..self.patch.n_modes).step_by(GROUP) {
            let amplitudes = self.amplitudes(first, acting);
            for (node, out) in nodes().zip(out.as_chunks_mut::<3>().0) {
                for (component, out) in out.iter_mut().enumerate() {
                    let row = self.some(node, component, first);
                    let moved: f64 = row.iter().zip(amplitudes).map(|(row, z)| row * z).sum();
                    *out += T::from_f64(scale * moved);
                }
            }
        }
    }

    /// Displacement of a node under a force at another by the further modes.
    fn by_modes(&self, of: usize, by: usize, force: [f64; 3]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for first in (0..self.patch.n_modes).step_by(GROUP) {
            let mut amplitudes = [0.0; GROUP];
            for (component, force) in force.into_iter().enumerate() {
                let row = self.some(by, component, first);
                amplitudes.iter_mut().zip(row).for_each(|(sum, row)| *sum += force * row);
            }
            for (component, sum) in sum.iter_mut().enumerate() {
                let row = self.some(of, component, first);
                *sum += row.iter().zip(amplitudes).map(|(row, z)| row * z).sum::<f64>();
            }
        }
        sum
    }

    /// Position of a place at rest \[m\].
    pub fn position_of(&self, place: &Place) -> [f64; 3] {
        self.position(place.entries().map(|(node, weight)| (node as usize, weight)))
    }

    /// `S + R'` between two nodes of one contact.
    pub fn whole(&self, of: usize, by: usize) -> Block {
        let rest = self.rest(of, by);
        let moved = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| self.by_modes(of, by, e));
        core::array::from_fn(|i| core::array::from_fn(|j| rest[i][j] + moved[j][i]))
    }

    /// Displacements of a contact by the further modes, `out` of shape `(3, n_modes)`.
    pub fn rows<T: Scalar>(&self, shares: &Shares<'_, T>, out: &mut [T]) {
        out.fill(T::ZERO);
        for (component, out) in out.chunks_exact_mut(self.patch.n_modes.max(1)).enumerate() {
            for (node, weight) in shares.entries() {
                let row = self.row(node as usize, component);
                let numbers = row.iter().flat_map(|row| row.iter());
                out.iter_mut().zip(numbers).for_each(|(out, value)| *out += T::from_f64(weight * value));
            }
        }
    }

    /// `ψ H_c R' H_dᵀ` of two contacts.
    pub fn between<T: Scalar>(&self, share: f64, [a, b]: &[Shares<'_, T>; 2]) -> Block {
        let mut sum = [[0.0; 3]; 3];
        if share > 0.0 {
            for (of, of_a) in a.entries() {
                for (by, of_b) in b.entries() {
                    let block = self.rest(of as usize, by as usize);
                    let scale = share * of_a * of_b;
                    let each = sum.as_flattened_mut().iter_mut().zip(block.as_flattened());
                    each.for_each(|(sum, block)| *sum += scale * block);
                }
            }
        }
        sum
    }
}
