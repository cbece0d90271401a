//! A load along the axis, which the drive holds besides friction and inertia: what is known of it is taken off the effort.

use super::{MotionKind, Recording, Warning};
use crate::report::figures::three;
use crate::statistics::LeastSquares;

/// Code of the warning that says so.
const LOAD_HELD: &str = "load-held";

/// By how much less or more than the load the effort may hold and hold it whole: gear and sensor are calibrated to within it.
const WHOLE: f64 = 0.1;
/// Share of the squares that the motion leaves of the effort which the load takes off: a normal force takes none, and what the motion makes is in
/// what the motion takes.
const MOST: f64 = 0.5;
/// Half of what a velocity is taken over (s): short against a motion, long against an encoder's step.
const HALF_WIDTH_S: f64 = 0.01;
/// Share of the top speed from which the axis slides.
const SLIDES: f64 = 0.05;
/// Fewest samples in sliding for eight coefficients.
const FEW: usize = 100;

impl Recording {
    /// Takes a load that the effort holds whole off it, and says so.
    pub(super) fn take_load_off(&mut self) {
        if let Some(share) = self.held_share() {
            self.take_off(share.signum());
            self.warnings.push(warning!(
                LOAD_HELD,
                "the drive holds the load, {} times what its column says: it is taken off the effort, and all results are for the axis without it. Add the measured load to a model's effort",
                three(share)
            ));
        }
    }

    /// Takes a load off the efforts of those that do not show it themselves, where the drive of another of the machine holds it, and says so.
    pub(super) fn take_off_alike(recordings: &mut [Self]) {
        let teller = recordings
            .iter()
            .find_map(|r| Some((r.load_held?, r.name.clone())));
        let Some((times, teller)) = teller else {
            return;
        };
        let does_not_tell = |r: &&mut Self| r.load_held.is_none() && r.load_n.is_some();
        for other in recordings.iter_mut().filter(does_not_tell) {
            other.take_off(times);
            let told = format!(
                "the load is taken off the effort of {} as in {teller}: its own motion does not show it",
                other.name
            );
            other.warnings.push(Warning::new(LOAD_HELD, told));
        }
    }

    /// Takes the load, so many times, off the effort.
    fn take_off(&mut self, times: f64) {
        let load = self.load_n.iter().flatten();
        self.effort
            .iter_mut()
            .zip(load)
            .for_each(|(f, load)| *f -= times * load);
        self.load_held = Some(times);
    }

    /// What share of the load the effort holds, where that is all of it.
    fn held_share(&self) -> Option<f64> {
        let load = self.load_n.as_ref()?;
        // Of a file that is read for its motion alone, or its effort.
        if self.effort.len() != load.len() || self.position.len() != load.len() {
            return None;
        }
        let half = ((HALF_WIDTH_S / self.sample_time_s).round() as usize).max(1);
        let width = half as f64 * self.sample_time_s;
        let inner = self.pieces.iter().flat_map(|p| {
            let reach = 2 * half;
            p.start + reach..p.end.saturating_sub(reach).max(p.start + reach)
        });
        let x = &self.position;
        let velocity = |i: usize| (x[i + half] - x[i - half]) / (2.0 * width);
        let moved: Vec<(usize, f64)> = inner.map(|i| (i, velocity(i))).collect();
        let top = moved.iter().map(|m| m.1.abs()).fold(0.0, f64::max);
        let slides: Vec<(usize, f64)> = moved
            .into_iter()
            .filter(|m| m.1.abs() > SLIDES * top)
            .collect();
        if slides.len() < FEW {
            return None;
        }
        let column =
            |of: &dyn Fn(usize, f64) -> f64| slides.iter().map(|&(i, v)| of(i, v)).collect();
        let place = |i: usize| match self.kind {
            MotionKind::Linear => [x[i], x[i] * x[i]],
            MotionKind::Rotary => [x[i].sin(), x[i].cos()],
        };
        let of_the_motion: [Vec<f64>; 7] = [
            column(&|_, _| 1.0),
            column(&|_, v| v),
            column(&|_, v| v.signum()),
            column(&|i, _| x[i + 2 * half] - 2.0 * x[i] + x[i - 2 * half]),
            column(&|i, _| place(i)[0]),
            column(&|i, _| place(i)[1]),
            // Friction that follows it is none that is held.
            column(&|i, v| load[i].abs() * v.signum()),
        ];
        let own: Vec<f64> = column(&|i, _| load[i]);
        let effort: Vec<f64> = column(&|i, _| self.effort[i]);
        let mut columns: Vec<&[f64]> = of_the_motion.iter().map(Vec::as_slice).collect();
        let without = LeastSquares::of(&columns)?.squares_left(&effort);
        columns.push(&own);
        let with = LeastSquares::of(&columns)?;
        let share = *with.coefficients(&effort).last()?;
        let is_whole = (share.abs() - 1.0).abs() < WHOLE;
        (is_whole && with.squares_left(&effort) < (1.0 - MOST) * without).then_some(share)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Recording;
    use super::super::tests::{apart, read};
    use super::LOAD_HELD;

    /// So many samples of an axis with friction, a spring and a load that is anybody's, of which the effort holds a share and friction follows another;
    /// and its effort without what is held.
    fn made(samples: u32, held: f64, followed: f64) -> (Recording, Vec<f64>) {
        let mut text = String::from("t_s,x_m,force_N,load_N\n");
        let mut without = Vec::new();
        for i in 0..samples {
            let t = f64::from(i) * 1e-3;
            let (x, v) = (0.02 * (1.9 * t).sin(), 0.038 * (1.9 * t).cos());
            let load = 12.0 * (0.7 * t).sin() + 5.0 * (2.3 * t + 0.4).cos();
            let own = (8.0 + followed * load.abs()) * (v / 1e-3).tanh() + 40.0 * v + 300.0 * x;
            without.push(own);
            text += &format!("{t:.3},{x:e},{:e},{load:e}\n", own + held * load);
        }
        (read(&text), without)
    }

    fn times_told(recording: &Recording) -> usize {
        let told = recording.warnings.iter().filter(|w| w.code == LOAD_HELD);
        told.count()
    }

    fn is_off(effort: &[f64], without: &[f64]) {
        let most = apart(effort, without);
        assert!(most < 1e-9, "{most}");
    }

    #[test]
    fn what_the_drive_holds_is_taken_off_and_what_friction_follows_is_not() {
        for (held, followed) in [(1.0, 0.0), (-1.0, 0.0), (1.0, 0.15)] {
            let (recording, without) = made(8000, held, followed);
            assert_eq!(times_told(&recording), 1, "{:?}", recording.warnings);
            is_off(&recording.effort, &without);
        }
        for (held, followed) in [(0.0, 0.15), (0.0, 0.0), (0.5, 0.0)] {
            let (recording, _) = made(8000, held, followed);
            assert_eq!(times_told(&recording), 0, "{held} {followed}");
        }
    }

    #[test]
    fn a_file_that_does_not_tell_is_as_another_of_the_machine_and_says_so() {
        let [(long, of_long), (short, of_short)] = [8000, 80].map(|n| made(n, 1.0, 0.0));
        assert_eq!(times_told(&short), 0, "{:?}", short.warnings);
        let whole = Recording::join(vec![long, short]).expect("one machine");
        assert_eq!(times_told(&whole), 2, "{:?}", whole.warnings);
        is_off(&whole.effort, &[of_long, of_short].concat());
    }
}
