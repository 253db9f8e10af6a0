//! The outline of a body as an SVG text, with its supports, forces and axes.

use std::fmt::Write as _;

use crate::html::escaped;
use crate::pictures::{COLORS, DrawResult, SIZE, number};
use crate::words::prefix_of;

/// Marks of an outline beside the body.
pub(crate) struct Outline<'a> {
    /// Above the picture.
    pub(crate) title: &'a str,
    /// Points to mark: colour index and position.
    pub(crate) marks: &'a [(usize, [f64; 3])],
    /// Unit of lengths; empty if it is not known.
    pub(crate) unit: &'a str,
    /// Forces: where they act, and their direction.
    pub(crate) forces: &'a [([f64; 3], [f64; 3])],
}

/// Draws the surface of a body, seen from a corner: the triangles that face the viewer, far ones first.
///
/// Neighbours of one shade share a path, which keeps the picture of some thousand triangles small enough for
/// a page.
pub(crate) fn outline(view: &Outline<'_>, nodes: &[[f64; 3]], triangles: &[[u32; 3]]) -> DrawResult {
    let corners = |t: &[u32; 3]| t.map(|node| nodes[node as usize]);
    let mut facing: Vec<[[f64; 3]; 3]> = triangles.iter().map(corners).filter(faces_viewer).collect();
    let distance = |t: &[[f64; 3]; 3]| t.iter().flatten().sum::<f64>();
    facing.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let pixel = Frame::around(facing.iter().flatten().map(|&p| project(p)));

    let (width, height) = SIZE;
    let mut svg = format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         xmlns=\"http://www.w3.org/2000/svg\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
         <text x=\"20\" y=\"26\" font-family=\"sans-serif\" font-size=\"16\">{}</text>\n\
         <g stroke=\"#5a6e8c\" stroke-opacity=\".5\" stroke-width=\".6\">\n",
        escaped(view.title)
    );
    for same in facing.chunk_by(|a, b| light(a) == light(b)) {
        let shade = light(&same[0]);
        write!(svg, "<path fill=\"#{shade:02x}{shade:02x}{:02x}\" d=\"", shade.saturating_add(12))?;
        for triangle in same {
            let [(a, b), (c, d), (e, f)] = triangle.map(|p| pixel.of(p));
            write!(svg, "M{a:.1} {b:.1}L{c:.1} {d:.1} {e:.1} {f:.1}z")?;
        }
        svg.push_str("\"/>\n");
    }
    svg.push_str("</g>\n");
    for (color, at) in view.marks {
        let ([r, g, b], (x, y)) = (COLORS[color % COLORS.len()], pixel.of(*at));
        writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>")?;
    }
    for (at, force) in view.forces {
        let size = force.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (dx, dy) = project(force.map(|x| x / size));
        // Seen from the front a force is as long as it is.
        let (head, back) = (pixel.of(*at), (-ARROW * dx, ARROW * dy));
        arrow(&mut svg, (head.0 + back.0, head.1 + back.1), head, "#dc3220")?;
    }
    // Axes, and how far the body reaches along each.
    let corner = (64.0, f64::from(height) - 64.0);
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let mut along = [0.0; 3];
        along[axis] = 1.0;
        let (dx, dy) = project(along);
        let end = (corner.0 + 34.0 * dx, corner.1 - 34.0 * dy);
        arrow(&mut svg, corner, end, "#5b6779")?;
        let (x, y) = (corner.0 + 46.0 * dx - 4.0, corner.1 - 46.0 * dy + 5.0);
        writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-family=\"sans-serif\" font-size=\"14\">{name}</text>"
        )?;
    }
    let (low, high) = nodes.iter().fold(([f64::MAX; 3], [f64::MIN; 3]), |(low, high), p| {
        (std::array::from_fn(|c| low[c].min(p[c])), std::array::from_fn(|c| high[c].max(p[c])))
    });
    let sides = sides([0, 1, 2].map(|c| high[c] - low[c]), view.unit);
    let (x, y) = (width - 20, height - 16);
    writeln!(
        svg,
        "<text x=\"{x}\" y=\"{y}\" text-anchor=\"end\" font-family=\"sans-serif\" font-size=\"14\">{sides}</text>"
    )?;
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// Lengths of the sides of a box, in one unit.
pub(crate) fn sides(lengths: [f64; 3], unit: &str) -> String {
    let longest = lengths.into_iter().fold(0.0, f64::max);
    let (factor, prefix) = if unit.is_empty() { (1.0, "") } else { prefix_of(longest) };
    let [a, b, c] = lengths.map(|length| number(length / factor));
    format!("{a} × {b} × {c} {prefix}{unit}").trim_end().into()
}

/// Length of the arrow of a force \[px\].
const ARROW: f64 = 60.0;

/// A line with a head at `to`.
fn arrow(svg: &mut String, from: (f64, f64), to: (f64, f64), color: &str) -> std::fmt::Result {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = (dx * dx + dy * dy).sqrt().max(1e-9);
    let (ux, uy) = (dx / length, dy / length);
    let at = |along: f64, across: f64| {
        format!("{:.1} {:.1}", to.0 - along * ux - across * uy, to.1 - along * uy + across * ux)
    };
    let (tail, neck, left, right) =
        (format!("{:.1} {:.1}", from.0, from.1), at(7.0, 0.0), at(9.0, 4.0), at(9.0, -4.0));
    writeln!(svg, "<path d=\"M{tail}L{neck}\" stroke=\"{color}\" stroke-width=\"2\" fill=\"none\"/>")?;
    writeln!(svg, "<path d=\"M{}L{left} {right}z\" fill=\"{color}\"/>", at(0.0, 0.0))
}

/// An isometric view: x to the lower right, y to the lower left, z up; the viewer stands at (1, 1, 1).
pub(crate) fn project(p: [f64; 3]) -> (f64, f64) {
    ((p[0] - p[1]) * 0.866, (p[0] + p[1]) * -0.5 + p[2])
}

/// True of triangles that show their outside.
pub(crate) fn faces_viewer(triangle: &[[f64; 3]; 3]) -> bool {
    normal(triangle).iter().sum::<f64>() > 0.0
}

/// Twice the area along the outward normal.
fn normal([a, b, c]: &[[f64; 3]; 3]) -> [f64; 3] {
    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// From the view plane to pixels.
pub(crate) struct Frame {
    center: (f64, f64),
    scale: f64,
}

impl Frame {
    /// Fits all points below the title.
    pub(crate) fn around(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let empty = (f64::MAX, f64::MIN);
        let ((x0, x1), (y0, y1)) = points.fold((empty, empty), |((x0, x1), (y0, y1)), (x, y)| {
            ((x0.min(x), x1.max(x)), (y0.min(y), y1.max(y)))
        });
        let fit = |pixels: u32, margin: f64, extent: f64| {
            (f64::from(pixels) - margin) / extent.max(f64::MIN_POSITIVE)
        };
        let scale = fit(SIZE.0, 60.0, x1 - x0).min(fit(SIZE.1, 90.0, y1 - y0));
        Self { center: (0.5 * (x0 + x1), 0.5 * (y0 + y1)), scale }
    }

    pub(crate) fn of(&self, p: [f64; 3]) -> (f64, f64) {
        let (x, y) = project(p);
        let middle = (0.5 * f64::from(SIZE.0), 0.5 * f64::from(SIZE.1) + 15.0);
        (middle.0 + self.scale * (x - self.center.0), middle.1 - self.scale * (y - self.center.1))
    }
}

/// Grey of a triangle lit from above the viewer.
pub(crate) fn light(triangle: &[[f64; 3]; 3]) -> u8 {
    let n = normal(triangle);
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let cosine = (0.2 * n[0] + 0.5 * n[1] + 0.84 * n[2]) / length;
    (170.0 + 70.0 * cosine).clamp(90.0, 240.0) as u8
}
