//! The step of modes that dashpots couple, from their responses.

use crate::base::lend::{Lender, Short};
use vademecum_format::coupled::CoupledModes;

/// Writes `D` of shape (2r, 2r) and, one after the other, the load maps `P₀ − P₁` and `P₁` of shape (2r, r),
/// column-major, from `S`, `φ` and `ψ`. `unit` is `Δt²/s_ρ`.
pub(crate) fn step_of(
    modes: &CoupledModes<'_>,
    [impulse, step, ramp]: [&[f64]; 3],
    unit: f64,
    [d, loads]: [&mut [f64]; 2],
) -> Result<(), Short> {
    let r = modes.stiffness.len().max(1);
    let half = r.saturating_mul(r).saturating_mul(2);
    let mut d = Lender::new(d);
    let [of_zeta, of_rate] = [d.take(half)?, d.take(half)?];
    let (mut zeta, mut rate) = (Lender::new(of_zeta), Lender::new(&mut *of_rate));
    // Rows of symmetric matrices are their columns.
    let (mut impulses, mut steps) = (Lender::new(impulse), Lender::new(step));
    for (&w2, &own) in modes.stiffness.iter().zip(modes.own) {
        let (s, phi) = (impulses.take(r)?, steps.take(r)?);
        combine(zeta.take(r)?, [(-w2, phi), (0.0, s)]);
        combine(zeta.take(r)?, [(-w2, s), (0.0, phi)]);
        combine(rate.take(r)?, [(1.0, s), (0.0, phi)]);
        combine(rate.take(r)?, [(-own, s), (-w2, phi)]);
    }
    // −S DᵀD of what the rates make of themselves.
    for row in modes.rows.chunks_exact(r) {
        let answer = Lender::new(&mut *loads).take(r)?;
        let mut impulses = Lender::new(impulse);
        for out in &mut *answer {
            let s = impulses.take(r)?;
            *out = s.iter().zip(row).map(|(s, d)| s * d).sum();
        }
        let mut rate = Lender::new(&mut *of_rate);
        for d in row {
            rate.take(r)?;
            rate.take(r)?.iter_mut().zip(&*answer).for_each(|(out, answer)| *out -= answer * d);
        }
    }
    let mut loads = Lender::new(loads);
    let (mut held, mut rising) = (Lender::new(loads.take(half)?), Lender::new(loads.take(half)?));
    let (mut impulses, mut steps, mut ramps) = (Lender::new(impulse), Lender::new(step), Lender::new(ramp));
    for _ in modes.stiffness {
        let (s, phi, psi) = (impulses.take(r)?, steps.take(r)?, ramps.take(r)?);
        combine(held.take(r)?, [(unit, phi), (-unit, psi)]);
        combine(held.take(r)?, [(unit, s), (-unit, phi)]);
        combine(rising.take(r)?, [(unit, psi), (0.0, phi)]);
        combine(rising.take(r)?, [(unit, phi), (0.0, psi)]);
    }
    Ok(())
}

/// A sum of two columns with their factors.
fn combine(out: &mut [f64], [(a, x), (b, y)]: [(f64, &[f64]); 2]) {
    out.iter_mut().zip(x.iter().zip(y)).for_each(|(out, (x, y))| *out = a * x + b * y);
}
