//! What identification, comparison, simulation and diagnosis all make of a recording: its motion, the deflection of a block along
//! it, and the samples to fit and to hold out.

mod deflection;
mod kinematics;
mod split;
mod zero_phase;

pub use deflection::Deflection;
pub use kinematics::Kinematics;
pub use split::{FEWEST, GROUPS, Split, Window, check_windows, parse_window};
pub use zero_phase::ZeroPhase;
