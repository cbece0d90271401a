//! What identification, comparison, simulation and diagnosis all make of a recording: its motion, what lies between the machine and the
//! recorded effort, the deflection of a block, and the samples to fit and to hold out.

mod bristle;
mod channel;
mod deflection;
mod delay;
mod kinematics;
mod noise;
mod resolution;
mod rigid;
mod saturation;
pub mod spectra;
mod split;
mod stick_slip;
mod vibration;
mod zero_phase;

pub use bristle::{RELAXED, bristle};
pub use channel::Channel;
pub use deflection::{Deflection, not_yet_known, unknown_starts};
pub use delay::{Delay, TAKES, beside_the_motion};
pub use kinematics::Kinematics;
pub use resolution::step_at_reversals;
pub use saturation::{End, Saturation, stands_mostly};
pub use split::{FEWEST, GROUPS, Split, Window, check_windows, parse_window};
pub use stick_slip::{Levels, StickSlip};
pub use vibration::Vibration;
pub use zero_phase::ZeroPhase;

use std::f64::consts::SQRT_2;

/// Shares of the usual top speed over which friction without hysteresis reverses (`tanh(v/v₀)`, as many simulations and some lubricated
/// machines have it): up to a tenth, above which it would be viscous friction, in half octaves. Midway between octaves two of them mix to within 2.2 % of
/// the level, and what that leaves falls with the speed as a Stribeck curve does.
pub const SMOOTH: [f64; 9] = [
    0.1 / 16.0,
    0.1 / 8.0 / SQRT_2,
    0.1 / 8.0,
    0.1 / 4.0 / SQRT_2,
    0.1 / 4.0,
    0.1 / 2.0 / SQRT_2,
    0.1 / 2.0,
    0.1 / SQRT_2,
    0.1,
];

/// Travel (rad) below which a sine of the angle is one slope.
pub const ONE_SLOPE_RAD: f64 = 1.0;

/// Yield displacements of friction end at this share of the travel; a later yield is a spring, and competes as one.
pub const LATE: f64 = 0.025;
