//! How much of the acceleration is the encoder's noise: as a regressor with an error in it, it takes that share off the inertia.

use super::Kinematics;
use super::zero_phase::NOISE_SHARE;
use crate::recording::Recording;
use crate::statistics::{LeastSquares, quantile};
use std::f64::consts::TAU;

/// Weights of a sixth difference: a motion of hundred samples to its shortest wave leaves a millionth of itself, white noise grows thirtyfold.
const SIXTH: [f64; 7] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];
/// Standard deviations in the median magnitude of a normal number.
const MEDIAN: f64 = 0.674_49;
/// Share of the acceleration beside velocity and direction that may be noise at most: what is left of less tells no inertia.
const MOST: f64 = 0.1;
/// Frequencies at which the filter is summed.
const BINS: usize = 1000;

impl Kinematics {
    /// Share of the acceleration, beside what velocity and direction explain of it, that is the machine's.
    pub(super) fn beside_noise(&self, recording: &Recording) -> f64 {
        self.noisy(recording)
            .map_or(1.0, |noise| 1.0 - noise.clamp(0.0, MOST))
    }

    fn noisy(&self, recording: &Recording) -> Option<f64> {
        let noise = self.position_noise(recording)? * self.gain(recording.sample_time_s());
        let rows: Vec<usize> = (0..recording.len())
            .filter(|i| self.direction[*i] != 0.0)
            .collect();
        let of = |values: &[f64]| -> Vec<f64> { rows.iter().map(|i| values[*i]).collect() };
        let direction = self.filter.smooth(&self.direction);
        let columns = [of(&direction), of(&self.velocity), vec![1.0; rows.len()]];
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let acceleration = of(&self.acceleration);
        let left = LeastSquares::of(&columns)?.squares_left(&acceleration);
        let whole: f64 = acceleration.iter().map(|a| a * a).sum();
        // The band lets in no more: what is more is a vibration.
        let noise = (rows.len() as f64 * noise.powi(2)).min(NOISE_SHARE * whole);
        (left > 0.0).then(|| noise / left)
    }

    /// Standard deviation (m or rad) of the white noise of the position, where the axis moves.
    fn position_noise(&self, recording: &Recording) -> Option<f64> {
        let pieces = recording.pieces.iter();
        let mut sizes: Vec<f64> = pieces
            .flat_map(|piece| {
                let moves = move |at: &usize| self.direction[piece.start + at] != 0.0;
                let windows = recording.position[piece.clone()].windows(SIXTH.len());
                let own = windows.enumerate().filter(move |(at, _)| moves(at));
                own.map(|(_, x)| difference(x).abs())
            })
            .collect();
        let gain = SIXTH.iter().map(|w| w * w).sum::<f64>().sqrt();
        Some(quantile(&mut sizes, 0.5)? / MEDIAN / gain)
    }

    /// Standard deviation of the filtered acceleration (1/s²) that a position with white noise of 1 has.
    fn gain(&self, sample_time_s: f64) -> f64 {
        let bin = 0.5 / sample_time_s / BINS as f64;
        let power = (0..BINS).map(|k| {
            let hz = (k as f64 + 0.5) * bin;
            ((TAU * hz).powi(2) * self.filter.keeps(hz)).powi(2)
        });
        (power.sum::<f64>() / BINS as f64).sqrt()
    }
}

fn difference(x: &[f64]) -> f64 {
    SIXTH.iter().zip(x).map(|(w, x)| w * x).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::{Options, identify};
    use crate::progress::Progress;
    use crate::recording::{LoadOptions, load_csv};
    use preslide_host_tests::made::{Blocks, sines};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::fmt::Write as _;

    /// A stage of 5 kg with blocks, its position with noise uniform within ± `size` (m).
    fn made(size: f64, seed: u64) -> Recording {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut blocks = Blocks::new(&[(2e5, 1e-5), (8e4, 3.75e-5), (2e4, 1.5e-4)]);
        let mut text = "t_s,x_m,force_N\n".to_owned();
        let waves = [
            [0.02, TAU * 0.5, 0.0],
            [0.01, TAU * 1.1, 1.0],
            [2e-3, TAU * 3.0, 2.0],
        ];
        for i in 0..20_000 {
            let t = f64::from(i) * 1e-3;
            let [x, v, a] = sines(&waves, t);
            let read = x + size * random.random_range(-1.0..1.0);
            let force = 5.0 * a + 30.0 * v + blocks.force(x);
            let _ = writeln!(text, "{t:.3},{read:.10},{force:.6}");
        }
        load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).expect("valid")
    }

    /// Deviations (relative) of the mass over recordings that differ by their noise; its bias without the share is −1.2e-3 at this noise.
    #[test]
    fn noise_of_the_position_takes_nothing_off_the_mass() {
        let deviations: Vec<f64> = (1..=4)
            .map(|seed| {
                let recording = made(1.7e-6, seed);
                let found = identify(&recording, &Options::default(), &Progress::new("test", 0));
                let found = found.expect("a fit");
                let mass = found.best().rigid_body.iter().find(|p| p.0 == "mass");
                mass.expect("a mass").1.value / 5.0 - 1.0
            })
            .collect();
        let n = deviations.len() as f64;
        let mean = deviations.iter().sum::<f64>() / n;
        let rms = (deviations.iter().map(|d| d * d).sum::<f64>() / n).sqrt();
        let most = deviations
            .iter()
            .fold(0.0, |most: f64, d| most.max(d.abs()));
        println!("mean {mean:.1e}, RMS {rms:.1e}, max {most:.1e}");
        assert!(mean.abs() < 5e-4 && rms < 7e-4 && most < 1.2e-3);
    }

    /// A motion alone looks like no noise, and noise is told within a tenth.
    #[test]
    fn the_noise_is_told_from_the_motion() {
        for (size, within) in [(0.0, 2e-10), (1.7e-6, 1e-7)] {
            let recording = made(size, 1);
            let noise = Kinematics::of(&recording).position_noise(&recording);
            let noise = noise.expect("moves");
            println!("{noise:e}");
            assert!((noise - size / 3.0_f64.sqrt()).abs() < within, "{noise:e}");
        }
    }
}
