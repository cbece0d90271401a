//! A simulated stage and what is studied on it.
//!
//! The stage knows more physics than any model of the tool; the rig runs the firmware's own control code on it, on the host or in
//! an emulator; the chain goes from a recording of it to a diagnosis and back into the firmware. The user's tool needs none of
//! it but for `preslide demo` and `preslide reproduce`.

pub mod chain;
pub mod demo;
mod normal;
pub mod reproduce;
pub mod rig;
pub mod stage;
pub mod tracking;
