//! The factor of the stiffness: a lower triangle whose groups, rows and numbers fit one another, and which
//! gives the modes the energies that the file says they have.

use vademecum_format::{Element, File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};

/// Tolerance between `‖Lᵀb‖²` and the eigenvalue of a mode `b`: both are rounded to binary32 at worst, and
/// rounding of a row of `B` weighs as much as the stiffest element makes it.
const ENERGY: f64 = 1e-2;

/// Sections 42 to 46, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    let all = [S::FactorOrder, S::FactorGroups, S::FactorRows, S::FactorValues];
    let Some(there) = all.into_iter().find(|&kind| file.section(kind).is_some()) else {
        let alone = file.section(S::PatternAnswer).map(|_| S::PatternAnswer);
        return alone.map_or(Ok(()), |kind| missing(kind, S::FactorOrder));
    };
    if let Some(kind) = all.into_iter().find(|&kind| file.section(kind).is_none()) {
        return missing(there, kind);
    }
    if file.section(S::ContactResidual).is_none() || !file.metadata().diagonal {
        let reason =
            "the factor goes with the residual flexibility of the diagonal structure, which is missing";
        return Err(unsound(S::FactorValues, Fault::Disagrees, reason.into()));
    }
    let order = integers(file, S::FactorOrder)?;
    places(&order)?;
    let groups = integers(file, S::FactorGroups)?;
    let rows = integers(file, S::FactorRows)?;
    let values = reals_of(file, S::FactorValues)?.unwrap_or_default();
    let columns = columns(&groups, &rows, &values, order.len())?;
    if let Some(section) = file.section(S::PatternAnswer)
        && section.shape()[1] != order.len() as u64
    {
        let reason = format!("{} numbers a pattern, and {} columns", section.shape()[1], order.len());
        return Err(unsound(S::PatternAnswer, Fault::Disagrees, reason));
    }
    energies(file, &order, &columns)
}

fn missing(there: SectionKind, kind: SectionKind) -> Result<(), RewriteError> {
    let reason = format!("section {kind}, which it goes with, is missing");
    Err(unsound(there, Fault::Disagrees, reason))
}

fn integers(file: &File<'_>, kind: SectionKind) -> Result<Vec<u32>, RewriteError> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    Ok(section.u32s()?.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect())
}

/// Each displacement stands for one column at most.
fn places(order: &[u32]) -> Result<(), RewriteError> {
    let mut seen = order.to_vec();
    seen.sort_unstable();
    match seen.windows(2).find(|pair| pair[0] == pair[1]) {
        None => Ok(()),
        Some(pair) => {
            let reason = format!("displacement {} stands for two columns", pair[0]);
            Err(unsound(SectionKind::FactorOrder, Fault::Twice, reason))
        }
    }
}

/// A column of `L`: its rows and numbers, the diagonal first.
struct Column<'a> {
    first: usize,
    /// Rows of the same group below the diagonal.
    beside: &'a [f64],
    diagonal: f64,
    rows: &'a [u32],
    below: &'a [f64],
}

fn columns<'a>(
    groups: &[u32],
    rows: &'a [u32],
    values: &'a [f64],
    n: usize,
) -> Result<Vec<Column<'a>>, RewriteError> {
    let kind = SectionKind::FactorGroups;
    let short = |what: &str| {
        unsound(kind, Fault::Disagrees, format!("its groups ask for more {what} than there are"))
    };
    let (mut rest_rows, mut rest_values) = (rows, values);
    let mut columns = vec![];
    for (place, group) in groups.as_chunks::<2>().0.iter().enumerate() {
        let [width, below] = group.map(|n| n as usize);
        let first = columns.len();
        if width == 0 || width > n - first {
            let reason = format!("group {place} has {width} columns; {} of {n} are left", n - first);
            return Err(unsound(kind, Fault::Disagrees, reason));
        }
        let (own, others) = rest_rows.split_at_checked(below).ok_or_else(|| short("rows"))?;
        rest_rows = others;
        let ascending = own.windows(2).all(|pair| pair[0] < pair[1]);
        let ends = own.first().zip(own.last());
        if !ascending || ends.is_some_and(|(&a, &b)| (a as usize) < first + width || b as usize >= n) {
            let reason =
                format!("the rows of group {place} do not ascend from column {} on to {n}", first + width);
            return Err(unsound(SectionKind::FactorRows, Fault::Disagrees, reason));
        }
        for j in 0..width {
            let column = rest_values.split_at_checked(width + below).ok_or_else(|| short("numbers"))?;
            rest_values = column.1;
            let (inside, below) = column.0.split_at(width);
            let (above, under) = inside.split_at(j);
            if under[0] <= 0.0 || above.iter().any(|&x| x != 0.0) {
                let reason = format!(
                    "column {} has {:e} on its diagonal, or numbers above it; it is a lower triangle with a \
                     positive diagonal",
                    first + j,
                    under[0]
                );
                return Err(unsound(SectionKind::FactorValues, Fault::Disagrees, reason));
            }
            columns.push(Column {
                first: first + j,
                diagonal: under[0],
                beside: &under[1..],
                rows: own,
                below,
            });
        }
    }
    if columns.len() == n && rest_rows.is_empty() && rest_values.is_empty() {
        return Ok(columns);
    }
    let reason = format!(
        "its groups have {} of {n} columns, and leave {} rows and {} numbers over",
        columns.len(),
        rest_rows.len(),
        rest_values.len()
    );
    Err(unsound(kind, Fault::Disagrees, reason))
}

/// `‖Lᵀb‖² = λ` of the first and the last mode, where the basis was not rounded within a tolerance.
fn energies(file: &File<'_>, order: &[u32], columns: &[Column<'_>]) -> Result<(), RewriteError> {
    let kinds = [SectionKind::SurfaceBasis, SectionKind::InteriorBasis];
    let losses = reals_of(file, SectionKind::Losses)?.unwrap_or_default();
    let lost = |kind: SectionKind| losses.chunks_exact(4).any(|row| row[0] == f64::from(kind.number()));
    let quantised =
        |kind| file.section(kind).is_none_or(|section| section.element() == Element::I16) || lost(kind);
    let r = file.metadata().n_modes as usize;
    let interior = file.metadata().n_nodes > file.metadata().n_surface_nodes;
    if r == 0 || quantised(kinds[0]) || (interior && quantised(kinds[1])) {
        return Ok(());
    }
    let mut rows = reals_of(file, kinds[0])?.unwrap_or_default();
    if interior {
        rows.extend(reals_of(file, kinds[1])?.unwrap_or_default());
    }
    let Some(eigenvalues) = reals_of(file, SectionKind::Eigenvalues)? else { return Ok(()) };
    for mode in [0, r - 1] {
        let b: Vec<f64> = order.iter().map(|&place| rows[place as usize * r + mode]).collect();
        let along = |column: &Column<'_>| {
            let beside = column.beside.iter().zip(&b[column.first + 1..]).map(|(l, b)| l * b).sum::<f64>();
            let below =
                column.rows.iter().zip(column.below).map(|(&row, l)| l * b[row as usize]).sum::<f64>();
            (column.diagonal * b[column.first] + beside + below).powi(2)
        };
        let energy: f64 = columns.iter().map(along).sum();
        let lambda = eigenvalues[mode];
        if (energy - lambda).abs() > ENERGY * lambda.abs() {
            let reason =
                format!("it gives mode {mode} the stiffness {energy:e}, section Eigenvalues {lambda:e}");
            return Err(unsound(SectionKind::FactorValues, Fault::Disagrees, reason));
        }
    }
    Ok(())
}
