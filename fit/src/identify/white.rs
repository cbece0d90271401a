//! Whether what a fit leaves is noise: no model predicts that, and a poor NMSE is not its fault.

use super::Identification;
use crate::recording::Recording;

/// Lags (samples) over which what is left is compared with itself.
const LAGS: usize = 10;
/// Mean correlation over these lags up to which it is noise: what a motion makes lasts for tens of samples and correlates nearly fully.
const WHITE: f64 = 0.1;

/// What is left of the effort at some rows.
struct Left {
    /// Mean square.
    square: f64,
    /// Mean product of one sample with those after it.
    lasting: f64,
}

impl Left {
    fn of(effort: &[f64], fitted: &[f64], rows: &[usize]) -> Self {
        let mean = |of: &dyn Fn(usize) -> f64| {
            rows.iter().map(|i| of(*i)).sum::<f64>() / rows.len().max(1) as f64
        };
        let level = mean(&|i| effort[i] - fitted[i]);
        let left = |i: usize| effort[i] - fitted[i] - level;
        let later = |lag: usize| {
            let pairs = rows.iter().filter(|i| **i + lag < fitted.len());
            let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), &i| {
                (sum + left(i) * left(i + lag), count + 1.0)
            });
            sum / f64::max(count, 1.0)
        };
        Self {
            square: mean(&|i| left(i).powi(2)),
            lasting: (1..=LAGS).map(later).sum::<f64>() / LAGS as f64,
        }
    }

    fn is_white(&self) -> bool {
        self.lasting.abs() < WHITE * self.square
    }
}

impl Identification {
    /// Whether the recorded effort less the fit is white over the samples that were fitted.
    pub(super) fn leaves_white(&self, recording: &Recording) -> bool {
        let rows = self.split.train();
        Left::of(&recording.effort, &self.best().fitted, &rows).is_white()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Options, identify};
    use crate::progress::Progress;
    use crate::recording::{LoadOptions, load_csv};
    use preslide_host_tests::made::sines;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::fmt::Write as _;

    /// Friction of 0.064 N·m under four times as much of something: noise is said to be noise, and the model is good for its intervals; what lasts is
    /// no friction, and no model is.
    #[test]
    fn noise_is_not_said_to_be_no_friction() {
        for is_noise in [true, false] {
            let mut random = ChaCha8Rng::seed_from_u64(1);
            let mut text = "t_s,q_rad,torque_Nm\n".to_owned();
            for i in 0..20_000 {
                let t = f64::from(i) * 1e-3;
                let [q, v, a] = sines(&[[3.0, 1.3, 0.0], [0.5, 4.4, 1.0]], t);
                let more = match is_noise {
                    true => random.random_range(-0.45..0.45),
                    false => 0.37 * (7.1 * t + 3.0 * (0.9 * t).sin()).sin(),
                };
                let torque = 3e-4 * a + 5e-4 * v + 0.064 * v.signum() + more;
                let _ = writeln!(text, "{t:.3},{q:.6},{torque:.6}");
            }
            let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default());
            let recording = recording.expect("valid");
            let found = identify(&recording, &Options::default(), &Progress::new("test", 0));
            let found = found.expect("a fit");
            let said = &found.recommendation;
            println!("{} % left: {said}", found.best().nmse_test);
            assert!(found.best().nmse_test > 50.0);
            assert_eq!(said.contains("not friction"), !is_noise, "{said}");
            assert_eq!(said.contains("as noise"), is_noise, "{said}");
            assert_eq!(found.refused().is_some(), !is_noise);
        }
    }
}
