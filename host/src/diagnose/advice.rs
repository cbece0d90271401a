//! What a diagnosis advises to do, in sentences.

use super::effect::actuator_saturation::READING;
use super::given::{Given, Refitted};
use super::named::{Name, Named};
use super::unnamed::Unknown;
use super::verdict::{Diagnosis, Verdict};
use preslide_fit::effects::form;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::{capital, left, probability};
use preslide_fit::report::units::name_and_unit;

/// Of a constant force, and of the difference that a direction makes to Coulomb friction.
pub(super) const ONE_FORCE: &str =
    "In sliding, a constant force and Coulomb friction that differs by direction are one force";

impl Unknown {
    /// What it asks for: the experiment of what it is most like, or eyes.
    fn advice(&self, found: &Diagnosis) -> String {
        let axis = self.axis.name(&found.null.rows.s);
        if self.rises_by.is_some() {
            return "record the temperature (`temperature_C`), and repeat the strokes after a rest: warm-up goes back, run-in does not.".to_owned();
        }
        if self.happened.is_some() {
            return "look at what happened then: a knock, something in the guideway, a cable that caught; or play, ageing or an end of the drive that shows in that motion alone: repeat it. Everything else leaves these stretches out.".to_owned();
        }
        match self.like {
            Some(effect) if !effect.axis().is_akin(self.axis) => format!(
                "something acts that is like {} and changes with {axis}, which is in no catalogue; look at the maps of what is left on the page of --report.",
                effect.name()
            ),
            Some(effect) => format!(
                "something that follows {axis} acts and may be {} ({}). To be sure: {}.",
                effect.name(),
                effect.words(),
                effect.experiment()
            ),
            None => format!(
                "something acts that follows {axis} and is in no catalogue; look at the maps of what is left on the page of --report."
            ),
        }
    }
}

impl Diagnosis {
    /// What to do.
    pub fn recommendation(&self, recording: &Recording) -> String {
        let advice = match (self.verdict, self.unknown()) {
            (Verdict::MissingPhysics | Verdict::ParametersDiffer, _)
                if self.missing().next().is_some() =>
            {
                self.advice_on_missing(recording)
            }
            (Verdict::ParametersDiffer, _) => self.correct(recording),
            (Verdict::InsufficientData, _) => "record strokes over the whole travel at several speeds, in both directions, with the effort of the motor (`preslide diagnose … --experiment motion.csv` writes such a motion).".to_owned(),
            _ if self.displacement_factor().is_some() => {
                "identify the model's hysteresis again (`preslide identify`); its law can stay.".to_owned()
            }
            (Verdict::UnknownPhysics, Some(unknown)) => unknown.advice(self),
            (Verdict::UnknownPhysics, None) => "look at the maps of what is left on the page of --report; nothing in the catalogue explains it.".to_owned(),
            _ => self.keep(recording),
        };
        let said = matches!(
            self.verdict,
            Verdict::ParametersDiffer | Verdict::Consistent
        );
        if said || self.wrong().next().is_none() {
            let in_vain = match self.missing().next().is_some() && self.writes_as_given(recording) {
                true => {
                    " `-o FILE` writes the model as it is: no refit with that in it leaves less on stretches held out and by `preslide simulate`."
                }
                false => "",
            };
            return format!("Recommendation: {advice}{in_vain}");
        }
        // What is worth more comes first.
        let names: f64 = self.budget.iter().map(|item| item.nmse).sum();
        let [parameters, _] = self.before_the_baseline();
        let (first, then) = match parameters > names {
            true => (self.correct(recording), advice),
            false => (advice, self.correct(recording)),
        };
        format!("Recommendation: {first} Also: {then}")
    }

    /// What all that is missing asks for, the additions in one sentence.
    fn advice_on_missing(&self, recording: &Recording) -> String {
        let add = format!("add to the {}: ", self.model_word());
        let (mut added, mut each) = (Vec::new(), Vec::new());
        for advice in self.missing().map(|e| self.advice(e, recording)) {
            match advice.strip_prefix(&add) {
                Some(one) => added.push(one.trim_end_matches('.').to_owned()),
                None => each.push(advice),
            }
        }
        each.dedup();
        if !added.is_empty() {
            each.insert(0, format!("{add}{}.", added.join("; ")));
        }
        each.join(" Also: ")
    }

    /// What a confident effect asks for.
    fn advice(&self, effect: &Named, recording: &Recording) -> String {
        let words = effect.name.words();
        let called = || effect.called(recording);
        match (effect.name, effect.ambiguous.first()) {
            (Name::Correction(_), _) => {
                let name = effect.name();
                format!("correct the {name} of the simulation ({words}).")
            }
            _ if effect.parameters.iter().any(|(key, _)| key == READING) => {
                "record with a wider range, or record the command: the reading ends where the force goes on, and those samples are left out.".to_owned()
            }
            _ if effect.in_simulation => format!("correct the {} of the simulation ({words}).", effect.name()),
            (_, None) => format!("add to the {}: {} ({words}).", self.model_word(), called()),
            (_, Some(rival)) => format!(
                "{} or {}: this recording cannot tell. To decide: {}.",
                called(),
                rival.name(),
                effect.name.experiment()
            ),
        }
    }

    /// Where numbers of the model are wrong.
    fn correct(&self, recording: &Recording) -> String {
        let wrong: Vec<&Refitted> = self.wrong().collect();
        if self.writes_as_given(recording) {
            let name = |p: &&Refitted| name_and_unit(&p.key, recording.effort_unit()).0;
            let names: Vec<String> = wrong.iter().map(name).collect();
            return format!(
                "keep {} until another recording says the same: no refit leaves less on stretches held out and by `preslide simulate` than the model as it is, which is what `-o FILE` writes.",
                names.join(", ")
            );
        }
        let effort = recording.effort_unit();
        let change = |p: &&Refitted| p.change(effort, self.written_of(p, recording));
        let each: Vec<String> = wrong.iter().map(change).collect();
        let is_constant = |p: &Refitted| p.key.starts_with(form::CONSTANT_FORCE.id);
        let either = match self.wrong().any(is_constant) {
            true => format!(" {ONE_FORCE}."),
            false => String::new(),
        };
        format!(
            "correct {} (`-o FILE` writes the model with its parameters refitted).{either}",
            each.join(", ")
        )
    }

    /// Whether `-o` writes the user's model, or the fit's, as it is.
    fn writes_as_given(&self, recording: &Recording) -> bool {
        (self.user.is_some() || self.fit.is_some()) && self.extended_model(recording).is_as_given
    }

    /// What the model that `-o` writes has of a parameter.
    pub(super) fn written_of(&self, parameter: &Refitted, recording: &Recording) -> f64 {
        let written =
            |given: &Given| parameter.written(&given.model, &self.extended_model(recording).model);
        self.given_model
            .as_ref()
            .map_or(parameter.found.value, written)
    }

    /// Where nothing material is missing; the likeliest suspicion is worth an experiment at most.
    fn keep(&self, recording: &Recording) -> String {
        /// Times the measured noise up to which what is left is noise.
        const NOISE: f64 = 1.5;
        let unrepeated = self.unrepeated.unwrap_or(0.0);
        let keep = if self.lacks_law(recording).is_some() {
            format!(
                "keep the {} above the speeds over which friction reverses; below them no law that a model file has is the machine's.",
                self.model_word()
            )
        } else if self.extended.test <= NOISE * self.noise_floor {
            format!("keep the {}; what is left is noise.", self.model_word())
        } else if self.extended.test <= NOISE * (self.noise_floor + unrepeated) {
            format!(
                "keep the {}; what is left varies from repeat to repeat: time, path or warmth may explain it, but no law of the motion.",
                self.model_word()
            )
        } else {
            format!(
                "keep the {}; of the {} left, {} is noise or varies between repeats, and nothing in the catalogue explains the rest.",
                self.model_word(),
                left(self.extended.test),
                left(self.noise_floor + unrepeated)
            )
        };
        let refitted = self
            .given_model
            .iter()
            .find(|g| g.refitted.test < 0.5 * g.stands && !self.writes_as_given(recording));
        let keep = keep + &refitted.map_or(String::new(), |given| {
            format!(
                " With its parameters refitted it leaves {} instead of {}, though none is off by as much as a machine changes from day to day (`-o FILE` writes it).",
                left(given.refitted.test),
                left(given.stands)
            )
        });
        let by_confidence = |a: &&Named, b: &&Named| a.confidence.total_cmp(&b.confidence);
        let Some(likeliest) = self.suspected().max_by(by_confidence) else {
            return keep;
        };
        format!(
            "{keep} {} is suspected, with a probability of {} ({}). To be sure: {}.",
            capital(likeliest.name()),
            probability(likeliest.confidence),
            likeliest.name.words(),
            likeliest.name.experiment()
        )
    }

    fn model_word(&self) -> &'static str {
        if self.null.core.corrects {
            "simulation"
        } else {
            "model"
        }
    }
}
