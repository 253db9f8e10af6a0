//! The address of a stage's result: a hash of everything the stage reads, the program included.

use std::fmt::Debug;
use std::io::{self, BufRead, BufReader};
use std::path::Path;
use std::sync::OnceLock;

use faer::MatRef;
use xxhash_rust::xxh3::Xxh3;

use super::read::open_regular;

/// A value that says itself what of it a stage depends on.
pub trait StageInput {
    /// Adds it to the inputs of a stage.
    fn add_to(&self, inputs: Inputs) -> Inputs;
}

/// Inputs of a stage, added piece by piece; XXH3-128 of all of it is the address.
#[derive(Clone)]
pub struct Inputs(Xxh3);

impl Inputs {
    /// Of nothing but the program: its version and, where the system shows them, the bytes it runs from. A
    /// program that was built anew computes anew.
    pub(crate) fn none() -> Self {
        static PROGRAM: OnceLock<u128> = OnceLock::new();
        let program = PROGRAM.get_or_init(|| {
            let mut state = Xxh3::new();
            // Where the system does not tell, the version has to do.
            let _ = std::env::current_exe().and_then(|running| read_into(&mut state, &running));
            state.digest128()
        });
        Self(Xxh3::new()).value(&(env!("CARGO_PKG_VERSION"), program))
    }

    /// A small value by its `Debug` text, which has every digit of every number and every field, later ones
    /// too.
    pub fn value(mut self, value: &impl Debug) -> Self {
        let text = format!("{value:?}");
        self.length(text.len());
        self.0.update(text.as_bytes());
        self
    }

    /// A row of numbers, bit by bit.
    pub fn numbers(mut self, numbers: &[f64]) -> Self {
        self.length(numbers.len());
        numbers.iter().for_each(|x| self.0.update(&x.to_le_bytes()));
        self
    }

    /// A row of indices.
    pub(crate) fn indices(mut self, indices: &[u32]) -> Self {
        self.length(indices.len());
        indices.iter().for_each(|i| self.0.update(&i.to_le_bytes()));
        self
    }

    /// A dense matrix.
    pub fn matrix(mut self, matrix: MatRef<'_, f64>) -> Self {
        self.length(matrix.ncols());
        matrix.col_iter().fold(self, |inputs, column| {
            let column: Vec<f64> = column.iter().copied().collect();
            inputs.numbers(&column)
        })
    }

    /// A value that knows what of it matters.
    pub fn with(self, value: &(impl StageInput + ?Sized)) -> Self {
        value.add_to(self)
    }

    /// Content of a file, or the fact that it cannot be read.
    pub fn file(mut self, path: &Path) -> Self {
        let read = read_into(&mut self.0, path);
        self.value(&read.ok())
    }

    /// The address.
    pub(crate) fn address(&self) -> u128 {
        self.0.digest128()
    }

    /// Lengths go before what they count, so that no two inputs share one row of bytes.
    fn length(&mut self, length: usize) {
        self.0.update(&(length as u64).to_le_bytes());
    }
}

/// A file piece by piece, and its length.
fn read_into(state: &mut Xxh3, path: &Path) -> io::Result<u64> {
    let mut reader = BufReader::with_capacity(1 << 16, open_regular(path)?);
    let mut length = 0;
    loop {
        let piece = reader.fill_buf()?;
        if piece.is_empty() {
            return Ok(length);
        }
        state.update(piece);
        let read = piece.len();
        length += read as u64;
        reader.consume(read);
    }
}
