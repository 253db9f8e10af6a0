//! Worlds stay safe: no step panics or leaves a number that is not one, whatever the file, the step and the
//! speed; what cannot be a member is refused by name.

use vademecum_eval::{
    Anchor, Body, BodyOptions, Field, JointKind, Member, Place, Pose, RigidMotion, RigidShape, Touching,
    World, WorldBuffers, WorldError, WorldJoint, WorldOptions,
};
use vademecum_format::File;

const PLATE: ([[f64; 3]; 4], [[u32; 3]; 2]) =
    ([[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]], [[0, 1, 2], [0, 2, 3]]);

/// Bytes of all golden files.
fn golden() -> Vec<(String, Vec<u8>)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/golden");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .expect("golden files")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "vdm"))
        .map(|path| (path.display().to_string(), std::fs::read(&path).expect("bytes")))
        .collect();
    files.sort();
    assert!(files.len() > 10, "golden files");
    files
}

/// Memory of a world.
fn buffers(
    members: &[Member<'_, '_, f64>],
    joints: &[WorldJoint],
    options: &WorldOptions,
) -> Result<WorldBuffers, WorldError> {
    World::sizes(members, joints, options).map(|sizes| WorldBuffers::new(&sizes))
}

/// Every golden file, thrown onto a plate at speeds up to the speed of light with steps of any length: a step
/// is done with finite numbers, or refused.
#[test]
fn nothing_becomes_infinite_whatever_the_step_and_the_speed() {
    let (mut stepped, mut refused) = (0, 0);
    for (name, bytes) in golden() {
        let Ok(file) = File::parse(&bytes) else { continue };
        for time_step in [1e-9, 1e-4, 1.0, 1e6] {
            let mut options = BodyOptions::default();
            options.scene.time_step = Some(time_step);
            options.scene.contacts = 64;
            let Ok(length) = Body::<f64>::len_for(&file, &options) else { continue };
            let mut memory = vec![0.0; length];
            let Ok(mut body) = Body::<f64>::bind(&file, &options, &mut memory) else { continue };
            for speed in [0.0, 1.0, 1e4, 3e8] {
                let pose = Pose::at([0.0, 0.0, -1e-6]);
                let mut plate = RigidShape::led(&PLATE.0, &PLATE.1, pose).expect("a plate");
                let flies = body.rigid_body();
                if let Some(rigid) = flies {
                    let motion = RigidMotion::thrown(&rigid, [0.1 * speed, 0.0, -speed], [speed, 0.0, 1.0]);
                    body.set_motion(motion).expect("a motion");
                }
                let mut members = [
                    match flies {
                        Some(_) => Member::Free(&mut body),
                        None => Member::Held(&mut body, Pose::IDENTITY),
                    },
                    Member::Rigid(&mut plate),
                ];
                let pairs = [Touching::new(0, 1).with_friction(0.7).with_restitution(0.3)];
                let options = WorldOptions {
                    gravity: [0.0, 0.0, -9.81],
                    contacts: 32,
                    reach: Some(0.05),
                    sweeps: 20,
                    ..WorldOptions::default()
                };
                let Ok(mut memory) = buffers(&members, &[], &options) else {
                    refused += 1;
                    continue;
                };
                let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
                for _ in 0..10 {
                    let Ok(report) = world.step(&mut members) else {
                        refused += 1;
                        break;
                    };
                    stepped += 1;
                    assert!(report.worst_gap.is_finite(), "{name} {time_step} {speed}: {report:?}");
                    assert!(report.energy_given_away.is_finite(), "{name} {time_step} {speed}: {report:?}");
                    for touch in world.touches() {
                        let numbers = touch.force().into_iter().chain(touch.slip()).chain([touch.gap()]);
                        assert!(numbers.into_iter().all(f64::is_finite), "{name} {time_step} {speed}");
                    }
                    let (Member::Free(body) | Member::Held(body, _)) = &members[0] else { unreachable!() };
                    let moved = body.node(0, Field::Displacement);
                    assert!(moved.is_ok_and(|moved| moved.iter().all(|x| x.is_finite())), "{name}");
                }
            }
        }
    }
    println!("{stepped} steps, {refused} refused");
    assert!(stepped > 500 && refused > 0, "{stepped} {refused}");
}

/// Members, pairs and joints that cannot be, and memory that is too short.
#[test]
fn what_cannot_be_is_refused() {
    let bytes = include_bytes!("../../../fixtures/golden/free.vdm");
    let file = File::parse(bytes).expect("a file");
    let options = BodyOptions::default();
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &options, &mut memory).expect("a body");
    let mut plate = RigidShape::led(&PLATE.0, &PLATE.1, Pose::IDENTITY).expect("a plate");
    assert!(RigidShape::led(&PLATE.0, &[[0, 1, 4]], Pose::IDENTITY).is_none());
    assert!(RigidShape::led(&PLATE.0, &PLATE.1, Pose::at([f64::NAN; 3])).is_none());
    let options = WorldOptions::default();
    {
        let members = [Member::Held(&mut body, Pose::IDENTITY), Member::Rigid(&mut plate)];
        let flies = World::sizes(&members, &[], &options);
        assert!(matches!(flies, Err(WorldError::Member { member: 0, .. })), "{flies:?}");
    }
    let mut members = [Member::Free(&mut body), Member::Rigid(&mut plate)];
    let mut memory = buffers(&members, &[], &options).expect("sizes");
    let wrong_pairs = [
        Touching::new(0, 0),
        Touching::new(0, 2),
        Touching::new(1, 1),
        Touching::new(0, 1).with_friction(-1.0),
        Touching::new(0, 1).with_friction(f64::NAN),
        Touching::new(0, 1).with_restitution(1.5),
    ];
    for pair in wrong_pairs {
        let pairs = [pair];
        let refused = World::new(&members, &pairs, &[], &options, memory.lend()).err();
        assert_eq!(refused, Some(WorldError::Pair { pair: 0 }), "{pair:?}");
    }
    let point = Anchor::point([0.0; 3]);
    let wrong_joints = [
        WorldJoint::new(JointKind::Ball, [0, 1], [point, point]),
        WorldJoint::new(JointKind::Ball, [0, 1], [Anchor::Place(Place::node(u32::MAX)), point]),
        WorldJoint::new(JointKind::Hinge, [0, 1], [Anchor::Place(Place::node(0)), point]),
        WorldJoint::new(JointKind::Hinge, [0, 1], [Anchor::Frame(3), point]),
        WorldJoint::new(JointKind::Cable { length: -1.0 }, [0, 1], [Anchor::Place(Place::node(0)), point]),
        WorldJoint::new(JointKind::Ball, [0, 0], [Anchor::Place(Place::node(0)); 2]),
    ];
    for joint in wrong_joints {
        let joints = [joint];
        let mut memory = buffers(&members, &joints, &options).expect("sizes");
        let refused = World::new(&members, &[], &joints, &options, memory.lend()).err();
        assert_eq!(refused, Some(WorldError::Joint { joint: 0 }), "{joint:?}");
    }
    let mut lent = memory.lend();
    lent.numbers = &mut [];
    let short = World::new(&members, &[], &[], &options, lent).err();
    assert!(matches!(short, Some(WorldError::LentMemory { found: 0, .. })), "{short:?}");
    // The same joint twice holds nothing more.
    let options = WorldOptions { gravity: [0.0, 0.0, -9.81], ..options };
    let joints = [WorldJoint::new(JointKind::Ball, [0, 1], [Anchor::Place(Place::node(0)), point]); 2];
    let mut memory = buffers(&members, &joints, &options).expect("sizes");
    let mut world = World::new(&members, &[], &joints, &options, memory.lend()).expect("a world");
    let redundant = world.step(&mut members).err();
    assert_eq!(redundant, Some(WorldError::Redundant { joint: 1 }));
    assert_eq!(world.step(&mut members[..1]).err(), Some(WorldError::Mismatch));
}
