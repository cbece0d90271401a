//! What is asked about: of true machines nothing, of those with a wrong unit most.

use super::*;
use preslide_host_tests::{recordings, shared};
use std::fmt::Write;

/// A machine that exists: what it does, and what it takes.
struct Machine {
    name: &'static str,
    kind: MotionKind,
    /// Position and effort as columns are called that do not say their unit.
    bare: [&'static str; 2],
    /// m or rad, per s, per s².
    travel: f64,
    speed: f64,
    acceleration: f64,
    /// kg or kg·m², N or N·m, and of a spring about the middle per m or rad.
    inertia: f64,
    coulomb: f64,
    spring: f64,
}

const fn machine(
    name: &'static str,
    kind: MotionKind,
    [travel, speed, acceleration]: [f64; 3],
    [inertia, coulomb, spring]: [f64; 3],
) -> Machine {
    Machine {
        name,
        kind,
        bare: match kind {
            MotionKind::Linear => ["pos", "force"],
            MotionKind::Rotary => ["angle", "torque"],
        },
        travel,
        speed,
        acceleration,
        inertia,
        coulomb,
        spring,
    }
}

use MotionKind::{Linear, Rotary};
#[rustfmt::skip]
const MACHINES: [Machine; 20] = [
    machine("nanometre stage", Linear, [2e-6, 1e-5, 1e-3], [0.5, 0.05, 2e4]),
    machine("piezo stage", Linear, [1e-4, 0.01, 50.0], [1.0, 0.5, 1e6]),
    machine("fast tool servo", Linear, [2e-5, 0.06, 2e3], [0.05, 0.1, 1e6]),
    machine("voice coil", Linear, [0.01, 1.0, 200.0], [0.05, 0.1, 0.0]),
    machine("stage of 12 kg", Linear, [0.04, 0.2, 5.0], [12.0, 5.0, 0.0]),
    machine("linear motor", Linear, [0.3, 1.5, 20.0], [12.0, 8.0, 0.0]),
    machine("ball screw", Linear, [0.25, 0.2, 2.0], [95.0, 20.0, 0.0]),
    machine("pneumatic cylinder", Linear, [0.2, 0.5, 5.0], [2.0, 30.0, 0.0]),
    machine("machine tool's column", Linear, [3.0, 0.5, 3.0], [8e3, 800.0, 0.0]),
    machine("gantry", Linear, [15.0, 2.0, 1.0], [3e3, 500.0, 0.0]),
    machine("press of 100 t", Linear, [0.4, 0.3, 2.0], [8e3, 2e4, 5e6]),
    machine("seismic damper", Linear, [0.2, 0.5, 2.0], [0.0, 1e6, 0.0]),
    machine("galvanometer", Rotary, [0.7, 300.0, 2e5], [1e-7, 1e-4, 0.0]),
    machine("nanoradian stage", Rotary, [1e-5, 1e-5, 1e-3], [0.01, 1e-3, 10.0]),
    machine("hobby servo", Rotary, [1.6, 5.0, 50.0], [2e-3, 0.1, 0.0]),
    machine("robot's wrist", Rotary, [4.0, 4.0, 20.0], [0.05, 1.0, 0.0]),
    machine("robot's base", Rotary, [3.7, 2.0, 10.0], [15.0, 20.0, 0.0]),
    Machine { bare: ["motor_angle", "torque"], ..machine("motor behind a gear", Rotary, [200.0, 300.0, 3e3], [1e-4, 0.05, 0.0]) },
    machine("rotary table", Rotary, [6.3, 5.0, 20.0], [5.0, 20.0, 0.0]),
    machine("antenna", Rotary, [5.0, 0.1, 0.03], [1e6, 1e4, 0.0]),
];

/// A motion to places that none of them is near another, with the steps that a log of 4000 rows has: time, position, velocity and effort.
fn run(m: &Machine) -> Vec<[f64; 4]> {
    let places = [
        0.5_f64, -0.5, 0.3, -0.1, 0.4, -0.45, 0.0, 0.5, -0.2, 0.1, -0.5, 0.0,
    ];
    let times = places.windows(2).map(|p| {
        let by = (p[1] - p[0]).abs() * m.travel;
        (1.875 * by / m.speed).max((5.77 * by / m.acceleration).sqrt())
    });
    let step = times.sum::<f64>() / 4000.0;
    let (mut rows, mut from, mut seed) = (Vec::new(), 0.0, 4_u32);
    for to in places {
        let by = to * m.travel - from;
        let time = (1.875 * by.abs() / m.speed).max((5.77 * by.abs() / m.acceleration).sqrt());
        let count = (time / step).ceil();
        for i in 0..count as u32 {
            let s = f64::from(i) / count;
            let x = from + by * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
            let v = by / time * 30.0 * s * s * (1.0 - s).powi(2);
            let a = by / (time * time) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s);
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = 0.2 * (f64::from(seed) / f64::from(u32::MAX) - 0.5);
            let friction = m.coulomb * ((v / (0.01 * m.speed)).tanh() + noise);
            let effort = m.inertia * a + friction + m.spring * x;
            rows.push([rows.len() as f64 * step, x, v, effort]);
        }
        from = to * m.travel;
    }
    rows
}

/// As its file, the columns times `factors`; `bare` columns say no unit, and are mapped as what they should be in.
fn asked(m: &Machine, factors: [f64; 4], bare: bool, with_velocity: bool) -> Option<Warning> {
    let [position, speed, effort] = match m.kind {
        Linear => ["x_m", "v_m_s", "force_N"],
        Rotary => ["q_rad", "qd_rad_s", "torque_Nm"],
    };
    let mut csv = match bare {
        true => format!("time,{},vel,{}", m.bare[0], m.bare[1]),
        false => format!("t_s,{position},{speed},{effort}"),
    };
    for row in run(m) {
        let cells: [f64; 4] = std::array::from_fn(|k| factors[k] * row[k]);
        let [t, x, v, f] = cells;
        write!(csv, "\n{t:.9e},{x:.9e},{v:.9e},{f:.9e}").expect("memory");
    }
    let maps = [
        ("t_s", "time"),
        (position, m.bare[0]),
        (speed, "vel"),
        (effort, m.bare[1]),
    ];
    let maps: Vec<_> = maps
        .into_iter()
        .filter(|m| with_velocity || m.0 != speed)
        .collect();
    let mut options = options(if bare { &maps } else { &[] });
    if !with_velocity {
        options
            .ignore
            .push(if bare { "vel" } else { speed }.to_owned());
    }
    let r = load_csv(csv.as_bytes(), m.name, &options).unwrap_or_else(|e| panic!("{e}"));
    r.warnings.into_iter().find(|w| w.code == "implausible")
}

/// Columns in units that they are not read in: how often it is asked about, and how often the first proposal is right.
#[test]
fn units_that_are_wrong_are_asked_about_and_true_machines_are_not() {
    let wrong: [(&str, usize, f64, MotionKind); 13] = [
        ("time in ms", 0, 1e3, Linear),
        ("time in µs", 0, 1e6, Linear),
        ("position in mm", 1, 1e3, Linear),
        ("position in µm", 1, 1e6, Linear),
        ("position in deg", 1, 180.0 / std::f64::consts::PI, Rotary),
        ("position in mrad", 1, 1e3, Rotary),
        ("position in rev", 1, 0.5 / std::f64::consts::PI, Rotary),
        ("velocity in mm/s", 2, 1e3, Linear),
        ("velocity in deg/s", 2, 180.0 / std::f64::consts::PI, Rotary),
        ("velocity in rev/s", 2, 0.5 / std::f64::consts::PI, Rotary),
        ("effort in mN", 3, 1e3, Linear),
        ("effort in mN·m", 3, 1e3, Rotary),
        ("effort in kN", 3, 1e-3, Linear),
    ];
    let mut falsely = Vec::new();
    for m in &MACHINES {
        for (bare, velocity) in [(false, false), (false, true), (true, false), (true, true)] {
            let told = asked(m, [1.0; 4], bare, velocity);
            falsely.extend(told.map(|w| format!("{} (bare: {bare}): {}", m.name, w.message)));
        }
    }
    let of = |(name, column, factor, kind): (&str, usize, f64, MotionKind), bare: bool| {
        let (mut caught, mut right, mut missed) = (0, 0, Vec::new());
        for m in MACHINES.iter().filter(|m| column == 0 || m.kind == kind) {
            let mut factors = [1.0; 4];
            factors[column] = factor;
            match asked(m, factors, bare, column == 2) {
                None => missed.push(m.name),
                Some(told) => {
                    caught += 1;
                    let scale = told
                        .maps
                        .first()
                        .and_then(|map| map.split(['=', '*']).nth(1));
                    let scale = scale.and_then(|s| s.parse::<f64>().ok());
                    let fits = |s: f64| (s * factor - 1.0).abs() < 1e-3;
                    let is_right = told.maps.len() == 1 && scale.is_some_and(fits);
                    right += usize::from(is_right);
                    if !is_right {
                        println!("  {}: {}", m.name, told.message);
                    }
                }
            }
        }
        println!(
            "{name:18} bare {bare:5}: asked {caught:2}, rightly {right:2}, missed {:2}: {}",
            missed.len(),
            missed.join(", ")
        );
        (caught, right, missed.len())
    };
    let add =
        |a: (usize, usize, usize), b: (usize, usize, usize)| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
    let [stated, bare] = [false, true].map(|bare| {
        let each = wrong.iter().map(|w| of(*w, bare));
        each.fold((0, 0, 0), add)
    });
    println!("stated {stated:?}, bare {bare:?} (asked, rightly, missed); falsely {falsely:#?}");
    assert!(falsely.is_empty());
    // What is left is possible: a stage of 12 g, a motor in place of a joint.
    assert!(stated.0 >= 93 && stated.1 >= 84, "{stated:?}");
    assert!(bare.0 >= 107 && bare.1 >= 97, "{bare:?}");
}

/// A map that is wrong is asked about by the mass that it makes, and taken back.
#[test]
fn a_mass_that_no_machine_has_is_asked_about() {
    let ball_screw = &MACHINES[6];
    let rows = run(ball_screw)
        .into_iter()
        .map(|[t, x, _, f]| format!("{t:.6},{x:.9},{f:.6}\n"));
    let csv = format!("t_s,pos,force_N\n{}", rows.collect::<String>());
    let r = text(&csv, &[("x_m", "1e-6*pos")]).expect("read");
    let asked = said(&r, "implausible");
    assert!(
        asked.contains("a mass of 9") && asked.contains("`pos` is in m,"),
        "{asked}"
    );
    // With all that the map has, and without an effort.
    let micrometres = csv.lines().enumerate().map(|(i, line)| match i {
        0 => "t_s,pos,force_N\n".to_owned(),
        _ => {
            let cells: Vec<f64> = line.split(',').flat_map(str::parse).collect();
            format!("{},{},{}\n", cells[0], 1e6 * cells[1], cells[2])
        }
    });
    let micrometres: String = micrometres.collect();
    let summed = text(&micrometres, &[("x_m", "2*pos-1*pos-0.03")]).expect("read");
    let asked = said(&summed, "implausible");
    let map = "'x_m=0.000002*pos-0.000001*pos-0.00000003'";
    assert!(asked.contains(map), "{asked}");
    let options = LoadOptions {
        needs: Needs::Motion,
        ignore: vec!["force_N".to_owned()],
        ..options(&[("x_m", "pos")])
    };
    let motion = load_csv(csv.as_bytes(), "motion.csv", &options).expect("a motion");
    assert!(!warns(&motion, "implausible"));
    let right = text(&csv, &[("x_m", "1*pos")]).expect("read");
    assert!(!warns(&right, "implausible"), "{:?}", right.warnings);
}

/// A position that goes a thousand times its reference is in another unit.
#[test]
fn a_position_far_from_its_reference_is_asked_about() {
    let csv = |millimetres: f64| {
        let rows = run(&MACHINES[6])
            .into_iter()
            .map(|[t, x, _, f]| format!("{t:.6},{:.9},{x:.9},{f:.6}\n", millimetres * x));
        format!("t_s,x_m,x_ref_m,force_N\n{}", rows.collect::<String>())
    };
    let asked = text(&csv(1e3), &[]).expect("read");
    let asked = said(&asked, "implausible");
    let parts = ["1000.0000 times its reference", "--map 'x_m=0.001*x_m'"];
    assert!(parts.iter().all(|part| asked.contains(part)), "{asked}");
    let right = text(&csv(1.0), &[]).expect("read");
    assert!(!warns(&right, "implausible"), "{:?}", right.warnings);
}

/// A file whose names say no unit, mapped as what it is in; `None` where its names are other ones.
fn bare(path: &Path) -> Option<Recording> {
    let known = [
        ("x_m", "pos"),
        ("q_rad", "angle"),
        ("v_m_s", "vel"),
        ("qd_rad_s", "vel"),
        ("force_N", "force"),
        ("friction_N", "friction"),
        ("torque_Nm", "torque"),
        ("current_A", "current"),
    ];
    let csv = std::fs::read_to_string(path).ok()?;
    let (header, rows) = csv.split_once('\n')?;
    let of = |name: &str| known.iter().find(|k| k.0 == name).copied();
    let names: Vec<&str> = header.trim().split(',').collect();
    let maps: Vec<_> = names.iter().filter_map(|name| of(name)).collect();
    let names = names.iter().map(|name| of(name).map_or(*name, |k| k.1));
    let csv = format!("{}\n{rows}", names.collect::<Vec<_>>().join(","));
    (maps.len() > 1).then(|| text(&csv, &maps).ok())?
}

/// A question about what is unusual, of a column whose unit no one stated, ends with the map that states it.
#[test]
fn a_unit_that_is_stated_is_asked_about_no_more() {
    let wrist = &MACHINES[15];
    let rows = run(wrist).into_iter().map(|[t, x, _, f]| {
        let degrees = x.to_degrees();
        format!("{t:.6},{degrees:.9},{f:.6}\n")
    });
    let csv = format!("t_s,angle,torque_Nm\n{}", rows.collect::<String>());
    let asked = text(&csv, &[("q_rad", "angle")]).expect("read");
    let asked = said(&asked, "implausible");
    let parts = [
        "is in deg, give --map 'q_rad=0.01745329251994*angle'",
        "--map 'q_rad=1*angle' says so",
    ];
    assert!(parts.iter().all(|part| asked.contains(part)), "{asked}");
    let stated = text(&csv, &[("q_rad", "1*angle")]).expect("read");
    assert!(!warns(&stated, "implausible"), "{:?}", stated.warnings);
}

/// Every recording of a real machine, and every case, read as its names or its error say. The limits of 90 rad to and fro and of thirty times
/// the reference were set with these files in view, so that none is asked about is no measure of others.
#[test]
fn no_real_recording_is_asked_about() {
    let roots = [shared("benches"), recordings(), shared("cases")];
    let mut folders: Vec<_> = roots.into_iter().flatten().collect();
    let (mut seen, mut bares, mut falsely) = (0, 0, Vec::new());
    while let Some(folder) = folders.pop() {
        for file in std::fs::read_dir(folder).expect("folder").flatten() {
            let path = file.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.display().to_string();
            let told = load(&path, &LoadOptions::default());
            let maps = told.as_ref().err().map(|e| e.problem.maps().to_vec());
            let maps = maps.unwrap_or_default().into_iter().map(|map| {
                let map = map
                    .replace("FACTOR*", "")
                    .replace("SAMPLE_TIME_IN_S", "0.01");
                parse_map(map.trim_start_matches("--map ").trim_matches('\''))
            });
            let mut map: Vec<_> = maps.flatten().collect();
            // What names alone do not tell.
            let emps = "t_s=t x_m=qm voltage_V=vir";
            let known = [("DATA_EMPS", emps), ("steady_state", "segment=run")];
            if let Some(of) = known.iter().find(|k| name.contains(k.0)) {
                map = of.1.split(' ').flat_map(parse_map).collect();
            }
            let options = LoadOptions {
                map,
                ..LoadOptions::default()
            };
            let Ok(r) = told.or_else(|_| load(&path, &options)) else {
                println!("{}: not read", path.display());
                continue;
            };
            println!("{}", r.in_one_line());
            seen += 1;
            let unsaid = bare(&path);
            bares += usize::from(unsaid.is_some());
            for r in [Some(r), unsaid].into_iter().flatten() {
                let asked = r.warnings.iter().find(|w| w.code == "implausible");
                falsely.extend(asked.map(|w| format!("{name}: {}", w.message)));
            }
        }
    }
    println!("{seen} recordings, {bares} of them without units too, asked about: {falsely:#?}");
    assert!(falsely.is_empty());
}
