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

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use fs_err as fs;
use preslide_tools::need::mdbook;
use preslide_tools::process::{build_as_tests, output_for, released, root, with_folder};

use crate::files::files;
use page::{CodeBlock, Kind, Page, Place};

/// No command of the book takes longer, on a busy machine either.
const LIMIT: Duration = Duration::from_secs(900);

/// Whether `cargo xtask test` has a step of this name.
type HasStep = fn(&str) -> bool;

/// `bless` writes what the commands print now into the book.
pub fn run_command(bless: bool, has_step: HasStep) -> Result<()> {
    let mut pages = page::all(&root().join("docs/src"))?;
    links::check(&pages)?;
    pages.push(Page::read(root(), "README.md")?);
    build()?;
    build_as_tests("--bin preslide")?;
    with_folder("book", |folder| follow(&pages, folder, bless, has_step))
}

/// The pages in HTML, warnings denied, nothing in them that needs a network.
fn build() -> Result<()> {
    let mut command = Command::new(mdbook()?);
    command.args(["build", "docs"]).current_dir(root());
    let result = command.output().context("mdbook did not start")?;
    let said = [result.stdout, result.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let is_fine = result.status.success() && !said.contains("WARN") && !said.contains("ERROR");
    ensure!(is_fine, "mdbook warns or fails:\n{}", said.trim());
    let pages = files(&root().join("target/book"), "html")?;
    for file in &pages {
        let text = fs::read_to_string(file)?;
        let tags = ["<script", "<link", "<img"].into_iter();
        let tags = tags.flat_map(|tag| text.split(tag).skip(1).map(move |rest| (tag, rest)));
        for (tag, rest) in tags {
            let inside = rest.split('>').next().unwrap_or_default();
            if inside.contains("http://") || inside.contains("https://") {
                bail!("{}: `{tag}{inside}>` needs a network", file.display());
            }
        }
    }
    println!(
        "target/book: {} pages, no warning, nothing that needs a network",
        pages.len()
    );
    Ok(())
}

/// Runs the blocks of all pages in order.
fn follow(pages: &[Page], folder: &Path, bless: bool, has_step: HasStep) -> Result<()> {
    let mut walk = Walk {
        folder,
        bless,
        has_step,
        printed: None,
        counts: [0; 4],
    };
    let mut failures = Vec::new();
    for page in pages {
        let mut lines: Vec<String> = page.text.lines().map(str::to_owned).collect();
        walk.printed = None;
        // A block may get longer when it is blessed.
        let mut shift = 0;
        for block in &page.blocks {
            let place = format!("{}:{}", page.name, block.first);
            match walk.block(&place, block) {
                Ok(None) => {}
                Ok(Some(new)) => {
                    let first = block.first.wrapping_add_signed(shift);
                    shift += new.len() as isize - block.lines.len() as isize;
                    lines.splice(first..first + block.lines.len(), new);
                }
                Err(reason) => failures.push(format!("{place}: {reason:#}")),
            }
        }
        let text = lines.join("\n") + "\n";
        if bless && text != page.text {
            fs::write(&page.file, text)?;
            println!("blessed {}", page.file.display());
        }
    }
    let [ran, ci, skipped, board] = walk.counts;
    println!(
        "\n{ran} blocks of commands ran; {ci} are run by other steps of `cargo xtask test`; {board} need a board and ran nowhere"
    );
    if skipped > 0 {
        println!(
            "SKIPPED: ../shared/recordings is absent; {skipped} blocks of the book did not run"
        );
    }
    ensure!(
        failures.is_empty(),
        "{}\n(what the commands wrote is in {}; `cargo xtask book --bless` takes what they print now)",
        failures.join("\n"),
        folder.display()
    );
    Ok(())
}

struct Walk<'a> {
    folder: &'a Path,
    bless: bool,
    has_step: HasStep,
    /// What the last commands of the page printed; `None` where they did not run.
    printed: Option<String>,
    /// Blocks run, left to another step, skipped, left to a board.
    counts: [u32; 4],
}

impl Walk<'_> {
    /// Does what a block asks for; the new lines of one with printed lines that is blessed.
    fn block(&mut self, place: &str, block: &CodeBlock) -> Result<Option<Vec<String>>> {
        match &block.kind {
            Kind::File(name) => {
                fs::write(self.folder.join(name), block.lines.join("\n") + "\n")?;
            }
            Kind::Printed => {
                let printed = self.printed.as_deref();
                let blessed = printed.filter(|_| self.bless);
                if let Some(printed) = blessed {
                    return printed::blessed(&block.lines, printed).map(Some);
                }
                return printed.map_or(Ok(None), |printed| {
                    printed::compare(&block.lines, printed).map(|()| None)
                });
            }
            Kind::Run(Place::Recordings | Place::Axis(_)) if !recordings().is_dir() => {
                self.printed = None;
                self.counts[2] += 1;
            }
            Kind::Run(at) => {
                self.printed = None;
                self.counts[0] += 1;
                println!("\n{place}");
                for line in &block.lines {
                    println!("  {line}");
                }
                self.printed = Some(self.printed_by(block, at)?);
            }
            Kind::Ci(step) => {
                self.printed = None;
                self.counts[1] += 1;
                in_ci(block, step, self.has_step)?;
            }
            Kind::Board => {
                self.printed = None;
                self.counts[3] += 1;
            }
            Kind::Long | Kind::Other => {}
        }
        Ok(None)
    }

    fn printed_by(&self, block: &CodeBlock, at: &Place) -> Result<String> {
        let folder = match at {
            Place::Shared | Place::Axis(_) => self.folder,
            Place::Root | Place::Recordings => root(),
        };
        if let Place::Axis(recording) = at {
            fs::copy(recordings().join(recording), folder.join("axis.csv"))?;
        }
        let script = self.folder.join(".block.sh");
        // The release build in front of whatever else is called so.
        let text = format!(
            "set -euo pipefail\nPATH='{}':\"$PATH\"\n{}\n",
            released("").display(),
            block.lines.join("\n")
        );
        fs::write(&script, text)?;
        let mut bash = Command::new("bash");
        bash.arg(&script).current_dir(folder);
        // What the README installs, it installs here.
        bash.env("CARGO_INSTALL_ROOT", self.folder);
        let printed = output_for(&mut bash, LIMIT);
        let (printed, _) = printed.with_context(|| format!("`{}`", block.lines.join("; ")))?;
        Ok(printed)
    }
}

/// Other people's, which are no part of the project.
fn recordings() -> PathBuf {
    root().join("../shared/recordings")
}

/// Whether the step that a block names exists, and every `cargo xtask` command in it.
fn in_ci(block: &CodeBlock, step: &str, has_step: HasStep) -> Result<()> {
    let is_step = has_step(step);
    ensure!(is_step, "`cargo xtask test` has no step `{step}`");
    let commands = block.lines.iter();
    for command in commands.filter_map(|line| line.strip_prefix("cargo xtask ")) {
        let name = command.split_whitespace().next().unwrap_or_default();
        let is_command = crate::is_command(name);
        ensure!(is_command, "there is no `cargo xtask {name}`");
    }
    Ok(())
}
