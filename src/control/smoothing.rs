//! The moving average that makes corners of velocity into S-curves.

/// Longest smoothing (ticks), and its `n`.
pub const MOST_SMOOTHED: u32 = 1 << LARGEST;
const LARGEST: u32 = 8;

/// Places of the ring that are cleared at a time: all of it at once would be the longest tick by far.
pub(super) const CLEARED: u32 = 16;

/// The mean of the last `2ⁿ` positions.
///
/// Averaging keeps every bound: positions stay between the outermost ones, speed and acceleration are means of speeds and
/// accelerations. And it bounds the jerk: with acceleration within ±A, the mean's changes by at most `2·A/2ⁿ` a tick. So what
/// feeds it needs to limit acceleration only, which it can do from one tick to the next, stop included.
///
/// What the division by `2ⁿ` leaves over is carried, so nothing is lost: once the input stands, the output ends exactly there.
///
/// Speeds come *lifted*, times `2⁸⁻ⁿ`: then the division is by 2⁸ whatever `n`, a shift of two words by a constant, which takes a
/// third of the instructions of one by a number in memory.
// In this order, so that the ring does not push what every tick reads out of the reach of a load.
#[derive(Clone, Debug, PartialEq)]
#[repr(C)]
pub(super) struct Smoothing {
    /// Place in the ring, which has `mask + 1` of them.
    at: u32,
    mask: u32,
    /// `8 − n`, and `2¹⁶` less so many bits.
    lift: u32,
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
        let bits = bits.min(LARGEST);
        Self {
            at: 0,
            mask: (1 << bits) - 1,
            lift: LARGEST - bits,
            part: 1 << (16 - LARGEST + bits),
            left: 0,
            rest: 0,
            sum: 0,
            clear: MOST_SMOOTHED,
            speeds: [0; MOST_SMOOTHED as usize],
        }
    }

    /// As [`Smoothing::at_rest`], in place; the ring is left to [`Smoothing::clear_ahead`].
    pub(super) fn rest(&mut self, bits: u32) {
        let bits = bits.min(LARGEST);
        self.at = 0;
        self.mask = (1 << bits) - 1;
        self.lift = LARGEST - bits;
        self.part = 1 << (16 - LARGEST + bits);
        self.left = 0;
        self.rest = 0;
        self.sum = 0;
        self.clear = 0;
    }

    /// Becomes as another one, whose ring is copied as far as it is used.
    pub(super) fn become_as(&mut self, other: &Self) {
        let Self {
            at,
            mask,
            lift,
            part,
            left,
            rest,
            sum,
            clear,
            speeds: _,
        } = *other;
        (self.at, self.mask, self.lift, self.part) = (at, mask, lift, part);
        (self.left, self.rest, self.sum, self.clear) = (left, rest, sum, clear);
        let used = mask as usize + 1;
        let places = self.speeds.iter_mut().zip(&other.speeds).take(used);
        for (to, from) in places {
            *to = *from;
        }
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

    /// The smoothed speed is 0.
    #[inline]
    pub(super) fn is_at_rest(&self) -> bool {
        self.sum == 0
    }

    /// By how many bits speeds are to be lifted.
    #[inline]
    pub(super) fn lift(&self) -> u32 {
        self.lift & 15
    }

    /// Takes the lifted speed of a tick; the smoothed one, and its change (2⁻¹⁶ counts per tick²) times `2ⁿ`.
    #[inline]
    pub(super) fn step(&mut self, speed: i64) -> (i64, i32) {
        let place = (self.at & (MOST_SMOOTHED - 1)) as usize;
        self.at = (self.at + 1) & self.mask;
        let oldest = core::mem::replace(&mut self.speeds[place], speed);
        let change = speed.wrapping_sub(oldest);
        self.sum = self.sum.wrapping_add(change);
        let whole = self.sum.wrapping_add(self.rest.into());
        self.rest = whole as u32 & (MOST_SMOOTHED - 1);
        // The change let down again and its lowest 16 bits left out: a shift by a number in memory, as the upper words of products.
        let (low, high) = (change as u32, (change >> 32) as u32);
        let below = (u64::from(low) * u64::from(self.part)) >> 32;
        let change = (below as u32).wrapping_add(high.wrapping_mul(self.part));
        (whole >> LARGEST, change.cast_signed())
    }
}
