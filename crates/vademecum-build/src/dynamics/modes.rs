//! The lowest natural modes, `K φ = λ M φ`, by block Lanczos on `K⁻¹ M`.
//!
//! `K⁻¹ M` is self-adjoint in the inner product of the mass, its largest eigenvalues `θ = 1/λ` are the modes
//! wanted, and it needs only a factor of `K`. The basis is kept orthogonal against all of itself (no ghosts)
//! and the Rayleigh–Ritz problem is solved on all of it. A Krylov space can miss a mode its start does not
//! see (or more copies of a multiple one than the block is wide), so once everything has nearly converged a
//! fresh random block joins, and only if its expansion changes nothing the answer stands (Parlett, *The
//! Symmetric Eigenvalue Problem*, ch. 13).

use std::sync::{Mutex, PoisonError};

use super::krylov::{Krylov, SearchSpace};
use super::natural::{Modes, ModesError};
use crate::fem::{FactorError, Pencil, PencilRows, Search, Symbolic, pencil_rows};
use crate::progress::Cancelled;
use crate::store::CachedSolves;

/// Ritz residual `‖K⁻¹M x − θ x‖ / θ`, in the mass norm, at which a mode counts as converged. It bounds the
/// relative error of its eigenvalue (whose true error is of the order of its square over the gap).
const TOLERANCE: f64 = 5e-9;

/// The same where only the first frequency is wanted: a Ritz value is off by the square.
const ROUGH: f64 = 3e-5;

/// Share of the lowest eigenvalue that may be rounding. Above it fewer than three digits of the first
/// frequency are left, and phase errors of a percent come within a few periods.
const LOST: f64 = 1e-3;

/// Expansions of a probe block before the result is accepted.
const PROBES: usize = 2;

/// Ritz residual of all modes at which a probe joins, as a multiple of that at which they count as converged:
/// they converge while it is expanded. What a probe finds has a larger one.
const NEAR: f64 = 1e3;

/// The `count` lowest modes of a pencil, with `symbolic` the analysis of its pattern.
///
/// One factor of `K`, then some two or three solves per mode; memory for up to `3 count + 192` vectors.
/// Deterministic.
///
/// An entry of `K` is rounded to ε of itself, so every eigenvalue is known to about `ε λ_max` and no better,
/// whoever computes it: where that is more than a thousandth of the lowest, there is nothing to compute with.
///
/// # Errors
/// [`ModesError`]. Modes that have not converged are no error: see [`Modes::residuals`].
pub fn lowest_modes(pencil: &Pencil, symbolic: &Symbolic, count: usize) -> Result<Modes, ModesError> {
    Ok(search(pencil, symbolic, count, (TOLERANCE, PROBES), (None, None))?.0)
}

/// The same, of which solves are kept while it goes on; it ends when the user wants to stop. It goes on from
/// the search for the first mode of the same pencil, where that is at hand, and finds the same bits.
///
/// # Errors
/// As [`lowest_modes`]; [`Cancelled`].
pub(crate) fn lowest_modes_kept(
    pencil: &Pencil,
    symbolic: &Symbolic,
    count: usize,
    (kept, first): (&CachedSolves<'_>, Option<&FirstMode>),
) -> Result<Modes, ModesError> {
    let grown = first.and_then(FirstMode::take);
    Ok(search(pencil, symbolic, count, (TOLERANCE, PROBES), (Some(kept), grown))?.0)
}

/// The first natural frequency of a body, and what the search for it has grown.
pub struct FirstMode {
    /// Hz, to eight digits, as far as the matrices have them.
    pub frequency_hz: f64,
    /// Until a search goes on from it. Nothing on several ranks, each of which has its own rows.
    grown: Mutex<Option<SearchSpace>>,
}

impl FirstMode {
    /// Finds it with less work than [`lowest_modes`]: nothing is probed for.
    ///
    /// # Errors
    /// [`ModesError`].
    pub fn find(pencil: &Pencil, symbolic: &Symbolic) -> Result<Self, ModesError> {
        let (first, grown) = search(pencil, symbolic, 1, (ROUGH, 0), (None, None))?;
        let grown = Mutex::new(grown.filter(|_| !symbolic.is_spread()));
        Ok(Self { frequency_hz: first.frequencies_hz()[0], grown })
    }

    /// s.
    pub fn period(&self) -> f64 {
        1.0 / self.frequency_hz
    }

    /// Drops the vectors that the search has grown.
    pub(crate) fn forget(&self) {
        self.take();
    }

    fn take(&self) -> Option<SearchSpace> {
        self.grown.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// Solves that are kept, and what an earlier search has grown.
type SearchStart<'a> = (Option<&'a CachedSolves<'a>>, Option<SearchSpace>);

/// The lowest modes to a residual, after more expansions, and what a search for more can go on from.
fn search(
    pencil: &Pencil,
    symbolic: &Symbolic,
    count: usize,
    (tolerance, probes): (f64, usize),
    begun: SearchStart<'_>,
) -> Result<(Modes, Option<SearchSpace>), ModesError> {
    let n = pencil.n_elastic();
    if count == 0 || count > n {
        return Err(ModesError::Count { count, n });
    }
    let factor = symbolic.factor_of(pencil.stiffness()).map_err(|error| match error {
        // The stiffness of a solid has no negative eigenvalue: what shows as one is zero, rounded.
        FactorError::NotPositiveDefinite { .. } => ModesError::LostInRounding { share: f64::INFINITY },
        other => ModesError::Factor(other),
    })?;
    let stiffest = stiffest_dof(pencil);
    let search = Search { count, available: n, tolerance, probes, stiffest };
    let (modes, grown) = search_from(pencil_rows(pencil, &factor, &search)?.as_mut(), &search, begun)?;
    let share = f64::EPSILON * stiffest / modes.eigenvalues[0].max(0.0);
    if share <= LOST { Ok((modes, grown)) } else { Err(ModesError::LostInRounding { share }) }
}

/// The modes of a search, on rows that are all here or spread over ranks, each of which calls this. The
/// shapes are whole on the first rank and have no rows on the others. Only the first rank knows of kept
/// solves.
///
/// # Errors
/// As [`lowest_modes`]; [`Cancelled`].
pub fn search_on(
    rows: &mut dyn PencilRows,
    search: &Search,
    kept: Option<&CachedSolves<'_>>,
) -> Result<Modes, ModesError> {
    Ok(search_from(rows, search, (kept, None))?.0)
}

/// The same, from what an earlier search for fewer modes with a looser tolerance has grown.
fn search_from(
    rows: &mut dyn PencilRows,
    search: &Search,
    (kept, grown): SearchStart<'_>,
) -> Result<(Modes, Option<SearchSpace>), ModesError> {
    let Search { count, tolerance, probes, .. } = *search;
    // What has grown is looked at before it grows on, as it would have been.
    let mut is_new = grown.is_some();
    let mut space = match grown {
        Some(grown) => Krylov::resume(rows, search, kept, grown),
        None => Krylov::new(rows, search, kept)?,
    };
    // Expansions of the last probe.
    let mut probed: Option<usize> = None;
    let ritz = loop {
        if space.is_stopped()? {
            return Err(Cancelled.into());
        }
        if !std::mem::take(&mut is_new) {
            space.expand()?;
        }
        let ritz = space.ritz()?;
        let within = |r: f64| ritz.values.len() >= count && ritz.residuals[..count].iter().all(|&x| x <= r);
        // What a probe finds asks for another one.
        probed = probed.map(|expansions| expansions + 1).filter(|_| within(NEAR * tolerance));
        if (within(tolerance) && probed.unwrap_or(0) >= probes) || space.is_full() {
            break ritz;
        }
        if probes > 0 && probed.is_none() && within(NEAR * tolerance) {
            space.add_random_block()?;
            probed = Some(0);
        }
        if space.frontier() == 0 {
            space.add_random_block()?;
            if space.frontier() == 0 {
                break ritz;
            }
        }
    };
    let modes = space.modes(&ritz, count)?;
    Ok((modes, space.grown()))
}

/// The largest `K_ii / M_ii`, 1/s²: a Rayleigh quotient, so the largest eigenvalue from below, and within a
/// small factor of it for finite elements. Dofs without mass are left out.
fn stiffest_dof(pencil: &Pencil) -> f64 {
    let (mass, stiffness) = (pencil.mass(), pencil.stiffness());
    let massive = (0..pencil.n_dof()).filter(|&i| mass.diagonal(i) > 0.0);
    massive.map(|i| stiffness.diagonal(i) / mass.diagonal(i)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use faer::Mat;

    use super::*;
    use crate::fem::Model;
    use crate::fem::test_mesh::{block, hold};
    use crate::fem::{Material, ModelError};
    use crate::linalg::symmetric_eigen;
    use crate::progress::{Listener, Silent};
    use crate::store::Store;

    fn beam(cells: [usize; 3], size: [f64; 3]) -> Result<Model, ModelError> {
        let mesh = block(cells, size);
        let held = hold(&mesh, |p| p[0] == 0.0);
        Model::assemble(mesh, &[Material::isotropic(1e7, 0.3, 1000.0)], &held)
    }

    /// A chain of unit masses and springs held at one end: `λ_j = 4 sin²((2j−1)π/(4n+2))`.
    fn chain(n: usize) -> Pencil {
        let mass: Vec<_> = (0..n as u32).map(|i| (i, i, 1.0)).collect();
        let mut stiffness = Vec::new();
        for i in 0..n as u32 {
            stiffness.push((i, i, if i + 1 == n as u32 { 1.0 } else { 2.0 }));
            if i > 0 {
                stiffness.extend([(i, i - 1, -1.0), (i - 1, i, -1.0)]);
            }
        }
        Pencil::from_triplets(n, &mass, &stiffness).unwrap()
    }

    #[test]
    fn a_chain_has_its_textbook_frequencies() {
        for (n, count) in [(1, 1), (2, 2), (9, 9), (400, 30)] {
            let pencil = chain(n);
            let modes = lowest_modes(&pencil, &Symbolic::analyze(&pencil).unwrap(), count).unwrap();
            for (j, &found) in modes.eigenvalues.iter().enumerate() {
                let angle = (2 * j + 1) as f64 * std::f64::consts::PI / (4 * n + 2) as f64;
                let exact = 4.0 * angle.sin().powi(2);
                // What the module promises; the residual bounds it.
                assert!((found / exact - 1.0).abs() < 1e-8, "n = {n}, mode {j}: {found} for {exact}");
            }
        }
    }

    #[test]
    fn twelve_copies_of_one_mode_are_all_found() {
        // More copies than the start block is wide: only the probes can find the rest.
        let n = 300;
        let mass: Vec<_> = (0..n).map(|i| (i, i, 1.0)).collect();
        let stiffness: Vec<_> = (0..n).map(|i| (i, i, if i < 12 { 1.0 } else { f64::from(i) })).collect();
        let pencil = Pencil::from_triplets(n as usize, &mass, &stiffness).unwrap();
        let modes = lowest_modes(&pencil, &Symbolic::analyze(&pencil).unwrap(), 14).unwrap();
        for (j, &found) in modes.eigenvalues.iter().enumerate() {
            let exact = if j < 12 { 1.0 } else { j as f64 };
            assert!((found / exact - 1.0).abs() < 1e-8, "mode {j}: {found} for {exact}");
        }
    }

    #[test]
    fn modes_of_a_square_beam_solve_the_pencil() {
        let model = beam([24, 3, 3], [1.0, 0.1, 0.1]).unwrap();
        let pencil = model.pencil();
        let modes = lowest_modes(pencil, &Symbolic::analyze(pencil).unwrap(), 20).unwrap();
        assert!(modes.residuals.iter().all(|r| *r < 1e-8), "{:?}", modes.residuals);
        assert!(modes.eigenvalues.is_sorted());
        for i in 0..20 {
            for j in 0..20 {
                let (x, y) = (modes.vectors.col_as_slice(i), modes.vectors.col_as_slice(j));
                let expected = f64::from(i == j);
                // Orthonormal to the rounding of n products in a basis of unit vectors.
                assert!((pencil.mass().inner(x, y) - expected).abs() < 1e-12);
                // A Ritz value is stationary: its error is of second order in the residual.
                let rayleigh = pencil.stiffness().inner(x, y) / modes.eigenvalues[i.max(j)];
                assert!((rayleigh - expected).abs() < 1e-8);
            }
        }
        // Euler–Bernoulli: linear tetrahedra are too stiff, so above it, and within half of it on this mesh.
        let bending = 0.5596 * (1e7_f64 * 0.1_f64.powi(4) / 12.0 / (1000.0 * 0.01)).sqrt();
        let first = modes.frequencies_hz()[0];
        assert!(first > bending && first < 1.5 * bending, "{first} Hz against {bending} Hz");
    }

    #[test]
    fn impossible_counts_and_singular_masses_are_named() {
        let pencil = chain(3);
        let symbolic = Symbolic::analyze(&pencil).unwrap();
        assert_eq!(lowest_modes(&pencil, &symbolic, 4).unwrap_err(), ModesError::Count { count: 4, n: 3 });
        let stiffness: Vec<_> = (0..3).map(|i| (i, i, 1.0)).collect();
        let massless = Pencil::from_triplets(3, &[(0, 0, 1.0)], &stiffness).unwrap();
        let found = lowest_modes(&massless, &Symbolic::analyze(&massless).unwrap(), 2);
        assert_eq!(found.unwrap_err(), ModesError::SingularMass { found: 1 });
    }

    #[test]
    fn a_first_frequency_below_the_rounding_of_the_stiffness_is_refused() {
        // Two springs in a row, the second 1e13 or 1e17 times as stiff as the first: λ₁ = 1, λ₂ = 2 · stiff.
        let body = |stiff: f64| {
            let mass = [(0, 0, 1.0), (1, 1, 1.0)];
            let stiffness = [(0, 0, 1.0 + stiff), (0, 1, -stiff), (1, 0, -stiff), (1, 1, stiff)];
            Pencil::from_triplets(2, &mass, &stiffness).unwrap()
        };
        let modes = |pencil: &Pencil| lowest_modes(pencil, &Symbolic::analyze(pencil).unwrap(), 1);
        assert!(modes(&body(1e10)).is_ok());
        // In between, λ₁ = ½ is known to ε · 1e13 / ½.
        let share = f64::EPSILON * 1e13 / 0.5;
        match modes(&body(1e13)) {
            Err(ModesError::LostInRounding { share: found }) => {
                assert!((found / share - 1.0).abs() < 2.0 * share)
            }
            other => panic!("{other:?}"),
        }
        // 1 + 1e17 is 1e17: a free body, whatever the factorisation makes of it.
        let lost = modes(&body(1e17));
        assert!(matches!(lost, Err(ModesError::LostInRounding { share }) if share >= 0.1), "{lost:?}");
    }

    #[test]
    fn eigenvalues_of_tiny_matrices_are_right() {
        // A matrix with known eigenvalues 1…200 scaled to 1e-16: I − 2wwᵀ turns the diagonal.
        let n = 200;
        let w = (1.0 / n as f64).sqrt();
        let reflect = |i: usize, k: usize| f64::from(i == k) - 2.0 * w * w;
        let dense = Mat::from_fn(n, n, |i, j| {
            1e-16 * (0..n).map(|k| reflect(i, k) * (k + 1) as f64 * reflect(k, j)).sum::<f64>()
        });
        let (values, _) = symmetric_eigen(dense.as_ref()).unwrap();
        for (i, value) in values.iter().enumerate() {
            // Backward error of a symmetric eigensolver: a few n units in the last place of the norm.
            assert!((value * 1e16 - (i + 1) as f64).abs() < 200.0 * 200.0 * f64::EPSILON * 4.0);
        }
    }

    #[test]
    fn a_search_goes_on_from_that_for_the_first_mode_to_the_same_bits() {
        let model = beam([24, 4, 4], [1.0, 0.1, 0.1]).unwrap();
        let symbolic = Symbolic::analyze(model.pencil()).unwrap();
        for count in [1, 3, 40] {
            let whole = lowest_modes(model.pencil(), &symbolic, count).unwrap();
            let first = FirstMode::find(model.pencil(), &symbolic).unwrap();
            let off = (first.frequency_hz / whole.frequencies_hz()[0] - 1.0).abs();
            assert!(off < 1e-8, "{off:e}");
            assert!(first.grown.lock().unwrap().is_some(), "nothing is handed on");
            let begun = (&CachedSolves::new(None, &Silent), Some(&first));
            let found = lowest_modes_kept(model.pencil(), &symbolic, count, begun).unwrap();
            assert_eq!((found.eigenvalues, found.vectors), (whole.eigenvalues, whole.vectors));
            assert!(first.take().is_none());
        }
    }

    /// Wants to stop when asked for the fifth time.
    struct Impatient(AtomicUsize);

    impl Listener for Impatient {
        fn stage(&self, _: &str) {}
        fn advance(&self, _: usize, _: usize) {}
        fn note(&self, _: &str) {}
        fn cancelled(&self) -> bool {
            self.0.fetch_add(1, Ordering::Relaxed) == 4
        }
    }

    #[test]
    fn a_search_that_was_stopped_goes_on_to_the_same_bits() {
        let model = beam([12, 3, 3], [1.0, 0.1, 0.1]).unwrap();
        let (pencil, folder) = (model.pencil(), tempfile::tempdir().unwrap());
        let symbolic = Symbolic::analyze(pencil).unwrap();
        let whole = lowest_modes(pencil, &symbolic, 40).unwrap();
        let store = Store::new(&folder.path().join("work"), false);
        let listener = Impatient(AtomicUsize::new(0));
        let first = CachedSolves::of_all(&store, &listener);
        let stopped = lowest_modes_kept(pencil, &symbolic, 40, (&first, None));
        assert!(matches!(stopped, Err(ModesError::Cancelled(_))));
        // The start, and four expansions.
        let files = || std::fs::read_dir(store.folder()).unwrap().map(|file| file.unwrap().path());
        assert_eq!((files().count(), first.found()), (5, 0));
        // One of them is damaged, and solved for again.
        std::fs::write(files().next().unwrap(), b"half").unwrap();
        let again = CachedSolves::of_all(&store, &Silent);
        let modes = lowest_modes_kept(pencil, &symbolic, 40, (&again, None)).unwrap();
        assert_eq!(again.found(), 4);
        assert_eq!(modes.eigenvalues, whole.eigenvalues);
        assert_eq!(modes.vectors, whole.vectors);
        again.forget();
        assert_eq!(files().count(), 0);
    }
}
