//! What ranks tell each other: numbers, lists of numbers, and the words by which the first rank leads.

use vademecum_build::fem::{EngineError, Search};

use crate::calls::Calls;

/// What the first rank has the others do. Numbers name a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Word {
    /// Factorise the rows that follow.
    Factorise(u64),
    /// Solve for so many columns, which follow, and send the answers.
    Solve(u64, usize),
    /// Search for modes with the mass that follows; `true`: of a body without supports.
    Search(u64, Search, bool),
    /// Free a factor.
    Release(u64),
    /// Go home.
    Stop,
}

/// A word on its way: its kind and up to six numbers.
type Sent = [u64; 7];

impl Word {
    fn sent(self) -> Sent {
        match self {
            Self::Factorise(id) => [0, id, 0, 0, 0, 0, 0],
            Self::Solve(id, columns) => [1, id, columns as u64, 0, 0, 0, 0],
            Self::Search(id, search, free) => {
                let Search { count, available, tolerance, probes } = search;
                let [count, available, probes] = [count, available, probes].map(|number| number as u64);
                [2, id, count, available, tolerance.to_bits(), probes, free.into()]
            }
            Self::Release(id) => [3, id, 0, 0, 0, 0, 0],
            Self::Stop => [4, 0, 0, 0, 0, 0, 0],
        }
    }

    fn received([kind, id, a, b, tolerance, probes, free]: Sent) -> Option<Self> {
        let [count, available] = [a, b].map(|number| number as usize);
        let tolerance = f64::from_bits(tolerance);
        Some(match kind {
            0 => Self::Factorise(id),
            1 => Self::Solve(id, count),
            2 => {
                let search = Search { count, available, tolerance, probes: probes as usize };
                Self::Search(id, search, free != 0)
            }
            3 => Self::Release(id),
            4 => Self::Stop,
            _ => return None,
        })
    }
}

/// A number as it is sent.
pub trait Number: Copy {
    /// Its bytes.
    fn bytes(self) -> [u8; 8];
    /// The number of these bytes.
    fn of(bytes: [u8; 8]) -> Self;
}

impl Number for u64 {
    fn bytes(self) -> [u8; 8] {
        self.to_ne_bytes()
    }
    fn of(bytes: [u8; 8]) -> Self {
        Self::from_ne_bytes(bytes)
    }
}

impl Number for i64 {
    fn bytes(self) -> [u8; 8] {
        self.to_ne_bytes()
    }
    fn of(bytes: [u8; 8]) -> Self {
        Self::from_ne_bytes(bytes)
    }
}

impl Number for f64 {
    fn bytes(self) -> [u8; 8] {
        self.to_ne_bytes()
    }
    fn of(bytes: [u8; 8]) -> Self {
        Self::from_ne_bytes(bytes)
    }
}

/// Numbers converted at once: what is on its way takes no second copy of a long list.
const PIECE: usize = 1 << 16;

/// The ranks of one job, seen from one of them.
pub struct Ranks {
    /// The libraries.
    pub calls: Calls,
}

impl Ranks {
    /// Whether this is the rank that leads.
    pub fn is_first(&self) -> bool {
        self.calls.rank == 0
    }

    /// All ranks but the first.
    pub fn others(&self) -> std::ops::Range<usize> {
        1..self.calls.size
    }

    /// The rows of a rank, of so many: equal shares, of whole nodes where every node has three rows.
    pub fn rows_of(&self, rank: usize, total: usize) -> std::ops::Range<usize> {
        let first = |rank: usize| match (total as u128 * rank as u128 / self.calls.size as u128) as usize {
            first if first == total => total,
            first => first / 3 * 3,
        };
        first(rank)..first(rank + 1)
    }

    /// Has all other ranks do something.
    pub fn say(&self, word: Word) -> Result<(), EngineError> {
        self.others().try_for_each(|rank| self.send(&word.sent(), rank))
    }

    /// Waits for a word.
    pub fn hear(&self) -> Result<Word, EngineError> {
        self.calls.idle()?;
        let mut sent = [[0; 8]; 7];
        self.calls.receive(sent.as_flattened_mut(), 0)?;
        let unknown = || EngineError { call: "MPI_Recv".into(), reason: "a word that no rank knows".into() };
        Word::received(sent.map(u64::from_ne_bytes)).ok_or_else(unknown)
    }

    /// Sends as many numbers as the other rank knows of.
    pub fn send<T: Number>(&self, numbers: &[T], to: usize) -> Result<(), EngineError> {
        numbers.chunks(PIECE).try_for_each(|piece| {
            let bytes: Vec<[u8; 8]> = piece.iter().map(|number| number.bytes()).collect();
            self.calls.send(bytes.as_flattened(), to)
        })
    }

    /// Receives so many numbers.
    pub fn receive<T: Number>(&self, count: usize, from: usize) -> Result<Vec<T>, EngineError> {
        let mut numbers = Vec::with_capacity(count);
        while numbers.len() < count {
            let mut bytes = vec![[0; 8]; PIECE.min(count - numbers.len())];
            self.calls.receive(bytes.as_flattened_mut(), from)?;
            numbers.extend(bytes.into_iter().map(T::of));
        }
        Ok(numbers)
    }

    /// Sends a list with its length.
    pub fn send_list<T: Number>(&self, numbers: &[T], to: usize) -> Result<(), EngineError> {
        self.send(&[numbers.len() as u64], to)?;
        self.send(numbers, to)
    }

    /// Receives a list with its length.
    pub fn receive_list<T: Number>(&self, from: usize) -> Result<Vec<T>, EngineError> {
        let length = self.receive::<u64>(1, from)?[0];
        self.receive(length as usize, from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_arrive_as_they_were_said() {
        let search = Search { count: 3, available: 40, tolerance: 5e-9, probes: 2 };
        let words = [
            Word::Factorise(7),
            Word::Solve(8, 24),
            Word::Search(9, search, true),
            Word::Release(1),
            Word::Stop,
        ];
        for word in words {
            assert_eq!(Word::received(word.sent()), Some(word));
        }
        assert_eq!(Word::received([9; 7]), None);
    }
}
