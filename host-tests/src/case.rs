//! A judged answer of any source: what was there, what was said, and what of it is right.

use serde_json::{Value, json};

use crate::answer::{Diagnosis, Named};

/// An interval of `position` (m or rad), `velocity` (magnitude), `time` (s) or `load` (N) on which an effect acts.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Which coordinate.
    pub axis: String,
    /// Start.
    pub from: f64,
    /// End.
    pub to: f64,
}

impl Place {
    /// From its three parts.
    pub fn new(axis: &str, from: f64, to: f64) -> Self {
        Self {
            axis: axis.to_owned(),
            from,
            to,
        }
    }

    /// Whether the overlap with a stated interval is half of the longer of the two: a whole axis hits no narrow place.
    pub fn hit(&self, axis: &str, mut from: f64, mut to: f64) -> bool {
        let speeds = ["velocity", "speed"];
        let speed = speeds.contains(&self.axis.as_str());
        if axis != self.axis && !(speed && speeds.contains(&axis)) {
            return false;
        }
        if speed && from < 0.0 {
            (from, to) = if to > 0.0 {
                (0.0, to.max(-from))
            } else {
                (-to, -from)
            };
        }
        let shared = to.min(self.to) - from.max(self.from);
        shared >= 0.5 * (to - from).max(self.to - self.from)
    }
}

/// A parameter that separates this effect from another of the same name in the machine.
#[derive(Clone, Debug)]
pub struct Check {
    starts_with: &'static str,
    value: f64,
    within: f64,
}

impl Check {
    /// The first parameter whose name starts so, within a share of its value.
    pub fn relative(starts_with: &'static str, value: f64, share: f64) -> Self {
        Self::within(starts_with, value, share * value.abs())
    }

    /// The first parameter whose name starts so, within a distance.
    pub fn within(starts_with: &'static str, value: f64, within: f64) -> Self {
        Self {
            starts_with,
            value,
            within,
        }
    }

    /// What is not stated does not speak against a name.
    fn passes(&self, named: &Named) -> bool {
        let stated = named
            .parameters
            .iter()
            .find(|p| p.0.starts_with(self.starts_with));
        stated.is_none_or(|(_, value, _)| (value - self.value).abs() <= self.within)
    }
}

/// An effect that is there.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Name in the catalogue, or the source's own where it is in none.
    pub id: String,
    /// Parameters that a right name must have.
    pub checks: Vec<Check>,
    /// Where it acts, if only there.
    pub place: Option<Place>,
    /// Parameters by name, in SI, to hold stated intervals against.
    pub parameters: Vec<(String, f64)>,
    /// Whether the source's own oracle sees it in the recording, which knows the machine's friction.
    pub seen: Option<bool>,
    /// Whether one does that has to fit the friction.
    pub seen_beside_a_fit: Option<bool>,
}

impl Truth {
    /// A name without more.
    pub fn named(id: &str) -> Self {
        Self {
            id: id.to_owned(),
            checks: Vec::new(),
            place: None,
            parameters: Vec::new(),
            seen: None,
            seen_beside_a_fit: None,
        }
    }

    /// Whether a name is right. Two effects are the same to every fit, and either is right with the other declared.
    pub fn is(&self, named: &Named) -> bool {
        const SAME: [&str; 2] = ["constant_force", "coulomb_asymmetry"];
        let same = SAME.contains(&self.id.as_str()) && SAME.contains(&named.id.as_str());
        named.id == self.id && self.checks.iter().all(|check| check.passes(named))
            || named.id != self.id && same && self.declared_by(named)
    }

    /// Whether a name says that it cannot be separated from this one.
    pub fn declared_by(&self, named: &Named) -> bool {
        named.ambiguous_with.contains(&self.id)
    }
}

/// What kind of question a case is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Sort {
    /// Nothing is concealed.
    Clean,
    /// One effect.
    Single,
    /// One effect in a corner of the travel, or on a model that is wrong.
    Hidden,
    /// Two effects.
    Pair,
    /// Two effects, one much larger.
    Masked,
    /// Something outside the catalogue.
    Stranger,
    /// A machine as it is, perhaps with more than its known effects.
    Machine,
}

impl Sort {
    /// In tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Sort::Clean => "clean",
            Sort::Single => "single",
            Sort::Hidden => "hidden",
            Sort::Pair => "pair",
            Sort::Masked => "masked",
            Sort::Stranger => "stranger",
            Sort::Machine => "machine",
        }
    }
}

/// A question and its answer.
#[derive(Clone, Debug)]
pub struct Case {
    /// Where the recording is from.
    pub source: &'static str,
    /// Which recording.
    pub name: String,
    /// What is asked.
    pub sort: Sort,
    /// 0.5, 1 or 2 of typical; percent of the effort for injections; 0 without an effect.
    pub strength: f64,
    /// What is there.
    pub truth: Vec<Truth>,
    /// What the machine has besides: a name for it is right, though it was not asked.
    pub native: Vec<Truth>,
    /// Names that count neither for nor against, declared or stated: those of the machine before anything was added or known of it, and what
    /// a truth implies.
    pub neutral: Vec<String>,
    /// Names known to be absent, where not every other one is.
    pub absent: Option<Vec<String>>,
    /// Whether an oracle with the true column says that the data show it.
    pub there: Option<bool>,
    /// Verdicts that are right whatever is named, a refusal besides; none is asked where empty.
    pub verdicts: &'static [&'static str],
    /// What was said.
    pub answer: Result<Diagnosis, String>,
    /// How long it took (s).
    pub seconds: f64,
}

impl Case {
    /// All names, first rank first.
    pub fn names(&self) -> &[Named] {
        self.answer.as_ref().map_or(&[], |answer| &answer.effects)
    }

    /// Names stated with confidence.
    pub fn confident(&self) -> impl Iterator<Item = &Named> {
        self.names().iter().filter(|n| n.confident)
    }

    /// Whether the first confident name is right.
    pub fn first_right(&self) -> bool {
        self.confident()
            .next()
            .is_some_and(|n| self.truth.iter().any(|t| t.is(n)))
    }

    /// Whether a confident name is this effect.
    pub fn finds(&self, truth: &Truth) -> bool {
        self.confident().any(|n| truth.is(n))
    }

    /// Whether a confident name is this effect, or is declared inseparable from it, or a number of the user's model is said to be wrong that is it.
    pub fn finds_or_declares(&self, truth: &Truth) -> bool {
        let named = |n: &Named| truth.is(n) || truth.declared_by(n);
        // `viscous_N_s_per_m`, `position_spring.stiffness_N_per_m`.
        let is_own = |key: &String| {
            let of = key
                .split('.')
                .next()
                .and_then(|own| own.strip_prefix(&truth.id));
            of.is_some_and(|unit| unit.is_empty() || unit.starts_with("_N"))
        };
        let mut wrong = self.answer.iter().flat_map(|answer| &answer.wrong);
        self.confident().any(named) || wrong.any(is_own)
    }

    /// `Some(true)` where the name is right, or says that it may as well be what is there; `Some(false)` where it is false, `None` where nothing is
    /// known or it does not count.
    pub fn judges(&self, named: &Named) -> Option<bool> {
        let mut there = self.truth.iter().chain(&self.native);
        if there.any(|t| t.is(named)) || self.truth.iter().any(|t| t.declared_by(named)) {
            return Some(true);
        }
        let known = self
            .absent
            .as_ref()
            .is_none_or(|absent| absent.contains(&named.id));
        let neutral = |id: &String| self.neutral.contains(id);
        let counts = !neutral(&named.id) && !named.ambiguous_with.iter().any(neutral);
        (known && counts).then_some(false)
    }

    /// Confident names that are false.
    pub fn false_names(&self) -> impl Iterator<Item = &Named> {
        self.confident().filter(|n| self.judges(n) == Some(false))
    }

    /// The verdict or `no answer`.
    pub fn verdict(&self) -> &str {
        self.answer
            .as_ref()
            .map_or("no answer", |answer| &answer.verdict)
    }

    /// Whether the verdict is one of those that are right, where one is asked.
    pub fn verdict_right(&self) -> Option<bool> {
        let right = self.answer.is_err() || self.verdicts.contains(&self.verdict());
        (!self.verdicts.is_empty()).then_some(right)
    }

    /// For each rightly named effect with a place: whether one was stated on that axis, whether it hits.
    pub fn places(&self) -> Vec<(bool, bool)> {
        let mut found = Vec::new();
        for truth in &self.truth {
            let (Some(place), Some(named)) = (&truth.place, self.confident().find(|n| truth.is(n)))
            else {
                continue;
            };
            let own = |axis: &str| place.hit(axis, place.from, place.to);
            let stated = named.places.iter().any(|p| own(&p.0));
            found.push((
                stated,
                named.places.iter().any(|p| place.hit(&p.0, p.1, p.2)),
            ));
        }
        found
    }

    /// For each stated 95 % interval of a rightly named effect's parameter: how far from its middle the true value is, in half widths;
    /// it is held up to 1.
    pub fn distances(&self) -> Vec<(String, f64)> {
        let mut distances = Vec::new();
        for truth in &self.truth {
            for named in self.confident().filter(|n| n.id == truth.id && truth.is(n)) {
                for (name, value) in &truth.parameters {
                    let stated = named.parameters.iter().find(|p| p.0 == *name);
                    if let Some((_, _, Some((low, high)))) = stated {
                        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
                        distances.push((
                            format!("{}.{name}", truth.id),
                            (value - middle).abs() / half.max(f64::MIN_POSITIVE),
                        ));
                    }
                }
            }
        }
        distances
    }

    /// One line: what was there, what was said.
    pub fn line(&self) -> String {
        let truth: Vec<&str> = self.truth.iter().map(|t| t.id.as_str()).collect();
        let said = match &self.answer {
            Err(reason) => format!("no answer: {reason}"),
            Ok(answer) => {
                let word = |n: &Named| {
                    let mark = match (n.confident, self.judges(n)) {
                        (false, _) => "?",
                        (true, Some(true)) => " ✓",
                        (true, Some(false)) => " ✗",
                        (true, None) => "",
                    };
                    format!("{}{mark} {:.2}", n.id, n.confidence)
                };
                let names: Vec<String> = answer.effects.iter().map(word).collect();
                format!("{} [{}]", answer.verdict, names.join(", "))
            }
        };
        let there = match self.there {
            None => "",
            Some(true) => " (there)",
            Some(false) => " (not there)",
        };
        format!(
            "{:<10} {:<8} ×{:<4} {:<28}{there} {} → {said}{}",
            self.source,
            self.sort.name(),
            self.strength,
            truth.join("+"),
            self.name,
            if self.verdict_right() == Some(false) {
                " ✗ verdict"
            } else {
                ""
            }
        )
    }

    /// For machines.
    pub fn to_json(&self) -> Value {
        let names: Vec<Value> = self
            .names()
            .iter()
            .map(|n| json!({ "id": n.id, "confident": n.confident, "confidence": n.confidence, "right": self.judges(n), "ambiguous_with": n.ambiguous_with, "features": n.features }))
            .collect();
        // On an out-of-catalogue recording any nameless finding is right, on a clean one none; beside a name it does not matter.
        let right = match self.sort {
            _ if self.confident().next().is_some() => None,
            Sort::Stranger => Some(true),
            Sort::Clean => Some(false),
            _ => None,
        };
        let unnamed = self.answer.iter().flat_map(|answer| &answer.unnamed);
        let unnamed: Vec<Value> = unnamed
            .map(|(p, features)| json!({ "confidence": p, "features": features, "right": right }))
            .collect();
        json!({
            "source": self.source, "name": self.name, "sort": self.sort.name(), "strength": self.strength,
            "truth": self.truth.iter().map(|t| &t.id).collect::<Vec<_>>(), "there": self.there,
            "verdict": self.verdict(), "error": self.answer.as_ref().err(), "names": names, "unnamed": unnamed, "distances": self.distances(), "seconds": self.seconds,
        })
    }
}
