//! A model's effects at work, tick after tick: how they change the friction level, and the forces beside friction.

use super::Model;
use crate::effects::Effect;
use crate::effects::form;
use crate::effects::term::Term;
use preslide::effects::Situation;

/// The effects that have a level or a force, with viscous and constant force.
#[derive(Clone)]
pub(super) struct Running {
    /// Each with whether its force comes from speed.
    terms: Vec<(Term, bool)>,
    viscous: f64,
    constant: f64,
    gear: Option<Gear>,
}

/// Friction of what a gear transmits to the load.
#[derive(Clone, Copy)]
struct Gear {
    share: f64,
    /// Inertia (kg or kg·m²) behind the gear.
    load: f64,
    /// Friction (N or N·m) of the whole sliding contact, which gives the direction.
    breakaway: f64,
}

impl Running {
    /// The effects of a model for ticks so far apart (s).
    pub(super) fn of(model: &Model, sample_time: f64) -> Result<Self, String> {
        let mut terms = Vec::new();
        for effect in &model.effects {
            let id = effect.id();
            let term = effect.term(sample_time);
            let term = term.map_err(|e| format!("effect {id}: {e}"))?;
            let of_speed = effect.form.of_speed;
            terms.extend(term.map(|term| (term, of_speed)));
        }
        let gear = model.of(&form::TRANSMITTED_FRICTION).next();
        Ok(Self {
            terms,
            viscous: model.viscous,
            constant: model.constant_force,
            gear: gear.map(|effect| Gear::of(effect, model)).transpose()?,
        })
    }

    /// The friction level (-), the force (N or N·m) of load and place, and that of speed, which acts on the motor's side of a gear.
    pub(super) fn tick(&mut self, at: &Situation<f64>) -> [f64; 3] {
        let mut sums = [1.0, self.constant, self.viscous * at.velocity];
        for (term, of_speed) in &mut self.terms {
            let (level, force) = term(at);
            sums[0] += level;
            sums[if *of_speed { 2 } else { 1 }] += force;
        }
        sums
    }

    /// The whole force (N or N·m) of a tick, with `spring` from elsewhere as a part of it: friction at its level and every force beside it, that of
    /// an `inertia` (kg or kg·m²) at an acceleration among them.
    pub(super) fn whole(
        &mut self,
        at: &Situation<f64>,
        spring: f64,
        inertia: f64,
        acceleration: f64,
    ) -> f64 {
        let [level, load, of_speed] = self.tick(at);
        level.max(0.0) * at.friction
            + spring
            + load
            + of_speed
            + inertia * acceleration
            + self.of_transmitted(at.friction, load, acceleration)
    }

    /// Whether something depends on what is transmitted.
    pub(super) fn has_gear(&self) -> bool {
        self.gear.is_some()
    }

    /// Friction (N or N·m) of what the gear transmits to a load of `load` (N or N·m) that it accelerates, too, in the direction of `friction`.
    pub(super) fn of_transmitted(&self, friction: f64, load: f64, acceleration: f64) -> f64 {
        self.gear.map_or(0.0, |gear| {
            let transmitted = gear.load * acceleration + load;
            gear.share * transmitted.abs() * friction / gear.breakaway
        })
    }
}

impl Gear {
    fn of(effect: &Effect, model: &Model) -> Result<Self, String> {
        let motor = effect.get("motor_mass_kg");
        let breakaway = model.friction.breakaway().filter(|force| *force > 0.0);
        let refused = |what: &str| format!("effect {}: {what}", effect.id());
        if model.inertia > 0.0 && motor >= model.inertia {
            return Err(refused(&format!(
                "the motor's inertia, {motor}, must be below the whole one, {}",
                model.inertia
            )));
        }
        Ok(Self {
            share: effect.get("share_of_transmitted"),
            load: (model.inertia - motor).max(0.0),
            breakaway: breakaway.ok_or_else(|| {
                refused("needs a friction model with a force at which it breaks away")
            })?,
        })
    }
}
