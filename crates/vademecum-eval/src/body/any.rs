//! A body whose precision is known at run time only: numbers of `f64` at its face, and one branch a call.

use crate::base::error::{BindError, LoadError, LocateError, OutputError, StepError};
use crate::base::options::{SceneOptions, Status, Structure};
use crate::body::body::{Body, BodyOptions, LoadsAfter};
use crate::body::quantity::{At, Quantity};
use crate::body::saved::{Restored, SavedError};
use crate::flight::free::FreeBody;
use crate::flight::rigid::{RigidBody, RigidMotion};
use crate::sections::place::Place;
use crate::sections::rows::Field;
use crate::sections::stress_rows::StressPoint;
use crate::sections::surface::SurfacePoint;
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{BaseMotion, File};

/// Precision of a march.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// `f32`.
    #[default]
    Single,
    /// `f64` (feature `double`).
    #[cfg(feature = "double")]
    Double,
}

/// A [`Body`] in either precision.
#[derive(Debug)]
pub enum AnyBody<'m> {
    /// `f32`.
    Single(Body<'m, f32>),
    /// `f64`.
    #[cfg(feature = "double")]
    Double(Body<'m, f64>),
}

/// The same lines in the precision of a body.
macro_rules! either {
    ($any:expr, $body:ident => $lines:expr) => {
        match $any {
            AnyBody::Single($body) => $lines,
            #[cfg(feature = "double")]
            AnyBody::Double($body) => $lines,
        }
    };
}

/// Methods of [`Body`] that are the same in both precisions.
macro_rules! faced {
    (
        $(
            $(#[$about:meta])*
            fn $name:ident $(<$life:lifetime>)?
                ($($own:ident)+; $($given:ident: $kind:ty),*) $(-> $answer:ty)?;
        )*
    ) => {
        $(faced!(@one $(#[$about])* $name $(<$life>)? ($($own)+) ($($given: $kind),*) ($($answer)?));)*
    };
    (@one $(#[$about:meta])* $name:ident $(<$life:lifetime>)?
        (shared) ($($given:ident: $kind:ty),*) ($($answer:ty)?)) => {
        $(#[$about])*
        #[inline]
        pub fn $name $(<$life>)? (&self, $($given: $kind),*) $(-> $answer)? {
            either!(self, body => body.$name($($given),*))
        }
    };
    (@one $(#[$about:meta])* $name:ident $(<$life:lifetime>)?
        (changed) ($($given:ident: $kind:ty),*) ($($answer:ty)?)) => {
        $(#[$about])*
        #[inline]
        pub fn $name $(<$life>)? (&mut self, $($given: $kind),*) $(-> $answer)? {
            either!(self, body => body.$name($($given),*))
        }
    };
}

impl<'m> AnyBody<'m> {
    /// [`Body::len_for`].
    ///
    /// # Errors
    /// [`BindError`].
    pub fn len_for(file: &File<'_>, options: &BodyOptions, precision: Precision) -> Result<usize, BindError> {
        match precision {
            Precision::Single => Body::<f32>::len_for(file, options),
            #[cfg(feature = "double")]
            Precision::Double => Body::<f64>::len_for(file, options),
        }
    }

    /// [`Body::bind`].
    ///
    /// # Errors
    /// [`BindError`].
    pub fn bind(
        file: &File<'m>,
        options: &BodyOptions,
        precision: Precision,
        memory: &'m mut [f64],
    ) -> Result<Self, BindError> {
        Ok(match precision {
            Precision::Single => Self::Single(Body::bind(file, options, memory)?),
            #[cfg(feature = "double")]
            Precision::Double => Self::Double(Body::bind(file, options, memory)?),
        })
    }

    /// Its precision.
    #[must_use]
    pub const fn precision(&self) -> Precision {
        match self {
            Self::Single(_) => Precision::Single,
            #[cfg(feature = "double")]
            Self::Double(_) => Precision::Double,
        }
    }

    /// [`Body::file`].
    #[must_use]
    pub const fn file(&self) -> &File<'m> {
        either!(self, body => body.file())
    }

    /// The options as they are after every change, as [`Scene::options`](crate::Scene::options).
    #[must_use]
    pub const fn options(&self) -> &SceneOptions {
        either!(self, body => body.scene().options())
    }

    /// Modes of the basis.
    #[must_use]
    pub const fn n_modes(&self) -> usize {
        either!(self, body => body.scene().n_modes())
    }

    /// A point that the file knows the stress of, as [`Scene::stress_point`](crate::Scene::stress_point).
    #[must_use]
    pub fn stress_point(&self, index: usize) -> Option<StressPoint> {
        either!(self, body => body.scene().stress_point(index))
    }

    /// [`Body::position`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn position(&self, at: &impl AsRef<Place>) -> Result<[f64; 3], OutputError> {
        either!(self, body => body.position(at))
    }

    /// [`Body::push`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn push(&mut self, at: &impl AsRef<Place>, force: [f64; 3]) -> Result<(), LoadError> {
        either!(self, body => body.push(at, force))
    }

    /// [`Body::push_staged`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn push_staged(
        &mut self,
        at: &impl AsRef<Place>,
        force: [f64; 3],
        amplitudes: &[f64; 1 + MAX_STAGES],
    ) -> Result<(), LoadError> {
        either!(self, body => body.push_staged(at, force, amplitudes))
    }

    /// [`Body::push_ramp`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn push_ramp(
        &mut self,
        at: &impl AsRef<Place>,
        start: [f64; 3],
        end: [f64; 3],
    ) -> Result<(), LoadError> {
        either!(self, body => body.push_ramp(at, start, end))
    }

    /// [`Body::compliance`].
    ///
    /// # Errors
    /// [`LoadError`].
    #[doc(alias = "Delassus operator")]
    pub fn compliance(&mut self, places: &[impl AsRef<Place>], w: &mut [f64]) -> Result<(), LoadError> {
        either!(self, body => body.compliance(places, w))
    }

    /// [`Body::free_motion`].
    ///
    /// # Errors
    /// [`StepError`].
    pub fn free_motion(
        &mut self,
        places: &[impl AsRef<Place>],
        out: &mut [[f64; 3]],
    ) -> Result<(), StepError> {
        either!(self, body => body.free_motion(places, out))
    }

    /// [`Body::point`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn point(&self, at: &impl AsRef<Place>, field: Field) -> Result<[f64; 3], OutputError> {
        either!(self, body => body.point(at, field))
    }

    /// [`Body::in_space`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn in_space(&self, at: &impl AsRef<Place>, field: Field) -> Result<[f64; 3], OutputError> {
        either!(self, body => body.in_space(at, field))
    }

    /// [`Body::read`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn read<'p>(
        &self,
        quantity: Quantity,
        at: impl Into<At<'p>>,
        field: Field,
        out: &mut [f64],
    ) -> Result<(), OutputError> {
        either!(self, body => body.read(quantity, at, field, out))
    }

    faced! {
        /// [`Body::time_step`].
        #[must_use]
        fn time_step(shared;) -> f64;
        /// [`Body::structure`].
        #[must_use]
        fn structure(shared;) -> Structure;
        /// [`Body::instants`].
        #[must_use]
        fn instants(shared;) -> [f64; 1 + MAX_STAGES];
        /// [`Body::locate`].
        ///
        /// # Errors
        /// [`LocateError`].
        fn locate(shared; point: [f64; 3]) -> Result<SurfacePoint, LocateError>;
        /// [`Body::flight`].
        #[must_use]
        fn flight(shared;) -> Option<&FreeBody>;
        /// [`Body::push_pattern`].
        ///
        /// # Errors
        /// [`LoadError`].
        fn push_pattern(changed; pattern: usize, amplitude: f64) -> Result<(), LoadError>;
        /// [`Body::push_pattern_staged`].
        ///
        /// # Errors
        /// [`LoadError`].
        fn push_pattern_staged(changed; pattern: usize, amplitudes: &[f64; 1 + MAX_STAGES])
            -> Result<(), LoadError>;
        /// [`Body::push_base`].
        ///
        /// # Errors
        /// [`LoadError`].
        fn push_base(changed; motion: &BaseMotion) -> Result<(), LoadError>;
        /// [`Body::push_spin`].
        ///
        /// # Errors
        /// [`LoadError`].
        fn push_spin(changed; before: [f64; 3], after: [f64; 3]) -> Result<(), LoadError>;
        /// [`Body::pull`].
        ///
        /// # Errors
        /// [`LoadError`].
        fn pull(changed; force: [f64; 3]) -> Result<(), LoadError>;
        /// [`Body::clear`].
        fn clear(changed;);
        /// [`Body::keep_loads`].
        ///
        /// # Errors
        /// [`LoadError`].
        fn keep_loads(changed;) -> Result<(), LoadError>;
        /// [`Body::recall_loads`].
        ///
        /// # Errors
        /// [`LoadError`].
        fn recall_loads(changed;) -> Result<(), LoadError>;
        /// [`Body::step`].
        ///
        /// # Errors
        /// [`StepError`].
        fn step(changed;) -> Result<Status, StepError>;
        /// [`Body::march`].
        ///
        /// # Errors
        /// [`StepError`].
        fn march(changed; steps: usize) -> Result<Status, StepError>;
        /// [`Body::rest`].
        fn rest(changed;);
        /// [`Body::set`].
        ///
        /// # Errors
        /// [`StepError`].
        fn set(changed; zeta: &[f64], zeta_dot: &[f64]) -> Result<(), StepError>;
        /// [`Body::coordinates_into`].
        ///
        /// # Errors
        /// [`OutputError`].
        fn coordinates_into(shared; zeta: &mut [f64], zeta_dot: &mut [f64]) -> Result<(), OutputError>;
        /// [`Body::set_parameters`].
        ///
        /// # Errors
        /// [`BindError`].
        fn set_parameters(changed; settings: &[(usize, f64)]) -> Result<LoadsAfter, BindError>;
        /// [`Body::rebind`].
        ///
        /// # Errors
        /// [`BindError`].
        fn rebind(changed; options: &SceneOptions) -> Result<LoadsAfter, BindError>;
        /// [`Body::rigid_body`].
        #[must_use]
        fn rigid_body(shared;) -> Option<RigidBody>;
        /// [`Body::motion`].
        #[must_use]
        fn motion(shared;) -> Option<&RigidMotion>;
        /// [`Body::set_motion`].
        #[must_use]
        fn set_motion(changed; motion: RigidMotion) -> Option<()>;
        /// [`Body::throw`].
        #[must_use]
        fn throw(changed; velocity: [f64; 3], spin: [f64; 3]) -> Option<()>;
        /// [`Body::solve_static_field`].
        ///
        /// # Errors
        /// [`OutputError`].
        fn solve_static_field(changed;) -> Result<(), OutputError>;
        /// [`Body::has_static_field`].
        #[must_use]
        fn has_static_field(shared;) -> bool;
        /// [`Body::count`].
        #[must_use]
        fn count(shared; quantity: Quantity) -> usize;
        /// [`Body::length`].
        #[must_use]
        fn length(shared; quantity: Quantity) -> usize;
        /// [`Body::saved_len`].
        #[must_use]
        fn saved_len(shared;) -> usize;
        /// [`Body::save_into`].
        ///
        /// # Errors
        /// [`SavedError`].
        fn save_into(shared; out: &mut [u8]) -> Result<usize, SavedError>;
        /// [`Body::restore`].
        ///
        /// # Errors
        /// [`SavedError`].
        fn restore(changed; saved: &[u8]) -> Result<Restored, SavedError>;
    }
}
