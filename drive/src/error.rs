//! What can go wrong between host and controller.

use crate::words;
use preslide_link::{FaultCode, PROTOCOL, Refusal};

/// Why a request was not carried out.
#[derive(Debug, thiserror::Error)]
pub enum DriveError {
    /// No connection.
    #[error(
        "cannot open {port}: {error}; give the path of a serial device (/dev/ttyACM0, see `ls /dev/tty*`) or tcp:HOST:PORT \
         (`cargo xtask stage` serves an emulated drive on tcp:127.0.0.1:7700)"
    )]
    Open {
        /// As it was given.
        port: String,
        /// What the system said.
        error: std::io::Error,
    },
    /// The line broke.
    #[error(
        "the line to the controller broke: {0}; a moving axis stops by itself when it hears nothing"
    )]
    Line(std::io::Error),
    /// No answer came.
    #[error(
        "no answer to `{request}` ({bytes} bytes came meanwhile, {damaged} damaged frames): check the cable and the line's speed, that this is a Preslide controller's port, and that nothing else has it open; a moving axis stops by itself when it hears nothing"
    )]
    Silent {
        /// What was asked for.
        request: String,
        /// Bytes that came while waiting.
        bytes: u64,
        /// Frames that could not be read, since the start.
        damaged: u64,
    },
    /// The controller speaks another version.
    #[error(
        "the controller speaks version {0} of the link, this tool version {PROTOCOL}: build both from the same source"
    )]
    Protocol(u16),
    /// The controller said no.
    #[error("`{request}` was refused: {}", words::refusal(*.refusal))]
    Refused {
        /// What was asked for.
        request: String,
        /// Why not.
        refusal: Refusal,
    },
    /// The controller is in its safe state.
    #[error("the axis stopped: {}", words::fault(*.0))]
    Fault(FaultCode),
    /// The axis was disabled, by somebody else or by a reset.
    #[error("the axis is no longer enabled; `state` says what reset the controller")]
    Disabled,
    /// Stopped by the user.
    #[error("stopped")]
    Stopped,
    /// A motion that cannot be played.
    #[error("{0}")]
    Motion(String),
    /// The controller did not get its points in time.
    #[error(
        "the stream ran dry {0} times: the axis stopped within its limits before the motion's end; play it slower or with points \
         further apart"
    )]
    Dry(u16),
    /// Something else than was asked for came back.
    #[error("the controller answered `{0}` with something else")]
    Answer(String),
}
