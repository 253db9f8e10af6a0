//! States come back as they were; a damaged one is refused.

use vademecum_fmu::fmi2::*;
use vademecum_fmu::variables::Variable as V;

use crate::unit::*;

#[test]
fn a_state_comes_back_with_its_outputs_and_goes_on_alike() {
    for name in [
        "exact-f64.vdm",
        "fixed-f64.vdm",
        "parameters.vdm",
        "parametric.vdm",
        "reactions.vdm",
        "stress.vdm",
        "free.vdm",
    ] {
        let unit = Unit::new(name);
        let log = Log::new();
        let (one, other) = (unit.two(&log), unit.two(&log));
        one.start();
        let step = one.internal_step();
        let (fx, fz) = (unit.reference(V::Force(1, 0)), unit.reference(V::Force(0, 2)));
        assert_eq!((one.set(fx, 3.0), one.set(fz, -20.0)), (0, 0));
        for turn in 0..5 {
            if turn == 3 && unit.counts.parameters > 0 {
                assert_eq!(one.set(unit.reference(V::Parameter(0)), 1.25), 0);
            }
            assert_eq!(one.step(f64::from(turn) * step, step), 0);
        }
        // An input that no step has seen yet is part of the state, too.
        assert_eq!(one.set(fx, 7.0), 0);
        let (saved, shown) = (one.serialized(), one.all(&unit));
        let go_on = |two: &Two| {
            for turn in 5..12 {
                assert_eq!(two.step(f64::from(turn) * step, step), 0);
            }
            two.all(&unit)
        };
        let after = go_on(&one);
        assert_ne!(after, shown, "{name}");
        for two in [&other, &one] {
            assert_eq!(two.take(&saved), 0, "{name}");
            assert_eq!(two.all(&unit), shown, "{name}: outputs");
            assert_eq!(two.serialized(), saved, "{name}: bytes");
            assert_eq!(go_on(two), after, "{name}: afterwards");
        }
        assert_eq!(unsafe { fmi2Reset(one.0) }, 0);
        one.start();
        let fresh = unit.two(&log);
        fresh.start();
        assert_eq!(one.all(&unit), fresh.all(&unit), "{name}: reset");
        assert_eq!(one.serialized(), fresh.serialized(), "{name}: reset");
    }
}

#[test]
fn a_damaged_state_is_refused_and_changes_nothing() {
    ["parameters.vdm", "parametric.vdm"].into_iter().for_each(refuse_damaged);
}

fn refuse_damaged(name: &str) {
    let unit = Unit::new(name);
    let log = Log::new();
    let one = unit.two(&log);
    one.start();
    let step = one.internal_step();
    assert_eq!(one.set(unit.reference(V::Force(0, 2)), -20.0), 0);
    assert_eq!(one.step(0.0, step), 0);
    let (saved, shown) = (one.serialized(), one.all(&unit));
    for length in 0..saved.len() {
        assert_eq!(one.take(&saved[..length]), 3);
    }
    log.last(&["fmi2DeSerializeFMUstate", "another length"]);
    assert_eq!(one.take(&[&saved[..], &[0]].concat()), 3);
    for place in 0..saved.len() {
        let mut damaged = saved.clone();
        damaged[place] ^= 0x40;
        assert_eq!(one.take(&damaged), 3, "byte {place}");
    }
    // With a checksum that fits, every number is still looked at.
    let sealed = |mut bytes: Vec<u8>| {
        let end = bytes.len() - 4;
        let checksum = crc32fast::hash(&bytes[..end]).to_le_bytes();
        bytes[end..].copy_from_slice(&checksum);
        bytes
    };
    const HEAD: usize = 8 + 38 + 2 + 16;
    let mut refused = 0;
    for place in (HEAD..saved.len() - 4).step_by(8) {
        for value in [f64::NAN, f64::INFINITY, f64::MAX, -1.0] {
            let mut hostile = saved.clone();
            hostile[place..place + 8].copy_from_slice(&value.to_le_bytes());
            if one.take(&sealed(hostile)) == 0 {
                assert_eq!(one.take(&saved), 0);
            } else {
                refused += 1;
            }
            assert_eq!(one.all(&unit), shown, "{value} at {place}");
            assert_eq!(one.serialized(), saved, "{value} at {place}");
        }
    }
    // Every number that is not finite, but that of the step, which is no parameter here.
    let numbers = (saved.len() - 4 - HEAD) / 8 - 1;
    assert!(refused >= 2 * numbers, "{refused} of {numbers} numbers");
    for (place, value) in [(46, 3), (46, 0), (47, 4)] {
        let mut hostile = saved.clone();
        hostile[place] = value;
        assert_eq!(one.take(&sealed(hostile)), 3, "byte {place}");
    }
    assert_eq!(one.all(&unit), shown);
    let foreign = Unit::new("fixed-f64.vdm");
    assert_eq!(foreign.two(&log).take(&saved), 3);
}
