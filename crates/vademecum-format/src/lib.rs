//! What a vademecum file is, byte for byte, and what its numbers mean.
//!
//! The builder writes through this crate, the evaluator reads through it, and they share nothing else.
//! The normative text is `formats/vademecum-1.md`. Core only: no heap, no panic on any input.
#![no_std]

mod fuse;
pub mod scheme;
