//! The rest of the family: models with parameters that enter nonlinearly, fitted.

pub mod bench;
pub mod fit;
pub mod starts;
#[cfg(test)]
pub(crate) mod tests;

pub use crate::friction::{Bounded, Family, Span};
