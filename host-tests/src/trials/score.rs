//! What a diagnosis is worth, given the truth: reads `preslide.diagnosis/1` and compares it with the label.
//!
//! Two effects count as one where no fit can tell them apart: `constant_force` and `coulomb_asymmetry` are
//! exactly equivalent for parallel blocks (a block with unequal limits is a bias and a symmetric block after
//! it first slips). Naming one with the other in `ambiguous_with` is right; without it, wrong.
//! `stribeck` beside a true `frictional_lag` is no false name: a lag follows a Stribeck curve.

use serde_json::Value;

use super::effect::{Effect, Id};
use super::friction::{LOAD_N, TEMPERATURE_C};
use super::truth::Achievable;
use super::{Label, Region, Trial};

/// A parameter as the diagnosis states it: name, value, 95 % interval.
pub type Stated = (String, f64, Option<(f64, f64)>);

/// An effect that the diagnosis named.
#[derive(Clone, Debug)]
pub struct Named {
    /// Identifier in the catalogue.
    pub id: String,
    /// Stated as `confident`, not `suspected`.
    pub confident: bool,
    /// Stated probability that it is there.
    pub confidence: f64,
    /// Evidence (nats).
    pub nats: f64,
    /// Rivals that cannot be told from it.
    pub ambiguous_with: Vec<String>,
    /// Where it acts: axis, from, to.
    pub places: Vec<(String, f64, f64)>,
    /// Name, value, 95 % interval.
    pub parameters: Vec<Stated>,
    /// What its confidence is computed from.
    pub features: Value,
}

/// An answer of the diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// `consistent`, `missing-physics`, `unknown-physics` or `insufficient-data`.
    pub verdict: String,
    /// Effects, first rank first.
    pub effects: Vec<Named>,
    /// It says that something is there which no catalogue has.
    pub unknown: bool,
    /// The coordinate that organises it.
    pub unknown_axis: Option<String>,
    /// What may be there without a name: its probability, and what that is computed from.
    pub unnamed: Vec<(f64, Value)>,
    /// NMSE (%) on data that no fit saw, before and after.
    pub nmse_test: Option<(f64, f64)>,
    /// NMSE (%) that it takes for noise.
    pub noise_floor: Option<f64>,
    /// Duration that it states (s).
    pub seconds: f64,
}

impl Diagnosis {
    /// Reads the JSON of `preslide diagnose --json`.
    ///
    /// # Errors
    /// What is missing.
    pub fn parse(text: &str) -> Result<Self, String> {
        let json: Value = serde_json::from_str(text).map_err(|e| format!("not JSON: {e}"))?;
        if json["schema"] != "preslide.diagnosis/1" {
            return Err(format!(
                "schema is {}, not preslide.diagnosis/1",
                json["schema"]
            ));
        }
        let verdict = json["verdict"].as_str().ok_or("no verdict")?.to_owned();
        let mut effects: Vec<(u64, Named)> = Vec::new();
        for effect in json["effects"].as_array().ok_or("no list of effects")? {
            effects.push((
                effect["rank"].as_u64().ok_or("an effect without rank")?,
                named(effect)?,
            ));
        }
        effects.sort_by_key(|(rank, _)| *rank);
        let test = |part: &str| json[part]["nmse_test"].as_f64();
        Ok(Diagnosis {
            unknown: !json["unknown"].is_null() || verdict == "unknown-physics",
            verdict,
            effects: effects.into_iter().map(|(_, named)| named).collect(),
            unnamed: json["unnamed"]
                .as_array()
                .into_iter()
                .flatten()
                .filter_map(|u| Some((u["confidence"].as_f64()?, u["features"].clone())))
                .collect(),
            unknown_axis: json["unknown"]["axis"].as_str().map(str::to_owned),
            nmse_test: test("baseline").zip(test("extended")),
            noise_floor: json["noise_floor_nmse"].as_f64(),
            seconds: json["seconds"].as_f64().unwrap_or(0.0),
        })
    }

    /// It claims that physics is missing: a confident name, or a mismatch of unknown kind.
    pub fn alarms(&self) -> bool {
        self.unknown || self.confident().next().is_some()
    }

    /// The confident names.
    pub fn confident(&self) -> impl Iterator<Item = &Named> {
        self.effects.iter().filter(|e| e.confident)
    }

    /// Their ids.
    pub fn confident_ids(&self) -> Vec<&str> {
        self.confident().map(|e| e.id.as_str()).collect()
    }
}

fn named(effect: &Value) -> Result<Named, String> {
    let id = effect["id"]
        .as_str()
        .ok_or("an effect without id")?
        .to_owned();
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let places = list(&effect["where"])
        .iter()
        .filter_map(|w| {
            Some((
                w["axis"].as_str()?.to_owned(),
                w["from"].as_f64()?,
                w["to"].as_f64()?,
            ))
        })
        .collect();
    let parameters = effect["parameters"]
        .as_object()
        .into_iter()
        .flatten()
        .filter_map(|(name, p)| {
            let interval = p["ci95"][0].as_f64().zip(p["ci95"][1].as_f64());
            Some((name.clone(), p["value"].as_f64()?, interval))
        })
        .collect();
    Ok(Named {
        confident: effect["level"]
            .as_str()
            .ok_or_else(|| format!("{id}: no level"))?
            == "confident",
        confidence: effect["confidence"]
            .as_f64()
            .ok_or_else(|| format!("{id}: no confidence"))?,
        nats: effect["nats"].as_f64().unwrap_or(f64::NAN),
        ambiguous_with: list(&effect["ambiguous_with"])
            .iter()
            .filter_map(|v| v.as_str().map(str::to_owned))
            .collect(),
        places,
        parameters,
        features: effect["features"].clone(),
        id,
    })
}

/// Effects that no fit can tell apart.
const EQUIVALENT: [Id; 2] = [Id::ConstantForce, Id::CoulombAsymmetry];

/// Whether a name is right for a true effect.
pub fn right(named: &Named, truth: Id) -> bool {
    named.id == truth.name()
        || (EQUIVALENT.contains(&truth)
            && EQUIVALENT.iter().any(|id| id.name() == named.id)
            && named
                .ambiguous_with
                .iter()
                .any(|rival| rival == truth.name()))
}

/// Whether a name is no error: right for one of the effects, or contained in one.
pub fn tenable(named: &Named, truth: &[Id]) -> bool {
    truth
        .iter()
        .any(|&id| right(named, id) || (id == Id::FrictionalLag && named.id == Id::Stribeck.name()))
}

/// The friction level, beside the nominal one, at the load or temperature that a stated level is relative to.
fn base(effect: &Effect, named: &Named) -> f64 {
    let (key, nominal) = match effect.id {
        Id::LoadDependentFriction => ("load_N", LOAD_N),
        Id::ThermalDrift => ("temperature_C", TEMPERATURE_C),
        _ => return 1.0,
    };
    let stated = named.parameters.iter().find(|p| p.0 == key);
    stated.map_or(1.0, |p| 1.0 + effect.values[0] * (p.1 - nominal))
}

/// Unit at the end of a parameter's name; empty for a pure number.
fn unit(name: &str) -> &str {
    const UNITS: [&str; 14] = [
        "_N_s2_per_m2",
        "_N_s_per_m",
        "_N_per_m",
        "_m2_s3",
        "_per_decade",
        "_per_K",
        "_per_N",
        "_per_m",
        "_m_s",
        "_rad",
        "_Hz",
        "_N",
        "_m",
        "_s",
    ];
    UNITS
        .into_iter()
        .find(|unit| name.ends_with(unit))
        .unwrap_or("")
}

/// The stated parameter that means the true one called `name`, among the true ones `all`.
fn stated<'a>(
    named: &'a Named,
    name: &str,
    all: impl Iterator<Item = &'static str>,
) -> Option<&'a Stated> {
    if let Some(same) = named.parameters.iter().find(|(stated, ..)| stated == name) {
        return Some(same);
    }
    let mut alike = named
        .parameters
        .iter()
        .filter(|(stated, ..)| unit(stated) == unit(name));
    match (
        alike.next(),
        alike.next(),
        all.filter(|other| unit(other) == unit(name)).count(),
    ) {
        (Some(only), None, 1) => Some(only),
        _ => None,
    }
}

/// A parameter that was stated and is known.
#[derive(Clone, Debug)]
pub struct ParameterScore {
    /// Effect and parameter.
    pub name: String,
    /// |stated − true| / |true|.
    pub relative_error: f64,
    /// The stated interval holds the true value; `None` without an interval.
    pub covered: Option<bool>,
}

/// A trial with its answer, judged.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The truth.
    pub label: Label,
    /// RMS of each effect (N).
    pub effect_rms: Vec<f64>,
    /// NMSE (%) of a refitted baseline and of the truth, from the generator.
    pub achievable_nmse: (f64, f64),
    /// The answer, or why there is none.
    pub answer: Result<Diagnosis, String>,
    /// Time that the command took, with start and reading of the file (s).
    pub wall_s: f64,
}

impl Judged {
    /// Joins a trial and the answer to it.
    pub fn new(trial: &Trial, answer: Result<Diagnosis, String>, wall_s: f64) -> Self {
        let Achievable {
            effect_rms,
            baseline_nmse,
            floor_nmse,
            ..
        } = &trial.achievable;
        Judged {
            label: trial.label.clone(),
            effect_rms: effect_rms.clone(),
            achievable_nmse: (*baseline_nmse, *floor_nmse),
            answer,
            wall_s,
        }
    }

    /// True effects.
    pub fn truth(&self) -> Vec<Id> {
        self.label.kind.ids()
    }

    /// Named effects, first rank first; none where there was no answer.
    pub fn names(&self) -> &[Named] {
        self.answer.as_ref().map_or(&[], |a| &a.effects)
    }

    /// One of the first `n` names is a true effect.
    pub fn found_within(&self, n: usize) -> bool {
        let truth = self.truth();
        self.names()
            .iter()
            .take(n)
            .any(|name| truth.iter().any(|&id| right(name, id)))
    }

    /// The effect is named, at either level or confidently only.
    pub fn found(&self, id: Id, confidently: bool) -> bool {
        self.names()
            .iter()
            .any(|n| right(n, id) && (n.confident || !confidently))
    }

    /// There is an answer, and it claims that physics is missing.
    pub fn alarms(&self) -> bool {
        self.answer.as_ref().is_ok_and(Diagnosis::alarms)
    }

    /// Share of the achievable held-out improvement: `(1 − after/before)` over the same ratio for the truth
    /// against a refitted baseline. Ratios, because the two may measure NMSE against different denominators.
    /// `None` where the effects leave less than a fifth on top of the noise floor.
    pub fn improvement(&self) -> Option<f64> {
        let (baseline, floor) = self.achievable_nmse;
        let (before, after) = self.answer.as_ref().ok()?.nmse_test?;
        (baseline > 1.2 * floor && before > 0.0)
            .then(|| (1.0 - after / before) / (1.0 - floor / baseline))
    }

    /// Distance between the centres of the true region and the nearest stated place on that axis, in
    /// widths of the true region. `None` without a region, `Some(None)` where no place is stated.
    pub fn localisation(&self) -> Option<Option<f64>> {
        let Region { axis, from, to } = self.label.region?;
        let first = *self.truth().first()?;
        let error = self
            .names()
            .iter()
            .filter(|n| right(n, first))
            .flat_map(|n| &n.places)
            .filter(|place| place.0 == axis)
            .map(|(_, a, b)| (0.5 * (a + b) - 0.5 * (from + to)).abs() / (to - from))
            .reduce(f64::min);
        Some(error)
    }

    /// Stated parameters of rightly named effects: of the same name, or else the only one stated in the
    /// same unit, where the effect has only one in it. Phases are left out: their origin is a convention.
    pub fn parameters(&self) -> Vec<ParameterScore> {
        let mut scores = Vec::new();
        for effect in &self.label.effects {
            for named in self.names().iter().filter(|n| n.id == effect.id.name()) {
                for (name, value) in effect.parameters() {
                    let own = effect.parameters().map(|(other, _)| other);
                    let Some((_, stated, interval)) = stated(named, name, own) else {
                        continue;
                    };
                    if name.starts_with("phase") || value == 0.0 {
                        continue;
                    }
                    let value = value / base(effect, named);
                    scores.push(ParameterScore {
                        name: format!("{}.{name}", named.id),
                        relative_error: (stated - value).abs() / value.abs(),
                        covered: interval.map(|(low, high)| (low..=high).contains(&value)),
                    });
                }
            }
        }
        scores
    }

    /// Each stated confidence, and whether the effect is there.
    pub fn stated(&self) -> Vec<(f64, bool)> {
        let truth = self.truth();
        self.names()
            .iter()
            .map(|n| (n.confidence, tenable(n, &truth)))
            .collect()
    }

    /// Confident names: how many, and how many of them are tenable.
    pub fn confident(&self) -> (usize, usize) {
        let truth = self.truth();
        let confident = || self.names().iter().filter(|n| n.confident);
        (
            confident().count(),
            confident().filter(|n| tenable(n, &truth)).count(),
        )
    }

    /// One line for progress and lists: what was there, what was said.
    pub fn line(&self) -> String {
        let truth: Vec<&str> = self.truth().iter().map(|id| id.name()).collect();
        let said = match &self.answer {
            Err(reason) => format!("no answer: {reason}"),
            Ok(answer) => {
                let names: Vec<String> = answer
                    .effects
                    .iter()
                    .map(|n| {
                        format!(
                            "{}{} {:.2}",
                            n.id,
                            if n.confident { "" } else { "?" },
                            n.confidence
                        )
                    })
                    .collect();
                format!("{} [{}]", answer.verdict, names.join(", "))
            }
        };
        format!(
            "{:>6} {:<14} {:<18} {:<8} {:<32} {said}",
            self.label.seed,
            self.label.kind.name(),
            self.label.law.name(),
            self.label.strength,
            truth.join("+")
        )
    }

    /// Whether the trial is of the given kind by name.
    pub fn is(&self, kind: &str) -> bool {
        self.label.kind.name() == kind
    }

    /// Whether it is clean.
    pub fn clean(&self) -> bool {
        self.is("clean")
    }
}
