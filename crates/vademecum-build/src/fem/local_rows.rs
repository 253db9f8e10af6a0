//! The rows of a search for modes, on ranks or in this process.

use faer::{Mat, MatMut, MatRef};

use super::engine::{MassProduct, PencilRows, Search};
use super::factor::{Factor, Solve};
use super::pencil::Pencil;
use super::sparse::AT_ONCE;
use super::spread::EngineError;

/// The rows of a search for modes of a pencil, with the factor of its stiffness.
///
/// # Errors
/// [`EngineError`].
pub(crate) fn pencil_rows<'a>(
    pencil: &'a Pencil,
    factor: &'a Factor,
    search: &Search,
) -> Result<Box<dyn PencilRows + 'a>, EngineError> {
    let local = || LocalRows { pencil, factor, solve: Solve::new(factor.symbolic(), AT_ONCE, false) };
    Ok(factor.spread_rows(pencil, search)?.unwrap_or_else(|| Box::new(local())))
}

/// All rows, in this process.
struct LocalRows<'a> {
    pencil: &'a Pencil,
    factor: &'a Factor,
    solve: Solve,
}

impl MassProduct for LocalRows<'_> {
    fn mul_mass(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError> {
        self.pencil.mass().mul_into(x, y);
        Ok(())
    }

    fn sum(&mut self, _: &mut [f64]) -> Result<(), EngineError> {
        Ok(())
    }
}

impl PencilRows for LocalRows<'_> {
    fn own(&self) -> usize {
        self.pencil.n_dof()
    }

    fn total(&self) -> usize {
        self.pencil.n_dof()
    }

    fn part_into(&self, whole: &[f64], own: &mut [f64]) {
        own.copy_from_slice(whole);
    }

    fn mul_stiffness(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError> {
        self.pencil.stiffness().mul_into(x, y);
        Ok(())
    }

    fn mul_stiffness_closely(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError> {
        self.pencil.stiffness().mul_closely_into(x, y);
        Ok(())
    }

    fn solve(&mut self, x: MatMut<'_, f64>) -> Result<(), EngineError> {
        self.solve.solve_in_place(self.factor, x);
        Ok(())
    }

    fn agree(&mut self, _: &mut [f64]) -> Result<(), EngineError> {
        Ok(())
    }

    fn gather(&mut self, x: Mat<f64>) -> Result<Mat<f64>, EngineError> {
        Ok(x)
    }

    fn scatter(&mut self, whole: Option<&Mat<f64>>, mut own: MatMut<'_, f64>) -> Result<(), EngineError> {
        own.copy_from(whole.expect("the one rank has all rows"));
        Ok(())
    }
}
