//! Model predictive control on lifted states: an outer task above the control loop.
//!
//! Korda and Mezić, *Linear predictors for nonlinear dynamical systems: Koopman operator meets model predictive control*, Automatica 93
//! (2018), arXiv 1611.03537. The plant is the closed control loop; what is decided is a force beside the feedback's, once a sample of
//! 0.5…1 ms. A host learns the map between lifted states from a recording with such forces in it.
//!
//! `f32` only: the products of a lift's states, each with a unit of its own, span more than a fixed-point word holds.
//!
//! The outer task, below the control loop in priority, once a sample: [`ErrorLift::take`] what was measured, [`KoopmanMpc::solve`],
//! then [`Guided`]'s order. It has a whole sample for that: an order counts from the next sample on, and the map knows. [`Outer`] is that
//! task, and a [`Desk`] lies between it and the control task.

mod desk;
mod guided;
mod lift;
mod mpc;
mod outer;
mod spectrum;

pub use desk::{Desk, Told};
pub use guided::{Guided, GuidedState};
pub use lift::{ErrorLift, ErrorLiftState};
pub use mpc::{Ahead, KoopmanModel, KoopmanMpc, KoopmanSettings, KoopmanState};
pub use outer::{Outer, OuterSettings};
