#![doc = include_str!("README.md")]
//!
//! # Models
//!
//! Those that implement [`Friction`], which lists them.
//!
//! Physics beyond these (Stribeck, cogging, a bad spot, temperature …) is composed with them by type: [`effects`].
//!
//! The way through the crate is the way of the signal: an encoder [`Count`] becomes a [`Motion`]
//! ([`CountTracker`], [`EncoderScale`]), a [`Friction`] model turns that into a force; [`control`] is the loop around
//! it. Parameters are given in SI and validated once (`try_new`, [`to_scalar`]); what every model computes in is a [`Scalar`], in
//! [`Units`] of its own.
//!
//! Equation and table numbers are those of E. Kamenar and S. Zelenika, *Issues in validation of pre-sliding
//! friction models for ultra-high precision positioning*, Proc. IMechE Part C (JMES-17-1227).
#![no_std]
// `!(a < b)` is meant: NaN has to take the branch that bounds it, without the cost of `partial_cmp`.
#![allow(clippy::neg_cmp_op_on_partial_ord)]
#![warn(missing_docs)]

mod encoder;
mod friction;
mod hint;
mod param;
mod scalar;

pub mod control;
pub mod effects;
#[cfg(feature = "fixed")]
pub mod kernels;

/// The crate of the fixed-point number types, which are part of this one's interface.
#[cfg(feature = "fixed")]
pub use fixed;

pub use encoder::{Count, CountTracker, EdgeTiming, EncoderScale};
pub use friction::*;
pub use param::{Block, Bound, ParamError, Units, WEIGHT_SUM_TOLERANCE, to_scalar};
pub use scalar::Scalar;
