//! Files that hold variables by name (`.mat`, NPZ, Parquet and their like): which of them the recording is made of.

use super::LoadOptions;
use super::clock;
use super::columns;
use super::error::Problem;
use super::expression::Term;
use super::extra::Reading;
use super::labels::Labels;
use super::names::{Names, Source, plausible};
use super::table::{Data, Location, Table};
use super::{Warning, lost};

/// A variable of the file.
#[derive(Debug)]
pub(super) struct Variable {
    pub(super) name: String,
    /// Its unit, where the file says one.
    pub(super) unit: Option<&'static str>,
    pub(super) dimensions: Vec<usize>,
    /// Real numbers in column-major order, or what it is instead.
    pub(super) values: Result<Vec<f64>, &'static str>,
}

impl Variable {
    /// A column of numbers.
    pub(super) fn column(name: impl Into<String>, values: Vec<f64>) -> Self {
        Self {
            name: name.into(),
            unit: None,
            dimensions: vec![values.len()],
            values: Ok(values),
        }
    }

    /// "qm 24841×1", for messages.
    fn describe(&self) -> String {
        let size: Vec<String> = self.dimensions.iter().map(usize::to_string).collect();
        let class = self
            .values
            .as_ref()
            .err()
            .map(|c| format!(" {c}"))
            .unwrap_or_default();
        format!("{} {}{class}", self.name, size.join("×"))
    }

    /// The numbers of a row or column vector.
    fn vector(&self) -> Option<&[f64]> {
        let long = self.dimensions.iter().filter(|&&d| d != 1).count();
        self.values.as_deref().ok().filter(|_| long <= 1)
    }
}

/// Reads the variables that `--map` and the column names ask for.
pub(super) fn table(variables: &[Variable], options: &LoadOptions) -> Result<Table, Problem> {
    let listing = variables
        .iter()
        .map(Variable::describe)
        .collect::<Vec<_>>()
        .join(", ");
    let names: Vec<String> = variables.iter().map(|v| v.name.clone()).collect();
    let units: Vec<String> = variables
        .iter()
        .map(|v| v.unit.unwrap_or_default().to_owned())
        .collect();
    let mut plan = columns::plan(&Names {
        columns: &names,
        units: &units,
        listing: &format!("the variables {listing}"),
        map: &options.map,
        ignore: &options.ignore,
        needs: options.needs,
        sample_time: None,
    })?;
    let mut found = Vec::new();
    let mut length: Option<(String, usize)> = None;
    for source in &plan.sources {
        let (name, mut values) = sum(variables, source, &listing)?;
        let since_1970 = values.first().copied().and_then(clock::since_1970);
        if let Some(unit) = since_1970.filter(|_| source.is_bare_time()) {
            values.iter_mut().for_each(|t| *t *= unit);
            plan.warnings.push(clock::said(unit));
        }
        match &length {
            // A number alone is the same for all samples.
            _ if source.terms.is_empty() => {}
            None => length = Some((name.into(), values.len())),
            Some((first, n)) => same_length(first, *n, name, values.len())?,
        }
        if values.len() > options.max_samples {
            let at = format!("variable `{name}`");
            return Err(Problem::too_many_samples(at, options.max_samples));
        }
        found.push((name, values));
    }
    let samples = length.map_or(0, |(_, n)| n);
    for (source, (_, values)) in plan.sources.iter().zip(&mut found) {
        if source.terms.is_empty() {
            values.resize(samples, source.offset);
        }
    }
    let mut extra = further(variables, &plan.unused);
    let breaks = leave_out_broken(&mut found, samples, &mut extra, &mut plan.warnings)?;
    let columns = plan.sources.iter().zip(found);
    let data = columns.map(|(source, (name, values))| {
        Ok(match source.known.slot.is_label() {
            true => Data::Labels(labels(name, &values)?),
            false => Data::Numbers(values),
        })
    });
    Ok(Table {
        data: data.collect::<Result<_, Problem>>()?,
        plan,
        extra,
        place: Location {
            what: "element",
            breaks,
        },
        first_change: Vec::new(),
    })
}

/// Leaves out the samples that one of the variables has no number for, where they are few, and says which; what follows a place where some are
/// left out, as [`Location`] has it.
fn leave_out_broken(
    found: &mut [(&str, Vec<f64>)],
    samples: usize,
    extra: &mut [Reading],
    warnings: &mut Vec<Warning>,
) -> Result<Vec<(usize, u64)>, Problem> {
    let is_broken = |i: &usize| {
        found
            .iter()
            .any(|(_, values)| plausible(values[*i]).is_err())
    };
    let broken: Vec<usize> = (0..samples).filter(is_broken).collect();
    let Some(&first) = broken.first() else {
        return Ok(vec![(0, 1)]);
    };
    let bad = found
        .iter()
        .find(|(_, values)| plausible(values[first]).is_err());
    let (name, value) = bad.map_or(("", f64::NAN), |(name, values)| (*name, values[first]));
    let what = format!("`{value}` is not finite, or beyond what any sensor gives");
    let problem = Problem::cell(format!("element {}", first + 1), name, what);
    if lost::too_many(broken.len(), samples - broken.len()) {
        return Err(problem);
    }
    let places: Vec<u64> = broken.iter().map(|&i| i as u64 + 1).collect();
    warnings.push(lost::said("element", &places, &problem.found()));
    for (_, values) in found.iter_mut() {
        lost::leave_out(values, &broken);
    }
    let same = extra.iter_mut().filter(|e| e.values.len() == samples);
    same.for_each(|e| e.leave_out(&broken));
    let after = broken.iter().enumerate();
    let breaks = after.map(|(before, &i)| (i - before, i as u64 + 2));
    Ok([(0, 1)].into_iter().chain(breaks).collect())
}

/// The sum of the products of a source, in SI; with the name of its first vector.
fn sum<'a>(
    variables: &'a [Variable],
    source: &Source,
    listing: &str,
) -> Result<(&'a str, Vec<f64>), Problem> {
    let (mut name, mut sum) = (source.known.name, vec![source.offset]);
    for term in &source.terms {
        let (vector, values) = product(variables, source, term, listing)?;
        if sum.len() == 1 {
            (name, sum) = (vector, values.iter().map(|v| v + sum[0]).collect());
        } else {
            same_length(name, sum.len(), vector, values.len())?;
            sum.iter_mut().zip(values).for_each(|(s, v)| *s += v);
        }
    }
    Ok((name, sum))
}

/// The product of the variables of a term, scalars among them; with the name of its first vector.
fn product<'a>(
    variables: &'a [Variable],
    source: &Source,
    term: &Term,
    listing: &str,
) -> Result<(&'a str, Vec<f64>), Problem> {
    let mut product: Option<(&str, Vec<f64>)> = None;
    let mut factor = term.factor;
    for variable in term.columns.iter().filter_map(|&i| variables.get(i)) {
        let values = variable.vector().ok_or_else(|| {
            let whole = variable.describe();
            let reason = format!("`{whole}` is no vector of real numbers; the file has {listing}");
            Problem::map(format!("{}={}", source.known.name, variable.name), reason)
        })?;
        match (&mut product, values) {
            (_, [scalar]) => factor *= scalar,
            (None, values) => product = Some((&variable.name, values.to_vec())),
            (Some((first, product)), values) => {
                same_length(first, product.len(), &variable.name, values.len())?;
                product.iter_mut().zip(values).for_each(|(p, v)| *p *= v);
            }
        }
    }
    let (name, mut values) = product.unwrap_or((source.known.name, vec![1.0]));
    values.iter_mut().for_each(|v| *v = *v * factor + 0.0);
    Ok((name, values))
}

/// The numbers of a variable that tells parts of the motion apart.
fn labels(name: &str, values: &[f64]) -> Result<Labels, Problem> {
    let mut labels = Labels::default();
    for value in values {
        let taken = labels.push(&value.to_string());
        taken.map_err(|what| Problem::cell("its elements", name, what))?;
    }
    Ok(labels)
}

/// The variables that have no role.
fn further(variables: &[Variable], unused: &[usize]) -> Vec<Reading> {
    let reading = |variable: &Variable| {
        let mut reading = Reading::new(&variable.name);
        match variable.vector() {
            Some(values) => {
                for (i, &value) in (1..).zip(values) {
                    let place = |what| format!("element {i}: {what}");
                    reading.push(plausible(value).map_err(place));
                }
            }
            None => reading.refuse("no vector of real numbers".to_owned()),
        }
        reading
    };
    unused
        .iter()
        .filter_map(|&i| variables.get(i))
        .map(reading)
        .collect()
}

fn same_length(
    first: &str,
    first_len: usize,
    second: &str,
    second_len: usize,
) -> Result<(), Problem> {
    if first_len == second_len {
        return Ok(());
    }
    Err(Problem::Other(format!(
        "`{first}` has {first_len} samples, `{second}` {second_len}; map variables of equal length"
    )))
}
