//! `preslide drive`.

pub mod arguments;
mod play;

use super::{AxisArgs, Failure, of_kind};
use arguments::{Home, Jog, MarkArg, Move, PlayArgs};
use clap::{Args, Subcommand};
use preslide_drive::quantity::{self, Quantity};
use preslide_drive::{BAUD, Drive as Session, DriveError, open, screen, words};
use preslide_fit::model::{Model, key_of};
use preslide_fit::recording::MotionKind;
use preslide_fit::report::{figures, units::name_and_unit};
use preslide_host::drive::loadable;
use preslide_host::export::bounded_terms;
use preslide_link::{GainSettings, Homing, Mark, Mode, Name, Request};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Command a running controller: enable, move, stop, home, play a motion while recording, load a model, save
///
/// Without a command it opens a terminal that shows the axis; the space bar stops it there, Ctrl-C everywhere. The axis is disabled
/// after every reset. A controller that hears nothing for its parameter `silence` stops a moving axis.
#[derive(Args)]
#[command(
    after_help = "Example: preslide drive /dev/ttyACM0\n         preslide drive /dev/ttyACM0 enable\n         preslide drive /dev/ttyACM0 move --by 1.5mm --speed 5mm/s\n         \
                  preslide drive tcp:127.0.0.1:7700 play motion.csv -o axis.csv\n\nLengths are m, or end in mm, um, nm; on a rotary axis rad, mrad, deg."
)]
pub struct Drive {
    #[command(flatten)]
    controller: ControllerArgs,

    #[command(subcommand)]
    command: Option<What>,
}

/// Which controller.
#[derive(Args, Clone, Debug)]
pub struct ControllerArgs {
    /// A serial device's path, or tcp:HOST:PORT
    #[arg(value_name = "PORT")]
    port: String,

    /// The serial line's speed
    #[arg(long, value_name = "BAUD", default_value_t = BAUD)]
    baud: u32,

    /// Try to connect for this many seconds
    #[arg(long, value_name = "S", default_value_t = 0)]
    wait: u64,

    /// The axis turns: lengths are angles in rad
    #[arg(long)]
    pub rotary: bool,
}

#[derive(Subcommand)]
enum What {
    /// Show the controller's state and the cause of its reset
    State,
    /// Close the loop and hold the position
    Enable,
    /// Stop, then open the bridge
    Disable,
    /// Brake within the limits and drop what is queued
    Stop,
    /// Acknowledge a fault; the axis stays disabled
    Acknowledge,
    /// Move, and wait until the axis stands still
    Move(Move),
    /// Move at a speed for a time, then stop
    Jog(Jog),
    /// Find the origin
    Home(Home),
    /// Set the axis's present position, without moving it
    Zero {
        /// The position to set
        #[arg(value_name = "POSITION", default_value = "0", value_parser = quantity::length, allow_hyphen_values = true)]
        position: Quantity,
    },
    /// Show parameters
    Get {
        /// Names; all if none is given
        #[arg(value_name = "NAME")]
        names: Vec<String>,
    },
    /// Compare the controller's parameters with an axis.toml: what differs, and the command that sets it
    Compare {
        #[command(flatten)]
        axis: AxisArgs,
    },
    /// Set parameters (SI): set gains.derivative=600 limits.speed=0.01
    Set {
        /// What to set
        #[arg(value_name = "NAME=VALUE", required = true)]
        pairs: Vec<String>,
    },
    /// Set the feedback's gains (SI) without a bump
    Gains {
        /// K_p in N/m
        proportional: f32,
        /// K_i in N/(m·s)
        integral: f32,
        /// K_d in N·s/m
        derivative: f32,
    },
    /// Load a friction model without a bump; its effects too, where the firmware was built for a model that has them
    Load {
        /// A model that identify or diagnose wrote
        #[arg(value_name = "MODEL.toml")]
        model: PathBuf,
    },
    /// Play a motion through the controller's buffer while recording
    Play(PlayArgs),
    /// Keep parameters and friction model over a reset; the axis must be disabled
    Save,
    /// Forget what was saved: from the next reset the compiled-in values apply
    Forget,
}

/// Samples of telemetry in a row of the recording: together with 1 kHz, what a serial line carries.
const SAMPLES_PER_ROW: f64 = 2.0;

impl From<DriveError> for Failure {
    fn from(error: DriveError) -> Self {
        let text = error.to_string();
        match error {
            DriveError::Line(_) | DriveError::Silent { .. } | DriveError::Answer(_) => {
                Failure::Tool(text)
            }
            DriveError::Fault(_)
            | DriveError::Dry(_)
            | DriveError::Disabled
            | DriveError::Stopped => Failure::Data(text),
            _ => Failure::Input(text),
        }
    }
}

/// Set by Ctrl-C. The axis is stopped before the program ends.
fn stop_flag() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&flag);
    ctrlc::set_handler(move || set.store(true, Ordering::Relaxed))
        .map_err(|error| Failure::Tool(format!("Ctrl-C cannot be caught: {error}")))?;
    Ok(flag)
}

impl Drive {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        if let Some(command) = &self.command {
            of_kind(self.controller.rotary, &command.quantities())?;
        }
        let session = self.controller.session()?;
        match self.command {
            None => Ok(screen::run(session, self.controller.kind().unit())?),
            Some(command) => Commanded::new(session, &self.controller)?.carry_out(command),
        }
    }
}

impl What {
    /// What it has with a unit, by its option.
    fn quantities(&self) -> Vec<(&'static str, Option<&Quantity>)> {
        match self {
            Self::Move(to) => vec![
                ("--by", to.by.as_ref()),
                ("--to", to.to.as_ref()),
                ("--speed", to.speed.as_ref()),
                ("--acceleration", to.acceleration.as_ref()),
            ],
            Self::Jog(jog) => vec![("SPEED", Some(&jog.speed))],
            Self::Home(home) => vec![
                ("--speed", home.speed.as_ref()),
                ("--position", Some(&home.position)),
                ("--back-off", home.back_off.as_ref()),
            ],
            Self::Zero { position } => vec![("POSITION", Some(position))],
            _ => Vec::new(),
        }
    }
}

impl ControllerArgs {
    fn session(&self) -> Result<Session, Failure> {
        let line = open(&self.port, self.baud, Duration::from_secs(self.wait))?;
        Ok(Session::begin(line)?)
    }

    fn kind(&self) -> MotionKind {
        MotionKind::turning(self.rotary)
    }

    /// The axis behind it.
    pub fn begin(&self) -> Result<Commanded, Failure> {
        Commanded::new(self.session()?, self)
    }
}

/// The axis, commanded.
pub struct Commanded {
    /// The conversation.
    pub drive: Session,
    /// Set by Ctrl-C, and by anyone who wants it to stop.
    pub stop: Arc<AtomicBool>,
    /// Whether it turns.
    pub kind: MotionKind,
    /// As it was given.
    pub port: String,
}

impl Commanded {
    fn new(drive: Session, controller: &ControllerArgs) -> Result<Self, Failure> {
        Ok(Self {
            drive,
            stop: stop_flag()?,
            kind: controller.kind(),
            port: controller.port.clone(),
        })
    }

    fn carry_out(&mut self, command: What) -> Result<(), Failure> {
        match command {
            What::State => self.tell_state(),
            What::Enable => self.simple(Request::Enable, "enabled: the axis holds its position"),
            What::Disable => self.disable(),
            What::Stop => {
                self.drive.stop()?;
                self.stands()
            }
            What::Acknowledge => {
                self.simple(Request::Acknowledge, "acknowledged; the axis is disabled")
            }
            What::Move(to) => self.go(&to),
            What::Jog(jog) => self.jog(&jog),
            What::Home(home) => self.home(&home),
            What::Zero { position } => {
                let position_m = position.value as f32;
                self.simple(
                    Request::Zero { position_m },
                    "the axis is located: its travel has ends",
                )
            }
            What::Get { names } => self.get(&names),
            What::Compare { axis } => self.compare(&axis),
            What::Set { pairs } => self.set(&pairs),
            What::Gains {
                proportional,
                integral,
                derivative,
            } => self.simple(
                Request::Gains(GainSettings {
                    proportional,
                    integral,
                    derivative,
                }),
                "gains set; `save` keeps them over a reset",
            ),
            What::Load { model } => {
                self.load(&model)?;
                say!(
                    "Next: preslide drive {} play motion.csv -o after.csv; `save` keeps the model over a reset",
                    self.port
                );
                Ok(())
            }
            What::Play(play) => {
                self.play(&play)?;
                say!(
                    "Next: preslide identify {} -o model.toml",
                    play.output.display()
                );
                Ok(())
            }
            What::Save => self.simple(Request::Save, "saved"),
            What::Forget => self.simple(Request::Forget, "forgotten"),
        }
    }

    fn simple(&mut self, request: Request, done: &str) -> Result<(), Failure> {
        self.drive.ask(request)?;
        say!("{done}");
        Ok(())
    }

    fn tell_state(&mut self) -> Result<(), Failure> {
        let state = self.drive.state()?;
        let identity = *self.drive.identity();
        for line in words::state(&state, identity.count, identity.rate_hz, self.kind.unit()) {
            say!("{line}");
        }
        let saved = if identity.saved {
            "saved"
        } else {
            "compiled in"
        };
        say!("settings  as {saved}; {} Hz", identity.rate_hz);
        Ok(())
    }

    /// Waits until the axis stands; Ctrl-C stops it.
    fn stands(&mut self) -> Result<(), Failure> {
        let stop = Arc::clone(&self.stop);
        let state = self.drive.wait(|| stop.load(Ordering::Relaxed))?;
        let position = state.position as f64 * self.drive.identity().count;
        say!("stands at {}", quantity::shown(position, self.kind.unit()));
        Ok(())
    }

    /// Stops, then opens the bridge.
    pub fn disable(&mut self) -> Result<(), Failure> {
        self.drive.ask(Request::Disable)?;
        while self.drive.state()?.mode != Mode::Disabled {
            self.drive.listen(Duration::from_millis(20))?;
        }
        say!("disabled: the bridge is open");
        Ok(())
    }

    /// A parameter that every controller reports.
    pub fn limit(&mut self, name: &str) -> Result<f64, Failure> {
        let value = self.drive.get(name)?;
        value.ok_or_else(|| Failure::Tool(format!("the controller does not report {name}")))
    }

    /// Moves, and waits until the axis stands.
    pub fn go(&mut self, to: &Move) -> Result<(), Failure> {
        let speed = match &to.speed {
            Some(speed) => speed.value,
            None => 0.2 * self.limit("limits.speed")?,
        };
        let acceleration = match &to.acceleration {
            Some(acceleration) => acceleration.value,
            None => 0.2 * self.limit("limits.acceleration")?,
        };
        let (speed_m_s, ramp_s) = (speed as f32, (speed / acceleration) as f32);
        let request = match (&to.by, &to.to) {
            (Some(by), _) => Request::Move {
                distance_m: by.value as f32,
                speed_m_s,
                ramp_s,
            },
            (None, to) => Request::MoveTo {
                position_m: to.as_ref().map_or(0.0, |to| to.value) as f32,
                speed_m_s,
                ramp_s,
            },
        };
        self.drive.insist(request)?;
        self.stands()
    }

    fn jog(&mut self, jog: &Jog) -> Result<(), Failure> {
        let speed_m_s = jog.speed.value as f32;
        self.drive.ask(Request::Jog { speed_m_s })?;
        let start = Instant::now();
        while start.elapsed().as_secs_f64() < jog.seconds && !self.stop.load(Ordering::Relaxed) {
            let state = self.drive.state()?;
            if let Some(fault) = state.fault {
                return Err(DriveError::Fault(fault).into());
            }
            self.drive.listen(Duration::from_millis(20))?;
        }
        self.drive.stop()?;
        self.stands()
    }

    /// Finds the origin.
    pub fn home(&mut self, home: &Home) -> Result<(), Failure> {
        let speed = match &home.speed {
            Some(speed) => speed.value,
            None => -0.1 * self.limit("limits.speed")?,
        };
        let back_off = match (home.mark, &home.back_off) {
            (MarkArg::Index, _) => 0.0,
            (MarkArg::Stop, Some(length)) => length.value,
            (MarkArg::Stop, None) => 10.0 * self.limit("watch.following_error")?,
        };
        self.drive.ask(Request::Home(Homing {
            mark: match home.mark {
                MarkArg::Index => Mark::Index,
                MarkArg::Stop => Mark::Stop,
            },
            speed_m_s: speed as f32,
            position_m: home.position.value as f32,
            back_off_m: back_off as f32,
        }))?;
        self.stands()?;
        if self.drive.state()?.located {
            say!("homed: positions count from the axis's origin, and its travel has ends");
            Ok(())
        } else {
            Err(Failure::Data(
                "the origin was not found; check the index's wiring, or home with --mark stop if the travel has a stop on that side"
                    .to_owned(),
            ))
        }
    }

    fn get(&mut self, names: &[String]) -> Result<(), Failure> {
        // In SI, as `set` takes it.
        let unit = self.kind.unit();
        let tell = |name: &str, value: f32| {
            let unit = quantity::of_parameter(name, unit);
            say!("{}", format!("{name:<24} {value:e} {unit}").trim_end());
        };
        if names.is_empty() {
            for parameter in self.drive.parameters()? {
                tell(parameter.name.as_str(), parameter.value);
            }
        }
        for name in names {
            let value = self.drive.get(name)?;
            tell(
                name,
                value.ok_or_else(|| Failure::Input(unknown(name)))? as f32,
            );
        }
        Ok(())
    }

    fn compare(&mut self, axis: &AxisArgs) -> Result<(), Failure> {
        let file = axis.read()?;
        let mut different = Vec::new();
        for parameter in self.drive.parameters()? {
            let name = parameter.name.as_str();
            let Some(wanted) = file.value(name) else {
                continue;
            };
            // In the precision of the link.
            if parameter.value != wanted as f32 {
                let unit = quantity::of_parameter(name, self.kind.unit());
                say!(
                    "{name:<24} {:e} {unit}, in the file {wanted:e} {unit}",
                    parameter.value
                );
                different.push(format!("{name}={wanted:e}"));
            }
        }
        let identity = self.drive.identity();
        let described = file.axis();
        if identity.count != described.encoder.count
            || identity.rate_hz != described.hardware.rate_hz
        {
            return Err(Failure::Data(format!(
                "the controller has {:e} {} a count and {} Hz, the file {:e} and {} Hz: these are compiled in: build the firmware with that file",
                identity.count,
                self.kind.unit(),
                identity.rate_hz,
                described.encoder.count,
                described.hardware.rate_hz
            )));
        }
        if different.is_empty() {
            say!("every parameter is as in the file");
        } else {
            let (port, pairs) = (&self.port, different.join(" "));
            say!("Next, disabled: preslide drive {port} set {pairs}");
        }
        Ok(())
    }

    fn set(&mut self, pairs: &[String]) -> Result<(), Failure> {
        // All are read before the first is sent.
        let read = |pair: &String| {
            let (name, value) = pair.split_once('=')?;
            Some((Name::new(name.trim())?, value.trim().parse::<f32>().ok()?))
        };
        let mut read_pairs = Vec::new();
        for pair in pairs {
            let found = read(pair).ok_or_else(|| {
                Failure::Input(format!(
                    "`{pair}`: give NAME=VALUE in SI, such as gains.derivative=600"
                ))
            })?;
            if self.drive.get(found.0.as_str())?.is_none() {
                return Err(Failure::Input(unknown(found.0.as_str())));
            }
            read_pairs.push(found);
        }
        for (name, value) in read_pairs {
            self.drive.ask(Request::Set(name, value))?;
            say!("{:<24} {value:e}", name.as_str());
        }
        Ok(())
    }

    /// Loads a model file.
    pub fn load(&mut self, path: &std::path::Path) -> Result<(), Failure> {
        let model = Model::load(path)?;
        let layout = self.drive.identity().model;
        let loaded = loadable(&model, layout)
            .map_err(|reason| Failure::Input(format!("{}: {reason}", path.display())))?;
        let values: Vec<f64> = loaded.parameters.iter().map(|p| p.1).collect();
        let named = loaded.parameters.iter();
        let named: Vec<String> = named
            .map(|(key, value)| {
                // A block's has no unit in the layout's name.
                let key = key.replace("stiffness", "stiffness_N_per_m");
                let (name, unit) = name_and_unit(&key_of(model.motion, &key), "N");
                format!("{name} {}", figures::quantity(*value, &unit))
            })
            .collect();
        let named = named.join(", ");
        self.drive
            .load(layout, &values)
            .map_err(|error| match &error {
                DriveError::Refused { .. } => {
                    Failure::Input(format!("{}: {error}; sent were {named}", path.display()))
                }
                _ => error.into(),
            })?;
        explain!("loaded: {named}");
        let own = model.friction.blocks().len();
        if let Some(sent) = loaded.blocks.filter(|sent| own < *sent) {
            say!(
                "Note: this firmware has {sent} blocks: the model's {own} are sent in equal parts, which make the same force."
            );
        }
        if loaded.deviation > 1e-6 {
            say!(
                "Note: this firmware has four blocks; joining them changes the force by up to {:.1} % of the breakaway force. \
                 Firmware built by `preslide export` and PRESLIDE_MODEL takes all.",
                100.0 * loaded.deviation
            );
        }
        let bounded = match loaded.blocks {
            None => bounded_terms(&model),
            Some(_) => Vec::new(),
        };
        if !bounded.is_empty() {
            say!(
                "Note: the bounds of {} stay those that the firmware was compiled with (FORCE_LIMIT, LEVEL_LIMIT of its source), whatever is loaded.",
                bounded.join(", ")
            );
        }
        if !loaded.left_out.is_empty() {
            say!(
                "Note: not sent: {}; firmware built by `preslide export` and PRESLIDE_MODEL takes what a controller can use.",
                loaded.left_out.join(", ")
            );
        }
        Ok(())
    }
}

/// A name that the controller does not know.
fn unknown(name: &str) -> String {
    format!("there is no parameter `{name}`; `preslide drive PORT get` lists them")
}
