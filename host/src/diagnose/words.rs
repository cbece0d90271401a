//! A diagnosis in sentences, in the machine's own units.

use super::axis::Axis;
use super::channel::FREQUENCY;
use super::effect::{Line, actuator_saturation::READING};
use super::given::{Given, Refitted, delay_of};
use super::hysteresis;
use super::named::{Name, Named};
use super::place::{Place, means_over};
use super::simulation::Correction;
use super::smooth::SmoothLaw;
use super::unnamed::Unknown;
use super::verdict::{Diagnosis, Verdict};
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::{
    between, capital, duration, estimate, left, percent, probability, quantity, times,
};
use preslide_fit::report::units::name_and_unit;
use preslide_fit::statistics::quantile_between_ranks;

/// NMSE (%) up to which what is left without a name is a trifle: a twentieth of the effort's deviation.
const TRIFLE: f64 = 0.25;
/// Share of what a suspicion would take that must be no noise.
const MOST_OF_IT: f64 = 0.5;
/// A force is called a change of the friction level where this share of its squares goes with, or against, the direction.
const WITH_DIRECTION: f64 = 0.8;

impl Name {
    /// Id in JSON.
    pub fn id(self) -> &'static str {
        match self {
            Name::Entry(effect) => effect.id(),
            Name::Hysteresis => hysteresis::ID,
            Name::Correction(what) => what.id(),
        }
    }

    /// For a person.
    pub fn name(self) -> &'static str {
        match self {
            Name::Entry(effect) => effect.name(),
            Name::Hysteresis => hysteresis::NAME,
            Name::Correction(what) => what.id(),
        }
    }

    /// What it is.
    pub fn words(self) -> &'static str {
        match self {
            Name::Entry(effect) => effect.words(),
            Name::Hysteresis => hysteresis::WORDS,
            Name::Correction(what) => what.words(),
        }
    }

    /// The experiment that decides between it and its rivals.
    pub fn experiment(self) -> &'static str {
        match self {
            Name::Entry(effect) => effect.experiment(),
            Name::Hysteresis => hysteresis::EXPERIMENT,
            Name::Correction(what) => what.experiment(),
        }
    }
}

impl Named {
    /// Id in JSON.
    pub fn id(&self) -> &'static str {
        self.name.id()
    }

    /// Its name for a person: what ends a reading is no drive.
    pub(super) fn name(&self) -> &'static str {
        match self.parameters.iter().any(|(key, _)| key == READING) {
            true => "saturation of the reading",
            false => self.name.name(),
        }
    }

    /// The same with the period, frequency or place that tells it from others of its kind.
    pub fn called(&self, recording: &Recording) -> String {
        let name = self.name();
        let effect = self.term.as_ref().and_then(|t| Some((t.effect()?, t)));
        let Some((effect, first)) = effect.and_then(|(e, t)| Some((e, *t.shape.first()?))) else {
            let mut own = self.parameters.iter();
            let above = own.find(|(key, _)| key == FREQUENCY);
            return above.map_or(name.to_owned(), |(_, hz)| {
                format!("{name} at {}", quantity(hz.value, "Hz"))
            });
        };
        let in_position = || quantity(first, recording.position_unit());
        match effect.line() {
            Some(Line::Time) => format!("{name} at {}", quantity(first, "Hz")),
            Some(_) => format!("{name} every {}", in_position()),
            None if effect.is_narrow() => format!("{name} at {}", in_position()),
            None => name.to_owned(),
        }
    }

    /// `confident` or `suspected`.
    pub fn level(&self) -> &'static str {
        if self.confident {
            "confident"
        } else {
            "suspected"
        }
    }
}

impl Refitted {
    /// Its name for people, and of an effort in such a unit what it is given, what was found and what is `written`.
    pub(super) fn words(&self, effort: &str, written: f64) -> [String; 4] {
        let (name, unit) = name_and_unit(&self.key, effort);
        let found = estimate(self.found.value, self.found.ci95, &unit);
        let [given, written] = [self.given, written].map(|value| quantity(value, &unit));
        [name, given, found.trim_end().to_owned(), written]
    }

    /// From what to what it is `written`: `mass 9.62 kg → 12.90 ± 0.05 kg`.
    pub(super) fn change(&self, effort: &str, written: f64) -> String {
        let [name, given, found, other] = self.words(effort, written);
        let to = match written == self.found.value {
            true => found,
            false => other,
        };
        format!("{name} {given} → {to}")
    }
}

impl Unknown {
    /// What is left, in a clause.
    pub fn words(&self, found: &Diagnosis, recording: &Recording) -> String {
        let s = &found.null.rows.s;
        if let Some(happened) = &self.happened {
            return self.event_words(&happened.times, recording);
        }
        if let Some(rise) = self.rises_by {
            return format!(
                "friction {} by {} within {}; by time, path or warmth, this recording cannot say which: {} RMS, {} of what is left, probability {}",
                if rise > 0.0 { "rises" } else { "falls" },
                percent(rise.abs()),
                duration(s.duration()),
                quantity(self.rms, recording.effort_unit()),
                percent(self.size),
                probability(self.confidence),
            );
        }
        let place = self.place.map_or(String::new(), |p| {
            format!(", largest {}", place_words(&p, recording))
        });
        let axis = self.axis.name(s);
        let what = match (self.change, self.like) {
            (Some(change), _) => change.name().to_owned(),
            (_, Some(effect)) if !effect.axis().is_akin(self.axis) => {
                format!("something like {} that changes with {axis}", effect.name())
            }
            (_, Some(effect)) => format!(
                "something that follows {axis}, most like {}, which is too doubtful to name",
                effect.name()
            ),
            _ => format!("something that follows {axis}"),
        };
        format!(
            "{what}, {}{place}: {} RMS, {} of what is left; something is there with a probability of {}",
            if self.odd {
                "flipping with the direction"
            } else {
                "the same in both directions"
            },
            quantity(self.rms, recording.effort_unit()),
            percent(self.size),
            probability(self.confidence),
        )
    }

    /// An event in a clause.
    fn event_words(&self, times: &[[f64; 2]], recording: &Recording) -> String {
        let told: Vec<String> = times.iter().map(|t| between(t[0], t[1], "s")).collect();
        format!(
            "something that happened {} and not in similar motion at other times, {}: {} RMS, {} of what is left",
            told.join(", "),
            if self.odd {
                "of the friction level"
            } else {
                "a force"
            },
            quantity(self.rms, recording.effort_unit()),
            percent(self.size),
        )
    }
}

pub(super) fn place_words(place: &Place, recording: &Recording) -> String {
    between(
        place.from,
        place.to,
        &place.axis.unit(recording.position_unit()),
    )
}

/// How large an effect's force is: of the effort where it is a share of that, of the friction level where it goes with the direction, else in its unit.
fn size(found: &Diagnosis, effect: &Named, recording: &Recording) -> String {
    let force = &effect.force;
    if let Name::Entry(entry) = effect.name
        && entry.line() == Some(Line::Effort)
        && let Some((_, share)) = effect.parameters.first()
    {
        return format!(
            "the motor gives up to {} more or less for its current",
            percent(share.value)
        );
    }
    let large = quantile_between_ranks(&force.iter().map(|f| f.abs()).collect::<Vec<_>>(), 0.98);
    let level = found.null.baseline.level;
    let share = large / level.max(1e-300);
    let differs = |way: &str| match share < 1.0 {
        true => format!(
            "friction is up to {} {way}, in both directions",
            percent(share)
        ),
        false => format!(
            "friction is off by up to {} its level, in both directions",
            times(share)
        ),
    };
    let unit = recording.effort_unit();
    // What shakes it in time knows no direction.
    let shakes = matches!(effect.name, Name::Entry(e) if e.line() == Some(Line::Time));
    match found.side(force).filter(|_| !shakes) {
        Some(side) if side > 0.0 => differs("higher"),
        Some(_) => differs("lower"),
        None if !shakes
            && effect
                .places
                .first()
                .is_some_and(|p| found.flips(p.axis, force)) =>
        {
            differs("higher or lower")
        }
        None => format!("a force of up to {} acts", quantity(large, unit)),
    }
}

impl Diagnosis {
    /// 1 where a force at the rows goes with the direction of the motion, −1 where it goes against it, `None` where it does neither.
    pub(super) fn side(&self, force: &[f64]) -> Option<f64> {
        let rows = &self.null.rows;
        let direction = rows.weak.at_centres(&rows.s.direction);
        let along: Vec<f64> = force.iter().zip(&direction).map(|(f, d)| f * d).collect();
        let square = |side: f64| -> f64 {
            along
                .iter()
                .filter(|a| **a * side > 0.0)
                .map(|a| a * a)
                .sum()
        };
        let both = square(1.0) + square(-1.0);
        [1.0, -1.0]
            .into_iter()
            .find(|side| square(*side) > WITH_DIRECTION * both)
    }

    /// Whether a force at the rows has opposite signs in the two directions at the same place of a coordinate, whichever goes with the motion
    /// there: a friction level that is higher at one end and lower at the other.
    pub(super) fn flips(&self, axis: Axis, force: &[f64]) -> bool {
        let rows = &self.null.rows;
        let Some(values) = axis.values(&rows.s) else {
            return false;
        };
        let values = rows.weak.at_centres(&values);
        let direction = rows.weak.at_centres(&rows.s.direction);
        let along: Vec<f64> = force.iter().zip(&direction).map(|(f, d)| f * d).collect();
        let held = |f: &[f64]| -> f64 { means_over(&values, f).1.iter().map(|m| m * m).sum() };
        held(&along) > held(force)
    }

    /// One sentence on an effect: where, how much, what it is, what it explains, what compensating it is worth.
    pub fn sentence(&self, effect: &Named, recording: &Recording) -> String {
        let confined = effect.places.iter().find(|p| p.share > 0.0);
        let place = confined.map_or(String::new(), |p| {
            format!("{}, ", place_words(p, recording))
        });
        let text = format!(
            "{place}{}: {}. It explains {} of what is left without it{}",
            size(self, effect, recording),
            effect.name(),
            percent(effect.evidence.share),
            self.worth(effect, recording),
        );
        capital(&text)
    }

    /// What compensating an effect takes off the residual on stretches held out, in a clause; nothing where that was not measured. Its own force
    /// may be far larger: most of it may be what the other terms would take as well.
    fn worth(&self, effect: &Named, recording: &Recording) -> String {
        let [without, with] = effect.nmse_test;
        if !(without.is_finite() && with.is_finite()) {
            return String::new();
        }
        let force = |nmse| quantity(self.null.rows.rms_of(nmse), recording.effort_unit());
        match without > with {
            true => format!(
                "; compensated, it takes {} RMS off the {} left on stretches held out",
                force(without - with),
                force(without)
            ),
            false => format!(
                "; compensated, it takes nothing off the {} RMS left on stretches held out",
                force(without)
            ),
        }
    }

    /// Verdict in one sentence.
    pub fn verdict_words(&self, recording: &Recording) -> String {
        self.verdict_clauses(recording).join("; ")
    }

    /// The same with a clause a line.
    pub fn verdict_lines(&self, recording: &Recording) -> String {
        self.verdict_clauses(recording).join(";\n  ")
    }

    /// The verdict itself, and what is to be said beside it.
    fn verdict_clauses(&self, recording: &Recording) -> Vec<String> {
        let in_fit: Vec<&str> = self.in_fit().map(|e| e.name()).collect();
        let in_fit = (!in_fit.is_empty()).then(|| format!("in the fit: {}", in_fit.join(", ")));
        let nameless = self.nameless().map(|u| u.words(self, recording));
        std::iter::once(self.verdict_clause(recording, true))
            .chain(in_fit)
            .chain(self.remarks(recording))
            .chain(nameless.map(|words| format!("without a name: {words}")))
            .collect()
    }

    /// The verdict in a clause, of what is missing with its names or without, where they follow.
    pub(super) fn verdict_clause(&self, recording: &Recording, names: bool) -> String {
        let between = self.unrepeated.filter(|u| *u > 0.0);
        let between = between.map_or(String::new(), |u| {
            format!(", {} varying between repeats", left(u))
        });
        let figures = format!(
            "held-out NMSE {} before, {} after, {} expected of noise{between}",
            left(self.baseline.test),
            left(self.extended.test),
            left(self.noise_floor)
        );
        match self.verdict {
            Verdict::Consistent if self.null.core.corrects => format!(
                "consistent: no difference larger than {} of the variance ({figures})",
                left(self.baseline.test.max(self.null.rows.missed))
            ),
            Verdict::Consistent if self.lacks_law(recording).is_some() => format!(
                "consistent in all but the friction law: nothing else material is missing ({figures})"
            ),
            Verdict::Consistent if self.not_explained() > TRIFLE => format!(
                "consistent: nothing in the catalogue is missing, but {} of the variance is neither noise nor explained ({figures})",
                left(self.not_explained())
            ),
            Verdict::Consistent => format!("consistent: nothing material is missing ({figures})"),
            Verdict::ParametersDiffer if self.null.core.corrects => {
                let names: Vec<&str> = self.missing().map(|e| e.name()).collect();
                format!(
                    "parameters differ: no physics is named, but the simulation's {} not the recording's ({figures})",
                    match names.as_slice() {
                        [one] => format!("{one} is"),
                        many => format!("{} are", many.join(", ")),
                    }
                )
            }
            Verdict::ParametersDiffer => {
                let wrong = self.wrong();
                let names: Vec<String> = wrong.map(|p| name_and_unit(&p.key, "").0).collect();
                format!(
                    "parameters differ: no physics is named, but {} ({figures})",
                    match names.as_slice() {
                        [one] => format!("{one} is wrong"),
                        many => format!("{} are wrong", many.join(", ")),
                    }
                )
            }
            Verdict::MissingPhysics if !names => format!("missing physics ({figures})"),
            Verdict::MissingPhysics => {
                let names: Vec<String> = self.missing().map(|e| e.called(recording)).collect();
                format!("missing physics: {} ({figures})", names.join(", "))
            }
            Verdict::UnknownPhysics if self.unknown().is_none() => format!(
                "unknown physics: {} of the variance is neither noise nor in the catalogue ({figures})",
                left(self.not_explained())
            ),
            Verdict::UnknownPhysics => format!("unknown physics ({figures})"),
            Verdict::InsufficientData if self.doubt.is_some() => format!(
                "insufficient data: {}; record strokes at several speeds, sampled fast enough to see them ({figures})",
                self.doubt.as_deref().unwrap_or_default()
            ),
            Verdict::InsufficientData if self.noise_floor > 0.5 * self.extended.test => format!(
                "insufficient data: noise makes {} of the variance, and {} more nothing explains; record less noise, or for longer ({figures})",
                left(self.noise_floor),
                left(self.not_explained())
            ),
            Verdict::InsufficientData => format!(
                "insufficient data: the best model leaves {:.0} % of the variance on stretches held out, and nothing in the catalogue explains it ({figures})",
                self.extended.test
            ),
        }
    }

    /// What is to be said of the model beside the verdict, a clause each.
    pub(super) fn remarks(&self, recording: &Recording) -> Vec<String> {
        let mut clauses = Vec::new();
        let wrong = self.wrong();
        let wrong: Vec<String> = wrong.map(|p| name_and_unit(&p.key, "").0).collect();
        if !wrong.is_empty() && self.verdict != Verdict::ParametersDiffer {
            clauses.push(format!("wrong in the model: {}", wrong.join(", ")));
        }
        clauses.extend(self.allowed_words());
        clauses.extend(self.other_law(recording));
        clauses.extend(self.too_soft());
        if let Some(law) = self.lacks_law(recording) {
            clauses.push(law.words(recording));
        } else if self.null.core.follows_velocity() {
            clauses.push("friction reverses smoothly over the slowest speeds, as tanh(v/v0), not along the path: hysteresis alone, GMS's too, would leave most of the mismatch".to_owned());
        }
        if let Some(wanders) = self.unnamed.iter().find(|u| u.wanders && u.is_sure()) {
            let axis = wanders.axis.name(&self.null.rows.s);
            let what = match wanders.axis {
                Axis::Time | Axis::Path | Axis::Position => format!("friction wanders over {axis}"),
                _ => format!("friction departs from its law over {axis}"),
            };
            let by = quantity(wanders.rms, recording.effort_unit());
            clauses.push(format!("{what} by {by} RMS, too little to tell from an error of the friction law, and so not named"));
        }
        clauses
    }

    /// Further columns that are left out, each in a sentence without its full stop.
    pub fn left_out_words(&self) -> impl Iterator<Item = String> {
        let left_out = self.null.rows.s.left_out.iter();
        left_out.map(|(name, kind)| format!("`{name}` {}: it is left out", kind.words()))
    }

    /// The user's model as it stands and refitted, in a sentence without its full stop.
    pub fn given_words(&self, recording: &Recording) -> Option<String> {
        self.given_model.as_ref().map(|given| {
            let refitted = match given.refitted.test < given.stands {
                _ if given.law.is_some() => {
                    "its parameters are not refitted on its own law, which would bend them"
                        .to_owned()
                }
                true => format!(
                    "with its parameters refitted{} {} on stretches held out",
                    match self.missing().next() {
                        Some(_) => " beside what is missing",
                        None => "",
                    },
                    left(given.refitted.test)
                ),
                false => {
                    "a refit of its parameters on its own law leaves no less on stretches held out"
                        .to_owned()
                }
            };
            // What -o writes need not be the refit.
            let written = self.extended_model(recording);
            let otherwise = match (written.is_on_the_core, written.is_as_given) {
                (true, _) => "; -o writes a finer hysteresis and the parameters that go with it",
                (_, true) => "; -o writes it as it is",
                _ => "",
            };
            format!(
                "your model as it stands leaves {} of the variance; {refitted}{otherwise}",
                left(given.stands)
            )
        })
    }

    /// Effects that are stated with confidence.
    pub fn confident(&self) -> impl Iterator<Item = &Named> {
        self.effects.iter().filter(|e| e.confident)
    }

    /// Those of them that the fit has.
    pub fn in_fit(&self) -> impl Iterator<Item = &Named> {
        self.confident().filter(|e| e.in_fit)
    }

    /// Those that it has not.
    pub fn missing(&self) -> impl Iterator<Item = &Named> {
        self.confident().filter(|e| e.is_missing())
    }

    /// What the displacements of the model's hysteresis are to be multiplied by, where that mends it.
    pub(super) fn displacement_factor(&self) -> Option<f64> {
        let own = self
            .effects
            .iter()
            .filter(|e| matches!(e.name, Name::Hysteresis));
        let mut parameters = own.flat_map(|e| &e.parameters);
        parameters
            .find(|p| p.0 == hysteresis::DISPLACEMENT_FACTOR)
            .map(|p| p.1.value)
    }

    /// Where a simulation's friction follows another law than the recording's.
    fn other_law(&self, recording: &Recording) -> Option<String> {
        let slow = self.null.core.simulated_law()?;
        let is_stated = |e: &Named| matches!(e.name, Name::Correction(Correction::Friction));
        self.missing().any(is_stated).then(|| {
            let slow = quantity(slow, &format!("{}/s", recording.position_unit()));
            format!("the simulation's friction reverses with the velocity, as tanh(v/v0) with v0 = {slow}, and the recording's along the path: pre-sliding is what it lacks")
        })
    }

    /// The delay of a recording whose model has one, in a clause.
    fn allowed_words(&self) -> Option<String> {
        let delay = self.allowed?;
        let given = self.user.as_ref().map_or(0.0, delay_of);
        let is_wrong = self.wrong().any(Refitted::is_delay);
        let allows = match is_wrong {
            true => format!("the model allows for {}", quantity(given, "s")),
            false => "the model allows for it".to_owned(),
        };
        Some(format!("{}, and {allows}", delay.recorded()))
    }

    /// The same in a clause.
    pub(super) fn too_soft(&self) -> Option<String> {
        self.displacement_factor().map(|factor| {
            format!(
                "the model's hysteresis is too soft: it fits with its displacements × {factor:.2}"
            )
        })
    }

    /// The parameters of the user's model that are wrong.
    pub(super) fn wrong(&self) -> impl Iterator<Item = &Refitted> {
        self.given_model.iter().flat_map(Given::wrong)
    }

    /// Whether most of what a suspicion would take is noise by the figures that stand beside it.
    fn is_of_noise(&self, suspicion: &Named) -> bool {
        let takes = suspicion.evidence.share.clamp(0.0, 1.0) * self.extended.test;
        self.not_explained() < MOST_OF_IT * takes
    }

    /// What is not of the fit, what the recording can show, and what is so likely as to be worth a word.
    pub(super) fn suspected(&self) -> impl Iterator<Item = &Named> {
        /// One in ten: of ten such suspicions nine are nothing.
        const WORTH_A_WORD: f64 = 0.1;
        let hidden = |id: &str| {
            self.lacks
                .iter()
                .any(|lack| lack.hides.iter().any(|e| e.id() == id))
        };
        let effects = self.effects.iter();
        effects.filter(move |e| {
            !e.in_fit
                && e.confidence >= WORTH_A_WORD
                && !hidden(e.id())
                && (e.confident || !self.is_of_noise(e))
        })
    }

    /// The law of the recording's friction, where it reverses with the speed.
    pub(super) fn smooth_law(&self) -> Option<SmoothLaw> {
        SmoothLaw::of(&self.null, &self.states[1])
    }

    /// The same, where the user's model, or the fit's, has another.
    pub(super) fn lacks_law(&self, recording: &Recording) -> Option<SmoothLaw> {
        match &self.given_model {
            Some(given) => given.law,
            None if self.fit.is_some() => {
                let law = self.smooth_law()?;
                let written = self.extended_model(recording);
                written.is_of_another_law.then_some(law)
            }
            None => None,
        }
    }
}
