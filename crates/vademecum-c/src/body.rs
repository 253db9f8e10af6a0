//! A body in lent memory: a scene, one state and its loads, in single or double precision.

use core::ptr::NonNull;

use vademecum_eval::format::File;
use vademecum_eval::{
    BindError, Contact, FreeBody, Loads, Modal, Place, RigidMotion, Scalar, Scene, SceneOptions, State,
    StaticField, Status, StepError, StructureChoice, Surface, SurfacePoint,
};

use crate::message::Message;
use crate::types::{VdmBody, VdmNeeds, VdmOptions, VdmPlace, VdmPrecision, VdmStatus, VdmStructure};

/// Alignment of lent memory.
const ALIGNMENT: usize = 16;

/// Places that an operator is made for at most.
pub const MOST_PLACES: usize = 64;

impl VdmPlace {
    pub(crate) fn contact(&self, force: [f64; 3]) -> Contact {
        Contact::new(Place::triangle(self.nodes, self.weights), force)
    }

    pub(crate) fn point(&self) -> SurfacePoint {
        let Self { nodes, weights, position, distance } = *self;
        SurfacePoint { place: Place::triangle(nodes, weights), position, distance }
    }
}

/// Memory that C lends, aligned.
pub struct Lent {
    pub at: NonNull<u8>,
    pub bytes: usize,
}

impl Lent {
    /// `None` for null, or without the alignment.
    ///
    /// # Safety
    /// `memory` points to `bytes` bytes that nobody else uses for as long as what is placed in them lives.
    pub unsafe fn new(memory: *mut u8, bytes: usize) -> Option<Self> {
        let at = NonNull::new(memory)?;
        (at.addr().get().is_multiple_of(ALIGNMENT) && bytes <= isize::MAX as usize)
            .then_some(Self { at, bytes })
    }
}

/// What the handle points to.
#[repr(align(16))]
pub struct Body {
    pub file: File<'static>,
    pub surface: Option<Surface<'static>>,
    pub march: March,
    /// The rigid motion of a body without supports.
    pub free: Option<FreeBody>,
    pub message: Message,
}

/// What moves, in the precision of the body.
pub enum March {
    Single(Moved<f32>),
    #[cfg(feature = "double")]
    Double(Moved<f64>),
}

/// A scene, one state of it, and what acts on it.
pub struct Moved<T: 'static> {
    pub scene: Scene<'static, T>,
    pub state: State<'static, T>,
    pub loads: Loads<'static, T>,
    /// Loads that were kept.
    pub kept: Option<Loads<'static, T>>,
    /// For the operator, and for a state on its way in or out.
    pub work: &'static mut [T],
    /// The answer of the whole body to forces that stay, once there is memory for it.
    pub statics: Option<StaticField<'static, T>>,
    /// The modes of a dense step, once there is memory for them.
    pub modal: Option<Modal<'static, T>>,
}

/// Runs the same lines in the precision of a body.
macro_rules! moved {
    ($march:expr, $moved:ident => $lines:expr) => {
        match &mut $march {
            $crate::body::March::Single($moved) => $lines,
            #[cfg(feature = "double")]
            $crate::body::March::Double($moved) => $lines,
        }
    };
}
pub(crate) use moved;

/// What is asked for: options of the evaluator, and those of this interface.
pub struct Asked {
    scene: SceneOptions,
    double: bool,
    places: usize,
    keep_loads: bool,
}

impl Asked {
    /// `None` for a number that no option has.
    pub fn of(given: Option<&VdmOptions>) -> Option<Self> {
        let mut scene = SceneOptions::default();
        let Some(given) = given else {
            return Some(Self { scene, double: false, places: MOST_PLACES, keep_loads: false });
        };
        scene.structure = match given.structure {
            s if s == VdmStructure::VDM_AUTO as i32 => StructureChoice::Auto,
            s if s == VdmStructure::VDM_DIAGONAL as i32 => StructureChoice::Diagonal,
            s if s == VdmStructure::VDM_BLOCK as i32 => StructureChoice::Block,
            s if s == VdmStructure::VDM_EXACT as i32 => StructureChoice::Exact,
            s if s == VdmStructure::VDM_STRAIN as i32 => StructureChoice::Strain,
            _ => return None,
        };
        let double = match given.precision {
            p if p == VdmPrecision::VDM_SINGLE as i32 => false,
            p if p == VdmPrecision::VDM_DOUBLE as i32 && cfg!(feature = "double") => true,
            _ => return None,
        };
        scene.contacts = given.contacts as usize;
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
        let places = given.places as usize;
        (places <= MOST_PLACES).then_some(Self { scene, double, places, keep_loads: given.keep_loads != 0 })
    }
}

/// What a caller has to lend.
pub fn measure(file: &File<'_>, asked: &Asked) -> Result<VdmNeeds, BindError> {
    let (lengths, work) =
        if asked.double { lengths::<Double>(file, asked)? } else { lengths::<f32>(file, asked)? };
    let metadata = file.metadata();
    let size = if asked.double { size_of::<f64>() } else { size_of::<f32>() };
    let numbers = lengths.iter().fold(0usize, |sum, &length| sum.saturating_add(length));
    Ok(VdmNeeds {
        memory: numbers.saturating_mul(size).saturating_add(size_of::<Body>()),
        work,
        state: 3 * metadata.n_modes as usize,
        modes: metadata.n_modes,
        nodes: metadata.n_nodes,
        surface_nodes: metadata.n_surface_nodes,
        load_nodes: metadata.n_load_nodes,
        triangles: metadata.n_triangles,
        load_triangles: metadata.n_load_triangles,
        probes: metadata.n_probes,
        patterns: metadata.n_patterns,
        parameters: metadata.active_parameters().len() as u32,
        time_step: asked.scene.time_step.unwrap_or(metadata.time_step),
    })
}

/// Double precision, where the library has it; options that ask for it are refused elsewhere.
#[cfg(feature = "double")]
type Double = f64;
#[cfg(not(feature = "double"))]
type Double = f32;

/// Numbers for the scene, the state, the loads, kept loads and for work, and numbers of work while binding.
fn lengths<T: Scalar>(file: &File<'_>, asked: &Asked) -> Result<([usize; 5], usize), BindError> {
    let sizes = Scene::<T>::sizes(file, &asked.scene)?;
    let r = file.metadata().n_modes as usize;
    let work = (3 * asked.places + 1).max(3).saturating_mul(r);
    let kept = if asked.keep_loads { sizes.loads } else { 0 };
    Ok(([sizes.scene, sizes.state, sizes.loads, kept, work], sizes.work))
}

impl<T: Scalar> Moved<T> {
    fn bind(
        file: &File<'static>,
        asked: &Asked,
        memory: &'static mut [T],
        work: &mut [f64],
        message: &mut Message,
    ) -> Result<Self, VdmStatus> {
        use VdmStatus as S;
        let (lengths, _) = lengths::<T>(file, asked).map_err(|error| message.note(S::VDM_BIND, &error))?;
        let mut memory = memory;
        let mut take = |length: usize| -> Option<&'static mut [T]> {
            let (taken, rest) = core::mem::take(&mut memory).split_at_mut_checked(length)?;
            memory = rest;
            Some(taken)
        };
        let parts = lengths.map(&mut take);
        let [Some(scene), Some(state), Some(loads), Some(kept), Some(own)] = parts else {
            return Err(message.note(S::VDM_MEMORY, &"the lent memory is too short"));
        };
        let bound = Self::of_pieces(file, asked, [scene, state, loads, kept, own], work);
        bound.map_err(|error| message.note(S::VDM_BIND, &error))
    }
}

impl<T: Scalar> Moved<T> {
    fn of_pieces(
        file: &File<'static>,
        asked: &Asked,
        [scene, state, loads, kept, own]: [&'static mut [T]; 5],
        work: &mut [f64],
    ) -> Result<Self, BindError> {
        let scene = Scene::bind(file, &asked.scene, scene, work)?;
        let (state, loads) = (State::new(&scene, state)?, Loads::new(&scene, loads)?);
        let kept = if asked.keep_loads { Some(Loads::new(&scene, kept)?) } else { None };
        Ok(Self { scene, state, loads, kept, work: own, statics: None, modal: None })
    }
}

impl Body {
    /// Places a body at the start of the memory and its numbers behind it.
    pub fn bind(
        file: File<'static>,
        asked: &Asked,
        memory: Lent,
        work: &mut [f64],
        message: &mut Message,
    ) -> Result<*mut VdmBody, VdmStatus> {
        let own = size_of::<Self>();
        let needed = measure(&file, asked).map_err(|error| message.note(VdmStatus::VDM_BIND, &error))?;
        if memory.bytes < needed.memory || work.len() < needed.work {
            let short = Short { memory: [memory.bytes, needed.memory], work: [work.len(), needed.work] };
            return Err(message.note(VdmStatus::VDM_MEMORY, &short));
        }
        let rest = needed.memory - own;
        // The size of a body is a multiple of its alignment, so the numbers behind it are aligned, too.
        // SAFETY: `own` bytes are within the lent memory.
        let behind = unsafe { memory.at.add(own) };
        #[cfg(feature = "double")]
        let march = if asked.double {
            // SAFETY: aligned, within the lent memory, and nobody else's; zeros are numbers.
            let numbers = unsafe { zeroed::<f64>(behind, rest) };
            March::Double(Moved::bind(&file, asked, numbers, work, message)?)
        } else {
            // SAFETY: the same.
            let numbers = unsafe { zeroed::<f32>(behind, rest) };
            March::Single(Moved::bind(&file, asked, numbers, work, message)?)
        };
        #[cfg(not(feature = "double"))]
        let march = {
            // SAFETY: the same.
            let numbers = unsafe { zeroed::<f32>(behind, rest) };
            March::Single(Moved::bind(&file, asked, numbers, work, message)?)
        };
        let surface = Surface::new(&file).ok();
        let free = match &march {
            March::Single(m) => FreeBody::new(&m.scene, RigidMotion::at_rest),
            #[cfg(feature = "double")]
            March::Double(m) => FreeBody::new(&m.scene, RigidMotion::at_rest),
        };
        let body = Self { file, surface, march, free, message: Message::default() };
        let place = memory.at.cast::<Self>();
        // SAFETY: aligned to 16 as the body is, and long enough.
        unsafe { place.write(body) };
        Ok(place.as_ptr().cast())
    }

    /// What a handle points to.
    ///
    /// # Safety
    /// `body` is null or a handle of [`Body::bind`] whose memory is still lent, used by no other thread.
    pub unsafe fn of<'a>(body: *const VdmBody) -> Option<&'a Self> {
        // SAFETY: as the caller promises.
        unsafe { body.cast::<Self>().as_ref() }
    }

    /// The same, to be changed.
    ///
    /// # Safety
    /// As for [`Body::of`].
    pub unsafe fn of_mut<'a>(body: *mut VdmBody) -> Option<&'a mut Self> {
        // SAFETY: as the caller promises.
        unsafe { body.cast::<Self>().as_mut() }
    }

    pub fn message(&self) -> &Message {
        &self.message
    }

    /// Keeps the words of a refusal.
    pub fn answer<E: core::fmt::Display>(&mut self, done: Result<(), E>, refused: VdmStatus) -> VdmStatus {
        match done {
            Ok(()) => VdmStatus::VDM_OK,
            Err(error) => self.message.note(refused, &error),
        }
    }

    pub fn step(&mut self, steps: u64) -> VdmStatus {
        let mut found = Ok(Status::Moving);
        moved!(self.march, m => {
            for _ in 0..steps {
                found = m.scene.step(&mut m.state, &m.loads);
                if !matches!(found, Ok(Status::Moving)) {
                    break;
                }
            }
        });
        self.stepped(found)
    }

    /// What a step found.
    pub fn stepped(&mut self, found: Result<Status, StepError>) -> VdmStatus {
        match found {
            Ok(Status::AtRest) => VdmStatus::VDM_AT_REST,
            Ok(_) => VdmStatus::VDM_OK,
            Err(error) => self.message.note(VdmStatus::VDM_STEP, &error),
        }
    }

    pub fn rest(&mut self) -> VdmStatus {
        moved!(self.march, m => m.state.rest());
        if let Some(free) = &mut self.free {
            free.set_motion(RigidMotion::at_rest(free.body()));
        }
        VdmStatus::VDM_OK
    }
}

/// What was lent, and what is needed.
struct Short {
    memory: [usize; 2],
    work: [usize; 2],
}

impl core::fmt::Display for Short {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let ([memory, needed], [work, wanted]) = (self.memory, self.work);
        write!(
            out,
            "{memory} bytes of memory and {work} numbers of work were lent; the body needs {needed} and \
             {wanted}: ask vdm_measure with the same options"
        )
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
