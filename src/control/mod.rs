//! The control task: what runs between the encoder and the PWM, on both boards and in the host's simulation.
//!
//! `count → displacement → reference → PID + friction feed-forward → limiter → PWM code`
//!
//! There is no `cfg` in this module: the code that a simulation shows to work is the code that runs on the axis.
//! [`Settings`] in SI become [`Coefficients`] once, outside the interrupt; [`Controller::tick`] uses only those.
//! The friction model is a type parameter ([`NoFriction`] for none) and brings its number type along.
//!
//! ```
//! use preslide::control::{Coefficients, Controller, Measurement, Move, Settings};
//! use preslide::{Block, QuasiStaticGms, Units};
//!
//! let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
//! let friction = QuasiStaticGms::<2>::try_new(&blocks, 0.9, Units::SI)?;
//! let settings = Settings::PAPER_AXIS;
//! let coefficients = Coefficients::try_new(&settings, friction, Units::SI)?;
//! let mut controller = Controller::new(coefficients, 0_u32);
//! controller.start(Move::plan(1e-6, 10e-6, 1e-3, settings.encoder.count, settings.sample_time, Units::SI)?);
//! let command = controller.tick(Measurement { count: 0, supply: 6000, late: false });
//! assert!(command.fault.is_none());
//! # Ok::<(), preslide::ParamError>(())
//! ```

mod compensator;
mod controller;
mod faults;
pub mod learning;
mod limiter;
mod motor;
mod pid;
mod reference;
mod settings;
mod swap;

pub use compensator::{Compensator, Drive, FeedForward, NoFriction};
pub use controller::{Command, Controller, Measurement};
pub use faults::{Fault, Monitor, Suspicion, Watch};
pub use learning::{Condition, Learning, LearningSettings, NormalRange};
pub use limiter::{Limiter, Saturation};
pub use motor::{Motor, MotorDrive, Rounding};
pub use pid::{Pid, PidGains, PidState};
pub use reference::{Move, Reference, Sample};
pub use settings::{Coefficients, Encoder, Settings};
pub use swap::{Fade, FadeState};
