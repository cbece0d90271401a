//! The friction level, by recursive least squares with forgetting.

use super::{BlockMeans, Learn, LearningSettings, reciprocal};
use crate::friction::condition::Condition;
use crate::param::{ParamError, at_least, at_most, not_negative, to_positive, to_scalar};
use crate::{Scalar, Units};

/// How fast and how far the level may go.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AdaptationSettings {
    /// Memory `M` in excited blocks (-), after which 37 % of a block's weight is left; at least 1, and so long that
    /// `(1/e² − 1)/M ≤ 1/2` with the excitation `e`.
    pub memory: f64,
    /// The level stays within `1 ± r` (-); at most 0.5.
    pub range: f64,
    /// Dead zone `δ` (-), a share of the limit: an error of the level's force up to this is the model's own, and is not followed.
    pub dead_zone: f64,
}

/// Scalar recursive least squares with exponential forgetting, once a block, of `s = θ·φ`: `φ` is the model's mean force along the
/// motion, `s` the spent one, both over the limit, `θ` the friction level.
///
/// ```text
/// R ← R + (φ² − R)/M           the information, forgotten over M blocks
/// P ← P·(2 − R·P)              its reciprocal, by one step of Newton's iteration instead of a division
/// ε = dead zone(s − θ·φ)       0 within ± δ, less by δ beyond it
/// θ ← θ + P·φ·ε/M              held within 1 ± r
/// ```
/// (K. J. Åström and B. Wittenmark, *Adaptive Control*, 2nd ed., 1995, chapter 2, with `R` normalised; that an estimator with
/// forgetting must not run where nothing excites it is chapter 11, "windup".)
///
/// `e² ≤ φ² ≤ 1` holds for excited blocks, so `e² ≤ R ≤ 1` always. From one block to the next `R` grows by at most the factor
/// `1 + (1/e² − 1)/M ≤ 3/2` and shrinks at most to `2/3`; so `1/2 ≤ R·P ≤ 3/2` before Newton's step gives `3/4 ≤ R·P ≤ 1` after
/// it, and that the former at the next block: it never diverges. `R` holds `φ²/M`, so the gain `P·φ²/M` is at most 1, and `θ`
/// moves towards `s/φ` and never past it.
///
/// A dead zone keeps what the model does not say (its shape, its Stribeck curve) from being taken for a change of level (B. B.
/// Peterson and K. S. Narendra, *Bounded error adaptive control*, IEEE Trans. Autom. Control 27, 1982).
#[derive(Clone, Debug, PartialEq)]
pub struct Adaptation<S> {
    per_limit: S,
    /// 1/M.
    share: S,
    range: S,
    dead_zone: S,
}

/// What an [`Adaptation`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AdaptationState<S> {
    level: S,
    information: S,
    reciprocal: S,
}

impl<S: Scalar> Learn<S> for Adaptation<S> {
    type State = AdaptationState<S>;
    const LEVEL: bool = true;

    fn try_new(settings: &LearningSettings, limit: f64, units: Units) -> Result<Self, ParamError> {
        let AdaptationSettings {
            memory,
            range,
            dead_zone,
        } = settings.adaptation;
        not_negative("dead zone of the adaptation", dead_zone)?;
        at_most("dead zone of the adaptation", dead_zone, 0.5)?;
        let growth = 1.0 / (settings.excitation * settings.excitation) - 1.0;
        let shortest = if growth > 0.5 { 2.0 * growth } else { 1.0 };
        at_least("memory of the adaptation in blocks", memory, shortest)?;
        at_most("memory of the adaptation in blocks", memory, 4096.0)?;
        not_negative("range of the friction level", range)?;
        Ok(Self {
            per_limit: reciprocal(limit / units.force)?,
            share: to_positive("share of a block in the adaptation", 1.0 / memory)?,
            range: to_scalar(
                "range of the friction level",
                at_most("range of the friction level", range, 0.5)?,
            )?,
            dead_zone: to_scalar("dead zone of the adaptation", dead_zone)?,
        })
    }

    fn start(&self) -> Self::State {
        AdaptationState {
            level: S::ONE,
            information: S::ONE,
            reciprocal: S::ONE,
        }
    }

    #[inline]
    fn block(&self, state: &mut Self::State, block: &BlockMeans<S>) {
        let model = block.model.mul_input(self.per_limit);
        let spent = block.spent.mul_input(self.per_limit);
        let news = model.mul_input(model).sub_input(state.information);
        state.information = state.information.add_input(self.share.mul_input(news));
        let product = state.information.mul_input(state.reciprocal);
        let newton = S::ONE.add_input(S::ONE).sub_input(product);
        state.reciprocal = state.reciprocal.mul_input(newton);
        let error = spent.sub_input(state.level.mul_input(model));
        let error = error.sub_input(error.limited(self.dead_zone));
        let gain = self.share.mul_input(state.reciprocal).mul_input(model);
        let deviation = state
            .level
            .sub_input(S::ONE)
            .add_input(gain.mul_input(error));
        state.level = S::ONE.add_input(deviation.limited(self.range));
    }

    #[inline]
    fn level(&self, state: &Self::State) -> S {
        state.level
    }

    fn highest(&self) -> S {
        S::ONE.add_input(self.range)
    }

    fn tell(&self, state: &Self::State, condition: &mut Condition<S>) {
        condition.level = Some(state.level);
    }
}
