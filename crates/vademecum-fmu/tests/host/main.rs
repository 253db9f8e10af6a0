//! A master that calls the entry points: the numbers are those of the evaluator, bit for bit, states come
//! back as they were, and everything else is refused by name.
#![allow(unsafe_code)]

mod arrays;
mod calls;
mod derivatives;
mod early_return;
mod numbers;
mod parameters;
mod states;
mod unit;
