//! Finished models, run through the library and measured.

use super::maxwell_slip::{self, Selection, Sized};
use super::plain::Plain;
use super::refine;
use super::regression::{Regressor, Surface};
use super::rigid_body::{self, RigidBody};
use super::virgin::VirginCurve;
use super::weights::Weights;
use super::{Candidate, Method};
use crate::friction::FrictionModel;
use crate::model::Model;
use crate::recording::Recording;
use crate::signal::Kinematics;
use crate::signal::Split;
use crate::statistics::Estimate;
use std::collections::BTreeMap;

/// Runs finished models through the library and measures them.
pub(super) struct Judge<'a> {
    pub(super) recording: &'a Recording,
    pub(super) kinematics: &'a Kinematics,
    pub(super) effort: &'a [f64],
    pub(super) split: &'a Split,
    pub(super) weights: &'a Weights,
    pub(super) train: &'a [usize],
    /// The effort contains inertia, so that it went through the filter.
    pub(super) inertial: bool,
    /// What every model but the baseline has beside hysteresis.
    pub(super) plain: Plain,
    /// Its columns.
    pub(super) columns: &'a [Regressor],
}

impl Judge<'_> {
    /// The whole effort of friction and plain physics, filtered like the measured one.
    fn effort_of(&self, friction: &FrictionModel, linear: &[f64]) -> Result<Vec<f64>, String> {
        let friction = friction
            .force(self.kinematics.path(self.recording))
            .map_err(|e| e.to_string())?;
        let mut effort = if self.inertial {
            self.kinematics.filter.smooth(&friction)
        } else {
            friction
        };
        self.add(&mut effort, linear, 1.0);
        Ok(effort)
    }

    /// Adds plain physics with these coefficients, times `factor`.
    fn add(&self, effort: &mut [f64], linear: &[f64], factor: f64) {
        for (column, coefficient) in self.columns.iter().zip(linear) {
            let of_column = column.values.iter();
            (effort.iter_mut().zip(of_column)).for_each(|(e, v)| *e += factor * coefficient * v);
        }
    }

    /// Runs a model through the library and measures it.
    fn candidate(
        &self,
        friction: FrictionModel,
        linear: &[f64],
        method: Method,
        nmse_cross: f64,
    ) -> Result<Candidate, String> {
        let fitted = self.effort_of(&friction, linear)?;
        let model = self.plain.model(self.recording, friction, linear);
        Ok(self.measured(model, method, nmse_cross, fitted))
    }

    /// Measures a fit. Where no test window was asked for, `nmse_cross` stands for the test figure.
    fn measured(
        &self,
        model: Model,
        method: Method,
        nmse_cross: f64,
        fitted: Vec<f64>,
    ) -> Candidate {
        let nmse_test = match &self.split.test {
            Some(rows) => self.weights.nmse(self.effort, &fitted, rows),
            None => nmse_cross,
        };
        Candidate {
            nmse_train: self.weights.nmse(self.effort, &fitted, self.train),
            nmse_test,
            method,
            fitted,
            ..Candidate::new(model)
        }
    }

    /// Coulomb and viscous friction as least squares found them, and its NMSE (%) on folds held out in turn.
    pub(super) fn coulomb(&self, rigid: RigidBody) -> Result<(Candidate, f64), String> {
        let coulomb = rigid.value("coulomb").max(0.0);
        let friction = FrictionModel::Coulomb { coulomb };
        let model = rigid.plain.model(self.recording, friction, &rigid.linear);
        let nmse_cross = self.cross_validated(|folds| {
            let rigid = rigid_body::fit(
                self.recording,
                self.kinematics,
                self.effort,
                folds,
                self.weights,
                rigid.plain,
            )?;
            Ok(rigid.fitted)
        })?;
        let mut candidate = self.measured(model, Method::LeastSquares, nmse_cross, rigid.fitted);
        candidate.rigid_body = rigid.parameters;
        Ok((candidate, nmse_cross))
    }

    /// NMSE over folds held out in turn of whatever `fit` predicts from the others.
    fn cross_validated(
        &self,
        fit: impl Fn(&[Vec<usize>]) -> Result<Vec<f64>, String>,
    ) -> Result<f64, String> {
        let mut predicted = vec![0.0; self.recording.len()];
        for group in self.split.groups() {
            let rest: Vec<Vec<usize>> = self
                .split
                .folds
                .iter()
                .filter(|fold| !group.contains(fold))
                .cloned()
                .collect();
            let fitted = fit(&rest)?;
            for &i in group.iter().flatten() {
                predicted[i] = fitted[i];
            }
        }
        Ok(self.weights.nmse(self.effort, &predicted, self.train))
    }

    pub(super) fn optimal(&self, surface: &Surface, sized: &Sized) -> Result<Candidate, String> {
        let fit = &sized.fit;
        let friction = FrictionModel::maxwell_slip(&fit.stiffness, &fit.yields);
        let method = Method::Optimal;
        let mut candidate = self.candidate(friction, &fit.linear, method, sized.nmse_cross)?;
        candidate.held_out.clone_from(&sized.held_out);
        let covariance = refine::covariance(surface, fit);
        let folds = self.split.folds.len();
        // Standard error of a sum of `(index, weight)` of the parameters (linear, k, ln D).
        let error = |terms: &[(usize, f64)]| {
            let c = covariance.as_ref()?;
            let variance: f64 = terms
                .iter()
                .flat_map(|(i, a)| terms.iter().map(move |(j, b)| a * b * c[(*i, *j)]))
                .sum();
            Some(variance.max(0.0).sqrt())
        };
        let (p, n) = (fit.linear.len(), fit.yields.len());
        candidate.blocks = (0..n)
            .map(|i| {
                (
                    Estimate::logarithmic(
                        fit.stiffness[i],
                        error(&[(p + i, 1.0 / fit.stiffness[i])]),
                        folds,
                    ),
                    Estimate::logarithmic(fit.yields[i], error(&[(p + n + i, 1.0)]), folds),
                )
            })
            .collect();
        candidate.covariance = covariance
            .as_ref()
            .map(|c| (c.view((p, p), (2 * n, 2 * n)).into_owned(), folds));
        let weights: Vec<f64> = fit
            .stiffness
            .iter()
            .zip(&fit.yields)
            .map(|(k, d)| k * d)
            .collect();
        let of_breakaway: Vec<(usize, f64)> = (0..n)
            .flat_map(|i| [(p + i, fit.yields[i]), (p + n + i, weights[i])])
            .collect();
        candidate.rigid_body =
            (self.plain).parameters(self.recording, &fit.linear, covariance.as_ref(), folds);
        candidate.rigid_body.push((
            "coulomb",
            Estimate::new(weights.iter().sum(), error(&of_breakaway), folds),
        ));
        Ok(candidate)
    }

    /// The averaged branch of the training strokes, without what the recommended model's linear columns explain.
    pub(super) fn virgin(&self, selection: &Selection) -> VirginCurve {
        self.virgin_of(selection, self.train)
    }

    fn virgin_of(&self, selection: &Selection, rows: &[usize]) -> VirginCurve {
        let mut friction = self.effort.to_vec();
        let linear = &selection.optimal[selection.knee].fit.linear;
        self.add(&mut friction, linear, -1.0);
        let mut strokes = BTreeMap::<u32, Vec<usize>>::new();
        for &i in rows {
            strokes
                .entry(self.recording.segment[i])
                .or_default()
                .push(i);
        }
        // A stroke that the window cuts, or that begins with the recording or after a gap, does not start at a
        // reversal, and Masing's rule does not hold for it.
        let at_reversal = |segment: u32, first: usize| {
            first > 0
                && self.recording.segment[first - 1] != segment
                && self
                    .recording
                    .pieces
                    .iter()
                    .all(|piece| piece.start != first)
        };
        let whole: Vec<Vec<usize>> = strokes
            .into_iter()
            .filter(|(segment, rows)| at_reversal(*segment, rows[0]))
            .map(|(_, rows)| rows)
            .collect();
        VirginCurve::from_strokes(&self.recording.position, &friction, &whole)
    }

    /// Eqs. (7)–(9) for 1…10 blocks; sizes at which the measured curve is not concave have fewer blocks and are
    /// left out.
    pub(super) fn by_paper(
        &self,
        selection: &Selection,
        virgin: &VirginCurve,
    ) -> Result<Vec<Candidate>, String> {
        let linear = &selection.optimal[selection.knee].fit.linear;
        let mut candidates = Vec::new();
        for n in 1..=maxwell_slip::MOST {
            let of_curve = |curve: &VirginCurve| {
                let fit = maxwell_slip::by_paper(curve, n);
                let whole = fit.yields.len() == n;
                whole.then(|| FrictionModel::maxwell_slip(&fit.stiffness, &fit.yields))
            };
            let Some(friction) = of_curve(virgin) else {
                continue;
            };
            let mut candidate =
                self.candidate(friction.clone(), linear, Method::Paper, f64::NAN)?;
            if self.split.test.is_none() {
                candidate.nmse_test = self.cross_validated(|folds| {
                    let curve = self.virgin_of(selection, &folds.concat());
                    let friction = of_curve(&curve).unwrap_or_else(|| friction.clone());
                    self.effort_of(&friction, linear)
                })?;
            }
            candidates.push(candidate);
        }
        Ok(candidates)
    }
}
