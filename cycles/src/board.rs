//! The image that measures on a board: that it links, runs to its end and prints the table's columns.
//!
//! QEMU's netduinoplus2 is a Cortex-M4 with flash and RAM where the STM32G474 has them, so the very image for the board runs
//! there; its cycle counter reads 0, so no cycle is checked, and neither is anything that the STM32G474 does differently.

use anyhow::{Context as _, Result, bail, ensure};
use fs_err as fs;
use preslide_tools::image::build_command;
use preslide_tools::process::{run, run_for};

use super::recorder::{QEMU_LIMIT, qemu};
use super::table::{COLUMNS, Row};

/// Builds the image, runs it and compares its lines with `rows`, which it must cover but for the control task and gcc's translations.
pub fn check(rows: &[Row]) -> Result<()> {
    let (mut build, built) = build_command("preslide-cycles")?;
    run(build.args(["--features", "board"]))?;
    let printed = built.with_file_name("printed");
    let mut qemu = qemu("netduinoplus2", &built.with_file_name("cycles"), &printed)?;
    run_for(&mut qemu, QEMU_LIMIT)?;
    let text = fs::read_to_string(&printed)?;
    let is_left_out = |row: &&Row| {
        let apart = ["control_task", "koopman_"];
        apart.iter().any(|name| row.kernel.starts_with(name))
    };
    let kernels = rows.iter().filter(|row| !is_left_out(row));
    let kernels: Vec<Row> = kernels.cloned().collect();
    let lines = compare(&text, &kernels).context("the board's image")?;
    println!(
        "the board's image links for an STM32G474 and prints {lines} rows in the table's columns (in QEMU its cycle \
         counter stands still: no cycle of it was checked)"
    );
    Ok(())
}

/// How many rows the image printed, each in the table's columns and in the order of `rows`.
fn compare(printed: &str, rows: &[Row]) -> Result<usize> {
    let mut lines = printed.lines().filter(|line| !line.starts_with('#'));
    if lines.next() != Some(COLUMNS) {
        bail!("its column line is not the table's");
    }
    let lines: Vec<&str> = lines.collect();
    for (line, row) in lines.iter().zip(rows) {
        let expected = format!("{},{},", row.kernel, row.blocks);
        if !line.starts_with(&expected) || line.split(',').count() != COLUMNS.split(',').count() {
            bail!("`{line}` where `{expected}…` is due");
        }
    }
    ensure!(
        lines.len() == rows.len(),
        "{} rows where {} are due",
        lines.len(),
        rows.len()
    );
    Ok(lines.len())
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, compare};
    use crate::table::from_csv;

    #[test]
    fn rows_in_other_columns_or_of_other_kernels_are_refused() {
        let table = format!("{COLUMNS}\na,6,1.0,1,2.0,2,2.0,2.0,,,8,,1,10,\n");
        let rows = from_csv(&table).unwrap();
        let printed = |row: &str| format!("# comment\n{COLUMNS}\n{row}");
        let compared = |row: &str| compare(&printed(row), &rows).map_err(|error| error.to_string());
        assert_eq!(compared("a,6,,,0.0,0,,,0.0,,,12,,10,\n"), Ok(1));
        assert!(compared("a,8,,,0.0,0,,,0.0,,,12,,10,\n").is_err());
        assert!(compared("a,6,,,0.0,0\n").is_err());
        assert!(compared("").unwrap_err().contains("0 rows"));
    }
}
