//! Columns that number the parts of a motion: segments and repeats.

use std::collections::HashMap;

use super::Warning;
use super::names::Source;

/// Numbers of segments or repeats from the cells of a column.
#[derive(Debug, Default)]
pub(super) struct Labels {
    ids: Vec<u32>,
    texts: Vec<String>,
    index: HashMap<String, u32>,
}

/// More parts than this and the column is not one of segments or repeats.
const MAX_LABELS: usize = 1_000_000;

/// Samples from which on a column of parts is judged …
const FEWEST_ROWS: usize = 60;
/// … and what a part has at least of them, on average.
const PART_ROWS: usize = 4;

/// A whole number from 0, as `3`, `3.0` or `3e0`.
pub(super) fn whole(text: &str) -> Option<u32> {
    let value = || {
        let value: f64 = text.parse().ok()?;
        (value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value))
            .then_some(value as u32)
    };
    text.parse().ok().or_else(value)
}

impl Labels {
    /// Takes the next cell.
    pub(super) fn push(&mut self, text: &str) -> Result<(), &'static str> {
        // Samples of one part follow each other: most cells repeat the one before.
        if let Some(&last) = self.ids.last()
            && self.texts.get(last as usize).is_some_and(|t| t == text)
        {
            self.ids.push(last);
            return Ok(());
        }
        if self.texts.len() >= MAX_LABELS {
            return Err("holds over a million different parts");
        }
        let next = self.texts.len() as u32;
        let id = *self.index.entry(text.to_string()).or_insert(next);
        if id == next {
            self.texts.push(text.to_string());
        }
        self.ids.push(id);
        Ok(())
    }

    /// The numbers of the parts: as they stand in the file, or, where they are words and the
    /// column was mapped, counted from 0 in order of appearance.
    pub(super) fn finish(
        self,
        source: &Source,
        warnings: &mut Vec<Warning>,
    ) -> Result<Vec<u32>, (usize, String)> {
        if self.ids.len() >= FEWEST_ROWS && PART_ROWS * self.texts.len() > self.ids.len() {
            return Err((
                0,
                format!(
                    "holds {} different parts in {} samples: it counts rows and no parts of the motion; leave it out with `--ignore`, or map the column that numbers the parts",
                    self.texts.len(),
                    self.ids.len()
                ),
            ));
        }
        let numbers: Result<Vec<u32>, u32> = (0u32..)
            .zip(&self.texts)
            .map(|(id, text)| whole(text).ok_or(id))
            .collect();
        match numbers {
            Ok(numbers) => Ok(self
                .ids
                .iter()
                .filter_map(|&id| numbers.get(id as usize).copied())
                .collect()),
            Err(_) if source.mapped => {
                warnings.push(warning!(
                    "labels-numbered",
                    "{} holds words, numbered 0 to {} in order of appearance",
                    source.known.name,
                    self.texts.len().saturating_sub(1)
                ));
                Ok(self.ids)
            }
            Err(bad) => {
                let at = self.ids.iter().position(|&id| id == bad).unwrap_or(0);
                let text = self.texts.get(bad as usize).cloned().unwrap_or_default();
                Err((at, format!("`{text}` is not a whole number from 0")))
            }
        }
    }
}
