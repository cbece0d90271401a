//! `preslide plan`.

use super::{Failure, parse_frequency, write_text};
use clap::{Args, ValueEnum};
use preslide_drive::quantity;
use preslide_host::plan::{Show, Wish, plan};
use std::path::PathBuf;

/// A motion that shows friction, for a controller to follow: nested reversals begun at different places, passes at several speeds
///
/// It begins and ends at 0 and stays within ± half of the travel.
#[derive(Args)]
#[command(
    after_help = "Example: preslide plan --travel 4mm --speed 2mm/s --acceleration 0.1m/s2 -o motion.csv\n\
                  Then: preslide drive /dev/ttyACM0 play motion.csv -o axis.csv"
)]
pub struct Plan {
    /// Write the motion
    #[arg(short, long, value_name = "MOTION.csv")]
    output: PathBuf,

    /// How far it may go in all: 4mm, or 90deg with --rotary
    #[arg(long, value_name = "LENGTH", value_parser = quantity::positive_rate)]
    travel: f64,

    /// Largest speed: 2mm/s
    #[arg(long, value_name = "SPEED", value_parser = quantity::positive_rate)]
    speed: f64,

    /// Largest acceleration: 0.1m/s2
    #[arg(long, value_name = "ACCELERATION", value_parser = quantity::positive_rate)]
    acceleration: f64,

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
        let wish = Wish {
            travel: self.travel,
            speed: self.speed,
            acceleration: self.acceleration,
            smallest: self.smallest.unwrap_or(self.travel * 1e-3),
            show: match self.show {
                What::Presliding => Show::Presliding,
                What::Sliding => Show::Sliding,
                What::All => Show::All,
            },
            repeats: self.repeats,
            rate: self.rate,
        };
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
}
