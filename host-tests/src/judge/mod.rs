//! Judges of `preslide diagnose`: they know the tool by its command line and its JSON only, so that any build can be judged.
//!
//! `properties` asks, without knowing a truth, whether an answer flips when it should not; `inject` adds known effects to real
//! recordings; `sources` puts every source of recordings with a known truth into one table.

pub use crate::{case, table};

pub mod baseline;
pub mod calibrate;
pub mod inject;
pub mod motion;
pub mod oracle;
pub mod properties;
pub mod real;
pub mod source;
pub mod summary;
pub mod tool;
