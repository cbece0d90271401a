//! The effects in the source: their parameters and bounds as constants, and the calls that build them.

use super::{Options, Source, Term, literal};
use crate::effects::Effect;
use crate::model::Model;
use std::fmt::Write as _;

/// Most by which a measured temperature or load may change the friction level of an exported model (-).
const LEVEL_LIMIT: f64 = 0.5;

/// The bound of forces that grow with speed or position, in breakaway forces, where none is given: far above what the
/// terms give on a healthy axis, and below what a drive could take for a fault.
const BREAKAWAYS: f64 = 10.0;

const FORCE_LIMIT: &str = "FORCE_LIMIT";
const LEVEL_BOUND: &str = "LEVEL_LIMIT";

/// What stands beside the friction model in a controller: the viscous term, the constant force, the effects.
pub fn carried(model: &Model) -> Vec<Effect> {
    let alone = |id, key: &str, value: f64| Effect {
        id,
        values: vec![(key.to_owned(), value)],
    };
    let mut effects = Vec::new();
    if model.viscous != 0.0 {
        effects.push(alone("viscous", "viscous_N_s_per_m", model.viscous));
    }
    if model.constant_force != 0.0 {
        effects.push(alone("constant_force", "force_N", model.constant_force));
    }
    effects.extend(model.effects.iter().cloned());
    effects
}

impl Source<'_> {
    pub(super) fn effects(&mut self, options: &Options) -> Result<(), String> {
        let effects = carried(self.model);
        self.bounds(&effects, options)?;
        for (i, effect) in effects.iter().enumerate() {
            let before = effects[..i].iter().filter(|e| e.id == effect.id).count();
            let id = if before == 0 {
                effect.id.to_owned()
            } else {
                format!("{}_{}", effect.id, before + 1)
            };
            self.effect(effect, &id);
        }
        Ok(())
    }

    /// The constants of the bounds that `effects` need.
    fn bounds(&mut self, effects: &[Effect], options: &Options) -> Result<(), String> {
        let needed = |bound| effects.iter().any(|e| shape(e).1.contains(&bound));
        if needed(FORCE_LIMIT) {
            let breakaway = self.model.friction.breakaway();
            let limit = options.limit.or(breakaway.map(|f| BREAKAWAYS * f));
            let limit = limit.filter(|l| l.is_finite() && *l > 0.0).ok_or(
                "--limit: give the bound of each force that grows with speed or position, above zero (N or N·m); this model has no breakaway force to take it from",
            )?;
            self.constant(
                FORCE_LIMIT,
                "Bound of each force that grows with speed or position (N or N·m)",
                limit,
            );
        }
        if needed(LEVEL_BOUND) {
            self.constant(
                LEVEL_BOUND,
                "Most by which temperature or load may change the friction level (-)",
                LEVEL_LIMIT,
            );
        }
        Ok(())
    }

    fn effect(&mut self, effect: &Effect, id: &str) {
        let (kind, arguments) = shape(effect);
        let build: Vec<String> = arguments
            .iter()
            .map(|argument| self.argument(effect, id, argument))
            .collect();
        let of_terms = match effect.cosines().len() {
            0 => "S".to_owned(),
            n => format!("{n}, S"),
        };
        self.terms.push(Term {
            kind: format!("::preslide::effects::{kind}<{of_terms}>"),
            build: format!(
                "::preslide::effects::{kind}::try_new({})?",
                build.join(", ")
            ),
        });
    }

    /// An argument of an effect's constructor; where it is a parameter, its constant is written.
    fn argument(&mut self, effect: &Effect, id: &str, argument: &str) -> String {
        let named = |key: &str| {
            let (key, id) = (key.to_uppercase(), id.to_uppercase());
            match key.starts_with(&id) {
                true => key,
                false => format!("{id}_{key}"),
            }
        };
        match argument {
            FORCE_LIMIT | LEVEL_BOUND | "sample_time" | "units" | "2.0" => argument.to_owned(),
            "cosines" => {
                let name = named("COSINES");
                let cosines: Vec<String> = effect.cosines().into_iter().map(literal).collect();
                let _ = writeln!(
                    self.constants,
                    "/// The cosines of `{}`.\npub const {name}: [f64; {}] = [{}];",
                    effect.id,
                    cosines.len(),
                    cosines.join(", ")
                );
                name
            }
            key => {
                let own = self.model.key(key);
                let name = named(&own);
                let said = format!("`{own}` of `{}`", effect.id);
                self.constant(&name, &said, effect.get(key));
                name
            }
        }
    }
}

/// The library's type, and the arguments of its constructor: keys, and what is no key.
fn shape(effect: &Effect) -> (&'static str, &'static [&'static str]) {
    match effect.id {
        "viscous" => ("Viscous", &["viscous_N_s_per_m", FORCE_LIMIT, "units"]),
        "constant_force" => ("ConstantForce", &["force_N", "units"]),
        "coulomb_asymmetry" => ("CoulombAsymmetry", &["asymmetry"]),
        "quadratic_drag" => ("QuadraticDrag", &["drag_N_s2_per_m2", FORCE_LIMIT, "units"]),
        "stribeck" => ("Stribeck", &["level", "velocity_m_s", "exponent", "units"]),
        "frictional_lag" => (
            "FrictionalLag",
            &[
                "level",
                "velocity_m_s",
                "exponent",
                "time_constant_s",
                "sample_time",
                "units",
            ],
        ),
        "position_spring" => (
            "PositionSpring",
            &["stiffness_N_per_m", "centre_m", FORCE_LIMIT, "units"],
        ),
        "position_force" => ("PositionForce", &["from_m", "to_m", "cosines", "units"]),
        "position_friction" => ("PositionFriction", &["from_m", "to_m", "cosines", "units"]),
        "local_friction_spot" => (
            "LocalFrictionSpot",
            &["level", "position_m", "width_m", "units"],
        ),
        "periodic_force" => (
            "PeriodicForce",
            &["force_N", "period_m", "phase_rad", "units"],
        ),
        "gravity" => ("Gravity", &["force_N", "angle_rad", "units"]),
        "periodic_friction" => (
            "PeriodicFriction",
            &["level", "period_m", "phase_rad", "units"],
        ),
        "encoder_error" => (
            "EncoderError",
            &["error_m", "period_m", "phase_rad", "units"],
        ),
        "thermal_drift" if effect.has("level_per_K") => (
            "ThermalDrift",
            &["level_per_K", "temperature_C", LEVEL_BOUND],
        ),
        "thermal_drift" => ("WarmUp", &["level", "time_constant_s", "sample_time"]),
        // Two decades of ageing: what single precision adds up in ticks of 50 µs, for time constants up to some seconds.
        "dwell_aging" => (
            "DwellAging",
            &[
                "level_per_decade",
                "time_constant_s",
                "erasing_path_m",
                "2.0",
                "sample_time",
                "units",
            ],
        ),
        "load_dependent_friction" => (
            "LoadDependentFriction",
            &["level_per_N", "load_N", LEVEL_BOUND, "units"],
        ),
        // `refused` was asked before; the source of an id that neither knows does not compile, and a test compiles all.
        _ => ("EffectWithoutType", &[]),
    }
}
