//! The page of `preslide demo`: what was recorded, how many blocks and why, what was missing, how much better it tracks.

use crate::chain::{Followed, Trial};
use preslide_fit::identify::Identification;
use preslide_fit::model::Model;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::quantity;
use preslide_fit::report::units::name_and_unit;
use preslide_fit::report::{Axis, Colour, Emphasis, Figure, Page, Section, Series, Table};
use preslide_host::cost::DEFAULT;
use preslide_host::diagnose::Diagnosis;
use preslide_host::diagnose::effect::by_id;
use preslide_host::tune::Choice;

/// Everything that the story is about.
pub struct Story<'a> {
    /// The stage and what it hides.
    pub trial: &'a Trial,
    /// Its recording.
    pub recording: &'a Recording,
    /// Rigid body and friction.
    pub found: &'a Identification,
    /// What the model left out.
    pub diagnosis: &'a Diagnosis,
    /// What was exported: its kernel with cycles and flash.
    pub exported: &'a Choice,
    /// The model that the diagnosis ends in, and the stage's own.
    pub models: [&'a Model; 2],
    /// The judged motion without a model, with the identified one, with what the diagnosis added, with that as it was exported, and with
    /// the truth.
    pub followed: [Followed; 5],
}

impl Story<'_> {
    fn names(&self) -> String {
        let names: Vec<String> = self
            .diagnosis
            .confident()
            .map(|e| {
                format!(
                    "{} ({}; confidence {:.2})",
                    e.called(self.recording),
                    e.name.words(),
                    e.confidence
                )
            })
            .collect();
        if names.is_empty() {
            "nothing that is certain".to_owned()
        } else {
            names.join(", ")
        }
    }

    /// What the five ways of compensating are called.
    fn ways(&self) -> [String; 5] {
        let size = self.found.best().size();
        [
            "no friction model".to_owned(),
            format!("identified: GMS, N = {size}"),
            "with what the diagnosis added".to_owned(),
            format!(
                "the same, exported as {} with {} blocks",
                self.exported.kernel.name(),
                self.exported.cost.blocks
            ),
            "with the stage's own parameters".to_owned(),
        ]
    }

    /// Tracking errors, for the terminal and the page.
    pub fn table(&self) -> Table {
        let error = |value: f64| quantity(value, "m");
        let row = |(way, followed): (String, &Followed)| {
            let rms = followed.error.rms_m().map_or("fault".to_owned(), error);
            vec![way, rms, error(followed.error.peak_m())]
        };
        Table {
            caption: "Tracking error of the true position, the same gains throughout".to_owned(),
            head: ["feed-forward", "RMS", "largest"]
                .map(String::from)
                .to_vec(),
            rows: self
                .ways()
                .into_iter()
                .zip(&self.followed)
                .map(row)
                .collect(),
        }
    }

    /// What was found beside what the stage has: moving mass, friction, and the numbers of what it hides.
    pub fn truth_table(&self) -> Table {
        let [found, truth] = self.models;
        let told = |key: &str, value: f64| {
            let (_, unit) = name_and_unit(key, "N");
            quantity(value, &unit)
        };
        let mut rows = vec![
            vec![
                "moving mass".to_owned(),
                told("mass_kg", found.inertia),
                told("mass_kg", truth.inertia),
            ],
            vec![
                "breakaway".to_owned(),
                told("breakaway_N", found.friction.breakaway().unwrap_or(0.0)),
                told("breakaway_N", truth.friction.breakaway().unwrap_or(0.0)),
            ],
        ];
        for hidden in &truth.effects {
            let own = found.effects.iter().find(|e| e.id() == hidden.id());
            let effect = by_id(hidden.id()).map_or(hidden.id(), |e| e.name());
            rows.extend(hidden.values.iter().map(|(key, value)| {
                let (name, _) = name_and_unit(key, "N");
                let own = own.map_or("not found".to_owned(), |e| told(key, e.get(key)));
                vec![format!("{effect}: {name}"), own, told(key, *value)]
            }));
        }
        Table {
            caption: "Found and true".to_owned(),
            head: ["", "found", "true"].map(String::from).to_vec(),
            rows,
        }
    }

    /// The result in a sentence or two.
    pub fn outcome(&self) -> String {
        let [none, identified, diagnosed, exported, known] = self.followed.each_ref().map(|f| {
            let rms = f.error.rms_m();
            rms.map_or("a fault".to_owned(), |rms| quantity(rms, "m"))
        });
        format!(
            "RMS tracking error: {none} without a friction model, {identified} with the identified one, {diagnosed} with what the diagnosis \
             added ({exported} as it is exported for the controller), {known} knowing the truth. The diagnosis names {}.",
            self.names(),
        )
    }

    /// The page.
    pub fn page(&self, command: String) -> Page {
        let recording = self.recording;
        let mut identified = self
            .found
            .page(recording, String::new())
            .sections
            .into_iter();
        let diagnosed = self.diagnosis.page(recording, String::new());
        // Parameters.
        let mut sections: Vec<Section> = identified.by_ref().take(1).collect();
        sections.push(self.recorded());
        sections.extend(identified.next().map(|section| Section {
            heading: "How many blocks, and why".to_owned(),
            paragraphs: [vec![self.found.recommendation.clone()], section.paragraphs].concat(),
            ..section
        }));
        // What is missing, what of the model is wrong, and where model and recording differ.
        sections.extend(diagnosed.sections.into_iter().take(3));
        sections.push(self.tracked());
        Page {
            title: "Preslide demo: recorded, identified, diagnosed, compensated".to_owned(),
            lead: self.outcome(),
            command,
            sections,
        }
    }

    fn recorded(&self) -> Section {
        let r = self.recording;
        let line = |title: &str, x: (&str, &str, &[f64]), y: (&str, &str, &[f64])| {
            Figure::new(title, Axis::new(x.0, x.1), Axis::new(y.0, y.1))
                .with(Series::line("measured", x.2.to_vec(), y.2.to_vec()).colour(Colour::Black))
        };
        Section {
            heading: "What was recorded".to_owned(),
            paragraphs: vec![format!(
                "The simulated stage (3 kg and a rotor of 1 kg on a 2 mm screw) follows nested strokes of 150 to 8 µm at three stations, slow slides \
                 and passes over 4 mm, for {:.0} s, under the firmware's control code without a friction model. Encoder count and \
                 motor current leave it as telemetry and become a recording. Its friction is a 64-element hysteresis that \
                 yields smoothly and wanders by up to ±15 %; besides, it hides something.",
                r.t_s.last().copied().unwrap_or(0.0)
            )],
            figures: vec![
                line(
                    "The motion",
                    ("time", "s", &r.t_s),
                    ("position", "m", &r.position),
                ),
                line(
                    "The force it took",
                    ("position", "m", &r.position),
                    ("motor force", "N", &r.effort),
                ),
            ],
            ..Section::default()
        }
    }

    fn tracked(&self) -> Section {
        let error = Figure::new(
            "Tracking error over the judged motion",
            Axis::new("time", "s"),
            Axis::new("reference − true position", "m"),
        );
        let looks = [
            (Colour::Sky, Emphasis::Normal),
            (Colour::Blue, Emphasis::Normal),
            (Colour::Vermillion, Emphasis::Strong),
        ];
        let lines = self.ways().into_iter().zip(&self.followed).zip(looks);
        let error = lines.fold(error, |figure, ((way, followed), (colour, emphasis))| {
            let line = Series::line(way, followed.t_s.clone(), followed.error_m.clone());
            figure.with(line.colour(colour).emphasis(emphasis))
        });
        let reference = self.followed.first().map(|followed| {
            Figure::new(
                "The judged motion",
                Axis::new("time", "s"),
                Axis::new("reference", "m"),
            )
            .with(
                Series::line(
                    "reference",
                    followed.t_s.clone(),
                    followed.reference_m.clone(),
                )
                .colour(Colour::Black),
            )
        });
        Section {
            heading: "How much better it tracks".to_owned(),
            paragraphs: vec![
                "Another motion than the recorded one: other places, speeds and reversals. The feedback is the same in every run; \
                 only the force fed forward differs."
                    .to_owned(),
                self.exported.said(DEFAULT),
                format!(
                    "What the stage hid from the diagnosis: {}.",
                    self.trial.effect.words()
                ),
            ],
            tables: vec![self.table(), self.truth_table()],
            figures: [error].into_iter().chain(reference).collect(),
        }
    }
}
