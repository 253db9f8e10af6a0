//! The numbers of a body that can change, in bytes and back.

use crate::acting::Acting;
use crate::body::{Body, LastStep, MAX_STEPS};
use crate::bytes::{Cursor, Pen, copy};
use crate::flight::{self, Flight};
use crate::parameters::{WHOLE, ask, parameter, set_whole, whole};
use crate::refusal::Refusal;

/// Numbers of the body itself: scales, surface nodes in use, length of the last internal step, count of those
/// of the last communication step, and its two flags.
const OWN: usize = WHOLE + 5;

impl Body {
    /// Bytes that [`Body::save_into`] writes.
    #[must_use]
    pub const fn saved_len(&self) -> usize {
        let flight = if self.flight.is_some() { flight::NUMBERS } else { 0 };
        8 * (self.asked.len() + OWN + flight + 2 * self.inputs.len() + self.saved.len())
    }

    /// Writes everything that can change: parameters, scales and damping of the whole body, the last
    /// step, flight, inputs, inputs of the last step, state.
    ///
    /// # Errors
    /// [`Refusal::Saved`]: no room.
    pub fn save_into(&mut self, pen: &mut Pen<'_>) -> Result<(), Refusal> {
        for index in 0..self.counts.parameters {
            let value = self.parameter(index).unwrap_or_default();
            self.asked.iter_mut().skip(index as usize).take(1).for_each(|place| *place = value);
        }
        let LastStep { steps, is_first, is_stale } = self.last;
        let flag = |is_set| f64::from(u8::from(is_set));
        let surface = f64::from(self.surface);
        let last = [surface, self.body.time_step(), steps as f64, flag(is_first), flag(is_stale)];
        let mut own = [0.0; OWN];
        own.iter_mut().skip(WHOLE).zip(last).for_each(|(place, number)| *place = number);
        for (index, place) in (0..WHOLE as u32).zip(&mut own) {
            *place = whole(self.body.scene().options(), &self.file, index).unwrap_or_default();
        }
        self.save_state()?;
        let flight = self.flight.zip(self.body.flight()).map(|(flight, free)| flight.numbers(free.motion()));
        let flight = flight.as_ref().map_or(&[][..], |numbers| &numbers[..]);
        let parts = [&*self.asked, &own, flight, self.inputs, self.shown, self.saved];
        for part in parts {
            pen.numbers(part).ok_or(Refusal::Saved("there is no room for it"))?;
        }
        Ok(())
    }

    /// Takes back what [`Body::save_into`] has written.
    ///
    /// # Errors
    /// [`Refusal`]; the body is then as it was.
    pub fn restore(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        const SHORT: Refusal = Refusal::Saved("it is too short");
        cursor.numbers(self.asked).ok_or(SHORT)?;
        let mut own = [0.0; OWN];
        cursor.numbers(&mut own).ok_or(SHORT)?;
        let mut flight = None;
        if self.flight.is_some() {
            let mut numbers = [0.0; flight::NUMBERS];
            cursor.numbers(&mut numbers).ok_or(SHORT)?;
            flight = Some(Flight::restored(&numbers).ok_or(Refusal::Saved("its flight is none"))?);
        }
        let inputs = cursor.take(8 * self.inputs.len()).ok_or(SHORT)?;
        let shown = cursor.take(8 * self.shown.len()).ok_or(SHORT)?;
        let state = cursor.take(8 * self.saved.len()).ok_or(SHORT)?;
        let numbers = |bytes| <[u8]>::as_chunks(bytes).0.iter().map(|&number| f64::from_le_bytes(number));
        let all = own.into_iter().chain(numbers(inputs)).chain(numbers(shown)).chain(numbers(state));
        if !{ all }.all(f64::is_finite) {
            return Err(Refusal::Saved("it has a number that is not finite"));
        }
        let [scales @ .., surface, time_step, steps, is_first, is_stale] = own;
        let is_flag = |number: f64| number == 0.0 || number == 1.0;
        let is_count = (0.0..=MAX_STEPS as f64).contains(&steps) && steps as u64 as f64 == steps;
        if !(is_count && is_flag(is_first) && is_flag(is_stale)) {
            return Err(Refusal::Saved("its last step is none"));
        }
        let most = f64::from(self.counts.surface);
        let is_used = (0.0..=most).contains(&surface) && (surface > 0.0) == (most > 0.0);
        if !is_used || f64::from(surface as u32) != surface {
            return Err(Refusal::Saved("its number of surface nodes is none"));
        }
        let last = LastStep { steps: steps as u64, is_first: is_first != 0.0, is_stale: is_stale != 0.0 };
        let before = (*self.body.scene().options(), self.body.flight().copied());
        let mut options = before.0;
        for (index, asked) in (0..).zip(&mut *self.asked) {
            let value = *asked;
            match parameter(&options, &self.file, index) {
                Some(_) if self.live.is_some() => ask(asked, &self.file, index, value)?,
                Some(_) => options.set(self.file.metadata(), &[(index as usize, value)])?,
                // The step, which an FMU does not offer.
                None => *asked = self.file.parameters().nth(index as usize).map_or(value, |own| own.nominal),
            }
        }
        if self.takes_any_step() {
            let scales: [f64; WHOLE] = scales;
            for (index, value) in (0..).zip(scales) {
                if whole(&options, &self.file, index).is_some() {
                    set_whole(&mut options, &self.file, index, value)?;
                }
            }
            if !(time_step > 0.0 && time_step <= self.internal_step) {
                return Err(Refusal::Saved("its last step has no length"));
            }
            options.time_step = Some(time_step);
        }
        self.save_state()?;
        copy(self.saved, self.kept);
        if options != before.0 {
            let _ = self.body.rebind(&options)?;
        }
        let is_changed = match self.set_live() {
            Ok(is_changed) => is_changed,
            Err(error) => {
                let _ = self.body.rebind(&before.0)?;
                return Err(error.into());
            }
        };
        // Forces so large that they cannot be applied are found here, before anything else is changed.
        self.stale = true;
        let own = self.saved.iter_mut();
        own.zip(numbers(state)).for_each(|(place, number)| *place = number);
        let Self { body, points, counts, saved, .. } = self;
        let motion = flight.map(|(_, motion)| motion);
        let flight = flight.map(|(flight, _)| flight);
        let acting = Acting { points, patterns: counts.patterns, flight: flight.as_ref() };
        if let Err(refusal) = body.with(|parts| acting.restore(parts, numbers(shown), saved)) {
            let _ = self.body.rebind(&before.0)?;
            if is_changed {
                // A change of live regions keeps no more of the motion than the stepped modes hold.
                copy(self.before, self.asked);
                self.set_live()?;
                copy(self.kept, self.saved);
                self.put_back()?;
            }
            self.body.with(|parts| *parts.flight = before.1);
            return Err(refusal);
        }
        // Every bit comes back: what was kept is not made of length one again.
        self.body.with(|parts| {
            if let (Some(free), Some(motion)) = (parts.flight, motion) {
                free.set_motion(motion);
            }
        });
        self.flight = flight;
        (self.last, self.surface) = (last, surface as u32);
        self.inputs.iter_mut().zip(numbers(inputs)).for_each(|(place, number)| *place = number);
        self.shown.iter_mut().zip(numbers(shown)).for_each(|(place, number)| *place = number);
        Ok(())
    }
}
