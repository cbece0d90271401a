//! Files of other tools: their clocks, their layouts, and the command that brings them in.

use preslide_host_tests::shared;

use super::*;

/// A joint that swings by 1.06 rad with its friction, 4000 samples at 500 Hz.
fn joint(i: i32) -> (f64, f64, f64, f64) {
    let phase = f64::from(i) * 0.002 * 2.2;
    let (q, qd) = (1.06 * phase.sin(), 1.06 * 2.2 * phase.cos());
    let torque = 0.05 * (qd / 0.1).tanh() + 0.004 * qd + 1e-3 * (f64::from(i) * 0.7).sin();
    (f64::from(i) * 0.002, q, qd, torque)
}

pub(super) fn joint_rows(
    header: &str,
    row: impl Fn(i32, (f64, f64, f64, f64)) -> String,
) -> String {
    let rows = (0..4000).map(|i| row(i, joint(i)) + "\n");
    format!("{header}{}", rows.collect::<String>())
}

/// Loads it with what its error says to, if it is refused; the maps that it took.
pub(super) fn as_told(csv: &str) -> (Recording, Vec<String>) {
    let maps = match text(csv, &[]) {
        Ok(r) => return (r, Vec::new()),
        Err(e) => e.problem.maps().to_vec(),
    };
    let map = maps.iter().map(|m| {
        let map = m.trim_start_matches("--map ").trim_matches('\'');
        parse_map(map).unwrap_or_else(|e| panic!("{e}"))
    });
    let map: Vec<_> = map.collect();
    let map: Vec<_> = map.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let r = text(csv, &map);
    (r.unwrap_or_else(|e| panic!("{maps:?}: {e}")), maps)
}

/// The motion and effort of [`joint`], to the digits that a file holds.
pub(super) fn is_joint(name: &str, r: &Recording, effort: f64) {
    let is = (r.len(), r.pieces.len(), r.kind);
    assert_eq!(is, (4000, 1, MotionKind::Rotary), "{name}");
    let step = r.sample_time_s();
    assert!((step - 0.002).abs() < 1e-6, "{name}: {step}");
    let right = |of: &dyn Fn((f64, f64, f64, f64)) -> f64| -> Vec<f64> {
        (0..4000).map(|i| of(joint(i))).collect()
    };
    for (column, right) in [
        (&r.t_s, right(&|joint| r.t_s[0] + joint.0)),
        (&r.position, right(&|joint| joint.1)),
        (&r.effort, right(&|joint| effort * joint.3)),
    ] {
        let worst = apart(column, &right);
        assert!(worst < 2e-6, "{name}: {worst}");
    }
    check_invariants(r);
}

#[test]
fn a_clock_that_wraps_goes_on() {
    let row = |t: String, (_, q, _, f): (f64, f64, f64, f64)| format!("{t},{q:.9},{f:.9}");
    for (name, first, range, per_second, map) in [
        ("micros", 4_294_000_000_u64, 1_u64 << 32, 1e6, &[][..]),
        ("millis", 60_000, 1 << 16, 1e3, &[]),
        (
            "cycles",
            16_000_000,
            1 << 24,
            1e6,
            &[("t_s", "1e-6*cycles")],
        ),
    ] {
        let step = (per_second * 0.002) as u64;
        let csv = joint_rows(&format!("{name},q_rad,torque_Nm\n"), |i, joint| {
            row(((first + step * i as u64) % range).to_string(), joint)
        });
        let r = text(&csv, map).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(warns(&r, "time-wrapped"), "{name}: {:?}", r.warnings);
        is_joint(name, &r, 1.0);
    }
    // Seconds of the day past midnight; a clock that starts again is no counter.
    let of_day = |i: i32| format!("{:.3}", (86_396.0 + f64::from(i) * 0.002) % 86_400.0);
    let csv = joint_rows("t_s,q_rad,torque_Nm\n", |i, joint| row(of_day(i), joint));
    is_joint("seconds of the day", &read(&csv), 1.0);
    let again = |i: i32| format!("{}", i % 2000 * 2000);
    let csv = joint_rows("micros,q_rad,torque_Nm\n", |i, joint| row(again(i), joint));
    refuses(text(&csv, &[]), &["runs backwards", "line 2002"]);
}

#[test]
fn a_time_step_a_row_and_a_stamp_in_parts_are_times() {
    for (header, time) in [
        ("dt_s", |_: i32| "0.002".to_owned()),
        ("timestep [us]", |_| "2000".to_owned()),
        ("delta_t [ms]", |_| "2".to_owned()),
        ("time_step", |_| "0.002".to_owned()),
        // The name of a step, and the time itself.
        ("timestep [us]", |i| (2000 * i).to_string()),
        ("sec,nanosec", |i| {
            format!("{},{}", 1_764_170_000 + i / 500, i % 500 * 2_000_000)
        }),
        ("stamp.secs,stamp.nsecs", |i| {
            format!("{},{}", 1_764_170_000 + i / 500, i % 500 * 2_000_000)
        }),
        ("tv_sec,tv_usec", |i| {
            format!("{},{}", 17_000 + i / 500, i % 500 * 2000)
        }),
    ] as [(&str, fn(i32) -> String); 8]
    {
        let csv = joint_rows(&format!("{header},q_rad,torque_Nm\n"), |i, (_, q, _, f)| {
            format!("{},{q:.9},{f:.9}", time(i))
        });
        let r = text(&csv, &[]).unwrap_or_else(|e| panic!("{header}: {e}"));
        is_joint(header, &r, 1.0);
    }
    let csv = joint_rows("q_rad,torque_Nm\n", |_, (_, q, _, f)| {
        format!("{q:.9},{f:.9}")
    });
    refuses(text(&csv, &[]), &["--map dt_s=SAMPLE_TIME_IN_S"]);
    let stepped = text(&csv, &[("dt_s", "0.002")]).expect("a step");
    is_joint("a number", &stepped, 1.0);
    // Since 1970, in whatever a tool counts it in.
    for per_second in [1e3, 1e6, 1e9] {
        let csv = joint_rows("timestamp,q_rad,torque_Nm\n", |_, (t, q, _, f)| {
            format!("{:.0},{q:.9},{f:.9}", per_second * (1.764e9 + t))
        });
        let r = text(&csv, &[]).unwrap_or_else(|e| panic!("{per_second}: {e}"));
        assert!(warns(&r, "since-1970") && !warns(&r, "implausible"));
        is_joint("since 1970", &r, 1.0);
    }
    for bad in ["0", "-0.002", "0*q_rad"] {
        assert!(text(&csv, &[("dt_s", bad)]).is_err(), "{bad}");
    }
}

#[test]
fn a_file_without_a_header_is_refused_with_the_command_that_reads_it() {
    let degrees = 180.0 / std::f64::consts::PI;
    type Row = fn(i32, (f64, f64, f64, f64), f64) -> String;
    for (name, scale, row, maps) in [
        (
            "a counter, a stamp, degrees",
            degrees,
            (|i, (t, q, _, f), k| format!("{i} {:.6} {:.9} {f:.9}", 1.764e9 + t, k * q)) as Row,
            "--map t_s=column2 --map 'q_rad=column3[deg]' --map effort_raw=column4",
        ),
        (
            "a counter and seconds",
            1.0,
            |i, (t, q, _, f), _| format!("{i}\t{t:.6}\t{q:.9}\t{f:.9}"),
            "--map t_s=column2 --map q_rad=column3 --map effort_raw=column4",
        ),
        (
            "microseconds",
            1.0,
            |i, (_, q, qd, f), _| format!("{},{q:.9},{qd:.9},{f:.9}", 2000 * i + 77),
            "--map 't_s=1e-6*column1' --map q_rad=column2 --map effort_raw=column4",
        ),
        (
            "a reference, an effort, a velocity, an angle",
            1.0,
            |_, (_, q, qd, f), _| format!("{q:.9}\t{f:.9}\t{qd:.9}\t{q:.9}"),
            "--map dt_s=2.000e-3 --map q_rad=column4 --map effort_raw=column2",
        ),
        (
            "decimal commas",
            1.0,
            |_, (t, q, _, f), _| format!("{t:.3};{q:.9};{f:.9};").replace('.', ","),
            "--map t_s=column1 --map q_rad=column2 --map effort_raw=column3",
        ),
    ] {
        let csv = joint_rows("", |i, joint| row(i, joint, scale));
        let (r, told) = as_told(&csv);
        assert_eq!(told.join(" "), maps, "{name}");
        is_joint(name, &r, 1.0);
        refuses(text(&csv, &[("t_s", "column9")]), &["column3"]);
    }
}

#[test]
fn joint_states_echoed_as_csv_are_named_by_their_joints() {
    let stamp = |i: i32| format!("{},{}", 1_764_170_000 + i / 500, i % 500 * 2_000_000);
    let csv = joint_rows("", |i, (_, q, qd, f)| {
        format!(
            "{},base,elbow,wrist,{q:.9},1.5,{qd:.9},0,{f:.9},0.1",
            stamp(i)
        )
    });
    let map = [("q_rad", "elbow.position"), ("torque_Nm", "elbow.effort")];
    is_joint("two joints", &text(&csv, &map).expect("mapped"), 1.0);
    let csv = joint_rows("", |i, (_, q, qd, f)| {
        format!("{},,elbow,{q:.9},{qd:.9},{f:.9}", stamp(i))
    });
    let (r, told) = as_told(&csv);
    assert_eq!(
        told.join(" "),
        "--map q_rad=elbow.position --map torque_Nm=elbow.effort"
    );
    is_joint("one joint", &r, 1.0);
}

/// The same with a date for the time.
fn rows_of_stamps() -> String {
    let row = |i: i32| {
        let (t, q, _, f) = joint(i);
        format!(
            "{{\"t\": \"2025-11-09T09:27:{t:06.3}Z\", \"state\": {{\"pos\": {q:.9}}}, \"torque\": [{f:.9}]}}"
        )
    };
    (0..4000).map(row).collect::<Vec<_>>().join(",")
}

#[test]
fn json_is_read_by_lines_rows_and_arrays() {
    let object = |(t, q, _, f): (f64, f64, f64, f64)| {
        format!("{{\"t\": {t:.6}, \"state\": {{\"pos\": {q:.9}}}, \"torque\": [{f:.9}]}}")
    };
    let lines = joint_rows("", |_, joint| object(joint));
    let rows = lines.trim().replace('\n', ",\n  ");
    let array = |value: fn((f64, f64, f64, f64)) -> f64| {
        let values: Vec<String> = (0..4000)
            .map(|i| format!("{:.9}", value(joint(i))))
            .collect();
        format!("[{}]", values.join(", "))
    };
    for (name, json) in [
        ("lines", lines.clone()),
        ("rows", format!("[\n  {rows}\n]")),
        ("stamps", format!("[{}]", rows_of_stamps())),
        (
            "rows within",
            format!("{{\"rate\": 500, \"samples\": [{rows}]}}"),
        ),
        (
            "arrays",
            format!(
                "{{\"t\": {}, \"state.pos\": {}, \"torque.0\": {}, \"name\": \"x\"}}",
                array(|j| j.0),
                array(|j| j.1),
                array(|j| j.3)
            ),
        ),
    ] {
        let (r, told) = as_told(&json);
        assert_eq!(
            told.join(" "),
            "--map q_rad=state.pos --map effort_raw=torque.0",
            "{name}"
        );
        is_joint(name, &r, 1.0);
    }
    // A line cut short and a number that is none are lost samples, reported by their lines.
    let mut broken: Vec<&str> = lines.lines().collect();
    let nan = broken[100].replace("\"pos\": ", "\"pos\": NaN, \"was\": ");
    (broken[100], broken[200]) = (&nan, &broken[200][..30]);
    let map = [("q_rad", "state.pos"), ("effort_raw", "torque.0")];
    let r = text(&broken.join("\n"), &map).expect("two lost");
    let lost = said(&r, "lost-samples");
    for part in ["2 samples", "line 101", "`state.pos`", "line 201"] {
        assert!(lost.contains(part), "{lost}");
    }
    for bad in [
        "{\"t\": ",
        "[{}]",
        "{\"a\": \"b\"}",
        "{\"t\" 1}\n{\"t\" 2}\n",
    ] {
        let e = text(bad, &[]).expect_err(bad).to_string();
        assert!(e.contains("JSON") || e.contains("no time"), "{bad}: {e}");
    }
}

#[test]
fn a_map_adds_up_products_of_columns() {
    let csv = "Zeit [s];Weg [mm];pA [bar];pB [bar]\n0,00;10,0;4,25;5,00\n0,01;10,5;4,50;5,25\n0,02;11,0;4,75;5,00\n";
    let sum = "--map 'force_N=1e5*AREA_M2*pA [bar]-1e5*AREA_M2*pB [bar]'";
    refuses(text(csv, &[]), &[sum]);
    for map in [
        "100*pA-80*pB",
        "100 * pA [bar] - 80 * pB [bar]",
        "-80*pB+100*pA",
        "100*pA[bar]+-80*pB[bar]",
    ] {
        let r = text(csv, &[("force_N", map)]).unwrap_or_else(|e| panic!("{map}: {e}"));
        assert!(apart(&r.effort, &[25.0, 30.0, 75.0]) < 1e-9, "{map}");
        for part in [" [bar]` is taken in bar", "1e5*AREA_M2"] {
            assert!(said(&r, "unit-kept").contains(part), "{:?}", r.warnings);
        }
        assert_eq!(r.position, [0.01, 0.0105, 0.011]);
    }
    let shifted = text(csv, &[("force_N", "pA*2-8")]).expect("an offset");
    assert_eq!(shifted.effort, [0.5, 1.0, 1.5]);
    // A drive's constant is in N/A, whatever the column is in; a factor of the same quantity is the user's own.
    let current = "t_s;x_m;Strom [mA];Weg [mm]\n0;0;10;1\n0.01;1;20;2\n0.02;2;30;3\n";
    let r = text(current, &[("force_N", "20*Strom"), ("x_m", "0.002*Weg")]).expect("N/A");
    assert!(apart(&r.effort, &[0.2, 0.4, 0.6]) < 1e-9);
    assert!(apart(&r.position, &[0.002, 0.004, 0.006]) < 1e-9);
    assert!(r.warnings.iter().any(|w| w.code == "unit-applied"));
    let unknown = text(csv, &[("force_N", "100*pA-80*pC")]);
    refuses(unknown, &["no column `pC`"]);
}

#[test]
fn a_current_of_hundreds_is_asked_about_by_its_column_and_travel_is_counted() {
    let csv = joint_rows("t_s,q_rad,iq\n", |_, (t, q, _, f)| {
        let counts = (q / (std::f64::consts::TAU / 4096.0)).round();
        format!(
            "{t:.3},{:.9},{:.3}",
            counts * std::f64::consts::TAU / 4096.0,
            5000.0 * f
        )
    });
    let r = text(&csv, &[("current_A", "iq")]).expect("taken as amperes");
    let asked = |r: &Recording| {
        let asked = r.warnings.iter().find(|w| w.code == "implausible");
        asked.expect("asked").maps.clone()
    };
    assert!(said(&r, "implausible").contains("`iq` is in mA"));
    assert_eq!(asked(&r), ["current_A=0.001*iq"]);
    let line = r.in_one_line();
    assert!(line.contains("travel 2.12 rad (1382 counts)"), "{line}");
    let r = text(&csv, &[("current_A", "0.001*iq")]).expect("as told");
    assert!(!warns(&r, "implausible") && r.in_one_line().contains("current ±"));
    // A time in another unit shows by how long its steps are.
    for (per_second, factor) in [(1e3, "0.001"), (1e6, "0.000001"), (1e9, "0.000000001")] {
        let csv = joint_rows("t,q_rad,torque_Nm\n", |_, (t, q, _, f)| {
            format!("{:.0},{q:.9},{f:.9}", per_second * t)
        });
        let map = format!("{factor}*t");
        assert_eq!(asked(&read(&csv)), [format!("t_s={map}")]);
        is_joint(factor, &text(&csv, &[("t_s", &map)]).expect("as told"), 1.0);
    }
    // What is no multiple of anything has no counts.
    let csv = joint_rows("t_s,q_rad,torque_Nm\n", |_, (t, q, _, f)| {
        format!("{t},{q},{f}")
    });
    let line = read(&csv).in_one_line();
    assert!(!line.contains("counts"), "{line}");
}

/// Each of the shared files, read as it is or by what its error says, is the same motion.
#[test]
fn every_shared_format_is_read_or_says_how() {
    let Some(root) = shared("cases/formats") else {
        return;
    };
    let right = real_file(&root, "iso.csv", &[]);
    let mut seen = 0;
    for file in std::fs::read_dir(&root).expect("folder").flatten() {
        let name = file.file_name().to_string_lossy().into_owned();
        let bytes = std::fs::read(file.path()).expect("readable");
        let (r, maps) = as_told(&String::from_utf8_lossy(&bytes));
        println!("{name}: {maps:?}");
        // Without a header they have a row more.
        assert!(
            (3999..=4000).contains(&r.len()) && r.kind == MotionKind::Rotary,
            "{name}"
        );
        assert!((r.sample_time_s() - 0.002).abs() < 1e-6, "{name}");
        // The monitor logs volts, 20 of which are a newton metre there.
        let unit = if name.starts_with("simplefoc") {
            20.0
        } else {
            1.0
        };
        let effort: Vec<f64> = r.effort.iter().map(|f| f / unit).collect();
        let n = right.len();
        assert!(apart(&r.position[..n], &right.position) < 1e-4, "{name}");
        assert!(apart(&effort[..n], &right.effort) < 1e-5, "{name}");
        seen += 1;
    }
    assert_eq!(seen, 9, "files of the folder");
}

/// Tables of speed and effort are no recordings, and are loaded as what they are.
#[test]
fn a_table_without_time_is_told_from_a_recording() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("table.csv");
    let load = |text: &str| {
        std::fs::write(&path, text).expect("written");
        load_speeds(&path, &options(&[]))
    };
    let table = load("velocity_rpm,torque_mNm\n60,1\n0,\n120,2\n-60,-1\n-120,-2\n180,3\n240,4\n300,5\n360,6\n420,7\n480,8\n").expect("a table").expect("a table");
    assert_eq!((table.velocity.len(), table.kind), (10, MotionKind::Rotary));
    assert!((table.velocity[0] - std::f64::consts::TAU).abs() < 1e-12);
    assert_eq!(table.effort[1], 0.002);
    let lost = table.warnings.iter().find(|w| w.code == "lost-samples");
    assert!(lost.is_some_and(|w| w.message.contains("line 3")));
    for other in [
        "t_s,qd_rad_s,torque_Nm\n0,1,1\n1,2,2\n",
        "q_rad,qd_rad_s,torque_Nm\n0,1,1\n1,2,2\n",
        "qd_rad_s,note\n1,1\n2,2\n",
    ] {
        assert!(load(other).expect("no table").is_none(), "{other}");
    }
    let words = load("qd_rad_s,torque_Nm\n1,1\n2,x\n3,y\n");
    refuses(words, &["line 3", "`x`"]);
}
