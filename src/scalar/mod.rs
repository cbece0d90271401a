//! The arithmetic a model runs in: `f32`, `f64`, or a binary fixed point number of the `fixed` crate.

mod arithmetic;
#[cfg(feature = "fixed")]
mod fixed_point;
mod floating;
#[cfg(all(test, feature = "fixed"))]
mod tests;

use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};

pub(crate) use arithmetic::Arithmetic;

/// A number that models compute in: what a model or an effect of your own needs of it, beside the operators.
///
/// Floats follow IEEE 754. Fixed point numbers use the plain operators only where construction has proved
/// that the result fits, and saturate where a quantity from outside enters ([`Scalar::add_input`],
/// [`Scalar::sub_input`], [`Scalar::mul_input`], [`Scalar::magnitude`]), so that no input can overflow.
///
/// It is sealed: `f32`, `f64`, and with the feature `fixed` every `FixedI32` and `FixedI64` are all that there are.
pub trait Scalar:
    Arithmetic
    + Copy
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

    /// An integer, saturating at the range's ends.
    fn from_int(value: i32) -> Self;

    /// The nearest integer, ties away from zero, saturating; NaN gives 0.
    fn round_to_int(self) -> i32;

    /// The nearest representable number, saturating at the range's ends; NaN gives 0 in fixed point.
    fn from_f32(value: f32) -> Self;

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
