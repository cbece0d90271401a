//! Effects beyond rigid body and friction model, as model files hold them (`[[effects]]`).

use crate::friction::Path;
use std::f64::consts::{PI, TAU};

/// An effect and its parameters, in SI with the keys of a linear axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Id in the catalogue.
    pub id: &'static str,
    /// Parameters by key.
    pub values: Vec<(String, f64)>,
}

/// Keys of every effect; "cosine" stands for `cosine1`, `cosine2`, … with the unit that follows it.
const KEYS: [(&str, &[&str]); 20] = [
    ("coulomb_asymmetry", &["amplitude"]),
    ("quadratic_drag", &["drag_N_s2_per_m2"]),
    (
        "stribeck",
        &["amplitude", "velocity_m_s", "exponent", "slipping_only"],
    ),
    ("frictional_lag", &["amplitude", "velocity_m_s", "time_s"]),
    ("position_spring", &["stiffness_N_per_m", "centre_m"]),
    ("position_force", &["terms", "from_m", "to_m", "cosine_N"]),
    ("position_friction", &["terms", "from_m", "to_m", "cosine"]),
    ("local_friction_spot", &["amplitude", "centre_m", "width_m"]),
    ("periodic_force", &["amplitude_N", "phase_deg", "period_m"]),
    ("periodic_friction", &["amplitude", "phase_deg", "period_m"]),
    ("encoder_error", &["amplitude_m", "phase_deg", "period_m"]),
    (
        "external_vibration",
        &["amplitude_N", "phase_deg", "frequency_Hz"],
    ),
    ("channel_delay", &["delay_s"]),
    ("drive_compliance", &["frequency_Hz"]),
    ("thermal_drift", &["amplitude", "time_s"]),
    (
        "thermal_drift_of_temperature",
        &["per_kelvin", "reference_celsius"],
    ),
    ("run_in", &["amplitude", "path_m"]),
    ("dwell_aging", &["amplitude", "time_s", "path_m"]),
    (
        "load_dependent_friction",
        &["per_newton", "reference_newton"],
    ),
    ("backlash", &["amplitude", "gap_m"]),
];

impl Effect {
    /// Reads an entry of `[[effects]]`, its keys already those of a linear axis.
    ///
    /// # Errors
    /// Key, reason and remedy.
    pub fn read(table: &toml::Table) -> Result<Self, String> {
        let Some(name) = table.get("id").and_then(toml::Value::as_str) else {
            return Err("id: missing; every effect needs one".to_owned());
        };
        let Some((id, keys)) = KEYS.iter().find(|(id, _)| *id == name) else {
            let known: Vec<&str> = KEYS.iter().map(|k| k.0).collect();
            return Err(format!(
                "id: the effect \"{name}\" is not known; use constant_force, {}",
                known.join(", ")
            ));
        };
        let mut values = Vec::new();
        for (key, value) in table.iter().filter(|(key, _)| *key != "id") {
            let plain: String = key.chars().filter(|c| !c.is_ascii_digit()).collect();
            let is_term = plain.starts_with("cosine") && keys.contains(&plain.as_str());
            if !is_term && !keys.contains(&key.as_str()) {
                return Err(format!("{key}: unknown key; {id} has {}", keys.join(", ")));
            }
            let number = value
                .as_float()
                .or_else(|| value.as_integer().map(|i| i as f64));
            match number.filter(|v| v.is_finite()) {
                Some(number) => values.push((key.clone(), number)),
                None => return Err(format!("{key}: must be a finite number")),
            }
        }
        for key in keys
            .iter()
            .filter(|k| !k.starts_with("cosine") && **k != "slipping_only")
        {
            if !values.iter().any(|(given, _)| given == key) {
                return Err(format!("{key}: missing; {id} needs it"));
            }
        }
        let positive = |key: &str| {
            [
                "width_m",
                "period_m",
                "velocity_m_s",
                "exponent",
                "time_s",
                "path_m",
                "frequency_Hz",
            ]
            .contains(&key)
        };
        if let Some((key, value)) = values.iter().find(|(k, v)| positive(k) && *v <= 0.0) {
            return Err(format!("{key}: {value} must be above zero"));
        }
        Ok(Self { id, values })
    }

    fn get(&self, key: &str) -> f64 {
        self.values
            .iter()
            .find(|(k, _)| k == key)
            .map_or(0.0, |v| v.1)
    }

    /// Cosine terms over the travel.
    fn map(&self, x: f64) -> f64 {
        let (from, to) = (self.get("from_m"), self.get("to_m"));
        let place = ((x - from) / (to - from)).clamp(0.0, 1.0);
        self.values
            .iter()
            .filter_map(|(key, c)| {
                let order: String = key
                    .strip_prefix("cosine")?
                    .chars()
                    .take_while(char::is_ascii_digit)
                    .collect();
                Some(c * (order.parse::<f64>().ok()? * PI * place).cos())
            })
            .sum()
    }

    fn wave(&self, amplitude: &str, place: f64, period: f64) -> f64 {
        self.get(amplitude) * (TAU * place / period + self.get("phase_deg").to_radians()).cos()
    }

    /// Whether [`add_to`](Self::add_to) can compute it from position, velocity and time alone. The others act on the
    /// measurement or on the whole drive, or need a temperature, a load or the state of the blocks.
    pub fn acts_along_path(&self) -> bool {
        !matches!(
            self.id,
            "encoder_error"
                | "channel_delay"
                | "drive_compliance"
                | "thermal_drift_of_temperature"
                | "load_dependent_friction"
                | "backlash"
                | "dwell_aging"
        ) && !(self.id == "stribeck" && self.get("slipping_only") > 0.5)
    }

    /// Adds its force [N or N·m] along a path to `force`; `friction` is that of the friction model alone.
    pub fn add_to(&self, force: &mut [f64], friction: &[f64], path: Path) {
        let mut travelled = 0.0;
        let mut lagging: Option<f64> = None;
        let share = (-path.sample_time / self.get("time_s").max(1e-300)).exp();
        for i in 0..force.len().min(path.position.len()) {
            let (x, v, t) = (
                path.position[i],
                path.velocity[i],
                i as f64 * path.sample_time,
            );
            travelled += v.abs() * path.sample_time;
            let falling =
                |exponent: f64| (-(v.abs() / self.get("velocity_m_s")).powf(exponent)).exp();
            force[i] += match self.id {
                "quadratic_drag" => self.get("drag_N_s2_per_m2") * v * v.abs(),
                "coulomb_asymmetry" => self.get("amplitude") * friction[i] * v.signum(),
                "stribeck" => self.get("amplitude") * friction[i] * falling(self.get("exponent")),
                "frictional_lag" => {
                    let now = falling(1.0);
                    let next = lagging.map_or(now, |last| now + (last - now) * share);
                    lagging = Some(next);
                    self.get("amplitude") * friction[i] * next
                }
                "position_spring" => self.get("stiffness_N_per_m") * (x - self.get("centre_m")),
                "position_force" => self.map(x),
                "position_friction" => self.map(x) * friction[i],
                "local_friction_spot" => {
                    let u = (x - self.get("centre_m")) / self.get("width_m");
                    self.get("amplitude") * (-u * u).exp() * friction[i]
                }
                "periodic_force" => self.wave("amplitude_N", x, self.get("period_m")),
                "periodic_friction" => {
                    self.wave("amplitude", x, self.get("period_m")) * friction[i]
                }
                "external_vibration" => self.wave("amplitude_N", t, 1.0 / self.get("frequency_Hz")),
                "run_in" => {
                    self.get("amplitude") * (-travelled / self.get("path_m")).exp() * friction[i]
                }
                "thermal_drift" => {
                    self.get("amplitude") * (-t / self.get("time_s")).exp() * friction[i]
                }
                _ => 0.0,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_key_and_the_remedy() {
        let read = |text: &str| Effect::read(&toml::from_str(text).unwrap());
        assert!(
            read("id = \"warp\"")
                .unwrap_err()
                .contains("not known; use constant_force")
        );
        assert!(
            read("id = \"run_in\"\namplitude = 0.1")
                .unwrap_err()
                .starts_with("path_m: missing")
        );
        assert!(
            read("id = \"run_in\"\nspeed = 0.1")
                .unwrap_err()
                .starts_with("speed: unknown key")
        );
        let spot = "id = \"local_friction_spot\"\namplitude = 0.5\ncentre_m = 0.0\nwidth_m = ";
        assert!(
            read(&format!("{spot}0.0"))
                .unwrap_err()
                .starts_with("width_m: 0 must")
        );
        assert!(read(&format!("{spot}1e-4")).is_ok());
    }

    #[test]
    fn a_spot_multiplies_friction_where_it_is() {
        let spot = Effect {
            id: "local_friction_spot",
            values: [("amplitude", 0.5), ("centre_m", 1.0), ("width_m", 0.1)]
                .map(|(k, v)| (k.to_owned(), v))
                .to_vec(),
        };
        let mut force = [0.0; 2];
        let path = Path {
            position: &[1.0, 3.0],
            velocity: &[1.0; 2],
            pieces: std::slice::from_ref(&(0..2)),
            sample_time: 1.0,
        };
        spot.add_to(&mut force, &[2.0, 2.0], path);
        assert_eq!(force, [1.0, 0.0]);
    }
}
