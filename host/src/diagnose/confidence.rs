//! How sure a name is: one logistic of features of its evidence, calibrated on judged names of every source that there is.

use super::naming::TermReport;
use preslide_fit::evidence::{Evidence, NAMED};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Weights that `cargo xtask calibrate --bless` writes, with what they were fitted to.
const CALIBRATION: &str = include_str!("calibration.toml");
/// Standard deviations beyond which more say nothing more: on a machine that repeats, whatever is wrong with the model is sure.
const SATURATED: f64 = 4.5;
/// Standard deviations of a suspicion at the edge.
const EDGE: f64 = 3.0;
/// Standard deviations beyond which nothing is surer to be there, and those of chance after the search has picked it.
const SURE: f64 = 8.0;
const SURE_EDGE: f64 = 4.0;
/// The least share of the weighted mismatch, or of the effort, that counts as some.
const LEAST: f64 = 1e-4;

#[derive(Deserialize)]
pub(super) struct Calibration {
    /// By feature, and the constant; a test holds them against [`features`].
    pub(super) weights: BTreeMap<String, f64>,
    /// The same of what has no name, against [`features_of_presence`].
    pub(super) presence: BTreeMap<String, f64>,
    /// The same of suspicions, against [`features_of_a_hint`].
    pub(super) hints: BTreeMap<String, f64>,
    /// By effect, and `others`.
    widths: BTreeMap<String, f64>,
}

pub(super) static FITTED: LazyLock<Calibration> =
    LazyLock::new(|| toml::from_str(CALIBRATION).expect("the committed calibration is TOML"));

/// What separates a right name from a false one, by name; about zero for a name at the edge. Ten more were tried (standard deviations, agreement of blocks,
/// changes of the hysteresis, order and number of terms, class): with them names of a source that was left out are judged less well.
pub fn features(report: &TermReport) -> BTreeMap<&'static str, f64> {
    BTreeMap::from([
        ("size", in_nats(report.size_of_the_name())),
        (
            "at_its_largest",
            report.at_its_largest.clamp(0.0, 1.0) - 1.0,
        ),
        // Of a line or a narrow place.
        ("state", report.placebo.unwrap_or_default()),
        ("law", f64::from(u8::from(report.law))),
    ])
}

fn in_nats(size: f64) -> f64 {
    (size.max(LEAST) / NAMED).ln()
}

/// What separates something, whatever it is called, from chance; about zero at the edge.
pub fn features_of_presence(report: &TermReport) -> BTreeMap<&'static str, f64> {
    BTreeMap::from([
        ("size", in_nats(report.size())),
        ("sure", report.evidence.z.min(SURE) - SURE_EDGE),
    ])
}

/// Probability that the effect is there and so named.
pub fn confidence(report: &TermReport) -> f64 {
    weighed(&FITTED.weights, features(report))
}

/// Probability that something is there, whatever it is called.
pub fn presence(report: &TermReport) -> f64 {
    weighed(&FITTED.presence, features_of_presence(report))
}

fn weighed(weights: &BTreeMap<String, f64>, features: BTreeMap<&'static str, f64>) -> f64 {
    let weight = |key: &str| weights.get(key).copied().unwrap_or(0.0);
    let own = features.into_iter();
    logistic(weight("constant") + own.map(|(key, f)| f * weight(key)).sum::<f64>())
}

/// How many times as wide as its fit says an interval of an effect must be to hold the truth as often as it claims: the fit does not
/// know how wrong its form is.
pub fn width(effect: &str) -> f64 {
    let widths = &FITTED.widths;
    *widths.get(effect).or(widths.get("others")).unwrap_or(&1.0)
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// What separates a right suspicion of what did not enter from a false one; about zero at the edge, where the user's hysteresis is taken to be:
/// another statistic suspects it.
pub fn features_of_a_hint(evidence: Option<&Evidence>) -> BTreeMap<&'static str, f64> {
    BTreeMap::from([("evidence", evidence.map_or(0.0, log_odds))])
}

/// The same for a suspicion.
pub fn of_a_hint(evidence: Option<&Evidence>) -> f64 {
    weighed(&FITTED.hints, features_of_a_hint(evidence))
}

/// The same for a hysteresis of the user's that is wrong, from the held-out NMSE (%) with it and with the core.
pub fn of_hysteresis(own: f64, core: f64) -> f64 {
    let ratio = (own / core.max(1e-12)).max(1.0);
    (1.0 - 0.5 / ratio).clamp(0.5, 0.99)
}

/// The same from share and deviations alone; set by hand, not calibrated.
pub fn of_evidence(evidence: &Evidence) -> f64 {
    logistic(log_odds(evidence))
}

fn log_odds(evidence: &Evidence) -> f64 {
    let share = (evidence.share.max(LEAST) / NAMED).ln();
    share + 0.25 * (evidence.z.min(SATURATED) - EDGE)
}
