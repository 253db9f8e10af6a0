//! Files and their builds: formats, bases, certificates, resumed work, rewriting.

mod basis;
mod canonical;
mod certificates;
mod decoding;
mod engineering;
mod format;
mod kaitai;
mod large;
mod modal;
mod modes;
mod own_matrices;
mod packed_pushes;
mod resume;
mod rewrite;
