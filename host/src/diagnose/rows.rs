//! The rows that are fitted: which instants of a recording count, in blocks, over which every decision is a paired statistic.

use super::signals::Signals;
use super::weak::{Column, Weak};
use preslide_fit::recording::Recording;
use preslide_fit::signal::{LATE, spectra};
use preslide_fit::statistics::quantile_between_ranks;
use std::collections::BTreeSet;
use std::ops::Range;

/// Blocks of rows. Their scores decide, so that what is common to neighbours counts once; more would be shorter than what
/// friction remembers along its path.
const BLOCKS: usize = 36;
/// Blocks of a fold, which are held out together.
const PER_FOLD: usize = 3;
/// Fewest blocks that can decide: with six, the least of all sign patterns has a chance of 1 in 64.
pub const FEWEST: usize = 7;
/// Fewest rows of a block.
const ROWS: usize = 30;
/// Fewest folds of a file for something that only it has: one is held out, and two agree or not.
const OWN_FOLDS: usize = 3;
/// Kinds of strokes that take turns in being left out, for intervals.
const KINDS: usize = 8;
/// Seconds around an instant within which an axis that rests does not move.
const STILL_S: f64 = 0.05;

/// A recording as rows.
pub struct Rows {
    /// Coordinates, at the samples.
    pub s: Signals,
    /// Kernel, centres and folds.
    pub weak: Weak,
    /// Measured effort at the rows.
    pub force: Vec<f64>,
    /// What core and terms are fitted to: the measured effort, less a simulation's where the recording is judged against one.
    pub target: Vec<f64>,
    /// What a simulation's reproduction misses of it, as an NMSE (%): nothing smaller is the machine's.
    pub missed: f64,
    /// Measured effort at the samples.
    pub effort: Vec<f64>,
    /// Whether the effort contains inertia.
    pub inertial: bool,
    /// Rows of each block.
    pub blocks: Vec<Range<usize>>,
    /// Kind of the stroke of each row.
    pub kinds: Vec<usize>,
    /// Share of the samples at which the axis rests.
    pub at_rest: f64,
}

impl Rows {
    /// Chooses the rows of a recording, none of them within the samples `outside`.
    ///
    /// # Errors
    /// What the recording lacks, and what to record.
    pub fn new(recording: &Recording, outside: &[Range<usize>]) -> Result<Self, String> {
        let mut s = Signals::of(recording);
        let inertial = recording.role.contains_inertia();
        let still = resting(&s);
        let unsettled = unsettled(&s);
        let mut usable: Vec<bool> = (0..still.len())
            .map(|i| !still[i] && !unsettled[i])
            .collect();
        for range in outside {
            usable[range.clone()].fill(false);
        }
        let block = blocks_of(&s, &usable);
        let count = block.iter().max().map_or(0, |b| b + 1);
        s.fold = block.iter().map(|b| b / PER_FOLD).collect();
        s.folds = count.div_ceil(PER_FOLD);
        if let Some(files) = sessions(&recording.joined, &s.fold, &usable) {
            s.sessions = files;
        }
        let weak = Weak::new(&s, inertial, &usable);
        let mut blocks: Vec<Range<usize>> = Vec::new();
        let mut last = None;
        for (row, &centre) in weak.centres.iter().enumerate() {
            match blocks.last_mut() {
                Some(rows) if last == Some(block[centre]) => rows.end = row + 1,
                _ => blocks.push(row..row + 1),
            }
            last = Some(block[centre]);
        }
        if blocks.len() < FEWEST || weak.folds.len() < 3 {
            return Err(format!(
                "{}: the axis moves for {:.1} s over {} stretches once its friction is known, too few to hold any out; record at least {FEWEST} strokes, or one several times as long",
                recording.name,
                usable.iter().filter(|u| **u).count() as f64 * s.dt,
                blocks.len()
            ));
        }
        let kinds = s.kinds_of_strokes(KINDS);
        let force = weak.rows(&Column::of(recording.effort.clone()));
        Ok(Self {
            target: force.clone(),
            missed: 0.0,
            force,
            effort: recording.effort.clone(),
            kinds: weak.centres.iter().map(|&c| kinds[c]).collect(),
            at_rest: still.iter().filter(|r| **r).count() as f64 / s.x.len().max(1) as f64,
            inertial,
            blocks,
            weak,
            s,
        })
    }

    /// Frequencies (Hz) at which values at the rows have lines in time, each session with a phase of its own.
    pub fn lines_in_time(&self, values: &[f64], slowest: f64, fastest: f64) -> Vec<f64> {
        let centres = &self.weak.centres;
        let of = |session: &Range<usize>| -> (Vec<f64>, Vec<f64>) {
            let own = (0..centres.len()).filter(|row| session.contains(&centres[*row]));
            own.map(|row| (self.s.t[centres[row]], values[row])).unzip()
        };
        let parts: Vec<(Vec<f64>, Vec<f64>)> = self.s.sessions.iter().map(of).collect();
        let parts: Vec<(&[f64], &[f64])> = parts.iter().map(|(t, v)| (&t[..], &v[..])).collect();
        spectra::lines_of(&parts, slowest, fastest)
    }

    /// NMSE (%, eq. 13) of what is left at the rows.
    pub fn nmse(&self, left: &[f64]) -> f64 {
        let square: f64 = left.iter().map(|r| r * r).sum();
        100.0 * square / self.variation().max(1e-300)
    }

    /// The root mean square (N or N·m) of what an NMSE (%) leaves.
    pub fn rms_of(&self, nmse: f64) -> f64 {
        (0.01 * nmse.max(0.0) * self.variation() / self.force.len().max(1) as f64).sqrt()
    }

    /// Sum of squares of the measured effort about its mean.
    pub fn variation(&self) -> f64 {
        let mean = self.force.iter().sum::<f64>() / self.force.len().max(1) as f64;
        self.force.iter().map(|f| (f - mean).powi(2)).sum()
    }
}

/// Where the axis rests: any force below breakaway is admissible there, whatever the model.
fn resting(s: &Signals) -> Vec<bool> {
    let half = ((STILL_S / s.dt).round() as usize).max(2);
    let steps: Vec<f64> =
        s.x.windows(2)
            .map(|p| (p[1] - p[0]).abs())
            .filter(|d| *d > 0.0)
            .collect();
    // A count of the encoder, or its noise, is no motion.
    let moved = 1.5 * quantile_between_ranks(&steps, 0.02).max(s.position_noise);
    let mut still = vec![false; s.x.len()];
    for piece in &s.pieces {
        for i in piece.clone() {
            let from = i.saturating_sub(half).max(piece.start);
            let to = (i + half).min(piece.end - 1);
            let (middle, ends) = (s.smooth[i], [s.smooth[from], s.smooth[to]]);
            still[i] = ends.iter().all(|e| (e - middle).abs() <= moved);
        }
    }
    still
}

/// Where the state of friction is not known: after every start and joint until each block of the core has slipped, which it
/// has once the axis moved over twice its yield.
fn unsettled(s: &Signals) -> Vec<bool> {
    let enough = 2.0 * LATE * s.travel();
    let mut unsettled = vec![false; s.x.len()];
    for piece in &s.pieces {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in piece.clone() {
            low = low.min(s.x[i]);
            high = high.max(s.x[i]);
            unsettled[i] = high - low < enough;
        }
    }
    unsettled
}

/// The files of a recording, if the folds of the others show what acts in each; where they are many and short, one clock is better
/// than none.
fn sessions(files: &[Range<usize>], fold: &[usize], usable: &[bool]) -> Option<Vec<Range<usize>>> {
    let folds_in = |file: &Range<usize>| {
        let usable = file.clone().filter(|i| usable[*i]);
        usable.map(|i| fold[i]).collect::<BTreeSet<usize>>().len()
    };
    let with_folds = files.iter().map(|file| (file.clone(), folds_in(file)));
    // A copy, or what only rests, has no fold.
    let (told, folds): (Vec<_>, Vec<usize>) = with_folds.filter(|(_, folds)| *folds > 0).unzip();
    let enough = told.len() > 1 && folds.iter().all(|folds| *folds >= OWN_FOLDS);
    enough.then_some(told)
}

/// The block of every sample: stretches with equal shares of the moving time and of the path.
fn blocks_of(s: &Signals, usable: &[bool]) -> Vec<usize> {
    let path = |i: usize| {
        if i > 0 {
            (s.path[i] - s.path[i - 1]).max(0.0)
        } else {
            0.0
        }
    };
    let moving = usable.iter().filter(|u| **u).count().max(1) as f64;
    let whole: f64 = (0..usable.len())
        .filter(|i| usable[*i])
        .map(path)
        .sum::<f64>()
        .max(1e-300);
    let rows = moving * s.dt / 12.5e-3;
    let count = BLOCKS.min((rows / ROWS as f64) as usize).max(1);
    let mut share = 0.0;
    (0..usable.len())
        .map(|i| {
            if usable[i] {
                share += 0.5 / moving + 0.5 * path(i) / whole;
            }
            ((share * count as f64) as usize).min(count - 1)
        })
        .collect()
}
