//! The faults, and what each must come to.

use super::{AT, Injection, coefficients};
use preslide::control::{Controller, Fault, Measurement};
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
    ]
}
