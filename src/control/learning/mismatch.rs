//! The watch on the model: is what the drive spends on friction still what it was at commissioning?

use super::{BlockMeans, Learn, LearningSettings, decision_interval};
use crate::friction::condition::{Condition, NormalRange};
use crate::param::{ParamError, at_least, at_most, positive, to_positive, to_scalar};
use crate::{Scalar, Units};

/// What is normal, and how rarely that may be denied.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MismatchSettings {
    /// Path of a window (m or rad): several times that over which friction wanders, so that windows are independent.
    pub window: f64,
    /// Windows in each half of the commissioning `n` (-), 8…4096. The first half tells the mean, the second the spread.
    pub commissioning: u32,
    /// Slack `k` in spreads, 0.25…4: half the change that is to be found soonest.
    pub slack: f64,
    /// False alarms per window (-), 1e-9…0.1, expected of an axis in normal condition.
    pub false_alarms: f64,
}

/// Smallest spread over the limit (-): what rounds to nothing must not raise a flag.
const SMALLEST_SPREAD: f64 = 1e-3;

/// `E|z|` of a normal `z` is its spread times `√(2/π)`.
const SPREAD_PER_DEVIATION: f64 = 1.253_314_137_315_500_3;

/// A two-sided CUSUM (E. S. Page, *Continuous inspection schemes*, Biometrika 41, 1954) of the mismatch, one value a window.
///
/// ```text
/// x = Σ (spent − model)·path / window                            the excess of the work done, per path
/// μ = mean of 2n windows,  σ = √(π/2)·mean |x − μ₁|              the normal range, learned
/// up ← max(0, up + (x − μ) − k·σ),  down ← max(0, down − (x − μ) − k·σ),  flag where one exceeds h·σ
/// ```
/// `μ₁` is the mean of the first half and `|x − μ₁|` is taken over the second, which owes it nothing. `h` follows from the
/// false-alarm rate ([`decision_interval`]); it holds for windows that are independent and near normal. Means over windows that are
/// several correlation lengths long are, which is what long windows are for (batch means).
///
/// Work counts the motion's direction, so a force that does not turn with it (a weight, a cable) cancels and is not watched. A spot
/// that is narrow against a window and rarely passed shows only if it is strong. The range belongs to the motions of the
/// commissioning: other speeds are another normal.
#[derive(Clone, Debug, PartialEq)]
pub struct MismatchWatch<S> {
    per_window: S,
    commissioning: u32,
    per_half: S,
    /// Mean |deviation| to spread, with what the first half's mean leaves uncertain.
    spread: S,
    smallest_spread: S,
    slack: S,
    threshold: S,
}

/// What a [`MismatchWatch`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MismatchState<S> {
    /// Of the running window: its part that is over (-), and its mismatch so far.
    part: S,
    sum: S,
    windows: u32,
    /// Means of both halves; then the first is that of all.
    first: S,
    second: S,
    /// Mean |deviation|, then the spread's multiples.
    deviation: S,
    slack: S,
    threshold: S,
    up: S,
    down: S,
    range: NormalRange,
}

impl<S: Scalar> MismatchWatch<S> {
    /// Takes a window's mean mismatch; public for those who watch something else.
    #[inline]
    pub fn window(&self, state: &mut MismatchState<S>, x: S) {
        let half = self.commissioning;
        match state.range {
            NormalRange::Learning if state.windows < half => {
                state.first = state.first.add_input(self.per_half.mul_input(x));
            }
            NormalRange::Learning => {
                state.second = state.second.add_input(self.per_half.mul_input(x));
                let deviation = x.sub_input(state.first).magnitude();
                state.deviation = state
                    .deviation
                    .add_input(self.per_half.mul_input(deviation));
                if state.windows + 1 == 2 * half {
                    let spread = self.spread.mul_input(state.deviation);
                    let spread = if spread > self.smallest_spread {
                        spread
                    } else {
                        self.smallest_spread
                    };
                    state.first = state.first.half().add_input(state.second.half());
                    state.slack = self.slack.mul_input(spread);
                    state.threshold = self.threshold.mul_input(spread);
                    state.range = NormalRange::Inside;
                }
            }
            NormalRange::Inside => {
                let excess = x.sub_input(state.first);
                let positive = |sum: S| if sum > S::ZERO { sum } else { S::ZERO };
                state.up = positive(state.up.add_input(excess).sub_input(state.slack));
                state.down = positive(state.down.sub_input(excess).sub_input(state.slack));
                if state.up > state.threshold {
                    state.range = NormalRange::Above;
                } else if state.down > state.threshold {
                    state.range = NormalRange::Below;
                }
            }
            NormalRange::Above | NormalRange::Below => {}
        }
        state.windows = state.windows.saturating_add(1);
    }
}

impl<S: Scalar> MismatchState<S> {
    /// Takes the flag back and watches on, within the range learned at commissioning.
    pub fn acknowledge(&mut self) {
        if matches!(self.range, NormalRange::Above | NormalRange::Below) {
            self.up = S::ZERO;
            self.down = S::ZERO;
            self.range = NormalRange::Inside;
        }
    }

    /// Windows taken, commissioning included.
    pub fn windows(&self) -> u32 {
        self.windows
    }

    /// The verdict.
    pub fn range(&self) -> NormalRange {
        self.range
    }
}

impl<S: Scalar> Learn<S> for MismatchWatch<S> {
    type State = MismatchState<S>;
    const LEVEL: bool = false;

    fn try_new(settings: &LearningSettings, limit: f64, units: Units) -> Result<Self, ParamError> {
        let MismatchSettings {
            window,
            commissioning,
            slack,
            false_alarms,
        } = settings.watch;
        let window = positive("window of the watch", window)? / units.length;
        let half = at_least(
            "windows of half the commissioning",
            commissioning.into(),
            8.0,
        )?;
        at_most("windows of half the commissioning", half, 4096.0)?;
        at_least("slack of the watch", slack, 0.25)?;
        at_most("slack of the watch", slack, 4.0)?;
        at_least("false alarms per window", false_alarms, 1e-9)?;
        at_most("false alarms per window", false_alarms, 0.1)?;
        let limit = limit / units.force;
        let uncertain = libm::sqrt(1.0 + 1.0 / half);
        let threshold = decision_interval(slack, false_alarms, commissioning);
        Ok(Self {
            per_window: to_positive("reciprocal of the watch's window", 1.0 / window)?,
            commissioning,
            per_half: to_positive("share of a window in the commissioning", 1.0 / half)?,
            spread: to_positive("spread per deviation", SPREAD_PER_DEVIATION / uncertain)?,
            smallest_spread: to_positive("smallest spread", SMALLEST_SPREAD * limit)?,
            slack: to_scalar("slack of the watch", slack)?,
            threshold: to_positive("threshold of the watch", threshold)?,
        })
    }

    fn start(&self) -> Self::State {
        MismatchState {
            part: S::ZERO,
            sum: S::ZERO,
            windows: 0,
            first: S::ZERO,
            second: S::ZERO,
            deviation: S::ZERO,
            slack: S::ZERO,
            threshold: S::ZERO,
            up: S::ZERO,
            down: S::ZERO,
            range: NormalRange::Learning,
        }
    }

    #[inline]
    fn block(&self, state: &mut Self::State, block: &BlockMeans<S>) {
        let part = block.path.mul_input(self.per_window);
        let mismatch = block.spent.sub_input(block.model);
        state.part = state.part.add_input(part);
        state.sum = state.sum.add_input(mismatch.mul_input(part));
        if state.part >= S::ONE {
            let x = state.sum;
            state.part = S::ZERO;
            state.sum = S::ZERO;
            self.window(state, x);
        }
    }

    fn tell(&self, state: &Self::State, condition: &mut Condition<S>) {
        condition.range = Some(state.range);
    }
}
