//! Messages between ranks: numbers, lists of numbers, and the commands of the first rank.

use vademecum_build::fem::{EngineError, Search};

use crate::calls::Calls;

/// A command of the first rank to the others. Numbers name matrices and factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Take the rows of a matrix that follow.
    Deal(u64),
    /// Assemble the rows of two matrices, mass and stiffness, of the elements that follow.
    Assemble(u64, u64),
    /// Make a matrix that is another one times a number.
    Scale(u64, u64, f64),
    /// Make a factor, of a matrix.
    Factorise(u64, u64),
    /// Multiply a matrix by a number of columns, which follow, and send the product.
    Multiply(u64, usize),
    /// Solve with a factor for a number of columns, which follow, and send the answers.
    Solve(u64, usize),
    /// Search for modes with a factor and a mass; `true`: of a body without supports.
    Search(u64, u64, Search, bool),
    /// Free a matrix or a factor.
    Release(u64),
    /// End the job.
    Stop,
}

/// An encoded command: its kind and up to eight numbers.
type Packet = [u64; 9];

impl Command {
    fn packet(self) -> Packet {
        match self {
            Self::Deal(id) => [0, id, 0, 0, 0, 0, 0, 0, 0],
            Self::Assemble(mass, stiffness) => [1, mass, stiffness, 0, 0, 0, 0, 0, 0],
            Self::Scale(id, of, weight) => [2, id, of, weight.to_bits(), 0, 0, 0, 0, 0],
            Self::Factorise(id, of) => [3, id, of, 0, 0, 0, 0, 0, 0],
            Self::Multiply(id, columns) => [4, id, columns as u64, 0, 0, 0, 0, 0, 0],
            Self::Solve(id, columns) => [5, id, columns as u64, 0, 0, 0, 0, 0, 0],
            Self::Search(id, mass, search, free) => {
                let Search { count, available, tolerance, probes, stiffest } = search;
                let [count, available, probes] = [count, available, probes].map(|number| number as u64);
                let [tolerance, stiffest] = [tolerance, stiffest].map(f64::to_bits);
                [6, id, mass, count, available, tolerance, probes, stiffest, free.into()]
            }
            Self::Release(id) => [7, id, 0, 0, 0, 0, 0, 0, 0],
            Self::Stop => [8, 0, 0, 0, 0, 0, 0, 0, 0],
        }
    }

    fn received(
        [kind, id, other, third, available, tolerance, probes, stiffest, free]: Packet,
    ) -> Option<Self> {
        Some(match kind {
            0 => Self::Deal(id),
            1 => Self::Assemble(id, other),
            2 => Self::Scale(id, other, f64::from_bits(third)),
            3 => Self::Factorise(id, other),
            4 => Self::Multiply(id, other as usize),
            5 => Self::Solve(id, other as usize),
            6 => {
                let [count, available, probes] = [third, available, probes].map(|number| number as usize);
                let [tolerance, stiffest] = [tolerance, stiffest].map(f64::from_bits);
                let search = Search { count, available, tolerance, probes, stiffest };
                Self::Search(id, other, search, free != 0)
            }
            7 => Self::Release(id),
            8 => Self::Stop,
            _ => return None,
        })
    }
}

/// A number as it is sent.
pub trait Scalar: Copy {
    /// Its bytes.
    fn bytes(self) -> [u8; 8];
    /// The number of these bytes.
    fn of(bytes: [u8; 8]) -> Self;
}

impl Scalar for u64 {
    fn bytes(self) -> [u8; 8] {
        self.to_ne_bytes()
    }
    fn of(bytes: [u8; 8]) -> Self {
        Self::from_ne_bytes(bytes)
    }
}

impl Scalar for i64 {
    fn bytes(self) -> [u8; 8] {
        self.to_ne_bytes()
    }
    fn of(bytes: [u8; 8]) -> Self {
        Self::from_ne_bytes(bytes)
    }
}

impl Scalar for f64 {
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
    /// True if this is the rank that leads.
    pub fn is_first(&self) -> bool {
        self.calls.rank == 0
    }

    /// All ranks but the first.
    pub fn others(&self) -> std::ops::Range<usize> {
        1..self.calls.size
    }

    /// The rows of a rank, of `total`: equal shares, of whole nodes where every node has three rows.
    pub fn rows_of(&self, rank: usize, total: usize) -> std::ops::Range<usize> {
        let first = |rank: usize| match (total as u128 * rank as u128 / self.calls.size as u128) as usize {
            first if first == total => total,
            first => first / 3 * 3,
        };
        first(rank)..first(rank + 1)
    }

    /// Sends a command to all other ranks.
    pub fn broadcast(&self, command: Command) -> Result<(), EngineError> {
        self.others().try_for_each(|rank| self.send(&command.packet(), rank))
    }

    /// Waits for a command.
    pub fn receive_command(&self) -> Result<Command, EngineError> {
        self.calls.idle()?;
        let mut packet = [[0; 8]; size_of::<Packet>() / 8];
        self.calls.receive(packet.as_flattened_mut(), 0)?;
        let reason = "a word that no rank knows";
        let unknown = || EngineError { call: "MPI_Recv".into(), reason: reason.into(), short: None };
        Command::received(packet.map(u64::from_ne_bytes)).ok_or_else(unknown)
    }

    /// Sends numbers; the other rank knows the count.
    pub fn send<T: Scalar>(&self, numbers: &[T], to: usize) -> Result<(), EngineError> {
        numbers.chunks(PIECE).try_for_each(|piece| {
            let bytes: Vec<[u8; 8]> = piece.iter().map(|number| number.bytes()).collect();
            self.calls.send(bytes.as_flattened(), to)
        })
    }

    /// Receives `count` numbers.
    pub fn receive<T: Scalar>(&self, count: usize, from: usize) -> Result<Vec<T>, EngineError> {
        let mut numbers = Vec::with_capacity(count);
        while numbers.len() < count {
            let mut bytes = vec![[0; 8]; PIECE.min(count - numbers.len())];
            self.calls.receive(bytes.as_flattened_mut(), from)?;
            numbers.extend(bytes.into_iter().map(T::of));
        }
        Ok(numbers)
    }

    /// Sends a list with its length.
    pub fn send_list<T: Scalar>(&self, numbers: &[T], to: usize) -> Result<(), EngineError> {
        self.send(&[numbers.len() as u64], to)?;
        self.send(numbers, to)
    }

    /// Receives a list with its length.
    pub fn receive_list<T: Scalar>(&self, from: usize) -> Result<Vec<T>, EngineError> {
        let length = self.receive::<u64>(1, from)?[0];
        self.receive(length as usize, from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_survive_encoding() {
        let search = Search { count: 3, available: 40, tolerance: 5e-9, probes: 2, stiffest: 1e12 };
        let commands = [
            Command::Deal(6),
            Command::Assemble(1, 2),
            Command::Scale(5, 6, 1.5),
            Command::Factorise(7, 6),
            Command::Multiply(6, 3),
            Command::Solve(8, 24),
            Command::Search(9, 6, search, true),
            Command::Release(1),
            Command::Stop,
        ];
        for command in commands {
            assert_eq!(Command::received(command.packet()), Some(command));
        }
        assert_eq!(Command::received([9; 9]), None);
    }
}
