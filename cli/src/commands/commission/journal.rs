//! What a commissioning has done so far, kept in its folder: the same command goes on from there.

use super::super::Failure;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The file in the folder.
const FILE: &str = "commission.json";
const SCHEMA: &str = "preslide.commissioning/1";

/// What was done.
#[derive(Debug, Serialize, Deserialize)]
pub struct Journal {
    schema: String,
    /// The axis and the limits that it was begun with.
    of: String,
    /// Share of the feed-forward that the controller had before it began.
    #[serde(default)]
    pub share: Option<f64>,
    /// By the recording's name.
    pub played: BTreeMap<String, Played>,
    /// Experiments, in their order.
    pub asked: Vec<Asked>,
    #[serde(skip)]
    folder: PathBuf,
}

/// A motion that was followed.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Played {
    /// Following error (10⁻⁹ m or rad).
    pub rms: f64,
    pub largest: f64,
}

/// An experiment.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Asked {
    /// Its recording's name.
    pub name: String,
    /// Effects that it was for, by id.
    pub about: Vec<String>,
    /// The result in words.
    pub answer: Option<String>,
}

impl Journal {
    /// Of a folder, which is made where there is none; `of` says in words what is commissioned.
    pub fn open(folder: &Path, of: String) -> Result<Self, Failure> {
        let unwritable = |error: std::io::Error| {
            Failure::Tool(format!(
                "-o {}: {error}; name a folder that can be written",
                folder.display()
            ))
        };
        std::fs::create_dir_all(folder).map_err(unwritable)?;
        let path = folder.join(FILE);
        let begun = match std::fs::read_to_string(&path) {
            Ok(text) => serde_json::from_str::<Self>(&text).map_err(|error| {
                Failure::Input(format!(
                    "{}: {error}; this command did not write it: name another folder",
                    path.display()
                ))
            })?,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Self {
                schema: SCHEMA.to_owned(),
                of: of.clone(),
                share: None,
                played: BTreeMap::new(),
                asked: Vec::new(),
                folder: PathBuf::new(),
            },
            Err(error) => return Err(unwritable(error)),
        };
        if begun.of != of {
            return Err(Failure::Input(format!(
                "-o {}: an earlier run there had {}, and this one has {of}; name another folder, or repeat those settings",
                folder.display(),
                begun.of
            )));
        }
        Ok(Self {
            folder: folder.to_owned(),
            ..begun
        })
    }

    /// A file of the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The motion that a recording follows.
    pub fn motion(&self, name: &str) -> PathBuf {
        self.file(&format!("{name}-motion.csv"))
    }

    /// Writes that motion.
    pub fn write_motion(&self, name: &str, text: &str) -> Result<(), Failure> {
        self.write(&format!("{name}-motion.csv"), text).map(|_| ())
    }

    /// Writes it down.
    pub fn keep(&self) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self).map_err(|e| Failure::Tool(e.to_string()))?;
        self.write(FILE, &(text + "\n")).map(|_| ())
    }

    /// Recordings of the machine under feedback alone.
    pub fn recordings(&self) -> Vec<PathBuf> {
        let asked = self.asked.iter().map(|asked| asked.name.as_str());
        let names = std::iter::once("before").chain(asked);
        let played = names.filter(|name| self.played.contains_key(*name));
        played
            .map(|name| self.file(&format!("{name}.csv")))
            .collect()
    }

    /// Effects that an experiment was for.
    pub fn about(&self) -> Vec<String> {
        self.asked
            .iter()
            .flat_map(|asked| asked.about.clone())
            .collect()
    }

    /// Writes a file of the folder, without a word: at the end the folder is named.
    pub fn write(&self, name: &str, text: &str) -> Result<PathBuf, Failure> {
        let path = self.file(name);
        let part = self.file("being-written.part");
        std::fs::write(&part, text)
            .and_then(|()| std::fs::rename(&part, &path))
            .map_err(|error| Failure::Tool(format!("cannot write {}: {error}", path.display())))?;
        Ok(path)
    }
}
