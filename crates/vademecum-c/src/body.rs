//! A body in lent memory: a scene, one state and its loads, in single or double precision.

use core::ffi::c_char;
use core::ptr::NonNull;

use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{
    Contact, Field, Loads, Scalar, Scene, SceneOptions, State, Status, Surface, SurfacePoint,
};

use crate::message::{Message, copy};
use crate::types::{VdmBody, VdmField, VdmNamed, VdmNeeds, VdmOptions, VdmPlace, VdmPrecision, VdmStatus};

/// Alignment of lent memory.
const ALIGNMENT: usize = 16;

/// Places that an operator is made for at most.
const MOST_PLACES: usize = 64;

impl VdmPlace {
    fn contact(&self, force: [f64; 3]) -> Contact {
        Contact { nodes: self.nodes, weights: self.weights, force }
    }

    fn point(&self) -> SurfacePoint {
        let Self { nodes, weights, position, distance } = *self;
        SurfacePoint { nodes, weights, position, distance }
    }
}

/// Memory that C lends, aligned.
pub struct Lent {
    at: NonNull<u8>,
    bytes: usize,
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
    file: File<'static>,
    surface: Option<Surface<'static>>,
    march: March,
    message: Message,
}

enum March {
    Single(Moved<f32>),
    Double(Moved<f64>),
}

struct Moved<T: 'static> {
    scene: Scene<'static, T>,
    state: State<'static, T>,
    loads: Loads<'static, T>,
    /// For the operator, and for a state on its way in or out.
    work: &'static mut [T],
}

/// Runs the same lines in the precision of a body.
macro_rules! moved {
    ($march:expr, $moved:ident => $lines:expr) => {
        match &mut $march {
            March::Single($moved) => $lines,
            March::Double($moved) => $lines,
        }
    };
}

/// The options of the evaluator.
pub fn options(given: Option<&VdmOptions>) -> (SceneOptions, bool) {
    let mut options = SceneOptions::default();
    let mut double = false;
    if let Some(given) = given {
        options.contacts = given.contacts as usize;
        options.residual = given.residual != 0;
        options.rest_below = given.rest_below;
        double = given.precision == VdmPrecision::VDM_DOUBLE as i32;
    }
    (options, double)
}

/// What a caller has to lend.
pub fn measure(
    file: &File<'_>,
    (options, double): &(SceneOptions, bool),
) -> Result<VdmNeeds, vademecum_eval::BindError> {
    let (numbers, work) =
        if *double { lengths::<f64>(file, options)? } else { lengths::<f32>(file, options)? };
    let metadata = file.metadata();
    let size = if *double { size_of::<f64>() } else { size_of::<f32>() };
    Ok(VdmNeeds {
        memory: size_of::<Body>() + numbers.iter().sum::<usize>() * size,
        work,
        state: 3 * metadata.n_modes as usize,
        modes: metadata.n_modes,
        nodes: metadata.n_nodes,
        surface_nodes: metadata.n_surface_nodes,
        load_nodes: metadata.n_load_nodes,
        probes: metadata.n_probes,
        patterns: metadata.n_patterns,
        parameters: metadata.active_parameters().len() as u32,
        time_step: metadata.time_step,
    })
}

/// Numbers for the scene, the state, the loads and for work, and numbers of work while binding.
fn lengths<T: Scalar>(
    file: &File<'_>,
    options: &SceneOptions,
) -> Result<([usize; 4], usize), vademecum_eval::BindError> {
    let sizes = Scene::<T>::sizes(file, options)?;
    let r = file.metadata().n_modes as usize;
    let work = (3 * MOST_PLACES + 1).saturating_mul(r);
    Ok(([sizes.scene, sizes.state, sizes.loads, work], sizes.work))
}

impl<T: Scalar> Moved<T> {
    fn bind(
        file: &File<'static>,
        options: &SceneOptions,
        memory: &'static mut [T],
        work: &mut [f64],
        message: &mut Message,
    ) -> Result<Self, VdmStatus> {
        use VdmStatus as S;
        let (lengths, needed) =
            lengths::<T>(file, options).map_err(|error| message.note(S::VDM_BIND, &error))?;
        let mut memory = memory;
        let mut take = |length: usize| -> Option<&'static mut [T]> {
            let (taken, rest) = core::mem::take(&mut memory).split_at_mut_checked(length)?;
            memory = rest;
            Some(taken)
        };
        let parts = lengths.map(&mut take);
        let [Some(scene), Some(state), Some(loads), Some(own)] = parts else {
            return Err(message.note(S::VDM_MEMORY, &"the lent memory is too short"));
        };
        if work.len() < needed {
            return Err(message.note(S::VDM_MEMORY, &"the lent work is too short"));
        }
        let scene = Scene::bind(file, options, scene, work);
        let scene = scene.map_err(|error| message.note(S::VDM_BIND, &error))?;
        let state = State::new(&scene, state).map_err(|error| message.note(S::VDM_BIND, &error))?;
        let loads = Loads::new(&scene, loads).map_err(|error| message.note(S::VDM_BIND, &error))?;
        Ok(Self { scene, state, loads, work: own })
    }
}

impl Body {
    /// Places a body at the start of the memory and its numbers behind it.
    pub fn bind(
        file: File<'static>,
        (options, double): &(SceneOptions, bool),
        memory: Lent,
        work: &mut [f64],
        message: &mut Message,
    ) -> Result<*mut VdmBody, VdmStatus> {
        let own = size_of::<Self>();
        let Some(rest) = memory.bytes.checked_sub(own) else {
            return Err(message.note(VdmStatus::VDM_MEMORY, &"the lent memory is too short"));
        };
        // The size of a body is a multiple of its alignment, so the numbers behind it are aligned, too.
        // SAFETY: `own` bytes are within the lent memory.
        let behind = unsafe { memory.at.add(own) };
        let march = if *double {
            // SAFETY: aligned, within the lent memory, and nobody else's; zeros are numbers.
            let numbers = unsafe { zeroed::<f64>(behind, rest) };
            March::Double(Moved::bind(&file, options, numbers, work, message)?)
        } else {
            // SAFETY: the same.
            let numbers = unsafe { zeroed::<f32>(behind, rest) };
            March::Single(Moved::bind(&file, options, numbers, work, message)?)
        };
        let surface = Surface::new(&file).ok();
        let body = Self { file, surface, march, message: Message::default() };
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
    fn answer<E: core::fmt::Display>(&mut self, done: Result<(), E>, refused: VdmStatus) -> VdmStatus {
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
        match found {
            Ok(Status::AtRest) => VdmStatus::VDM_AT_REST,
            Ok(_) => VdmStatus::VDM_OK,
            Err(error) => self.message.note(VdmStatus::VDM_STEP, &error),
        }
    }

    pub fn rest(&mut self) -> VdmStatus {
        moved!(self.march, m => m.state.rest());
        VdmStatus::VDM_OK
    }

    pub fn locate(&mut self, point: [f64; 3], place: &mut VdmPlace) -> VdmStatus {
        match self.surface.as_ref().and_then(|surface| surface.locate(point)) {
            Some(SurfacePoint { nodes, weights, position, distance }) => {
                *place = VdmPlace { nodes, weights, position, distance };
                VdmStatus::VDM_OK
            }
            None => self.message.note(VdmStatus::VDM_OUTPUT, &"the file has no loadable surface"),
        }
    }

    pub fn clear_loads(&mut self) -> VdmStatus {
        moved!(self.march, m => m.loads.clear());
        VdmStatus::VDM_OK
    }

    pub fn add_contact(&mut self, place: &VdmPlace, force: [f64; 3]) -> VdmStatus {
        let contact = place.contact(force);
        let done = moved!(self.march, m => m.loads.add_contact(&m.scene, &contact));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    pub fn add_pattern(&mut self, pattern: u32, amplitude: f64) -> VdmStatus {
        let done = moved!(self.march, m => m.loads.add_pattern(&m.scene, pattern as usize, amplitude));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    pub fn set_parameter(&mut self, parameter: u32, value: f64, work: &mut [f64]) -> VdmStatus {
        let index = parameter as usize;
        let done = moved!(self.march, m => m.scene.set_parameter(index, value, &mut m.state, work));
        self.answer(done, VdmStatus::VDM_BIND)
    }

    /// The field of this number; for another one the message says so.
    fn field(&mut self, field: i32) -> Option<Field> {
        match field {
            f if f == VdmField::VDM_DISPLACEMENT as i32 => Some(Field::Displacement),
            f if f == VdmField::VDM_VELOCITY as i32 => Some(Field::Velocity),
            _ => {
                self.message.note(VdmStatus::VDM_ARGUMENT, &"no such field");
                None
            }
        }
    }

    pub fn probe(&mut self, probe: u32, field: i32, value: &mut f64) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        let found = moved!(self.march, m => m.scene.probe(&m.state, probe as usize, field));
        self.answer(found.map(|found| *value = found), VdmStatus::VDM_OUTPUT)
    }

    pub fn point(&mut self, place: &VdmPlace, field: i32, out: [&mut f64; 3]) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        let found = moved!(self.march, m => m.scene.point(&m.state, &place.point(), field));
        let found = found.map(|found| out.into_iter().zip(found).for_each(|(out, x)| *out = x));
        self.answer(found, VdmStatus::VDM_OUTPUT)
    }

    pub fn node(&mut self, node: u32, field: i32, out: [&mut f64; 3]) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        let found = moved!(self.march, m => m.scene.node(&m.state, node as usize, field));
        let found = found.map(|found| out.into_iter().zip(found).for_each(|(out, x)| *out = x));
        self.answer(found, VdmStatus::VDM_OUTPUT)
    }

    pub fn surface_single(&mut self, field: i32, out: &mut [f32]) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        match &self.march {
            March::Single(m) => {
                let done = m.scene.surface_into(&m.state, field, out);
                self.answer(done, VdmStatus::VDM_OUTPUT)
            }
            March::Double(_) => {
                self.message.note(VdmStatus::VDM_ARGUMENT, &"the body is in double precision")
            }
        }
    }

    pub fn surface_double(&mut self, field: i32, out: &mut [f64]) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        match &self.march {
            March::Double(m) => {
                let done = m.scene.surface_into(&m.state, field, out);
                self.answer(done, VdmStatus::VDM_OUTPUT)
            }
            March::Single(_) => {
                self.message.note(VdmStatus::VDM_ARGUMENT, &"the body is in single precision")
            }
        }
    }

    pub fn energy(&mut self, value: &mut f64) -> VdmStatus {
        let found = moved!(self.march, m => m.scene.energy(&m.state));
        self.answer(found.map(|found| *value = found), VdmStatus::VDM_OUTPUT)
    }

    pub fn save(&mut self, out: &mut [f64]) -> VdmStatus {
        let done = moved!(self.march, m => {
            let saved = m.work.get_mut(..out.len()).unwrap_or_default();
            let done = m.state.save_into(saved);
            out.iter_mut().zip(saved).for_each(|(out, x)| *out = x.to_f64());
            done
        });
        self.answer(done, VdmStatus::VDM_STEP)
    }

    pub fn restore(&mut self, saved: &[f64]) -> VdmStatus {
        let done = moved!(self.march, m => {
            let own = m.work.get_mut(..saved.len()).unwrap_or_default();
            own.iter_mut().zip(saved).for_each(|(own, &x)| *own = Scalar::from_f64(x));
            m.state.restore(own)
        });
        self.answer(done, VdmStatus::VDM_STEP)
    }

    pub fn compliance(&mut self, places: &[VdmPlace], w: &mut [f64]) -> VdmStatus {
        let mut contacts = [Contact { nodes: [0; 3], weights: [0.0; 3], force: [0.0; 3] }; MOST_PLACES];
        let Some(contacts) = contacts.get_mut(..places.len()) else {
            return self.message.note(VdmStatus::VDM_ARGUMENT, &"more than 64 places");
        };
        contacts.iter_mut().zip(places).for_each(|(contact, place)| *contact = place.contact([0.0; 3]));
        let done = moved!(self.march, m => m.scene.compliance(contacts, w, m.work));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    /// Names of a kind, in order.
    fn names(&self, kind: i32) -> Option<Names<'_>> {
        let section = |kind| {
            let text = self.file.section(kind).and_then(|section| section.text().ok()).unwrap_or("");
            Names::Lines(text.lines())
        };
        match kind {
            k if k == VdmNamed::VDM_PROBES as i32 => Some(section(SectionKind::ProbeNames)),
            k if k == VdmNamed::VDM_PATTERNS as i32 => Some(section(SectionKind::PatternNames)),
            k if k == VdmNamed::VDM_PARAMETERS as i32 => {
                Some(Names::Parameters(self.file.metadata().active_parameters().iter()))
            }
            _ => None,
        }
    }

    pub fn name(&mut self, kind: i32, index: u32, out: &mut [c_char]) -> VdmStatus {
        let found = self.names(kind).and_then(|mut names| names.nth(index as usize));
        match found {
            Some(name) => {
                copy(name.as_bytes(), out);
                VdmStatus::VDM_OK
            }
            None => self.message.note(VdmStatus::VDM_ARGUMENT, &"the file has no such name"),
        }
    }

    pub fn find(&mut self, kind: i32, name: &str) -> i32 {
        let place = self.names(kind).and_then(|mut names| names.position(|found| found == name));
        place.and_then(|place| i32::try_from(place).ok()).unwrap_or(-1)
    }
}

/// Names as the file has them.
enum Names<'a> {
    Lines(core::str::Lines<'a>),
    Parameters(core::slice::Iter<'a, vademecum_eval::format::Parameter<'a>>),
}

impl<'a> Iterator for Names<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        match self {
            Self::Lines(lines) => lines.next(),
            Self::Parameters(parameters) => parameters.next().map(|parameter| parameter.name),
        }
    }
}

/// As many numbers as fit, all zero.
///
/// # Safety
/// `at` is aligned for `T` and points to `bytes` bytes that nobody else uses for as long as the numbers live;
/// all zeros is a value of `T`.
unsafe fn zeroed<T>(at: NonNull<u8>, bytes: usize) -> &'static mut [T] {
    let count = bytes / size_of::<T>();
    let at = at.cast::<T>().as_ptr();
    // SAFETY: as the caller promises.
    unsafe {
        core::ptr::write_bytes(at, 0, count);
        core::slice::from_raw_parts_mut(at, count)
    }
}
