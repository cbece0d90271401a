//! `cargo xtask imports`: who imports whom, read from the sources, held against ARCHITECTURE.md.
//!
//! Two rules, checked without compiling anything:
//! - **No circles.** In every folder, what one module (with all that it holds) imports of its siblings leads nowhere back. A
//!   module may use what its parent itself defines; a name that the parent only hands on counts as the sibling's that has it.
//! - **The order of the rooms.** The top modules of a crate stand in ARCHITECTURE.md in a block `imports: FOLDER`, and each
//!   imports only from lines above its own.
//!
//! Tests are no part of it: they may look at everything.

mod source;
mod tree;

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, ensure};
use fs_err as fs;
use preslide_tools::process::{command, output, root};

use tree::{Edge, Tree};

/// The page that gives the order.
const PAGE: &str = "ARCHITECTURE.md";

/// Where each function of these sources stands decides what is counted of it: they are not rearranged for a rule.
const COUNTED: &str = "firmware/cycles/src";

/// Reads every crate of the project, and says what breaks the rules.
pub fn check() -> Result<()> {
    let page = fs::read_to_string(root().join(PAGE))?;
    let manifests = output(command("git ls-files *Cargo.toml").current_dir(root()))?;
    let folders = manifests
        .lines()
        .map(|file| file.replace("Cargo.toml", "src"));
    let mut wrong = Vec::new();
    for name in folders.filter(|name| root().join(name).is_dir()) {
        if name == COUNTED {
            println!("{name}: not looked at, since its cycles are counted");
            continue;
        }
        let tree = Tree::read(&root().join(&name))?;
        let edges = tree.edges();
        let circles = circles(&edges);
        println!(
            "{name}: {} files, {} imports between siblings, {} of them in circles",
            tree.0.len(),
            edges.len(),
            circles.len()
        );
        wrong.extend(
            circles
                .iter()
                .map(|edge| format!("{name}: {edge}, in a circle")),
        );
        let order = order(&page, &name);
        let breaches = order.map(|order| out_of_order(&order, &tree, &edges));
        wrong.extend(
            breaches
                .iter()
                .flatten()
                .map(|breach| format!("{name}: {breach}")),
        );
    }
    ensure!(wrong.is_empty(), "{}", wrong.join("\n"));
    Ok(())
}

/// What a module takes of a sibling that takes, itself or through others, of it, too: what is left of a folder's imports once those from a
/// module that nothing is taken of, and those from one that takes nothing, are left out again and again.
fn circles(edges: &[Edge]) -> Vec<&Edge> {
    let mut left: Vec<&Edge> = edges.iter().collect();
    loop {
        let count = left.len();
        let takes: BTreeSet<_> = left.iter().map(|e| (&e.folder, &e.from)).collect();
        left.retain(|e| takes.contains(&(&e.folder, &e.to)));
        let gives: BTreeSet<_> = left.iter().map(|e| (&e.folder, &e.to)).collect();
        left.retain(|e| gives.contains(&(&e.folder, &e.from)));
        if left.len() == count {
            return left;
        }
    }
}

/// The rooms of a crate by their line in its block, the lowest first: the words before a ` — `.
fn order<'a>(page: &'a str, name: &str) -> Option<BTreeMap<&'a str, usize>> {
    let (_, block) = page.split_once(&format!("```text imports: {name}\n"))?;
    let lines = block.split("```").next()?.lines().enumerate();
    let rooms = lines.flat_map(|(floor, line)| {
        let rooms = line.split(" — ").next().unwrap_or_default();
        rooms.split_whitespace().map(move |room| (room, floor))
    });
    Some(rooms.collect())
}

/// Rooms that the page does not name, names without a room, and imports from the same line or one below.
fn out_of_order(order: &BTreeMap<&str, usize>, tree: &Tree, edges: &[Edge]) -> Vec<String> {
    let (rooms, named) = (tree.rooms(), order.keys().copied().collect());
    let unnamed = rooms
        .difference(&named)
        .map(|room| format!("no line of its order in {PAGE} names the room `{room}`"));
    let gone = named
        .difference(&rooms)
        .map(|room| format!("{PAGE} names `{room}`, which is no room"));
    let floor = |room: &String| order.get(room.as_str());
    let between_rooms = edges.iter().filter(|e| e.folder.is_empty());
    let upward = between_rooms.filter(|e| {
        let (from, to) = (floor(&e.from), floor(&e.to));
        from.is_some_and(|from| to >= Some(from))
    });
    let upward = upward.map(|e| format!("{e}, which {PAGE} does not place above"));
    unnamed.chain(gone).chain(upward).collect()
}

#[cfg(test)]
mod tests;
