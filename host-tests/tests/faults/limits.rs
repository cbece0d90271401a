//! Limit switches and a holding brake, on the firmware's application.

use super::drive::{Drive, Flash, HoldingBrake};
use preslide_link::{FaultCode, Mode, Request};

/// The switches (m).
const SWITCHES: (f64, f64) = (-1.0e-3, 1.2e-3);

fn away(mm: f64) -> Request {
    Request::Move {
        distance_m: (mm * 1e-3) as f32,
        speed_m_s: 4e-3,
        ramp_s: 0.05,
    }
}

/// Ticks on, with a host that is not silent, until the axis has a fault or so many have passed.
fn wait(drive: &mut Drive, ticks: u32) -> Option<FaultCode> {
    for _ in 0..ticks / 20 {
        for _ in 0..20 {
            let _ = drive.tick();
        }
        let state = drive.state();
        if state.fault.is_some() {
            assert_eq!((state.mode, drive.bridge.code), (Mode::Disabled, 0));
            return state.fault;
        }
    }
    None
}

/// From the switch on (m), until it has come to rest.
fn beyond(drive: &mut Drive, speed: f64) -> f64 {
    for _ in 0..8000 {
        let _ = drive.tick();
    }
    let at_m = drive.stage.truth().position_m;
    if speed < 0.0 {
        SWITCHES.0 - at_m
    } else {
        at_m - SWITCHES.1
    }
}

/// Both ends, slow and at the axis's top speed: the fault, how far the axis goes on without a brake, and the way back.
#[test]
fn a_limit_switch_stops_the_axis_and_lets_it_move_away() {
    println!("speed (mm/s)  beyond the switch (um)  bound  again (um)");
    for (speed, bound_um) in [(-2e-3, 3.0), (2e-3, 3.0), (-15e-3, 300.0), (15e-3, 300.0)] {
        let mut drive = Drive::on(Flash::erased());
        drive.switches_m = Some(SWITCHES);
        drive.done(Request::Enable);
        let jog = Request::Jog {
            speed_m_s: speed as f32,
        };
        drive.done(jog);
        let met = match speed < 0.0 {
            true => FaultCode::LimitLow,
            false => FaultCode::LimitHigh,
        };
        assert_eq!(wait(&mut drive, 20_000), Some(met), "{speed}");
        let passed = beyond(&mut drive, speed);
        // It stands on the switch, and may be driven there, but not on.
        drive.done(Request::Acknowledge);
        drive.done(Request::Enable);
        assert_eq!(wait(&mut drive, 4000), None, "{speed}");
        drive.done(jog);
        assert_eq!(wait(&mut drive, 4000), Some(met), "{speed}");
        let again = beyond(&mut drive, speed) - passed;
        drive.done(Request::Acknowledge);
        drive.done(Request::Enable);
        drive.done(away(-1.5 * speed.signum()));
        assert_eq!(wait(&mut drive, 12_000), None, "{speed}");
        assert_eq!(drive.state().mode, Mode::Standing);
        // It has come off the switch, which is there again.
        drive.done(jog);
        assert_eq!(wait(&mut drive, 20_000), Some(met), "{speed}");
        let (passed, again) = (passed * 1e6, again * 1e6);
        println!(
            "{:>12.1} {passed:>23.1} {bound_um:>6} {again:>11.2}",
            speed * 1e3
        );
        assert!((0.0..bound_um).contains(&passed), "{speed}: {passed}");
        assert!(again.abs() < 0.2, "{speed}: {again}");
    }
}

/// Switches that are swapped stop the axis, too; spikes of two ticks do not, nor does a contact that bounces when it is left.
#[test]
fn swapped_switches_stop_and_spikes_do_not() {
    let mut swapped = Drive::on(Flash::erased());
    swapped.switches_m = Some(SWITCHES);
    swapped.swapped = true;
    swapped.done(Request::Enable);
    swapped.done(Request::Jog { speed_m_s: 4e-3 });
    assert_eq!(wait(&mut swapped, 20_000), Some(FaultCode::LimitLow));

    let mut drive = Drive::on(Flash::erased());
    drive.done(Request::Enable);
    drive.done(Request::Jog { speed_m_s: 1e-3 });
    for _ in 0..40 {
        for tick in 0..50 {
            drive.bridge.limits.high = tick < 2;
            let _ = drive.tick();
        }
    }
    assert_eq!(drive.state().fault, None);
    drive.bridge.limits.high = true;
    assert_eq!(wait(&mut drive, 40), Some(FaultCode::LimitHigh));
    drive.done(Request::Acknowledge);
    drive.done(Request::Enable);
    drive.done(away(-0.5));
    for tick in 0..2000_u32 {
        // Between open and closed for 15 ms, by no pattern.
        drive.bridge.limits.high = tick < 300 && tick.wrapping_mul(0x9E37_79B9) >> 31 == 1;
        let _ = drive.tick();
    }
    assert_eq!(drive.state().fault, None);
}

/// 2 N hang on an axis whose brake takes 40 ms to be released and 60 ms to hold. Told so, the controller never lets it fall; told nothing, it
/// is off before the brake holds.
#[test]
fn a_brake_holds_whenever_the_controller_does_not() {
    let ticks = [800, 1200];
    let fell = [ticks, [0, 0]].map(|told| {
        let mut drive = Drive::on(Flash::erased());
        drive.bridge.delays = told;
        drive.weight_n = 2.0;
        drive.brake = Some(HoldingBrake::new(ticks));
        for _ in 0..2000 {
            let _ = drive.tick();
        }
        let before = drive.stage.truth().position_m;
        drive.done(Request::Enable);
        drive.done(away(0.2));
        let mut released = None;
        let mut moved = None;
        for tick in 0..8000 {
            let _ = drive.tick();
            released = released.or(drive.bridge.released.then_some(tick));
            let off = drive.stage.truth().position_m - before;
            moved = moved.or((off > 1e-6).then_some(tick));
        }
        let lowest = drive.lowest_m - before;
        if told == ticks {
            assert!(released.is_some() && moved > released.map(|tick| tick + ticks[0] - 40));
        }
        let before = drive.stage.truth().position_m;
        drive.done(Request::Disable);
        let (mut set, mut open) = (None, None);
        for tick in 0..6000_u32 {
            let _ = drive.tick();
            set = set.or((!drive.bridge.released).then_some(tick));
            open = open.or((!drive.bridge.closed).then_some(tick));
        }
        assert_eq!(drive.state().mode, Mode::Disabled);
        if told == ticks {
            let (set, open) = (set.expect("it is set"), open.expect("it is open"));
            assert!((open - set).abs_diff(ticks[1]) <= 1, "{set} {open}");
        }
        let last = drive.stage.truth().position_m - before;
        println!(
            "told {told:?}: enabling moves it by {:.2} um down, disabling by {:.2} um",
            -lowest * 1e6,
            -last * 1e6
        );
        [-lowest, -last]
    });
    let [told, untold] = fell;
    // The weight comes onto the feedback as the brake lets go, and onto the brake's spring as it holds.
    assert!(told[0] < 10e-6 && told[1] < 4e-6, "{told:?}");
    assert!(untold[1] > 200e-6, "{untold:?}");

    // A fault sets it in the tick in which it opens the bridge.
    let mut drive = Drive::on(Flash::erased());
    drive.bridge.delays = ticks;
    drive.done(Request::Enable);
    for _ in 0..2000 {
        let _ = drive.tick();
    }
    assert!(drive.bridge.released && drive.bridge.closed);
    drive.bridge.limits.low = true;
    while drive.bridge.closed {
        let _ = drive.tick();
        assert_eq!(drive.bridge.released, drive.bridge.closed);
    }
    for _ in 0..40 {
        let _ = drive.tick();
    }
    assert_eq!(drive.state().fault, Some(FaultCode::LimitLow));
}
