//! The host's end of a controller's command link.
//!
//! [`Drive`] asks and is answered; [`Play`] streams a motion through the controller's buffer; [`screen`] is the terminal's; [`SpaceBar`] stops
//! what moves where there is no screen.

// They end the program where their stream is closed.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod error;
mod keys;
mod play;
mod port;
pub mod quantity;
pub mod screen;
mod session;
pub mod words;

pub use error::DriveError;
pub use keys::SpaceBar;
pub use play::{Motion, Play, Played};
pub use port::{BAUD, Line, open};
pub use session::Drive;
