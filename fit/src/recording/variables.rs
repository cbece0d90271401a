//! Files that hold variables by name (`.mat`, NPZ, Parquet and their like): which of them the recording is made of.

use super::LoadOptions;
use super::clock::Since1970;
use super::columns;
use super::error::Problem;
use super::names::{Names, Source, plausible};
use super::table::{Builder, Table};

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
    let plan = columns::plan(&Names {
        columns: &names,
        units: &units,
        listing: &format!("the variables {listing}"),
        map: &options.map,
        ignore: &options.ignore,
        needs: options.needs,
        sample_time: None,
    })?;
    let mut length: Option<(&str, usize)> = None;
    // A number alone is the same for all samples.
    for source in plan.sources.iter().filter(|s| !s.terms.is_empty()) {
        let (name, n) = length_of(source, variables, &listing)?;
        let (first, first_n) = *length.get_or_insert((name, n));
        same_length(first, first_n, name, n)?;
    }
    let samples = length.map_or(0, |(_, n)| n);
    let mut builder = Builder::new(plan, "element", options.max_samples);
    let Table { plan, extra, .. } = &mut builder.table;
    for (reading, &i) in extra.iter_mut().zip(&plan.unused) {
        match variables[i].vector() {
            None => reading.refuse("no vector of real numbers".into()),
            Some(values) if values.len() != samples => {
                reading.refuse("not one number for every sample".into());
            }
            Some(_) => {}
        }
    }
    let vectors = variables.iter().map(|v| v.vector().unwrap_or_default());
    let vectors: Vec<&[f64]> = vectors.collect();
    let mut since_1970 = Since1970::default();
    for i in 0..samples {
        let at = i as u64 + 1;
        let number = |c: usize| {
            *vectors[c]
                .get(i)
                .or(vectors[c].first())
                .unwrap_or(&f64::NAN)
        };
        let value = |source: &Source| source.value(|c| Ok(since_1970.of(source, number(c))));
        let values: Result<Vec<f64>, _> = builder.table.plan.sources.iter().map(value).collect();
        match values {
            Ok(values) => {
                let label = |c: usize| number(c).to_string();
                builder.take(at, &values, label, |c| plausible(number(c)))?;
            }
            Err((c, what)) => {
                let problem = Problem::cell(format!("element {at}"), &names[c], what);
                builder.lose(at, problem, true)?;
            }
        }
    }
    builder.table.plan.warnings.extend(since_1970.said());
    builder.finish()
}

/// The number of samples that the vectors of a source have, scalars among them, and the name of the first.
fn length_of<'a>(
    source: &Source,
    variables: &'a [Variable],
    listing: &str,
) -> Result<(&'a str, usize), Problem> {
    let mut length = (source.known.name, 1);
    for variable in source.columns().map(|i| &variables[i]) {
        let values = variable.vector().ok_or_else(|| {
            let whole = variable.describe();
            let reason =
                format!("`{whole}` is not a vector of real numbers; the file has {listing}");
            Problem::map(format!("{}={}", source.known.name, variable.name), reason)
        })?;
        match values.len() {
            1 => {}
            n if length.1 == 1 => length = (&variable.name, n),
            n => same_length(length.0, length.1, &variable.name, n)?,
        }
    }
    Ok(length)
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
