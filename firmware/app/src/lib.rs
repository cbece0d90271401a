//! The controller's application, the same on every board.
//!
//! Two tasks. [`Control`] is the interrupt at the control rate: it computes, and touches nothing that can block.
//! [`Background`] runs below it: it reads requests, validates and plans, and frames telemetry. Between them are
//! single-producer queues, so neither ever waits for the other; so are the line's two interrupts, which only move bytes.

#![no_std]

mod background;
mod bridge;
mod control;
mod learning;
mod model;
mod observing;
mod parameters;
mod queues;
mod sense;
mod tasks;
mod telemetry;

pub use background::Background;
pub use bridge::Bridge;
pub use control::{Control, Inputs};
pub use learning::Learner;
pub use model::{Blocks, Exported, Model, Number, STARTING_MODEL};
pub use observing::Observing;
pub use parameters::Parameters;
pub use queues::ROOM;
pub use sense::Scales;
pub use tasks::{Queues, Start};

/// Bytes that a board's ring for received bytes must hold, so that the frames that a host may have on their way find room while the
/// background plans, or writes flash; and one more that the queue itself uses up.
pub const RECEIVED: usize = preslide_link::WINDOW * preslide_link::LARGEST_FRAME + 1;

/// Bytes of the queue towards the line: an answer and samples behind it.
pub const SENT: usize = 1024 + 1;
