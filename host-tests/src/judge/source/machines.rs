//! Machines of the second generator ([`crate::machines`]) as cases.

use crate::judge::case::{Case, Sort};
use crate::judge::tool::{Tool, parallel};
use crate::machines::make;

/// Name of the source.
pub const SOURCE: &str = "machines";

/// Asks the tool of the machines of some seeds whose sort is wanted.
pub fn cases(
    tool: &Tool,
    seeds: &[u64],
    wanted: impl Fn(Sort) -> bool + Sync,
    jobs: usize,
) -> Vec<Case> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    let answered = parallel(seeds, jobs, |&seed| {
        let n = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        let made = make(seed);
        if !wanted(made.sort) {
            return None;
        }
        let (answer, seconds) = tool.diagnose(&made.recording);
        let case = Case {
            source: SOURCE,
            name: made.recording.name,
            sort: made.sort,
            strength: made.strength,
            truth: made.truth,
            native: Vec::new(),
            neutral: Vec::new(),
            absent: None,
            there: None,
            verdicts: &[],
            answer,
            seconds,
        };
        // No line tells which was what: nobody may tune to them.
        eprintln!("machines: {n} of {} ({seconds:.1} s)", seeds.len());
        Some(case)
    });
    answered.into_iter().flatten().collect()
}
