//! The table of pins in a board's README, checked against the chip's own data.

/// Ends the build where the table of `README.md` and `src/main.rs` differ, or where the chip does not connect a peripheral's signal to the
/// pin (`connects`).
pub fn pins(connects: impl Fn(&str, &str, &str) -> bool) {
    let read = |file: &str| {
        println!("cargo:rerun-if-changed={file}");
        std::fs::read_to_string(file).unwrap_or_default()
    };
    for wrong in check(&read("README.md"), &read("src/main.rs"), connects) {
        println!("cargo::error={wrong}");
    }
}

/// A row of the table: peripheral, signal, pin.
struct Row<'a> {
    peripheral: &'a str,
    signal: &'a str,
    pin: &'a str,
}

/// The rows `| function | PERIPHERAL_SIGNAL | pin | … |`.
fn rows(readme: &str) -> Vec<Row<'_>> {
    let rows = readme.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let (peripheral, signal) = cells.get(2)?.split_once('_')?;
        let pin = *cells.get(3)?;
        let is_pin = pin.starts_with('P') && pin.get(2..)?.parse::<u8>().is_ok();
        is_pin.then_some(Row {
            peripheral,
            signal,
            pin,
        })
    });
    rows.collect()
}

/// Everything that is wrong with the table: a pin that the chip does not connect so, a pin twice, one that the source does not use,
/// and one that it uses without telling.
fn check(readme: &str, source: &str, connects: impl Fn(&str, &str, &str) -> bool) -> Vec<String> {
    let rows = rows(readme);
    let mut wrong = Vec::new();
    for Row {
        peripheral,
        signal,
        pin,
    } in &rows
    {
        if !connects(peripheral, signal, pin) {
            wrong.push(format!("{pin} is not {peripheral}_{signal} on this chip"));
        }
        if rows.iter().filter(|row| row.pin == *pin).count() > 1 {
            wrong.push(format!("{pin} is in the table twice"));
        }
        if !source.contains(&format!("p.{pin}")) {
            wrong.push(format!(
                "{pin} is in the table, but src/main.rs does not use p.{pin}"
            ));
        }
    }
    for piece in source.split("p.P").skip(1) {
        let pin: String = piece
            .chars()
            .take_while(|c| c.is_ascii_alphanumeric())
            .collect();
        let pin = format!("P{pin}");
        if pin.len() >= 3
            && pin[2..].parse::<u8>().is_ok()
            && !rows.iter().any(|row| row.pin == pin)
        {
            wrong.push(format!("src/main.rs uses {pin}, which is not in the table"));
        }
    }
    if rows.len() < 10 {
        wrong.push(format!("only {} rows were found in the table", rows.len()));
    }
    wrong
}
