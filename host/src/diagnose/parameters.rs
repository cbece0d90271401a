//! Values of an effect's parameters, with what the recording leaves open.

use super::columns::{self, ASIDE, Scale, amplitude_key, mean};
use super::score::{Bound, Problem};
use super::shape::slopes;
use super::signals;
use super::study::{State, Study, Term};
use crate::identify::estimate::Estimate;

/// Coefficients and shape parameters of a term with 95 % intervals, all other coefficients free.
pub fn parameters(study: &Study, state: &State, index: usize) -> Vec<(String, Estimate)> {
    let term = &state.terms[index];
    let keys = columns::parameters(term.id);
    // A measured temperature needs no time constant: fewer shape parameters than keys.
    let keys = &keys[..keys.len().min(term.shape.len())];
    let place = state.places[index].clone();
    let c: Vec<f64> = place.clone().map(|j| state.fit.coefficients[j]).collect();
    // The shape enters through the derivative of the columns, linearised at the estimate.
    let mut rows = state.rows.clone();
    let mut bounds = state.bounds.clone();
    let slopes: Vec<Option<usize>> = slopes(study, state, index)
        .into_iter()
        .map(|slope| {
            rows.push(slope?);
            bounds.push(Bound::Free);
            Some(rows.len() - 1)
        })
        .collect();
    let problem = Problem::new(&state.noise, &rows, bounds, &study.force, 1);
    let fit = problem.fit();
    let of_form = fit
        .as_ref()
        .and_then(|f| problem.error_of_form(f, &study.kinds));
    let deviation = |j: usize| {
        let fit = fit.as_ref()?;
        let at = fit.active.iter().position(|a| *a == j)?;
        // The fit's own error, or what leaving out a fold or a kind of strokes at a time tells, whichever is largest.
        let left_out: Vec<f64> = fit.held_out.iter().map(|c| c[j]).collect();
        let centre = mean(&left_out);
        let n = left_out.len() as f64;
        let spread: f64 = left_out.iter().map(|c| (c - centre).powi(2)).sum();
        let jackknife = (spread * (n - 1.0) / n).sqrt();
        let own = fit.covariance[(at, at)].max(0.0).sqrt().max(jackknife);
        Some(of_form.as_ref().map_or(own, |form| form[j].max(own)))
    };
    let folds = study.weak.folds.len();
    let estimate = |value: f64, error: Option<f64>| Estimate::new(value, error, folds);
    let mut list = Vec::new();
    let first = place.start;
    // A value under the assumed parameter, and an interval that holds those under all that it may be.
    let over_assumed = |of: &dyn Fn(f64, f64, Option<f64>) -> Estimate| {
        let error = deviation(first);
        let mut own = of(term.shape[0], c[0], error);
        for share in columns::assumed(term.id).into_iter().flatten() {
            let other = Term::new(term.id, &[share]);
            let gain = study
                .without(state, index)
                .and_then(|w| study.gain(&w, &other));
            let coefficient = gain.and_then(|g| g.coefficients.first().copied());
            if let (Some([low, high]), Some(c)) = (&mut own.ci95, coefficient)
                && let Some(ends) = of(share, c, error).ci95
            {
                (*low, *high) = (low.min(ends[0]), high.max(ends[1]));
            }
        }
        own
    };
    match (term.id, c.as_slice()) {
        (
            "periodic_force" | "periodic_friction" | "encoder_error" | "external_vibration",
            [a, b],
        ) => {
            let amplitude = a.hypot(*b);
            let error = deviation(first).zip(deviation(first + 1)).map(|(ea, eb)| {
                ((a * ea).powi(2) + (b * eb).powi(2)).sqrt() / amplitude.max(1e-300)
            });
            list.push((
                amplitude_key(term.id, &study.s).to_owned(),
                estimate(amplitude, error),
            ));
            let phase = (-b).atan2(*a);
            let reach = error.map(|e| e / amplitude.max(1e-300));
            list.push(("phase_rad".to_owned(), estimate(phase, reach)));
        }
        ("position_spring", [stiffness, _]) => list.push((
            "stiffness_N_per_m".to_owned(),
            estimate(*stiffness, deviation(first)),
        )),
        ("position_force" | "position_friction", c) => {
            let terms = term.shape.first().map_or(c.len(), |n| *n as usize);
            if let Some(constant) = c.get(terms) {
                list.push((
                    "constant_N".to_owned(),
                    estimate(*constant, deviation(first + terms)),
                ));
            }
            let c = c.get(..terms).unwrap_or(c);
            let unit = if term.id == "position_force" {
                "_N"
            } else {
                ""
            };
            for (j, value) in c.iter().enumerate() {
                list.push((
                    format!("cosine{}{unit}", j + 1),
                    estimate(*value, deviation(first + j)),
                ));
            }
        }
        ("drive_compliance", [_]) => {
            let stiffness = |c: f64| 1.0 / c.abs().max(1e-300);
            list.push((
                "stiffness_N_per_m".to_owned(),
                over_assumed(&|_, c, e| {
                    estimate(stiffness(c), e.map(|e| e * stiffness(c).powi(2)))
                }),
            ));
            list.push((
                "frequency_Hz".to_owned(),
                over_assumed(&|share, c, e| {
                    // Two masses on a spring: ω² = k/(m·μ·(1 − μ)).
                    let reduced = study.reference.mass * share * (1.0 - share);
                    let frequency = (stiffness(c) / reduced).sqrt() / std::f64::consts::TAU;
                    estimate(frequency, e.map(|e| 0.5 * e * stiffness(c) * frequency))
                }),
            ));
        }
        ("creep", [_]) => list.push((
            amplitude_key(term.id, &study.s).to_owned(),
            over_assumed(&|_, c, e| estimate(c, e)),
        )),
        (id, [c]) => list.push((
            amplitude_key(id, &study.s).to_owned(),
            estimate(*c, deviation(first)),
        )),
        _ => {}
    }
    for (k, key) in keys.iter().enumerate() {
        let error = slopes[k].and_then(deviation);
        let value = term.shape[k];
        let estimate = match key.1 {
            Scale::Logarithmic => Estimate::logarithmic(value, error.map(|e| e / value), folds),
            _ => Estimate::new(value, error, folds),
        };
        list.push((key.0.to_owned(), estimate));
    }
    let (from, to) = signals::bounds(&study.s.x);
    let known = |value| Estimate { value, ci95: None };
    match term.id {
        "position_force" | "position_friction" => {
            list.push(("from_m".to_owned(), known(from)));
            list.push(("to_m".to_owned(), known(to)));
        }
        "position_spring" => {
            let aside = c
                .get(1)
                .map_or(0.0, |share| ASIDE * (to - from) * share / c[0]);
            list.push(("centre_m".to_owned(), known(0.5 * (from + to) - aside)));
        }
        "load_dependent_friction" => {
            list.push((
                "load_N".to_owned(),
                known(study.s.load.as_deref().map_or(0.0, mean)),
            ));
        }
        "thermal_drift" => {
            if let Some(t) = &study.s.temperature {
                list.push(("temperature_C".to_owned(), known(mean(t))));
            }
        }
        _ => {}
    }
    list
}
