//! The feed-forward of friction, by any model.

use crate::param::{ParamError, Units, at_most, not_negative, to_gain, to_scalar};
use crate::{Friction, Motion, Scalar};
use core::marker::PhantomData;

/// Which motion drives the friction model.
///
/// **Stability.** With [`VelocitySource::Reference`] the feed-forward is a bounded function of the reference alone. It is
/// outside the loop and cannot destabilise it, however wrong the model; a wrong model leaves an error that the
/// feedback has to remove.
///
/// With [`VelocitySource::Measured`] the feed-forward closes a second loop with *positive* sign: while the blocks stick, a
/// displacement `δ` is answered by `+g·Σk̂_i·δ`, against the true friction's `−Σk_i·δ` and the feedback's
/// `−K_p·δ`. The loop keeps a positive stiffness if `g·Σk̂_i < K_p + Σk_i`, for which `g·Σk̂_i < K_p` is enough
/// whatever the truth; and a delay `T_d` (a tick, the encoder's half count) turns the same stiffness into a
/// negative damping `−g·Σk̂_i·T_d` that `K_d` and the motor's back-EMF must exceed. Where either fails the
/// result is a limit cycle and not a divergence: `|F̂| ≤ g·ΣŴ` still holds. So compensate less than all
/// (`share < 1`) when driving by the measured count, and do it where the reference is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum VelocitySource {
    /// The reference's displacement and velocity: feed-forward proper.
    Reference,
    /// The measured displacement and velocity: cancellation by feedback.
    Measured,
}

/// How much of what is fed forward (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FeedForward {
    /// Which motion drives the model.
    pub drive: VelocitySource,
    /// Share of the model's force that is applied `g` (-), 0…1.
    pub share: f64,
    /// Bound on the friction force that is applied (N or N·m); a model's own bound holds where it is smaller.
    pub limit: f64,
    /// Moving mass with the rotor's inertia reflected to the stage (kg or kg·m²), fed forward with the
    /// reference's acceleration; 0 for none. Give the true one: what the feedback adds to it, since it meets the reference with a
    /// velocity that was measured over a window, is taken off when coefficients are computed.
    pub mass: f64,
}

/// `F = g·F̂(motion)`, limited.
///
/// A Maxwell-slip sum, Dahl's model and Coulomb friction are bounded by construction ([`Friction::limit`]); the
/// clamp here is for models with a viscous term, which are not.
#[derive(Clone, Debug, PartialEq)]
pub struct Compensator<F: Friction> {
    friction: F,
    drive: VelocitySource,
    share: F::Scalar,
    limit: F::Scalar,
}

impl<F: Friction> Compensator<F> {
    /// `friction` must have been built in the same `units`.
    ///
    /// # Errors
    /// [`ParamError`] where a value is negative, not finite, `share` exceeds 1, or a value does not fit the
    /// number type in `units`.
    pub fn try_new(friction: F, settings: &FeedForward, units: Units) -> Result<Self, ParamError> {
        units.check()?;
        not_negative("feed-forward share", settings.share)?;
        at_most("feed-forward share", settings.share, 1.0)?;
        let limit = not_negative("feed-forward limit", settings.limit)? / units.force;
        let limit: F::Scalar = to_scalar("feed-forward limit", limit)?;
        let limit = match friction.limit() {
            Some(own) if own < limit => own,
            _ => limit,
        };
        Ok(Self {
            friction,
            drive: settings.drive,
            share: to_gain("feed-forward share", settings.share)?,
            limit,
        })
    }

    /// The friction model.
    pub fn friction(&self) -> &F {
        &self.friction
    }

    /// Which motion drives the model.
    pub fn drive(&self) -> VelocitySource {
        self.drive
    }

    /// Advances the model by one tick of the motion that drives it; the force to add to the feedback.
    #[inline]
    pub fn step(&self, state: &mut F::State, motion: Motion<F::Scalar>) -> F::Scalar {
        let force = self.friction.step(state, motion);
        // Not `limited`: what is not a number stays none, for the motor drive to find.
        let force = if force > self.limit {
            self.limit
        } else if force < -self.limit {
            -self.limit
        } else {
            force
        };
        self.share.mul_input(force)
    }
}

/// No friction model: feedback only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoFriction<S = f32>(PhantomData<S>);

impl<S> NoFriction<S> {
    /// The model that always answers 0.
    pub fn new() -> Self {
        Self(PhantomData)
    }
}

impl<S: Scalar> Friction for NoFriction<S> {
    type Scalar = S;
    type State = ();

    fn at_rest(&self) {}

    #[inline]
    fn step(&self, _state: &mut (), _motion: Motion<S>) -> S {
        S::ZERO
    }

    fn limit(&self) -> Option<S> {
        Some(S::ZERO)
    }
}
