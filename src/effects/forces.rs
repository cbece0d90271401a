//! Forces that need no memory: constant, of velocity, of position.

use super::{Bounds, Effect, Situation};
use crate::Scalar;
use crate::param::{ParamError, Units, positive, to_positive, to_scalar};

/// `constant_force`: gravity, tilt, current offset, `F0`.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantForce<S = f32> {
    force: S,
}

impl<S: Scalar> ConstantForce<S> {
    /// `force` is `F0` (N or N·m).
    ///
    /// # Errors
    /// [`ParamError`] where it does not fit `S` in `units`.
    pub fn try_new(force: f64, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        Ok(Self {
            force: to_scalar("constant force", force / units.force)?,
        })
    }
}

impl<S: Scalar> Effect<S> for ConstantForce<S> {
    type State = ();
    const FORCE: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn force(&self, _state: &mut (), _at: &Situation<S>) -> S {
        self.force
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_force(self.force.magnitude())
    }
}

/// A coefficient in the model's units and the bound of what it gives.
#[derive(Clone, Debug, PartialEq)]
struct Limited<S> {
    coefficient: S,
    limit: S,
}

impl<S: Scalar> Limited<S> {
    fn try_new(
        name: &'static str,
        coefficient: f64,
        limit: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        units.check()?;
        positive("limit of a force term", limit)?;
        Ok(Self {
            coefficient: to_scalar(name, coefficient)?,
            limit: to_positive("limit of a force term", limit / units.force)?,
        })
    }

    #[inline]
    fn of(&self, input: S) -> S {
        self.coefficient.mul_input(input).limited(self.limit)
    }
}

macro_rules! limited_force {
    ($(#[$doc:meta])* $name:ident, $(#[$new:meta])* $coefficient:ident, $said:literal, $unit:expr, |$at:ident| $input:expr) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name<S = f32>(Limited<S>);

        impl<S: Scalar> $name<S> {
            $(#[$new])*
            /// `limit` (N or N·m) bounds the force.
            ///
            /// # Errors
            /// [`ParamError`] where the coefficient is not finite, `limit` not positive, or one does not fit `S` in `units`.
            pub fn try_new($coefficient: f64, limit: f64, units: Units) -> Result<Self, ParamError> {
                let scale: fn(Units) -> f64 = $unit;
                Limited::try_new($said, $coefficient * scale(units), limit, units).map(Self)
            }
        }

        impl<S: Scalar> Effect<S> for $name<S> {
            type State = ();
            const FORCE: bool = true;

            fn at_rest(&self) {}

            #[inline]
            fn force(&self, _state: &mut (), $at: &Situation<S>) -> S {
                self.0.of($input)
            }

            fn bounds(&self) -> Bounds<S> {
                Bounds::of_force(self.0.limit)
            }
        }
    };
}

limited_force!(
    /// Viscous friction `b·v`, bounded.
    Viscous,
    /// `viscous` is `b` (N·s/m or N·m·s/rad).
    viscous, "viscous coefficient", |u| u.velocity / u.force, |at| at.velocity
);

limited_force!(
    /// `viscous_asymmetry`: `d·|v|`, bounded. Beside [`Viscous`] friction `b·v` it is `b + d` forwards and `b − d` backwards.
    ViscousAsymmetry,
    /// `half_difference` is `d` (N·s/m or N·m·s/rad).
    half_difference, "viscous asymmetry", |u| u.velocity / u.force, |at| at.velocity.magnitude()
);

limited_force!(
    /// `quadratic_drag`: `c·v·|v|`, bounded.
    QuadraticDrag,
    /// `drag` is `c` (N·s²/m² or N·m·s²/rad²).
    drag, "drag coefficient", |u| u.velocity * u.velocity / u.force,
    |at| at.velocity.mul_input(at.velocity.magnitude())
);

/// `position_spring`: cable drag, `κ·(x − x0)`, bounded.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionSpring<S = f32> {
    spring: Limited<S>,
    centre: S,
}

impl<S: Scalar> PositionSpring<S> {
    /// `stiffness` is `κ` (N/m or N·m/rad), `centre` is `x0` (m or rad), `limit` (N or N·m) bounds the force.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite, `limit` not positive, or one does not fit `S` in `units`.
    pub fn try_new(
        stiffness: f64,
        centre: f64,
        limit: f64,
        units: Units,
    ) -> Result<Self, ParamError> {
        let coefficient = stiffness * units.length / units.force;
        Ok(Self {
            spring: Limited::try_new(
                "stiffness of the position spring",
                coefficient,
                limit,
                units,
            )?,
            centre: to_scalar("centre of the position spring", centre / units.length)?,
        })
    }
}

impl<S: Scalar> Effect<S> for PositionSpring<S> {
    type State = ();
    const FORCE: bool = true;
    const PLACED: bool = true;

    fn at_rest(&self) {}

    #[inline]
    fn force(&self, _state: &mut (), at: &Situation<S>) -> S {
        self.spring.of(at.position.sub_input(self.centre))
    }

    fn bounds(&self) -> Bounds<S> {
        Bounds::of_force(self.spring.limit)
    }
}
