//! The host's end of a controller's command link.
//!
//! [`Drive`] asks and is answered; [`Play`] streams a motion through the controller's buffer; [`screen`] is the terminal's.

mod error;
mod play;
mod port;
pub mod quantity;
pub mod screen;
mod session;
pub mod words;

pub use error::DriveError;
pub use play::{Motion, Play, Played};
pub use port::{BAUD, Line, open};
pub use session::Drive;
