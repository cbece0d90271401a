//! What `axis.toml` says of a board's bridge and converters.

use crate::Scales;

/// The board's table in `axis.toml`, as its build writes it (`preslide_build::axis`).
#[derive(Clone, Copy, Debug)]
pub struct Board {
    /// Neither gate of a half bridge is on for so long after each edge (s).
    pub dead_time: f64,
    /// Forward voltage of the diodes (V).
    pub diode_drop: f64,
    /// Supply at the converter's full scale (V).
    pub supply_full: f64,
    /// Current from end to end of the converter's scale (A).
    pub current_span: f64,
    /// Time (s) that the holding brake takes to be released; 0 without one.
    pub brake_release: f64,
    /// Time (s) that it takes to hold.
    pub brake_set: f64,
}

impl Board {
    /// The scales of both inputs.
    pub const fn scales(&self) -> Scales {
        Scales::new(self.supply_full, self.current_span)
    }

    /// Whole ticks at `rate_hz` that the brake takes to be released, and to hold.
    pub const fn brake(&self, rate_hz: u32) -> [u32; 2] {
        // `as` saturates, at 59 hours of 20 kHz.
        [
            (self.brake_release * rate_hz as f64 + 0.999) as u32,
            (self.brake_set * rate_hz as f64 + 0.999) as u32,
        ]
    }
}
