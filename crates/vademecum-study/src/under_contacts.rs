//! The displacement under the contacts of a scenario, wherever they are at an instant.

use vademecum_build::dynamics::{Course, History, Interval};
use vademecum_eval::{Field, SurfacePoint};

use crate::error::FileError;
use crate::player::{PlacedContact, Playable, Track};

/// All contacts of a scenario: for each its places, with the share of each over time.
pub(crate) struct UnderContacts {
    contacts: Vec<Vec<(SurfacePoint, History)>>,
}

impl UnderContacts {
    pub(crate) fn of(track: &Track) -> Self {
        let during = Interval { start: f64::NEG_INFINITY, end: f64::INFINITY, ramp: 0.0 };
        let of_entry = |entry: &[PlacedContact]| {
            let share =
                |placed: &PlacedContact| History { share: placed.when.share, course: Course::Held, during };
            let mut places: Vec<_> = entry.iter().map(|placed| (placed.point, share(placed))).collect();
            // A force by its components acts at one place three times.
            places.dedup_by(|a, b| a.0.place == b.0.place && a.1 == b.1);
            places
        };
        Self { contacts: track.contacts.chunk_by(|a, b| a.entry == b.entry).map(of_entry).collect() }
    }

    /// Number of contacts.
    pub(crate) fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Displacement under each contact at the time of the body \[m\].
    pub(crate) fn read(
        &self,
        body: &dyn Playable<Number = f64>,
        time: f64,
        out: &mut [[f64; 3]],
    ) -> Result<(), FileError> {
        for (places, out) in self.contacts.iter().zip(out) {
            *out = [0.0; 3];
            for (point, share) in places {
                let share = share.factor(time);
                if share != 0.0 {
                    let moved = body.point(point, Field::Displacement)?;
                    out.iter_mut().zip(moved).for_each(|(out, u)| *out += share * u);
                }
            }
        }
        Ok(())
    }
}
