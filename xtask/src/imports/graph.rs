//! A circle in a graph of names.

use std::collections::{BTreeMap, BTreeSet};

/// A way from a name back to itself, if there is one: its first name stands again at its end.
pub fn circle<'a>(edges: &[(&'a str, &'a str)]) -> Option<Vec<&'a str>> {
    let mut next: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for &(from, to) in edges {
        next.entry(from).or_default().insert(to);
    }
    let mut done = BTreeSet::new();
    next.keys()
        .find_map(|start| walk(start, &next, &mut Vec::new(), &mut done))
}

fn walk<'a>(
    here: &'a str,
    next: &BTreeMap<&'a str, BTreeSet<&'a str>>,
    way: &mut Vec<&'a str>,
    done: &mut BTreeSet<&'a str>,
) -> Option<Vec<&'a str>> {
    if let Some(start) = way.iter().position(|name| *name == here) {
        return Some([&way[start..], &[here]].concat());
    }
    if !done.insert(here) {
        return None;
    }
    way.push(here);
    let found = next
        .get(here)
        .into_iter()
        .flatten()
        .find_map(|to| walk(to, next, way, done));
    way.pop();
    found
}
