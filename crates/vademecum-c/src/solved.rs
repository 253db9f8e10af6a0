//! What is solved for beside a step, over memory of its own: the static answer of the whole body, and the
//! modes of a dense step.

use vademecum_eval::{BindError, Modal, OutputError, Scalar, Scene, StaticField, Status};

use crate::body::{Body, Lent, Moved, moved, zeroed};
use crate::types::VdmStatus;

/// Bytes of memory that the answer of the whole body wants; 0 where the file does not have it.
pub fn static_bytes<T: Scalar>(scene: &Scene<'_, T>) -> usize {
    let [answer, rest] = scene.static_field_sizes();
    let rest = rest.saturating_mul(size_of::<T>());
    answer.saturating_mul(size_of::<f64>()).saturating_add(rest)
}

/// Bytes of memory that the modes of a dense step want, and numbers of work; zeros for other structures.
pub fn modal_needs<T: Scalar>(scene: &Scene<'_, T>) -> (usize, usize) {
    if scene.structure() != vademecum_eval::Structure::Block {
        return (0, 0);
    }
    let sizes = Modal::sizes(scene);
    (sizes.memory.saturating_mul(size_of::<T>()), sizes.work)
}

impl Body {
    pub fn static_lend(&mut self, memory: Lent) -> VdmStatus {
        let done = moved!(self.march, m => m.static_lend(memory));
        self.answer(done, VdmStatus::VDM_MEMORY)
    }

    pub fn static_solve(&mut self) -> VdmStatus {
        let done = moved!(self.march, m => m.static_solve());
        self.answer(done, VdmStatus::VDM_OUTPUT)
    }

    pub fn modal_needs(&mut self) -> (usize, usize) {
        moved!(self.march, m => modal_needs(&m.scene))
    }

    pub fn modal_bind(&mut self, tolerance: f64, memory: Lent, work: &mut [f64]) -> VdmStatus {
        let done = moved!(self.march, m => m.modal_bind(tolerance, memory, work));
        self.answer(done, VdmStatus::VDM_BIND)
    }

    pub fn modal_march(&mut self, steps: usize) -> VdmStatus {
        let found = moved!(self.march, m => m.modal_march(steps));
        match found {
            Some(Ok(Status::AtRest)) => VdmStatus::VDM_AT_REST,
            Some(Ok(_)) => VdmStatus::VDM_OK,
            Some(Err(error)) => self.message.note(VdmStatus::VDM_STEP, &error),
            None => self.message.note(VdmStatus::VDM_ARGUMENT, &"no modes are bound: call vdm_modal_bind"),
        }
    }
}

impl<T: Scalar> Moved<T> {
    fn static_lend(&mut self, memory: Lent) -> Result<(), BindError> {
        let (found, needed) = (memory.bytes, static_bytes(&self.scene));
        if found < needed {
            return Err(BindError::LentMemory { found, needed });
        }
        let [answer, rest] = self.scene.static_field_sizes();
        let of_answer = answer.saturating_mul(size_of::<f64>());
        // SAFETY: `of_answer` bytes are within the lent memory, and what is behind them is aligned to 8.
        let behind = unsafe { memory.at.add(of_answer) };
        // SAFETY: aligned, within the lent memory, two parts of it that do not overlap; zeros are numbers.
        let (answer, rest) = unsafe {
            (zeroed::<f64>(memory.at, of_answer), zeroed::<T>(behind, rest.saturating_mul(size_of::<T>())))
        };
        self.statics = Some(StaticField::new(&self.scene, answer, rest)?);
        Ok(())
    }

    fn static_solve(&mut self) -> Result<(), OutputError> {
        let kind = vademecum_eval::format::SectionKind::FactorValues;
        let statics = self.statics.as_mut().ok_or(OutputError::Missing { kind })?;
        self.scene.solve_static_field(&self.state, statics)
    }

    fn modal_bind(&mut self, tolerance: f64, memory: Lent, work: &mut [f64]) -> Result<(), BindError> {
        let (found, (needed, _)) = (memory.bytes, modal_needs(&self.scene));
        if found < needed {
            return Err(BindError::LentMemory { found, needed });
        }
        // SAFETY: aligned, within the lent memory, and nobody else's; zeros are numbers.
        let numbers = unsafe { zeroed::<T>(memory.at, needed) };
        self.modal = None;
        self.modal = Some(Modal::bind(&self.scene, tolerance, numbers, work)?);
        Ok(())
    }

    fn modal_march(&mut self, steps: usize) -> Option<Result<Status, vademecum_eval::StepError>> {
        let Self { scene, state, loads, modal, .. } = self;
        Some(modal.as_mut()?.march(scene, state, loads, steps))
    }
}
