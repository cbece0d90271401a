//! What a command says: to the terminal, or to its caller in this process.

use super::Arguments;
use clap::Parser;
pub use preslide_fit::progress::Listener;
use preslide_fit::progress::heard;
use std::cell::RefCell;
use std::io::IsTerminal as _;
use std::sync::atomic::{AtomicBool, Ordering};

/// Standard output belongs to a file requested as `-`; messages go to standard error.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Whether standard output holds a file from here on.
pub(super) fn take_stdout(taken: bool) {
    TAKEN.store(taken, Ordering::Relaxed);
}

/// Prints a line for the user. A reader that has closed the pipe (`preslide … | head`) ends nothing: files are
/// still written. Any other failure ends the program, because the answer would be lost.
macro_rules! say {
    ($($line:tt)*) => { $crate::heard::say_line(format_args!($($line)*)) };
}

/// Prints sentences for the user, in lines that people read.
macro_rules! explain {
    ($($line:tt)*) => { say!("{}", $crate::heard::for_reader(format!($($line)*))) };
}

/// Tells the user something beside the answer, on stderr.
macro_rules! tell {
    ($($line:tt)*) => { $crate::heard::tell_line(format_args!($($line)*)) };
}

/// How a command ended.
#[derive(Debug, Default)]
pub struct Answer {
    /// What it printed.
    pub said: String,
    /// What it said beside that, such as warnings.
    pub told: Vec<String>,
    /// Why it ended without its answer, and the exit code; `None` if it succeeded.
    pub failure: Option<(String, u8)>,
    arguments: Vec<String>,
}

thread_local! {
    static CALLED: RefCell<Option<Answer>> = const { RefCell::new(None) };
}

/// Runs a command in this process, as `preslide ARGUMENTS…` would; `listener` hears of its progress.
pub fn call(arguments: Vec<String>, listener: Listener) -> Answer {
    let whole = std::iter::once("preslide".to_owned()).chain(arguments);
    let arguments: Vec<String> = whole.collect();
    CALLED.set(Some(Answer {
        arguments: arguments.clone(),
        ..Answer::default()
    }));
    let failure = match Arguments::try_parse_from(arguments) {
        Ok(parsed) => heard(listener, || parsed.command.run())
            .err()
            .map(|failure| (failure.message().to_owned(), failure.exit_code())),
        // Bad usage, or help.
        Err(error) => Some((error.to_string(), error.exit_code() as u8)),
    };
    let answer = CALLED.take().unwrap_or_default();
    Answer { failure, ..answer }
}

/// The command line.
pub(super) fn arguments() -> Vec<String> {
    let called = CALLED.with_borrow(|called| called.as_ref().map(|c| c.arguments.clone()));
    called.unwrap_or_else(|| std::env::args().collect())
}

/// Gives a line to the command's caller; `false` where it is the program's own.
fn give(line: &impl Fn(&mut Answer)) -> bool {
    CALLED.with_borrow_mut(|called| called.as_mut().map(line).is_some())
}

/// Columns at which sentences are broken at most.
const WIDTH: usize = 100;
/// How lines begin that are to be copied as they stand.
const WHOLE: [&str; 4] = ["Next: ", "Next, on the axis: ", "Try: ", "preslide "];

/// The work of `explain!`: folded, to the terminal's width where there is one.
pub(super) fn for_reader(text: String) -> String {
    let is_called = CALLED.with_borrow(Option::is_some);
    let width = match !is_called && std::io::stdout().is_terminal() {
        true => WIDTH.min(textwrap::termwidth()),
        false => WIDTH,
    };
    folded(&text, width)
}

/// Sentences in lines of a width; tables and commands stay as they are.
fn folded(text: &str, width: usize) -> String {
    let fold = |line: &str| {
        let words = line.trim_start();
        let is_table = words.contains("  ") || words.contains(['│', '─']);
        if is_table || WHOLE.iter().any(|begins| words.starts_with(begins)) {
            return line.to_owned();
        }
        let margin = " ".repeat(line.len() - words.len());
        let options = textwrap::Options::new(width)
            .initial_indent(&margin)
            .subsequent_indent(&margin)
            .break_words(false)
            .word_splitter(textwrap::WordSplitter::NoHyphenation);
        textwrap::fill(&tied(words), options).replace(TIE, " ")
    };
    let lines: Vec<String> = text.split('\n').map(fold).collect();
    lines.join("\n")
}

/// A space at which no line is broken.
const TIE: char = '\u{a0}';

/// The same with each number tied to its unit.
fn tied(words: &str) -> String {
    let is_unit = |next: &str| next.starts_with(|c: char| c.is_alphabetic() || "%±°".contains(c));
    let mut tied = String::new();
    for (at, c) in words.char_indices() {
        let in_front = tied.ends_with(|c: char| c.is_ascii_digit() || c == '±');
        let after = &words[at + c.len_utf8()..];
        let unit = is_unit(after) || tied.ends_with('±');
        tied.push(if c == ' ' && in_front && unit { TIE } else { c });
    }
    tied
}

/// The same with what would command a terminal, or turn the order of its letters, spelt out: names and cells are of strangers' files.
fn printable(line: std::fmt::Arguments) -> String {
    let commands = |c: char| c.is_control() && !"\n\t".contains(c);
    let turns = |c: char| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let mut printable = String::new();
    for c in line.to_string().chars() {
        match commands(c) || turns(c) {
            true => printable.extend(c.escape_unicode()),
            false => printable.push(c),
        }
    }
    printable
}

/// The work of `say!`.
pub(super) fn say_line(line: std::fmt::Arguments) {
    let line = printable(line);
    if give(&|called| called.said += &format!("{line}\n")) {
        return;
    }
    if TAKEN.load(Ordering::Relaxed) {
        return to_stderr(&line);
    }
    if let Err(error) = to_stdout(&format!("{line}\n")) {
        to_stderr(&format!("preslide: standard output: {error}"));
        std::process::exit(1);
    }
}

/// Writes to standard output. That its reader has seen enough is no failure.
pub(super) fn to_stdout(text: &str) -> std::io::Result<()> {
    use std::io::Write;
    let mut stdout = std::io::stdout();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Writes a line to stderr.
fn to_stderr(line: &str) {
    ask(&format!("{line}\n"));
}

/// Writes to stderr, and stays on the line. Where that is closed, there is nobody to tell; `eprint!` would end the program.
pub(super) fn ask(text: &str) {
    use std::io::Write;
    let mut stderr = std::io::stderr();
    let _ = stderr
        .write_all(text.as_bytes())
        .and_then(|()| stderr.flush());
}

/// The work of `tell!`.
pub(super) fn tell_line(line: std::fmt::Arguments) {
    let line = printable(line);
    if !give(&|called| called.told.push(line.clone())) {
        // Whoever filters a log does so by lines.
        to_stderr(&match std::io::stderr().is_terminal() {
            true => folded(&line, WIDTH.min(textwrap::termwidth())),
            false => line,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_are_broken_between_words_and_nothing_else_is() {
        let words = "the friction of this axis is 12.3 mN ± 0.4 mN and falls with the speed";
        let long = [words; 4].join(", ");
        let broken = folded(&long, WIDTH);
        assert!(broken.lines().count() > 2 && broken.lines().all(|l| l.chars().count() <= WIDTH));
        assert_eq!(broken.replace('\n', " "), long);
        assert!(
            broken
                .lines()
                .all(|l| !l.ends_with(|c: char| c.is_ascii_digit()))
        );
        let command = format!("  preslide diagnose {}", "file.csv ".repeat(20));
        let row = "─".repeat(2 * WIDTH);
        for whole in [command.as_str(), row.as_str()] {
            assert_eq!(folded(whole, WIDTH), whole);
        }
        let indented = folded(&format!("  {long}"), WIDTH);
        assert!(indented.lines().all(|l| l.starts_with("  ")));
    }
}
