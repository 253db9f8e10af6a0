//! A body whose live parameters are set while it moves: two sides of lent memory, of which one holds the body
//! and the other takes its successor.
//!
//! Note: a body borrows from its side for as long as it lives, so the side of one that was replaced is free
//! again, which no lifetime says. [`LiveMemory::set`] therefore is unsafe for its caller.
#![allow(unsafe_code)]

use core::marker::PhantomData;
use core::ptr::NonNull;

use crate::base::error::BindError;
use crate::base::lend::Lender;
use crate::base::options::SceneOptions;
use crate::base::scalar::Scalar;
use crate::body::any::{AnyBody, Precision};
use crate::body::body::{Body, BodyOptions, LoadsAfter};
use crate::kernels::dense::at;
use crate::parametric::error::ParametricError;
use crate::parametric::model::Parametric;
use crate::parametric::tuned::Tuned;
use vademecum_format::{File, ParameterRole, SectionKind};

/// Energies of a change of parameters \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Carried {
    /// Kinetic energy that the stepped modes at the new values do not hold.
    pub lost_kinetic: f64,
    /// Elastic energy that they do not hold.
    pub lost_elastic: f64,
    /// Work of the change of stiffness on the displacement as it is.
    pub work: f64,
}

/// Lent memory of a body whose live parameters are set while it moves. `O(r³)` a change.
///
/// One side holds the file at the present values, its modes and the numbers of the body; a change writes the
/// other side from the first, and the two change places.
#[derive(Debug)]
pub struct LiveMemory<'m> {
    model: Parametric<'m>,
    options: BodyOptions,
    modes: usize,
    values: &'m mut [f64],
    asked: &'m mut [f64],
    work: &'m mut [f64],
    /// Side that holds no body.
    spare: NonNull<[f64]>,
    /// Side of the body.
    used: NonNull<[f64]>,
    tuned: Tuned<'m>,
    carried: Carried,
    lent: PhantomData<&'m mut [f64]>,
}

// SAFETY: the sides are numbers that were lent to this value alone, as a slice would be.
unsafe impl Send for LiveMemory<'_> {}
// SAFETY: nothing is written through a shared reference to it.
unsafe impl Sync for LiveMemory<'_> {}

/// Numbers of each piece.
struct Pieces {
    values: usize,
    work: usize,
    /// Of a side: bytes of the file as numbers, its modes, the body.
    bytes: usize,
    memory: usize,
    body: usize,
}

impl Pieces {
    fn of<T: Scalar>(
        model: &Parametric<'_>,
        options: &BodyOptions,
        modes: usize,
    ) -> Result<Self, ParametricError> {
        let sizes = model.sizes(modes)?;
        // Of the file with all of its modes, which no file at values has more of.
        let mut largest = *options;
        let damped = model.parameters().find(|p| p.role == ParameterRole::Beta && p.upper > 0.0);
        largest.scene.beta = damped.map_or(options.scene.beta, |beta| Some(beta.upper));
        Ok(Self {
            values: model.n_parameters(),
            work: sizes.work.max(sizes.write_work).max(4 * modes + 2 * model.n_basis()),
            bytes: sizes.bytes.div_ceil(size_of::<f64>()),
            memory: sizes.memory,
            body: Body::<T>::len_for(model.file(), &largest).map_err(ParametricError::Bind)?,
        })
    }

    fn side(&self) -> usize {
        [self.bytes, self.memory, self.body].into_iter().fold(0, usize::saturating_add)
    }

    fn sum(&self) -> usize {
        let sides = self.side().saturating_mul(2);
        sides.saturating_add(self.work).saturating_add(2 * self.values)
    }
}

/// Number of modes that these options ask of a model.
fn modes_of(model: &Parametric<'_>, options: &BodyOptions) -> usize {
    options.modes.unwrap_or(model.usual_modes())
}

/// Takes out of the options what a parameter decides.
fn without(options: &mut SceneOptions, role: ParameterRole) {
    match role {
        ParameterRole::Alpha => options.alpha = None,
        ParameterRole::Beta => options.beta = None,
        ParameterRole::TimeStep => options.time_step = None,
        _ => {}
    }
}

impl<'m> LiveMemory<'m> {
    /// Numbers of `f64` to lend for a parametric file.
    ///
    /// # Errors
    /// [`BindError`]: a file that is not parametric, options that it cannot have.
    pub fn len_for<T: Scalar>(file: &File<'_>, options: &BodyOptions) -> Result<usize, BindError> {
        let model = Parametric::new(file)?;
        Ok(Pieces::of::<T>(&model, options, modes_of(&model, options))?.sum())
    }

    /// The body at the values as built, at rest and without loads, with [`BodyOptions::modes`] modes.
    ///
    /// # Errors
    /// [`BindError`].
    pub fn bind<T: Scalar>(
        file: &File<'m>,
        options: &BodyOptions,
        memory: &'m mut [f64],
    ) -> Result<(Self, Body<'m, T>), BindError> {
        let model = Parametric::new(file)?;
        let modes = modes_of(&model, options);
        let pieces = Pieces::of::<T>(&model, options, modes)?;
        let (found, needed) = (memory.len(), pieces.sum());
        let memory = memory.get_mut(..needed).ok_or(BindError::LentMemory { found, needed })?;
        let mut memory = Lender::new(memory);
        let (values, asked) = (memory.take(pieces.values)?, memory.take(pieces.values)?);
        let work = memory.take(pieces.work)?;
        let (used, spare) = (memory.take(pieces.side())?, memory.take(pieces.side())?);
        model.nominal_into(values);
        let (used, spare) = (NonNull::from(used), NonNull::from(spare));
        // SAFETY: `used` was lent for `'m`, and nothing else refers to it: its slice is gone.
        let side: &'m mut [f64] = unsafe { &mut *used.as_ptr() };
        let (tuned, body) = bound(&model, (values, modes), options, &pieces, (side, work))?;
        let (options, carried, lent) = (*options, Carried::default(), PhantomData);
        Ok((Self { model, options, modes, values, asked, work, spare, used, tuned, carried, lent }, body))
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> &Parametric<'m> {
        &self.model
    }

    /// Values of the parameters.
    #[must_use]
    pub const fn values(&self) -> &[f64] {
        self.values
    }

    /// Squares of the angular frequencies of the stepped modes at these values \[rad²/s²\], ascending.
    #[must_use]
    pub const fn eigenvalues(&self) -> &[f64] {
        self.tuned.eigenvalues
    }

    /// Energies of the last change.
    #[must_use]
    pub const fn carried(&self) -> Carried {
        self.carried
    }

    /// Sets parameters and replaces the body by the one at these values. Elastic and rigid motion are carried
    /// over, forces of the last step stay; loads become stale, and those that were kept are gone.
    ///
    /// # Safety
    /// `body` is that of [`LiveMemory::bind`] of this memory, and nothing that borrows from it for `'m`, such
    /// as a copy of its file, is used after the call.
    ///
    /// # Errors
    /// [`BindError`]; nothing has changed then.
    pub unsafe fn set<T: Scalar>(
        &mut self,
        settings: &[(usize, f64)],
        body: &mut Body<'m, T>,
    ) -> Result<LoadsAfter, BindError> {
        self.asked.iter_mut().zip(&*self.values).for_each(|(to, from)| *to = *from);
        self.model.set(self.asked, settings)?;
        // SAFETY: as the caller promises.
        unsafe { self.replace(|place| settings.iter().any(|&(index, _)| index == place), body) }
    }

    /// [`LiveMemory::set`] of all parameters at once. Options of the body that damping or step were given by
    /// stay what they are.
    ///
    /// # Safety
    /// As for [`LiveMemory::set`].
    ///
    /// # Errors
    /// [`BindError`]; nothing has changed then.
    pub unsafe fn set_all<T: Scalar>(
        &mut self,
        values: &[f64],
        body: &mut Body<'m, T>,
    ) -> Result<LoadsAfter, BindError> {
        let (found, needed) = (values.len(), self.asked.len());
        if found != needed {
            return Err(ParametricError::Values { found, needed }.into());
        }
        for (index, (asked, &value)) in self.asked.iter_mut().zip(values).enumerate() {
            self.model.check(index, value)?;
            *asked = value;
        }
        // SAFETY: as the caller promises.
        unsafe { self.replace(|_| false, body) }
    }

    /// The body at the values asked for. `is_set` is true of parameters that decide in place of an option.
    unsafe fn replace<T: Scalar>(
        &mut self,
        is_set: impl Fn(usize) -> bool,
        body: &mut Body<'m, T>,
    ) -> Result<LoadsAfter, BindError> {
        let mut options = self.options;
        options.scene = *body.scene().options();
        for (place, parameter) in self.model.parameters().enumerate() {
            if is_set(place) {
                without(&mut options.scene, parameter.role);
            }
        }
        let pieces = Pieces::of::<T>(&self.model, &self.options, self.modes)?;
        // SAFETY: the body that this side had, if any, was replaced, and as the caller promises nothing
        // borrows from it any more.
        let side: &'m mut [f64] = unsafe { &mut *self.spare.as_ptr() };
        let (tuned, mut next) =
            bound(&self.model, (self.asked, self.modes), &options, &pieces, (side, self.work))?;
        self.carried = carry((&self.tuned, body), (&tuned, &mut next), self.work)?;
        let after = next.follow(body);
        *body = next;
        self.tuned = tuned;
        core::mem::swap(&mut self.spare, &mut self.used);
        core::mem::swap(&mut self.values, &mut self.asked);
        Ok(after)
    }
}

/// The same for hosts that open any file in either precision. They are compiled where they are called, as
/// [`AnyBody`] is: a program has one body of each precision.
impl<'m> LiveMemory<'m> {
    /// Numbers of `f64` to lend for a body of a file: [`LiveMemory::len_for`] of a parametric one,
    /// [`AnyBody::len_for`] of any other.
    ///
    /// # Errors
    /// [`BindError`].
    #[inline]
    pub fn any_len(file: &File<'_>, options: &BodyOptions, precision: Precision) -> Result<usize, BindError> {
        if file.section(SectionKind::LiveParameters).is_none() {
            return AnyBody::len_for(file, options, precision);
        }
        match precision {
            Precision::Single => Self::len_for::<f32>(file, options),
            #[cfg(feature = "double")]
            Precision::Double => Self::len_for::<f64>(file, options),
        }
    }

    /// The body, and the memory of a parametric file.
    ///
    /// # Errors
    /// [`BindError`].
    #[inline]
    pub fn bind_any(
        file: &File<'m>,
        options: &BodyOptions,
        precision: Precision,
        memory: &'m mut [f64],
    ) -> Result<(Option<Self>, AnyBody<'m>), BindError> {
        if file.section(SectionKind::LiveParameters).is_none() {
            return Ok((None, AnyBody::bind(file, options, precision, memory)?));
        }
        Ok(match precision {
            Precision::Single => {
                let (live, body) = Self::bind(file, options, memory)?;
                (Some(live), AnyBody::Single(body))
            }
            #[cfg(feature = "double")]
            Precision::Double => {
                let (live, body) = Self::bind(file, options, memory)?;
                (Some(live), AnyBody::Double(body))
            }
        })
    }

    /// [`LiveMemory::set`].
    ///
    /// # Safety
    /// As for [`LiveMemory::set`].
    ///
    /// # Errors
    /// [`BindError`]; nothing has changed then.
    #[inline]
    pub unsafe fn set_any(
        &mut self,
        settings: &[(usize, f64)],
        body: &mut AnyBody<'m>,
    ) -> Result<LoadsAfter, BindError> {
        // SAFETY (both): as the caller promises.
        match body {
            AnyBody::Single(body) => unsafe { self.set(settings, body) },
            #[cfg(feature = "double")]
            AnyBody::Double(body) => unsafe { self.set(settings, body) },
        }
    }
}

/// The body at these values in a side.
#[inline(never)]
fn bound<'m, T: Scalar>(
    model: &Parametric<'m>,
    (values, modes): (&[f64], usize),
    options: &BodyOptions,
    pieces: &Pieces,
    (side, work): (&'m mut [f64], &mut [f64]),
) -> Result<(Tuned<'m>, Body<'m, T>), BindError> {
    let mut side = Lender::new(side);
    let (bytes, memory, numbers) =
        (side.take(pieces.bytes)?, side.take(pieces.memory)?, side.take(pieces.body)?);
    let tuned = model.solve(values, modes, memory, work)?;
    let file = tuned.write(model, bytemuck::cast_slice_mut(bytes), work)?;
    Ok((tuned, Body::bind(&file, options, numbers)?))
}

/// Carries the elastic motion over.
fn carry<T: Scalar>(
    (from, old): (&Tuned<'_>, &Body<'_, T>),
    (to, new): (&Tuned<'_>, &mut Body<'_, T>),
    work: &mut [f64],
) -> Result<Carried, BindError> {
    let mut lender = Lender::new(work);
    let (n, m) = (from.eigenvalues.len(), to.eigenvalues.len());
    let (zeta, rate) = (lender.take(n)?, lender.take(n)?);
    let (next, next_rate) = (lender.take(m)?, lender.take(m)?);
    old.coordinates_into(zeta, rate).map_err(|_| BindError::Mismatch)?;
    if zeta.iter().chain(&*rate).all(|x| *x == 0.0) {
        // A body that has not started yet stays so.
        return Ok(Carried::default());
    }
    let carried = project((from, zeta, rate), (to, next, next_rate), lender.rest())?;
    new.set(next, next_rate).map_err(|_| BindError::NotFinite)?;
    Ok(carried)
}

/// Projects coordinates and rates along the modes at other values, by the mass at these.
pub(crate) fn project(
    (from, zeta, rate): (&Tuned<'_>, &[f64], &[f64]),
    (to, next, next_rate): (&Tuned<'_>, &mut [f64], &mut [f64]),
    work: &mut [f64],
) -> Result<Carried, ParametricError> {
    let [kinetic, elastic] = to.energies_of(from, (zeta, rate), work)?;
    to.carry(from, rate, next_rate, work)?;
    to.carry(from, zeta, next, work)?;
    let squares = |x: &[f64]| 0.5 * x.iter().map(|x| x * x).sum::<f64>();
    let energy = |tuned: &Tuned<'_>, x: &[f64]| {
        let terms = x.iter().enumerate().map(|(k, x)| at(tuned.eigenvalues, k) * x * x);
        0.5 * terms.sum::<f64>()
    };
    Ok(Carried {
        lost_kinetic: kinetic - squares(next_rate),
        lost_elastic: elastic - energy(to, next),
        work: elastic - energy(from, zeta),
    })
}
