//! The terminal: what the axis does, and keys that command it.
//!
//! The space bar stops the axis whatever else is going on; so does Ctrl-C, before it ends the program.

mod panes;

use crate::{Drive, DriveError, quantity, words};
use preslide_link::{Homing, Mark, Mode, Name, Request, Sample, State};
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How long a controller that does not disable, or refuses to, is waited for.
const LEAVES: Duration = Duration::from_secs(5);
/// From one drawing to the next; each hears the controller and is heard by it.
const FRAME: Duration = Duration::from_millis(50);

/// Telemetry of every so many ticks.
const EVERY: u16 = 100;

/// Samples that the plot shows.
const SHOWN: usize = 400;

/// Lines of what happened.
const LINES: usize = 200;

/// The speed and acceleration of a move that is typed, as shares of the axis's limits.
const GENTLY: f64 = 0.2;

/// The prompt at the bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Question {
    To,
    By,
    Set,
    Zero,
}

impl Question {
    fn text(self) -> &'static str {
        match self {
            Question::To => "move to (1.5mm, -20um; Enter moves, Esc cancels):",
            Question::By => "move by (1.5mm, -20um; Enter moves, Esc cancels):",
            Question::Set => "set NAME=VALUE (gains.proportional=1e5):",
            Question::Zero => "the axis is now at (0, 5mm):",
        }
    }
}

/// The terminal's state.
struct Screen {
    drive: Drive,
    state: State,
    samples: VecDeque<Sample>,
    lines: VecDeque<String>,
    question: Option<Question>,
    typed: String,
    /// Limits (SI).
    speed: f64,
    acceleration: f64,
    unit: &'static str,
    over: bool,
}

/// Shows the axis and commands it until the user quits. `unit` is m or rad.
///
/// # Errors
/// The line's errors; the terminal is put back first. What the controller refuses is shown, and ends nothing.
pub fn run(drive: Drive, unit: &'static str) -> Result<(), DriveError> {
    let mut screen = Screen::new(drive, unit)?;
    let mut terminal = ratatui::init();
    let ended = screen.serve(&mut terminal);
    ratatui::restore();
    ended
}

impl Screen {
    fn new(mut drive: Drive, unit: &'static str) -> Result<Self, DriveError> {
        let state = drive.state()?;
        let speed = drive.get("limits.speed")?.unwrap_or(0.0);
        let acceleration = drive.get("limits.acceleration")?.unwrap_or(0.0);
        drive.ask(Request::Telemetry { every: EVERY })?;
        let mut screen = Self {
            drive,
            state,
            samples: VecDeque::new(),
            lines: VecDeque::new(),
            question: None,
            typed: String::new(),
            speed,
            acceleration,
            unit,
            over: false,
        };
        screen.tell(format!("reset by: {}", words::reset(state.reset)));
        Ok(screen)
    }

    fn tell(&mut self, line: impl Into<String>) {
        self.lines.push_front(line.into());
        self.lines.truncate(LINES);
    }

    fn serve(&mut self, terminal: &mut DefaultTerminal) -> Result<(), DriveError> {
        let terminal_error = DriveError::Line;
        while !self.over {
            terminal
                .draw(|frame| self.draw(frame))
                .map_err(terminal_error)?;
            let start = Instant::now();
            self.look()?;
            while event::poll(FRAME.saturating_sub(start.elapsed())).map_err(terminal_error)? {
                if let Event::Key(key) = event::read().map_err(terminal_error)?
                    && key.kind != KeyEventKind::Release
                {
                    self.key(key)?;
                }
            }
        }
        Ok(())
    }

    /// Takes state and telemetry, and reports what changed.
    fn look(&mut self) -> Result<(), DriveError> {
        let before = std::mem::replace(&mut self.state, self.drive.state()?);
        let now = self.state;
        if let Some(fault) = now.fault
            && before.fault.is_none()
        {
            self.tell(format!("FAULT: {}", words::fault(fault)));
            self.tell("a acknowledges, e enables again");
        }
        if now.mode != before.mode {
            self.tell(words::mode(now.mode));
        }
        if now.tick < before.tick {
            self.tell(format!(
                "the controller was reset: {}",
                words::reset(now.reset)
            ));
        }
        self.samples.extend(self.drive.take_samples());
        let more = self.samples.len().saturating_sub(SHOWN);
        self.samples.drain(..more);
        Ok(())
    }

    fn key(&mut self, key: KeyEvent) -> Result<(), DriveError> {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        match (key.code, self.question) {
            (KeyCode::Char('c'), _) if control => {
                self.order("stop", Request::Stop)?;
                self.over = true;
            }
            (KeyCode::Char(' '), _) => {
                self.question = None;
                self.order("stop", Request::Stop)?;
            }
            (KeyCode::Esc, Some(_)) => self.question = None,
            (KeyCode::Enter, Some(question)) => {
                self.question = None;
                let typed = std::mem::take(&mut self.typed);
                self.answered(question, typed.trim())?;
            }
            (KeyCode::Backspace, Some(_)) => {
                self.typed.pop();
            }
            (KeyCode::Char(letter), Some(_)) => self.typed.push(letter),
            (code, None) => self.command(code)?,
            _ => {}
        }
        Ok(())
    }

    fn command(&mut self, code: KeyCode) -> Result<(), DriveError> {
        let jog = |share: f64| Request::Jog {
            speed_m_s: (share * GENTLY * self.speed) as f32,
        };
        let (what, request) = match code {
            KeyCode::Char('e') => ("enable", Request::Enable),
            KeyCode::Char('d') => ("disable", Request::Disable),
            KeyCode::Char('a') => ("acknowledge", Request::Acknowledge),
            KeyCode::Char('w') => ("save", Request::Save),
            KeyCode::Char('h') => (
                "home to the index",
                Request::Home(Homing {
                    mark: Mark::Index,
                    speed_m_s: (-GENTLY * self.speed) as f32,
                    position_m: 0.0,
                    back_off_m: 0.0,
                }),
            ),
            KeyCode::Right => ("jog forward", jog(1.0)),
            KeyCode::Left => ("jog backward", jog(-1.0)),
            KeyCode::Char('t') => return self.ask(Question::To),
            KeyCode::Char('b') => return self.ask(Question::By),
            KeyCode::Char('s') => return self.ask(Question::Set),
            KeyCode::Char('z') => return self.ask(Question::Zero),
            KeyCode::Char('q') => {
                self.order("stop", Request::Stop)?;
                self.order("disable", Request::Disable)?;
                self.over = true;
                return self.leave();
            }
            _ => return Ok(()),
        };
        self.order(what, request)
    }

    /// The bridge opens when the axis stands: who leaves leaves it open.
    fn leave(&mut self) -> Result<(), DriveError> {
        let start = Instant::now();
        while self.drive.state()?.mode != Mode::Disabled && start.elapsed() < LEAVES {
            self.drive.listen(FRAME)?;
        }
        Ok(())
    }

    fn ask(&mut self, question: Question) -> Result<(), DriveError> {
        self.typed.clear();
        self.question = Some(question);
        Ok(())
    }

    /// A length or an angle, as the axis has it.
    fn length(&self, typed: &str) -> Result<f64, String> {
        let length = quantity::length(typed)?;
        let axis = format!("the axis moves in {}", self.unit);
        quantity::check(self.unit == "rad", &axis, &[("", Some(&length))])?;
        Ok(length.value)
    }

    fn answered(&mut self, question: Question, typed: &str) -> Result<(), DriveError> {
        let (speed, ramp) = self.pace();
        let request = match question {
            Question::Set => {
                let pair = typed.split_once('=');
                let set = pair.and_then(|(name, value)| {
                    let value = value.trim().parse::<f32>().ok()?;
                    Some(Request::Set(Name::new(name.trim())?, value))
                });
                set.ok_or_else(|| {
                    format!("`{typed}`: give a name and a number, gains.derivative=600")
                })
            }
            _ => self.length(typed).map(|length| match question {
                Question::By => Request::Move {
                    distance_m: length as f32,
                    speed_m_s: speed,
                    ramp_s: ramp,
                },
                Question::Zero => Request::Zero {
                    position_m: length as f32,
                },
                _ => Request::MoveTo {
                    position_m: length as f32,
                    speed_m_s: speed,
                    ramp_s: ramp,
                },
            }),
        };
        match request {
            Ok(request) => self.order(typed, request),
            Err(reason) => {
                self.tell(reason);
                Ok(())
            }
        }
    }

    /// Speed and ramp of a typed move.
    fn pace(&self) -> (f32, f32) {
        let ramp = self.speed / self.acceleration;
        ((GENTLY * self.speed) as f32, ramp as f32)
    }

    /// Requests it; a refusal is shown, and ends nothing.
    fn order(&mut self, what: &str, request: Request) -> Result<(), DriveError> {
        match self.drive.ask(request) {
            Ok(_) => self.tell(format!("{what}: done")),
            Err(DriveError::Refused { refusal, .. }) => {
                self.tell(format!("{what}: refused, {}", words::refusal(refusal)));
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }

    fn is_enabled(&self) -> bool {
        self.state.mode != Mode::Disabled
    }
}
