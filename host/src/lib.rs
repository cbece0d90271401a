//! The host side.
pub mod recording;
