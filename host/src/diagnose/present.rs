//! A diagnosis for people and for machines.

use super::conclude::{Diagnosis, Effect};
use super::signature::Axis;
use super::study::Study;
use super::{catalogue, conclude::Unknown};
use crate::model::key_of;
use crate::recording::Recording;
use crate::report::{self, Colour, Emphasis, Figure, Page, Section, Series, Style, Table};
use serde_json::{Value, json};

/// Points of a figure's cloud.
const POINTS: usize = 6000;

fn digits(value: f64) -> String {
    if value == 0.0 || (value.abs() >= 0.01 && value.abs() < 1e4) {
        format!("{value:.4}")
    } else {
        format!("{value:.3e}")
    }
}

impl Effect {
    fn level(&self) -> &'static str {
        if self.confident {
            "confident"
        } else {
            "suspected"
        }
    }

    fn experiment(&self) -> &'static str {
        catalogue::entry(self.id).map_or("", |e| e.experiment)
    }
}

impl Unknown {
    fn words(&self, position: &str, force: &str) -> String {
        let place = self.place.map_or(String::new(), |(from, to, share)| {
            format!(
                ", {:.0} % of it between {} and {} {}",
                100.0 * share,
                digits(from),
                digits(to),
                self.signature.axis.unit(position)
            )
        });
        format!(
            "what is left follows {}, {}{place}; {} {force} RMS in all; it helps in {} of {} folds",
            self.signature.axis.name(),
            match (self.signature.axis, self.signature.odd) {
                (Axis::Bursts, _) => "which nothing in the motion tells",
                (_, true) => "flips with direction",
                (_, false) => "the same in both directions",
            },
            digits(self.rms),
            self.folds.0,
            self.folds.1
        )
    }
}

impl Diagnosis {
    /// `preslide.diagnosis/1`.
    pub fn to_json(&self, recording: &Recording, seconds: f64) -> Value {
        let unit = recording.position_unit();
        let effects: Vec<Value> = self
            .effects
            .iter()
            .enumerate()
            .map(|(i, e)| {
                let parameters: serde_json::Map<String, Value> = e
                    .parameters
                    .iter()
                    .map(|(name, estimate)| (key_of(recording.kind, name), json!(estimate)))
                    .collect();
                let place: Vec<Value> = e
                    .places
                    .iter()
                    .map(|p| json!({
                        "axis": p.axis.name(), "from": p.from, "to": p.to, "unit": p.axis.unit(unit), "share_of_mismatch": p.share,
                    }))
                    .collect();
                json!({
                    "id": e.id, "rank": i + 1, "level": e.level(), "confidence": e.confidence, "nats": e.nats,
                    "threshold_nats": e.threshold, "standard_errors": e.certainty, "nats_by_fold": e.by_fold,
                    "nmse_test_without": e.nmse_test[0], "nmse_test_with": e.nmse_test[1],
                    "where": place, "parameters": parameters, "source": e.source,
                    "ambiguous_with": e.ambiguous_with, "would_tell_apart": e.experiment(),
                    "rivals": e.rivals.iter().take(6).map(|(id, nats)| json!({"id": id, "nats": nats})).collect::<Vec<_>>(),
                })
            })
            .collect();
        json!({
            "schema": "preslide.diagnosis/1",
            "recording": recording.name,
            "verdict": self.verdict,
            "baseline": { "nmse_train": self.baseline.train, "nmse_test": self.baseline.test },
            "extended": { "nmse_train": self.extended.train, "nmse_test": self.extended.test },
            "noise_floor_nmse": self.noise_floor,
            "effects": effects,
            "unknown": self.unknown.as_ref().map(|u| json!({
                "axis": u.signature.axis.name(),
                "symmetry": if u.signature.odd { "odd" } else { "even" },
                "from": u.place.map(|p| p.0), "to": u.place.map(|p| p.1), "share": u.place.map(|p| p.2),
                "unit": u.signature.axis.unit(unit),
                "rms": u.rms, "nats": u.signature.gain.total(),
                "segments": u.folds.0, "segments_of": u.folds.1,
            })),
            "organised_by": self.organised.iter().take(6).map(|s| json!({
                "axis": s.axis.name(), "symmetry": if s.odd { "odd" } else { "even" }, "nats": s.gain.total(),
                "threshold_nats": s.threshold,
            })).collect::<Vec<_>>(),
            "not_named": self.rest.iter().take(8).map(|c| json!({
                "id": c.term.id, "nats": c.gain.total(), "threshold_nats": c.threshold,
            })).collect::<Vec<_>>(),
            "noise": { "friction_variability": self.states[1].noise.variability(), "disturbance": self.states[1].noise.disturbance() },
            "excitation": self.lacks.iter().map(|l| json!({"missing": l.missing, "hides": l.hides})).collect::<Vec<_>>(),
            "seconds": seconds,
        })
    }

    /// Effects, for the terminal and the page.
    pub fn table(&self, recording: &Recording) -> Table {
        Table {
            caption:
                "Physics that the model leaves out; nats: log-likelihood gained on folds held out"
                    .to_owned(),
            head: [
                "effect",
                "level",
                "confidence",
                "nats",
                "needed",
                "NMSE % without",
                "with",
                "parameters",
                "as likely",
            ]
            .map(String::from)
            .to_vec(),
            rows: self
                .effects
                .iter()
                .map(|e| {
                    let parameters: Vec<String> = e
                        .parameters
                        .iter()
                        .map(|(name, p)| {
                            let reach = p.ci95.map_or(String::new(), |[a, b]| {
                                format!(" ± {}", digits(0.5 * (b - a)))
                            });
                            format!(
                                "{} {}{reach}",
                                key_of(recording.kind, name),
                                digits(p.value)
                            )
                        })
                        .collect();
                    vec![
                        e.id.to_owned(),
                        e.level().to_owned(),
                        format!("{:.2}", e.confidence),
                        format!("{:.0}", e.nats),
                        format!("{:.0}", e.threshold),
                        format!("{:.3}", e.nmse_test[0]),
                        format!("{:.3}", e.nmse_test[1]),
                        parameters.join(", "),
                        e.ambiguous_with.join(", "),
                    ]
                })
                .collect(),
        }
    }

    /// Verdict in one sentence.
    pub fn verdict_words(&self, recording: &Recording) -> String {
        let (x, f) = (recording.position_unit(), recording.effort_unit());
        let figures = format!(
            "held-out NMSE {:.3} % before, {:.3} % after, {:.3} % expected of noise and of friction's own variability",
            self.baseline.test, self.extended.test, self.noise_floor
        );
        let mut text = match self.verdict {
            "consistent" => format!("consistent: nothing significant is missing ({figures})"),
            "missing-physics" => {
                let names: Vec<&str> = self
                    .effects
                    .iter()
                    .filter(|e| e.confident)
                    .map(|e| e.id)
                    .collect();
                format!("missing-physics: {} ({figures})", names.join(", "))
            }
            other => format!("{other} ({figures})"),
        };
        if let Some(unknown) = &self.unknown {
            text += &format!("; besides, in no catalogue: {}", unknown.words(x, f));
        }
        text
    }

    /// One thing to do.
    pub fn recommendation(&self) -> String {
        let Some(first) = self.effects.first() else {
            return match &self.unknown {
                Some(_) => "Recommendation: look at the residual maps of the report; something acts that no catalogue entry describes.".to_owned(),
                None => "Recommendation: keep the model; what is left is noise and friction's own variability.".to_owned(),
            };
        };
        let words = catalogue::entry(first.id).map_or("", |e| e.words);
        match (first.confident, first.ambiguous_with.first()) {
            (true, None) => format!("Recommendation: add {} to the model ({words}).", first.id),
            (true, Some(rival)) => format!(
                "Recommendation: {} or {rival}, this recording cannot tell. To tell them apart: {}.",
                first.id,
                first.experiment()
            ),
            (false, _) => format!(
                "Recommendation: {} is only suspected ({words}). To be sure: {}.",
                first.id,
                first.experiment()
            ),
        }
    }

    /// The report page.
    pub fn page(&self, study: &Study, recording: &Recording, command: String) -> Page {
        let (x, f) = (
            recording.position_unit(),
            if recording.effort_unit() == "Nm" {
                "N·m"
            } else {
                "N"
            },
        );
        let [before, after] = &self.states;
        let residuals = [before, after].map(|s| study.residual(s));
        let step = study.force.len().div_ceil(POINTS).max(1);
        let thin = |v: &[f64]| v.iter().copied().step_by(step).collect::<Vec<_>>();
        let position = study.weak.at_centres(&study.s.x);
        let modelled = |i: usize| -> Vec<f64> {
            study
                .force
                .iter()
                .zip(&residuals[i])
                .map(|(f, r)| f - r)
                .collect()
        };
        let shown = study.weak.folds.last().cloned().unwrap_or(0..0);
        let loops = Figure::new(
            "Force–displacement loops of the last fold",
            report::Axis::new("position", x),
            report::Axis::new("effort, averaged by the kernel", f),
        )
        .with(
            Series::line(
                "measured",
                position[shown.clone()].to_vec(),
                study.force[shown.clone()].to_vec(),
            )
            .colour(Colour::Black),
        )
        .with(
            Series::line(
                "model",
                position[shown.clone()].to_vec(),
                modelled(0)[shown.clone()].to_vec(),
            )
            .style(Style::Dashed)
            .colour(Colour::Sky),
        )
        .with(
            Series::line(
                "extended model",
                position[shown.clone()].to_vec(),
                modelled(1)[shown].to_vec(),
            )
            .emphasis(Emphasis::Strong)
            .colour(Colour::Vermillion),
        );
        let maps = Axis::ALL
            .iter()
            .filter_map(|axis| {
                let values = study.weak.at_centres(&axis.values(&study.s)?);
                Some(
                    Figure::new(
                        format!("Mismatch against {}", axis.name()),
                        report::Axis::new(axis.name(), axis.unit(x)),
                        report::Axis::new("measured − model", f),
                    )
                    .with(
                        Series::points("before", thin(&values), thin(&residuals[0]))
                            .colour(Colour::Sky)
                            .emphasis(Emphasis::Faint),
                    )
                    .with(
                        Series::points("after", thin(&values), thin(&residuals[1]))
                            .colour(Colour::Vermillion),
                    ),
                )
            })
            .collect();
        let evidence: Vec<String> = self
            .effects
            .iter()
            .map(|e| {
                if e.by_fold.is_empty() {
                    return format!(
                        "{}: {}. The model's blocks, refitted by a common factor, leave {:.3} % on folds held out, a fine core of {} blocks {:.3} %.",
                        e.id,
                        catalogue::entry(e.id).map_or("", |c| c.words),
                        e.nmse_test[0],
                        study.yields.len(),
                        e.nmse_test[1]
                    );
                }
                let rivals: Vec<String> =
                    e.rivals.iter().take(4).map(|(id, nats)| format!("{id} {nats:.0}")).collect();
                format!(
                    "{} ({}): {}. On folds that the fit did not see it gains {:.0} nats, where noise alone reaches {:.0}, and helps in {} of {} folds. Held-out NMSE {:.3} % without, {:.3} % with it. In its place the next best gain: {}. To tell them apart: {}.",
                    e.id,
                    e.level(),
                    catalogue::entry(e.id).map_or("", |c| c.words),
                    e.nats,
                    e.threshold,
                    e.by_fold.iter().filter(|g| **g > 0.0).count(),
                    e.by_fold.len(),
                    e.nmse_test[0],
                    e.nmse_test[1],
                    if rivals.is_empty() { "none".to_owned() } else { rivals.join(", ") },
                    e.experiment()
                )
            })
            .collect();
        Page {
            title: format!("Diagnosis of {}", recording.name),
            lead: format!("{}. {}", self.verdict_words(recording), self.recommendation()),
            command,
            sections: vec![
                Section {
                    heading: "What is missing".to_owned(),
                    paragraphs: [
                        vec![format!(
                            "NMSE (eq. 13) is the squared error over the variance of the whole measured effort after averaging with a kernel of ±{:.1} ms; test figures come from {} {}s held out in turn.",
                            1e3 * study.weak.half_width_s, study.weak.folds.len(), study.s.unit
                        )],
                        evidence,
                    ]
                    .concat(),
                    tables: vec![self.table(recording)],
                    figures: vec![loops],
                },
                Section {
                    heading: "Where model and recording differ".to_owned(),
                    paragraphs: vec!["Structure in these plots is physics that the model lacks.".to_owned()],
                    tables: vec![Table {
                        caption: "A free curve over one coordinate: what it predicts of the mismatch in folds held out".to_owned(),
                        head: ["coordinate", "in direction", "nats", "needed"].map(String::from).to_vec(),
                        rows: self.organised.iter().map(|s| vec![
                            s.axis.name().to_owned(),
                            if s.odd { "flips" } else { "same" }.to_owned(),
                            format!("{:.0}", s.gain.total()),
                            format!("{:.0}", s.threshold),
                        ]).collect(),
                    }],
                    figures: maps,
                },
                Section {
                    heading: "What this recording cannot show".to_owned(),
                    paragraphs: self.lacks.iter().map(|l| format!("{}: hides {}.", l.missing, l.hides.join(", "))).collect(),
                    ..Section::default()
                },
            ],
        }
    }
}
