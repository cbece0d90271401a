//! What `xtask` and `cycles` stand on: how programs are run and installed, who compiles for a microcontroller, the firmware's
//! images and what is in them.

pub mod call_graph;
pub mod checked;
pub mod image;
pub mod need;
pub mod objdump;
pub mod process;
pub mod thumb;
