//! What the library itself asks of a number, and what seals [`Scalar`](super::Scalar).

/// Operations that only this crate's models and its control task take; it may change with any release.
pub trait Arithmetic: Sized {
    /// `−self`, saturating: the most negative fixed point number has no opposite.
    fn opposite(self) -> Self;

    /// `self` where `direction` is 1 and `−self`, saturating, where it is −1: a multiplication for floats, a choice for
    /// fixed point, whichever is cheaper.
    fn along(self, direction: Self) -> Self;

    /// `eˢᵉˡᶠ`. Fixed point goes through `libm`'s software `f32`: the same bits on every machine, and slow
    /// on a core without a float unit.
    fn exp(self) -> Self;

    /// `ln(1 + self)` for `self > −1`; see [`Arithmetic::exp`] for fixed point.
    fn ln_1p(self) -> Self;

    /// `selfᵖ` for `self ≥ 0`; see [`Arithmetic::exp`] for fixed point.
    fn powf(self, p: Self) -> Self;

    /// `ln(self)` for `self > 0`; see [`Arithmetic::exp`] for fixed point.
    fn ln(self) -> Self;

    /// `sin(self)`, in radians; see [`Arithmetic::exp`] for fixed point.
    fn sin(self) -> Self;

    /// `1/self` for `self > 0`, by [`Arithmetic::powf`]: for the models that are not meant for a control tick.
    fn reciprocal(self) -> Self;

    /// The whole part of a number from +0 up to, not including, `end` (at most 2²⁴); `None` for any other, NaN too.
    fn whole_below(self, end: usize) -> Option<usize>;

    /// `value / 65536`, rounded down where the type is coarser, saturating at the range's ends.
    fn from_q16(value: i32) -> Self;

    /// What [`Arithmetic::of_q16`] is to be called on for multiples of `self`: for floats `self / 65536`, which saves them a product and, but
    /// for numbers below the normal ones, changes no bit; `self` for fixed point.
    fn per_q16(self) -> Self;

    /// `unit · value / 65536`, where `self` is `unit.per_q16()`.
    fn of_q16(self, value: i32) -> Self;

    /// `self · 2^places` in 2⁻¹⁶, saturating; NaN gives 0. Floats give the nearest; fixed point is exact, but where it has more than 16
    /// bits of fraction, which is rounded down. `places` is at most 62.
    fn to_q16(self, places: u32) -> i32;

    /// A power of two as a tick takes it: floats multiply by it, fixed point shifts.
    type Scaling: Copy + core::fmt::Debug + PartialEq + Send + 'static;

    /// Most binary places of [`Arithmetic::finer`].
    const MOST_PLACES: u32;

    /// For [`Arithmetic::to_path`]: units that are `2^places` times finer.
    fn finer(places: u32) -> Self::Scaling;

    /// Binary places that [`Arithmetic::to_path`] has beyond the units, 1 to 16.
    fn beyond(finer: Self::Scaling) -> u32;

    /// `self` in the finer units, with so many places beyond, saturating; NaN gives 0. Floats are rounded towards 0, and fixed point down
    /// where it has more places.
    fn to_path(self, finer: Self::Scaling) -> i32;

    /// For [`Arithmetic::from_whole`]: units that are `2^places` times coarser, within ±62.
    fn coarser(places: i32) -> Self::Scaling;

    /// `value` in the coarser units, which must fit, rounded down where the type is coarser.
    fn from_whole(value: i32, coarser: Self::Scaling) -> Self;

    /// `self · counts / ticks`, saturating, for what takes `counts` in a tick's place takes `ticks` (at least 1): floats divide in
    /// single precision; fixed point divides whole numbers, to the nearest if `|self · counts|` stays below 2¹⁵ (2³¹ for 64 bits),
    /// and beyond to a part `ticks · 2⁻³⁰` (`2⁻⁶²`) of the result.
    fn rate(self, counts: i32, ticks: u32) -> Self;

    /// `self` limited to ± `per_tick / ticks`, with `per_tick` positive: no division where it is well within.
    fn decayed(self, per_tick: Self, ticks: u32) -> Self;

    /// `self / 2`.
    fn half(self) -> Self;
}
