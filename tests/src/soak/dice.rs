//! What chance decides: every choice of an iteration comes from one seed.

use crate::synthetic::Random;

/// A generator of choices.
pub struct Dice(Random);

impl Dice {
    /// Of one iteration of a soak: two iterations share nothing.
    #[must_use]
    pub fn new(seed: u64, iteration: u64) -> Self {
        let mut random = Random::new(seed ^ iteration.wrapping_mul(0xD1B5_4A32_D192_ED03).rotate_left(17));
        // The first numbers of neighbouring seeds are alike.
        random.numbers(8);
        Self(random)
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * 0.5 * (self.0.number() + 1.0)
    }

    /// Uniform in the logarithm, in [low, high).
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// A whole number below `n`, which is positive.
    pub fn below(&mut self, n: usize) -> usize {
        (self.between(0.0, n as f64) as usize).min(n - 1)
    }

    /// A whole number from `low` to `high`, both included.
    pub fn whole(&mut self, low: usize, high: usize) -> usize {
        low + self.below(high - low + 1)
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// One of several.
    pub fn pick<'a, T>(&mut self, items: &'a [T]) -> &'a T {
        &items[self.below(items.len())]
    }

    /// A vector of three numbers in [−1, 1).
    pub fn vector(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.between(-1.0, 1.0))
    }
}
