//! Adjoint marches of many instances of one scene, stepped together as a batch is.

use crate::adjoint::cotangents::{Cotangents, check_exact};
use crate::adjoint::error::AdjointError;
use crate::adjoint::march::Adjoint;
use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::body::batch::Batch;
use crate::scene::scene::Scene;

/// The marches backwards of many instances of one scene, in lent memory: those of a [`Batch`]. Outputs show
/// forces beside the modes as those of [`Batch::get_under`] do, at once.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # bound!(BODY, Exact: file, sizes, scene, state, loads, work);
/// let mut memory = vec![0.0; BatchAdjoint::len_for(&scene, 20)?];
/// let mut adjoints = BatchAdjoint::new(&scene, 20, &mut memory)?;
/// let sizes = scene.adjoint_sizes()?;
/// let (mut of_one, mut of_outputs) = (vec![0.0; sizes.adjoint], vec![0.0; sizes.cotangents]);
/// let mut adjoint = Adjoint::new(&scene, &mut of_one)?;
/// let mut cotangents = Cotangents::new(&scene, &mut of_outputs)?;
/// for step in 0..10 {
///     // Of each instance, a scalar of its own.
///     for instance in 0..20 {
///         cotangents.clear();
///         cotangents.add_probe(&scene, 0, Field::Displacement, f64::from(instance as u8))?;
///         adjoints.set(&scene, instance, &cotangents)?;
///     }
///     adjoints.back(&scene)?;
///     // The last instance: cotangents are still its own.
///     adjoints.get(&scene, 19, &cotangents, &mut adjoint)?;
///     let [start, end] = adjoint.pattern(&scene, 0)?;
///     assert!(start + end != 0.0);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct BatchAdjoint<'m, T> {
    transposed: Scene<'m, T>,
    batch: Batch<'m, T>,
}

impl<'m, T: Scalar> BatchAdjoint<'m, T> {
    /// Numbers of `T` to lend for so many instances.
    ///
    /// # Errors
    /// [`AdjointError::Structure`].
    pub fn len_for(scene: &Scene<'_, T>, n_instances: usize) -> Result<usize, AdjointError> {
        check_exact(scene)?;
        Ok(scene.shape.map_len().saturating_add(Batch::len_for(scene, n_instances)))
    }

    /// The ends of so many marches, without cotangents. Lends [`BatchAdjoint::len_for`] numbers.
    ///
    /// # Errors
    /// [`AdjointError::Structure`], [`AdjointError::Bind`].
    pub fn new<'s: 'm>(
        scene: &Scene<'s, T>,
        n_instances: usize,
        memory: &'m mut [T],
    ) -> Result<Self, AdjointError> {
        check_exact(scene)?;
        let mut memory = Lender::new(memory);
        let transposed = scene.transposed(memory.take(scene.shape.map_len())?)?;
        let batch = Batch::new(&transposed, n_instances, memory.rest())?;
        Ok(Self { transposed, batch })
    }

    fn check(&self, scene: &Scene<'_, T>) -> Result<(), AdjointError> {
        if self.transposed.shape != scene.shape {
            return Err(AdjointError::Mismatch);
        }
        let same = self.transposed.generation == scene.generation;
        if same && self.transposed.parameters == scene.parameters { Ok(()) } else { Err(AdjointError::Stale) }
    }

    /// Sets the cotangents of the outputs of `instance`, in place of those that it had; they stay for every
    /// step back until the next call. `O(r)`.
    ///
    /// # Errors
    /// [`AdjointError`].
    pub fn set(
        &mut self,
        scene: &Scene<'_, T>,
        instance: usize,
        cotangents: &Cotangents<'_, T>,
    ) -> Result<(), AdjointError> {
        self.check(scene)?;
        cotangents.check_scene(scene)?;
        Ok(self.batch.load_increment(&self.transposed, instance, cotangents.state)?)
    }

    /// Goes back over a step of all instances. Costs a step of the batch. Allocates nothing.
    ///
    /// # Errors
    /// [`AdjointError::Stale`]; [`AdjointError::NotFinite`]: an instance whose gradient is not finite.
    pub fn back(&mut self, scene: &Scene<'_, T>) -> Result<(), AdjointError> {
        self.check(scene)?;
        if self.batch.step(&self.transposed)?.refused > 0 { Err(AdjointError::NotFinite) } else { Ok(()) }
    }

    /// Writes the march of an instance to `adjoint`, which then gives its gradients with respect to the loads
    /// of the step and to the state before it. `cotangents` are those of the instance in this step. `O(r)`.
    ///
    /// # Errors
    /// [`AdjointError`].
    pub fn get(
        &self,
        scene: &Scene<'_, T>,
        instance: usize,
        cotangents: &Cotangents<'_, T>,
        adjoint: &mut Adjoint<'_, T>,
    ) -> Result<(), AdjointError> {
        self.check(scene)?;
        if instance >= self.batch.n_instances() {
            return Err(AdjointError::NoInstance);
        }
        adjoint.take(scene, cotangents, |part, k| self.batch.number(instance, part, k))
    }
}
