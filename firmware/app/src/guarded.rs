//! What an axis may have beside its bridge: limit switches, and a brake that holds it while it is off.

use crate::{Bridge, Limits};
use embedded_hal::digital::{InputPin, OutputPin};

/// A bridge with limit switches and a brake, by the pins of embedded-hal.
///
/// Everything is wired so that a broken wire is safe: a switch opens at the end of travel and its input, pulled up, is then high; the brake
/// holds by its spring and is released by a high output.
pub struct Guarded<B, Low, High, Brake> {
    bridge: B,
    low: Low,
    high: High,
    brake: Brake,
    delays: [u32; 2],
}

impl<B, Low, High, Brake> Guarded<B, Low, High, Brake> {
    /// `delays` are the ticks that the brake takes to be released and to hold ([`crate::Board::brake`]).
    pub fn new(bridge: B, switches: (Low, High), brake: Brake, delays: [u32; 2]) -> Self {
        Self {
            bridge,
            low: switches.0,
            high: switches.1,
            brake,
            delays,
        }
    }
}

impl<B: Bridge, Low: InputPin, High: InputPin, Brake: OutputPin> Bridge
    for Guarded<B, Low, High, Brake>
{
    const GUARDED: bool = true;

    #[inline]
    fn drive(&mut self, code: i32) {
        self.bridge.drive(code);
    }

    #[inline]
    fn open(&mut self) {
        self.bridge.open();
    }

    #[inline]
    fn is_broken(&mut self) -> bool {
        self.bridge.is_broken()
    }

    #[inline]
    fn limits(&mut self) -> Limits {
        // An input that cannot be read is a wire that is broken.
        Limits {
            low: self.low.is_high().unwrap_or(true),
            high: self.high.is_high().unwrap_or(true),
        }
    }

    fn release_brake(&mut self, released: bool) {
        // An output that fails leaves a brake that holds, or one that the next tick tries to set again.
        let _ = self.brake.set_state(released.into());
    }

    fn brake_delays(&self) -> [u32; 2] {
        self.delays
    }
}
