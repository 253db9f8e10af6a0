//! Many instances of a body, stepped together in lent memory of their own.

use vademecum_eval::{AnyBody, Batch, BatchStatus, Scalar, Scene, Status, StepError};

use crate::handle::{Body, Handle, Lent, on_handle, zeroed};
use crate::refusal::{Answer, Refusal, needed};
use crate::types::{VdmBatch, VdmBatchStatus, VdmBody, VdmStatus};

/// The body behind a handle.
#[repr(align(16))]
pub struct Instances {
    many: Many,
    /// [`Handle::changes`] of the body that they were made of: the states are along its modes.
    changes: u64,
}

enum Many {
    Single(Batch<'static, f32>),
    #[cfg(feature = "double")]
    Double(Batch<'static, f64>),
}

/// Bytes lent for so many instances.
pub fn bytes(body: &Body, count: usize) -> usize {
    let numbers = match body {
        AnyBody::Single(body) => of_scene(body.scene(), count),
        #[cfg(feature = "double")]
        AnyBody::Double(body) => of_scene(body.scene(), count),
    };
    numbers.saturating_add(size_of::<Instances>())
}

fn of_scene<T: Scalar>(scene: &Scene<'_, T>, count: usize) -> usize {
    Batch::len_for(scene, count).saturating_mul(size_of::<T>())
}

/// Runs the same lines in the precision of a batch and its body; refuses two precisions.
macro_rules! both {
    ($batch:expr, $body:expr, $b:ident, $parts:ident => $lines:expr) => {
        match (&mut $batch.many, $body) {
            (Many::Single($b), AnyBody::Single(body)) => body.with(|$parts| $lines)?,
            #[cfg(feature = "double")]
            (Many::Double($b), AnyBody::Double(body)) => body.with(|$parts| $lines)?,
            #[cfg(feature = "double")]
            _ => {
                let said = "body and batch are in different precisions";
                return Err(Refusal::Words(VdmStatus::VDM_ARGUMENT, said));
            }
        }
    };
}

impl Instances {
    /// Places a batch at the start of the memory and its numbers behind it.
    pub fn bind(handle: &Handle, count: usize, memory: Lent) -> Result<*mut VdmBatch, Refusal> {
        let Handle { body, changes, .. } = handle;
        let (own, needed) = (size_of::<Self>(), bytes(body, count));
        memory.check(needed)?;
        // SAFETY: `own` bytes are within the lent memory; what is behind them is aligned to 16.
        let behind = unsafe { memory.at.add(own) };
        let many = match body {
            // SAFETY: aligned, within the lent memory, and nobody else's; zeros are numbers.
            AnyBody::Single(body) => {
                let numbers = unsafe { zeroed::<f32>(behind, needed - own) };
                Many::Single(Batch::new(body.scene(), count, numbers)?)
            }
            // SAFETY: the same.
            #[cfg(feature = "double")]
            AnyBody::Double(body) => {
                let numbers = unsafe { zeroed::<f64>(behind, needed - own) };
                Many::Double(Batch::new(body.scene(), count, numbers)?)
            }
        };
        let place = memory.at.cast::<Self>();
        // SAFETY: aligned to 16 as the batch is, and long enough.
        unsafe { place.write(Self { many, changes: *changes }) };
        Ok(place.as_ptr().cast())
    }

    /// The batch behind a handle.
    ///
    /// # Safety
    /// `batch` is null or a handle of [`Instances::bind`] whose memory is still lent, used by no other
    /// thread.
    pub unsafe fn of_mut<'a>(batch: *mut VdmBatch) -> Option<&'a mut Self> {
        // SAFETY: as the caller promises.
        unsafe { batch.cast::<Self>().as_mut() }
    }

    pub fn clear(&mut self) -> VdmStatus {
        match &mut self.many {
            Many::Single(batch) => batch.clear(),
            #[cfg(feature = "double")]
            Many::Double(batch) => batch.clear(),
        }
        VdmStatus::VDM_OK
    }

    /// Loads an instance with the loads of the body.
    pub fn load(&mut self, body: &mut Body, instance: usize) -> Answer {
        both!(self, body, b, parts => b.load(parts.scene, instance, parts.loads));
        Ok(VdmStatus::VDM_OK)
    }

    /// Gives an instance the state of the body.
    pub fn set(&mut self, body: &mut Body, instance: usize) -> Answer {
        both!(self, body, b, parts => b.set(instance, parts.state));
        Ok(VdmStatus::VDM_OK)
    }

    /// Gives the body the state of an instance.
    pub fn get(&mut self, body: &mut Body, instance: usize) -> Answer {
        both!(self, body, b, parts => b.get(instance, parts.state));
        Ok(VdmStatus::VDM_OK)
    }

    /// The same, with the loads of the body as those of its last step.
    pub fn get_under(&mut self, body: &mut Body, instance: usize) -> Answer {
        both!(self, body, b, parts => b.get_under(instance, parts.state, parts.loads));
        Ok(VdmStatus::VDM_OK)
    }

    pub fn carry(&mut self, body: &mut Body) -> Answer {
        both!(self, body, b, parts => b.carry(parts.scene));
        Ok(VdmStatus::VDM_OK)
    }

    pub fn step(&mut self, body: &mut Body, steps: u64, out: &mut VdmBatchStatus) -> Answer {
        let BatchStatus { moving, at_rest, refused } =
            both!(self, body, b, parts => march(b, parts.scene, steps));
        *out = VdmBatchStatus { moving, at_rest, refused };
        match (refused, moving) {
            (0, 0) => Ok(VdmStatus::VDM_AT_REST),
            (0, _) => Ok(VdmStatus::VDM_OK),
            _ => Err(StepError::NotFinite.into()),
        }
    }

    /// Status of an instance after the last step.
    pub fn status(&mut self, body: &mut Body, instance: usize) -> Answer {
        Ok(match both!(self, body, b, _parts => b.status(instance)) {
            Status::AtRest => VdmStatus::VDM_AT_REST,
            _ => VdmStatus::VDM_OK,
        })
    }
}

/// Runs a call on a batch and its body, and keeps the words of its refusal there.
///
/// # Safety
/// As for [`Instances::of_mut`] and [`Handle::of`].
pub unsafe fn on_batch(
    batch: *mut VdmBatch,
    body: *mut VdmBody,
    run: impl FnOnce(&mut Instances, &mut Body) -> Answer,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_handle(body, |handle| {
            let batch = needed(Instances::of_mut(batch), "batch")?;
            if batch.changes == handle.changes {
                return run(batch, &mut handle.body);
            }
            let said = "a live parameter of the body was set since the batch was made, and its modes are \
                        others; make another batch";
            Err(Refusal::Words(VdmStatus::VDM_BIND, said))
        })
    }
}

/// Steps; stops where nothing moves, and after a step in which an instance was refused.
fn march<T: Scalar>(
    batch: &mut Batch<'_, T>,
    scene: &Scene<'_, T>,
    steps: u64,
) -> Result<BatchStatus, StepError> {
    let mut found = BatchStatus::default();
    for _ in 0..steps {
        found = batch.step(scene)?;
        if found.refused > 0 || found.moving == 0 {
            break;
        }
    }
    Ok(found)
}
