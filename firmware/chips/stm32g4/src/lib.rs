//! What boards with an STM32G4 share, whichever of them: the board's own dependency on `embassy-stm32` names the chip.

#![no_std]

pub mod clock;
mod reset;
pub mod tim1;

pub use reset::cause;
