//! Time courses of loads.

use std::sync::Arc;

use vademecum_build::dynamics::{Course, History, Interval, LoadTable, Wave};
use vademecum_format::{BASE_PATTERNS, BaseMotion};

use super::entries::{BaseEntry, ChirpEntry, ContactEntry, PatternUse, SinusoidEntry, forever};
use super::tables::{LARGEST, Rows};

impl ContactEntry {
    /// A force at a point from time zero to `end` \[s\].
    pub fn push(point: [f64; 3], force: [f64; 3], end: f64) -> Self {
        Self { point: Some(point), force: Some(force), end, ..Self::default() }
    }

    /// Its forces of fixed direction, each with its history: one, or one for each component of a table.
    pub(crate) fn forces(&self, duration: f64) -> Vec<([f64; 3], History)> {
        let history = |course| History { during: self.varying().during(), share: None, course };
        match &self.rows {
            Some(table) if table.columns() == 3 => {
                let axis = |c: usize| std::array::from_fn(|i| if i == c { 1.0 } else { 0.0 });
                let acts = (0..3).filter(|&c| table.largest(c) > 0.0);
                acts.map(|c| (axis(c), history(Course::Table(Arc::clone(table), c)))).collect()
            }
            _ => vec![(self.force.unwrap_or_default(), self.varying().history(duration))],
        }
    }

    /// The places of its path, each with its instant; none if it stays where it is.
    pub(crate) fn path_rows(&self) -> Option<Vec<(f64, [f64; 3])>> {
        let places = self.places.as_ref()?;
        let [x, y, z] = [0, 1, 2].map(|c| places.rows(c));
        Some(x.zip(y).zip(z).map(|(([t, x], [_, y]), [_, z])| (self.start + t, [x, y, z])).collect())
    }

    pub(super) fn varying(&self) -> TimeCourse<'_> {
        let Self { start, end, ramp, sinusoid, chirp, ref table, ref rows, .. } = *self;
        let when = Interval { start, end, ramp };
        TimeCourse { when, table: table.is_some(), rows: rows.as_ref(), sinusoid, chirp }
    }
}

impl BaseEntry {
    /// The patterns of the base that act, as tables: formed at the rows, and linear between them. The size of
    /// a number that is too large otherwise.
    pub(super) fn motions(&self, table: &LoadTable) -> Result<Vec<PatternUse>, f64> {
        let columns: Vec<Vec<[f64; 2]>> = (0..table.columns()).map(|c| table.rows(c).collect()).collect();
        let times: Vec<f64> = columns[0].iter().map(|[time, _]| *time).collect();
        let three = |row: usize, first: usize| -> [f64; 3] {
            std::array::from_fn(|c| columns.get(first + c).map_or(0.0, |column| column[row][1]))
        };
        let amplitudes: Vec<[f64; 12]> = (0..times.len())
            .map(|row| {
                let motion = BaseMotion {
                    acceleration: three(row, 0).map(|a| self.amplitude * a),
                    angular_velocity: three(row, 3),
                    angular_acceleration: three(row, 6),
                };
                motion.amplitudes()
            })
            .collect();
        let mut found = vec![];
        for (motion, name) in BASE_PATTERNS.iter().enumerate() {
            let values: Vec<f64> = amplitudes.iter().map(|row| row[motion]).collect();
            let largest = values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            match largest {
                0.0 => continue,
                x if x <= LARGEST => {}
                x => return Err(x),
            }
            let rows = times.iter().zip(&values).map(|(&t, &x)| vec![t, x]).collect();
            found.push(PatternUse {
                name: (*name).into(),
                amplitude: 1.0,
                start: 0.0,
                end: forever(),
                ramp: 0.0,
                table: Some(Rows::Here(rows)),
                sinusoid: None,
                chirp: None,
                rows: LoadTable::new(times.clone(), values).map(Arc::new),
            });
        }
        Ok(found)
    }
}

impl PatternUse {
    /// Its time course.
    pub(crate) fn history(&self, duration: f64) -> History {
        self.varying().history(duration)
    }

    pub(super) fn varying(&self) -> TimeCourse<'_> {
        let Self { start, end, ramp, sinusoid, chirp, ref table, ref rows, .. } = *self;
        let when = Interval { start, end, ramp };
        TimeCourse { when, table: table.is_some(), rows: rows.as_ref(), sinusoid, chirp }
    }
}

/// Time course of a contact or a pattern.
pub(super) struct TimeCourse<'a> {
    pub(super) when: Interval,
    pub(super) table: bool,
    rows: Option<&'a Arc<LoadTable>>,
    pub(super) sinusoid: Option<SinusoidEntry>,
    pub(super) chirp: Option<ChirpEntry>,
}

impl TimeCourse<'_> {
    fn during(&self) -> Interval {
        self.when
    }

    fn history(&self, duration: f64) -> History {
        let Interval { start, end, .. } = self.when;
        let course = if let Some(table) = self.rows {
            Course::Table(Arc::clone(table), 0)
        } else if let Some(SinusoidEntry { frequency, phase, mean }) = self.sinusoid {
            Course::Wave(Wave::sinusoid(frequency, phase, mean))
        } else if let Some(ChirpEntry { from, to, phase }) = self.chirp {
            // Without an end of its own it sweeps up to the end of the scenario.
            let end = if end < forever() { end } else { duration };
            let sweep = if end > start { end - start } else { 1.0 };
            Course::Wave(Wave { frequency: [from, to], sweep, phase, mean: 0.0 })
        } else {
            Course::Held
        };
        History { during: self.when, share: None, course }
    }

    pub(super) fn highest_frequency(&self) -> f64 {
        let sweep = self.chirp.map_or(0.0, |chirp| chirp.from.max(chirp.to));
        self.sinusoid.map_or(sweep, |sinusoid| sinusoid.frequency)
    }
}
