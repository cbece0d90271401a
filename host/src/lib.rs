//! The host side.

pub mod progress;
pub mod report;
