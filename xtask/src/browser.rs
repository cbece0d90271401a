//! A report page in a real browser: headless Chromium without a network.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::process::output_for;

/// A page of 8 MB is drawn in 5 s on a slow machine.
const LIMIT: Duration = Duration::from_secs(60);

/// A laptop's screen, the height that of a few figures.
const FLAGS: &[&str] = &[
    "--headless",
    // Which a container has no right to.
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1366,2400",
    "--virtual-time-budget=8000",
    "--enable-logging=stderr",
];

/// Whether every figure of the page is drawn, with a title and a unit on both axes, and nothing was asked of the network: the
/// page's own policy forbids that, and the browser says what it refused.
pub fn check(page: &Path) -> Result<(), String> {
    let profile = std::env::temp_dir().join(format!("preslide-browser-{}", std::process::id()));
    let mut chromium = Command::new("chromium");
    chromium
        .args(FLAGS)
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg("--dump-dom")
        .arg(format!("file://{}", page.display()));
    let shown = output_for(&mut chromium, LIMIT);
    // The next run makes its own.
    let _ = std::fs::remove_dir_all(&profile);
    let (dom, log) = shown?;
    let said: Vec<&str> = log
        .lines()
        .filter(|line| line.contains("CONSOLE"))
        .collect();
    if !said.is_empty() {
        return Err(format!("{}: {}", page.display(), said.join("\n")));
    }
    // Before its script has run a plot is an empty box.
    let figures = dom.matches("<div class=\"plot\">").count();
    let drawn = dom.matches("<g class=\"cartesianlayer\">").count();
    let titles = ["xtitle", "ytitle"].map(|axis| titles(&dom, axis));
    let [x, y] = titles.each_ref().map(Vec::len);
    if figures == 0 || drawn != figures || x != figures || y != figures {
        return Err(format!(
            "{}: of {figures} figures {drawn} are drawn, {x} with a horizontal and {y} with a vertical title",
            page.display()
        ));
    }
    if let Some(bare) = titles.iter().flatten().find(|title| !title.ends_with(']')) {
        return Err(format!("{}: the axis `{bare}` has no unit", page.display()));
    }
    println!("{figures} figures drawn by Chromium, all axes with units, no request refused");
    Ok(())
}

/// The texts of all titles of an axis.
fn titles<'a>(dom: &'a str, axis: &str) -> Vec<&'a str> {
    let begin = format!("<text class=\"{axis}\"");
    let of = |rest: &'a str| {
        rest.split_once('>')?
            .1
            .split_once('<')
            .map(|(text, _)| text)
    };
    dom.split(&begin).skip(1).filter_map(of).collect()
}
