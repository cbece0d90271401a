//! Progress of long work, on stderr only: a bar on a terminal, a few lines of text in a log.

use std::cell::RefCell;
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Lines of a log are at least this far apart…
const LEAST_PAUSE: Duration = Duration::from_secs(2);
/// …and a line is due after this time even when no further tenth is done.
const LONGEST_PAUSE: Duration = Duration::from_secs(30);

/// Hears of what is being done, the steps that are done, and how many there are (0 where nobody knows).
pub type Listener = Arc<dyn Fn(&str, u64, u64) + Send + Sync>;

thread_local! {
    static LISTENER: RefCell<Option<Listener>> = const { RefCell::new(None) };
}

/// Has a listener hear of all work that this thread begins within `work`, in place of stderr.
pub fn heard<R>(listener: Listener, work: impl FnOnce() -> R) -> R {
    let before = LISTENER.replace(Some(listener));
    let done = work();
    LISTENER.set(before);
    done
}

/// Progress through a known number of steps. Shared by reference between threads (rayon's among them).
///
/// Dropped without [`finish`](Progress::finish), as on an error, it leaves nothing on the terminal.
pub struct Progress {
    shown: Shown,
}

enum Shown {
    Bar(ProgressBar),
    Lines(Lines),
    Told(Told),
}

/// Progress that a listener hears of.
struct Told {
    message: Mutex<String>,
    steps: u64,
    done: AtomicU64,
    to: Listener,
}

impl Told {
    fn inc(&self, steps: u64) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        let message = self.message.lock().unwrap_or_else(PoisonError::into_inner);
        (self.to)(&message, done, self.steps);
    }
}

impl Progress {
    /// Starts `steps` steps of the work that `message` names, such as "fitting GMS"; 0 where nobody knows how many.
    pub fn new(message: impl Into<String>, steps: u64) -> Self {
        let message = message.into();
        if let Some(to) = LISTENER.with_borrow(Clone::clone) {
            let told = Told {
                message: Mutex::new(message),
                steps,
                done: AtomicU64::new(0),
                to,
            };
            return Progress {
                shown: Shown::Told(told),
            };
        }
        let stderr = std::io::stderr();
        if !stderr.is_terminal() {
            return Progress {
                shown: Shown::Lines(Lines::new(message, steps, Box::new(stderr))),
            };
        }
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr())
            .with_message(message);
        // The default style replaces a template that is wrong.
        let template = if steps > 0 {
            "{msg} {wide_bar} {pos}/{len}  {elapsed}"
        } else {
            "{msg} {pos}  {elapsed}"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Progress {
            shown: Shown::Bar(bar),
        }
    }

    /// `steps` more are done.
    pub fn inc(&self, steps: u64) {
        match &self.shown {
            Shown::Bar(bar) => bar.inc(steps),
            Shown::Lines(lines) => lines.inc(steps, Instant::now()),
            Shown::Told(told) => told.inc(steps),
        }
    }

    /// Names what is being done now.
    pub fn set_message(&self, message: impl Into<String>) {
        match &self.shown {
            Shown::Bar(bar) => bar.set_message(message.into()),
            Shown::Lines(lines) => lines.set_message(message.into()),
            Shown::Told(told) => {
                *told.message.lock().unwrap_or_else(PoisonError::into_inner) = message.into();
            }
        }
    }

    /// Ends the work and leaves one line that says what was done and how long it took.
    pub fn finish(self) {
        match &self.shown {
            Shown::Bar(bar) => {
                let line = format!(
                    "{} {}, {}",
                    bar.message(),
                    bar.position(),
                    HumanDuration(bar.elapsed())
                );
                bar.finish_and_clear();
                say(&mut std::io::stderr(), &line);
            }
            Shown::Lines(lines) => lines.finish(Instant::now()),
            Shown::Told(_) => {}
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Shown::Bar(bar) = &self.shown {
            bar.finish_and_clear();
        }
    }
}

/// Progress where there is no terminal.
struct Lines {
    steps: u64,
    started: Instant,
    done: AtomicU64,
    log: Mutex<Log>,
}

struct Log {
    message: String,
    to: Box<dyn Write + Send>,
    last: Instant,
    tenths: u64,
}

impl Lines {
    fn new(message: String, steps: u64, to: Box<dyn Write + Send>) -> Self {
        let started = Instant::now();
        let log = Mutex::new(Log {
            message,
            to,
            last: started,
            tenths: 0,
        });
        Lines {
            steps,
            started,
            done: AtomicU64::new(0),
            log,
        }
    }

    fn inc(&self, steps: u64, now: Instant) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        // Another thread is writing its line: this one need not.
        let Ok(mut log) = self.log.try_lock() else {
            return;
        };
        let tenths = tenths(done, self.steps);
        let pause = now.saturating_duration_since(log.last);
        if (tenths > log.tenths && pause >= LEAST_PAUSE) || pause >= LONGEST_PAUSE {
            (log.last, log.tenths) = (now, tenths);
            self.write(&mut log, done, now);
        }
    }

    fn set_message(&self, message: String) {
        self.log
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .message = message;
    }

    fn finish(&self, now: Instant) {
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        self.write(&mut log, self.done.load(Ordering::Relaxed), now);
    }

    fn write(&self, log: &mut Log, done: u64, now: Instant) {
        let seconds = now.saturating_duration_since(self.started).as_secs_f64();
        let of = match self.steps {
            0 => String::new(),
            steps => format!(" of {steps}"),
        };
        let line = format!("{}: {done}{of} ({seconds:.1} s)", log.message);
        say(&mut log.to, &line);
    }
}

fn tenths(done: u64, steps: u64) -> u64 {
    (u128::from(done) * 10 / u128::from(steps.max(1))) as u64
}

/// Progress is a courtesy: when stderr is closed the work goes on.
fn say(to: &mut dyn Write, line: &str) {
    let _ = writeln!(to, "{line}");
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rayon::prelude::*;

    use super::*;

    #[derive(Clone, Default)]
    struct Sink(Arc<Mutex<Vec<u8>>>);

    impl Sink {
        fn lines(&self) -> Vec<String> {
            String::from_utf8(self.0.lock().unwrap().clone())
                .unwrap()
                .lines()
                .map(String::from)
                .collect()
        }
    }

    impl Write for Sink {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn lines(steps: u64) -> (Lines, Sink) {
        let sink = Sink::default();
        (
            Lines::new("fitting".into(), steps, Box::new(sink.clone())),
            sink,
        )
    }

    #[test]
    fn fast_work_leaves_one_line() {
        let (progress, sink) = lines(1000);
        let end = progress.started + LEAST_PAUSE / 2;
        (0..1000).into_par_iter().for_each(|_| progress.inc(1, end));
        progress.finish(end);
        assert_eq!(sink.lines().len(), 1, "{:?}", sink.lines());
        assert!(sink.lines()[0].starts_with("fitting: 1000 of 1000 ("));
    }

    #[test]
    fn slow_work_leaves_a_line_a_tenth() {
        let (progress, sink) = lines(1000);
        for i in 1..=1000 {
            progress.inc(1, progress.started + Duration::from_millis(100 * i));
        }
        assert_eq!(sink.lines().len(), 10);
        assert_eq!(sink.lines()[0], "fitting: 100 of 1000 (10.0 s)");
    }

    #[test]
    fn very_slow_work_shows_that_it_lives() {
        let (progress, sink) = lines(1000);
        for i in 1..=10 {
            progress.inc(1, progress.started + Duration::from_secs(40 * i));
        }
        assert_eq!(sink.lines().len(), 10);
    }

    #[test]
    fn no_steps_and_too_many_steps_are_harmless() {
        let (progress, sink) = lines(0);
        progress.inc(u64::MAX, progress.started + LEAST_PAUSE);
        progress.set_message("other".into());
        progress.finish(progress.started);
        assert!(sink.lines().last().unwrap().starts_with("other: "));
    }
}
