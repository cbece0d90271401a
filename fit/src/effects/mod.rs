//! Physics beyond rigid body and friction model: the `[[effects]]` of model files, and what they do along a recording.
//!
//! The catalogue is that of `preslide diagnose`; those that a controller can use are computed by the library
//! ([`preslide::effects`]), the others here ([`force_along`](crate::model::Model::force_along)). Parameters are SI, keys are those of a linear axis; a rotary
//! file has the same keys in its own units (`force_Nm`, `period_rad`, `stiffness_Nm_per_rad` …).
//!
//! | id | what it does | keys |
//! |---|---|---|
//! | `constant_force` | `F0` | `force_N` |
//! | `coulomb_asymmetry` | `m = 1 + a·sgn F` (`= sgn v` in sliding) | `asymmetry` |
//! | `viscous_asymmetry` | `d·abs(v)`: viscous friction `viscous + d` forwards, `viscous − d` backwards | `half_difference_N_s_per_m` |
//! | `quadratic_drag` | `c·v·abs(v)` | `drag_N_s2_per_m2` |
//! | `stribeck` | `m = 1 + a·exp(−(abs(v)/v_s)^δ)` | `level`, `velocity_m_s`, `exponent` |
//! | `frictional_lag` | the same, following with `τ` | `level`, `velocity_m_s`, `exponent`, `time_constant_s` |
//! | `position_spring` | `κ·(x − x0)` | `stiffness_N_per_m`, `centre_m` |
//! | `position_force` | `Σ c_j·cos(jπu)`, `u = (x − from)/(to − from)` in 0…1 | `from_m`, `to_m`, `cosine1_N`, `cosine2_N` … |
//! | `position_friction` | `m = 1 + Σ c_j·cos(jπu)` | `from_m`, `to_m`, `cosine1`, `cosine2` … |
//! | `local_friction_spot` | `m = 1 + a·exp(−((x − x_s)/w)²)` | `level`, `position_m`, `width_m` |
//! | `periodic_force` | `A·cos(2πx/p + φ)` | `force_N`, `period_m`, `phase_rad` |
//! | `periodic_friction` | `m = 1 + a·cos(2πx/p + φ)` | `level`, `period_m`, `phase_rad` |
//! | `encoder_error` | measured `= x + e·cos(2πx/p + φ)` | `error_m`, `period_m`, `phase_rad` |
//! | `gravity` | `A·sin(q − q0)`, rotary axes only | `force_N` (there `force_Nm`), `angle_rad` |
//! | `external_vibration` | `A·sin(2πft + φ)` | `force_N`, `frequency_Hz`, `phase_rad` |
//! | `channel_delay` | the force is recorded `τ` after the motion | `delay_s` |
//! | `drive_compliance` | the load on a spring behind the motor with the encoder, `ω = 2πf = √(4k/M)` | `frequency_Hz` |
//! | `backlash` | a play of the whole width `gap` between motor and load | `gap_m` |
//! | `thermal_drift` | `m = 1 + β·(T − T0)` | `level_per_K`, `temperature_C` |
//! | `thermal_drift` | `m = 1 + a·exp(−t/τ)` | `level`, `time_constant_s` |
//! | `run_in` | `m = 1 + a·exp(−s/λ)` | `level`, `path_m` |
//! | `dwell_aging` | `m = 1 + a·log10(1 + θ/τ)`, `dθ/dt = 1 − abs(v)·θ/λ` | `level_per_decade`, `time_constant_s`, `erasing_path_m` |
//! | `load_dependent_friction` | `m = 1 + c·(load − load0)` | `level_per_N`, `load_N` |
//! | `load_dependent_friction` | `μ·abs(T)` against the motion, `T = (M − M_motor)·a + F0 +` every force of place: what a gear transmits | `share_of_transmitted`, `motor_mass_kg` |
//! | `torque_ripple` | command `= F/(1 + a·cos(2πx/p + φ))` | `share`, `period_m`, `phase_rad` |
//! | `actuator_dead_zone` | command `= F + ½·width·sgn F` | `width_N` |
//! | `actuator_saturation` | `F` held within ± limit | `limit_N` |
//! | `creep` | displacement less `rate·T_s·sinh(F/(share·F_limit))` | `rate_m_s`, `share_of_breakaway` |
//!
//! Levels add: `m = 1 + Σ(m_i − 1)`, not below 0. Time and path count from the first sample. `viscous` is a key of
//! `[friction]`; `lead_error` and `presliding_shape` have no parameters here: the one is a calibration of the
//! encoder, the other is more blocks.

pub mod form;
mod read;
pub mod term;
#[cfg(test)]
mod tests;

use form::Form;
use preslide::ParamError;
use term::Term;

/// Most cosines of a map.
pub const MOST_TERMS: usize = 16;

/// An effect and its parameters, in SI with the keys of a linear axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Its form, of which its id is one part.
    pub form: &'static Form,
    /// Parameters by key, in the order of the table above.
    pub values: Vec<(String, f64)>,
}

impl Effect {
    /// An effect of the catalogue with its parameters, in any order.
    ///
    /// # Errors
    /// `key: reason and remedy`: an id or key that is not known, a key that is missing, a value out of its range.
    pub fn new(id: &str, values: &[(&str, f64)]) -> Result<Self, String> {
        read::checked(id, values, &str::to_owned)
    }

    /// The effect of a form with the values of its keys, in their order.
    pub fn of(form: &'static Form, values: &[f64]) -> Self {
        let keys = form.keys.iter().map(|(key, _)| (*key).to_owned());
        Self {
            form,
            values: keys.zip(values.iter().copied()).collect(),
        }
    }

    /// Id in the catalogue.
    pub fn id(&self) -> &'static str {
        self.form.id
    }

    /// Whether it has that form.
    pub fn is(&self, form: &'static Form) -> bool {
        self.form == form
    }

    /// Its term in the library for samples `sample_time` (s) apart; `None` where it is neither a level nor a force.
    ///
    /// # Errors
    /// Which parameter the library refuses.
    pub(crate) fn term(&self, sample_time: f64) -> Result<Option<Term>, ParamError> {
        (self.form.library)(self, sample_time)
    }

    /// The value of a key, 0 where it has none.
    pub fn get(&self, key: &str) -> f64 {
        self.values
            .iter()
            .find(|(own, _)| own == key)
            .map_or(0.0, |(_, value)| *value)
    }

    /// The values of the first keys of its form, 0 where it has none.
    fn numbers<const N: usize>(&self) -> [f64; N] {
        std::array::from_fn(|i| self.form.keys.get(i).map_or(0.0, |(key, _)| self.get(key)))
    }

    /// Whether it has the key.
    pub fn has(&self, key: &str) -> bool {
        self.values.iter().any(|(own, _)| own == key)
    }

    /// The coefficients of a map, in order.
    pub fn cosines(&self) -> Vec<f64> {
        self.values
            .iter()
            .filter(|(key, _)| key.starts_with("cosine"))
            .map(|(_, value)| *value)
            .collect()
    }

    /// The same, with zeros after the last.
    fn padded_cosines(&self) -> [f64; MOST_TERMS] {
        let mut padded = [0.0; MOST_TERMS];
        for (term, c) in padded.iter_mut().zip(self.cosines()) {
            *term = c;
        }
        padded
    }

    /// Reads an entry of `[[effects]]` whose keys are those of a linear axis; `said` gives the file's word for one.
    pub(crate) fn read(table: &toml::Table, said: &dyn Fn(&str) -> String) -> Result<Self, String> {
        read::read(table, said)
    }
}
