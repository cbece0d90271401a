//! An answer of the tool: what `preslide.diagnosis/1` says, read without anything of the tool's own.

use serde_json::Value;

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
    /// Rivals that are as likely.
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
    /// Keys of the user's model whose numbers it says are wrong, an effect's behind the effect's id.
    pub wrong: Vec<String>,
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
            wrong: json["given_model"]["parameters"]
                .as_array()
                .into_iter()
                .flatten()
                .filter(|p| p["differs"] == true)
                .filter_map(|p| Some(p["key"].as_str()?.to_owned()))
                .collect(),
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

    /// A parameter of the effect of an id.
    ///
    /// # Panics
    /// Where it is not stated.
    pub fn value(&self, id: &str, key: &str) -> f64 {
        self.stated(id, key).1
    }

    /// Its 95 % interval.
    ///
    /// # Panics
    /// Where it is not stated, or without one.
    pub fn interval(&self, id: &str, key: &str) -> (f64, f64) {
        let interval = self.stated(id, key).2;
        interval.unwrap_or_else(|| panic!("{key} of {id} has no interval"))
    }

    fn stated(&self, id: &str, key: &str) -> &Stated {
        let effect = self.effects.iter().find(|e| e.id == id);
        let parameter = effect.and_then(|e| e.parameters.iter().find(|p| p.0 == key));
        parameter.unwrap_or_else(|| panic!("{id} states no {key}"))
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
