//! `cargo xtask imports`: who imports whom, read from the sources, held against ARCHITECTURE.md.
//!
//! Two rules, checked without compiling anything:
//! - **No circles.** In every folder, what one module (with all that it holds) imports of its siblings leads nowhere back. A
//!   module may use what its parent itself defines; a name that the parent only hands on counts as the sibling's that has it.
//! - **The order of the rooms.** The top modules of a crate stand in ARCHITECTURE.md in a block `imports: FOLDER`, and each
//!   imports only from lines above its own.
//!
//! Tests are no part of it: they may look at everything.

mod graph;
mod source;
mod tree;

use crate::process::root;
use graph::circle;
use std::path::Path;
use tree::{Edge, Tree};

/// Folders of sources that are one crate each.
const CRATES: [&str; 12] = [
    "src",
    "fit/src",
    "host/src",
    "sim/src",
    "cli/src",
    "host-tests/src",
    "drive/src",
    "link/src",
    "axis/src",
    "store/src",
    "firmware/app/src",
    "xtask/src",
];

/// Siblings that may name each other: effects that one recording cannot separate. Each lists the other by its type; nothing is
/// computed in a circle.
const ALIKE: [(&str, &str, &str); 4] = [
    ("diagnose::effect", "constant_force", "coulomb_asymmetry"),
    ("diagnose::effect", "stribeck", "frictional_lag"),
    ("diagnose::effect", "gravity", "position_spring"),
    ("diagnose::effect", "run_in", "thermal_drift"),
];

/// The page that gives the order.
const PAGE: &str = "ARCHITECTURE.md";

/// Reads every crate, and says what breaks the rules.
pub fn run_command(arguments: &[String]) -> Result<(), String> {
    crate::given("imports", &[], arguments)?;
    let path = root().join(PAGE);
    let page = std::fs::read_to_string(&path).map_err(|error| format!("{PAGE}: {error}"))?;
    let mut wrong = Vec::new();
    for name in CRATES {
        let tree = Tree::read(&root().join(name))?;
        let edges = tree.edges();
        let circles = circles(&tree, &edges);
        println!(
            "{name}: {} files, {} imports between siblings, {} circles",
            tree.files().count(),
            edges.len(),
            circles.len()
        );
        wrong.extend(circles.into_iter().map(|words| format!("{name}: {words}")));
        if let Some(order) = order(&page, name) {
            wrong.extend(out_of_order(name, &order, &tree, &edges));
        }
    }
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(wrong.join("\n"))
    }
}

/// The circles of every folder, each with the files and names that close it.
fn circles(tree: &Tree, edges: &[Edge]) -> Vec<String> {
    let folders = tree.folders();
    let found = folders.iter().flat_map(|folder| {
        let here: Vec<&Edge> = edges.iter().filter(|edge| edge.folder == *folder).collect();
        let mut pairs: Vec<_> = here
            .iter()
            .map(|e| (e.from.as_str(), e.to.as_str()))
            .filter(|(from, to)| !ALIKE.contains(&(folder, from, to)))
            .collect();
        let mut told = Vec::new();
        while let Some(round) = circle(&pairs) {
            let ties: Vec<String> = here
                .iter()
                .filter(|e| round.windows(2).any(|two| two == [&e.from, &e.to]))
                .map(|e| format!("\n    {} takes {}", e.file.display(), e.name))
                .collect();
            told.push(format!("a circle, {}:{}", round.join(" → "), ties.concat()));
            // Other circles show once this one is open.
            pairs.retain(|pair| *pair != (round[0], round[1]));
        }
        told
    });
    found.collect()
}

/// The lines of the block that gives the order of a crate's rooms, lowest first: the words before a ` — `.
fn order<'a>(page: &'a str, name: &str) -> Option<Vec<Vec<&'a str>>> {
    let head = format!("```text imports: {name}\n");
    let block = page.split_once(&head)?.1;
    let block = block.split("```").next()?;
    let rooms = |line: &'a str| {
        line.split(" — ")
            .next()
            .unwrap_or("")
            .split_whitespace()
            .collect()
    };
    Some(block.lines().map(rooms).collect())
}

/// Rooms that the page does not name, names without a room, and imports from the same line or one below.
fn out_of_order(name: &str, order: &[Vec<&str>], tree: &Tree, edges: &[Edge]) -> Vec<String> {
    let floor = |room: &str| order.iter().position(|line| line.contains(&room));
    let rooms = tree.rooms();
    let unnamed = rooms
        .iter()
        .filter(|room| floor(room).is_none())
        .map(|room| {
            format!("{PAGE}: `{name}` has a room `{room}` that no line of its order names")
        });
    let gone = order
        .iter()
        .flatten()
        .filter(|room| !rooms.iter().any(|r| r == *room))
        .map(|room| format!("{PAGE}: `{name}` has no room `{room}`"));
    let upward = edges
        .iter()
        .filter(|e| e.folder.is_empty())
        .filter_map(|e| {
            let (from, to) = (floor(&e.from)?, floor(&e.to)?);
            (to >= from).then(|| {
                format!(
                    "{name}: {} takes {} from `{}`, which {PAGE} does not place above `{}`",
                    e.file.display(),
                    e.name,
                    e.to,
                    e.from
                )
            })
        });
    unnamed.chain(gone).chain(upward).collect()
}

/// A path as it is printed: from the root of the project.
fn from_root(path: &Path) -> &Path {
    path.strip_prefix(root()).unwrap_or(path)
}

#[cfg(test)]
mod tests;
