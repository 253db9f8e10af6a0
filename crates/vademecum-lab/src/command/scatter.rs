//! A chart of methods: points on two logarithmic axes with a word beside each.

use plotters::prelude::*;
use vademecum_cli::front::{COLORS, Chart, DrawResult, axes, named};

/// Points of one method in a [`scatter`].
pub struct Cloud {
    /// Shown in the legend.
    pub name: String,
    /// Points (x, y), joined in this order, each with a word beside it.
    pub points: Vec<(f64, f64, String)>,
}

/// Draws points on two logarithmic axes, those of one cloud joined by a thin line, and `front` as a wide
/// pale line behind them. Points that are not positive are left out.
pub fn scatter(chart: &Chart<'_>, clouds: &[Cloud], front: &[(f64, f64)]) -> DrawResult {
    let usable = |p: &&(f64, f64, String)| p.0.is_finite() && p.1.is_finite() && p.0 > 0.0 && p.1 > 0.0;
    let all: Vec<&(f64, f64, String)> = clouds.iter().flat_map(|c| c.points.iter().filter(usable)).collect();
    if all.is_empty() {
        return Err("nothing to draw".into());
    }
    // Whole decades, with room for the words beside the points: part of one gets a label at every tenth.
    let range = |value: fn(&(f64, f64, String)) -> f64| {
        let (low, high) =
            all.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(value(p)), b.max(value(p))));
        10f64.powf((low / 1.2).log10().floor())..10f64.powf((high * 1.6).log10().ceil())
    };
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (900 + LEGEND, 600)).into_drawing_area();
    root.fill(&WHITE)?;
    let (area, beside) = named(&root, chart, &[])?.split_horizontally(900);
    let mut context = axes(&area, chart, range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
    let pale = RGBColor(215, 215, 215);
    context.draw_series(LineSeries::new(front.iter().copied(), pale.stroke_width(9)))?;
    for (i, cloud) in clouds.iter().enumerate() {
        // Colours repeat after five clouds; hollow marks tell the second five from the first.
        let (color, solid) = (COLORS[i % COLORS.len()], i < COLORS.len());
        let style = if solid { color.filled() } else { color.stroke_width(2) };
        let points: Vec<&(f64, f64, String)> = cloud.points.iter().filter(usable).collect();
        context.draw_series(LineSeries::new(points.iter().map(|p| (p.0, p.1)), color.stroke_width(1)))?;
        context.draw_series(points.iter().map(|p| Circle::new((p.0, p.1), 4, style)))?;
        let y = 20 + 22 * i as i32;
        beside.draw(&Circle::new((8, y), 4, style))?;
        beside.draw(&Text::new(cloud.name.as_str(), (20, y - 8), ("sans-serif", 14)))?;
    }
    let marked: Vec<((i32, i32), &str)> =
        all.iter().map(|p| (context.backend_coord(&(p.0, p.1)), p.2.as_str())).collect();
    for (place, word) in words_beside(&marked) {
        root.draw(&Text::new(word, place, ("sans-serif", WORD as u32)))?;
    }
    root.present()?;
    drop((context, area, beside, root));
    Ok(svg)
}

/// Width of the names beside a scatter \[px\].
const LEGEND: u32 = 240;
/// Height of the words beside points \[px\].
const WORD: i32 = 12;

/// The upper left corners of words beside points \[px\]: none of them covers another one or a point. A word
/// that stands beside a point already is not said again beside one that can hardly be told from it, and one
/// that finds no free place near its point is left out.
fn words_beside<'a>(points: &[((i32, i32), &'a str)]) -> Vec<((i32, i32), &'a str)> {
    const AWAY: [i32; 4] = [6, 18, 32, 48];
    const RADIUS: i32 = 4;
    let overlap = |a: [i32; 4], b: [i32; 4]| a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
    let mut taken: Vec<[i32; 4]> =
        points.iter().map(|&((x, y), _)| [x - RADIUS, y - RADIUS, x + RADIUS, y + RADIUS]).collect();
    let mut said: Vec<((i32, i32), &str)> = vec![];
    let mut placed = vec![];
    for &((x, y), word) in points {
        let near = |&((a, b), other): &((i32, i32), &str)| {
            other == word && (a - x).abs() <= 3 * RADIUS && (b - y).abs() <= 3 * RADIUS
        };
        if said.iter().any(near) {
            continue;
        }
        said.push(((x, y), word));
        // Wide letters, so that a word is never wider than it is taken for.
        let width = 7 * word.chars().count() as i32;
        let corners = AWAY.iter().flat_map(|&away| {
            let (right, left) = (x + away, x - away - width);
            let (above, below) = (y - away - WORD / 2, y + away - WORD / 2);
            [(right, above), (right, below), (left, above), (left, below), (x - width / 2, above - 6)]
        });
        let boxed = |(x, y): (i32, i32)| [x, y, x + width, y + WORD];
        let free = |corner: &(i32, i32)| !taken.iter().any(|&other| overlap(boxed(*corner), other));
        if let Some(corner) = corners.into_iter().find(free) {
            taken.push(boxed(corner));
            placed.push((corner, word));
        }
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_beside_points_cover_nothing() {
        let words: Vec<String> = (0..12).map(|k| format!("{k}, 6 terms")).collect();
        let place = |k: i32| (100 + 5 * (k % 4), 100 + 9 * (k / 4));
        let points: Vec<((i32, i32), &str)> =
            words.iter().zip(0..).map(|(word, k)| (place(k), word.as_str())).collect();
        let placed = words_beside(&points);
        assert!(placed.len() > 6, "{placed:?}");
        let boxed = |&((x, y), word): &((i32, i32), &str)| [x, y, x + 7 * word.len() as i32, y + WORD];
        for (k, a) in placed.iter().map(boxed).enumerate() {
            for b in placed[..k].iter().map(boxed) {
                assert!(a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1], "{a:?} {b:?}");
            }
            for ((x, y), _) in &points {
                assert!(!((a[0]..a[2]).contains(x) && (a[1]..a[3]).contains(y)), "{a:?} {x} {y}");
            }
        }
        let twice = [((50, 50), "8"), ((52, 50), "8"), ((90, 50), "8")];
        assert_eq!(words_beside(&twice).len(), 2, "one word for two points in one place");
    }
}
