//! A report page in a real browser: headless Chromium without a network.

use std::path::Path;
use std::time::Duration;

use anyhow::{Result, bail, ensure};
use preslide_tools::process::{command, output_for, with_folder};

/// A page of 8 MB is drawn in 5 s on a slow machine.
const LIMIT: Duration = Duration::from_secs(60);

/// Without a sandbox, which a container has no right to; on a laptop's screen, the height that of a few figures.
const CHROMIUM: &str = "chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking \
    --disable-component-update --disable-sync --window-size=1366,2400 --virtual-time-budget=8000 --enable-logging=stderr --dump-dom";

/// Whether every figure of the page is drawn, with a title and a unit on both axes, and nothing was asked of the network: the
/// page's own policy forbids that, and the browser says what it refused.
pub fn check(page: &Path) -> Result<()> {
    let page = page.display();
    let (dom, log) = with_folder("browser", |profile| {
        let mut chromium = command(CHROMIUM);
        chromium.arg(format!("--user-data-dir={}", profile.display()));
        output_for(chromium.arg(format!("file://{page}")), LIMIT)
    })?;
    let said: Vec<&str> = log.lines().filter(|l| l.contains("CONSOLE")).collect();
    ensure!(said.is_empty(), "{page}: {}", said.join("\n"));
    // Before its script has run a plot is an empty box.
    let figures = dom.matches("<div class=\"plot\">").count();
    let drawn = dom.matches("<g class=\"cartesianlayer\">").count();
    let titles = ["xtitle", "ytitle"].map(|axis| titles(&dom, axis));
    let [x, y] = titles.each_ref().map(Vec::len);
    ensure!(
        figures > 0 && [drawn, x, y] == [figures; 3],
        "{page}: of {figures} figures {drawn} are drawn, {x} with a horizontal and {y} with a vertical title"
    );
    if let Some(bare) = titles.iter().flatten().find(|title| !title.ends_with(']')) {
        bail!("{page}: the axis `{bare}` has no unit");
    }
    println!("{figures} figures drawn by Chromium, all axes with units, no request refused");
    Ok(())
}

/// The texts of all titles of an axis.
fn titles<'a>(dom: &'a str, axis: &str) -> Vec<&'a str> {
    let begin = format!("<text class=\"{axis}\"");
    let of = |rest: &'a str| Some(rest.split_once('>')?.1.split_once('<')?.0);
    dom.split(&begin).skip(1).filter_map(of).collect()
}
