//! `cargo xtask cycles --picture`: error against cycles on every core, from the committed tables, as `docs/src/frontier.svg`.
//!
//! A kernel that is measured with several numbers of blocks is a line, one with one number a cross with its name. The thick line
//! joins what nothing else beats in both.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::labels::{self, Area, Point};
use crate::process::root;

const PICTURE: &str = "docs/src/frontier.svg";

/// Title and table. The errors are the first one's: forces are the same on all of them.
const CORES: [(&str, &str); 3] = [
    ("Cortex-M4F", "cortex-m4"),
    ("Cortex-M0+", "cortex-m0plus"),
    ("Hazard3 (RP2350), exact", "hazard3-rp2350"),
];

/// Kernel, how it is called, colour and dashes.
const FAMILIES: [(&str, &str, &str, &str); 19] = [
    ("slip_reserve_i32", "quasi-static, i32", "#0072b2", "4 3"),
    (
        "lumped_slip_reserve_i32",
        "quasi-static by events, i32",
        "#0072b2",
        "",
    ),
    ("packed", "quasi-static, 2×16 bit", "#56b4e9", ""),
    ("constant_time", "2×16 bit, constant time", "#000000", "1 3"),
    ("quasi_static_f32", "quasi-static, f32", "#56b4e9", "4 3"),
    (
        "quasi_static_i16f16",
        "quasi-static, I16F16",
        "#56b4e9",
        "1 3",
    ),
    ("gms_i32", "full law, i32", "#d55e00", ""),
    ("lumped_i32", "full law by events, i32", "#e69f00", ""),
    ("gms_f32", "full law, f32", "#d55e00", "4 3"),
    ("lumped_f32", "full law by events, f32", "#e69f00", "4 3"),
    ("gms_i16f16", "full law, I16F16", "#d55e00", "1 3"),
    ("leuven_f32", "Leuven, f32", "#cc79a7", "4 3"),
    (
        "leuven_original_f32",
        "Leuven as published, f32",
        "#cc79a7",
        "",
    ),
    ("textbook_float_O2", "textbook C, float", "#888888", ""),
    (
        "textbook_float_O3_fast",
        "textbook C, float, fast",
        "#888888",
        "1 3",
    ),
    ("textbook_double_O2", "textbook C, double", "#888888", "4 3"),
    (
        "slip_reserve_i32_gcc_O2",
        "quasi-static, i32, by gcc",
        "#009e73",
        "4 3",
    ),
    (
        "lumped_slip_reserve_i32_gcc_O2",
        "by events, i32, by gcc",
        "#009e73",
        "",
    ),
    ("gms_i32_gcc_O2", "full law, i32, by gcc", "#009e73", "1 3"),
];

/// Kernel and how it is called.
const RIVALS: [(&str, &str); 8] = [
    ("coulomb_f32", "Coulomb"),
    ("dahl_n1_f32", "Dahl, n = 1"),
    ("dahl_n1.6_f32", "Dahl, n = 1.6"),
    ("two_state_f32", "two-state"),
    ("bouc_wen_f32", "Bouc-Wen"),
    ("lugre_f32", "LuGre"),
    ("elasto_plastic_f32", "elasto-plastic"),
    ("hsieh_f32", "Hsieh"),
];

/// Kernel and N.
type Name = (String, u32);

/// Draws it anew.
pub fn write() -> Result<(), String> {
    let picture = drawn()?;
    std::fs::write(root().join(PICTURE), picture)
        .map_err(|error| format!("cannot write {PICTURE}: {error}"))?;
    println!("written to {PICTURE}");
    Ok(())
}

/// Whether the committed picture shows the committed tables.
pub fn check() -> Result<(), String> {
    if std::fs::read_to_string(root().join(PICTURE)).is_ok_and(|old| Ok(old) == drawn()) {
        return Ok(());
    }
    Err(format!(
        "{PICTURE} does not show the committed tables: run `cargo xtask cycles --picture`"
    ))
}

fn drawn() -> Result<String, String> {
    let tables = CORES
        .iter()
        .map(|(_, name)| {
            let file = format!("firmware/cycles/{name}.csv");
            let text = std::fs::read_to_string(root().join(&file));
            text.map_err(|error| format!("cannot read {file}: {error}"))
        })
        .collect::<Result<Vec<String>, String>>()?;
    const CYCLES: usize = 4;
    const ERROR: usize = 15;
    let errors = column(&tables[0], ERROR);
    every_one(&errors)?;
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH} {HEIGHT}' font-family='sans-serif' font-size='11'>\n\
         <rect width='{WIDTH}' height='{HEIGHT}' fill='white'/>\n"
    );
    for (index, table) in tables.iter().enumerate() {
        let cycles = column(table, CYCLES);
        let costs = cycles.into_iter().filter_map(|(name, cycles)| {
            let error = *errors.get(&name)?;
            Some((name, (cycles, error)))
        });
        panel(&mut svg, index, &costs.collect());
    }
    legend(&mut svg);
    svg += "</svg>\n";
    Ok(svg)
}

/// Refuses what would be counted and not drawn.
fn every_one(errors: &BTreeMap<Name, f64>) -> Result<(), String> {
    let is_drawn = |(kernel, blocks): &Name| {
        FAMILIES.iter().any(|family| family.0 == kernel)
            || *blocks == 1 && RIVALS.iter().any(|rival| rival.0 == kernel)
    };
    errors.keys().find(|name| !is_drawn(name)).map_or(Ok(()), |(kernel, n)| {
        Err(format!("{kernel} with N = {n} is in the table and not in the picture: name it in FAMILIES or RIVALS of xtask/src/cycles/picture.rs"))
    })
}

/// A column of a table, where it is filled.
fn column(table: &str, index: usize) -> BTreeMap<Name, f64> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let name = (cells.first()?.to_string(), cells.get(1)?.parse().ok()?);
        Some((name, cells.get(index)?.parse().ok()?))
    };
    table.lines().filter_map(row).collect()
}

const WIDTH: f64 = 1180.0;
const HEIGHT: f64 = 560.0;
const TOP: f64 = 30.0;
const LEFT: f64 = 55.0;
/// Of a panel.
const SIZE: [f64; 2] = [345.0, 400.0];
const GAP: f64 = 35.0;

/// Decades of cycles and of error (% of `F_s`).
const CYCLES: [i32; 2] = [1, 6];
const ERROR: [i32; 2] = [-4, 4];

/// Where so many cycles and so much error are in a panel. An error below four decimals stands at the bottom.
fn place(index: usize, (cycles, error): (f64, f64)) -> (f64, f64) {
    let share = |value: f64, [low, high]: [i32; 2]| {
        (value.log10().max(f64::from(low)) - f64::from(low)) / f64::from(high - low)
    };
    (
        LEFT + index as f64 * (SIZE[0] + GAP) + SIZE[0] * share(cycles, CYCLES),
        TOP + SIZE[1] * (1.0 - share(error, ERROR)),
    )
}

fn panel(svg: &mut String, index: usize, costs: &BTreeMap<Name, (f64, f64)>) {
    grid(svg, index);
    let at = |cost: &(f64, f64)| place(index, *cost);
    let frontier: Vec<_> = frontier(costs.values().copied()).iter().map(at).collect();
    polyline(svg, &frontier, BEST);
    let mut curves = along(&frontier);
    for (kernel, _, colour, dashes) in FAMILIES {
        let family = costs.iter().filter(|((name, _), _)| name == kernel);
        let points: Vec<_> = family.map(|(_, cost)| at(cost)).collect();
        polyline(svg, &points, &stroke(colour, dashes));
        curves.extend(along(&points));
        for (x, y) in points {
            let _ = writeln!(
                svg,
                "<circle cx='{x:.1}' cy='{y:.1}' r='2.5' fill='{colour}'/>"
            );
        }
    }
    let marks = RIVALS.iter().filter_map(|(kernel, title)| {
        let cost = costs.get(&(kernel.to_string(), 1))?;
        Some((at(cost), *title))
    });
    rivals(svg, &marks.collect::<Vec<_>>(), &curves, index);
}

/// A cross each with its name, and a line between the two where they are apart.
fn rivals(svg: &mut String, marks: &[(Point, &str)], curves: &[Point], index: usize) {
    let (left, bottom) = place(index, (10f64.powi(CYCLES[0]), 10f64.powi(ERROR[0])));
    let (right, top) = place(index, (10f64.powi(CYCLES[1]), 10f64.powi(ERROR[1])));
    let panel = Area {
        left,
        top,
        right,
        bottom,
    };
    let names = labels::placed(marks, curves, &panel);
    for (((x, y), title), name) in marks.iter().zip(names) {
        let (near_x, near_y) = name.nearest((*x, *y));
        if (near_x - x).hypot(near_y - y) > labels::FAR {
            let _ = writeln!(
                svg,
                "<path d='M{x:.1} {y:.1}L{near_x:.1} {near_y:.1}' stroke='#888888' stroke-width='0.7'/>"
            );
        }
        let _ = writeln!(
            svg,
            "<path d='M{:.1} {:.1}l6 6m0 -6l-6 6' stroke='black'/><text x='{:.1}' y='{:.1}' text-anchor='middle'>{title}</text>",
            x - 3.0,
            y - 3.0,
            0.5 * (name.left + name.right),
            name.bottom - 2.5
        );
    }
}

/// Points along a line, close enough that none passes unseen under a name.
fn along(points: &[Point]) -> Vec<Point> {
    const STEPS: u32 = 40;
    let between = points.windows(2).flat_map(|pair| {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        (0..=STEPS).map(move |i| {
            let part = f64::from(i) / f64::from(STEPS);
            (x0 + part * (x1 - x0), y0 + part * (y1 - y0))
        })
    });
    between.chain(points.iter().copied()).collect()
}

/// Frame, title, decades.
fn grid(svg: &mut String, index: usize) {
    let (left, bottom) = place(index, (10f64.powi(CYCLES[0]), 10f64.powi(ERROR[0])));
    let (right, top) = place(index, (10f64.powi(CYCLES[1]), 10f64.powi(ERROR[1])));
    let mut text = |x: f64, y: f64, anchor: &str, what: &str| {
        let _ = writeln!(
            svg,
            "<text x='{x:.1}' y='{y:.1}' text-anchor='{anchor}'>{what}</text>"
        );
    };
    text((left + right) / 2.0, top - 10.0, "middle", CORES[index].0);
    text(
        (left + right) / 2.0,
        bottom + 32.0,
        "middle",
        "cycles of a call, mean",
    );
    if index == 0 {
        text(2.0, top - 10.0, "start", "RMS error, % of F_s");
    }
    let mut lines = String::new();
    for decade in CYCLES[0]..=CYCLES[1] {
        let (x, _) = place(index, (10f64.powi(decade), 1.0));
        let _ = write!(lines, "M{x:.1} {top:.1}V{bottom:.1}");
        text(x, bottom + 15.0, "middle", &format!("1e{decade}"));
    }
    for decade in ERROR[0]..=ERROR[1] {
        let (_, y) = place(index, (1.0, 10f64.powi(decade)));
        let _ = write!(lines, "M{left:.1} {y:.1}H{right:.1}");
        if index == 0 {
            text(left - 5.0, y + 4.0, "end", &10f64.powi(decade).to_string());
        }
    }
    let _ = writeln!(svg, "<path d='{lines}' stroke='#dddddd'/>");
}

/// What no other beats in cycles and error, by rising cycles.
fn frontier(costs: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut costs: Vec<_> = costs.collect();
    costs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    costs.retain(|(_, error)| {
        let better = *error < least;
        least = least.min(*error);
        better
    });
    costs
}

/// What nothing beats in both.
const BEST: &str = "stroke='#000000' stroke-opacity='0.25' stroke-width='7'";

fn stroke(colour: &str, dashes: &str) -> String {
    format!("stroke='{colour}' stroke-dasharray='{dashes}'")
}

fn polyline(svg: &mut String, points: &[(f64, f64)], stroke: &str) {
    let places: String = points
        .iter()
        .map(|(x, y)| format!("{x:.1},{y:.1} "))
        .collect();
    let _ = writeln!(
        svg,
        "<polyline points='{}' fill='none' {stroke}/>",
        places.trim_end()
    );
}

fn legend(svg: &mut String) {
    const COLUMNS: usize = 5;
    let entries = FAMILIES.map(|(_, title, colour, dashes)| (title, stroke(colour, dashes)));
    let best = [("what nothing beats in both", BEST.to_owned())];
    for (index, (title, stroke)) in entries.into_iter().chain(best).enumerate() {
        let x = LEFT + 215.0 * (index % COLUMNS) as f64;
        let y = TOP + SIZE[1] + 58.0 + 18.0 * (index / COLUMNS) as f64;
        polyline(svg, &[(x, y), (x + 30.0, y)], &stroke);
        let _ = writeln!(
            svg,
            "<text x='{:.1}' y='{:.1}'>{title}</text>",
            x + 36.0,
            y + 4.0
        );
    }
}

#[cfg(test)]
mod tests {
    use super::{column, every_one, frontier};

    #[test]
    fn the_frontier_is_what_nothing_beats_in_both() {
        let costs = [(10.0, 5.0), (20.0, 6.0), (30.0, 1.0), (10.0, 7.0)];
        assert_eq!(frontier(costs.into_iter()), [(10.0, 5.0), (30.0, 1.0)]);
    }

    #[test]
    fn a_kernel_that_is_not_drawn_is_refused() {
        let table = |kernel: &str, n| [((kernel.to_string(), n), 1.0)].into();
        assert_eq!(every_one(&table("packed", 6)), Ok(()));
        assert_eq!(every_one(&table("lugre_f32", 1)), Ok(()));
        for (kernel, n) in [("lugre_f32", 2), ("new_kernel", 1)] {
            assert!(every_one(&table(kernel, n)).unwrap_err().contains(kernel));
        }
    }

    #[test]
    fn a_column_leaves_out_what_is_empty() {
        let table = "# made\nkernel,n,a\nx,1,2.5\ny,2,\n";
        let found = column(table, 2);
        assert_eq!(
            found.into_iter().collect::<Vec<_>>(),
            [(("x".to_string(), 1), 2.5)]
        );
    }
}
