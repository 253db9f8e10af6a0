//! The surface of a body in colours: one value for each loadable node, on a logarithmic scale.

use std::fmt::Write as _;

use vademecum_study::log_scale::LogScale;

use crate::outline::{Frame, faces_viewer, light, project};
use crate::pictures::{DrawResult, SIZE};

/// From the least value to the largest; readable without colour, since it grows lighter.
const RAMP: [[u8; 3]; 6] = [
    [0x45, 0x52, 0x9f],
    [0x32, 0x78, 0xb8],
    [0x1f, 0x9b, 0xab],
    [0x4f, 0xbd, 0x8b],
    [0xb0, 0xd8, 0x65],
    [0xfb, 0xe4, 0x57],
];
/// Shades of the ramp in a picture: neighbours of one shade share a path.
const SHADES: usize = 48;

/// Colour at a place of the ramp.
fn color(place: f64) -> [f64; 3] {
    let along = place * (RAMP.len() - 1) as f64;
    let left = (along as usize).min(RAMP.len() - 2);
    let share = along - left as f64;
    [0, 1, 2].map(|c| f64::from(RAMP[left][c]) * (1.0 - share) + f64::from(RAMP[left + 1][c]) * share)
}

/// Draws a surface that moves, by values from 0 to 1 of its nodes.
pub(crate) fn shape(title: &str, values: &[f64], nodes: &[[f64; 3]], triangles: &[[u32; 3]]) -> DrawResult {
    let shade = |t: &[u32; 3]| {
        let sum: f64 = t.iter().filter_map(|&node| values.get(node as usize)).sum();
        Some((sum / 3.0 * SHADES as f64).round() as usize)
    };
    let all = triangles.iter().map(|t| (t.map(|node| nodes[node as usize]), shade(t)));
    let mut svg = surface(title, all.collect())?;
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// Draws the triangles of a surface that face the viewer: those that can be loaded in the colour of the mean
/// place of their nodes' values, the others grey. `values` are of the first nodes, and a node of value zero
/// says nothing, since no push moves it; `words` says a value.
///
/// # Errors
/// If no value is above zero.
pub(crate) fn colored(
    title: &str,
    words: &dyn Fn(f64) -> String,
    values: &[f64],
    nodes: &[[f64; 3]],
    (loadable, others): (&[[u32; 3]], &[[u32; 3]]),
) -> DrawResult {
    let Some(scale) = LogScale::of(values) else { return Err("nothing to draw".into()) };
    let corners = |t: &[u32; 3]| t.map(|node| nodes[node as usize]);
    let shade = |t: &[u32; 3]| {
        let known = t.iter().filter_map(|&node| values.get(node as usize)).filter(|&&value| value > 0.0);
        let (sum, count) =
            known.fold((0.0, 0.0), |(sum, count), &value| (sum + scale.place(value), count + 1.0));
        (count > 0.0).then(|| (sum / count * SHADES as f64).round() as usize)
    };
    let colored = loadable.iter().map(|t| (corners(t), shade(t)));
    let grey = others.iter().map(|t| (corners(t), None));
    let mut svg = surface(title, colored.chain(grey).collect())?;
    legend(&mut svg, &scale, words)?;
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// A triangle and its shade; grey without one.
type Shaded = ([[f64; 3]; 3], Option<usize>);

/// The beginning of a picture: its title and the triangles that face the viewer.
fn surface(title: &str, all: Vec<Shaded>) -> DrawResult {
    let mut facing: Vec<Shaded> = all.into_iter().filter(|(triangle, _)| faces_viewer(triangle)).collect();
    let distance = |t: &[[f64; 3]; 3]| t.iter().flatten().sum::<f64>();
    facing.sort_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)));
    let frame = Frame::around(facing.iter().flat_map(|(triangle, _)| *triangle).map(project));

    let (width, height) = SIZE;
    let mut svg = format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         xmlns=\"http://www.w3.org/2000/svg\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
         <text x=\"20\" y=\"26\" font-family=\"sans-serif\" font-size=\"16\">{title}</text>\n\
         <g stroke=\"#223\" stroke-opacity=\".3\" stroke-width=\".5\">\n"
    );
    let look = |(triangle, shade): &Shaded| (light(triangle), *shade);
    for same in facing.chunk_by(|a, b| look(a) == look(b)) {
        let (light, shade) = look(&same[0]);
        // A little of the light, so that the shape is seen and the colour is read.
        let bright = 0.75 + 0.25 * f64::from(light) / 240.0;
        let base = shade.map_or([176.0; 3], |shade| color(shade as f64 / SHADES as f64));
        let [r, g, b] = base.map(|channel| (bright * channel).round() as u8);
        write!(svg, "<path fill=\"#{r:02x}{g:02x}{b:02x}\" d=\"")?;
        for (triangle, _) in same {
            let [(a, b), (c, d), (e, f)] = triangle.map(|p| frame.of(p));
            write!(svg, "M{a:.1} {b:.1}L{c:.1} {d:.1} {e:.1} {f:.1}z")?;
        }
        svg.push_str("\"/>\n");
    }
    svg.push_str("</g>\n");
    Ok(svg)
}

/// The ramp in the upper right corner, with its ends and its middle, which is their geometric mean.
fn legend(svg: &mut String, scale: &LogScale, words: &dyn Fn(f64) -> String) -> std::fmt::Result {
    const WIDE: u32 = 240;
    let (left, top) = (SIZE.0 - WIDE - 40, 14);
    svg.push_str("<g shape-rendering=\"crispEdges\">");
    for part in 0..SHADES {
        let [r, g, b] = color((part as f64 + 0.5) / SHADES as f64).map(|channel| channel.round() as u8);
        let (x, step) = (left + part as u32 * WIDE / SHADES as u32, WIDE / SHADES as u32);
        write!(
            svg,
            "<rect x=\"{x}\" y=\"{top}\" width=\"{step}\" height=\"12\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>"
        )?;
    }
    svg.push_str("</g>\n");
    let ends = [scale.low, scale.middle(), scale.high];
    for (place, value) in ends.into_iter().enumerate() {
        let x = left + place as u32 * WIDE / 2;
        let y = top + 28;
        writeln!(
            svg,
            "<text x=\"{x}\" y=\"{y}\" font-family=\"sans-serif\" font-size=\"13\" \
             text-anchor=\"middle\">{}</text>",
            words(value)
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_runs_from_end_to_end() {
        assert_eq!([0.0, 1.0].map(color), [RAMP[0], RAMP[5]].map(|rgb| rgb.map(f64::from)));
    }

    #[test]
    fn a_worse_place_has_another_colour_and_one_that_cannot_be_pushed_is_grey() {
        let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let triangles = [[0, 1, 2], [1, 3, 2]];
        let draw = |values: [f64; 4], loadable| {
            colored("t", &|x| format!("{x}"), &values, &nodes, triangles.split_at(loadable)).expect("drawn")
        };
        let colors = |svg: &str| {
            let fills = svg.split("<path fill=\"").skip(1).map(|path| path[..7].to_string());
            fills.collect::<Vec<_>>()
        };
        let both = colors(&draw([1e-3, 1e-3, 1e-3, 1e-1], 2));
        assert_eq!(both.len(), 2);
        assert_ne!(both[0], both[1]);
        let one = draw([1e-3, 1e-2, 1e-1, 1e-1], 1);
        assert!(
            colors(&one).iter().any(|fill| fill[1..3] == fill[3..5] && fill[3..5] == fill[5..7]),
            "{one}"
        );
        assert!(one.contains(">0.001<") && one.contains(">0.1<"), "{one}");
    }
}
