//! Random problem and scenario files, and how they are spoilt.

use std::fmt::Write as _;

use super::dice::Dice;
use crate::program::repository;

/// A problem that chance made.
pub struct Problem {
    /// The file.
    pub text: String,
    /// Corner of the body farthest from the origin \[m\].
    pub lengths: [f64; 3],
    /// Step \[s\].
    pub step: f64,
    /// Names of its load patterns.
    pub patterns: Vec<&'static str>,
    /// It has live parameters.
    pub live: bool,
    /// Its numbers are stored in double precision.
    pub double: bool,
    /// It is the chapter's representation.
    pub canonical: bool,
    /// Its scheme never lets the energy of a free body grow, whatever the body.
    pub dissipative: bool,
}

/// Meshes of the repository that a body of two regions with one named side is read from.
const MESHES: [&str; 12] = [
    "gmsh1.msh",
    "gmsh22-binary.msh",
    "gmsh41.msh",
    "quadratic-gmsh41-binary.msh",
    "deck.inp",
    "quadratic-deck.inp",
    "vtk42-binary.vtk",
    "vtk51.vtk",
    "quadratic-vtu.vtu",
    "medit.mesh",
    "mfem.mesh",
    "tetgen.node",
];

/// A small problem: a block or a mesh of the repository.
pub fn problem(dice: &mut Dice) -> Problem {
    let from_file = dice.once_in(4);
    let lengths = match from_file {
        true => [0.5, 0.25, 0.25],
        false => [dice.log(0.1, 10.0), 0.0, 0.0],
    };
    let lengths = match from_file {
        true => lengths,
        false => [lengths[0], lengths[0] * dice.between(0.1, 0.5), lengths[0] * dice.between(0.1, 0.5)],
    };
    let (young, density) = (dice.log(1e3, 2e11), dice.log(1e2, 1e4));
    // First bending of a cantilever, which says what a sensible step is.
    let height = lengths[1].min(lengths[2]);
    let period = lengths[0] * lengths[0] / (0.1615 * height * (young / density).sqrt());
    let step = period / dice.log(15.0, 200.0);
    let mut made = Problem {
        text: String::from("title = \"made by chance\"\n"),
        lengths,
        step,
        patterns: vec![],
        live: false,
        double: true,
        canonical: !from_file && dice.once_in(24),
        dissipative: false,
    };
    if made.canonical {
        made.text += "representation = \"canonical\"\n";
    }
    let cut = mesh(dice, &mut made, from_file);
    materials(dice, &mut made, [young, density], cut);
    let damping = damping(dice, &mut made, period);
    supports(dice, &mut made);
    loads(dice, &mut made, young);
    scheme(dice, &mut made);
    basis(dice, &mut made, period);
    output(dice, &mut made);
    if made.canonical {
        made.text += "[canonical]\nrepairs = [\"scaled-coordinates\", \"separate-blocks\", \"one-axis-start\"]\n\
                      positions = 3\npoints = 4\n";
    } else if dice.once_in(3) {
        parameters(dice, &mut made, damping, cut);
    }
    made
}

/// The table `[mesh]`; whether a region `tip` is cut out of it.
fn mesh(dice: &mut Dice, made: &mut Problem, from_file: bool) -> bool {
    let [x, y, z] = made.lengths;
    if from_file {
        let path = repository().join("fixtures/meshes/bar").join(dice.pick(&MESHES));
        let _ = writeln!(made.text, "[mesh]\nfile = \"{}\"", path.display());
        return false;
    }
    let (order, most) = if dice.once_in(2) { ("linear", 3) } else { ("quadratic", 2) };
    let divisions = [dice.whole(2, 2 * most), dice.whole(1, most - 1), dice.whole(1, most - 1)];
    let _ = writeln!(
        made.text,
        "[mesh]\nblock = {{ lengths = [{x:?}, {y:?}, {z:?}], divisions = {divisions:?}, order = \"{order}\" }}"
    );
    let cut = dice.once_in(3);
    if cut {
        made.text += "[[mesh.region]]\nname = \"tip\"\n\
                      on = { fraction = { axis = \"x\", side = \"max\", fraction = 0.5 } }\n";
    }
    cut
}

fn materials(dice: &mut Dice, made: &mut Problem, [young, density]: [f64; 2], cut: bool) {
    let poisson = dice.between(-0.3, 0.48);
    let mut material = |region: &str, young: f64, density: f64| {
        let _ = writeln!(
            made.text,
            "[[material]]\nregion = \"{region}\"\nyoung = {young:?}\npoisson = {poisson:?}\ndensity = {density:?}"
        );
    };
    material("*", young, density);
    if cut && dice.once_in(2) {
        material("tip", young * dice.log(0.1, 10.0), density * dice.log(0.5, 2.0));
    }
}

/// The table `[damping]`; its α and β.
fn damping(dice: &mut Dice, made: &mut Problem, period: f64) -> [f64; 2] {
    let omega = 2.0 * std::f64::consts::PI / period;
    let ratio = dice.log(1e-4, 0.1);
    let (alpha, beta) = match dice.below(4) {
        0 => (2.0 * ratio * omega, 0.0),
        1 => (0.0, 2.0 * ratio / omega),
        2 => (ratio * omega, ratio / omega),
        _ => (0.0, 0.0),
    };
    let _ = writeln!(made.text, "[damping]\nalpha = {alpha:?}\nbeta = {beta:?}");
    [alpha, beta]
}

fn supports(dice: &mut Dice, made: &mut Problem) {
    made.text += "[[support]]\non = { plane = { axis = \"x\", at = 0.0 } }\n";
    if dice.once_in(4) {
        let component = dice.pick(&["x", "y", "z"]);
        let _ = writeln!(
            made.text,
            "[[support]]\non = {{ fraction = {{ axis = \"x\", side = \"max\", fraction = 0.0 }} }}\n\
             components = [\"{component}\"]"
        );
    }
}

fn loads(dice: &mut Dice, made: &mut Problem, young: f64) {
    made.text += "[load]\n";
    if dice.once_in(3) {
        made.text += "surface = { fraction = { axis = \"z\", side = \"max\", fraction = 0.0 } }\n";
    }
    if made.canonical {
        return;
    }
    if dice.once_in(2) {
        let [x, y, z] = dice.vector().map(|v| 10.0 * v);
        let _ =
            writeln!(made.text, "[[load.pattern]]\nname = \"gravity\"\nacceleration = [{x:?}, {y:?}, {z:?}]");
        made.patterns.push("gravity");
    }
    if dice.once_in(2) {
        let pressure = young * dice.log(1e-9, 1e-5);
        let _ = writeln!(
            made.text,
            "[[load.pattern]]\nname = \"water\"\npressure = {pressure:?}\n\
             on = {{ fraction = {{ axis = \"z\", side = \"max\", fraction = 0.0 }} }}"
        );
        made.patterns.push("water");
    }
}

fn scheme(dice: &mut Dice, made: &mut Problem) {
    let rho = dice.between(0.0, 1.0);
    let gamma = dice.between(0.5, 0.9);
    let (name, dissipative) = match dice.below(9) {
        0 => (format!("{{ name = \"rho-bathe\", rho_infinity = {rho:?} }}"), false),
        1 => (format!("{{ name = \"newmark\", beta = {:?}, gamma = {gamma:?} }}", gamma / 2.0 + 0.01), false),
        2 => ("{ name = \"newmark\", beta = 0.25, gamma = 0.5 }".into(), true),
        3 => (format!("{{ name = \"hht-alpha\", alpha = {:?} }}", -rho / 3.0), false),
        4 => (format!("{{ name = \"generalized-alpha\", rho_infinity = {rho:?} }}"), false),
        5 | 6 => ("{ name = \"exact\" }".into(), true),
        _ => ("{ name = \"bathe\" }".into(), true),
    };
    made.dissipative = dissipative;
    let _ = writeln!(made.text, "[time]\nstep = {:?}\nscheme = {name}", made.step);
}

fn basis(dice: &mut Dice, made: &mut Problem, period: f64) {
    let kind = dice.pick(&["ritz", "ritz", "pod", "modes"]);
    let modes = dice.whole(1, if made.canonical { 2 } else { 6 });
    let positions = dice.whole(2, 4);
    let _ = writeln!(made.text, "[snapshots]\npositions = {positions}");
    if dice.once_in(2) {
        let _ = writeln!(
            made.text,
            "duration = {:?}\nhold = {:?}",
            1.5 * period,
            dice.between(0.2, 0.8) * period
        );
    }
    let _ = writeln!(made.text, "[basis]\nkind = \"{kind}\"\nmodes = {modes}");
    if dice.once_in(3) {
        let product = dice.pick(&["mass", "stiffness", "identity"]);
        let _ = writeln!(made.text, "inner_product = \"{product}\"");
    }
    let steps = dice.whole(20, 100);
    let _ = writeln!(
        made.text,
        "[tolerance]\nfloor_ratio = 3.0\nabsolute = 1e-3\nsteps = {steps}\nmap = 1e-4\nmax_terms = 30"
    );
}

fn output(dice: &mut Dice, made: &mut Problem) {
    let fields = dice.pick(&["body", "surface"]);
    made.double = !dice.once_in(3);
    let precision = if made.double { "f64" } else { "f32" };
    let _ = writeln!(made.text, "[output]\nfields = \"{fields}\"\nprecision = \"{precision}\"");
    for probe in 0..dice.below(3) {
        let ([x, y, z], [u, v, w]) = (made.lengths, dice.vector());
        let _ = writeln!(
            made.text,
            "[[output.probe]]\nname = \"p{probe}\"\npoint = [{x:?}, {y:?}, {z:?}]\ndirection = [{u:?}, {v:?}, {w:?}]"
        );
    }
}

/// One to three live parameters of different kinds around the problem's own values.
fn parameters(dice: &mut Dice, made: &mut Problem, [alpha, beta]: [f64; 2], cut: bool) {
    made.live = true;
    let region = if cut { *dice.pick(&["*", "tip"]) } else { "*" };
    let step = made.step;
    let wide = dice.between(1.1, 2.0);
    let around = |value: f64| (value / wide, value * wide);
    let mut all = vec![
        (format!("kind = \"stiffness\"\nregion = \"{region}\""), around(1.0)),
        (format!("kind = \"density\"\nregion = \"{region}\""), around(1.0)),
        ("kind = \"alpha\"".to_string(), (0.0, 2.0 * alpha + 0.01 / step)),
        ("kind = \"beta\"".to_string(), (0.0, 2.0 * beta + 0.01 * step)),
        ("kind = \"time-step\"".to_string(), around(step)),
    ];
    for number in 0..dice.whole(1, 2) {
        let (kind, (low, high)) = all.swap_remove(dice.below(all.len()));
        let scale = if low > 0.0 && dice.once_in(2) { "log" } else { "linear" };
        let _ = writeln!(
            made.text,
            "[[parameter]]\nname = \"live {number}\"\n{kind}\nrange = [{low:?}, {high:?}]\nscale = \"{scale}\""
        );
    }
}

/// A scenario of a problem, and the rows its table will have.
pub fn scenario(dice: &mut Dice, problem: &Problem, steps: usize) -> (String, usize) {
    let duration = steps as f64 * problem.step;
    let mut text = format!("duration = {duration:?}\n");
    let when = |dice: &mut Dice, text: &mut String| {
        if dice.once_in(2) {
            let _ = writeln!(text, "ramp = {:?}", dice.between(0.0, 0.5) * duration);
        }
        let start = if dice.once_in(2) { dice.between(0.0, 0.4) * duration } else { 0.0 };
        let _ = writeln!(text, "start = {start:?}");
        if dice.once_in(2) {
            let _ = writeln!(text, "end = {:?}", start + dice.between(0.1, 0.5) * duration);
        }
    };
    for _ in 0..dice.below(4) {
        let unit = dice.vector().map(f64::abs);
        let [x, y, z] = [0, 1, 2].map(|k| unit[k] * problem.lengths[k]);
        let size = dice.log(1e-3, 1e3);
        let [u, v, w] = dice.vector().map(|v| v * size);
        let _ = writeln!(text, "[[contact]]\npoint = [{x:?}, {y:?}, {z:?}]\nforce = [{u:?}, {v:?}, {w:?}]");
        when(dice, &mut text);
    }
    for name in &problem.patterns {
        let _ = writeln!(text, "[[pattern]]\nname = \"{name}\"\namplitude = {:?}", dice.between(-2.0, 2.0));
        when(dice, &mut text);
    }
    let every = dice.whole(1, 5);
    let fields = if dice.once_in(3) { steps.div_ceil(3) } else { 0 };
    let _ = writeln!(text, "[output]\nprobes_every = {every}\nfields_every = {fields}\nfields = \"surface\"");
    (text, steps / every + 1)
}

/// Numbers that no honest file has.
const EXTREMES: [&str; 18] = [
    "0",
    "-1",
    "1",
    "1e-300",
    "1e300",
    "-1e300",
    "1e-30",
    "1e30",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "1000000",
    "400",
    "\"\"",
    "[]",
    "true",
    "{}",
];

/// A text with one to three things wrong, or not so wrong.
pub fn mutated(dice: &mut Dice, text: &[u8]) -> Vec<u8> {
    let mut bytes = text.to_vec();
    for _ in 0..dice.whole(1, 3) {
        bytes = match dice.below(8) {
            0..=3 => other_number(dice, &bytes),
            4 => lines_moved(dice, &bytes),
            5 => bytes[..dice.below(bytes.len() + 1)].to_vec(),
            6 => flipped(dice, bytes),
            _ => other_word(dice, &bytes),
        };
    }
    bytes
}

/// One number is another.
fn other_number(dice: &mut Dice, bytes: &[u8]) -> Vec<u8> {
    let part_of_number = |b: u8| b.is_ascii_digit() || matches!(b, b'.' | b'e' | b'-' | b'+');
    let starts: Vec<usize> = (0..bytes.len())
        .filter(|&i| {
            bytes[i].is_ascii_digit()
                && (i == 0 || !(part_of_number(bytes[i - 1]) || bytes[i - 1].is_ascii_alphabetic()))
        })
        .collect();
    if starts.is_empty() {
        return bytes.to_vec();
    }
    let start = *dice.pick(&starts);
    let length = bytes[start..].iter().take_while(|&&b| part_of_number(b)).count();
    let number = dice.pick(&EXTREMES).as_bytes();
    [&bytes[..start], number, &bytes[start + length..]].concat()
}

/// A line is left out, there twice, or elsewhere.
fn lines_moved(dice: &mut Dice, bytes: &[u8]) -> Vec<u8> {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&b| b == b'\n').collect();
    if lines.is_empty() {
        return vec![];
    }
    let (from, to) = (dice.below(lines.len()), dice.below(lines.len()));
    match dice.below(3) {
        0 => drop(lines.remove(from)),
        1 => lines.insert(to, lines[from]),
        _ => lines.swap(from, to),
    }
    lines.concat()
}

/// Some bits are others.
pub fn flipped(dice: &mut Dice, mut bytes: Vec<u8>) -> Vec<u8> {
    for _ in 0..dice.whole(1, 4) {
        if !bytes.is_empty() {
            let at = dice.below(bytes.len());
            bytes[at] ^= 1 << dice.below(8);
        }
    }
    bytes
}

/// One word is another of the same text.
fn other_word(dice: &mut Dice, bytes: &[u8]) -> Vec<u8> {
    let words: Vec<&[u8]> =
        bytes.split(|b| !(b.is_ascii_alphanumeric() || *b == b'_')).filter(|w| !w.is_empty()).collect();
    if words.is_empty() {
        return bytes.to_vec();
    }
    let (old, new) = (*dice.pick(&words), *dice.pick(&words));
    let at = bytes.windows(old.len()).position(|window| window == old).unwrap_or(0);
    [&bytes[..at], new, &bytes[at + old.len()..]].concat()
}
