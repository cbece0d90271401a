//! From a recording to parameters: the rigid body, and friction models of every size.

pub mod estimate;
pub mod maxwell_slip;
pub mod refine;
pub mod regression;
pub mod rigid_body;
pub mod search;
pub mod split;
pub mod stop;
pub mod virgin;

use crate::friction::{FrictionModel, Path};
use crate::model::Model;
use crate::nmse::nmse;
use crate::progress::Progress;
use crate::recording::Recording;
use estimate::Estimate;
use maxwell_slip::{Selection, Sized};
use regression::{Column, Regression};
use rigid_body::Kinematics;
use split::{Split, Window};
use virgin::VirginCurve;

/// What to fit and what to hold out.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Fit only this window [s].
    pub train: Option<Window>,
    /// Judge on this window [s], which is never fitted.
    pub test: Option<Window>,
}

/// How a friction model's parameters were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Linear least squares.
    LeastSquares,
    /// Eqs. (7)–(9) on the averaged branch, breakpoints at equal steps of force.
    Paper,
    /// Globally searched breakpoints.
    Optimal,
}

impl Method {
    /// Its name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Method::LeastSquares => "least squares",
            Method::Paper => "paper",
            Method::Optimal => "optimal",
        }
    }
}

/// One friction model on the recording.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The model, viscous part and offset included.
    pub model: Model,
    /// How it was found.
    pub method: Method,
    /// NMSE (13) on the samples that were fitted [%].
    pub nmse_train: f64,
    /// NMSE (13) on the test window, or on folds held out in turn [%].
    pub nmse_test: f64,
    /// Stiffness [N/m] and yield displacement [m] of each block with confidence.
    pub blocks: Vec<(Estimate, Estimate)>,
    /// Modelled effort at every sample, filtered like the measured one.
    pub fitted: Vec<f64>,
}

impl Candidate {
    /// Number of Maxwell-slip blocks, 0 for other models.
    pub fn size(&self) -> usize {
        match &self.model.friction {
            FrictionModel::Gms { blocks, .. } => blocks.len(),
            _ => 0,
        }
    }
}

/// Everything that `identify` found.
#[derive(Clone, Debug)]
pub struct Identification {
    /// Rigid body: `mass`, `viscous`, `coulomb`, `offset`.
    pub rigid_body: Vec<(&'static str, Estimate)>,
    /// Cut-off of the zero-phase filter [Hz].
    pub band_hz: f64,
    /// Whether the effort went through that filter (it does where it contains inertia).
    pub filtered: bool,
    /// Coulomb and viscous first, then the paper's procedure and optimal breakpoints by size.
    pub candidates: Vec<Candidate>,
    /// Index into `candidates`.
    pub recommended: usize,
    /// One sentence: what to use and why.
    pub recommendation: String,
    /// What the user should know, besides the recording's own warnings.
    pub notes: Vec<String>,
    /// The effort that the models explain, filtered where `filtered`.
    pub effort: Vec<f64>,
    /// Velocity [m/s or rad/s].
    pub velocity: Vec<f64>,
    /// The split that was used.
    pub split: Split,
    /// The virgin curve of the training strokes.
    pub virgin: VirginCurve,
}

/// Warnings of the loader that leave nothing to identify, with what would.
const FATAL: [(&str, &str); 4] = [
    ("no-motion", "record a motion"),
    ("one-way-motion", "record motion in both directions"),
    ("too-short", "record for longer"),
    (
        "constant-effort",
        "record or map the column that holds the effort",
    ),
];

/// Identifies rigid body and friction.
///
/// # Errors
/// What the recording lacks and what to record instead; exit code 3.
pub fn identify(
    recording: &Recording,
    options: &Options,
    progress: &Progress,
) -> Result<Identification, String> {
    for (code, remedy) in FATAL {
        if let Some(warning) = recording.warnings.iter().find(|w| w.code == code) {
            return Err(format!("{}: {warning}; {remedy}", recording.name));
        }
    }
    if !matches!(recording.effort_unit(), "N" | "Nm") {
        return Err(format!(
            "{}: the effort is a {} in {}, which is no force; map it with the drive's constant, such as --map force_N=35.15*voltage_V or --map torque_Nm=0.0066*current_A",
            recording.name,
            recording.role.name(),
            recording.effort_unit()
        ));
    }
    let split = Split::new(recording, options.train, options.test);
    let train = split.train();
    if split.folds.len() < 2 {
        return Err(format!(
            "{}: {} stroke(s) to fit and none to hold out; record at least three reversals, or widen --train",
            recording.name,
            split.folds.len()
        ));
    }
    if split.test.as_ref().is_some_and(|rows| rows.len() < 2) {
        return Err(format!(
            "{}: the test window holds no samples; the recording runs from {} to {} s",
            recording.name,
            recording.t_s[0],
            recording.t_s[recording.len() - 1]
        ));
    }

    let inertial = recording.role.contains_inertia();
    let kinematics = Kinematics::of(recording);
    let effort = if inertial {
        kinematics.filter.smooth(&recording.effort)
    } else {
        recording.effort.clone()
    };
    let rigid = rigid_body::fit(recording, &kinematics, &effort, &split.folds)?;

    let mut columns = Vec::new();
    if inertial {
        columns.push(Column {
            name: "mass",
            values: kinematics.acceleration.clone(),
        });
    }
    columns.push(Column {
        name: "viscous",
        values: kinematics.velocity.clone(),
    });
    columns.push(Column {
        name: "offset",
        values: vec![1.0; recording.len()],
    });
    let filter = |values: &[f64]| {
        if inertial {
            kinematics.filter.smooth(values)
        } else {
            values.to_vec()
        }
    };
    let regression = Regression {
        position: &recording.position,
        pieces: &recording.pieces,
        force: effort.clone(),
        columns,
        filter: Box::new(filter),
        folds: split.folds.clone(),
    };
    let range = yield_range(recording, &train)?;
    let selection = maxwell_slip::select(&regression, range, progress)?;

    let judge = Judge {
        recording,
        kinematics: &kinematics,
        effort: &effort,
        split: &split,
        train: &train,
        inertial,
    };
    let mut candidates = vec![judge.coulomb(&rigid.parameters)?];
    let virgin = judge.virgin(&selection);
    let paper = judge.by_paper(&selection, &virgin)?;
    candidates.extend(paper);
    let first_optimal = candidates.len();
    for sized in &selection.optimal {
        candidates.push(judge.optimal(&regression, sized)?);
    }
    let recommended = first_optimal + selection.knee;
    let mut identification = Identification {
        rigid_body: rigid.parameters,
        band_hz: kinematics.filter.cutoff_hz(),
        filtered: inertial,
        recommendation: String::new(),
        notes: Vec::new(),
        candidates,
        recommended,
        effort,
        velocity: kinematics.velocity,
        split,
        virgin,
    };
    identification.conclude(recording, &selection, first_optimal);
    Ok(identification)
}

/// Yields that a recording can tell apart: from the displacement of a typical sample to half of the longest
/// stroke, beyond which a block never slips.
fn yield_range(recording: &Recording, train: &[usize]) -> Result<(f64, f64), String> {
    let mut steps: Vec<f64> = train
        .windows(2)
        .map(|pair| (recording.position[pair[1]] - recording.position[pair[0]]).abs())
        .filter(|step| *step > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    let mut extent = std::collections::BTreeMap::new();
    for &i in train {
        let x = recording.position[i];
        let (low, high) = extent.entry(recording.segment[i]).or_insert((x, x));
        *low = x.min(*low);
        *high = x.max(*high);
    }
    let longest = extent
        .values()
        .map(|(low, high)| high - low)
        .fold(0.0, f64::max)
        / 2.0;
    let shortest = steps.get(steps.len() / 2).copied().unwrap_or(longest) / 2.0;
    if shortest.max(steps.first().copied().unwrap_or(0.0)) >= longest / 2.0 {
        return Err(format!(
            "{}: strokes of {:.3e} {} are sampled every {:.3e}: too coarse for a friction model; sample faster or move slower",
            recording.name,
            2.0 * longest,
            recording.position_unit(),
            2.0 * shortest,
        ));
    }
    Ok((shortest.max(steps[0]).min(longest / 10.0), longest))
}

/// Runs finished models through the library and measures them.
struct Judge<'a> {
    recording: &'a Recording,
    kinematics: &'a Kinematics,
    effort: &'a [f64],
    split: &'a Split,
    train: &'a [usize],
    inertial: bool,
}

impl Judge<'_> {
    fn path(&self) -> Path<'_> {
        Path {
            position: &self.recording.position,
            velocity: &self.kinematics.velocity,
            pieces: &self.recording.pieces,
            sample_time: self.recording.sample_time_s(),
        }
    }

    /// The whole effort of a model, filtered like the measured one.
    fn effort_of(&self, model: &Model) -> Result<Vec<f64>, String> {
        let friction = model
            .friction
            .force(self.path())
            .map_err(|e| e.to_string())?;
        let mut effort = if self.inertial {
            self.kinematics.filter.smooth(&friction)
        } else {
            friction
        };
        for (i, effort) in effort.iter_mut().enumerate() {
            *effort += model.inertia * self.kinematics.acceleration[i]
                + model.viscous * self.kinematics.velocity[i]
                + model.constant_force;
        }
        Ok(effort)
    }

    /// Measures a model. Where no test window was asked for, `nmse_cross` stands for the test figure.
    fn candidate(
        &self,
        model: Model,
        method: Method,
        nmse_cross: f64,
    ) -> Result<Candidate, String> {
        let fitted = self.effort_of(&model)?;
        let nmse_test = match &self.split.test {
            Some(rows) => nmse(self.effort, &fitted, rows),
            None => nmse_cross,
        };
        Ok(Candidate {
            nmse_train: nmse(self.effort, &fitted, self.train),
            nmse_test,
            blocks: Vec::new(),
            model,
            method,
            fitted,
        })
    }

    fn model(&self, friction: FrictionModel, linear: &[(&'static str, f64)]) -> Model {
        let of = |name| linear.iter().find(|p| p.0 == name).map_or(0.0, |p| p.1);
        Model {
            motion: self.recording.kind,
            inertia: of("mass"),
            viscous: of("viscous"),
            friction,
            constant_force: of("offset"),
            mechanics: Vec::new(),
        }
    }

    /// Coulomb and viscous friction as least squares found them, with `sgn v` as there.
    fn coulomb(&self, rigid: &[(&'static str, Estimate)]) -> Result<Candidate, String> {
        let linear: Vec<_> = rigid.iter().map(|(name, e)| (*name, e.value)).collect();
        let coulomb = linear
            .iter()
            .find(|p| p.0 == "coulomb")
            .map_or(0.0, |p| p.1.max(0.0));
        let model = self.model(FrictionModel::Coulomb { coulomb }, &linear);
        let mut candidate = self.candidate(model, Method::LeastSquares, f64::NAN)?;
        if self.split.test.is_none() {
            candidate.nmse_test = self.cross_validated(|rows| {
                let rigid = rigid_body::fit(self.recording, self.kinematics, self.effort, rows)?;
                Ok(rigid.fitted)
            })?;
        }
        Ok(candidate)
    }

    /// NMSE over folds held out in turn of whatever `fit` predicts from the others.
    fn cross_validated(
        &self,
        fit: impl Fn(&[Vec<usize>]) -> Result<Vec<f64>, String>,
    ) -> Result<f64, String> {
        let mut predicted = vec![0.0; self.recording.len()];
        let per_group = self.split.folds.len().div_ceil(6);
        for group in self.split.folds.chunks(per_group) {
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
        Ok(nmse(self.effort, &predicted, self.train))
    }

    fn linear_of(&self, linear: &[f64]) -> Vec<(&'static str, f64)> {
        let names: &[&'static str] = if self.inertial {
            &["mass", "viscous", "offset"]
        } else {
            &["viscous", "offset"]
        };
        names.iter().copied().zip(linear.iter().copied()).collect()
    }

    fn optimal(&self, regression: &Regression, sized: &Sized) -> Result<Candidate, String> {
        let fit = &sized.fit;
        let friction = FrictionModel::maxwell_slip(&fit.stiffness, &fit.yields);
        let model = self.model(friction, &self.linear_of(&fit.linear));
        let mut candidate = self.candidate(model, Method::Optimal, sized.nmse_cross)?;
        let errors = refine::standard_errors(regression, fit);
        let (p, n, folds) = (fit.linear.len(), fit.yields.len(), self.split.folds.len());
        candidate.blocks = (0..n)
            .map(|i| {
                let of = |at: usize| errors.as_ref().map(|e| e[at]);
                (
                    Estimate::new(fit.stiffness[i], of(p + i), folds),
                    Estimate::logarithmic(fit.yields[i], of(p + n + i), folds),
                )
            })
            .collect();
        Ok(candidate)
    }

    /// The averaged branch of the training strokes, without what the recommended model's linear columns explain.
    fn virgin(&self, selection: &Selection) -> VirginCurve {
        self.virgin_of(selection, self.train)
    }

    fn virgin_of(&self, selection: &Selection, rows: &[usize]) -> VirginCurve {
        let linear = self.linear_of(&selection.optimal[selection.knee].fit.linear);
        let model = self.model(FrictionModel::Coulomb { coulomb: 0.0 }, &linear);
        let friction: Vec<f64> = (0..self.recording.len())
            .map(|i| {
                self.effort[i]
                    - model.inertia * self.kinematics.acceleration[i]
                    - model.viscous * self.kinematics.velocity[i]
                    - model.constant_force
            })
            .collect();
        let mut strokes = std::collections::BTreeMap::<u32, Vec<usize>>::new();
        for &i in rows {
            strokes
                .entry(self.recording.segment[i])
                .or_default()
                .push(i);
        }
        // A stroke that the window cuts does not start at its reversal.
        let whole: Vec<Vec<usize>> = strokes
            .into_iter()
            .filter(|(segment, rows)| {
                rows[0] == 0 || self.recording.segment[rows[0] - 1] != *segment
            })
            .map(|(_, rows)| rows)
            .collect();
        VirginCurve::from_strokes(&self.recording.position, &friction, &whole)
    }

    /// Eqs. (7)–(9) for 1…10 blocks; sizes at which the measured curve is not concave have fewer blocks and are
    /// left out.
    fn by_paper(
        &self,
        selection: &Selection,
        virgin: &VirginCurve,
    ) -> Result<Vec<Candidate>, String> {
        let linear = self.linear_of(&selection.optimal[selection.knee].fit.linear);
        let mut candidates = Vec::new();
        for n in 1..=maxwell_slip::MOST {
            let of_curve = |curve: &VirginCurve| {
                let fit = maxwell_slip::by_paper(curve, n);
                let whole = fit.yields.len() == n;
                whole.then(|| {
                    self.model(
                        FrictionModel::maxwell_slip(&fit.stiffness, &fit.yields),
                        &linear,
                    )
                })
            };
            let Some(model) = of_curve(virgin) else {
                continue;
            };
            let mut candidate = self.candidate(model.clone(), Method::Paper, f64::NAN)?;
            if self.split.test.is_none() {
                candidate.nmse_test = self.cross_validated(|folds| {
                    let curve = self.virgin_of(selection, &folds.concat());
                    self.effort_of(&of_curve(&curve).unwrap_or_else(|| model.clone()))
                })?;
            }
            candidates.push(candidate);
        }
        Ok(candidates)
    }
}

impl Identification {
    /// Writes the recommendation and the notes.
    fn conclude(&mut self, recording: &Recording, selection: &Selection, first_optimal: usize) {
        let baseline = self.candidates[0].nmse_test;
        let best = &self.candidates[self.recommended];
        let lowest = self.candidates[first_optimal..]
            .iter()
            .map(|c| c.nmse_test)
            .fold(f64::INFINITY, f64::min);
        let _ = (recording, selection);
        self.recommendation = format!(
            "Use GMS with {} block{}: {:.3} % of the variance left on held-out data (best of all sizes {:.3} %, Coulomb + viscous {:.3} %).",
            best.size(),
            if best.size() == 1 { "" } else { "s" },
            best.nmse_test,
            lowest,
            baseline
        );
    }
}
