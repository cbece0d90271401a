//! The faults, and what each must come to.

use super::{AT, Injection, coefficients};
use preslide::control::{Controller, Fault, Measurement};
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

fn row(
    name: &'static str,
    expected: Option<Fault>,
    within: u32,
    travel_um: f64,
    injection: Injection,
) -> Row {
    Row {
        name,
        expected,
        within,
        travel_um,
        injection,
    }
}

fn read(change: impl Fn(u32, &mut Measurement<u32>) + 'static) -> Injection {
    Injection {
        read: Some(Box::new(move |tick, m| {
            if tick >= AT {
                change(tick, m)
            }
        })),
        ..Injection::default()
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

/// All of them.
pub fn rows() -> Vec<Row> {
    let kept = || Cell::new(None);
    let (frozen, swapped, lost, stuck) = (kept(), kept(), kept(), Cell::new(0));
    vec![
        row(
            "encoder frozen",
            Some(Fault::EncoderFrozen),
            300,
            160.0,
            read(move |_, m| {
                frozen.set(frozen.get().or(Some(m.count)));
                m.count = frozen.get().unwrap_or(0);
            }),
        ),
        row(
            "encoder phase lost",
            Some(Fault::EncoderFrozen),
            300,
            160.0,
            read(move |_, m| {
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
                bridge: Some(Box::new(move |tick, code| {
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
                        c.swap(&coefficients(&soft, false));
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
                        c.swap(&coefficients(a, true));
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
                stage: Some(jam),
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
        row(
            "count wraps",
            None,
            0,
            0.0,
            Injection {
                rides_out: true,
                from_start: true,
                // At 2 mm/s it passes the counter's end after 0.27 s of the move.
                read: Some(Box::new(|_, m| m.count = m.count.wrapping_sub(21_600))),
                ..Injection::default()
            },
        ),
        row(
            "winding open",
            Some(Fault::EncoderFrozen),
            900,
            160.0,
            Injection {
                bridge: Some(Box::new(|tick, code| if tick < AT { code } else { 0 })),
                ..Injection::default()
            },
        ),
        row(
            "supply flickers",
            None,
            0,
            1.0,
            Injection {
                rides_out: true,
                // For half of the time that is allowed.
                stage: Some(|tick, s| {
                    if tick >= AT {
                        let low = (tick - AT) % 60 < 10;
                        let _ = s.set_supply_v(if low { 4.2 } else { 6.0 });
                    }
                }),
                ..Injection::default()
            },
        ),
        row(
            "frozen during a swap",
            Some(Fault::EncoderFrozen),
            300,
            160.0,
            Injection {
                host: Some(|tick, c, a| {
                    c.heard();
                    if tick == AT {
                        let mut soft = *a;
                        soft.gains.proportional *= 0.5;
                        c.swap(&coefficients(&soft, false));
                    }
                }),
                ..read(move |_, m| {
                    swapped.set(swapped.get().or(Some(m.count)));
                    m.count = swapped.get().unwrap_or(0);
                })
            },
        ),
        row(
            "over-current during a stop",
            Some(Fault::OverCurrent),
            1,
            10.0,
            Injection {
                host: Some(|tick, c, _| {
                    c.heard();
                    if tick == AT - 10 {
                        c.stop();
                    }
                }),
                ..read(|_, m| m.current = 20_000)
            },
        ),
        row(
            // The finest at which the error that is a fault can be told.
            "jam, counts of 2 nm",
            Some(Fault::FollowingError),
            300,
            260.0,
            Injection {
                axis: Some(|a| {
                    a.encoder.count = 2e-9;
                    a.watch.frozen_duty = 0.37;
                }),
                stage: Some(jam),
                ..Injection::default()
            },
        ),
        row(
            "jump, then enabled again",
            Some(Fault::EncoderJump),
            0,
            10.0,
            Injection {
                host: Some(|tick, c, _| {
                    c.heard();
                    if tick == AT + 500 {
                        c.acknowledge();
                        let _ = c.enable();
                    }
                }),
                ..read(|_, m| m.count = m.count.wrapping_add(4000))
            },
        ),
        row(
            "current beyond its codes",
            Some(Fault::OverCurrent),
            1,
            10.0,
            read(|_, m| m.current = i16::MAX),
        ),
        row(
            "supply beyond its codes",
            Some(Fault::SupplyOutOfRange),
            20,
            12.0,
            read(|_, m| m.supply = u16::MAX),
        ),
        row(
            "overload, told to go on",
            Some(Fault::Overload),
            2200,
            240.0,
            Injection {
                axis: Some(|a| a.watch.thermal_time = 0.1),
                host: Some(|_, c, _| {
                    c.heard();
                    if c.fault().is_some() {
                        c.acknowledge();
                        let _ = c.enable();
                    }
                }),
                ..read(|_, m| m.current = 9500)
            },
        ),
        row(
            "integral held to less",
            None,
            0,
            10.0,
            Injection {
                rides_out: true,
                // A load of 3 N, of which the integral may keep 2.5 N: half a newton more is left to K_p, 5 µm.
                stage: Some(|tick, s| weigh(s, 3.0, f64::from(tick) / 4000.0)),
                host: Some(|tick, c, a| {
                    c.heard();
                    if tick == AT {
                        let mut less = *a;
                        less.gains.integral_limit = 2.5;
                        c.swap(&coefficients(&less, false));
                    }
                }),
                ..Injection::default()
            },
        ),
        row(
            "weight comes, 4.5 N",
            None,
            0,
            // 9 N/s for an integral gain of 3e6 N/(m·s).
            4.0,
            Injection {
                rides_out: true,
                stage: Some(|tick, s| weigh(s, 4.5, (f64::from(tick) - f64::from(AT)) / 10_000.0)),
                ..Injection::default()
            },
        ),
        row(
            "weight laid on, 3.64 N",
            None,
            0,
            // 36 N/s.
            15.0,
            Injection {
                rides_out: true,
                stage: Some(|tick, s| weigh(s, 3.64, (f64::from(tick) - f64::from(AT)) / 2000.0)),
                ..Injection::default()
            },
        ),
        row(
            "current offset from power on",
            Some(Fault::CurrentOffset),
            1,
            0.5,
            Injection {
                host: Some(|_, c, _| {
                    c.heard();
                    if c.fault().is_none() {
                        let _ = c.enable();
                    }
                }),
                read: Some(Box::new(|_, m| m.current = m.current.saturating_add(2000))),
                from_start: true,
                ..Injection::default()
            },
        ),
    ]
}
