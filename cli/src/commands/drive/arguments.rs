//! The arguments of the commands of `preslide drive`.

use super::super::parse_frequency;
use clap::{Args, ValueEnum};
use preslide_drive::quantity::{self, Quantity};
use std::path::PathBuf;

#[derive(Args)]
pub struct Move {
    /// By a distance
    #[arg(long, value_name = "LENGTH", value_parser = quantity::length, allow_hyphen_values = true, conflicts_with = "to", required_unless_present = "to")]
    pub by: Option<Quantity>,

    /// To a position
    #[arg(long, value_name = "LENGTH", value_parser = quantity::length, allow_hyphen_values = true)]
    pub to: Option<Quantity>,

    /// Speed [default: a fifth of limits.speed]
    #[arg(long, value_name = "SPEED", value_parser = |text: &str| quantity::positive(quantity::speed(text)))]
    pub speed: Option<Quantity>,

    /// Acceleration [default: a fifth of limits.acceleration]
    #[arg(long, value_name = "ACCELERATION", value_parser = |text: &str| quantity::positive(quantity::acceleration(text)))]
    pub acceleration: Option<Quantity>,
}

#[derive(Args)]
pub struct Jog {
    /// Speed, signed
    #[arg(value_name = "SPEED", value_parser = quantity::speed, allow_hyphen_values = true)]
    pub speed: Quantity,

    /// How long
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    pub seconds: f64,
}

#[derive(Args)]
pub struct Home {
    /// What marks the origin
    #[arg(long, value_name = "WHAT", default_value = "index")]
    pub mark: MarkArg,

    /// Speed on the way, signed [default: a tenth of limits.speed, backward]
    #[arg(long, value_name = "SPEED", value_parser = quantity::speed, allow_hyphen_values = true)]
    pub speed: Option<Quantity>,

    /// Position of the mark
    #[arg(long, value_name = "LENGTH", default_value = "0", value_parser = quantity::length, allow_hyphen_values = true)]
    pub position: Quantity,

    /// How far to move back from a stop [default: ten times watch.following_error]
    #[arg(long, value_name = "LENGTH", value_parser = quantity::length)]
    pub back_off: Option<Quantity>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum MarkArg {
    /// The encoder's index pulse
    Index,
    /// A mechanical stop, reached slowly
    Stop,
}

#[derive(Args)]
pub struct PlayArgs {
    /// Columns t_s and x_m (or q_rad); `preslide plan` writes one
    #[arg(value_name = "MOTION.csv")]
    pub motion: PathBuf,

    /// Write the recording
    #[arg(short, long, value_name = "REC.csv")]
    pub output: PathBuf,

    /// Replace the recording if it exists
    #[arg(long)]
    pub overwrite: bool,

    /// Positions count from the axis's origin, not from where the axis stands
    #[arg(long)]
    pub absolute: bool,

    /// Rows of the recording per second
    #[arg(long, value_name = "HZ", default_value = "1kHz", value_parser = parse_frequency)]
    pub rate: f64,

    /// Write how closely the axis followed, and what is missing, as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}
