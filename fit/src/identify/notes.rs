//! What a user should know about an identification, in words.

use super::family::Family;
use super::family::bench::Bench;
use super::maxwell_slip::knee;
use super::{Candidate, Identification, Method, reads_to_an_end};
use crate::progress::Progress;
use crate::recording::Recording;
use crate::report::figures::{left, quantity};
use crate::report::units::symbol;
use crate::signal::{Kinematics, stands_mostly};
use crate::statistics::{Estimate, nmse};

/// Difference between training and test NMSE that wants an explanation.
const WORTH_EXPLAINING: f64 = 0.15;
/// Folds below which an interval clustered by fold is a rough guess.
const FEW_FOLDS: usize = 6;

/// Held-out NMSE of the best model (%) above which it explains nothing.
const UNEXPLAINED: f64 = 50.0;

/// NMSE held out (%) from which a model is useless: it predicts the effort no better, or hardly better, than its mean does.
const NOTHING: f64 = 95.0;

/// A model leaves at least as much of what is held out as of what it was fitted to, but for how the two are measured: where it leaves this
/// many times as much of the fitted samples, it is not the model that was fitted …
const NOT_AS_FITTED: f64 = 2.0;
/// … beyond what the rounding of a nearly perfect fit makes of that (percentage points of NMSE).
const NOT_AS_FITTED_LEAST: f64 = 1.0;
/// A model that leaves this many times as much of what is held out as of what it was fitted to, and more than [`UNEXPLAINED`], has learned its
/// samples by heart.
const BY_HEART: f64 = 10.0;

/// NMSE of Coulomb + viscous friction (%) above which the motion hardly slides.
const MOSTLY_PRESLIDING: f64 = 30.0;

/// A block that yields only beyond this share of half of the longest stroke hardly slips …
const SOFT: f64 = 0.8;
/// … and where such blocks hold more than this share of the friction, it is said.
const MOSTLY_SOFT: f64 = 0.5;

/// How the friction level of one fold differs from the model's: `effort ≈ gain·friction + rest + offset`.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Start of the fold (s).
    pub start: f64,
    /// Gain on the model's friction (-).
    pub gain: f64,
    /// Offset beside the model's (N or N·m).
    pub offset: f64,
    /// The fold lies in the test window.
    pub test: bool,
}

impl Candidate {
    /// What the search says against its own result.
    pub fn caveats(&self) -> Vec<String> {
        let mut caveats = Vec::new();
        let name = self.model.friction.name();
        if self.method == Method::Descent(Family::Hsieh) {
            caveats.push(format!("{name}: its error has several minima; another seed may find other parameters and a smaller error"));
        }
        if !self.at_edge.is_empty() {
            caveats.push(format!(
                "{name}: {} ended at the bound of its search range, a limiting case of the model: the value means little",
                self.at_edge.join(", ")
            ));
        }
        caveats
    }
}

impl Identification {
    /// Highest speed of the training data (m/s or rad/s).
    pub fn top_speed(&self) -> f64 {
        let rows = self.split.folds.iter().flatten();
        rows.map(|&i| self.velocity[i].abs()).fold(0.0, f64::max)
    }

    /// The model to use.
    pub fn best(&self) -> &Candidate {
        &self.candidates[self.recommended]
    }

    /// Recommends GMS with `blocks` blocks, or Coulomb + viscous friction for 0, because the user wants it.
    ///
    /// # Errors
    /// Which sizes there are, where this one is not among them.
    pub fn choose(&mut self, blocks: usize) -> Result<(), String> {
        let wanted =
            |c: &Candidate| c.size() == blocks && (blocks == 0 || c.method == Method::Optimal);
        let sizes = self.optimal().map(|c| c.size().to_string());
        let sizes: Vec<String> = std::iter::once("0".to_owned()).chain(sizes).collect();
        self.recommended = self.candidates.iter().position(wanted).ok_or_else(|| {
            format!(
                "--blocks {blocks}: this recording gives models of {} blocks",
                sizes.join(", ")
            )
        })?;
        self.say_taken();
        Ok(())
    }

    /// Fits a model of the family and recommends it, because the user wants it. Reports two steps to `progress`.
    ///
    /// # Errors
    /// Why the model does not go with this recording; exit code 3.
    pub fn choose_family(
        &mut self,
        recording: &Recording,
        family: Family,
        progress: &Progress,
    ) -> Result<(), String> {
        let kinematics = Kinematics::below(recording, self.band_hz);
        let candidate = Bench::new(recording, &kinematics, self).candidate(family, progress)?;
        let candidate = candidate.ok_or_else(|| {
            format!(
                "{}: {} cannot be fitted: no starting values make its force resist the motion; `preslide compare` tries the others",
                recording.name,
                family.name()
            )
        })?;
        let before = std::mem::replace(&mut self.recommended, self.candidates.len());
        self.candidates.push(candidate);
        self.reach_to_a_better(before, recording);
        self.say_taken();
        Ok(())
    }

    fn say_taken(&mut self) {
        let best = self.best();
        self.recommendation = format!(
            "As requested: {}, {} held out. Otherwise: {}",
            best.model.friction.name(),
            left(best.nmse_test),
            self.recommendation
        );
    }

    /// The GMS models with optimal breakpoints, ascending in size.
    pub fn optimal(&self) -> impl Iterator<Item = &Candidate> {
        self.candidates
            .iter()
            .filter(|c| c.method == Method::Optimal)
    }

    /// The model to use of those that `may` have so many blocks: the recommended one, or where it may not, by the same rule among the others.
    pub fn recommended_among(&self, may: impl Fn(usize) -> bool) -> Option<&Candidate> {
        if may(self.best().size()) {
            return Some(self.best());
        }
        let others: Vec<&Candidate> = self.optimal().filter(|c| may(c.size())).collect();
        let held_out: Vec<&[f64]> = others.iter().map(|c| c.held_out.as_slice()).collect();
        others.get(knee(&held_out)).copied()
    }

    /// Gain and offset of every repeat of training and test data against the recommended model.
    pub fn levels(&self, recording: &Recording) -> Vec<Level> {
        let model = self.best();
        let mut levels: Vec<Level> = self
            .rows_by_repeat(recording)
            .iter()
            .filter_map(|(rows, test)| {
                let (gain, offset) = self.gain_and_offset(model, rows)?;
                Some(Level {
                    start: recording.t_s[rows[0]],
                    gain,
                    offset,
                    test: *test,
                })
            })
            .collect();
        levels.sort_by(|a, b| a.start.total_cmp(&b.start));
        levels
    }

    fn rows_by_repeat(&self, recording: &Recording) -> Vec<(Vec<usize>, bool)> {
        let train = self.split.folds.iter().map(|rows| (rows.clone(), false));
        let mut test = std::collections::BTreeMap::<u32, Vec<usize>>::new();
        for &i in self.split.test.iter().flatten() {
            test.entry(recording.repeat[i]).or_default().push(i);
        }
        train
            .chain(test.into_values().map(|rows| (rows, true)))
            .collect()
    }

    fn gain_and_offset(&self, model: &Candidate, rows: &[usize]) -> Option<(f64, f64)> {
        let n = rows.len() as f64;
        let (mut f, mut e, mut ff, mut fe) = (0.0, 0.0, 0.0, 0.0);
        for &i in rows {
            f += model.fitted[i];
            e += self.effort[i];
            ff += model.fitted[i] * model.fitted[i];
            fe += model.fitted[i] * self.effort[i];
        }
        let variation = ff - f * f / n;
        (variation > 0.0).then(|| {
            let gain = (fe - f * e / n) / variation;
            (gain, (e - gain * f) / n)
        })
    }

    /// NMSE (%) that stays over `test` or training rows when every repeat may have its own gain and offset.
    fn nmse_with_own_levels(&self, recording: &Recording, of_test: bool) -> f64 {
        let model = self.best();
        let mut corrected = model.fitted.clone();
        let mut all = Vec::new();
        for (rows, test) in self.rows_by_repeat(recording) {
            if test == of_test
                && let Some((gain, offset)) = self.gain_and_offset(model, &rows)
            {
                for &i in &rows {
                    corrected[i] = gain * model.fitted[i] + offset;
                }
                all.extend(rows);
            }
        }
        nmse(&self.effort, &corrected, &all)
    }

    /// NMSE (%) held out of Coulomb + viscous friction, and the lowest of GMS.
    fn extremes(&self) -> (f64, f64) {
        let held_out = self.optimal().map(|c| c.nmse_test);
        (
            self.candidates[0].nmse_test,
            held_out.fold(f64::INFINITY, f64::min),
        )
    }

    /// Whether hysteresis is nearly all that this motion shows of friction; of samples beside the end of a reading that is no wonder.
    pub(super) fn is_mostly_presliding(&self) -> bool {
        let (baseline, lowest) = self.extremes();
        let is_cut = reads_to_an_end(&self.channel);
        !is_cut && baseline > MOSTLY_PRESLIDING && lowest < 0.5 * baseline
    }

    /// What to use and why.
    pub(super) fn recommended_in_words(&self) -> String {
        let (baseline, lowest) = self.extremes();
        let [baseline, lowest] = [baseline, lowest].map(left);
        let best = self.best();
        let blocks = best.size();
        let plural = if blocks == 1 { "" } else { "s" };
        if best.nmse_test.is_nan() || best.nmse_test > UNEXPLAINED {
            self.unexplained_in_words()
        } else if self.optimal().next().is_none() {
            format!(
                "Use this fit ({baseline} of the variance left on held-out data) in this direction only; record reversals for a friction model."
            )
        } else if blocks == 0 {
            format!(
                "Use Coulomb + viscous friction ({baseline} of the variance left on held-out data): blocks leave {lowest}, so this recording does not show pre-sliding. To see it, reverse so slowly that the friction force takes tens of samples to return."
            )
        } else {
            format!(
                "Use GMS with {blocks} block{plural}: {} of the variance left on held-out data (the best of all sizes leaves {lowest}, Coulomb + viscous {baseline}).",
                left(best.nmse_test)
            )
        }
    }

    /// What to use where the best model leaves most of the effort.
    fn unexplained_in_words(&self) -> String {
        let best = self.best();
        let told = left(best.nmse_test);
        match (self.leaves_noise, best.nmse_test < NOTHING) {
            (true, true) => format!(
                "Use {} with its intervals in mind: {told} of the variance is left on held-out data, but as noise, which changes from sample to sample and which no model predicts. To know more, record for longer, or less noise.",
                best.model.friction.name()
            ),
            (true, false) => format!(
                "Use none of these models: the best leaves {told} of the variance on held-out data, as noise, which changes from sample to sample. Record for longer, or less noise, or motion that takes more force."
            ),
            (false, _) if self.optimal().next().is_none() => format!(
                "Use none of these models: the best leaves {told} of the variance on held-out data. So little motion in one direction shows no friction: record strokes in both."
            ),
            (false, _) => format!(
                "Use none of these models: the best leaves {told} of the variance on held-out data. This effort is not friction: look at the residual against time and position, check the effort's column (--map) and sign (--sign), and record faster or longer strokes."
            ),
        }
    }

    /// The share of the breakaway force that blocks hold which hardly ever slip, where it is most of it.
    fn soft_share(&self) -> Option<f64> {
        let held = |(k, d): &(Estimate, Estimate)| k.value * d.value;
        let blocks = &self.best().blocks;
        let soft = blocks
            .iter()
            .filter(|b| b.1.value > SOFT * self.half_a_stroke);
        let share = soft.map(held).sum::<f64>() / blocks.iter().map(held).sum::<f64>();
        (share > MOSTLY_SOFT).then_some(share)
    }

    /// Why the best model is useless, if its errors on fitted and held-out samples say so.
    pub fn refused(&self) -> Option<String> {
        let best = self.best();
        let (train, test) = (best.nmse_train, best.nmse_test);
        let told = format!(
            "it leaves {} of the variance it was fitted to, and {} of what is held out",
            left(train),
            left(test)
        );
        // A requested window may be calmer or livelier than the rest; then only a fit that explains nothing of its own samples is useless.
        let most = match self.split.test {
            Some(_) => NOTHING,
            None => NOT_AS_FITTED * test + NOT_AS_FITTED_LEAST,
        };
        if !train.is_finite() || train > most.max(test) {
            return Some(format!(
                "the best model does not run as it was fitted ({told}): this is a fault of this program; please report it with the recording"
            ));
        }
        if test.is_nan() || test >= NOTHING {
            return Some("the best model explains nothing of what is held out; record more strokes, or widen --train".to_owned());
        }
        if test > UNEXPLAINED && test > BY_HEART * train {
            return Some(format!(
                "the best model fits its own samples only ({told}); record more of the same motion, or widen --train"
            ));
        }
        // A window may show little of the effort that was fitted.
        let is_windowed = self.split.test.is_some();
        (test > UNEXPLAINED && !is_windowed && !self.leaves_noise)
            .then(|| format!("this effort is not friction ({told})"))
    }

    /// Why the fit is recommended where blocks that the paper's method reads off the curve leave less.
    pub fn why_not_the_papers(&self, recording: &Recording) -> Option<String> {
        let papers = self.candidates.iter().filter(|c| c.method == Method::Paper);
        let papers = papers.min_by(|a, b| a.nmse_test.total_cmp(&b.nmse_test))?;
        let (_, latest) = self.yield_range;
        let may_yield_later = latest < self.half_a_stroke;
        (may_yield_later && papers.nmse_test < self.best().nmse_test).then(|| {
            format!(
                "the paper's method leaves less, {} with {} blocks, because its blocks may yield late; those of the fit yield by {} at the latest: later ones may as well be a force of the position, and do not surely predict strokes better that were left out; more strokes decide",
                left(papers.nmse_test),
                papers.size(),
                quantity(latest, recording.position_unit())
            )
        })
    }

    /// What the user should know, besides the recording's own warnings.
    pub fn notes(&self, recording: &Recording) -> Vec<String> {
        let unit = recording.position_unit();
        let (baseline, _) = self.extremes();
        let best = self.best();
        let mut notes = self.search_notes.clone();
        if self.channel.saturation.is_none() {
            notes.extend(stands_mostly(recording));
        }
        notes.extend(self.stick_slip.map(|found| found.words(recording)));
        let (shortest, longest) = self.yield_range;
        if let Some(share) = self.soft_share() {
            notes.push(format!(
                "{:.0} % of the friction yields only beyond {:.0} % of the longest stroke: what hardly ever slips may just as well be a spring, a weight or another position-dependent force; `preslide diagnose` says which, and so would a longer motion",
                100.0 * share,
                50.0 * SOFT
            ));
        } else if self.is_mostly_presliding() {
            notes.push(format!(
                "Coulomb + viscous friction leaves {baseline:.0} %: most of this motion is pre-sliding, where it says nothing"
            ));
        }
        if let Some(viscous) = best.rigid_body.iter().find(|p| p.0 == "viscous")
            && viscous.1.value < 0.0
        {
            notes.push(format!(
                "the viscous coefficient came out negative{}: friction falls with speed in this recording; do not use the model beyond the recorded speeds",
                if viscous.1.ci95.is_some_and(|ci| ci[1] > 0.0) { ", and may be zero" } else { "" }
            ));
        }
        notes.extend(self.falls_with_speed(recording));
        notes.extend(best.caveats());
        if best.size() > 0 {
            for (_, d) in &best.blocks {
                if d.value <= 1.001 * shortest {
                    notes.push(format!(
                        "the stiffest block yields within one sample ({}): its stiffness is a lower bound; sample faster or reverse more slowly",
                        quantity(d.value, unit)
                    ));
                }
                if d.value >= 0.98 * longest {
                    let (end, remedy) = match longest < 0.98 * self.half_a_stroke {
                        true => (
                            "the longest displacement that this recording separates from a force of the position",
                            "more strokes of different length",
                        ),
                        false => ("half of the longest stroke", "longer strokes"),
                    };
                    notes.push(format!(
                        "the softest block yields at {end} ({}) and may never have slipped: its weight is a lower bound; record {remedy}",
                        quantity(d.value, unit)
                    ));
                }
            }
        }
        if self.split.folds.len() < FEW_FOLDS {
            notes.push(format!(
                "only {} {}s to judge by: the confidence intervals are rough; record more",
                self.split.folds.len(),
                self.split.unit
            ));
        }
        if self.one_speed() {
            notes.push(
                "nearly all of the motion is at one speed, so viscous friction and friction level look alike; move at several speeds".to_owned(),
            );
        }
        notes.extend(self.explain_test(recording));
        notes
    }

    /// Whether three quarters of the moving samples have the median speed within a fifth.
    fn one_speed(&self) -> bool {
        let mut speeds: Vec<f64> = self
            .split
            .folds
            .iter()
            .flatten()
            .map(|&i| self.velocity[i].abs())
            .collect();
        speeds.sort_by(f64::total_cmp);
        let top = speeds.last().copied().unwrap_or(0.0);
        speeds.retain(|speed| *speed > 0.05 * top);
        let median = speeds.get(speeds.len() / 2).copied().unwrap_or(0.0);
        let near = speeds
            .iter()
            .filter(|s| (*s / median - 1.0).abs() < 0.2)
            .count();
        4 * near > 3 * speeds.len()
    }

    /// Why training and test data fit differently well, where they do.
    fn explain_test(&self, recording: &Recording) -> Option<String> {
        self.split.test.as_ref()?;
        let best = self.best();
        let (worse, better) = if best.nmse_train > best.nmse_test {
            ("training", "test")
        } else {
            ("test", "training")
        };
        if (best.nmse_train / best.nmse_test).ln().abs() < WORTH_EXPLAINING {
            return None;
        }
        let levels = self.levels(recording);
        // The median: the window may cut a repeat to a few samples.
        let median = |test: bool, pick: fn(&Level) -> f64| {
            let mut of: Vec<f64> = levels.iter().filter(|l| l.test == test).map(pick).collect();
            of.sort_by(f64::total_cmp);
            of.get(of.len() / 2).copied().unwrap_or(f64::NAN)
        };
        Some(format!(
            "the {worse} part fits worse than the {better} part ({:.3} % and {:.3} %): in training the friction level per {} is {:.2} % and the offset {:+.4} {} off the model, in test {:.2} % and {:+.4} {}; with a level and an offset of their own for every {} {:.3} % and {:.3} % would be left, the rest is the shape of the loops",
            best.nmse_train.max(best.nmse_test),
            best.nmse_train.min(best.nmse_test),
            self.split.unit,
            100.0 * (median(false, |l| l.gain) - 1.0),
            median(false, |l| l.offset),
            symbol(recording.effort_unit()),
            100.0 * (median(true, |l| l.gain) - 1.0),
            median(true, |l| l.offset),
            symbol(recording.effort_unit()),
            self.split.unit,
            self.nmse_with_own_levels(recording, best.nmse_train < best.nmse_test),
            self.nmse_with_own_levels(recording, best.nmse_train >= best.nmse_test),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Options, identify};
    use crate::progress::Progress;
    use crate::recording::{LoadOptions, load_csv};
    use preslide_host_tests::made::{Blocks, sines};

    /// Notes on an arm that swings against friction of 0.2 N·m and this weight.
    fn notes(weight: f64) -> String {
        let mut block = Blocks::new(&[(20.0, 0.01)]);
        let mut text = "t_s,q_rad,torque_Nm\n".to_owned();
        for i in 0..4000 {
            let t = f64::from(i) * 0.005;
            let [q, v, a] = sines(&[[1.2, 1.3, 0.0], [0.4, 4.4, 1.0]], t);
            let torque = 0.02 * a + 0.02 * v + block.force(q) + weight * (q - 0.3).sin();
            text += &format!("{t:.3},{q:.5},{torque:.5}\n");
        }
        let recording = load_csv(text.as_bytes(), "arm.csv", &LoadOptions::default())
            .unwrap_or_else(|e| panic!("{e}"));
        let progress = Progress::new("identify", 0);
        let found = identify(&recording, &Options::default(), &progress);
        let found = found.unwrap_or_else(|e| panic!("{e}"));
        found.notes(&recording).join("\n")
    }

    #[test]
    fn a_weight_is_gravity_and_no_hysteresis() {
        let said = notes(3.0);
        assert!(
            said.contains("gravity (a force with the sine of the angle) is part of the fit"),
            "{said}"
        );
        assert!(
            !said.contains("most of this motion is pre-sliding"),
            "{said}"
        );
        let said = notes(0.0);
        assert!(
            !said.contains("a spring, a weight") && !said.contains("gravity"),
            "{said}"
        );
    }
}
