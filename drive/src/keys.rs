//! The space bar, while a command commands the axis in an ordinary terminal: it stops what moves.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The terminal hands on every key at once, until this is dropped.
pub struct SpaceBar(#[cfg(unix)] rustix::termios::Termios);

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
        // It ends with the program: nothing else waits for a key.
        std::thread::spawn(move || {
            for byte in std::io::stdin().bytes().map_while(Result::ok) {
                if byte == b' ' {
                    stop.store(true, std::sync::atomic::Ordering::Relaxed);
                }
            }
        });
        Some(Self(before))
    }

    /// There is no such terminal here: Ctrl-C stops.
    #[cfg(not(unix))]
    pub fn stops(_: &Arc<AtomicBool>) -> Option<Self> {
        None
    }
}

impl Drop for SpaceBar {
    fn drop(&mut self) {
        #[cfg(unix)]
        let _ = rustix::termios::tcsetattr(
            std::io::stdin(),
            rustix::termios::OptionalActions::Now,
            &self.0,
        );
    }
}
