//! The encoder, as a board has it.

/// A quadrature counter, which embedded-hal has no trait for.
pub trait CountEncoder {
    /// What it showed at the index pulse, once for each pulse, on the scale of the last [`CountEncoder::count`]; `None` without an index.
    /// Asked before the count.
    fn index(&mut self) -> Option<u32>;

    /// The count, which wraps; asked once a tick.
    fn count(&mut self) -> u32;
}

/// A counter of 16 bits, counted on: it is to come on by less than half its range from tick to tick.
#[derive(Clone, Copy, Debug)]
pub struct Widened {
    last: u16,
    count: u32,
}

impl Widened {
    /// With the counter at `reading`.
    pub const fn new(reading: u16) -> Self {
        Self {
            last: reading,
            count: reading as u32,
        }
    }

    /// The count where the counter showed `reading`.
    #[inline]
    pub const fn at(&self, reading: u16) -> u32 {
        let since = reading.wrapping_sub(self.last).cast_signed();
        self.count.wrapping_add_signed(since as i32)
    }

    /// Goes on to `reading`, and the count there.
    #[inline]
    pub const fn go_on(&mut self, reading: u16) -> u32 {
        self.count = self.at(reading);
        self.last = reading;
        self.count
    }
}
