//! Faults, refusals and resets in plain words, with what to do.

use crate::quantity;
use preslide_link::{FaultCode, Mode, Refusal, ResetCause, State};

/// Why the axis is in its safe state.
pub fn fault(fault: FaultCode) -> &'static str {
    match fault {
        FaultCode::EncoderJump => {
            "the count jumped further in one tick than the axis can move; check the encoder's cable and shield, and watch.top_speed"
        }
        FaultCode::EncoderFrozen => {
            "the motor was pushed hard and no count came; check the encoder's plug, the coupling, and that nothing blocks the axis"
        }
        FaultCode::FollowingError => {
            "the position error grew too large; check that encoder and motor have the same sign, lower speed or acceleration, or \
             raise watch.following_error"
        }
        FaultCode::SupplyOutOfRange => {
            "the supply voltage left its range; check the power supply, its current limit, and watch.supply_min and _max"
        }
        FaultCode::Overrun => {
            "the control task was late too often; lower the rate or take a cheaper friction model (`preslide tune`)"
        }
        FaultCode::NotANumber => {
            "the command was not a number; check the friction model and the gains"
        }
        FaultCode::OverCurrent => {
            "the current exceeded watch.current_max; check the winding and its leads for a short"
        }
        FaultCode::Overload => {
            "the winding was above its rated current for too long; let it cool, then move less hard"
        }
        FaultCode::CurrentOffset => {
            "the current sense does not read zero with the bridge open; check its wiring, its reference and watch.current_offset"
        }
        FaultCode::Bridge => {
            "the bridge's own protection opened it; check its supply, its temperature and the motor's leads"
        }
        FaultCode::LimitLow => {
            "the limit switch at the low end of travel opened; `acknowledge`, `enable`, and move up, away from it. If the axis is \
             nowhere near, check the switch's wire"
        }
        FaultCode::LimitHigh => {
            "the limit switch at the high end of travel opened; `acknowledge`, `enable`, and move down, away from it. If the axis \
             is nowhere near, check the switch's wire"
        }
    }
}

/// Why a request was refused.
pub fn refusal(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::Oversized | Refusal::Malformed | Refusal::Checksum => {
            "the frame was damaged on its way; check the line's speed and its cable"
        }
        Refusal::Unknown => {
            "the firmware does not know this request; build it from the same source as the tool"
        }
        Refusal::OutOfRange => "a value is not a number or out of its range",
        Refusal::Busy => "the queue is full; send it again later",
        Refusal::Faulted => {
            "the controller is in its safe state; see `state`, then `acknowledge` and `enable`"
        }
        Refusal::OtherModel => {
            "the firmware's friction model has other parts; `preslide export MODEL.toml -o stage_model.rs`, then build the \
             firmware with PRESLIDE_MODEL=/full/path/to/stage_model.rs"
        }
        Refusal::NotEnabled => "the axis is not enabled: `enable` first",
        Refusal::Enabled => "only while the axis is disabled: `disable` first",
        Refusal::NotStanding => "the axis must stand still first: `stop`, or wait",
        Refusal::TooFast => "it is faster than limits.speed",
        Refusal::TooSteep => "it accelerates harder than limits.acceleration",
        Refusal::BeyondTravel => {
            "it leaves the travel between limits.travel_low and limits.travel_high"
        }
        Refusal::NoParameter => "there is no such parameter; `get` lists them",
        Refusal::ReadOnly => "that parameter changes with the firmware's build only",
        Refusal::Storage => "the board has no memory for parameters, or writing it failed",
    }
}

/// What the controller was reset by.
pub fn reset(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::Power => "power came on",
        ResetCause::BrownOut => "the supply of the controller was too low (brown-out)",
        ResetCause::Watchdog => "the watchdog: the firmware hung or panicked",
        ResetCause::Pin => "the reset pin or a debug probe",
        ResetCause::Software => "the firmware itself",
    }
}

/// What the controller does.
pub fn mode(mode: Mode) -> &'static str {
    match mode {
        Mode::Disabled => "disabled, the bridge is open",
        Mode::Standing => "enabled, holds its position",
        Mode::Moving => "moves",
        Mode::Homing => "looks for its origin",
    }
}

/// A state in lines; `count` is one encoder count (m or rad), `rate_hz` the controller's.
pub fn state(state: &State, count: f64, rate_hz: u32, unit: &str) -> Vec<String> {
    let mut lines = vec![
        format!("state     {}", mode(state.mode)),
        format!(
            "position  {} ({} counts, {})",
            quantity::shown(state.position as f64 * count, unit),
            state.position,
            if state.located {
                "from the axis's origin"
            } else {
                "from where it was switched on: not homed, so its travel has no ends"
            }
        ),
        format!(
            "supply    {:.2} V, current {:+.3} A",
            f64::from(state.supply) * 1e-3,
            f64::from(state.current) * 1e-4
        ),
        format!(
            "queue     {} waiting, {} dropped since the reset",
            state.queued, state.dropped
        ),
        format!(
            "reset     {:.1} s ago: {}",
            f64::from(state.tick) / f64::from(rate_hz.max(1)),
            reset(state.reset)
        ),
    ];
    if state.missed > 0 {
        lines.push(format!(
            "outer     {} of the outer task's orders came too late; the loop ran on without them",
            state.missed
        ));
    }
    if state.silent {
        lines.push(
            "silence   the host was silent for too long; a moving axis was stopped".to_owned(),
        );
    }
    if let Some(code) = state.fault {
        lines.push(format!("FAULT     {code:?}: {}", fault(code)));
        lines.push("          then: acknowledge, enable".to_owned());
    }
    lines
}
