//! Strikes of a world: impulses at which a member begins to be touched, for the ear.

use alloc::vec::Vec;

use vademecum_eval::{Place, Touch, Touching};

use crate::vectors::{Vector, dot, plus, times};

/// Members that were apart for so long \[s\] strike each other anew.
const APART: f64 = 0.02;
/// A strike is over after so long \[s\] at the latest: what goes on is pressed.
const LASTS: f64 = 0.005;

/// An impulse on a member.
#[derive(Clone, Copy, Debug)]
pub struct Strike {
    /// Number of the member.
    pub member: usize,
    /// The place that was struck.
    pub place: Place,
    /// Impulse in space \[N s\].
    pub impulse: Vector,
}

/// A pair, and the strike that it is in.
#[derive(Clone, Copy, Debug)]
struct Pair {
    members: [usize; 2],
    /// Since when it is apart \[s\]; 0 of one that touches.
    apart: f64,
    /// Time that the strike lasts \[s\]; `None` between strikes.
    lasting: Option<f64>,
    impulse: Vector,
    /// The strongest place on each member, and its force.
    strongest: (f64, [Place; 2]),
}

/// The strikes of the pairs of a world.
#[derive(Debug, Default)]
pub struct Strikes {
    pairs: Vec<Pair>,
    /// Strikes since the page asked.
    pub heard: Vec<Strike>,
}

impl Strikes {
    /// Of these pairs, which are apart.
    #[must_use]
    pub fn new(pairs: &[Touching]) -> Self {
        let apart = |pair: &Touching| Pair {
            members: pair.members,
            apart: f64::INFINITY,
            lasting: None,
            impulse: [0.0; 3],
            strongest: (0.0, [Place::node(0); 2]),
        };
        Self { pairs: pairs.iter().map(apart).collect(), heard: Vec::new() }
    }

    /// Hears the contacts of a step of `time` \[s\].
    pub fn hear(&mut self, touches: &[Touch], time: f64) {
        for pair in &mut self.pairs {
            pair.apart += time;
        }
        for touch in touches.iter().filter(|touch| touch.pressure() > 0.0) {
            let [a, b] = touch.members();
            let found = self.pairs.iter_mut().find(|pair| pair.members == [a, b] || pair.members == [b, a]);
            let Some(pair) = found else { continue };
            if pair.apart > APART {
                (pair.lasting, pair.impulse, pair.strongest.0) = (Some(0.0), [0.0; 3], 0.0);
            }
            pair.apart = 0.0;
            // On the first member of the pair.
            let first = pair.members == [a, b];
            let force = touch.force();
            pair.impulse = plus(pair.impulse, times(if first { time } else { -time }, force));
            let size = dot(force, force);
            if size > pair.strongest.0 {
                let [at, on] = *touch.places();
                pair.strongest = (size, if first { [at, on] } else { [on, at] });
            }
        }
        for pair in &mut self.pairs {
            let Some(lasting) = &mut pair.lasting else { continue };
            *lasting += time;
            if pair.apart > 0.0 || *lasting >= LASTS {
                pair.lasting = None;
                for (side, sign) in [(0, 1.0), (1, -1.0)] {
                    let (member, place) = (pair.members[side], pair.strongest.1[side]);
                    self.heard.push(Strike { member, place, impulse: times(sign, pair.impulse) });
                }
            }
        }
    }
}
