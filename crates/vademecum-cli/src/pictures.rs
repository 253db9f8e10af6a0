//! Pictures as SVG texts: line charts and the outline of a body. Nothing is written to a file here.

use std::error::Error;
use std::fmt::Write as _;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

/// A named line.
pub struct Series<'a> {
    /// Shown in the legend.
    pub name: &'a str,
    /// Points (x, y).
    pub points: Vec<(f64, f64)>,
}

/// What a chart says about itself.
pub struct Chart<'a> {
    /// Above the chart.
    pub title: &'a str,
    /// Quantity and unit along x.
    pub x: &'a str,
    /// Quantity and unit along y.
    pub y: &'a str,
    /// Logarithmic y axis; points that are not positive are left out.
    pub log_y: bool,
}

/// Points of one method in a [`scatter`].
pub struct Cloud {
    /// Shown in the legend.
    pub name: String,
    /// Points (x, y), joined in this order, each with a word beside it.
    pub points: Vec<(f64, f64, String)>,
}

/// Colours that stay apart in print and for colour-blind readers.
const COLORS: [RGBColor; 5] = [
    RGBColor(0, 90, 181),
    RGBColor(220, 50, 32),
    RGBColor(0, 0, 0),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
];

/// Length of dashes and gaps of the lines of a chart \[px\]; without gaps the line is whole.
const DASHES: [(u32, u32); 4] = [(1, 0), (7, 7), (2, 5), (12, 4)];

/// Size of every picture \[px\].
pub(crate) const SIZE: (u32, u32) = (900, 480);

/// The SVG, or why nothing could be drawn.
pub type DrawResult = Result<String, Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Axes<'a, X, Y> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>;

/// Draws a line chart.
pub fn line_chart(chart: &Chart<'_>, series: &[Series<'_>]) -> DrawResult {
    let usable = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite() && (!chart.log_y || p.1 > 0.0);
    let points: Vec<(f64, f64)> =
        series.iter().flat_map(|s| s.points.iter().filter(usable)).copied().collect();
    if points.is_empty() {
        return Err("nothing to draw".into());
    }
    let bounds = |value: fn(&(f64, f64)) -> f64| {
        let values = points.iter().map(value);
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        if high > low {
            (low, high)
        } else {
            (low - 0.5 * low.abs() - 1e-300, high + 0.5 * high.abs() + 1e-300)
        }
    };
    let ((x0, x1), (y0, y1)) = (bounds(|p| p.0), bounds(|p| p.1));
    if chart.log_y {
        draw(chart, series, Mark::Line, x0..x1, (y0 / 2.0..y1 * 2.0).log_scale())
    } else {
        let margin = 0.05 * (y1 - y0);
        draw(chart, series, Mark::Line, x0..x1, y0 - margin..y1 + margin)
    }
}

/// Draws the points of each series as dots on a logarithmic y axis, against a plain or a logarithmic x axis;
/// all are positive.
pub fn dot_chart(chart: &Chart<'_>, log_x: bool, series: &[Series<'_>]) -> DrawResult {
    let all = || series.iter().flat_map(|s| &s.points);
    let range = |value: fn(&(f64, f64)) -> f64| {
        all().map(value).fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
    };
    let ((x0, x1), (y0, y1)) = (range(|p| p.0), range(|p| p.1));
    if all().any(|p| !(p.1 > 0.0 && p.0.is_finite())) || x1 <= x0 {
        return Err("nothing to draw".into());
    }
    let (low, high) = (y0 / 1.5, y1 * 1.5);
    let y = (low..high).log_scale().with_key_points(round_numbers(low, high));
    if log_x {
        let margin = (x1 / x0).powf(0.03);
        let (low, high) = (x0 / margin, x1 * margin);
        let x = (low..high).log_scale().with_key_points(round_numbers(low, high));
        draw(chart, series, Mark::Dots, x, y)
    } else {
        let margin = 0.03 * (x1 - x0);
        draw(chart, series, Mark::Dots, x0 - margin..x1 + margin, y)
    }
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
    let root = SVGBackend::with_string(&mut svg, (SIZE.0, SIZE.1 + 120)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut context = axes(&root, chart, range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
    let pale = RGBColor(215, 215, 215);
    context.draw_series(LineSeries::new(front.iter().copied(), pale.stroke_width(9)))?;
    for (i, cloud) in clouds.iter().enumerate() {
        // Colours repeat after five clouds; hollow marks tell the second five from the first.
        let (color, solid) = (COLORS[i % COLORS.len()], i < COLORS.len());
        let style = if solid { color.filled() } else { color.stroke_width(2) };
        let points: Vec<&(f64, f64, String)> = cloud.points.iter().filter(usable).collect();
        context.draw_series(LineSeries::new(points.iter().map(|p| (p.0, p.1)), color.stroke_width(1)))?;
        context
            .draw_series(points.iter().map(|p| Circle::new((p.0, p.1), 4, style)))?
            .label(cloud.name.as_str())
            .legend(move |(x, y)| Circle::new((x + 12, y), 4, style));
        let word = |p: &&(f64, f64, String)| {
            EmptyElement::at((p.0, p.1)) + Text::new(p.2.clone(), (6, -12), ("sans-serif", 12))
        };
        context.draw_series(points.iter().map(word))?;
    }
    legend(&mut context)?;
    root.present()?;
    drop((context, root));
    Ok(svg)
}

/// Zero where a place on a linear axis differs from it by rounding only.
fn near_zero(value: f64, extent: f64) -> f64 {
    if value.abs() < 1e-9 * extent { 0.0 } else { value }
}

/// A label of at most four figures: whole numbers without a point, very small and very large ones with a
/// power of ten.
fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-2..1e5).contains(&value.abs());
    let text = if plain { format!("{value:.3}") } else { format!("{value:.1e}") };
    let (digits, power) = text.split_once('e').unwrap_or((&text, ""));
    let digits =
        if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    let digits = if digits == "-0" { "0" } else { digits };
    if power.is_empty() { digits.into() } else { format!("{digits}e{power}") }
}

/// Numbers for a logarithmic axis: 1, 2 and 5 of each decade while that is not too many, powers of ten
/// beyond.
fn round_numbers(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let steps: &[f64] = if (high / low).log10() <= 3.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let stride = 1 + (last - first) as usize / 10;
    // Read from decimals: powers of ten are not exact.
    let number = |power: i32, step: f64| format!("{step}e{power}").parse().unwrap_or(f64::NAN);
    let decade = |power: i32| steps.iter().map(move |&step| number(power, step));
    let all = (first..=last).step_by(stride).flat_map(decade);
    all.filter(|v| (low..=high).contains(v)).collect()
}

/// How the points of a series are shown.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    Line,
    Dots,
}

/// Title, axes and grid.
fn axes<'a, X, Y>(
    root: &Area<'a>,
    chart: &Chart<'_>,
    x: X,
    y: Y,
) -> Result<Axes<'a, X::CoordDescType, Y::CoordDescType>, Box<dyn Error>>
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
{
    let mut context = ChartBuilder::on(root)
        .caption(chart.title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(86)
        .build_cartesian_2d(x, y)?;
    let range = context.y_range();
    let extent = if chart.log_y { 0.0 } else { range.end - range.start };
    context
        .configure_mesh()
        .x_desc(chart.x)
        .y_desc(chart.y)
        .label_style(("sans-serif", 14))
        .light_line_style(RGBColor(238, 238, 238))
        .x_label_formatter(&|v: &f64| number(*v))
        .y_label_formatter(&|v: &f64| number(near_zero(*v, extent)))
        .draw()?;
    Ok(context)
}

/// The names of all series, each beside its mark.
fn legend<X, Y>(context: &mut Axes<'_, X, Y>) -> Result<(), Box<dyn Error>>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    context
        .configure_series_labels()
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.4))
        .label_font(("sans-serif", 14))
        .draw()?;
    Ok(())
}

fn draw<X, Y>(chart: &Chart<'_>, series: &[Series<'_>], mark: Mark, x: X, y: Y) -> DrawResult
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
{
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let mut context = axes(&root, chart, x, y)?;
    for (i, line) in series.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let style = color.stroke_width(2);
        let usable = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite() && (!chart.log_y || p.1 > 0.0);
        let points: Vec<(f64, f64)> = line.points.iter().copied().filter(usable).collect();
        if mark == Mark::Dots {
            let dot = color.mix(0.7).filled();
            context
                .draw_series(points.iter().map(|&p| Circle::new(p, 3, dot)))?
                .label(line.name)
                .legend(move |(x, y)| Circle::new((x + 12, y), 3, dot));
            continue;
        }
        // A line that covers the one before it shall not hide it.
        let (dash, gap) = DASHES[i % DASHES.len()];
        let drawn = match gap {
            0 => context.draw_series(LineSeries::new(points, style))?,
            gap => context.draw_series(DashedLineSeries::new(points, dash, gap, style))?,
        };
        drawn.label(line.name).legend(move |(x, y)| match gap {
            0 => PathElement::new(vec![(x, y), (x + 24, y)], style).into_dyn(),
            gap => DashedPathElement::new(vec![(x, y), (x + 24, y)], dash, gap, style).into_dyn(),
        });
    }
    if series.len() > 1 {
        legend(&mut context)?;
    }
    root.present()?;
    drop((context, root));
    Ok(svg)
}

/// What an outline shows beside the body.
pub struct Outline<'a> {
    /// Above the picture.
    pub title: &'a str,
    /// Points to mark: colour index and position.
    pub marks: &'a [(usize, [f64; 3])],
}

/// Draws the surface of a body, seen from a corner: the triangles that face the viewer, far ones first.
///
/// Written by hand and not by plotters, which makes two elements of each triangle: neighbours of one shade
/// share a path, which keeps the picture of some thousand triangles small enough for a page.
pub fn outline(view: &Outline<'_>, nodes: &[[f64; 3]], triangles: &[[u32; 3]]) -> DrawResult {
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
        view.title
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
        let (RGBColor(r, g, b), (x, y)) = (COLORS[color % COLORS.len()], pixel.of(*at));
        writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>")?;
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// An isometric view: x to the lower right, y to the lower left, z up; the viewer stands at (1, 1, 1).
pub(crate) fn project(p: [f64; 3]) -> (f64, f64) {
    ((p[0] - p[1]) * 0.866, (p[0] + p[1]) * -0.5 + p[2])
}

/// Whether a triangle shows its outside.
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

/// Draws horizontal bars: label, length, what stands at its end. Lengths are shares of the longest.
pub fn bars(title: &str, rows: &[(String, f64, String)]) -> DrawResult {
    const ROW: i32 = 26;
    const LEFT: i32 = 214;
    let longest = rows.iter().map(|row| row.1).fold(f64::MIN_POSITIVE, f64::max);
    let height = 60 + ROW * rows.len() as i32;
    let room = f64::from(SIZE.0 as i32 - LEFT - 170);
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (SIZE.0, height as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    root.draw(&Text::new(title, (20, 14), ("sans-serif", 20)))?;
    for (i, (label, length, value)) in rows.iter().enumerate() {
        let y = 46 + ROW * i as i32;
        let end = LEFT + (room * length / longest).round() as i32;
        root.draw(&Text::new(label.as_str(), (20, y + 4), ("sans-serif", 14)))?;
        root.draw(&Rectangle::new([(LEFT, y), (end.max(LEFT + 1), y + ROW - 7)], COLORS[0].filled()))?;
        root.draw(&Text::new(value.as_str(), (end + 8, y + 4), ("sans-serif", 14)))?;
    }
    root.present()?;
    drop(root);
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_axis_has_round_numbers() {
        assert_eq!(round_numbers(0.4, 2.1), [0.5, 1.0, 2.0]);
        assert_eq!(round_numbers(2e-7, 6e-6), [2e-7, 5e-7, 1e-6, 2e-6, 5e-6]);
        assert_eq!(round_numbers(0.5, 2e5), [1.0, 10.0, 100.0, 1e3, 1e4, 1e5]);
        assert!(round_numbers(1e-300, 1e300).len() <= 11);
    }

    #[test]
    fn labels_are_short_and_exact() {
        assert_eq!([near_zero(1.1e-19, 5e-4), near_zero(1e-6, 5e-4)], [0.0, 1e-6]);
        assert_eq!(near_zero(1.1e-19, 0.0), 1.1e-19, "a logarithmic axis has no zero");
        let labels = [0.0, 1.0, 20.0, 0.25, -3.5, 12000.0, 1e6, 2.5e-7, -0.0001].map(number);
        assert_eq!(labels, ["0", "1", "20", "0.25", "-3.5", "12000", "1e6", "2.5e-7", "-1e-4"]);
    }
}
