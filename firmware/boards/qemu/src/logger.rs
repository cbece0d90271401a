//! Frames of defmt on QEMU's standard error: the emulator stands still for each, so that a log moves no tick.

#![allow(unsafe_code)]

use crate::registers::HostFile;
use core::cell::UnsafeCell;
use critical_section::RestoreState;

#[defmt::global_logger]
struct Logger;

/// What a frame is made with, and the state of the interrupts before it.
struct Frame(UnsafeCell<(defmt::Encoder, RestoreState)>);

// Safety: it is touched between `acquire` and `release` only, in a critical section on one core.
unsafe impl Sync for Frame {}

static FRAME: Frame = Frame(UnsafeCell::new((
    defmt::Encoder::new(),
    RestoreState::invalid(),
)));

fn put(bytes: &[u8]) {
    HostFile::ERROR.write(bytes);
}

// Safety: `acquire` begins the critical section that `release` ends, and defmt calls the others in between.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // Safety: see above.
        unsafe {
            let before = critical_section::acquire();
            let (encoder, restore) = &mut *FRAME.0.get();
            *restore = before;
            encoder.start_frame(put);
        }
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // Safety: see above.
        unsafe {
            let (encoder, restore) = &mut *FRAME.0.get();
            encoder.end_frame(put);
            critical_section::release(*restore);
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // Safety: see above.
        unsafe { (*FRAME.0.get()).0.write(bytes, put) };
    }
}
