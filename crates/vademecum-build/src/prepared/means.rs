//! Means of a computation: memory, engine, precision.

use std::sync::Arc;

use crate::fem::{Engine, Pencil, Symbolic};
use crate::limits::{Memory, memory_in_words};
use crate::progress::Listener;

/// The precision of the factor of the stiffness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FactorPrecision {
    /// Double, or single where exact steps need no other factor and one in double precision would not fit.
    #[default]
    Fitting,
    /// Double.
    Double,
    /// Single: half the memory. Conjugate gradients with it solve in double precision.
    Single,
}

/// Memory, engine and precision of a computation.
pub(crate) struct Means<'a> {
    /// Memory that may be used.
    pub(crate) memory: Memory,
    /// The engine for factors of the stiffness; absent: this process.
    pub(crate) engine: Option<&'a Arc<dyn Engine>>,
    /// The precision of these, in this process.
    pub(crate) precision: FactorPrecision,
}

/// Memory of a build in addition to its matrices, as a multiple of the factor: what a factorisation holds at
/// its top, and the vectors of a search for modes. It is what blocks of 282 576 and 591 408 dofs took; bodies
/// for which memory is short are not smaller.
const BESIDE_FACTOR: f64 = 1.4;

impl Default for Means<'_> {
    fn default() -> Self {
        let memory = Memory::asked_or_available(None);
        Self { memory, engine: None, precision: FactorPrecision::default() }
    }
}

impl Means<'_> {
    /// The structure of a factor in the precision that was asked for, or in the one that fits where that is
    /// left open.
    pub(super) fn precise(
        &self,
        symbolic: Symbolic,
        pencil: &Pencil,
        open: bool,
        listener: &dyn Listener,
    ) -> Symbolic {
        let here = open && !symbolic.is_spread();
        let needed = BESIDE_FACTOR * symbolic.factor_bytes() as f64 + pencil.bytes() as f64;
        match self.precision {
            FactorPrecision::Single => symbolic.in_single_precision(),
            FactorPrecision::Fitting if here && needed > self.memory.limit() as f64 => {
                listener.note(&format!(
                    "a factor in double precision would need about {} of memory in all, and {} can be had: it is \
                     made in single precision, and every solve takes some iterations",
                    memory_in_words(needed as u64),
                    memory_in_words(self.memory.limit()),
                ));
                symbolic.in_single_precision()
            }
            _ => symbolic,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Material, Model};
    use crate::mesh::{Order, block};
    use crate::progress::Silent;

    #[test]
    fn a_factor_is_in_single_precision_where_one_in_double_precision_would_not_fit() {
        let mesh = block([1.0, 0.2, 0.2], [4, 2, 2], Order::Quadratic);
        let held: Vec<bool> = mesh.nodes.iter().flat_map(|node| [node[0] == 0.0; 3]).collect();
        let rubber = Material::isotropic(1e7, 0.3, 1000.0);
        let model = Model::assemble(mesh, &[rubber], &held).expect("a model");
        let pencil = model.pencil();
        let symbolic = Symbolic::analyze(pencil).expect("a structure");
        let little = Memory::bytes((symbolic.factor_bytes() + pencil.bytes()) as u64);
        let much = Memory::bytes(2 * little.limit());
        let is_single = |memory: Memory, precision: FactorPrecision, open: bool| {
            let means = Means { memory, engine: None, precision };
            !means.precise(symbolic.clone(), pencil, open, &Silent).has_entries()
        };
        use FactorPrecision::{Double, Fitting, Single};
        assert!(is_single(little, Fitting, true) && !is_single(much, Fitting, true));
        // Where something else needs a factor in double precision, nothing is gained.
        assert!(!is_single(little, Fitting, false));
        assert!(is_single(much, Single, true) && !is_single(little, Double, true));
    }
}
