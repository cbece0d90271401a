//! Links between pages, and the project's files that the text names.

use anyhow::{Result, bail};
use preslide_tools::process::root;

use super::page::{Page, links};

/// Folders whose files the text names in backticks.
const FOLDERS: [&str; 13] = [
    "src/",
    "cli/",
    "cycles/",
    "docs/",
    "emulated/",
    "firmware/",
    "fit/",
    "host-tests/",
    "host/",
    "link/",
    "sim/",
    "tools/",
    "xtask/",
];

/// Every link inside the book leads to a page and a heading that exist, and every file named exists.
pub fn check(pages: &[Page]) -> Result<()> {
    let mut broken = Vec::new();
    for page in pages {
        let inside =
            |target: &&str| !target.starts_with("http://") && !target.starts_with("https://");
        for target in links(&page.prose).filter(inside) {
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let mut others = pages.iter();
            let there = match file {
                "" => Some(page),
                file => others.find(|other| other.name == file),
            };
            // A picture, or the schema, stands beside the pages.
            let is_there = match there {
                Some(page) => heading.is_empty() || headings(&page.prose).any(|h| h == heading),
                None => !file.ends_with(".md") && root().join("docs/src").join(file).is_file(),
            };
            if !is_there {
                broken.push(format!("{}: no page or heading `{target}`", page.name));
            }
        }
        for code in page.prose.split('`').skip(1).step_by(2) {
            let is_file = FOLDERS.iter().any(|folder| code.starts_with(folder));
            if is_file && !code.contains([' ', '*', '…']) && !root().join(code).exists() {
                broken.push(format!("{}: no file `{code}`", page.name));
            }
        }
    }
    if !broken.is_empty() {
        bail!(broken.join("\n"));
    }
    Ok(())
}

/// The anchors that mdBook gives the headings.
fn headings(prose: &str) -> impl Iterator<Item = String> {
    let titles = prose.lines().filter(|line| line.starts_with('#'));
    titles.map(|line| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::headings;

    #[test]
    fn headings_become_anchors() {
        let found: Vec<String> = headings("# What N costs, and why\n## Two-state\n").collect();
        assert_eq!(found, ["what-n-costs-and-why", "two-state"]);
    }
}
