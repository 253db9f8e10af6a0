//! The shape of least energy among those with prescribed coordinates: `u*(q) = argmin V(u)`, `VᵀM u = q`.
//!
//! Balance under forces `λ` along the momenta `W = M V`, found by Newton's method in a border:
//!
//! ```text
//! [ K(u)  W ] [ p ]   [ −f(u)      ]
//! [ Wᵀ    0 ] [ λ ] = [ q − Wᵀ u   ]
//! ```
//!
//! in the first form of Newton's method that `newton.rs` explains. The first correction meets the constraint,
//! and the others stay on it. A factor, with its solve for `W`, serves as long as the corrections shrink
//! fast ([`Newton::keep`]).

use std::sync::Arc;

use faer::linalg::solvers::{Llt, Solve as _};
use faer::{Mat, MatRef, Side};

use super::error::{LargeError, check_length};
use super::newton::{DIVERGED, Newton, ROUNDING};
use super::vectors::{add, dot};
use crate::fem::{Factor, FactorError, GreenStrain, Solve, Symbolic};
use crate::linalg::transposed_product;

/// Shapes of least energy at prescribed coordinates of a basis, each begun at the one before. A copy shares
/// what belongs to the basis.
#[derive(Clone)]
pub(crate) struct Relaxation<'a> {
    strain: &'a GreenStrain<'a>,
    symbolic: &'a Symbolic,
    newton: Newton,
    /// `M V`, shape (n, r).
    momenta: Arc<Mat<f64>>,
    displacement: Vec<f64>,
    factorisations: usize,
}

/// A shape of least energy.
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("static condensation", "implicit condensation"))]
pub(crate) struct RelaxedShape {
    /// Displacement over the free dofs \[m\].
    pub(crate) displacement: Vec<f64>,
    /// Multipliers `λ` of the constraints: the force is `G(u)ᵀ z(u) = M V λ`, so that `λ` is the gradient of
    /// the least energy in `q`.
    pub(crate) forces: Vec<f64>,
    /// Factorisations it took.
    pub(crate) factorisations: usize,
}

/// Initial guess of a shape, from which Newton's method begins.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InitialGuess {
    /// Displacement over the free dofs \[m\].
    pub(crate) displacement: Vec<f64>,
    /// The stress of the first tangent, of the length of the strain. That of a prediction of second order is
    /// better than the stress at its displacement, which has terms of third and fourth order.
    pub(crate) stress: Vec<f64>,
}

impl<'a> Relaxation<'a> {
    /// Relaxations over a basis, shape (n, r); they begin at rest.
    ///
    /// # Errors
    /// [`LargeError`]: a body without supports, a basis of another height.
    pub(crate) fn new(
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
        let (momenta, displacement) = (Arc::new(momenta), vec![0.0; n]);
        Ok(Relaxation { strain, symbolic, newton, momenta, displacement, factorisations: 0 })
    }

    /// The shape at coordinates `q`: searched for from a guess if there is one, and where that leads nowhere
    /// from the last shape. The next search starts at what was found. What it does not find is mostly a body
    /// that collapses.
    ///
    /// # Errors
    /// [`LargeError::NoShape`], a length, memory.
    pub(crate) fn relax(
        &mut self,
        guess: Option<InitialGuess>,
        q: &[f64],
    ) -> Result<RelaxedShape, LargeError> {
        check_length("the prescribed coordinates", q.len(), self.momenta.ncols())?;
        if let Some(guess) = &guess {
            check_length("the guessed displacement", guess.displacement.len(), self.displacement.len())?;
            check_length("the guessed stress", guess.stress.len(), self.strain.n_rows())?;
        }
        self.factorisations = 0;
        let guessed = guess.is_some();
        let gone = match self.go(guess, q) {
            Err(Failure::Stopped { .. }) if guessed => self.go(None, q),
            done => done,
        };
        match gone {
            Ok(forces) => Ok(self.relaxed(forces)),
            Err(Failure::Factor(error)) => Err(error.into()),
            Err(Failure::Stopped { residual, iterations }) => {
                Err(LargeError::NoShape { residual, iterations })
            }
        }
    }

    fn relaxed(&self, forces: Vec<f64>) -> RelaxedShape {
        RelaxedShape { displacement: self.displacement.clone(), forces, factorisations: self.factorisations }
    }

    /// `VᵀM u`.
    fn project(&self, u: &[f64]) -> Vec<f64> {
        let column = MatRef::from_column_major_slice(u, u.len(), 1);
        transposed_product(self.momenta.as_ref().as_ref(), column).col_as_slice(0).to_vec()
    }

    /// From the last shape, or from where `guess` says, to the one at `q`; the last shape stays where it
    /// fails.
    fn go(&mut self, guess: Option<InitialGuess>, q: &[f64]) -> Result<Vec<f64>, Failure> {
        let rows = self.strain.n_rows();
        let (mut u, stress) = match guess {
            Some(InitialGuess { displacement, stress }) => (displacement, Some(stress)),
            None => (self.displacement.clone(), None),
        };
        let (mut z, mut f) = (vec![0.0; rows], vec![0.0; u.len()]);
        self.strain.strain(&u, &mut z);
        self.strain.transpose(&u, &z, &mut f);
        let mut stress = stress.unwrap_or_else(|| z.clone());
        let mut border = None;
        let (mut first, mut previous) = (None, f64::INFINITY);
        for iteration in 0..self.newton.iterations {
            let missing: Vec<f64> = q.iter().zip(self.project(&u)).map(|(q, at)| q - at).collect();
            let (p, forces, size) = loop {
                let fresh = border.is_none();
                let mut own: Border = match border.take() {
                    Some(border) => border,
                    None => {
                        let made = self.border(&u, &stress).map_err(Failure::Factor)?;
                        made.ok_or_else(|| stopped(previous, iteration))?
                    }
                };
                let (p, forces) = own.correction(self, &f, &missing);
                // −p·(f − W λ) = pᵀK p: the energy of the correction.
                let work = dot(&forces, &self.project(&p)) - dot(&p, &f);
                let reference = *first.get_or_insert(work) + 0.5 * dot(&z, &z);
                let size = if work <= 0.0 { 0.0 } else { (work / reference).sqrt() };
                if fresh || size <= self.newton.keep * previous || size <= self.newton.tolerance {
                    border = Some(own);
                    break (p, forces, size);
                }
            };
            if size.is_nan() || size > DIVERGED {
                return Err(stopped(size, iteration));
            }
            self.strain.rate(&u, &p, &mut stress);
            add(&mut stress, 1.0, &z);
            add(&mut u, 1.0, &p);
            self.strain.strain(&u, &mut z);
            self.strain.transpose(&u, &z, &mut f);
            if size <= self.newton.tolerance || size < ROUNDING && size >= 0.5 * previous {
                self.displacement = u;
                return Ok(forces);
            }
            previous = size;
            if self.newton.keep == 0.0 {
                border = None;
            }
        }
        Err(stopped(previous, self.newton.iterations))
    }

    /// The factor of the tangent in its border; nothing where it is not positive definite.
    fn border(&mut self, u: &[f64], stress: &[f64]) -> Result<Option<Border>, FactorError> {
        self.factorisations += 1;
        let factor = match self.symbolic.factorize(self.strain.weighted_tangent(u, 1.0, stress, false)) {
            Err(FactorError::NotPositiveDefinite { .. }) => return Ok(None),
            done => done?,
        };
        let mut memory = Solve::new(self.symbolic, self.momenta.ncols(), false);
        let mut answers = Mat::clone(&self.momenta);
        memory.solve_in_place(&factor, answers.as_mut());
        let compliance = transposed_product(self.momenta.as_ref().as_ref(), answers.as_ref());
        let Ok(compliance) = compliance.as_ref().llt(Side::Lower) else { return Ok(None) };
        Ok(Some(Border { factor, memory, answers, compliance }))
    }
}

/// The factor of a tangent in the border of the momenta.
struct Border {
    factor: Factor,
    memory: Solve,
    /// `X = K⁻¹W`, shape (n, r).
    answers: Mat<f64>,
    /// The factor of `WᵀX`.
    compliance: Llt<f64>,
}

impl Border {
    /// The correction at a place with the force `f` that misses the coordinates by so much, and the
    /// multipliers: with `p = X λ − y` and `y = K⁻¹f`, `(WᵀX) λ = missing + Wᵀy`.
    fn correction(&mut self, of: &Relaxation<'_>, f: &[f64], missing: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut y = Mat::from_fn(f.len(), 1, |i, _| f[i]);
        self.memory.solve_in_place(&self.factor, y.as_mut());
        let y = y.col_as_slice(0);
        let pulled = of.project(y);
        let right = Mat::from_fn(missing.len(), 1, |k, _| missing[k] + pulled[k]);
        let forces = self.compliance.solve(&right).col_as_slice(0).to_vec();
        let mut p: Vec<f64> = y.iter().map(|y| -y).collect();
        forces.iter().enumerate().for_each(|(k, &force)| add(&mut p, force, self.answers.col_as_slice(k)));
        (p, forces)
    }
}

enum Failure {
    Stopped { residual: f64, iterations: usize },
    Factor(FactorError),
}

fn stopped(residual: f64, iterations: usize) -> Failure {
    Failure::Stopped { residual, iterations }
}
