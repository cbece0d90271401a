//! An encoder that moves at a rational number of counts per tick: its readings are exact.

/// `counts/ticks` counts per tick, starting `phase/ticks` of a count past an edge.
#[derive(Clone, Copy, Debug)]
pub struct SteadyMotion {
    /// Counts travelled in [`SteadyMotion::ticks`] ticks; negative backwards.
    pub counts: i64,
    /// Ticks that they take.
    pub ticks: i64,
    /// Position at tick 0 in parts of a count, `0..ticks`.
    pub phase: i64,
}

impl SteadyMotion {
    /// Count that the encoder shows at the end of a tick: `⌊(counts·tick + phase)/ticks⌋`.
    pub fn reading(&self, tick: i64) -> i64 {
        (self.counts * tick + self.phase).div_euclid(self.ticks)
    }

    /// True velocity (counts per tick).
    pub fn velocity(&self) -> f64 {
        self.counts as f64 / self.ticks as f64
    }
}
