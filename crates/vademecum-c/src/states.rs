//! The state of a body: copied out and back, set, carried from one body to another; and how it yields at
//! places.

use vademecum_eval::{Contact, LoadError, Place, Scalar, StepError};

use crate::body::{Body, MOST_PLACES, Moved, moved};
use crate::types::{VdmPlace, VdmStatus};

impl Body {
    /// Copies the state out; what is lent beyond it becomes zero.
    pub fn save(&mut self, out: &mut [f64]) -> VdmStatus {
        let done = moved!(self.march, m => m.save(out));
        self.answer(done, VdmStatus::VDM_STEP)
    }

    pub fn restore(&mut self, saved: &[f64]) -> VdmStatus {
        let done = moved!(self.march, m => m.restore(saved));
        self.answer(done, VdmStatus::VDM_STEP)
    }

    pub fn set(&mut self, zeta: &[f64], zeta_dot: &[f64]) -> VdmStatus {
        let done = moved!(self.march, m => m.scene.set(&mut m.state, zeta, zeta_dot, &m.loads));
        self.answer(done, VdmStatus::VDM_STEP)
    }

    /// Reduced coordinates and their rates.
    pub fn coordinates(&mut self, zeta: &mut [f64], zeta_dot: &mut [f64]) -> VdmStatus {
        let done = moved!(self.march, m => {
            let (x, v, step) = (m.state.zeta(), m.state.scaled_velocity(), m.state.time_step());
            if zeta.len() == x.len() && zeta_dot.len() == v.len() {
                zeta.iter_mut().zip(x).for_each(|(out, x)| *out = x.to_f64());
                zeta_dot.iter_mut().zip(v).for_each(|(out, v)| *out = v.to_f64() / step);
                Ok(())
            } else {
                Err(StepError::Mismatch)
            }
        });
        self.answer(done, VdmStatus::VDM_STEP)
    }

    /// Takes over the state of another body of the same file, precision and structure.
    pub fn carry(&mut self, other: &Self) -> VdmStatus {
        use crate::body::March as M;
        let done = match (&mut self.march, &other.march) {
            (M::Single(to), M::Single(from)) => to.carry(from),
            #[cfg(feature = "double")]
            (M::Double(to), M::Double(from)) => to.carry(from),
            #[cfg(feature = "double")]
            _ => Err(StepError::Mismatch),
        };
        self.answer(done, VdmStatus::VDM_STEP)
    }

    pub fn compliance(&mut self, places: &[VdmPlace], w: &mut [f64]) -> VdmStatus {
        let mut contacts = CONTACTS;
        let Some(contacts) = contacts_of(places, &mut contacts) else { return self.too_many() };
        let done = moved!(self.march, m => m.scene.compliance_at(&m.state, contacts, w, m.work));
        self.answer(done.map_err(of_places), VdmStatus::VDM_LOAD)
    }

    pub fn free_motion(&mut self, places: &[VdmPlace], out: &mut [f64]) -> VdmStatus {
        let mut contacts = CONTACTS;
        let Some(contacts) = contacts_of(places, &mut contacts) else { return self.too_many() };
        let out = out.as_chunks_mut().0;
        let done = moved!(self.march, m => m.scene.free_motion(&m.state, &m.loads, contacts, out, m.work));
        self.answer(done, VdmStatus::VDM_STEP)
    }

    fn too_many(&mut self) -> VdmStatus {
        self.message.note(VdmStatus::VDM_ARGUMENT, &"more than 64 places")
    }
}

/// Room for the most places there may be.
const CONTACTS: [Contact; MOST_PLACES] =
    [Contact::new(Place::triangle([0; 3], [0.0; 3]), [0.0; 3]); MOST_PLACES];

/// The places as contacts without force; `None` if they are too many.
fn contacts_of<'c>(places: &[VdmPlace], contacts: &'c mut [Contact]) -> Option<&'c [Contact]> {
    let contacts = contacts.get_mut(..places.len())?;
    contacts.iter_mut().zip(places).for_each(|(contact, place)| *contact = place.contact([0.0; 3]));
    Some(contacts)
}

/// What was wrong with places.
enum Places {
    Mismatch,
    Other(LoadError),
}

fn of_places(error: LoadError) -> Places {
    if error == LoadError::Mismatch { Places::Mismatch } else { Places::Other(error) }
}

impl core::fmt::Display for Places {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Mismatch => out.write_str(
                "more places than VdmOptions.places, or a body with the block structure, which has no \
                 operator",
            ),
            Self::Other(error) => error.fmt(out),
        }
    }
}

impl<T: Scalar> Moved<T> {
    fn save(&mut self, out: &mut [f64]) -> Result<(), StepError> {
        let numbers = self.scene.state_numbers();
        let (out, rest) = out.split_at_mut_checked(numbers).ok_or(StepError::Mismatch)?;
        let saved = self.work.get_mut(..numbers).ok_or(StepError::Mismatch)?;
        self.state.save_into(saved)?;
        out.iter_mut().zip(saved).for_each(|(out, x)| *out = x.to_f64());
        rest.fill(0.0);
        Ok(())
    }

    fn restore(&mut self, saved: &[f64]) -> Result<(), StepError> {
        let numbers = self.scene.state_numbers();
        let saved = saved.get(..numbers).ok_or(StepError::Mismatch)?;
        let own = self.work.get_mut(..numbers).ok_or(StepError::Mismatch)?;
        own.iter_mut().zip(saved).for_each(|(own, &x)| *own = T::from_f64(x));
        self.state.restore(own)
    }

    /// Velocity and acceleration stay what they are, so their numbers change with the step in time.
    fn carry(&mut self, other: &Self) -> Result<(), StepError> {
        let numbers = self.scene.state_numbers();
        let same = numbers == other.scene.state_numbers()
            && self.scene.structure() == other.scene.structure()
            && self.scene.metadata().mesh_hash == other.scene.metadata().mesh_hash;
        let own = self.work.get_mut(..numbers).filter(|_| same).ok_or(StepError::Mismatch)?;
        other.state.save_into(own)?;
        let ratio = self.state.time_step() / other.state.time_step();
        let rates = own.chunks_exact_mut(self.scene.n_modes().max(1)).skip(1);
        for (part, factor) in rates.zip([ratio, ratio * ratio]) {
            part.iter_mut().for_each(|x| *x = T::from_f64(x.to_f64() * factor));
        }
        self.state.restore(own)
    }
}
