//! Values of the variables of an instance by their references, and derivatives. Arrays are read row by row.

use crate::instance::Instance;
use crate::memory::Block;
use crate::outputs::Seen;
use crate::refusal::{Refusal, Trouble};
use crate::variables::Variable;

impl Instance {
    /// Values of variables.
    ///
    /// # Errors
    /// [`Refusal::NoReference`], [`Refusal::Output`].
    pub fn get(&self, references: &[u32], values: &mut [f64]) -> Result<(), Trouble> {
        let (mut elements, found) = (self.body().elements(references), values.len());
        let mut seen = Seen::default();
        for value in values {
            let Some(variable) = elements.next() else { return Ok(self.check(references, found)?) };
            *value = match variable {
                Variable::Time => self.time(),
                variable => self.body().value(variable, &mut seen).map_err(|refusal| (variable, refusal))?,
            };
        }
        if elements.is_whole() { Ok(()) } else { Ok(self.check(references, found)?) }
    }

    /// Sets variables, all of them or none.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Trouble> {
        self.check(references, values.len())?;
        let elements = self.body().elements(references);
        let settings = || elements.clone().zip(values.iter().copied());
        let starting = self.is_starting();
        self.body_mut().set(settings, starting)?;
        Ok(())
    }

    /// Values of structural parameters: of the surface nodes in use.
    ///
    /// # Errors
    /// [`Refusal::NoReference`], [`Refusal::Values`].
    pub fn get_counts(&self, references: &[u32], values: &mut [u64]) -> Result<(), Trouble> {
        self.check_counts(references, values.len())?;
        values.iter_mut().for_each(|value| *value = u64::from(self.body().surface()));
        Ok(())
    }

    /// Sets structural parameters.
    ///
    /// # Errors
    /// [`Refusal::SurfaceNodes`], [`Refusal::NoReference`], [`Refusal::Values`].
    pub fn set_counts(&mut self, references: &[u32], values: &[u64]) -> Result<(), Trouble> {
        self.check_counts(references, values.len())?;
        // There is one, so that the last value is that of all of its references.
        let Some(&nodes) = values.last() else { return Ok(()) };
        self.body_mut().set_surface(nodes).map_err(|refusal| (Variable::SurfaceNodes, refusal).into())
    }

    fn check_counts(&self, references: &[u32], found: usize) -> Result<(), Refusal> {
        let is_count =
            |reference| self.body().references().variable(reference) == Some(Variable::SurfaceNodes);
        if let Some(&reference) = references.iter().find(|&&reference| !is_count(reference)) {
            return Err(Refusal::NoReference { reference });
        }
        let expected = references.len();
        if found == expected { Ok(()) } else { Err(Refusal::Values { found, expected }) }
    }

    /// Derivatives of unknowns along seeds of knowns (`Body::directional`).
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn directional(
        &self,
        unknowns: &[u32],
        knowns: &[u32],
        seeds: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), Trouble> {
        self.check(unknowns, sensitivity.len())?;
        self.check(knowns, seeds.len())?;
        let mut memory = self.tangent_memory()?;
        let seeds = self.body().elements(knowns).zip(seeds.iter().copied());
        let unknowns = self.body().elements(unknowns);
        self.body().directional(memory.numbers_mut(), seeds, unknowns, sensitivity)
    }

    /// Derivatives of the sum of seeded unknowns with respect to knowns (`Body::adjoint`).
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn adjoint(
        &self,
        unknowns: &[u32],
        knowns: &[u32],
        seeds: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), Trouble> {
        self.check(unknowns, seeds.len())?;
        self.check(knowns, sensitivity.len())?;
        let mut memory = self.tangent_memory()?;
        let unknowns = self.body().elements(unknowns);
        let seeds = || unknowns.clone().zip(seeds.iter().copied());
        self.body().adjoint(memory.numbers_mut(), seeds, self.body().elements(knowns), sensitivity)
    }

    fn tangent_memory(&self) -> Result<Block, Refusal> {
        Block::zeroed(self.body().tangent_len().saturating_mul(8)).ok_or(Refusal::Memory)
    }

    /// Refuses a reference that no variable has, and another number of values than the variables have.
    fn check(&self, references: &[u32], found: usize) -> Result<(), Refusal> {
        let (known, nodes, mut expected) = (self.body().references(), self.body().surface(), 0_usize);
        for &reference in references {
            let variable = known.variable(reference).filter(Variable::is_number);
            let variable = variable.ok_or(Refusal::NoReference { reference })?;
            expected = expected.saturating_add(variable.length(nodes) as usize);
        }
        if found == expected { Ok(()) } else { Err(Refusal::Values { found, expected }) }
    }
}
