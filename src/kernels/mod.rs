//! The Maxwell-slip laws made for a cycle budget, in whole numbers.
//!
//! | kernel | law | arithmetic | accepts |
//! |---|---|---|---|
//! | [`CountGms`] | [`Gms`](crate::Gms): stick/slip, Stribeck curve, lag | `i32` | `D_max²/D_min ≤ 2²⁰` |
//! | [`SlipReserve`] | [`QuasiStaticGms`](crate::QuasiStaticGms) | `i32` | `D < 2²⁹`, `ΣW < 2³⁰` |
//! | [`PackedSlipReserve`] | that of `SlipReserve` | two 16-bit blocks a word | `D < 2¹⁴`, `k < 2¹⁵`, `ΣW < 2³⁰` |
//!
//! [`Scaled`] makes a friction model in a controller's own number type and units of any of them: what a control task takes, and what
//! `preslide export --kernel` writes.
//!
//! By themselves they take displacement and velocity and give force in whole numbers of their [`Units`](crate::Units): let the unit of
//! length be one encoder count, and take the unit of force from the kernel's `finest_force`. Whole numbers make the quasi-static
//! law exact: no drift, however long it runs; what is left is the rounding of `D` to the unit of length and of `k`.
//! The quasi-static kernels agree bit for bit wherever their ranges and units do, on the host as on the target.
//!
//! What each costs in a controller's units stands in `firmware/cycles/cortex-m4.csv`; `preslide tune` chooses between them. Kept is what
//! is cheapest on a core: packed words where there are DSP instructions, one block after the other where there are none.

mod count_gms;
mod curves;
mod dsp;
mod packed;
mod product;
mod quantised;
mod scaled;
mod slip_reserve;
#[cfg(test)]
mod tests;

pub use count_gms::{CountGms, CountGmsState};
pub use packed::{PackedSlipReserve, PackedState};
pub use scaled::{Kernel, Scaled, ScaledState};
pub use slip_reserve::{SlipReserve, SlipReserveState};

/// A whole number of the model's units: encoder counts, or steps of force.
pub type Whole = fixed::types::I32F0;
