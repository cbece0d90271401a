//! Homing runs the axis into a stop: what is a fault elsewhere is how it finds its origin there.

use super::drive::{Drive, Flash};
use preslide_link::{Homing, Mark, Mode, Request};

/// Where the stop is (m).
const STOP: f64 = -1.5e-3;
/// The axis is to come to rest so far from it (m).
const BACK: f64 = 0.5e-3;

/// Slow, where the push tells before the lag does, as fast as the tool asks by default, and three times that.
#[test]
fn a_stop_is_found_and_left_without_a_fault() {
    println!("speed (mm/s)  origin - stop (um)  into the stop (um)  rests at (mm)  codes");
    for speed in [0.1e-3, 1.5e-3, 4.5e-3] {
        let mut drive = Drive::on(Flash::erased());
        drive.stop_m = Some(STOP);
        drive.done(Request::Enable);
        drive.done(Request::Home(Homing {
            mark: Mark::Stop,
            speed_m_s: -speed as f32,
            position_m: 0.0,
            back_off_m: BACK as f32,
        }));
        let mut state = drive.state();
        for _ in 0..40_000 {
            // As a host does, which would otherwise be taken for silent.
            for _ in 0..20 {
                let _ = drive.tick();
            }
            state = drive.state();
            if !matches!(state.mode, Mode::Homing | Mode::Moving) {
                break;
            }
        }
        for _ in 0..4000 {
            let _ = drive.tick();
        }
        let origin = drive.stage.truth().position_m - state.position as f64 * 25e-9;
        let into = STOP - drive.lowest_m;
        println!(
            "{:>12.1} {:>19.2} {:>19.2} {:>14.4} {:>6}",
            speed * 1e3,
            (origin - STOP) * 1e6,
            into * 1e6,
            state.position as f64 * 25e-6,
            drive.push
        );
        assert_eq!((state.mode, state.fault), (Mode::Standing, None), "{speed}");
        assert!(state.located, "{speed}");
        assert!((origin - STOP).abs() < 10e-6, "{speed}");
        assert!((0.0..10e-6).contains(&into), "{speed}");
        assert!(
            (state.position as f64 * 25e-9 - BACK).abs() < 2e-6,
            "{speed}"
        );
        assert!(drive.push < 3230, "{speed}");
    }
}

/// Without a stop the way ends where the host stops it, and the axis is not located.
#[test]
fn without_a_stop_nothing_is_found() {
    let mut drive = Drive::on(Flash::erased());
    drive.done(Request::Enable);
    drive.done(Request::Home(Homing {
        mark: Mark::Stop,
        speed_m_s: -1.5e-3,
        position_m: 0.0,
        back_off_m: 0.0,
    }));
    for _ in 0..20_000 {
        let _ = drive.tick();
    }
    assert_eq!(drive.state().mode, Mode::Homing);
    drive.done(Request::Stop);
    for _ in 0..2000 {
        let _ = drive.tick();
    }
    let state = drive.state();
    assert_eq!(
        (state.mode, state.located, state.fault),
        (Mode::Standing, false, None)
    );
}
