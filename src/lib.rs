//! Friction models for the last micrometre, fast enough for a motor controller's interrupt.
//!
//! Below about 0.1 mm of travel, guideways and screws never quite slide: friction is a hysteretic spring with
//! memory (*pre-sliding*). This crate runs models of it inside a control task, without heap, panics or the
//! standard library:
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
//! it. Parameters are given in SI
//! and validated once (`try_new`); every model computes in `f32`, `f64` or a type of the [`fixed`] crate
//! ([`Scalar`], [`Units`]).
//!
//! Equation and table numbers are those of E. Kamenar and S. Zelenika, *Issues in validation of pre-sliding
//! friction models for ultra-high precision positioning*, Proc. IMechE Part C (JMES-17-1227).
//!
//! ```
//! use preslide::{Block, CountTracker, EncoderScale, Friction, QuasiStaticGms, Units};
//!
//! let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
//! let gms = QuasiStaticGms::<2>::try_new(&blocks, 0.9, Units::SI)?;
//! let encoder = EncoderScale::try_new(25e-9, 50e-6, 1e-3, 2.0, Units::SI)?;
//!
//! let mut counter = CountTracker::new(0_u16);
//! let (mut timing, mut friction) = (encoder.at_rest(), gms.at_rest());
//! for reading in [3_u16, 7, 12] {
//!     let motion = encoder.step(&mut timing, counter.update(reading));
//!     let force = gms.step(&mut friction, motion); // (N), to be added to the controller's output
//!     assert!(force > 0.0);
//! }
//! # Ok::<(), preslide::ParamError>(())
//! ```
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
