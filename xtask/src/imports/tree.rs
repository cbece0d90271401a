//! The modules of one crate, and what siblings take from each other.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;

use anyhow::{Context as _, Result};
use fs_err as fs;

use crate::files::files;

use super::source::{self, Source};

/// Where a module stands in its crate: `["control", "faults"]`.
type Place = source::Path;

/// The files of one crate, each with its name from the crate's folder, by their place.
pub struct Tree(pub BTreeMap<Place, (String, Source)>);

/// A module takes something from a sibling.
pub struct Edge {
    /// The module that holds both, by its names joined; empty for the crate itself.
    pub folder: String,
    /// The sibling that takes.
    pub from: String,
    /// The sibling that gives.
    pub to: String,
    file: String,
    /// What, as written.
    name: String,
}

impl fmt::Display for Edge {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            file,
            name,
            from,
            to,
            ..
        } = self;
        write!(out, "{file} takes {name}: `{from}` from `{to}`")
    }
}

/// Re-exports of re-exports end somewhere.
const DEEPEST: usize = 8;

impl Tree {
    /// Reads a crate's folder of sources, but for tests.
    pub fn read(folder: &Path) -> Result<Self> {
        let mut texts = Vec::new();
        for file in files(folder, "rs")? {
            let name = file.strip_prefix(folder)?;
            if name.with_extension("").iter().all(|part| part != "tests") {
                texts.push((name.display().to_string(), fs::read_to_string(&file)?));
            }
        }
        Self::new(
            texts
                .iter()
                .map(|(name, text)| (name.as_str(), text.as_str())),
        )
    }

    /// From files, named from the crate's folder, and their texts.
    pub fn new<'a>(texts: impl Iterator<Item = (&'a str, &'a str)>) -> Result<Self> {
        let modules = texts.map(|(name, text)| {
            let source = Source::read(text).with_context(|| name.to_owned())?;
            Ok((place(name), (name.to_owned(), source)))
        });
        Ok(Self(modules.collect::<Result<_>>()?))
    }

    /// The modules right under the crate.
    pub fn rooms(&self) -> BTreeSet<&str> {
        let first = self.0.keys().filter_map(|place| place.first());
        first.map(String::as_str).collect()
    }

    /// What siblings take from each other.
    pub fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (place, (file, source)) in &self.0 {
            let mut paths = source.spelled_out.clone();
            paths.extend(source.imports.iter().map(|import| import.path.clone()));
            for path in paths {
                let Some(giver) = self.giver(place, &path, 0) else {
                    continue;
                };
                let shared = place.iter().zip(&giver).take_while(|(a, b)| a == b).count();
                if let (Some(from), Some(to)) = (place.get(shared), giver.get(shared)) {
                    edges.push(Edge {
                        folder: place[..shared].join("::"),
                        from: from.clone(),
                        to: to.clone(),
                        file: file.clone(),
                        name: path.join("::"),
                    });
                }
            }
        }
        edges
    }

    /// The module whose file has what `path`, written at `here`, means; `None` for other crates.
    fn giver(&self, here: &[String], path: &[String], depth: usize) -> Option<Place> {
        let (mut at, mut rest) = match path.first()?.as_str() {
            "crate" => (Vec::new(), &path[1..]),
            "self" => (here.to_vec(), &path[1..]),
            _ => (here.to_vec(), path),
        };
        while let Some((name, others)) = rest.split_first() {
            if name == "super" {
                at.pop()?;
            } else {
                at.push(name.clone());
                if !self.0.contains_key(&at) {
                    at.pop();
                    break;
                }
            }
            rest = others;
        }
        if rest.len() == path.len() {
            return None;
        }
        let name = rest.first().filter(|_| depth < DEEPEST);
        let handed_on = name.and_then(|name| {
            // What it imports itself, by name or with all else; any other name is its own.
            let imports = &self.0.get(&at)?.1.imports;
            let of = |alias: &str| imports.iter().find(|import| import.alias == alias);
            self.giver(&at, &of(name).or(of("*"))?.path, depth + 1)
        });
        handed_on.or_else(|| self.0.contains_key(&at).then_some(at))
    }
}

/// `control/mod.rs` and `control.rs` are `["control"]`; `lib.rs` and `main.rs` are the crate.
fn place(file: &str) -> Place {
    let path = file.trim_end_matches(".rs");
    let mut names: Vec<String> = path.split('/').map(String::from).collect();
    names.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
    names
}
