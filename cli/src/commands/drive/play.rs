//! `play`: a motion from a file, followed and recorded.

use super::arguments::PlayArgs;
use super::{Commanded, Failure, SAMPLES_PER_ROW};
use crate::commands::capture::{OnceWritten, machine, refuse_existing};
use crate::commands::outputs::{self, write_json};
use preslide_drive::{Motion, Play, Played, quantity};
use preslide_fit::model::keys_of;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{self, LoadOptions, Needs};
use preslide_host::capture::{Recorder, Scale, Summary};
use preslide_link::{Identity, Sample};
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl Commanded {
    /// Plays, and prints how closely the axis followed: RMS and largest error (10⁻⁹ m or rad).
    pub fn play(&mut self, play: &PlayArgs) -> Result<(f64, f64), Failure> {
        refuse_existing(&play.output, play.overwrite)?;
        outputs::check(
            &[&play.motion],
            &[("-o", Some(&play.output)), ("--json", play.json.as_ref())],
            None,
        )?;
        let identity = *self.drive.identity();
        let options = LoadOptions {
            needs: Needs::Motion,
            ..LoadOptions::default()
        };
        let read = recording::load(&play.motion, &options)?;
        let motion = Motion::new(&read.t_s, &read.position, identity.rate_hz)
            .map_err(|reason| Failure::Input(format!("{}: {reason}", play.motion.display())))?;
        let playing = Play {
            offset: self.offset(play.absolute, &motion, identity.count)?,
            unit: self.kind.unit(),
            every: every(play, &identity) as u16,
        };
        let mut following = Following::default();
        let (played, summary) = self.recorded(play, playing, &motion, &mut following)?;
        let path = play.output.display();
        tell!("wrote {path}");
        say!(
            "played {} points in {:.1} s, the buffer never below {}; {} samples in {} rows, {} missing.",
            played.points,
            motion.seconds(identity.rate_hz),
            played.lowest,
            summary.samples,
            summary.rows,
            summary.missing
        );
        let (rms, largest) = following.of(identity.count);
        say!(
            "following error: RMS {rms:.1} n{u}, largest {largest:.0} n{u}",
            u = self.kind.unit()
        );
        if let Some(path) = &play.json {
            let answer = json!({
                "schema": "preslide.play/1", "points": played.points, "length_s": motion.seconds(identity.rate_hz),
                "buffer_lowest": played.lowest, "following_rms_m": 1e-9 * rms, "following_max_m": 1e-9 * largest,
                "recorded": machine(&summary),
            });
            write_json(path, &keys_of(self.kind, answer))?;
        }
        Ok((rms, largest))
    }

    /// What is added to the motion's positions (m or rad): nothing where they are `absolute`, which the axis must then stand
    /// at; else what brings its start to where the axis stands.
    fn offset(&mut self, absolute: bool, motion: &Motion, count: f64) -> Result<f64, Failure> {
        let state = self.drive.state()?;
        let stands = state.position as f64 * count;
        if !absolute {
            return Ok(stands - motion.start());
        }
        if !state.located {
            return Err(Failure::Input(
                "--absolute needs an axis that knows where it is: `home` or `zero` first"
                    .to_owned(),
            ));
        }
        if (stands - motion.start()).abs() > 2.0 * count {
            return Err(Failure::Input(format!(
                "the motion begins at {} and the axis stands at {}: `move --to {:.9}` first",
                quantity::shown(motion.start(), self.kind.unit()),
                quantity::shown(stands, self.kind.unit()),
                motion.start()
            )));
        }
        Ok(0.0)
    }

    /// Plays and records to the file of `play`. What was recorded is kept whatever happened.
    fn recorded(
        &mut self,
        play: &PlayArgs,
        playing: Play,
        motion: &Motion,
        following: &mut Following,
    ) -> Result<(Played, Summary), Failure> {
        let identity = *self.drive.identity();
        let scale = Scale {
            motion: self.kind,
            sample_time_s: 1.0 / f64::from(identity.rate_hz),
            count: identity.count,
            effort_per_a: identity.effort_per_a.into(),
            every: (every(play, &identity) * SAMPLES_PER_ROW) as u32,
            after_s: 0.0,
        };
        let file = OnceWritten::new(&play.output, play.overwrite);
        let mut recorder = Recorder::new(file, &scale, None);
        let progress = Progress::new(
            "play, rows",
            (motion.seconds(identity.rate_hz) * play.rate) as u64,
        );
        let stop = Arc::clone(&self.stop);
        let mut failed: Option<Failure> = None;
        let played = playing.play(&mut self.drive, motion, |samples| {
            for sample in &samples {
                following.add(sample);
                if let Err(error) = recorder.take(sample) {
                    failed = Some(error.into());
                }
            }
            progress.inc((samples.len() as f64 / SAMPLES_PER_ROW) as u64);
            failed.is_some() || stop.load(Ordering::Relaxed)
        });
        progress.finish();
        let recorded = recorder.end(0);
        if let Some(error) = failed {
            return Err(error);
        }
        if let Err(error) = &played
            && recorded.is_ok()
        {
            let path = play.output.display();
            tell!("wrote {path} up to the interruption: {error}");
        }
        Ok((played?, recorded?))
    }
}

/// Ticks between samples for the rows a second that are asked for.
fn every(play: &PlayArgs, identity: &Identity) -> f64 {
    (f64::from(identity.rate_hz) / play.rate / SAMPLES_PER_ROW)
        .round()
        .max(1.0)
}

/// Reference less position, by the encoder.
#[derive(Default)]
struct Following {
    squares: f64,
    samples: u32,
    largest: f64,
}

impl Following {
    fn add(&mut self, sample: &Sample) {
        let error = sample.reference as f64 / 65_536.0 - f64::from(sample.position);
        self.squares += error * error;
        self.samples += 1;
        self.largest = self.largest.max(error.abs());
    }

    /// RMS and largest (10⁻⁹ m or rad) for this count.
    fn of(&self, count: f64) -> (f64, f64) {
        let rms = (self.squares / f64::from(self.samples.max(1))).sqrt();
        (rms * count * 1e9, self.largest * count * 1e9)
    }
}
