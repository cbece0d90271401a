//! The moving average that makes corners of velocity into S-curves.

/// Longest smoothing (ticks).
pub const MOST_SMOOTHED: u32 = 256;

/// Places of the ring that are cleared at a time: all of it at once would be the longest tick by far.
pub(super) const CLEARED: u32 = 16;

/// The mean of the last `2ⁿ` positions.
///
/// Averaging keeps every bound: positions stay between the outermost ones, speed and acceleration are means of speeds and
/// accelerations. And it bounds the jerk: with acceleration within ±A, the mean's changes by at most `2·A/2ⁿ` a tick. So what
/// feeds it needs to limit acceleration only, which it can do from one tick to the next, stop included.
///
/// What the division by `2ⁿ` leaves over is carried, so nothing is lost: once the input stands, the output ends exactly there.
// In this order, so that the ring does not push what every tick reads out of the reach of a load.
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub(super) struct Smoothing {
    /// Place in the ring, which has `mask + 1` of them.
    at: u32,
    mask: u32,
    /// `2ⁿ = mask + 1`, and `2³²⁻ⁿ`.
    bits: u32,
    part: u32,
    /// Ticks until the output stands.
    pub(super) left: u32,
    rest: u32,
    sum: i64,
    /// Places of the ring, from its first on, that hold nothing from before the last rest.
    clear: u32,
    /// Speeds of the last ticks, a ring.
    speeds: [i64; MOST_SMOOTHED as usize],
}

impl Smoothing {
    /// Over `2^bits` ticks, 2 to [`MOST_SMOOTHED`].
    pub(super) fn at_rest(bits: u32) -> Self {
        let bits = bits & 31;
        Self {
            at: 0,
            mask: (1 << bits) - 1,
            bits,
            part: 1 << ((32 - bits) & 31),
            left: 0,
            rest: 0,
            sum: 0,
            clear: MOST_SMOOTHED,
            speeds: [0; MOST_SMOOTHED as usize],
        }
    }

    /// As [`Smoothing::at_rest`], in place; the ring is left to [`Smoothing::clear_ahead`].
    pub(super) fn rest(&mut self, bits: u32) {
        let bits = bits & 31;
        self.at = 0;
        self.mask = (1 << bits) - 1;
        self.bits = bits;
        self.part = 1 << ((32 - bits) & 31);
        self.left = 0;
        self.rest = 0;
        self.sum = 0;
        self.clear = 0;
    }

    /// Clears the next places of the ring; for how many ticks that is enough, this one included, where some are left.
    ///
    /// Called again no later than that, it stays ahead of the ticks that read them.
    #[inline]
    pub(super) fn clear_ahead(&mut self) -> Option<u32> {
        if self.clear > self.mask {
            return None;
        }
        let from = (self.clear & (MOST_SMOOTHED - CLEARED)) as usize;
        for speed in self.speeds.iter_mut().skip(from).take(CLEARED as usize) {
            *speed = 0;
        }
        self.clear += CLEARED;
        Some(CLEARED)
    }

    /// Counts the ticks until the output stands; to be told of every tick at speed 0, and of the first at another.
    #[inline]
    pub(super) fn note(&mut self, speed: i64) {
        if speed != 0 {
            self.left = self.mask + 1;
        } else if self.left > 0 {
            self.left -= 1;
        }
    }

    /// Takes the speed of a tick; the smoothed one, and its change times `2^bits`.
    #[inline]
    pub(super) fn step(&mut self, speed: i64) -> (i64, i64) {
        let place = (self.at & (MOST_SMOOTHED - 1)) as usize;
        self.at = (self.at + 1) & self.mask;
        let oldest = core::mem::replace(&mut self.speeds[place], speed);
        let change = speed.wrapping_sub(oldest);
        self.sum = self.sum.wrapping_add(change);
        let whole = self.sum.wrapping_add(self.rest.into());
        // Word by word, and the lower one by products: a shift of both by any number of bits takes three times the instructions.
        let (low, high) = (whole as u32, (whole >> 32) as i32);
        self.rest = low & self.mask;
        let below = (u64::from(low) * u64::from(self.part)) >> 32;
        let below = (below as u32).wrapping_add(high.cast_unsigned().wrapping_mul(self.part));
        let above = high >> (self.bits & 31);
        ((i64::from(above) << 32) | i64::from(below), change)
    }
}
