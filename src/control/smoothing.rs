//! The moving average that makes corners of velocity into S-curves.

/// Longest smoothing (ticks).
pub const MOST_SMOOTHED: u32 = 256;

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
    at: u32,
    bits: u32,
    /// Ticks of the ring that are filled; the rest stood still.
    filled: u32,
    /// Ticks until the output stands.
    pub(super) left: u32,
    sum: i64,
    rest: u32,
    /// Speeds of the last ticks, a ring.
    speeds: [i64; MOST_SMOOTHED as usize],
}

impl Smoothing {
    /// Over `2^bits` ticks, 2 to [`MOST_SMOOTHED`].
    pub(super) fn at_rest(bits: u32) -> Self {
        Self {
            at: 0,
            bits,
            filled: 0,
            left: 0,
            sum: 0,
            rest: 0,
            speeds: [0; MOST_SMOOTHED as usize],
        }
    }

    /// As [`Smoothing::at_rest`], in place: what the ring holds counts no more.
    pub(super) fn rest(&mut self, bits: u32) {
        self.bits = bits;
        self.filled = 0;
        self.left = 0;
        self.sum = 0;
        self.rest = 0;
    }

    /// Takes the speed of a tick; the smoothed one, and its change times `2^bits`.
    #[inline]
    pub(super) fn step(&mut self, speed: i64) -> (i64, i64) {
        let bits = self.bits & 31;
        let mask = (1_u32 << bits) - 1;
        let place = (self.at & mask & (MOST_SMOOTHED - 1)) as usize;
        self.at = self.at.wrapping_add(1);
        let mut oldest = core::mem::replace(&mut self.speeds[place], speed);
        if self.filled <= mask {
            self.filled += 1;
            oldest = 0;
        }
        let change = speed.wrapping_sub(oldest);
        self.sum = self.sum.wrapping_add(change);
        if speed != 0 {
            self.left = mask + 1;
        } else if self.left > 0 {
            self.left -= 1;
        }
        let whole = self.sum.wrapping_add(self.rest.into());
        self.rest = whole as u32 & mask;
        // Word by word: a shift of both by any number of bits takes twice the instructions.
        let (low, high) = (whole as u32, (whole >> 32) as i32);
        let low = (low >> bits) | (high.cast_unsigned() << ((32 - bits) & 31));
        ((i64::from(high >> bits) << 32) | i64::from(low), change)
    }
}
