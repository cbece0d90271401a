//! NPZ: a zip archive of NumPy arrays.

use std::borrow::Cow;

use zip::ZipArchive;

use super::npy::{self, Array};
use super::{Input, Variable};

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
        let Some(name) = array_name(&path).map(str::to_owned) else {
            continue;
        };
        let Array {
            shape,
            is_fortran,
            values,
        } = npy::read(entry, &mut budget)
            .map_err(|e| format!("an NPZ file whose array `{name}` cannot be read ({e}); save it again, or without it"))?;
        match (shape.as_slice(), values) {
            (&[rows, columns], Ok(values)) if rows > 1 && (2..=MOST_COLUMNS).contains(&columns) => {
                found.extend((0..columns).map(|j| {
                    let at = |i: usize| match is_fortran {
                        false => values[i * columns + j],
                        true => values[j * rows + i],
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
        return Err(other_archive(archive.file_names().flatten().collect()));
    }
    Ok(found)
}

/// What an archive without arrays is, by what it holds, and what to do.
fn other_archive(names: Vec<Cow<str>>) -> String {
    let has = |start: &str| names.iter().any(|name| name.starts_with(start));
    let table = |name: &&Cow<str>| {
        [".csv", ".txt", ".mat", ".tsv"]
            .iter()
            .any(|end| name.ends_with(end))
    };
    if has("xl/") {
        return "an Excel workbook; save the sheet as CSV (File, Save As, CSV UTF-8), or pandas.read_excel(...).to_csv(...)".to_owned();
    }
    if has("content.xml") {
        return "an OpenDocument spreadsheet; save the sheet as CSV".to_owned();
    }
    match names.iter().find(table) {
        Some(name) => format!(
            "a zip archive; unpack it and give `{}`",
            name.replace(char::is_control, "\u{fffd}")
        ),
        None => {
            "a zip archive without NumPy arrays or tables; unpack it, and export its columns as CSV"
                .to_owned()
        }
    }
}

/// The name that an array was saved by, of its entry's path.
fn array_name(path: &str) -> Option<&str> {
    // Some writers end a name with a zero, and padding.
    path.split('\0').next()?.strip_suffix(".npy")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// One array of every type, as numpy wrote it (`types` of `make.py`): the numbers -3 … 3, without sign 0 … 6, true and false.
    #[test]
    fn every_type_that_numpy_writes() {
        let path = Path::new(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/formats/types.npz"
        ));
        let input = Input {
            path,
            file: std::fs::File::open(path).expect("types.npz"),
            start: b"",
            budget: 1 << 20,
        };
        let found = variables(input).expect("read");
        let of = |name: &str| match found.iter().find(|v| v.name == name) {
            Some(variable) => variable.values.clone(),
            None => panic!("no {name}"),
        };
        let signed: Vec<f64> = (-3..=3).map(f64::from).collect();
        let unsigned: Vec<f64> = (0..=6).map(f64::from).collect();
        for order in ["little", "big"] {
            for kind in ["f4", "f8", "i1", "i2", "i4", "i8", "m8"] {
                assert_eq!(of(&format!("{order}_{kind}")), Ok(signed.clone()), "{kind}");
            }
            for kind in ["u1", "u2", "u4", "u8"] {
                assert_eq!(
                    of(&format!("{order}_{kind}")),
                    Ok(unsigned.clone()),
                    "{kind}"
                );
            }
        }
        assert_eq!(of("bool"), Ok(vec![0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]));
        for order in ["rows", "columns"] {
            assert_eq!(of(&format!("{order}[:,0]")), Ok(signed.clone()));
            assert_eq!(of(&format!("{order}[:,1]")), Ok(unsigned.clone()));
        }
        for name in ["text", "complex", "record", "half"] {
            assert_eq!(of(name), Err("no real numbers"), "{name}");
        }
        assert_eq!(of("scalar"), Ok(vec![50.0]));
        assert_eq!(of("empty"), Ok(vec![]));
    }
}
