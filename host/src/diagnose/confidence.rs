//! How sure a name is: one logistic of four features of its evidence.

use super::evidence::Evidence;
use super::naming::Standing;

/// Features: logarithm of the share of the mismatch, standard deviations (saturating), margin over the best rival that makes it
/// needless, survival of changes of the core.
pub const FEATURES: [&str; 4] = ["share", "z", "margin", "survival"];

/// The constant and the weights of the [`FEATURES`]. Set by hand, before any figure that is reported was measured; they are not
/// calibrated yet, and `cargo xtask sources` prints how far off they are.
const WEIGHTS: [f64; 5] = [1.5, 0.8, 0.25, 1.0, 1.5];

/// Factor of the probability of a name whose size changes over a foreign coordinate.
const MALFORMED: f64 = 0.4;
/// Standard deviations beyond which more say nothing more.
const SATURATED: f64 = 10.0;

/// The features of a name.
pub fn features(standing: &Standing) -> [f64; 4] {
    // A curve without a name that does as well as its own effect says nothing against it; one that does better does.
    let rival = standing.rival.max(standing.nameless - 0.2).clamp(0.0, 1.5);
    [
        (standing.evidence.share.max(1e-4) / 0.03).ln(),
        standing.evidence.z.min(SATURATED) - 3.0,
        1.0 - rival,
        standing.survival.clamp(0.0, 1.0) - 0.5,
    ]
}

/// Probability that the effect is there and so named.
pub fn confidence(standing: &Standing) -> f64 {
    let sum: f64 = features(standing)
        .iter()
        .zip(&WEIGHTS[1..])
        .map(|(f, w)| f * w)
        .sum();
    let probability = 1.0 / (1.0 + (-(WEIGHTS[0] + sum)).exp());
    // What changes its size where the catalogue's effect does not is something else.
    if standing.form.is_some() {
        MALFORMED * probability
    } else {
        probability
    }
}

/// The same for the user's hysteresis, from the held-out NMSE (%) with it and with the core.
pub fn of_hysteresis(own: f64, core: f64, wrong: bool) -> f64 {
    let ratio = (own / core.max(1e-12)).max(1.0);
    let sure = (1.0 - 0.5 / ratio).clamp(0.5, 0.99);
    if wrong { sure } else { 0.5 * sure }
}

/// The same for a candidate that did not enter: half of what its evidence alone would give.
pub fn of_a_hint(evidence: &Evidence) -> f64 {
    0.5 * of_evidence(evidence)
}

/// The same from share and deviations alone.
pub fn of_evidence(evidence: &Evidence) -> f64 {
    let share = (evidence.share.max(1e-4) / 0.03).ln();
    let sum = WEIGHTS[0] + WEIGHTS[1] * share + WEIGHTS[2] * (evidence.z.min(SATURATED) - 3.0);
    1.0 / (1.0 + (-sum).exp())
}
