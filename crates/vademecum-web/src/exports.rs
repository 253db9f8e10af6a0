//! The exports. Numbers go in as arguments; what comes back in several numbers is left in [`exchange`],
//! sentences in [`message_at`]. `1` means done and `0` refused (then the message says why), if nothing else
//! is said.
//!
//! The one place of the crate with `unsafe`: it trusts the page for what no language can check across this
//! boundary, that lent ranges lie inside the module's memory, do not overlap, and stay untouched for as long
//! as they are lent (the file for ever, a body's memory until the next [`bind`]). A page that breaks this
//! harms its own module's memory and nothing else.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;
use core::panic::PanicInfo;
use core::slice::{from_raw_parts, from_raw_parts_mut};

use vademecum_eval::format::{File, MAX_LIVE, MAX_REGIONS, Metadata, ParameterRole, SectionKind};
use vademecum_eval::{
    AnyBody, Field, LiveMemory, LoadError, LoadsAfter, MAX_PLACE_NODES, OutputError, Parametric, Place,
    PlaceError, Precision, Quantity, RegionScales, Restored, SceneOptions, Status, Structure,
    StructureChoice,
};

use crate::message::Message;
use crate::refusal::Refusal;
use crate::tool::{MAX_PLACES, Sphere, Tool, body_options};

/// Numbers in the exchange buffer: number and value of each parameter.
const EXCHANGE: usize = 2 * MAX_LIVE;

/// Everything the module remembers.
struct Module {
    file: Option<File<'static>>,
    bound: Option<Bound>,
    exchange: [f64; EXCHANGE],
    message: Message,
}

/// A body, and what a page has beside it.
struct Bound {
    body: AnyBody<'static>,
    /// Memory of a parametric file, whose body is replaced when parameters are set.
    live: Option<LiveMemory<'static>>,
    /// A field of the surface, in the precision of the body.
    field: &'static mut [f64],
    /// A displacement component that is recorded beside the probes: place and unit vector.
    watch: Option<(Place, [f64; 3])>,
    tool: Option<Tool<'static>>,
}

impl Bound {
    /// One step, with the tool where there is one.
    fn step(&mut self) -> Result<Status, Refusal> {
        match &mut self.tool {
            Some(tool) => tool.step(&mut self.body),
            None => Ok(self.body.step()?),
        }
    }

    /// The scalar `index` of a quantity.
    fn scalar(&self, quantity: Quantity, index: usize) -> Result<f64, OutputError> {
        let mut value = [0.0];
        self.body.read(quantity, index, Field::Displacement, &mut value)?;
        Ok(value[0])
    }

    /// Numbers of one record of [`march`].
    fn record_len(&self) -> usize {
        self.body.count(Quantity::Probe) + 1 + Quantity::totals().count()
    }

    fn record(&self, row: &mut [f64]) -> Result<(), Refusal> {
        let n_probes = self.body.count(Quantity::Probe);
        let Some((probes, [watched, totals @ ..])) = row.split_at_mut_checked(n_probes) else {
            return Ok(());
        };
        for (index, out) in probes.iter_mut().enumerate() {
            *out = self.scalar(Quantity::Probe, index)?;
        }
        *watched = match &self.watch {
            None => 0.0,
            Some((place, direction)) => {
                let u = self.body.point(place, Field::Displacement)?;
                u.iter().zip(direction).map(|(u, d)| u * d).sum()
            }
        };
        for (quantity, out) in Quantity::totals().zip(totals) {
            *out = self.scalar(quantity, 0)?;
        }
        Ok(())
    }
}

struct Global(UnsafeCell<Module>);

// SAFETY: the module is built without threads, so nothing is ever shared between them.
unsafe impl Sync for Global {}

static MODULE: Global = Global(UnsafeCell::new(Module {
    file: None,
    bound: None,
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

    /// Runs `ask` on the body; 0 without one or if it refuses.
    fn ask(&mut self, ask: impl FnOnce(&mut Bound) -> Result<u32, Refusal>) -> u32 {
        let result = self.bound.as_mut().map_or(Ok(0), ask);
        result.unwrap_or_else(|refusal| {
            self.message.say(&refusal);
            0
        })
    }
}

/// Address of the exchange buffer.
#[unsafe(no_mangle)]
pub extern "C" fn exchange() -> *const f64 {
    module().exchange.as_ptr()
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

/// Opens the file in the lent range and compares every section with its checksum.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn open(at: *const u8, length: usize) -> u32 {
    let module = module();
    module.bound = None;
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
    let model = Parametric::new(file).ok();
    let modes = model.map_or(m.n_modes, |model| model.usual_modes() as u32);
    let counts = [
        m.n_nodes,
        m.n_surface_nodes,
        m.n_load_nodes,
        m.n_triangles,
        m.n_load_triangles,
        modes,
        m.n_patterns,
        m.n_probes,
        m.n_terms,
        u32::from(m.diagonal),
        u32::from(m.block),
        file.parameters().count() as u32,
    ];
    let (d, b) = (&m.certificate.diagonal, &m.certificate.block);
    let parametric = f64::from(u32::from(model.is_some()));
    let figures = [
        m.time_step,
        m.alpha,
        m.beta,
        d.trajectory_error,
        d.projection_floor,
        b.trajectory_error,
        b.projection_floor,
        parametric,
    ];
    let (counts, figures) = (counts.map(f64::from), figures);
    module.give(counts.into_iter().chain(figures));
    1
}

/// Address of text 0 (program), 1 (problem), 2 (units) or 3 (scheme); its length is left in the exchange
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

/// Address of the section with this number; length in bytes and element code are left in the exchange buffer.
/// Null if it is absent or compressed.
#[unsafe(no_mangle)]
pub extern "C" fn section(kind: u32) -> *const u8 {
    let module = module();
    let bound = module.bound.as_ref().filter(|bound| bound.live.is_some());
    let file = bound.map(|bound| bound.body.file()).or(module.file.as_ref());
    let section = file.and_then(|file| file.section(SectionKind::from_number(kind)?));
    let Some(section) = section.filter(|section| section.raw().is_ok()) else { return core::ptr::null() };
    module.give([section.stored().len() as f64, f64::from(section.element() as u8)]);
    section.stored().as_ptr()
}

/// Leaves what parameter `index` of the file says in the exchange buffer: places and lengths of its name and
/// unit, its role (0 stiffness, 1 a region's stiffness, 2 density, 3 a region's density, 4 `α`, 5 `β`, 6
/// `Δt`, 7 a region's loss factor, 8 dashpots), the region or group, whether it is walked in the logarithm,
/// its range and its nominal value. 0 if there is none or its role is not known here.
#[unsafe(no_mangle)]
pub extern "C" fn parameter(index: usize) -> u32 {
    use ParameterRole as R;
    let module = module();
    let parameter = module.file.as_ref().and_then(|file| file.parameters().nth(index));
    let Some(p) = parameter else { return 0 };
    let (role, region) = match p.role {
        R::Stiffness => (0, 0),
        R::RegionStiffness { region } => (1, region),
        R::Density => (2, 0),
        R::RegionDensity { region } => (3, region),
        R::Alpha => (4, 0),
        R::Beta => (5, 0),
        R::TimeStep => (6, 0),
        R::LossFactor { region } => (7, region),
        R::Damping { group } => (8, group),
        _ => return 0,
    };
    let text = |text: &str| [text.as_ptr() as usize as f64, text.len() as f64];
    let numbers =
        [f64::from(role), f64::from(region), f64::from(u32::from(p.log)), p.lower, p.upper, p.nominal];
    module.give(text(p.name).into_iter().chain(text(p.unit)).chain(numbers));
    1
}

/// Leaves the row of a quantity of the evaluator's table in the exchange buffer: places and lengths of its
/// name, its unit, the unit of its velocity (empty where it has none) and a line about it; how many the bound
/// body has and numbers of each (0 without a body); whether it is a scalar of the whole body, which
/// [`march`] records. 0 if there is no quantity of this number: they are numbered from 0.
#[unsafe(no_mangle)]
pub extern "C" fn quantity(number: u32) -> u32 {
    let module = module();
    let Some(quantity) = Quantity::from_number(number) else { return 0 };
    let unit = |field| quantity.unit(field).unwrap_or_default();
    let texts = [quantity.name(), unit(Field::Displacement), unit(Field::Velocity), quantity.text()];
    let text = |text: &str| [text.as_ptr() as usize as f64, text.len() as f64];
    let sizes = |bound: &Bound| [bound.body.count(quantity) as f64, bound.body.length(quantity) as f64];
    let sizes = module.bound.as_ref().map_or([0.0; 2], sizes);
    let total = f64::from(u32::from(Quantity::totals().any(|total| total == quantity)));
    module.give(texts.into_iter().flat_map(text).chain(sizes).chain([total]));
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

const fn precision(double: u32) -> Precision {
    if double == 0 { Precision::Single } else { Precision::Double }
}

/// Numbers of a body, and of a field of its surface.
fn lengths(file: &File<'_>, options: SceneOptions, double: u32) -> Result<[usize; 2], Refusal> {
    let body = LiveMemory::any_len(file, &body_options(options), precision(double))?;
    Ok([body, 3 * file.metadata().n_surface_nodes as usize])
}

/// Bytes to lend for a body with the options in the exchange buffer; 0 if they are refused.
#[unsafe(no_mangle)]
pub extern "C" fn bind_len(double: u32) -> usize {
    let module = module();
    let Some(file) = &module.file else { return 0 };
    match lengths(file, options(&module.exchange), double) {
        Ok([body, field]) => 8 * (body + field),
        Err(refusal) => {
            module.message.say(&refusal);
            0
        }
    }
}

/// Binds a body with the options in the exchange buffer: 1 for the diagonal structure, 2 for the block
/// structure, 4 for exact steps, 5 for large displacements. The range is aligned to 8 bytes and holds
/// [`bind_len`] bytes. The body before it ends, whether this is refused or not.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bind(double: u32, at: *mut f64) -> u32 {
    let module = module();
    module.bound = None;
    let Some(file) = &module.file else { return 0 };
    let options = options(&module.exchange);
    let bound = lengths(file, options, double).and_then(|[body, field]| {
        // SAFETY (both): the range holds `bind_len` bytes, 8 for each of these numbers.
        let memory = unsafe { from_raw_parts_mut(at, body) };
        let field = unsafe { from_raw_parts_mut(at.add(body), field) };
        let (live, body) = LiveMemory::bind_any(file, &body_options(options), precision(double), memory)?;
        Ok(Bound { body, live, field, watch: None, tool: None })
    });
    match bound {
        Ok(bound) => {
            let structure = match bound.body.structure() {
                Structure::Diagonal => 1,
                Structure::Block => 2,
                Structure::Exact => 4,
                Structure::Strain => 5,
            };
            module.bound = Some(bound);
            structure
        }
        Err(refusal) => {
            module.message.say(&refusal);
            0
        }
    }
}

/// Sets `n` parameters of the file, pairs of number and value in the exchange buffer; the motion is carried
/// over. 1 without loads; 2 with loads, which are then to be cleared and added again.
#[unsafe(no_mangle)]
pub extern "C" fn set_parameters(n: usize) -> u32 {
    let module = module();
    let mut settings = [(0, 0.0); EXCHANGE / 2];
    let pairs = module.exchange.as_chunks::<2>().0;
    settings.iter_mut().zip(pairs).for_each(|(setting, &[index, value])| *setting = (index as usize, value));
    module.ask(|bound| {
        let settings = settings.get(..n).unwrap_or_default();
        let after = match &mut bound.live {
            // SAFETY: the body is that of this memory, and places that are kept borrow nothing from it.
            Some(live) => unsafe { live.set_any(settings, &mut bound.body)? },
            None => bound.body.set_parameters(settings)?,
        };
        Ok(match after {
            LoadsAfter::Empty => 1,
            LoadsAfter::Stale => 2,
        })
    })
}

/// Takes all loads away.
#[unsafe(no_mangle)]
pub extern "C" fn clear() -> u32 {
    module().ask(|bound| {
        bound.body.clear();
        Ok(1)
    })
}

/// The exchange buffer as a place of `count` nodes: room for 16 nodes, room for 16 weights, the radius \[m\].
fn place(numbers: &[f64; EXCHANGE], count: usize) -> Result<Place, PlaceError> {
    let [nodes, weights, [radius, ..], ..] = numbers.as_chunks::<MAX_PLACE_NODES>().0 else {
        return Err(PlaceError::Empty);
    };
    let nodes = nodes.map(|node| node as u32);
    let listed = nodes.get(..count).zip(weights.get(..count));
    let (nodes, weights) = listed.ok_or(PlaceError::TooManyNodes { found: count })?;
    Ok(Place::new(nodes, weights)?.with_radius(*radius))
}

/// Adds a held force \[N\] at the place of `count` nodes in the exchange buffer: room for 16 nodes, room for
/// 16 weights, the radius \[m\].
#[unsafe(no_mangle)]
pub extern "C" fn push(count: usize, x: f64, y: f64, z: f64) -> u32 {
    let module = module();
    let place = place(&module.exchange, count).map_err(LoadError::Place);
    module.ask(|bound| {
        bound.body.push(&place?, [x, y, z])?;
        Ok(1)
    })
}

/// Adds a held load pattern.
#[unsafe(no_mangle)]
pub extern "C" fn push_pattern(index: usize, amplitude: f64) -> u32 {
    module().ask(|bound| {
        bound.body.push_pattern(index, amplitude)?;
        Ok(1)
    })
}

/// Records the displacement component of a place, as in [`push`], along a unit vector beside the probes.
#[unsafe(no_mangle)]
pub extern "C" fn watch(count: usize, x: f64, y: f64, z: f64) -> u32 {
    let module = module();
    let place = place(&module.exchange, count).map_err(OutputError::Place);
    module.ask(|bound| {
        bound.watch = Some((place?, [x, y, z]));
        Ok(1)
    })
}

/// Numbers of one record of [`march`]: the probes, the watched component (0 without), and the scalars of the
/// whole body.
#[unsafe(no_mangle)]
pub extern "C" fn record_len() -> u32 {
    module().ask(|bound| Ok(bound.record_len() as u32))
}

/// Takes `steps` steps and writes a record after each, up to `rows` of them. 1 moving, 2 at rest, 0 refused.
///
/// # Safety
/// The module's documentation; the range holds `rows` records.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn march(steps: u32, records: *mut f64, rows: u32) -> u32 {
    module().ask(|bound| {
        let width = bound.record_len();
        let length = rows as usize * width;
        // SAFETY: the page lends this range for the call; an empty one may lie anywhere.
        let records = if length == 0 { &mut [] } else { unsafe { from_raw_parts_mut(records, length) } };
        let mut rows = records.chunks_exact_mut(width);
        let mut status = Status::Moving;
        for _ in 0..steps {
            status = bound.step()?;
            if let Some(row) = rows.next() {
                bound.record(row)?;
            }
        }
        Ok(if status == Status::AtRest { 2 } else { 1 })
    })
}

const fn field(velocity: u32) -> Field {
    if velocity == 0 { Field::Displacement } else { Field::Velocity }
}

/// Address of the displacement (or velocity) of the surface, in the precision of the body; null if refused.
#[unsafe(no_mangle)]
pub extern "C" fn surface(velocity: u32) -> usize {
    module().ask(|Bound { body, field: numbers, .. }| {
        match body {
            AnyBody::Single(body) => {
                // SAFETY: as many numbers of half the size, lent with them; any bits are numbers.
                let halves = unsafe { from_raw_parts_mut(numbers.as_mut_ptr().cast::<f32>(), numbers.len()) };
                body.surface_into(field(velocity), halves)?;
            }
            AnyBody::Double(body) => body.surface_into(field(velocity), numbers)?,
        }
        Ok(numbers.as_ptr() as usize as u32)
    }) as usize
}

/// Address of von Mises' equivalent stress \[Pa\] of the surface, in double precision: the first of three
/// numbers a node, zero where the file has none; null if refused.
#[unsafe(no_mangle)]
pub extern "C" fn equivalent_stress() -> usize {
    module().ask(|bound| {
        bound.field.fill(0.0);
        for index in 0..bound.body.count(Quantity::VonMises) {
            let stress = bound.scalar(Quantity::VonMises, index)?;
            let node = bound.body.stress_point(index).map(|point| point.node as usize);
            let nodes = bound.field.as_chunks_mut::<3>().0;
            // Between two regions the larger one.
            if let Some([most, ..]) = node.and_then(|node| nodes.get_mut(node)) {
                *most = most.max(stress);
            }
        }
        Ok(bound.field.as_ptr() as usize as u32)
    }) as usize
}

/// Leaves displacement (or velocity) of a place, as in [`push`], in the exchange buffer.
#[unsafe(no_mangle)]
pub extern "C" fn point(count: usize, velocity: u32) -> u32 {
    let module = module();
    let place = place(&module.exchange, count).map_err(OutputError::Place);
    let mut value = [0.0; 3];
    let done = module.ask(|bound| {
        value = bound.body.point(&place?, field(velocity))?;
        Ok(1)
    });
    module.give(value);
    done
}

/// Writes a quantity of the table, or its velocity, to the range; `n` is the length that its row gives.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn read(number: u32, index: usize, velocity: u32, at: *mut f64, n: usize) -> u32 {
    module().ask(|bound| {
        let unknown = OutputError::OutOfRange { index: number as usize, count: Quantity::ALL.len() };
        let quantity = Quantity::from_number(number).ok_or(unknown)?;
        // SAFETY: the page lends this range for the call.
        bound.body.read(quantity, index, field(velocity), unsafe { from_raw_parts_mut(at, n) })?;
        Ok(1)
    })
}

/// Leaves the loadable point nearest to (x, y, z) in the exchange buffer: number of nodes, nodes, weights,
/// position, distance.
#[unsafe(no_mangle)]
pub extern "C" fn locate(x: f64, y: f64, z: f64) -> u32 {
    let module = module();
    let mut found = None;
    let done = module.ask(|bound| {
        found = Some(bound.body.locate([x, y, z])?);
        Ok(1)
    });
    if let Some(p) = found {
        let mut out = module.exchange.iter_mut();
        let mut give = |number: f64| {
            if let Some(place) = out.next() {
                *place = number;
            }
        };
        give(p.place.nodes().len() as f64);
        p.place.nodes().iter().for_each(|&node| give(f64::from(node)));
        p.place.weights().iter().chain(&p.position).for_each(|&number| give(number));
        give(p.distance);
    }
    done
}

/// Bytes that [`save`] writes at most.
#[unsafe(no_mangle)]
pub extern "C" fn saved_len() -> usize {
    module().ask(|bound| Ok(bound.body.saved_len() as u32)) as usize
}

/// Writes the state to the range of `n` bytes, tagged; the bytes written.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn save(at: *mut u8, n: usize) -> usize {
    // SAFETY: the page lends this range for the call.
    module().ask(|bound| Ok(bound.body.save_into(unsafe { from_raw_parts_mut(at, n) })? as u32)) as usize
}

/// Takes back what [`save`] wrote, from the range of `n` bytes: 1 with every bit, 2 carried over from other
/// parameters or the other precision.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn restore(at: *const u8, n: usize) -> u32 {
    module().ask(|bound| {
        // SAFETY: the page lends this range for the call.
        Ok(match bound.body.restore(unsafe { from_raw_parts(at, n) })? {
            Restored::AsSaved => 1,
            Restored::Carried => 2,
        })
    })
}

/// Writes `ζ` and `ζ̇` to the range, `n` numbers in all.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coordinates(at: *mut f64, n: usize) -> u32 {
    module().ask(|bound| {
        // SAFETY: the page lends this range for the call.
        let numbers = unsafe { from_raw_parts_mut(at, n) };
        let (zeta, rates) = numbers.split_at_mut(n / 2);
        bound.body.coordinates_into(zeta, rates)?;
        Ok(1)
    })
}

/// Sets `ζ` and `ζ̇` from the range, `n` numbers in all.
///
/// # Safety
/// The module's documentation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn set_coordinates(at: *const f64, n: usize) -> u32 {
    module().ask(|bound| {
        // SAFETY: the page lends this range for the call.
        let (zeta, rates) = unsafe { from_raw_parts(at, n) }.split_at(n / 2);
        bound.body.set(zeta, rates)?;
        Ok(1)
    })
}

/// The body at rest, loads kept.
#[unsafe(no_mangle)]
pub extern "C" fn rest() -> u32 {
    module().ask(|bound| {
        bound.body.rest();
        Ok(1)
    })
}

/// Lays down a sphere that cannot enter the body: radius \[m\], friction, how fast \[m/s\] and how hard \[N\]
/// it follows at most, and where its centre is \[m\]. It presses from the next step on. Refused unless the
/// body's steps are exact. A newly bound body has none.
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
    module().ask(|bound| {
        bound.tool = Some(Tool::new(sphere, &bound.body)?);
        Ok(1)
    })
}

/// Sets the target of the sphere \[m\]; it starts with the next step. 0 without a sphere.
#[unsafe(no_mangle)]
pub extern "C" fn move_tool(x: f64, y: f64, z: f64) -> u32 {
    module().ask(|bound| {
        let target = [x, y, z];
        let tool = bound.tool.as_mut().filter(|_| target.iter().all(|x| x.is_finite()));
        Ok(tool.map_or(0, |tool| {
            tool.sphere.target = target;
            1
        }))
    })
}

/// Takes the sphere away.
#[unsafe(no_mangle)]
pub extern "C" fn lift_tool() -> u32 {
    module().ask(|bound| {
        bound.tool = None;
        Ok(1)
    })
}

/// Leaves in the exchange buffer what the sphere did in the last step: its centre \[m\], the deepest place of
/// the body inside of it \[m\] (below zero for a gap), whether all forces were found (1 or 0), how many
/// places were pushed, and for each of these where it is \[m\] and the force on the body \[N\]. 0 without a
/// sphere.
#[unsafe(no_mangle)]
pub extern "C" fn tool() -> u32 {
    let module = module();
    let (mut head, mut touches, mut count) = ([0.0; 6], [0.0; 6 * MAX_PLACES], 0);
    let done = module.ask(|bound| {
        let Some(tool) = &bound.tool else { return Ok(0) };
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
