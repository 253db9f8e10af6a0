//! Charts as SVG texts. Nothing is written to a file here.

use std::error::Error;
use std::ops::Range;

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

/// Title and axes of a chart.
#[derive(Clone, Copy)]
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

/// Colours that stay apart in print and for colour-blind readers.
pub const COLORS: [RGBColor; 5] = [
    RGBColor(0, 90, 181),
    RGBColor(220, 50, 32),
    RGBColor(0, 0, 0),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
];

/// Length of dashes and gaps of the lines of a chart \[px\]; without gaps the line is whole.
const DASHES: [(u32, u32); 4] = [(1, 0), (7, 7), (2, 5), (12, 4)];

/// Size of every picture \[px\].
///
/// Small, so that words stay readable where a page is as wide as a phone.
pub(crate) const SIZE: (u32, u32) = (720, 420);

/// Height of the line of names above a chart \[px\].
const NAMES: i32 = 26;

/// The SVG, or why nothing could be drawn.
pub type DrawResult = Result<String, Box<dyn Error>>;
/// A part of a picture.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Axes with their grid.
pub(crate) type Axes<'a, X, Y> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>;

/// Two lines and how far they are apart.
pub(crate) struct ComparedLines<'a> {
    /// The reference, then the compared line.
    pub(crate) lines: [Series<'a>; 2],
    /// Start and end of each load along x.
    pub(crate) acting: &'a [[f64; 2]],
}

/// Draws two lines that should be one, and their difference below; the times at which loads act are shaded.
pub(crate) fn compared_chart(chart: &Chart<'_>, compared: ComparedLines<'_>) -> DrawResult {
    let [first, second] = compared.lines;
    let apart = first.points.iter().zip(&second.points).map(|(a, b)| (a.0, b.1 - a.1)).collect();
    let (above, y) = engineering(chart.y, vec![first, second]);
    let (below, unit) = engineering(chart.y, vec![Series { name: "", points: apart }]);
    let unit = unit.rsplit(' ').next().unwrap_or_default();
    let below_y = format!("difference {unit}");
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (SIZE.0, SIZE.1 + 170)).into_drawing_area();
    root.fill(&WHITE)?;
    let (upper, lower) = root.split_vertically(SIZE.1 - 10);
    for (area, title, series, y) in
        [(&upper, chart.title, &above, y.as_str()), (&lower, "", &below, &below_y)]
    {
        let (x_range, y_range) = ranges(series, false)?;
        let height = y_range.end - y_range.start;
        let margin = 0.05 * height;
        let (low, high) = (y_range.start - margin, y_range.end + margin);
        let within = Chart { title, x: chart.x, y, log_y: false };
        let mut context = axes(&named(area, &within, series)?, &within, x_range.clone(), low..high)?;
        let shade = |&[start, end]: &[f64; 2]| {
            let corners = [(start.max(x_range.start), low), (end.min(x_range.end), high)];
            Rectangle::new(corners, RGBColor(0, 90, 181).mix(0.07).filled())
        };
        context.draw_series(compared.acting.iter().filter(|[start, _]| *start < x_range.end).map(shade))?;
        lines(&mut context, series, false)?;
    }
    root.present()?;
    drop((upper, lower, root));
    Ok(svg)
}

/// Draws the amplitude of an answer on a logarithmic axis over the frequency, and its phase below. The axis
/// of the frequencies is logarithmic with `log_x`.
pub(crate) fn response_chart(
    title: &str,
    y: &str,
    log_x: bool,
    amplitudes: Vec<Series<'_>>,
    phases: Vec<Series<'_>>,
) -> DrawResult {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (SIZE.0, SIZE.1 + 170)).into_drawing_area();
    root.fill(&WHITE)?;
    let (upper, lower) = root.split_vertically(SIZE.1 - 10);
    let (x, range) = ranges(&amplitudes, true)?;
    let chart = Chart { title, x: "frequency [Hz]", y, log_y: true };
    let amplitude = (range.start / 2.0..range.end * 2.0).log_scale();
    let below = Chart { title: "", x: "frequency [Hz]", y: "phase [°]", log_y: false };
    let (upper_area, lower_area) = (named(&upper, &chart, &amplitudes)?, named(&lower, &below, &[])?);
    if log_x {
        let x = || (x.start..x.end).log_scale();
        lines(&mut axes(&upper_area, &chart, x(), amplitude)?, &amplitudes, true)?;
        lines(&mut axes(&lower_area, &below, x(), -185.0..185.0)?, &phases, false)?;
    } else {
        lines(&mut axes(&upper_area, &chart, x.clone(), amplitude)?, &amplitudes, true)?;
        lines(&mut axes(&lower_area, &below, x, -185.0..185.0)?, &phases, false)?;
    }
    root.present()?;
    drop((upper_area, lower_area, upper, lower, root));
    Ok(svg)
}

/// Values in a unit with the prefix that suits the largest of them; `y` ends with the unit in brackets.
fn engineering<'a>(y: &str, series: Vec<Series<'a>>) -> (Vec<Series<'a>>, String) {
    const PREFIXES: [(f64, &str); 7] =
        [(1e-12, "p"), (1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M")];
    let unit = ["m", "J", "s"].iter().find(|unit| y.ends_with(&format!(" [{unit}]")));
    let points = series.iter().flat_map(|s| &s.points);
    let largest = points.map(|p| p.1.abs()).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let (Some(unit), true) = (unit, largest > 0.0) else { return (series, y.into()) };
    let fits = PREFIXES.iter().rev().find(|(factor, _)| largest >= *factor).unwrap_or(&PREFIXES[0]);
    let scaled = |s: Series<'a>| Series {
        name: s.name,
        points: s.points.into_iter().map(|(x, y)| (x, y / fits.0)).collect(),
    };
    let words = y.trim_end_matches(&format!("[{unit}]")).trim_end();
    (series.into_iter().map(scaled).collect(), format!("{words} [{}{unit}]", fits.1))
}

/// Draws a line chart.
pub(crate) fn line_chart(chart: &Chart<'_>, series: Vec<Series<'_>>) -> DrawResult {
    let (series, y) = if chart.log_y { (series, chart.y.into()) } else { engineering(chart.y, series) };
    let (x, range) = ranges(&series, chart.log_y)?;
    let chart = &Chart { y: &y, ..*chart };
    if chart.log_y {
        draw(chart, &series, Mark::Line, x, (range.start / 2.0..range.end * 2.0).log_scale())
    } else {
        let margin = 0.05 * (range.end - range.start);
        draw(chart, &series, Mark::Line, x, range.start - margin..range.end + margin)
    }
}

/// True of points that can be drawn.
fn usable(p: &(f64, f64), log_y: bool) -> bool {
    p.0.is_finite() && p.1.is_finite() && (!log_y || p.1 > 0.0)
}

/// From the least to the largest value along both axes.
fn ranges(series: &[Series<'_>], log_y: bool) -> Result<(Range<f64>, Range<f64>), Box<dyn Error>> {
    let all = series.iter().flat_map(|s| &s.points);
    let points: Vec<(f64, f64)> = all.copied().filter(|p| usable(p, log_y)).collect();
    if points.is_empty() {
        return Err("nothing to draw".into());
    }
    let bounds = |value: fn(&(f64, f64)) -> f64| {
        let values = points.iter().map(value);
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        if high > low { low..high } else { low - 0.5 * low.abs() - 1e-300..high + 0.5 * high.abs() + 1e-300 }
    };
    Ok((bounds(|p| p.0), bounds(|p| p.1)))
}

/// Draws the points of each series as dots on a logarithmic y axis, against a plain or a logarithmic x axis;
/// all are positive.
pub(crate) fn dot_chart(chart: &Chart<'_>, log_x: bool, series: &[Series<'_>]) -> DrawResult {
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

/// Zero where a place on a linear axis differs from it by rounding only.
fn near_zero(value: f64, extent: f64) -> f64 {
    if value.abs() < 1e-9 * extent { 0.0 } else { value }
}

/// A label of at most four figures: whole numbers without a point, very small and very large ones with a
/// power of ten.
pub(crate) fn number(value: f64) -> String {
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

/// Style of a series.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    Line,
    Dots,
}

/// Draws axes and their grid.
///
/// # Errors
/// What the drawing refuses.
pub fn axes<'a, X, Y>(
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
        .bold_line_style(RGBColor(225, 228, 234))
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|v: &f64| number(*v))
        .y_label_formatter(&|v: &f64| number(near_zero(*v, extent)))
        .draw()?;
    Ok(context)
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
    let area = named(&root, chart, series)?;
    let mut context = axes(&area, chart, x, y)?;
    match mark {
        Mark::Line => lines(&mut context, series, chart.log_y)?,
        Mark::Dots => {
            for (i, line) in series.iter().enumerate() {
                let dot = COLORS[i % COLORS.len()].mix(0.7).filled();
                let points = line.points.iter().filter(|p| usable(p, chart.log_y));
                context.draw_series(points.map(|&p| Circle::new(p, 3, dot)))?;
            }
        }
    }
    root.present()?;
    drop((context, area, root));
    Ok(svg)
}

/// Draws the title and, of several series, their names in their colours above a chart. The area that is left
/// for the chart.
///
/// # Errors
/// What the drawing refuses.
pub fn named<'a>(
    area: &Area<'a>,
    chart: &Chart<'_>,
    series: &[Series<'_>],
) -> Result<Area<'a>, Box<dyn Error>> {
    if !chart.title.is_empty() {
        area.draw(&Text::new(chart.title, (20, 12), ("sans-serif", 18)))?;
    }
    let several = series.len() > 1;
    if several {
        let room = (SIZE.0 as i32 - 100) / series.len() as i32;
        for (i, line) in series.iter().enumerate() {
            let color = COLORS[i % COLORS.len()];
            let x = 86 + i as i32 * room.min(190);
            let (dash, gap) = DASHES[i % DASHES.len()];
            let path = vec![(x, 46), (x + 26, 46)];
            match gap {
                0 => area.draw(&PathElement::new(path, color.stroke_width(2)))?,
                gap => area.draw(&DashedPathElement::new(path, dash, gap, color.stroke_width(2)))?,
            }
            area.draw(&Text::new(line.name, (x + 32, 38), ("sans-serif", 14)))?;
        }
    }
    let title = if chart.title.is_empty() { 0 } else { 30 };
    Ok(area.split_vertically(title + if several { NAMES } else { 0 }).1)
}

/// Draws each series as a line; one that covers the one before it does not hide it.
fn lines<X, Y>(context: &mut Axes<'_, X, Y>, series: &[Series<'_>], log_y: bool) -> Result<(), Box<dyn Error>>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    for (i, line) in series.iter().enumerate() {
        let style = COLORS[i % COLORS.len()].stroke_width(2);
        let points = line.points.iter().copied().filter(|p| usable(p, log_y));
        let (dash, gap) = DASHES[i % DASHES.len()];
        match gap {
            0 => context.draw_series(LineSeries::new(points, style))?,
            gap => context.draw_series(DashedLineSeries::new(points, dash, gap, style))?,
        };
    }
    Ok(())
}

/// Draws horizontal bars: label, length, what stands at its end. Lengths are shares of the longest.
pub(crate) fn bars(title: &str, rows: &[(String, f64, String)]) -> DrawResult {
    const ROW: i32 = 26;
    const LEFT: i32 = 214;
    let longest = rows.iter().map(|row| row.1).fold(f64::MIN_POSITIVE, f64::max);
    let height = 60 + ROW * rows.len() as i32;
    let room = f64::from(SIZE.0 as i32 - LEFT - 170);
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (SIZE.0, height as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    root.draw(&Text::new(title, (20, 14), ("sans-serif", 18)))?;
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
