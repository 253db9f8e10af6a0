//! The canonical structure: the chapter's stage maps, looked up axis by axis at every step.
//!
//! A stage is a sum of terms, each a product of one-dimensional functions of the state's coordinates and of the load. Evaluating it
//! is one interpolation per axis for all terms at once, then one weighted sum of r numbers a term. Where state and load are apart,
//! what the loads contribute does not depend on the state: it is summed when they are added, contact by contact.
//!
//! The odd thing: the functions end where their ranges do. A coordinate that leaves its range is refused by name with the state
//! unchanged; nothing is clamped or extrapolated. There is no map to fuse, so the stages run one after the other.

use crate::error::{BindError, LoadError, StepError};
use crate::kernel::flushed;
use crate::loads::{Amplitudes, Contact, Loads};
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::state::State;
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{Chapter, ChapterAxis, ChapterPart, ChapterRole};

/// The one load that terms over state *and* load can stand under.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Held {
    /// Whether there is one.
    pub present: bool,
    position: usize,
    magnitudes: [f64; MAX_STAGES],
    components: [f64; 3],
}

impl Held {
    fn value(&self, role: ChapterRole, stage: usize) -> f64 {
        match role {
            ChapterRole::Magnitude => self.magnitudes.get(stage).copied().unwrap_or_default(),
            ChapterRole::Component { component } => {
                self.components.get(component).copied().unwrap_or_default()
            }
            _ => self.position as f64,
        }
    }
}

/// Rounds factors and terms to the scene's precision, factors first, in the order of the file.
pub(crate) fn lay_out<T: Scalar>(canonical: &Chapter<'_>, map: &mut [T]) -> Result<(), BindError> {
    let factors = canonical.parts().flat_map(|part| part.factors);
    let numbers = factors.chain(canonical.parts().flat_map(|part| part.terms));
    for (out, &bytes) in map.iter_mut().zip(numbers) {
        *out = T::from_f64(f64::from_le_bytes(bytes));
        if !out.to_f64().is_finite() {
            return Err(BindError::NotFinite);
        }
    }
    Ok(())
}

/// Parts with their rounded factors and terms.
fn pieces<'s, T: Scalar>(
    canonical: &Chapter<'s>,
    map: &'s [T],
) -> impl Iterator<Item = (ChapterPart<'s>, &'s [T], &'s [T])> {
    let (mut factors, mut terms) = map.split_at_checked(canonical.lengths().0).unwrap_or_default();
    canonical.parts().map(move |part| {
        let (own_factors, rest) = factors.split_at_checked(part.factors.len()).unwrap_or_default();
        factors = rest;
        let (own_terms, rest) = terms.split_at_checked(part.terms.len()).unwrap_or_default();
        terms = rest;
        (part, own_factors, own_terms)
    })
}

/// One step: the stages in order, then the scheme's finish, beside the state. Gives `Σ|y|` of the new one.
pub(crate) fn step<T: Scalar>(
    scene: &Scene<'_, T>,
    state: &mut State<'_, T>,
    loads: &Loads<'_, T>,
) -> Result<T, StepError> {
    let canonical = scene.sections.canonical.as_ref().ok_or(StepError::Mismatch)?;
    let (r, now) = (scene.shape.r, &*state.now);
    let (stages, weights) = state.scratch.split_at_mut_checked(scene.shape.n_stages * r).unwrap_or_default();
    stages.iter_mut().zip(&*loads.increment).for_each(|(stage, &load)| *stage = load);
    for (part, factors, terms) in pieces(canonical, scene.map) {
        if !part.has_state() {
            continue;
        }
        let stage = part.stage;
        let (earlier, rest) = stages.split_at_mut_checked(stage.saturating_mul(r)).unwrap_or_default();
        let out = rest.get_mut(..r).unwrap_or_default();
        let value = |role: ChapterRole| match role {
            ChapterRole::State { family, mode } => entry(now, earlier, r, family, mode),
            other => loads.held.value(other, stage),
        };
        add_part(&part, factors, terms, value, weights, out).map_err(|(axis, value)| {
            StepError::OutsideAxis { stage, role: axis.role, value, lower: axis.lower, upper: axis.upper }
        })?;
    }
    let mut sum = T::ZERO;
    let rows = scene.metadata.scheme.finish.iter();
    for (row, new) in rows.zip(state.next.chunks_exact_mut(r.max(1))) {
        for (mode, new) in new.iter_mut().enumerate() {
            let terms = row.iter().take(3 + scene.shape.n_stages).enumerate();
            let value: f64 = terms.map(|(family, w)| w * entry(now, stages, r, family, mode)).sum();
            *new = flushed(T::from_f64(value), &mut sum);
        }
    }
    Ok(sum)
}

/// An entry of the history `(ζ, Δt ζ̇, Δt² ζ̈, ζ_1, …)`.
fn entry<T: Scalar>(now: &[T], stages: &[T], r: usize, family: usize, mode: usize) -> f64 {
    let (from, family) = if family < 3 { (now, family) } else { (stages, family - 3) };
    from.get(family * r + mode).map(|x| x.to_f64()).unwrap_or_default()
}

/// Adds `Σ_t (Π_a g_ta(x_a)) f_t` to `out`, length r; the axis and the value if one is not on it.
fn add_part<T: Scalar>(
    part: &ChapterPart<'_>,
    factors: &[T],
    terms: &[T],
    value: impl Fn(ChapterRole) -> f64,
    weights: &mut [T],
    out: &mut [T],
) -> Result<(), (ChapterAxis, f64)> {
    let n = part.n_terms;
    let weights = weights.get_mut(..n).unwrap_or_default();
    weights.fill(T::from_f64(1.0));
    let mut rest = factors;
    for axis in part.axes() {
        let (own, others) = rest.split_at_checked(axis.points.saturating_mul(n)).unwrap_or_default();
        rest = others;
        let (left, share) = place(&axis, value(axis.role))?;
        let row = |point: usize| {
            let at = point.saturating_mul(n);
            own.get(at..at.saturating_add(n))
        };
        let left_row = row(left).unwrap_or_default();
        let right_row = row(left.saturating_add(1)).unwrap_or(left_row);
        let (a, b) = (T::from_f64(1.0 - share), T::from_f64(share));
        for ((weight, &left), &right) in weights.iter_mut().zip(left_row).zip(right_row) {
            *weight = *weight * (a * left + b * right);
        }
    }
    let mut rows = terms.chunks_exact(out.len().max(1));
    for &weight in &*weights {
        let row = rows.next().unwrap_or_default();
        out.iter_mut().zip(row).for_each(|(out, &f)| *out += weight * f);
    }
    Ok(())
}

/// The point at or before a value of the history, and how far it is to the next.
fn place(axis: &ChapterAxis, value: f64) -> Result<(usize, f64), (ChapterAxis, f64)> {
    let x = axis.factor * value;
    if !(axis.lower <= x && x <= axis.upper) {
        return Err((*axis, x));
    }
    if axis.role == ChapterRole::Position {
        return Ok((x as usize, 0.0));
    }
    let t = (x - axis.lower) / (axis.upper - axis.lower) * axis.points.saturating_sub(1) as f64;
    let left = (t as usize).min(axis.points.saturating_sub(2));
    Ok((left, t - left as f64))
}

/// A force as the axes have it: magnitude and direction.
fn along(canonical: &Chapter<'_>, force: [f64; 3]) -> Result<(f64, [f64; 3]), LoadError> {
    let size = libm::sqrt(force.iter().map(|f| f * f).sum());
    let Some(direction) = canonical.direction() else {
        let unit = if size > 0.0 { force.map(|f| f / size) } else { [0.0; 3] };
        return Ok((size, unit));
    };
    let magnitude: f64 = force.iter().zip(direction).map(|(f, d)| f * d).sum();
    let mut across = force.iter().zip(direction).map(|(f, d)| f - magnitude * d);
    // A direction given in decimals is off by its last digits.
    if across.any(|x| x.abs() > 1e-9 * size) {
        return Err(LoadError::OtherDirection);
    }
    Ok((magnitude, direction))
}

/// Adds a contact whose row of `B` stands in the loads already; all of it or nothing.
pub(crate) fn add_contact<T: Scalar>(
    loads: &mut Loads<'_, T>,
    scene: &Scene<'_, T>,
    contact: &Contact,
    p: Amplitudes,
) -> Result<(), LoadError> {
    let canonical = scene.sections.canonical.as_ref().ok_or(LoadError::Mismatch)?;
    let (magnitude, components) = along(canonical, contact.force)?;
    let r = scene.shape.r;
    let (_, stages) = loads.rows.split_at_mut_checked(r).unwrap_or_default();
    stages.fill(T::ZERO);
    let joint = canonical.parts().any(|part| part.has_state() && part.has_load());
    let mut held = loads.held;
    for (&node, weight) in contact.nodes.iter().zip(contact.weights) {
        if weight == 0.0 {
            continue;
        }
        let position = canonical.positions().position(|known| known == node);
        let position = position.ok_or(LoadError::NotAPosition { node })?;
        let own = Held {
            present: true,
            position,
            magnitudes: p.stages.map(|s| s * weight * magnitude),
            components,
        };
        if joint && (held.present || weight != 1.0) {
            return Err(LoadError::OneContact);
        }
        held = own;
        for (part, factors, terms) in pieces(canonical, scene.map).filter(|(part, _, _)| part.has_load()) {
            let value = |role: ChapterRole| own.value(role, part.stage);
            let outside = |(axis, value): (ChapterAxis, f64)| LoadError::OutsideAxis {
                role: axis.role,
                value,
                lower: axis.lower,
                upper: axis.upper,
            };
            if joint {
                let mut axes = part.axes().filter(|axis| !axis.is_state());
                axes.try_for_each(|axis| place(&axis, value(axis.role)).map(|_| ())).map_err(outside)?;
                continue;
            }
            let at = part.stage.saturating_mul(r);
            let out = stages.get_mut(at..at.saturating_add(r)).unwrap_or_default();
            add_part(&part, factors, terms, value, loads.scratch, out).map_err(outside)?;
        }
    }
    if joint {
        loads.held = held;
    }
    loads.increment.iter_mut().zip(stages).for_each(|(sum, &mut x)| *sum += x);
    Ok(())
}
