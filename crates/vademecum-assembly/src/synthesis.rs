//! Component mode synthesis with residual flexibility, the forces of the joints eliminated.
//!
//! With the coordinates `q` of all parts, `u = B q + R F`, and rows `g = Γ q + G R F + S f` of the joints
//! that are zero, `S = G R Gᵀ + C` and `N = G R M R Gᵀ`:
//!
//! ```text
//! f  = −S⁻¹(Γ q + G R F)         L = S⁻¹Γ
//! K' = Λ + ΓᵀL                   M' = I + LᵀN L
//! K' Y = M' Y Ω                  YᵀM'Y = I          q = Y η
//! ```
//!
//! With `N` this is Rubin's synthesis (1975), without it MacNeal's (1971). `K'` is positive semidefinite,
//! since the forces are eliminated and are no unknowns (compare Rixen 2004).

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use vademecum_build::dynamics::{COUPLED, coupling_error, damping_rows};
use vademecum_build::linalg::{sequential_product as product, symmetric_eigen};

use crate::error::AssemblyError;
use crate::joint::JointRow;
use crate::part::Part;

/// An eigenvalue that is a smaller share of the largest one is that of a motion without stiffness.
const RIGID: f64 = 1e-12;

/// A pivot of `S` that is a smaller share of its entry is that of a row that follows from others.
const DEPENDENT: f64 = 1e-11;

/// The joined body in the coordinates of its parts.
pub(crate) struct Synthesis {
    /// Rows of the joints over the rows of the ports of each part.
    pub weights: Vec<Mat<f64>>,
    /// First coordinate of each part.
    pub firsts: Vec<usize>,
    /// Factor of `S`.
    pub compliance: Option<Llt<f64>>,
    /// `L`, shape (rows, coordinates).
    pub answers: Mat<f64>,
    /// `Y`, shape (coordinates, modes).
    pub shapes: Mat<f64>,
    /// `Ω` \[rad²/s²\], ascending.
    pub eigenvalues: Vec<f64>,
    /// The damping of the modes.
    pub damping: Damped,
    /// True if the inertia of what the parts leave out is known.
    pub rubin: bool,
}

/// A matrix over the rows of the ports of a part.
type OfPart<'f> = &'f dyn Fn(&Part<'_>) -> Option<Mat<f64>>;

/// Damping of the joined modes.
pub(crate) enum Damped {
    /// Rayleigh's, `α` and `β`, and a ratio of every mode, the same of all parts.
    Alike { alpha: f64, beta: f64, ratio: f64 },
    /// A ratio for each mode; and the largest change by what that leaves out.
    Ratios(Vec<f64>, f64),
    /// Rows of a damping matrix that couples modes; and the change without it.
    Rows(Mat<f64>, f64),
}

impl Synthesis {
    /// Joins parts.
    ///
    /// # Errors
    /// [`AssemblyError`]: rows that follow from others, a body that is not held.
    pub fn new(
        parts: &[Part<'_>],
        rows: &[JointRow],
        name: impl Fn(usize) -> String,
    ) -> Result<Self, AssemblyError> {
        let m = rows.len();
        let mut firsts = vec![];
        let mut total = 0;
        for part in parts {
            firsts.push(total);
            total += part.n_modes();
        }
        let mut weights: Vec<Mat<f64>> = parts.iter().map(|part| Mat::zeros(m, part.rows.nrows())).collect();
        for (i, row) in rows.iter().enumerate() {
            row.terms.iter().for_each(|&(part, port, weight)| weights[part][(i, port)] += weight);
        }
        let mut s = Mat::from_fn(m, m, |i, j| if i == j { rows[i].compliance } else { 0.0 });
        let mut gamma = Mat::zeros(m, total);
        for ((part, own), &first) in parts.iter().zip(&weights).zip(&firsts) {
            let half = product(own.as_ref(), part.compliance.as_ref());
            s += product(half.as_ref(), own.transpose());
            gamma.subcols_mut(first, part.n_modes()).copy_from(product(own.as_ref(), part.rows.as_ref()));
        }
        let compliance = if m == 0 { None } else { Some(factor(&s, rows, &name)?) };
        let answers = compliance.as_ref().map_or(Mat::zeros(0, total), |factor| factor.solve(&gamma));

        // Σ over parts of Lᵀ G R M R Gᵀ L, each weighted.
        let rubin = parts.iter().all(|part| part.inertia.is_some() || part.rows.nrows() == 0);
        let of_parts = |of: OfPart<'_>| {
            let mut sum = Mat::zeros(total, total);
            for (part, own) in parts.iter().zip(&weights) {
                if let Some(matrix) = of(part) {
                    let along = product(own.transpose(), answers.as_ref());
                    sum += product(along.transpose(), product(matrix.as_ref(), along.as_ref()).as_ref());
                }
            }
            sum
        };
        let of_inertia = |part: &Part<'_>| part.inertia.clone().filter(|_| rubin);
        let mut mass = of_parts(&of_inertia);
        (0..total).for_each(|k| mass[(k, k)] += 1.0);
        let mut stiffness = product(gamma.transpose(), answers.as_ref());
        let own = parts.iter().flat_map(|part| part.eigenvalues.iter().copied()).enumerate();
        own.for_each(|(k, value)| stiffness[(k, k)] += value);

        let lower = mass.llt(Side::Lower).map_err(|_| AssemblyError::NoConvergence)?;
        let lower = lower.L().to_owned();
        let half = solve_lower(&lower, &stiffness);
        let both = solve_lower(&lower, &half.transpose().to_owned());
        let both = Mat::from_fn(total, total, |i, j| 0.5 * (both[(i, j)] + both[(j, i)]));
        let (eigenvalues, vectors) =
            symmetric_eigen(both.as_ref()).map_err(|_| AssemblyError::NoConvergence)?;
        let shapes = solve_upper(&lower, &vectors);
        held(parts, &firsts, &shapes, &eigenvalues)?;

        let damping = damped(parts, rows, (&shapes, &eigenvalues), &of_parts)?;
        Ok(Self { weights, firsts, compliance, answers, shapes, eigenvalues, damping, rubin })
    }

    /// Rows over the joined modes: those of a part over its coordinates, less what the forces of the joints
    /// give; `ports` are the same rows of `R Gᵀ` over the rows of its ports.
    pub fn rows(&self, part: usize, modal: &Mat<f64>, ports: &Mat<f64>) -> Mat<f64> {
        let first = self.firsts[part];
        let own = product(modal.as_ref(), self.shapes.subrows(first, modal.ncols()));
        let ports = product(ports.as_ref(), self.weights[part].transpose());
        let forces = product(self.answers.as_ref(), self.shapes.as_ref());
        own - product(ports.as_ref(), forces.as_ref())
    }

    /// `S⁻¹ G R`: forces of the joints under loads whose displacement at the ports is `columns`, with the
    /// other sign; shape (rows, loads).
    pub fn forces(&self, columns: &Mat<f64>) -> Mat<f64> {
        self.compliance.as_ref().map_or(Mat::zeros(0, columns.ncols()), |factor| factor.solve(columns))
    }
}

/// Cholesky's factor of the compliance at the joints.
fn factor(
    s: &Mat<f64>,
    rows: &[JointRow],
    name: impl Fn(usize) -> String,
) -> Result<Llt<f64>, AssemblyError> {
    let redundant = |row: usize| AssemblyError::Redundant { joint: name(rows[row].joint) };
    let found = s.llt(Side::Lower).ok();
    if let Some(factor) = found {
        let lower = factor.L();
        let small = (0..rows.len()).find(|&k| lower[(k, k)].powi(2) <= DEPENDENT * s[(k, k)]);
        return small.map_or(Ok(factor), |row| Err(redundant(row)));
    }
    // The first row whose leading block has no factor.
    let last = (1..=rows.len()).find(|&n| s.submatrix(0, 0, n, n).to_owned().llt(Side::Lower).is_err());
    Err(redundant(last.unwrap_or(rows.len()) - 1))
}

/// `L⁻¹ X`.
fn solve_lower(lower: &Mat<f64>, x: &Mat<f64>) -> Mat<f64> {
    let mut found = x.clone();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(
        lower.as_ref(),
        found.as_mut(),
        faer::Par::Seq,
    );
    found
}

/// `L⁻ᵀ X`.
fn solve_upper(lower: &Mat<f64>, x: &Mat<f64>) -> Mat<f64> {
    let mut found = x.clone();
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(
        lower.transpose(),
        found.as_mut(),
        faer::Par::Seq,
    );
    found
}

/// Refuses motions without stiffness.
fn held(
    parts: &[Part<'_>],
    firsts: &[usize],
    shapes: &Mat<f64>,
    eigenvalues: &[f64],
) -> Result<(), AssemblyError> {
    let largest = eigenvalues.last().copied().unwrap_or(0.0);
    let free = eigenvalues.iter().filter(|value| **value <= RIGID * largest).count();
    if free == 0 {
        return Ok(());
    }
    let moves = |&(part, first): &(&Part<'_>, &usize)| {
        let own = shapes.submatrix(*first, 0, part.n_modes(), free);
        own.norm_max() > 1e-3
    };
    let names = parts.iter().zip(firsts).filter(moves).map(|(part, _)| format!("`{}`", part.name));
    Err(AssemblyError::Free { motions: free, parts: names.collect::<Vec<_>>().join(", ") })
}

/// Damping of the joined modes.
fn damped(
    parts: &[Part<'_>],
    rows: &[JointRow],
    (shapes, eigenvalues): (&Mat<f64>, &[f64]),
    of_parts: &dyn Fn(OfPart<'_>) -> Mat<f64>,
) -> Result<Damped, AssemblyError> {
    let rayleigh = |part: &Part<'_>| {
        let metadata = part.file.metadata();
        (metadata.alpha, metadata.beta)
    };
    let alike = |part: &Part<'_>| Some((rayleigh(part), part.ratio()?));
    let rigid = rows.iter().all(|row| row.compliance == 0.0);
    if let Some(((alpha, beta), ratio)) = alike(&parts[0])
        && parts.iter().all(|part| alike(part) == alike(&parts[0]))
        && (rigid || beta == 0.0)
    {
        return Ok(Damped::Alike { alpha, beta, ratio });
    }
    // Damping of what the parts leave out, as their Rayleigh damping has it.
    let mut damping = of_parts(&|part| {
        let (alpha, beta) = rayleigh(part);
        let mut sum = &part.compliance * faer::Scale(beta);
        if let Some(inertia) = &part.inertia {
            sum += inertia * faer::Scale(alpha);
        }
        Some(sum)
    });
    let mut first = 0;
    for part in parts {
        let r = part.n_modes();
        let of_dashpots = product(part.dashpots.transpose(), part.dashpots.as_ref());
        let mut own = damping.submatrix_mut(first, first, r, r);
        own += of_dashpots;
        (0..r).for_each(|k| own[(k, k)] += part.damping[k]);
        first += r;
    }
    let damping = product(shapes.transpose(), product(damping.as_ref(), shapes.as_ref()).as_ref());
    let change = coupling_error(eigenvalues, damping.as_ref());
    if change <= COUPLED {
        let ratio = |(k, value): (usize, &f64)| damping[(k, k)].max(0.0) / (2.0 * value.sqrt());
        return Ok(Damped::Ratios(eigenvalues.iter().enumerate().map(ratio).collect(), change));
    }
    let rows = damping_rows(damping.as_ref()).map_err(|_| AssemblyError::NoConvergence)?;
    Ok(Damped::Rows(rows, change))
}
