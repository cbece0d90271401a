//! From a recording to the physics that fits it, and back to motion and force: what every command of the tool stands on.

pub mod effects;
pub mod evidence;
pub mod friction;
pub mod identify;
pub mod kernel;
pub mod model;
pub mod progress;
pub mod recording;
pub mod report;
pub mod signal;
pub mod simulate;
pub mod statistics;
