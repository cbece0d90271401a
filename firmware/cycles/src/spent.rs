//! Cycles by the core's own counter, on a board. QEMU has none: there the calls are recorded from outside.

use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::Peripherals;
use cortex_m::peripheral::DWT;

/// Cycles of many calls, without those of reading the counter.
pub struct Spent {
    sum: u64,
    calls: u32,
    pub worst: u32,
    reading: u32,
}

/// Switches the counter on, and interrupts off for good: nothing else is to be counted. Whether it counts.
pub fn start_counter() -> bool {
    cortex_m::interrupt::disable();
    if let Some(mut core) = Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
    between(|| cortex_m::asm::delay(10)).1 > 0
}

/// Cycles between two readings with `work` between them.
#[inline(always)]
fn between<R>(work: impl FnOnce() -> R) -> (R, u32) {
    let start = DWT::cycle_count();
    compiler_fence(Ordering::SeqCst);
    let result = work();
    compiler_fence(Ordering::SeqCst);
    (result, DWT::cycle_count().wrapping_sub(start))
}

impl Spent {
    pub fn new() -> Self {
        let reading = if cfg!(feature = "board") {
            between(|| ()).1
        } else {
            0
        };
        Self {
            sum: 0,
            calls: 0,
            worst: 0,
            reading,
        }
    }

    /// Does the work, and counts its cycles on a board.
    #[inline(always)]
    pub fn by<R>(&mut self, work: impl FnOnce() -> R) -> R {
        if !cfg!(feature = "board") {
            return work();
        }
        let (result, cycles) = between(work);
        let cycles = cycles.saturating_sub(self.reading);
        self.sum += u64::from(cycles);
        self.calls += 1;
        self.worst = self.worst.max(cycles);
        result
    }

    pub fn mean(&self) -> f64 {
        self.sum as f64 / f64::from(self.calls.max(1))
    }
}
