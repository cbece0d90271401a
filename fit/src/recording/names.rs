//! A file's column names, and the columns that `--map` makes of them.

use super::error::Problem;
use super::expression::{self, Factor, Term};
use super::known::{KNOWN, Known, Slot};
use super::places;
use super::units::{self, Dimension, Unit};
use super::words::{quantity, split};
use super::{Needs, Warning};

/// A column of the recording: a sum of products of numbers and columns of the file.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) known: &'static Known,
    /// None where `--map` gives a number alone.
    pub(super) terms: Vec<Term>,
    pub(super) offset: f64,
    /// Chosen by `--map`; then text labels are accepted for segments and repeats.
    pub(super) mapped: bool,
    /// Its unit is said: by the file, or in the map by a factor that is one.
    pub(super) stated: bool,
}

impl Source {
    pub(super) fn new(known: &'static Known, column: usize, unit: Option<Unit>) -> Self {
        let factor = unit.map_or(1.0, |u| u.factor);
        Self {
            known,
            terms: vec![Term {
                factor,
                columns: vec![column],
            }],
            offset: unit.map_or(0.0, |u| u.offset),
            mapped: false,
            stated: true,
        }
    }

    /// Indices of the file's columns that it is made of.
    pub(super) fn columns(&self) -> impl Iterator<Item = usize> {
        self.terms.iter().flat_map(|t| t.columns.iter().copied())
    }

    /// A time whose unit nothing gives.
    pub(super) fn is_bare_time(&self) -> bool {
        self.known.slot == Slot::Time && self.is_one_column()
    }

    /// A column as it stands, but for an offset.
    fn is_one_column(&self) -> bool {
        matches!(self.terms.as_slice(), [Term { factor: 1.0, columns }] if columns.len() == 1)
    }

    /// Its value, of those of the columns; or the column that has none, and why.
    pub(super) fn value(
        &self,
        mut read: impl FnMut(usize) -> Result<f64, String>,
    ) -> Result<f64, (usize, String)> {
        let mut sum = self.offset;
        for term in &self.terms {
            let mut product = term.factor;
            for &column in &term.columns {
                product *= read(column).map_err(|what| (column, what))?;
            }
            sum += product;
        }
        let first = self.columns().next().unwrap_or(0);
        plausible(sum).map_err(|what| (first, what))
    }
}

/// Largest magnitude that any physical quantity has in SI; what is beyond is a broken number.
const ABSURD: f64 = 1e15;

/// The value, where it can be a measured one.
pub(super) fn plausible(value: f64) -> Result<f64, String> {
    if value.abs() <= ABSURD {
        Ok(value)
    } else if !value.is_finite() {
        Err(format!("`{value}` is not finite"))
    } else {
        Err(format!(
            "{value:e} is beyond {ABSURD:e}, which no sensor gives"
        ))
    }
}

/// A file's columns, and what its reader was given of them.
pub(super) struct Names<'a> {
    pub(super) columns: &'a [String],
    /// What a row of units says, empty where there is none.
    pub(super) units: &'a [String],
    /// The columns as messages describe them.
    pub(super) listing: &'a str,
    pub(super) map: &'a [(String, String)],
    pub(super) ignore: &'a [String],
    pub(super) needs: Needs,
    /// The sample time (s) that the file states beside its columns.
    pub(super) sample_time: Option<f64>,
}

impl Names<'_> {
    /// The column of that name; `Position[counts]` for `Position [counts]` and `pA` for `pA [bar]`, where only one is called so.
    fn find(&self, name: &str) -> Option<usize> {
        if name.is_empty() {
            return None;
        }
        let only = |is: &dyn Fn(&str) -> bool| {
            let mut alike = (0..self.columns.len()).filter(|&i| is(&self.columns[i]));
            alike.next().filter(|_| alike.next().is_none())
        };
        let tight = |name: &str| name.replace(' ', "");
        let wanted = tight(name);
        let stem = |column: &str| {
            let stem = column.split_once(['[', '(']);
            stem.is_some_and(|(stem, _)| stem.trim() == name)
        };
        let exact = self.columns.iter().position(|c| c == name);
        exact
            .or_else(|| only(&|column| tight(column) == wanted))
            .or_else(|| only(&stem))
    }

    /// Reads `35.1507*vir`, `100*pA-80*pB` or `position[mm]`. A column may itself be called `a*b`.
    fn sum(
        &self,
        known: &'static Known,
        map: &str,
        text: &str,
        warnings: &mut Vec<Warning>,
    ) -> Result<Source, Problem> {
        let fail = |reason: String| Problem::map(map, reason);
        let products = expression::products(text, |name| self.find(name)).map_err(|part| {
            if places::WORDS.contains(&part) {
                return fail(format!("put your own in place of `{part}`"));
            }
            let divides = match part.contains('/') {
                true => "; a map multiplies: 0.5*COLUMN for COLUMN/2",
                false => "",
            };
            fail(format!(
                "there is no column `{part}`; the file has {}{divides}",
                self.columns.join(", ")
            ))
        })?;
        let mut source = Source {
            known,
            terms: Vec::new(),
            offset: 0.0,
            mapped: true,
            stated: true,
        };
        for (sign, factors) in products {
            if let [Factor::Column(column, None)] = factors.as_slice() {
                let (unit, said) = self.in_its_unit(known, *column);
                warnings.extend(said);
                source.stated &= unit.is_some();
                source.offset += sign * unit.map_or(0.0, |u| u.offset);
                source.terms.push(Term {
                    factor: sign * unit.map_or(1.0, |u| u.factor),
                    columns: vec![*column],
                });
                continue;
            }
            let (mut term, offset) = product(known, sign, &factors).map_err(fail)?;
            source.stated &= units::is_factor(known.dimension, term.factor);
            for factor in &factors {
                let Factor::Column(column, None) = *factor else {
                    continue;
                };
                if let Some((scale, said)) = self.in_si(known, column) {
                    term.factor *= scale;
                    warnings.push(said);
                }
            }
            source.offset += offset;
            match term.columns.is_empty() {
                true => source.offset += term.factor,
                false => source.terms.push(term),
            }
        }
        let is_step = known.slot == Slot::Step;
        if source.terms.is_empty() && !is_step {
            return Err(fail(
                "names no column; write COLUMN or FACTOR*COLUMN to the right of `=`".into(),
            ));
        }
        if source.terms.is_empty() && source.offset <= 0.0 {
            return Err(fail("a time step is above 0 s".into()));
        }
        if known.slot.is_label() && !(source.is_one_column() && source.offset == 0.0) {
            return Err(fail(
                "segments and repeats are numbers of parts; map one column without a factor".into(),
            ));
        }
        Ok(source)
    }

    /// The known unit of a column that is mapped without a factor, by its name or the row of units, and what is to be said of it.
    fn in_its_unit(&self, known: &Known, column: usize) -> (Option<Unit>, Option<Warning>) {
        let (target, name) = (known.name, &self.columns[column]);
        let given = self.units.get(column).map(String::as_str);
        // In square brackets stands a unit, be it an unknown one; in round ones anything.
        let is_unit = |u: &&str| units::is_unit(u) || name.ends_with(']');
        let given = given
            .filter(|u| units::is_unit(u))
            .or_else(|| split(name).1.filter(is_unit));
        let (Some(wanted), Some(given)) = (known.dimension, given) else {
            return (None, None);
        };
        match units::unit(given) {
            Some(unit) if unit.dimension == wanted => {
                let plain = unit.factor == 1.0 && unit.offset == 0.0;
                let said = (!plain).then(|| {
                    warning!(
                        "unit-applied",
                        "`{name}` is in {given}: {target}={}*{name}{} (--map '{target}=1*{name}' takes its numbers as they are)",
                        unit.factor,
                        match unit.offset {
                                0.0 => String::new(),
                                offset => format!(" {offset:+}"),
                            }
                    )
                });
                (Some(unit), said)
            }
            _ => (
                None,
                Some(warning!(
                    "unit-of-another-kind",
                    "`{name}` is in {given}, which is not a unit of {target}: its numbers are taken as they are; if one of them is worth something else, give --map '{target}=FACTOR*{name}'"
                )),
            ),
        }
    }

    /// What brings a column of another quantity to SI, for a factor such as N/A or the lever arm in m is in SI, and what is to be said of it.
    /// Where the quantity is that of the target, the factor is the user's own conversion; so it is of a pressure, whose proposed `--map` has it.
    fn in_si(&self, known: &Known, column: usize) -> Option<(f64, Warning)> {
        let (wanted, unit) = (known.dimension?, self.unit(column)?);
        if unit.dimension == wanted || unit.factor == 1.0 || unit.offset != 0.0 {
            return None;
        }
        let (target, name, scale) = (known.name, &self.columns[column], unit.factor);
        let of_row = self.units.get(column).map(String::as_str);
        let spelt = of_row.filter(|u| units::is_unit(u)).or(split(name).1);
        let (code, scale, said) = match unit.dimension {
            Dimension::Pressure => (
                "unit-kept",
                1.0,
                format!(
                    "`{name}` is taken in {0}, not in Pa, so its factor in `{target}` is per {0}: for an area in m² it is {scale:e}*AREA_M2",
                    spelt.unwrap_or("its own unit")
                ),
            ),
            _ => (
                "unit-applied",
                scale,
                format!(
                    "`{name}` is converted to SI first ({scale} × its numbers), so its factor in `{target}` is per SI unit; divide a factor that is per unit of the file by {scale}"
                ),
            ),
        };
        Some((scale, Warning::new(code, said)))
    }

    /// What `--map` asks for.
    pub(super) fn mapped(&self, warnings: &mut Vec<Warning>) -> Result<Vec<Source>, Problem> {
        let mut sources: Vec<Source> = Vec::new();
        for (target, expression) in self.map {
            let text = format!("{target}={expression}");
            let fail = |reason: String| Problem::map(&text, reason);
            let Some(known) = KNOWN.iter().find(|k| k.name == target.trim()) else {
                return Err(fail(format!(
                    "`{target}` is not a column of a recording; choose one of {}",
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
            sources.push(self.sum(known, &text, expression, warnings)?);
        }
        Ok(sources)
    }

    /// The unit that a column's name or the row of units gives.
    pub(super) fn unit(&self, column: usize) -> Option<Unit> {
        let of_row = self.units.get(column).and_then(|u| units::unit(u));
        of_row.or_else(|| quantity(self.columns.get(column)?).unit)
    }
}

/// The product of the factors, and what its unit adds.
fn product(known: &Known, sign: f64, factors: &[Factor]) -> Result<(Term, f64), String> {
    let mut term = Term {
        factor: sign,
        columns: Vec::new(),
    };
    let (mut offset, mut unscaled) = (0.0, None);
    for factor in factors {
        match *factor {
            Factor::Number(number) => term.factor *= number,
            Factor::Column(column, None) => term.columns.push(column),
            Factor::Column(column, Some((unit, part))) => {
                term.columns.push(column);
                match units::unit(unit) {
                    Some(u) if Some(u.dimension) == known.dimension => {
                        term.factor *= u.factor;
                        offset = u.offset;
                    }
                    None if units::is_unscaled(unit) => unscaled = Some(part),
                    _ => {
                        return Err(format!(
                            "`{unit}` is not a unit of `{}`; give the unit that the column is in, or a factor",
                            known.name
                        ));
                    }
                }
            }
        }
    }
    match unscaled.filter(|_| known.dimension.is_some() && term.factor == sign) {
        Some(part) => Err(format!(
            "the file does not say what one unit of `{part}` is worth; give it as a factor: {}=FACTOR*{part}",
            known.name
        )),
        None => Ok((term, offset)),
    }
}
