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
}

impl Board {
    /// The scales of both inputs.
    pub const fn scales(&self) -> Scales {
        Scales::new(self.supply_full, self.current_span)
    }
}
