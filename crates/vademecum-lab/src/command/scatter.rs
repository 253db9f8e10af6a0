//! A chart of methods: points on two logarithmic axes with a word beside each.

use vademecum_cli::front::{Anchor, Axis, COLORS, Chart, DrawResult, Frame, Picture, Shape};

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
    let axis = |value: fn(&(f64, f64, String)) -> f64| {
        let (low, high) =
            all.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(value(p)), b.max(value(p))));
        let power = |exponent: f64| 10f64.powf(exponent);
        Axis { low: power((low / 1.2).log10().floor()), high: power((high * 1.6).log10().ceil()), log: true }
    };
    let mut picture = Picture::new(900.0 + LEGEND, 600.0);
    picture.text((20.0, 26.0), 16.0, Anchor::Start, chart.title);
    let frame = Frame { ends: [86.0, 42.0, 882.0, 554.0], x: axis(|p| p.0), y: axis(|p| p.1) };
    frame.draw(&mut picture, chart.x, chart.y);
    frame.line(&mut picture, front, [215; 3], 9.0, &[]);
    for (i, cloud) in clouds.iter().enumerate() {
        // Colours repeat after five clouds; hollow marks tell the second five from the first.
        let (color, hollow) = (COLORS[i % COLORS.len()], i >= COLORS.len());
        let points = cloud.points.iter().filter(usable).map(|p| frame.at((p.0, p.1)));
        let points: Vec<(f64, f64)> = points.collect();
        let dot = |at| Shape::Dot { at, radius: 4.0, color, hollow };
        picture.add(Shape::Line { points: points.clone(), color, width: 1.0, dash: &[] });
        points.into_iter().for_each(|at| picture.add(dot(at)));
        let y = 62.0 + 22.0 * i as f64;
        picture.add(dot((908.0, y)));
        picture.text((920.0, y + 4.0), 12.0, Anchor::Start, cloud.name.as_str());
    }
    let pixel = |x: f64| x.round() as i32;
    let marked: Vec<((i32, i32), &str)> = all
        .iter()
        .map(|p| (frame.at((p.0, p.1)), p.2.as_str()))
        .map(|((x, y), word)| ((pixel(x), pixel(y)), word))
        .collect();
    for ((x, y), word) in words_beside(&marked) {
        let base = (f64::from(x), f64::from(y) + 0.8 * f64::from(WORD));
        picture.text(base, f64::from(WORD), Anchor::Start, word);
    }
    Ok(picture.svg())
}

/// Width of the names beside a scatter \[px\].
const LEGEND: f64 = 240.0;
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
