//! The host side.
pub mod identify;
