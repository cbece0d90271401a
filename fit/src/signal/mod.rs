//! What identification, comparison, simulation and diagnosis all make of a recording: its motion, what lies between the machine and the
//! recorded effort, the deflection of a block, and the samples to fit and to hold out.

mod channel;
mod deflection;
mod delay;
mod kinematics;
mod resolution;
mod rigid;
mod saturation;
pub mod spectra;
mod split;
mod stick_slip;
mod vibration;
mod zero_phase;

pub use channel::Channel;
pub use deflection::{Deflection, not_yet_known, unknown_starts};
pub use delay::{Delay, TAKES};
pub use kinematics::Kinematics;
pub use resolution::step_at_reversals;
pub use saturation::{End, Saturation};
pub use split::{FEWEST, GROUPS, Split, Window, check_windows, parse_window};
pub use stick_slip::{Levels, StickSlip};
pub use vibration::Vibration;
pub use zero_phase::ZeroPhase;

/// Travel (rad) below which a sine of the angle is one slope.
pub const ONE_SLOPE_RAD: f64 = 1.0;

/// Yield displacements of friction end at this share of the travel; a later yield is a spring, and competes as one.
pub const LATE: f64 = 0.025;
