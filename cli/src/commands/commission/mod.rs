//! `preslide commission`.

mod findings;
mod journal;
mod page;

use super::drive::arguments::{Home, MarkArg, Move, PlayArgs};
use super::drive::{Commanded, ControllerArgs};
use super::plan::WishArgs;
use super::{Failure, command_line};
use crate::heard::ask;
use clap::{Args, ValueEnum};
use findings::Findings;
use journal::{Asked, Journal, Played};
use preslide_drive::SpaceBar;
use preslide_fit::model::Model;
use preslide_fit::report::figures::duration;
use preslide_host::diagnose::experiment::Experiment;
use preslide_host::plan::{Plan, Show, Wish, plan};
use preslide_link::{Mode, Name, Request};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Commission an axis: from just switched on to friction compensated
///
/// It finds direction and moving mass with small moves, plays a motion, identifies and diagnoses it, plays experiments while
/// something is in doubt, loads the model, and shows the gain on a motion that no fit saw. The space bar or Ctrl-C stops the axis; the
/// same command resumes. Nothing is kept over a reset unless you say yes.
#[derive(Args)]
#[command(
    after_help = "Example: preslide commission /dev/ttyACM0 --travel 4mm\n         preslide commission tcp:127.0.0.1:7700 --travel 1mm --dry\n\n\
                  Defaults come from the controller's limits. The link carries no effects of a diagnosis: the page names the command that \
                  compiles them in."
)]
pub struct Commission {
    #[command(flatten)]
    controller: ControllerArgs,

    /// Folder for recordings, models and the page
    #[arg(short, long, value_name = "FOLDER", default_value = "commission")]
    output: PathBuf,

    /// What marks the origin
    #[arg(long, value_name = "WHAT", default_value = "index")]
    home: Origin,

    #[command(flatten)]
    wish: WishArgs,

    /// Play at most this many experiments while something is in doubt
    #[arg(long, value_name = "N", default_value_t = 3)]
    experiments: usize,

    /// Keep the result over a reset without asking
    #[arg(long)]
    save: bool,

    /// Print the plan and move nothing
    #[arg(long)]
    dry: bool,
}

/// What marks the origin.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Origin {
    /// The encoder's index pulse
    Index,
    /// A mechanical stop, reached slowly
    Stop,
    /// Nothing: the motion is centred on where the axis stands; needs --travel
    None,
}

/// Rows a second of a recording.
const ROWS_HZ: f64 = 1000.0;
/// Counts of the first move, there and back: a motor that is wired the wrong way runs from it no further than the following error allows.
const NUDGE_COUNTS: f64 = 20.0;
/// Shares of travel, speed and acceleration of the careful motion.
const CAREFUL: [f64; 3] = [0.2, 0.2, 0.5];
/// The same of the motion that no fit sees, and its smallest stroke over the other's: no stroke of it was made before.
const UNSEEN: [f64; 3] = [0.83, 0.7, 0.8];
const UNSEEN_SMALLEST: f64 = 1.7;

/// What the axis shall do.
struct Bounds {
    wish: Wish,
    /// The middle of the travel, of an axis that is to be located.
    middle: Option<f64>,
    count: f64,
}

impl Commission {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        self.wish.check(self.controller.rotary)?;
        let mut axis = self.controller.begin()?;
        let bounds = self.bounds(&mut axis)?;
        let motions = Motions::of(&bounds)?;
        self.announce(&motions);
        if self.dry {
            return Ok(());
        }
        let mut journal = Journal::open(&self.output, bounds.in_words(axis.kind.unit()))?;
        let keys = SpaceBar::stops(&axis.stop);
        // Where a link was pulled, the controller still has what a stage set.
        let found_share = match journal.share {
            Some(share) => share,
            None => axis.limit("feed_forward.share")?,
        };
        journal.share = Some(found_share);
        journal.keep()?;
        let mut run = Run {
            axis,
            journal,
            motions,
            middle: 0.0,
            stage: String::new(),
        };
        let done = run.all(&self, &bounds);
        let ended = run.end(done.is_err().then_some(found_share));
        let findings = done.map_err(|failure| self.interrupted(failure, &run.stage, &ended))?;
        ended?;
        run.report(&findings)?;
        self.keep(&mut run.axis, keys.as_ref())
    }

    /// From the options and the controller's own limits; reports everything wrong at once.
    fn bounds(&self, axis: &mut Commanded) -> Result<Bounds, Failure> {
        let ends = (
            axis.drive.get("limits.travel_low")?,
            axis.drive.get("limits.travel_high")?,
        );
        let ends = ends.0.zip(ends.1).filter(|_| self.home != Origin::None);
        let length = ends.map(|(low, high)| high - low);
        let top = [
            axis.limit("limits.speed")?,
            axis.limit("limits.acceleration")?,
        ];
        Ok(Bounds {
            wish: self.wish.wish(length, top, true)?,
            middle: ends.map(|(low, high)| 0.5 * (low + high)),
            count: axis.drive.identity().count,
        })
    }

    fn announce(&self, motions: &Motions) {
        let seconds = |plan: &Plan| duration(plan.seconds());
        say!(
            "1. enable, a nudge of {NUDGE_COUNTS} counts, {}",
            self.home_words()
        );
        say!(
            "2. a careful motion of {}: direction, moving mass",
            seconds(&motions.careful)
        );
        say!(
            "3. a motion of {}, the feedback alone: identify, diagnose",
            seconds(&motions.first)
        );
        say!(
            "4. while something is in doubt, an experiment, each announced: {} at most",
            self.experiments
        );
        say!(
            "5. load the model; a motion of {} that no fit saw, without the model and with it",
            seconds(&motions.unseen)
        );
        say!(
            "6. the page, {}\n",
            self.output.join("report.html").display()
        );
    }

    fn home_words(&self) -> &'static str {
        match self.home {
            Origin::Index => "find the encoder's index",
            Origin::Stop => "find a mechanical stop",
            Origin::None => "no origin: all motions are centred on where the axis stands",
        }
    }

    /// What to do about a commissioning that ended early.
    fn interrupted(&self, failure: Failure, stage: &str, ended: &Result<(), Failure>) -> Failure {
        let axis = match ended {
            Ok(()) => "The axis is disabled".to_owned(),
            Err(reason) => format!(
                "The axis could not be disabled ({}): a controller that hears nothing stops it after its `silence` and holds it; check cable and supply",
                reason.message()
            ),
        };
        let next = format!(
            "in stage `{stage}`: {}\n{axis}. The recordings so far are in {}; the same command goes on from there",
            failure.message(),
            self.output.display()
        );
        match failure {
            Failure::Tool(_) => Failure::Tool(next),
            Failure::Input(_) => Failure::Input(next),
            Failure::Data(_) => Failure::Data(next),
        }
    }

    /// Asks whether parameters and model are to be kept over a reset.
    fn keep(&self, axis: &mut Commanded, keys: Option<&SpaceBar>) -> Result<(), Failure> {
        let says_yes = || {
            let Some(keys) = keys else { return false };
            ask("Keep parameters and model over a reset? [y/N] ");
            let key = keys.next();
            ask("\n");
            key.is_some_and(|key| key.eq_ignore_ascii_case(&'y'))
        };
        if !self.save && !says_yes() {
            say!(
                "Not kept over a reset. Next: preslide drive {} save",
                axis.port
            );
            return Ok(());
        }
        axis.drive.ask(Request::Save)?;
        say!(
            "Kept over a reset. The axis is disabled. Next: preslide drive {} enable",
            axis.port
        );
        Ok(())
    }
}

impl Bounds {
    /// What makes it the same commissioning.
    fn in_words(&self, unit: &str) -> String {
        let Wish {
            travel,
            speed,
            acceleration,
            smallest,
            repeats,
            ..
        } = self.wish;
        format!(
            "{:e} {unit} a count, travel {travel:e}, speed {speed:e}, acceleration {acceleration:e}, smallest stroke {smallest:e}, {repeats} repeats",
            self.count
        )
    }
}

/// The motions that are known beforehand.
struct Motions {
    careful: Plan,
    first: Plan,
    unseen: Plan,
}

impl Motions {
    fn of(bounds: &Bounds) -> Result<Self, Failure> {
        let wish = bounds.wish;
        let scaled = |[travel, speed, acceleration]: [f64; 3]| Wish {
            travel: travel * wish.travel,
            speed: speed * wish.speed,
            acceleration: acceleration * wish.acceleration,
            smallest: travel * wish.smallest,
            repeats: 1,
            ..wish
        };
        let careful = Wish {
            show: Show::Sliding,
            ..scaled(CAREFUL)
        };
        let unseen = scaled(UNSEEN);
        let unseen = Wish {
            // A nested stroke is a tenth of the travel at most.
            smallest: (UNSEEN_SMALLEST * wish.smallest).min(0.06 * unseen.travel),
            ..unseen
        };
        Ok(Self {
            careful: plan(&careful).map_err(Failure::Input)?,
            first: plan(&wish).map_err(Failure::Input)?,
            unseen: plan(&unseen).map_err(Failure::Input)?,
        })
    }
}

/// A commissioning under way.
struct Run {
    axis: Commanded,
    journal: Journal,
    motions: Motions,
    /// Where every motion begins, as the controller counts (m or rad): the middle of the travel, or where an axis without an origin stood.
    middle: f64,
    /// What is going on, for who reads of an early end.
    stage: String,
}

impl Run {
    fn all(&mut self, asked: &Commission, bounds: &Bounds) -> Result<Findings, Failure> {
        self.begin(asked, bounds)?;
        for (name, plan) in [
            ("careful", &self.motions.careful),
            ("before", &self.motions.first),
            ("unseen-without", &self.motions.unseen),
            ("unseen-with", &self.motions.unseen),
        ] {
            self.journal.write_motion(name, &plan.csv(self.axis.kind))?;
        }
        self.careful()?;
        self.play("before", 0.0)?;
        let findings = self.experiments(asked.experiments)?;
        self.load(&findings)?;
        self.play("unseen-without", 0.0)?;
        self.play("unseen-with", 1.0)?;
        Ok(findings)
    }

    /// Enabled, moved by hardly anything, and located.
    fn begin(&mut self, asked: &Commission, bounds: &Bounds) -> Result<(), Failure> {
        self.stage = "enable, nudge".to_owned();
        let mut state = self.axis.drive.state()?;
        if let Some(fault) = state.fault {
            return Err(Failure::Data(format!(
                "the axis has a fault ({fault:?}); find out why, then: preslide drive {} acknowledge",
                self.axis.port
            )));
        }
        if state.mode == Mode::Disabled {
            self.axis.drive.ask(Request::Enable)?;
        } else {
            // What a link that was pulled left moving.
            self.axis.drive.stop()?;
            state = self.axis.drive.wait(|| false)?;
        }
        let nudge = NUDGE_COUNTS * bounds.count;
        for by in [nudge, -nudge] {
            self.go(by).map_err(|failure| match failure {
                Failure::Data(reason) => Failure::Data(format!(
                    "{reason}; at a move of {NUDGE_COUNTS} counts motor and encoder may have opposite signs: reverse one of them (`motor.reversed`, `encoder.reversed` of axis.toml), or raise gains that are too low to move the axis"
                )),
                other => other,
            })?;
        }
        if asked.home != Origin::None && !state.located {
            let mark = match asked.home {
                Origin::Stop => MarkArg::Stop,
                Origin::Index | Origin::None => MarkArg::Index,
            };
            self.stage = "home".to_owned();
            self.axis.home(&Home {
                mark,
                speed: None,
                position: 0.0.into(),
                back_off: None,
            })?;
        }
        self.middle = match bounds.middle {
            Some(middle) => middle,
            None => self.stands()?,
        };
        Ok(())
    }

    /// The controller's position (m or rad).
    fn stands(&mut self) -> Result<f64, Failure> {
        let count = self.axis.drive.identity().count;
        Ok(self.axis.drive.state()?.position as f64 * count)
    }

    fn go(&mut self, by: f64) -> Result<(), Failure> {
        self.axis.go(&Move {
            by: Some(by.into()),
            to: None,
            speed: None,
            acceleration: None,
        })
    }

    fn go_to(&mut self, position: f64) -> Result<(), Failure> {
        let by = position - self.stands()?;
        // What is no move is refused.
        match by.abs() < self.axis.drive.identity().count {
            true => Ok(()),
            false => self.go(by),
        }
    }

    /// Slow and short, to find whether effort and motion go together, and what moves.
    fn careful(&mut self) -> Result<(), Failure> {
        self.play("careful", 0.0)?;
        let path = self.journal.file("careful.csv");
        let (turned, weight) = findings::careful(&path)?;
        if turned {
            return Err(Failure::Data(format!(
                "{}: the recorded effort drives the axis backward; set `motor.reversed` of axis.toml, or the sign of the current sense",
                path.display()
            )));
        }
        match weight {
            Ok(weight) => say!("direction: correct; the axis moves {weight}"),
            Err(reason) => {
                say!("direction: correct; the moving mass is not known yet ({reason})")
            }
        }
        Ok(())
    }

    /// Plays what would decide the most costly doubt, until nothing is in doubt or as many were played as may be.
    fn experiments(&mut self, most: usize) -> Result<Findings, Failure> {
        self.stage = "identify, diagnose".to_owned();
        let mut findings = Findings::of(&self.journal.recordings())?;
        findings.say();
        while let Some(Asked { name, about, .. }) = self.next_experiment(&findings, most)? {
            self.play(&name, 0.0)?;
            let next = Findings::of(&self.journal.recordings())?;
            let answer = findings::answer(&findings, &next, &about);
            say!("{name}: {answer}");
            if let Some(asked) = self.journal.asked.last_mut() {
                asked.answer = Some(answer);
            }
            self.journal.keep()?;
            findings = next;
        }
        Ok(findings)
    }

    /// The experiment that was begun before, or the next one, announced and with its motion written; `None` where none is to be played.
    fn next_experiment(
        &mut self,
        findings: &Findings,
        most: usize,
    ) -> Result<Option<Asked>, Failure> {
        let begun = self.journal.asked.last();
        if let Some(begun) = begun.filter(|asked| asked.answer.is_none()) {
            return Ok(Some(begun.clone()));
        }
        if self.journal.asked.len() >= most {
            return Ok(None);
        }
        let Some(next) = Experiment::next(&findings.diagnosis, &self.journal.about()) else {
            say!("Nothing is in doubt that an experiment could decide.");
            return Ok(None);
        };
        let asked = Asked {
            name: format!("experiment-{}", self.journal.asked.len() + 1),
            about: next.about.iter().map(|id| (*id).to_owned()).collect(),
            answer: None,
        };
        say!(
            "{}: {}; it stays within the travel and the speeds of the first motion",
            asked.name,
            next.words()
        );
        let column = self.axis.kind.column();
        self.journal.write_motion(&asked.name, &next.csv(column))?;
        self.journal.asked.push(asked.clone());
        self.journal.keep()?;
        Ok(Some(asked))
    }

    /// Plays a motion that was written from the middle on, with a share of the feed-forward, unless it was played before.
    fn play(&mut self, name: &str, share: f64) -> Result<(), Failure> {
        self.stage = format!("play {name}");
        let output = self.journal.file(&format!("{name}.csv"));
        if self.journal.played.contains_key(name) {
            say!("{name}: recorded earlier, {}", output.display());
            return Ok(());
        }
        if self.axis.stop.load(Ordering::Relaxed) {
            return Err(preslide_drive::DriveError::Stopped.into());
        }
        self.go_to(self.middle)?;
        self.share(share)?;
        let (rms, largest) = self.axis.play(&PlayArgs {
            motion: self.journal.motion(name),
            output,
            overwrite: true,
            absolute: false,
            rate: ROWS_HZ,
            json: None,
        })?;
        self.journal
            .played
            .insert(name.to_owned(), Played { rms, largest });
        self.journal.keep()
    }

    /// Sets the share of the feed-forward, and waits until it acts fully: a motion that begins before is not followed as it will be.
    fn share(&mut self, share: f64) -> Result<(), Failure> {
        self.set("feed_forward.share", share)?;
        let fade = self.axis.limit("fade_time")?;
        Ok(self.axis.drive.listen(Duration::from_secs_f64(fade))?)
    }

    fn set(&mut self, name: &str, value: f64) -> Result<(), Failure> {
        let named =
            Name::new(name).ok_or_else(|| Failure::Tool(format!("the link knows no {name}")))?;
        self.axis.drive.ask(Request::Set(named, value as f32))?;
        Ok(())
    }

    /// Hysteresis and moving mass to the controller; the files know its encoder, which `tune` asks for.
    fn load(&mut self, findings: &Findings) -> Result<(), Failure> {
        self.stage = "load".to_owned();
        let remarks = [findings.diagnosis.verdict_words(&findings.recording)];
        let count = self.axis.drive.identity().count;
        let write = |name: &str, model: Model| {
            let model = model.with_count(count);
            self.journal.write(name, &model.to_toml(&remarks))
        };
        write("extended.toml", findings.extended())?;
        let model = findings.loadable()?;
        let path = write("model.toml", model.clone())?;
        self.axis.load(&path)?;
        if model.inertia > 0.0 {
            self.set("feed_forward.mass", model.inertia)?;
        }
        Ok(())
    }

    /// Leaves the axis disabled, where it did not come to an end with the share of the feed-forward that it had. A model that was loaded stays until
    /// the next reset.
    fn end(&mut self, share: Option<f64>) -> Result<(), Failure> {
        self.axis.stop.store(false, Ordering::Relaxed);
        if let Some(share) = share {
            self.set("feed_forward.share", share)?;
        }
        self.axis.disable()
    }

    fn report(&self, findings: &Findings) -> Result<(), Failure> {
        let page = page::page(
            &self.journal,
            findings,
            self.axis.kind.unit(),
            command_line(),
        )?;
        let path = self.journal.file("report.html");
        super::outputs::write_with(&path, |path| page.write_html(path))?;
        for line in page::result(&self.journal, self.axis.kind.unit()) {
            say!("{line}");
        }
        explain!("{}", findings.diagnosis.recommendation(&findings.recording));
        Ok(())
    }
}
