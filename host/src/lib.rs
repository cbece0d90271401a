//! The host side.

pub mod stage;
