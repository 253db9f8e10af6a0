//! Motions over time and harmonic answers of decks, as the parts of a problem file.

use crate::{BAR, deck_of, parts};

#[test]
fn loads_of_a_motion_over_time_follow_their_own_courses() {
    let found = parts(
        "*AMPLITUDE,NAME=a\n0,0,1,2\n*AMPLITUDE,NAME=b\n0.5,1,3,4\n*STEP\n*STATIC\n*DLOAD\nbar,GRAV,9,0,0,-1\n\
         *END STEP\n*STEP\n*MODAL DYNAMIC\n0.1,2\n*BOUNDARY\nleft,1,1\n*CLOAD,AMPLITUDE=a\nright,1,3\n\
         *CLOAD,AMPLITUDE=b\nright,2,5\n*CLOAD\nright,3,7\n*END STEP\n",
    );
    assert_eq!((found.time_step, &found.missing[..]), (Some(0.1), &[][..]));
    // Gravity of the step before goes on, and a course holds its first and its last value.
    let expected = "\
duration = 2.0 # s

[[pattern]]
name = \"2 2\"

[[pattern]]
name = \"3 2\"
table = [[0.0, 0.0], [1.0, 2.0], [2.1, 2.0]]

[[pattern]]
name = \"4 2\"
table = [[0.0, 1.0], [0.5, 1.0], [3.0, 4.0]]

[[pattern]]
name = \"5 2\"
";
    let scenario = found.scenario.unwrap();
    assert!(scenario.ends_with(expected), "{scenario}");
    for (name, keys) in [("2 2", "acceleration = [0.0, 0.0, -9.0]"), ("4 2", "[3, 0.0, 5.0, 0.0]")] {
        let table =
            found.patterns.split("[[load.pattern]]").find(|table| table.contains(&format!("\"{name}\"")));
        assert!(table.is_some_and(|table| table.contains(keys)), "{name}: {}", found.patterns);
    }
}

#[test]
fn damping_of_a_deck_is_that_of_its_problem_file() {
    let modal = |cards: &str| {
        let steps =
            format!("*STEP\n*FREQUENCY\n4\n*END STEP\n*STEP\n*MODAL DYNAMIC\n0.1,2\n{cards}*END STEP\n");
        parts(&steps).damping
    };
    assert_eq!(modal(""), None);
    let rayleigh = modal("*MODAL DAMPING,RAYLEIGH\n,,5.,0.25\n");
    assert_eq!(rayleigh.as_deref(), Some("alpha = 5.0 # 1/s\nbeta = 0.25 # s\n"));
    // Modes without a ratio have none, and a list has no more than the modes of the sum.
    let ratios = modal("*MODAL DAMPING\n1,2,0.5\n3,3,0.25\n");
    assert_eq!(ratios.as_deref(), Some("modal = [0.5, 0.5, 0.25, 0.0]\n"));
    assert_eq!(modal("*MODAL DAMPING\n1,9,0.5\n").as_deref(), Some("modal = [0.5, 0.5, 0.5, 0.5]\n"));
    // Two motions with damping: that of the first one.
    let second = "*MODAL DAMPING,RAYLEIGH\n,,5.,0\n*END STEP\n*STEP\n*MODAL DYNAMIC\n0.1,2\n\
                  *MODAL DAMPING,RAYLEIGH\n,,7.,0\n";
    assert_eq!(modal(second).as_deref(), Some("alpha = 5.0 # 1/s\n"));
    // That of a material acts in motions that are no sums of modes.
    let direct = "*DAMPING,ALPHA=3,BETA=1e-3\n*STEP\n*DYNAMIC\n0.1,2\n*END STEP\n";
    assert_eq!(parts(direct).damping.as_deref(), Some("alpha = 3.0 # 1/s\nbeta = 0.001 # s\n"));
    assert_eq!(parts(&direct.replace("*DYNAMIC", "*MODAL DYNAMIC")).damping, None);
    for wrong in ["*MODAL DAMPING\n0,2,0.5\n", "*MODAL DAMPING\n1,2,-0.5\n", "*MODAL DAMPING\n2,1,0.5\n"] {
        let text = format!("{BAR}*STEP\n*MODAL DYNAMIC\n0.1,2\n{wrong}*END STEP\n");
        let error = deck_of("wrong.inp", &text).unwrap_err().to_string();
        assert!(error.contains("MODAL DAMPING"), "{error}");
    }
}

#[test]
fn a_harmonic_step_is_a_frequency_response() {
    let step =
        "*NSET,NSET=out\n3,3,12\n*STEP\n*FREQUENCY\n5\n*END STEP\n*STEP\n*STEADY STATE DYNAMICS\n1,9,5\n";
    let loads = "*CLOAD\nright,2,3\n*CLOAD,LOAD CASE=2\nright,3,7\n*NODE PRINT,NSET=out\nU\n*END STEP\n";
    let found = parts(&format!("{step}{loads}"));
    let response = found.frequency_response.unwrap();
    assert_eq!((response.range, response.pattern.as_str()), ([1.0, 9.0], "1 2"));
    // A node that a set names twice has its probes once.
    assert_eq!(response.probes, ["N3.x", "N3.y", "N3.z", "N12.x", "N12.y", "N12.z"]);
    assert_eq!(found.probes.matches("[[output.probe]]").count(), 6);
    assert_eq!(found.modes, Some(5));
    // Loads out of phase are named and do not act.
    assert!(found.patterns.contains("3.0, 0.0]") && !found.patterns.contains("7.0"), "{}", found.patterns);
    let moved = parts(&format!("{step}*BOUNDARY\nleft,1,1,2.\n*END STEP\n"));
    assert!(moved.missing.iter().any(|words| words.contains("motions of supports")), "{:?}", moved.missing);
}
