//! The exports. Numbers go in as arguments; what comes back in several numbers is left in [`exchange`],
//! sentences in [`message_at`]. `1` means done and `0` refused (then the message says why), if nothing else
//! is said.
//!
//! The one place of the crate with `unsafe`: it trusts the page for what no language can check across this
//! boundary, that lent ranges lie inside the module's memory, do not overlap, and stay untouched for as long
//! as they are lent (the file for ever, a session's memory until the next [`bind`]). A page that breaks this
//! harms its own module's memory and nothing else.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;
use core::panic::PanicInfo;
use core::slice::{from_raw_parts, from_raw_parts_mut};

use vademecum_eval::format::{File, MAX_REGIONS, Metadata, ParameterRole};
use vademecum_eval::{
    Contact, Field, Place, Quantity, RegionScales, SceneOptions, Status, StructureChoice, SurfacePoint,
};

use crate::message::Message;
use crate::refusal::Refusal;
use crate::session::{Player, Session, Watch, lengths, locate as nearest, plain_section};
use crate::tool::{MOST_PLACES, Sphere};

/// Numbers in the exchange buffer.
const EXCHANGE: usize = 64;

/// Everything the module remembers.
struct Module {
    file: Option<File<'static>>,
    bound: Bound,
    exchange: [f64; EXCHANGE],
    message: Message,
}

/// A session of either precision.
enum Bound {
    Nothing,
    Single(Session<'static, f32>),
    Double(Session<'static, f64>),
}

struct Global(UnsafeCell<Module>);

// SAFETY: the module is built without threads, so nothing is ever shared between them.
unsafe impl Sync for Global {}

static MODULE: Global = Global(UnsafeCell::new(Module {
    file: None,
    bound: Bound::Nothing,
    exchange: [0.0; EXCHANGE],
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
    /// Puts `numbers` into the exchange buffer, from its start.
    fn give(&mut self, numbers: impl IntoIterator<Item = f64>) {
        self.exchange.iter_mut().zip(numbers).for_each(|(place, x)| *place = x);
    }

    fn player(&mut self) -> Option<&mut dyn Player> {
        match &mut self.bound {
            Bound::Nothing => None,
            Bound::Single(session) => Some(session),
            Bound::Double(session) => Some(session),
        }
    }

    /// Runs `ask` on the session; 0 without one or if it refuses.
    fn ask(&mut self, ask: impl FnOnce(&mut dyn Player) -> Result<u32, Refusal>) -> u32 {
        let result = self.player().map_or(Ok(0), ask);
        result.unwrap_or_else(|refusal| {
            self.message.say(&refusal);
            0
        })
    }
}

/// Where the exchange buffer lies.
#[unsafe(no_mangle)]
pub extern "C" fn exchange() -> *const f64 {
    module().exchange.as_ptr()
}

/// Where the last refusal's sentence lies.
#[unsafe(no_mangle)]
pub extern "C" fn message_at() -> *const u8 {
    module().message.bytes().as_ptr()
}

/// Its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn message_len() -> usize {
    module().message.bytes().len()
}

/// Opens the file in the lent range and compares every section with its checksum.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn open(at: *const u8, length: usize) -> u32 {
    let module = module();
    module.bound = Bound::Nothing;
    // SAFETY: lent for ever.
    let bytes: &'static [u8] = unsafe { from_raw_parts(at, length) };
    match File::parse(bytes).and_then(|file| file.verify_all().map(|()| file)) {
        Ok(file) => {
            module.file = Some(file);
            1
        }
        Err(error) => {
            module.file = None;
            module.message.say(&error);
            0
        }
    }
}

/// Leaves the file's counts and figures in the exchange buffer, in this order.
#[unsafe(no_mangle)]
pub extern "C" fn describe() -> u32 {
    let module = module();
    let Some(file) = &module.file else { return 0 };
    let m: &Metadata<'static> = file.metadata();
    let counts = [
        m.n_nodes,
        m.n_surface_nodes,
        m.n_load_nodes,
        m.n_triangles,
        m.n_load_triangles,
        m.n_modes,
        m.n_patterns,
        m.n_probes,
        m.n_terms,
        u32::from(m.diagonal),
        u32::from(m.block),
        m.n_parameters,
    ];
    let (d, b) = (&m.certificate.diagonal, &m.certificate.block);
    let figures = [
        m.time_step,
        m.alpha,
        m.beta,
        d.trajectory_error,
        d.projection_floor,
        b.trajectory_error,
        b.projection_floor,
    ];
    let (counts, figures) = (counts.map(f64::from), figures);
    module.give(counts.into_iter().chain(figures));
    1
}

/// Where text 0 (program), 1 (problem), 2 (units) or 3 (scheme) lies; its length is left in the exchange
/// buffer.
#[unsafe(no_mangle)]
pub extern "C" fn text(which: u32) -> *const u8 {
    let module = module();
    let Some(file) = &module.file else { return core::ptr::null() };
    let m = file.metadata();
    let text = match which {
        0 => m.program,
        1 => m.problem,
        2 => m.units,
        _ => m.scheme_name,
    };
    module.give([text.len() as f64]);
    text.as_ptr()
}

/// Where the section with this number lies; length in bytes and element code are left in the exchange buffer.
/// Null if it is absent or compressed.
#[unsafe(no_mangle)]
pub extern "C" fn section(kind: u32) -> *const u8 {
    let module = module();
    let Some(section) = module.file.as_ref().and_then(|file| plain_section(file, kind)) else {
        return core::ptr::null();
    };
    module.give([section.stored().len() as f64, f64::from(section.element() as u8)]);
    section.stored().as_ptr()
}

/// Leaves what parameter `index` of the file says in the exchange buffer: places and lengths of its name and
/// unit, its role (0 stiffness, 1 a region's stiffness, 2 density, 3 a region's density, 4 `α`, 5 `β`, 6
/// `Δt`), the region, whether it is walked in the logarithm, its range and its nominal value. 0 if there is
/// none or its role is not known here.
#[unsafe(no_mangle)]
pub extern "C" fn parameter(index: usize) -> u32 {
    use ParameterRole as R;
    let module = module();
    let parameter =
        module.file.as_ref().and_then(|file| file.metadata().active_parameters().get(index).copied());
    let Some(p) = parameter else { return 0 };
    let (role, region) = match p.role {
        R::Stiffness => (0, 0),
        R::RegionStiffness { region } => (1, region),
        R::Density => (2, 0),
        R::RegionDensity { region } => (3, region),
        R::Alpha => (4, 0),
        R::Beta => (5, 0),
        R::TimeStep => (6, 0),
        _ => return 0,
    };
    let text = |text: &str| [text.as_ptr() as usize as f64, text.len() as f64];
    let numbers =
        [f64::from(role), f64::from(region), f64::from(u32::from(p.log)), p.lower, p.upper, p.nominal];
    module.give(text(p.name).into_iter().chain(text(p.unit)).chain(numbers));
    1
}

/// Leaves the row of scalar `index` of the whole body in the exchange buffer: places and lengths of its name,
/// its unit and a line about it. 0 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn total(index: usize) -> u32 {
    let Some(quantity) = Quantity::totals().nth(index) else { return 0 };
    let text = |text: &str| [text.as_ptr() as usize as f64, text.len() as f64];
    let unit = quantity.unit(Field::Displacement).unwrap_or_default();
    module().give([quantity.name(), unit, quantity.text()].into_iter().flat_map(text));
    1
}

/// The exchange buffer as options: structure (0 chosen, 1 diagonal, 2 block, 4 exact), `Δt` \[s\], scales of
/// stiffness and density, `α` \[1/s\], `β` \[s\], rest threshold \[m kg^½\], then the scales of each region's
/// stiffness and of each region's density, 8 and 8.
fn options(numbers: &[f64; EXCHANGE]) -> SceneOptions {
    let [structure, time_step, stiffness, density, alpha, beta, rest_below, regions @ ..] = *numbers;
    let mut scales = RegionScales::ONE;
    for (region, &number) in (0..).zip(regions.iter().take(2 * MAX_REGIONS)) {
        let count = MAX_REGIONS as u32;
        // Their numbers are within what there may be.
        let _ = match u32::checked_sub(region, count) {
            None => scales.set_stiffness(region, number),
            Some(region) => scales.set_density(region, number),
        };
    }
    let structure = match structure as u32 {
        1 => StructureChoice::Diagonal,
        2 => StructureChoice::Block,
        4 => StructureChoice::Exact,
        _ => StructureChoice::Auto,
    };
    SceneOptions {
        structure,
        time_step: Some(time_step),
        stiffness,
        density,
        regions: scales,
        alpha: Some(alpha),
        beta: Some(beta),
        rest_below,
        ..SceneOptions::default()
    }
}

/// Bytes to lend for a session with the options in the exchange buffer; 0 if they are refused.
#[unsafe(no_mangle)]
pub extern "C" fn bind_len(double: u32) -> usize {
    let module = module();
    let Some(file) = &module.file else { return 0 };
    let options = options(&module.exchange);
    let lengths = if double == 0 { lengths::<f32>(file, &options) } else { lengths::<f64>(file, &options) };
    match lengths {
        Ok((body, field)) => 8 * (body + field),
        Err(refusal) => {
            module.message.say(&refusal);
            0
        }
    }
}

/// Binds a session with the options in the exchange buffer. The range is aligned to 8 bytes and holds
/// [`bind_len`] bytes. The session before it ends, whether this is refused or not.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bind(double: u32, at: *mut u8) -> u32 {
    let module = module();
    module.bound = Bound::Nothing;
    let Some(file) = &module.file else { return 0 };
    let options = options(&module.exchange);
    // SAFETY (both): the range holds `bind_len` bytes, 8 for each number of the body and of its field.
    let bound = if double == 0 {
        lengths::<f32>(file, &options).and_then(|(body, field)| {
            let (field, memory) = unsafe { split(at, field, body) };
            Session::<f32>::bind(file, &options, memory, field).map(Bound::Single)
        })
    } else {
        lengths::<f64>(file, &options).and_then(|(body, field)| {
            let (field, memory) = unsafe { split(at, field, body) };
            Session::<f64>::bind(file, &options, memory, field).map(Bound::Double)
        })
    };
    match bound {
        Ok(bound) => {
            module.bound = bound;
            module.ask(|player| Ok(player.structure()))
        }
        Err(refusal) => {
            module.message.say(&refusal);
            0
        }
    }
}

/// Numbers of a field and of a body in one range, 8 bytes each, set to zero.
///
/// # Safety
/// The range is lent and holds `8 (n + body)` bytes, aligned to 8.
unsafe fn split<T>(at: *mut u8, n: usize, body: usize) -> (&'static mut [T], &'static mut [f64]) {
    // SAFETY: the caller's promise; zero bytes are the number 0 in both precisions.
    unsafe {
        at.write_bytes(0, 8 * (n + body));
        (from_raw_parts_mut(at.cast::<T>(), n), from_raw_parts_mut(at.add(8 * n).cast::<f64>(), body))
    }
}

/// Takes all loads away.
#[unsafe(no_mangle)]
pub extern "C" fn clear_loads() -> u32 {
    module().ask(|player| {
        player.clear_loads();
        Ok(1)
    })
}

fn point_of(nodes: [u32; 3], weights: [f64; 3]) -> SurfacePoint {
    SurfacePoint { place: Place::triangle(nodes, weights), position: [0.0; 3], distance: 0.0 }
}

/// Adds a held contact: nodes, weights (the third completes 1), force \[N\].
#[unsafe(no_mangle)]
pub extern "C" fn add_contact(a: u32, b: u32, c: u32, wa: f64, wb: f64, fx: f64, fy: f64, fz: f64) -> u32 {
    let contact = Contact::new(Place::triangle([a, b, c], [wa, wb, 1.0 - wa - wb]), [fx, fy, fz]);
    module().ask(|player| player.add_contact(&contact).map(|()| 1))
}

/// Adds a held load pattern.
#[unsafe(no_mangle)]
pub extern "C" fn add_pattern(index: u32, amplitude: f64) -> u32 {
    module().ask(|player| player.add_pattern(index as usize, amplitude).map(|()| 1))
}

/// Records this displacement component beside the probes: nodes, weights (the third completes 1), unit
/// vector.
#[unsafe(no_mangle)]
pub extern "C" fn watch(a: u32, b: u32, c: u32, wa: f64, wb: f64, x: f64, y: f64, z: f64) -> u32 {
    let watch = Watch { point: point_of([a, b, c], [wa, wb, 1.0 - wa - wb]), direction: [x, y, z] };
    module().ask(|player| {
        player.watch(Some(watch));
        Ok(1)
    })
}

/// Numbers of one record of [`march`].
#[unsafe(no_mangle)]
pub extern "C" fn record_len() -> u32 {
    module().ask(|player| Ok(player.record_len() as u32))
}

/// Takes `steps` steps and writes a record after each, up to `rows` of them. 1 moving, 2 at rest, 0 refused.
///
/// # Safety
/// The module's documentation; the range holds `rows` records.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn march(steps: u32, records: *mut f64, rows: u32) -> u32 {
    module().ask(|player| {
        let length = rows as usize * player.record_len();
        // SAFETY: the page lends this range for the call; an empty one may lie anywhere.
        let records = if length == 0 { &mut [] } else { unsafe { from_raw_parts_mut(records, length) } };
        Ok(match player.march(steps as usize, records)? {
            Status::AtRest => 2,
            _ => 1,
        })
    })
}

const fn field(velocity: u32) -> Field {
    if velocity == 0 { Field::Displacement } else { Field::Velocity }
}

/// Where the displacement (or velocity) of the surface lies, in the session's precision; null if refused.
#[unsafe(no_mangle)]
pub extern "C" fn surface(velocity: u32) -> usize {
    module().ask(|player| Ok(player.surface(field(velocity))? as usize as u32)) as usize
}

/// Where von Mises' equivalent stress of the surface lies, in the session's precision: the first of three
/// numbers a node, zero where the file has none; null if refused.
#[unsafe(no_mangle)]
pub extern "C" fn equivalent_stress() -> usize {
    module().ask(|player| Ok(player.equivalent_stress()? as usize as u32)) as usize
}

/// Leaves displacement (or velocity) of a point of the surface in the exchange buffer.
#[unsafe(no_mangle)]
pub extern "C" fn point(a: u32, b: u32, c: u32, wa: f64, wb: f64, velocity: u32) -> u32 {
    let module = module();
    let point = point_of([a, b, c], [wa, wb, 1.0 - wa - wb]);
    let mut value = [0.0; 3];
    let done = module.ask(|player| {
        value = player.point(&point, field(velocity))?;
        Ok(1)
    });
    module.give(value);
    done
}

/// Leaves the loadable point nearest to (x, y, z) in the exchange buffer: nodes, weights, position, distance.
/// 0 if none.
#[unsafe(no_mangle)]
pub extern "C" fn locate(x: f64, y: f64, z: f64) -> u32 {
    let module = module();
    let Some(file) = &module.file else { return 0 };
    match nearest(file, [x, y, z]) {
        Ok(Some(p)) => {
            let (nodes, weights) = p.place.corners().unwrap_or_default();
            let nodes = nodes.map(f64::from);
            module.give(nodes.into_iter().chain(weights).chain(p.position).chain([p.distance]));
            1
        }
        Ok(None) => 0,
        Err(refusal) => {
            module.message.say(&refusal);
            0
        }
    }
}

/// Energy \[J\]; 0 without a session.
#[unsafe(no_mangle)]
pub extern "C" fn energy() -> f64 {
    let mut energy = 0.0;
    module().ask(|player| {
        energy = player.energy()?;
        Ok(1)
    });
    energy
}

/// Writes `ζ` and `ζ̇` to the range, `n` numbers in all.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coordinates(at: *mut f64, n: usize) -> u32 {
    module().ask(|player| {
        // SAFETY: the page lends this range for the call.
        player.coordinates(unsafe { from_raw_parts_mut(at, n) });
        Ok(1)
    })
}

/// Sets `ζ` and `ζ̇` from the range, `n` numbers in all.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn set_coordinates(at: *const f64, n: usize) -> u32 {
    // SAFETY: the page lends this range for the call.
    module().ask(|player| player.set_coordinates(unsafe { from_raw_parts(at, n) }).map(|()| 1))
}

/// The body at rest, loads kept.
#[unsafe(no_mangle)]
pub extern "C" fn rest() -> u32 {
    module().ask(|player| {
        player.rest();
        Ok(1)
    })
}

/// Lays down a sphere that cannot enter the body: radius \[m\], friction, how fast \[m/s\] and how hard \[N\]
/// it follows at most, and where its centre is \[m\]. It presses from the next step on. Refused unless the
/// session's steps are exact. A new session has none.
#[unsafe(no_mangle)]
pub extern "C" fn hold_tool(
    radius: f64,
    friction: f64,
    speed: f64,
    most: f64,
    x: f64,
    y: f64,
    z: f64,
) -> u32 {
    let sphere = Sphere { radius, friction, speed, most, centre: [x, y, z], target: [x, y, z] };
    module().ask(|player| player.hold(Some(sphere)).map(|()| 1))
}

/// Where the sphere is to go \[m\]; it starts with the next step. 0 without a sphere.
#[unsafe(no_mangle)]
pub extern "C" fn move_tool(x: f64, y: f64, z: f64) -> u32 {
    module().ask(|player| {
        let target = [x, y, z];
        let tool = player.tool().filter(|_| target.iter().all(|x| x.is_finite()));
        Ok(tool.map_or(0, |tool| {
            tool.sphere.target = target;
            1
        }))
    })
}

/// Takes the sphere away.
#[unsafe(no_mangle)]
pub extern "C" fn lift_tool() -> u32 {
    module().ask(|player| player.hold(None).map(|()| 1))
}

/// Leaves in the exchange buffer what the sphere did in the last step: its centre \[m\], the deepest place of
/// the body inside of it \[m\] (below zero for a gap), whether all forces were found (1 or 0), how many
/// places were pushed, and for each of these where it is \[m\] and the force on the body \[N\]. 0 without a
/// sphere.
#[unsafe(no_mangle)]
pub extern "C" fn tool() -> u32 {
    let module = module();
    let (mut head, mut touches, mut count) = ([0.0; 6], [0.0; 6 * MOST_PLACES], 0);
    let done = module.ask(|player| {
        let Some(tool) = player.tool() else { return Ok(0) };
        let pushed = tool.touches().iter().filter(|touch| touch.force != [0.0; 3]);
        for (out, touch) in touches.as_chunks_mut::<6>().0.iter_mut().zip(pushed) {
            let [x, y, z] = touch.place;
            let [fx, fy, fz] = touch.force;
            *out = [x, y, z, fx, fy, fz];
            count += 1;
        }
        let [x, y, z] = tool.sphere.centre;
        head = [x, y, z, tool.deepest(), f64::from(u32::from(tool.is_solved())), f64::from(count)];
        Ok(1)
    });
    module.give(head.into_iter().chain(touches));
    done
}
