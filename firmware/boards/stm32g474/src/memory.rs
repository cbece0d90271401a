//! The last two pages of flash, for parameters. The code runs from the other bank, so it goes on while these are written.

#![allow(unsafe_code)]

use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m_rt::exception;
use embassy_stm32::pac;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use preslide_app::Parameters;
use preslide_stm32g4::tim1;
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

/// The pages are being read; and a double word was met there whose ECC finds two wrong bits or more.
static READING: AtomicBool = AtomicBool::new(false);
static TORN: AtomicBool = AtomicBool::new(false);

/// What a double ECC error comes as (RM0440, "Error code correction"). A cut of power while parameters are saved leaves such words, and
/// they stay until the page is erased: the read goes on, and its slot is no record. Anywhere else it is the program that is damaged,
/// and any other cause is none that this firmware sets up: the bridge opens, and the watchdog, where it runs, resets.
// Unsafe because it may interrupt anything: it takes no lock and shares only atomics and registers.
#[exception]
unsafe fn NonMaskableInt() {
    let found = pac::FLASH.eccr().read();
    if (found.eccd() || found.eccd2()) && READING.load(Ordering::Relaxed) {
        TORN.store(true, Ordering::Relaxed);
        // Flags are cleared by writing 1 to them.
        pac::FLASH.eccr().modify(|w| {
            w.set_eccd(true);
            w.set_eccd2(true);
        });
        return;
    }
    tim1::off();
    loop {
        cortex_m::asm::nop();
    }
}

/// Reads a byte of the pages; the error of its double word, if it has one, has come when this returns.
fn byte(address: usize) -> u8 {
    // Safety: every caller is in this module and passes an address within the two pages.
    let byte = unsafe { (address as *const u8).read_volatile() };
    cortex_m::asm::dsb();
    byte
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
    // The data cache would go on with what was there before (RM0440, "Flash main memory erase sequences"): it is off meanwhile, and
    // emptied, which only works while it is off.
    let cached = pac::FLASH.acr().read().dcen();
    pac::FLASH.acr().modify(|w| w.set_dcen(false));
    let done = settle().or(Ok(())).and_then(|()| act());
    pac::FLASH.cr().modify(|w| {
        w.set_pg(false);
        w.set_per(false);
        w.set_lock(true);
    });
    pac::FLASH.acr().modify(|w| w.set_dcrst(true));
    pac::FLASH.acr().modify(|w| w.set_dcrst(false));
    pac::FLASH.acr().modify(|w| w.set_dcen(cached));
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
        TORN.store(false, Ordering::Relaxed);
        READING.store(true, Ordering::SeqCst);
        for (at, place) in (BASE + from..).zip(bytes) {
            *place = byte(at);
        }
        READING.store(false, Ordering::SeqCst);
        if TORN.load(Ordering::Relaxed) {
            return Err(NorFlashErrorKind::Other);
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
