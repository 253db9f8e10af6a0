//! A body in lent memory, and the words of its last refusal.

use core::ptr::NonNull;

use vademecum_eval::format::File;
use vademecum_eval::{AnyBody, BindError, BodyOptions, Place, Precision, StructureChoice};
#[cfg(feature = "parametric")]
use vademecum_eval::{Carried, LiveMemory, Parametric};

use crate::message::Message;
use crate::refusal::{Answer, Refusal};
use crate::types::{
    VDM_NO_FRAME, VdmBody, VdmCarried, VdmNeeds, VdmOptions, VdmPlace, VdmPrecision, VdmStatus, VdmStructure,
};

/// Alignment of lent memory.
const ALIGNMENT: usize = 16;

/// A body in the precision that was asked for.
pub type Body = AnyBody<'static>;

/// The body behind a handle.
#[repr(align(16))]
pub struct Handle {
    pub body: Body,
    pub message: Message,
    /// The file as it was given; that of a parametric body is written anew at each change of a parameter.
    pub file: File<'static>,
    /// Changes of parameters that have replaced the body.
    pub changes: u64,
    #[cfg(feature = "parametric")]
    live: Option<LiveMemory<'static>>,
}

/// Memory that C lends, aligned.
pub struct Lent {
    pub at: NonNull<u8>,
    pub bytes: usize,
}

impl Lent {
    /// # Safety
    /// `memory` is null or points to `bytes` bytes that nobody else uses for as long as what is placed in
    /// them lives.
    pub unsafe fn new(memory: *mut u8, bytes: usize) -> Result<Self, Refusal> {
        let said = "the lent memory is null, or not aligned to 16 bytes";
        NonNull::new(memory)
            .filter(|at| at.addr().get().is_multiple_of(ALIGNMENT) && bytes <= isize::MAX as usize)
            .map(|at| Self { at, bytes })
            .ok_or(Refusal::Words(VdmStatus::VDM_MEMORY, said))
    }

    /// Refuses fewer bytes than are needed.
    pub const fn check(&self, needed: usize) -> Result<(), Refusal> {
        let found = self.bytes;
        if found < needed { Err(Refusal::Memory { found, needed }) } else { Ok(()) }
    }
}

/// Options of the evaluator that were asked for.
pub struct Asked {
    options: BodyOptions,
    precision: Precision,
}

impl Asked {
    pub fn of(given: Option<&VdmOptions>) -> Result<Self, Refusal> {
        let mut options = BodyOptions::default();
        let Some(given) = given else { return Ok(Self { options, precision: Precision::Single }) };
        let said = "an option is none: precision or structure; start from vdm_default_options";
        let none = Refusal::Words(VdmStatus::VDM_ARGUMENT, said);
        let scene = &mut options.scene;
        scene.structure = match given.structure {
            s if s == VdmStructure::VDM_AUTO as i32 => StructureChoice::Auto,
            s if s == VdmStructure::VDM_DIAGONAL as i32 => StructureChoice::Diagonal,
            s if s == VdmStructure::VDM_BLOCK as i32 => StructureChoice::Block,
            s if s == VdmStructure::VDM_EXACT as i32 => StructureChoice::Exact,
            s if s == VdmStructure::VDM_STRAIN as i32 => StructureChoice::Strain,
            _ => return Err(none),
        };
        let precision = match given.precision {
            p if p == VdmPrecision::VDM_SINGLE as i32 => Precision::Single,
            #[cfg(feature = "double")]
            p if p == VdmPrecision::VDM_DOUBLE as i32 => Precision::Double,
            _ => return Err(none),
        };
        scene.contacts = given.contacts as usize;
        scene.filtered_nodes = (given.filtered_nodes != 0).then_some(given.filtered_nodes as usize);
        scene.residual = given.residual != 0;
        scene.terms = (given.terms != 0).then_some(given.terms as usize);
        scene.tolerance = given.tolerance;
        scene.time_step = (given.time_step != 0.0).then_some(given.time_step);
        (scene.stiffness, scene.density) = (given.stiffness, given.density);
        // Not a number is no wish for the file's value.
        scene.alpha = (given.alpha.is_nan() || given.alpha >= 0.0).then_some(given.alpha);
        scene.beta = (given.beta.is_nan() || given.beta >= 0.0).then_some(given.beta);
        scene.rest_below = given.rest_below;
        scene.substeps = (given.substeps != 0).then_some(given.substeps as usize);
        scene.viscosity = given.viscosity;
        options.places = given.places as usize;
        options.keep_loads = given.keep_loads != 0;
        options.static_field = given.static_field != 0;
        options.flight = given.flight != 0;
        options.modes = (given.modes != 0).then_some(given.modes as usize);
        Ok(Self { options, precision })
    }

    /// Bytes for a handle and what it lives in.
    fn bytes(&self, file: &File<'_>) -> Result<usize, BindError> {
        #[cfg(feature = "parametric")]
        let numbers = LiveMemory::any_len(file, &self.options, self.precision)?;
        #[cfg(not(feature = "parametric"))]
        let numbers = Body::len_for(file, &self.options, self.precision)?;
        Ok(numbers.saturating_mul(size_of::<f64>()).saturating_add(size_of::<Handle>()))
    }

    /// Memory that a caller lends, and counts of the file.
    pub fn needs(&self, file: &File<'_>) -> Result<VdmNeeds, BindError> {
        let metadata = file.metadata();
        #[cfg(feature = "parametric")]
        let modes = Parametric::new(file)
            .map_or(metadata.n_modes, |model| self.options.modes.unwrap_or(model.usual_modes()) as u32);
        #[cfg(not(feature = "parametric"))]
        let modes = metadata.n_modes;
        Ok(VdmNeeds {
            memory: self.bytes(file)?,
            modes,
            nodes: metadata.n_nodes,
            surface_nodes: metadata.n_surface_nodes,
            load_nodes: metadata.n_load_nodes,
            triangles: metadata.n_triangles,
            load_triangles: metadata.n_load_triangles,
            probes: metadata.n_probes,
            patterns: metadata.n_patterns,
            parameters: file.parameters().count() as u32,
            time_step: self.options.scene.time_step.unwrap_or(metadata.time_step),
        })
    }
}

impl Handle {
    /// Places a handle at the start of the memory and the numbers of its body behind it.
    pub fn bind(file: &File<'static>, asked: &Asked, memory: &Lent) -> Result<*mut VdmBody, Refusal> {
        let (own, needed) = (size_of::<Self>(), asked.bytes(file)?);
        memory.check(needed)?;
        // The size of a handle is a multiple of its alignment, so the numbers behind it are aligned, too.
        // SAFETY: `needed` bytes are within the lent memory, `own` of them for the handle, and nobody else
        // uses them; zeros are numbers.
        let numbers = unsafe { zeroed(memory.at.add(own), needed - own) };
        #[cfg(feature = "parametric")]
        let (live, body) = LiveMemory::bind_any(file, &asked.options, asked.precision, numbers)?;
        #[cfg(not(feature = "parametric"))]
        let body = Body::bind(file, &asked.options, asked.precision, numbers)?;
        let place = memory.at.cast::<Self>();
        // SAFETY: aligned to 16 as the handle is, and long enough.
        unsafe {
            place.write(Self {
                body,
                message: Message::default(),
                file: *file,
                changes: 0,
                #[cfg(feature = "parametric")]
                live,
            });
        }
        Ok(place.as_ptr().cast())
    }

    /// Value of a live parameter.
    pub fn value(&self, index: usize) -> Option<f64> {
        #[cfg(feature = "parametric")]
        if let Some(live) = &self.live {
            return live.values().get(index).copied();
        }
        self.body.options().value(self.file.metadata(), index)
    }

    /// Energies of the last change; `None` of a file without live regions.
    pub fn carried(&self) -> Option<VdmCarried> {
        #[cfg(feature = "parametric")]
        if let Some(live) = &self.live {
            let Carried { lost_kinetic, lost_elastic, work } = live.carried();
            return Some(VdmCarried { lost_kinetic, lost_elastic, work });
        }
        None
    }

    /// Sets live parameters.
    pub fn set_parameters(&mut self, settings: &[(usize, f64)]) -> Result<(), BindError> {
        #[cfg(feature = "parametric")]
        if let Some(live) = &mut self.live {
            // SAFETY: the body is that of this memory. Its file is copied by nothing that outlives a call.
            let _ = unsafe { live.set_any(settings, &mut self.body)? };
            self.changes += 1;
            return Ok(());
        }
        let _ = self.body.set_parameters(settings)?;
        Ok(())
    }

    /// # Safety
    /// `body` is null or a handle of [`Handle::bind`] whose memory is still lent, used by no other thread.
    pub unsafe fn of<'a>(body: *const VdmBody) -> Option<&'a Self> {
        // SAFETY: as the caller promises.
        unsafe { body.cast::<Self>().as_ref() }
    }

    /// The same, to be changed.
    ///
    /// # Safety
    /// As for [`Handle::of`].
    pub unsafe fn of_mut<'a>(body: *mut VdmBody) -> Option<&'a mut Self> {
        // SAFETY: as the caller promises.
        unsafe { body.cast::<Self>().as_mut() }
    }
}

/// Runs a call on a body and keeps the words of its refusal; a null handle has nowhere to keep them.
///
/// # Safety
/// As for [`Handle::of`].
pub unsafe fn on(body: *mut VdmBody, run: impl FnOnce(&mut Body) -> Answer) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_handle(body, |handle| run(&mut handle.body)) }
}

/// The same with what is beside the body.
///
/// # Safety
/// As for [`Handle::of`].
pub unsafe fn on_handle(body: *mut VdmBody, run: impl FnOnce(&mut Handle) -> Answer) -> VdmStatus {
    // SAFETY: as the caller promises.
    let Some(handle) = (unsafe { Handle::of_mut(body) }) else { return VdmStatus::VDM_ARGUMENT };
    run(handle).unwrap_or_else(|refusal| handle.message.note(&refusal))
}

/// Reads from a body what cannot be refused; `none` for a null handle.
///
/// # Safety
/// As for [`Handle::of`].
pub unsafe fn ask<R>(body: *const VdmBody, none: R, run: impl FnOnce(&Body) -> R) -> R {
    // SAFETY: as the caller promises.
    unsafe { Handle::of(body) }.map_or(none, |handle| run(&handle.body))
}

// A place of C begins with a place of the evaluator.
const _: () = {
    assert!(core::mem::offset_of!(VdmPlace, position) == size_of::<Place>());
    assert!(align_of::<VdmPlace>() == align_of::<Place>());
};

impl AsRef<Place> for VdmPlace {
    fn as_ref(&self) -> &Place {
        // SAFETY: `Place` is laid out as C does and allows every value of its numbers; its fields are the
        // first ones of `VdmPlace`, of the same types in the same order (a test compares them).
        unsafe { &*core::ptr::from_ref(self).cast() }
    }
}

impl VdmPlace {
    /// A place of the evaluator, and where it is at rest.
    pub fn new(place: &Place, position: [f64; 3], distance: f64) -> Self {
        let mut found = Self {
            count: place.nodes().len() as u32,
            frame: place.frame_index().unwrap_or(VDM_NO_FRAME),
            radius: place.radius(),
            position,
            distance,
            ..Self::default()
        };
        found.nodes.iter_mut().zip(place.nodes()).for_each(|(to, node)| *to = *node);
        found.weights.iter_mut().zip(place.weights()).for_each(|(to, weight)| *to = *weight);
        found
    }
}

/// As many numbers as fit, all zero.
///
/// # Safety
/// `at` is aligned for `T` and points to `bytes` bytes that nobody else uses for as long as the numbers live;
/// all zeros is a value of `T`.
pub unsafe fn zeroed<T>(at: NonNull<u8>, bytes: usize) -> &'static mut [T] {
    let count = bytes / size_of::<T>();
    let at = at.cast::<T>().as_ptr();
    // SAFETY: as the caller promises.
    unsafe {
        core::ptr::write_bytes(at, 0, count);
        core::slice::from_raw_parts_mut(at, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_of_c_begins_with_one_of_the_evaluator() {
        let place = Place::new(&[3, 4, 7, 8], &[0.5, 0.25, 0.125, 0.125]).expect("a place").with_radius(2.0);
        for place in [place, Place::triangle([1, 2, 3], [0.5, 0.25, 0.25]), Place::node(9), Place::frame(5)] {
            assert_eq!(*VdmPlace::new(&place, [0.0; 3], 0.0).as_ref(), place);
        }
        // More nodes than there is room for are no place.
        let wrong = VdmPlace { count: 17, ..VdmPlace::new(&place, [0.0; 3], 0.0) };
        assert!(wrong.as_ref().check().is_err());
    }
}
