//! Decks of a few elements whose answers are known on paper.

use vademecum_deck::{DeckError, Dialect, FullOrder, ReadOptions, System, read};

use crate::{BAR, answers, at, close, deck_of};

#[test]
fn forces_pressure_gravity_and_given_displacements_stretch_a_bar() {
    let steps = "\
*STEP
*STATIC
*CLOAD
right,1,2.5
*END STEP
*STEP
*STATIC
*CLOAD,OP=NEW
*DSLOAD
end,P,-10
*END STEP
*STEP
*STATIC
*DLOAD,OP=NEW
bar,GRAV,4,1,0,0
*END STEP
*STEP
*STATIC
*DLOAD,OP=NEW
*BOUNDARY
right,1,1,0.5
*END STEP
";
    let found = answers("bar.inp", &format!("{BAR}{steps}"));
    let deck = deck_of("bar.inp", BAR).unwrap();
    let [force, pressure, gravity, given] = &found[..] else { panic!("{} steps", found.len()) };
    // F L / (E A).
    close(at(&deck, force, 3)[0], 10.0 * 2.0 / 100.0);
    close(force.reaction_sum[0], -10.0);
    close(force.strain_energy, 0.5 * 10.0 * 0.2);
    close(at(&deck, pressure, 12)[0], 10.0 * 2.0 / 100.0);
    // ρ g L² / 2E, exact at the nodes.
    close(at(&deck, gravity, 6)[0], 3.0 * 4.0 * 4.0 / 200.0);
    close(gravity.reaction_sum[0], -3.0 * 2.0 * 4.0);
    close(at(&deck, given, 2)[0], 0.25);
    // What pulls at the right is given too: the sum of both ends is zero.
    close(given.reaction_sum[0], 0.0);
    close(given.strain_energy, 0.5 * 100.0 * 0.25 * 0.25 * 2.0);
    assert!(found.iter().all(|answer| answer.residual < 1e-12));
}

#[test]
fn a_rigid_coupling_carries_a_force_and_a_moment_to_a_face() {
    let steps = "\
*RIGID BODY,NSET=right,REF NODE=20
*STEP
*STATIC
*CLOAD
20,1,10
20,4,2
*END STEP
";
    let text = format!("{BAR}{steps}");
    let found = answers("rigid.inp", &text);
    let deck = deck_of("rigid.inp", &text).unwrap();
    let tip = at(&deck, &found[0], 20);
    close(tip[0], 0.2);
    close(found[0].reaction_sum[0], -10.0);
    // A torque turns the face: its corners move by the same angle about the axis.
    let (a, b) = (at(&deck, &found[0], 12), at(&deck, &found[0], 3));
    close(a[1] + b[1], 0.0);
    assert!(a[1] < -1e-3 && a[2] > 1e-3, "{a:?}");
}

#[test]
fn a_mean_coupling_distributes_a_force_and_follows_the_mean() {
    let steps = "\
*COUPLING,REF NODE=20,SURFACE=end,CONSTRAINT NAME=c
*DISTRIBUTING
*STEP
*STATIC
*CLOAD
20,1,10
*END STEP
";
    let text = format!("{BAR}{steps}");
    let found = answers("mean.inp", &text);
    let deck = deck_of("mean.inp", &text).unwrap();
    close(at(&deck, &found[0], 20)[0], 0.2);
    close(at(&deck, &found[0], 9)[0], 0.2);
}

#[test]
fn springs_and_masses_make_an_oscillator() {
    // A stiff brick on rollers, held by one spring; a mass at each corner of one end.
    let text = "\
*NODE
1,0,0,0
2,1,0,0
3,1,1,0
4,0,1,0
5,0,0,1
6,1,0,1
7,1,1,1
8,0,1,1
9,-1,0,0
*ELEMENT,TYPE=C3D8,ELSET=block
1,1,2,3,4,5,6,7,8
*ELEMENT,TYPE=SPRINGA,ELSET=spring
2,9,1
*ELEMENT,TYPE=SPRING1,ELSET=ground
3,7
*ELEMENT,TYPE=MASS,ELSET=masses
4,2
5,3
*NSET,NSET=later
rest,1
*NSET,NSET=rest
2,3,4,5,6,7,8
*MATERIAL,NAME=stiff
*ELASTIC
1e9,0.3
*DENSITY
1
*SOLID SECTION,ELSET=block,MATERIAL=stiff
*SPRING,ELSET=spring

30
*SPRING,ELSET=ground
1
20
*MASS,ELSET=masses
2
*BOUNDARY
later,2,3
9,1,3
*STEP
*FREQUENCY
1
*END STEP
";
    let deck = deck_of("oscillator.inp", text).unwrap();
    let modes = FullOrder::new(&deck).modes(1).unwrap();
    let expected = (50.0_f64 / 5.0).sqrt() / std::f64::consts::TAU;
    assert!((modes.frequencies_hz[0] / expected - 1.0).abs() < 1e-6, "{:?}", modes.frequencies_hz);
}

#[test]
fn a_body_that_a_spring_holds_is_not_free() {
    // A brick on rollers, held by a spring to a support outside of the mesh.
    let text = BAR.replace("*BOUNDARY\nleft,1,3\n", "*BOUNDARY\n20,1,3\n");
    let spring = "*ELEMENT,TYPE=SPRINGA,ELSET=spring\n50,20,3\n*SPRING,ELSET=spring\n\n5\n*STEP\n*FREQUENCY\n2\n*END STEP\n";
    let deck = deck_of("spring.inp", &format!("{text}{spring}")).unwrap();
    let answer = FullOrder::new(&deck).modes(2);
    assert!(answer.as_ref().map_or(true, |modes| modes.rigid_motions == 0), "{answer:?}");
}

#[test]
fn a_tie_of_different_meshes_passes_a_patch_test_and_a_transform_turns_supports() {
    // A second brick that meets the first bar with other nodes, turned by nothing but tied.
    let tied = "\
*NODE
31,2,0,0
32,3,0,0
33,3,1,0
34,2,1,0
35,2,0,1
36,3,0,1
37,3,1,1
38,2,1,1
*ELEMENT,TYPE=C3D8,ELSET=bar
11,31,32,33,34,35,36,37,38
*NSET,NSET=far
32,33,36,37
*SURFACE,NAME=slave
11,S6
*TIE,POSITION TOLERANCE=0.1,NAME=t
slave,end
*STEP
*STATIC
*CLOAD
far,1,2.5
*END STEP
";
    let text = format!("{BAR}{tied}");
    let found = answers("tie.inp", &text);
    let deck = deck_of("tie.inp", &text).unwrap();
    close(at(&deck, &found[0], 33)[0], 10.0 * 3.0 / 100.0);
    // Axes turned by 90 degrees about z: component 2 of the node is -x.
    let turned = "\
*TRANSFORM,NSET=right,TYPE=R
0,1,0,-1,0,0
*STEP
*STATIC
*CLOAD
right,2,2.5
*END STEP
";
    let text = format!("{BAR}{turned}");
    let found = answers("turned.inp", &text);
    let deck = deck_of("turned.inp", &text).unwrap();
    close(at(&deck, &found[0], 9)[0], -0.2);
}

#[test]
fn an_equation_joins_nodes_and_a_contradiction_is_named() {
    let equal = "\
*EQUATION
2
3,1,1.0,6,1,-1.0
2
9,1,1.0,6,1,-1.0
2
12,1,1.0,6,1,-1.0
*STEP
*STATIC
*CLOAD
3,1,10
*END STEP
";
    let text = format!("{BAR}{equal}");
    let found = answers("equal.inp", &text);
    let deck = deck_of("equal.inp", &text).unwrap();
    close(at(&deck, &found[0], 12)[0], 0.2);
    let against =
        "*EQUATION\n2\n3,1,1.0,6,1,-1.0\n*BOUNDARY\n3,1,1,1.0\n6,1,1,2.0\n*STEP\n*STATIC\n*END STEP\n";
    let deck = deck_of("against.inp", &format!("{BAR}{against}")).unwrap();
    let error = FullOrder::new(&deck).static_answers().unwrap_err();
    assert!(
        matches!(error, DeckError::Contradiction(_)) && error.to_string().contains("*EQUATION"),
        "{error}"
    );
}

#[test]
fn a_body_that_is_not_held_is_named_and_one_without_density_has_no_modes() {
    let free = BAR.replace("*BOUNDARY\nleft,1,3\n", "*BOUNDARY\nleft,1,1\n");
    let deck = deck_of("free.inp", &format!("{free}*STEP\n*STATIC\n*CLOAD\nright,1,1\n*END STEP\n")).unwrap();
    let error = FullOrder::new(&deck).static_answers().unwrap_err();
    assert!(matches!(error, DeckError::NotHeld { parts: 1, .. }), "{error}");
    let light = BAR.replace("*DENSITY\n3\n", "");
    let deck = deck_of("light.inp", &light).unwrap();
    let error = FullOrder::new(&deck).modes(2).unwrap_err().to_string();
    assert!(error.contains("density"), "{error}");
}

#[test]
fn cards_that_are_not_taken_are_listed_with_their_lines() {
    let extra =
        "*CONTACT PAIR,INTERACTION=i\na,b\n*FANCY CARD\n*PLASTIC\n1,2\n*STEP,NLGEOM\n*STATIC\n*END STEP\n";
    let deck = deck_of("extra.inp", &format!("{BAR}{extra}")).unwrap();
    let found: Vec<(&str, usize)> = deck.left_out.iter().map(|one| (one.card.as_str(), one.line)).collect();
    let first = BAR.lines().count() + 1;
    let expected =
        [("*CONTACT PAIR", first), ("*FANCY CARD", first + 2), ("*PLASTIC", first + 3), ("*STEP", first + 5)];
    assert_eq!(found, expected);
}

#[test]
fn shells_are_refused_by_name_line_and_share() {
    let shell = "*ELEMENT,TYPE=S4,ELSET=shells\n90,1,2,5,4\n";
    // Without a section they only name a surface.
    assert!(deck_of("surface.inp", &format!("{BAR}{shell}")).is_ok());
    let shell = format!("{shell}*SHELL SECTION,ELSET=shells,MATERIAL=soft\n0.1\n");
    let error = deck_of("shell.inp", &format!("{BAR}{shell}")).unwrap_err().to_string();
    assert!(error.contains("S4") && error.contains("33.3 %"), "{error}");
    assert!(error.contains(&format!("line {}", BAR.lines().count() + 2)), "{error}");
}

#[test]
fn the_dialect_is_found_and_can_be_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.inp");
    std::fs::write(&path, BAR.replace("100,0", "100,0.3")).unwrap();
    let bending = |dialect| {
        let deck = read(&path, &ReadOptions { dialect, units: None }).unwrap();
        (FullOrder::new(&deck).modes(1).unwrap().frequencies_hz[0], deck.lumped.clone())
    };
    let (calculix, consistent) = bending(None);
    let (abaqus, lumped) = bending(Some(Dialect::Abaqus));
    assert_eq!((consistent, lumped), (vec![false], vec![true]));
    assert!(abaqus < calculix, "{abaqus} {calculix}");
}

/// The same bar as Nastran writes it, joined to a second one by rigid elements and a bar.
const NASTRAN: &str = "\
SOL 101
CEND
SUBCASE 7
  SPC = 1
  LOAD = 2
BEGIN BULK
GRID    1               0.      0.      0.
GRID    2               1.      0.      0.
GRID    3               1.      1.      0.
GRID    4               0.      1.      0.
GRID    5               0.      0.      1.
GRID    6               1.      0.      1.
GRID    7               1.      1.      1.
GRID    8               0.      1.      1.
GRID    20              1.      .5      .5
GRID    21              3.      .5      .5
CHEXA   1       1       1       2       3       4       5       6       +
+       7       8
PSOLID  1       5
MAT1    5       100.            0.      3.
RBE2    9       20      123456  2       3       6       7
CBAR    10      2       20      21      0.      1.      0.
PBAR    2       5       1.      0.1     0.2     0.3
SPC1    1       123     1       4       5       8
FORCE   3       21      0       5.      1.      0.      0.
FORCE   4       21      0       1.      0.      1.      0.
LOAD    2       1.      2.      3       6.      4
ENDDATA
";

#[test]
fn a_nastran_deck_with_a_rigid_element_and_a_bar_bends_as_beams_do() {
    let found = answers("bar.bdf", NASTRAN);
    let deck = deck_of("bar.bdf", NASTRAN).unwrap();
    assert_eq!(found[0].step, "7");
    let (tip, middle) = (at(&deck, &found[0], 21), at(&deck, &found[0], 20));
    // 10 along x through a brick of length 1 and a bar of length 2.
    close(middle[0], 0.1);
    close(tip[0], 0.3);
    close(found[0].reaction_sum[0], -10.0);
    close(found[0].reaction_sum[1], -6.0);
    // The rigid end turns under the moment 6 · 2 and moves; the bar adds F L³ / 3 E I1.
    let bar = 6.0 * 8.0 / (3.0 * 100.0 * 0.1);
    let angle = (at(&deck, &found[0], 2)[0] - at(&deck, &found[0], 3)[0]) / 1.0;
    close(tip[1], middle[1] + 2.0 * angle + bar);
    assert!(deck.left_out.is_empty(), "{:?}", deck.left_out);
}

#[test]
fn broken_decks_are_named_and_never_panic() {
    for (name, text) in [("bar.inp", BAR.to_string()), ("bar.bdf", NASTRAN.to_string())] {
        for end in 0..text.len() {
            if let Ok(deck) = deck_of(name, &text[..end]) {
                let _ = FullOrder::new(&deck).static_answers();
            }
        }
    }
    for line in
        ["*CLOAD\nright,9999999999999999999999,1", "*DLOAD\nbar,GRAV,1,0,0,0", "*EQUATION\n99999999999\n1"]
    {
        let text = format!("{BAR}*STEP\n*STATIC\n{line}\n*END STEP\n");
        assert!(deck_of("broken.inp", &text).is_err(), "{line}");
    }
}

#[test]
fn an_ansys_material_without_a_ratio_has_that_of_its_program() {
    let brick = |constants: &str| {
        let corners = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1", "1 1 1", "0 1 1"];
        let mut text = String::from("ET,1,185\nNBLOCK,6,SOLID,8,8\n(3i9,6e21.13e3)\n");
        for (at, corner) in corners.iter().enumerate() {
            text += &format!("{:9}{:9}{:9}", at + 1, 0, 0);
            corner.split(' ').for_each(|x| text += &format!("{x:>21}"));
            text += "\n";
        }
        text += "N,R5.3,LOC,       -1,\nEBLOCK,19,SOLID,1,1\n(19i9)\n";
        let row = [1, 1, 1, 1, 0, 0, 0, 0, 8, 0, 1, 1, 2, 3, 4, 5, 6, 7, 8];
        row.iter().for_each(|number| text += &format!("{number:9}"));
        text += &format!("\n       -1\n{constants}");
        // A unit pull along x on a brick that is free to contract.
        text += "D,1,ALL,0.\nD,4,UX,0.\nD,4,UZ,0.\nD,5,UX,0.\nD,5,UY,0.\nD,8,UX,0.\n";
        [2, 3, 6, 7].iter().for_each(|node| text += &format!("F,{node},FX,0.25\n"));
        let deck = deck_of("brick.cdb", &text).unwrap_or_else(|error| panic!("{error}"));
        let answers = FullOrder::new(&deck).static_answers().unwrap_or_else(|error| panic!("{error}"));
        let [x, y, _] = at(&deck, &answers[0], 7);
        (x, -y / x)
    };
    let modulus = "MPDATA,R5.0,1,EX,1,1,100.,\n";
    for (more, ratio) in [
        ("", 0.3),
        ("MPDATA,R5.0,1,NUXY,1,1,0.,\n", 0.0),
        ("MPDATA,R5.0,1,PRXY,1,1,0.25,\nMPDATA,R5.0,1,GXY,1,1,40.,\n", 0.25),
    ] {
        let (stretch, found) = brick(&format!("{modulus}{more}"));
        close(100.0 * stretch, 1.0);
        close(found, ratio);
    }
    // The same by 21 constants, which win over a modulus: 120 and 40, shear 40.
    let table = "TB,ANEL,1,1,21,0\nTBDATA,1,120.,40.,40.,0.,0.,0.\nTBDATA,7,120.,40.,0.,0.,0.,120.\n\
                 TBDATA,13,0.,0.,0.,40.,0.,0.\nTBDATA,19,40.,0.,40.\n";
    for constants in [table.to_string(), format!("{modulus}{table}")] {
        let (stretch, found) = brick(&constants);
        close(100.0 * stretch, 1.0);
        close(found, 0.25);
    }
}

#[test]
fn axes_about_a_line_are_those_of_nastran_too() {
    let corners =
        ["2,1,0", "3,1.2,0", "2.6,2.3,0.1", "1.7,1.9,0", "2,1,1", "3,1.2,1.1", "2.6,2.3,1", "1.7,1.9,1.2"];
    let numbered = |card: &str| -> String {
        corners
            .iter()
            .enumerate()
            .map(|(i, at)| format!("{}{at}\n", card.replace('#', &(i + 1).to_string())))
            .collect()
    };
    let nastran = |system: &str| {
        format!(
            "SOL 101\nCEND\nSPC = 1\nLOAD = 2\nBEGIN BULK\n{}CHEXA,1,1,1,2,3,4,5,6,+\n+,7,8\n\
             PSOLID,1,1,7,TWO,,FULL\nMAT11,1,11.,2.,1.,.3,.4,.35,.9,+\n+,1.1,.4\n\
             {system},7,,.3,-.2,0.,.3,-.2,1.,+\n+,1.3,-.2,0.\nSPC1,1,123,1,4,5,8\n\
             FORCE,2,7,,1.,0.1,0.2,0.3\nENDDATA\n",
            numbered("GRID,#,,")
        )
    };
    let abaqus = |system: &str| {
        format!(
            "*NODE\n{}*ELEMENT,TYPE=C3D8,ELSET=all\n1,1,2,3,4,5,6,7,8\n*MATERIAL,NAME=wood\n\
             *ELASTIC,TYPE=ENGINEERING CONSTANTS\n11,2,1,.3,.4,.35,.9,1.1,\n.4\n\
             *ORIENTATION,NAME=o,SYSTEM={system}\n\
             *SOLID SECTION,ELSET=all,MATERIAL=wood,ORIENTATION=o\n*BOUNDARY\n1,1,3\n4,1,3\n5,1,3\n8,1,3\n\
             *STEP\n*STATIC\n*CLOAD\n7,1,0.1\n7,2,0.2\n7,3,0.3\n*END STEP\n",
            numbered("#,")
        )
    };
    let energy = |name: &str, text: &str| answers(name, text)[0].strain_energy;
    let turning = energy("ring.inp", &abaqus("CYLINDRICAL\n.3,-.2,0,.3,-.2,1"));
    close(energy("ring.bdf", &nastran("CORD2C")) / turning, 1.0);
    // Those of space are others; a quarter turn about the line exchanges the radial and the tangential axis.
    let fixed = energy("fixed.inp", &abaqus("RECTANGULAR\n1,0,0,0,1,0"));
    assert!((fixed / turning - 1.0).abs() > 0.01, "{fixed} {turning}");
    let turned = energy("turned.inp", &abaqus("CYLINDRICAL\n.3,-.2,0,.3,-.2,1\n3,90"));
    let exchanged = abaqus("CYLINDRICAL\n.3,-.2,0,.3,-.2,1").replace(
        "11,2,1,.3,.4,.35,.9,1.1,\n.4\n",
        // E, ν₂₁ = ν₁₂ E₂/E₁, ν₂₃, ν₁₃; G₁₂, G₂₃, G₁₃.
        &format!("2,11,1,{},.35,.4,.9,.4,\n1.1\n", 0.3 * 2.0 / 11.0),
    );
    close(energy("exchanged.inp", &exchanged) / turned, 1.0);
}

#[test]
fn units_of_their_own_keep_the_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.inp");
    let mass = "*ELEMENT,TYPE=MASS,ELSET=m\n30,20\n*MASS,ELSET=m\n2.5\n*SOLID";
    // A modulus and a density of 1 are those of no solid.
    let text = BAR.replace("\n100,0\n*DENSITY\n3\n", "\n1,0\n*DENSITY\n1\n").replace("*SOLID", mass);
    std::fs::write(&path, text).unwrap();
    let unknown = read(&path, &ReadOptions::default()).unwrap();
    assert_eq!((unknown.units.system, unknown.units.words().contains("unknown")), (None, true));
    let error = unknown.problem_parts(None).unwrap_err().to_string();
    assert!(error.contains("--units none") && error.contains("own.inp"), "{error}");
    let own = read(&path, &ReadOptions { units: System::parse("none"), ..ReadOptions::default() }).unwrap();
    let parts = own.problem_parts(None).unwrap();
    assert!(parts.own_units && parts.scale == 1.0);
    assert_eq!(
        parts.materials,
        "[[material]]\nyoung = 1e0\npoisson = 0.0\ndensity = 1.0\nhexahedra = \"full\"\n\n"
    );
    assert!(parts.attachments.contains("mass = 2.5\n"), "{}", parts.attachments);
    let millimetres = ReadOptions { units: System::parse("mm-t-N"), ..ReadOptions::default() };
    let parts = read(&path, &millimetres).unwrap().problem_parts(None).unwrap();
    assert!(parts.materials.contains("young = 1e6 # Pa"), "{}", parts.materials);
}

#[test]
fn contact_is_named_where_a_body_is_loose() {
    // The brick beyond the gap is held by contact alone.
    let second = "*NODE\n31,5,0,0\n32,6,0,0\n33,6,1,0\n34,5,1,0\n35,5,0,1\n36,6,0,1\n37,6,1,1\n38,5,1,1\n\
                  *ELEMENT,TYPE=C3D8,ELSET=bar\n9,31,32,33,34,35,36,37,38\n*CONTACT PAIR,INTERACTION=i\na,b\n";
    let step = "*STEP\n*STATIC\n*CLOAD\n33,1,1.\n*END STEP\n";
    let deck = deck_of("loose.inp", &format!("{BAR}{second}{step}")).unwrap();
    let error = FullOrder::new(&deck).static_answers().unwrap_err().to_string();
    let line = BAR.lines().count() + second.lines().count() - 1;
    assert!(error.contains(&format!("*CONTACT PAIR at line {line}")), "{error}");
    assert!(error.contains("2 bodies"), "{error}");
}

#[test]
fn parameters_do_not_mind_blanks_and_rotations_are_no_displacements() {
    let steps = "*NODE\n40,9,9,9\n*RIGID BODY,NSET=right,REFNODE=20,ROTNODE=40\n*STEP\n*STATIC\n*BOUNDARY\n\
                 40,1,1,0.5\n20,1,3\n*END STEP\n";
    let found = answers("turned.inp", &format!("{BAR}{steps}"));
    // The corner stands half a diagonal from the axis; the rotation itself is 0.5.
    assert!((found[0].largest_displacement() - 0.5 * 0.5_f64.sqrt()).abs() < 1e-9, "{:?}", found[0]);
}

#[test]
fn displacements_of_other_steps_and_models_are_named() {
    let fixed = "*STEP\n*STATIC\n*BOUNDARY,FIXED\nright,1,1\n*END STEP\n";
    let deck = deck_of("fixed.inp", &format!("{BAR}{fixed}")).unwrap();
    assert!(deck.left_out[0].meaning.contains("step before"), "{:?}", deck.left_out);
    let submodel = fixed.replace("FIXED", "SUBMODEL,STEP=1");
    let error = deck_of("part.inp", &format!("{BAR}{submodel}")).unwrap_err().to_string();
    assert!(error.contains("SUBMODEL") && error.contains("in this deck"), "{error}");
}

#[test]
fn decks_without_solids_name_their_elements() {
    let nodes: String =
        BAR.lines().take_while(|line| !line.starts_with("*ELEMENT")).map(|l| l.to_string() + "\n").collect();
    for (kind, ids) in [("B32R", "1,2,3"), ("CAX8R", "1,3,6,4,2,5,11,10"), ("S4", "1,2,5,4"), ("T3D2", "1,2")]
    {
        let text = format!(
            "{nodes}*ELEMENT,TYPE={kind},ELSET=e\n1,{ids}\n*MATERIAL,NAME=m\n*ELASTIC\n1,0\n\
             *BEAM SECTION,ELSET=e,MATERIAL=m\n1\n"
        );
        let error = deck_of("thin.inp", &text).unwrap_err().to_string();
        assert!(error.contains(kind) && error.contains("100.0 %"), "{error}");
    }
    let shell = "SOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n\
                 CTRIA3,1,1,1,2,3\nPSHELL,1,1,.1\nMAT1,1,1.,,0.\nENDDATA\n";
    let error = deck_of("thin.bdf", shell).unwrap_err().to_string();
    assert!(error.contains("CTRIA3") && error.contains("100.0 %"), "{error}");
}

#[test]
fn instances_are_copies_of_their_parts_where_they_stand() {
    let text = "\
*PART,NAME=brick
*NODE
1,0,0,0
2,1,0,0
3,1,1,0
4,0,1,0
5,0,0,1
6,1,0,1
7,1,1,1
8,0,1,1
*ELEMENT,TYPE=C3D8,ELSET=all
1,1,2,3,4,5,6,7,8
*NSET,NSET=left
1,4,5,8
*SURFACE,NAME=front
all,S4
*SURFACE,NAME=back
1,S6
*SOLID SECTION,ELSET=all,MATERIAL=soft
*END PART
*ASSEMBLY,NAME=both
*INSTANCE,NAME=one,PART=brick
*END INSTANCE
*INSTANCE,NAME=two,PART=brick
1,0,-1
1,0,0,2,0,0,90
*END INSTANCE
*NSET,NSET=end,INSTANCE=two
2,3,6,7
*TIE,NAME=joint
two.back,one.front
*END ASSEMBLY
*MATERIAL,NAME=soft
*ELASTIC
100,0
*DENSITY
3
*STEP
*STATIC
*BOUNDARY
one.left,1,3
*CLOAD
end,1,2.5
two.2,2,0.5
*END STEP
";
    let deck = deck_of("both.inp", text).unwrap();
    let regions: Vec<&str> = deck.mesh.regions.iter().map(|region| region.name.as_str()).collect();
    assert_eq!(regions, ["ONE.all", "TWO.all"]);
    // A quarter turn about x: the second brick stands beside the first one.
    let node = (0..deck.node_count() as u32).find(|&node| deck.id(node) == 22).unwrap();
    let place = deck.place(node);
    assert!((0..3).all(|c| (place[c] - [2.0, 1.0, 0.0][c]).abs() < 1e-12), "{place:?}");
    let answer = &FullOrder::new(&deck).static_answers().unwrap()[0];
    let mean = [22, 23, 26, 27].iter().map(|&id| at(&deck, answer, id)[0]).sum::<f64>() / 4.0;
    close(mean, 10.0 * 2.0 / 100.0);
    close(answer.reaction_sum[0], -10.0);
    close(answer.reaction_sum[1], -0.5);
    assert!(deck.notes.iter().any(|note| note.contains("`TWO`: their numbers plus 20")), "{:?}", deck.notes);
    let copies = "*INSTANCE,NAME=i,PART=brick\n*END INSTANCE\n".repeat(10_000);
    let copied = text.replace("*NSET,NSET=end", &format!("{copies}*NSET,NSET=end"));
    let error = deck_of("many.inp", &copied).unwrap_err().to_string();
    assert!(error.contains("10001 instances"), "{error}");
    let error = deck_of("lost.inp", &text.replace("PART=brick", "PART=other")).unwrap_err().to_string();
    assert!(error.contains("OTHER") && error.contains("*INSTANCE"), "{error}");
}
