//! Points of the box of live parameters: those at which a basis is trained, and fresh ones at which it is
//! measured.
//!
//! Interior points are those of a Latin hypercube (McKay, Beckman and Conover 1979): each parameter takes
//! each of its strata once. Corners are those of a two-level factorial design: all of them up to five live
//! factors, 32 runs of resolution IV up to sixteen, a folded Hadamard matrix beyond (Box and Hunter 1961).

use super::parameters::{LiveParameter, ParameterSpace, region_of};
use crate::linalg::Random;

/// Interior points beside the centre, for each live factor, and at most.
const INTERIOR: (usize, usize) = (4, 48);
/// Factors of which all corners are trained.
const ALL_CORNERS: usize = 5;
/// Fresh points of the interior, and on corners or edges.
const FRESH: [usize; 2] = [16, 16];
/// Start of the draw of fresh points.
const SEED: u64 = 46;

/// Points of the box, each a value for every parameter.
#[derive(Clone, Debug)]
pub(crate) struct Design {
    /// Points that train the basis; parameters that turn no mode have their nominal value.
    pub(crate) trained: Vec<Vec<f64>>,
    /// The middle of the box.
    pub(crate) centre: Vec<f64>,
    /// Points that train nothing.
    pub(crate) fresh: Vec<Vec<f64>>,
}

impl Design {
    pub(crate) fn new(space: &ParameterSpace) -> Self {
        let live: Vec<usize> =
            (0..space.parameters.len()).filter(|&k| region_of(space.parameters[k].role).is_some()).collect();
        let with = |units: &[f64]| {
            let mut values = space.nominal();
            for (&k, &unit) in live.iter().zip(units) {
                values[k] = between(&space.parameters[k], unit);
            }
            values
        };
        let p = live.len();
        let corners = corners(p);
        let interior = (INTERIOR.0 * p).min(INTERIOR.1);
        let inside = [vec![0.5; p]].into_iter().chain(hypercube(p, interior)).chain(corners.clone());
        let mut trained: Vec<Vec<f64>> = vec![space.nominal()];
        for values in inside.map(|units| with(&units)) {
            // The centre of the box may be the values of the problem.
            if !trained.iter().any(|known| is_same(known, &values)) {
                trained.push(values);
            }
        }
        Self { trained, centre: with(&vec![0.5; p]), fresh: fresh(space, &live, &corners) }
    }
}

/// True of one point, up to the digits of a range.
fn is_same(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs())
}

/// A value of a parameter at this share of its range.
fn between(parameter: &LiveParameter, unit: f64) -> f64 {
    let LiveParameter { lower, upper, log, .. } = *parameter;
    // Stiffness and density are factors, whose ratio counts.
    let factor = lower > 0.0 && (log || region_of(parameter.role).is_some());
    match unit {
        0.0 => lower,
        1.0 => upper,
        _ if factor => lower * (upper / lower).powf(unit),
        _ => lower + (upper - lower) * unit,
    }
}

/// Points of a Latin hypercube, in the unit cube.
fn hypercube(p: usize, count: usize) -> Vec<Vec<f64>> {
    let mut random = Random::new(SEED + 1);
    let mut points = vec![vec![0.0; p]; count];
    for j in 0..p {
        let mut strata: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            strata.swap(last, (random.next_u64() % (last as u64 + 1)) as usize);
        }
        for (point, stratum) in points.iter_mut().zip(strata) {
            point[j] = (stratum as f64 + 0.5) / count as f64;
        }
    }
    points
}

/// Corners that train the basis, in the unit cube.
fn corners(p: usize) -> Vec<Vec<f64>> {
    let ends = |signs: Vec<bool>| signs.into_iter().map(|high| f64::from(u8::from(high))).collect();
    if p <= ALL_CORNERS {
        return (0..1_usize << p).map(|run| ends((0..p).map(|k| run >> k & 1 == 1).collect())).collect();
    }
    if p <= 16 {
        // Five base columns, their products of three, and that of all: odd products, so that a main effect is
        // mixed with those of three factors at least.
        let columns: Vec<u32> = (1_u32..32).filter(|column| column.count_ones() % 2 == 1).collect();
        let high = |run: u32, column: u32| (run & column).count_ones() % 2 == 1;
        return (0..32).map(|run| ends(columns[..p].iter().map(|&c| high(run, c)).collect())).collect();
    }
    let size = p.next_power_of_two() as u32;
    let row = |run: u32, folded: bool| {
        ends((0..p as u32).map(|k| ((run & k).count_ones() % 2 == 1) != folded).collect())
    };
    (0..size).flat_map(|run| [row(run, false), row(run, true)]).collect()
}

/// Points that train nothing: of the interior, and corners, or points on edges where all corners train.
fn fresh(space: &ParameterSpace, live: &[usize], trained: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut random = Random::new(SEED);
    let (p, count) = (live.len(), space.parameters.len());
    let [interior, corners] = FRESH;
    let mut points: Vec<Vec<f64>> =
        (0..interior).map(|_| (0..count).map(|_| random.uniform()).collect()).collect();
    while points.len() < interior + corners {
        let mut units: Vec<f64> = (0..count).map(|_| f64::from(u8::from(random.uniform() < 0.5))).collect();
        if p <= ALL_CORNERS {
            let edge = (random.next_u64() % p.max(1) as u64) as usize;
            units[live[edge]] = random.uniform();
        }
        let own: Vec<f64> = live.iter().map(|&k| units[k]).collect();
        if !trained.contains(&own) && !points.contains(&units) {
            points.push(units);
        }
    }
    let values =
        |units: Vec<f64>| units.iter().zip(&space.parameters).map(|(&unit, p)| between(p, unit)).collect();
    points.into_iter().map(values).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_a_design_are_balanced_in_every_pair_of_factors() {
        for p in [1, 2, 5, 6, 8, 16, 17, 64] {
            let runs = corners(p);
            for a in 0..p {
                let high = runs.iter().filter(|run| run[a] == 1.0).count();
                assert_eq!(2 * high, runs.len(), "{p}: factor {a}");
                for b in 0..a {
                    let both = runs.iter().filter(|run| run[a] == 1.0 && run[b] == 1.0).count();
                    assert_eq!(4 * both, runs.len(), "{p}: factors {a} and {b}");
                }
            }
        }
        assert_eq!(corners(8).len(), 32);
    }

    #[test]
    fn points_of_a_hypercube_take_every_stratum_once() {
        for p in [1, 2, 8, 16] {
            let points = hypercube(p, 32);
            for j in 0..p {
                let mut strata: Vec<usize> = points.iter().map(|x| (32.0 * x[j]) as usize).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..32).collect::<Vec<_>>(), "{p}: parameter {j}");
            }
        }
    }
}
