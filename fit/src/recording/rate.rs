//! One rate for pieces that were sampled at several: what takes derivatives over all of them has one sample time.

use std::borrow::Cow;
use std::ops::Range;

use super::Recording;
use super::decimate::{blackman_sinc, low_passed};
use super::even::Grid;
use super::samples::ranges;

/// Sample times within this share of each other are one; an inertia that is taken by a wrong one is off by twice as much.
const SAME: f64 = 5e-4;
/// A piece that is sampled so many times slower says nothing at the rate of the others.
const SLOWER: f64 = 3.0;

/// A piece on its way to another rate.
struct Plan {
    piece: Range<usize>,
    /// Of so many samples one is kept, low-passed, …
    factor: usize,
    weights: Vec<f64>,
    /// … and brought to the common rate.
    grid: Grid,
}

impl Recording {
    /// All pieces at the sample time that half of the seconds have or are faster than, those that are sampled three times slower left out.
    pub fn at_one_rate(&self) -> Cow<'_, Recording> {
        let of = |piece: &Range<usize>| {
            let seconds = self.t_s[piece.end - 1] - self.t_s[piece.start];
            let step = seconds / (piece.len() - 1) as f64;
            (step, seconds, piece.clone())
        };
        let mut steps: Vec<_> = self.pieces.iter().filter(|p| p.len() > 1).map(of).collect();
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let half = 0.5 * steps.iter().map(|s| s.1).sum::<f64>();
        let mut seconds = 0.0;
        let common = steps.iter().find(|s| {
            seconds += s.1;
            seconds >= half
        });
        let Some(common) = common.map(|s| s.0) else {
            return Cow::Borrowed(self);
        };
        if steps.iter().all(|s| (s.0 / common - 1.0).abs() < SAME) {
            return Cow::Borrowed(self);
        }
        steps.retain(|s| s.0 < SLOWER * common);
        steps.sort_by_key(|s| s.2.start);
        let plan = |(step, _, piece): (f64, f64, Range<usize>)| {
            let factor = ((common / step).round() as usize).max(1);
            let kept: Vec<f64> = self.t_s[piece.clone()]
                .iter()
                .copied()
                .step_by(factor)
                .collect();
            // A single sample has no rate.
            (kept.len() > 1).then(|| Plan {
                grid: Grid::at(&kept, common),
                weights: blackman_sinc(factor),
                factor,
                piece,
            })
        };
        let plans: Vec<Plan> = steps.into_iter().filter_map(plan).collect();
        Cow::Owned(self.at(common, &plans))
    }

    fn at(&self, step: f64, plans: &[Plan]) -> Recording {
        let length = |within: &Range<usize>| -> usize {
            let inside = plans.iter().filter(|p| within.contains(&p.piece.start));
            inside.map(|p| p.grid.length()).sum()
        };
        let of_plans: Vec<Range<usize>> = plans.iter().map(|p| p.piece.clone()).collect();
        let times = |p: &Plan| p.grid.times(self.t_s[p.piece.start]);
        let even = self.with_samples(
            plans.iter().flat_map(times).collect(),
            ranges(&of_plans, length),
            ranges(&self.joined, length),
            |values| plans.iter().flat_map(|p| p.numbers(values)).collect(),
            |values| plans.iter().flat_map(|p| p.labels(values)).collect(),
        );
        Recording {
            sample_time_s: step,
            ..even
        }
    }
}

impl Plan {
    fn numbers(&self, values: &[f64]) -> Vec<f64> {
        let own = &values[self.piece.clone()];
        match self.factor {
            1 => self.grid.cubic(own),
            factor => self.grid.cubic(&low_passed(own, factor, &self.weights)),
        }
    }

    fn labels(&self, values: &[u32]) -> Vec<u32> {
        let own = values[self.piece.clone()].iter().copied();
        self.grid
            .last(&own.step_by(self.factor).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::read;
    use super::*;

    /// A sine of 3 Hz, sampled for 10 s.
    fn sampled(hertz: f64) -> Recording {
        samples((10.0 * hertz) as usize, hertz)
    }

    fn samples(count: usize, hertz: f64) -> Recording {
        let mut text = String::from("t_s,x_m,force_N\n");
        for i in 0..count {
            let t = i as f64 / hertz;
            let (sin, cos) = (std::f64::consts::TAU * 3.0 * t).sin_cos();
            text += &format!("{t:.9},{:.9},{:.9}\n", 0.01 * sin, cos);
        }
        read(&text)
    }

    #[test]
    fn pieces_of_unlike_rates_come_to_one_and_keep_what_they_say() {
        let same = Recording::join(vec![sampled(1000.0), sampled(1000.2)]).expect("joined");
        assert!(matches!(same.at_one_rate(), Cow::Borrowed(_)));

        // Of three samples at four times the rate one is left, and of one alone there is no rate.
        let few = Recording::join(vec![sampled(1000.0), samples(3, 4000.0)]).expect("joined");
        let few = few.at_one_rate();
        assert_eq!((few.len(), few.pieces.len()), (10_000, 1));

        let files = [1000.0, 980.0, 4000.0, 90.0].map(sampled).to_vec();
        let whole = Recording::join(files).expect("joined");
        let even = whole.at_one_rate();
        assert_eq!((even.pieces.len(), even.sample_time_s()), (3, 1e-3));
        assert_eq!(even.joined.len(), 4);
        assert!(even.joined[3].is_empty());
        for piece in &even.pieces {
            assert!((piece.len() as f64 / 1e4 - 1.0).abs() < 1e-3, "{piece:?}");
            let t = &even.t_s[piece.clone()];
            assert!(t.windows(2).all(|p| (p[1] - p[0] - 1e-3).abs() < 1e-9));
            // The ends of the low-passed piece are a continuation.
            for i in piece.start + 30..piece.end - 30 {
                let (sin, cos) = (std::f64::consts::TAU * 3.0 * even.t_s[i]).sin_cos();
                let off = [even.position[i] / 0.01 - sin, even.effort[i] - cos];
                assert!(off.iter().all(|o| o.abs() < 2e-5), "{i}: {off:?}");
            }
        }
    }
}
