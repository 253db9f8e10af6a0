//! Strikes of a world: impulses at which a member begins to be touched, for the ear.

use alloc::vec::Vec;

use vademecum_eval::{Place, Touch};

use crate::vectors::{Vector, dot, plus, times};

/// Members that were apart for so long \[s\] strike each other anew.
const APART: f64 = 0.02;
/// A strike is over after so long \[s\] at the latest: what goes on is pressed.
const LASTS: f64 = 0.005;
/// Most strikes that wait for the page.
const WAITING: usize = 1024;

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

/// A pair that touched of late, and the strike that it is in.
#[derive(Clone, Copy, Debug)]
struct Pair {
    /// Its members, the smaller number first.
    members: [usize; 2],
    /// Since when it is apart \[s\]; 0 of one that touches.
    apart: f64,
    /// Time that the strike lasts \[s\]; `None` after it.
    lasting: Option<f64>,
    /// On the first member.
    impulse: Vector,
    /// Square of the strongest force, and its places.
    strongest: (f64, [Place; 2]),
}

/// The strikes of a world.
#[derive(Debug, Default)]
pub struct Strikes {
    /// In the order of their members.
    pairs: Vec<Pair>,
    heard: Vec<Strike>,
}

impl Strikes {
    /// Hears the contacts of a step of `time` \[s\].
    pub fn hear(&mut self, touches: &[Touch], time: f64) {
        self.pairs.iter_mut().for_each(|pair| pair.apart += time);
        self.pairs.retain(|pair| pair.apart <= APART);
        for touch in touches.iter().filter(|touch| touch.pressure() > 0.0) {
            let [a, b] = touch.members();
            let first = a < b;
            let members = if first { [a, b] } else { [b, a] };
            let at = match self.pairs.binary_search_by_key(&members, |pair| pair.members) {
                Ok(at) => at,
                Err(at) => {
                    let strongest = (0.0, [Place::node(0); 2]);
                    let new = Pair { members, apart: 0.0, lasting: Some(0.0), impulse: [0.0; 3], strongest };
                    self.pairs.insert(at, new);
                    at
                }
            };
            let Some(pair) = self.pairs.get_mut(at) else { continue };
            pair.apart = 0.0;
            let force = touch.force();
            pair.impulse = plus(pair.impulse, times(if first { time } else { -time }, force));
            let size = dot(force, force);
            if size > pair.strongest.0 {
                let [node, surface] = *touch.places();
                pair.strongest = (size, if first { [node, surface] } else { [surface, node] });
            }
        }
        for pair in &mut self.pairs {
            let Some(lasting) = &mut pair.lasting else { continue };
            *lasting += time;
            if pair.apart > 0.0 || *lasting >= LASTS {
                pair.lasting = None;
                for (side, sign) in [(0, 1.0), (1, -1.0)] {
                    let (member, place) = (pair.members[side], pair.strongest.1[side]);
                    if self.heard.len() < WAITING {
                        self.heard.push(Strike { member, place, impulse: times(sign, pair.impulse) });
                    }
                }
            }
        }
    }

    /// Strikes that wait for the page.
    #[must_use]
    pub fn heard(&self) -> &[Strike] {
        &self.heard
    }

    /// Forgets the strikes that the page has taken.
    pub fn taken(&mut self) {
        self.heard.clear();
    }

    /// Forgets everything.
    pub fn forget(&mut self) {
        self.pairs.clear();
        self.heard.clear();
    }
}
