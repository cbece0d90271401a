//! The faults, and what each must come to.

use super::{AT, Host, Injection, Model, coefficients};
use preslide::control::{Axis, Controller, Fault, Measurement};
use preslide_sim::stage::Stage;
use std::cell::Cell;

/// A row: what is injected, what must be found, within how many ticks, and the bound on travel (µm).
pub struct Row {
    pub name: &'static str,
    pub expected: Option<Fault>,
    pub within: u32,
    pub travel_um: f64,
    pub injection: Injection,
}

/// A fault that must be found within so many ticks, after so many µm; what is injected is put to it below.
fn row(name: &'static str, expected: Option<Fault>, within: u32, travel_um: f64) -> Row {
    let injection = Injection::default();
    Row {
        name,
        expected,
        within,
        travel_um,
        injection,
    }
}

impl Row {
    /// From the injection on, which is the first tick behind `at_once`, the drive reads otherwise.
    fn read(mut self, change: impl Fn(u32, &mut Measurement<u32>) + 'static) -> Self {
        let from = if self.injection.from_start { 0 } else { AT };
        self.injection.read = Some(Box::new(move |tick, m| {
            if tick >= from {
                change(tick, m)
            }
        }));
        self
    }

    /// The bridge makes something else of a command.
    fn bridge(mut self, change: impl Fn(u32, i32) -> i32 + 'static) -> Self {
        self.injection.bridge = Some(Box::new(change));
        self
    }

    fn axis(mut self, change: fn(&mut Axis)) -> Self {
        self.injection.axis = Some(change);
        self
    }

    fn stage(mut self, change: fn(u32, &mut Stage)) -> Self {
        self.injection.stage = Some(change);
        self
    }

    /// Beside talking all the time.
    fn host(mut self, act: Host) -> Self {
        self.injection.host = Some(act);
        self
    }

    fn at_once(mut self) -> Self {
        self.injection.from_start = true;
        self
    }

    fn rides_out(mut self) -> Self {
        self.injection.rides_out = true;
        self
    }
}

/// 12 N against the motion for 10 ms.
fn jam(tick: u32, stage: &mut Stage) {
    if tick == AT || tick == AT + 200 {
        let force = if tick == AT { -12.0 } else { 0.0 };
        let _ = stage.set_external_force_n(force);
    }
}

/// A weight that hangs on the axis by `share` of it, 0…1, beyond which it is all or nothing.
fn weigh(stage: &mut Stage, newtons: f64, share: f64) {
    let _ = stage.set_external_force_n(-newtons * share.clamp(0.0, 1.0));
}

fn supply(now: bool, stage: &mut Stage, volts: f64) {
    if now {
        let _ = stage.set_supply_v(volts);
    }
}

fn stop_before(tick: u32, c: &mut Controller<Model, u32>, _: &Axis) {
    c.heard();
    if tick == AT - 10 {
        c.stop();
    }
}

/// The count is what it was at the injection.
fn freeze() -> impl Fn(u32, &mut Measurement<u32>) {
    let kept = Cell::new(None);
    move |_, m| {
        kept.set(kept.get().or(Some(m.count)));
        m.count = kept.get().unwrap_or(0);
    }
}

fn jump(_: u32, m: &mut Measurement<u32>) {
    m.count = m.count.wrapping_add(4000);
}

fn too_much_current(_: u32, m: &mut Measurement<u32>) {
    m.current = 20_000;
}

fn offset_current(_: u32, m: &mut Measurement<u32>) {
    m.current = m.current.saturating_add(2000);
}

/// Gains of half the size.
fn swap_to_soft(c: &mut Controller<Model, u32>, axis: &Axis) {
    let mut soft = *axis;
    soft.gains.proportional *= 0.5;
    c.swap(&coefficients(&soft, false));
}

fn enable_again(c: &mut Controller<Model, u32>) {
    c.acknowledge();
    let _ = c.enable();
}

/// All of them.
pub fn rows() -> Vec<Row> {
    let (lost, stuck) = (Cell::new(None), Cell::new(0));
    vec![
        row("encoder frozen", Some(Fault::EncoderFrozen), 300, 160.0).read(freeze()),
        row("encoder phase lost", Some(Fault::EncoderFrozen), 300, 160.0).read(move |_, m| {
            // Of the four states of a line two are left: the count goes to and fro by one.
            let base = lost.get().unwrap_or(m.count);
            lost.set(Some(base));
            m.count = base + (m.count >> 1 & 1);
        }),
        row("count jumps", Some(Fault::EncoderJump), 0, 10.0).read(jump),
        row("count noise of one", None, 0, 0.2)
            .rides_out()
            .read(|tick, m| m.count = m.count.wrapping_add((tick * 7919 / 3) & 1)),
        row("encoder reversed", Some(Fault::EncoderFrozen), 900, 160.0)
            .at_once()
            .axis(|a| a.encoder.reversed = true),
        row(
            "motor leads reversed",
            Some(Fault::EncoderFrozen),
            900,
            160.0,
        )
        .at_once()
        .axis(|a| a.motor.reversed = true),
        row("bridge stuck", Some(Fault::EncoderFrozen), 500, 160.0).bridge(move |tick, code| {
            if tick < AT {
                stuck.set(code);
                code
            } else {
                2 * stuck.get()
            }
        }),
        row("over-current", Some(Fault::OverCurrent), 1, 10.0).read(too_much_current),
        row("overload (I2t)", Some(Fault::Overload), 2200, 240.0)
            .axis(|a| a.watch.thermal_time = 0.1)
            .read(|_, m| m.current = 9500),
        row("current offset", Some(Fault::CurrentOffset), 600, 0.5)
            .at_once()
            .read(offset_current),
        row(
            "supply sags to 4 V",
            Some(Fault::SupplyOutOfRange),
            20,
            12.0,
        )
        .stage(|tick, s| supply(tick == AT, s, 4.0)),
        row(
            "supply over-voltage, 9 V",
            Some(Fault::SupplyOutOfRange),
            20,
            12.0,
        )
        .stage(|tick, s| supply(tick == AT, s, 9.0)),
        // The controller begins anew every 5 ms and is told nothing: it stays off.
        row("brown-out, reset", None, 0, 20.0).host(|tick, c, a| {
            if tick >= AT && tick % 100 == 0 {
                *c = Controller::new(coefficients(a, false), 0);
            } else {
                c.heard();
            }
        }),
        // The last word was a tick before the injection.
        row("host silent", None, 0, 120.0)
            .axis(|a| a.silence = 0.05)
            .host(|tick, c, _| {
                if tick < AT {
                    c.heard()
                }
            }),
        row("jump during a swap", Some(Fault::EncoderJump), 0, 10.0)
            .read(jump)
            .host(|tick, c, a| {
                c.heard();
                if tick == AT - 10 {
                    swap_to_soft(c, a);
                }
            }),
        row("jump during a stop", Some(Fault::EncoderJump), 0, 10.0)
            .read(jump)
            .host(stop_before),
        row("NaN from a model", Some(Fault::NotANumber), 0, 10.0).host(|tick, c, a| {
            c.heard();
            if tick == AT {
                c.swap(&coefficients(a, true));
            }
        }),
        row(
            "jam (following error)",
            Some(Fault::FollowingError),
            300,
            260.0,
        )
        .axis(|a| a.watch.frozen_duty = 0.37)
        .stage(jam),
        row("every tick late", Some(Fault::Overrun), 2, 10.0).read(|_, m| m.late = true),
        row("disabled in motion", None, 0, 20.0)
            .host(|tick, c, _| if tick == AT { c.disable() } else { c.heard() }),
        // At 2 mm/s it passes the counter's end after 0.27 s of the move.
        row("count wraps", None, 0, 0.0)
            .rides_out()
            .at_once()
            .read(|_, m| m.count = m.count.wrapping_sub(21_600)),
        row("winding open", Some(Fault::EncoderFrozen), 900, 160.0)
            .bridge(|tick, code| if tick < AT { code } else { 0 }),
        // For half of the time that is allowed.
        row("supply flickers", None, 0, 1.0)
            .rides_out()
            .stage(|tick, s| {
                let low = tick >= AT && (tick - AT) % 60 < 10;
                supply(tick >= AT, s, if low { 4.2 } else { 6.0 });
            }),
        row(
            "frozen during a swap",
            Some(Fault::EncoderFrozen),
            300,
            160.0,
        )
        .read(freeze())
        .host(|tick, c, a| {
            c.heard();
            if tick == AT {
                swap_to_soft(c, a);
            }
        }),
        row(
            "over-current during a stop",
            Some(Fault::OverCurrent),
            1,
            10.0,
        )
        .read(too_much_current)
        .host(stop_before),
        // The finest at which the error that is a fault can be told.
        row(
            "jam, counts of 2 nm",
            Some(Fault::FollowingError),
            300,
            260.0,
        )
        .axis(|a| (a.encoder.count, a.watch.frozen_duty) = (2e-9, 0.37))
        .stage(jam),
        row(
            "jump, then enabled again",
            Some(Fault::EncoderJump),
            0,
            10.0,
        )
        .read(jump)
        .host(|tick, c, _| {
            c.heard();
            if tick == AT + 500 {
                enable_again(c);
            }
        }),
        row(
            "current beyond its codes",
            Some(Fault::OverCurrent),
            1,
            10.0,
        )
        .read(|_, m| m.current = i16::MAX),
        row(
            "supply beyond its codes",
            Some(Fault::SupplyOutOfRange),
            20,
            12.0,
        )
        .read(|_, m| m.supply = u16::MAX),
        row(
            "overload, told to go on",
            Some(Fault::Overload),
            2200,
            240.0,
        )
        .axis(|a| a.watch.thermal_time = 0.1)
        .read(|_, m| m.current = 9500)
        .host(|_, c, _| {
            c.heard();
            if c.fault().is_some() {
                enable_again(c);
            }
        }),
        // A load of 3 N, of which the integral may keep 2.5 N: half a newton more is left to K_p, 5 µm.
        row("integral held to less", None, 0, 10.0)
            .rides_out()
            .stage(|tick, s| weigh(s, 3.0, f64::from(tick) / 4000.0))
            .host(|tick, c, a| {
                c.heard();
                if tick == AT {
                    let mut less = *a;
                    less.gains.integral_limit = 2.5;
                    c.swap(&coefficients(&less, false));
                }
            }),
        // 9 N/s for an integral gain of 3e6 N/(m·s).
        row("weight comes, 4.5 N", None, 0, 4.0)
            .rides_out()
            .stage(|tick, s| weigh(s, 4.5, (f64::from(tick) - f64::from(AT)) / 10_000.0)),
        // 36 N/s.
        row("weight laid on, 3.64 N", None, 0, 15.0)
            .rides_out()
            .stage(|tick, s| weigh(s, 3.64, (f64::from(tick) - f64::from(AT)) / 2000.0)),
        row(
            "current offset from power on",
            Some(Fault::CurrentOffset),
            1,
            0.5,
        )
        .at_once()
        .read(offset_current)
        .host(|_, c, _| {
            c.heard();
            if c.fault().is_none() {
                let _ = c.enable();
            }
        }),
    ]
}
