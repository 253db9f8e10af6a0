//! Contacts as an operator: how the body yields at contacts to forces that are held over the coming step.
//!
//! ```text
//! u_c(t + Δt) = u_c,free + Σ_d W_cd f_d        W_cd = H_c ((1 − e) R + B P₀ Bᵀ) H_dᵀ
//! ```
//!
//! `H_c` shares a force among the nodes of contact `c`, `P₀` is the answer of each mode to a unit load held
//! over the step, `e = exp(−Δt/β)` (0 without stiffness-proportional damping, see
//! [`crate::sections::filter`]), and `R` is the residual flexibility. Between two contacts it is that of the
//! file's contact patch, tapered so that `W` stays positive semidefinite ([`crate::sections::near`]), and `W`
//! is exactly what a step does. Without a patch it is a contact's own and left out between two: then `W` is
//! exact of contacts that share no facet; of contacts that share one, a step shows it between them too. This is the Delassus operator of contact mechanics. With it a loop of
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
use crate::sections::contact::{Shares, check_loadable};
use crate::sections::disc::{largest, spread};
use crate::sections::near::Near;
use crate::sections::place::{Place, PlaceError};
use crate::sections::residual::Statics;
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
    /// dashpots couple the modes; for the diagonal and the exact structure. Of a
    /// file with a contact patch, and for contacts that share no facet, it is exactly what a step does.
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
        let discs = work.take(2 * self.shape.disc_nodes * places.len())?.as_chunks_mut().0;
        self.project(places, rows, discs)?;
        let discs = &*discs;
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
        if let Some(near) = self.sections.residual.near.as_ref().filter(|_| self.shape.has_patch) {
            let further = work.take(n * self.shape.further)?;
            self.add_between(near, (places, discs), further, w);
        }
        for (c, place) in places.iter().enumerate() {
            let own = self.residual_at(&self.known_shares(c, place.as_ref(), discs));
            let share = self.held_share();
            for (i, row) in own.iter().enumerate() {
                for (j, value) in row.iter().enumerate().take(i + 1) {
                    if let Some(out) = w.get_mut((3 * c + i) * n + 3 * c + j) {
                        *out += share * value;
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
        let discs = work.take(2 * self.shape.disc_nodes * places.len())?.as_chunks_mut().0;
        self.project(places, rows, discs).map_err(|_| StepError::Mismatch)?;
        let discs = &*discs;
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
            let residual = &self.sections.residual;
            for ((c, place), out) in places.iter().enumerate().zip(&mut *out) {
                let shares = self.known_shares(c, place.as_ref(), discs);
                let at = residual.position(place.as_ref());
                let mut add = |share: f64, statics: &Statics<'_, T>| {
                    let nodes = shares.entries().map(|(node, weight)| (node as usize, weight));
                    residual.place(nodes, at, statics, |weight, rest| {
                        let scale = weight / self.parameters.stiffness * share;
                        out.iter_mut().zip(rest).for_each(|(out, rest)| *out += scale * rest);
                    });
                };
                add(1.0, acting);
                if kept {
                    add(filter.keep, old);
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
    /// The discs of places with a radius, as many entries for each as the scene has room for, go to `discs`.
    pub(crate) fn project(
        &self,
        places: &[impl AsRef<Place>],
        rows: &mut [T],
        discs: &mut [[T; 2]],
    ) -> Result<(), LoadError> {
        let (kind, r) = (SectionKind::SurfaceBasis, self.shape.r);
        let basis = self.sections.rows.surface.ok_or(LoadError::Missing { kind })?;
        rows.fill(T::ZERO);
        let mut rows = rows.chunks_exact_mut(r.max(1));
        for (c, place) in places.iter().enumerate() {
            let each = self.shape.disc_nodes;
            let disc = discs.get_mut(c * each..).and_then(|discs| discs.get_mut(..each)).unwrap_or_default();
            let shares = self.shares(place.as_ref(), disc)?;
            for component in 0..3 {
                let out = rows.next().ok_or(LoadError::Mismatch)?;
                for (node, weight) in shares.entries() {
                    let row = basis.row((3 * node as usize + component) * r, r);
                    add_row(row.ok_or(LoadError::Missing { kind })?, T::from_f64(weight), out);
                }
            }
        }
        Ok(())
    }

    /// Nodes and shares of a place, those of a disc in `disc`.
    pub(crate) fn shares<'a>(
        &self,
        place: &'a Place,
        disc: &'a mut [[T; 2]],
    ) -> Result<Shares<'a, T>, LoadError> {
        if !cfg!(feature = "full") || place.radius() == 0.0 || self.shape.disc_nodes == 0 {
            check_loadable(place, self.metadata.n_load_nodes)?;
            return Ok(Shares::of_point(place));
        }
        let radius = place.radius();
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(PlaceError::Radius { radius }.into());
        }
        check_loadable(&place.with_radius(0.0), self.metadata.n_load_nodes)?;
        let kind = SectionKind::Triangles;
        let surface = self.sections.surface.as_ref().ok_or(LoadError::Missing { kind })?;
        match spread(surface, place, disc) {
            Some(count) => {
                disc.iter_mut().skip(count).for_each(|entry| *entry = [T::ZERO; 2]);
                Ok(Shares::of_disc(disc.get(..count).unwrap_or_default()))
            }
            None => {
                let (largest, room) = (largest(surface, place, disc), disc.len());
                Err(LoadError::Disc { radius, largest, room })
            }
        }
    }

    /// Shares that were found before, of place number `c`.
    fn known_shares<'a>(&self, c: usize, place: &'a Place, discs: &'a [[T; 2]]) -> Shares<'a, T> {
        let each = self.shape.disc_nodes;
        if each == 0 || place.radius() == 0.0 {
            return Shares::of_point(place);
        }
        Shares::of_disc(discs.get(c * each..).and_then(|discs| discs.get(..each)).unwrap_or_default())
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

    /// Adds the residual flexibility between contacts, below the diagonal; `rows` of `(n, 3, further)`.
    fn add_between(
        &self,
        near: &Near<'_>,
        (places, discs): (&[impl AsRef<Place>], &[[T; 2]]),
        rows: &mut [T],
        w: &mut [f64],
    ) {
        let (n, m) = (3 * places.len(), self.shape.further);
        let scale = self.held_share() / self.parameters.stiffness;
        for ((c, place), out) in places.iter().enumerate().zip(rows.chunks_exact_mut((3 * m).max(1))) {
            near.rows(&self.known_shares(c, place.as_ref(), discs), out);
        }
        let row = |contact: usize, component: usize| rows.iter().skip((3 * contact + component) * m).take(m);
        for (c, of) in places.iter().enumerate() {
            for (d, by) in places.iter().enumerate().take(c) {
                let (of, by) = (of.as_ref(), by.as_ref());
                let share = near.share(near.position_of(of), near.position_of(by));
                if share == 0.0 && m == 0 {
                    continue;
                }
                let shares = [(c, of), (d, by)].map(|(c, place)| self.known_shares(c, place, discs));
                let block = near.between(share, &shares);
                for (i, block) in block.iter().enumerate() {
                    for (j, &rest) in block.iter().enumerate() {
                        let products = row(c, i).zip(row(d, j)).map(|(&a, &b)| a * b);
                        let further = products.fold(T::ZERO, |sum, product| sum + product).to_f64();
                        if let Some(out) = w.get_mut((3 * c + i) * n + 3 * d + j) {
                            *out += scale * (rest + further);
                        }
                    }
                }
            }
        }
    }

    /// Share of the residual that answers at the end of the step: 1 without stiffness-proportional damping.
    const fn held_share(&self) -> f64 {
        if self.shape.is_filtered() { self.filter.held() } else { 1.0 }
    }

    /// `H_c R H_cᵀ` of one contact \[m/N\].
    fn residual_at(&self, shares: &Shares<'_, T>) -> [[f64; 3]; 3] {
        let residual = &self.sections.residual;
        self.residual_by(shares, |a, b| residual.together(a, b))
    }

    /// The same of a place, with what the sections of a single contact have.
    #[cfg(feature = "world")]
    pub(crate) fn residual_of(&self, place: &Place) -> [[f64; 3]; 3] {
        let residual = &self.sections.residual;
        self.residual_by(&Shares::of_point(place), |a, b| residual.between(a, b))
    }

    fn residual_by(
        &self,
        shares: &Shares<'_, T>,
        between: impl Fn(usize, usize) -> [[f64; 3]; 3],
    ) -> [[f64; 3]; 3] {
        let mut sum = [[0.0; 3]; 3];
        if self.shape.statics[0] == 0 {
            return sum;
        }
        for (a, of_a) in shares.entries() {
            for (b, of_b) in shares.entries() {
                let scale = of_a * of_b / self.parameters.stiffness;
                let block = between(a as usize, b as usize);
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
