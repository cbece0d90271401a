//! Flash for two slots of parameters, kept in RAM: it lasts as long as the emulator does.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use preslide_app::Parameters;
use preslide_store::Slots;

/// A page of the STM32G4's flash.
const PAGE: usize = 2048;

/// Two pages.
pub struct Pages([u8; 2 * PAGE]);

impl Pages {
    /// Erased.
    pub const fn new() -> Self {
        Self([0xFF; 2 * PAGE])
    }

    fn range(&mut self, from: u32, length: usize) -> Result<&mut [u8], NorFlashErrorKind> {
        let from = from as usize;
        let range = self.0.get_mut(from..from + length);
        range.ok_or(NorFlashErrorKind::OutOfBounds)
    }
}

/// The slots in these pages.
pub fn slots(pages: &'static mut Pages) -> Option<Slots<&'static mut Pages>> {
    Slots::new(pages, [0, PAGE as u32], PAGE as u32, Parameters::VERSION)
}

impl ErrorType for &'static mut Pages {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for &'static mut Pages {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let range = self.range(offset, bytes.len())?;
        bytes.copy_from_slice(range);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for &'static mut Pages {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.range(from, (to - from) as usize)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        self.range(offset, bytes.len())?.copy_from_slice(bytes);
        Ok(())
    }
}
