//! `preslide plan`.

use super::{AxisArgs, Failure, outputs, parse_frequency, write_text};
use clap::{Args, ValueEnum};
use preslide::control::Limits;
use preslide_drive::quantity;
use preslide_host::plan::{Show, Wish, plan};
use std::path::PathBuf;

/// A motion that shows friction, for a controller to follow: nested reversals begun at different places, passes at several speeds
///
/// It begins and ends at 0 and stays within ± half of the travel. What is not said is taken from the axis's limits.
#[derive(Args)]
#[command(
    after_help = "Example: preslide plan --travel 4mm --speed 2mm/s --acceleration 0.1m/s2 -o motion.csv\n\
                  Then: preslide drive /dev/ttyACM0 play motion.csv -o axis.csv"
)]
pub struct Plan {
    /// Write the motion
    #[arg(short, long, value_name = "MOTION.csv")]
    output: PathBuf,

    #[command(flatten)]
    axis: AxisArgs,

    /// How far it may go in all: 4mm, or 90deg with --rotary [default: four fifths of the axis's travel]
    #[arg(long, value_name = "LENGTH", value_parser = quantity::positive_rate)]
    travel: Option<f64>,

    /// Largest speed: 2mm/s [default: half of limits.speed]
    #[arg(long, value_name = "SPEED", value_parser = quantity::positive_rate)]
    speed: Option<f64>,

    /// Largest acceleration: 0.1m/s2 [default: half of limits.acceleration]
    #[arg(long, value_name = "ACCELERATION", value_parser = quantity::positive_rate)]
    acceleration: Option<f64>,

    /// Smallest stroke between two reversals; some dozens of encoder counts [default: a thousandth of the travel]
    #[arg(long, value_name = "LENGTH", value_parser = quantity::positive_rate)]
    smallest: Option<f64>,

    /// What it should show
    #[arg(long, value_name = "WHAT", default_value = "all")]
    show: What,

    /// How often, so that identify can hold one repeat out after the other
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: u32,

    /// Rows per second
    #[arg(long, value_name = "HZ", default_value = "400Hz", value_parser = parse_frequency)]
    rate: f64,

    /// The axis turns: lengths are angles, in rad or with deg
    #[arg(long)]
    rotary: bool,
}

/// What a motion should show.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum What {
    /// Nested reversals: the friction model's blocks
    Presliding,
    /// Passes over the travel: speed, cogging, spots
    Sliding,
    /// Both
    All,
}

impl Plan {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let limits = self.axis.read()?.axis().limits;
        if self.axis.is_chosen() {
            self.within(&limits)?;
        }
        let Some(travel) = self.travel.or(length(&limits).map(|length| 0.8 * length)) else {
            return Err(Failure::Input(
                "the axis has no ends of travel; give --travel".to_owned(),
            ));
        };
        let wish = Wish {
            travel,
            speed: self.speed.unwrap_or(0.5 * limits.speed),
            acceleration: self.acceleration.unwrap_or(0.5 * limits.acceleration),
            smallest: self.smallest.unwrap_or(travel * 1e-3),
            show: match self.show {
                What::Presliding => Show::Presliding,
                What::Sliding => Show::Sliding,
                What::All => Show::All,
            },
            repeats: self.repeats,
            rate: self.rate,
        };
        outputs::check(&self.axis.file(), &[("-o", Some(&self.output))], None)?;
        let planned = plan(&wish).map_err(Failure::Input)?;
        write_text(&self.output, &planned.csv(self.rotary))?;
        let unit = if self.rotary { "rad" } else { "m" };
        say!(
            "{} rows, {:.1} s, {} reversals, strokes from {:.3e} to {:.3e} {unit}, in {} repeats.",
            planned.rows.len(),
            planned.seconds(),
            planned.reversals,
            planned.strokes.0,
            planned.strokes.1,
            self.repeats
        );
        say!(
            "Next: preslide drive PORT play {} -o axis.csv",
            self.output.display()
        );
        Ok(())
    }

    /// Refuses what the axis's controller would, all of it at once.
    fn within(&self, limits: &Limits) -> Result<(), Failure> {
        let asked = [
            ("travel", self.travel, length(limits), "the axis's travel"),
            ("speed", self.speed, Some(limits.speed), "limits.speed"),
            (
                "acceleration",
                self.acceleration,
                Some(limits.acceleration),
                "limits.acceleration",
            ),
        ];
        let beyond = asked.iter().filter_map(|(name, asked, limit, of)| {
            let (asked, limit) = ((*asked)?, (*limit)?);
            (asked > limit).then(|| format!("--{name} {asked:e} is beyond {of}, {limit:e}"))
        });
        let beyond: Vec<String> = beyond.collect();
        if beyond.is_empty() {
            Ok(())
        } else {
            Err(Failure::Input(beyond.join("\n")))
        }
    }
}

/// From end to end (m or rad), where there are ends.
fn length(limits: &Limits) -> Option<f64> {
    limits.travel.map(|(low, high)| high - low)
}
