//! The paper's Table 3 and Figures 7–8 from its own parameters, beside what optimal breakpoints reach.

pub mod experiment;
pub mod figure_6;
pub mod literal;
mod present;
pub mod printed;
pub mod recovery;
mod search;
mod stick_slip;
mod study;
#[cfg(test)]
mod tests;

use experiment::Experiment;
use figure_6::Figure6;
use literal::Literal;
use preslide_fit::friction::{FrictionModel, Path};
use preslide_fit::identify::regression::MaxwellSlipFit;
use preslide_fit::identify::virgin::VirginCurve;
use preslide_fit::progress::Progress;
use preslide_fit::report::figures::significant;
use preslide_fit::statistics::nmse;
use preslide_host::compare::memory::Scale;
use preslide_host::paper::{self, TableColumn};
use printed::Bound;
use rayon::prelude::*;
use recovery::Recovery;
use search::Search;
use std::ops::Range;

/// Samples of the virgin curve.
pub const SAMPLES: usize = 2001;
/// Sizes for which breakpoints are searched. The curve itself has ten blocks, so more than nine say nothing.
pub const SIZES: Range<usize> = 2..10;
/// Best subsets of the grid that are refined.
const REFINED: usize = 6;
/// The paper's own criterion for enough blocks (%): "limiting the respective normalized Mean Square Error to less
/// than 1 %".
pub const CRITERION: f64 = 1.0;

/// A virgin curve of the reference model: displacements from rest and the force there.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Displacement \[m\], ascending from 0.
    pub displacement: Vec<f64>,
    /// Force \[N\] of the ten-block column of Table 3.
    pub force: Vec<f64>,
    piece: Range<usize>,
    velocity: Vec<f64>,
}

impl Curve {
    /// The ten-block column along these displacements \[m\].
    fn along(displacement: Vec<f64>) -> Result<Self, String> {
        let samples = displacement.len();
        let mut curve = Self {
            velocity: vec![0.0; samples],
            piece: 0..samples,
            force: Vec::new(),
            displacement,
        };
        curve.force = curve.force_of(&paper::REFERENCE.model())?;
        Ok(curve)
    }

    /// [`SAMPLES`] samples, uniform in displacement from 0 to [`paper::RANGE`].
    ///
    /// # Errors
    /// A parameter that the library refuses.
    pub fn uniform() -> Result<Self, String> {
        let step = paper::RANGE / (SAMPLES - 1) as f64;
        Self::along((0..SAMPLES).map(|i| i as f64 * step).collect())
    }

    /// One sample at every step of the load by [`paper::LOAD_RESOLUTION`] below breakaway: uniform in force, as a
    /// machine that ramps the load would sample.
    ///
    /// # Errors
    /// A parameter that the library refuses.
    pub fn load_steps() -> Result<Self, String> {
        let corners = recovery::exact_curve(&paper::REFERENCE.weights());
        let inverse = VirginCurve {
            displacement: corners.force,
            force: corners.displacement,
        };
        let steps = (paper::BREAKAWAY / paper::LOAD_RESOLUTION).round() as usize;
        Self::along(
            (0..steps)
                .map(|i| inverse.at(i as f64 * paper::LOAD_RESOLUTION))
                .collect(),
        )
    }

    /// Force \[N\] of a model along this curve's displacements from rest, computed by the library.
    ///
    /// # Errors
    /// A parameter that the library refuses.
    pub fn force_of(&self, model: &FrictionModel) -> Result<Vec<f64>, String> {
        model
            .force(Path {
                position: &self.displacement,
                velocity: &self.velocity,
                pieces: std::slice::from_ref(&self.piece),
                sample_time: 1.0,
            })
            .map_err(|e| e.to_string())
    }

    /// NMSE (13) (%) of a model.
    fn nmse_of(&self, model: &FrictionModel) -> Result<f64, String> {
        Ok(nmse(&self.force, &self.force_of(model)?, &self.rows()))
    }

    fn rows(&self) -> Vec<usize> {
        (0..self.displacement.len()).collect()
    }
}

/// One number of blocks: the paper's breakpoints and the best ones.
#[derive(Clone, Debug)]
pub struct Size {
    /// Number of blocks `N`.
    pub n: usize,
    /// NMSE (%) of the column of Table 3.
    pub nmse_table3: f64,
    /// The same over [`Curve::load_steps`].
    pub nmse_load_steps: f64,
    /// What the paper's text prints (%).
    pub nmse_printed: Option<f64>,
    /// NMSE (%) of optimal breakpoints.
    pub nmse_optimal: f64,
    /// Optimal breakpoints and stiffnesses.
    pub optimal: MaxwellSlipFit,
    /// Force \[N\] of the column of Table 3 along the curve.
    pub force_table3: Vec<f64>,
    /// Force \[N\] of the optimal blocks along the curve.
    pub force_optimal: Vec<f64>,
}

impl Size {
    /// `ΣW` \[N\] of the optimal blocks.
    pub fn limit(&self) -> f64 {
        let MaxwellSlipFit {
            yields, stiffness, ..
        } = &self.optimal;
        yields.iter().zip(stiffness).map(|(d, k)| d * k).sum()
    }
}

/// Everything that `reproduce` computes from the paper's tables.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// The curve that is fitted.
    pub curve: Curve,
    /// Sizes 2…9.
    pub sizes: Vec<Size>,
    /// Table 3 by (7)–(9), columns of 2…10 blocks.
    pub recovered: Vec<Recovery>,
    /// What the printed errors can mean.
    pub bounds: Vec<Bound>,
    /// Equations (10)–(12) as printed.
    pub literal: Vec<Literal>,
    /// Figure 6 and Table 2, with all models.
    pub figure_6: Figure6,
    /// The experiment, simulated.
    pub experiment: Experiment,
    /// One sentence: what to use and why.
    pub recommendation: String,
}

/// Steps that [`reproduce`] reports to its progress.
pub const STEPS: u64 = 3 + (SIZES.end - SIZES.start) as u64 + experiment::REPEATS as u64;

/// Reproduces the paper's figures from [`paper`]; `seed` is that of the experiment's repeats.
///
/// # Errors
/// A parameter that the library refuses, or a size for which no fit exists; neither happens with the paper's
/// tables.
pub fn reproduce(seed: u64, progress: &Progress) -> Result<Reproduction, String> {
    of_repeats(seed, experiment::REPEATS, progress)
}

fn of_repeats(seed: u64, repeats: usize, progress: &Progress) -> Result<Reproduction, String> {
    let curve = Curve::uniform()?;
    let steps = Curve::load_steps()?;
    let optimal = optimal(&curve, progress)?;
    let sizes = optimal
        .into_iter()
        .map(|optimal| {
            let n = optimal.yields.len();
            let table = column(n)?.model();
            let best = FrictionModel::maxwell_slip(&optimal.stiffness, &optimal.yields);
            Ok(Size {
                n,
                nmse_table3: curve.nmse_of(&table)?,
                nmse_load_steps: steps.nmse_of(&table)?,
                nmse_printed: paper::PRINTED_NMSE.iter().find(|p| p.0 == n).map(|p| p.1),
                nmse_optimal: curve.nmse_of(&best)?,
                force_table3: curve.force_of(&table)?,
                force_optimal: curve.force_of(&best)?,
                optimal,
            })
        })
        .collect::<Result<Vec<_>, String>>()?;
    let sampled = VirginCurve {
        displacement: curve.displacement.clone(),
        force: curve.force.clone(),
    };
    let recovered = paper::TABLE_3
        .iter()
        .map(|column| recovery::recover(column, &sampled))
        .collect::<Result<Vec<_>, String>>()?;
    Ok(Reproduction {
        recommendation: recommendation(&sizes),
        bounds: printed::bounds(&curve)?,
        literal: literal::literal()?,
        figure_6: {
            let found = Figure6::of_the_paper()?;
            progress.inc(1);
            found
        },
        experiment: Experiment::run(seed, repeats, progress)?,
        curve,
        sizes,
        recovered,
    })
}

/// Nested reversals within the pre-sliding range, at the speed of a quasi-static experiment: an outer loop of
/// ±40 µm and inner loops down to a 500th of it.
const REVERSALS: Scale = Scale {
    amplitude: paper::RANGE,
    speed: 20e-6,
};

fn column(n: usize) -> Result<&'static TableColumn, String> {
    paper::TABLE_3
        .iter()
        .find(|column| column.size() == n)
        .ok_or_else(|| format!("Table 3 has no column of {n} blocks"))
}

/// The best breakpoints for every size.
fn optimal(curve: &Curve, progress: &Progress) -> Result<Vec<MaxwellSlipFit>, String> {
    let pieces = std::slice::from_ref(&curve.piece);
    let search = Search::new(&curve.displacement, pieces, &curve.force)?;
    progress.inc(1);
    SIZES
        .into_par_iter()
        .map(|n| {
            let best = search.best(n, REFINED);
            progress.inc(1);
            best.ok_or_else(|| format!("no {n} blocks with positive stiffness fit the curve"))
        })
        .collect()
}

/// The fewest blocks that meet the paper's own criterion, and what else they save.
fn recommendation(sizes: &[Size]) -> String {
    let first = |nmse: fn(&Size) -> f64| sizes.iter().find(|size| nmse(size) < CRITERION);
    let Some((best, table)) = first(|s| s.nmse_optimal).zip(first(|s| s.nmse_table3)) else {
        return format!("No size leaves less than {CRITERION} % of the variance.");
    };
    let beaten: Vec<String> = sizes
        .iter()
        .skip_while(|size| size.n < best.n)
        .take(2)
        .filter_map(|size| {
            let worse = sizes
                .iter()
                .rfind(|other| other.n > size.n && other.nmse_table3 > size.nmse_optimal)?;
            Some(format!(
                "{} optimal blocks leave {} %, less than the paper's {} ({} %)",
                size.n,
                significant(size.nmse_optimal),
                worse.n,
                significant(worse.nmse_table3)
            ))
        })
        .collect();
    format!(
        "Place the breakpoints by optimisation and use {} blocks: they meet the paper's own criterion (NMSE below {CRITERION} %), for which its breakpoints take {}. {}.",
        best.n,
        table.n,
        beaten.join("; ")
    )
}
