//! The table of a fleet, as CSV or Parquet.

use super::Row;
use super::history::Change;
use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

/// A column: its name, and a cell a row.
pub struct Column {
    /// Its name, with the unit.
    pub name: String,
    /// Its cells.
    pub cells: Cells,
}

/// Cells of one type.
pub enum Cells {
    /// Numbers.
    Numbers(Vec<Option<f64>>),
    /// Texts.
    Texts(Vec<Option<String>>),
    /// Yes or no.
    Flags(Vec<Option<bool>>),
}

/// The columns of rows and what changed in each. Parameters have three: `KEY`, `KEY_low` and `KEY_high`; lists are joined by `;`.
pub fn columns(rows: &[Row], changes: &[Vec<Change>]) -> Vec<Column> {
    let mut columns = Vec::new();
    let mut add = |name: &str, cells: Cells| {
        columns.push(Column {
            name: name.to_owned(),
            cells,
        });
    };
    let texts = |of: &dyn Fn(&Row) -> Option<String>| Cells::Texts(rows.iter().map(of).collect());
    let numbers = |of: &dyn Fn(&Row) -> Option<f64>| Cells::Numbers(rows.iter().map(of).collect());
    let list = |own: &[String]| (!own.is_empty()).then(|| own.join(";"));
    add("axis", texts(&|r| Some(r.axis.clone())));
    add("file", texts(&|r| Some(r.file.clone())));
    add("modified_s", numbers(&|r| Some(r.modified_s)));
    add("error", texts(&|r| r.error.clone()));
    add(
        "alarm",
        Cells::Flags(
            changes
                .iter()
                .map(|own| (!own.is_empty()).then(|| own.iter().any(|c| c.alarm)))
                .collect(),
        ),
    );
    add(
        "changed",
        Cells::Texts(
            rows.iter()
                .zip(changes)
                .map(|(row, own)| {
                    let alarms = own.iter().filter(|c| c.alarm);
                    let told = alarms.map(|c| {
                        let [_, size] = c.words(row.effort());
                        format!("{} {size}", c.parameter)
                    });
                    list(&told.collect::<Vec<_>>())
                })
                .collect(),
        ),
    );
    add(
        "least_chance",
        Cells::Numbers(
            changes
                .iter()
                .map(|own| own.first().map(|c| c.chance))
                .collect(),
        ),
    );
    add("verdict", texts(&|r| r.verdict.clone()));
    add("names", texts(&|r| list(&r.names)));
    add("possible", texts(&|r| list(&r.possible)));
    add("law", texts(&|r| r.law.clone()));
    add("nmse_held_out_percent", numbers(&|r| r.nmse_held_out));
    for (place, name) in ["before", "after", "noise"].into_iter().enumerate() {
        add(
            &format!("nmse_{name}_percent"),
            numbers(&|r| r.nmse.map(|n| n[place])),
        );
    }
    add("effort_unit", texts(&|r| r.effort_unit.clone()));
    let keys: BTreeSet<&String> = rows.iter().flat_map(|r| r.parameters.keys()).collect();
    for key in keys {
        let own = |r: &Row| r.parameters.get(key).copied();
        add(key, numbers(&|r| own(r).map(|p| p.0)));
        for (side, name) in ["low", "high"].into_iter().enumerate() {
            add(
                &format!("{key}_{name}"),
                numbers(&|r| own(r)?.1.map(|ci| ci[side])),
            );
        }
    }
    add("length_s", numbers(&|r| r.length_s));
    add("rate_Hz", numbers(&|r| r.rate_hz));
    add("warnings", texts(&|r| list(&r.warnings)));
    add("bytes", numbers(&|r| Some(r.bytes as f64)));
    add("seconds", numbers(&|r| Some(r.seconds)));
    columns
}

/// The table as CSV; an empty cell is none.
///
/// # Errors
/// Why it cannot be written.
pub fn write_csv(path: &Path, columns: &[Column]) -> anyhow::Result<()> {
    let mut writer = csv::Writer::from_path(path)?;
    writer.write_record(columns.iter().map(|c| &c.name))?;
    let count = columns.first().map_or(0, |c| c.cells.len());
    for i in 0..count {
        writer.write_record(columns.iter().map(|c| c.cells.text(i)))?;
    }
    writer.flush()?;
    Ok(())
}

impl Cells {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(own) => own.len(),
            Self::Texts(own) => own.len(),
            Self::Flags(own) => own.len(),
        }
    }

    fn text(&self, i: usize) -> String {
        match self {
            Self::Numbers(own) => own[i].map_or(String::new(), |v| v.to_string()),
            Self::Texts(own) => own[i].clone().unwrap_or_default(),
            Self::Flags(own) => own[i].map_or(String::new(), |v| v.to_string()),
        }
    }

    fn physical(&self) -> (Physical, ConvertedType) {
        match self {
            Self::Numbers(_) => (Physical::DOUBLE, ConvertedType::NONE),
            Self::Texts(_) => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
            Self::Flags(_) => (Physical::BOOLEAN, ConvertedType::NONE),
        }
    }
}

/// The table as Parquet, every column optional.
///
/// # Errors
/// Why it cannot be written.
pub fn write_parquet(path: &Path, columns: &[Column]) -> anyhow::Result<()> {
    let fields: Result<Vec<Arc<Type>>, ParquetError> = columns.iter().map(field).collect();
    let schema = Type::group_type_builder("fleet")
        .with_fields(fields?)
        .build()?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
    let file = std::fs::File::create(path)?;
    let mut writer =
        SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build()))?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        let Some(mut writer) = group.next_column()? else {
            break;
        };
        match &column.cells {
            Cells::Numbers(own) => {
                let (levels, values) = optional(own, |v| *v);
                writer
                    .typed::<DoubleType>()
                    .write_batch(&values, Some(&levels), None)?;
            }
            Cells::Texts(own) => {
                let (levels, values) = optional(own, |v| ByteArray::from(v.as_str()));
                writer
                    .typed::<ByteArrayType>()
                    .write_batch(&values, Some(&levels), None)?;
            }
            Cells::Flags(own) => {
                let (levels, values) = optional(own, |v| *v);
                writer
                    .typed::<BoolType>()
                    .write_batch(&values, Some(&levels), None)?;
            }
        }
        writer.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, converted) = column.cells.physical();
    let field = Type::primitive_type_builder(&column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_converted_type(converted);
    field.build().map(Arc::new)
}

/// Which cells there are, and their values.
fn optional<T, V>(cells: &[Option<T>], value: impl Fn(&T) -> V) -> (Vec<i16>, Vec<V>) {
    let levels = cells.iter().map(|c| i16::from(c.is_some())).collect();
    (levels, cells.iter().flatten().map(value).collect())
}
