//! Cells that are no number: lost samples where they are few, an error where they are many.

use super::*;

/// Cells, and why they are none.
const BROKEN: [(&str, &str); 6] = [
    ("nan", "not finite"),
    ("NaN", "not finite"),
    ("inf", "not finite"),
    ("-inf", "not finite"),
    ("", "empty"),
    ("abc", "`abc` is not a number"),
];

/// 1000 rows of a swing with a repeat and a temperature, one cell of which is replaced: that of `column`, in line 502.
fn rows(column: usize, cell: &str) -> String {
    let row = |i: i32| {
        let phase = f64::from(i) * 0.02;
        let mut cells = [
            format!("{}", f64::from(i) * 0.002),
            format!("{:.9}", 0.01 * phase.sin()),
            format!("{:.6}", 3.0 * phase.cos().signum()),
            format!("{}", i / 250),
            format!("{:.3}", 20.0 + 0.001 * f64::from(i)),
            format!("{}", i % 7),
        ];
        if i == 500 {
            cells[column] = cell.to_owned();
        }
        cells.join(",") + "\n"
    };
    let rows: String = (0..1000).map(row).collect();
    format!("t_s,x_m,force_N,repeat,temperature_C,note_mm\n{rows}")
}

#[test]
fn one_broken_cell_in_any_column_is_a_lost_sample_or_a_held_value() {
    let whole = read(&rows(0, "1"));
    assert!(!warns(&whole, "lost-samples") && whole.len() == 1000);
    for column in 0..6 {
        for (cell, reason) in BROKEN {
            let r = text(&rows(column, cell), &[]).unwrap_or_else(|e| panic!("{column} {e}"));
            let code = if column == 5 {
                "held-values"
            } else {
                "lost-samples"
            };
            let lost = said(&r, code);
            assert!(lost.contains("line 502"), "{column} `{cell}`: {lost}");
            // A repeat is a whole number, and none for that reason.
            let is_told = column > 2 || lost.contains(reason);
            assert!(is_told, "{column} `{cell}`: {lost}");
            // The gap of one sample is bridged, and nothing else moves.
            assert_eq!((r.len(), r.pieces.len()), (1000, 1), "{column} `{cell}`");
            for (i, (a, b)) in r.position.iter().zip(&whole.position).enumerate() {
                let near = if i == 500 { 1e-7 } else { 1e-15 };
                assert!((a - b).abs() <= near, "{column} `{cell}` {i}: {a} {b}");
            }
            check_invariants(&r);
        }
    }
}

#[test]
fn what_is_broken_throughout_is_an_error_with_its_first_line() {
    for column in 0..5 {
        for (cell, _) in BROKEN {
            let whole = rows(0, "1");
            let (header, samples) = whole.split_once('\n').expect("header");
            let row = |line: &str| {
                let mut cells: Vec<&str> = line.split(',').collect();
                cells[column] = cell;
                cells.join(",") + "\n"
            };
            let samples: String = samples.lines().map(row).collect();
            let broken = format!("{header}\n{samples}");
            refuses(text(&broken, &[]), &["line 2, column"]);
        }
    }
}

#[test]
fn lost_rows_are_named_and_counted_up_to_a_tenth() {
    let lose = |every: usize| {
        let whole = rows(0, "1");
        let rows = whole.lines().enumerate().map(|(i, line)| match i % every {
            1 if i > 1 => "0.5,0.1\n".to_owned(),
            _ => format!("{line}\n"),
        });
        text(&rows.collect::<String>(), &[])
    };
    let r = lose(50).expect("two in a hundred");
    let lost = said(&r, "lost-samples");
    for part in [
        "19 samples",
        "line 52: 2 cells where the header has 6",
        "line 102, 152",
        "10 more",
    ] {
        assert!(lost.contains(part), "{lost}");
    }
    refuses(lose(8), &["line 10: 2 cells"]);
}

#[test]
fn lost_elements_of_variables_are_left_out_of_all_of_them() {
    use super::super::variables::{Variable, table};
    let swing = |i: i32| (f64::from(i) * 0.02).sin();
    let column = |name: &str, value: &dyn Fn(i32) -> f64| {
        Variable::column(name, (0..1000).map(value).collect())
    };
    let load = |broken: &[i32]| {
        let at = |i: i32, value: f64| if broken.contains(&i) { f64::NAN } else { value };
        let variables = [
            column("t_s", &|i| f64::from(i) * 0.002),
            column("x_m", &|i| at(i, swing(i))),
            column("force_N", &|i| swing(i + 70).signum()),
            column("other", &|i| {
                if i == 7 { f64::INFINITY } else { swing(3 * i) }
            }),
        ];
        table(&variables, &options(&[])).and_then(|t| assemble(t, "v.npz", &options(&[])))
    };
    let r = load(&[500, 501]).expect("two");
    let lost = said(&r, "lost-samples");
    for part in ["2 samples are lost: element 501", "element 502"] {
        assert!(lost.contains(part), "{lost}");
    }
    assert!(said(&r, "held-values").contains("element 8"));
    assert_eq!((r.len(), r.extra.len()), (1000, 1));
    check_invariants(&r);
    let all: Vec<i32> = (0..1000).step_by(5).collect();
    refuses(load(&all), &["element 1", "`x_m`"]);
}
