//! A table of speed and effort without time, as a test bench writes it: one row for each speed that was held.

use std::path::Path;

use super::join::one_machine;
use super::known::Slot;
use super::table::Data;
use super::{EffortRole, LoadOptions, MotionKind, Needs, Problem, RecordingError, Warning, read};
use crate::statistics::bounds;

/// Speeds and the effort that each took.
#[derive(Clone, Debug)]
pub struct Speeds {
    /// File name, for messages.
    pub name: String,
    /// Linear or rotary.
    pub kind: MotionKind,
    /// What the effort measures.
    pub role: EffortRole,
    /// Velocity (m/s or rad/s), one for every row.
    pub velocity: Vec<f64>,
    /// Effort, positive where it drives motion forwards, once the sign of [`LoadOptions`] is applied.
    pub effort: Vec<f64>,
    /// What the user should know.
    pub warnings: Vec<Warning>,
}

/// Loads a table of speed and effort; `None` where the file is none: it has a time, a position, or lacks one of the two.
///
/// # Errors
/// [`RecordingError`]: where it is one and a row of it cannot be read; what else is wrong [`super::load`] tells.
pub fn load_speeds(path: &Path, options: &LoadOptions) -> Result<Option<Speeds>, RecordingError> {
    let options = LoadOptions {
        needs: Needs::Speeds,
        ..options.clone()
    };
    let fail = |problem| RecordingError {
        file: path.display().to_string(),
        problem,
    };
    let mut table = match read::file(path, &options) {
        Ok(table) => table,
        Err(problem @ Problem::Row { .. }) => return Err(fail(problem)),
        Err(_) => return Ok(None),
    };
    let sign = options.sign().map_err(fail)?.unwrap_or(1.0);
    let slots: Vec<Slot> = table.plan.sources.iter().map(|s| s.known.slot).collect();
    let mut warnings = std::mem::take(&mut table.plan.warnings);
    let mut column = |slot: Slot| {
        let at = slots.iter().position(|s| *s == slot);
        match at.map(|at| std::mem::replace(&mut table.data[at], Data::Numbers(Vec::new()))) {
            Some(Data::Numbers(values)) => values,
            _ => Vec::new(),
        }
    };
    let (velocity, mut effort) = (column(Slot::Velocity), column(Slot::Effort));
    effort.iter_mut().for_each(|f| *f *= sign);
    if !table.extra.is_empty() {
        let names: Vec<&str> = table.extra.iter().map(|e| e.name.as_str()).collect();
        let said = format!("not used: {}", names.join(", "));
        warnings.push(Warning::new("unused-columns", said));
    }
    let name = path.file_name().unwrap_or(path.as_os_str());
    Ok(Some(Speeds {
        name: name.to_string_lossy().into_owned(),
        kind: table.plan.kind,
        role: table.plan.role,
        velocity,
        effort,
        warnings,
    }))
}

impl Speeds {
    /// Lowest and highest velocity (m/s or rad/s) and effort.
    pub fn ranges(&self) -> [(f64, f64); 2] {
        [&self.velocity, &self.effort].map(|values| bounds(values))
    }

    /// The tables of one machine as one.
    ///
    /// # Errors
    /// Which two do not belong together.
    pub fn join(tables: Vec<Speeds>) -> Result<Speeds, String> {
        let mut rest = tables.into_iter();
        let mut whole = rest.next().ok_or("no table given")?;
        for next in rest {
            let of = |t: &Speeds| (t.kind, t.role);
            one_machine("tables", [&whole.name, &next.name], [&whole, &next].map(of))?;
            whole.name = format!("{}, {}", whole.name, next.name);
            whole.velocity.extend(next.velocity);
            whole.effort.extend(next.effort);
            whole.warnings.extend(next.warnings);
        }
        Ok(whole)
    }
}
