//! The controller's application, the same on every board.
//!
//! Two tasks. [`Control`] is the interrupt at the control rate: it computes, and touches nothing that can block.
//! [`Background`] runs below it: it reads requests, validates and plans, and frames telemetry. Between them are
//! single-producer queues, so neither ever waits for the other.

#![no_std]

mod background;
mod bridge;
mod control;
mod learning;
mod model;
mod queues;

pub use background::Background;
pub use bridge::Bridge;
pub use control::{Control, Inputs};
pub use learning::Learner;
pub use model::{Blocks, Exported, Model, Number, STARTING_MODEL};
pub use queues::{Change, Queues};
