//! Large displacements: the step of the strain structure, its energy, its compliance, and whether a state is
//! one that the training has seen.
//!
//! The strain `z(q) = L q + Q(q, q)` of the body is quadratic in its coordinates, and its energy `½|z|²`. A
//! state is the displacement `ζ` and `Δt ζ̇` at one instant. It stands for two places half a sub-step `k`
//! before and after that instant, `ζ ∓ p/2` with `p = k ζ̇/√m`, where `m` is the inertia of each coordinate.
//! The step is centred at the later one, `q = ζ + p/2`, where the loads act; there is no iteration, and an
//! energy that is no function of a linearisation is kept exactly
//! (`docs/explanation/large-displacements-reduced.md` has the scheme and its proofs).
//!
//! Note: the energy has the strain `z(ζ + p/2, ζ − p/2)`, in which one place meets the other. It
//! differs from `z(ζ)` by `Q(p, p)/4`.

use crate::base::error::{LoadError, OutputError, StepError};
use crate::base::lend::{Lender, Short};
use crate::base::options::Status;
use crate::base::scalar::Scalar;
use crate::kernels::strain::kernel::{Force, answer, dissipated, moved, prepare, strain_square, sub_step};
use crate::kernels::strain::map::distance;
use crate::kernels::strain::memory::{Scratch, StrainMap};
use crate::motion::compliance::check_finite;
use crate::scene::equation::Energy;
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::state::State;
use crate::sections::place::Place;

/// Energy balance of a step \[J\], see [`Scene::step_metered`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyAccount {
    /// Energy before the step.
    pub before: f64,
    /// Energy after it.
    pub after: f64,
    /// Work of the loads.
    pub work: f64,
    /// Energy that damping took; never negative.
    pub dissipated: f64,
}

impl EnergyAccount {
    /// Rest of the balance: `after − before − work + dissipated`, which is rounding.
    #[must_use]
    pub fn violation(&self) -> f64 {
        self.after - self.before - self.work + self.dissipated
    }
}

/// Comparison of a state with those of the training, see [`Scene::training`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Training {
    /// Distance of the state from rest, `|W q|`.
    pub distance: f64,
    /// The largest of the training.
    pub largest_distance: f64,
    /// Energy of the state \[J\], with the stiffness as built.
    pub energy: f64,
    /// The largest of the training \[J\].
    pub largest_energy: f64,
}

impl Training {
    /// `true` if the training has seen states as far from rest, and as much energy. Outside, a step is as
    /// stable as inside, but nobody has measured how accurate.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        self.distance <= self.largest_distance && self.energy <= self.largest_energy
    }
}

impl<T: Scalar> Scene<'_, T> {
    /// [`Scene::step`] of the strain structure, with an account of its energy: it tells at run time that the
    /// step is right. Costs three steps; a step without it pays nothing for it.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BENT, Auto: file, sizes, scene, state, loads, work);
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// let (_, account) = scene.step_metered(&mut state, &loads)?;
    /// assert!(account.work != 0.0 && account.dissipated >= 0.0);
    /// assert!(account.violation().abs() < 1e-12 * account.after);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`Scene::step`]; [`StepError::Mismatch`] for the other structures.
    pub fn step_metered(
        &self,
        state: &mut State<'_, T>,
        loads: &Loads<'_, T>,
    ) -> Result<(Status, EnergyAccount), StepError> {
        if !self.shape.is_strain() || loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        self.check_carried(state)?;
        self.check_fresh(loads)?;
        let before = self.kept_energy(state).map_err(|_| StepError::Mismatch)?.total();
        let mut account = EnergyAccount { before, ..EnergyAccount::default() };
        let status = if state.y.at_rest && !loads.active {
            Status::AtRest
        } else {
            self.march_strain(state, loads, Some(&mut account))?
        };
        account.after = self.kept_energy(state).map_err(|_| StepError::Mismatch)?.total();
        Ok((status, account))
    }

    /// Comparison of the state with those of the file's training. A scaled stiffness or density is taken into
    /// account. Costs `O(r²)` and about a step.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BENT, Auto: file, sizes, scene, state, loads, work);
    /// assert!(scene.training(&state)?.is_inside()); // at rest
    /// scene.set(&mut state, &[1e3; 3], &[0.0; 3], &loads)?;
    /// assert!(!scene.training(&state)?.is_inside()); // further than any state of the training
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError::NoTraining`], [`OutputError::Mismatch`].
    pub fn training(&self, state: &State<'_, T>) -> Result<Training, OutputError> {
        self.check(state)?;
        let [rows, limits] = self.sections.strain.training.ok_or(OutputError::NoTraining)?;
        let &[largest_distance, largest_energy] = limits else { return Err(OutputError::NoTraining) };
        Ok(Training {
            distance: distance(rows, state.y.part(0)),
            largest_distance: f64::from_le_bytes(largest_distance),
            energy: self.kept_energy(state)?.total() / self.parameters.stiffness,
            largest_energy: f64::from_le_bytes(largest_energy),
        })
    }

    /// Delassus operator of contacts, for forces held over the coming step, in the present state:
    /// [`Scene::compliance`], which is the same for every state of a linear body. With the strain structure
    /// the matrix is that of the coming step's own solve, so it is exactly what this step does, and another
    /// one for the next step. `O(n r²)` there.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BENT, Auto: file, sizes, scene, state, loads, work);
    /// scene.set(&mut state, &[0.2, -0.1, 0.05], &[1.0; 3], &loads)?;
    /// let touched = Surface::new(&file)?.locate([0.1, 0.05, 0.0]).ok_or("nothing to touch")?;
    /// let force = [1.0, -2.0, -20.0];
    /// let contact = Contact::new(touched.place, force);
    /// let (mut w, mut work) = ([0.0; 9], vec![0.0; scene.compliance_work(1)]);
    /// scene.compliance_at(&state, &[contact], &mut w, &mut work)?;
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
    /// As [`Scene::compliance`]; [`LoadError::Substeps`] for a scene of the strain structure with more than
    /// one sub-step.
    pub fn compliance_at(
        &self,
        state: &State<'_, T>,
        places: &[impl AsRef<Place>],
        w: &mut [f64],
        work: &mut [T],
    ) -> Result<(), LoadError> {
        if !self.shape.is_strain() {
            return self.compliance(places, w, work);
        }
        let (n, r) = (3 * places.len(), self.shape.r);
        if state.shape != self.shape || w.len() != n * n {
            return Err(LoadError::Mismatch);
        }
        let substeps = self.strain.substeps;
        if substeps != 1 {
            return Err(LoadError::Substeps { substeps });
        }
        let mut work = Lender::new(work);
        let rows = work.take(n * r)?;
        self.project(places, rows)?;
        let map = self.strain_map()?;
        let mut scratch = Scratch::new(self.shape.strain, work.take(self.shape.scratch_len())?)?;
        let p = state.y.part(1).iter().enumerate().map(|(i, p)| T::from_f64(map.p_of(i, p.to_f64())));
        prepare(&map, state.y.part(0), p, &mut scratch)?;
        let of_force = self.strain.of_force(self.parameters.density);
        for (j, row) in rows.chunks_exact(r.max(1)).enumerate() {
            answer(&map, row, &mut scratch);
            for (i, other) in rows.chunks_exact(r.max(1)).enumerate().skip(j) {
                let products = other.iter().zip(moved(&map, &scratch)).map(|(&a, d)| a.to_f64() * d.to_f64());
                let value = of_force * products.sum::<f64>();
                for at in [i * n + j, j * n + i] {
                    w.get_mut(at).into_iter().for_each(|out| *out = value);
                }
            }
        }
        check_finite(w)
    }

    /// Coordinates at the end of the coming step, `(r)`, and the rest of the work.
    pub(crate) fn strain_ahead<'w>(
        &self,
        state: &State<'_, T>,
        loads: &Loads<'_, T>,
        work: &'w mut [T],
    ) -> Result<&'w [T], StepError> {
        let mut work = Lender::new(work);
        let (y, scratch) = (work.take(self.shape.padded())?, work.take(self.shape.scratch_len())?);
        y.iter_mut().zip(&*state.y.now).for_each(|(out, &now)| *out = now);
        self.sub_steps(y, loads.increment, scratch, None)?;
        y.get(..self.shape.r).ok_or(StepError::Mismatch)
    }

    /// The step of a state that moves or is loaded.
    pub(crate) fn march_strain(
        &self,
        state: &mut State<'_, T>,
        loads: &Loads<'_, T>,
        account: Option<&mut EnergyAccount>,
    ) -> Result<Status, StepError> {
        let y = &mut state.y;
        y.next.iter_mut().zip(&*y.now).for_each(|(next, &now)| *next = now);
        let magnitude = self.sub_steps(y.next, loads.increment, state.scratch, account)?;
        y.settle(magnitude, loads.active, self.rest_below)
    }

    /// All sub-steps of a step, in place; `Σ|y|`.
    pub(crate) fn sub_steps(
        &self,
        y: &mut [T],
        increment: &[T],
        scratch: &mut [T],
        mut account: Option<&mut EnergyAccount>,
    ) -> Result<T, Short> {
        let (step, r) = (&self.strain, self.shape.r);
        let mut lent = Lender::new(&mut *y);
        let (mean, p) = (lent.take(r)?, lent.take(r)?);
        let mut lent = Lender::new(increment);
        let (start, rise) = (lent.take(r)?, lent.take(r)?);
        let map = self.strain_map()?;
        let mut scratch = Scratch::new(self.shape.strain, scratch)?;
        let substeps = step.substeps as f64;
        let scale = T::from_f64(1.0 / substeps);
        for (p, root) in p.iter_mut().zip(map.roots) {
            *p = T::from_f64((*p * scale).to_f64() / root.to_f64());
        }
        for j in 0..step.substeps {
            let fraction = T::from_f64((j as f64 + 0.5) / substeps);
            let force = Force { start, rise, fraction };
            sub_step(&map, mean, p, force, &mut scratch)?;
            if let Some(account) = account.as_deref_mut() {
                let unit = 2.0 * self.parameters.density / (step.step * step.step);
                let pushed = force.values().zip(moved(&map, &scratch));
                account.work += unit * pushed.map(|(f, d)| f.to_f64() * d.to_f64()).sum::<f64>();
                account.dissipated += unit * dissipated(&map, &scratch);
            }
        }
        let scale = T::from_f64(substeps);
        for (p, &root) in p.iter_mut().zip(map.roots) {
            *p = *p * scale * root;
        }
        let mut magnitude = T::ZERO;
        for value in y.iter_mut() {
            let size = value.magnitude();
            magnitude += size;
            if size < T::FLOOR {
                *value = T::ZERO;
            }
        }
        Ok(magnitude)
    }

    /// The energy that the scheme keeps.
    pub(crate) fn kept_energy(&self, state: &State<'_, T>) -> Result<Energy, OutputError> {
        self.check(state)?;
        if !self.shape.is_strain() {
            return Err(OutputError::NoTraining);
        }
        let (step, density) = (&self.strain, self.parameters.density);
        let (mean, rates) = (state.y.part(0), state.y.part(1));
        let map = self.strain_map()?;
        let rate = |i: usize| rates.get(i).map_or(0.0, |p| p.to_f64()) / step.substeps as f64;
        let p = |i: usize| map.p_of(i, rate(i));
        let unit = 2.0 * density / (step.step * step.step);
        let square: f64 = rates.iter().map(|x| x.to_f64() * x.to_f64()).sum();
        let per_second = 1.0 / state.y.time_step;
        Ok(Energy {
            kinetic: 0.5 * density * square * per_second * per_second,
            elastic: unit * strain_square(&map, mean, p),
        })
    }

    fn strain_map(&self) -> Result<StrainMap<'_, T>, Short> {
        StrainMap::new(self.shape.strain, T::from_f64(self.strain.mass), self.strain.is_damped(), self.map)
    }
}
