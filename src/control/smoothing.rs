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
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Smoothing {
    /// Speeds of the last ticks, a ring.
    speeds: [i64; MOST_SMOOTHED as usize],
    at: u32,
    bits: u32,
    sum: i64,
    rest: i64,
    /// Ticks until the output stands.
    pub(super) left: u32,
}

impl Smoothing {
    /// Over `2^bits` ticks, at most [`MOST_SMOOTHED`].
    pub(super) fn at_rest(bits: u32) -> Self {
        Self {
            speeds: [0; MOST_SMOOTHED as usize],
            at: 0,
            bits,
            sum: 0,
            rest: 0,
            left: 0,
        }
    }

    /// Takes the speed of a tick; the smoothed one, and its change.
    #[inline]
    pub(super) fn step(&mut self, speed: i64) -> (i64, i64) {
        let length = 1_u32 << self.bits;
        let place = (self.at & (length - 1) & (MOST_SMOOTHED - 1)) as usize;
        self.at = self.at.wrapping_add(1);
        let oldest = core::mem::replace(&mut self.speeds[place], speed);
        let change = speed.wrapping_sub(oldest);
        self.sum = self.sum.wrapping_add(change);
        if speed != 0 {
            self.left = length;
        } else if self.left > 0 {
            self.left -= 1;
        }
        let whole = self.rest.wrapping_add(self.sum);
        let smooth = whole >> self.bits;
        // The bits that were shifted out.
        self.rest = whole & i64::from(length - 1);
        (smooth, change >> self.bits)
    }
}
