//! From force to motion with inertia: the whole model file in time.
//!
//! `M·(v₁ − v₀)/dt = F − R(x₀ + dt·v₁, v₁)`, `x₁ = x₀ + dt·v₁`: the velocity at the end of the step is the root, so a stiff
//! contact and standstill need no small steps. First order in `dt`; the step is halved until the motion no longer changes.

use super::{Simulation, position_error};
use crate::effects::Effect;
use crate::effects::form::{self, Form};
use crate::friction::Visitor;
use crate::model::Model;
use crate::recording::Recording;
use crate::report::figures::quantity;
use crate::statistics::earlier;
use preslide::{Friction, Motion};

/// Steps within a sample that are tried first, and most of them.
pub(super) const FIRST: u32 = 4;
const MOST: u32 = 256;

/// Change of the position on halving the step, relative to the travel, that is small enough.
const SETTLED: f64 = 1e-3;

/// The velocity is found to this share of the largest that the step could reach.
const ROOT: f64 = 1e-10;

/// Effects whose forward simulation would take a second body.
static TWO_BODIES: [&Form; 3] = [&form::DRIVE_COMPLIANCE, &form::BACKLASH, &form::CREEP];

/// The motion that a recorded force causes. Where the recording has a position too, its first `given` samples are taken as they
/// are, start the motion and load the friction; the rest is compared and never looked at.
///
/// # Errors
/// A model without inertia or of the other kind of axis, effects that need what one moving body does not have, a parameter that
/// the library refuses.
pub fn motion_with_inertia(
    model: &Model,
    recording: &Recording,
    given: usize,
) -> Result<Simulation, String> {
    model.check_fits(recording)?;
    one_body(model)?;
    let piece = recording.pieces[0].clone();
    let mut notes = Vec::new();
    if recording.pieces.len() > 1 {
        notes.push(format!(
            "Only the first {} of {} samples are simulated: then some are missing",
            piece.len(),
            recording.len()
        ));
    }
    let t_s = &recording.t_s[piece.clone()];
    let sample_time = recording.sample_time_s();
    let force = applied(model, &recording.effort[piece.clone()], sample_time);
    let measured = recording.position.get(piece).unwrap_or_default();
    let given = given.clamp(1, t_s.len()).min(measured.len().max(1));
    let (head, velocity) = match measured.get(..given) {
        Some(head) => (head.to_vec(), end_slope(head, sample_time)),
        None => (vec![0.0], 0.0),
    };
    let settled = settled(|steps: u32| {
        let run = Run {
            model,
            force: &force,
            head: &head,
            velocity,
            sample_time,
            steps,
        };
        model.forward_law(sample_time / f64::from(steps), run)
    })?;
    let (position, velocity) = settled.motion;
    notes.push(format!(
        "Forward dynamics with {} steps a sample; half as many move the position by {} of its travel",
        settled.steps,
        quantity(100.0 * settled.change, "%")
    ));
    let position_error =
        (measured.len() > given).then(|| position_error(&position, measured, given));
    if let Some(error) = &position_error {
        notes.push(format!(
            "Started from the first {given} measured positions; the rest is simulated without looking at them: {} RMSE",
            quantity(error.rmse, recording.position_unit())
        ));
    }
    Ok(Simulation {
        kind: recording.kind,
        effort: model.effort(),
        t_s: t_s.to_vec(),
        position,
        velocity: Some(velocity),
        force: recording.effort[..t_s.len()].to_vec(),
        from_force: true,
        agreement: None,
        measured_position: position_error.is_some().then(|| measured.to_vec()),
        position_error,
        following: None,
        breakaway: None,
        notes,
    })
}

/// A motion that finer steps no longer change.
struct Settled {
    /// Position and velocity at every sample.
    motion: (Vec<f64>, Vec<f64>),
    /// Steps within a sample.
    steps: u32,
    /// What half as many steps change of the position, relative to the travel.
    change: f64,
}

/// Doubles the steps of `run` until the position no longer changes.
fn settled<E>(run: impl Fn(u32) -> Result<(Vec<f64>, Vec<f64>), E>) -> Result<Settled, E> {
    let mut steps = FIRST;
    let mut motion = run(steps)?;
    let mut change = f64::INFINITY;
    while steps < MOST {
        steps *= 2;
        let finer = run(steps)?;
        let apart = motion.0.iter().zip(&finer.0).map(|(a, b)| (a - b).abs());
        let [low, high] = super::present::range(&finer.0);
        change = apart.fold(0.0, f64::max) / (high - low);
        motion = finer;
        if change <= SETTLED || change.is_nan() {
            break;
        }
    }
    Ok(Settled {
        motion,
        steps,
        // A body that does not move has no travel.
        change: if change.is_nan() { 0.0 } else { change },
    })
}

/// Refuses a model that is not one body that can move.
pub(super) fn one_body(model: &Model) -> Result<(), String> {
    if model.inertia <= 0.0 {
        return Err("the model has no inertia; identify it from a motion that accelerates, or give it by hand in [inertia]".to_owned());
    }
    let two: Vec<&str> = model
        .effects
        .iter()
        .filter(|e| TWO_BODIES.contains(&e.form))
        .map(Effect::id)
        .collect();
    if !two.is_empty() {
        return Err(format!(
            "{} is between two moving bodies, and this simulation has one; remove it from the model",
            two.join(", ")
        ));
    }
    Ok(())
}

/// The force that reaches the body from the recorded command.
pub(super) fn applied(model: &Model, recorded: &[f64], sample_time: f64) -> Vec<f64> {
    let mut force = recorded.to_vec();
    for effect in model.of(&form::CHANNEL_DELAY) {
        // What is recorded now acted that much earlier.
        force = earlier(&force, effect.get("delay_s") / sample_time);
    }
    force.iter_mut().for_each(|f| *f = acting(model, *f));
    force
}

/// The force that acts on the body where `force` is commanded: what the drive's limits leave of it.
pub(super) fn acting(model: &Model, mut force: f64) -> f64 {
    for effect in model.of(&form::ACTUATOR_SATURATION) {
        let limit = effect.get("limit_N");
        force = force.clamp(-limit, limit);
    }
    for effect in model.of(&form::ACTUATOR_DEAD_ZONE) {
        let half = 0.5 * effect.get("width_N");
        force = force.signum() * (force.abs() - half).max(0.0);
    }
    force
}

/// The slope at the end of the parabola through the samples (least squares).
pub(super) fn end_slope(head: &[f64], sample_time: f64) -> f64 {
    if head.len() < 3 {
        return match head {
            [a, b] => (b - a) / sample_time,
            _ => 0.0,
        };
    }
    let n = head.len();
    let t = |i: usize| (i as f64 - (n - 1) as f64) * sample_time;
    let rows = nalgebra::DMatrix::from_fn(n, 3, |i, j| t(i).powi(j as i32));
    let fit = rows
        .svd(true, true)
        .solve(&nalgebra::DVector::from_column_slice(head), 1e-12);
    fit.map_or(0.0, |c| c[1])
}

/// A moving body with what its friction remembers.
pub(super) struct Body<L: Friction<Scalar = f64>> {
    /// Position (m or rad).
    pub(super) x: f64,
    /// Velocity (m/s or rad/s).
    pub(super) v: f64,
    pub(super) resistance: f64,
    pub(super) state: L::State,
}

impl<L: Friction<Scalar = f64>> Body<L> {
    /// At a place that nothing has moved it to.
    pub(super) fn at(law: &L, x: f64, v: f64) -> Self {
        let mut state = law.at_rest();
        law.set_position(&mut state, x);
        Self {
            x,
            v,
            resistance: 0.0,
            state,
        }
    }

    /// Is led to the next measured position in so many steps of `dt` (s); its friction remembers all of them.
    pub(super) fn lead(&mut self, law: &L, to: f64, steps: u32, dt: f64) {
        let from = self.x;
        let displacement = (to - from) / f64::from(steps);
        let motion = Motion {
            displacement,
            velocity: displacement / dt,
        };
        for step in 1..=steps {
            law.set_position(&mut self.state, from + f64::from(step) * displacement);
            self.resistance = law.step(&mut self.state, motion);
        }
        (self.x, self.v) = (to, motion.velocity);
    }

    /// Goes on by one implicit step of `dt` (s) under `force` (N or N·m). Compiled once a law, and not once for each that calls it.
    #[inline(never)]
    pub(super) fn advance(&mut self, law: &L, inertia: f64, force: f64, dt: f64) {
        let (x, v) = (self.x, self.v);
        let take = |state: &mut L::State, v: f64| {
            law.set_position(state, x + dt * v);
            law.step(
                state,
                Motion {
                    displacement: dt * v,
                    velocity: v,
                },
            )
        };
        let start = &self.state;
        let excess = |v1: f64| inertia * (v1 - v) / dt - force + take(&mut start.clone(), v1);
        let guess = v + dt / inertia * (force - self.resistance);
        self.v = root(&excess, guess, dt / inertia);
        self.resistance = take(&mut self.state, self.v);
        self.x += dt * self.v;
    }
}

struct Run<'a> {
    model: &'a Model,
    force: &'a [f64],
    head: &'a [f64],
    velocity: f64,
    sample_time: f64,
    steps: u32,
}

impl Visitor for Run<'_> {
    /// Position and velocity at every sample.
    type Outcome = (Vec<f64>, Vec<f64>);

    fn visit<L: Friction<Scalar = f64>>(self, law: L) -> Self::Outcome {
        let dt = self.sample_time / f64::from(self.steps);
        let mut body = Body::at(&law, self.head[0], self.velocity);
        // Given samples have the velocity that leads from one to the next.
        let first = match self.head {
            [first, second, ..] => (second - first) / self.sample_time,
            _ => self.velocity,
        };
        let (mut positions, mut velocities) = (vec![body.x], vec![first]);
        for &place in &self.head[1..] {
            body.lead(&law, place, self.steps, dt);
            positions.push(body.x);
            velocities.push(body.v);
        }
        body.v = self.velocity;
        for pair in self.force[self.head.len() - 1..].windows(2) {
            for step in 0..self.steps {
                let part = (f64::from(step) + 0.5) / f64::from(self.steps);
                let force = pair[0] + part * (pair[1] - pair[0]);
                let force = force * self.model.given_of_command(body.x);
                body.advance(&law, self.model.inertia, force, dt);
            }
            positions.push(body.x);
            velocities.push(body.v);
        }
        (positions, velocities)
    }
}

/// The velocity at which `excess`, which grows with it by at least `1/mobility`, is zero. Compiled once, and not once a law.
fn root(excess: &dyn Fn(f64) -> f64, guess: f64, mobility: f64) -> f64 {
    let first = excess(guess);
    if first == 0.0 || !first.is_finite() {
        return guess;
    }
    // Growing at least so fast it is zero within this distance.
    let mut other = guess - mobility * first;
    let mut at_other = excess(other);
    let (mut low, mut high) = ((guess, first), (other, at_other));
    let mut width = (other - guess).abs();
    // Friction that falls with speed may grow more slowly: look further.
    for _ in 0..60 {
        if low.1 * at_other <= 0.0 || !at_other.is_finite() {
            break;
        }
        width *= 2.0;
        other = guess - width.copysign(first);
        at_other = excess(other);
        high = (other, at_other);
    }
    if low.0 > high.0 {
        std::mem::swap(&mut low, &mut high);
    }
    let close = ROOT * (width + guess.abs());
    // Illinois: the secant, with the end that stays halved.
    let mut side = 0;
    for _ in 0..100 {
        if high.0 - low.0 <= close {
            break;
        }
        let middle = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let middle = if middle.is_finite() {
            middle.clamp(low.0, high.0)
        } else {
            0.5 * (low.0 + high.0)
        };
        let value = excess(middle);
        if value == 0.0 || (middle - low.0).min(high.0 - middle) <= 0.01 * close {
            return middle;
        }
        if value > 0.0 {
            high = (middle, value);
            low.1 *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        } else {
            low = (middle, value);
            high.1 *= if side == -1 { 0.5 } else { 1.0 };
            side = -1;
        }
    }
    0.5 * (low.0 + high.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::FrictionModel;
    use crate::recording::{LoadOptions, MotionKind, Needs, load_csv};

    fn recording(force: impl Fn(f64) -> f64, seconds: f64) -> Recording {
        let rows: String = (0..(seconds * 1e3) as usize)
            .map(|i| format!("{},{:e}\n", i as f64 * 1e-3, force(i as f64 * 1e-3)))
            .collect();
        let options = LoadOptions {
            needs: Needs::Effort,
            ..LoadOptions::default()
        };
        load_csv(
            format!("t_s,force_N\n{rows}").as_bytes(),
            "force.csv",
            &options,
        )
        .expect("valid")
    }

    fn body(friction: FrictionModel) -> Model {
        Model {
            inertia: 2.0,
            ..Model::of_friction(MotionKind::Linear, friction)
        }
    }

    /// `M·dv/dt = F − F_c − b·v` from rest, and standstill below the breakaway force.
    #[test]
    fn a_sliding_body_follows_its_exponential_and_a_held_one_stays() {
        let model = Model {
            viscous: 4.0,
            ..body(FrictionModel::Coulomb { coulomb: 3.0 })
        };
        let found = motion_with_inertia(&model, &recording(|_| 5.0, 2.0), 1).expect("valid");
        for (t, x) in found.t_s.iter().zip(&found.position) {
            let exact = 0.5 * (t - 0.5 * (1.0 - (-2.0 * t).exp()));
            assert!((x - exact).abs() < 1e-3, "{t} s: {x} for {exact}");
        }
        let held = motion_with_inertia(&model, &recording(|t| 2.9 * (20.0 * t).sin(), 2.0), 1)
            .expect("valid");
        assert!(
            held.position.iter().all(|x| x.abs() < 1e-9),
            "{:?}",
            held.position.last()
        );
    }

    /// A contact of 1e8 N/m under 2 kg rings at 1.1 kHz: no explicit step of 0.25 ms survives it.
    #[test]
    fn a_stiff_contact_stays_at_its_static_displacement() {
        let friction = FrictionModel::maxwell_slip(&[1e8, 1e6], &[1e-8, 2e-6]);
        let found = motion_with_inertia(
            &body(friction),
            &recording(|t| 1.5 * (t / 0.5).min(1.0), 1.5),
            1,
        )
        .expect("valid");
        let last = found.position[found.position.len() - 1];
        // 1 N of the stiff block has yielded, the soft one carries the rest.
        assert!((last / 5e-7 - 1.0).abs() < 0.02, "{last:e}");
    }

    /// An axis that starts from rest is at rest in the first row, and the page draws the measured position beside the simulated one.
    #[test]
    fn given_samples_have_their_own_velocity_and_the_measured_position_is_drawn() {
        let model = body(FrictionModel::Coulomb { coulomb: 1.0 });
        let velocity = |t: f64| 0.2 * (4.0 * t).sin();
        let rows: String = (0..3000)
            .map(|i| {
                let t = f64::from(i) * 1e-3;
                let (x, a) = (0.05 * (1.0 - (4.0 * t).cos()), 0.8 * (4.0 * t).cos());
                format!("{t},{x:e},{:e}\n", 2.0 * a + f64::signum(velocity(t)))
            })
            .collect();
        let text = format!("t_s,x_m,force_N\n{rows}");
        let recording =
            load_csv(text.as_bytes(), "rest.csv", &LoadOptions::default()).expect("valid");
        let found = motion_with_inertia(&model, &recording, 20).expect("valid");
        let simulated = found.velocity.as_ref().expect("a velocity");
        for (t, v) in found.t_s.iter().zip(simulated).take(20) {
            assert!((v - velocity(*t)).abs() < 1e-3, "{t} s: {v}");
        }
        let page = found.page("rest.csv", String::new());
        let drawn = page.sections[0].figures.iter();
        let drawn = drawn.filter(|f| f.title == "Position over time");
        let measured = drawn.flat_map(|f| &f.series).find(|s| s.name == "measured");
        assert_eq!(measured.map(|s| &s.y), Some(&recording.position));
    }

    /// Started from some samples of a motion, the simulation goes on with it.
    #[test]
    fn a_recorded_start_is_taken_up_and_the_rest_compared() {
        let model = body(FrictionModel::Coulomb { coulomb: 1.0 });
        let rows: String = (0..3000)
            .map(|i| {
                let t = f64::from(i) * 1e-3;
                let (x, v, a) = (
                    0.1 * (4.0 * t).sin(),
                    0.4 * (4.0 * t).cos(),
                    -1.6 * (4.0 * t).sin(),
                );
                format!("{t},{x:e},{:e}\n", 2.0 * a + f64::signum(v))
            })
            .collect();
        let text = format!("t_s,x_m,force_N\n{rows}");
        let recording =
            load_csv(text.as_bytes(), "swing.csv", &LoadOptions::default()).expect("valid");
        let found = motion_with_inertia(&model, &recording, 20).expect("valid");
        let error = found.position_error.expect("compared");
        assert!(error.rmse < 1e-3, "{error:?}");
        let two = Model {
            effects: vec![Effect::new("backlash", &[("gap_m", 1e-6)]).expect("valid")],
            ..model
        };
        let refused = motion_with_inertia(&two, &recording, 20).expect_err("two bodies");
        assert!(refused.contains("backlash"), "{refused}");
    }
}
