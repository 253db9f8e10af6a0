//! Contacts as an operator: how the body yields at contacts to forces that are held over the coming step.
//!
//! ```text
//! u_c(t + Δt) = u_c,free + Σ_d W_cd f_d        W_cd = H_c ((1 − e) R + B P₀ Bᵀ) H_dᵀ
//! ```
//!
//! `H_c` shares a force among the nodes of contact `c`, `P₀` is the answer of each mode to a unit load held
//! over the step, `e = exp(−Δt/β)` (0 without stiffness-proportional damping, see
//! [`crate::sections::filter`]), and `R` is the residual flexibility, which is a contact's own: between two
//! contacts it is left out, so that `W` stays positive semidefinite whatever the file holds of it. Of
//! contacts that share no facet, `W` says exactly what a step does; of contacts that share one, a step
//! shows the residual between them too. This is the Delassus operator of contact mechanics. With it a loop of
//! its caller can solve for stick, slip and release at the end of the step, and is stable whatever the
//! stiffness of what touches the body.

use crate::base::error::{LoadError, StepError};
use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::kernels::kernel::{TILE, add_row};
use crate::scene::bind::place_in_tiles;
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::state::State;
use crate::sections::contact::check_loadable;
use crate::sections::place::Place;
use vademecum_format::SectionKind;

impl<T: Scalar> Scene<'_, T> {
    /// Numbers of work that [`Scene::compliance`] and [`Scene::free_motion`] want for so many contacts.
    #[must_use]
    pub const fn compliance_work(&self, contacts: usize) -> usize {
        self.shape.compliance_work(contacts)
    }

    /// Delassus operator of contacts, for forces held over the coming step: `w` of shape `(3n, 3n)` for `n`
    /// contacts, row by row \[m/N\]; number `(3c + i, 3d + j)` is the displacement of contact `c` in
    /// direction `i` at the end of the step for each newton at contact `d` in direction `j`. The forces of
    /// `contacts` are not looked at. Symmetric and positive semidefinite. `O(n² r)`, and `O(n r²)` more if
    /// dashpots couple the modes; for the diagonal and the exact structure. For contacts that share no facet
    /// it is exactly what a step does.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Exact: file, sizes, scene, state, loads, work);
    /// let touched = Surface::new(&file)?.locate([0.1, 0.05, 0.0]).ok_or("nothing to touch")?;
    /// let force = [1.0, -2.0, -20.0];
    /// let contact = Contact::new(touched.place, force);
    /// let (mut w, mut work) = ([0.0; 9], vec![0.0; scene.compliance_work(1)]);
    /// scene.compliance(&[contact], &mut w, &mut work)?;
    /// let mut free = [[0.0; 3]];
    /// scene.free_motion(&state, &loads, &[contact], &mut free, &mut work)?;
    ///
    /// // What it says is what a step does.
    /// loads.add_contact(&scene, &contact)?;
    /// scene.step(&mut state, &loads)?;
    /// let moved = scene.point(&state, &touched, Field::Displacement)?;
    /// for i in 0..3 {
    ///     let said = free[0][i] + w[3 * i] * force[0] + w[3 * i + 1] * force[1] + w[3 * i + 2] * force[2];
    ///     assert!((said - moved[i]).abs() < 1e-12 * moved[2].abs());
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`LoadError::Mismatch`] for the block structure and for lent memory that is too short,
    /// [`LoadError::NeedsState`] for the strain structure, [`LoadError::NotFinite`] for numbers that
    /// overflow, and the errors of a contact that cannot be added.
    #[doc(alias = "Delassus operator")]
    pub fn compliance(
        &self,
        places: &[impl AsRef<Place>],
        w: &mut [f64],
        work: &mut [T],
    ) -> Result<(), LoadError> {
        let (n, r) = (3 * places.len(), self.shape.r);
        if self.shape.is_strain() {
            return Err(LoadError::NeedsState);
        }
        if self.shape.is_block() || w.len() != n * n {
            return Err(LoadError::Mismatch);
        }
        let mut work = Lender::new(work);
        let (rows, answers) = (work.take(n * r)?, work.take(r)?);
        self.project(places, rows)?;
        let coupled = self.shape.is_coupled();
        if !coupled {
            self.held_answers(answers)?;
        }
        let rows = &*rows;
        for (i, (a, out)) in rows.chunks_exact(r.max(1)).zip(w.chunks_exact_mut(n.max(1))).enumerate() {
            if coupled {
                self.held_answers_to(a, answers)?;
            }
            for (out, b) in out.iter_mut().zip(rows.chunks_exact(r.max(1))).take(i + 1) {
                let products = a.iter().zip(b).zip(&*answers);
                let products = products.map(|((&a, &b), &p)| if coupled { p * b } else { a * p * b });
                *out = products.fold(T::ZERO, |sum, product| sum + product).to_f64();
            }
        }
        for (c, place) in places.iter().enumerate() {
            let own = self.own_residual(place.as_ref());
            for (i, row) in own.iter().enumerate() {
                for (j, value) in row.iter().enumerate().take(i + 1) {
                    if let Some(out) = w.get_mut((3 * c + i) * n + 3 * c + j) {
                        *out += value;
                    }
                }
            }
        }
        for i in 0..n {
            for j in 0..i {
                let below = w.get(i * n + j).copied().unwrap_or(0.0);
                if let Some(above) = w.get_mut(j * n + i) {
                    *above = below;
                }
            }
        }
        check_finite(w)
    }

    /// Displacements of contacts at the end of the coming step if `loads` act over it and nothing else does
    /// \[m\]. State and loads stay as they are. `O(n r)`.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] for the block structure, for a state or loads of another scene, for contacts
    /// that cannot be added, and for lent memory that is too short; [`StepError::NotCarried`],
    /// [`StepError::StaleLoads`]; [`StepError::NotFinite`] for numbers that overflow.
    #[doc(alias = "free velocity")]
    pub fn free_motion(
        &self,
        state: &State<'_, T>,
        loads: &Loads<'_, T>,
        places: &[impl AsRef<Place>],
        out: &mut [[f64; 3]],
        work: &mut [T],
    ) -> Result<(), StepError> {
        let shapes = state.shape == self.shape && loads.shape == self.shape;
        if !shapes || self.shape.is_block() || out.len() != places.len() {
            return Err(StepError::Mismatch);
        }
        self.check_carried(state)?;
        self.check_fresh(loads)?;
        let (n, r) = (3 * places.len(), self.shape.r);
        let mut work = Lender::new(work);
        let rows = work.take(n * r)?;
        self.project(places, rows).map_err(|_| StepError::Mismatch)?;
        if self.shape.is_strain() {
            let moved = self.strain_ahead(state, loads, work.rest())?;
            show(rows, moved, out);
            return check_shown(out);
        }
        let moved = work.take(r)?;
        self.coordinates_ahead(state, loads, moved)?;
        show(rows, moved, out);
        let (filter, old, filters) = (&self.filter, &state.filtered.forces, self.shape.is_filtered());
        let acting = if filters { &loads.drive } else { &loads.statics };
        let kept = filters && !old.is_empty();
        if !acting.is_empty() || kept {
            for (place, out) in places.iter().zip(&mut *out) {
                for (node, weight) in place.as_ref().entries() {
                    let scale = weight / self.parameters.stiffness;
                    let rest = self.sections.residual.node(node as usize, acting);
                    out.iter_mut().zip(rest).for_each(|(out, rest)| *out += scale * rest);
                    if kept {
                        let scale = scale * filter.keep;
                        let rest = self.sections.residual.node(node as usize, old);
                        out.iter_mut().zip(rest).for_each(|(out, rest)| *out += scale * rest);
                    }
                }
            }
        }
        check_shown(out)
    }

    /// Coordinates of the modes at the end of the coming step under `loads`, `out` of length `r`; not of the
    /// strain structure.
    pub(crate) fn coordinates_ahead(
        &self,
        state: &State<'_, T>,
        loads: &Loads<'_, T>,
        out: &mut [T],
    ) -> Result<(), Short> {
        let r = self.shape.r;
        for (k, out) in out.iter_mut().enumerate() {
            let increment = |part: usize, mode: usize| {
                let number = state.y.part(part).get(mode).copied().unwrap_or(T::ZERO);
                Ok::<T, Short>(T::from_f64(self.increment(k, part * r + mode)?) * number)
            };
            let mut next = loads.increment.get(k).copied().unwrap_or(T::ZERO);
            let modes = if self.shape.is_coupled() { 0..r } else { k..k + 1 };
            for part in 0..self.shape.n_parts() {
                for mode in modes.clone() {
                    next += increment(part, mode)?;
                }
            }
            *out = state.y.part(0).get(k).copied().unwrap_or(T::ZERO) + next;
        }
        Ok(())
    }

    /// `H_c B` of each contact, `(n, 3, r)`.
    pub(crate) fn project(&self, places: &[impl AsRef<Place>], rows: &mut [T]) -> Result<(), LoadError> {
        let (kind, r) = (SectionKind::SurfaceBasis, self.shape.r);
        let basis = self.sections.rows.surface.ok_or(LoadError::Missing { kind })?;
        rows.fill(T::ZERO);
        let mut rows = rows.chunks_exact_mut(r.max(1));
        for place in places {
            let place = place.as_ref();
            check_loadable(place, self.metadata.n_load_nodes)?;
            for component in 0..3 {
                let out = rows.next().ok_or(LoadError::Mismatch)?;
                for (node, weight) in place.entries() {
                    let row = basis.row((3 * node as usize + component) * r, r);
                    add_row(row.ok_or(LoadError::Missing { kind })?, T::from_f64(weight), out);
                }
            }
        }
        Ok(())
    }

    /// Answer of each mode's displacement to a unit load that is held over the step.
    pub(crate) fn held_answers(&self, answers: &mut [T]) -> Result<(), Short> {
        answers.fill(T::ZERO);
        let mut maps = Lender::new(&*self.load_maps);
        for _ in 0..self.shape.n_stages {
            let map = maps.take(self.shape.load_map_len())?;
            answers.iter_mut().zip(map).for_each(|(sum, &answer)| *sum += answer);
        }
        Ok(())
    }

    /// Answer of all modes' displacements to a load along `force` that is held over the step, where dashpots
    /// couple them.
    fn held_answers_to(&self, force: &[T], answers: &mut [T]) -> Result<(), Short> {
        answers.fill(T::ZERO);
        let mut maps = Lender::new(&*self.load_maps);
        for _ in 0..self.shape.n_stages {
            let map = maps.take(self.shape.load_map_len())?;
            for (i, answer) in answers.iter_mut().enumerate() {
                let row = map.iter().skip(place_in_tiles(i, 0, force.len())).step_by(TILE);
                row.zip(force).for_each(|(&map, &force)| *answer += map * force);
            }
        }
        Ok(())
    }

    /// `(1 − e) H_c R H_cᵀ` of one contact \[m/N\]; `e = 0` without stiffness-proportional damping.
    fn own_residual(&self, place: &Place) -> [[f64; 3]; 3] {
        let share = if self.shape.is_filtered() { self.filter.held() } else { 1.0 };
        self.residual_at(place).map(|row| row.map(|value| share * value))
    }

    /// `H_c R H_cᵀ` of one contact \[m/N\].
    pub(crate) fn residual_at(&self, place: &Place) -> [[f64; 3]; 3] {
        let mut sum = [[0.0; 3]; 3];
        if self.shape.statics[0] == 0 {
            return sum;
        }
        for (a, of_a) in place.entries() {
            for (b, of_b) in place.entries() {
                let scale = of_a * of_b / self.parameters.stiffness;
                let block = self.sections.residual.between(a as usize, b as usize);
                for (sum, block) in sum.as_flattened_mut().iter_mut().zip(block.as_flattened()) {
                    *sum += scale * block;
                }
            }
        }
        sum
    }
}

/// Refuses an operator of which a number overflowed.
pub(crate) fn check_finite(w: &[f64]) -> Result<(), LoadError> {
    if w.iter().all(|number| number.is_finite()) { Ok(()) } else { Err(LoadError::NotFinite) }
}

/// Refuses displacements that overflowed: those of a step that would be refused.
fn check_shown(out: &[[f64; 3]]) -> Result<(), StepError> {
    let finite = out.as_flattened().iter().all(|number| number.is_finite());
    if finite { Ok(()) } else { Err(StepError::NotFinite) }
}

/// Displacements of contacts, from their rows `(n, 3, r)` and the coordinates.
fn show<T: Scalar>(rows: &[T], moved: &[T], out: &mut [[f64; 3]]) {
    let r = moved.len().max(1);
    for (row, out) in rows.chunks_exact(r).zip(out.as_flattened_mut()) {
        let products = row.iter().zip(moved).map(|(&a, &b)| a * b);
        *out = products.fold(T::ZERO, |sum, product| sum + product).to_f64();
    }
}
