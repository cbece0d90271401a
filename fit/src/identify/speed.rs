//! Whether friction at the slowest speeds is more than Coulomb's and viscous friction together: then both stand for a mean over the speeds.

use super::Identification;
use super::laws::figures;
use crate::recording::Recording;
use crate::report::figures::quantity;
use crate::statistics::{LeastSquares, mean_and_error, quantile_between_ranks};

/// Speeds within which it falls that are tried, as quantiles of the speed while moving.
const WITHIN: [f64; 4] = [0.03, 0.1, 0.25, 0.5];
/// Standard errors over the folds of the clearest of them.
const CLEAR: f64 = 4.0;
/// Share of Coulomb friction that counts.
const COUNTS: f64 = 0.05;
/// Share of the top speed that is rest.
const REST: f64 = 1e-3;

impl Identification {
    /// In words, where it is so.
    pub(super) fn falls_with_speed(&self, recording: &Recording) -> Option<String> {
        let best = self.best();
        let coulomb = best.rigid_body.iter().find(|p| p.0 == "coulomb")?.1;
        let top = self.velocity.iter().fold(0.0, |t: f64, v| t.max(v.abs()));
        let moves = |i: &usize| self.velocity[*i].abs() > REST * top;
        let parts = self.split.parts().concat();
        let parts: Vec<Vec<usize>> = parts
            .into_iter()
            .map(|part| part.into_iter().filter(moves).collect())
            .collect();
        let speeds: Vec<f64> = parts
            .iter()
            .flatten()
            .map(|i| self.velocity[*i].abs())
            .collect();
        let found = WITHIN.map(|q| {
            let within = quantile_between_ranks(&speeds, q);
            let more = parts
                .iter()
                .filter_map(|rows| self.more_below(within, rows));
            (within, more.collect::<Vec<f64>>())
        });
        let (within, more, _) = found
            .into_iter()
            .map(|(within, more)| {
                let [mean, error] = mean_and_error(&more);
                (within, mean, mean / error)
            })
            .filter(|(_, more, clear)| *clear > CLEAR && *more > COUNTS * coulomb.value)
            .max_by(|a, b| a.2.total_cmp(&b.2))?;
        let beside = match (&self.beside_falling, coulomb.ci95) {
            (Some(own), _) => format!(
                "beside friction that falls they are {}, and the intervals include that",
                figures(recording, own)
            ),
            (None, Some(_)) => "the true value of each may lie outside its interval".to_owned(),
            (None, None) => {
                "how far the true values are away is not known, so that they have no intervals"
                    .to_owned()
            }
        };
        Some(format!(
            "at the slowest speeds friction exceeds the fit by {}, which fades within about {}: Coulomb and viscous friction are a mean over the speeds here; {beside}; `preslide diagnose` says what falls with the speed",
            quantity(more, recording.effort_unit()),
            quantity(within, &format!("{}/s", recording.position_unit()))
        ))
    }

    /// What friction is more at rest, falling within a speed, over some rows (N or N·m).
    fn more_below(&self, within: f64, rows: &[usize]) -> Option<f64> {
        let fitted = &self.best().fitted;
        let of = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let v = rows.iter().map(|&i| self.velocity[i]);
            v.map(|v| f(v.signum(), v.abs() / within)).collect()
        };
        let columns = [
            of(&|_, _| 1.0),
            of(&|sign, _| sign),
            of(&|sign, speed| sign * speed),
            of(&|sign, speed| sign * (-speed).exp()),
        ];
        let left: Vec<f64> = rows.iter().map(|&i| self.effort[i] - fitted[i]).collect();
        let columns = columns.each_ref().map(Vec::as_slice);
        let fit = LeastSquares::of(&columns)?.coefficients(&left);
        fit.last().copied()
    }
}
