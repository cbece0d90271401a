//! What a controller says and hears, shared by the firmware and the host tool.
//!
//! A [`Request`] goes down, a [`Report`] comes up; both travel in frames of postcard, a CRC and COBS
//! ([`Deframer`]). [`Exchange`] is the lock step between an emulated board and the simulated stage.
#![no_std]

mod frame;
mod lock_step;
mod message;

pub use frame::{Deframer, FrameError, LARGEST_FRAME, encode};
pub use lock_step::{Exchange, Order, Reading};
pub use message::{
    FaultCode, GainSettings, MOST_BLOCKS, ModelSettings, RangeCode, Refusal, Report, Request,
    Sample,
};
