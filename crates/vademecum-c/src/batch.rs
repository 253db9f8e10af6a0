//! Many instances of a body, stepped together in lent memory of their own.

use vademecum_eval::{Batch, BatchStatus, Scalar, Scene, Status, StepError};

use crate::body::{Body, Lent, March, Moved, zeroed};
use crate::message::Message;
use crate::types::{VdmBatch, VdmBatchStatus, VdmStatus};

/// What the handle points to.
#[repr(align(16))]
pub struct Instances {
    march: Many,
}

enum Many {
    Single(Batch<'static, f32>),
    #[cfg(feature = "double")]
    Double(Batch<'static, f64>),
}

/// What is lent for so many instances, in bytes.
pub fn bytes(body: &Body, count: usize) -> usize {
    let numbers = match &body.march {
        March::Single(m) => of_scene(&m.scene, count),
        #[cfg(feature = "double")]
        March::Double(m) => of_scene(&m.scene, count),
    };
    numbers.saturating_add(size_of::<Instances>())
}

fn of_scene<T: Scalar>(scene: &Scene<'_, T>, count: usize) -> usize {
    Batch::len_for(scene, count).saturating_mul(size_of::<T>())
}

/// Runs the same lines in the precision of a batch and its body; refuses two precisions.
macro_rules! both {
    ($batch:expr, $body:expr, $b:ident, $m:ident => $lines:expr) => {
        match (&mut $batch.march, &mut $body.march) {
            (Many::Single($b), March::Single($m)) => Ok($lines),
            #[cfg(feature = "double")]
            (Many::Double($b), March::Double($m)) => Ok($lines),
            #[cfg(feature = "double")]
            _ => Err(()),
        }
    };
}

impl Instances {
    /// Places a batch at the start of the memory and its numbers behind it.
    pub fn bind(body: &mut Body, count: usize, memory: Lent) -> Result<*mut VdmBatch, VdmStatus> {
        let needed = bytes(body, count);
        if memory.bytes < needed {
            let said = "the lent memory is shorter than vdm_batch_bytes says";
            return Err(body.message.note(VdmStatus::VDM_MEMORY, &said));
        }
        let own = size_of::<Self>();
        // SAFETY: `own` bytes are within the lent memory; what is behind them is aligned to 16.
        let behind = unsafe { memory.at.add(own) };
        let bound = match &body.march {
            // SAFETY: aligned, within the lent memory, and nobody else's; zeros are numbers.
            March::Single(m) => {
                let numbers = unsafe { zeroed::<f32>(behind, needed - own) };
                Batch::new(&m.scene, count, numbers).map(Many::Single)
            }
            // SAFETY: the same.
            #[cfg(feature = "double")]
            March::Double(m) => {
                let numbers = unsafe { zeroed::<f64>(behind, needed - own) };
                Batch::new(&m.scene, count, numbers).map(Many::Double)
            }
        };
        let march = bound.map_err(|error| body.message.note(VdmStatus::VDM_MEMORY, &error))?;
        let place = memory.at.cast::<Self>();
        // SAFETY: aligned to 16 as the batch is, and long enough.
        unsafe { place.write(Self { march }) };
        Ok(place.as_ptr().cast())
    }

    /// What a handle points to.
    ///
    /// # Safety
    /// `batch` is null or a handle of [`Instances::bind`] whose memory is still lent, used by no other
    /// thread.
    pub unsafe fn of_mut<'a>(batch: *mut VdmBatch) -> Option<&'a mut Self> {
        // SAFETY: as the caller promises.
        unsafe { batch.cast::<Self>().as_mut() }
    }

    pub fn clear(&mut self) -> VdmStatus {
        match &mut self.march {
            Many::Single(batch) => batch.clear(),
            #[cfg(feature = "double")]
            Many::Double(batch) => batch.clear(),
        }
        VdmStatus::VDM_OK
    }

    /// Loads an instance with the loads of the body.
    pub fn load(&mut self, body: &mut Body, instance: usize) -> VdmStatus {
        let done = both!(self, body, b, m => b.load(&m.scene, instance, &m.loads));
        answer(&mut body.message, done, VdmStatus::VDM_LOAD)
    }

    /// Gives an instance the state of the body.
    pub fn set(&mut self, body: &mut Body, instance: usize) -> VdmStatus {
        let done = both!(self, body, b, m => b.set(instance, &m.state));
        answer(&mut body.message, done, VdmStatus::VDM_STEP)
    }

    /// Gives the body the state of an instance.
    pub fn get(&mut self, body: &mut Body, instance: usize) -> VdmStatus {
        let done = both!(self, body, b, m => b.get(instance, &mut m.state));
        answer(&mut body.message, done, VdmStatus::VDM_STEP)
    }

    /// The same, with the loads of the body as those of its last step.
    pub fn get_under(&mut self, body: &mut Body, instance: usize) -> VdmStatus {
        let done = both!(self, body, b, m => b.get_under(instance, &mut m.state, &m.loads));
        answer(&mut body.message, done, VdmStatus::VDM_STEP)
    }

    pub fn carry(&mut self, body: &mut Body) -> VdmStatus {
        let done = both!(self, body, b, m => b.carry(&m.scene));
        answer(&mut body.message, done, VdmStatus::VDM_STEP)
    }

    pub fn step(&mut self, body: &mut Body, steps: u64, found: &mut VdmBatchStatus) -> VdmStatus {
        let done = both!(self, body, b, m => march(b, m, steps));
        let done = done.map(|done| {
            done.map(|BatchStatus { moving, at_rest, refused }| {
                *found = VdmBatchStatus { moving, at_rest, refused };
            })
        });
        match answer(&mut body.message, done, VdmStatus::VDM_STEP) {
            VdmStatus::VDM_OK if found.refused > 0 => {
                body.message.note(VdmStatus::VDM_STEP, &StepError::NotFinite)
            }
            VdmStatus::VDM_OK if found.moving == 0 => VdmStatus::VDM_AT_REST,
            status => status,
        }
    }

    /// What the last step found of an instance.
    pub fn status(&mut self, body: &mut Body, instance: usize) -> VdmStatus {
        let found = match &self.march {
            Many::Single(batch) => batch.status(instance),
            #[cfg(feature = "double")]
            Many::Double(batch) => batch.status(instance),
        };
        match found {
            Ok(Status::AtRest) => VdmStatus::VDM_AT_REST,
            Ok(_) => VdmStatus::VDM_OK,
            Err(error) => body.message.note(VdmStatus::VDM_STEP, &error),
        }
    }
}

/// Steps; stops where nothing moves, and after a step in which an instance was refused.
fn march<T: Scalar>(
    batch: &mut Batch<'_, T>,
    moved: &Moved<T>,
    steps: u64,
) -> Result<BatchStatus, StepError> {
    let mut found = BatchStatus::default();
    for _ in 0..steps {
        found = batch.step(&moved.scene)?;
        if found.refused > 0 || found.moving == 0 {
            break;
        }
    }
    Ok(found)
}

fn answer<E: core::fmt::Display>(
    message: &mut Message,
    done: Result<Result<(), E>, ()>,
    refused: VdmStatus,
) -> VdmStatus {
    match done {
        Ok(Ok(())) => VdmStatus::VDM_OK,
        Ok(Err(error)) => message.note(refused, &error),
        Err(()) => message.note(VdmStatus::VDM_ARGUMENT, &"body and batch are in different precisions"),
    }
}
