//! Ports at values of the parameters: residual flexibility and residual inertia between their rows, and what
//! their forces do at nodes, at probes and beside patterns.
//!
//! With `w_i = (K⁻¹ − X Λ⁻¹ Xᵀ) a_i` the modes that are not stepped answer row `b` by `b w_i`, and between
//! two ports their inertia is `w_iᵀ M w_j`. The part outside of the basis is scaled as that of loadable nodes
//! is: a row of a patch as its node, or by the mean over the port where that is not loadable.

use crate::kernels::dense::{add_scaled, apply, dot, row, solve_lower, solve_upper};
use crate::parametric::model::{Parametric, Scales};
use crate::parametric::rows::{Reals, along, read_row};
use crate::parametric::tuned::Tuned;
use vademecum_format::{FormatError, Numbers, SectionKind as S};

/// Answers to unit forces at the rows of the ports.
pub(crate) struct PortAnswers<'w> {
    /// `w`, a row for each row of a port.
    rows: &'w [f64],
    /// `√ρ` of each row.
    roots: &'w [f64],
    /// Factor on the mass outside of the basis.
    mass: f64,
    r: usize,
}

impl<'w> PortAnswers<'w> {
    /// Numbers of so many rows of ports.
    pub const fn len(rows: usize, r: usize) -> usize {
        rows.saturating_mul(r + 1)
    }

    /// `node_roots` are `√ρ` of the loadable nodes.
    pub fn new(
        model: &Parametric<'_>,
        (tuned, scales): (&Tuned<'_>, &Scales<'_>),
        node_roots: &[f64],
        (work, lent): (&mut [f64], &'w mut [f64]),
    ) -> Result<Self, FormatError> {
        let r = model.n_basis();
        let missing = |kind: S| FormatError::Missing { kind: kind.number() };
        let section = |kind: S| model.file.section(kind).ok_or(missing(kind));
        let own = section(S::PortRows)?.numbers()?;
        let m = own.len().checked_div(r).unwrap_or(0);
        let (roots, rows) = lent.split_at_mut(m.min(lent.len()));
        let table = section(S::PortTable)?.u32s()?;
        let nodes = match model.file.section(S::PortNodes) {
            Some(section) => section.u32s()?,
            None => &[],
        };
        let all = mean(node_roots.iter().copied()).unwrap_or(1.0 / libm::sqrt(scales.stiffness));
        roots.fill(all);
        for port in table.as_chunks::<7>().0 {
            let [_, first, count, node, n_nodes, ..] = port.map(|x| u32::from_le_bytes(x) as usize);
            let of_port = nodes.get(node..node.saturating_add(n_nodes)).unwrap_or_default();
            let known = |node: &[u8; 4]| node_roots.get(u32::from_le_bytes(*node) as usize).copied();
            let own = mean(of_port.iter().filter_map(known)).unwrap_or(all);
            // A patch has three rows a node.
            for (row, root) in roots.iter_mut().skip(first).take(count).enumerate() {
                *root = of_port.get(row / 3).and_then(known).unwrap_or(own);
            }
        }
        for (place, w) in rows.chunks_exact_mut(r.max(1)).enumerate() {
            let a = work.get_mut(..r).unwrap_or_default();
            read_row(&own, place, a);
            w.iter_mut().zip(&*a).for_each(|(to, from)| *to = *from);
            solve_lower(tuned.lower, r, w);
            solve_upper(tuned.lower, r, w);
            let along_modes = along(tuned.shapes, a).zip(tuned.eigenvalues);
            for (shape, (value, eigenvalue)) in tuned.shapes.chunks_exact(r.max(1)).zip(along_modes) {
                add_scaled(w, -value / eigenvalue, shape);
            }
        }
        let count = model.live.n_regions;
        let densities = (1..=count).map(|region| model.scale_of(scales, region, true));
        Ok(Self { rows, roots, mass: mean(densities).unwrap_or(scales.density), r })
    }

    fn of(&self, place: usize) -> &[f64] {
        row(self.rows, place, self.r)
    }

    /// Residual flexibility between the rows.
    pub fn write_compliance(
        &self,
        ports: &Numbers<'_>,
        numbers: &Numbers<'_>,
        (work, out): (&mut [f64], &mut Reals<'_>),
    ) {
        let own = work.get_mut(..self.r).unwrap_or_default();
        let mut built = numbers.iter();
        for (i, &root) in self.roots.iter().enumerate() {
            read_row(ports, i, own);
            for (j, &other) in self.roots.iter().enumerate() {
                out.push(root * other * built.next().unwrap_or(0.0) + dot(own, self.of(j)));
            }
        }
    }

    /// Residual inertia between the rows.
    pub fn write_inertia(
        &self,
        tuned: &Tuned<'_>,
        numbers: &Numbers<'_>,
        (work, out): (&mut [f64], &mut Reals<'_>),
    ) {
        let own = work.get_mut(..self.r).unwrap_or_default();
        let mut built = numbers.iter();
        for (i, &root) in self.roots.iter().enumerate() {
            match tuned.mass {
                [] => own.iter_mut().zip(self.of(i)).for_each(|(to, w)| *to = tuned.density * w),
                mass => apply(mass, self.of(i), own),
            }
            for (j, &other) in self.roots.iter().enumerate() {
                let scale = self.mass * root * root * other * other;
                out.push(scale * built.next().unwrap_or(0.0) + dot(own, self.of(j)));
            }
        }
    }

    /// Residual flexibility between the rows and displacements of surface nodes, probes or patterns, which
    /// are `others` over the basis. `node_roots` are `√ρ` of loadable nodes; none of probes and patterns.
    pub fn write_others(
        &self,
        others: &Numbers<'_>,
        node_roots: &[f64],
        numbers: &Numbers<'_>,
        (work, out): (&mut [f64], &mut Reals<'_>),
    ) {
        let own = work.get_mut(..self.r).unwrap_or_default();
        let count = others.len().checked_div(self.r).unwrap_or(0);
        for (place, &root) in self.roots.iter().enumerate() {
            for other in 0..count {
                read_row(others, other, own);
                let scale = root * node_roots.get(other / 3).copied().unwrap_or(root);
                let built = numbers.get(place * count + other).unwrap_or(0.0);
                out.push(scale * built + dot(own, self.of(place)));
            }
        }
    }
}

/// Mean of numbers; `None` of none.
fn mean(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = numbers.fold((0.0, 0_u32), |(sum, count), x| (sum + x, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}
