//! The modules of one crate, and what siblings take from each other.

use super::source::{Import, code, defines, imports, spelled_out};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Where a module stands in its crate: `["control", "faults"]`.
type Place = Vec<String>;

/// One file.
struct Module {
    file: PathBuf,
    code: String,
    imports: Vec<Import>,
}

impl Module {
    /// Every path that it names, without those that another only continues.
    fn paths(&self) -> Vec<Vec<String>> {
        let used = self.imports.iter().map(|import| import.path.clone());
        let paths: BTreeSet<_> = used.chain(spelled_out(&self.code)).collect();
        // Sorted, a path stands right before those that continue it.
        let next = paths.iter().skip(1).map(Some).chain([None]);
        let whole = paths
            .iter()
            .zip(next)
            .filter(|(path, next)| !next.is_some_and(|next| next.starts_with(path)));
        whole.map(|(path, _)| path.clone()).collect()
    }
}

/// The files of one crate by their place.
pub struct Tree {
    modules: BTreeMap<Place, Module>,
}

/// A module takes something from a sibling.
#[derive(Debug, PartialEq)]
pub struct Edge {
    /// The module that holds both, by its names joined; empty for the crate itself.
    pub folder: String,
    /// The sibling that takes.
    pub from: String,
    /// The sibling that gives.
    pub to: String,
    /// The file that takes.
    pub file: PathBuf,
    /// What, as written.
    pub name: String,
}

/// Re-exports of re-exports end somewhere.
const DEEPEST: usize = 8;

impl Tree {
    /// Reads a crate's folder of sources.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let mut sources = Vec::new();
        collect(folder, folder, &mut sources)?;
        Ok(Self::new(sources))
    }

    /// From files, named from the crate's folder, and their texts.
    pub fn new(sources: Vec<(PathBuf, String)>) -> Self {
        let modules = sources.into_iter().map(|(file, text)| {
            let code = code(&text);
            let imports = imports(&code);
            let module = Module {
                file: file.clone(),
                code,
                imports,
            };
            (place(&file), module)
        });
        Self {
            modules: modules.collect(),
        }
    }

    /// Every file.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.modules.values().map(|module| module.file.as_path())
    }

    /// The modules right under the crate.
    pub fn rooms(&self) -> Vec<String> {
        let first = self
            .modules
            .keys()
            .filter_map(|place| place.first().cloned());
        first.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Every module that holds others, the crate first.
    pub fn folders(&self) -> Vec<String> {
        let parents = self.modules.keys().filter(|place| !place.is_empty());
        let parents = parents.map(|place| place[..place.len() - 1].join("::"));
        parents.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// What siblings take from each other.
    pub fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (place, module) in &self.modules {
            for path in module.paths() {
                let Some(giver) = self.giver(place, &path, 0) else {
                    continue;
                };
                let shared = place.iter().zip(&giver).take_while(|(a, b)| a == b).count();
                if let (Some(from), Some(to)) = (place.get(shared), giver.get(shared)) {
                    edges.push(Edge {
                        folder: place[..shared].join("::"),
                        from: from.clone(),
                        to: to.clone(),
                        file: module.file.clone(),
                        name: path.join("::"),
                    });
                }
            }
        }
        edges
    }

    /// The module whose file has what `path`, written at `here`, means; `None` for other crates.
    fn giver(&self, here: &[String], path: &[String], depth: usize) -> Option<Place> {
        let (mut at, mut rest): (Place, &[String]) = match path.first()?.as_str() {
            "crate" => (Vec::new(), &path[1..]),
            "self" => (here.to_vec(), &path[1..]),
            "super" => (here[..here.len().checked_sub(1)?].to_vec(), &path[1..]),
            // A child of this module, named without `self::`.
            first => {
                let mut child = here.to_vec();
                child.push(first.to_owned());
                self.modules
                    .contains_key(&child)
                    .then_some((child, &path[1..]))?
            }
        };
        while rest.first().is_some_and(|s| s == "super") {
            at.pop()?;
            rest = &rest[1..];
        }
        while let Some(name) = rest.first() {
            let mut deeper = at.clone();
            deeper.push(name.clone());
            if !self.modules.contains_key(&deeper) {
                break;
            }
            (at, rest) = (deeper, &rest[1..]);
        }
        let handed_on = rest.first().filter(|_| depth < DEEPEST);
        handed_on
            .and_then(|name| self.handed_on(&at, name, depth))
            .or_else(|| self.modules.contains_key(&at).then_some(at))
    }

    /// The module that a name comes from which `at` itself imports.
    fn handed_on(&self, at: &[String], name: &str, depth: usize) -> Option<Place> {
        let module = self.modules.get(at)?;
        if defines(&module.code, name) {
            return None;
        }
        let named = module.imports.iter().find(|import| import.alias == name);
        if let Some(import) = named {
            return self.giver(at, &import.path, depth + 1);
        }
        let globs = module.imports.iter().filter(|import| import.alias == "*");
        globs
            .filter_map(|import| self.giver(at, &import.path, depth + 1))
            .find(|place| {
                self.modules
                    .get(place)
                    .is_some_and(|m| defines(&m.code, name))
            })
    }
}

/// `control/mod.rs` and `control.rs` are `["control"]`; `lib.rs` and `main.rs` are the crate.
fn place(file: &Path) -> Place {
    let mut names: Vec<String> = file
        .with_extension("")
        .iter()
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    let last = names.last().map(String::as_str);
    if ["mod", "lib", "main"].map(Some).contains(&last) {
        names.pop();
    }
    names
}

/// Every source under a folder that is no test, by its name from the crate's folder.
fn collect(root: &Path, folder: &Path, found: &mut Vec<(PathBuf, String)>) -> Result<(), String> {
    let why = |error: std::io::Error| format!("{}: {error}", super::from_root(folder).display());
    for entry in std::fs::read_dir(folder).map_err(why)? {
        let path = entry.map_err(why)?.path();
        if path.file_stem().is_some_and(|name| name == "tests") {
            continue;
        }
        if path.is_dir() {
            collect(root, &path, found)?;
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&path).map_err(why)?;
            let name = path.strip_prefix(root).unwrap_or(&path).to_owned();
            found.push((name, text));
        }
    }
    Ok(())
}
