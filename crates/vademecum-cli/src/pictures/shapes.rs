//! A picture as a list of shapes, and how it is written: SVG with one decimal, or PDF.
//!
//! Both formats show the same shapes. The PDF has one page, and its text is set in Helvetica, which every
//! reader of PDF has.

use std::fmt::Write as _;

use crate::html::escaped;

/// Red, green, blue.
pub type Color = [u8; 3];

/// The place of a text that is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// A shape; lengths in px, `y` downwards.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A polyline.
    Line {
        /// Its points.
        points: Vec<(f64, f64)>,
        /// Its colour.
        color: Color,
        /// Its width.
        width: f64,
        /// Lengths of dashes and gaps; a whole line without any.
        dash: &'static [u32],
    },
    /// A filled rectangle.
    Rectangle {
        /// Its upper left corner.
        corner: (f64, f64),
        /// Width and height.
        size: (f64, f64),
        /// Its colour.
        color: Color,
    },
    /// A disc, or a ring.
    Dot {
        /// Its centre.
        at: (f64, f64),
        /// Its radius.
        radius: f64,
        /// Its colour.
        color: Color,
        /// True of a ring.
        hollow: bool,
    },
    /// A line of text on its base line. Raised figures (⁻³) are set as such.
    Text {
        /// Where its anchor is.
        at: (f64, f64),
        /// The text.
        text: String,
        /// Height of the letters' body.
        size: f64,
        /// The part of it that is at `at`.
        anchor: Anchor,
        /// True of a text that runs upwards.
        upwards: bool,
    },
}

/// A picture on white.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Its width \[px\].
    pub width: f64,
    /// Its height \[px\].
    pub height: f64,
    /// Its shapes, in the order of drawing.
    shapes: Vec<Shape>,
}

impl Picture {
    /// An empty picture.
    #[must_use]
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, shapes: vec![] }
    }

    /// Draws a shape over the others.
    pub fn add(&mut self, shape: Shape) {
        self.shapes.push(shape);
    }

    /// Draws a text that runs to the right.
    pub fn text(&mut self, at: (f64, f64), size: f64, anchor: Anchor, text: impl Into<String>) {
        self.add(Shape::Text { at, text: text.into(), size, anchor, upwards: false });
    }

    /// The picture as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        let Self { width, height, .. } = self;
        let mut out = format!(
            "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
        );
        for shape in &self.shapes {
            write_svg(&mut out, shape).expect("writing to a string cannot fail");
        }
        out.push_str("</svg>\n");
        out
    }

    /// The picture as a PDF of one page.
    #[must_use]
    pub fn pdf(&self) -> Vec<u8> {
        // Points of 1/72 inch, and `y` upwards.
        let [width, height] = [0.75 * self.width, 0.75 * self.height];
        let mut content = format!("0.75 0 0 -0.75 0 {height} cm 1 j\n");
        for shape in &self.shapes {
            write_pdf(&mut content, shape).expect("writing to a string cannot fail");
        }
        let objects = [
            "<</Type/Catalog/Pages 2 0 R>>".into(),
            "<</Type/Pages/Kids[3 0 R]/Count 1>>".into(),
            format!(
                "<</Type/Page/Parent 2 0 R/MediaBox[0 0 {width} {height}]/Contents 4 0 R\
                 /Resources<</Font<</F 5 0 R>>>>>>"
            ),
            format!("<</Length {}>>\nstream\n{content}endstream", content.len()),
            "<</Type/Font/Subtype/Type1/BaseFont/Helvetica/Encoding/WinAnsiEncoding>>".into(),
        ];
        let mut out = String::from("%PDF-1.4\n");
        let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
        for (i, object) in objects.iter().enumerate() {
            let _ = writeln!(table, "{:010} 00000 n ", out.len());
            let _ = write!(out, "{} 0 obj\n{object}\nendobj\n", i + 1);
        }
        let start = out.len();
        let size = objects.len() + 1;
        let _ = write!(out, "{table}trailer\n<</Size {size}/Root 1 0 R>>\nstartxref\n{start}\n%%EOF\n");
        out.into_bytes()
    }
}

fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn write_svg(out: &mut String, shape: &Shape) -> std::fmt::Result {
    match shape {
        Shape::Line { points, color, width, dash } => {
            write!(out, "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"", hex(*color))?;
            if !dash.is_empty() {
                let lengths: Vec<String> = dash.iter().map(u32::to_string).collect();
                write!(out, " stroke-dasharray=\"{}\"", lengths.join(" "))?;
            }
            out.push_str(" stroke-linejoin=\"round\" points=\"");
            for (i, (x, y)) in points.iter().enumerate() {
                write!(out, "{}{x:.1},{y:.1}", if i > 0 { " " } else { "" })?;
            }
            writeln!(out, "\"/>")
        }
        Shape::Rectangle { corner: (x, y), size: (width, height), color } => writeln!(
            out,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{}\"/>",
            hex(*color)
        ),
        Shape::Dot { at: (x, y), radius, color, hollow } => {
            let color = hex(*color);
            let paint = if *hollow {
                format!("fill=\"#fff\" stroke=\"{color}\" stroke-width=\"2\"")
            } else {
                format!("fill=\"{color}\"")
            };
            writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" {paint}/>")
        }
        Shape::Text { at: (x, y), text, size, anchor, upwards } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            write!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\"")?;
            if *upwards {
                write!(out, " transform=\"rotate(-90 {x:.1} {y:.1})\"")?;
            }
            out.push('>');
            let mut lifted = 0.0;
            for (raised, part) in parts(text) {
                let lift = if raised { RAISED * size } else { 0.0 };
                let part = escaped(&part);
                if raised || lifted > 0.0 {
                    let share = if raised { SMALL } else { 1.0 };
                    write!(
                        out,
                        "<tspan dy=\"{:.1}\" font-size=\"{:.1}\">{part}</tspan>",
                        lifted - lift,
                        share * size
                    )?;
                } else {
                    out.push_str(&part);
                }
                lifted = lift;
            }
            writeln!(out, "</text>")
        }
    }
}

/// Height of raised figures over the base line, and their size, as shares of the size of the text.
const RAISED: f64 = 0.38;
const SMALL: f64 = 0.72;

fn write_pdf(out: &mut String, shape: &Shape) -> std::fmt::Result {
    let paint = |[r, g, b]: Color| [r, g, b].map(|c| format!("{:.3}", f64::from(c) / 255.0)).join(" ");
    match shape {
        Shape::Line { points, color, width, dash } => {
            let lengths: Vec<String> = dash.iter().map(u32::to_string).collect();
            write!(out, "{} RG {width} w 0 J [{}] 0 d", paint(*color), lengths.join(" "))?;
            for (i, (x, y)) in points.iter().enumerate() {
                write!(out, "\n{x:.1} {y:.1} {}", if i == 0 { 'm' } else { 'l' })?;
            }
            writeln!(out, " S")
        }
        Shape::Rectangle { corner: (x, y), size: (width, height), color } => {
            writeln!(out, "{} rg {x:.1} {y:.1} {width:.1} {height:.1} re f", paint(*color))
        }
        // A line of no length with round ends.
        Shape::Dot { at: (x, y), radius, color, hollow } => {
            let mut disc = |color, radius: f64| {
                let width = 2.0 * radius;
                writeln!(out, "{} RG {width} w 1 J [] 0 d {x:.1} {y:.1} m {x:.1} {y:.1} l S", paint(color))
            };
            disc(*color, radius + if *hollow { 1.0 } else { 0.0 })?;
            if *hollow { disc([255; 3], radius - 1.0) } else { Ok(()) }
        }
        Shape::Text { at: (x, y), text, size, anchor, upwards } => {
            let back = text_width(text, *size)
                * match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => 0.5,
                    Anchor::End => 1.0,
                };
            let (direction, x, y) =
                if *upwards { ("0 -1 -1 0", *x, y + back) } else { ("1 0 0 -1", x - back, *y) };
            writeln!(out, "0 g BT {direction} {x:.1} {y:.1} Tm")?;
            for (raised, part) in parts(text) {
                let (share, lift) = if raised { (SMALL, RAISED) } else { (1.0, 0.0) };
                let letters: String = part.chars().map(|c| format!("{:02x}", windows_letter(c))).collect();
                writeln!(out, "/F {:.2} Tf {:.2} Ts <{letters}> Tj", share * size, lift * size)?;
            }
            writeln!(out, "ET")
        }
    }
}

/// The parts of a text that are raised figures, written as plain ones, and those that are not.
fn parts(text: &str) -> Vec<(bool, String)> {
    const FIGURES: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    let mut parts: Vec<(bool, String)> = vec![];
    for letter in text.chars() {
        let figure = FIGURES.chars().position(|known| known == letter);
        let plain = match figure {
            Some(figure) => Some((b'0' + figure as u8) as char),
            None => (letter == '⁻').then_some('−'),
        };
        let (raised, letter) = (plain.is_some(), plain.unwrap_or(letter));
        match parts.last_mut() {
            Some((same, part)) if *same == raised => part.push(letter),
            _ => parts.push((raised, letter.into())),
        }
    }
    parts
}

/// The number of a letter in the encoding of Windows for western languages; a question mark of others.
fn windows_letter(letter: char) -> u8 {
    match letter {
        ' '..='~' | '\u{a0}'..='\u{ff}' => letter as u8,
        '−' | '–' => 0x96,
        '…' => 0x85,
        _ => b'?',
    }
}

/// Widths of the letters of Helvetica from the space to the tilde \[1/1000 of the size\].
const WIDTHS: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556,
    556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278,
    500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469,
    556, 333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500,
    278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// Width of a text \[px\].
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let letter =
        |letter: char| (letter as usize).checked_sub(32).and_then(|i| WIDTHS.get(i)).map_or(556, |&w| w);
    let part = |(raised, part): (bool, String)| {
        let share = if raised { SMALL } else { 1.0 };
        share * part.chars().map(|c| f64::from(letter(c))).sum::<f64>()
    };
    parts(text).into_iter().map(part).sum::<f64>() * size / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn() -> Picture {
        let mut picture = Picture::new(100.0, 60.0);
        let points = vec![(10.04, 20.0), (10.16, 21.26)];
        picture.add(Shape::Line { points, color: [255, 0, 0], width: 2.0, dash: &[7, 7] });
        picture.text((5.0, 50.0), 10.0, Anchor::End, "a<b 10⁻³");
        picture
    }

    #[test]
    fn a_line_is_written_to_a_tenth_of_a_pixel_and_a_text_escaped_with_raised_figures() {
        let svg = drawn().svg();
        assert!(
            svg.contains("points=\"10.0,20.0 10.2,21.3\"") && svg.contains("stroke-dasharray=\"7 7\""),
            "{svg}"
        );
        assert!(svg.contains(">a&lt;b 10<tspan dy=\"-3.8\" font-size=\"7.2\">−3</tspan></text>"), "{svg}");
    }

    #[test]
    fn a_document_has_its_objects_where_its_table_says() {
        let pdf = String::from_utf8(drawn().pdf()).expect("a text");
        let start: usize = pdf.lines().nth_back(1).expect("a place").parse().expect("a number");
        let table = &pdf[start..];
        assert!(table.starts_with("xref\n0 6\n"), "{table}");
        for (i, line) in table.lines().skip(3).take(5).enumerate() {
            let at: usize = line[..10].parse().expect("a number");
            assert!(pdf[at..].starts_with(&format!("{} 0 obj\n", i + 1)), "{line}");
        }
        assert!(pdf.contains("<9633> Tj"), "the raised minus and three: {pdf}");
        let (before, after) = pdf.split_once("stream\n").expect("a stream");
        let length = after.find("endstream").expect("its end");
        assert!(before.ends_with(&format!("<</Length {length}>>\n")), "{length}");
    }

    #[test]
    fn the_width_of_a_text_is_that_of_its_letters() {
        assert!((text_width("Wi", 10.0) - 11.66).abs() < 1e-12);
        assert!((text_width("10⁻³", 10.0) - 11.12 * (1.0 + SMALL)).abs() < 1e-12);
    }
}
