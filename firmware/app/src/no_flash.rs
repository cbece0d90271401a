//! The memory of a board that keeps nothing over a reset.

use core::convert::Infallible;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use preslide_store::Slots;

/// A flash that there is not: saving is refused.
pub enum NoFlash {}

impl NoFlash {
    /// What the background is to be polled with.
    pub const SLOTS: Option<Slots<Self>> = None;
}

impl ErrorType for NoFlash {
    type Error = Infallible;
}

impl ReadNorFlash for NoFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, _offset: u32, _bytes: &mut [u8]) -> Result<(), Infallible> {
        match *self {}
    }

    fn capacity(&self) -> usize {
        match *self {}
    }
}

impl NorFlash for NoFlash {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = 1;

    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), Infallible> {
        match *self {}
    }

    fn write(&mut self, _offset: u32, _bytes: &[u8]) -> Result<(), Infallible> {
        match *self {}
    }
}
