//! Parquet: the flat numeric columns of a table, as pandas and Polars write it.

use ::parquet::basic::{LogicalType, TimeUnit, Type};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use ::parquet::data_type::DataType;
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::schema::types::ColumnDescriptor;

use super::{Input, Variable, spend};

pub(super) fn variables(input: Input) -> Result<Vec<Variable>, String> {
    let broken = |e: ParquetError| {
        format!("a Parquet file that cannot be read ({e}); copy or write it again")
    };
    let reader = SerializedFileReader::new(input.file).map_err(broken)?;
    let metadata = reader.metadata().file_metadata();
    let schema = metadata.schema_descr();
    let rows = usize::try_from(metadata.num_rows()).unwrap_or(0);
    let mut budget = input.budget;
    let mut found = Vec::new();
    for (j, column) in schema.columns().iter().enumerate() {
        let name = column.path().parts().join(".");
        let tick = tick(column);
        let values = if is_number(column) {
            spend(&mut budget, (rows as u64).saturating_mul(8))?;
            let (mut values, mut first) = (Vec::new(), None);
            for group in 0..reader.num_row_groups() {
                let group = reader.get_row_group(group).map_err(broken)?;
                let column = group.get_column_reader(j).map_err(broken)?;
                read(column, tick.is_some(), &mut first, &mut values).map_err(broken)?;
            }
            Ok(values)
        } else {
            Err("no numbers")
        };
        let mut variable = Variable {
            name,
            unit: tick.map(|_| "s"),
            dimensions: vec![rows],
            values,
        };
        if let (Some(tick), Ok(values)) = (tick, &mut variable.values) {
            values.iter_mut().for_each(|v| *v *= tick);
        }
        unsigned(&mut variable, column);
        found.push(variable);
    }
    Ok(found)
}

fn is_number(column: &ColumnDescriptor) -> bool {
    let plain = !matches!(
        column.logical_type_ref(),
        Some(LogicalType::Decimal(_) | LogicalType::Date)
    );
    let kinds = [
        Type::BOOLEAN,
        Type::INT32,
        Type::INT64,
        Type::FLOAT,
        Type::DOUBLE,
    ];
    plain && column.max_rep_level() == 0 && kinds.contains(&column.physical_type())
}

/// The upper half of an unsigned range is stored as negative numbers.
fn unsigned(variable: &mut Variable, column: &ColumnDescriptor) {
    if let Some(LogicalType::Integer(integer)) = column.logical_type_ref()
        && !integer.is_signed
        && let Ok(values) = &mut variable.values
    {
        let range = match column.physical_type() {
            Type::INT32 => 2.0_f64.powi(32),
            _ => 2.0_f64.powi(64),
        };
        let negative = values.iter_mut().filter(|v| **v < 0.0);
        negative.for_each(|v| *v += range);
    }
}

/// How long a tick of a column of times is (s).
fn tick(column: &ColumnDescriptor) -> Option<f64> {
    let (LogicalType::Timestamp(time) | LogicalType::Time(time)) = column.logical_type_ref()?
    else {
        return None;
    };
    Some(match time.unit {
        TimeUnit::MILLIS => 1e-3,
        TimeUnit::MICROS => 1e-6,
        TimeUnit::NANOS => 1e-9,
    })
}

/// Appends a column. Times count from their `first`, taken off as whole numbers: ticks since 1970 are too many for an `f64`.
fn read(
    column: ColumnReader,
    is_time: bool,
    first: &mut Option<i64>,
    values: &mut Vec<f64>,
) -> Result<(), ParquetError> {
    match column {
        ColumnReader::BoolColumnReader(c) => all(c, values, |v| f64::from(u8::from(*v))),
        ColumnReader::Int32ColumnReader(c) => all(c, values, |v| f64::from(*v)),
        ColumnReader::Int64ColumnReader(c) if is_time => all(c, values, |v| {
            v.wrapping_sub(*first.get_or_insert(*v)) as f64
        }),
        ColumnReader::Int64ColumnReader(c) => all(c, values, |v| *v as f64),
        ColumnReader::FloatColumnReader(c) => all(c, values, |v| f64::from(*v)),
        ColumnReader::DoubleColumnReader(c) => all(c, values, |v| *v),
        _ => Ok(()),
    }
}

/// Rows that are decoded at a time.
const AT_A_TIME: usize = 1 << 16;

/// Appends a column of a row group; NaN where there is no value.
fn all<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    values: &mut Vec<f64>,
    mut number: impl FnMut(&T::T) -> f64,
) -> Result<(), ParquetError> {
    let (mut there, mut some) = (Vec::new(), Vec::new());
    loop {
        there.clear();
        some.clear();
        let (rows, _, _) = column.read_records(AT_A_TIME, Some(&mut there), None, &mut some)?;
        if rows == 0 {
            return Ok(());
        }
        let most = there.iter().copied().max().unwrap_or(0);
        if some.len() == rows {
            values.extend(some.iter().map(&mut number));
            continue;
        }
        let mut some = some.iter().map(&mut number);
        values.extend(there.iter().map(|&level| {
            if level == most && most > 0 {
                some.next().unwrap_or(f64::NAN)
            } else {
                f64::NAN
            }
        }));
    }
}
