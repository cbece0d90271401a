//! The arithmetic a model runs in: `f32`, `f64`, or a binary fixed point number of the `fixed` crate.

use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};
use fixed::types::extra::{LeEqU32, LeEqU64};
use fixed::{FixedI32, FixedI64};

/// The few operations that a friction model needs of a number.
///
/// Floats follow IEEE 754. Fixed point numbers use the plain operators only where construction has proved
/// that the result fits, and saturate where a quantity from outside enters ([`Scalar::add_input`],
/// [`Scalar::sub_input`], [`Scalar::mul_input`], [`Scalar::magnitude`], [`Scalar::opposite`]), so that no input can overflow.
pub trait Scalar:
    Copy
    + PartialOrd
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;

    /// The nearest representable number, or `None` where `value` is not finite or lies outside the range.
    fn try_from_f64(value: f64) -> Option<Self>;

    /// The value as `f64` (rounded for the widest fixed point types).
    fn to_f64(self) -> f64;

    /// The largest representable number.
    fn greatest() -> f64;

    /// `self + input`, saturating at the range's ends instead of wrapping.
    fn add_input(self, input: Self) -> Self;

    /// `self − input`, saturating at the range's ends instead of wrapping.
    fn sub_input(self, input: Self) -> Self;

    /// `self · input`, saturating at the range's ends.
    fn mul_input(self, input: Self) -> Self;

    /// Absolute value, saturating (the most negative fixed point number has no opposite).
    fn magnitude(self) -> Self;

    /// `−self`, saturating for the same reason.
    fn opposite(self) -> Self;

    /// `self` where `direction` is 1 and `−self`, saturating, where it is −1: a multiplication for floats, a choice for
    /// fixed point, whichever is cheaper.
    fn along(self, direction: Self) -> Self;

    /// `eˢᵉˡᶠ`. Fixed point goes through `libm`'s software `f32`: the same bits on every machine, and slow
    /// on a core without a float unit.
    fn exp(self) -> Self;

    /// `ln(1 + self)` for `self > −1`; see [`Scalar::exp`] for fixed point.
    fn ln_1p(self) -> Self;

    /// `selfᵖ` for `self ≥ 0`; see [`Scalar::exp`] for fixed point.
    fn powf(self, p: Self) -> Self;

    /// `ln(self)` for `self > 0`; see [`Scalar::exp`] for fixed point.
    fn ln(self) -> Self;

    /// `sin(self)`, in radians; see [`Scalar::exp`] for fixed point.
    fn sin(self) -> Self;

    /// `1/self` for `self > 0`, by [`Scalar::powf`]: for the models that are not meant for a control tick.
    #[inline]
    fn reciprocal(self) -> Self {
        self.powf(-Self::ONE)
    }

    /// The whole part of a number from +0 up to, not including, `end` (at most 2²⁴); `None` for any other, NaN too.
    fn whole_below(self, end: usize) -> Option<usize>;

    /// An integer, saturating at the range's ends.
    fn from_int(value: i32) -> Self;

    /// `value / 65536`, rounded down where the type is coarser, saturating at the range's ends.
    fn from_q16(value: i32) -> Self;

    /// What [`Scalar::of_q16`] is to be called on for multiples of `self`: for floats `self / 65536`, which saves them a product and, but
    /// for numbers below the normal ones, changes no bit; `self` for fixed point.
    #[inline]
    fn per_q16(self) -> Self {
        self
    }

    /// `unit · value / 65536`, where `self` is `unit.per_q16()`.
    #[inline]
    fn of_q16(self, value: i32) -> Self {
        Self::from_q16(value).mul_input(self)
    }

    /// The nearest integer, ties away from zero, saturating; NaN gives 0.
    fn round_to_int(self) -> i32;

    /// `self · 2^places` in 2⁻¹⁶, saturating; NaN gives 0. Floats give the nearest; fixed point is exact, but where it has more than 16
    /// bits of fraction, which is rounded down. `places` is at most 62.
    fn to_q16(self, places: u32) -> i32;

    /// `value · 2^-places`, which must fit, rounded down where the type is coarser. `places` is within ±62.
    fn from_binary(value: i32, places: i32) -> Self;

    /// `self · counts / ticks`, saturating, for what takes `counts` in a tick's place takes `ticks` (at least 1): floats divide in
    /// single precision; fixed point divides whole numbers, to the nearest if `|self · counts|` stays below 2¹⁵ (2³¹ for 64 bits),
    /// and beyond to a part `ticks · 2⁻³⁰` (`2⁻⁶²`) of the result.
    fn rate(self, counts: i32, ticks: u32) -> Self;

    /// `self` limited to ± `per_tick / ticks`, with `per_tick` positive: no division where it is well within.
    fn decayed(self, per_tick: Self, ticks: u32) -> Self;

    /// The nearest representable number, saturating at the range's ends; NaN gives 0 in fixed point.
    fn from_f32(value: f32) -> Self;

    /// `self / 2`.
    fn half(self) -> Self;

    /// `self` limited to `(-limit, limit)`, `limit ≥ 0`; NaN becomes one of the two, so that a poisoned input cannot stay in a
    /// state. Written with comparisons because `clamp` links a panic path and `max().min()` calls libm.
    #[inline]
    fn limited(self, limit: Self) -> Self {
        if self < limit {
            if self > -limit { self } else { -limit }
        } else {
            limit
        }
    }
}

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
            fn whole_below(self, end: usize) -> Option<usize> {
                // The bits of positive floats are in the floats' order, and those of NaN and of negative numbers above
                // them: one comparison of integers, which costs a Cortex-M4 half as much as one of floats.
                (self.to_bits() < (end as $t).to_bits()).then_some(self as usize)
            }
            #[inline]
            fn from_int(value: i32) -> Self {
                value as $t
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
            fn round_to_int(self) -> i32 {
                (if self < 0.0 { self - 0.5 } else { self + 0.5 }) as i32
            }
            #[inline]
            fn to_q16(self, places: u32) -> i32 {
                (self * power_of_two!($t, $bits, places.wrapping_add(16).cast_signed()))
                    .round_to_int()
            }
            #[inline]
            fn from_binary(value: i32, places: i32) -> Self {
                value as $t * power_of_two!($t, $bits, places.wrapping_neg())
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
            fn from_f32(value: f32) -> Self {
                value.into()
            }
            #[inline]
            fn half(self) -> Self {
                0.5 * self
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

/// A wide integer as a narrow one, at the range's ends instead of wrapping.
macro_rules! saturated {
    ($value:expr, $wide:ty, $narrow:ty) => {{
        let value: $wide = $value;
        let low = value as $narrow;
        if <$wide>::from(low) == value {
            low
        } else if value < 0 {
            <$narrow>::MIN
        } else {
            <$narrow>::MAX
        }
    }};
}
pub(crate) use saturated;

// Products, sums and shifts are made in the next wider integer and saturated once: the same bits as the operators of
// `fixed`, which look for an overflow in other ways that cost a Cortex-M4 three times as many instructions.
macro_rules! fixed_scalar {
    ($t:ident, $bound:ident, $bits:ty, $unsigned:ty, $wide:ty, $uwide:ty) => {
        impl<Frac: $bound + 'static> Scalar for $t<Frac> {
            const ZERO: Self = $t::ZERO;
            // A type with no room for 1 (`I0F32`) saturates here; every constructor then refuses it.
            const ONE: Self = if Frac::U32 < $t::<Frac>::MAX.to_bits().count_ones() {
                $t::from_bits(1 << Frac::U32)
            } else {
                $t::MAX
            };

            fn try_from_f64(value: f64) -> Option<Self> {
                if value.is_finite() {
                    $t::checked_from_num(value)
                } else {
                    None
                }
            }
            #[inline]
            fn to_f64(self) -> f64 {
                self.to_num()
            }
            fn greatest() -> f64 {
                $t::<Frac>::MAX.to_num()
            }
            #[inline]
            fn add_input(self, input: Self) -> Self {
                self.saturating_add(input)
            }
            #[inline]
            fn sub_input(self, input: Self) -> Self {
                self.saturating_sub(input)
            }
            #[inline]
            fn mul_input(self, input: Self) -> Self {
                let product = <$wide>::from(self.to_bits()) * <$wide>::from(input.to_bits());
                let narrow = (product >> Frac::U32) as $bits;
                // Compared in the upper word alone, where there is a fraction: three instructions less.
                let high = (product >> <$bits>::BITS) as $bits;
                let sign = high >> (<$bits>::BITS - 1);
                let fits = if Frac::U32 > 0 {
                    high >> (Frac::U32 - 1) == sign
                } else {
                    <$wide>::from(narrow) == product
                };
                $t::from_bits(if fits { narrow } else { sign ^ <$bits>::MAX })
            }
            #[inline]
            fn magnitude(self) -> Self {
                self.saturating_abs()
            }
            #[inline]
            fn opposite(self) -> Self {
                self.saturating_neg()
            }
            #[inline]
            fn along(self, direction: Self) -> Self {
                if direction < Self::ZERO {
                    self.saturating_neg()
                } else {
                    self
                }
            }
            fn exp(self) -> Self {
                Self::from_f32(libm::expf(self.to_num()))
            }
            fn ln_1p(self) -> Self {
                Self::from_f32(libm::log1pf(self.to_num()))
            }
            fn powf(self, p: Self) -> Self {
                Self::from_f32(libm::powf(self.to_num(), p.to_num()))
            }
            fn ln(self) -> Self {
                Self::from_f32(libm::logf(self.to_num()))
            }
            fn sin(self) -> Self {
                Self::from_f32(libm::sinf(self.to_num()))
            }
            #[inline]
            fn whole_below(self, end: usize) -> Option<usize> {
                let whole = self.to_bits().checked_shr(Frac::U32).unwrap_or(0); // no whole part in `I0F32`
                // A negative number becomes a large one.
                ((whole as u64) < end as u64).then_some(whole as usize)
            }
            #[inline]
            fn from_int(value: i32) -> Self {
                let scaled = <$wide>::from(value) << Frac::U32;
                $t::from_bits(saturated!(scaled, $wide, $bits))
            }
            #[inline]
            fn from_q16(value: i32) -> Self {
                let scaled = <$wide>::from(value) << Frac::U32 >> 16;
                $t::from_bits(saturated!(scaled, $wide, $bits))
            }
            #[inline]
            fn round_to_int(self) -> i32 {
                if Frac::U32 == 0 {
                    return saturated!(self.to_bits(), $bits, i32);
                }
                // A tie goes away from zero: down, where rounding halves up would take it up. A number without whole bits has no
                // room below its least one, which is a tie.
                let down = self.to_bits() >> (<$bits>::BITS - 1);
                let halves = self.to_bits().saturating_add(down) >> (Frac::U32 - 1);
                let rounded = (halves >> 1) + (halves & 1);
                let least = Frac::U32 == <$bits>::BITS && self == Self::MIN;
                saturated!(if least { -1 } else { rounded }, $bits, i32)
            }
            #[inline]
            fn to_q16(self, places: u32) -> i32 {
                let bits = self.to_bits();
                // Any bit at all is then beyond the range.
                let places = places.min(<$bits>::BITS - 1);
                if Frac::U32 == 16 && <$bits>::BITS == 32 {
                    // Without wide shifts, which a Cortex-M0+ has to call.
                    let scaled = bits << places;
                    let end = (bits >> (<$bits>::BITS - 1)) ^ <$bits>::MAX;
                    return (if scaled >> places == bits {
                        scaled
                    } else {
                        end
                    }) as i32;
                }
                let scaled = <$wide>::from(bits) << places;
                if Frac::U32 >= 16 {
                    saturated!(scaled >> (Frac::U32 - 16), $wide, i32)
                } else {
                    let narrow = saturated!(scaled, $wide, $bits);
                    saturated!(<$wide>::from(narrow) << (16 - Frac::U32), $wide, i32)
                }
            }
            #[inline]
            fn from_binary(value: i32, places: i32) -> Self {
                let right = places.wrapping_sub(Frac::U32.cast_signed());
                if right >= 0 {
                    return $t::from_bits((value >> right.min(31)).into());
                }
                // What fits is not shifted out, and a shift beyond the type's bits is one of 0.
                $t::from_bits(
                    <$bits>::from(value).wrapping_shl(right.wrapping_neg().cast_unsigned()),
                )
            }
            #[inline]
            fn rate(self, counts: i32, ticks: u32) -> Self {
                #[inline(never)]
                fn large(product: $wide, ticks: $unsigned) -> $bits {
                    let size = product.unsigned_abs();
                    // What the narrow type has no room for is left out and comes back as zeros.
                    let excess = (size >> (<$bits>::BITS - 1)) as $unsigned;
                    let shift = <$bits>::BITS - excess.leading_zeros();
                    let whole =
                        <$wide>::from(nearest((size >> shift) as $unsigned, ticks)) << shift;
                    saturated!(if product < 0 { -whole } else { whole }, $wide, $bits)
                }
                // Below the type's upper half, as is half of any number of ticks.
                fn nearest(size: $unsigned, ticks: $unsigned) -> $unsigned {
                    (size + ticks / 2).checked_div(ticks).unwrap_or(size)
                }
                let product = <$wide>::from(self.to_bits()) * <$wide>::from(counts);
                let (narrow, ticks) = (product as $bits, ticks as $unsigned);
                $t::from_bits(if <$wide>::from(narrow) != product {
                    large(product, ticks)
                } else {
                    let size = nearest(narrow.unsigned_abs(), ticks) as $bits;
                    if narrow < 0 {
                        size.wrapping_neg()
                    } else {
                        size
                    }
                })
            }
            #[inline]
            fn decayed(self, per_tick: Self, ticks: u32) -> Self {
                let path = <$wide>::from(self.to_bits()).unsigned_abs() * <$uwide>::from(ticks);
                if path <= <$wide>::from(per_tick.to_bits()).unsigned_abs() {
                    self
                } else {
                    self.limited(per_tick.rate(1, ticks))
                }
            }
            #[inline]
            fn from_f32(value: f32) -> Self {
                // Not `saturating_from_num`: it panics on NaN. Scaling by a power of two is exact, and `as`
                // saturates and takes NaN to 0.
                let scaled = value * f32::from_bits((127 + Frac::U32) << 23);
                // From here on every `f32` is an integer.
                const WHOLE: f32 = 8_388_608.0;
                let half = if scaled >= WHOLE || scaled <= -WHOLE {
                    0.0
                } else if scaled < 0.0 {
                    -0.5
                } else {
                    0.5
                };
                $t::from_bits((scaled + half) as _)
            }
            #[inline]
            fn half(self) -> Self {
                $t::from_bits(self.to_bits() >> 1)
            }
        }
    };
}

fixed_scalar!(FixedI32, LeEqU32, i32, u32, i64, u64);
fixed_scalar!(FixedI64, LeEqU64, i64, u64, i128, u128);

#[cfg(test)]
mod tests {
    use super::Scalar;
    use fixed::types::{I0F32, I16F16, I32F0, I32F32, I40F24, I64F64};
    use fixed::{FixedI32, types::extra::U16};

    #[test]
    fn the_whole_part_is_given_inside_the_range_only() {
        let floats = [
            (0.0, Some(0)),
            (63.99, Some(63)),
            (64.0, None),
            (-0.5, None),
        ];
        for (value, whole) in floats {
            assert_eq!((value as f32).whole_below(64), whole, "{value}");
            assert_eq!(value.whole_below(64), whole, "{value}");
            assert_eq!(I16F16::from_num(value).whole_below(64), whole, "{value}");
        }
        for value in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(value.whole_below(64), None);
        }
        assert_eq!(I0F32::from_num(0.25).whole_below(64), Some(0));
    }

    #[test]
    fn a_direction_turns_the_sign_without_overflow() {
        assert_eq!(2.5_f32.along(-1.0), -2.5);
        assert_eq!(I16F16::MIN.along(-I16F16::ONE), I16F16::MAX);
        assert_eq!(I16F16::MIN.along(I16F16::ONE), I16F16::MIN);
    }

    #[test]
    fn a_part_of_a_unit_gives_floats_the_same_bits() {
        for unit in [25e-9, 5.0e-7, 1.1, 3e8] {
            for value in [0, 1, -1, 65_537, -123_456_789, i32::MIN, i32::MAX] {
                let (narrow, wide) = (unit as f32, unit);
                assert_eq!(
                    narrow.per_q16().of_q16(value),
                    f32::from_q16(value) * narrow
                );
                assert_eq!(wide.per_q16().of_q16(value), f64::from_q16(value) * wide);
            }
        }
    }

    /// Every pair of a few hundred bit patterns: the ends, powers of two and their neighbours, and a scatter between.
    #[test]
    fn fixed_point_gives_the_bits_of_the_fixed_crate() {
        let mut scatter = 1_u64;
        let patterns: [i64; 256] = core::array::from_fn(|i| {
            scatter = scatter
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            match i {
                0..192 => (1_i64 << (i / 3)).wrapping_add(i as i64 % 3 - 1),
                _ => scatter.cast_signed() >> (scatter % 64),
            }
        });
        macro_rules! compare {
            ($($t:ty),+) => {$(
                for &a in &patterns {
                    let x = <$t>::from_bits(a as _);
                    // In a wider type, because `fixed` cannot round up what lies above its last whole number.
                    let nearest = I64F64::from_num(x).saturating_round().saturating_to_num::<i32>();
                    assert_eq!(x.round_to_int(), nearest, "{x:?}");
                    let whole = a as i32;
                    assert_eq!(<$t>::from_int(whole), <$t>::saturating_from_num(whole), "{whole}");
                    let q16 = FixedI32::<U16>::from_bits(whole);
                    assert_eq!(<$t>::from_q16(whole), <$t>::saturating_from_num(q16), "{q16}");
                    let unit = <$t>::from_bits(0x5a5a);
                    assert_eq!(unit.per_q16().of_q16(whole), <$t>::from_q16(whole).mul_input(unit), "{q16}");
                    for &b in &patterns {
                        let y = <$t>::from_bits(b as _);
                        assert_eq!(x.mul_input(y), x.saturating_mul(y), "{x:?} {y:?}");
                    }
                }
            )+};
        }
        compare!(I16F16, I0F32, I32F0, I32F32, I40F24);
    }
}
