//! From a recording to the parameters of a real-time friction model, and to its simulation.

pub mod capture;
pub mod compare;
pub mod cost;
pub mod diagnose;
pub mod drive;
pub mod effects;
pub mod evidence;
pub mod export;
pub mod fleet;
pub mod friction;
pub mod identify;
pub mod kernel;
pub mod model;
pub mod paper;
pub mod plan;
pub mod predict;
pub mod progress;
pub mod recording;
pub mod report;
pub mod signal;
pub mod simulate;
pub mod statistics;
pub mod tune;
