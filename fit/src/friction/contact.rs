//! A model of friction behind play and creep, tick after tick or along a path.

use super::{Path, Transmission, Visitor};
use preslide::{Friction, Motion, ParamError};

/// A model behind a transmission at work, tick after tick.
struct Contact<M: Friction> {
    model: M,
    state: M::State,
    /// How far the contact creeps in a tick where the sinh is 1 (m or rad), and the force (N or N·m) where its argument is.
    creep: Option<(f64, f64)>,
    /// Half of the play (m or rad).
    half: f64,
    /// Where the load is (m or rad), and the force on it (N or N·m); before the first tick it is where the motor is.
    load: Option<f64>,
    force: f64,
}

impl<M: Friction<Scalar = f64>> Contact<M> {
    /// At rest, for ticks of `sample_time` (s).
    fn at_rest(model: M, transmission: Transmission, sample_time: f64) -> Result<Self, ParamError> {
        let creep = match (transmission.creep, model.limit()) {
            (None, _) => None,
            (Some((rate, share)), Some(limit)) if limit > 0.0 => {
                Some((rate * sample_time, share * limit))
            }
            (Some(creep), _) => {
                return Err(ParamError::new(
                    "rate of creep, of a friction model without a highest force,",
                    creep.0,
                    preslide::Bound::AtMost(0.0),
                ));
            }
        };
        Ok(Self {
            state: model.at_rest(),
            model,
            creep,
            half: 0.5 * transmission.gap,
            load: None,
            force: 0.0,
        })
    }

    /// The force (N or N·m) once the motor has come to `position`.
    fn step(&mut self, position: f64, velocity: f64) -> f64 {
        let Self { model, creep, .. } = self;
        // No creep is no displacement, whatever the force: 0·sinh would be no number beyond 710 stresses.
        let yielding = match creep {
            Some((most, stress)) if *most > 0.0 => *most * (self.force / *stress).sinh(),
            _ => 0.0,
        };
        let of = |displacement: f64| Motion {
            displacement: displacement - yielding,
            velocity,
        };
        let load = self.load.unwrap_or(position);
        let unloads = |displacement: f64| model.step(&mut self.state.clone(), of(displacement));
        let displacement = match self.half {
            0.0 => position - load,
            half => driven(load, position, half, self.force, &unloads),
        };
        self.load = Some(load + displacement);
        self.force = model.step(&mut self.state, of(displacement));
        self.force
    }
}

/// A path behind a transmission, to be run along.
pub(super) struct Driven<'a> {
    pub path: Path<'a>,
    pub transmission: Transmission,
}

impl Visitor for Driven<'_> {
    type Outcome = Result<Vec<f64>, ParamError>;

    fn visit<M: Friction<Scalar = f64>>(self, model: M) -> Self::Outcome {
        let path = self.path;
        let mut contact = Contact::at_rest(model, self.transmission, path.sample_time)?;
        let mut force = vec![0.0; path.position.len()];
        for piece in path.pieces {
            contact.load = None;
            for i in piece.clone() {
                force[i] = contact.step(path.position[i], path.velocity[i]);
            }
        }
        Ok(force)
    }
}

/// From position (m or rad) and velocity (m/s or rad/s) of a tick to the friction force (N or N·m).
pub type Tick = Box<dyn FnMut(f64, f64) -> f64 + Send>;

/// A contact to be called tick after tick.
pub(super) struct AtWork {
    pub transmission: Transmission,
    pub sample_time: f64,
}

impl Visitor for AtWork {
    type Outcome = Result<Tick, ParamError>;

    fn visit<M: Friction<Scalar = f64, State: Send> + Send + 'static>(
        self,
        model: M,
    ) -> Self::Outcome {
        let mut contact = Contact::at_rest(model, self.transmission, self.sample_time)?;
        Ok(Box::new(move |position, velocity| {
            contact.step(position, velocity)
        }))
    }
}

/// How far a load at `load` goes when the motor with its play of ± `half` is at `motor`, under the friction force `force`;
/// `after` is the force that a displacement would leave.
fn driven(load: f64, motor: f64, half: f64, force: f64, after: &dyn Fn(f64) -> f64) -> f64 {
    // It is held against the side that pushes it, and leaves that side where its friction is used up.
    let side = if force > 0.0 {
        motor - half
    } else if force < 0.0 {
        motor + half
    } else {
        load
    };
    let mut displacement = side - load;
    if displacement * force < 0.0 && after(displacement) * force < 0.0 {
        // Friction need not be linear in between: bisection, to the last bit or nearly so.
        let (mut near, mut far) = (0.0, displacement);
        for _ in 0..50 {
            let middle = 0.5 * (near + far);
            if after(middle) * force < 0.0 {
                far = middle;
            } else {
                near = middle;
            }
        }
        displacement = near;
    }
    (load + displacement).clamp(motor - half, motor + half) - load
}
