//! Thermal strain in decks of a few elements, whose answers are known on paper.

use std::fmt::Write as _;

use vademecum_deck::{Deck, Dialect, FullOrder, ReadOptions, StaticAnswer, read};

/// Edges of the bar.
const EDGES: [f64; 3] = [1.5, 0.2, 0.1];
const YOUNG: f64 = 2e11;
const EXPANSION: f64 = 1.2e-5;
/// Rise of the temperature.
const RISE: f64 = 50.0;

/// Place of a node of the bar, from 0: four cross-sections of four nodes.
fn place(k: usize) -> [f64; 3] {
    [EDGES[0] / 3.0 * (k / 4) as f64, EDGES[1] * (k / 2 % 2) as f64, EDGES[2] * (k % 2) as f64]
}

/// Numbers of the nodes of a brick of the bar.
fn brick(k: usize) -> [usize; 8] {
    [1, 5, 7, 3, 2, 6, 8, 4].map(|corner| corner + 4 * k)
}

fn of_text(name: &str, text: &str, dialect: Option<Dialect>) -> Deck {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    read(&path, &ReadOptions { dialect, units: None }).unwrap_or_else(|error| panic!("{error}"))
}

fn answer(deck: &Deck) -> StaticAnswer {
    FullOrder::new(deck).static_answers().unwrap_or_else(|error| panic!("{error}")).remove(0)
}

fn inp(element: &str, cards: &str) -> String {
    let mut text = String::from("*NODE,NSET=all\n");
    for k in 0..16 {
        let [x, y, z] = place(k);
        writeln!(text, "{},{x},{y},{z}", k + 1).unwrap();
    }
    writeln!(text, "*ELEMENT,TYPE={element},ELSET=bar").unwrap();
    for k in 0..3 {
        writeln!(text, "{},{}", k + 1, brick(k).map(|corner| corner.to_string()).join(",")).unwrap();
    }
    // The first end slides on itself; one corner stays, another one keeps the bar from turning.
    text + &format!(
        "*ELSET,ELSET=last\n3\n*MATERIAL,NAME=solid\n*ELASTIC\n2e11,0.3\n*EXPANSION,ZERO=20.\n1.2e-5\n\
         *SOLID SECTION,ELSET=bar,MATERIAL=solid\n*NSET,NSET=end\n1,2,3,4\n*BOUNDARY\nend,1\n1,2,3\n2,2\n\
         *INITIAL CONDITIONS,TYPE=TEMPERATURE\nall,20.\n*STEP\n*STATIC\n*TEMPERATURE\nall,70.\n{cards}*END STEP\n"
    )
}

/// Energy of the bar if it may not become longer.
fn whole_energy() -> f64 {
    0.5 * YOUNG * (EXPANSION * RISE).powi(2) * EDGES.iter().product::<f64>()
}

/// A bar that has the displacement `α ΔT x` has no stress.
fn assert_free(deck: &Deck, what: &str) {
    let found = answer(deck);
    for (k, moved) in found.displacement.iter().enumerate() {
        let x = deck.place(k as u32);
        for c in 0..3 {
            let off = moved[c] - EXPANSION * RISE * x[c];
            assert!(off.abs() < 1e-13, "{what}: node {k}, {c}: {off:e}");
        }
    }
    assert!(found.strain_energy.abs() < 1e-9 * whole_energy(), "{what}: {:e}", found.strain_energy);
    let force = found.reaction_sum[0];
    assert!(force.abs() < 1e-9 * YOUNG * EXPANSION * RISE * EDGES[1] * EDGES[2], "{what}: {force:e}");
}

#[test]
fn a_free_bar_expands_and_a_clamped_one_is_pressed() {
    for dialect in [Dialect::CalculiX, Dialect::Abaqus] {
        for element in ["C3D8", "C3D8I", "C3D8R"] {
            let what = format!("{element} of {dialect:?}");
            assert_free(&of_text("bar.inp", &inp(element, ""), Some(dialect)), &what);

            // The pressure E α ΔT at the other end keeps the length: the stress is −E α ΔT.
            let (pressure, area) = (YOUNG * EXPANSION * RISE, EDGES[1] * EDGES[2]);
            let pressed = inp(element, &format!("*DLOAD\nlast,P4,{pressure:e}\n"));
            let found = answer(&of_text("bar.inp", &pressed, Some(dialect)));
            assert!((found.reaction_sum[0] / (pressure * area) - 1.0).abs() < 1e-9, "{what}");
            assert!((found.strain_energy / whole_energy() - 1.0).abs() < 1e-9, "{what}");
            let moved = found.displacement.iter().map(|u| u[0].abs()).fold(0.0, f64::max);
            assert!(moved < 1e-13, "{what}: {moved:e}");
        }
    }
}

#[test]
fn cards_of_temperatures_that_are_not_taken_are_listed() {
    let meanings = |cards: &str| -> Vec<(String, String)> {
        let deck = of_text("bar.inp", &inp("C3D8", cards), None);
        deck.left_out.into_iter().map(|card| (card.card, card.meaning)).collect()
    };
    assert_eq!(meanings(""), []);
    let file = meanings("*TEMPERATURE,FILE=heat.frd,BSTEP=1\n");
    assert!(file[0].1.contains("not listed in the deck"), "{file:?}");
    let text =
        inp("C3D8", "").replace("*EXPANSION,ZERO=20.\n1.2e-5\n", "*EXPANSION,TYPE=ANISO\n1,2,3,4,5,6\n");
    let left = of_text("bar.inp", &text, None).left_out;
    assert!(left[0].meaning.contains("TYPE=ISO and ORTHO"), "{left:?}");
    let text = inp("C3D8", "").replace("2e11,0.3\n", "2e11,0.3,100.\n1e11,0.3,20.\n");
    let left = of_text("bar.inp", &text, None).left_out;
    assert!(left[0].meaning.contains("do not ascend"), "{left:?}");
}

/// The bar as a deck of Nastran; bricks have incompatible modes.
fn bdf(case: &str, cards: &str) -> String {
    let mut text = format!("SOL 101\nCEND\nSPC = 1\n{case}\nBEGIN BULK\n");
    for k in 0..16 {
        let [x, y, z] = place(k);
        writeln!(text, "GRID,{},,{x:?},{y:?},{z:?}", k + 1).unwrap();
    }
    for k in 0..3 {
        let ids = brick(k).map(|corner| corner.to_string());
        writeln!(text, "CHEXA,{},1,{},\n,{}", k + 1, ids[..6].join(","), ids[6..].join(",")).unwrap();
    }
    text + &format!(
        "PSOLID,1,1\nMAT1,1,2.+11,,.3,7850.,1.2-5,20.\nSPC1,1,1,1,2,3,4\nSPC1,1,23,1\nSPC1,1,2,2\n{cards}ENDDATA\n"
    )
}

#[test]
fn temperatures_of_nastran_and_ansys_expand_a_bar() {
    let uniform = bdf("TEMPERATURE(LOAD) = 5", "TEMPD,5,70.\nTEMPD,6,100.\n");
    let deck = of_text("bar.bdf", &uniform, None);
    assert_free(&deck, "Nastran");
    let left: Vec<_> = deck.left_out.iter().map(|card| card.meaning.as_str()).collect();
    assert_eq!(left, ["no subcase selects its set"]);
    let initial = bdf("TEMP(LOAD) = 5\nTEMP(INIT) = 6", "TEMPD,5,90.\nTEMPD,6,40.\n");
    assert_free(&of_text("bar.bdf", &initial, None), "Nastran from initial temperatures");

    // A temperature that is linear in space makes a strain that fits together: there is no stress.
    let mut lines = String::new();
    for k in 0..16 {
        let [x, y, z] = place(k);
        writeln!(lines, "TEMP,5,{},{:?}", k + 1, 20.0 + 40.0 * x - 100.0 * y + 300.0 * z).unwrap();
    }
    let hold = "SPC1,1,1,1,2,3,4\nSPC1,1,23,1\nSPC1,1,2,2\n";
    let three = "SPC1,1,123,1\nSPC1,1,23,13\nSPC1,1,3,3\n";
    let free = bdf("TEMP = 5", &lines).replace(hold, three);
    let found = answer(&of_text("bar.bdf", &free, None));
    assert!(found.strain_energy.abs() < 1e-9 * whole_energy(), "{:e}", found.strain_energy);
    // The strain α 40 x along the bar, from the side at the origin on.
    let moved = found.displacement[12][0];
    assert!((moved - 0.5 * EXPANSION * 40.0 * EDGES[0].powi(2)).abs() < 1e-12, "{moved:e}");

    let mut cdb = String::from("/PREP7\nET,1,185\nKEYOPT,1,2,3\nNBLOCK,6,SOLID,16,16\n(3i9,6e21.13e3)\n");
    for k in 0..16 {
        let [x, y, z] = place(k);
        writeln!(cdb, "{:9}{:9}{:9}{x:21.13}{y:21.13}{z:21.13}", k + 1, 0, 0).unwrap();
    }
    cdb += "N,R5.3,LOC,       -1,\nEBLOCK,19,SOLID,3,3\n(19i9)\n";
    for k in 0..3 {
        for number in [1, 1, 1, 1, 0, 0, 0, 0, 8, 0, k + 1].into_iter().chain(brick(k)) {
            write!(cdb, "{number:9}").unwrap();
        }
        cdb.push('\n');
    }
    cdb += "       -1\nMPDATA,R5.0,1,EX,1,1,2e11,\nMPDATA,R5.0,1,NUXY,1,1,0.3,\nMPDATA,R5.0,1,ALPX,1,1,1.2e-5,\n\
            TREF,20.\nBFUNIF,TEMP,70.\nD,1,UX,0.\nD,2,UX,0.\nD,3,UX,0.\nD,4,UX,0.\nD,1,UY,0.\nD,1,UZ,0.\nD,2,UY,0.\n";
    assert_free(&of_text("bar.cdb", &cdb, None), "Ansys");
    let nodes: String = (1..=16).map(|node| format!("BF,{node},TEMP,70.\n")).collect();
    let cdb = cdb.replace("BFUNIF,TEMP,70.\n", &format!("BFUNIF,TEMP,_TINY\n{nodes}"));
    assert_free(&of_text("bar.cdb", &cdb, None), "Ansys, by nodes");
}
