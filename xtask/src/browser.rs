//! A report page in a real browser: headless Chromium without a network.

use std::fs;
use std::path::Path;
use std::time::Duration;

use anyhow::{Result, bail, ensure};
use preslide_tools::process::{command, output_for, with_folder};

/// A page of 8 MB is drawn in 5 s on a slow machine.
const LIMIT: Duration = Duration::from_secs(60);

/// Of a page with plotly.js, which is most of it.
const LARGEST: usize = 1_500_000;

/// Without a sandbox, which a container has no right to; on a laptop's screen, the height that of a few figures.
const CHROMIUM: &str = "chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking \
    --disable-component-update --disable-sync --window-size=1366,2400 --virtual-time-budget=8000 --enable-logging=stderr --dump-dom";

/// Begin of a figure; before its script has run it is an empty box.
const PLOT: &str = "<div class=\"plot\"";

/// Widths of a phone and of a small laptop.
const WIDTHS: [u32; 2] = [390, 1280];

/// Says to the page around it what is cut or lies on something else.
const LAYOUT: &str = "<script>addEventListener('load', () => setTimeout(() => {
  const faults = [], root = document.documentElement;
  if (root.scrollWidth > root.clientWidth) faults.push(`the page is ${root.scrollWidth} px wide`);
  for (const plot of document.querySelectorAll('.plotly-graph-div')) {
    const whole = plot.getBoundingClientRect(), boxes = [];
    for (const part of ['.modebar', '.legend .bg', '.xtitle', '.ytitle', '.nsewdrag']) {
      const box = plot.querySelector(part)?.getBoundingClientRect();
      if (!box?.width) continue;
      if (box.left < whole.left - 1 || box.right > whole.right + 1 || box.top < whole.top - 1 || box.bottom > whole.bottom + 1)
        faults.push(`${plot.id}: ${part} is cut`);
      for (const [other, b] of boxes)
        if (box.left < b.right - 1 && b.left < box.right - 1 && box.top < b.bottom - 1 && b.top < box.bottom - 1)
          faults.push(`${plot.id}: ${part} lies on ${other}`);
      boxes.push([part, box]);
    }
  }
  parent.postMessage(faults.join('; ') || 'nothing', '*');
}, 200));</script>";

/// Whether the page has its parameters before its figures, draws them with a title and a unit on both axes, cuts nothing, and asks
/// nothing of the network: its own policy forbids that, and the browser says what it refused.
pub fn check(page: &Path) -> Result<()> {
    let html = fs::read_to_string(page)?;
    for width in WIDTHS {
        let faults = faults(&html, width)?;
        ensure!(
            faults == "nothing",
            "{}, {width} px wide: {faults}",
            page.display()
        );
    }
    let (page, bytes) = (page.display(), html.len());
    ensure!(bytes < LARGEST, "{page}: {bytes} bytes");
    let (dom, log) = with_folder("browser", |folder| dump(folder, &format!("file://{page}")))?;
    let said: Vec<&str> = log.lines().filter(|l| l.contains("CONSOLE")).collect();
    ensure!(said.is_empty(), "{page}: {}", said.join("\n"));
    let figures = dom.matches(PLOT).count();
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
    let parameters = dom.find("<th>parameter</th>");
    ensure!(
        parameters.is_some() && parameters < dom.find(PLOT),
        "{page}: no table of parameters stands before the first figure"
    );
    println!("{figures} figures drawn by Chromium, all axes with units, no request refused");
    Ok(())
}

/// What a page so many pixels wide cuts or covers. Chromium's own windows are no narrower than 500.
fn faults(html: &str, width: u32) -> Result<String> {
    let (dom, _) = with_folder("browser", |folder| {
        fs::write(folder.join("page.html"), format!("{html}{LAYOUT}"))?;
        let frame = format!(
            "<iframe src='page.html' style='width: {width}px; height: 2000px; border: 0'></iframe><pre></pre>\
             <script>onmessage = (told) => document.querySelector('pre').textContent = told.data</script>"
        );
        fs::write(folder.join("frame.html"), frame)?;
        dump(folder, &format!("file://{}/frame.html", folder.display()))
    })?;
    let told = dom
        .split_once("<pre>")
        .and_then(|(_, rest)| rest.split_once("</pre>"));
    Ok(told.map_or("no answer", |(told, _)| told).to_owned())
}

/// A page after its scripts, and what the browser said; its own files in a folder.
fn dump(folder: &Path, page: &str) -> Result<(String, String)> {
    let mut chromium = command(CHROMIUM);
    chromium.arg(format!(
        "--user-data-dir={}",
        folder.join("profile").display()
    ));
    output_for(chromium.arg(page), LIMIT)
}

/// The texts of all titles of an axis.
fn titles<'a>(dom: &'a str, axis: &str) -> Vec<&'a str> {
    let begin = format!("<text class=\"{axis}\"");
    let of = |rest: &'a str| Some(rest.split_once('>')?.1.split_once('<')?.0);
    dom.split(&begin).skip(1).filter_map(of).collect()
}
