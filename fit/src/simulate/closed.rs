//! A reference followed in closed loop: the library's feedback ([`Pid`]) around the whole model file.
//!
//! The controller ticks at its own rate and holds its force between ticks; it sees position and velocity as they are, without
//! encoder and without delay. Between ticks the body moves by the implicit steps of `forward`, halved until the
//! following error no longer changes.

use super::forward::{Body, acting, one_body};
use super::{Following, Simulation, position_error};
use crate::effects::form;
use crate::friction::Visitor;
use crate::model::{self, Model};
use crate::recording::Recording;
use crate::report::figures::quantity;
use preslide::control::{Pid, PidGains, PidState, Saturation};
use preslide::{Friction, Units};
use serde::Deserialize;
use std::path::Path;

/// Most steps between two ticks.
const MOST: u32 = 256;

/// Change of the following error on halving the step, relative to its largest value, that is small enough.
const SETTLED: f64 = 1e-2;

/// Following errors beyond so many times the reference's travel are those of an unstable loop.
const RUNAWAY: f64 = 10.0;

/// A controller as its file describes it: linear keys, or rotary ones in their place.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    schema: String,
    /// Ticks per second (Hz).
    #[serde(rename = "rate_Hz")]
    pub rate_hz: f64,
    /// `K_p` (N/m or N·m/rad).
    #[serde(rename = "proportional_N_per_m", alias = "proportional_Nm_per_rad")]
    pub proportional: f64,
    /// `K_i` (N/(m·s) or N·m/(rad·s)).
    #[serde(
        default,
        rename = "integral_N_per_m_s",
        alias = "integral_Nm_per_rad_s"
    )]
    pub integral: f64,
    /// `K_d` (N·s/m or N·m·s/rad).
    #[serde(
        default,
        rename = "derivative_N_s_per_m",
        alias = "derivative_Nm_s_per_rad"
    )]
    pub derivative: f64,
    /// Position error (m or rad) within which the integral holds.
    #[serde(default, rename = "deadband_m", alias = "deadband_rad")]
    pub deadband: f64,
    /// Largest force (N or N·m), of the integral too.
    #[serde(rename = "limit_N", alias = "limit_Nm")]
    pub limit: f64,
}

/// What a controller file calls itself.
const SCHEMA: &str = "preslide.controller/1";

impl Controller {
    /// Reads a controller's file.
    ///
    /// # Errors
    /// The file, the key and the reason, for the user.
    pub fn load(path: &Path) -> Result<Self, String> {
        let file = path.display();
        let text = model::read(path).map_err(|e| format!("{file}: {e}"))?;
        Self::parse(&text).map_err(|e| format!("{file}: {e}"))
    }

    /// Reads the text of a controller's file.
    ///
    /// # Errors
    /// The key and the reason, for the user.
    pub fn parse(text: &str) -> Result<Self, String> {
        let read: Self = toml::from_str(text).map_err(|e| {
            format!(
                "{e}it needs schema = \"{SCHEMA}\", rate_Hz, proportional_N_per_m and limit_N, and may have integral_N_per_m_s, derivative_N_s_per_m and deadband_m (on a rotary axis _Nm_per_rad and so on)"
            )
        })?;
        if read.schema != SCHEMA {
            return Err(format!("schema `{}` is not {SCHEMA}", read.schema));
        }
        for (key, value) in [("rate_Hz", read.rate_hz), ("limit_N", read.limit)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{key} = {value}: must be finite and above zero"));
            }
        }
        Ok(read)
    }

    pub(crate) fn pid(&self) -> Result<Pid<f64>, String> {
        let gains = PidGains {
            proportional: self.proportional,
            integral: self.integral,
            derivative: self.derivative,
            integral_limit: self.limit,
            deadband: self.deadband,
        };
        Pid::try_new(&gains, 1.0 / self.rate_hz, Units::SI).map_err(|e| e.to_string())
    }
}

/// The motion of an axis that follows the recording's reference, its position where it has none. Where the recording has both,
/// the simulated motion is compared with the measured one.
///
/// # Errors
/// A model without inertia or of the other kind of axis, effects that need two bodies, gains that the library refuses, a loop
/// that is not stable.
pub fn motion_in_loop(
    model: &Model,
    recording: &Recording,
    controller: &Controller,
) -> Result<Simulation, String> {
    model.check_fits(recording)?;
    one_body(model)?;
    let piece = recording.pieces[0].clone();
    if piece.len() < 2 {
        return Err(format!(
            "{}: a gap follows the first sample; cut the file there",
            recording.name
        ));
    }
    let t_s = &recording.t_s[piece.clone()];
    let measured = &recording.position[piece.clone()];
    let reference = match &recording.reference {
        Some(reference) => &reference[piece],
        None => measured,
    };
    let pid = controller.pid()?;
    let tick = 1.0 / controller.rate_hz;
    let wanted = at_ticks(t_s, reference, tick);
    let run = |steps: u32| {
        let run = Loop {
            model,
            pid: &pid,
            limit: controller.limit,
            tick,
            wanted: &wanted,
            steps,
        };
        model.forward_law(tick / f64::from(steps), run)
    };
    let mut steps = 1;
    let mut found = run(steps)?;
    let mut change = f64::INFINITY;
    while steps < MOST && change > SETTLED {
        steps *= 2;
        let finer = run(steps)?;
        let apart = found.x.iter().zip(&finer.x).map(|(a, b)| (a - b).abs());
        change = apart.fold(0.0, f64::max) / largest(&finer, &wanted);
        found = finer;
    }
    stable(&found, &wanted, reference, tick, &recording.name)?;
    let of = |values: &[f64]| sampled(t_s, values, tick);
    let position = of(&found.x);
    let position_error =
        (recording.reference.is_some()).then(|| position_error(&position, measured, 0));
    Ok(Simulation {
        kind: recording.kind,
        effort: model.effort(),
        t_s: t_s.to_vec(),
        velocity: Some(of(&found.v)),
        force: of(&found.force),
        following: Some(following(&found, &wanted)),
        position,
        from_force: true,
        agreement: None,
        measured_position: position_error.is_some().then(|| measured.to_vec()),
        position_error,
        breakaway: None,
        notes: notes(model, recording, steps, change),
    })
}

fn notes(model: &Model, recording: &Recording, steps: u32, change: f64) -> Vec<String> {
    let mut notes = vec![
        format!(
            "In closed loop with {steps} steps a tick; half as many move the position by {} of the largest following error",
            quantity(100.0 * change, "%")
        ),
        "The controller sees the true position and velocity: no encoder, no delay, no feed-forward"
            .to_owned(),
    ];
    if recording.pieces.len() > 1 {
        notes.push("Only the samples before the first gap are simulated".to_owned());
    }
    if model.of(&form::CHANNEL_DELAY).next().is_some() {
        notes.push(
            "The channel's delay is left out: it is the recording's, not the axis's".to_owned(),
        );
    }
    notes
}

/// What a limit leaves of a force (N or N·m), and what it cut.
pub(crate) fn limited(asked: f64, limit: f64) -> (f64, Saturation) {
    let cut = match asked {
        a if a > limit => Saturation::Above,
        a if a < -limit => Saturation::Below,
        _ => Saturation::None,
    };
    (asked.clamp(-limit, limit), cut)
}

/// Reference and its velocity at every tick: cubic between samples, with the slopes of their neighbours.
pub(crate) fn at_ticks(t_s: &[f64], reference: &[f64], tick: f64) -> Vec<[f64; 2]> {
    let last = t_s.len() - 1;
    let slope = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
        (reference[b] - reference[a]) / (t_s[b] - t_s[a])
    };
    let ticks = ((t_s[last] - t_s[0]) / tick).floor() as usize + 1;
    let mut i = 0;
    let at = |k: usize| {
        let t = t_s[0] + k as f64 * tick;
        while i + 1 < last && t_s[i + 1] <= t {
            i += 1;
        }
        let h = t_s[i + 1] - t_s[i];
        let s = (t - t_s[i]) / h;
        let (x0, x1, m0, m1) = (
            reference[i],
            reference[i + 1],
            h * slope(i),
            h * slope(i + 1),
        );
        let rise = x1 - x0;
        let (c2, c3) = (3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise);
        [
            x0 + s * (m0 + s * (c2 + s * c3)),
            (m0 + s * (2.0 * c2 + 3.0 * s * c3)) / h,
        ]
    };
    (0..ticks).map(at).collect()
}

/// Values at ticks, brought to the recording's times.
pub(crate) fn sampled(t_s: &[f64], values: &[f64], tick: f64) -> Vec<f64> {
    let at = |t: &f64| {
        let place = (t - t_s[0]) / tick;
        let low = (place.floor() as usize).min(values.len() - 1);
        let high = (low + 1).min(values.len() - 1);
        values[low] + (place - low as f64).min(1.0) * (values[high] - values[low])
    };
    t_s.iter().map(at).collect()
}

fn errors<'a>(found: &'a Track, wanted: &'a [[f64; 2]]) -> impl Iterator<Item = f64> + 'a {
    found.x.iter().zip(wanted).map(|(x, [r, _])| r - x)
}

fn largest(found: &Track, wanted: &[[f64; 2]]) -> f64 {
    errors(found, wanted).fold(f64::MIN_POSITIVE, |most: f64, e| most.max(e.abs()))
}

fn following(found: &Track, wanted: &[[f64; 2]]) -> Following {
    let squares: f64 = errors(found, wanted).map(|e| e * e).sum();
    Following {
        rms: (squares / wanted.len() as f64).sqrt(),
        max: largest(found, wanted),
    }
}

fn stable(
    found: &Track,
    wanted: &[[f64; 2]],
    reference: &[f64],
    tick: f64,
    name: &str,
) -> Result<(), String> {
    let [low, high] = super::present::range(reference);
    let limit = RUNAWAY * (high - low);
    let away = errors(found, wanted).position(|e| e.is_nan() || e.abs() > limit);
    match away {
        Some(k) if limit > 0.0 => Err(format!(
            "{name}: the loop is not stable with these gains: {:.4} s after the start the error exceeds {RUNAWAY} times the reference's travel; lower the gains, or raise the rate",
            k as f64 * tick
        )),
        _ => Ok(()),
    }
}

/// Position, velocity and commanded force at every tick.
struct Track {
    x: Vec<f64>,
    v: Vec<f64>,
    force: Vec<f64>,
}

struct Loop<'a> {
    model: &'a Model,
    pid: &'a Pid<f64>,
    limit: f64,
    tick: f64,
    wanted: &'a [[f64; 2]],
    steps: u32,
}

impl Visitor for Loop<'_> {
    type Outcome = Track;

    fn visit<L: Friction<Scalar = f64>>(self, law: L) -> Track {
        let dt = self.tick / f64::from(self.steps);
        let mut body = Body::at(&law, self.wanted[0][0], 0.0);
        let (mut memory, mut cut) = (PidState::new(), Saturation::None);
        let mut track = Track {
            x: Vec::with_capacity(self.wanted.len()),
            v: Vec::with_capacity(self.wanted.len()),
            force: Vec::with_capacity(self.wanted.len()),
        };
        for [r, speed] in self.wanted {
            let asked = self.pid.step(&mut memory, r - body.x, speed - body.v, cut);
            let force;
            (force, cut) = limited(asked, self.limit);
            track.x.push(body.x);
            track.v.push(body.v);
            track.force.push(force);
            let force = acting(self.model, force) * self.model.given_of_command(body.x);
            for _ in 0..self.steps {
                body.advance(&law, self.model.inertia, force, dt);
            }
        }
        track
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::FrictionModel;
    use crate::recording::{LoadOptions, MotionKind, Needs, load_csv};

    const GAINS: &str = "schema = \"preslide.controller/1\"\nrate_Hz = 20000\nproportional_N_per_m = 5000\nderivative_N_s_per_m = 120\nlimit_N = 500\n";

    fn reference(x: impl Fn(f64) -> f64) -> Recording {
        let rows: String = (0..4000)
            .map(|i| f64::from(i) * 1e-3)
            .map(|t| format!("{t:.3},{:e}\n", x(t)))
            .collect();
        let options = LoadOptions {
            needs: Needs::Motion,
            ..LoadOptions::default()
        };
        let text = format!("t_s,x_m\n{rows}");
        load_csv(text.as_bytes(), "reference.csv", &options).expect("valid")
    }

    fn body(coulomb: f64) -> Model {
        Model {
            inertia: 2.0,
            viscous: 15.0,
            ..Model::of_friction(MotionKind::Linear, FrictionModel::Coulomb { coulomb })
        }
    }

    /// Largest, RMS and mean deviation over the second half, when the start has died out.
    fn deviation(found: &Simulation, exact: impl Fn(f64) -> f64) -> [f64; 3] {
        let pairs = found.t_s.iter().zip(&found.position).skip(2000);
        let apart: Vec<f64> = pairs.map(|(t, x)| x - exact(*t)).collect();
        let n = apart.len() as f64;
        [
            apart.iter().fold(0.0, |most: f64, a| most.max(a.abs())),
            (apart.iter().map(|a| a * a).sum::<f64>() / n).sqrt(),
            apart.iter().sum::<f64>() / n,
        ]
    }

    /// Without Coulomb friction the loop is linear: the response to a sine is that of `(K_d·s + K_p)/(m·s² + (c + K_d)·s + K_p)`.
    #[test]
    fn a_linear_loop_follows_its_transfer_function() {
        let controller = Controller::parse(GAINS).expect("valid");
        let w = 18.0;
        let recording = reference(|t| 0.01 * (w * t).sin());
        let found = motion_in_loop(&body(0.0), &recording, &controller).expect("stable");
        let (p, d) = (controller.proportional, controller.derivative);
        let top = nalgebra::Complex::new(p, d * w);
        let whole = top / nalgebra::Complex::new(p - 2.0 * w * w, (15.0 + d) * w);
        let exact = |t: f64| 0.01 * whole.norm() * (w * t + whole.arg()).sin();
        let [most, rms, bias] = deviation(&found, exact);
        println!("sine: max {most:.2e}, RMS {rms:.2e}, bias {bias:.2e} m");
        // Half a tick of holding at 0.18 m/s is 4.5 µm, and the loop keeps a part of that; the step adds its first-order share.
        assert!(
            most < 5e-6 && rms < 3.5e-6 && bias.abs() < 1e-7,
            "{most:e} {rms:e} {bias:e}"
        );
    }

    /// At constant speed the proportional gain alone carries Coulomb and viscous friction: `e = (F_c + c·v)/K_p`.
    #[test]
    fn friction_at_constant_speed_leaves_its_following_error() {
        let controller = Controller::parse(GAINS).expect("valid");
        let found =
            motion_in_loop(&body(3.0), &reference(|t| 0.05 * t), &controller).expect("stable");
        let error = (3.0 + 15.0 * 0.05) / controller.proportional;
        let [most, rms, bias] = deviation(&found, |t| 0.05 * t - error);
        println!("ramp: max {most:.2e}, RMS {rms:.2e}, bias {bias:.2e} m");
        assert!(
            most < 1e-7 && rms < 1e-7 && bias.abs() < 1e-7,
            "{most:e} {rms:e} {bias:e}"
        );
    }

    #[test]
    fn an_unstable_loop_and_a_wrong_file_are_refused() {
        let wild = GAINS
            .replace("20000", "50")
            .replace("limit_N = 500", "limit_N = 5e6");
        let wild = Controller::parse(&wild.replace("= 5000", "= 500000")).expect("valid");
        let recording = reference(|t| 0.01 * (18.0 * t).sin());
        let told = motion_in_loop(&body(0.0), &recording, &wild).expect_err("unstable");
        assert!(told.contains("not stable"), "{told}");
        for (from, to, part) in [
            ("limit_N = 500", "limit_N = -1", "limit_N"),
            ("rate_Hz = 20000", "rate = 20000", "rate_Hz"),
            ("controller/1", "controller/9", "controller/9"),
        ] {
            let told = Controller::parse(&GAINS.replace(from, to)).expect_err(to);
            assert!(told.contains(part), "{told}");
        }
    }
}
