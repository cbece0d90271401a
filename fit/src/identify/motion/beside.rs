//! What the fit of the force, with its blocks, says beside a fit of the motion, whose friction is Coulomb's.

use super::super::Identification;
use super::super::fit::{shown, unit};
use crate::recording::Recording;
use crate::report::figures::{estimate, left};
use crate::statistics::Estimate;

/// Share of what Coulomb friction leaves of the force below which blocks leave so much less that what they have is missed.
const MUCH_LESS: f64 = 0.5;
/// What Coulomb friction must leave of the force's variance (%) that it matters: a motion that slides leaves that much at its reversals.
const MATTERS: f64 = 10.0;
/// Parameters that mean the same in both fits.
const COMMON: [&str; 2] = ["mass", "viscous"];

/// The fit of the force that is recommended.
#[derive(Clone, Debug)]
pub(super) struct Beside {
    /// NMSE held out (%) of Coulomb friction, and of the recommended model.
    leaves: [f64; 2],
    name: String,
    parameters: Vec<(&'static str, Estimate)>,
}

impl Beside {
    pub(super) fn of(force: &Identification) -> Self {
        let best = force.best();
        Self {
            leaves: [force.candidates[0].nmse_test, best.nmse_test],
            name: best.model.friction.name(),
            parameters: best.rigid_body.clone(),
        }
    }

    /// Whether blocks explain what Coulomb friction cannot.
    fn shows_presliding(&self) -> bool {
        let [coulomb, blocks] = self.leaves;
        coulomb > MATTERS && blocks < MUCH_LESS * coulomb
    }

    fn leaves(&self) -> String {
        let [coulomb, own] = self.leaves.map(left);
        format!(
            "of the force's variance Coulomb friction leaves {coulomb}, {} {own}",
            self.name
        )
    }

    /// Why a simulation with Coulomb friction says nothing of this motion.
    pub(super) fn refusal(&self, name: &str) -> String {
        format!(
            "{name}: most of this motion is pre-sliding ({}), where a body with Coulomb friction stands still: --criterion motion would find another machine; leave it out, or record strokes that slide",
            self.leaves()
        )
    }

    /// What friction is left out, a sentence without its full stop.
    pub(super) fn words(&self) -> String {
        match self.shows_presliding() {
            true => format!(
                "Friction is Coulomb's, which this motion is too small for: {}. What it lacks bends mass and viscous friction; without --criterion motion blocks are fitted to the force",
                self.leaves()
            ),
            false => "Friction is Coulomb's: a motion of this size shows no pre-sliding; without --criterion motion blocks are fitted to the force".to_owned(),
        }
    }

    /// Parameters that the two fits say to be different, beyond both intervals; `own` are those of the motion.
    pub(super) fn contradictions(
        &self,
        own: &[(&'static str, Estimate)],
        recording: &Recording,
    ) -> Vec<String> {
        let of = |parameters: &[(&'static str, Estimate)], name| {
            let found = parameters.iter().find(|p| p.0 == name);
            found.map(|p| p.1)
        };
        let both = COMMON.iter().filter_map(|name| {
            let (own, other) = (of(own, *name)?, of(&self.parameters, *name)?);
            are_apart(own, other).then_some((*name, own, other))
        });
        both.map(|(name, own, other)| {
            let unit = unit(recording, name);
            let [own, other] = [own, other].map(|e| estimate(e.value, e.ci95, &unit));
            format!(
                "{}, {own} here, contradicts the fit of the force, {other}, beyond both intervals: one of them lacks physics ({}); take that of the force, and let `preslide diagnose` say what it lacks",
                shown(recording, name),
                self.leaves()
            )
        })
        .collect()
    }
}

fn are_apart(one: Estimate, other: Estimate) -> bool {
    one.ci95
        .zip(other.ci95)
        .is_some_and(|(a, b)| a[1] < b[0] || b[1] < a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_intervals_that_do_not_meet_are_apart() {
        let of = |value: f64, reach: f64| Estimate {
            value,
            ci95: Some([value - reach, value + reach]),
        };
        assert!(are_apart(of(3.1, 0.66), of(4.99, 0.02)));
        assert!(are_apart(of(4.99, 0.02), of(3.1, 0.66)));
        assert!(!are_apart(of(4.4, 0.66), of(4.99, 0.02)));
        let unknown = Estimate {
            value: 3.0,
            ci95: None,
        };
        assert!(!are_apart(unknown, of(4.99, 0.02)));
    }
}
