//! The library's terms at work, chosen at run time.

use super::{Effect, MOST_TERMS};
use preslide::effects::{
    self, ConstantForce, CoulombAsymmetry, DwellAging, EncoderError, ExternalVibration,
    FrictionalLag, Gravity, LARGEST_LEVEL, LoadDependentFriction, LocalFrictionSpot, PeriodicForce,
    PeriodicFriction, PositionForce, PositionFriction, PositionSpring, QuadraticDrag, RunIn,
    Situation, Stribeck, ThermalDrift, WarmUp,
};
use preslide::{ParamError, Units};

/// An effect at work: change of the friction level (-) and force (N or N·m) of a tick.
pub(crate) trait Tick: FnMut(&Situation<f64>) -> (f64, f64) + Send {
    /// A copy with the memory of this moment.
    fn copy(&self) -> Term;
}

pub(crate) type Term = Box<dyn Tick>;

impl<T: FnMut(&Situation<f64>) -> (f64, f64) + Clone + Send + 'static> Tick for T {
    fn copy(&self) -> Term {
        Box::new(self.clone())
    }
}

/// Forces that grow without bound in the library need one; on the host it is out of the way.
pub(crate) const FAR: f64 = 1e12;

fn term<E>(effect: E) -> Option<Term>
where
    E: effects::Effect<f64, State: Send + 'static> + Clone + Send + 'static,
{
    let mut state = effect.at_rest();
    Some(Box::new(move |at: &Situation<f64>| {
        (effect.level(&mut state, at), effect.force(&mut state, at))
    }))
}

/// The term of an effect for samples `sample_time` (s) apart; `None` where it is neither a level nor a force.
///
/// # Errors
/// Which parameter the library refuses.
pub(crate) fn library(effect: &Effect, sample_time: f64) -> Result<Option<Term>, ParamError> {
    let u = Units::SI;
    let get = |key| effect.get(key);
    Ok(match effect.id {
        "constant_force" => term(ConstantForce::try_new(get("force_N"), u)?),
        "coulomb_asymmetry" => term(CoulombAsymmetry::try_new(get("asymmetry"))?),
        "quadratic_drag" => term(QuadraticDrag::try_new(get("drag_N_s2_per_m2"), FAR, u)?),
        "stribeck" => term(Stribeck::try_new(
            get("level"),
            get("velocity_m_s"),
            get("exponent"),
            u,
        )?),
        "frictional_lag" => term(FrictionalLag::try_new(
            get("level"),
            get("velocity_m_s"),
            get("exponent"),
            get("time_constant_s"),
            sample_time,
            u,
        )?),
        "position_spring" => term(PositionSpring::try_new(
            get("stiffness_N_per_m"),
            get("centre_m"),
            FAR,
            u,
        )?),
        "position_force" => term(PositionForce::try_new(
            get("from_m"),
            get("to_m"),
            padded(effect),
            u,
        )?),
        "position_friction" => term(PositionFriction::try_new(
            get("from_m"),
            get("to_m"),
            padded(effect),
            u,
        )?),
        "local_friction_spot" => term(LocalFrictionSpot::try_new(
            get("level"),
            get("position_m"),
            get("width_m"),
            u,
        )?),
        "periodic_force" => term(PeriodicForce::try_new(
            get("force_N"),
            get("period_m"),
            get("phase_rad"),
            u,
        )?),
        "periodic_friction" => term(PeriodicFriction::try_new(
            get("level"),
            get("period_m"),
            get("phase_rad"),
            u,
        )?),
        "gravity" => term(Gravity::try_new(get("force_N"), get("angle_rad"), u)?),
        "external_vibration" => term(ExternalVibration::try_new(
            get("force_N"),
            get("frequency_Hz"),
            get("phase_rad"),
            sample_time,
            u,
        )?),
        "thermal_drift" if effect.has("level_per_K") => term(ThermalDrift::try_new(
            get("level_per_K"),
            get("temperature_C"),
            LARGEST_LEVEL,
        )?),
        "thermal_drift" => term(WarmUp::try_new(
            get("level"),
            get("time_constant_s"),
            sample_time,
        )?),
        "run_in" => term(RunIn::try_new(get("level"), get("path_m"), sample_time, u)?),
        "dwell_aging" => term(DwellAging::try_new(
            get("level_per_decade"),
            get("time_constant_s"),
            get("erasing_path_m"),
            6.0,
            sample_time,
            u,
        )?),
        "load_dependent_friction" => term(LoadDependentFriction::try_new(
            get("level_per_N"),
            get("load_N"),
            LARGEST_LEVEL,
            u,
        )?),
        "encoder_error" => {
            encoder(effect)?;
            None
        }
        _ => None,
    })
}

/// The library's correction of an `encoder_error`.
pub(crate) fn encoder(effect: &Effect) -> Result<EncoderError<f64>, ParamError> {
    EncoderError::try_new(
        effect.get("error_m"),
        effect.get("period_m"),
        effect.get("phase_rad"),
        Units::SI,
    )
}

fn padded(effect: &Effect) -> [f64; MOST_TERMS] {
    let mut terms = [0.0; MOST_TERMS];
    for (term, c) in terms.iter_mut().zip(effect.cosines()) {
        *term = c;
    }
    terms
}
