//! The report as one static page: no scripts, nothing fetched.

use std::fmt::Write as _;

use vademecum_build::certificate::StructureReport;
use vademecum_build::dynamics::ModeRow;
use vademecum_format::SectionKind;
use vademecum_study::contents::{Geometry, mesh_errors};
use vademecum_study::shapes::smallest_angles;
use vademecum_study::timings::machine;
use vademecum_study::verify::{Figures as Measured, LargeVerification};

use super::content::Content;
use super::figures::{Figure, Figures};
use super::words::file_name;
use crate::accuracy::Accuracy;
use crate::html::escaped;
use crate::words::{bytes, duration, hertz, percent, sentence};

const STYLE: &str = include_str!("../../../assets/report.css");

/// The whole page.
pub(crate) fn page(content: &Content<'_>, figures: &Figures) -> String {
    let title = escaped(&content.title);
    let parts = [
        ("The body", "body", body(content)),
        ("The basis", "basis", basis(content)),
        ("The certificate", "certificate", certificate(content)),
        ("Comparison with the full order", "full order", full_order(content)),
        ("A free run", "energy", String::new()),
        ("Live parameters", "axes", parameters(content)),
        ("The file", "file", file(content)),
        ("Timings", "timings", timings(content)),
        ("The problem", "problem", problem(content)),
    ];
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" \
         content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}: report</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>{title}</h1>\n{}",
        summary(content)
    );
    let shown = |part: &str, text: &str| !text.is_empty() || figures.of(part).next().is_some();
    html.push_str("<nav aria-label=\"contents\"><ol>\n");
    for (heading, part, _) in parts.iter().filter(|(_, part, text)| shown(part, text)) {
        let _ = writeln!(html, "<li><a href=\"#{}\">{heading}</a></li>", file_name(part));
    }
    html.push_str("</ol></nav>\n");
    for (heading, part, text) in parts.iter().filter(|(_, part, text)| shown(part, text)) {
        let _ = write!(html, "<section id=\"{}\">\n<h2>{heading}</h2>\n{text}", file_name(part));
        for (small, same) in by_size(figures.of(part)) {
            html.push_str(if small { "<div class=\"shapes\">\n" } else { "" });
            for figure in same {
                let svg = figure.svg.trim_start_matches(|c| c != '<');
                let caption = escaped(&figure.caption);
                let _ = write!(html, "<figure>\n{svg}\n<figcaption>{caption}</figcaption>\n</figure>\n");
            }
            html.push_str(if small { "</div>\n" } else { "" });
        }
        html.push_str("</section>\n");
    }
    html.push_str("</body>\n</html>\n");
    html
}

/// Figures in order, those of one size that follow each other together.
fn by_size<'a>(figures: impl Iterator<Item = &'a Figure>) -> Vec<(bool, Vec<&'a Figure>)> {
    let mut groups: Vec<(bool, Vec<&Figure>)> = vec![];
    for figure in figures {
        match groups.last_mut() {
            Some((small, same)) if *small == figure.small => same.push(figure),
            _ => groups.push((figure.small, vec![figure])),
        }
    }
    groups
}

/// Summary of the file.
fn summary(content: &Content<'_>) -> String {
    let m = content.file.metadata();
    let pace = content.timings.as_ref().map_or(String::new(), |timings| {
        let step = timings.step[1][0];
        let faster = times(m.time_step / step);
        format!(
            " A step of {} takes {} on this machine: {faster} times faster than real time.",
            duration(m.time_step),
            duration(step)
        )
    });
    let lowest = content.modes.iter().map(|mode| mode.frequency_hz).fold(f64::INFINITY, f64::min);
    format!(
        "<p class=\"lead\">This file steps a body of {} nodes ({} displacement components) with {} numbers \
         of state. Its lowest natural frequency is {}.{pace}</p>\n",
        m.n_nodes,
        3 * m.n_nodes,
        if m.scheme.is_exact() { 2 * m.n_modes } else { 3 * m.n_modes },
        hertz(lowest),
    ) + &good_for(content)
}

/// True of a file of large displacements.
fn is_strain(content: &Content<'_>) -> bool {
    content.file.section(SectionKind::StrainSizes).is_some()
}

/// Range of validity.
fn good_for(content: &Content<'_>) -> String {
    let m = content.file.metadata();
    let highest = content.modes.iter().map(|mode| mode.frequency_hz).fold(0.0, f64::max);
    let mut good = format!("motions up to {}", hertz(highest));
    if m.n_load_nodes > 0 {
        good += &format!(", and forces at {} nodes of the surface", m.n_load_nodes);
    }
    if let Ok([first, ..]) = mesh_errors(content.file).as_deref() {
        good += &format!(
            ". The mesh makes the first frequency about {} too {} (95 % bound {})",
            percent(first.error.abs()),
            if first.error < 0.0 { "low" } else { "high" },
            percent(first.bound)
        );
    }
    let mut not = if is_strain(content) {
        "plasticity: the material is that of St. Venant and Kirchhoff, which lets elements collapse under strong \
         compression; displacements beyond those of its training"
            .to_string()
    } else {
        "large rotations or plasticity: displacements are small, and the material is linear".to_string()
    };
    if m.n_load_nodes == 0 {
        not += "; forces at single points, which the file does not know";
    } else if m.n_load_triangles < m.n_triangles {
        not += "; forces at the rest of the surface, which the file does not know";
    }
    let accuracy: String =
        accuracy(content).iter().map(|line| format!("<p>{}</p>\n", escaped(line))).collect();
    format!("{accuracy}<p><b>Good for</b> {good}.</p>\n<p><b>Not for</b> {not}.</p>\n")
}

/// Sentences on the error of the file.
fn accuracy(content: &Content<'_>) -> Vec<String> {
    let lines = Accuracy::of(content.file).map(|accuracy| accuracy.lines()).unwrap_or_default();
    lines.iter().map(|line| sentence(line) + ".").collect()
}

fn body(content: &Content<'_>) -> String {
    let m = content.file.metadata();
    let listed = |kind| content.listed(kind).unwrap_or_else(|_| "not readable".into());
    let hash: String = m.mesh_hash.iter().map(|byte| format!("{byte:02x}")).collect();
    table(&[
        ("nodes", format!("{}, {} of them on the surface", m.n_nodes, m.n_surface_nodes)),
        (
            "loadable",
            format!(
                "{} nodes, {} of {} surface triangles",
                m.n_load_nodes, m.n_load_triangles, m.n_triangles
            ),
        ),
        ("shape of the surface's triangles", surface_quality(content)),
        ("load patterns", listed(SectionKind::PatternNames)),
        ("probes", listed(SectionKind::ProbeNames)),
        ("units", m.units.into()),
        ("mesh", format!("XXH3-128 {hash}; the file fits no other")),
    ])
}

/// Smallest angles of the triangles.
fn surface_quality(content: &Content<'_>) -> String {
    let Ok(geometry) = Geometry::of(content.file) else { return "not readable".into() };
    let angles = smallest_angles(&geometry);
    let (Some(worst), Some(median)) = (angles.first(), angles.get(angles.len() / 2)) else {
        return "no triangles".into();
    };
    format!("smallest angle {worst:.1}° in the worst, {median:.1}° in the median triangle (60° at best)")
}

fn basis(content: &Content<'_>) -> String {
    let table = &content.modes;
    let [with_share, damps, stretches] = [
        table.iter().any(|mode| !mode.energy.is_nan()),
        table.iter().any(|mode| mode.numerical_damping != 0.0),
        table.iter().any(|mode| mode.period_elongation != 0.0),
    ];
    type Column = (&'static str, bool, fn(&ModeRow) -> f64);
    let columns: [Column; 5] = [
        ("frequency [Hz]", true, |mode| mode.frequency_hz),
        ("energy share", with_share, |mode| mode.energy),
        ("damping ratio, material", true, |mode| mode.physical_damping),
        ("damping ratio, scheme", damps, |mode| mode.numerical_damping),
        ("period elongation", stretches, |mode| mode.period_elongation),
    ];
    let columns: Vec<Column> = columns.into_iter().filter(|column| column.1).collect();
    let heads: String = columns.iter().map(|(name, ..)| format!("<th>{name}</th>")).collect();
    let mut rows = String::new();
    for (k, mode) in content.modes.iter().enumerate() {
        let cells: String =
            columns.iter().map(|(.., value)| format!("<td>{}</td>", figure(value(mode)))).collect();
        let _ = writeln!(rows, "<tr><td>{}</td>{cells}</tr>", k + 1);
    }
    let scheme = if is_strain(content) {
        "At large displacements all of them interact; the frequencies are those of small motions. The strain \
         structure steps them together, and keeps a discrete energy."
    } else if content.file.metadata().scheme.is_exact() {
        "Its steps are exact in time: nothing damps a mode but the material, and no period is stretched."
    } else {
        "The time scheme damps a mode by what stands under <i>scheme</i> and makes its period longer by the \
         share in the last column; both grow with frequency times time step."
    };
    format!(
        "<p>The body moves in {} shapes, its modes. {scheme}</p>\n<div class=\"wide\"><table>\
         <thead><tr><th>mode</th>{heads}</tr></thead>\n\
         <tbody>\n{rows}</tbody></table></div>\n",
        content.modes.len()
    )
}

fn certificate(content: &Content<'_>) -> String {
    let m = content.file.metadata();
    let of =
        |present: bool, certificate, figures| present.then(|| StructureReport::new(certificate, figures));
    let figures = &content.figures;
    let both = [
        (moved_by(content), of(m.diagonal, &m.certificate.diagonal, &figures.diagonal)),
        ("block", of(m.block, &m.certificate.block, &figures.block)),
    ];
    let columns: Vec<(&str, StructureReport)> =
        both.into_iter().filter_map(|(name, column)| Some((name, column?))).collect();
    let heads: String = columns.iter().map(|(name, _)| format!("<th>{name} structure</th>")).collect();
    // A row without a number in any column says nothing.
    let row = |name: &str, value: &dyn Fn(&StructureReport) -> f64| {
        if columns.iter().all(|(_, column)| value(column).is_nan()) {
            return String::new();
        }
        let cells = columns.iter().map(|(_, column)| format!("<td>{}</td>", figure(value(column))));
        format!("<tr><td>{name}</td>{}</tr>\n", cells.collect::<String>())
    };
    let rows = [
        row("largest error of the test runs", &|c| c.trajectory_error),
        row("largest projection error: what the basis cannot show of one", &|c| c.projection_floor),
        row("largest error ÷ projection error", &|c| c.floor_ratio),
        row("spectral radius − 1 (must not be positive)", &|c| c.spectral_radius - 1.0),
        row("largest energy after release ÷ that at release − 1", &|c| c.energy_ratio - 1.0),
        row("largest energy of free motions ÷ that at their start − 1, in a million steps", &|c| {
            c.energy_growth - 1.0
        }),
        row("reciprocity error (response at A to a force at B, and the reverse)", &|c| c.reciprocity),
        row("error of the stage maps at fresh parameters, mean", &|c| c.map_error_rms),
        row("error of the stage maps at fresh parameters, worst", &|c| c.map_error_max),
        row("steps marched", &|c| c.steps),
    ];
    let repaired = |done: &String| format!("<p>Repaired by the build: {}.</p>\n", escaped(done));
    let repairs: String = content.repairs.iter().map(repaired).collect();
    format!(
        "{}<p>The test runs were marched when the file was built, under loads that it was not made from; \
         another load can do worse. Errors are relative, over all displacement components and all steps, in \
         the norm of the mass. An error close to the projection error says that more could be gained only \
         with more modes. The scene takes the cheaper structure that keeps the tolerance; here the {} \
         one.</p>\n<div class=\"wide\"><table><thead><tr><th></th>{heads}</tr></thead>\n\
         <tbody>\n{}</tbody></table></div>\n{repairs}",
        accuracy(content).iter().map(|line| format!("<p>{}</p>\n", escaped(line))).collect::<String>(),
        content.structure,
        rows.concat()
    )
}

/// The structure without maps between modes, by its name.
fn moved_by(content: &Content<'_>) -> &'static str {
    if is_strain(content) {
        "strain"
    } else if content.file.metadata().scheme.is_exact() {
        "exact"
    } else {
        "diagonal"
    }
}

fn full_order(content: &Content<'_>) -> String {
    let Some(verified) = &content.verified else { return String::new() };
    let r = match &verified.figures {
        Measured::Linear(figures) => figures,
        Measured::Large(figures) => return at_large_displacements(figures),
    };
    let truth = &r.truth;
    let beside = if truth.time_error.is_some() { "full order" } else { "the exact motion" };
    let scheme = truth.time_error.map_or("none: its steps are exact".into(), share);
    let contact = truth.contact_error.map(|error| ("displacement under a contact", share(error)));
    let mut rows = vec![
        (
            "total error",
            format!("{} (the reference is known to {})", share(truth.total_error), share(truth.truth_error)),
        ),
        ("of that the time scheme", scheme),
        ("what the modes cannot show", share(truth.basis_error)),
        ("what their coordinates add", share(truth.rest_error)),
    ];
    rows.extend(contact);
    // Against a motion without a scheme this is the total error again.
    rows.extend(truth.time_error.map(|_| {
        let [error, floor, ratio] = [r.trajectory_error, r.projection_floor, r.floor_ratio].map(figure);
        let text = format!("{error} (floor {floor}, ratio {ratio})");
        ("error against the march with the same scheme", text)
    }));
    rows.extend([
        ("steps", r.steps.to_string()),
        ("free components", r.dofs.to_string()),
        ("energy lost after release", lost([r.energy_drift, r.energy_drift_full_order], beside)),
        ("a step", paces(r.full_order_seconds_per_step, r.vademecum_seconds_per_step)),
    ]);
    format!(
        "<p>The loads of a scenario on the file, and on a motion of the full-order model that is exact in \
         time. Errors are relative, over all steps, in the norm of the mass.</p>\n{}",
        table(&rows)
    )
}

/// Energy lost after release, and that of the motion beside it.
fn lost(drifts: [Option<f64>; 2], beside: &str) -> String {
    match drifts {
        [Some(own), Some(other)] => format!("{} ({beside} {})", figure(0.0 - own), figure(0.0 - other)),
        _ => "not measured: a load acts to the end".into(),
    }
}

/// The same beside a march at large displacements.
fn at_large_displacements(r: &LargeVerification) -> String {
    let contact = r.contact_error.map(|error| ("displacement under a contact", share(error)));
    let mut rows = vec![
        (
            "error",
            format!(
                "{} (the reference is {} from a march with twice its step)",
                share(r.trajectory_error),
                share(r.truth_error)
            ),
        ),
        ("what the basis cannot show", share(r.projection_floor)),
        ("error of the linear model", share(r.linear_error)),
    ];
    rows.extend(contact);
    rows.extend([
        ("the surface moves by", format!("{} m", figure(r.displacement))),
        ("violation of the energy's identity", format!("{:.0e} of the largest energy", r.energy_identity)),
        ("steps", r.steps.to_string()),
        ("free components", r.dofs.to_string()),
        ("energy lost after release", lost([r.energy_drift, r.energy_drift_full_order], "full order")),
        ("a step", paces(r.full_order_seconds_per_step, r.vademecum_seconds_per_step)),
    ]);
    format!(
        "<p>The loads of a scenario on the file, and on the full-order model at large displacements, marched \
         by Bathe's method in {} steps for one of the file. Errors are relative, over all steps, in the norm of \
         the mass.</p>\n{}",
        r.truth_parts,
        table(&rows)
    )
}

fn share(error: f64) -> String {
    format!("{} %", figure(100.0 * error))
}

/// Seconds of a step at full order and through the file.
fn paces(full: f64, own: f64) -> String {
    let (one, other) = (duration(full), duration(own));
    format!("{one} at full order, {other} through the file: {} times faster", times(full / own))
}

/// Live parameters.
fn parameters(content: &Content<'_>) -> String {
    let m = content.file.metadata();
    let always = format!(
        "The {} structure takes any stiffness and density of the whole body, any time step and any Rayleigh \
         damping.",
        moved_by(content)
    );
    let always = if m.diagonal { format!("<p>{always}</p>\n") } else { String::new() };
    let of_model = content.file.live_parameters().ok().flatten();
    let of_model = of_model.iter().flat_map(|live| live.iter());
    let all: Vec<_> = m.active_parameters().iter().copied().chain(of_model).collect();
    if all.is_empty() {
        return always;
    }
    let row = |p: &vademecum_format::Parameter<'_>| {
        format!(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            escaped(p.name),
            figure(p.lower),
            figure(p.nominal),
            figure(p.upper),
            escaped(p.unit)
        )
    };
    let rows: String = all.iter().map(row).collect();
    format!(
        "{always}<p>The file was built for these ranges; a value outside is refused.</p>\n\
         <div class=\"wide\"><table><thead><tr><th>parameter</th><th>from</th><th>built around</th>\
         <th>to</th><th>unit</th></tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n"
    )
}

fn file(content: &Content<'_>) -> String {
    let m = content.file.metadata();
    table(&[
        ("name", content.path.file_name().unwrap_or_default().to_string_lossy().into_owned()),
        ("size", bytes(content.bytes)),
        ("format", format!("{}.{}, written by {}", vademecum_format::MAJOR, content.file.minor(), m.program)),
        (
            "time scheme",
            match m.scheme.n_stages {
                0 => format!("{}, time step {}", m.scheme_name, duration(m.time_step)),
                n => format!("{}, {n} stages, time step {}", m.scheme_name, duration(m.time_step)),
            },
        ),
        ("Rayleigh damping", format!("α {} 1/s, β {} s", figure(m.alpha), figure(m.beta))),
        ("separated terms", m.n_terms.to_string()),
        ("this page", content.command.clone()),
    ])
}

fn timings(content: &Content<'_>) -> String {
    let build = content.build.as_ref().map_or(String::new(), |build| {
        let total = duration(build.total());
        format!("<p>The build took {total} on the machine it ran on, as it reported itself.</p>\n")
    });
    let Some(t) = &content.timings else { return build };
    let step = |[median, p99, worst]: [f64; 3]| {
        format!(
            "{} (99 of 100 within {}, slowest burst {})",
            duration(median),
            duration(p99),
            duration(worst)
        )
    };
    let rows = table(&[
        ("read and open", duration(t.open)),
        ("bind a scene", duration(t.bind)),
        ("step, 32 bit", step(t.step[0])),
        ("step, 64 bit", step(t.step[1])),
        ("displacement of the whole surface, 32 bit", duration(t.surface)),
    ]);
    format!(
        "<p>Measured when this report was written, in one thread of {}. A step is the median over bursts of \
         32.</p>\n{rows}{build}",
        escaped(&machine())
    )
}

fn problem(content: &Content<'_>) -> String {
    let text = escaped(content.file.metadata().problem);
    format!("<p>The problem file the build was asked for, as kept in the file.</p>\n<pre>{text}</pre>\n")
}

/// Names and values.
fn table(rows: &[(&str, String)]) -> String {
    let row = |(name, value): &(&str, String)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(value));
    format!("<dl>\n{}</dl>\n", rows.iter().map(row).collect::<String>())
}

/// A number with four figures; a dash where nothing was measured.
fn figure(value: f64) -> String {
    if value.is_nan() {
        "–".into()
    } else if value == 0.0 || (1e-2..1e5).contains(&value.abs()) {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        format!("{value:.3e}")
    }
}

/// A ratio with two figures: more would be noise of the clock.
fn times(ratio: f64) -> String {
    let unit = 10_f64.powf(ratio.log10().floor() - 1.0);
    let rounded = (ratio / unit).round() * unit;
    if ratio >= 10.0 { format!("{rounded:.0}") } else { format!("{rounded:.1}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short() {
        assert_eq!([1.0, 0.25, 0.0, 1234.5, 1e-7].map(figure), ["1", "0.25", "0", "1234.5", "1.000e-7"]);
        assert_eq!(figure(f64::NAN), "–");
        assert_eq!([20001.0, 1.26, 34.9].map(times), ["20000", "1.3", "35"]);
    }
}
