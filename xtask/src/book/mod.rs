//! `cargo xtask book`: builds the book, runs the commands in it and in the README, and compares what they print.
//!
//! A fenced block's info string says what it is, after commas or blanks (GitHub knows `sh root`, not `sh,root`):
//!
//! | block | meaning |
//! |---|---|
//! | `sh` | run, in a folder of its own that the book's commands share, with the release `preslide` on the path |
//! | `sh,root` | run in the workspace root |
//! | `sh,recordings` | run in the workspace root if `../shared/recordings` is there, else skipped, loudly |
//! | `sh,axis=FILE` | run as `sh`, beside a copy of `../shared/recordings/FILE` of the name `axis.csv`, else skipped, loudly |
//! | `sh,ci=STEP` | not run here: that step of `cargo xtask test` runs it |
//! | `sh,long` | takes minutes: the next block, or the step of CI that it names, runs a part of it |
//! | `sh,board` | needs hardware: nothing runs it, and the chapter says so |
//! | `LANGUAGE,file=NAME` | written into that folder |
//! | `text,printed` | lines that the commands before it print, in order; `…` stands for any number of lines |

mod links;
mod page;
mod printed;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::process::{build_as_tests, released, root, run_for};
use crate::tools::mdbook;
use page::{CodeBlock, Kind, Page};

/// No command of the book takes longer, on a busy machine either.
const LIMIT: Duration = Duration::from_secs(900);

/// Whether `cargo xtask test` has a step of this name.
type HasStep = fn(&str) -> bool;

/// `--bless` writes what the commands print now into the book.
pub fn run_command(arguments: &[String], has_step: HasStep) -> Result<(), String> {
    let bless = crate::given("book", &["--bless"], arguments)?.is_some();
    let mut pages = page::all(&root().join("docs/src"))?;
    links::check(&pages)?;
    pages.push(page::page(root(), "README.md")?);
    build()?;
    follow(&pages, bless, has_step)
}

/// The pages in HTML, warnings denied, nothing in them that needs a network.
fn build() -> Result<(), String> {
    let program = mdbook()?;
    let mut command = Command::new(program);
    command.args(["build", "docs"]).current_dir(root());
    let result = command
        .output()
        .map_err(|error| format!("mdbook did not start: {error}"))?;
    let said = String::from_utf8_lossy(&result.stdout).into_owned()
        + &String::from_utf8_lossy(&result.stderr);
    if !result.status.success() || said.contains("WARN") || said.contains("ERROR") {
        return Err(format!("mdbook warns or fails:\n{}", said.trim()));
    }
    let folder = root().join("target/book");
    let mut count = 0;
    for file in files(&folder, "html")? {
        let text = read(&file)?;
        for tag in ["<script", "<link", "<img"] {
            for part in text.split(tag).skip(1) {
                let inside = part.split('>').next().unwrap_or_default();
                if inside.contains("http://") || inside.contains("https://") {
                    return Err(format!(
                        "{}: `{tag}{inside}>` needs a network",
                        file.display()
                    ));
                }
            }
        }
        count += 1;
    }
    println!("target/book: {count} pages, no warning, nothing that needs a network");
    Ok(())
}

/// Runs the blocks of all pages in order.
fn follow(pages: &[Page], bless: bool, has_step: HasStep) -> Result<(), String> {
    build_as_tests(&["--bin", "preslide"])?;
    let scratch = std::env::temp_dir().join(format!("preslide-book-{}", std::process::id()));
    fs::create_dir_all(&scratch)
        .map_err(|error| format!("cannot create {}: {error}", scratch.display()))?;
    let mut state = Walk {
        scratch: &scratch,
        has_step,
        printed: None,
        counts: [0; 4],
        failures: Vec::new(),
    };
    for page in pages {
        let mut lines: Vec<String> = page.text.lines().map(str::to_string).collect();
        let mut shift = 0_isize;
        state.printed = None;
        for block in &page.blocks {
            if let Some(new) = state.block(page, block, bless) {
                let first = block.first.wrapping_add_signed(shift);
                let range = first..first + block.lines.len();
                shift += new.len() as isize - block.lines.len() as isize;
                lines.splice(range, new);
            }
        }
        let text = lines.join("\n") + "\n";
        if bless && text != page.text {
            fs::write(&page.file, text)
                .map_err(|error| format!("cannot write {}: {error}", page.file.display()))?;
            println!("blessed {}", page.file.display());
        }
    }
    let [ran, ci, skipped, board] = state.counts;
    println!(
        "\n{ran} blocks of commands ran; {ci} are run by other steps of `cargo xtask test`; {board} need a board and ran nowhere"
    );
    if skipped > 0 {
        println!(
            "SKIPPED: ../shared/recordings is absent; {skipped} blocks of the book did not run"
        );
    }
    if state.failures.is_empty() {
        fs::remove_dir_all(&scratch)
            .map_err(|error| format!("cannot remove {}: {error}", scratch.display()))
    } else {
        Err(format!(
            "{}\n(what the commands wrote is in {}; `cargo xtask book --bless` takes what they print now)",
            state.failures.join("\n"),
            scratch.display()
        ))
    }
}

struct Walk<'a> {
    scratch: &'a Path,
    has_step: HasStep,
    /// What the last commands of the page printed; `None` where they did not run.
    printed: Option<String>,
    /// Blocks run, left to another step, skipped, left to a board.
    counts: [u32; 4],
    failures: Vec<String>,
}

impl Walk<'_> {
    /// The new lines of a block of printed lines that `bless` changes.
    fn block(&mut self, page: &Page, block: &CodeBlock, bless: bool) -> Option<Vec<String>> {
        let place = format!("{}:{}", page.name, block.first);
        match &block.kind {
            Kind::File(name) => {
                let text = block.lines.join("\n") + "\n";
                if let Err(error) = fs::write(self.scratch.join(name), text) {
                    self.failures
                        .push(format!("{place}: cannot write {name}: {error}"));
                }
            }
            Kind::Run { folder } => self.run(&place, block, folder.as_deref()),
            Kind::Recordings | Kind::Axis(_) if !recordings().is_dir() => {
                self.counts[2] += 1;
                self.printed = None;
            }
            Kind::Axis(recording) => {
                match fs::copy(recordings().join(recording), self.scratch.join("axis.csv")) {
                    Ok(_) => self.run(&place, block, None),
                    Err(error) => self.failures.push(format!("{place}: {recording}: {error}")),
                }
            }
            Kind::Recordings => self.run(&place, block, Some(root())),
            Kind::Ci(step) => {
                self.counts[1] += 1;
                self.printed = None;
                if let Err(reason) = in_ci(block, step, self.has_step) {
                    self.failures.push(format!("{place}: {reason}"));
                }
            }
            Kind::Board => {
                self.counts[3] += 1;
                self.printed = None;
            }
            Kind::Printed => {
                let printed = self.printed.as_deref()?;
                if bless {
                    match printed::blessed(&block.lines, printed) {
                        Ok(lines) => return Some(lines),
                        Err(reason) => self.failures.push(format!("{place}: {reason}")),
                    }
                } else if let Err(reason) = printed::compare(&block.lines, printed) {
                    self.failures.push(format!("{place}: {reason}"));
                }
            }
            Kind::Long | Kind::Other => {}
        }
        None
    }

    fn run(&mut self, place: &str, block: &CodeBlock, folder: Option<&Path>) {
        self.counts[0] += 1;
        self.printed = None;
        println!("\n{place}");
        for line in &block.lines {
            println!("  {line}");
        }
        match self.printed_by(block, folder) {
            Ok(text) => self.printed = Some(text),
            Err(reason) => self.failures.push(format!("{place}: {reason}")),
        }
    }

    fn printed_by(&self, block: &CodeBlock, folder: Option<&Path>) -> Result<String, String> {
        let script = self.scratch.join(".block.sh");
        let kept = self.scratch.join(".printed");
        // The release build in front of whatever else is called so.
        let text = format!(
            "set -euo pipefail\nPATH='{}':\"$PATH\"\n{}\n",
            released("").display(),
            block.lines.join("\n")
        );
        fs::write(&script, text).map_err(|error| format!("{}: {error}", script.display()))?;
        let out = File::create(&kept).map_err(|error| format!("{}: {error}", kept.display()))?;
        let err = File::create(self.scratch.join(".said"))
            .map_err(|error| format!("{}: {error}", kept.display()))?;
        let mut bash = Command::new("bash");
        bash.arg(&script)
            .current_dir(folder.unwrap_or(self.scratch))
            // What the README installs, it installs here.
            .env("CARGO_INSTALL_ROOT", self.scratch)
            .stdout(out)
            .stderr(err);
        run_for(&mut bash, LIMIT).map_err(|_| {
            let said = read(&self.scratch.join(".said")).unwrap_or_default();
            format!("`{}` failed: {}", block.lines.join("; "), said.trim())
        })?;
        read(&kept)
    }
}

/// Other people's, which are no part of the project.
fn recordings() -> PathBuf {
    root().join("../shared/recordings")
}

/// Whether the step that a block names exists, and every `cargo xtask` command in it.
fn in_ci(block: &CodeBlock, step: &str, has_step: HasStep) -> Result<(), String> {
    if !has_step(step) {
        return Err(format!("`cargo xtask test` has no step `{step}`"));
    }
    for line in &block.lines {
        if let Some(command) = line.strip_prefix("cargo xtask ") {
            let name = command.split_whitespace().next().unwrap_or_default();
            if !crate::is_command(name) {
                return Err(format!("there is no `cargo xtask {name}`"));
            }
        }
    }
    Ok(())
}

fn read(file: &Path) -> Result<String, String> {
    fs::read_to_string(file).map_err(|error| format!("cannot read {}: {error}", file.display()))
}

/// Files below `folder` with this extension, sorted.
fn files(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder)
        .map_err(|error| format!("cannot read {}: {error}", folder.display()))?;
    let mut found = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            found.extend(files(&path, extension)?);
        } else if path.extension().is_some_and(|kind| kind == extension) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}
