//! Thirty-five faults and what looks like one on the simulated stage: how far the axis travels after each, and how hard it is pushed.
//!
//! The production controller and the paper's axis; a move of 2 mm at 2 mm/s runs when the fault strikes. Off, the stage is
//! short-circuited, as by a bridge with both low sides on; an open one lets it coast a little further.

use crate::measured::read;
use preslide::control::{Axis, Coefficients, Controller, Fault, Measurement, Move};
use preslide::{Friction, Motion, QuasiStaticGms, Units};
use preslide_host_tests::table3;
use preslide_sim::stage::{Stage, StageConfig};

mod after;
mod changes;
mod drive;
mod frozen;
mod homing;
mod limits;
mod loading;
mod loads;
mod reachable;
mod rows;
mod spans;

use rows::{Row, rows};

/// The tick of the injection, and the last one.
const AT: u32 = 6000;
const END: u32 = 20_000;

/// Changes what the drive reads in a tick.
type Reading = Box<dyn Fn(u32, &mut Measurement<u32>)>;
/// What the host does in a tick.
type Host = fn(u32, &mut Controller<Model, u32>, &Axis);

/// What a fault does to what passes between controller and stage.
#[derive(Default)]
struct Injection {
    /// To the settings: how the axis was wired or described.
    axis: Option<fn(&mut Axis)>,
    /// To what the board reads, by tick.
    read: Option<Reading>,
    /// To what the bridge gets.
    bridge: Option<Box<dyn Fn(u32, i32) -> i32>>,
    /// To the stage.
    stage: Option<fn(u32, &mut Stage)>,
    /// What the host does: by default it sends a move and keeps talking.
    host: Option<Host>,
    /// It is wrong from the start: counted from the first tick, and no move is asked for before it.
    from_start: bool,
    /// It changes nothing: the run is compared with an undisturbed one.
    rides_out: bool,
}

/// A friction model that can answer NaN on command.
#[derive(Clone, Debug, PartialEq)]
struct Model {
    gms: QuasiStaticGms<3>,
    poisoned: bool,
}

impl Friction for Model {
    type Scalar = f32;
    type State = <QuasiStaticGms<3> as Friction>::State;

    fn at_rest(&self) -> Self::State {
        self.gms.at_rest()
    }

    fn step(&self, state: &mut Self::State, motion: Motion<f32>) -> f32 {
        let force = self.gms.step(state, motion);
        if self.poisoned { f32::NAN } else { force }
    }

    fn limit(&self) -> Option<f32> {
        self.gms.limit()
    }
}

fn model(poisoned: bool) -> Model {
    let gms = QuasiStaticGms::try_new(&table3::blocks::<3>(), 0.9, Units::SI).expect("Table 3");
    Model { gms, poisoned }
}

fn coefficients(axis: &Axis, poisoned: bool) -> Coefficients<Model> {
    Coefficients::try_new(axis, model(poisoned), Units::SI).expect("a valid axis")
}

/// What a run shows.
struct Outcome {
    fault: Option<Fault>,
    /// Ticks from the injection to the fault.
    after: Option<u32>,
    /// Farthest from where the mass was at the injection; from an undisturbed run's where there is no fault (m).
    travel_m: f64,
    /// Largest |code| that the bridge got after the injection, and after the fault was found.
    push: i32,
    push_off: i32,
    path: Vec<f64>,
}

impl Outcome {
    fn nothing() -> Self {
        Self {
            fault: None,
            after: None,
            travel_m: 0.0,
            push: 0,
            push_off: 0,
            path: Vec::new(),
        }
    }
}

fn run(injection: &Injection, undisturbed: Option<&Outcome>) -> Outcome {
    let wired = Axis::PAPER_AXIS;
    let mut axis = wired;
    if let Some(change) = injection.axis {
        change(&mut axis);
    }
    let mut config = StageConfig {
        seed: 7,
        ..StageConfig::default()
    };
    config.encoder.count_m = axis.encoder.count;
    let mut stage = Stage::try_new(config).expect("the default stage");
    let mut controller = Controller::new(
        coefficients(&axis, false),
        stage.reading().count.cast_unsigned(),
    );
    let mut outcome = Outcome::nothing();
    let at = if injection.from_start { 0 } else { AT };
    let mut start_m = 0.0;
    for tick in 0..END {
        if tick == 500 {
            // What speaks against it is the fault that is looked for.
            let _ = controller.enable();
        }
        if tick == 600 {
            let far = Move::plan(2e-3, 2e-3, 0.2, axis.grid()).expect("a move");
            let _ = controller.start(far);
        }
        match injection.host {
            Some(host) => host(tick, &mut controller, &axis),
            None => controller.heard(),
        }
        if let Some(change) = injection.stage {
            change(tick, &mut stage);
        }
        let reading = stage.reading();
        let mut measured = read(&reading);
        if let Some(read) = &injection.read {
            read(tick, &mut measured);
        }
        let command = controller.tick(measured);
        // A bridge opens on command, whatever its PWM says.
        let code = match &injection.bridge {
            Some(bridge) if command.enabled => bridge(tick, command.code),
            _ => command.code,
        };
        let true_m = stage.truth().position_m;
        outcome.path.push(true_m);
        if tick == at {
            start_m = true_m;
        }
        if tick >= at {
            outcome.push = outcome.push.max(code.abs());
            let from = undisturbed
                .filter(|_| outcome.fault.is_none())
                .map_or(start_m, |u| u.path[tick as usize]);
            outcome.travel_m = outcome.travel_m.max((true_m - from).abs());
            if let Some(fault) = command.fault {
                if outcome.fault.is_none() {
                    (outcome.fault, outcome.after) = (Some(fault), Some(tick - at));
                    // From the injection on, whatever was asked for then.
                    let passed = outcome.path.iter().skip(at as usize);
                    outcome.travel_m = passed.map(|x| (x - start_m).abs()).fold(0.0, f64::max);
                }
                outcome.push_off = outcome.push_off.max(command.code.abs());
            }
        }
        stage.tick(f64::from(code) / f64::from(wired.hardware.steps));
    }
    outcome
}

/// A line of the table.
fn line(name: &str, outcome: &Outcome, bound_um: f64) -> String {
    let found = outcome
        .fault
        .map_or("nothing".into(), |fault| format!("{fault:?}"));
    let after = outcome.after.map_or("-".into(), |ticks| ticks.to_string());
    format!(
        "{name:<28} {found:<18} {after:>6} {:>12.1} {bound_um:>8} {:>10} {:>6}\n",
        outcome.travel_m * 1e6,
        outcome.push,
        outcome.push_off
    )
}

/// What the table was when someone last looked at it; `PRESLIDE_BLESS=1` takes what it is now.
const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/faults/expected.txt");

#[test]
fn every_fault_keeps_its_bound_on_travel_and_command() {
    let undisturbed = run(&Injection::default(), None);
    assert_eq!(undisturbed.fault, None);
    let mut table = format!(
        "{:<28} {:<18} {:>6} {:>12} {:>8} {:>10} {:>6}\n",
        "injected", "found", "ticks", "travel (um)", "bound", "codes", "off"
    );
    let mut wrong = Vec::new();
    for Row {
        name,
        expected,
        within,
        travel_um,
        injection,
    } in rows()
    {
        let outcome = run(&injection, injection.rides_out.then_some(&undisturbed));
        table += &line(name, &outcome, travel_um);
        let limit = (0.38 * 8500.0) as i32;
        let met = outcome.fault == expected
            && outcome.after.is_none_or(|after| after <= within)
            && outcome.travel_m * 1e6 <= travel_um
            && outcome.push <= limit
            && outcome.push_off == 0;
        if !met {
            wrong.push(name);
        }
    }
    let stored = drive::corrupt_parameters();
    table += &line("corrupt stored parameters", &stored, 0.5);
    if stored.fault.is_some() || stored.travel_m > 0.5e-6 || stored.push != 0 {
        wrong.push("corrupt stored parameters");
    }
    print!("{table}");
    assert!(wrong.is_empty(), "beyond their bounds: {wrong:?}");
    if std::env::var_os("PRESLIDE_BLESS").is_some() {
        std::fs::write(GOLDEN, &table).expect("the golden file");
    }
    let golden = std::fs::read_to_string(GOLDEN).unwrap_or_default();
    assert_eq!(table, golden, "PRESLIDE_BLESS=1 takes the new table");
}
