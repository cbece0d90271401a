#![doc = include_str!("README.md")]
//!
//! # Models
//!
//! | | model | memory |
//! |---|---|---|
//! | [`Gms`] | Generalized Maxwell-Slip, N blocks, sliding dynamics | non-local |
//! | [`QuasiStaticGms`] | the same with `F_s = F_c`, exact for any displacement step | non-local |
//! | [`Dahl`] | eq. (1) | one state |
//! | [`LuGre`] | eqs. (2)–(3) | one state |
//! | [`BoucWen`] | Dahl's law with its own shape on unloading | one state |
//! | [`ElastoPlastic`] | LuGre that is purely elastic below breakaway | one state |
//! | [`Leuven`] | Maxwell-slip hysteresis under a LuGre-like state, original and modified | non-local, leaks |
//! | [`TwoState`] | elasto-plastic branch from the last reversal, lagging level | the last reversal |
//! | [`Hsieh`] | eqs. (4)–(6) | non-local, creep |
//! | [`Coulomb`] | `F_c·sgn v + b·v`, the baseline | none |
//! | [`kernels`] | the two Maxwell-slip laws in whole numbers, for a cycle budget | non-local |
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
pub use friction::{
    BoucWen, BoucWenState, Coulomb, Dahl, DahlState, ElastoPlastic, ElastoPlasticState, Friction,
    Gms, GmsState, Hsieh, HsiehParams, HsiehState, Leuven, LeuvenForm, LeuvenState, LuGre,
    LuGreState, Motion, QuasiStaticGms, QuasiStaticState, REVERSALS, Sliding, TwoState,
    TwoStateMemory,
};
pub use param::{Block, Bound, ParamError, Units, WEIGHT_SUM_TOLERANCE, to_scalar};
pub use scalar::Scalar;
