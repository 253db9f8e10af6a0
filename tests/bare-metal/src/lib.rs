//! Everything the evaluator does, in both precisions, as a library for a machine without operating system:
//! opening, binding, setting parameters, loading, stepping, reading. `check` builds it and looks at the
//! symbols it is left with.
#![no_std]

use core::panic::PanicInfo;
use vademecum_eval::format::File;
use vademecum_eval::{
    Assembly, AssemblyOptions, Batch, Body, BodyOptions, Contact, End, Field, Joint, Part, PartState, Place,
    Pose, Quantity, Scalar, SceneOptions, StructureChoice, Surface, SurfaceTree,
};

unsafe extern "C" {
    /// Defined nowhere: left in the library exactly when a panic is reachable.
    fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never called; the library is not linked into a program.
    unsafe { a_panic_is_reachable() }
}

/// What a host would do in a loop; `None` on any refusal.
fn run<T: Scalar>(bytes: &[u8], memory: &mut [T], work: &mut [f64], block: bool) -> Option<f64> {
    let file = File::parse(bytes).ok()?;
    file.verify_all().ok()?;
    let structure = if block { StructureChoice::Block } else { StructureChoice::Auto };
    let scene = SceneOptions { structure, ..SceneOptions::default() };
    let options = BodyOptions { scene, keep_loads: true, static_field: true, ..BodyOptions::default() };
    let (lent, work) = work.split_at_mut_checked(Body::<T>::len_for(&file, &options).ok()?)?;
    let mut body = Body::<T>::bind(&file, &options, lent).ok()?;
    let index = SceneOptions::find(file.metadata(), "stiffness")?;
    let _ = body.set_parameters(&[(index, 1.1)]).ok()?;
    let _ = body.rebind(&scene).ok()?;
    let surface = Surface::whole(&file).ok()?;
    let (mut order, mut boxes) = ([0; 64], [0.0; 256]);
    let mut tree = SurfaceTree::new(&surface, &mut order, &mut boxes).ok()?;
    tree.refit(memory, 2.0).ok()?;
    let point = body.locate([0.0; 3]).ok()?;
    let point = tree.pick(point.position, [0.0, 0.0, -1.0]).or(tree.locate(point.position))?;
    body.push(&Place::new(&[0, 1, 2, 3], &[0.25; 4]).ok()?, [0.0, 0.0, -1.0]).ok()?;
    body.push_ramp(&point, [0.0; 3], [0.0, 0.0, -1.0]).ok()?;
    body.push_pattern_staged(0, &[0.0, 0.5, 1.0, 0.0]).ok()?;
    body.keep_loads().ok()?;
    body.set(&[0.0], &[1.0]).ok()?;
    body.march(10).ok()?;
    body.recall_loads().ok()?;
    body.compliance(&[point], work.get_mut(..9)?).ok()?;
    let mut gone = [[0.0; 3]];
    body.free_motion(&[point], &mut gone).ok()?;
    body.scene().increment_into(work.get_mut(..9 * body.scene().n_modes() * body.scene().n_modes())?).ok()?;
    let (lent, out) = memory.split_at_mut_checked(Batch::len_for(body.scene(), 20))?;
    let mut batch = Batch::new(body.scene(), 20, lent).ok()?;
    body.with(|parts| {
        batch.load(parts.scene, 17, parts.loads).ok()?;
        batch.set(17, parts.state).ok()?;
        batch.step(parts.scene).ok()?;
        batch.carry(parts.scene).ok()?;
        batch.status(17).ok()?;
        batch.get_under(17, parts.state, parts.loads).ok()
    })?;
    batch.clear();
    let mut saved = [0; 4096];
    let written = body.save_into(&mut saved).ok()?;
    body.restore(saved.get(..written)?).ok()?;
    body.body_into(Field::Velocity, out).ok()?;
    body.solve_static_field().ok()?;
    body.body_with_statics(Field::Displacement, out).ok()?;
    body.throw([1.0; 3], [0.0; 3])?;
    body.pull([0.0; 3]).ok()?;
    let mut sum = body.in_space(&point, Field::Velocity).ok()?[0] + gone[0][0];
    for quantity in Quantity::ALL {
        let numbers = work.get_mut(..body.length(quantity))?;
        for index in 0..body.count(quantity) {
            body.read(quantity, index, Field::Displacement, numbers).ok()?;
            sum += numbers.iter().sum::<f64>();
        }
    }
    Some(sum + body.point(&point, Field::Displacement).ok()?[0])
}

/// Two bodies of one file, welded, and taken apart.
fn join(bytes: &[u8], out: &mut [u8], memory: &mut [f64], work: &mut [f64]) -> Option<f64> {
    let file = File::parse(bytes).ok()?;
    let pose = Pose::new([1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
    let parts = [Part::new("a", file, Pose::IDENTITY).ok()?, Part::new("b", file, pose).ok()?];
    let (first, second) = (End::find(&parts, "a.end")?, End::find(&parts, "b.end")?);
    let stiffness = [1.0; 6];
    let joints = [
        Joint::bushing(first, second, &stiffness).within(0.1),
        Joint::spring(first, second, &stiffness),
        Joint::weld(first, second).at(&stiffness),
        Joint::hinge(first, None),
        Joint::ball(first, None),
        Joint::slider(first, second).as_it_stands(),
    ];
    let (states, work) = work.split_at_mut_checked(4 * parts[0].n_coordinates())?;
    parts[0].move_ports(&[Contact::new(Place::node(0), [1.0; 3])], &[(0, 1.0)], states).ok()?;
    let n = parts[0].n_coordinates();
    let of_part = |k: usize| -> Option<PartState<'_>> {
        let own = states.get(2 * k * n..2 * (k + 1) * n)?;
        let (displacement, velocity) = own.split_at_checked(n)?;
        Some(PartState { displacement, velocity, port_motion: &[] })
    };
    let states = [of_part(0)?, of_part(1)?];
    let options = AssemblyOptions::default().as_it_stands(&states);
    let sizes = Assembly::sizes(&parts, &joints, &options).ok()?;
    let (carried, work) = work.split_at_mut_checked(5 * sizes.coordinates + sizes.rows)?;
    let assembly = Assembly::bind(&parts, &joints, &options, out, memory, work).ok()?;
    let (eta, rest) = carried.split_at_mut_checked(sizes.coordinates)?;
    let (rates, rest) = rest.split_at_mut_checked(sizes.coordinates)?;
    let (q, rest) = rest.split_at_mut_checked(sizes.coordinates)?;
    let (speeds, forces) = rest.split_at_mut_checked(sizes.coordinates)?;
    assembly.join(&states, eta, rates, work).ok()?;
    assembly.part_states(eta, rates, q, speeds, work).ok()?;
    let forces = forces.get_mut(..sizes.rows)?;
    assembly.forces_into(q, &[], forces).ok()?;
    let energy = assembly.joint_energy(forces, speeds);
    let [x, ..] = parts[0].rigid_motion(&parts[1].rigid_coordinates([1.0; 3], [0.0; 3]));
    let reaction = assembly.nodal_reaction_into(0, forces, work.get_mut(..3)?).ok()?;
    let sum = x[0] + energy.stored + reaction.force[0] + assembly.reaction(1, forces).ok()?.moment[0];
    let length = assembly.file().bytes().len() as f64;
    Some(sum + assembly.report().time_step + assembly.offsets(2).ok()?.first()? + length)
}

/// [`join`] with the slices of a C caller.
///
/// # Safety
/// As [`run_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn join_f64(
    bytes: *const u8,
    n_bytes: usize,
    out: *mut u8,
    n_out: usize,
    memory: *mut f64,
    n: usize,
    work: *mut f64,
    n_work: usize,
) -> f64 {
    // SAFETY: the caller's promise.
    let (bytes, out, memory, work) = unsafe {
        (
            core::slice::from_raw_parts(bytes, n_bytes),
            core::slice::from_raw_parts_mut(out, n_out),
            core::slice::from_raw_parts_mut(memory, n),
            core::slice::from_raw_parts_mut(work, n_work),
        )
    };
    join(bytes, out, memory, work).unwrap_or(f64::NAN)
}

/// `run` for f32 with the slices of a C caller.
///
/// # Safety
/// The pointers and lengths describe memory that lives and is not shared during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn run_f32(
    bytes: *const u8,
    n_bytes: usize,
    memory: *mut f32,
    n: usize,
    work: *mut f64,
    n_work: usize,
    block: bool,
) -> f64 {
    // SAFETY: the caller's promise.
    let (bytes, memory, work) = unsafe {
        (
            core::slice::from_raw_parts(bytes, n_bytes),
            core::slice::from_raw_parts_mut(memory, n),
            core::slice::from_raw_parts_mut(work, n_work),
        )
    };
    run(bytes, memory, work, block).unwrap_or(f64::NAN)
}

/// `run` for f64 with the slices of a C caller.
///
/// # Safety
/// As [`run_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn run_f64(
    bytes: *const u8,
    n_bytes: usize,
    memory: *mut f64,
    n: usize,
    work: *mut f64,
    n_work: usize,
    block: bool,
) -> f64 {
    // SAFETY: the caller's promise.
    let (bytes, memory, work) = unsafe {
        (
            core::slice::from_raw_parts(bytes, n_bytes),
            core::slice::from_raw_parts_mut(memory, n),
            core::slice::from_raw_parts_mut(work, n_work),
        )
    };
    run(bytes, memory, work, block).unwrap_or(f64::NAN)
}
