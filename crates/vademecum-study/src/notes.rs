//! Notes on parts of a scenario that have no effect: valid, but seldom intended.

use vademecum_build::dynamics::{Course, History, INSTANTS};
use vademecum_format::{File, Numbers, SectionKind};

use crate::contents::lines;
use crate::error::{FileError, place};
use crate::near::FAR;
use crate::player::{PlacedContact, Track};
use crate::scenario::Scenario;

/// Most notes of a scenario; the rest is counted.
const MOST: usize = 20;

/// Notes on a scenario bound to a file and marched for `steps` steps.
///
/// # Errors
/// Names that cannot be read.
pub(crate) fn notes(
    file: &File<'_>,
    scenario: &Scenario,
    track: &Track,
    time_step: f64,
    steps: usize,
) -> Result<Vec<String>, FileError> {
    let (r, scheme) = (file.metadata().n_modes as usize, file.metadata().scheme);
    // Exact steps look at every instant, and so does the mean over a step of a body that flies.
    let instants = (!scheme.is_exact() && scenario.free.is_none()).then(|| scheme.instants());
    let never = |when: &History| never(when, instants.as_ref(), time_step, steps);
    let (basis, patterns) = (raw(file, SectionKind::SurfaceBasis), raw(file, SectionKind::PatternBasis));
    let partly = file.metadata().n_load_triangles < file.metadata().n_triangles;
    let surface = if partly {
        "loadable part of the surface (`load.surface` of the problem chooses it)"
    } else {
        "surface"
    };
    let mut notes: Vec<String> = spins_beyond_the_model(file, scenario).into_iter().collect();
    for i in 0..scenario.contacts.len() {
        // Components of its force, and places of its path: there are none of a table of zeros.
        let first = track.contacts.partition_point(|placed| placed.entry < i);
        let all = &track.contacts[first..];
        let all = &all[..all.partition_point(|placed| placed.entry == i)];
        let furthest = all.iter().filter_map(|placed| Some((placed, far(placed)?)));
        notes.extend(furthest.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(placed, distance)| {
            let at = place(placed.point.position);
            format!(
                "contact[{i}] acts {distance:.3e} away from the point given, at {at}, the nearest place on the {surface}"
            )
        }));
        let is_held = |placed: &PlacedContact| basis.as_ref().is_some_and(|basis| held(r, basis, placed));
        let nothing = if all.iter().all(|placed| placed.contact.force == [0.0; 3]) {
            Some("its force is zero".to_string())
        } else if all.iter().all(is_held) {
            let at = place(all[0].point.position);
            Some(format!("all that its force acts on at {at} is held"))
        } else {
            all.iter().map(|placed| never(&placed.when)).reduce(Option::and).flatten()
        };
        notes.extend(nothing.map(|why| format!("contact[{i}] moves nothing: {why}")));
    }
    for (i, (entry, placed)) in scenario.patterns.iter().zip(&track.patterns).enumerate() {
        let nothing = if entry.amplitude == 0.0 {
            Some("its amplitude is zero".to_string())
        } else if patterns.as_ref().is_some_and(|rows| is_zero(rows, placed.index, r)) {
            Some("all that its forces act on is held".to_string())
        } else {
            never(&placed.when)
        };
        notes.extend(nothing.map(|why| format!("pattern[{i}] (`{}`) moves nothing: {why}", entry.name)));
    }
    if let Some(rows) = raw(file, SectionKind::ProbeRows) {
        let names = lines(file, SectionKind::ProbeNames)?;
        let still = names.iter().enumerate().filter(|&(i, _)| is_zero(&rows, i, r));
        notes.extend(still.map(|(_, name)| format!("probe `{name}` stays zero: what it looks at is held")));
    }
    if notes.len() > MOST {
        let more = notes.len() - MOST;
        notes.truncate(MOST);
        notes.push(format!("{more} more notes about contacts, patterns and probes are left out"));
    }
    Ok(notes)
}

/// Spin of a thrown body, as a share of its first natural frequency, that is worth a note: the Coriolis force
/// that the model leaves out is of first order in it.
const FAST: f64 = 0.1;

/// Note on a body that is thrown with a spin near its first natural frequency.
fn spins_beyond_the_model(file: &File<'_>, scenario: &Scenario) -> Option<String> {
    let spin = scenario.free?.spin.iter().map(|x| x * x).sum::<f64>().sqrt();
    let eigenvalues = raw(file, SectionKind::Eigenvalues)?;
    let first = eigenvalues.iter().fold(f64::INFINITY, f64::min).sqrt();
    (spin > FAST * first).then(|| {
        format!(
            "`free.spin` of {spin:.4} rad/s is {:.2} of the first natural frequency ({first:.4} rad/s): the model \
             leaves out the Coriolis force and the softening by the spin, and is meant for a tenth and less",
            spin / first
        )
    })
}

/// Note on a contact far from its requested point.
fn far(placed: &PlacedContact) -> Option<f64> {
    let size = placed.point.position.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    (placed.point.distance > FAR * size).then_some(placed.point.distance)
}

/// Numbers of a section, if it is there and not compressed.
fn raw<'a>(file: &File<'a>, kind: SectionKind) -> Option<Numbers<'a>> {
    file.section(kind)?.numbers().ok()
}

/// True of a row of `r` zeros: no mode moves its output.
fn is_zero(rows: &Numbers<'_>, index: usize, r: usize) -> bool {
    rows.row(index * r, r).is_some_and(|row| row.iter().all(|x| x == 0.0))
}

/// True if all dofs under a contact's force are fixed.
fn held(r: usize, basis: &Numbers<'_>, placed: &PlacedContact) -> bool {
    let contact = &placed.contact;
    let nodes = contact.place.entries().filter(|(_, weight)| *weight != 0.0);
    let mut dofs = nodes.flat_map(|(node, _)| (0..3).map(move |c| (node as usize, c)));
    dofs.all(|(node, c)| contact.force[c] == 0.0 || is_zero(basis, 3 * node + c, r))
}

/// Reason that a load acts at no instant of a march with these instants of a step, or at all; `None` if it
/// acts.
fn never(when: &History, instants: Option<&[f64; INSTANTS]>, time_step: f64, steps: usize) -> Option<String> {
    let (start, end) = (when.start(), when.end());
    // A table and a sinusoid may be zero at some instants and act later.
    let instants = instants.filter(|_| when.course == Course::Held && when.share.is_none());
    // A load as long as two steps acts at the start of one of them; a shorter one is over in the third.
    let first = (start / time_step - 1.0).max(0.0).floor();
    if first < steps as f64 {
        let first = first as usize;
        let acts = |step: usize| {
            let mut looked_at = instants.into_iter().flatten();
            looked_at.any(|c| when.factor((step as f64 + c) * time_step) != 0.0)
        };
        if (first..steps.min(first + 4)).any(acts) {
            return None;
        }
    }
    let last = steps as f64 * time_step;
    let late = start * (1.0 + 1e-9) >= last;
    if !late && instants.is_none() {
        return None;
    }
    Some(if late {
        format!("it starts at {start} s, and the scenario ends at {last} s")
    } else {
        format!("no instant that a step of {time_step} s looks at lies from {start} s to {end} s")
    })
}

#[cfg(test)]
mod tests {
    use vademecum_build::dynamics::Interval;

    use super::*;

    #[test]
    fn loads_that_act_at_no_instant_are_told_from_those_that_do() {
        let mut instants = [0.0; INSTANTS];
        (instants[1], instants[2]) = (0.5, 1.0);
        let (dt, steps) = (1e-3, 100);
        let found = |start: f64, end: f64, ramp: f64| {
            never(&Interval { start, end, ramp }.into(), Some(&instants), dt, steps)
                .unwrap_or_else(|| "acts".into())
        };
        assert_eq!(found(0.0, f64::MAX, 0.0), "acts");
        assert_eq!(found(0.0, f64::MAX, 10.0), "acts");
        assert_eq!(found(0.0505, 0.0506, 0.0), "acts");
        assert_eq!(found(0.0995, 1.0, 0.0), "acts");
        assert!(found(0.0501, 0.0504, 0.0).contains("looks at lies from 0.0501 s to 0.0504 s"));
        assert!(found(0.2, 1.0, 0.0).contains("starts at 0.2 s, and the scenario ends at 0.1 s"));
        assert!(found(1e300, f64::MAX, 0.0).contains("the scenario ends"));
        // Exact steps miss none but those that come too late.
        let exact = |start: f64, end: f64| never(&Interval { start, end, ramp: 0.0 }.into(), None, dt, steps);
        assert_eq!(exact(0.0501, 0.0504), None);
        assert!(exact(0.2, 1.0).is_some_and(|why| why.contains("the scenario ends at 0.1 s")));
    }
}
