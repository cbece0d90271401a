//! The Maxwell-slip laws made for a cycle budget, in whole numbers.
//!
//! | kernel | law | arithmetic | accepts |
//! |---|---|---|---|
//! | [`CountGms`] | [`Gms`](crate::Gms): stick/slip, Stribeck curve, lag | `i32` | `D_max²/D_min ≤ 2²⁰` |
//! | [`SlipReserve`] | [`QuasiStaticGms`](crate::QuasiStaticGms) | `i32` | `D < 2²⁹`, `ΣW < 2³⁰` |
//! | [`PackedSlipReserve`] | that of `SlipReserve` | two 16-bit blocks a word | `D < 2¹⁴`, `k < 2¹⁵`, `ΣW < 2³⁰` |
//! | [`ConstantTimeSlipReserve`] | the same, on a path that no data changes | two 16-bit blocks a word | the same |
//!
//! Displacement, velocity and force are whole numbers of their [`Units`](crate::Units): let the unit of length be one
//! encoder count, and take the unit of force from the kernel's `finest_force`. Counts make the quasi-static
//! law exact: no drift, however long it runs; what is left is the rounding of `D` to a count and of `k`.
//! The quasi-static kernels agree bit for bit wherever their ranges and units do, on the host as on the target.
//!
//! What each costs stands in `firmware/cycles/cortex-m4.csv`; `preslide tune` chooses between them.

mod constant_time;
mod count_gms;
mod curves;
mod dsp;
mod packed;
mod product;
mod quantised;
mod slip_reserve;

pub use constant_time::ConstantTimeSlipReserve;
pub use count_gms::{CountGms, CountGmsState};
pub use packed::{PackedSlipReserve, PackedState};
pub use slip_reserve::{SlipReserve, SlipReserveState};

/// A whole number of the model's units: encoder counts, or steps of force.
pub type Whole = fixed::types::I32F0;
