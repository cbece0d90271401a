//! The fit: plain physics that the recording shows, and Coulomb friction and blocks of every number beside it.

use super::evidence::{Evidence, Shown};
use super::judge::Judge;
use super::laws::{self, Law, Mixture};
use super::maxwell_slip::{self, Selection};
use super::plain::{self, Place, Plain};
use super::regression::{Regression, Regressor, Surface};
use super::rigid_body::{self, RigidBody};
use super::virgin::VirginCurve;
use super::weights::Weights;
use super::{Candidate, FINEST, STEPS, yield_range};
use crate::progress::Progress;
use crate::recording::{MotionKind, Recording};
use crate::report::figures::quantity;
use crate::signal::{Kinematics, Split};

/// Share of the moving samples in the rarer direction below which a recording goes one way.
const ONE_WAY: f64 = 0.01;

/// Share of the acceleration's squares that direction, velocity and a constant must leave for an inertia to be reported: the band lets in noise of a
/// tenth of that, which takes as much off the inertia.
const TOLD: f64 = 0.01;

/// Samples that the breakpoints are fitted to. Of a longer recording every n-th is taken, which bounds the memory
/// of the search (450 B per sample) at what a small machine has; the models still run along all samples and are
/// measured on all of them.
const MOST_SCORED: usize = 25_000;

/// What is fitted, and to what.
pub(super) struct Fitting<'a> {
    pub(super) recording: &'a Recording,
    pub(super) kinematics: &'a Kinematics,
    /// Filtered where it contains inertia.
    pub(super) effort: &'a [f64],
    pub(super) split: &'a Split,
    pub(super) train: &'a [usize],
    pub(super) inertial: bool,
}

/// The result.
pub(super) struct Found {
    pub(super) candidates: Vec<Candidate>,
    pub(super) recommended: usize,
    pub(super) virgin: VirginCurve,
    pub(super) range: (f64, f64),
    pub(super) half_a_stroke: f64,
    pub(super) plain: Plain,
    pub(super) mixture: Option<Mixture>,
}

/// Blocks of every number beside the plain physics that the recording shows.
struct Searched<'a> {
    regression: Regression<'a>,
    surface: Surface,
    selection: Selection,
    shown: Shown,
    mixture: Option<Mixture>,
}

impl Fitting<'_> {
    /// The rigid body, without the terms that would come out negative.
    fn rigid_body(&self, weights: &Weights, mut plain: Plain) -> Result<RigidBody, String> {
        let fit = |plain| {
            rigid_body::fit(
                self.recording,
                self.kinematics,
                self.effort,
                &self.split.folds,
                weights,
                plain,
            )
        };
        let mut rigid = fit(plain)?;
        if rigid.value("mass") < 0.0 {
            // In pre-sliding the spring that Coulomb friction lacks looks like a negative inertia.
            plain.mass = false;
            rigid = fit(plain)?;
        }
        if rigid.value("coulomb") < 0.0 {
            // Viscous friction that imitates the rounded reversals of pre-sliding.
            (plain.viscous, plain.by_direction) = (false, false);
            rigid = fit(plain)?;
        }
        Ok(rigid)
    }

    /// The regression behind the search for breakpoints.
    fn regression(
        &self,
        columns: Vec<Regressor>,
        folds: &[Vec<usize>],
        weights: &Weights,
    ) -> Regression<'_> {
        let stride = self.train.len().div_ceil(MOST_SCORED).max(1);
        let filter = |values: &[f64]| {
            if self.inertial {
                self.kinematics.filter.smooth(values)
            } else {
                values.to_vec()
            }
        };
        Regression {
            position: &self.recording.position,
            pieces: &self.recording.pieces,
            force: self.effort.to_vec(),
            columns,
            filter: Box::new(filter),
            folds: folds
                .iter()
                .map(|fold| fold.iter().step_by(stride).copied().collect())
                .collect(),
            weights: weights.clone(),
        }
    }

    /// Plain physics, and Maxwell-slip blocks of every number beside it.
    fn search(
        &self,
        base: Plain,
        weights: &Weights,
        range: (f64, f64),
        progress: &Progress,
    ) -> Result<Searched<'_>, String> {
        let laws = Law::all(self.recording, self.kinematics, self.train, range.0);
        let mut columns = plain::every_column(self.recording, self.kinematics);
        let of_laws = laws::columns(&laws, self.recording, self.kinematics, self.effort);
        columns.extend(of_laws);
        let parts = self.split.parts();
        let mut regression = self.regression(columns, &parts.concat(), weights);
        let mut every = Surface::new(&regression, maxwell_slip::grid(range));
        let waves = Evidence {
            columns: &regression.columns,
            surface: &every,
        }
        .waves(
            &regression,
            (self.recording, self.kinematics),
            base,
            range.1,
        );
        if !waves.is_empty() {
            regression.columns.extend(waves);
            every = Surface::new(&regression, maxwell_slip::grid(range));
        }
        let evidence = Evidence {
            columns: &regression.columns,
            surface: &every,
        };
        let shown = evidence.shown(self.recording, base, range.1);
        let by_fold = every.joined(parts.iter().map(Vec::len));
        let mixture = Mixture::of(&evidence, &by_fold, &laws, self.recording, shown);
        let taken = shown.plain.among(&regression.columns);
        let surface = by_fold.part(&taken, shown.longest);
        regression.columns = shown.plain.columns(self.recording, self.kinematics);
        let selection = maxwell_slip::select(&regression, &surface, progress)
            .map_err(|reason| format!("{}: {reason}", self.recording.name))?;
        Ok(Searched {
            regression,
            surface,
            selection,
            shown,
            mixture,
        })
    }

    pub(super) fn goes_one_way(&self, rows: &[usize]) -> bool {
        let of = |sign: f64| {
            let direction = rows.iter().map(|&i| self.kinematics.direction[i]);
            direction.filter(|d| *d == sign).count() as f64
        };
        let (forward, backward) = (of(1.0), of(-1.0));
        forward.min(backward) <= ONE_WAY * (forward + backward)
    }

    /// Plain physics alone, with friction and the constant force as one.
    fn fit_one_way(&self, weights: &Weights, notes: &mut Vec<String>) -> Result<Found, String> {
        let recording = self.recording;
        let columns = plain::every_column(recording, self.kinematics);
        let folds = self.split.parts().concat();
        let folds = rigid_body::moving(recording, self.kinematics, &folds);
        let regression = self.regression(columns, &folds, weights);
        let evidence = Evidence {
            columns: &regression.columns,
            surface: &Surface::new(&regression, Vec::new()),
        };
        let (low, high) = recording.ends();
        let shown = evidence.shown(recording, Plain::of(self.inertial), high - low);
        notes.extend(said(shown));
        notes.push("the motion goes one way: Coulomb friction and a constant load come out as their sum, and pre-sliding does not show; record reversals".to_owned());
        let rigid = self.rigid_body(weights, shown.plain)?;
        let judge = Judge {
            recording,
            kinematics: self.kinematics,
            effort: self.effort,
            split: self.split,
            weights,
            train: self.train,
            inertial: self.inertial,
            plain: shown.plain,
            columns: &regression.columns,
        };
        Ok(Found {
            candidates: vec![judge.coulomb(rigid)?.0],
            recommended: 0,
            virgin: VirginCurve::default(),
            range: (FINEST * (high - low), high - low),
            half_a_stroke: high - low,
            plain: shown.plain,
            mixture: None,
        })
    }

    /// Coulomb friction, and Maxwell-slip blocks of every number: by the paper's procedure, and at the best breakpoints.
    pub(super) fn fit(
        &self,
        progress: &Progress,
        notes: &mut Vec<String>,
    ) -> Result<Found, String> {
        let recording = self.recording;
        let mut weights = Weights::by_time(recording);
        if self.goes_one_way(self.train) {
            return self.fit_one_way(&weights, notes);
        }
        let range = yield_range(recording, self.train)?;
        let mut base = Plain::of(self.inertial);
        let alike = self.inertial
            && rigid_body::inertia_told(recording, self.kinematics, &self.split.folds) < TOLD;
        if alike {
            base.mass = false;
            notes.push("the acceleration follows the direction of motion, so that inertia and Coulomb friction are one force, given as friction; record moves at several accelerations to separate them".to_owned());
        }
        let mut found = self.search(base, &weights, range, progress)?;
        let again = |what| Progress::new(what, STEPS);
        if weights.differ() {
            let knee = &found.selection.optimal[found.selection.knee];
            let residual = found.regression.residual(&knee.fit);
            weights = Weights::by_residual(recording, &residual, self.train);
            found = self.search(base, &weights, range, &again("weighted"))?;
            notes.extend(weights.in_words(recording));
        }
        let mass = found.selection.optimal[found.selection.knee].fit.linear[0];
        if base.mass && mass < 0.0 {
            notes.push(format!(
                "the inertia came out as {} and was left out: this motion has too little acceleration to show one; record faster reversals",
                quantity(
                    mass,
                    match recording.kind {
                        MotionKind::Linear => "kg",
                        MotionKind::Rotary => "kg·m²",
                    }
                )
            ));
            base.mass = false;
            found = self.search(base, &weights, range, &again("without inertia"))?;
        }
        let Searched {
            regression,
            surface,
            selection,
            shown,
            mixture,
        } = found;
        let rigid = self.rigid_body(&weights, shown.plain)?;
        notes.extend(said(shown));

        let judge = Judge {
            recording,
            kinematics: self.kinematics,
            effort: self.effort,
            split: self.split,
            weights: &weights,
            train: self.train,
            inertial: self.inertial,
            plain: shown.plain,
            columns: &regression.columns,
        };
        let without_mass = shown.plain.mass && !rigid.plain.mass;
        let (coulomb, baseline) = judge.coulomb(rigid)?;
        let mut candidates = vec![coulomb];
        let virgin = judge.virgin(&selection);
        candidates.extend(judge.by_paper(&selection, &virgin)?);
        let first_optimal = candidates.len();
        for sized in &selection.optimal {
            candidates.push(judge.optimal(&surface, sized)?);
        }
        let resolved = !maxwell_slip::baseline_suffices(baseline, &selection.optimal);
        let recommended = if resolved {
            first_optimal + selection.knee
        } else {
            0
        };
        if recommended == 0 && without_mass {
            notes.push("with Coulomb friction alone the inertia came out negative and was left out; record faster reversals".to_owned());
        }
        if alike {
            let told = candidates.iter_mut().flat_map(|c| &mut c.rigid_body);
            let coulomb = told.filter(|p| p.0 == "coulomb");
            coulomb.for_each(|p| p.0 = "coulomb_and_inertia");
        }
        Ok(Found {
            candidates,
            recommended,
            virgin,
            range: (range.0, shown.longest),
            half_a_stroke: range.1,
            plain: shown.plain,
            mixture,
        })
    }
}

/// What plain physics there is beside the rigid body, for the user.
fn said(shown: Shown) -> Option<String> {
    let place = match shown.plain.place {
        Place::Nowhere => None,
        Place::Spring => Some("a spring (a force in proportion to the position)"),
        Place::Gravity => Some("gravity (a force with the sine of the angle)"),
    };
    let asymmetry = shown
        .plain
        .by_direction
        .then_some("viscous friction that differs by direction");
    let parts: Vec<&str> = place.into_iter().chain(asymmetry).collect();
    (!parts.is_empty()).then(|| {
        format!(
            "{} {} part of the fit, for {:.0} % less error on held-out stretches",
            parts.join(" and "),
            if parts.len() == 1 { "is" } else { "are" },
            shown.gain
        )
    })
}
