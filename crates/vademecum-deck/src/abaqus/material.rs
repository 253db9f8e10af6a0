//! Materials of a deck of Abaqus or CalculiX.

use vademecum_build::fem::{Cylinder, Elasticity, Stiffness};
use vademecum_build::linalg::unit;
use vademecum_build::linalg::vec3::{cross, norm, sub};
use vademecum_build::mesh::inp::{DataLine, InpCard};

use crate::abaqus::reader::Reader;
use crate::abaqus::solid::{Orientation, Solid};
use crate::error::DeckError;

/// Begins a material.
pub(crate) fn begin(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(name) = card.parameter("NAME") else {
        return Err(reader.fault(card, None, "no NAME", "NAME=material"));
    };
    let name = name.to_ascii_uppercase();
    reader.materials.insert(name.clone(), Solid::default());
    reader.material = Some(name);
    Ok(())
}

/// Names of the constants of a law by `TYPE`, and their number.
const LAWS: [(&str, usize, &str); 4] = [
    ("ISO", 2, "a modulus above 0 and a Poisson's ratio between -1 and 0.5"),
    ("ENGINEERING", 9, "three moduli, three Poisson's ratios and three shear moduli of a solid"),
    ("ORTHO", 9, "D1111, D1122, D2222, D1133, D2233, D3333, D1212, D1313, D2323 of a solid"),
    ("ANISO", 21, "21 constants of a solid, D1111 first"),
];

/// Elastic constants.
pub(crate) fn elastic(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let kind = card.parameter("TYPE").unwrap_or("ISO").to_ascii_uppercase();
    let Some(&(law, count, constants)) = LAWS.iter().find(|law| kind.starts_with(law.0)) else {
        let expected = "TYPE=ISO, ENGINEERING CONSTANTS, ORTHO or ANISO: others are not computed with";
        return Err(reader.fault(card, None, &format!("TYPE={kind}"), expected));
    };
    if card.data.is_empty() {
        return Err(reader.fault(card, None, "no data", constants));
    }
    // Eight numbers a line; a temperature stands behind the constants.
    let mut rows = Vec::new();
    for lines in card.data.chunks(count.div_ceil(8)) {
        let mut numbers = Vec::new();
        for line in lines {
            let row = reader.reals(card, line)?;
            numbers.extend(row.into_iter().take(8));
        }
        // A modulus alone has a Poisson's ratio of zero, and no constants at the end are zeros.
        numbers.resize(count, 0.0);
        let Some(elasticity) = elasticity(law, &numbers) else {
            if rows.is_empty() {
                return Err(reader.fault(card, Some(&lines[0]), &lines[0].text, constants));
            }
            reader.leave(card, "a row of the table is that of no solid: those before it are taken");
            break;
        };
        rows.push((of_row(reader, card, lines, count)?, elasticity));
    }
    let rows = ascending(reader, card, rows);
    if let Some(solid) = current(reader, card)? {
        solid.elasticity = Some(rows[0].1);
        solid.by_temperature = if rows.len() > 1 { rows } else { vec![] };
    }
    Ok(())
}

/// Rows of a table whose temperatures ascend; of others the first one.
pub(crate) fn ascending<T>(
    reader: &mut Reader<'_>,
    card: &InpCard,
    mut rows: Vec<(f64, T)>,
) -> Vec<(f64, T)> {
    if rows.windows(2).any(|pair| pair[0].0 >= pair[1].0) {
        reader.leave(card, "its temperatures do not ascend: the first row of the table is taken");
        rows.truncate(1);
    }
    rows
}

/// The temperature that stands behind the constants of a row.
fn of_row(reader: &Reader<'_>, card: &InpCard, lines: &[DataLine], count: usize) -> Result<f64, DeckError> {
    let Some(line) = lines.get(count / 8) else { return Ok(0.0) };
    Ok(reader.reals(card, line)?.get(count % 8).copied().unwrap_or(0.0))
}

/// The elasticity of as many constants as its law has; `None` of no solid.
fn elasticity(law: &str, numbers: &[f64]) -> Option<Elasticity> {
    let three = |from: usize| [numbers[from], numbers[from + 1], numbers[from + 2]];
    let stiffness = match law {
        "ISO" => {
            let [young, poisson] = [numbers[0], numbers[1]];
            let sound = young > 0.0 && poisson > -1.0 && poisson < 0.5;
            return sound.then_some(Elasticity::Isotropic { young, poisson });
        }
        "ENGINEERING" => Stiffness::orthotropic(three(0), three(3), three(6))?,
        _ => {
            // Pairs of components in the order of the program: 11, 22, 33, 12, 13, 23.
            const ORDER: [usize; 6] = [0, 1, 2, 3, 5, 4];
            let pairs: Vec<[usize; 2]> = match law {
                "ORTHO" => {
                    vec![[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2], [3, 3], [4, 4], [5, 5]]
                }
                _ => (0..6).flat_map(|j| (0..=j).map(move |i| [i, j])).collect(),
            };
            let mut all = [[0.0; 6]; 6];
            for ([i, j], &value) in pairs.into_iter().zip(numbers) {
                let (i, j) = (ORDER[i], ORDER[j]);
                (all[i][j], all[j][i]) = (value, value);
            }
            Stiffness(all)
        }
    };
    stiffness.is_definite().then_some(Elasticity::Anisotropic(stiffness))
}

/// Axes of a material: whatever they are, they matter where a section of an anisotropic one names them.
pub(crate) fn orientation(reader: &mut Reader<'_>, card: &InpCard) {
    let Some(name) = card.parameter("NAME") else { return };
    let axes = axes(reader, card).unwrap_or(Orientation::Other);
    reader.orientations.insert(name.to_ascii_uppercase(), axes);
}

/// Axes by coordinates of points; none where they are given otherwise.
fn axes(reader: &Reader<'_>, card: &InpCard) -> Option<Orientation> {
    let system = card.parameter("SYSTEM").unwrap_or("RECTANGULAR").to_ascii_uppercase();
    let by_points = card.parameter("DEFINITION").is_none_or(|how| how.eq_ignore_ascii_case("COORDINATES"));
    if !by_points {
        return None;
    }
    let numbers = reader.reals(card, card.data.first()?).ok()?;
    let at =
        |from: usize| -> [f64; 3] { std::array::from_fn(|c| numbers.get(from + c).copied().unwrap_or(0.0)) };
    match system.as_str() {
        "RECTANGULAR" => {
            let origin = at(6);
            let (a, b) = (sub(at(0), origin), sub(at(3), origin));
            let third = cross(a, b);
            if norm(third) <= 1e-9 * norm(a) * norm(b) || !norm(third).is_finite() {
                return None;
            }
            let (first, third) = (unit(a), unit(third));
            let [first, second, _] = turned(reader, card, [first, cross(third, first), third])?;
            Some(Orientation::Fixed([first, second]))
        }
        // A point of the line, and another one.
        "CYLINDRICAL" => {
            let cylinder = Cylinder { point: at(0), axis: sub(at(3), at(0)) };
            let along = norm(cylinder.axis);
            if along == 0.0 || !along.is_finite() {
                return None;
            }
            let local = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let [first, second, _] = turned(reader, card, local)?;
            Some(Orientation::Turning(cylinder, [first, second]))
        }
        _ => None,
    }
}

/// Turns axes as a second line says: about one of them, the first one if it names none.
fn turned(reader: &Reader<'_>, card: &InpCard, mut axes: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    if let Some(line) = card.data.get(1) {
        let turn = reader.reals(card, line).ok()?;
        let (about, angle) = (turn.first().copied().unwrap_or(0.0), turn.get(1).copied().unwrap_or(0.0));
        let about = [1.0, 2.0, 3.0].iter().position(|axis| *axis == about.max(1.0))?;
        let (sine, cosine) = angle.to_radians().sin_cos();
        let (i, j) = ((about + 1) % 3, (about + 2) % 3);
        let [p, q] = [axes[i], axes[j]];
        axes[i] = std::array::from_fn(|c| cosine * p[c] + sine * q[c]);
        axes[j] = std::array::from_fn(|c| cosine * q[c] - sine * p[c]);
    }
    Some(axes)
}

/// The density.
pub(crate) fn density(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(line) = card.data.first() else {
        return Err(reader.fault(card, None, "no data", "a density"));
    };
    let density = reader.reals(card, line)?.first().copied().unwrap_or(0.0);
    if density <= 0.0 {
        return Err(reader.fault(card, Some(line), &line.text, "a density above 0"));
    }
    if let Some(solid) = current(reader, card)? {
        solid.density = density;
    }
    Ok(())
}

/// The material that cards of properties belong to.
pub(crate) fn current<'r>(
    reader: &'r mut Reader<'_>,
    card: &InpCard,
) -> Result<Option<&'r mut Solid>, DeckError> {
    match reader.material.clone() {
        Some(name) => Ok(reader.materials.get_mut(&name)),
        None => Err(reader.fault(card, None, &card.section(), "a *MATERIAL before it")),
    }
}
