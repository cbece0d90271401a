"""Run a machine with effects, judge the run, and find the size of an effect."""

import math

import numpy as np

import choose
import motions
from catalogue import BAND, CODE, TARGET
from plant import simulate

MECHANICAL = ("drive_compliance", "backlash")


class Reject(Exception):
    pass


def rms(y):
    return float(np.sqrt(np.mean(np.square(y))))


def run(s, effects, halve=1):
    """effects: up to two of (name, amp, p, time course)."""
    codes = np.zeros(2, dtype=np.int64)
    amps, ep = np.zeros(2), np.zeros((2, 12))
    aux = np.zeros((2, s["n"]))
    enc, act = np.zeros(5), np.zeros(2)
    mech = s["mech"].copy()
    m = s["m"]
    for i, (name, amp, p, course) in enumerate(effects):
        if name == "channel_delay":
            continue
        if name == "encoder_error":
            enc[:] = amp, p[0], p[1], p[2], p[3]
        elif name == "actuator_dead_zone":
            act[0] = amp
        elif name == "actuator_saturation":
            act[1] = 1.0 / amp
        elif name in MECHANICAL:
            red = m["mass"] * mech[8] * (1 - mech[8])
            mech[9] = 1.0 / amp if name == "drive_compliance" else red * (2 * math.pi * p[2]) ** 2
            mech[10] = 2 * p[0] * math.sqrt(mech[9] * red)
            mech[11] = amp if name == "backlash" else 0.0
            mech[12], mech[13], mech[14] = 1.0, p[3], p[1]
        else:
            codes[i], amps[i], ep[i], aux[i] = CODE[name], amp, p, course
    return simulate(
        s["cfg"]["nsub"] * halve,
        s["cfg"]["tick"],
        s["ref"],
        s["levt"],
        aux,
        mech,
        s["mode"],
        s["ctl"],
        m["code"],
        m["lawp"],
        m["bw"],
        m["bd"],
        codes,
        amps,
        ep,
        enc,
        act,
    )


def share(s, out, effects):
    """RMS of what the nominal model leaves over, against the effort's deviation."""
    tick = s["cfg"]["tick"]
    w = max(1, int(0.002 / tick))
    u = motions.smooth(out[:, 3], w)[int(0.3 / tick) :]
    e = motions.smooth(out[:, 4], w)[int(0.3 / tick) :]
    for name, amp, _, _ in effects:
        if name == "channel_delay":
            t = np.arange(u.size)
            e = e + np.interp(t - amp / tick, t, u) - u
    return rms(e) / (float(np.std(u)) + 1e-30)


def spread(s, out, names):
    """An effect has to show again and again, not in one event."""
    if set(names) & {"run_in", "payload_change", "thermal_drift", "channel_delay"}:
        return
    e = out[int(0.3 / s["cfg"]["tick"]) :, 4]
    parts = np.array([np.sum(q * q) for q in np.array_split(e, 8)])
    if parts.max() > 0.7 * parts.sum():
        raise Reject("one event")


def sane(s, out, loose=False):
    """Reject runs that an operator would have stopped."""
    m, tick = s["m"], s["cfg"]["tick"]
    if not np.isfinite(out).all():
        raise Reject("diverged")
    u, x = out[:, 3], out[:, 0]
    stroke = m["hi"] - m["lo"]
    mode = s["cfg"]["mode"]
    if mode == "open":
        if np.ptp(x) > 2.0 * stroke or np.ptp(x) < 20 * m["xs"]:
            raise Reject("range")
    elif mode != "speed_pi" and np.max(np.abs(out[:, 1] - s["ref"][0])) > 0.12 * stroke:
        raise Reject("following error")
    elif mode == "speed_pi" and rms(out[:, 5] - s["ref"][1]) > 0.3 * rms(s["ref"][1]):
        raise Reject("speed error")
    if np.mean(np.abs(out[:, 2]) >= 0.999 * s["ctl"][7]) > 0.002:
        raise Reject("limit")
    hf = rms(u - motions.smooth(u, max(3, int(0.006 / tick)))) / np.std(u)
    if hf > (0.3 if loose else 0.16):
        raise Reject("noise or hunting")
    if np.ptp(x) < 30 * m["count"]:
        raise Reject("counts")


def settled(s, out, effects, total):
    """The same run at half the step has to tell the same story."""
    fine = run(s, effects, 2)
    w = max(1, int(0.002 / s["cfg"]["tick"]))
    u, uf = motions.smooth(out[:, 3], w), motions.smooth(fine[:, 3], w)
    if not np.isfinite(fine).all() or rms(u - uf) > 0.03 * np.std(u):
        raise Reject("half step")
    if effects and abs(share(s, fine, effects) / total - 1) > 0.03:
        raise Reject("half step")


def first_guess(name, goal, s, base, p):
    m = s["m"]
    std = float(np.std(base[:, 3]))
    v, x = base[:, 5], base[:, 0]
    f = goal * std
    red = m["mass"] * s["mech"][8] * (1 - s["mech"][8])
    table = {
        "viscous": f / rms(v),
        "quadratic_drag": f / rms(v * v),
        "position_spring": f / rms(x - p[0]),
        "gravity": 1.4 * f,
        "drive_compliance": 0.5 * m["xs"] / m["level"],
        "backlash": 2 * m["xs"],
        "actuator_dead_zone": f,
        "actuator_saturation": 1.0 / (0.75 * np.max(np.abs(base[:, 3]))),
        "rattling_mass": goal * m["mass"],
        "supply_sag": goal,
        "film_memory": f / rms(v),
        "eddy_drag_peak": 2 * f / rms(v),
        "gain_fading": goal,
        "amplifier_dropout": min(1.0, 3 * goal),
        "magnetic_hysteresis": goal * 2,
        "payload_change": 2 * goal * m["mass"],
        "sloshing_tank": goal * m["mass"],
        "rocking_base": goal,
        "leaking_air_spring": 3 * f,
        "wiper_relaxation": 2 * f / p[1] if p[1] else f,
        "channel_delay": 0.004,
    }
    if name in table:
        return min(table[name], cap(name, s, p)) if name in MECHANICAL else table[name]
    if name == "encoder_error":
        k = 2 * math.pi / p[0]
        return f / (m["mass"] * rms(v * v) * k * k + 0.05 * m["level"] / m["xs"])
    levels = (
        "stribeck",
        "coulomb_asymmetry",
        "position_friction",
        "local_friction_spot",
        "periodic_friction",
        "thermal_drift",
        "run_in",
        "dwell_aging",
        "load_dependent_friction",
        "frictional_lag",
        "sticky_brake",
    )
    if name in levels:
        return 2.0 * f / m["level"]
    del red
    return 2.0 * f


def cap(name, s, p):
    """The largest size that a builder of machines would believe."""
    m = s["m"]
    stroke = m["hi"] - m["lo"]
    red = m["mass"] * s["mech"][8] * (1 - s["mech"][8])
    return {
        "stribeck": 1.3,
        "frictional_lag": 1.3,
        "coulomb_asymmetry": 0.5,
        "run_in": 1.5,
        "thermal_drift": 3.0,
        "dwell_aging": 0.6,
        "load_dependent_friction": 0.6,
        "local_friction_spot": 6.0,
        "periodic_friction": 0.75,
        "position_friction": 1.2,
        "encoder_error": min(0.06 * p[0], 0.008 * stroke),
        "drive_compliance": 1.0 / (red * (2 * math.pi * 14.0) ** 2),
        "backlash": 0.02 * stroke,
        "actuator_dead_zone": 0.8 * m["level"],
        "rattling_mass": 0.4 * m["mass"],
        "supply_sag": 1.0,
        "gain_fading": 0.35,
        "amplifier_dropout": 1.0,
        "magnetic_hysteresis": 0.6,
        "payload_change": 0.6 * m["mass"],
        "sloshing_tank": 0.4 * m["mass"],
        "rocking_base": 0.4,
        "sticky_brake": 3.0,
        "channel_delay": 0.03,
    }.get(name, math.inf)


def size(s, name, sev, rng, base):
    """Find the amplitude at which the effect alone has its share."""
    p = choose.shape(name, rng, s["m"], s["ref"], s["cfg"]["tick"], base, s["cfg"]["fs"])
    if name in MECHANICAL:
        p[0], p[1], p[2] = rng.uniform(0.03, 0.1), float(rng.random() < 0.25), rng.uniform(90, 140)
        p[3] = float(rng.random() < 0.25) if name == "drive_compliance" else 0.0
    course, other = choose.outside(name, rng, s["m"], s["n"], s["cfg"]["tick"])
    if name == "gravity" and np.ptp(base[:, 0]) < 0.9:
        raise Reject("too short a swing")
    sign = 1.0
    if name in ("constant_force", "coulomb_asymmetry", "channel_delay", "supply_sag", "axis_coupling"):
        sign = rng.choice([-1.0, 1.0]) if name != "supply_sag" else 1.0
    goal = rng.uniform(*TARGET[sev])
    amp = first_guess(name, goal, s, base, p)
    seen = []
    for _ in range(6):
        if amp > cap(name, s, p):
            if seen and seen[-1][0] >= 0.999 * cap(name, s, p):
                raise Reject("cap " + name)
            amp = cap(name, s, p)
        eff = (name, sign * amp, p, course)
        out = base if name == "channel_delay" else run(s, [eff])
        if not np.isfinite(out).all():
            amp *= 0.5
            continue
        q = share(s, out, [eff])
        seen.append((amp, q))
        if abs(q / goal - 1) < 0.12:
            break
        g = 1.0
        if len(seen) > 1 and seen[-1][0] != seen[-2][0]:
            g = math.log(max(seen[-1][1], 1e-9) / max(seen[-2][1], 1e-9)) / math.log(
                seen[-1][0] / seen[-2][0]
            )
            g = min(max(g, 0.35), 6.0)
        amp *= min(max((goal / max(q, 1e-9)) ** (1 / g), 0.15), 8.0)
    if not seen or not BAND[sev][0] < seen[-1][1] < BAND[sev][1]:
        raise Reject("size " + name)
    return eff, out, seen[-1][1], other
