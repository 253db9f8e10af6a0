//! The discretisation error in words.

use vademecum_build::mesh_error::{MeshEstimate, RefinedValue};

use crate::words::percent;

/// A value of the mesh, its error, and the value without it.
fn in_words(value: &RefinedValue, unit: &str, digits: usize) -> String {
    let side = if value.error < 0.0 { "low" } else { "high" };
    let number = |x: f64| if unit == "Hz" { format!("{x:.digits$}") } else { format!("{x:.digits$e}") };
    format!(
        "{} {unit} on this mesh, about {} too {side} (95 % bound {}): {} {unit}",
        number(value.mesh),
        percent(value.error.abs()),
        percent(value.bound),
        number(value.refined),
    )
}

/// A support whose region the mesh does not resolve.
pub(crate) const BETWEEN_NODES: &str = "a support ends between nodes: another mesh holds another part of the body, which these \
                                        numbers leave out";

/// A line for each frequency.
pub(crate) fn frequency_lines(frequencies: &[RefinedValue]) -> Vec<String> {
    let line = |(k, value)| format!("  mode {}: {}", k + 1, in_words(value, "Hz", 6));
    frequencies.iter().enumerate().map(line).collect()
}

/// The frequencies in one line: the first in full, of the others the error.
pub(crate) fn in_a_line(estimate: &MeshEstimate) -> String {
    let error = match estimate {
        MeshEstimate::Known(error) => error,
        MeshEstimate::Unknown { reason } => return format!("mesh error: not estimated: {reason}"),
    };
    let Some((first, others)) = error.frequencies.split_first() else {
        return "mesh error: not estimated: no frequency".to_string();
    };
    let others: Vec<String> = others.iter().map(|value| percent(value.error.abs())).collect();
    let others = match others.len() {
        0 => String::new(),
        n => format!("; modes 2 to {}: {}", n + 1, others.join(", ")),
    };
    let between = if error.support_between_nodes { format!("; {BETWEEN_NODES}") } else { String::new() };
    format!("mesh error: {}{others}{between}", in_words(first, "Hz", 4))
}

/// The error of a reduction beside that of its mesh: of the displacement under a traction, else of the first
/// frequency.
pub(crate) fn beside(reduction: f64, estimate: &MeshEstimate) -> Option<String> {
    let MeshEstimate::Known(error) = estimate else { return None };
    let (value, what) = match (&error.displacement, error.frequencies.first()) {
        (Some(found), _) => (found.value, "displacement under a traction"),
        (None, Some(first)) => (*first, "first frequency"),
        (None, None) => return None,
    };
    Some(format!("reduction {}, mesh about {} ({what})", percent(reduction), percent(value.error.abs())))
}

/// Lines for people.
pub(crate) fn lines(estimate: &MeshEstimate) -> Vec<String> {
    let error = match estimate {
        MeshEstimate::Known(error) => error,
        MeshEstimate::Unknown { reason } => return vec![format!("mesh error: not estimated: {reason}")],
    };
    let mut lines = vec!["mesh error (discretisation error of the finite element model):".to_string()];
    lines.extend(frequency_lines(&error.frequencies));
    if let Some(displacement) = &error.displacement {
        let [x, y, z] = displacement.disc.point;
        lines.push(format!(
            "  displacement under 1 N on a disc of radius {:.4e} m at ({x:.6}, {y:.6}, {z:.6}): {}",
            displacement.disc.radius,
            in_words(&displacement.value, "m", 4)
        ));
        lines.push(
            "  a force at a point has no limit under refinement: the displacement under it depends on the mesh"
                .to_string(),
        );
    }
    if error.nodes_without_area > 0 {
        lines.push(format!(
            "  {} held nodes lie in no held face: the part of the answer that comes from them has no limit under \
             refinement and is not in these numbers",
            error.nodes_without_area
        ));
    }
    lines.extend(error.support_between_nodes.then(|| format!("  {BETWEEN_NODES}")));
    lines
}
