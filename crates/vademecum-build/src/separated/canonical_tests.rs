//! The chapter's representation on the beam, each repair apart.

use super::canonical::*;
use super::surrogate::Pencil;
use super::*;
use faer::sparse::{SparseColMat, Triplet};
use faer::Mat;
use std::time::Instant;

/// Stage 1 (`third` is Δt² ζ̈, weights 16, 8, 1) or 2 (`third` is ζ½, weights −19, −5, 28) of Bathe's scheme.
struct Case {
    beam: Pencil,
    dt: f64,
}

impl Case {
    fn new(beam: Pencil) -> Case {
        let dt = 2.0 * std::f64::consts::PI / beam.eigenvalues[0].sqrt() / 35.0;
        Case { beam, dt }
    }

    /// `(m M + Δt² K)`.
    fn space(&self, m: f64) -> SparseSpace {
        let n = self.beam.mass.nrows();
        let mut entries = Vec::new();
        for j in 0..n {
            for (i, v) in self.beam.mass.row_idx_of_col(j).zip(self.beam.mass.val_of_col(j)) {
                let k = self.beam.stiffness[0].as_ref().get(i, j).copied().unwrap_or(0.0);
                entries.push(Triplet::new(i, j, m * v + self.dt.powi(2) * k));
            }
        }
        SparseSpace::new(vec![SparseColMat::try_new_from_triplets(n, n, &entries).unwrap()]).unwrap()
    }

    /// Ranges as free vibration from a tip load makes them: amplitude `a_j = φ_j(L)/λ_j`, velocity `ω a`, not centred.
    fn stage(&self, second: bool, positions: usize) -> CanonicalStage {
        let b = &self.beam.modes;
        let (n, r) = (b.nrows(), b.ncols());
        let mb = self.beam.energy()(b.as_ref());
        let amplitude = |j: usize| (b[(n - 2, j)] / self.beam.eigenvalues[j]).abs();
        let range = |power: i32| -> Vec<(f64, f64)> {
            let size = |j: usize| amplitude(j) * self.beam.eigenvalues[j].sqrt().powi(power);
            (0..r).map(|j| (-1.1 * size(j), 0.9 * size(j))).collect()
        };
        let weights = if second { [-19.0, -5.0, 28.0] } else { [16.0, 8.0, 1.0] };
        let third = if second { ("zeta_half_", 0, 1.0) } else { ("zeta_ddot_", 2, self.dt.powi(2)) };
        let families = [("zeta_", 0, 1.0), ("zeta_dot_", 1, self.dt), third];
        let families = families.iter().zip(weights).map(|((name, power, scale), w)| StateFamily {
            name: name.to_string(),
            unit: "1".into(),
            ranges: range(*power),
            scale: *scale,
            columns: Mat::from_fn(n, r, |i, j| w * mb[(i, j)]),
        });
        let at = |s: usize| 2 * ((s + 1) * (n / 2) / positions - 1);
        let loads = Mat::from_fn(n, positions, |i, s| if i == at(s) { self.dt.powi(2) } else { 0.0 });
        CanonicalStage { families: families.collect(), magnitude: (0.0, 1.0), components: Vec::new(), loads, points: 7 }
    }
}

#[test]
#[ignore = "measurement"]
fn measure_canonical() {
    for (pencil, positions) in [
        (Pencil::beam(150, 1, 6), 20),
        (Pencil::beam(150, 1, 8), 20),
        (Pencil::lattice(15, 15, 45, 1, 8), 100),
    ] {
        let modes = pencil.modes.ncols();
        let case = Case::new(pencil);
        let rank = 3 * modes + positions;
        for second in [false, true] {
            let (stage, space) = (case.stage(second, positions), case.space(if second { 9.0 } else { 16.0 }));
            println!("n = {}, r = {modes}, n_s = {positions}, stage {}: load share {:.1e}", case.beam.mass.nrows(), 1 + usize::from(second),
                load_share(&stage, &space, &case.beam.energy()).unwrap());
            let chapter = CanonicalOptions::chapter(1e-7, rank);
            let all = CanonicalOptions::repaired(1e-7, rank);
            let with = |o: &CanonicalOptions, updates: usize, start: bool| CanonicalOptions {
                one_axis_start: start,
                enrichment: EnrichmentOptions { update_sweeps: updates, ..o.enrichment.clone() },
                ..o.clone()
            };
            let variants = [
                ("chapter", chapter.clone()),
                ("scaled", CanonicalOptions { scaled_coordinates: true, ..chapter.clone() }),
                ("separate", CanonicalOptions { separate_blocks: true, ..chapter.clone() }),
                ("start", with(&chapter, 0, true)),
                ("updates", with(&chapter, 3, false)),
                ("all but start", with(&all, 3, false)),
                ("all but updates", with(&all, 0, true)),
                ("all", all),
            ];
            for (name, options) in variants {
                let clock = Instant::now();
                let found = separate(&stage, &space, &case.beam.energy(), &options).unwrap();
                let history: Vec<String> = found.reports.iter().map(|r| {
                    let at = |n: usize| r.history.get(n - 1).map_or(String::new(), |v| format!("{n}: {v:.1e} "));
                    [10, 20, 40].iter().map(|n| at(*n)).collect()
                }).collect();
                println!("  {name:16} {} terms, total {:.1e} state {:.1e} load {:.1e}, {:.2} s; {:?} {:?}", found.solution.n_terms(),
                    found.error.total, found.error.state, found.error.load, clock.elapsed().as_secs_f64(),
                    found.reports.iter().map(|r| r.stop).collect::<Vec<_>>(), history);
            }
        }
    }
}
