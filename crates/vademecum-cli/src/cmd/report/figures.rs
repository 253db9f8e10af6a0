//! The figures of a report, each a file of its own.

use std::path::Path;

use vademecum_build::dynamics::ModeRow;
use vademecum_build::store::{Kind, Outputs};
use vademecum_format::{AxisKind, SectionKind};
use vademecum_study::FileError;
use vademecum_study::contents::{Geometry, bound, bound_map};
use vademecum_study::shapes::{ModeShape, mode_shape};
use vademecum_study::verify::{AnyVerification, Figures as Measured};

use super::build_times::Stage;
use super::content::Content;
use super::words::{file_name, with_unit};
use crate::accuracy::bound_words;
use crate::failure::{Cause, Failure};
use crate::files::write_bytes;
use crate::outline::{Outline, outline};
use crate::pictures::{Chart, ComparedLines, DrawResult, Series, bars, compared_chart, line_chart};
use crate::surface_picture::{colored, shape};
use crate::words::{bytes, duration, hertz, percent, sentence};

/// A drawn figure.
pub(crate) struct Figure {
    /// Its file, without the extension.
    name: String,
    /// The SVG.
    pub(crate) svg: String,
    /// Caption.
    pub(crate) caption: String,
    /// True of a picture that stands beside others of its kind.
    pub(crate) small: bool,
}

/// All figures that the file gives rise to, by the part of the page they stand in.
#[derive(Default)]
pub(crate) struct Figures {
    drawn: Vec<(&'static str, Figure)>,
}

impl Figures {
    /// Draws everything.
    pub(crate) fn draw(content: &Content<'_>) -> Result<Self, Failure> {
        let mut figures = Self::default();
        figures.body(content)?;
        figures.basis(content)?;
        figures.shapes(content)?;
        figures.bound(content)?;
        figures.energy(content)?;
        figures.enrichment(content)?;
        figures.axes(content)?;
        figures.radius(content)?;
        figures.make_up(content)?;
        figures.build_times(content)?;
        if let Some(verified) = &content.verified {
            figures.beside_the_file(verified)?;
        }
        Ok(figures)
    }

    /// Writes every figure into `folder`.
    pub(crate) fn write(&self, outputs: &Outputs, folder: &Path) -> Result<(), Failure> {
        let path = |figure: &Figure| folder.join(format!("{}.svg", figure.name));
        let all: Vec<_> = self.drawn.iter().map(|(_, figure)| (path(figure), Kind::Svg)).collect();
        outputs.check(&all)?;
        let mut figures = self.drawn.iter().map(|(_, figure)| figure);
        figures.try_for_each(|figure| write_bytes(outputs, &path(figure), Kind::Svg, figure.svg.as_bytes()))
    }

    /// The figures of a part, in order.
    pub(crate) fn of(&self, part: &str) -> impl Iterator<Item = &Figure> {
        self.drawn.iter().filter(move |(of, _)| *of == part).map(|(_, figure)| figure)
    }

    /// Number of figures.
    pub(crate) fn len(&self) -> usize {
        self.drawn.len()
    }

    pub(super) fn add(
        &mut self,
        part: &'static str,
        name: &str,
        caption: String,
        drawn: DrawResult,
    ) -> Result<(), Failure> {
        let failed = |error| Failure::new(Cause::Numerics, format!("figure `{name}`: not drawn: {error}"));
        let svg = drawn.map_err(failed)?;
        self.drawn.push((part, Figure { name: name.into(), svg, caption, small: false }));
        Ok(())
    }

    fn body(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let unread = |error: FileError| Failure::file(content.path, error);
        let geometry = Geometry::of(content.file).map_err(unread)?;
        let held = geometry.held(content.file).map_err(unread)?;
        let marks: Vec<(usize, [f64; 3])> = held.into_iter().map(|node| (0, node)).collect();
        let caption = format!(
            "The surface of the body at rest. Dots: its {} held surface nodes, which no mode moves.",
            marks.len()
        );
        let title = if marks.is_empty() { "Surface" } else { "Surface and supports" };
        self.add(
            "body",
            "mesh",
            caption,
            outline(
                &Outline { title, marks: &marks, unit: content.length_unit(), forces: &[] },
                &geometry.nodes,
                &geometry.triangles,
            ),
        )
    }

    fn basis(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let values = content.numbers(SectionKind::SingularValues)?;
        if let Some(&first) = values.first() {
            let points = values.iter().enumerate().map(|(i, s)| ((i + 1) as f64, s / first)).collect();
            let chart =
                Chart {
                    title: "singular values of the snapshots", x: "number", y: "σ / σ₁", log_y: true
                };
            let caption = "How fast the snapshots run out of new shapes: the steeper, the fewer modes say \
                everything. The rest after the last mode kept bounds what the basis cannot show of them.";
            self.add(
                "basis",
                "singular-values",
                caption.into(),
                line_chart(&chart, vec![Series { name: "", points }]),
            )?;
        }
        if content.modes.iter().all(|mode| mode.energy.is_nan()) {
            // Natural modes without snapshots carry no share of them.
            return Ok(());
        }
        let share = |(k, mode): (usize, &ModeRow)| {
            (
                format!("mode {}, {}", k + 1, hertz(mode.frequency_hz)),
                mode.energy.max(0.0),
                format!("{} %", rounded(100.0 * mode.energy)),
            )
        };
        let rows: Vec<_> = content.modes.iter().enumerate().map(share).take(32).collect();
        let caption = "How much of the snapshots' energy each mode carries.".into();
        self.add("basis", "modes", caption, bars("share of the snapshots' energy", &rows))
    }

    /// Pictures of the first modes.
    fn shapes(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        /// Modes drawn at most, and triangles of all of their pictures.
        const MOST: usize = 6;
        const TRIANGLES: usize = 120_000;
        let unread = |error: FileError| Failure::file(content.path, error);
        let geometry = Geometry::of(content.file).map_err(unread)?;
        let basis = content.numbers(SectionKind::SurfaceBasis)?;
        let r = content.file.metadata().n_modes as usize;
        let fit = (TRIANGLES / geometry.triangles.len().max(1)).clamp(1, MOST);
        for (k, mode) in content.modes.iter().enumerate().take(fit) {
            let ModeShape { nodes, values } = mode_shape(&geometry, &basis, (k, r));
            let title = format!("Mode {}: {}", k + 1, hertz(mode.frequency_hz));
            let caption = format!("{title}; yellow: largest displacement.");
            self.add(
                "basis",
                &format!("shape-{}", k + 1),
                caption,
                shape(&title, &values, &nodes, &geometry.triangles),
            )?;
            if let Some((_, figure)) = self.drawn.last_mut() {
                figure.small = true;
            }
        }
        Ok(())
    }

    /// Colours of the truncation error of a push at each point.
    fn bound(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let unread = |error: FileError| Failure::file(content.path, error);
        let (Some(bound), map) =
            (bound(content.file).map_err(unread)?, bound_map(content.file).map_err(unread)?)
        else {
            return Ok(());
        };
        if !map.iter().any(|&share| share > 0.0) {
            return Ok(());
        }
        let geometry = Geometry::of(content.file).map_err(unread)?;
        let loadable = content.file.metadata().n_load_triangles as usize;
        let holds = match bound.kind {
            "bound" => "With natural modes and exact steps, no push makes a larger error at any time.",
            _ => "The modes are not natural ones moved exactly, so this is an estimate and not a bound.",
        };
        let caption = format!(
            "{} of the static response. The picture shows the worst direction at each place, on a logarithmic \
             scale. {holds} Grey: not loadable. The displacement under the push itself is better: the file adds \
             its residual flexibility there.",
            sentence(&bound_words(&bound)),
        );
        let title = "Error bound for a push here";
        let drawn = colored(title, &percent, &map, &geometry.nodes, geometry.triangles.split_at(loadable));
        self.add("certificate", "bound", caption, drawn)
    }

    fn energy(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let free = &content.free;
        let run = |name, points: &[(f64, f64)]| Series { name, points: points.to_vec() };
        let pushed = free.pushed.as_ref().map(|points| run("pushed and let go", points));
        let lines: Vec<Series<'_>> =
            pushed.into_iter().chain([run("bent in the lowest mode", &free.lowest)]).collect();
        let caption = format!(
            "The body is let go and left alone for {:.0} periods of its lowest mode: after a push of half \
             such a period, and bent in that mode alone. What the curves lose is the damping of the material \
             and of the time scheme; a curve that keeps rising would be a defect.",
            free.periods
        );
        let chart = Chart {
            title: "energy of a free run",
            x: "time [s]",
            y: "energy / energy at the start",
            log_y: false,
        };
        self.add("energy", "free-run", caption, line_chart(&chart, lines))
    }

    /// Factors of the first terms along each axis that has more than names.
    fn axes(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let metadata = content.file.metadata();
        let points = content.numbers(SectionKind::AxisPoints)?;
        let factors = content.numbers(SectionKind::Factors)?;
        let n_terms = metadata.n_terms as usize;
        let mut first = 0;
        for axis in metadata.active_axes() {
            let n = axis.n_points as usize;
            let (from, to) = (first, first + n);
            first = to;
            if axis.kind == AxisKind::Index || n_terms * to > factors.len() || to > points.len() {
                continue;
            }
            let line = |term: usize| {
                let row = n_terms * from + term * n;
                let mut line: Vec<(f64, f64)> =
                    points[from..to].iter().copied().zip(factors[row..row + n].iter().copied()).collect();
                line.sort_by(|a, b| a.0.total_cmp(&b.0));
                line
            };
            let labels: Vec<String> = (0..n_terms.min(5)).map(|term| format!("term {}", term + 1)).collect();
            let lines: Vec<Series<'_>> =
                labels.iter().enumerate().map(|(term, name)| Series { name, points: line(term) }).collect();
            let x = with_unit(axis.name, axis.unit);
            let title = format!("factors along {}", axis.name);
            let chart = Chart { title: &title, x: &x, y: "factor", log_y: false };
            let caption = format!(
                "The first {} of {n_terms} terms of the separated solution along `{}`.",
                lines.len(),
                axis.name
            );
            self.add("axes", &format!("axis-{}", file_name(axis.name)), caption, line_chart(&chart, lines))?;
        }
        Ok(())
    }

    fn make_up(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let mut sections: Vec<(String, f64)> =
            content.stored.sections().map(|s| (s.kind().to_string(), s.stored().len() as f64)).collect();
        let rest = content.bytes as f64 - sections.iter().map(|s| s.1).sum::<f64>();
        sections.push(("header, metadata, padding".into(), rest));
        sections.sort_by(|a, b| b.1.total_cmp(&a.1));
        let row = |(name, length): (String, f64)| {
            let share = 100.0 * length / content.bytes as f64;
            (name, length, format!("{} ({share:.1} %)", bytes(length as usize)))
        };
        let rows: Vec<_> = sections.into_iter().map(row).collect();
        let caption = "What the bytes of the file are for. The basis at interior nodes is touched only by \
            those who ask for fields inside the body.";
        self.add("file", "file", caption.into(), bars("bytes by section", &rows))
    }

    fn build_times(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let Some(build) = &content.build else { return Ok(()) };
        let row = |stage: &Stage| {
            let memory =
                stage.peak_memory_bytes.map_or(String::new(), |b| format!(", {}", bytes(b as usize)));
            (stage.stage.clone(), stage.seconds, format!("{}{memory}", duration(stage.seconds)))
        };
        let rows: Vec<_> = build.timings.iter().map(row).collect();
        let caption = "Where the build spent its time, stage by stage in order, and the most memory the \
            program had held until the end of each.";
        self.add("timings", "build", caption.into(), bars("seconds of the build", &rows))
    }

    /// The file beside the march at full order, or beside the exact motion where the file moves exactly.
    fn beside_the_file(&mut self, verified: &AnyVerification) -> Result<(), Failure> {
        let (name, model) = match &verified.figures {
            Measured::Large(_) => ("full order", "full-order model, marched at large displacements,"),
            Measured::Linear(figures) => match figures.truth.time_error {
                Some(_) => ("full order", "full-order model, marched with the file's own time scheme,"),
                None => ("exact motion", "motion of the full-order model that is exact in time"),
            },
        };
        let over_time = |name, values: &[f64], width: usize, place: usize| {
            let values = values.iter().skip(place).step_by(width);
            Series {
                name,
                points: values.enumerate().map(|(i, &v)| (i as f64 * verified.time_step, v)).collect(),
            }
        };
        let width = verified.probes.len();
        for (place, probe) in verified.probes.iter().enumerate() {
            let [full, file] = &verified.probe_series;
            let shown = verified.shown_seconds();
            let lines = [over_time(name, full, width, place), over_time("vademecum", file, width, place)];
            let lines = lines.map(|line| Series {
                name: line.name,
                points: line.points.into_iter().filter(|point| point.0 <= shown).collect(),
            });
            let title = format!("displacement of {probe}");
            let chart = Chart { title: &title, x: "time [s]", y: "displacement [m]", log_y: false };
            let caption = format!(
                "The same loads on the {model} and on the file, and how far apart the two are; the shade says when \
                 loads act."
            );
            self.add(
                "full order",
                &format!("probe-{}", file_name(probe)),
                caption,
                compared_chart(&chart, ComparedLines { lines, acting: &verified.acting }),
            )?;
        }
        let [full, file] = &verified.energy_series;
        let lines = vec![over_time(name, full, 1, 0), over_time("vademecum", file, 1, 0)];
        let chart = Chart { title: "energy", x: "time [s]", y: "energy [J]", log_y: false };
        let caption = "Kinetic plus elastic energy over the scenario.".into();
        self.add("full order", "energy", caption, line_chart(&chart, lines))
    }
}

/// A share of 100 with three decimals; below that, two figures.
fn rounded(percent: f64) -> String {
    if percent >= 1e-3 || percent == 0.0 { format!("{percent:.3}") } else { format!("{percent:.1e}") }
}
