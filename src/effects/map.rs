//! Maps over the travel: cosine series, `Σ_j c_j·cos(jπu)`, `u = (x − from)/(to − from)` held to 0…1.

use super::wave::{PRESCALE, cosine, precise, prescaled};
use super::{Bounds, Effect, LARGEST_LEVEL, Situation};
use crate::Scalar;
use crate::param::{ParamError, Units, at_most, fits, positive, to_scalar};

/// The series, by Clenshaw's recurrence: one cosine, and three operations a term.
#[derive(Clone, Debug, PartialEq)]
struct Series<const J: usize, S> {
    from: S,
    per_length: S,
    terms: [S; J],
    bound: S,
}

impl<const J: usize, S: Scalar> Series<J, S> {
    fn try_new(
        name: &'static str,
        from: f64,
        to: f64,
        terms: [f64; J],
        length: f64,
    ) -> Result<Self, ParamError> {
        const { assert!(J > 0, "a map needs at least one term") };
        positive("length of the mapped travel", to - from)?;
        fits::<S>("coefficients of the cosine", 82.0)?;
        let sum: f64 = terms.iter().map(|c| c.abs()).sum();
        // What the recurrence holds on the way.
        fits::<S>(name, 2.0 * (J as f64 + 1.0) * sum)?;
        let mut own = [S::ZERO; J];
        for (own, term) in own.iter_mut().zip(terms) {
            *own = to_scalar(name, term)?;
        }
        Ok(Self {
            from: to_scalar("start of the mapped travel", from / length)?,
            per_length: precise(
                "share of the mapped travel per unit",
                PRESCALE * length / (to - from),
                1e-2,
            )?,
            terms: own,
            bound: to_scalar(name, sum)?,
        })
    }

    #[inline]
    fn at(&self, position: S) -> S {
        let u = prescaled(position.sub_input(self.from)).mul_input(self.per_length);
        let u = if u > S::ZERO {
            u.limited(S::ONE)
        } else {
            S::ZERO
        };
        let c = cosine(u.half());
        let (mut one, mut two) = (S::ZERO, S::ZERO);
        for term in self.terms.iter().rev() {
            let next = *term + c * (one + one) - two;
            two = one;
            one = next;
        }
        (c * one - two).limited(self.bound)
    }
}

macro_rules! map {
    ($(#[$doc:meta])* $name:ident, $(#[$new:meta])* $said:literal, $per_term:expr, $largest:expr,
     $acts:ident, $method:ident, $of:ident) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name<const J: usize, S = f32>(Series<J, S>);

        impl<const J: usize, S: Scalar> $name<J, S> {
            $(#[$new])*
            ///
            /// # Errors
            /// [`ParamError`] where a value is not finite, `to` not above `from`, or one does not fit `S` in `units`.
            pub fn try_new(
                from: f64,
                to: f64,
                terms: [f64; J],
                units: Units,
            ) -> Result<Self, ParamError> {
                units.check()?;
                let unit: fn(Units) -> f64 = $per_term;
                for term in terms {
                    at_most($said, term.abs(), $largest)?;
                }
                let terms = terms.map(|c| c / unit(units));
                Series::try_new($said, from, to, terms, units.length).map(Self)
            }
        }

        impl<const J: usize, S: Scalar> Effect<S> for $name<J, S> {
            type State = ();
            const $acts: bool = true;
            const PLACED: bool = true;

            fn at_rest(&self) {}

            #[inline]
            fn $method(&self, _state: &mut (), at: &Situation<S>) -> S {
                self.0.at(at.position)
            }

            fn bounds(&self) -> Bounds<S> {
                Bounds::$of(self.0.bound)
            }
        }
    };
}

map!(
    /// `position_force`: a force map over the travel that is not periodic, `F(x) = Σ_j c_j·cos(jπu)`, of `J` terms.
    PositionForce,
    /// The map lies over `from…to` (m or rad) and is held beyond; `terms` are `c_1…c_J` (N or N·m).
    "term of the force map",
    |u| u.force,
    f64::MAX,
    FORCE,
    force,
    of_force
);

map!(
    /// `position_friction`: preload or wear that varies over the travel, `m(x) = 1 + Σ_j c_j·cos(jπu)`, of `J` terms.
    PositionFriction,
    /// The map lies over `from…to` (m or rad) and is held beyond; `terms` are `c_1…c_J` (-).
    "term of the friction map",
    |_| 1.0,
    LARGEST_LEVEL,
    LEVEL,
    level,
    of_level
);
