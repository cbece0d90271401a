//! What loggers, spreadsheets and microcontrollers write: counters, clocks of twelve hours, labels, names with their paths, numbers in groups.

use super::foreign::{as_told, is_joint, joint_rows};
use super::*;

type Joint = (f64, f64, f64, f64);

/// Rows of a time as it is written, position and torque.
fn timed(name: &str, time: impl Fn(i32) -> String) -> String {
    joint_rows(&format!("{name},q_rad,torque_Nm\n"), |i, (_, q, _, f)| {
        format!("{},{q:.9},{f:.9}", time(i))
    })
}

#[test]
fn counters_of_time_are_known_by_their_names_and_units() {
    for (name, bits, per_second) in [
        ("tick_us", 16, 1e6),
        ("ticks_us", 16, 1e6),
        ("counter_ms", 16, 1e3),
        ("tickUs", 24, 1e6),
        ("t_us", 24, 1e6),
        ("timer [us]", 32, 1e6),
        ("micros", 32, 1e6),
        ("timestamp_usec", 32, 1e6),
        ("time_micros", 32, 1e6),
        ("clock_ns", 32, 1e9),
    ] {
        let range = 1_i64 << bits;
        let step = (per_second * 0.002) as i64;
        let count =
            |i: i32| ((range - 300 * step / 2 + step * i64::from(i)).rem_euclid(range)).to_string();
        let (r, maps) = as_told(&timed(name, count));
        assert_eq!(maps, [""; 0], "{name}");
        assert!(warns(&r, "time-wrapped"), "{name}: {:?}", r.warnings);
        is_joint(name, &r, 1.0);
    }
    // By its unit alone it is offered.
    let (r, maps) = as_told(&timed("esp.loop_us", |i| (2000 * i).to_string()));
    assert_eq!(maps, ["--map t_s=esp.loop_us"]);
    is_joint("loop_us", &r, 1.0);
    for (name, step) in [("loop.dt_us", "2000"), ("loop.dt", "0.002")] {
        let (r, maps) = as_told(&timed(name, |_| step.into()));
        assert_eq!(maps, [format!("--map dt_s={name}")]);
        is_joint(name, &r, 1.0);
    }
    // Below four samples a turn a wrap is as near as none.
    let few = timed("tick_us", |i| (20_000 * i % 65_536).to_string());
    refuses(text(&few, &[]), &["backwards"]);
}

#[test]
fn no_sample_time_is_invented() {
    let row = |_, (_, q, _, f): Joint| format!("{q:.9},{f:.9}");
    let csv = joint_rows("q_rad,torque_Nm\n", row);
    let ticks = timed("tick", |i| (2000 * i).to_string());
    let counted = joint_rows("", |i, (_, q, _, f)| format!("{i} {q:.9} {f:.9}"));
    for (csv, map, part) in [
        (&csv, &[][..], "--map dt_s=SAMPLE_TIME_IN_S"),
        (&csv, &[], "your own in place of SAMPLE_TIME_IN_S"),
        (
            &csv,
            &[("dt_s", "SAMPLE_TIME_IN_S")],
            "put your own in place of `SAMPLE_TIME_IN_S`",
        ),
        (&ticks, &[], "--map 't_s=FACTOR*tick'"),
        (&counted, &[], "dt_s=SAMPLE_TIME_IN_S"),
    ] {
        refuses(text(csv, map), &[part]);
    }
    // What the file states beside its columns is no invention.
    for (header, maps) in [
        (
            "Scope 4\nSampling rate: 500 Hz\n\nq_rad,torque_Nm\n",
            "--map dt_s=0.002",
        ),
        ("# dt = 2 ms\nq_rad,torque_Nm\n", "--map dt_s=0.002"),
        (
            "# fs = 500\n",
            "--map dt_s=0.002 --map q_rad=column1 --map effort_raw=column2",
        ),
    ] {
        let (r, told) = as_told(&joint_rows(header, row));
        assert_eq!(told.join(" "), maps, "{header}");
        is_joint(header, &r, 1.0);
    }
}

#[test]
fn names_with_paths_and_units_are_offered_whole() {
    let (turn, degree) = (std::f64::consts::TAU, std::f64::consts::PI / 180.0);
    for (position, effort, (one, unit), maps) in [
        (
            "Axis1.ActPos_turns",
            "Axis1.ActTorque_mNm",
            (turn, 1e-3),
            "--map q_rad=Axis1.ActPos_turns --map torque_Nm=Axis1.ActTorque_mNm",
        ),
        (
            "state.q_rad",
            "cmd.torque_Nm",
            (1.0, 1.0),
            "--map q_rad=state.q_rad --map torque_Nm=cmd.torque_Nm",
        ),
        (
            "fActPosDeg",
            "fTorqueNm",
            (degree, 1.0),
            "--map q_rad=fActPosDeg --map torque_Nm=fTorqueNm",
        ),
        (
            "joint/0/encoder_degrees",
            "joint/0/load_cell_Nm",
            (degree, 1.0),
            "--map q_rad=joint/0/encoder_degrees --map torque_Nm=joint/0/load_cell_Nm",
        ),
        (
            "A1_mrad",
            "torque_setpoint_std,A1_cmd_Ncm",
            (1e-3, 1e-2),
            "--map q_rad=A1_mrad --map torque_Nm=A1_cmd_Ncm",
        ),
    ] {
        let extra = effort.matches(',').count();
        let csv = joint_rows(&format!("t_s,{position},{effort}\n"), |_, (t, q, _, f)| {
            format!(
                "{t:.3},{:.12},{}{:.12}",
                q / one,
                "7,".repeat(extra),
                f / unit
            )
        });
        let (r, told) = as_told(&csv);
        assert_eq!(told.join(" "), maps);
        is_joint(position, &r, 1.0);
    }
    let speed = "t_s,Motor.Speed_rpm,Motor.Torque_Nm\n0,60,1\n1,120,2\n2,60,1\n";
    let (r, told) = as_told(speed);
    assert_eq!(told, [""; 0]);
    assert!((r.velocity.expect("measured")[1] - 2.0 * turn).abs() < 1e-12);
    // What a count is worth only its user knows.
    let counts = "t_s,enc_counts,torque_Nm\n0,1,1\n1,2,1\n2,3,1\n";
    refuses(text(counts, &[]), &["--map 'q_rad=FACTOR*enc_counts'"]);
}

#[test]
fn numbers_behind_their_names_are_read() {
    for (separator, colon) in [("\t", ":"), (",", ":"), (" ", ":"), (", ", ": ")] {
        let mut csv = joint_rows("", |_, (t, q, _, f)| {
            ["t", "q_rad", "torque_Nm"]
                .iter()
                .zip([t, q, f])
                .map(|(name, v)| format!("{name}{colon}{v:.9}"))
                .collect::<Vec<_>>()
                .join(separator)
        });
        // A line that was cut before it began to be heard.
        csv.insert_str(0, &format!("1{separator}torque_Nm{colon}0.1\n"));
        is_joint(separator, &read(&csv), 1.0);
        // One that lost a name is a lost sample.
        let r = read(&csv.replacen("q_rad", "q_ra", 1));
        let is_lost = (r.len(), warns(&r, "lost-samples")) == (3998, true);
        assert!(is_lost || r.len() == 3999, "{}", r.len());
    }
    let (_, told) = as_told(&joint_rows("", |_, (t, q, _, f)| {
        format!("t:{t:.3}\tpos:{q:.9}\ttau:{f:.9}")
    }));
    assert_eq!(told.join(" "), "--map q_rad=pos --map torque_Nm=tau");
}

#[test]
fn clocks_of_twelve_hours_are_read_across_noon_and_midnight() {
    for (date, start, first, second) in [
        ("", 11, "AM", "PM"),
        ("", 11, "pm", "am"),
        ("3/31/2024 ", 11, "AM", "PM"),
    ] {
        let time = |i: i32| {
            let ms = i * 2;
            // From two seconds before the twelfth hour.
            match ms < 2000 {
                true => format!(
                    "{date}{start}:59:{:06.3} {first}",
                    58.0 + f64::from(ms) / 1e3
                ),
                false => format!("{date}12:00:{:06.3} {second}", f64::from(ms - 2000) / 1e3),
            }
        };
        is_joint(first, &read(&timed("Time", time)), 1.0);
    }
}

/// With commas between thousands.
fn grouped(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value.abs());
    let (whole, part) = text.split_once('.').unwrap_or((&text, ""));
    let groups = whole
        .as_bytes()
        .rchunks(3)
        .rev()
        .map(String::from_utf8_lossy);
    let whole = groups.collect::<Vec<_>>().join(",");
    let sign = if value < 0.0 { "-" } else { "" };
    match part {
        "" => format!("{sign}{whole}"),
        part => format!("{sign}{whole}.{part}"),
    }
}

#[test]
fn thousands_in_quotes_are_numbers() {
    // Times without decimals are in thousands where others show their points.
    for decimals in [0, 1] {
        let csv = joint_rows(
            "\"t_ms\",\"Position [urad]\",\"Torque [uNm]\"\n",
            |_, (t, q, _, f)| {
                format!(
                    "\"{}\",\"{}\",\"{}\"",
                    grouped(1e3 * t, decimals),
                    grouped(1e6 * q, 3),
                    grouped(1e6 * f, 3)
                )
            },
        );
        is_joint("commas", &read(&csv), 1.0);
        let semicolons = csv.replace("\",\"", ";").replace('"', "");
        if decimals > 0 {
            is_joint("semicolons", &read(&semicolons), 1.0);
            // The other way round.
            let other = semicolons
                .replace('.', "'")
                .replace(',', ".")
                .replace('\'', ",");
            is_joint("points", &read(&other), 1.0);
        }
    }
    let unsure = "t_s,x_m,force_N\n\"1,000\",\"2,000\",\"3\"\n\"1,001\",\"2,500\",\"3\"\n";
    refuses(text(unsure, &[]), &["line 2", "thousands or of decimals"]);
}

#[test]
fn names_may_be_separated_otherwise_than_the_samples() {
    for (header, separator) in [
        (
            "# logger v1.2\n# date 2024-03-31\n# t_s q_rad torque_Nm\n",
            "\t",
        ),
        ("# t_s q_rad torque_Nm\n# logged by me\n", ","),
        ("# t_s, q_rad, torque_Nm\n", " "),
        ("t_s, q_rad, torque_Nm\n", " "),
        ("t_s q_rad torque_Nm\n", ";"),
        ("% t_s,q_rad,torque_Nm\n", "\t"),
    ] {
        let csv = joint_rows(header, |_, (t, q, _, f)| {
            [t, q, f].map(|v| format!("{v:.9}")).join(separator)
        });
        let r = text(&csv, &[]).unwrap_or_else(|e| panic!("{header}{e}"));
        assert_eq!(r.role, EffortRole::Torque, "{header}");
        is_joint(header, &r, 1.0);
    }
}

#[test]
fn channels_of_a_scope_alone_have_their_times() {
    let header = "Name\tAxis.ActPos\tName\tAxis.ActTorque\nSymbolComment\t\tSymbolComment\t\nUnit\tdeg\tUnit\tNm\nSampleTime[ms]\t2\tSampleTime[ms]\t2\n\n";
    let csv = joint_rows(header, |_, (t, q, _, f)| {
        let t = 1e3 * t;
        format!("{t:.0}\t{:.9}\t{t:.0}\t{f:.9}", q.to_degrees())
    });
    let (r, told) = as_told(&csv);
    assert_eq!(told, [""; 0]);
    is_joint("channels", &r, 1.0);
}

/// A scale against another one, place by place: seconds by their name, and nothing to ask.
#[test]
fn a_scan_may_take_seconds_a_place() {
    let rows = |name: &str| {
        let row = |i: i32| {
            let place = (i % 60 - 30).abs();
            format!("{},{},{}\n", 2 * i, 0.005 * f64::from(place), 3 + i % 7)
        };
        let rows: String = (0..240).map(row).collect();
        format!("{name},x_m,force_N\n{rows}")
    };
    let asks = |csv: &str| warns(&read(csv), "implausible");
    assert!(!asks(&rows("t_s")) && asks(&rows("t")));
    let fine: String = swing(|_, _, _| {})
        .lines()
        .enumerate()
        .map(|(i, l)| match l.split_once(',') {
            Some((_, rest)) if i > 0 => format!("{},{rest}\n", 2 * i),
            _ => format!("{l}\n"),
        })
        .collect();
    assert!(asks(&fine), "milliseconds called seconds");
}
