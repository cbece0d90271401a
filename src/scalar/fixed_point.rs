//! The numbers of the `fixed` crate, of 32 and 64 bits.

use super::{Arithmetic, Scalar, saturated};
use fixed::types::extra::{LeEqU32, LeEqU64};
use fixed::{FixedI32, FixedI64};

/// Numbers of 32 bits with 16 of fraction, which need no wide shifts: a Cortex-M0+ has to call those.
const fn is_q16(fraction: u32, bits: u32) -> bool {
    fraction == 16 && bits == 32
}

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
            fn from_int(value: i32) -> Self {
                let scaled = <$wide>::from(value) << Frac::U32;
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
        }

        impl<Frac: $bound + 'static> Arithmetic for $t<Frac> {
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
            fn reciprocal(self) -> Self {
                self.powf(-Self::ONE)
            }
            #[inline]
            fn whole_below(self, end: usize) -> Option<usize> {
                let whole = self.to_bits().checked_shr(Frac::U32).unwrap_or(0); // no whole part in `I0F32`
                // A negative number becomes a large one.
                ((whole as u64) < end as u64).then_some(whole as usize)
            }
            #[inline]
            fn from_q16(value: i32) -> Self {
                let scaled = <$wide>::from(value) << Frac::U32 >> 16;
                $t::from_bits(saturated!(scaled, $wide, $bits))
            }
            #[inline]
            fn per_q16(self) -> Self {
                self
            }
            #[inline]
            fn of_q16(self, value: i32) -> Self {
                Self::from_q16(value).mul_input(self)
            }
            #[inline]
            fn to_q16(self, places: u32) -> i32 {
                let bits = self.to_bits();
                // Any bit at all is then beyond the range.
                let places = places.min(<$bits>::BITS - 1);
                if is_q16(Frac::U32, <$bits>::BITS) {
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
            type Scaling = i32;
            // One place beyond the units is left for their half.
            const MOST_PLACES: u32 = if is_q16(Frac::U32, <$bits>::BITS) {
                15
            } else {
                62
            };
            fn finer(places: u32) -> i32 {
                if is_q16(Frac::U32, <$bits>::BITS) {
                    16 - places.cast_signed()
                } else {
                    places.cast_signed()
                }
            }
            #[inline]
            fn beyond(finer: i32) -> u32 {
                if is_q16(Frac::U32, <$bits>::BITS) {
                    finer.cast_unsigned()
                } else {
                    16
                }
            }
            #[inline]
            fn to_path(self, finer: i32) -> i32 {
                if is_q16(Frac::U32, <$bits>::BITS) {
                    // As it is: the places beyond take the shift.
                    self.to_bits() as i32
                } else {
                    self.to_q16(finer.cast_unsigned())
                }
            }
            fn coarser(places: i32) -> i32 {
                places.wrapping_sub(Frac::U32.cast_signed()).min(31)
            }
            #[inline]
            fn from_whole(value: i32, coarser: i32) -> Self {
                $t::from_bits(if coarser >= 0 {
                    value.wrapping_shr(coarser.cast_unsigned()).into()
                } else {
                    // What fits is not shifted out, and a shift beyond the type's bits is one of 0.
                    <$bits>::from(value).wrapping_shl(coarser.wrapping_neg().cast_unsigned())
                })
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
            fn half(self) -> Self {
                $t::from_bits(self.to_bits() >> 1)
            }
        }
    };
}

fixed_scalar!(FixedI32, LeEqU32, i32, u32, i64, u64);
fixed_scalar!(FixedI64, LeEqU64, i64, u64, i128, u128);
