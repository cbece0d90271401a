// Part of the board's build script: the table of pins in README.md, checked against the chip's own data.

use stm32_metapac::metadata::METADATA;

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
        is_pin.then_some(Row { peripheral, signal, pin })
    });
    rows.collect()
}

/// Everything that is wrong with the table: a pin that the chip does not connect so, a pin twice, one that the source does not use,
/// and one that it uses without telling.
fn check_pins(readme: &str, source: &str) -> Vec<String> {
    let rows = rows(readme);
    let mut wrong = Vec::new();
    for Row { peripheral, signal, pin } in &rows {
        let known = METADATA.peripherals.iter().find(|p| p.name == *peripheral);
        let connects = known.is_some_and(|p| p.pins.iter().any(|c| c.pin == *pin && c.signal == *signal));
        if !connects {
            wrong.push(format!("{pin} is not {peripheral}_{signal} on the {}", METADATA.name));
        }
        if rows.iter().filter(|row| row.pin == *pin).count() > 1 {
            wrong.push(format!("{pin} is in the table twice"));
        }
        if !source.contains(&format!("p.{pin}")) {
            wrong.push(format!("{pin} is in the table, but src/main.rs does not use p.{pin}"));
        }
    }
    for piece in source.split("p.P").skip(1) {
        let pin: String = piece.chars().take_while(|c| c.is_ascii_alphanumeric()).collect();
        let pin = format!("P{pin}");
        if pin.len() >= 3 && pin[2..].parse::<u8>().is_ok() && !rows.iter().any(|row| row.pin == pin) {
            wrong.push(format!("src/main.rs uses {pin}, which is not in the table"));
        }
    }
    if rows.len() < 10 {
        wrong.push(format!("only {} rows were found in the table", rows.len()));
    }
    wrong
}
