//! Files that hold variables by name (`.mat`, NPZ, Parquet and their like): which of them the recording is made of.

use super::LoadOptions;
use super::columns;
use super::error::Problem;
use super::extra::Reading;
use super::labels::Labels;
use super::names::{Names, Source};
use super::table::{Data, Location, Table};

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
    })?;
    let mut data = Vec::new();
    let mut length: Option<(String, usize)> = None;
    for source in &plan.sources {
        let (name, values) = product(variables, source, &listing)?;
        if let Some(at) = values.iter().position(|&v| columns::plausible(v).is_err()) {
            return Err(Problem::Cell {
                at: Location::Elements.of(at),
                column: name.into(),
                what: format!(
                    "`{}` is not finite, or beyond what any sensor gives",
                    values.get(at).copied().unwrap_or(f64::NAN)
                ),
            });
        }
        match &length {
            None => length = Some((name.into(), values.len())),
            Some((first, n)) => same_length(first, *n, name, values.len())?,
        }
        if values.len() > options.max_samples {
            return Err(Problem::TooManySamples {
                at: format!("variable `{name}`"),
                limit: options.max_samples,
            });
        }
        data.push(if source.known.slot.is_label() {
            Data::Labels(labels(name, &values)?)
        } else {
            Data::Numbers(values)
        });
    }
    let extra = further(variables, &plan.unused);
    Ok(Table {
        plan,
        data,
        extra,
        place: Location::Elements,
        first_change: Vec::new(),
    })
}

/// The product of the variables of a source, scalars among them, in SI; with the name of its first vector.
fn product<'a>(
    variables: &'a [Variable],
    source: &Source,
    listing: &str,
) -> Result<(&'a str, Vec<f64>), Problem> {
    let mut product: Option<(&str, Vec<f64>)> = None;
    let mut factor = source.factor;
    for variable in source.columns.iter().filter_map(|&i| variables.get(i)) {
        let values = variable.vector().ok_or_else(|| Problem::Map {
            map: format!("{}={}", source.known.name, variable.name),
            reason: format!(
                "`{}` is no vector of real numbers; the file has {listing}",
                variable.describe()
            ),
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
    values
        .iter_mut()
        .for_each(|v| *v = *v * factor + source.offset + 0.0);
    Ok((name, values))
}

/// The numbers of a variable that tells parts of the motion apart.
fn labels(name: &str, values: &[f64]) -> Result<Labels, Problem> {
    let mut labels = Labels::default();
    if values.iter().all(|v| labels.push(&v.to_string())) {
        return Ok(labels);
    }
    Err(Problem::Cell {
        at: "its elements".into(),
        column: name.into(),
        what: "over a million different parts".into(),
    })
}

/// The variables that have no role.
fn further(variables: &[Variable], unused: &[usize]) -> Vec<Reading> {
    let reading = |variable: &Variable| {
        let mut reading = Reading::new(&variable.name);
        match variable.vector() {
            Some(values) if values.iter().all(|v| v.is_finite()) => {
                reading.values = values.to_vec()
            }
            Some(_) => reading.refuse("holds numbers that are not finite".to_owned()),
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
    Err(Problem::Lengths {
        first: first.into(),
        first_len,
        second: second.into(),
        second_len,
    })
}
