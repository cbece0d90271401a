//! The controller's application, the same on every board.
//!
//! Two tasks. [`Control`] is the interrupt at the control rate: it computes, and touches nothing that can block.
//! [`Background`] runs below it: it reads requests, validates and plans, and frames telemetry. Between them are
//! single-producer queues, so neither ever waits for the other; so are the line's two interrupts, which only move bytes.
//!
//! A board with a predictive controller has a third, between the two: the outer task ([`Guiding`]), which [`Control::attend`] starts.
//!
//! A board is its chip's HAL and what this asks for: PWM channels and pins by the traits of embedded-hal ([`HalfBridges`]), and by two of
//! its own what those have not, a counter ([`CountEncoder`]) and a converter in step with the PWM ([`Sense`]); [`Drive`] is then the tick.

#![no_std]

mod background;
mod board;
mod brake;
mod bridge;
mod control;
mod drive;
mod encoder;
mod guarded;
mod guiding;
mod half_bridges;
mod learning;
mod limits;
mod log;
mod model;
mod no_flash;
mod observing;
mod parameters;
mod queues;
mod sense;
#[rustfmt::skip]
#[allow(dead_code)] // `model`: its parameters are given.
mod starting;
mod tasks;
mod telemetry;

pub use background::Background;
pub use board::Board;
pub use bridge::Bridge;
pub use control::{Control, Inputs};
pub use drive::Drive;
pub use encoder::{CountEncoder, Widened};
pub use guarded::Guarded;
pub use guiding::{Guiding, Unmodelled};
pub use half_bridges::{HalfBridges, wake};
pub use learning::Learner;
pub use limits::Limits;
pub use model::{Exported, Model, Number, Starting, Table};
pub use no_flash::NoFlash;
pub use observing::Observing;
pub use parameters::Parameters;
pub use queues::ROOM;
pub use sense::{Scales, Sense};
pub use tasks::{Queues, Start};

/// Bytes that a board's ring for received bytes must hold, so that the frames that a host may have on their way find room while the
/// background plans, or writes flash; and one more that the queue itself uses up.
pub const RECEIVED: usize = preslide_link::WINDOW * preslide_link::LARGEST_FRAME + 1;

/// Bytes of the queue towards the line: an answer and samples behind it.
pub const SENT: usize = 1024 + 1;
