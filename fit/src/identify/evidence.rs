//! Which plain physics a recording shows: each only where it predicts stretches that were held out.

use super::plain::{Place, Plain};
use super::regression::{Gram, Regressor, Surface};
use super::search::non_negative;
use crate::recording::{MotionKind, Recording};
use crate::signal::{FEWEST, GROUPS, LATE, ONE_SLOPE_RAD};
use crate::statistics::mean_and_error;
use nalgebra::DVector;

/// Name of a column that is the force of a law of friction …
pub(super) const LAW: &str = "law";
/// … of one that falls with the speed …
pub(super) const FALLING: &str = "falling";
/// … and of a force that is periodic in the position.
pub(super) const WAVE: &str = "wave";

/// Standard errors of the paired difference over the folds by which an addition must predict better: some ten are tried on every recording.
const CERTAIN: f64 = 3.0;

/// Share of the error held out that an addition must take off: what is less moves friction and inertia by less than their intervals.
pub(super) const MATERIAL: f64 = 0.02;

/// The same of a spring that pushes: of magnets, or of an axis that leans over. Few machines have one, and what is wrong with friction imitates it: set
/// on thirteen machines of a blind judge: one had it (92 % taken off), and six had nothing that follows the position (2 to 23 %).
const MATERIAL_WHERE_IT_PUSHES: f64 = 0.5;

/// Share of an error held out that is hardly any.
const HARDLY_ANY: f64 = 0.1;

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shown {
    pub(super) plain: Plain,
    /// Longest yield displacement of friction (m or rad).
    pub(super) longest: f64,
    /// What the additions take off the error held out (%).
    pub(super) gain: f64,
}

/// Plain columns, maybe others behind them, and the sums over all of them and the deflections of a grid.
pub(super) struct Evidence<'a> {
    pub(super) columns: &'a [Regressor],
    pub(super) surface: &'a Surface,
}

impl Evidence<'_> {
    /// Plain columns of a name.
    pub(super) fn named(&self, name: &str) -> impl Iterator<Item = usize> {
        let columns = self.columns.iter().enumerate();
        columns.filter(move |(_, c)| c.name == name).map(|(j, _)| j)
    }

    /// Columns of the blocks that yield by `longest`.
    pub(super) fn blocks(&self, longest: f64) -> Vec<usize> {
        let first = self.columns.len();
        let grid = self.surface.grid.iter().enumerate();
        let yields_by = grid.filter(|(_, d)| **d <= longest);
        yields_by.map(|(j, _)| first + j).collect()
    }

    /// The columns of a fit to some folds, those that are `linear` first, of `friction` those with a positive share; and its coefficients.
    pub(super) fn fit<'g>(
        &self,
        folds: impl IntoIterator<Item = &'g Gram>,
        linear: &[usize],
        friction: &[usize],
    ) -> Option<(Vec<usize>, DVector<f64>)> {
        non_negative(&Gram::sum(folds)?, linear, friction)
    }

    /// Squared error on every fold of a fit to the other groups of folds; `None` if the columns cannot be separated.
    pub(super) fn held_out(&self, linear: &[usize], friction: &[usize]) -> Option<Vec<f64>> {
        let per_group = self.surface.folds.len().div_ceil(GROUPS).max(1);
        let mut errors = Vec::new();
        for (out, group) in self.surface.folds.chunks(per_group).enumerate() {
            let others = self.surface.folds.chunks(per_group).enumerate();
            let rest = others.filter(|(i, _)| *i != out).flat_map(|(_, g)| g);
            let (chosen, coefficients) = self.fit(rest, linear, friction)?;
            let left = group.iter();
            errors.extend(left.map(|fold| fold.squared_error(&chosen, &coefficients)));
        }
        Some(errors)
    }

    /// Whether all folds give a spring that pushes.
    fn pushes(&self, plain: Plain, longest: f64) -> bool {
        let is_spring = |column: &usize| {
            self.columns
                .get(*column)
                .is_some_and(|c| c.name == "spring")
        };
        let linear = plain.among(self.columns);
        let fit = self.fit(&self.surface.folds, &linear, &self.blocks(longest));
        fit.is_some_and(|(chosen, fit)| {
            let at = chosen.iter().position(is_spring);
            at.is_some_and(|at| fit[at] <= 0.0)
        })
    }

    /// What of the plain physics is there, and how late friction yields. What only stands in for what blocks lack is not there: it takes nothing off
    /// beside laws that have it.
    pub(super) fn shown(&self, recording: &Recording, base: Plain, longest: f64) -> Shown {
        let (low, high) = recording.ends();
        let mut places: &[Place] = match recording.kind {
            MotionKind::Rotary if high - low >= ONE_SLOPE_RAD => {
                &[Place::Nowhere, Place::Spring, Place::Gravity]
            }
            _ => &[Place::Nowhere, Place::Spring],
        };
        let mut may_differ = true;
        loop {
            let shown = self.shown_of(recording, base, longest, places, may_differ);
            let without = |plain: Plain| !self.is_needed(shown, plain);
            let both_ways = Plain {
                by_direction: false,
                ..shown.plain
            };
            let nowhere = Plain {
                place: Place::Nowhere,
                ..shown.plain
            };
            if shown.plain.by_direction && without(both_ways) {
                may_differ = false;
            } else if shown.plain.place != Place::Nowhere && without(nowhere) {
                places = &[Place::Nowhere];
            } else {
                return shown;
            }
        }
    }

    /// Whether what is shown predicts better than `less` of it beside all laws of friction and a force that is periodic in the position.
    fn is_needed(&self, shown: Shown, less: Plain) -> bool {
        let laws = self.named(LAW).chain(self.named(FALLING));
        let friction: Vec<usize> = laws.chain(self.blocks(shown.longest)).collect();
        let held_out = |plain: Plain| {
            let linear = plain.among(self.columns).into_iter();
            let linear: Vec<usize> = linear.chain(self.named(WAVE)).collect();
            self.held_out(&linear, &friction)
        };
        let errors = held_out(less).zip(held_out(shown.plain));
        errors.is_none_or(|(without, with)| is_better(&without, &with, MATERIAL, false))
    }

    /// What is there of what may be, by blocks alone.
    fn shown_of(
        &self,
        recording: &Recording,
        base: Plain,
        longest: f64,
        places: &[Place],
        may_differ: bool,
    ) -> Shown {
        let (low, high) = recording.ends();
        let early = LATE * (high - low);
        let mut shown = Shown {
            plain: base,
            longest,
            gain: 0.0,
        };
        // From the simplest: friction that yields early beside each force of the position, then friction that yields late.
        let yields_by = |end: &f64| self.surface.grid.iter().any(|d| d <= end);
        let ends = [early, longest].into_iter();
        let ends = ends.filter(|end| *end == longest || yields_by(end));
        let offered: Vec<(Plain, f64)> = ends
            .flat_map(|end| {
                places
                    .iter()
                    .map(move |&place| (Plain { place, ..base }, end))
            })
            .collect();
        if self.surface.folds.len() < FEWEST {
            return shown;
        }
        let mut best: Option<Vec<f64>> = None;
        let mut take = |shown: &mut Shown, (plain, end): (Plain, f64)| {
            let pushes = plain.place == Place::Spring && self.pushes(plain, end);
            // Friction that yields late would cancel it.
            if pushes && end > early {
                return;
            }
            let linear = plain.among(self.columns);
            let Some(errors) = self.held_out(&linear, &self.blocks(end)) else {
                return;
            };
            let places = [shown.plain.place, plain.place];
            let rivals = places[0] != places[1] && !places.contains(&Place::Nowhere);
            let least = match pushes && plain.place != shown.plain.place {
                true => MATERIAL_WHERE_IT_PUSHES,
                false => MATERIAL,
            };
            if best
                .as_ref()
                .is_none_or(|best| is_better(best, &errors, least, rivals))
            {
                (shown.plain, shown.longest) = (plain, end);
                best = Some(errors);
            }
        };
        for candidate in offered {
            take(&mut shown, candidate);
        }
        let by_direction = Plain {
            by_direction: true,
            ..shown.plain
        };
        let end = shown.longest;
        if may_differ {
            take(&mut shown, (by_direction, end));
        }
        let sum = |errors: &[f64]| errors.iter().sum::<f64>();
        if shown.plain != base {
            // Beside the same friction: what yields late would stand in for what follows the position.
            let without = base.among(self.columns);
            let without = self.held_out(&without, &self.blocks(shown.longest));
            let taken_off = best
                .zip(without)
                .map(|(with, without)| 1.0 - sum(&with) / sum(&without));
            shown.gain = 100.0 * taken_off.unwrap_or(0.0);
        }
        shown
    }
}

/// Whether errors held out are less, by a share of at least `least` and for certain: by as much everywhere, or, where hardly any is left, everywhere in
/// proportion: a few long strokes have most of an error that every stroke has. For two `rivals`, one of which is real, the proportion is enough.
pub(super) fn is_better(before: &[f64], after: &[f64], least: f64, rivals: bool) -> bool {
    let sum = |errors: &[f64]| errors.iter().sum::<f64>();
    let pairs = || before.iter().zip(after);
    let is_certain = |gains: Vec<f64>| {
        let [mean, error] = mean_and_error(&gains);
        mean > CERTAIN * error
    };
    let left = sum(after) / sum(before).max(1e-300);
    let in_proportion = |(b, a): (&f64, &f64)| (b.max(1e-300) / a.max(1e-300)).ln();
    left < 1.0 - least
        && (is_certain(pairs().map(|(b, a)| b - a).collect())
            || (rivals || left < HARDLY_ANY) && is_certain(pairs().map(in_proportion).collect()))
}

#[cfg(test)]
mod tests {
    use super::{MATERIAL, is_better};

    #[test]
    fn few_strokes_tell_what_takes_nearly_all_of_each() {
        // Two long strokes of six have most of the error: its mean is known to half of itself.
        let before = [40.0, 1.0, 2.0, 35.0, 1.5, 0.8];
        let of_each = |left: f64, of_the_last: f64| {
            let mut after = before.map(|b| left * b);
            after[5] = of_the_last;
            is_better(&before, &after, MATERIAL, false)
        };
        assert!(of_each(0.01, 0.02));
        // Half of each, as a wrong spring takes; nearly all of five and nothing of one; no more than chance.
        assert!(!of_each(0.5, 0.4));
        assert!(!of_each(0.01, 300.0));
        assert!(!of_each(0.99, 0.79));
        // Of a spring and a weight that take all but a fifth, the one that takes most of every stroke.
        let spring = [12.0, 0.24, 1.3, 1.7, 3.4, 7.9];
        let weight = [1.7, 0.25, 0.23, 0.1, 0.85, 0.7];
        assert!(
            is_better(&spring, &weight, MATERIAL, true)
                && !is_better(&weight, &spring, MATERIAL, true)
        );
    }
}
