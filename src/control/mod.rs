//! The control task: what runs between the encoder and the PWM, on every board and in the host's simulation.
//!
//! `count → displacement → reference → PID + friction feed-forward → limiter → PWM code`
//!
//! There is no `cfg` in this module: the code that a simulation shows to work is the code that runs on the axis.
//! An [`Axis`] in SI, which follows from its [`Basics`] or is told in full, becomes [`Coefficients`] once, outside the interrupt;
//! [`Controller::tick`] uses only those.
//! The friction model is a type parameter ([`NoFriction`] for none) and brings its number type along. A [`Planner`] checks
//! what is asked for against the axis's [`Limits`], also outside the interrupt.

mod axis;
mod basics;
mod coefficients;
mod command;
mod compensator;
mod controller;
mod cross_fade;
mod fade;
mod fault_limits;
mod faults;
mod hardware;
pub mod koopman;
pub mod learning;
mod limiter;
mod measurement;
mod motor;
mod moves;
mod notch;
mod observed;
mod observer;
mod pid;
mod planner;
mod reference;
mod smoothing;
mod winding;

pub use axis::{Axis, Encoder, Limits, Settings};
pub use basics::{Basics, BasicsError};
pub use coefficients::Coefficients;
pub use command::Command;
pub use compensator::{Compensator, FeedForward, NoFriction, VelocitySource};
pub use controller::Controller;
pub use fade::Fade;
pub use fault_limits::FaultLimits;
pub use faults::{Fault, Monitor, Suspicion};
pub use hardware::Hardware;
pub use learning::{Condition, Learning, LearningSettings, NormalRange};
pub use limiter::{Limiter, Saturation};
pub use measurement::Measurement;
pub use motor::{Motor, MotorDrive, Rounding};
pub use moves::{Grid, Move};
pub use notch::{Notch, NotchFilter, NotchState};
pub use observed::{Observed, ObservedState};
pub use observer::{Observer, ObserverSettings, ObserverState};
pub use pid::{Pid, PidGains, PidState};
pub use planner::Planner;
pub use reference::{Jog, Pace, Reference, Refused, Sample};
pub use smoothing::MOST_SMOOTHED;
