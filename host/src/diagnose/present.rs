//! A diagnosis for machines, and its table.

use super::account::parameter;
use super::candidate::Candidate;
use super::given::Refitted;
use super::named::Named;
use super::place::Place;
use super::second_position::SecondPosition;
use super::unnamed::Unknown;
use super::verdict::Diagnosis;
use preslide_fit::effects::form;
use preslide_fit::model::{key_of, keys_of};
use preslide_fit::recording::Recording;
use preslide_fit::report::Table;
use preslide_fit::report::figures::{capital, left, probability};
use serde_json::{Map, Value, json};

impl SecondPosition {
    /// For machines.
    pub fn to_json(&self, recording: &Recording) -> Value {
        let unit = recording.position_unit();
        let smooth = self.lead.iter().map(|lead| json!({
            "id": "lead_error", "slope": lead.slope, "bow_m": lead.bow, "lowest_at_m": lead.lowest_at, "highest_at_m": lead.highest_at,
            "share_of_difference": lead.share, "standard_errors": lead.z, "curve_m": lead.curve,
        }));
        let periodic = self.periodic.iter().map(|p| json!({
            "id": "periodic_lead_error", "period_m": p.period, "amplitude_m": p.amplitude, "highest_at_m": p.highest_at,
            "share_of_difference": p.passes.share, "standard_errors": p.passes.z,
            "share_on_stretches": p.stretches.share, "standard_errors_on_stretches": p.stretches.z,
            "folded_m": p.folded, "ambiguous_with": [form::ENCODER_ERROR.id],
        }));
        json!({
            "column": self.column, "unit": unit, "ratio": self.ratio, "passes": self.passes, "rms_left_m": self.left,
            "lost_motion_m": self.lost_motion, "compliance_m_per_N": self.compliance,
            "effects": smooth.chain(periodic).collect::<Vec<_>>(),
        })
    }
}

impl Diagnosis {
    /// `preslide.diagnosis/1`.
    pub fn to_json(&self, recording: &Recording, seconds: f64) -> Value {
        let answer = json!({
            "schema": "preslide.diagnosis/1",
            "recording": recording.name,
            "effort_unit": recording.effort_unit(),
            "verdict": self.verdict.name(),
            "fit": self.fit.as_ref().map(|fit| fit.to_json(recording)),
            "baseline": { "nmse_train": self.baseline.train, "nmse_test": self.baseline.test },
            "extended": { "nmse_train": self.extended.train, "nmse_test": self.extended.test },
            "noise_floor_nmse": self.noise_floor,
            "unrepeated_nmse": self.unrepeated,
            "given_model": self.given_model.as_ref().map(|g| json!({
                "nmse_as_it_stands": g.stands, "nmse_refitted": g.refitted.test,
                "parameters": g.parameters.iter().map(|p| json!({
                    "key": p.key, "given": p.given, "refitted": p.found, "differs": p.differs, "worth_nmse": p.worth,
                })).collect::<Vec<_>>(),
            })),
            "budget": self.budget_json(),
            "effects": self.effects.iter().enumerate().map(|(i, e)| self.effect_json(i, e, recording)).collect::<Vec<_>>(),
            "unknown": self.unknown().map(|u| self.unknown_json(u, recording)),
            "unnamed": self.unnamed.iter().map(|u| self.unknown_json(u, recording)).collect::<Vec<_>>(),
            "organised_by": self.organised.iter().take(6).map(|o| self.candidate_json(o)).collect::<Vec<_>>(),
            "not_named": self.rest.iter().take(8).map(|o| self.candidate_json(o)).collect::<Vec<_>>(),
            "noise": { "friction_variability": self.null.noise.variability(), "disturbance_N": self.null.noise.disturbance() },
            "excitation": self.lacks.iter().map(|l| json!({"missing": l.missing, "hides": l.hides.iter().map(|e| e.id()).collect::<Vec<_>>()})).collect::<Vec<_>>(),
            "blocks": self.null.rows.blocks.len(),
            "friction_reverses_over_m_s": self.smooth_law().map(|law| law.speed),
            "correction": self.correction.as_ref().map(|c| c.to_json(recording)),
            "simulated_late_s": self.simulated_late,
            "reproduced_nmse": self.reproduced.as_ref().map(|r| r.nmse),
            "second_positions": self.second_positions.iter().map(|p| p.to_json(recording)).collect::<Vec<_>>(),
            "left_out": self.null.rows.s.left_out.iter().map(|(name, kind)| json!({"column": name, "why": kind.words()})).collect::<Vec<_>>(),
            "seconds": seconds,
        });
        keys_of(recording.kind, answer)
    }

    fn place_json(&self, place: &Place, recording: &Recording) -> Value {
        json!({
            "axis": place.axis.name(&self.null.rows.s), "from": place.from, "to": place.to,
            "unit": place.axis.unit(recording.position_unit()), "share_of_mismatch": place.share,
        })
    }

    fn effect_json(&self, index: usize, e: &Named, recording: &Recording) -> Value {
        let parameters: Map<String, Value> = e
            .parameters
            .iter()
            .map(|(name, estimate)| (name.clone(), json!(estimate)))
            .collect();
        let place: Vec<Value> = e
            .places
            .iter()
            .map(|p| self.place_json(p, recording))
            .collect();
        let rivals: Vec<Value> = e
            .report
            .iter()
            .flat_map(|s| &s.tried)
            .map(|(key, ratio)| json!({"id": key, "of_its_own": ratio}))
            .collect();
        json!({
            "id": e.id(), "name": e.name(), "rank": index + 1, "level": e.level(), "in_fit": e.in_fit, "in_simulation": e.in_simulation, "confidence": e.confidence,
            "share_of_mismatch": e.evidence.share, "standard_errors": e.evidence.z, "blocks": e.evidence.blocks,
            "nmse_test_without": finite(e.nmse_test[0]), "nmse_test_with": finite(e.nmse_test[1]),
            "where": place, "parameters": parameters, "source": e.source,
            "ambiguous_with": e.ambiguous.iter().map(|a| a.id()).collect::<Vec<_>>(),
            "would_tell_apart": e.name.experiment(), "rivals": rivals, "features": e.features(),
        })
    }

    fn unknown_json(&self, u: &Unknown, recording: &Recording) -> Value {
        let unit = u.axis.unit(recording.position_unit());
        json!({
            "axis": u.axis.name(&self.null.rows.s),
            "symmetry": if u.odd { "odd" } else { "even" },
            "rises_by": u.rises_by, "core": u.change.map(|c| c.name()), "like": u.like.map(|e| e.id()), "confidence": u.confidence,
            "from": u.place.map(|p| p.from), "to": u.place.map(|p| p.to), "share": u.place.map(|p| p.share),
            "unit": unit, "rms_N": u.rms, "share_of_mismatch": u.evidence.share, "standard_errors": u.evidence.z,
            "segments": u.evidence.blocks.round(), "segments_of": self.null.rows.blocks.len(),
            "wanders": u.wanders, "features": u.features, "stretches_s": u.happened.as_ref().map_or(&[][..], |h| &h.times),
        })
    }

    fn candidate_json(&self, candidate: &Candidate) -> Value {
        json!({
            "id": candidate.term.subject.name(&self.null.rows.s), "share_of_mismatch": candidate.evidence.share,
            "standard_errors": candidate.evidence.z, "chance": candidate.chance(self.families),
        })
    }

    /// The parameters of the user's model, given and refitted, for the terminal and the page.
    pub fn given_table(&self, recording: &Recording) -> Option<Table> {
        let given = self
            .given_model
            .as_ref()
            .filter(|g| !g.parameters.is_empty())?;
        let row = |p: &Refitted| {
            let differs = if p.differs { "differs" } else { "" };
            let mut cells =
                Vec::from(p.words(recording.effort_unit(), self.written_of(p, recording)));
            cells.extend([left(p.worth), differs.to_owned()]);
            cells
        };
        Some(Table {
            caption: format!(
                "Parameters of the model, given, refitted {}, and as -o writes them; worth: what the difference alone leaves of the variance",
                match given.law {
                    Some(_) => "beside friction that reverses with the speed",
                    None => "on its own law",
                }
            ),
            head: ["parameter", "given", "refitted", "-o", "worth", ""]
                .map(String::from)
                .to_vec(),
            rows: given.parameters.iter().map(row).collect(),
        })
    }

    /// Effects, for the terminal and the page.
    pub fn table(&self, recording: &Recording) -> Table {
        let row = |e: &Named| {
            let parameters = e.parameters.iter().map(|(key, p)| {
                parameter(&key_of(recording.kind, key), p, recording.effort_unit())
            });
            let parameters: Vec<String> = parameters.collect();
            let nmse = |v: f64| finite(v).map_or("–".to_owned(), left);
            vec![
                capital(&e.called(recording)),
                match e.confident && e.in_fit {
                    true => "in the fit".to_owned(),
                    false => e.level().to_owned(),
                },
                probability(e.confidence),
                format!("{:.1}", 100.0 * e.evidence.share),
                format!("{:.1}", e.evidence.z),
                nmse(e.nmse_test[0]),
                nmse(e.nmse_test[1]),
                parameters.join(", "),
                e.ambiguous
                    .iter()
                    .map(|a| a.name())
                    .collect::<Vec<_>>()
                    .join(", "),
            ]
        };
        Table {
            caption: format!(
                "Physics that the {}; share: of the mismatch on stretches held out; z: standard errors between stretches",
                match self.effects.iter().any(|e| e.in_fit) {
                    true => "recording shows, in the fit or missing from it",
                    false => "model leaves out",
                }
            ),
            head: [
                "effect",
                "level",
                "confidence",
                "share %",
                "z",
                "NMSE without",
                "with",
                "parameters",
                "as likely",
            ]
            .map(String::from)
            .to_vec(),
            rows: self.effects.iter().map(row).collect(),
        }
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
