//! The user's model against the recording: as it stands, and with its own parameters refitted. Wrong parameters are an answer of their own,
//! and no physics: the over-resolved core that names are judged on refits them without a word.

use super::confidence;
use super::effect::ALWAYS_FREE;
use super::modelled::effort_of;
use super::normal::{Bound, Normal};
use super::null_model::{Hypothesis, Nmse, NullModel};
use super::smooth::SmoothLaw;
use super::term::{Subject, Term};
use super::weak::Column;
use super::without_delay;
use preslide_fit::effects::{Effect, form};
use preslide_fit::model::Model;
use preslide_fit::recording::Recording;
use preslide_fit::signal::Delay;
use preslide_fit::statistics::{Estimate, jackknife};

/// Keys of an effect's size, to which its force is in proportion.
const SIZES: [&str; 8] = [
    "force_N",
    "level",
    "asymmetry",
    "stiffness_N_per_m",
    "drag_N_s2_per_m2",
    "half_difference_N_s_per_m",
    "level_per_K",
    "level_per_N",
];
/// Relative difference from which a parameter is said to be wrong: an identification repeated on another day, or with another motion, comes
/// within it.
const APART: f64 = 0.1;
/// NMSE (%) that its difference must be worth by itself, of the effort or of the friction, whichever is smaller: as much as a term that enters, of a
/// model that leaves ten per cent.
const WORTH: f64 = 0.1;
/// The same, of what the model leaves with its parameters refitted: less may be its form's error, which no parameter mends.
const OF_LEFT: f64 = 1.0;

/// Times what the core leaves that another law must leave at least …
const WORSE: f64 = 2.0;
/// … and by so much more (NMSE, %).
const NOTICED: f64 = 0.1;

/// A model as it stands.
pub struct Given {
    /// NMSE (%) of the model as it stands: nothing of it is fitted.
    pub stands: f64,
    /// The same with its parameters refitted.
    pub refitted: Nmse,
    /// Measured less modelled effort at the rows (N or N·m), as it stands and refitted.
    pub(super) mismatch: [Vec<f64>; 2],
    /// Its parameters.
    pub parameters: Vec<Refitted>,
    /// The model with its parameters refitted.
    pub model: Model,
    /// The law of the recording's friction, where it reverses with the speed and the model has another: then nothing is refitted.
    pub(super) law: Option<SmoothLaw>,
}

/// A parameter of the model.
pub struct Refitted {
    /// Its key in the model file, an effect's behind the effect's id.
    pub key: String,
    /// As it is given (SI).
    pub given: f64,
    /// Refitted.
    pub found: Estimate,
    /// NMSE (%) that the difference is worth.
    pub worth: f64,
    /// Whether it is wrong: beyond its interval, beyond what identifications differ by, and worth something.
    pub differs: bool,
    part: Part,
}

/// Whose parameter it is.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Inertia,
    Level,
    Viscous,
    ViscousOf(f64),
    Constant,
    Delay,
    /// The number of an effect.
    Effect(usize),
}

/// A parameter with its force as it is given, at the rows.
struct Share {
    part: Part,
    key: String,
    given: f64,
    force: Vec<f64>,
}

impl Refitted {
    /// Whether it is the delay of the effort.
    pub fn is_delay(&self) -> bool {
        self.part == Part::Delay
    }

    /// Its value beside another law.
    fn beside(&self, law: &SmoothLaw) -> Option<f64> {
        match self.key.as_str() {
            key if key.starts_with("mass") || key.starts_with("inertia") => law.inertia,
            key if key.starts_with("viscous_N") => law.viscous,
            key if key.starts_with("viscous_half") => None,
            _ if self.part == Part::Level => Some(law.coulomb),
            _ => None,
        }
    }

    /// Whether it is wrong, where the refitted model leaves so much (%) and less than `least` (%) is worth nothing.
    fn is_wrong(&self, left: f64, least: f64) -> bool {
        let outside = self
            .found
            .ci95
            .is_some_and(|[low, high]| !(low..=high).contains(&self.given));
        let apart = (self.found.value - self.given).abs() > APART * self.given.abs();
        outside && apart && self.worth > least.max(OF_LEFT * left)
    }
}

impl Given {
    /// Judges a model beside what a hypothesis names besides, and a delay, which every recording may have; `allowed` is the one that the rows are
    /// without and the model has. `None` where an effect needs what was
    /// not recorded, or where the motion does not determine the parameters.
    pub fn of(
        null: &NullModel,
        extended: &Hypothesis,
        recording: &Recording,
        model: &Model,
        allowed: Option<Delay>,
    ) -> Option<Self> {
        let delay = Term::new(Subject::Effect(ALWAYS_FREE), &[]);
        let named = extended.terms.iter().filter(|t| !t.is_delay());
        let beside: Vec<Term> = named.chain([&delay]).cloned().collect();
        let judged = Self::beside(null, &beside, recording, model, allowed)?;
        let core = extended.nmse(&null.rows).test;
        Some(match SmoothLaw::of(null, extended) {
            Some(law) => judged.beside_law(law, model, core),
            None => judged,
        })
    }

    /// Judges a model beside some terms.
    pub(super) fn beside(
        null: &NullModel,
        terms: &[Term],
        recording: &Recording,
        model: &Model,
        allowed: Option<Delay>,
    ) -> Option<Self> {
        let rows = &null.rows;
        let at_rows = |model: &Model| Some(rows.weak.rows(&effort_of(model, recording).ok()?));
        let as_recorded = rows.weak.rows(&Column::of(recording.effort.clone()));
        let leaves = |model: &Model| Some(rows.nmse(&left(&as_recorded, &at_rows(model)?)));
        let as_it_stands = left(&as_recorded, &at_rows(model)?);
        let stands = rows.nmse(&as_it_stands);
        let late = allowed.map(|found| Late::of(model, found, |late| Some(leaves(late)? - stands)));
        let prompt = late.as_ref().map(|_| without_delay(model));
        let model = prompt.as_ref().unwrap_or(model);
        let whole = at_rows(model)?;
        let shares = shares(null, recording, model)?;
        // What is in no proportion to a parameter stays as it is.
        let mut fixed = whole;
        for share in &shares {
            fixed
                .iter_mut()
                .zip(&share.force)
                .for_each(|(w, f)| *w -= f);
        }
        let target = left(&rows.force, &fixed);
        let fit = Fit::of(null, terms, shares, &target)?;
        // A model that has a viscous friction of each direction has it in two numbers, not three.
        let has_one = model.of(&form::VISCOUS_ASYMMETRY).next().is_none();
        let split = has_one.then(|| fit.split_by_direction(null, terms, model, &target));
        let split = split.flatten();
        let by_direction = split.and_then(|split| split.parameters(null, model));
        let own = fit.parameters(null, model)?;
        let mut model = model.clone();
        own.iter().for_each(|p| p.enter(&mut model));
        let refitted = fit.residual(false, &target);
        let train = rows.nmse(&refitted);
        let test = rows.nmse(&fit.residual(true, &target));
        let mut parameters = by_direction
            .filter(|split| is_one_way(split))
            .unwrap_or(own);
        if let Some(late) = late.flatten() {
            model.effects.push(late.effect);
            parameters.push(late.parameter);
        }
        let least = WORTH
            * (null.usual_friction() / rows.rms_of(100.0))
                .powi(2)
                .min(1.0);
        for parameter in &mut parameters {
            parameter.differs = parameter.is_wrong(test, least);
        }
        Some(Self {
            stands,
            refitted: Nmse { train, test },
            mismatch: [as_it_stands, refitted],
            parameters,
            model,
            law: None,
        })
    }

    /// Whether the model has another law than the core's, which leaves so much (NMSE, %).
    fn lacks(&self, core: f64) -> bool {
        let own = self.refitted.test.min(self.stands);
        own > WORSE * core && own - core > NOTICED
    }

    /// Of a model with another law than this one: as it stands, with the values that its parameters have beside this.
    fn beside_law(self, law: SmoothLaw, model: &Model, core: f64) -> Self {
        if !self.lacks(core) {
            return self;
        }
        let stands = self.stands;
        let beside = |mut p: Refitted| {
            if let Some(value) = p.beside(&law) {
                p.found = Estimate { value, ci95: None };
            }
            p.differs = false;
            p
        };
        Self {
            refitted: Nmse {
                train: stands,
                test: stands,
            },
            parameters: self.parameters.into_iter().map(beside).collect(),
            model: model.clone(),
            law: Some(law),
            ..self
        }
    }

    /// What the most wrong parameter is worth (NMSE, %), where one is wrong.
    pub fn worth(&self) -> Option<f64> {
        self.wrong().map(|p| p.worth).max_by(f64::total_cmp)
    }

    /// The parameters that are wrong.
    pub fn wrong(&self) -> impl Iterator<Item = &Refitted> {
        self.parameters.iter().filter(|p| p.differs)
    }
}

/// The delay of a model, found anew on the recording.
struct Late {
    effect: Effect,
    parameter: Refitted,
}

impl Late {
    /// `changes` tells what a model leaves more (NMSE, %) than the one that is given.
    fn of(model: &Model, found: Delay, changes: impl Fn(&Model) -> Option<f64>) -> Option<Self> {
        let found = found.delay_s;
        let effect = Effect::new(form::CHANNEL_DELAY.id, &[("delay_s", found.value)]).ok()?;
        let mut late = without_delay(model);
        late.effects.push(effect.clone());
        let parameter = Refitted {
            part: Part::Delay,
            key: format!("{}.delay_s", form::CHANNEL_DELAY.id),
            given: delay_of(model),
            found,
            worth: (-changes(&late)?).max(0.0),
            differs: false,
        };
        Some(Self { effect, parameter })
    }
}

/// The delay (s) of a model's effort.
pub(super) fn delay_of(model: &Model) -> f64 {
    let all = model.of(&form::CHANNEL_DELAY);
    all.map(|e| e.get("delay_s")).sum()
}

/// Whether viscous friction differs by direction beyond its intervals: halves of one that is wrong are worth half each, and neither may count.
fn is_one_way(parameters: &[Refitted]) -> bool {
    let of = |direction: f64| {
        let mut own = parameters.iter();
        let own = own.find(|p| p.part == Part::ViscousOf(direction));
        own.and_then(|p| p.found.ci95)
    };
    let apart = |([low, high], [other_low, other_high]): ([f64; 2], [f64; 2])| {
        low > other_high || other_low > high
    };
    of(1.0).zip(of(-1.0)).is_some_and(apart)
}

/// Whether a term is one of a model's own parts.
fn is_among(term: &Term, shares: &[Share]) -> bool {
    let id = term.effect().map_or("", |effect| effect.id());
    shares.iter().any(|share| match share.part {
        Part::Viscous | Part::ViscousOf(_) => id == form::VISCOUS.id,
        Part::Constant => id == form::CONSTANT_FORCE.id,
        Part::Effect(_) => share.key.split('.').next() == Some(id),
        Part::Inertia | Part::Level | Part::Delay => false,
    })
}

/// Measured less modelled.
fn left(measured: &[f64], modelled: &[f64]) -> Vec<f64> {
    measured.iter().zip(modelled).map(|(m, f)| m - f).collect()
}

/// The parameters of a model that a fit can find, each with its force.
fn shares(null: &NullModel, recording: &Recording, model: &Model) -> Option<Vec<Share>> {
    let rows = &null.rows;
    let at_rows = |column: Column| rows.weak.rows(&column);
    let n = recording.len();
    let mut shares = Vec::new();
    let mut add = |part: Part, key: &str, given: f64, force: Vec<f64>| {
        let key = preslide_fit::model::key_of(recording.kind, key);
        shares.push(Share {
            part,
            key,
            given,
            force,
        });
    };
    if model.inertia > 0.0 && rows.inertial {
        let force = null.core.rows[0].iter().map(|c| model.inertia * c);
        add(Part::Inertia, "mass_kg", model.inertia, force.collect());
    }
    let friction = Model {
        mechanics: Vec::new(),
        ..Model::of_friction(model.motion, model.friction.clone())
    };
    if let Some((key, level)) = model.friction.level() {
        let force = at_rows(effort_of(&friction, recording).ok()?);
        add(Part::Level, key, level, force);
    }
    if model.viscous != 0.0 {
        let force = rows.s.v.iter().map(|v| model.viscous * v).collect();
        let key = "viscous_N_s_per_m";
        add(
            Part::Viscous,
            key,
            model.viscous,
            at_rows(Column::of(force)),
        );
    }
    if model.constant_force != 0.0 {
        let force = at_rows(Column::of(vec![model.constant_force; n]));
        let key = "constant_force.force_N";
        add(Part::Constant, key, model.constant_force, force);
    }
    for (number, effect) in model.effects.iter().enumerate() {
        let Some(key) = SIZES.into_iter().find(|key| effect.has(key)) else {
            continue;
        };
        // Alone on the friction: what acts behind the actuator would act on it, too.
        let with = Model {
            effects: vec![effect.clone()],
            ..friction.clone()
        };
        let [with, without] =
            [&with, &friction].map(|m| Some(at_rows(effort_of(m, recording).ok()?)));
        let key = format!("{}.{key}", effect.id());
        add(
            Part::Effect(number),
            &key,
            effect.get(key.split('.').next_back()?),
            left(&with?, &without?),
        );
    }
    shares.retain(|s| s.given != 0.0 && s.force.iter().any(|f| *f != 0.0));
    Some(shares)
}

/// The parameters fitted by least squares: a wrong shape misleads a fit that trusts its noise model.
struct Fit {
    shares: Vec<Share>,
    normal: Normal,
    columns: Vec<Vec<f64>>,
}

impl Fit {
    fn of(null: &NullModel, terms: &[Term], shares: Vec<Share>, target: &[f64]) -> Option<Self> {
        let mut columns: Vec<Vec<f64>> = shares.iter().map(|s| s.force.clone()).collect();
        let named = |t: &&Term| !t.given && t.effect().is_some() && !is_among(t, &shares);
        for term in terms.iter().filter(named) {
            columns.extend(null.columns(term).iter().cloned());
        }
        let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let bounds = vec![Bound::Free; all.len()];
        let folds = &null.rows.weak.folds;
        let normal = Normal::new(&null.unweighted(), folds, &all, &bounds, target)?;
        Some(Self {
            shares,
            normal,
            columns,
        })
    }

    /// The same with viscous friction of each direction, where the model has any.
    fn split_by_direction(
        &self,
        null: &NullModel,
        terms: &[Term],
        model: &Model,
        target: &[f64],
    ) -> Option<Self> {
        let s = &null.rows.s;
        let viscous = self.shares.iter().find(|s| s.part == Part::Viscous)?;
        let of = |direction: f64| {
            let along = s.v.iter().map(|v| {
                let own = (v * direction).max(0.0) * direction;
                model.viscous * own
            });
            Share {
                part: Part::ViscousOf(direction),
                key: format!(
                    "{} {}",
                    viscous.key,
                    if direction > 0.0 { "forward" } else { "back" }
                ),
                given: viscous.given,
                force: null.rows.weak.rows(&Column::of(along.collect())),
            }
        };
        let others = self.shares.iter().filter(|s| s.part != Part::Viscous);
        let shares = others.map(Share::copy).chain([1.0, -1.0].map(of)).collect();
        Self::of(null, terms, shares, target)
    }

    fn residual(&self, held_out: bool, target: &[f64]) -> Vec<f64> {
        let columns: Vec<&[f64]> = self.columns.iter().map(Vec::as_slice).collect();
        if held_out {
            self.normal.held_out_residual(&columns, target)
        } else {
            self.normal.residual(&columns, target)
        }
    }

    /// Values with the widest interval that blocks, kinds of strokes, or folds give.
    fn parameters(&self, null: &NullModel, model: &Model) -> Option<Vec<Refitted>> {
        let rows = &null.rows;
        let mut block_of = vec![0; rows.force.len()];
        for (b, own) in rows.blocks.iter().enumerate() {
            block_of[own.clone()].fill(b);
        }
        let (by_block, by_kind) = (
            self.normal.errors(&block_of),
            self.normal.errors(&rows.kinds),
        );
        let folds = rows.weak.folds.len();
        let held: Vec<Vec<f64>> = (0..folds).map(|s| self.normal.without_fold(s)).collect();
        let fitted = |j: usize| {
            let by_fold = jackknife(&held.iter().map(|c| c[j]).collect::<Vec<_>>());
            let error = by_block[j]?.max(by_kind[j]?).max(by_fold);
            Some((self.normal.coefficients[j], error))
        };
        let level = self.shares.iter().position(|s| s.part == Part::Level);
        let level = level.map_or(Some((1.0, 0.0)), fitted)?;
        let mut all = Vec::new();
        for (j, share) in self.shares.iter().enumerate() {
            let (mut times, mut error) = fitted(j)?;
            if share.multiplies(model) {
                // Its force is in proportion to the friction level, which is refitted, too.
                let relative = (error / times).hypot(level.1 / level.0);
                times /= level.0;
                error = (times * relative).abs();
            }
            let error = (confidence::width("others") * error * share.given).abs();
            let change: Vec<f64> = share.force.iter().map(|f| (times - 1.0) * f).collect();
            let square: f64 = change.iter().map(|f| f * f).sum();
            all.push(Refitted {
                part: share.part,
                key: share.key.clone(),
                given: share.given,
                found: Estimate::new(times * share.given, Some(error), folds),
                worth: 100.0 * square / rows.variation().max(1e-300),
                differs: false,
            });
        }
        Some(all)
    }
}

impl Share {
    fn copy(&self) -> Self {
        Self {
            part: self.part,
            key: self.key.clone(),
            given: self.given,
            force: self.force.clone(),
        }
    }

    /// Whether it is a share of the friction level.
    fn multiplies(&self, model: &Model) -> bool {
        let Part::Effect(number) = self.part else {
            return false;
        };
        let effect = &model.effects[number];
        ["level", "asymmetry", "level_per_K", "level_per_N"]
            .iter()
            .any(|key| effect.has(key))
    }
}

impl Refitted {
    /// What `model` has of it, which was written for one with the effects of `given`.
    pub(super) fn written(&self, given: &Model, model: &Model) -> f64 {
        let half_difference = || {
            let mut own = model.of(&form::VISCOUS_ASYMMETRY);
            own.next()
                .map_or(0.0, |e| e.get("half_difference_N_s_per_m"))
        };
        match self.part {
            Part::Inertia => model.inertia,
            Part::Level => model.friction.breakaway().unwrap_or(0.0),
            Part::Viscous => model.viscous,
            Part::ViscousOf(direction) => model.viscous + direction * half_difference(),
            Part::Constant => model.constant_force,
            Part::Delay => delay_of(model),
            Part::Effect(number) => {
                let form = given.effects[number].form;
                let before = given.effects[..number].iter();
                let own = model
                    .of(form)
                    .nth(before.filter(|e| e.id() == form.id).count());
                let size = |e: &Effect| SIZES.into_iter().find(|key| e.has(key)).map(|k| e.get(k));
                own.and_then(size).unwrap_or(0.0)
            }
        }
    }

    /// Puts it into a model.
    fn enter(&self, model: &mut Model) {
        let value = self.found.value;
        match self.part {
            Part::Inertia => model.inertia = value.max(0.0),
            Part::Level => {
                if let Some(scaled) = model.friction.scaled(value / self.given) {
                    model.friction = scaled;
                }
            }
            Part::Viscous => model.viscous = value,
            Part::ViscousOf(_) | Part::Delay => {}
            Part::Constant => model.constant_force = value,
            Part::Effect(number) => {
                let size = |key: &str| SIZES.contains(&key);
                let own = &mut model.effects[number].values;
                if let Some((_, own)) = own.iter_mut().find(|(key, _)| size(key)) {
                    *own = value;
                }
            }
        }
    }
}
