//! A file's column names, and the columns that `--map` makes of them.

use super::error::Problem;
use super::known::{KNOWN, Known};
use super::units::{self, Unit};
use super::words::{quantity, split};
use super::{Needs, Warning};

/// A column of the recording: the product of a number and columns of the file, and an offset.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) known: &'static Known,
    pub(super) factor: f64,
    pub(super) offset: f64,
    /// Indices of the file's columns; at least one.
    pub(super) columns: Vec<usize>,
    /// Chosen by `--map`; then text labels are accepted for segments and repeats.
    pub(super) mapped: bool,
}

impl Source {
    pub(super) fn new(known: &'static Known, column: usize, unit: Option<Unit>) -> Self {
        Self {
            known,
            factor: unit.map_or(1.0, |u| u.factor),
            offset: unit.map_or(0.0, |u| u.offset),
            columns: vec![column],
            mapped: false,
        }
    }
}

/// A file's columns, and what its reader was told of them.
pub(super) struct Names<'a> {
    pub(super) columns: &'a [String],
    /// What a row of units says, empty where there is none.
    pub(super) units: &'a [String],
    /// The columns as messages describe them.
    pub(super) listing: &'a str,
    pub(super) map: &'a [(String, String)],
    pub(super) ignore: &'a [String],
    pub(super) needs: Needs,
}

impl Names<'_> {
    /// Reads `35.1507*vir` or `position[mm]` as a number, an offset and columns. A column may itself be called `a*b`.
    fn product(
        &self,
        known: &'static Known,
        map: &str,
        text: &str,
        warnings: &mut Vec<Warning>,
    ) -> Result<Source, Problem> {
        let fail = |reason: String| Problem::Map {
            map: map.into(),
            reason,
        };
        let find = |name: &str| {
            let exact = self.columns.iter().position(|c| c == name);
            // `Position[counts]` for `Position [counts]`, where only one is called so.
            let tight = |name: &str| name.replace(' ', "");
            let wanted = tight(name);
            let mut alike = (0..self.columns.len()).filter(|&i| tight(&self.columns[i]) == wanted);
            exact.or_else(|| alike.next().filter(|_| alike.next().is_none()))
        };
        let text = text.trim();
        let mut source = Source {
            known,
            factor: 1.0,
            offset: 0.0,
            columns: Vec::new(),
            mapped: true,
        };
        let mut unscaled = None;
        if let Some(i) = find(text) {
            source.columns.push(i);
            warnings.extend(self.in_its_unit(&mut source, i));
            return Ok(source);
        }
        for part in text.split('*').map(str::trim) {
            let bracket = part.strip_suffix(']').and_then(|p| p.rsplit_once('['));
            if let Some(i) = find(part) {
                source.columns.push(i);
            } else if let Some(number) = part.parse::<f64>().ok().filter(|n| n.is_finite()) {
                source.factor *= number;
            } else if let Some((i, unit)) =
                bracket.and_then(|(name, unit)| Some((find(name.trim())?, unit)))
            {
                source.columns.push(i);
                match units::unit(unit) {
                    Some(u) if Some(u.dimension) == known.dimension => {
                        source.factor *= u.factor;
                        source.offset = u.offset;
                    }
                    None if units::is_unscaled(unit) => unscaled = Some(part),
                    _ => {
                        return Err(fail(format!(
                            "`{unit}` is no unit of `{}`; give the unit that the column is in, or a factor",
                            known.name
                        )));
                    }
                }
            } else {
                return Err(fail(format!(
                    "there is no column `{part}`; the file has {}",
                    self.columns.join(", ")
                )));
            }
        }
        if source.columns.is_empty() {
            return Err(fail(
                "names no column; write COLUMN or FACTOR*COLUMN to the right of `=`".into(),
            ));
        }
        if let Some(part) = unscaled.filter(|_| known.dimension.is_some() && source.factor == 1.0) {
            return Err(fail(format!(
                "what one unit of `{part}` is worth is not said; give it as a factor: {}=FACTOR*{part}",
                known.name
            )));
        }
        if known.slot.is_label() && (source.columns.len() > 1 || source.factor != 1.0) {
            return Err(fail(
                "segments and repeats are numbers of parts; map one column without a factor".into(),
            ));
        }
        Ok(source)
    }

    /// Turns a column that is mapped without a factor into SI by the unit that its name or the row of units gives, and says so.
    fn in_its_unit(&self, source: &mut Source, column: usize) -> Option<Warning> {
        let wanted = source.known.dimension?;
        let (target, name) = (source.known.name, &self.columns[column]);
        let given = self.units.get(column).map(String::as_str);
        let given = given
            .filter(|u| units::is_unit(u))
            .or_else(|| split(name).1.filter(|u| units::is_unit(u)))?;
        match units::unit(given) {
            Some(unit) if unit.dimension == wanted => {
                (source.factor, source.offset) = (unit.factor, unit.offset);
                let plain = unit.factor == 1.0 && unit.offset == 0.0;
                (!plain).then(|| {
                    Warning::new(
                        "unit-applied",
                        format!(
                            "`{name}` is in {given}: {target}={}*{name}{} (--map '{target}=1*{name}' takes its numbers as they are)",
                            unit.factor,
                            match unit.offset {
                                0.0 => String::new(),
                                offset => format!(" {offset:+}"),
                            }
                        ),
                    )
                })
            }
            _ => Some(Warning::new(
                "unit-of-another-kind",
                format!(
                    "`{name}` is in {given}, which is no unit of {target}: its numbers are taken as they are; if one of them is worth something else, give --map '{target}=FACTOR*{name}'"
                ),
            )),
        }
    }

    /// What `--map` asks for.
    pub(super) fn mapped(&self, warnings: &mut Vec<Warning>) -> Result<Vec<Source>, Problem> {
        let mut sources: Vec<Source> = Vec::new();
        for (target, expression) in self.map {
            let text = format!("{target}={expression}");
            let fail = |reason: String| Problem::Map {
                map: text.clone(),
                reason,
            };
            let Some(known) = KNOWN.iter().find(|k| k.name == target.trim()) else {
                return Err(fail(format!(
                    "`{target}` is no column of a recording; choose one of {}",
                    KNOWN.map(|k| k.name).join(", ")
                )));
            };
            if let Some(other) = sources.iter().find(|s| s.known.slot == known.slot) {
                return Err(fail(format!(
                    "the {} is already mapped as `{}`; keep one of them",
                    known.slot.words(),
                    other.known.name
                )));
            }
            sources.push(self.product(known, &text, expression, warnings)?);
        }
        Ok(sources)
    }

    /// The unit that a column's name or the row of units gives.
    pub(super) fn unit(&self, column: usize) -> Option<Unit> {
        let of_row = self.units.get(column).and_then(|u| units::unit(u));
        of_row.or_else(|| quantity(self.columns.get(column)?).unit)
    }
}
