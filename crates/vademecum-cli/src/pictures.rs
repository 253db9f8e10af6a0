//! Charts. Nothing is written to a file here.

mod axis;
mod shapes;

use std::error::Error;

pub use axis::Axis;
pub(crate) use axis::number;
use shapes::text_width;

use crate::words::{prefix_of, sentence};
pub use shapes::{Anchor, Color, Picture, Shape};

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
pub const COLORS: [Color; 5] = [[0, 90, 181], [220, 50, 32], [0, 0, 0], [230, 159, 0], [0, 158, 115]];

/// Lengths of dashes and gaps of the lines of a chart \[px\]; the first is whole.
const DASHES: [&[u32]; 4] = [&[], &[7, 7], &[2, 5], &[12, 4]];

/// Size of every picture \[px\].
///
/// Small, so that words stay readable where a page is as wide as a phone.
pub(crate) const SIZE: (u32, u32) = (720, 420);

/// Height of a panel of a chart with several \[px\], with the numbers and the title of its axes.
const PANEL: f64 = 230.0;

/// Size of titles and of all other text \[px\].
const TITLE: f64 = 16.0;
const WORDS: f64 = 12.0;
/// Height of a line of names above a chart \[px\].
const NAMES: f64 = 22.0;
/// Room around an area of a chart \[px\]: left, right, below.
const AROUND: [f64; 3] = [86.0, 18.0, 46.0];

const GRID: Color = [225, 228, 234];
/// Of the times at which loads act.
const SHADE: Color = [236, 243, 250];

/// A picture, or the reason why there is none.
pub type Drawn = Result<Picture, Box<dyn Error>>;
/// The SVG of a picture, or the reason why there is none.
pub type DrawResult = Result<String, Box<dyn Error>>;

/// An area of a chart and its axes.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Left, top, right and lower end \[px\].
    pub ends: [f64; 4],
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
}

impl Frame {
    /// Where a point is \[px\].
    #[must_use]
    pub fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let [left, top, right, bottom] = self.ends;
        (left + (right - left) * self.x.place(x), bottom - (bottom - top) * self.y.place(y))
    }

    /// Draws the grid, the axes, their numbers and what they are of.
    pub fn draw(&self, picture: &mut Picture, x: &str, y: &str) {
        let [left, top, right, bottom] = self.ends;
        let (along, up) = (self.x.ticks((right - left) / 85.0), self.y.ticks((bottom - top) / 40.0));
        let mut line = |from, to, color| {
            picture.add(Shape::Line { points: vec![from, to], color, width: 1.0, dash: &[] });
        };
        let across = |value| self.at((value, self.y.low)).0;
        let above = |value| self.at((self.x.low, value)).1;
        const BLACK: Color = [0; 3];
        for (value, _) in &along.named {
            line((across(*value), bottom), (across(*value), top), GRID);
            line((across(*value), bottom), (across(*value), bottom + 5.0), BLACK);
        }
        for (value, _) in &up.named {
            line((left, above(*value)), (right, above(*value)), GRID);
            line((left - 5.0, above(*value)), (left, above(*value)), BLACK);
        }
        along.minor.iter().for_each(|v| line((across(*v), bottom), (across(*v), bottom + 3.0), BLACK));
        up.minor.iter().for_each(|v| line((left - 3.0, above(*v)), (left, above(*v)), BLACK));
        line((left, top), (left, bottom), BLACK);
        line((left, bottom), (right, bottom), BLACK);
        for (value, words) in &along.named {
            picture.text((across(*value), bottom + 18.0), WORDS, Anchor::Middle, words);
        }
        for (value, words) in &up.named {
            picture.text((left - 9.0, above(*value) + 0.35 * WORDS), WORDS, Anchor::End, words);
        }
        let title = |words: &str, factor: &str| format!("{words} {factor}").trim_end().to_string();
        let middle = (0.5 * (left + right), 0.5 * (top + bottom));
        picture.text((middle.0, bottom + 38.0), WORDS, Anchor::Middle, title(x, &along.factor));
        picture.add(Shape::Text {
            at: (left - 66.0, middle.1),
            text: title(y, &up.factor),
            size: WORDS,
            anchor: Anchor::Middle,
            upwards: true,
        });
    }

    /// Draws a line; of its points that fall into half a pixel those that are seen.
    pub fn line(
        &self,
        picture: &mut Picture,
        points: &[(f64, f64)],
        color: Color,
        width: f64,
        dash: &'static [u32],
    ) {
        let mut seen = Thinned::new(0.5);
        points.iter().for_each(|&point| seen.push(self.at(point)));
        picture.add(Shape::Line { points: seen.finish(), color, width, dash });
    }
}

/// The points of a line that are seen: of those in a column of a width the first, the lowest, the highest and
/// the last. Lines of any length fit into memory so.
pub(crate) struct Thinned {
    width: f64,
    column: f64,
    /// Those of the column.
    held: Vec<(f64, f64)>,
    points: Vec<(f64, f64)>,
}

impl Thinned {
    pub(crate) fn new(width: f64) -> Self {
        Self { width, column: f64::NAN, held: vec![], points: vec![] }
    }

    /// Adds the next point.
    pub(crate) fn push(&mut self, point: (f64, f64)) {
        let column = (point.0 / self.width).floor();
        if column != self.column {
            self.keep();
            self.column = column;
        }
        // First, lowest, highest, last.
        match &mut self.held[..] {
            [] => self.held = vec![point; 4],
            [_, low, high, last] => {
                if point.1 < low.1 {
                    *low = point;
                }
                if point.1 > high.1 {
                    *high = point;
                }
                *last = point;
            }
            _ => {}
        }
    }

    fn keep(&mut self) {
        let mut held = std::mem::take(&mut self.held);
        // The first and the last stay where they are.
        if let [_, low, high, _] = &mut held[..]
            && low.0 > high.0
        {
            std::mem::swap(low, high);
        }
        held.dedup();
        self.points.append(&mut held);
    }

    pub(crate) fn finish(mut self) -> Vec<(f64, f64)> {
        self.keep();
        self.points
    }
}

/// Two lines and how far they are apart.
pub(crate) struct ComparedLines<'a> {
    /// The reference, then the compared line.
    pub(crate) lines: [Series<'a>; 2],
    /// Start and end of each load along x.
    pub(crate) acting: &'a [[f64; 2]],
}

/// An area of a chart among others over one axis.
pub(crate) struct Panel<'a> {
    /// Quantity and unit.
    pub(crate) y: String,
    /// A logarithmic axis.
    pub(crate) log_y: bool,
    /// Least and largest value; those of the lines if absent.
    pub(crate) range: Option<[f64; 2]>,
    /// Its lines.
    pub(crate) series: Vec<Series<'a>>,
}

/// Draws two lines that should be one, and their difference below; the times at which loads act are shaded.
pub(crate) fn compared_chart(chart: &Chart<'_>, compared: ComparedLines<'_>) -> DrawResult {
    let [first, second] = compared.lines;
    let apart = first.points.iter().zip(&second.points).map(|(a, b)| (a.0, b.1 - a.1)).collect();
    let unit = chart.y.rsplit(' ').next().unwrap_or_default();
    let panel = |y: String, series| Panel { y, log_y: false, range: None, series };
    let panels = vec![
        panel(chart.y.into(), vec![first, second]),
        panel(format!("difference {unit}"), vec![Series { name: "", points: apart }]),
    ];
    Ok(panels_chart(chart.title, (chart.x, false), panels, compared.acting)?.svg())
}

/// Draws the amplitude of an answer on a logarithmic axis over the frequency, and its phase below. The axis
/// of the frequencies is logarithmic with `log_x`.
pub(crate) fn response_chart(
    title: &str,
    y: &str,
    log_x: bool,
    amplitudes: Vec<Series<'_>>,
    phases: Vec<Series<'_>>,
) -> Drawn {
    let amplitude = Panel { y: y.into(), log_y: true, range: None, series: amplitudes };
    let phase = Panel { y: "phase [°]".into(), log_y: false, range: Some([-185.0, 185.0]), series: phases };
    panels_chart(title, ("frequency [Hz]", log_x), vec![amplitude, phase], &[])
}

/// Draws areas below each other over one axis; those of the first are named above it, and those of others
/// where they have other names. The parts of the axis at which loads act are shaded.
pub(crate) fn panels_chart(
    title: &str,
    (x, log_x): (&str, bool),
    panels: Vec<Panel<'_>>,
    acting: &[[f64; 2]],
) -> Drawn {
    let first_height = f64::from(SIZE.1) - 10.0;
    let panels: Vec<Panel<'_>> = panels.into_iter().map(engineering).collect();
    let all: Vec<&Series<'_>> = panels.iter().flat_map(|panel| &panel.series).collect();
    let x_axis = Axis {
        log: log_x,
        ..span(all.iter().flat_map(|s| &s.points).map(|p| p.0).filter(|x| !log_x || *x > 0.0))?
    };
    let names = |panel: &Panel<'_>| panel.series.iter().map(|s| s.name.to_string()).collect::<Vec<_>>();
    let width = f64::from(SIZE.0);
    let mut picture = Picture::new(width, 0.0);
    let mut top = 8.0;
    if !title.is_empty() {
        picture.text((20.0, 26.0), TITLE, Anchor::Start, sentence(title));
        top = 34.0;
    }
    let mut before: Vec<String> = vec![];
    for (i, panel) in panels.iter().enumerate() {
        let named = names(panel);
        let start = top;
        // One line has the title of the chart, unless there are other areas.
        let alone = named.len() == 1 && (panels.len() == 1 || named[0].is_empty());
        if !alone && named != before {
            top = legend(&mut picture, &named, top);
        } else {
            top += 6.0;
        }
        before = named;
        let height = if i == 0 { first_height - start } else { PANEL };
        let [left, right, below] = AROUND;
        let y_axis = panel_axis(panel)?;
        let ends = [left, top, width - right, (start + height).max(top + 110.0) - below];
        let frame = Frame { ends, x: x_axis, y: y_axis };
        for &[start, end] in acting.iter().filter(|[start, _]| *start < x_axis.high) {
            let (from, to) = (start.max(x_axis.low), end.min(x_axis.high));
            let (corner, other) = (frame.at((from, y_axis.high)), frame.at((to, y_axis.low)));
            let size = (other.0 - corner.0, other.1 - corner.1);
            picture.add(Shape::Rectangle { corner, size, color: SHADE });
        }
        frame.draw(&mut picture, x, &panel.y);
        lines(&mut picture, &frame, panel);
        top = ends[3] + below;
    }
    picture.height = top.ceil();
    Ok(picture)
}

/// The axis of a panel, with a margin above and below its lines.
fn panel_axis(panel: &Panel<'_>) -> Result<Axis, Box<dyn Error>> {
    if let Some([low, high]) = panel.range {
        return Ok(Axis { low, high, log: panel.log_y });
    }
    let points = panel.series.iter().flat_map(|s| &s.points).filter(|p| usable(p, panel.log_y));
    let Axis { low, high, .. } = span(points.map(|p| p.1))?;
    Ok(if panel.log_y {
        Axis { low: low / 2.0, high: high * 2.0, log: true }
    } else {
        let margin = 0.05 * (high - low);
        Axis { low: low - margin, high: high + margin, log: false }
    })
}

/// The same values in a unit with the prefix that suits the largest of them, on a linear axis whose name
/// ends with its unit in brackets.
fn engineering(panel: Panel<'_>) -> Panel<'_> {
    let points = panel.series.iter().flat_map(|s| &s.points);
    let largest = points.map(|p| p.1.abs()).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let Some((words, unit)) = panel.y.strip_suffix(']').and_then(|y| y.rsplit_once('[')) else {
        return panel;
    };
    if panel.log_y || panel.range.is_some() || !takes_prefix(unit) || largest == 0.0 {
        return panel;
    }
    let (factor, prefix) = prefix_of(largest);
    let y = format!("{words}[{prefix}{unit}]");
    let mut panel = Panel { y, ..panel };
    panel.series.iter_mut().flat_map(|s| &mut s.points).for_each(|point| point.1 /= factor);
    panel
}

/// True of units of which a thousandth has a name of its own.
fn takes_prefix(unit: &str) -> bool {
    let first = unit.split('/').next().unwrap_or_default();
    ["m", "J", "s", "N", "Pa", "Hz", "N m"].contains(&first)
}

/// Draws a line chart.
pub(crate) fn line_chart(chart: &Chart<'_>, series: Vec<Series<'_>>) -> DrawResult {
    let panel = Panel { y: chart.y.into(), log_y: chart.log_y, range: None, series };
    Ok(panels_chart(chart.title, (chart.x, false), vec![panel], &[])?.svg())
}

/// True of points that can be drawn.
fn usable(p: &(f64, f64), log_y: bool) -> bool {
    p.0.is_finite() && p.1.is_finite() && (!log_y || p.1 > 0.0)
}

/// From the least to the largest of some values, those apart that are not finite.
fn span(values: impl Iterator<Item = f64>) -> Result<Axis, Box<dyn Error>> {
    let finite = values.filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
    if low > high {
        return Err("nothing to draw".into());
    }
    // One value alone stands in the middle.
    let around = if high > low { 0.0 } else { 0.5 * low.abs() + 1e-300 };
    Ok(Axis { low: low - around, high: high + around, log: false })
}

/// Draws the points of each series as dots on a logarithmic y axis, against a plain or a logarithmic x axis;
/// all are positive.
pub(crate) fn dot_chart(chart: &Chart<'_>, log_x: bool, series: &[Series<'_>]) -> DrawResult {
    let all = || series.iter().flat_map(|s| &s.points);
    let (x, y) = (span(all().map(|p| p.0))?, span(all().map(|p| p.1))?);
    if all().any(|p| !(p.1 > 0.0 && p.0.is_finite())) || x.low >= x.high {
        return Err("nothing to draw".into());
    }
    let x = if log_x {
        let margin = (x.high / x.low).powf(0.03);
        Axis { low: x.low / margin, high: x.high * margin, log: true }
    } else {
        let margin = 0.03 * (x.high - x.low);
        Axis { low: x.low - margin, high: x.high + margin, log: false }
    };
    let y = Axis { low: y.low / 1.5, high: y.high * 1.5, log: true };
    let (width, height) = (f64::from(SIZE.0), f64::from(SIZE.1));
    let mut picture = Picture::new(width, height);
    picture.text((20.0, 26.0), TITLE, Anchor::Start, sentence(chart.title));
    let names: Vec<String> = series.iter().map(|s| s.name.to_string()).collect();
    let top = if names.len() > 1 { legend(&mut picture, &names, 34.0) } else { 40.0 };
    let [left, right, below] = AROUND;
    let frame = Frame { ends: [left, top, width - right, height - below], x, y };
    frame.draw(&mut picture, chart.x, chart.y);
    for (i, line) in series.iter().enumerate() {
        let color = paler(COLORS[i % COLORS.len()]);
        let dots = line.points.iter().map(|&point| frame.at(point));
        dots.for_each(|at| picture.add(Shape::Dot { at, radius: 3.0, color, hollow: false }));
    }
    Ok(picture.svg())
}

/// A colour of which something of the paper is seen.
fn paler(color: Color) -> Color {
    color.map(|c| (0.7 * f64::from(c) + 0.3 * 255.0) as u8)
}

/// Draws the names of lines beside pieces of them, in as many rows as they need; the end of the last row.
fn legend(picture: &mut Picture, names: &[String], top: f64) -> f64 {
    const PIECE: f64 = 26.0;
    let (mut x, mut row) = (AROUND[0], top);
    for (i, name) in names.iter().enumerate() {
        let needed = PIECE + 6.0 + text_width(name, WORDS) + 24.0;
        if x > AROUND[0] && x + needed > f64::from(SIZE.0) {
            (x, row) = (AROUND[0], row + NAMES);
        }
        let y = row + 0.5 * NAMES;
        let (color, dash) = (COLORS[i % COLORS.len()], DASHES[i % DASHES.len()]);
        picture.add(Shape::Line { points: vec![(x, y), (x + PIECE, y)], color, width: 2.0, dash });
        picture.text((x + PIECE + 6.0, y + 0.35 * WORDS), WORDS, Anchor::Start, name);
        x += needed;
    }
    row + NAMES + 6.0
}

/// Draws each series of a panel as a line; one that covers the one before it does not hide it.
fn lines(picture: &mut Picture, frame: &Frame, panel: &Panel<'_>) {
    for (i, line) in panel.series.iter().enumerate() {
        let points: Vec<_> = line.points.iter().copied().filter(|p| usable(p, panel.log_y)).collect();
        frame.line(picture, &points, COLORS[i % COLORS.len()], 1.6, DASHES[i % DASHES.len()]);
    }
}

/// Draws horizontal bars: label, length, what stands at its end. Lengths are shares of the longest.
pub(crate) fn bars(title: &str, rows: &[(String, f64, String)]) -> DrawResult {
    const ROW: f64 = 26.0;
    const LEFT: f64 = 214.0;
    let longest = rows.iter().map(|row| row.1).fold(f64::MIN_POSITIVE, f64::max);
    let width = f64::from(SIZE.0);
    let room = width - LEFT - 170.0;
    let mut picture = Picture::new(width, 60.0 + ROW * rows.len() as f64);
    picture.text((20.0, 26.0), TITLE, Anchor::Start, sentence(title));
    for (i, (label, length, value)) in rows.iter().enumerate() {
        let y = 46.0 + ROW * i as f64;
        let (long, words) = ((room * length / longest).max(1.0), y + 0.5 * (ROW - 7.0) + 0.35 * WORDS);
        picture.text((20.0, words), WORDS, Anchor::Start, label);
        picture.add(Shape::Rectangle { corner: (LEFT, y), size: (long, ROW - 7.0), color: COLORS[0] });
        picture.text((LEFT + long + 8.0, words), WORDS, Anchor::Start, value);
    }
    Ok(picture.svg())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_no_staircase() {
        let points: Vec<_> =
            (0..4000).map(|i| (f64::from(i) * 1e-3, f64::from(i) * f64::from(4000 - i))).collect();
        let chart = Chart { title: "arch", x: "time [s]", y: "displacement [m]", log_y: false };
        let svg = line_chart(&chart, vec![Series { name: "", points }]).expect("drawn");
        let drawn = svg.split("points=\"").last().expect("a line").split('"').next().expect("its points");
        let heights: Vec<&str> = drawn.split([' ', ',']).skip(1).step_by(2).collect();
        let repeated = heights.windows(2).filter(|pair| pair[0] == pair[1]).count();
        assert!(heights.len() > 1000 && repeated * 5 < heights.len(), "{repeated} of {}", heights.len());
    }

    #[test]
    fn a_thinned_line_keeps_what_is_seen() {
        let mut seen = Thinned::new(1.0);
        let peak = [(0.0, 1.0), (0.2, 9.0), (0.4, -3.0), (0.5, 0.0), (0.9, 2.0), (1.5, 4.0)];
        peak.into_iter().for_each(|point| seen.push(point));
        assert_eq!(seen.finish(), [(0.0, 1.0), (0.2, 9.0), (0.4, -3.0), (0.9, 2.0), (1.5, 4.0)]);
    }

    #[test]
    fn values_are_shown_with_the_prefix_that_suits_them() {
        let shown = |y: &str, value: f64| {
            let series = vec![Series { name: "", points: vec![(0.0, value)] }];
            let panel = engineering(Panel { y: y.into(), log_y: false, range: None, series });
            (panel.y, panel.series[0].points[0].1)
        };
        assert_eq!(shown("displacement [m]", 2e-4), ("displacement [µm]".into(), 2e-4 / 1e-6));
        assert_eq!(shown("stress [Pa]", -3e6), ("stress [MPa]".into(), -3.0));
        assert_eq!(shown("velocity [m/s]", 2e-2).0, "velocity [mm/s]");
        assert_eq!(shown("area [m²]", 2e-4), ("area [m²]".into(), 2e-4));
        assert_eq!(shown("strain", 2e-4), ("strain".into(), 2e-4));
    }

    #[test]
    fn names_that_find_no_room_in_a_row_begin_another_one() {
        let mut picture = Picture::new(720.0, 100.0);
        let names: Vec<String> = (0..9).map(|i| format!("probe at corner {i}")).collect();
        assert!(legend(&mut picture, &names[..2], 0.0) < legend(&mut picture, &names, 0.0));
    }
}
