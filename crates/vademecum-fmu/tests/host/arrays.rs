//! Arrays over surface nodes: values row by row, a structural parameter for their number, derivatives.

use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{Contact, Field, Place, SceneOptions};
use vademecum_fmu::fmi3::*;
use vademecum_fmu::variables::Variable as V;

use crate::unit::*;

/// An instance of FMI 3.
struct Three(*mut std::ffi::c_void);

impl Drop for Three {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.0) };
    }
}

impl Three {
    fn start(&self) {
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(self.0, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!(fmi3ExitInitializationMode(self.0), 0);
        }
    }

    fn get(&self, references: &[u32], values: usize) -> Vec<f64> {
        let mut found = vec![f64::NAN; values];
        let (r, n) = (references.as_ptr(), references.len());
        assert_eq!(unsafe { fmi3GetFloat64(self.0, r, n, found.as_mut_ptr(), values) }, 0);
        found
    }

    fn put(&self, references: &[u32], values: &[f64]) -> i32 {
        let (r, n) = (references.as_ptr(), references.len());
        unsafe { fmi3SetFloat64(self.0, r, n, values.as_ptr(), values.len()) }
    }

    fn step(&self, point: f64, size: f64) {
        let (mut flags, mut last) = ([9_u8; 3], 0.0);
        let [a, b, c] = &mut flags;
        assert_eq!(unsafe { fmi3DoStep(self.0, point, size, 1, a, b, c, &mut last) }, 0);
        assert_eq!(flags, [0; 3]);
    }

    fn along(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64], values: usize) -> Vec<f64> {
        let mut change = vec![f64::NAN; values];
        let (u, m, k, n) = (unknowns.as_ptr(), unknowns.len(), knowns.as_ptr(), knowns.len());
        let (s, out) = (seed.as_ptr(), change.as_mut_ptr());
        let status = unsafe { fmi3GetDirectionalDerivative(self.0, u, m, k, n, s, seed.len(), out, values) };
        assert_eq!(status, 0);
        change
    }

    fn adjoint(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64], values: usize) -> Vec<f64> {
        let mut change = vec![f64::NAN; values];
        let (u, m, k, n) = (unknowns.as_ptr(), unknowns.len(), knowns.as_ptr(), knowns.len());
        let (s, out) = (seed.as_ptr(), change.as_mut_ptr());
        let status = unsafe { fmi3GetAdjointDerivative(self.0, u, m, k, n, s, seed.len(), out, values) };
        assert_eq!(status, 0);
        change
    }
}

#[test]
fn arrays_are_the_nodes_of_the_evaluator_bit_for_bit() {
    for name in ["exact-f64.vdm", "fixed-f64.vdm", "quadratic.vdm", "reactions.vdm", "bent.vdm"] {
        let nodes = [3, 0, 4];
        let unit = Unit::with_surface(name, &nodes);
        let file = File::parse(&unit.bytes).expect("a file");
        let options = SceneOptions { contacts: 5, ..SceneOptions::default() };
        let mut memory = SceneMemory::new(&file, &options);
        let (scene, mut state, mut loads) = memory.bind(&file, &options);
        let log = Log::new();
        let three = Three(unit.three(&log));
        three.start();
        let step = scene.parameters().time_step;
        // Several references in one call, an array between scalars.
        let inputs = [V::Force(1, 2), V::SurfaceForce, V::Force(0, 0)].map(|v| unit.reference(v));
        let outputs = [V::SurfaceVelocity, V::Energy, V::SurfaceDisplacement].map(|v| unit.reference(v));
        let places = nodes.map(|node| Place::new(&[node], &[1.0]).expect("a place"));
        for turn in 0..20 {
            let rows: Vec<[f64; 3]> = (0..3).map(|k| force(turn, k)).collect();
            let [x, z] = [0.5, -1.5].map(|scale| scale * f64::from(turn));
            let values: Vec<f64> = [z].into_iter().chain(rows.concat()).chain([x]).collect();
            assert_eq!(three.put(&inputs, &values), 0);
            three.step(f64::from(turn) * step, step);
            loads.clear();
            let named = unit.points.iter().zip([[x, 0.0, 0.0], [0.0, 0.0, z]]);
            for (at, force) in named.filter(|(_, force)| *force != [0.0; 3]) {
                loads.add_contact(&scene, &Contact::new(at.place, force)).expect("a push");
            }
            for (&place, &force) in places.iter().zip(&rows) {
                if force != [0.0; 3] {
                    loads.add_contact(&scene, &Contact::new(place, force)).expect("a nodal force");
                }
            }
            scene.step(&mut state, &loads).expect("a step");
            let at = |field| places.map(|place| scene.point(&state, &place, field).expect("a node"));
            let mut wanted = at(Field::Velocity).concat();
            wanted.push(scene.energy(&state).expect("an energy"));
            wanted.extend(at(Field::Displacement).concat());
            assert_eq!(three.get(&outputs, 19), wanted, "{name}, turn {turn}");
            assert!(wanted[9] > 0.0 && wanted[0] != wanted[3]);
        }
        let section = file.section(SectionKind::NodeCoordinates).expect("coordinates");
        let coordinates = section.numbers().expect("numbers");
        let row = |node: u32| (0..3).map(move |c| coordinates.get(3 * node as usize + c).expect("a node"));
        let wanted: Vec<f64> = nodes.into_iter().flat_map(row).collect();
        assert_eq!(three.get(&[unit.reference(V::SurfacePosition)], 9), wanted, "{name}");
    }
}

#[test]
fn the_number_of_nodes_is_a_structural_parameter() {
    let unit = Unit::with_surface("exact-f64.vdm", &[3, 0, 4]);
    let log = Log::new();
    let (three, other) = (Three(unit.three(&log)), Three(unit.three(&log)));
    let i = three.0;
    let [nodes, force, shown] =
        [V::SurfaceNodes, V::SurfaceForce, V::SurfaceDisplacement].map(|v| unit.reference(v));
    let count = |three: &Three| {
        let mut count = 0;
        assert_eq!(unsafe { fmi3GetUInt64(three.0, &nodes, 1, &mut count, 1) }, 0);
        count
    };
    let configure = |three: &Three, count: u64| unsafe {
        assert_eq!(fmi3EnterConfigurationMode(three.0), 0);
        let status = fmi3SetUInt64(three.0, &nodes, 1, &count, 1);
        assert_eq!(fmi3ExitConfigurationMode(three.0), 0);
        status
    };
    assert_eq!(count(&three), 3);
    unsafe {
        log.refused(fmi3SetUInt64(i, &nodes, 1, &2, 1), &["fmi3SetUInt64 is not allowed now"]);
        log.refused(fmi3ExitConfigurationMode(i), &["fmi3ExitConfigurationMode is not allowed now"]);
    }
    for bad in [0, 4, u64::MAX] {
        log.refused(configure(&three, bad), &["surface_nodes", &bad.to_string(), "expected 1 to 3"]);
    }
    assert_eq!(count(&three), 3);
    // Forces that were set before on nodes that go out of use are gone.
    assert_eq!(three.put(&[force], &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 9e3, 0.0]), 0);
    assert_eq!((configure(&three, 2), count(&three)), (0, 2));
    three.start();
    other.start();
    log.refused(unsafe { fmi3EnterConfigurationMode(i) }, &["is not allowed now: the instance steps"]);
    let values = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(other.put(&[force], &values), 0);
    log.refused(three.put(&[force], &values), &["fmi3SetFloat64", "9 values for variables that have 6"]);
    let step = f64::from_bits(three.get(&[1], 1)[0].to_bits());
    three.step(0.0, step);
    other.step(0.0, step);
    let (few, all) = (three.get(&[shown], 6), other.get(&[shown], 9));
    assert_eq!(few, all[..6]);
    assert!(few[2] > 0.0);
    log.refused(three.put(&[force], &[0.0, 0.0, 1.0, f64::NAN, 0.0, 0.0]), &["surface_force[2,1]", "NaN"]);
    log.refused(three.put(&[shown], &[0.0; 6]), &["surface_displacement[1,1]", "cannot be set"]);
    unsafe {
        let mut value = 0.0;
        log.refused(fmi3GetFloat64(i, &nodes, 1, &mut value, 1), &["no variable of this type"]);
        log.refused(fmi3GetUInt64(i, &force, 1, &mut 0, 1), &["no variable of this type"]);
        // The number comes back with a state, and with a reset.
        let mut state = std::ptr::null_mut();
        assert_eq!(fmi3GetFMUState(i, &mut state), 0);
        assert_eq!(fmi3SetFMUState(other.0, state), 0);
        assert_eq!((count(&other), other.get(&[shown], 6)), (2, few));
        assert_eq!(fmi3FreeFMUState(i, &mut state), 0);
        assert_eq!((fmi3Reset(other.0), count(&other)), (0, 3));
    }
    let plain = Unit::new("exact-f64.vdm");
    let three = Three(plain.three(&log));
    log.refused(unsafe { fmi3EnterConfigurationMode(three.0) }, &["no structural parameters", "--surface"]);
}

#[test]
fn derivatives_of_arrays_are_those_of_their_elements() {
    let unit = Unit::with_surface("reactions.vdm", &[3, 0, 4, 5]);
    let log = Log::new();
    let three = Three(unit.three(&log));
    three.start();
    let step = three.get(&[1], 1)[0];
    let [force, shown, point] =
        [V::SurfaceForce, V::SurfaceDisplacement, V::Displacement(1, 2)].map(|v| unit.reference(v));
    three.step(0.0, 3.0 * step);
    // Column by column; a body answers a force here as one there.
    let unit_seed = |k: usize| (0..12).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
    let columns: Vec<Vec<f64>> =
        (0..12).map(|k| three.along(&[shown], &[force], &unit_seed(k), 12)).collect();
    let most = columns.iter().flatten().fold(0.0_f64, |most, x| x.abs().max(most));
    for j in 0..12 {
        for k in 0..12 {
            assert!((columns[j][k] - columns[k][j]).abs() <= 1e-12 * most, "{j} {k}");
        }
    }
    assert!(most > 0.0);
    let seed: Vec<f64> = (0..12).map(|k| (0.3 + f64::from(k)).sin()).collect();
    let along = three.along(&[point, shown], &[force], &seed, 13);
    let adjoint = three.adjoint(&[shown], &[force], &seed, 12);
    for k in 0..12 {
        let wanted: f64 = (0..12).map(|j| columns[j][k] * seed[j]).sum();
        assert!((along[1 + k] - wanted).abs() <= 1e-12 * most);
        let wanted: f64 = (0..12).map(|j| columns[k][j] * seed[j]).sum();
        assert!((adjoint[k] - wanted).abs() <= 1e-12 * most);
    }
}
