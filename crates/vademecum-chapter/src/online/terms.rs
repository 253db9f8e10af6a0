//! Sums of products of one-dimensional functions.

use vademecum_format::{Chapter, ChapterAxis, ChapterPart, ChapterRole};

/// A part of a stage, with its axes read once.
#[derive(Debug)]
pub(super) struct Piece<'m> {
    pub part: ChapterPart<'m>,
    pub axes: Vec<ChapterAxis>,
}

/// A value that is not on its axis.
pub(super) struct Outside {
    pub axis: ChapterAxis,
    pub value: f64,
}

/// The parts in the order of the file.
pub(super) fn pieces<'m>(chapter: &Chapter<'m>) -> Vec<Piece<'m>> {
    chapter.parts().map(|part| Piece { part, axes: part.axes().collect() }).collect()
}

impl Piece<'_> {
    /// Adds `Σ_t (Π_a g_ta(x_a)) f_t` to `out`, length r. `value` gives the coordinate of an axis; `weights`
    /// is work.
    pub fn add(
        &self,
        value: impl Fn(ChapterRole) -> f64,
        weights: &mut Vec<f64>,
        out: &mut [f64],
    ) -> Result<(), Outside> {
        let n = self.part.n_terms;
        weights.clear();
        weights.resize(n, 1.0);
        let mut factors = self.part.factors;
        for axis in &self.axes {
            let (own, rest) = factors.split_at(axis.points * n);
            factors = rest;
            let (left, share) = place(axis, value(axis.role))?;
            let rows = &own[left * n..];
            // At the last position there is nothing to the right, and its share is 0.
            let right = rows.get(n..2 * n).unwrap_or(&rows[..n]);
            for ((weight, &left), &right) in weights.iter_mut().zip(rows).zip(right) {
                let [left, right] = [left, right].map(f64::from_le_bytes);
                *weight *= (1.0 - share) * left + share * right;
            }
        }
        for (&weight, term) in weights.iter().zip(self.part.terms.chunks_exact(out.len().max(1))) {
            out.iter_mut().zip(term).for_each(|(out, &f)| *out += weight * f64::from_le_bytes(f));
        }
        Ok(())
    }
}

/// The point at or before a value of the history, and how far it is to the next.
pub(super) fn place(axis: &ChapterAxis, value: f64) -> Result<(usize, f64), Outside> {
    let x = axis.factor * value;
    if !(axis.lower <= x && x <= axis.upper) {
        return Err(Outside { axis: *axis, value: x });
    }
    if axis.role == ChapterRole::Position {
        return Ok((x as usize, 0.0));
    }
    let t = (x - axis.lower) / (axis.upper - axis.lower) * (axis.points - 1) as f64;
    let left = (t as usize).min(axis.points - 2);
    Ok((left, t - left as f64))
}
