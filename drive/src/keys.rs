//! The space bar, while a command commands the axis in an ordinary terminal: it stops what moves.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};

/// The terminal hands on every key at once, until this is dropped.
pub struct SpaceBar {
    keys: Receiver<u8>,
    #[cfg(unix)]
    before: rustix::termios::Termios,
}

impl SpaceBar {
    /// Sets `stop` whenever the space bar is pressed; `None` where there is no terminal to type at.
    #[cfg(unix)]
    pub fn stops(stop: &Arc<AtomicBool>) -> Option<Self> {
        use rustix::termios::{LocalModes, OptionalActions, tcgetattr, tcsetattr};
        use std::io::Read;
        let before = tcgetattr(std::io::stdin()).ok()?;
        let mut at_once = before.clone();
        at_once
            .local_modes
            .remove(LocalModes::ICANON | LocalModes::ECHO);
        tcsetattr(std::io::stdin(), OptionalActions::Now, &at_once).ok()?;
        let stop = Arc::clone(stop);
        let (pressed, keys) = channel();
        // It ends with the program: nothing else reads what is typed.
        std::thread::spawn(move || {
            for key in std::io::stdin().lock().bytes().map_while(Result::ok) {
                if key == b' ' {
                    stop.store(true, Ordering::Relaxed);
                }
                if pressed.send(key).is_err() {
                    break;
                }
            }
        });
        Some(Self { keys, before })
    }

    /// There is no such terminal here: Ctrl-C stops.
    #[cfg(not(unix))]
    pub fn stops(_: &Arc<AtomicBool>) -> Option<Self> {
        None
    }

    /// The next key that is pressed; none where nothing can be typed any more.
    pub fn next(&self) -> Option<char> {
        // What was typed before there was a question is no answer.
        while self.keys.try_recv().is_ok() {}
        self.keys.recv().ok().map(char::from)
    }
}

impl Drop for SpaceBar {
    fn drop(&mut self) {
        #[cfg(unix)]
        let _ = rustix::termios::tcsetattr(
            std::io::stdin(),
            rustix::termios::OptionalActions::Now,
            &self.before,
        );
    }
}
