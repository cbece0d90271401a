//! NPZ: a zip archive of NumPy arrays.

use std::io::Read;

use npyz::{NpyFile, Order};
use zip::ZipArchive;

use super::{Input, Variable, spend};

/// Columns of a table that are taken as variables of their own; a larger one is no table of channels.
const MOST_COLUMNS: usize = 64;

pub(super) fn variables(input: Input) -> Result<Vec<Variable>, String> {
    let mut budget = input.budget;
    let broken = |e: zip::result::ZipError| {
        format!("a zip archive that cannot be read ({e}); copy or save it again")
    };
    let mut archive = ZipArchive::new(input.file).map_err(broken)?;
    let mut found = Vec::new();
    for i in 0..archive.len() {
        let entry = archive.by_index(i).map_err(broken)?;
        let path = entry.name().map_err(broken)?.into_owned();
        let Some(name) = npyz::npz::array_name_from_file_name(&path).map(str::to_owned) else {
            continue;
        };
        let (shape, order, values) = array(entry, &mut budget)
            .map_err(|e| format!("an NPZ file whose array `{name}` cannot be read ({e}); save it again, or without it"))?;
        match (shape.as_slice(), values) {
            (&[rows, columns], Ok(values)) if rows > 1 && (2..=MOST_COLUMNS).contains(&columns) => {
                found.extend((0..columns).map(|j| {
                    let at = |i: usize| match order {
                        Order::C => values[i * columns + j],
                        Order::Fortran => values[j * rows + i],
                    };
                    Variable::column(format!("{name}[:,{j}]"), (0..rows).map(at).collect())
                }));
            }
            (_, values) => found.push(Variable {
                name,
                unit: None,
                dimensions: shape,
                values,
            }),
        }
    }
    if found.is_empty() {
        return Err("a zip archive without NumPy arrays; save a spreadsheet as CSV".to_owned());
    }
    Ok(found)
}

type Array = (Vec<usize>, Order, Result<Vec<f64>, &'static str>);

fn array(reader: impl Read, budget: &mut u64) -> Result<Array, String> {
    let file = NpyFile::new(reader).map_err(|e| e.to_string())?;
    let shape: Vec<usize> = file.shape().iter().map(|&n| n as usize).collect();
    let order = file.order();
    let count = shape.iter().try_fold(8u64, |n, &d| n.checked_mul(d as u64));
    spend(budget, count.unwrap_or(u64::MAX))?;
    let values = numbers(file).map_err(|e| e.to_string())?;
    Ok((shape, order, values.ok_or("no real numbers")))
}

/// The numbers, whatever their type; `None` where they are none.
fn numbers(file: NpyFile<impl Read>) -> std::io::Result<Option<Vec<f64>>> {
    macro_rules! of_type {
        ($($kind:ty),*) => {{
            let file = file;
            $(let file = match file.try_data::<$kind>() {
                Ok(data) => return data.map(|v| v.map(|v| v as f64)).collect::<Result<_, _>>().map(Some),
                Err(file) => file,
            };)*
            file
        }};
    }
    let file = of_type!(f64, f32, i64, i32, i16, i8, u64, u32, u16, u8);
    match file.try_data::<bool>() {
        Ok(data) => data
            .map(|v| v.map(|v| f64::from(u8::from(v))))
            .collect::<Result<_, _>>()
            .map(Some),
        Err(_) => Ok(None),
    }
}
