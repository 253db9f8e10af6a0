//! Adjoint marches of a body.

use crate::adjoint::error::AdjointError;
use crate::adjoint::march::{Adjoint, AdjointSizes};
use crate::base::scalar::Scalar;
use crate::body::body::Body;

impl<'b, T: Scalar> Body<'b, T> {
    /// Memory to lend for [`Body::adjoint`] and for [`Cotangents`](crate::Cotangents) of its scene.
    ///
    /// # Errors
    /// [`AdjointError::Structure`], [`AdjointError::Flies`].
    pub fn adjoint_sizes(&self) -> Result<AdjointSizes, AdjointError> {
        if self.flight().is_some() {
            return Err(AdjointError::Flies);
        }
        self.scene().adjoint_sizes()
    }

    /// The adjoint of a march of this body at its present parameters, for [`Body::scene`].
    ///
    /// # Errors
    /// As [`Body::adjoint_sizes`]; [`AdjointError::Bind`].
    pub fn adjoint<'m>(&self, memory: &'m mut [T]) -> Result<Adjoint<'m, T>, AdjointError>
    where
        'b: 'm,
    {
        self.adjoint_sizes()?;
        Adjoint::new(self.scene(), memory)
    }
}
