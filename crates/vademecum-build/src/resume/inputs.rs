//! The address of a stage's result: a hash of everything the stage reads, the program included.

use std::fmt::Debug;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;
use std::sync::OnceLock;

use faer::MatRef;
use xxhash_rust::xxh3::Xxh3;

use crate::certificate::UnseenLoads;
use crate::fem::{Model, SymmetricMatrix};
use crate::pod::Basis;
use crate::response::StageResponse;

/// What a stage reads, added piece by piece; XXH3-128 of all of it is the address.
#[derive(Clone)]
pub struct Inputs(Xxh3);

impl Inputs {
    /// Of nothing but the program: its version and, where the system shows them, the bytes it runs from. A program that was
    /// built anew computes anew.
    pub fn none() -> Self {
        static PROGRAM: OnceLock<u128> = OnceLock::new();
        let program = PROGRAM.get_or_init(|| {
            let mut state = Xxh3::new();
            // Where the system does not tell, the version has to do.
            let _ = std::env::current_exe().and_then(|running| read_into(&mut state, &running));
            state.digest128()
        });
        Self(Xxh3::new()).value(&(env!("CARGO_PKG_VERSION"), program))
    }

    /// A small value by its `Debug` text, which has every digit of every number and every field, later ones too.
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

    fn indices(mut self, indices: &[u32]) -> Self {
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

    fn sparse(self, matrix: &SymmetricMatrix) -> Self {
        self.numbers(matrix.values())
    }

    /// What a file holds, or that it cannot be read.
    pub fn file(mut self, path: &Path) -> Self {
        let read = read_into(&mut self.0, path);
        self.value(&read.ok())
    }

    /// The matrices of all regions on their pattern, and the dofs they stand for. Mesh, materials and supports act on the
    /// dynamics through these alone.
    pub fn model(self, model: &Model) -> Self {
        let (pencil, pattern) = (model.pencil(), model.pencil().mass().pattern());
        let shape = self.indices(model.dofs().dof_of_free()).value(&model.dofs().n_dof());
        let shape = (0..pattern.n()).fold(shape, |inputs, j| inputs.indices(pattern.rows_of(j)));
        let regions = 0..pencil.n_regions();
        regions
            .fold(shape, |inputs, q| inputs.sparse(pencil.region_mass(q)).sparse(pencil.region_stiffness(q)))
    }

    /// A basis, what it was made from left aside.
    pub fn basis(self, basis: &Basis) -> Self {
        self.matrix(basis.vectors.as_ref()).matrix(basis.stiffness.as_ref()).value(&basis.eigenvalues)
    }

    /// Stage responses.
    pub fn responses(self, responses: &[StageResponse]) -> Self {
        let one = |inputs: Self, r: &StageResponse| {
            inputs.value(&r.theta).matrix(r.increment.as_ref()).matrix(r.state.as_ref())
        };
        responses.iter().fold(self, one)
    }

    /// The loads of a certificate and how long they are marched.
    pub fn unseen(self, unseen: &UnseenLoads) -> Self {
        let steps = self.value(&unseen.steps);
        unseen
            .loads
            .iter()
            .fold(steps, |inputs, load| inputs.value(&(load.column, load.when)).numbers(&load.force))
    }

    /// The address.
    pub fn address(&self) -> u128 {
        self.0.digest128()
    }

    /// Lengths go before what they count, so that no two inputs share one row of bytes.
    fn length(&mut self, length: usize) {
        self.0.update(&(length as u64).to_le_bytes());
    }
}

/// A file piece by piece, and its length.
fn read_into(state: &mut Xxh3, path: &Path) -> io::Result<u64> {
    let mut reader = BufReader::with_capacity(1 << 16, File::open(path)?);
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
