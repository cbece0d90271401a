//! The firmware in QEMU against the simulated stage: agreement with the host's simulation, and injected faults.

mod agreement;
mod emulator;
mod faults;
mod outer;
mod run;
pub mod sensed;
mod truth;
mod wear;
mod winding;

pub use agreement::{Agreement, agreement, motion, samples};
pub use emulator::{Emulator, Listener, Remains, RigError};
pub use faults::{Injection, injections, logged};
pub use outer::{Guidance, guidance};
pub use run::{ByTick, CALIBRATED, Record, Script, frame, registers, requests, run};
pub use sensed::telemetry;
pub use truth::{Comparison, TrueCurve, presliding};
pub use wear::{Notice, Wear, notice};
pub use winding::{Followed, followed};
