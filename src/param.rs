//! Parameters as people give them (SI, `f64`) and the errors that refuse them.

use crate::Scalar;
use core::fmt;

/// One Maxwell-slip block: the paper's `k_i` and `α_i` (eqs. 7–9, Table 3).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Block {
    /// Stiffness `k_i` (N/m), or (N·m/rad) on a rotary axis.
    pub stiffness: f64,
    /// Weight `α_i` (-): the block's share of the breakaway force. The weights of a model sum to 1.
    pub weight: f64,
}

impl Block {
    /// Yield displacement `D_i = α_i·F_s/k_i` (m) for the breakaway force `F_s` (N) (eq. 9 solved for `D_i`).
    pub fn yield_displacement(&self, breakaway: f64) -> f64 {
        self.weight * breakaway / self.stiffness
    }
}

/// What one unit of a model's displacement, force and velocity is in SI.
///
/// Floats usually run in SI ([`Units::SI`]). Fixed point has a narrow range, so let a displacement of 1 be
/// one encoder count and a force of 1 be a millinewton:
///
/// ```
/// use preslide::Units;
/// let counts = Units { length: 25e-9, force: 1e-3, velocity: 1e-3 };
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Units {
    /// Displacement unit (m or rad).
    pub length: f64,
    /// Force unit (N or N·m).
    pub force: f64,
    /// Velocity unit (m/s or rad/s).
    pub velocity: f64,
}

impl Units {
    /// Metres, newtons, metres per second (radians, newton-metres, radians per second on a rotary axis).
    pub const SI: Units = Units {
        length: 1.0,
        force: 1.0,
        velocity: 1.0,
    };

    pub(crate) fn check(&self) -> Result<(), ParamError> {
        positive("unit of length", self.length)?;
        positive("unit of force", self.force)?;
        positive("unit of velocity", self.velocity)?;
        Ok(())
    }
}

impl Default for Units {
    fn default() -> Self {
        Self::SI
    }
}

/// How far the weights of a model may be from summing to 1. Table 3 prints three digits, so a column of ten
/// may be off by 10 × 0.0005. Models use the weights as given, they are not rescaled.
pub const WEIGHT_SUM_TOLERANCE: f64 = 0.005;

/// A parameter that cannot be used: which one, its value, and the bound it broke.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ParamError {
    /// The parameter in the field's words ("stiffness", "weight", …).
    pub parameter: &'static str,
    /// The Maxwell-slip block it belongs to, counted from 1 as in the paper.
    pub block: Option<usize>,
    /// The value that was given (SI), or the computed one where a bound on a result was broken.
    pub value: f64,
    /// What it should have been.
    pub bound: Bound,
}

/// The bound that a parameter broke.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Bound {
    /// Must be finite and above zero.
    Positive,
    /// Must be finite and zero or above.
    NotNegative,
    /// Must not exceed this.
    AtMost(f64),
    /// Must be at least this.
    AtLeast(f64),
    /// All of them together must sum to 1 within [`WEIGHT_SUM_TOLERANCE`].
    SumToOne,
    /// Does not fit the number type in the chosen [`Units`]: its largest value.
    Representable(f64),
    /// Rounds to zero in the chosen [`Units`]: the number type is too coarse.
    Resolvable,
    /// Is held as this other value, more than a hundredth off: the number type is too coarse in the chosen [`Units`].
    Rounded(f64),
    /// A limit that nothing exceeds, since what is compared with it ends here: its fault would never come.
    Reachable(f64),
}

impl ParamError {
    /// That `parameter`, which is no block's, is `value` (SI) and breaks `bound`: for the `try_new` of a model or an effect of your own.
    pub const fn new(parameter: &'static str, value: f64, bound: Bound) -> Self {
        Self {
            parameter,
            block: None,
            value,
            bound,
        }
    }

    /// The same of block `index`, counted from 0.
    pub(crate) fn of_block(self, index: usize) -> Self {
        Self {
            block: Some(index + 1),
            ..self
        }
    }
}

impl fmt::Display for ParamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.parameter)?;
        if let Some(block) = self.block {
            write!(f, " of block {block}")?;
        }
        write!(f, " is {}", self.value)?;
        match self.bound {
            Bound::Positive => write!(f, ": it must be finite and above zero"),
            Bound::NotNegative => write!(f, ": it must be finite and not negative"),
            Bound::AtMost(limit) => write!(f, ": it must be at most {limit}"),
            Bound::AtLeast(limit) => write!(f, ": it must be at least {limit}"),
            Bound::SumToOne => write!(
                f,
                ": the weights must sum to 1 within {WEIGHT_SUM_TOLERANCE}"
            ),
            Bound::Representable(limit) => write!(
                f,
                ": the number type holds at most {limit} in the chosen units; choose larger units or a wider type"
            ),
            Bound::Resolvable => write!(
                f,
                ": it rounds to zero in the number type; choose smaller units or a finer type"
            ),
            Bound::Rounded(held) => write!(
                f,
                ": the number type holds it as {held}, more than 1 % off; choose smaller units or a finer type"
            ),
            Bound::Reachable(most) => write!(
                f,
                ": it must be below {most}, which is all that can be measured or computed here, or it would never act"
            ),
        }
    }
}

impl core::error::Error for ParamError {}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, ParamError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(ParamError::new(name, value, Bound::Positive))
    }
}

pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<f64, ParamError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(ParamError::new(name, value, Bound::NotNegative))
    }
}

pub(crate) fn at_most(name: &'static str, value: f64, limit: f64) -> Result<f64, ParamError> {
    if value <= limit {
        Ok(value)
    } else {
        Err(ParamError::new(name, value, Bound::AtMost(limit)))
    }
}

pub(crate) fn at_least(name: &'static str, value: f64, limit: f64) -> Result<f64, ParamError> {
    if value >= limit {
        Ok(value)
    } else {
        Err(ParamError::new(name, value, Bound::AtLeast(limit)))
    }
}

/// Converts a value in the model's units to its number type, refusing overflow.
pub(crate) fn nearest<S: Scalar>(name: &'static str, value: f64) -> Result<S, ParamError> {
    S::try_from_f64(value)
        .ok_or_else(|| ParamError::new(name, value, Bound::Representable(S::greatest())))
}

/// A parameter in the model's own [`Units`] as its number type: the nearest representable number. What the constructors of this crate
/// convert by, for those of your own.
///
/// ```
/// use preslide::{ParamError, Scalar, Units, to_scalar};
/// /// From N/m.
/// fn stiffness<S: Scalar>(si: f64, units: Units) -> Result<S, ParamError> {
///     to_scalar("stiffness", si * units.length / units.force)
/// }
/// let counts = Units { length: 25e-9, force: 1e-3, velocity: 1e-3 };
/// assert_eq!(stiffness(1e5, counts), Ok(2.5_f32));
/// assert_eq!(stiffness::<f32>(1e-50, counts).map_err(|e| e.bound), Err(preslide::Bound::Resolvable));
/// ```
///
/// # Errors
/// [`Bound::Representable`] where it lies outside the type's range or is not finite, [`Bound::Resolvable`] where it is not 0 and would
/// be held as 0; under the `name` given, with the value as it is given.
pub fn to_scalar<S: Scalar>(name: &'static str, value: f64) -> Result<S, ParamError> {
    let scalar: S = nearest(name, value)?;
    if value != 0.0 && scalar == S::ZERO {
        return Err(ParamError::new(name, value, Bound::Resolvable));
    }
    // −0 becomes 0, since limits are compared by their bits.
    Ok(scalar + S::ZERO)
}

/// The same for a gain, which is also refused where rounding would make more than a hundredth of it another one.
pub(crate) fn to_gain<S: Scalar>(name: &'static str, value: f64) -> Result<S, ParamError> {
    let scalar: S = to_scalar(name, value)?;
    let held = scalar.to_f64();
    if (held - value).abs() > 0.01 * value.abs() {
        return Err(ParamError::new(name, value, Bound::Rounded(held)));
    }
    Ok(scalar)
}

/// The same for a value that is positive, refusing also one that has already vanished in `f64`.
pub(crate) fn to_positive<S: Scalar>(name: &'static str, value: f64) -> Result<S, ParamError> {
    let scalar = to_scalar(name, value)?;
    if scalar > S::ZERO {
        Ok(scalar)
    } else {
        Err(ParamError::new(name, value, Bound::Resolvable))
    }
}

/// Refuses a bound on a run-time result that the number type could not hold.
pub(crate) fn fits<S: Scalar>(name: &'static str, value: f64) -> Result<(), ParamError> {
    if value.abs() <= S::greatest() {
        Ok(())
    } else {
        Err(ParamError::new(
            name,
            value,
            Bound::Representable(S::greatest()),
        ))
    }
}

/// Refuses a limit that nothing exceeds. `own` is the limit as it is compared, in units of `unit`; what it is compared with is at
/// most `most` of them.
pub(crate) fn reachable(
    name: &'static str,
    own: f64,
    most: f64,
    unit: f64,
) -> Result<f64, ParamError> {
    if own < most {
        Ok(own)
    } else {
        Err(ParamError::new(
            name,
            own * unit,
            Bound::Reachable(most * unit),
        ))
    }
}

/// The same for a time, as whole ticks of `sample_time` (s): what counts them ends at the largest `u32`.
pub(crate) fn reachable_ticks(
    name: &'static str,
    time: f64,
    sample_time: f64,
) -> Result<u32, ParamError> {
    let ticks = libm::ceil(time / sample_time);
    reachable(name, ticks, u32::MAX.into(), sample_time).map(|ticks| ticks as u32)
}

/// The magnitude of a result that was computed with saturation, refusing one at the range's end.
pub(crate) fn unsaturated<S: Scalar>(name: &'static str, result: S) -> Result<S, ParamError> {
    let magnitude = result.magnitude();
    if magnitude.to_f64() < S::greatest() {
        Ok(magnitude)
    } else {
        Err(ParamError::new(
            name,
            result.to_f64(),
            Bound::Representable(S::greatest()),
        ))
    }
}

/// Checks what every Maxwell-slip model is made of: finite and positive, weights that sum to 1.
pub(crate) fn check_blocks(
    blocks: &[Block],
    breakaway: f64,
    units: Units,
) -> Result<(), ParamError> {
    units.check()?;
    positive("breakaway force", breakaway)?;
    let mut sum = 0.0;
    for (i, block) in blocks.iter().enumerate() {
        let of_block = |e: ParamError| e.of_block(i);
        positive("stiffness", block.stiffness).map_err(of_block)?;
        positive("weight", block.weight).map_err(of_block)?;
        sum += block.weight;
    }
    if (sum - 1.0).abs() > WEIGHT_SUM_TOLERANCE {
        return Err(ParamError::new("sum of the weights", sum, Bound::SumToOne));
    }
    Ok(())
}
