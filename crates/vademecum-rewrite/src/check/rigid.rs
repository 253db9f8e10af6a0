//! A free body: mass and moments that matter can have, and load patterns of its angular velocity that fit
//! them.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};

/// Tolerance for rounding in a sum over all nodes.
const ROUNDED: f64 = 1e-9;

/// Numbers before those of the patterns.
const OWN: usize = 11;

/// Section 59, if the file has it.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    let kind = SectionKind::RigidBody;
    let Some(numbers) = reals_of(file, kind)? else { return Ok(()) };
    let refused = |fault, reason: String| Err(unsound(kind, fault, reason));
    let [mass, _, _, _, xx, xy, xz, yy, yz, zz, first] = numbers[..OWN] else {
        return refused(Fault::Disagrees, format!("{} numbers; expected at least {OWN}", numbers.len()));
    };
    if !file.metadata().diagonal || !file.metadata().scheme.is_exact() {
        let reason = "a free body goes with modes that are moved exactly, which the file does not have";
        return refused(Fault::Disagrees, reason.into());
    }
    if mass <= 0.0 {
        return refused(Fault::Negative, format!("the mass is {mass:e}; expected a positive number"));
    }
    // Of the second moments of the mass, ½ tr(I) − I, none is negative along any direction.
    let half = 0.5 * (xx + yy + zz);
    let second = [half - xx, -xy, -xz, half - yy, -yz, half - zz];
    if !is_positive(&second) {
        let reason = format!(
            "the moments of inertia (xx {xx:e}, xy {xy:e}, xz {xz:e}, yy {yy:e}, yz {yz:e}, zz {zz:e}) are those of no \
             body: along some direction its mass would have a negative second moment"
        );
        return refused(Fault::Negative, reason);
    }
    let patterns = file.metadata().n_patterns as usize;
    if !(first >= 0.0 && first.fract() == 0.0 && first + 6.0 <= patterns as f64) {
        let reason = format!(
            "the first pattern of the angular velocity is {first}; expected a number that leaves six of the {patterns} \
             patterns"
        );
        return refused(Fault::Disagrees, reason);
    }
    // −ω × Iω of each product of components of ω.
    let moments = [
        [0.0, xz, -xy],
        [-yz, 0.0, xy],
        [yz, -xz, 0.0],
        [-xz, yz, xx - yy],
        [yy - zz, -xy, xz],
        [xy, zz - xx, -yz],
    ];
    let wrenches = numbers[OWN..].as_chunks::<6>().0;
    let scale = (mass * half).sqrt();
    for (k, (wrench, expected)) in wrenches[first as usize..].iter().zip(moments).enumerate() {
        let [force, moment] = [&wrench[..3], &wrench[3..]];
        let pushes = force.iter().any(|f| f.abs() > ROUNDED * scale);
        let turns = moment.iter().zip(expected).any(|(m, e)| (m - e).abs() > ROUNDED * half);
        if pushes || turns {
            let reason = format!(
                "pattern {} of the angular velocity has the force {force:?} and the moment {moment:?}; the moments of \
                 inertia give no force and {expected:?}",
                first as usize + k
            );
            return refused(Fault::Disagrees, reason);
        }
    }
    Ok(())
}

/// True if a symmetric matrix (xx, xy, xz, yy, yz, zz) is positive definite, by its leading minors.
fn is_positive(&[xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> bool {
    let two = xx * yy - xy * xy;
    let three = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    xx > 0.0 && two > 0.0 && three > 0.0
}
