//! A second position in a sentence.

use super::{Periodic, SecondPosition};
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::{quantity, within};
use preslide_fit::statistics::Estimate;

impl Periodic {
    /// In words, without a full stop.
    fn words(&self, unit: &str) -> String {
        let sure = |e: &Estimate| within(e.value, e.reach().unwrap_or(0.0), unit);
        format!(
            "periodic lead error, period {}, amplitude {} to either side, highest at {}; it takes {:.1} % of what all else leaves on passes held out and {:.1} % on stretches of the travel, at {:.1} and {:.1} standard errors; it belongs to the drive between the two or to one of the two scales, which cannot be told apart: compare the period with a turn of the screw or gear, with its balls and teeth, and with the pitch of either scale (encoder interpolation error)",
            sure(&self.period),
            sure(&self.amplitude),
            quantity(self.highest_at, unit),
            100.0 * self.passes.share,
            100.0 * self.stretches.share,
            self.passes.z,
            self.stretches.z
        )
    }
}

impl SecondPosition {
    /// In words, without a full stop.
    pub fn words(&self, recording: &Recording) -> String {
        let unit = recording.position_unit();
        let column = &self.column;
        let sure = |e: &Estimate| within(e.value, e.reach().unwrap_or(0.0), unit);
        let mut said = match &self.lead {
            None => vec![format!(
                "`{column}` measures the position too; no {}lead error: over {} passes their difference has no smooth course over the travel",
                if self.periodic.is_empty() {
                    ""
                } else {
                    "smooth "
                },
                self.passes
            )],
            Some(lead) => {
                let slope = match (&lead.slope, self.ratio) {
                    (Some(slope), _) => {
                        let reach = slope.reach().unwrap_or(0.0);
                        format!(
                            "grows by {:.1} ± {:.1} ppm of the travel and ",
                            1e6 * slope.value,
                            1e6 * reach
                        )
                    }
                    (None, Some(ratio)) => {
                        format!("(at its own {ratio:.6} times the position, so without a slope) ")
                    }
                    (None, None) => String::new(),
                };
                vec![format!(
                    "lead error: `{column}` less the position {slope}bends by {}, lowest at {} and highest at {}; on passes held out this takes {:.1} % of the difference, at {:.1} standard errors over {} passes",
                    quantity(lead.bow, unit),
                    quantity(lead.lowest_at, unit),
                    quantity(lead.highest_at, unit),
                    100.0 * lead.share,
                    lead.z,
                    self.passes
                )]
            }
        };
        said.extend(self.periodic.iter().map(|p| p.words(unit)));
        said.extend(self.lost_motion.as_ref().map(|e| {
            format!(
                "at reversals it stays behind by {} (backlash or lost motion)",
                sure(e)
            )
        }));
        said.extend(self.compliance.as_ref().map(|e| {
            let effort = recording.effort_unit();
            format!(
                "it stays behind the effort by {} a {effort} (compliance)",
                sure(e)
            )
        }));
        said.push(format!("{} RMS is left", quantity(self.left, unit)));
        said.join("; ")
    }
}
