//! `f32` and `f64`.

use super::{Arithmetic, Scalar};

/// `2^places`, a normal number, whose exponent is put together without a product.
macro_rules! power_of_two {
    ($t:ty, $bits:ty, $places:expr) => {
        <$t>::from_bits(
            (<$bits>::from($places.wrapping_add(<$t>::MAX_EXP - 1)) << (<$t>::MANTISSA_DIGITS - 1))
                as _,
        )
    };
}

macro_rules! float_scalar {
    ($t:ty, $bits:ty, $exp:path, $ln_1p:path, $pow:path, $ln:path, $sin:path) => {
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            #[inline]
            fn try_from_f64(value: f64) -> Option<Self> {
                let narrowed = value as $t;
                narrowed.is_finite().then_some(narrowed)
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            fn greatest() -> f64 {
                f64::from(<$t>::MAX)
            }
            #[inline]
            fn add_input(self, input: Self) -> Self {
                self + input
            }
            #[inline]
            fn sub_input(self, input: Self) -> Self {
                self - input
            }
            #[inline]
            fn mul_input(self, input: Self) -> Self {
                self * input
            }
            #[inline]
            fn magnitude(self) -> Self {
                self.abs()
            }
            #[inline]
            fn from_int(value: i32) -> Self {
                value as $t
            }
            #[inline]
            fn round_to_int(self) -> i32 {
                (if self < 0.0 { self - 0.5 } else { self + 0.5 }) as i32
            }
            #[inline]
            fn from_f32(value: f32) -> Self {
                value.into()
            }
            #[inline]
            fn limited(self, limit: Self) -> Self {
                // The bits of magnitudes are in the magnitudes' order, those of NaN above all: one comparison of integers and no
                // branch, where floats take two. It pays on a core with a float unit, and more on one without.
                let sign = self.to_bits() & (-0.0 as $t).to_bits();
                let (size, limit) = (self.to_bits() ^ sign, limit.to_bits());
                <$t>::from_bits(if size < limit { size } else { limit } | sign)
            }
        }

        impl Arithmetic for $t {
            #[inline]
            fn opposite(self) -> Self {
                -self
            }
            #[inline]
            fn along(self, direction: Self) -> Self {
                self * direction
            }
            #[inline]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline]
            fn ln_1p(self) -> Self {
                $ln_1p(self)
            }
            #[inline]
            fn powf(self, p: Self) -> Self {
                $pow(self, p)
            }
            #[inline]
            fn ln(self) -> Self {
                $ln(self)
            }
            #[inline]
            fn sin(self) -> Self {
                $sin(self)
            }
            #[inline]
            fn reciprocal(self) -> Self {
                self.powf(-Self::ONE)
            }
            #[inline]
            fn whole_below(self, end: usize) -> Option<usize> {
                // The bits of positive floats are in the floats' order, and those of NaN and of negative numbers above
                // them: one comparison of integers, which costs a Cortex-M4 half as much as one of floats.
                (self.to_bits() < (end as $t).to_bits()).then_some(self as usize)
            }
            #[inline]
            fn from_q16(value: i32) -> Self {
                value as $t / 65536.0
            }
            #[inline]
            fn per_q16(self) -> Self {
                self / 65536.0
            }
            #[inline]
            fn of_q16(self, value: i32) -> Self {
                value as $t * self
            }
            #[inline]
            fn to_q16(self, places: u32) -> i32 {
                (self * power_of_two!($t, $bits, places.wrapping_add(16).cast_signed()))
                    .round_to_int()
            }
            type Scaling = Self;
            const MOST_PLACES: u32 = 62;
            fn finer(places: u32) -> Self {
                power_of_two!($t, $bits, places.wrapping_add(16).cast_signed())
            }
            #[inline]
            fn beyond(_finer: Self) -> u32 {
                16
            }
            #[inline]
            fn to_path(self, finer: Self) -> i32 {
                (self * finer) as i32
            }
            fn coarser(places: i32) -> Self {
                power_of_two!($t, $bits, places.wrapping_neg())
            }
            #[inline]
            fn from_whole(value: i32, coarser: Self) -> Self {
                value as $t * coarser
            }
            #[inline]
            fn rate(self, counts: i32, ticks: u32) -> Self {
                (counts as f32 / ticks as f32 * self as f32).into()
            }
            #[inline]
            fn decayed(self, per_tick: Self, ticks: u32) -> Self {
                // One tick less than the limit: a part of it, which is more than what single precision rounds.
                if self.abs() * (ticks.wrapping_add(1) as $t) <= per_tick {
                    self
                } else {
                    self.limited(per_tick.rate(1, ticks))
                }
            }
            #[inline]
            fn half(self) -> Self {
                0.5 * self
            }
        }
    };
}

float_scalar!(
    f32,
    i32,
    libm::expf,
    libm::log1pf,
    libm::powf,
    libm::logf,
    libm::sinf
);
float_scalar!(
    f64,
    i64,
    libm::exp,
    libm::log1p,
    libm::pow,
    libm::log,
    libm::sin
);
