//! Units that keys of model files and answers end in.

/// Endings of keys, the longest first, with the unit that they stand for and what of the key is no unit.
const UNITS: [(&str, &str); 26] = [
    ("_Nm_s2_per_rad2", "N·m·s²/rad²"),
    ("_N_s2_per_m2", "N·s²/m²"),
    ("_Nm_s_per_rad", "N·m·s/rad"),
    ("_N_s_per_m", "N·s/m"),
    ("_Nm_per_rad", "N·m/rad"),
    ("_N_per_m", "N/m"),
    ("_Nm_per_s", "N·m/s"),
    ("_N_per_s", "N/s"),
    ("_per_cycle", "1/cycle"),
    ("_per_rad", "1/rad"),
    ("_per_Nm", "1/(N·m)"),
    ("_per_N", "1/N"),
    ("_per_m", "1/m"),
    ("_per_s", "1/s"),
    ("_C", "°C"),
    ("_kg_m2", "kg·m²"),
    ("_rad_s", "rad/s"),
    ("_m_s", "m/s"),
    ("_per_K", "1/K"),
    ("_rad", "rad"),
    ("_Nm", "N·m"),
    ("_Hz", "Hz"),
    ("_kg", "kg"),
    ("_N", "N"),
    ("_m", "m"),
    ("_s", "s"),
];

/// Name and unit of a key where the effort is in a unit of its own: `viscous_Nm_s_per_rad` in A is viscous, in A·s/rad.
pub fn name_and_unit(key: &str, effort: &str) -> (String, String) {
    // What differs by direction has it behind its key.
    let (key, direction) = key.split_once(' ').unwrap_or((key, ""));
    let unit = UNITS
        .iter()
        .find_map(|(ending, unit)| Some((key.strip_suffix(ending)?, *unit)));
    let (name, unit) = unit.unwrap_or((key, ""));
    let name = format!("{name} {direction}").replace(['_', '.'], " ");
    let mut words: Vec<&str> = name.split_whitespace().collect();
    // `constant_force.force_N` says its quantity twice.
    words.dedup();
    (words.join(" "), in_effort(unit, effort))
}

/// A unit as people write it: the `Nm` of a recording's columns is N·m.
pub fn symbol(unit: &str) -> &str {
    match unit {
        "Nm" => "N·m",
        unit => unit,
    }
}

fn in_effort(unit: &str, effort: &str) -> String {
    if matches!(effort, "N" | "Nm") {
        return unit.to_owned();
    }
    let rest = ["N·m", "N"].into_iter().find_map(|force| {
        let rest = unit.strip_prefix(force)?;
        (rest.is_empty() || rest.starts_with(['·', '/'])).then_some(rest)
    });
    match (unit, rest) {
        ("kg", _) => format!("{effort}·s²/m"),
        ("kg·m²", _) => format!("{effort}·s²/rad"),
        (_, Some(rest)) => format!("{effort}{rest}"),
        (unit, None) => unit.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::name_and_unit;
    use crate::effects::Effect;
    use crate::effects::form;
    use crate::friction::FrictionModel;
    use crate::model::key_of;
    use crate::recording::MotionKind;

    /// Of every parameter there is: what is per something is not in that something's unit.
    #[test]
    fn what_is_per_a_unit_has_the_unit_below_the_line() {
        let effects = form::ALL
            .into_iter()
            .map(|form| Effect::of(form, form.example));
        let mut keys: Vec<String> = effects.flat_map(|e| e.values).map(|(key, _)| key).collect();
        for law in FrictionModel::one_of_each(0.9, 1e-5) {
            keys.extend(law.scalars().into_iter().map(|(key, _)| key.to_owned()));
        }
        for key in &keys {
            for key in [MotionKind::Linear, MotionKind::Rotary].map(|kind| key_of(kind, key)) {
                let (name, unit) = name_and_unit(&key, "N");
                let is_per = key.contains("_per_") && !key.ends_with("_per_decade");
                assert_eq!(
                    unit.contains('/'),
                    is_per || unit.ends_with("/s"),
                    "{key}: {unit}"
                );
                assert!(!name.ends_with(" per"), "{key}: {name}");
            }
        }
        let level = name_and_unit("level_per_N", "N");
        assert_eq!(level, ("level".to_owned(), "1/N".to_owned()));
    }
}
