//! Ids, keys and ranges, and the errors that name them.

use super::{Effect, MOST_TERMS, terms};

/// What a value may be.
#[derive(Clone, Copy)]
enum Range {
    Any,
    Positive,
    NotNegative,
    /// A share of the friction level.
    Within(f64),
    Between(f64, f64),
}

impl Range {
    fn refuses(self, value: f64) -> Option<String> {
        let (good, wanted) = match self {
            Self::Any => (true, "finite".to_owned()),
            Self::Positive => (value > 0.0, "above zero".to_owned()),
            Self::NotNegative => (value >= 0.0, "zero or above".to_owned()),
            Self::Within(most) => (value.abs() <= most, format!("within ±{most}")),
            Self::Between(low, high) => ((low..=high).contains(&value), format!("{low} to {high}")),
        };
        (!(good && value.is_finite())).then_some(wanted)
    }
}

use Range::{Any, Between, NotNegative, Positive, Within};

const LEVEL: Range = Within(preslide::effects::LARGEST_LEVEL);

/// Keys of an effect, of which an id may have two sets; `cosine*` stands for `cosine1`, `cosine2`, … with what follows it.
type Keys = &'static [(&'static str, Range)];

const CATALOGUE: [(&str, Keys); 25] = [
    ("constant_force", &[("force_N", Any)]),
    ("coulomb_asymmetry", &[("asymmetry", Within(1.0))]),
    ("quadratic_drag", &[("drag_N_s2_per_m2", Any)]),
    (
        "stribeck",
        &[
            ("level", LEVEL),
            ("velocity_m_s", Positive),
            ("exponent", Between(1.0, 4.0)),
        ],
    ),
    (
        "frictional_lag",
        &[
            ("level", LEVEL),
            ("velocity_m_s", Positive),
            ("exponent", Between(1.0, 4.0)),
            ("time_constant_s", Positive),
        ],
    ),
    (
        "position_spring",
        &[("stiffness_N_per_m", Any), ("centre_m", Any)],
    ),
    (
        "position_force",
        &[("from_m", Any), ("to_m", Any), ("cosine*_N", Any)],
    ),
    (
        "position_friction",
        &[("from_m", Any), ("to_m", Any), ("cosine*", LEVEL)],
    ),
    (
        "local_friction_spot",
        &[("level", LEVEL), ("position_m", Any), ("width_m", Positive)],
    ),
    (
        "periodic_force",
        &[("force_N", Any), ("period_m", Positive), ("phase_rad", Any)],
    ),
    (
        "periodic_friction",
        &[("level", LEVEL), ("period_m", Positive), ("phase_rad", Any)],
    ),
    (
        "encoder_error",
        &[("error_m", Any), ("period_m", Positive), ("phase_rad", Any)],
    ),
    ("gravity", &[("force_N", Any), ("angle_rad", Any)]),
    (
        "external_vibration",
        &[
            ("force_N", Any),
            ("frequency_Hz", Positive),
            ("phase_rad", Any),
        ],
    ),
    ("channel_delay", &[("delay_s", Any)]),
    ("drive_compliance", &[("frequency_Hz", Positive)]),
    ("backlash", &[("gap_m", NotNegative)]),
    (
        "thermal_drift",
        &[("level_per_K", Any), ("temperature_C", Any)],
    ),
    (
        "thermal_drift",
        &[("level", LEVEL), ("time_constant_s", Positive)],
    ),
    ("run_in", &[("level", LEVEL), ("path_m", Positive)]),
    (
        "dwell_aging",
        &[
            ("level_per_decade", Within(1.0)),
            ("time_constant_s", Positive),
            ("erasing_path_m", Positive),
        ],
    ),
    (
        "load_dependent_friction",
        &[("level_per_N", Any), ("load_N", Any)],
    ),
    ("actuator_dead_zone", &[("width_N", NotNegative)]),
    ("actuator_saturation", &[("limit_N", Positive)]),
    (
        "creep",
        &[("rate_m_s", NotNegative), ("share_of_breakaway", Positive)],
    ),
];

/// What to do with an id that has no entry.
fn unknown(id: &str) -> String {
    match id {
        "viscous" => "id: viscous friction is the key viscous_N_s_per_m (rotary: viscous_Nm_s_per_rad) of [friction]; move it there".to_owned(),
        "lead_error" | "periodic_lead_error" => format!("id: {id} shows against a reference only and has no term here; correct the encoder's calibration and remove it"),
        "presliding_shape" => "id: presliding_shape has no term of its own; identify with more blocks and remove it".to_owned(),
        _ => {
            let mut known: Vec<&str> = CATALOGUE.iter().map(|entry| entry.0).collect();
            known.dedup();
            format!("id: the effect \"{id}\" is not known; use {}, or remove it", known.join(", "))
        }
    }
}

/// The number of a cosine: `cosine12_N` of `cosine*_N` is 12.
fn order(key: &str, pattern: &str) -> Option<usize> {
    let (before, after) = pattern.split_once('*')?;
    let digits = key.strip_prefix(before)?.strip_suffix(after)?;
    let plain = digits.bytes().all(|b| b.is_ascii_digit()) && !digits.starts_with('0');
    digits.parse().ok().filter(|_| plain)
}

fn fits(key: &str, pattern: &str) -> bool {
    key == pattern || order(key, pattern).is_some()
}

/// Reads an entry of a model file.
pub(super) fn read(table: &toml::Table, said: &dyn Fn(&str) -> String) -> Result<Effect, String> {
    let id = match table.get("id") {
        Some(toml::Value::String(id)) => id,
        Some(_) => return Err("id: must be a string, such as \"stribeck\"".to_owned()),
        None => return Err("id: missing; every effect needs one".to_owned()),
    };
    if !CATALOGUE.iter().any(|entry| entry.0 == id) {
        return Err(unknown(id));
    }
    let mut values = Vec::new();
    for (key, value) in table.iter().filter(|(key, _)| *key != "id") {
        let number = value
            .as_float()
            .or_else(|| value.as_integer().map(|i| i as f64));
        match number {
            Some(number) => values.push((key.as_str(), number)),
            None => return Err(format!("{}: must be a number", said(key))),
        }
    }
    checked(id, &values, said)
}

/// Checks keys and values and puts them in order.
pub(super) fn checked(
    id: &str,
    given: &[(&str, f64)],
    said: &dyn Fn(&str) -> String,
) -> Result<Effect, String> {
    let sets: Vec<_> = CATALOGUE.iter().filter(|entry| entry.0 == id).collect();
    // Of two sets of keys the one that the first telling key belongs to.
    let telling = |keys: Keys| {
        keys.iter()
            .any(|(key, _)| given.iter().any(|(own, _)| own == key))
    };
    let Some(&&(id, keys)) = sets.iter().find(|entry| telling(entry.1)).or(sets.first()) else {
        return Err(unknown(id));
    };
    let has = sets.iter().map(|entry| named(entry.1, said));
    let has = format!("{id} has {}", has.collect::<Vec<_>>().join("; or "));
    for (key, value) in given {
        let Some((_, range)) = keys.iter().find(|(pattern, _)| fits(key, pattern)) else {
            return Err(format!("{}: unknown key; {has}", said(key)));
        };
        if let Some(wanted) = range.refuses(*value) {
            return Err(format!("{}: {value} must be {wanted}", said(key)));
        }
        if given.iter().filter(|(other, _)| other == key).count() > 1 {
            return Err(format!("{}: given twice", said(key)));
        }
    }
    let mut values = Vec::new();
    for (pattern, _) in keys {
        let mut own: Vec<_> = given.iter().filter(|(key, _)| fits(key, pattern)).collect();
        own.sort_by_key(|(key, _)| order(key, pattern));
        if own.is_empty() {
            let first = pattern.replacen('*', "1", 1);
            return Err(format!("{}: missing; {has}", said(&first)));
        }
        if pattern.contains('*') {
            numbered(pattern, &own, said)?;
        }
        values.extend(
            own.into_iter()
                .map(|(key, value)| ((*key).to_owned(), *value)),
        );
    }
    let effect = Effect { id, values };
    if effect.has("to_m") && effect.get("to_m") <= effect.get("from_m") {
        return Err(format!(
            "{}: {} must be above {} = {}",
            said("to_m"),
            effect.get("to_m"),
            said("from_m"),
            effect.get("from_m")
        ));
    }
    // The library is the last judge of what it computes. The sample time is known later; 10 µs suits all that is plausible.
    terms::library(&effect, 1e-5).map_err(|e| format!("{id}: {e}"))?;
    Ok(effect)
}

/// A set of keys as an error names it.
fn named(keys: Keys, said: &dyn Fn(&str) -> String) -> String {
    let name = |(key, _): &(&str, Range)| match key.split_once('*') {
        Some((before, after)) => {
            let first = said(&format!("{before}1{after}"));
            let second = said(&format!("{before}2{after}"));
            format!("{first}, {second}, …")
        }
        None => said(key),
    };
    keys.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// Refuses cosines in order that are not numbered from 1 without a gap, or are too many.
fn numbered(
    pattern: &str,
    cosines: &[&(&str, f64)],
    said: &dyn Fn(&str) -> String,
) -> Result<(), String> {
    let name = |j: usize| pattern.replacen('*', &j.to_string(), 1);
    if let Some(j) = (1..=cosines.len()).find(|&j| cosines[j - 1].0 != name(j)) {
        return Err(format!(
            "{}: missing; the cosines are numbered from 1 without a gap (0 is a value)",
            said(&name(j))
        ));
    }
    if cosines.len() > MOST_TERMS {
        return Err(format!(
            "{}: at most {MOST_TERMS} cosines; remove those above",
            said(&name(MOST_TERMS + 1))
        ));
    }
    Ok(())
}
