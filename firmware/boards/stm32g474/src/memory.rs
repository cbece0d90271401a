//! The last two pages of flash, for parameters. The code runs from the other bank, so it goes on while these are written.

#![allow(unsafe_code)]

use embassy_stm32::pac;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use preslide_app::Parameters;
use preslide_store::Slots;

/// Where they are; `memory.x` leaves them out of FLASH. Pages 126 and 127 of bank 2.
const BASE: usize = 0x0807_F000;
const FIRST_PAGE: u32 = 126;
const PAGE: usize = 2048;

/// Keys that unlock the flash (RM0440, FLASH_KEYR).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

/// Both pages.
pub struct Pages(());

/// The slots; `None` where the option bytes make one bank of the flash: its pages are then others, and the code would stand still.
pub fn slots() -> Option<Slots<Pages>> {
    let two_banks = pac::FLASH.optr().read().dbank();
    let slots = || {
        Slots::new(
            Pages(()),
            [0, PAGE as u32],
            PAGE as u32,
            Parameters::VERSION,
        )
    };
    two_banks.then(slots).flatten()
}

/// Waits for the end of an operation; whether it went well.
fn settle() -> Result<(), NorFlashErrorKind> {
    while pac::FLASH.sr().read().bsy() {}
    let status = pac::FLASH.sr().read();
    // Flags are cleared by writing them back.
    pac::FLASH.sr().write_value(status);
    let wrong = status.progerr()
        || status.wrperr()
        || status.pgaerr()
        || status.sizerr()
        || status.pgserr();
    if wrong {
        Err(NorFlashErrorKind::Other)
    } else {
        Ok(())
    }
}

/// Does something to the flash between unlocking and locking it.
fn unlocked(act: impl FnOnce() -> Result<(), NorFlashErrorKind>) -> Result<(), NorFlashErrorKind> {
    if pac::FLASH.cr().read().lock() {
        for key in KEYS {
            pac::FLASH.keyr().write_value(key);
        }
    }
    let done = settle().or(Ok(())).and_then(|()| act());
    pac::FLASH.cr().modify(|w| {
        w.set_pg(false);
        w.set_per(false);
        w.set_lock(true);
    });
    done
}

impl ErrorType for Pages {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let from = offset as usize;
        if from + bytes.len() > self.capacity() {
            return Err(NorFlashErrorKind::OutOfBounds);
        }
        for (at, byte) in (BASE + from..).zip(bytes) {
            // Safety: within the two pages, by the check above.
            *byte = unsafe { (at as *const u8).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * PAGE
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let pages = from / PAGE as u32..to / PAGE as u32;
        if pages.end > 2 {
            return Err(NorFlashErrorKind::OutOfBounds);
        }
        unlocked(|| {
            for page in pages {
                pac::FLASH.cr().modify(|w| {
                    w.set_per(true);
                    w.set_bker(true);
                    w.set_pnb((FIRST_PAGE + page) as u8);
                });
                pac::FLASH.cr().modify(|w| w.set_strt(true));
                settle()?;
            }
            Ok(())
        })
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let from = offset as usize;
        if from + bytes.len() > self.capacity() {
            return Err(NorFlashErrorKind::OutOfBounds);
        }
        unlocked(|| {
            pac::FLASH.cr().modify(|w| w.set_pg(true));
            let (words, _) = bytes.as_chunks::<8>();
            for (at, word) in (BASE + from..).step_by(8).zip(words) {
                let [a, b, c, d, e, f, g, h] = *word;
                // Safety: within the two pages, by the check above, and aligned. Two words make a double word, which is what
                // the flash is programmed in.
                unsafe {
                    (at as *mut u32).write_volatile(u32::from_le_bytes([a, b, c, d]));
                    ((at + 4) as *mut u32).write_volatile(u32::from_le_bytes([e, f, g, h]));
                }
                settle()?;
            }
            Ok(())
        })
    }
}
