//! The factor `L` of the stiffness, `K = L Lᵀ`, where a file has it, and solves with it.
//!
//! Columns with the same rows below them stand in a group, as a multifrontal factorisation leaves them (Liu
//! 1992). Every length is checked where it is used: a file that contradicts itself gives no answer.

use vademecum_format::{File, Numbers, SectionKind};

/// The sections of the factor; empty where they are absent or compressed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Factor<'m> {
    /// The displacement, `3 node + component`, that each column stands for.
    pub order: &'m [[u8; 4]],
    groups: &'m [[[u8; 4]; 2]],
    rows: &'m [[u8; 4]],
    pub values: Option<Numbers<'m>>,
    /// `K⁻¹F_p` of each pattern, in the order of the columns.
    pub patterns: Option<Numbers<'m>>,
}

/// Start of a group of columns: its first column, and its first number among rows and values.
#[derive(Clone, Copy, Default)]
struct Place {
    column: usize,
    row: usize,
    value: usize,
}

/// Columns of the factor with the same rows below them.
struct Group<'m, const N: usize> {
    width: usize,
    /// The rows below, counted from the first row after the group.
    rows: &'m [[u8; 4]],
    /// Column by column, `width` numbers and one for each row below.
    values: &'m [[u8; N]],
}

impl<'m> Factor<'m> {
    /// Looks the sections up.
    pub fn of(file: &File<'m>) -> Self {
        let integers = |kind| file.section(kind).and_then(|section| section.u32s().ok()).unwrap_or_default();
        let numbers = |kind| file.section(kind).and_then(|section| section.numbers().ok());
        Self {
            order: integers(SectionKind::FactorOrder),
            groups: integers(SectionKind::FactorGroups).as_chunks().0,
            rows: integers(SectionKind::FactorRows),
            values: numbers(SectionKind::FactorValues),
            patterns: numbers(SectionKind::PatternAnswer),
        }
    }

    /// Overwrites `x`, in the order of the factor, by `K⁻¹x`; `None` for a factor that contradicts itself.
    pub fn solve(&self, x: &mut [f64]) -> Option<()> {
        match self.values? {
            Numbers::F32(values) => self.solve_with(values, x, |v| f64::from(f32::from_le_bytes(v))),
            Numbers::F64(values) => self.solve_with(values, x, f64::from_le_bytes),
            Numbers::I16(_) => None,
        }
    }

    fn solve_with<const N: usize>(
        &self,
        values: &'m [[u8; N]],
        x: &mut [f64],
        read: impl Fn([u8; N]) -> f64 + Copy,
    ) -> Option<()> {
        let mut place = Place::default();
        for &group in self.groups {
            let (group, next) = self.group(group, values, place)?;
            let (own, after) = x.get_mut(place.column..)?.split_at_mut_checked(group.width)?;
            for j in 0..group.width {
                let (diagonal, beside, below) = group.column(j)?;
                let (first, rest) = own.get_mut(j..)?.split_first_mut()?;
                // Forces act on few nodes: most columns do not answer yet.
                if *first == 0.0 {
                    continue;
                }
                *first /= read(diagonal);
                rest.iter_mut().zip(beside).for_each(|(x, &l)| *x -= read(l) * *first);
                for (&row, &l) in group.rows.iter().zip(below) {
                    *after.get_mut(row_after(row, next.column)?)? -= read(l) * *first;
                }
            }
            place = next;
        }
        for &group in self.groups.iter().rev() {
            place = place.before(group)?;
            let (group, next) = self.group(group, values, place)?;
            let (own, after) = x.get_mut(place.column..)?.split_at_mut_checked(group.width)?;
            for j in (0..group.width).rev() {
                let (diagonal, beside, below) = group.column(j)?;
                let (first, rest) = own.get_mut(j..)?.split_first_mut()?;
                let mut sum = *first;
                rest.iter().zip(beside).for_each(|(x, &l)| sum -= read(l) * x);
                for (&row, &l) in group.rows.iter().zip(below) {
                    sum -= read(l) * after.get(row_after(row, next.column)?)?;
                }
                *first = sum / read(diagonal);
            }
        }
        Some(())
    }

    /// The group that begins at `place`, and where the next one does.
    fn group<const N: usize>(
        &self,
        group: [[u8; 4]; 2],
        values: &'m [[u8; N]],
        place: Place,
    ) -> Option<(Group<'m, N>, Place)> {
        let next = place.after(group)?;
        let [width, _] = sizes(group);
        let rows = self.rows.get(place.row..next.row)?;
        let values = values.get(place.value..next.value)?;
        Some((Group { width, rows, values }, next))
    }
}

/// The number on the diagonal, those below it in the group, and those in the rows below the group.
type Column<'m, const N: usize> = ([u8; N], &'m [[u8; N]], &'m [[u8; N]]);

impl<'m, const N: usize> Group<'m, N> {
    /// Column `j`.
    fn column(&self, j: usize) -> Option<Column<'m, N>> {
        let height = self.width + self.rows.len();
        let column = self.values.get(j * height..)?.get(j..height)?;
        let (&diagonal, under) = column.split_first()?;
        let (beside, below) = under.split_at_checked(self.width - 1 - j)?;
        Some((diagonal, beside, below))
    }
}

impl Place {
    fn after(self, group: [[u8; 4]; 2]) -> Option<Self> {
        self.moved(group, usize::checked_add)
    }

    fn before(self, group: [[u8; 4]; 2]) -> Option<Self> {
        self.moved(group, usize::checked_sub)
    }

    fn moved(self, group: [[u8; 4]; 2], by: fn(usize, usize) -> Option<usize>) -> Option<Self> {
        let [width, below] = sizes(group);
        let count = width.checked_add(below)?.checked_mul(width)?;
        let (column, row) = (by(self.column, width)?, by(self.row, below)?);
        Some(Self { column, row, value: by(self.value, count)? })
    }
}

fn sizes(group: [[u8; 4]; 2]) -> [usize; 2] {
    group.map(|n| u32::from_le_bytes(n) as usize)
}

/// A row of the factor, counted from `first` on.
fn row_after(row: [u8; 4], first: usize) -> Option<usize> {
    (u32::from_le_bytes(row) as usize).checked_sub(first)
}
