//! What runs in QEMU: the firmware against the simulated stage, through the whole chain and as the book commissions it, and the
//! examples.

pub mod chain;
mod commission;
pub mod example;
pub mod example_riscv;
mod logged;
pub mod qemu;
