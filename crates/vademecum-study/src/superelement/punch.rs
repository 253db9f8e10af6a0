//! A superelement as bulk data of Nastran: grid points of the interfaces, scalar points of the modes, and the
//! matrices as DMIG entries.
//!
//! Fields are 16 characters wide, so a number has ten significant digits at least.

use std::fmt::Write as _;

use vademecum_build::Matrix;
use vademecum_build::prepared::Interface;

use super::body::ReducedBody;

/// Names of the matrices: mass, stiffness, damping.
const NAMES: [&str; 3] = ["MAAX", "KAAX", "BAAX"];

/// Width of a field.
const WIDTH: usize = 16;

/// A row of the matrices: a grid point and its component, or a scalar point and 0.
type Row = (u64, usize);

/// The matrices as DMIG entries of Nastran, with the grid points of the interfaces.
pub fn punch(body: &ReducedBody) -> String {
    let found = &body.superelement;
    let numbering = Numbering::new(body);
    let mut text = String::from("$ Superelement of vademecum: formats/superelement-1.md\n");
    text.push_str("$ Case control: K2GG = KAAX  M2GG = MAAX  B2GG = BAAX\n");
    for (interface, points) in found.interfaces.iter().zip(&numbering.points) {
        writeln!(text, "$ Interface {} of kind {}", printable(&interface.name), interface.kind)
            .expect("writing to a string cannot fail");
        grid_points(&mut text, body, interface, points);
    }
    for point in &numbering.scalars {
        line(&mut text, "SPOINT*", &[point.to_string()]);
    }
    for (name, matrix) in NAMES.iter().zip([&found.mass, &found.stiffness, &found.damping]) {
        dmig(&mut text, name, matrix, &numbering.rows);
    }
    text
}

/// Grid points of the interfaces and scalar points of the other coordinates.
struct Numbering {
    /// Of each interface the number of each grid point: its nodes, or the frame.
    points: Vec<Vec<u64>>,
    scalars: Vec<u64>,
    rows: Vec<Row>,
}

impl Numbering {
    fn new(body: &ReducedBody) -> Self {
        let found = &body.superelement;
        let mut next = body.node_ids.iter().max().map_or(0, |largest| *largest) + 1;
        let (mut points, mut rows) = (vec![], vec![]);
        for interface in &found.interfaces {
            let frame = next;
            let mut own: Vec<u64> = vec![];
            for coordinate in &interface.coordinates {
                let point = coordinate.node.map_or(frame, |node| body.node_id(node));
                if own.last() != Some(&point) {
                    own.push(point);
                }
                rows.push((point, coordinate.motion + 1));
            }
            next += u64::from(own.contains(&frame));
            points.push(own);
        }
        let scalars: Vec<u64> = (next..).take(found.mass.nrows() - found.coordinates).collect();
        rows.extend(scalars.iter().map(|&point| (point, 0)));
        Self { points, scalars, rows }
    }
}

fn grid_points(text: &mut String, body: &ReducedBody, interface: &Interface, points: &[u64]) {
    let of_nodes = interface.coordinates.iter().any(|coordinate| coordinate.node.is_some());
    if of_nodes {
        let mut nodes: Vec<u32> = interface.coordinates.iter().filter_map(|own| own.node).collect();
        nodes.dedup();
        for (&point, &node) in points.iter().zip(&nodes) {
            // Rotations of a node of a solid are none of its dofs.
            grid(text, point, body.nodes[node as usize], (0, "456"));
        }
        return;
    }
    let [point] = points else { return };
    let (origin, [x, _, z]) = (interface.origin, interface.axes);
    let own = interface.axes != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    if own {
        let at = |axis: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| origin[c] + axis[c]) };
        let numbers = [origin, at(z), at(x)].concat();
        let mut fields = vec![point.to_string(), "0".into()];
        fields.extend(numbers.into_iter().map(number));
        line(text, "CORD2R*", &fields);
    }
    grid(text, *point, origin, (if own { *point } else { 0 }, ""));
}

/// A grid point with the system of its displacements and the components that are held.
fn grid(text: &mut String, point: u64, at: [f64; 3], (system, held): (u64, &str)) {
    let [x, y, z] = at.map(number);
    line(text, "GRID*", &[point.to_string(), "0".into(), x, y, z, system.to_string(), held.into()]);
}

/// The lower triangle of a symmetric matrix, column by column.
fn dmig(text: &mut String, name: &str, matrix: &Matrix, rows: &[Row]) {
    // Name, 0, form 6: symmetric, 2: real in double precision, 0: as the machine has it.
    writeln!(text, "DMIG    {name:<8}{:>8}{:>8}{:>8}{:>8}", 0, 6, 2, 0)
        .expect("writing to a string cannot fail");
    for (column, &(point, component)) in rows.iter().enumerate() {
        let below = (column..rows.len()).filter(|&row| matrix[(row, column)] != 0.0);
        let mut fields = vec![name.to_string(), point.to_string(), component.to_string(), String::new()];
        for row in below {
            let (point, component) = rows[row];
            fields.extend([point.to_string(), component.to_string(), number(matrix[(row, column)])]);
            fields.push(String::new());
        }
        if fields.len() > 4 {
            line(text, "DMIG*", &fields);
        }
    }
}

/// An entry in fields of 16 characters, four on a line.
fn line(text: &mut String, name: &str, fields: &[String]) {
    for (place, four) in fields.chunks(4).enumerate() {
        let first = if place == 0 { name } else { "*" };
        let mut line = format!("{first:<8}");
        for (field, content) in four.iter().enumerate() {
            // The name of a matrix stands to the left, numbers to the right.
            if place == 0 && field == 0 && name == "DMIG*" {
                write!(line, "{content:<WIDTH$}").expect("writing to a string cannot fail");
            } else {
                write!(line, "{content:>WIDTH$}").expect("writing to a string cannot fail");
            }
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    // Two lines make an entry of wide fields, at least.
    if fields.len() <= 4 {
        text.push_str("*\n");
    }
}

/// A number in 16 characters, with the `D` of double precision.
fn number(value: f64) -> String {
    for digits in (0..14).rev() {
        let text = format!("{value:.digits$E}");
        let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
        let sign = if exponent.starts_with('-') { '-' } else { '+' };
        let exponent = exponent.trim_start_matches('-');
        let dot = if mantissa.contains('.') { "" } else { "." };
        let found = format!("{mantissa}{dot}D{sign}{exponent:0>2}");
        if found.len() <= WIDTH {
            return found;
        }
    }
    "0.D+00".into()
}

/// A name on one line of a comment.
fn printable(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_ten_digits_in_sixteen_characters() {
        for (value, text) in [
            (0.0, "0.0000000000D+00"),
            (1.0, "1.0000000000D+00"),
            (-2.0 / 3.0, "-6.666666667D-01"),
            (2.1e11, "2.1000000000D+11"),
            (-1.0e-200, "-1.00000000D-200"),
        ] {
            assert_eq!(number(value), text);
            let read: f64 = text.replace('D', "E").parse().unwrap();
            assert!((read - value).abs() <= 1e-9 * value.abs());
        }
    }
}
