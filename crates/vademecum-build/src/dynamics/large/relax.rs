//! The shape of least energy among those with prescribed coordinates: `u*(q) = argmin V(u)`, `VᵀM u = q`.
//!
//! Balance under forces `λ` along the momenta `W = M V`, found by Newton's method in a border:
//!
//! ```text
//! [ K(u)  W ] [ p ]   [ −f(u)      ]
//! [ Wᵀ    0 ] [ λ ] = [ q − Wᵀ u   ]
//! ```
//!
//! One factorisation of the tangent and a solve for `W` at each correction, in the two forms of Newton's
//! method that `newton.rs` explains. The first correction meets the constraint, and the others stay on it.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef, Side};

use super::error::{LargeError, check_length};
use super::newton::{DIVERGED, Newton, ROUNDING};
use super::vectors::{add, dot, sum};
use crate::fem::{Factor, FactorError, GreenStrain, Solve, Symbolic};
use crate::linalg::transposed_product;

/// Shapes of least energy at prescribed coordinates of a basis, each begun at the one before.
pub struct Relaxation<'a> {
    strain: &'a GreenStrain<'a>,
    symbolic: &'a Symbolic,
    newton: Newton,
    /// `M V`, shape (n, r).
    momenta: Mat<f64>,
    displacement: Vec<f64>,
    coordinates: Vec<f64>,
    factorisations: usize,
}

/// A shape of least energy.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxed {
    /// Displacement over the free dofs \[m\].
    pub displacement: Vec<f64>,
    /// Multipliers `λ` of the constraints: the force is `G(u)ᵀ z(u) = M V λ`, so that `λ` is the gradient of
    /// the least energy in `q`.
    pub forces: Vec<f64>,
    /// Factorisations it took.
    pub factorisations: usize,
}

/// Most halvings of the way to the prescribed coordinates.
const HALVINGS: i32 = 8;

impl<'a> Relaxation<'a> {
    /// Relaxations over a basis, shape (n, r); they begin at rest.
    ///
    /// # Errors
    /// [`LargeError`]: a body without supports, a basis of another height.
    pub fn new(
        strain: &'a GreenStrain<'a>,
        symbolic: &'a Symbolic,
        basis: MatRef<'_, f64>,
        newton: Newton,
    ) -> Result<Relaxation<'a>, LargeError> {
        let n = strain.n_dof();
        check_length("the basis", basis.nrows(), n)?;
        let pencil = strain.model().pencil();
        if pencil.rigid().is_some() {
            return Err(LargeError::FreeBody);
        }
        let mut momenta = Mat::zeros(n, basis.ncols());
        let columns = basis.to_owned();
        pencil.mass().mul_into(columns.as_ref(), momenta.as_mut());
        let coordinates = vec![0.0; basis.ncols()];
        let displacement = vec![0.0; n];
        Ok(Relaxation { strain, symbolic, newton, momenta, displacement, coordinates, factorisations: 0 })
    }

    /// Begins anew at a displacement; the next relaxation starts there.
    ///
    /// # Errors
    /// [`LargeError::Length`].
    pub fn begin_at(&mut self, displacement: &[f64]) -> Result<(), LargeError> {
        check_length("the displacement", displacement.len(), self.strain.n_dof())?;
        self.displacement = displacement.to_vec();
        self.coordinates = self.project(displacement);
        Ok(())
    }

    /// The shape at coordinates `q`. The way there is halved where Newton's method finds no shape; the next
    /// relaxation starts at the last shape that was found.
    ///
    /// # Errors
    /// [`LargeError::NoShape`], a length, memory.
    pub fn relax(&mut self, q: &[f64]) -> Result<Relaxed, LargeError> {
        check_length("the prescribed coordinates", q.len(), self.coordinates.len())?;
        self.factorisations = 0;
        let from = self.coordinates.clone();
        let (mut reached, mut part) = (0.0, 1.0);
        loop {
            let next = if reached + 1.001 * part >= 1.0 { 1.0 } else { reached + part };
            let target: Vec<f64> = if next == 1.0 {
                q.to_vec()
            } else {
                from.iter().zip(q).map(|(a, b)| a + next * (b - a)).collect()
            };
            let gone = match self.go(&target, true) {
                Err(Failure::Stopped { .. }) => self.go(&target, false),
                done => done,
            };
            match gone {
                Ok(forces) if next == 1.0 => {
                    let (displacement, factorisations) = (self.displacement.clone(), self.factorisations);
                    return Ok(Relaxed { displacement, forces, factorisations });
                }
                Ok(_) => (reached, part) = (next, 2.0 * part),
                Err(Failure::Factor(error)) => return Err(error.into()),
                Err(Failure::Stopped { residual, iterations }) => {
                    part = 0.5 * (next - reached);
                    if part < 0.5_f64.powi(HALVINGS) {
                        return Err(LargeError::NoShape { reached, residual, iterations });
                    }
                }
            }
        }
    }

    /// `VᵀM u`.
    fn project(&self, u: &[f64]) -> Vec<f64> {
        let column = MatRef::from_column_major_slice(u, u.len(), 1);
        transposed_product(self.momenta.as_ref(), column).col_as_slice(0).to_vec()
    }

    /// From the last shape to the one at `q`; the last shape stays where it fails. `mixed` is the first form
    /// of Newton's method, with a stress of its own in the tangent; else the second, with a line search.
    fn go(&mut self, q: &[f64], mixed: bool) -> Result<Vec<f64>, Failure> {
        let (n, r) = (self.displacement.len(), q.len());
        let mut memory = Solve::new(self.symbolic, r + 1, false);
        let (mut u, mut f) = (self.displacement.clone(), vec![0.0; n]);
        let mut z = vec![0.0; self.strain.n_rows()];
        self.strain.strain(&u, &mut z);
        self.strain.transpose(&u, &z, &mut f);
        let mut stress = z.clone();
        let mut forces = vec![0.0; r];
        let (mut first, mut previous) = (None, f64::INFINITY);
        for iteration in 0..self.newton.iterations {
            let Some(factor) = self.factorise(&u, &stress, mixed)? else {
                return Err(stopped(previous, iteration));
            };
            let mut columns = Mat::zeros(n, r + 1);
            columns.as_mut().subcols_mut(0, r).copy_from(self.momenta.as_ref());
            columns.col_as_slice_mut(r).copy_from_slice(&f);
            memory.solve_in_place(&factor, columns.as_mut());
            let answers = columns.as_ref().subcols(0, r);
            // With p = X λ − y, X = K⁻¹W, y = K⁻¹f: (WᵀX) λ = q − Wᵀu + Wᵀy.
            let compliance = transposed_product(self.momenta.as_ref(), answers);
            let at = self.project(&u);
            let pulled = self.project(columns.col_as_slice(r));
            let missing: Vec<f64> = (0..r).map(|k| q[k] - at[k]).collect();
            let rhs = Mat::from_fn(r, 1, |k, _| missing[k] + pulled[k]);
            let solved = compliance.as_ref().llt(Side::Lower).map_err(|_| stopped(f64::NAN, iteration))?;
            let lambda = solved.solve(&rhs);
            let mut p: Vec<f64> = columns.col_as_slice(r).iter().map(|y| -y).collect();
            for k in 0..r {
                add(&mut p, lambda[(k, 0)], columns.col_as_slice(k));
            }
            forces = lambda.col_as_slice(0).to_vec();
            // −p·(f − W λ) = pᵀK p: the energy of the correction.
            let work = dot(&forces, &self.project(&p)) - dot(&p, &f);
            let reference = *first.get_or_insert(work) + 0.5 * dot(&z, &z);
            let size = if work <= 0.0 { 0.0 } else { (work / reference).sqrt() };
            if size.is_nan() || size > DIVERGED {
                return Err(stopped(size, iteration));
            }
            if mixed {
                self.strain.rate(&u, &p, &mut stress);
                add(&mut stress, 1.0, &z);
            }
            // The first correction is whole in any case: it meets the constraint.
            let whole = self.descend(&mut u, &p, &mut f, mixed || iteration == 0);
            self.strain.strain(&u, &mut z);
            if !mixed {
                stress.copy_from_slice(&z);
            }
            if whole && (size <= self.newton.tolerance || size < ROUNDING && size >= 0.5 * previous) {
                self.displacement = u;
                self.coordinates = q.to_vec();
                return Ok(forces);
            }
            previous = size;
        }
        Err(stopped(previous, self.newton.iterations))
    }

    /// Goes along `p`: all the way where the constraint is not met yet, else until the slope of the energy is
    /// half of what it was or turns. Whether it went all the way.
    fn descend(&self, u: &mut Vec<f64>, p: &[f64], f: &mut [f64], all: bool) -> bool {
        let (from, start) = (u.clone(), dot(p, f));
        let mut length = 1.0;
        for _ in 0..12 {
            *u = sum(&from, length, p);
            self.strain.force(u, f);
            let slope = dot(p, f);
            if all || slope <= 0.5 * start.abs() {
                break;
            }
            length *= (start.abs() / (start.abs() + slope)).clamp(0.1, 0.5);
        }
        length == 1.0
    }

    /// The factor of the tangent. Where it is not positive definite, nothing in the mixed form, else the
    /// factor of one without compression.
    fn factorise(&mut self, u: &[f64], stress: &[f64], mixed: bool) -> Result<Option<Factor>, Failure> {
        self.factorisations += 1;
        let tangent = |pulled| self.strain.weighted_tangent(u, 1.0, stress, pulled);
        let done = match self.symbolic.factorize(tangent(false)) {
            Err(FactorError::NotPositiveDefinite { .. }) if mixed => return Ok(None),
            Err(FactorError::NotPositiveDefinite { .. }) => self.symbolic.factorize(tangent(true)),
            done => done,
        };
        done.map(Some).map_err(Failure::Factor)
    }
}

enum Failure {
    Stopped { residual: f64, iterations: usize },
    Factor(FactorError),
}

fn stopped(residual: f64, iterations: usize) -> Failure {
    Failure::Stopped { residual, iterations }
}
