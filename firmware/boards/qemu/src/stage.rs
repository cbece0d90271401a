//! The stage link: counter, ADC and PWM as registers that a simulator on the host keeps.

use crate::registers::HostFile;
use core::sync::atomic::{AtomicBool, AtomicI16, Ordering};
use preslide_app::Bridge;
use preslide_link::{Exchange, Order, Reading};

static CODE: AtomicI16 = AtomicI16::new(0);
static DRIVEN: AtomicBool = AtomicBool::new(false);

/// The bridge: what it holds is sent with the next exchange.
pub struct StageBridge;

impl Bridge for StageBridge {
    #[inline]
    fn drive(&mut self, code: i32) {
        // Within ± the limiter's, which is at most 32000.
        CODE.store(code as i16, Ordering::Relaxed);
        DRIVEN.store(true, Ordering::Relaxed);
    }

    #[inline]
    fn open(&mut self) {
        off();
    }

    fn is_broken(&mut self) -> bool {
        false
    }
}

/// Opens the bridge, from wherever.
pub fn off() {
    CODE.store(0, Ordering::Relaxed);
    DRIVEN.store(false, Ordering::Relaxed);
}

/// The next run of the outer task is to take longer than its sample.
#[cfg(outer_task)]
static OUTLAST: AtomicBool = AtomicBool::new(false);

/// Has it do so.
#[cfg(outer_task)]
pub fn outlast(does: bool) {
    if does {
        OUTLAST.store(true, Ordering::Relaxed);
    }
}

/// Whether the run that begins is that one.
#[cfg(outer_task)]
pub fn outlasts() -> bool {
    OUTLAST.swap(false, Ordering::Relaxed)
}

/// Sends what the bridge holds and waits for what the registers show after the stage has moved on by a tick.
///
/// The emulator stands still meanwhile: neither the controller's time nor the watchdog sees how long the simulator takes.
pub fn exchange() -> Reading {
    let order = Order {
        code: CODE.load(Ordering::Relaxed),
        driven: DRIVEN.load(Ordering::Relaxed),
    };
    HostFile::OUTPUT.write(&order.to_bytes());
    let mut bytes = [0; 14];
    if HostFile::INPUT.read(&mut bytes) {
        Reading::from_bytes(bytes)
    } else {
        // The simulator is gone.
        Reading {
            quit: true,
            ..Reading::default()
        }
    }
}
