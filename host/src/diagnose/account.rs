//! The budget in figures and words: root mean squares of what is taken off, never more than is left.

use super::advice::ONE_FORCE;
use super::named::{CERTAIN, Name, Named};
use super::verdict::Diagnosis;
use super::words::place_words;
use preslide_fit::effects::form;
use preslide_fit::model::key_of;
use preslide_fit::recording::Recording;
use preslide_fit::report::Table;
use preslide_fit::report::figures::{estimate, left, percent, probability, quantity};
use preslide_fit::report::units::name_and_unit;
use preslide_fit::statistics::Estimate;
use serde_json::{Value, json};

/// Share of the mismatch below which nobody misses a row.
const SEEN: f64 = 0.005;
/// Cells of a bar.
const BAR: f64 = 10.0;
/// Parameters listed of one finding: a map has as many as cosines.
const TOLD: usize = 3;
/// Parameters without a unit that only a model file needs.
const SMALL_PRINT: [&str; 2] = ["exponent", "slipping_only"];

impl Named {
    /// How sure it is, in a word.
    pub fn certainty(&self) -> &'static str {
        match (self.confident, self.confidence >= CERTAIN) {
            (true, true) => "certain",
            (true, false) => "likely",
            (false, _) => "possible",
        }
    }

    /// Its size in the machine's units.
    fn size(&self, recording: &Recording) -> String {
        let own = self.parameters.iter();
        let told = own.filter(|(key, _)| !SMALL_PRINT.contains(&key.as_str()));
        let told = told.take(TOLD);
        let told: Vec<String> = told
            .map(|(key, e)| parameter(&key_of(recording.kind, key), e, recording.effort_unit()))
            .collect();
        told.join(", ")
    }
}

/// A parameter by its key in a model file, of an effort in such a unit: `period 2.50 ± 0.01 mm`.
pub(super) fn parameter(key: &str, known: &Estimate, effort: &str) -> String {
    let (name, unit) = name_and_unit(key, effort);
    let size = estimate(known.value, known.ci95, &unit);
    format!("{name} {size}").trim_end().to_owned()
}

impl Diagnosis {
    /// What is left over the budget's items, the noise and what does not repeat (% of the effort's variance).
    pub(super) fn not_explained(&self) -> f64 {
        let at_random = self.noise_floor + self.unrepeated.unwrap_or(0.0);
        (self.extended.test - at_random).max(0.0)
    }

    /// What fitting the hysteresis anew beside the effects takes off besides (% of the effort's variance).
    fn refitted(&self) -> f64 {
        let items: f64 = self.budget.iter().map(|item| item.nmse).sum();
        (self.baseline.test - items - self.extended.test).max(0.0)
    }

    /// What the user's own model has beyond the baseline: by its parameters, and by a hysteresis that is coarser (% of the effort's variance);
    /// nothing where there is none, or it is no worse.
    pub(super) fn before_the_baseline(&self) -> [f64; 2] {
        let given = self
            .given_model
            .as_ref()
            .filter(|_| !self.null.core.corrects);
        given.map_or([0.0; 2], |given| {
            let refitted = given.refitted.test.max(self.baseline.test);
            let parameters = (given.stands - refitted).max(0.0);
            [
                parameters,
                (given.stands.min(refitted) - self.baseline.test).max(0.0),
            ]
        })
    }

    /// What the budget is of (% of the effort's variance).
    fn whole(&self) -> f64 {
        let before: f64 = self.before_the_baseline().iter().sum();
        (self.baseline.test + before).max(1e-300)
    }

    /// The budget for machines: what is taken off, of the residual without all of it.
    pub(super) fn budget_json(&self) -> Value {
        let share = |nmse: f64| nmse / self.whole();
        let rms = |nmse: f64| self.null.rows.rms_of(nmse);
        let items = self.budget.iter().map(|item| {
            let effect = &self.effects[item.effect];
            json!({ "what": effect.id(), "certainty": effect.certainty(), "probability": effect.confidence,
                    "share": share(item.nmse), "rms_N": rms(item.nmse) })
        });
        let [parameters, hysteresis] = self.before_the_baseline();
        let rest = [
            ("parameters", parameters),
            ("finer_hysteresis", hysteresis),
            ("refitted_hysteresis", self.refitted()),
            ("noise", self.noise_floor),
            ("unrepeated", self.unrepeated.unwrap_or(0.0)),
            ("not_explained", self.not_explained()),
        ];
        let rest = rest
            .map(|(what, nmse)| json!({ "what": what, "share": share(nmse), "rms_N": rms(nmse) }));
        json!({ "rms_N": rms(self.whole()), "items": items.chain(rest).collect::<Vec<_>>() })
    }

    /// Who leaves the mismatch.
    fn whose(&self) -> String {
        let whose = match (self.null.core.corrects, self.given_model.is_some()) {
            (true, _) => "Your simulation",
            (_, true) => "Your model",
            _ if self.fit.as_ref().is_some_and(|fit| fit.is_found()) => {
                "The fit with a finer hysteresis"
            }
            _ => return "The best plain model".to_owned(),
        };
        // The fit itself takes off what lies between the machine and the recorded effort.
        let taken_off = self.effects.iter().filter(|e| e.is_in_the_channel());
        let taken_off: Vec<&str> = taken_off.map(Named::name).collect();
        match (&self.fit, taken_off.as_slice()) {
            (Some(_), [_, ..]) => format!("{whose} without a {}", taken_off.join(" and a ")),
            _ => whose.to_owned(),
        }
    }

    /// The budget for a terminal of 100 columns: the sizes of each finding stand below it.
    pub fn budget_text(&self, recording: &Recording) -> String {
        let mut table = self.budget_table(recording);
        let sizes: Vec<String> = table.rows.iter_mut().filter_map(Vec::pop).collect();
        let text = table.to_text();
        let mut lines = text.lines();
        let mut all: Vec<String> = lines.next().map(str::to_owned).into_iter().collect();
        for (line, size) in lines.zip(sizes) {
            all.push(format!("  {line}"));
            all.extend((!size.is_empty()).then(|| format!("      {size}")));
        }
        all.push(String::new());
        all.join("\n")
    }

    /// The budget for a page.
    pub fn budget_table(&self, recording: &Recording) -> Table {
        let whole = self.whole();
        let force = |nmse: f64| quantity(self.null.rows.rms_of(nmse), recording.effort_unit());
        let row = |what: String, nmse: f64, sure: &str, size: String| {
            let share = (nmse / whole).clamp(0.0, 1.0);
            let bar = "█".repeat((BAR * share).round() as usize);
            vec![
                what,
                bar,
                force(nmse),
                format!("{:.0} %", 100.0 * share),
                sure.to_owned(),
                size,
            ]
        };
        let [parameters, hysteresis] = self.before_the_baseline();
        let mut rows = Vec::new();
        if parameters >= SEEN * whole {
            let what = "parameters refitted".to_owned();
            rows.push(row(what, parameters, "", self.wrong_parameters(recording)));
        }
        if hysteresis >= SEEN * whole {
            let what = match self.lacks_law(recording) {
                Some(_) => "friction that reverses with the speed",
                None => "finer hysteresis",
            };
            rows.push(row(what.to_owned(), hysteresis, "", String::new()));
        }
        rows.extend(self.budget.iter().map(|item| {
            let e = &self.effects[item.effect];
            let what = e.called(recording);
            row(what, item.nmse, e.certainty(), e.size(recording))
        }));
        if self.refitted() >= SEEN * whole {
            let what = "hysteresis fitted anew".to_owned();
            rows.push(row(what, self.refitted(), "", String::new()));
        }
        rows.push(row(
            "measurement noise".to_owned(),
            self.noise_floor,
            "",
            String::new(),
        ));
        if let Some(unrepeated) = self.unrepeated.filter(|u| *u >= SEEN * whole) {
            let what = "varies between repeats".to_owned();
            rows.push(row(what, unrepeated, "", String::new()));
        }
        let most = self.nameless().next().map(|u| {
            let place = u.place.map_or(String::new(), |p| {
                format!("most {}", place_words(&p, recording))
            });
            format!("follows {} {place}", u.axis.name(&self.null.rows.s))
        });
        rows.push(row(
            "not explained".to_owned(),
            self.not_explained(),
            "",
            most.unwrap_or_default(),
        ));
        Table {
            caption: format!(
                "{} leaves {} RMS on stretches held out. What explains it, RMS and share of the square:",
                self.whose(),
                force(whole)
            ),
            head: Vec::new(),
            rows,
        }
    }

    /// The parameters of the user's model that are wrong, given and refitted.
    fn wrong_parameters(&self, recording: &Recording) -> String {
        let wrong = self.wrong();
        let told = wrong
            .take(TOLD)
            .map(|p| p.change(recording.effort_unit(), p.found.value));
        told.collect::<Vec<_>>().join(", ")
    }

    /// What may be there besides, each with what it would take off; nothing where nothing may.
    pub fn possible_words(&self, recording: &Recording) -> Option<String> {
        let force = |nmse: f64| quantity(self.null.rows.rms_of(nmse), recording.effort_unit());
        let possible = self.suspected().filter(|e| !e.confident);
        let each: Vec<String> = possible
            .filter(|e| !matches!(e.name, Name::Correction(_)))
            .map(|e| {
                let worth = e.evidence.share.clamp(0.0, 1.0) * self.extended.test;
                format!(
                    "{} ({}, would take {})",
                    e.called(recording),
                    probability(e.confidence),
                    force(worth)
                )
            })
            .collect();
        (!each.is_empty()).then(|| format!("Possible: {}", each.join("; ")))
    }

    /// The fit that every command reports, and why what the diagnosis begins with is another figure.
    pub fn fit_words(&self, recording: &Recording) -> Option<String> {
        let fit = self.fit.as_ref()?;
        // The verdict says why there is none.
        if !fit.is_found() && self.doubt.is_some() {
            return None;
        }
        let words = fit.words(recording);
        Some(match fit.is_found() && self.given_model.is_none() {
            true => format!(
                "{words}; the diagnosis begins with {}: stretches in motion only, with as many blocks as they support",
                left(self.baseline.test)
            ),
            false => words,
        })
    }

    /// What the fit has, with its sizes.
    pub fn in_fit_words(&self, recording: &Recording) -> Option<String> {
        let each: Vec<String> = self
            .in_fit()
            .map(|e| format!("{} ({})", e.name(), e.size(recording)))
            .collect();
        let one_force = self.one_force_words(recording);
        (!each.is_empty()).then(|| format!("In the fit: {}{one_force}", each.join("; ")))
    }

    /// That a constant force in the fit may as well be friction that differs by direction, and how much of it, in a sentence without its full stop;
    /// nothing where the recording tells them apart.
    fn one_force_words(&self, recording: &Recording) -> String {
        let is_either = |e: &&Named| {
            let mut rivals = e.ambiguous.iter();
            e.id() == form::CONSTANT_FORCE.id
                && rivals.any(|rival| rival.id() == form::COULOMB_ASYMMETRY.id)
        };
        let force = self.in_fit().find(is_either);
        let Some((_, force)) = force.and_then(|e| e.parameters.first()) else {
            return String::new();
        };
        let level = self.null.baseline.level;
        format!(
            ". {ONE_FORCE}: the {} may be either or some of each (all of it as friction: {} ± {} by direction)",
            quantity(force.value.abs(), recording.effort_unit()),
            quantity(level, recording.effort_unit()),
            percent((force.value / level.max(1e-300)).abs()),
        )
    }
}
