//! A model at work: the force that a motion takes, the motion that a force causes, and a reference followed in closed loop.

pub mod closed;
mod forward;
pub mod inverse;
mod present;
pub mod ramp;
mod starts;

use crate::effects::Effect;
use crate::friction::FrictionModel;
use crate::model::{Measured, Model};
use crate::recording::{EffortRole, MotionKind, Recording};
use crate::report::figures::{quantity, significant};
use crate::signal::Kinematics;
use crate::statistics::nmse;

pub use forward::motion_with_inertia;
pub use starts::motion_from_each;

/// A simulated recording.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Linear or rotary.
    pub kind: MotionKind,
    /// What its forces are.
    pub effort: EffortRole,
    /// Time \[s\].
    pub t_s: Vec<f64>,
    /// Position (m or rad).
    pub position: Vec<f64>,
    /// Velocity (m/s or rad/s); `None` where the force is the input: in the quasi-static limit it plays no part.
    pub velocity: Option<Vec<f64>>,
    /// Force \[N\] or torque (N·m): inertia, friction, viscous part and constant force.
    pub force: Vec<f64>,
    /// The force was the input.
    pub from_force: bool,
    /// How well it meets the measured effort, where there is one.
    pub agreement: Option<Agreement>,
    /// The position that the motion is compared with (m or rad).
    pub measured_position: Option<Vec<f64>>,
    /// How far the motion lies from the measured one, where a force was the input and the recording has a position.
    pub position_error: Option<PositionError>,
    /// How far the axis is from its reference, where it follows one in closed loop.
    pub following: Option<Following>,
    /// Where the body slid away; the columns end before it.
    pub breakaway: Option<Breakaway>,
    /// What the user should know, a sentence without its full stop each.
    pub notes: Vec<String>,
}

/// A measured effort against the simulated force.
#[derive(Clone, Debug)]
pub struct Agreement {
    /// Measured (N or N·m), filtered like the acceleration where it contains inertia, as `identify` does.
    pub measured: Vec<f64>,
    /// Simulated, filtered alike; without inertia where the measured effort is friction.
    pub simulated: Vec<f64>,
    /// NMSE (13) (%) between the two.
    pub nmse: f64,
    /// Root mean square of their difference (N or N·m).
    pub rms: f64,
}

/// A simulated motion against the measured one.
#[derive(Clone, Copy, Debug)]
pub struct PositionError {
    /// Root mean square of their difference (m or rad), over the samples that were not given.
    pub rmse: f64,
    /// Mean magnitude of their difference (m or rad).
    pub mean_abs: f64,
    /// NMSE (13) (%) between the two, over the same samples.
    pub nmse: f64,
    /// Samples at the start that were given.
    pub given: usize,
}

/// A simulated motion against its reference, at the controller's ticks.
#[derive(Clone, Copy, Debug)]
pub struct Following {
    /// Root mean square of their difference (m or rad).
    pub rms: f64,
    /// Its largest magnitude (m or rad).
    pub max: f64,
}

/// The moment at which friction can no longer hold the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Time \[s\], interpolated between samples.
    pub time_s: f64,
    /// The applied force (N or N·m) then.
    pub force: f64,
}

/// The force that a motion takes: `inertia·a + friction + viscous·v + constant force` and every effect, velocity and acceleration by
/// the zero-phase filter of `identify`.
///
/// # Errors
/// A model of the other kind of axis, a parameter that the library refuses, or an effect that needs a column that the
/// recording does not have.
pub fn force_of_motion(model: &Model, recording: &Recording) -> Result<Simulation, String> {
    model.check_fits(recording)?;
    let kinematics = Kinematics::of(recording);
    let (path, filter) = (kinematics.path(recording), &kinematics.filter);
    let measured = Measured {
        t_s: Some(&recording.t_s),
        acceleration: Some(&kinematics.acceleration),
        temperature_c: recording.temperature_c.as_deref(),
        load_n: recording.load_n.as_deref(),
    };
    let force = model
        .force_along(path, &measured)
        .map_err(|e| format!("{}: {e}", recording.name))?;
    let mut notes = vec![format!(
        "Velocity and acceleration by a zero-phase low-pass at {:.1} Hz, chosen from the position's noise",
        filter.cutoff_hz()
    )];
    notes.extend(at_the_ends(recording, &kinematics));
    if !recording.effort.is_empty() {
        notes.extend(recording.per_unit().map(|per| match model.effort_unit {
            Some(_) => per,
            None => format!(
                "The model states no effort_unit, so it is taken to have the recording's: {per}"
            ),
        }));
    }
    let agreement = (!recording.effort.is_empty())
        .then(|| agreement(model, recording, &kinematics, &measured, &force))
        .transpose()?;
    Ok(Simulation {
        kind: recording.kind,
        effort: model.effort(),
        t_s: recording.t_s.clone(),
        position: recording.position.clone(),
        force,
        velocity: Some(kinematics.velocity),
        from_force: false,
        agreement,
        measured_position: None,
        position_error: None,
        following: None,
        breakaway: None,
        notes,
    })
}

/// What is not known at the ends of a motion that does not rest there.
fn at_the_ends(recording: &Recording, kinematics: &Kinematics) -> Option<String> {
    /// Share of the top speed below which the noise of an encoder is taken for a rest.
    const RESTS: f64 = 0.02;
    let speeds = &kinematics.velocity;
    let top = speeds.iter().fold(0.0, |top: f64, v| top.max(v.abs()));
    let moves = |piece: &std::ops::Range<usize>| {
        let ends = [piece.start, piece.end.saturating_sub(1)];
        ends.iter()
            .any(|&i| speeds.get(i).is_some_and(|v| v.abs() > RESTS * top))
    };
    let reach = kinematics.filter.reach(recording) as f64 * recording.sample_time_s();
    recording.pieces.iter().any(moves).then(|| {
        format!(
            "The motion begins or ends moving: velocity and acceleration are uncertain within {} of there, and friction begins without tension, which it had",
            quantity(reach, "s")
        )
    })
}

/// The measured effort beside `force`, the simulated one: filtered alike where it contains inertia, and friction beside friction where
/// it does not.
fn agreement(
    model: &Model,
    recording: &Recording,
    kinematics: &Kinematics,
    columns: &Measured,
    force: &[f64],
) -> Result<Agreement, String> {
    let (measured, simulated) = if recording.role.contains_inertia() {
        let filter = &kinematics.filter;
        // What comes from velocity and acceleration has been through the filter already.
        let rigid: Vec<f64> = kinematics
            .velocity
            .iter()
            .zip(&kinematics.acceleration)
            .map(|(v, a)| model.inertia * a + model.viscous * v + model.constant_force)
            .collect();
        let rest: Vec<f64> = force.iter().zip(&rigid).map(|(f, r)| f - r).collect();
        let simulated = filter
            .smooth(&rest)
            .iter()
            .zip(&rigid)
            .map(|(f, r)| f + r)
            .collect();
        (filter.smooth(&recording.effort), simulated)
    } else {
        let friction = Measured {
            acceleration: None,
            ..*columns
        };
        let simulated = model.force_along(kinematics.path(recording), &friction)?;
        (recording.effort.clone(), simulated)
    };
    let rows: Vec<usize> = (0..measured.len()).collect();
    let error = measured
        .iter()
        .zip(&simulated)
        .map(|(m, s)| (m - s).powi(2));
    Ok(Agreement {
        nmse: nmse(&measured, &simulated, &rows),
        rms: (error.sum::<f64>() / measured.len() as f64).sqrt(),
        measured,
        simulated,
    })
}

/// A simulated position against the measured one, from `given` samples on.
fn position_error(simulated: &[f64], measured: &[f64], given: usize) -> PositionError {
    let rows: Vec<usize> = (given..measured.len()).collect();
    let apart = || rows.iter().map(|&i| simulated[i] - measured[i]);
    let count = rows.len() as f64;
    PositionError {
        rmse: (apart().map(|e| e * e).sum::<f64>() / count).sqrt(),
        mean_abs: apart().map(f64::abs).sum::<f64>() / count,
        nmse: nmse(measured, simulated, &rows),
        given,
    }
}

/// The motion that a slowly varying force causes, from rest at 0 in a body that was never moved: inertia and viscous
/// friction play no part, and the friction force balances the applied one less the constant force.
///
/// `sample_time` \[s\] is the time between samples, for models in which time matters.
///
/// # Errors
/// A parameter that the library refuses, or an effect that depends on more than velocity: that is not inverted.
pub fn motion_of_force(
    model: &Model,
    t_s: &[f64],
    force: &[f64],
    sample_time: f64,
) -> Result<Simulation, String> {
    let at_rest = |effect: &&Effect| !effect.form.of_speed;
    let effects: Vec<&str> = model
        .effects
        .iter()
        .filter(at_rest)
        .map(Effect::id)
        .collect();
    if !effects.is_empty() {
        return Err(format!(
            "force → motion takes no effects, and the model has {}; simulate the force of a motion (--motion), or remove them from the model",
            effects.join(", ")
        ));
    }
    let mut inverse = inverse::inverse(&model.friction, sample_time).map_err(|e| e.to_string())?;
    let mut simulation = Simulation {
        kind: model.motion,
        effort: model.effort(),
        t_s: Vec::new(),
        position: Vec::new(),
        velocity: None,
        force: Vec::new(),
        from_force: true,
        agreement: None,
        measured_position: None,
        position_error: None,
        following: None,
        breakaway: None,
        notes: time_dependence(model),
    };
    if let Some(first) = force.first().filter(|f| **f != model.constant_force) {
        simulation.notes.push(format!(
            "The first force, {}, less the constant force, {}, acts at once on a body that was never moved",
            significant(*first),
            significant(model.constant_force)
        ));
    }
    let mut position = 0.0;
    let mut last: Option<(f64, f64)> = None;
    for (&t, &f) in t_s.iter().zip(force) {
        match inverse.advance(f - model.constant_force) {
            Ok(displacement) => position += displacement,
            Err(away) => {
                let at = model.constant_force + away.limit.copysign(f - model.constant_force);
                let time_s = match last {
                    Some((t0, f0)) if f != f0 => {
                        t0 + ((at - f0) / (f - f0)).clamp(0.0, 1.0) * (t - t0)
                    }
                    _ => t,
                };
                simulation.breakaway = Some(Breakaway { time_s, force: at });
                break;
            }
        }
        simulation.t_s.push(t);
        simulation.position.push(position);
        simulation.force.push(f);
        last = Some((t, f));
    }
    Ok(simulation)
}

/// What the quasi-static limit leaves out or keeps of time.
fn time_dependence(model: &Model) -> Vec<String> {
    let mut notes = Vec::new();
    match &model.friction {
        FrictionModel::Coulomb { .. } => notes.push(
            "Coulomb friction has no pre-sliding: the body does not move below the Coulomb force".to_owned(),
        ),
        FrictionModel::LuGre { .. } => notes.push(
            "LuGre in the quasi-static limit: σp·dz/dt and the Stribeck effect vanish with the velocity, so time does not enter".to_owned(),
        ),
        FrictionModel::Hsieh(_) => notes.push(
            "Hsieh's model depends on time: C_v acts on the velocity of every step and the plastic module creeps while the force is held, so the motion changes with the ramp's rate".to_owned(),
        ),
        FrictionModel::Gms { sliding: Some(_), .. } => notes.push(
            "GMS in the quasi-static limit: blocks slip at α_i·F_s, the Stribeck effect and frictional lag begin with sliding, so time does not enter".to_owned(),
        ),
        other if other.sliding().is_some() => notes.push(
            "The model in its quasi-static limit: damping, Stribeck effect and lag vanish with the velocity, so time does not enter".to_owned(),
        ),
        _ => {}
    }
    if model.inertia > 0.0 || model.viscous != 0.0 || !model.effects.is_empty() {
        notes.push(
            "Inertia, viscous friction and drag are left out: the force is taken to vary slowly"
                .to_owned(),
        );
    }
    notes
}
