//! Reading an effect of a model file, and the errors that name ids, keys and ranges.

use super::form::{self, Form, Keys, Range};
use super::{Effect, MOST_TERMS};

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

/// What to do with an id that has no entry.
fn unknown(id: &str) -> String {
    match id {
        id if id == form::VISCOUS.id => "id: viscous friction is the key viscous_N_s_per_m (rotary: viscous_Nm_s_per_rad) of [friction]; move it there".to_owned(),
        "lead_error" | "periodic_lead_error" => format!("id: {id} shows against a reference only and has no term here; correct the encoder's calibration and remove it"),
        "presliding_shape" => "id: presliding_shape has no term of its own; identify with more blocks and remove it".to_owned(),
        _ => {
            let mut known: Vec<&str> = form::ALL.iter().map(|form| form.id).collect();
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
    if !form::ALL.iter().any(|form| form.id == id) {
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
    let forms: Vec<&'static Form> = form::ALL.into_iter().filter(|form| form.id == id).collect();
    // Of two sets of keys the one that the first telling key belongs to.
    let telling = |keys: Keys| {
        keys.iter()
            .any(|(key, _)| given.iter().any(|(own, _)| own == key))
    };
    let meant = forms.iter().find(|form| telling(form.keys));
    let Some(&form) = meant.or(forms.first()) else {
        return Err(unknown(id));
    };
    let keys = form.keys;
    let has = forms.iter().map(|form| named(form.keys, said));
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
    let effect = Effect { form, values };
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
    effect.term(1e-5).map_err(|e| format!("{id}: {e}"))?;
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
