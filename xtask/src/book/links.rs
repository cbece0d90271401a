//! Links between pages, and the project's files that the text names.

use super::page::Page;
use crate::process::root;

/// Folders whose files the text names in backticks.
const FOLDERS: [&str; 10] = [
    "src/",
    "cli/",
    "fit/",
    "host/",
    "host-tests/",
    "link/",
    "sim/",
    "firmware/",
    "xtask/",
    "docs/",
];

/// Every link inside the book leads to a page and a heading that exist, and every file named exists.
pub fn check(pages: &[Page]) -> Result<(), String> {
    let mut broken = Vec::new();
    for page in pages {
        let prose = prose(&page.text);
        for target in prose
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
        {
            if target.starts_with("http://") || target.starts_with("https://") {
                continue;
            }
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let there = if file.is_empty() {
                Some(page)
            } else {
                pages.iter().find(|other| other.name == file)
            };
            // A picture stands beside the pages.
            let is_picture =
                || file.ends_with(".svg") && root().join("docs/src").join(file).is_file();
            match there {
                None if is_picture() => {}
                None => broken.push(format!("{}: no page `{target}`", page.name)),
                Some(other)
                    if !heading.is_empty()
                        && !headings(&other.text).contains(&heading.to_string()) =>
                {
                    broken.push(format!("{}: no heading `{target}`", page.name));
                }
                Some(_) => {}
            }
        }
        for code in prose.split('`').skip(1).step_by(2) {
            let is_file = FOLDERS.iter().any(|folder| code.starts_with(folder));
            if is_file && !code.contains([' ', '*', '…']) && !root().join(code).exists() {
                broken.push(format!("{}: no file `{code}`", page.name));
            }
        }
    }
    if broken.is_empty() {
        Ok(())
    } else {
        Err(broken.join("\n"))
    }
}

/// The text without its fenced blocks.
fn prose(text: &str) -> String {
    let mut inside = false;
    let lines = text.lines().filter(|line| {
        let fence = line.starts_with("```");
        inside ^= fence;
        !inside && !fence
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// The anchors that mdBook gives the headings.
fn headings(text: &str) -> Vec<String> {
    let prose = prose(text);
    let titles = prose.lines().filter(|line| line.starts_with('#'));
    titles
        .map(|line| {
            let title = line.trim_start_matches('#').trim().to_lowercase();
            let kept = title.chars().filter_map(|c| match c {
                ' ' | '-' => Some('-'),
                c if c.is_alphanumeric() || c == '_' => Some(c),
                _ => None,
            });
            kept.collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{headings, prose};

    #[test]
    fn headings_become_anchors_and_blocks_are_no_prose() {
        let text = "# What N costs, and why\n```sh\n# no heading\n```\n## Two-state\n";
        assert_eq!(headings(text), ["what-n-costs-and-why", "two-state"]);
        assert!(!prose(text).contains("no heading"));
    }
}
