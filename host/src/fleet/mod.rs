//! Many axes, a recording a day each: a row a recording, and what changed against the axis's own history.
//!
//! [`members`] finds the recordings and whose they are → [`Row::of`] makes a row of each, in any order, on as many cores as there are →
//! [`Journal`] keeps them, so that nothing is computed twice → [`history`] holds each against those before it → [`table`] and [`page`] show it.

pub mod history;
mod journal;
mod members;
pub mod page;
mod row;
pub mod table;

pub use journal::{Journal, is_begun, is_journal};
pub use members::{Member, members};
pub use row::{Depth, Row};

use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use rayon::ThreadPoolBuilder;

/// Every `of`th recording, from the one of this number on, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which part.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text
            .split_once('/')
            .and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        numbers
            .map(|(number, of)| Self { number, of })
            .filter(|part| (1..=part.of).contains(&part.number))
            .ok_or_else(|| "give the part and how many there are, such as 1/8".to_owned())
    }
}

/// Makes rows on so many cores, and hands each over with its place as it is done: a recording at a time on each core is in memory, whatever the
/// fleet. Where there are more cores than recordings, those work together on one.
pub fn rows(
    members: &[Member],
    cores: usize,
    row: impl Fn(&Member) -> Row + Sync,
    mut done: impl FnMut(usize, Row),
) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        let at_a_time = cores.clamp(1, members.len().max(1));
        for _ in 0..at_a_time {
            let (sender, next, row) = (sender.clone(), &next, &row);
            scope.spawn(move || {
                // Threads of its own: in the pool of all, each recording would wait for parts of the others.
                let threads = ThreadPoolBuilder::new().num_threads(cores / at_a_time);
                let pool = threads.build().ok();
                let row = |member| match &pool {
                    Some(pool) => pool.install(|| row(member)),
                    None => row(member),
                };
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let made = members.get(place).map(|member| (place, row(member)));
                    // Nobody hears any more: the command was stopped.
                    if made.is_none_or(|made| sender.send(made).is_err()) {
                        break;
                    }
                }
            });
        }
        drop(sender);
        receiver
            .into_iter()
            .for_each(|(place, row)| done(place, row));
    });
}
