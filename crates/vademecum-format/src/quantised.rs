//! Quantised numbers: 16-bit integers, and a binary32 scale for each block of nodes and each column.
//!
//! A section of shape `(nodes, a, b)` has `a·b` columns. Its decoded bytes are the scales,
//! `(⌈nodes/128⌉, a·b)`, and then the integers, `(nodes, a·b)`; number `(i, c)` is
//! `scale(i/128, c) × integer(i, c)`. So any node can be read where it lies, at half the bytes of binary32,
//! and the scales of a node lie side by side like its numbers.

/// Nodes that share their scales.
pub const BLOCK_NODES: usize = 128;

/// Bytes of the scales of a section of this shape.
pub(crate) fn scales_length(shape: [u64; 3]) -> Option<u64> {
    let blocks = shape[0].div_ceil(BLOCK_NODES as u64);
    blocks.checked_mul(shape[1])?.checked_mul(shape[2])?.checked_mul(4)
}

/// Quantised numbers of a section, as bytes. See the module's text for what they mean.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quantised<'a> {
    scales: &'a [[u8; 4]],
    numbers: &'a [[u8; 2]],
    columns: usize,
}

impl<'a> Quantised<'a> {
    /// From decoded bytes; `None` if they are not as many as the shape asks for.
    pub(crate) fn new(decoded: &'a [u8], shape: [u64; 3]) -> Option<Self> {
        let columns = usize::try_from(shape[1].checked_mul(shape[2])?).ok()?;
        let (scales, numbers) = decoded.split_at_checked(usize::try_from(scales_length(shape)?).ok()?)?;
        let (scales, numbers) = (scales.as_chunks().0, numbers.as_chunks::<2>().0);
        let as_many = numbers.len() as u64 == shape[0].checked_mul(columns as u64)?;
        as_many.then_some(Self { scales, numbers, columns })
    }

    /// Count of numbers.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.numbers.len()
    }

    /// True without any number.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Scales and integers of each block of nodes, in order: `(columns)` and `(nodes of the block, columns)`.
    pub fn blocks(&self) -> impl Iterator<Item = (&'a [[u8; 4]], &'a [[u8; 2]])> + use<'a> {
        let columns = self.columns.max(1);
        let blocks = self.numbers.chunks(columns.saturating_mul(BLOCK_NODES).max(1));
        self.scales.chunks_exact(columns).zip(blocks)
    }

    /// The number at `index`.
    pub(crate) fn get(&self, index: usize) -> Option<f64> {
        let (node, column) = (index.checked_div(self.columns)?, index.checked_rem(self.columns)?);
        let scale = self.scales.get(node / BLOCK_NODES * self.columns + column)?;
        self.numbers.get(index).map(|&number| value(scale, &number))
    }

    /// `length` numbers from `start`, all of one node.
    pub(crate) fn row(&self, start: usize, length: usize) -> Option<Self> {
        let (node, column) = (start.checked_div(self.columns)?, start.checked_rem(self.columns)?);
        if length > self.columns - column {
            return None;
        }
        let at = node / BLOCK_NODES * self.columns + column;
        let scales = self.scales.get(at..at.checked_add(length)?)?;
        let numbers = self.numbers.get(start..start.checked_add(length)?)?;
        Some(Self { scales, numbers, columns: length })
    }

    /// All of them in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = f64> + use<'a> {
        let columns = self.columns;
        let node = |scales: &'a [[u8; 4]], numbers: &'a [[u8; 2]]| {
            scales.iter().zip(numbers).map(|(scale, number)| value(scale, number))
        };
        self.blocks().flat_map(move |(scales, numbers)| {
            // The bound stands here, where the compiler sees that a chunk is not empty: no panic is left to
            // link.
            numbers.chunks(columns.max(1)).flat_map(move |numbers| node(scales, numbers))
        })
    }
}

/// Exact: 24 and 16 bits.
fn value(scale: &[u8; 4], number: &[u8; 2]) -> f64 {
    f64::from(f32::from_le_bytes(*scale)) * f64::from(i16::from_le_bytes(*number))
}
