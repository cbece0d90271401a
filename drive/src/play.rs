//! A motion, streamed through the controller's buffer.

use crate::quantity::shown;
use crate::{Drive, DriveError};
use preslide_link::{POINTS, Points, Refusal, Reply, Request, Sample, State};
use std::time::Duration;

/// A motion on an even grid of the controller's ticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    ticks: u16,
    /// Positions (m or rad), the first being where it begins.
    positions: Vec<f64>,
}

/// Longest time between two points (ticks): the link's.
const LONGEST: f64 = 65_535.0;

impl Motion {
    /// From times (s) and positions (m or rad), for a controller of `rate_hz`. What is not on an even grid is laid on one by cubic
    /// pieces (Catmull and Rom) through its points.
    ///
    /// # Errors
    /// What is wrong, with the row (counted from 1) where it is.
    pub fn new(times: &[f64], positions: &[f64], rate_hz: u32) -> Result<Self, String> {
        if times.len() < 3 || times.len() != positions.len() {
            return Err("a motion takes at least three rows".to_owned());
        }
        if let Some(row) = positions
            .iter()
            .chain(times)
            .position(|value| !value.is_finite())
        {
            return Err(format!("row {}: not a number", row % times.len() + 1));
        }
        if let Some(row) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(format!("row {}: time does not increase", row + 2));
        }
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let median = steps[steps.len() / 2];
        let ticks = (median * f64::from(rate_hz)).round().clamp(1.0, LONGEST);
        let step = ticks / f64::from(rate_hz);
        // A grid's time stamps are printed with few digits.
        let even =
            |(row, time): (usize, &f64)| (time - times[0] - row as f64 * step).abs() < 0.01 * step;
        let positions = if times.iter().enumerate().all(even) {
            positions.to_vec()
        } else {
            resample(times, positions, step)
        };
        Ok(Self {
            ticks: ticks as u16,
            positions,
        })
    }

    /// Points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// There is always a motion.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Duration (s) on a controller of `rate_hz`.
    pub fn seconds(&self, rate_hz: u32) -> f64 {
        self.positions.len() as f64 * f64::from(self.ticks) / f64::from(rate_hz)
    }

    /// Where it begins (m or rad).
    pub fn start(&self) -> f64 {
        self.positions[0]
    }

    /// Checks it against the axis's limits: largest speed, acceleration, and, where it is played, travel.
    ///
    /// # Errors
    /// The limit that is exceeded most, and the row where.
    pub fn check(&self, rate_hz: u32, limits: &Limits, play: &Play) -> Result<(), String> {
        let Play { offset, unit, .. } = *play;
        let step = f64::from(self.ticks) / f64::from(rate_hz);
        let speeds: Vec<f64> = self
            .positions
            .windows(2)
            .map(|p| (p[1] - p[0]) / step)
            .collect();
        let accelerations = speeds.windows(2).map(|v| (v[1] - v[0]) / step);
        let largest = |values: &mut dyn Iterator<Item = f64>| {
            let values = values.map(f64::abs).enumerate();
            values
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((0, 0.0))
        };
        let (row, speed) = largest(&mut speeds.iter().copied());
        if speed > limits.speed {
            return Err(format!(
                "row {}: {} is faster than limits.speed, {}; plan it slower",
                row + 2,
                shown(speed, &format!("{unit}/s")),
                shown(limits.speed, &format!("{unit}/s"))
            ));
        }
        let (row, acceleration) = largest(&mut accelerations.into_iter());
        if acceleration > limits.acceleration {
            return Err(format!(
                "row {}: {} is more than limits.acceleration, {}; plan it more gently",
                row + 2,
                shown(acceleration, &format!("{unit}/s²")),
                shown(limits.acceleration, &format!("{unit}/s²"))
            ));
        }
        let ends = limits.travel.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let beyond = |x: &f64| *x + offset < ends.0 || *x + offset > ends.1;
        match self.positions.iter().position(beyond) {
            Some(row) => Err(format!(
                "row {}: {} is beyond the travel, {} to {}",
                row + 1,
                shown(self.positions[row] + offset, unit),
                shown(ends.0, unit),
                shown(ends.1, unit)
            )),
            None => Ok(()),
        }
    }
}

/// What a motion must not exceed (SI).
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    speed: f64,
    acceleration: f64,
    travel: Option<(f64, f64)>,
}

impl Limits {
    /// The controller's. Travel only where it is located.
    fn of(drive: &mut Drive, located: bool) -> Result<Self, DriveError> {
        let mut get = |name| drive.get(name);
        let speed = get("limits.speed")?.unwrap_or(f64::INFINITY);
        let acceleration = get("limits.acceleration")?.unwrap_or(f64::INFINITY);
        let travel = get("limits.travel_low")?.zip(get("limits.travel_high")?);
        Ok(Self {
            speed,
            acceleration,
            travel: travel.filter(|_| located),
        })
    }
}

/// Cubic pieces on a grid of `step`.
fn resample(times: &[f64], positions: &[f64], step: f64) -> Vec<f64> {
    let last = times.len() - 1;
    let points = ((times[last] - times[0]) / step).floor() as usize + 1;
    let slope = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
        (positions[b] - positions[a]) / (times[b] - times[a])
    };
    let mut piece = 0;
    (0..points)
        .map(|point| {
            let t = times[0] + point as f64 * step;
            while piece + 2 <= last && times[piece + 1] <= t {
                piece += 1;
            }
            let h = times[piece + 1] - times[piece];
            let s = ((t - times[piece]) / h).clamp(0.0, 1.0);
            let (a, b) = (positions[piece], positions[piece + 1]);
            let (va, vb) = (h * slope(piece), h * slope(piece + 1));
            let r = 1.0 - s;
            a * r * r * (1.0 + 2.0 * s) + b * s * s * (3.0 - 2.0 * s) + va * s * r * r
                - vb * s * s * r
        })
        .collect()
}

/// How a motion was played.
#[derive(Clone, Copy, Debug)]
pub struct Played {
    /// Points sent, rests at either end included.
    pub points: usize,
    /// Least that the buffer held while the motion ran (points).
    pub lowest: u16,
    /// How the controller was at the end.
    pub state: State,
}

/// How to play.
#[derive(Clone, Copy, Debug)]
pub struct Play {
    /// Add this to every position (m or rad).
    pub offset: f64,
    /// Of positions, for messages.
    pub unit: &'static str,
    /// Telemetry of every so many ticks.
    pub every: u16,
}

impl Play {
    /// Plays a motion from where the axis stands. `take` is given the telemetry, and says whether to stop. The controller's
    /// limits are checked first.
    ///
    /// # Errors
    /// [`DriveError::Motion`], [`DriveError::Stopped`], [`DriveError::Fault`], [`DriveError::Dry`], or as [`Drive::ask`]. The axis
    /// stands then, or is stopped by the controller as soon as it hears no more.
    pub fn play(
        &self,
        drive: &mut Drive,
        motion: &Motion,
        mut take: impl FnMut(Vec<Sample>) -> bool,
    ) -> Result<Played, DriveError> {
        let before = drive.state()?;
        let (count, room) = (drive.identity().count, drive.identity().room);
        let limits = Limits::of(drive, before.located)?;
        motion
            .check(drive.identity().rate_hz, &limits, self)
            .map_err(DriveError::Motion)?;
        drive.ask(Request::Telemetry { every: self.every })?;
        drive.take_samples();
        let raw = |x: f64| ((x + self.offset) / count * 65_536.0).round() as i64;
        // Rests fill the buffer before the motion begins, and end it; one frame more than is needed at the end brings the
        // reference to rest.
        let lead = usize::from(room / 2).next_multiple_of(POINTS);
        let last = motion.positions.len() - 1;
        let total = (lead + motion.positions.len() + 2).next_multiple_of(POINTS) + POINTS;
        let at = |point: usize| raw(motion.positions[point.saturating_sub(lead).min(last)]);
        let (mut stopped, mut lowest) = (false, room);
        for first in (0..total).step_by(POINTS) {
            let mut steps = [0; POINTS - 1];
            for (step, point) in steps.iter_mut().zip(first..) {
                *step = i32::try_from(at(point + 1) - at(point)).unwrap_or(i32::MAX);
            }
            let points = Points {
                ticks: motion.ticks,
                first: at(first),
                steps,
            };
            let reply = send(drive, points, first == 0, &mut take, &mut stopped)?;
            if stopped {
                break;
            }
            if let Reply::Done { room: left } = reply
                && first > lead
                && first < total - usize::from(room)
            {
                // Before this frame.
                lowest = lowest.min((room - left).saturating_sub(POINTS as u16));
            }
        }
        let waited = drive.wait(|| false);
        stopped |= take(drive.take_samples());
        let state = waited?;
        if stopped {
            return Err(DriveError::Stopped);
        }
        match state.dropped.wrapping_sub(before.dropped) {
            0 => Ok(Played {
                points: total,
                lowest,
                state,
            }),
            dropped => Err(DriveError::Dry(dropped)),
        }
    }
}

/// Sends points when the buffer has room; hands on telemetry meanwhile. Where even the `first` are refused there was no motion, and nothing is of it.
fn send(
    drive: &mut Drive,
    points: Points,
    first: bool,
    take: &mut impl FnMut(Vec<Sample>) -> bool,
    stopped: &mut bool,
) -> Result<Reply, DriveError> {
    loop {
        let answer = drive.ask(Request::Points(points));
        let is_busy = matches!(&answer, Err(DriveError::Refused { refusal, .. }) if *refusal == Refusal::Busy);
        let is_moving = !first || is_busy || answer.is_ok();
        if is_moving && take(drive.take_samples()) {
            drive.stop()?;
            *stopped = true;
            return Ok(Reply::Done { room: 0 });
        }
        match answer {
            Err(_) if is_busy => {
                drive.listen(Duration::from_millis(2))?;
            }
            Err(error @ DriveError::Refused { .. }) => {
                // A fault or a stream that ran dry says more than the refusal that follows from it.
                return Err(drive.state()?.fault.map_or(error, DriveError::Fault));
            }
            answer => return answer,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use preslide_link::{
        Deframer, Identity, LARGEST_FRAME, Mode, Numbered, PROTOCOL, Report, ResetCause, encode,
    };
    use std::collections::VecDeque;
    use std::io::{ErrorKind, Read, Write};

    #[test]
    fn an_even_grid_is_taken_as_it_is_and_another_is_laid_on_one() {
        let times: Vec<f64> = (0..40).map(|i| f64::from(i) * 0.0025).collect();
        let x = |t: f64| 1e-3 * (20.0 * t).sin();
        let positions: Vec<f64> = times.iter().map(|t| x(*t)).collect();
        let motion = Motion::new(&times, &positions, 20_000).expect("a motion");
        assert_eq!((motion.ticks, motion.len()), (50, 40));
        assert_eq!(motion.positions, positions);
        let uneven: Vec<f64> = times.iter().map(|t| t + 4e-4 * (500.0 * t).sin()).collect();
        let positions: Vec<f64> = uneven.iter().map(|t| x(*t)).collect();
        let motion = Motion::new(&uneven, &positions, 20_000).expect("a motion");
        let step = f64::from(motion.ticks) / 20_000.0;
        let worst = motion
            .positions
            .iter()
            .enumerate()
            .map(|(i, p)| (p - x(uneven[0] + i as f64 * step)).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 2e-6, "{worst}");
    }

    #[test]
    fn what_cannot_be_played_is_named_with_its_row() {
        assert!(Motion::new(&[0.0, 1.0], &[0.0, 1.0], 1000).is_err());
        let back = Motion::new(&[0.0, 1.0, 0.5], &[0.0; 3], 1000).expect_err("time runs back");
        assert!(back.starts_with("row 3"), "{back}");
        let nan =
            Motion::new(&[0.0, 1.0, 2.0], &[0.0, f64::NAN, 0.0], 1000).expect_err("not a number");
        assert!(nan.starts_with("row 2"), "{nan}");
        let motion =
            Motion::new(&[0.0, 0.1, 0.2, 0.3], &[0.0, 0.0, 1e-3, 1e-3], 1000).expect("a motion");
        let limits = |speed, acceleration, high| Limits {
            speed,
            acceleration,
            travel: Some((-1.0, high)),
        };
        let raised = Play {
            offset: 0.5,
            unit: "m",
            every: 1,
        };
        let says = |limits: Limits| {
            motion
                .check(1000, &limits, &raised)
                .expect_err("beyond a limit")
        };
        assert!(says(limits(5e-3, 1.0, 1.0)).contains("row 3"));
        assert!(says(limits(1.0, 0.01, 1.0)).contains("limits.acceleration"));
        assert!(says(limits(1.0, 1.0, 0.5005)).contains("travel"));
        assert_eq!(motion.check(1000, &limits(1.0, 1.0, 1.0), &raised), Ok(()));
    }
    /// Its telemetry runs, and it takes no motion.
    #[derive(Default)]
    struct DisabledAxis {
        heard: Deframer,
        says: VecDeque<u8>,
    }

    impl DisabledAxis {
        fn say(&mut self, report: Report) {
            let mut frame = [0; LARGEST_FRAME];
            let length = encode(&report, &mut frame).expect("a frame");
            self.says.extend(&frame[..length]);
        }
    }

    impl Read for DisabledAxis {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            match self.says.is_empty() {
                true => Err(ErrorKind::TimedOut.into()),
                false => self.says.read(buffer),
            }
        }
    }

    impl Write for DisabledAxis {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            for byte in bytes {
                let Some(Ok(Numbered { id, request })) = self.heard.push(*byte) else {
                    continue;
                };
                let reply = match request {
                    Request::Hello => Reply::Identity(Identity {
                        protocol: PROTOCOL,
                        rate_hz: 1000,
                        count: 1e-6,
                        effort_per_a: 1.0,
                        room: 32,
                        saved: false,
                        model: 0,
                    }),
                    Request::State => Reply::State(State {
                        mode: Mode::Disabled,
                        fault: None,
                        located: false,
                        silent: false,
                        reset: ResetCause::Power,
                        tick: 0,
                        position: 0,
                        queued: 0,
                        dropped: 0,
                        missed: 0,
                        supply: 0,
                        current: 0,
                    }),
                    Request::Telemetry { .. } => Reply::Done { room: 32 },
                    Request::Points(_) => Reply::Refused(Refusal::NotEnabled),
                    _ => Reply::Refused(Refusal::NoParameter),
                };
                self.say(Report::Sample(Sample {
                    sequence: 0,
                    dropped: 0,
                    tick: 0,
                    position: 0,
                    reference: 0,
                    code: 0,
                    current: 0,
                    supply: 0,
                    fault: None,
                    range: None,
                    level: 0,
                }));
                self.say(Report::Answer { id, reply });
            }
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_motion_that_is_refused_from_the_start_gives_nothing_to_record() {
        let mut drive = Drive::begin(Box::new(DisabledAxis::default())).expect("a controller");
        let motion = Motion::new(&[0.0, 0.1, 0.2], &[0.0; 3], 1000).expect("a motion");
        let (play, mut taken) = (
            Play {
                offset: 0.0,
                unit: "m",
                every: 1,
            },
            0,
        );
        let refused = play.play(&mut drive, &motion, |samples| {
            taken += samples.len();
            false
        });
        let error = refused.expect_err("refused").to_string();
        assert!(
            error.contains("`enable` first") && taken == 0,
            "{error}, {taken}"
        );
    }
}
