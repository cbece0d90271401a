//! `preslide plan`.

use super::{
    AxisArgs, Failure, OutputArgs, command_line, of_kind, outputs, parse_frequency, write_text,
};
use clap::{Args, ValueEnum};
use preslide_drive::quantity::{self, Quantity};
use preslide_fit::recording::MotionKind;
use preslide_fit::report::figures;
use preslide_host::plan::{Show, Wish, plan};
use std::path::PathBuf;

/// Write a motion that shows friction: nested reversals from different places, passes at several speeds
///
/// It begins and ends at 0 and stays within ± half of the travel. Without --axis, travel, speed and acceleration must be given.
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

    #[command(flatten)]
    wish: WishArgs,

    /// What to show
    #[arg(long, value_name = "WHAT", default_value = "all")]
    show: What,

    /// Rows per second
    #[arg(long, value_name = "HZ", default_value = "400Hz", value_parser = parse_frequency)]
    rate: f64,

    /// The axis turns: lengths are angles, in rad or with deg
    #[arg(long)]
    rotary: bool,

    #[command(flatten)]
    outputs: OutputArgs,
}

/// How far, how fast and how often.
#[derive(Args, Clone, Debug)]
pub struct WishArgs {
    /// Whole travel: 4mm, or 90deg with --rotary [default: four fifths of the axis's, if it is known]
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    travel: Option<Quantity>,

    /// Largest speed: 2mm/s, or 90deg/s or 15rpm with --rotary [default: half of the axis's limit, if it is known]
    #[arg(long, value_name = "SPEED", value_parser = speed)]
    speed: Option<Quantity>,

    /// Largest acceleration: 0.1m/s2, or 720deg/s2 with --rotary [default: half of the axis's limit, if it is known]
    #[arg(long, value_name = "ACCELERATION", value_parser = acceleration)]
    acceleration: Option<Quantity>,

    /// Least stroke between two reversals, some dozens of encoder counts; strokes shrink by 0.55, so the smallest is up to 1.8 times
    /// that [default: a thousandth of the travel]
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    smallest: Option<Quantity>,

    /// Repeats, which identify holds out in turn
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: u32,
}

/// A motion's length or speed is given with its unit: a bare 4 was meant in mm as often as in m.
fn stated<'a>(text: &'a str, per: &str) -> Result<&'a str, String> {
    match text.trim().parse::<f64>() {
        Ok(_) => Err(format!(
            "`{text}` has no unit; give {text}mm{per}, {text}m{per} or, with --rotary, {text}deg{per}"
        )),
        Err(_) => Ok(text),
    }
}

fn length(text: &str) -> Result<Quantity, String> {
    stated(text, "").and_then(quantity::positive_length)
}

fn speed(text: &str) -> Result<Quantity, String> {
    quantity::positive(stated(text, "/s").and_then(quantity::speed))
}

fn acceleration(text: &str) -> Result<Quantity, String> {
    quantity::positive(stated(text, "/s2").and_then(quantity::acceleration))
}

impl WishArgs {
    /// Sees to it that its units are of an axis that turns or does not.
    pub fn check(&self, rotary: bool) -> Result<(), Failure> {
        let given = [
            ("--travel", self.travel.as_ref()),
            ("--speed", self.speed.as_ref()),
            ("--acceleration", self.acceleration.as_ref()),
            ("--smallest", self.smallest.as_ref()),
        ];
        of_kind(rotary, &given)
    }

    /// On an axis of such a length (m or rad), where it has ends, with such a top speed and acceleration. Where those are the axis's own, what
    /// its controller would refuse is refused, all of it at once.
    pub fn wish(
        &self,
        length: Option<f64>,
        [speed, acceleration]: [f64; 2],
        are_its_own: bool,
    ) -> Result<Wish, Failure> {
        let value = |given: &Option<Quantity>| given.as_ref().map(|given| given.value);
        let (given, top) = (value(&self.travel), value(&self.speed));
        let ramp = value(&self.acceleration);
        let asked = [
            ("travel", given, length, "the axis's travel"),
            ("speed", top, Some(speed), "limits.speed"),
            (
                "acceleration",
                ramp,
                Some(acceleration),
                "limits.acceleration",
            ),
        ];
        let beyond = asked.iter().filter_map(|(name, asked, limit, of)| {
            let (asked, limit) = ((*asked)?, (*limit)?);
            (are_its_own && asked > limit)
                .then(|| format!("--{name} {asked:e} exceeds {of}, {limit:e}"))
        });
        let mut wrong: Vec<String> = beyond.collect();
        let travel = given.or(length.map(|length| 0.8 * length));
        if travel.is_none() {
            wrong.push("the ends of the axis's travel are not known; give --travel".to_owned());
        }
        let (Some(travel), []) = (travel, wrong.as_slice()) else {
            return Err(Failure::Input(wrong.join("\n")));
        };
        Ok(Wish {
            travel,
            speed: top.unwrap_or(0.5 * speed),
            acceleration: ramp.unwrap_or(0.5 * acceleration),
            smallest: value(&self.smallest).unwrap_or(1e-3 * travel),
            show: Show::All,
            repeats: self.repeats,
            rate: RATE_HZ,
        })
    }
}

/// Rows a second of a motion, by default.
const RATE_HZ: f64 = 400.0;

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
    /// Without an axis of the user's nothing is known of its limits: those of another would drive a shorter one into its stop.
    fn check_limits(&self) -> Result<(), Failure> {
        let needed = [
            ("--travel 4mm", "--travel 90deg", &self.wish.travel),
            ("--speed 2mm/s", "--speed 90deg/s", &self.wish.speed),
            (
                "--acceleration 0.1m/s2",
                "--acceleration 720deg/s2",
                &self.wish.acceleration,
            ),
        ];
        let missing = needed.iter().filter(|(_, _, given)| given.is_none());
        let missing =
            missing.map(|(linear, rotary, _)| if self.rotary { *rotary } else { *linear });
        let missing: Vec<&str> = missing.collect();
        match self.axis.chosen().is_some() || missing.is_empty() {
            true => Ok(()),
            false => Err(Failure::Input(format!(
                "the limits of the axis are not known; give them, such as {}, or --axis AXIS.toml",
                missing.join(" ")
            ))),
        }
    }

    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        self.check_limits()?;
        self.wish.check(self.rotary)?;
        let limits = self.axis.read()?.axis().limits;
        let length = limits.travel.map(|(low, high)| high - low);
        let top = [limits.speed, limits.acceleration];
        let kind = MotionKind::turning(self.rotary);
        let wish = Wish {
            show: match self.show {
                What::Presliding => Show::Presliding,
                What::Sliding => Show::Sliding,
                What::All => Show::All,
            },
            rate: self.rate,
            ..self.wish.wish(length, top, self.axis.chosen().is_some())?
        };
        outputs::check(
            &self.axis.file(),
            &[("-o", Some(&self.output))],
            Some(&self.outputs),
        )?;
        if let Some(file) = self.axis.chosen() {
            let unit = kind.unit();
            let travel =
                length.map(|length| format!("travel {}, ", figures::quantity(length, unit)));
            say!(
                "Limits of {}: {}speed {}, acceleration {}.",
                file.display(),
                travel.unwrap_or_default(),
                figures::quantity(limits.speed, &format!("{unit}/s")),
                figures::quantity(limits.acceleration, &format!("{unit}/s²"))
            );
        }
        let planned = plan(&wish).map_err(Failure::Input)?;
        write_text(&self.output, &planned.csv(kind))?;
        say!("{}", planned.words(kind));
        self.outputs.write(&planned.to_json(kind), || {
            planned.page(kind, command_line())
        })?;
        say!(
            "Next: preslide drive PORT play {} -o axis.csv",
            self.output.display()
        );
        Ok(())
    }
}
