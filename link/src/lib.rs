//! What a controller says and hears, shared by the firmware and the host tool.
//!
//! A [`Request`] goes down with a number, its answer and the telemetry come up as [`Report`]s; both travel in frames of postcard, a
//! CRC and COBS ([`Deframer`]). [`Answered`] makes a repeated request harmless. [`Exchange`] is the lock step between an emulated
//! board and the simulated stage.
#![no_std]

mod answered;
mod frame;
mod lock_step;
mod message;
mod parameter;

pub use answered::{Answered, WINDOW};
pub use frame::{Deframer, FrameError, LARGEST_FRAME, encode};
pub use lock_step::{Exchange, Order, Reading};
pub use message::{
    FaultCode, GainSettings, Homing, Identity, MOST_PARAMETERS, Mark, Mode, ModelPart, Numbered,
    PART, POINTS, PROTOCOL, Points, RangeCode, Refusal, Reply, Report, Request, ResetCause, Sample,
    State,
};
pub use parameter::{LONGEST_NAME, Name, Parameter};
