//! Physics beyond rigid body and friction model: the `[[effects]]` of model files, and what they do along a recording.
//!
//! [The catalogue](form::catalogue) is that of `preslide diagnose`; those that a controller can use are computed by the library
//! ([`preslide::effects`]), the others here ([`force_along`](crate::model::Model::force_along)). Parameters are SI.
//!
//! Levels add: `m = 1 + Σ(m_i − 1)`, not below 0. Time and path count from the first sample. `viscous` is a key of
//! `[friction]`; `lead_error` and `presliding_shape` have no parameters here: the one is a calibration of the
//! encoder, the other is more blocks.

pub mod form;
mod read;
pub mod term;
#[cfg(test)]
mod tests;

use form::Form;
use preslide::ParamError;
use term::Term;

/// Most cosines of a map.
pub const MOST_TERMS: usize = 16;

/// An effect and its parameters, in SI with the keys of a linear axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Its form, of which its id is one part.
    pub form: &'static Form,
    /// Parameters by key, in the order of the form's keys.
    pub values: Vec<(String, f64)>,
}

impl Effect {
    /// An effect of the catalogue with its parameters, in any order.
    ///
    /// # Errors
    /// `key: reason and remedy`: an id or key that is not known, a key that is missing, a value out of its range.
    pub fn new(id: &str, values: &[(&str, f64)]) -> Result<Self, String> {
        read::checked(id, values, &str::to_owned)
    }

    /// The effect of a form with the values of its keys, in their order; a map has as many cosines as there are values for.
    pub fn of(form: &'static Form, values: &[f64]) -> Self {
        let keys = form.keys.iter().flat_map(|(key, _)| {
            let many = if key.contains('*') { MOST_TERMS } else { 1 };
            (1..=many).map(|i| key.replace('*', &i.to_string()))
        });
        Self {
            form,
            values: keys.zip(values.iter().copied()).collect(),
        }
    }

    /// Id in the catalogue.
    pub fn id(&self) -> &'static str {
        self.form.id
    }

    /// Whether it has that form.
    pub fn is(&self, form: &'static Form) -> bool {
        self.form == form
    }

    /// Its term in the library for samples `sample_time` (s) apart; `None` where it is neither a level nor a force.
    ///
    /// # Errors
    /// Which parameter the library refuses.
    pub(crate) fn term(&self, sample_time: f64) -> Result<Option<Term>, ParamError> {
        (self.form.library)(self, sample_time)
    }

    /// The value of a key, 0 where it has none.
    pub fn get(&self, key: &str) -> f64 {
        self.values
            .iter()
            .find(|(own, _)| own == key)
            .map_or(0.0, |(_, value)| *value)
    }

    /// The values of the first keys of its form, 0 where it has none.
    fn numbers<const N: usize>(&self) -> [f64; N] {
        std::array::from_fn(|i| self.form.keys.get(i).map_or(0.0, |(key, _)| self.get(key)))
    }

    /// Whether it has the key.
    pub fn has(&self, key: &str) -> bool {
        self.values.iter().any(|(own, _)| own == key)
    }

    /// The coefficients of a map, in order.
    pub fn cosines(&self) -> Vec<f64> {
        self.values
            .iter()
            .filter(|(key, _)| key.starts_with("cosine"))
            .map(|(_, value)| *value)
            .collect()
    }

    /// The same, with zeros after the last.
    fn padded_cosines(&self) -> [f64; MOST_TERMS] {
        let mut padded = [0.0; MOST_TERMS];
        for (term, c) in padded.iter_mut().zip(self.cosines()) {
            *term = c;
        }
        padded
    }

    /// Reads an entry of `[[effects]]` whose keys are those of a linear axis; `said` gives the file's word for one.
    pub(crate) fn read(table: &toml::Table, said: &dyn Fn(&str) -> String) -> Result<Self, String> {
        read::read(table, said)
    }
}
