//! The bounds of terms that grow with speed, position, temperature or load: where they are taken from, and where they cut.

use super::Options;
use super::terms::{carried, numbered};
use preslide::effects::{LARGEST_LEVEL, Situation};
use preslide_fit::effects::Effect;
use preslide_fit::effects::form::{self, Argument};
use preslide_fit::model::{Model, key_of};
use preslide_fit::recording::{MotionKind, Recording};
use preslide_fit::report::figures::{quantity, three};
use preslide_fit::signal::Kinematics;
use serde_json::{Value, json};

/// Most by which a measured temperature or load may change the friction level of an exported model (-), where no recording shows more.
const LEVEL_LIMIT: f64 = 0.5;

/// The bound of forces, in breakaway forces, where no recording shows more: above what most healthy axes need, and below what a drive
/// could take for a fault.
const BREAKAWAYS: f64 = 10.0;

/// The bound, in the largest value that a term has on a recording: another motion may go twice as fast or as far.
const HEADROOM: f64 = 2.0;

/// The largest that a bounded term has on a recording.
#[derive(Clone, Debug)]
pub struct Reached {
    term: String,
    recording: String,
    of: Argument,
    /// Force (N or N·m) or change of the friction level (-), without its sign.
    largest: f64,
}

/// What a bound is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// `--limit`.
    Option,
    /// A recording.
    Recording,
    /// The breakaway force; of a level, a number of this tool.
    Default,
}

/// A bound, and where it cuts.
#[derive(Clone, Debug)]
pub struct Bound {
    pub(super) of: Argument,
    /// Force (N or N·m) or change of the friction level (-).
    pub(super) value: f64,
    /// What it is taken from.
    source: Source,
    motion: MotionKind,
    unit: &'static str,
    /// A recording was there to take it from.
    is_shown: bool,
    cuts: Vec<Cut>,
}

/// From where on a term is held at its bound.
#[derive(Clone, Debug)]
struct Cut {
    term: String,
    /// Key of the distance, for machines.
    key: &'static str,
    distance: f64,
    words: String,
}

/// The bound that a term takes, where it takes one.
fn bounded(effect: &Effect) -> Option<Argument> {
    let more = effect.form.controller.as_ref().ok()?.more.iter();
    let mut bounds = more.filter(|a| matches!(a, Argument::ForceLimit | Argument::LevelLimit));
    bounds.next().copied()
}

/// Names of the terms of a model that have a bound in a controller.
pub fn bounded_terms(model: &Model) -> Vec<String> {
    let effects = carried(model);
    let bounded = numbered(&effects).filter(|(_, effect)| bounded(effect).is_some());
    bounded.map(|(term, _)| term).collect()
}

/// The largest that each bounded term has on the motion of a recording, as the host computes it.
///
/// # Errors
/// A parameter that the library refuses.
pub fn reached(model: &Model, recording: &Recording) -> Result<Vec<Reached>, String> {
    let effects = carried(model);
    let mut terms = Vec::new();
    for (term, effect) in numbered(&effects) {
        terms.extend(bounded(effect).map(|of| (term, effect, of)));
    }
    if terms.is_empty() {
        return Ok(Vec::new());
    }
    let kinematics = Kinematics::of(recording);
    let reached = terms.into_iter().map(|(term, effect, of)| {
        let largest = largest(effect, of, recording, &kinematics)?;
        let recording = recording.name.clone();
        Ok(Reached {
            term,
            recording,
            of,
            largest,
        })
    });
    reached.collect()
}

fn largest(
    effect: &Effect,
    of: Argument,
    recording: &Recording,
    kinematics: &Kinematics,
) -> Result<f64, String> {
    if effect.is(&form::VISCOUS) {
        let speeds = kinematics.velocity.iter();
        let top = speeds.fold(0.0, |top: f64, v| top.max(v.abs()));
        return Ok(effect.get("viscous_N_s_per_m").abs() * top);
    }
    let term = (effect.form.library)(effect, recording.sample_time_s());
    let term = term.map_err(|reason| format!("effect {}: {reason}", effect.id()))?;
    let Some(mut term) = term else {
        return Ok(0.0);
    };
    let value = |i: usize| {
        let (level, force) = term(&Situation {
            position: recording.position[i],
            located: true,
            velocity: kinematics.velocity[i],
            friction: 0.0,
            temperature: recording.temperature_c.as_ref().map(|column| column[i]),
            load: recording.load_n.as_ref().map(|column| column[i]),
        });
        if of == Argument::ForceLimit {
            force.abs()
        } else {
            level.abs()
        }
    };
    Ok((0..recording.position.len()).map(value).fold(0.0, f64::max))
}

/// The bounds that the model needs, that of forces first.
///
/// # Errors
/// One that is needed and can be taken from nowhere, or that cuts a term on a recording: which, and what would hold it.
pub fn bounds(model: &Model, options: &Options) -> Result<Vec<Bound>, String> {
    let effects = carried(model);
    let mut found = Vec::new();
    for of in [Argument::ForceLimit, Argument::LevelLimit] {
        if !effects.iter().any(|effect| bounded(effect) == Some(of)) {
            continue;
        }
        let (value, source) = match of {
            Argument::ForceLimit => of_forces(model, options)?,
            _ => of_levels(options),
        };
        let cuts = numbered(&effects).filter(|(_, effect)| bounded(effect) == Some(of));
        found.push(Bound {
            of,
            value,
            source,
            motion: model.motion,
            unit: model.effort().unit(),
            is_shown: options.reached.iter().any(|reached| reached.of == of),
            cuts: cuts
                .filter_map(|(term, effect)| Cut::of(term, effect, value, model))
                .collect(),
        });
    }
    Ok(found)
}

/// Twice the largest of a kind on the recordings; 0 without one.
fn needed(options: &Options, of: Argument) -> f64 {
    let reached = options.reached.iter().filter(|reached| reached.of == of);
    HEADROOM * reached.fold(0.0, |most: f64, reached| most.max(reached.largest))
}

fn of_levels(options: &Options) -> (f64, Source) {
    match needed(options, Argument::LevelLimit).min(LARGEST_LEVEL) {
        seen if seen > LEVEL_LIMIT => (seen, Source::Recording),
        _ => (LEVEL_LIMIT, Source::Default),
    }
}

fn of_forces(model: &Model, options: &Options) -> Result<(f64, Source), String> {
    let breakaway = model.friction.breakaway();
    let seen = needed(options, Argument::ForceLimit);
    if let Some(limit) = options.limit.filter(|l| l.is_finite() && *l > 0.0) {
        holds(model, options, limit)?;
        return Ok((limit, Source::Option));
    }
    let usual = breakaway.map_or(0.0, |force| BREAKAWAYS * force);
    let (limit, source) = match seen > usual {
        true => (seen, Source::Recording),
        false => (usual, Source::Default),
    };
    if options.limit.is_none() && limit.is_finite() && limit > 0.0 {
        return Ok((limit, source));
    }
    let why = match breakaway {
        Some(_) => "",
        None => {
            "; this model has no breakaway force to take it from, and --recording would take it from your motion"
        }
    };
    Err(format!(
        "--limit: give the bound of each force that grows with speed or position, above zero ({}){why}",
        model.effort().unit()
    ))
}

/// # Errors
/// A bound that was given and cuts a term on a recording: the error of the model, which the source names, would not be the controller's.
fn holds(model: &Model, options: &Options, limit: f64) -> Result<(), String> {
    let forces = options
        .reached
        .iter()
        .filter(|reached| reached.of == Argument::ForceLimit);
    let cut: Vec<&Reached> = forces.filter(|reached| reached.largest > limit).collect();
    if cut.is_empty() {
        return Ok(());
    }
    let unit = model.effort().unit();
    let list = cut.iter().map(|reached| {
        let force = quantity(reached.largest, unit);
        format!("{} reaches {force} on {}", reached.term, reached.recording)
    });
    let list: Vec<String> = list.collect();
    let most = cut
        .iter()
        .fold(0.0, |most: f64, reached| most.max(reached.largest));
    Err(format!(
        "--limit {limit}: {}; --limit {} holds {}, and without --limit the recording gives the bound",
        list.join(", "),
        above(most),
        if list.len() == 1 { "it" } else { "all" }
    ))
}

/// A number of two figures that is not below `value`.
fn above(value: f64) -> f64 {
    let step = 10_f64.powi(value.log10().floor() as i32 - 1);
    let up = (value / step).ceil() * step;
    // The product's dust.
    format!("{up:.2e}").parse().unwrap_or(up)
}

impl Cut {
    /// Where the bound holds a term; `None` for one that is nothing.
    fn of(term: String, effect: &Effect, bound: f64, model: &Model) -> Option<Self> {
        let (coefficient, power, key) = match effect {
            e if e.is(&form::VISCOUS) => (e.get("viscous_N_s_per_m"), 1.0, SPEED),
            e if e.is(&form::VISCOUS_ASYMMETRY) => (e.get("half_difference_N_s_per_m"), 1.0, SPEED),
            e if e.is(&form::QUADRATIC_DRAG) => (e.get("drag_N_s2_per_m2"), 0.5, SPEED),
            e if e.is(&form::POSITION_SPRING) => (e.get("stiffness_N_per_m"), 1.0, PLACE),
            e if e.is(&form::THERMAL_DRIFT) => (e.get("level_per_K"), 1.0, "beyond_K"),
            e if e.is(&form::LOAD_DEPENDENT_FRICTION) => (e.get("level_per_N"), 1.0, LOAD),
            _ => return None,
        };
        let distance = (bound / coefficient.abs()).powf(power);
        if !distance.is_finite() {
            return None;
        }
        let linear = model.motion == MotionKind::Linear;
        let shown = |unit| quantity(distance, unit);
        let words = match key {
            SPEED => format!(
                "{term} above {}",
                shown(if linear { "m/s" } else { "rad/s" })
            ),
            PLACE => format!(
                "{term} beyond ±{} of its centre",
                shown(if linear { "m" } else { "rad" })
            ),
            LOAD => format!("{term} beyond ±{} of its load", shown("N")),
            _ => format!("{term} beyond ±{} K of its temperature", three(distance)),
        };
        Some(Self {
            term,
            key,
            distance,
            words,
        })
    }
}

const SPEED: &str = "beyond_m_s";
const PLACE: &str = "beyond_m";
const LOAD: &str = "beyond_load_N";

impl Bound {
    /// The bound, what it is taken from and where it cuts, a sentence without its full stop.
    fn said(&self) -> String {
        let cuts: Vec<&str> = self.cuts.iter().map(|cut| cut.words.as_str()).collect();
        let bound = match self.of {
            Argument::ForceLimit => format!("Force bound {}", quantity(self.value, self.unit)),
            _ => format!(
                "Bound of temperature and load {} of the friction level",
                three(self.value)
            ),
        };
        let source = match (self.source, self.of) {
            (Source::Option, _) => " (--limit)",
            (Source::Recording, _) => " (twice the largest on the recordings)",
            (Source::Default, Argument::ForceLimit) => " (ten times the breakaway force)",
            (Source::Default, _) => "",
        };
        if cuts.is_empty() {
            return bound + source;
        }
        format!("{bound}{source} cuts {}", cuts.join(", "))
    }

    /// The same, with what moves it where nothing showed how much is needed.
    pub fn said_with_remedy(&self) -> String {
        match self.remedy() {
            "" => self.said(),
            remedy => format!("{}; {remedy}", self.said()),
        }
    }

    fn remedy(&self) -> &'static str {
        match (self.source, self.of) {
            (Source::Option | Source::Recording, _) => "",
            _ if self.is_shown => "",
            (Source::Default, Argument::ForceLimit) => {
                "--limit raises the bound, --recording REC takes it from your motion"
            }
            (Source::Default, _) => "--recording REC takes it from your motion",
        }
    }

    /// For machines.
    pub fn to_json(&self) -> Value {
        let cuts = self.cuts.iter().map(|cut| {
            // A load is in N on any axis.
            let key = match cut.key {
                LOAD => LOAD.to_owned(),
                key => key_of(self.motion, key),
            };
            json!({ "term": cut.term, key: cut.distance })
        });
        let key = match self.of {
            Argument::ForceLimit => key_of(self.motion, "limit_N"),
            _ => "limit".to_owned(),
        };
        let source = match self.source {
            Source::Option => "option",
            Source::Recording => "recording",
            Source::Default => "default",
        };
        json!({ "from": source, key: self.value, "cuts": cuts.collect::<Vec<_>>() })
    }
}

#[cfg(test)]
mod tests;
