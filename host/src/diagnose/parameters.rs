//! Values of an effect's parameters, with what the recording leaves open.

use super::confidence;
use super::effect::Fitted;
use super::null_model::{Hypothesis, NullModel};
use super::polish::slopes;
use super::term::Term;
use preslide_fit::statistics::{Estimate, jackknife};

/// Parameters of term `index` with 95 % intervals, all other coefficients and shapes free. The interval is the widest that
/// blocks of the recording, its folds, or its kinds of strokes give: where a form is wrong, other motions give other values,
/// which repeats of the same motion do not show.
pub fn parameters(
    null: &NullModel,
    hypothesis: &Hypothesis,
    index: usize,
) -> Vec<(String, Estimate)> {
    let Some(effect) = hypothesis.terms[index].effect() else {
        return Vec::new();
    };
    let term = &hypothesis.terms[index];
    let slopes = slopes(null, hypothesis, 0);
    let columns: Vec<Vec<f64>> = slopes.iter().map(|s| s.force.clone()).collect();
    let fit = null.fit_beside(&hypothesis.terms, &columns);
    let mut block_of = vec![0; null.rows.force.len()];
    for (b, rows) in null.rows.blocks.iter().enumerate() {
        block_of[rows.clone()].fill(b);
    }
    let errors: Option<Vec<Option<f64>>> = fit.as_ref().map(|fit| {
        let (by_block, by_kind) = (fit.errors(&block_of), fit.errors(&null.rows.kinds));
        let folds = null.rows.weak.folds.len();
        let held: Vec<Vec<f64>> = (0..folds).map(|s| fit.without_fold(s)).collect();
        let by_fold = |j: usize| jackknife(&held.iter().map(|c| c[j]).collect::<Vec<_>>());
        by_block
            .iter()
            .zip(&by_kind)
            .enumerate()
            .map(|(j, (a, b))| Some((*a)?.max((*b)?).max(by_fold(j))))
            .collect()
    });
    let error = |j: usize| errors.as_ref().and_then(|e| e[j]);
    let place = hypothesis.places[index].clone();
    let first_slope = fit
        .as_ref()
        .map_or(0, |f| f.coefficients.len() - slopes.len());
    let shape_errors: Vec<Option<f64>> = (0..term.shape.len())
        .map(|k| {
            let at = slopes
                .iter()
                .position(|s| s.term == index && s.parameter == k)?;
            error(first_slope + at)
        })
        .collect();
    let at_shape = |shape: &[f64]| {
        let mut terms = hypothesis.terms.clone();
        terms[index] = Term::new(term.subject, shape);
        Some(null.fit(&terms)?.coefficients(index)[0])
    };
    let errors = place.map(error).collect::<Vec<_>>();
    let values = |coefficients: &[f64]| {
        effect.values(&Fitted {
            shape: &term.shape,
            coefficients,
            shape_errors: &shape_errors,
            errors: &errors,
            folds: null.rows.weak.folds.len(),
            at_shape: &at_shape,
            scene: null.scene(),
        })
    };
    let mut own = values(hypothesis.coefficients(index));
    if let Some(alike) = null.fit_unweighted(&hypothesis.terms) {
        hold(&mut own, values(alike.coefficients(index)));
    }
    for (_, estimate) in &mut own {
        widen(estimate, confidence::width(effect.id()));
    }
    own
}

/// Widens an interval `times`, by a factor where it is of one sign: it stays so.
fn widen(estimate: &mut Estimate, times: f64) {
    let value = estimate.value;
    for bound in estimate.ci95.iter_mut().flatten() {
        *bound = if *bound * value > 0.0 {
            value * (*bound / value).powf(times)
        } else {
            value + times * (*bound - value)
        };
    }
}

/// Widens intervals to what a fit says that weights all rows alike: the noise model is not known better than that.
fn hold(own: &mut [(String, Estimate)], alike: Vec<(String, Estimate)>) {
    for ((_, own), (_, alike)) in own.iter_mut().zip(alike) {
        if let Some([low, high]) = &mut own.ci95 {
            (*low, *high) = (low.min(alike.value), high.max(alike.value));
        }
    }
}
