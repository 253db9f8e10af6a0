//! The exports of the module of a world. Numbers go in as arguments and in [`exchange`]; what comes back is
//! left there too, or in [`answer`] where it is long, sentences in [`message_at`]. `1` means done and `0`
//! refused (then the message says why), if nothing else is said.
//!
//! Beside the exports of one body the second place of the crate with `unsafe`: it trusts the page for what no
//! language can check across this boundary, that lent ranges lie inside the module's memory, do not overlap,
//! and stay untouched for as long as they are lent (files and surfaces for ever). Here is the module's
//! allocator, too, which gives out memory and takes back only what was given out last.
#![allow(unsafe_code)]

use alloc::vec::Vec;
use core::alloc::{GlobalAlloc, Layout};
use core::cell::UnsafeCell;
use core::panic::PanicInfo;
use core::slice::{from_raw_parts, from_raw_parts_mut};

use vademecum_eval::format::SectionKind;
use vademecum_eval::{
    Anchor, JointKind, Lead, LoadError, MAX_PLACE_NODES, Nodes, Place, PlaceError, RigidBody, Touching,
    WorldJoint, WorldOptions,
};

use crate::message::Message;
use crate::pull::{Grip, Pull};
use crate::refusal::Refusal;
use crate::stage::{Shown, Stage, Start};

/// Numbers in the exchange buffer.
const EXCHANGE: usize = 64;
/// Bytes of a page of the module's memory.
const PAGE: usize = 65_536;
/// First number of target, stiffness and damping of [`pull`] in the exchange buffer.
const HAND: usize = 40;

/// The end of what was given out, and of the memory behind it.
struct Bump(UnsafeCell<[usize; 2]>);

// SAFETY: the module is built without threads, so nothing is ever shared between them.
unsafe impl Sync for Bump {}

// SAFETY: a block lies between the end before and the end after it, within pages that the memory grew by, so
// no two blocks that are both given out overlap.
unsafe impl GlobalAlloc for Bump {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: one thread, and no call of this function inside of itself.
        let [end, limit] = unsafe { &mut *self.0.get() };
        let mut start = end.next_multiple_of(layout.align());
        if *end == 0 || start + layout.size() > *limit {
            let pages = layout.size().div_ceil(PAGE) + 16;
            let grown = core::arch::wasm32::memory_grow::<0>(pages);
            if grown == usize::MAX {
                return core::ptr::null_mut();
            }
            // Beside what there was before, unless the page has grown the memory meanwhile.
            if *end == 0 || grown * PAGE != *limit {
                start = grown * PAGE;
            }
            *limit = (grown + pages) * PAGE;
        }
        *end = start + layout.size();
        start as *mut u8
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: as above.
        let [end, _] = unsafe { &mut *self.0.get() };
        if at as usize + layout.size() == *end {
            *end = at as usize;
        }
    }
}

#[global_allocator]
static MEMORY: Bump = Bump(UnsafeCell::new([0; 2]));

/// Everything the module remembers.
struct Module {
    stage: Stage,
    exchange: [f64; EXCHANGE],
    answer: Vec<f64>,
    bytes: Vec<u8>,
    work: Vec<f64>,
    message: Message,
}

struct Global(UnsafeCell<Module>);

// SAFETY: the module is built without threads, so nothing is ever shared between them.
unsafe impl Sync for Global {}

static MODULE: Global = Global(UnsafeCell::new(Module {
    stage: Stage::new(),
    exchange: [0.0; EXCHANGE],
    answer: Vec::new(),
    bytes: Vec::new(),
    work: Vec::new(),
    message: Message::new(),
}));

/// The module's memory of itself, for the time of one call.
fn module() -> &'static mut Module {
    // SAFETY: each export calls this once, calls no other export, and runs to its end before the page can
    // call again (one thread, no imports), so this is the only reference.
    unsafe { &mut *MODULE.0.get() }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    core::arch::wasm32::unreachable()
}

impl Module {
    /// The result of a call; a refusal becomes the message and 0.
    fn told(&mut self, result: Result<u32, Refusal>) -> u32 {
        result.unwrap_or_else(|refusal| {
            self.message.say(&refusal);
            0
        })
    }

    /// Puts `numbers` into the exchange buffer, from its start.
    fn give(&mut self, numbers: impl IntoIterator<Item = f64>) {
        self.exchange.iter_mut().zip(numbers).for_each(|(place, x)| *place = x);
    }

    /// Three numbers of the exchange buffer.
    fn three(&self, at: usize) -> [f64; 3] {
        core::array::from_fn(|k| self.exchange.get(at + k).copied().unwrap_or(0.0))
    }

    /// The exchange buffer as the start of a part: position, quaternion, velocity, angular velocity.
    fn start(&self) -> Start {
        let [_, _, _, w, x, y, z, ..] = self.exchange;
        let (position, rotation) = (self.three(0), [w, x, y, z]);
        Start { position, rotation, velocity: self.three(7), spin: self.three(10) }
    }
}

/// Address of the exchange buffer.
#[unsafe(no_mangle)]
pub extern "C" fn exchange() -> *const f64 {
    module().exchange.as_ptr()
}

/// Address of the numbers of the last long answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const f64 {
    module().answer.as_ptr()
}

/// Address of the bytes of the last saved state.
#[unsafe(no_mangle)]
pub extern "C" fn bytes() -> *const u8 {
    module().bytes.as_ptr()
}

/// Address of the last refusal's sentence.
#[unsafe(no_mangle)]
pub extern "C" fn message_at() -> *const u8 {
    module().message.bytes().as_ptr()
}

/// Its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn message_len() -> usize {
    module().message.bytes().len()
}

/// Lends so many bytes to the page, for ever; their address, aligned to 8.
#[unsafe(no_mangle)]
pub extern "C" fn lend(length: usize) -> *mut f64 {
    alloc::vec![0.0_f64; length.div_ceil(8)].leak().as_mut_ptr()
}

/// Opens the file in the lent range and compares every section with its checksum: its number, counted from 1.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn open(at: *const u8, length: usize) -> usize {
    let module = module();
    // SAFETY: lent for ever.
    match module.stage.open(unsafe { from_raw_parts(at, length) }) {
        Ok(number) => number + 1,
        Err(error) => {
            module.message.say(&error);
            0
        }
    }
}

/// Leaves the counts of file `file` (from 0) in the exchange buffer: nodes of the surface, loadable ones,
/// triangles, loadable ones, modes; and its step \[s\].
#[unsafe(no_mangle)]
pub extern "C" fn describe(file: usize) -> u32 {
    let module = module();
    let Some(m) = module.stage.file(file).map(|file| file.metadata()) else { return 0 };
    let counts = [m.n_surface_nodes, m.n_load_nodes, m.n_triangles, m.n_load_triangles, m.n_modes];
    let time_step = m.time_step;
    module.give(counts.into_iter().map(f64::from).chain([time_step]));
    1
}

/// Address of the section with this number of file `file`; length in bytes and element code are left in the
/// exchange buffer. Null if it is absent or compressed.
#[unsafe(no_mangle)]
pub extern "C" fn section(file: usize, kind: u32) -> *const u8 {
    let module = module();
    let file = module.stage.file(file);
    let section = file.and_then(|file| file.section(SectionKind::from_number(kind)?));
    let Some(section) = section.filter(|section| section.raw().is_ok()) else { return core::ptr::null() };
    let (stored, element) = (section.stored(), section.element());
    module.give([stored.len() as f64, f64::from(element as u8)]);
    stored.as_ptr()
}

/// Adds a body of file `file` with room for so many contacts. The exchange buffer holds position, quaternion,
/// velocity and angular velocity at the start. Its number, counted from 1.
#[unsafe(no_mangle)]
pub extern "C" fn add_body(file: usize, time_step: f64, contacts: usize) -> u32 {
    let module = module();
    let start = module.start();
    let added = module.stage.add_body(file, time_step, contacts, &start);
    module.told(added.map(|number| number as u32 + 1))
}

/// Adds a rigid body of `n_nodes` nodes and `n_triangles` triangles in lent ranges. The exchange buffer holds
/// its start as in [`add_body`]; then, if `moves` is 1, mass, centre, moments and axes. Its number, counted
/// from 1.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn add_rigid(
    nodes: *const [f64; 3],
    n_nodes: usize,
    triangles: *const [u32; 3],
    n_triangles: usize,
    moves: u32,
) -> u32 {
    let module = module();
    let start = module.start();
    let body = (moves == 1).then(|| RigidBody {
        mass: module.exchange[13],
        centre: module.three(14),
        moments: module.three(17),
        axes: [module.three(20), module.three(23), module.three(26)],
        first_pattern: 0,
    });
    // SAFETY (both): lent for ever.
    let nodes = unsafe { from_raw_parts(nodes, n_nodes) };
    let triangles = unsafe { from_raw_parts(triangles, n_triangles) };
    let added = module.stage.add_rigid(nodes, triangles, body, &start);
    module.told(added.map(|number| number as u32 + 1))
}

/// Adds a pair that may touch; `nodes` are those of both (0), of the first (1) or of the second (2).
#[unsafe(no_mangle)]
pub extern "C" fn add_pair(a: usize, b: usize, friction: f64, restitution: f64, nodes: u32) {
    let nodes = match nodes {
        1 => Nodes::First,
        2 => Nodes::Second,
        _ => Nodes::Both,
    };
    module().stage.add_pair(Touching { members: [a, b], friction, restitution, nodes });
}

/// Adds a joint of kind 0 (ball), 1 (hinge), 2 (slider) or 3 (cable). The exchange buffer holds compliance,
/// force at which it breaks (below 0 for none), length of a cable; and for each side 13 numbers: the number
/// of a port, or −1 with point and axes.
#[unsafe(no_mangle)]
pub extern "C" fn add_joint(kind: u32, a: usize, b: usize) {
    let module = module();
    let [compliance, breaks_at, length, ..] = module.exchange;
    let anchor = |first: usize| match module.exchange.get(first) {
        Some(&port) if port >= 0.0 => Anchor::Frame(port as usize),
        _ => Anchor::Point {
            at: module.three(first + 1),
            axes: [module.three(first + 4), module.three(first + 7), module.three(first + 10)],
        },
    };
    let kind = match kind {
        1 => JointKind::Hinge,
        2 => JointKind::Slider,
        3 => JointKind::Cable { length },
        _ => JointKind::Ball,
    };
    let joint = WorldJoint::new(kind, [a, b], [anchor(3), anchor(16)]);
    let breaks_at = if breaks_at < 0.0 { f64::INFINITY } else { breaks_at };
    module.stage.add_joint(WorldJoint { compliance, breaks_at, ..joint });
}

/// Leads a member over `n_stops` stops in a lent range, instants and displacements; the exchange buffer holds
/// amplitude, frequency and ramp of a shake.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lead(member: usize, stops: *const [f64; 4], n_stops: usize) -> u32 {
    let module = module();
    // SAFETY: lent for ever.
    let stops: &'static [[f64; 4]] =
        if n_stops == 0 { &[] } else { unsafe { from_raw_parts(stops, n_stops) } };
    let [_, _, _, frequency, ramp, ..] = module.exchange;
    let way = Lead { stops, amplitude: module.three(0), frequency, ramp };
    let led = module.stage.lead(member, way);
    module.told(led.map(|()| 1))
}

/// Makes the world. The exchange buffer holds gravity, reach and tolerance (below 0 for those of the
/// evaluator), most sweeps and contacts.
#[unsafe(no_mangle)]
pub extern "C" fn bind(time_step: f64) -> u32 {
    let module = module();
    let [_, _, _, reach, tolerance, sweeps, contacts, ..] = module.exchange;
    let options = WorldOptions {
        gravity: module.three(0),
        reach: (reach >= 0.0).then_some(reach),
        tolerance: (tolerance >= 0.0).then_some(tolerance),
        sweeps: sweeps as usize,
        contacts: contacts as usize,
        ..WorldOptions::default()
    };
    let bound = module.stage.bind(&options, time_step);
    module.told(bound.map(|()| 1))
}

/// Takes so many steps.
#[unsafe(no_mangle)]
pub extern "C" fn step(steps: u32) -> u32 {
    let module = module();
    let stepped = (0..steps).try_for_each(|_| module.stage.step());
    module.told(stepped.map(|()| 1))
}

/// Leaves in the exchange buffer: time \[s\]; contacts of the last step, those that press, those without
/// room; sweeps, whether they converged (1 or 0), deepest overlap \[m\], energy given away \[J\]; joints that
/// broke since the start; kinetic and elastic energy, potential of gravity \[J\].
#[unsafe(no_mangle)]
pub extern "C" fn report() -> u32 {
    let module = module();
    let numbers = || -> Result<[f64; 11], Refusal> {
        let (report, broken) = module.stage.report()?;
        let [energy, potential] = module.stage.energies()?;
        let count = |count: usize| count as f64;
        Ok([
            module.stage.time()?,
            count(report.contacts),
            count(report.pressed),
            count(report.left_out),
            count(report.sweeps),
            f64::from(u8::from(report.converged)),
            report.worst_gap,
            report.energy_given_away,
            count(broken),
            energy,
            potential,
        ])
    };
    match numbers() {
        Ok(numbers) => {
            module.give(numbers);
            1
        }
        Err(refusal) => module.told(Err(refusal)),
    }
}

/// Number of contacts of the last step that carry a force; the answer has nine numbers of each: member of the
/// node and of the surface, place \[m\], force on the node \[N\], normal force \[N\].
#[unsafe(no_mangle)]
pub extern "C" fn touches() -> usize {
    let module = module();
    module.answer.clear();
    let touches = module.stage.touches().unwrap_or_default();
    for touch in touches.iter().filter(|touch| touch.pressure() > 0.0) {
        module.answer.extend(touch.members().map(|member| member as f64));
        module.answer.extend(touch.position());
        module.answer.extend(touch.force());
        module.answer.push(touch.pressure());
    }
    module.answer.len() / 9
}

/// Number of joints; the answer has four numbers of each: the force on the first member \[N\], and 1 of a
/// broken one.
#[unsafe(no_mangle)]
pub extern "C" fn joints() -> usize {
    let module = module();
    module.answer.clear();
    if let Ok(joints) = module.stage.joints() {
        for (force, broken) in joints {
            module.answer.extend(force);
            module.answer.push(f64::from(u8::from(broken)));
        }
    }
    module.answer.len() / 4
}

/// Number of numbers in the answer about the strikes since the last call. Of each: the member, the impulse in
/// space \[N s\], the number of nodes of the place, the nodes, the weights.
#[unsafe(no_mangle)]
pub extern "C" fn strikes() -> usize {
    let module = module();
    module.answer.clear();
    if let Some(strikes) = module.stage.strikes() {
        for strike in strikes.heard() {
            module.answer.push(strike.member as f64);
            module.answer.extend(strike.impulse);
            module.answer.push(strike.place.nodes().len() as f64);
            module.answer.extend(strike.place.nodes().iter().map(|&node| f64::from(node)));
            module.answer.extend(strike.place.weights());
        }
        strikes.taken();
    }
    module.answer.len()
}

/// Number of members; the answer has seven numbers of each: place of the origin in space \[m\], quaternion.
#[unsafe(no_mangle)]
pub extern "C" fn poses() -> usize {
    let module = module();
    module.answer.clear();
    let count = module.stage.members().len();
    for (position, attitude) in (0..count).filter_map(|member| module.stage.pose(member)) {
        module.answer.extend(position);
        module.answer.extend(attitude);
    }
    count
}

/// Mass of a member that moves freely \[kg\]; 0 of any other.
#[unsafe(no_mangle)]
pub extern "C" fn mass(member: usize) -> f64 {
    module().stage.mass(member)
}

/// Writes the nodes of all surfaces in space \[m\], one member after the other, and their displacement
/// (`velocity` 0) or velocity in space (1), three numbers each.
///
/// # Safety
/// The module's documentation; the ranges have `count` nodes, as many as the members together.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surfaces(
    velocity: u32,
    nodes: *mut [f32; 3],
    field: *mut [f32; 3],
    count: usize,
) -> u32 {
    let module = module();
    let shown = if velocity == 0 { Shown::Displacement } else { Shown::Velocity };
    // SAFETY (both): the page lends these ranges for the call.
    let (mut nodes, mut field) =
        unsafe { (from_raw_parts_mut(nodes, count), from_raw_parts_mut(field, count)) };
    for member in 0..module.stage.members().len() {
        let own = module.stage.n_nodes(member).min(nodes.len());
        let (nodes_of, nodes_after) = nodes.split_at_mut(own);
        let (field_of, field_after) = field.split_at_mut(own);
        let written = module.stage.surface_into(member, shown, &mut module.work, nodes_of, field_of);
        if let Err(refusal) = written {
            return module.told(Err(refusal));
        }
        (nodes, field) = (nodes_after, field_after);
    }
    1
}

/// Lays hand `hand` on a member, or lays it anew. The exchange buffer holds the place of `count` nodes (room
/// for 16 nodes, room for 16 weights), or, where `count` is 0, a point of a rigid body; from number 40 on
/// target, stiffness and damping.
#[unsafe(no_mangle)]
pub extern "C" fn pull(hand: u32, member: usize, count: usize) -> u32 {
    let module = module();
    let place = || -> Result<Place, PlaceError> {
        let [nodes, weights, ..] = module.exchange.as_chunks::<MAX_PLACE_NODES>().0 else {
            return Err(PlaceError::Empty);
        };
        let nodes = nodes.map(|node| node as u32);
        let listed = nodes.get(..count).zip(weights.get(..count));
        let (nodes, weights) = listed.ok_or(PlaceError::TooManyNodes { found: count })?;
        Place::new(nodes, weights)
    };
    let grip = if count == 0 { Ok(Grip::Point(module.three(0))) } else { place().map(Grip::Place) };
    let (target, [stiffness, damping, _]) = (module.three(HAND), module.three(HAND + 3));
    let laid = grip.map_err(|error| Refusal::from(LoadError::Place(error))).and_then(|grip| {
        let hold = Pull { member, grip, target, stiffness, damping, force: [0.0; 3] };
        module.stage.pull(hand, hold)
    });
    module.told(laid.map(|()| 1))
}

/// Moves a hand. 0 if there is none of this number.
#[unsafe(no_mangle)]
pub extern "C" fn move_pull(hand: u32, x: f64, y: f64, z: f64) -> u32 {
    module().stage.move_pull(hand, [x, y, z]).map_or(0, |()| 1)
}

/// Takes a hand away.
#[unsafe(no_mangle)]
pub extern "C" fn release(hand: u32) {
    module().stage.release(hand);
}

/// Number of hands; the answer has eleven numbers of each: its number, the member, where it holds \[m\],
/// where it is \[m\], its force \[N\].
#[unsafe(no_mangle)]
pub extern "C" fn pulls() -> usize {
    let module = module();
    module.answer.clear();
    for (hand, pull) in module.stage.pulls() {
        let held = module.stage.members().get(pull.member).and_then(|member| pull.at(member).ok());
        module.answer.extend([f64::from(*hand), pull.member as f64]);
        module.answer.extend(held.unwrap_or(pull.target));
        module.answer.extend(pull.target.into_iter().chain(pull.force));
    }
    module.answer.len() / 11
}

/// Throws a member from where it is; the exchange buffer holds velocity \[m/s\] and angular velocity
/// \[rad/s\].
#[unsafe(no_mangle)]
pub extern "C" fn throw(member: usize) -> u32 {
    let module = module();
    let thrown = module.stage.throw(member, module.three(0), module.three(3));
    module.told(thrown.map(|()| 1))
}

/// Breaks a joint.
#[unsafe(no_mangle)]
pub extern "C" fn break_joint(joint: usize) -> u32 {
    let module = module();
    let broken = module.stage.break_joint(joint);
    module.told(broken.map(|()| 1))
}

/// Sets the acceleration of gravity \[m/s²\].
#[unsafe(no_mangle)]
pub extern "C" fn set_gravity(x: f64, y: f64, z: f64) -> u32 {
    let module = module();
    let set = module.stage.set_gravity([x, y, z]);
    module.told(set.map(|()| 1))
}

/// Saves the state; its length in [`bytes`], 0 if refused.
#[unsafe(no_mangle)]
pub extern "C" fn save() -> u32 {
    let module = module();
    let saved = module.stage.save_into(&mut module.bytes).map(|()| module.bytes.len() as u32);
    module.told(saved)
}

/// Takes back what [`save`] gave, from the range of `n` bytes.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn restore(at: *const u8, n: usize) -> u32 {
    let module = module();
    // SAFETY: the page lends this range for the call.
    let restored = module.stage.restore(unsafe { from_raw_parts(at, n) });
    module.told(restored.map(|()| 1))
}

/// Starts over.
#[unsafe(no_mangle)]
pub extern "C" fn reset() -> u32 {
    let module = module();
    let done = module.stage.reset();
    module.told(done.map(|()| 1))
}
