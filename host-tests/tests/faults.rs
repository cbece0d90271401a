//! Twenty faults on the simulated stage: how far the axis travels after each, and how hard it is pushed.
//!
//! The production controller and the paper's axis; a move of 2 mm at 2 mm/s runs when the fault strikes. Off, the stage is
//! short-circuited, as by a bridge with both low sides on; an open one lets it coast a little further.

use preslide::control::{Axis, Coefficients, Controller, Fault, Measurement, Move};
use preslide::{Block, Friction, Motion, QuasiStaticGms, Units};
use preslide_host::stage::{Stage, StageConfig};
use std::cell::Cell;

/// The tick of the injection, and the last one.
const AT: u32 = 6000;
const END: u32 = 20_000;

/// Changes what the drive reads in a tick.
type Reading<'a> = Box<dyn Fn(u32, &mut Measurement<u32>) + 'a>;
/// What the host does in a tick.
type Host = fn(u32, &mut Controller<Model, u32>, &Axis);

/// What a fault does to what passes between controller and stage.
#[derive(Default)]
struct Injection<'a> {
    /// To the settings: how the axis was wired or described.
    axis: Option<fn(&mut Axis)>,
    /// To what the board reads, by tick.
    read: Option<Reading<'a>>,
    /// To what the bridge gets.
    bridge: Option<Box<dyn Fn(u32, i32) -> i32 + 'a>>,
    /// To the stage.
    stage: Option<fn(u32, &mut Stage)>,
    /// What the host does: by default it sends a move and keeps talking.
    host: Option<Host>,
    /// It is wrong from the start: counted from the first tick, and no move is asked for before it.
    from_start: bool,
    /// It changes nothing: the run is compared with an undisturbed one.
    rides_out: bool,
}

/// A friction model that can be told to answer NaN.
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
    let blocks = [(325_379.0, 0.352), (40_535.0, 0.307), (7_886.0, 0.341)];
    let blocks = blocks.map(|(stiffness, weight)| Block { stiffness, weight });
    let gms = QuasiStaticGms::try_new(&blocks, 0.9, Units::SI).expect("Table 3");
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

fn run(injection: &Injection, undisturbed: Option<&Outcome>) -> Outcome {
    let wired = Axis::PAPER_AXIS;
    let mut axis = wired;
    if let Some(change) = injection.axis {
        change(&mut axis);
    }
    let config = StageConfig {
        seed: 7,
        ..StageConfig::default()
    };
    let mut stage = Stage::try_new(config).expect("the default stage");
    let mut controller = Controller::new(
        coefficients(&axis, false),
        stage.reading().count.cast_unsigned(),
    );
    let mut outcome = Outcome {
        fault: None,
        after: None,
        travel_m: 0.0,
        push: 0,
        push_off: 0,
        path: Vec::new(),
    };
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
        let mut measured = Measurement {
            count: reading.count.cast_unsigned(),
            // Saturating: what an ADC does.
            supply: (reading.supply_v * 1e3).round() as u16,
            current: (reading.current_a * 1e4).round() as i16,
            late: false,
        };
        if let Some(read) = &injection.read {
            read(tick, &mut measured);
        }
        let command = controller.tick(measured);
        // A bridge that is told to open does, whatever its PWM says.
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

/// A row: what is injected, what must be found, within how many ticks, and the bound on travel (µm).
struct Row<'a> {
    name: &'static str,
    expected: Option<Fault>,
    within: u32,
    travel_um: f64,
    injection: Injection<'a>,
}

fn row<'a>(
    name: &'static str,
    expected: Option<Fault>,
    within: u32,
    travel_um: f64,
    injection: Injection<'a>,
) -> Row<'a> {
    Row {
        name,
        expected,
        within,
        travel_um,
        injection,
    }
}

fn read<'a>(change: impl Fn(u32, &mut Measurement<u32>) + 'a) -> Injection<'a> {
    Injection {
        read: Some(Box::new(move |tick, m| {
            if tick >= AT {
                change(tick, m)
            }
        })),
        ..Injection::default()
    }
}

#[test]
fn every_fault_keeps_its_bound_on_travel_and_command() {
    let undisturbed = run(&Injection::default(), None);
    assert_eq!(undisturbed.fault, None);
    let frozen = Cell::new(None);
    let (lost, stuck) = (Cell::new(None), Cell::new(0));
    let rows = vec![
        row(
            "encoder frozen",
            Some(Fault::EncoderFrozen),
            300,
            160.0,
            read(|_, m| {
                frozen.set(frozen.get().or(Some(m.count)));
                m.count = frozen.get().unwrap_or(0);
            }),
        ),
        row(
            "encoder phase lost",
            Some(Fault::EncoderFrozen),
            300,
            160.0,
            read(|_, m| {
                // Of the four states of a line two are left: the count goes to and fro by one.
                let base = lost.get().unwrap_or(m.count);
                lost.set(Some(base));
                m.count = base + (m.count >> 1 & 1);
            }),
        ),
        row(
            "count jumps",
            Some(Fault::EncoderJump),
            0,
            10.0,
            read(|_, m| m.count = m.count.wrapping_add(4000)),
        ),
        row(
            "count noise of one",
            None,
            0,
            0.2,
            Injection {
                rides_out: true,
                ..read(|tick, m| m.count = m.count.wrapping_add((tick * 7919 / 3) & 1))
            },
        ),
        row(
            "encoder reversed",
            Some(Fault::EncoderFrozen),
            900,
            160.0,
            Injection {
                axis: Some(|a| a.encoder.reversed = true),
                from_start: true,
                ..Injection::default()
            },
        ),
        row(
            "motor leads reversed",
            Some(Fault::EncoderFrozen),
            900,
            160.0,
            Injection {
                axis: Some(|a| a.motor.reversed = true),
                from_start: true,
                ..Injection::default()
            },
        ),
        row(
            "bridge stuck",
            Some(Fault::EncoderFrozen),
            500,
            160.0,
            Injection {
                bridge: Some(Box::new(|tick, code| {
                    if tick < AT {
                        stuck.set(code);
                        code
                    } else {
                        2 * stuck.get()
                    }
                })),
                ..Injection::default()
            },
        ),
        row(
            "over-current",
            Some(Fault::OverCurrent),
            1,
            10.0,
            read(|_, m| m.current = 20_000),
        ),
        row(
            "overload (I2t)",
            Some(Fault::Overload),
            2200,
            240.0,
            Injection {
                axis: Some(|a| a.watch.thermal_time = 0.1),
                read: Some(Box::new(|tick, m| {
                    if tick >= AT {
                        m.current = 9500
                    }
                })),
                ..Injection::default()
            },
        ),
        row(
            "current offset",
            Some(Fault::CurrentOffset),
            600,
            0.5,
            Injection {
                read: Some(Box::new(|_, m| m.current = m.current.saturating_add(2000))),
                from_start: true,
                ..Injection::default()
            },
        ),
        row(
            "supply sags to 4 V",
            Some(Fault::SupplyOutOfRange),
            20,
            12.0,
            Injection {
                stage: Some(|tick, s| {
                    if tick == AT {
                        let _ = s.set_supply_v(4.0);
                    }
                }),
                ..Injection::default()
            },
        ),
        row(
            "supply over-voltage, 9 V",
            Some(Fault::SupplyOutOfRange),
            20,
            12.0,
            Injection {
                stage: Some(|tick, s| {
                    if tick == AT {
                        let _ = s.set_supply_v(9.0);
                    }
                }),
                ..Injection::default()
            },
        ),
        row(
            "brown-out, reset",
            None,
            0,
            20.0,
            Injection {
                // The controller begins anew every 5 ms and is told nothing: it stays off.
                host: Some(|tick, c, a| {
                    if tick >= AT && tick % 100 == 0 {
                        *c = Controller::new(coefficients(a, false), 0);
                    } else {
                        c.heard();
                    }
                }),
                ..Injection::default()
            },
        ),
        row(
            "host silent",
            None,
            0,
            120.0,
            Injection {
                // The last word was a tick before the injection.
                axis: Some(|a| a.silence = 0.05),
                host: Some(|tick, c, _| {
                    if tick < AT {
                        c.heard()
                    }
                }),
                ..Injection::default()
            },
        ),
        row(
            "jump during a swap",
            Some(Fault::EncoderJump),
            0,
            10.0,
            Injection {
                host: Some(|tick, c, a| {
                    c.heard();
                    if tick == AT - 10 {
                        let mut soft = *a;
                        soft.gains.proportional *= 0.5;
                        c.swap(coefficients(&soft, false));
                    }
                }),
                read: Some(Box::new(|tick, m| {
                    if tick >= AT {
                        m.count = m.count.wrapping_add(4000)
                    }
                })),
                ..Injection::default()
            },
        ),
        row(
            "jump during a stop",
            Some(Fault::EncoderJump),
            0,
            10.0,
            Injection {
                host: Some(|tick, c, _| {
                    c.heard();
                    if tick == AT - 10 {
                        c.stop();
                    }
                }),
                read: Some(Box::new(|tick, m| {
                    if tick >= AT {
                        m.count = m.count.wrapping_add(4000)
                    }
                })),
                ..Injection::default()
            },
        ),
        row(
            "NaN from a model",
            Some(Fault::NotANumber),
            0,
            10.0,
            Injection {
                host: Some(|tick, c, a| {
                    c.heard();
                    if tick == AT {
                        c.swap(coefficients(a, true));
                    }
                }),
                ..Injection::default()
            },
        ),
        row(
            "jam (following error)",
            Some(Fault::FollowingError),
            300,
            260.0,
            Injection {
                axis: Some(|a| a.watch.frozen_duty = 0.37),
                stage: Some(|tick, s| {
                    // For 10 ms.
                    if tick == AT || tick == AT + 200 {
                        let force = if tick == AT { -12.0 } else { 0.0 };
                        let _ = s.set_external_force_n(force);
                    }
                }),
                ..Injection::default()
            },
        ),
        row(
            "every tick late",
            Some(Fault::Overrun),
            2,
            10.0,
            read(|_, m| m.late = true),
        ),
        row(
            "disabled in motion",
            None,
            0,
            20.0,
            Injection {
                host: Some(|tick, c, _| if tick == AT { c.disable() } else { c.heard() }),
                ..Injection::default()
            },
        ),
    ];
    println!(
        "{:<26} {:<18} {:>6} {:>12} {:>8} {:>10} {:>6}",
        "injected", "found", "ticks", "travel (um)", "bound", "codes", "off"
    );
    let mut wrong = Vec::new();
    for Row {
        name,
        expected,
        within,
        travel_um,
        injection,
    } in rows
    {
        let outcome = run(&injection, injection.rides_out.then_some(&undisturbed));
        let found = outcome
            .fault
            .map_or("nothing".into(), |fault| format!("{fault:?}"));
        let after = outcome.after.map_or("-".into(), |ticks| ticks.to_string());
        let travel = outcome.travel_m * 1e6;
        println!(
            "{name:<26} {found:<18} {after:>6} {travel:>12.1} {travel_um:>8} {:>10} {:>6}",
            outcome.push, outcome.push_off
        );
        let limit = (0.38 * 8500.0) as i32;
        let met = outcome.fault == expected
            && outcome.after.is_none_or(|after| after <= within)
            && travel <= travel_um
            && outcome.push <= limit
            && outcome.push_off == 0;
        if !met {
            wrong.push(name);
        }
    }
    assert!(wrong.is_empty(), "beyond their bounds: {wrong:?}");
}
