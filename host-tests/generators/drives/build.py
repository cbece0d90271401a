"""One trial: draw a machine, run it, find each effect's size, run them together."""

import math

import baseline
import choose
import machines
import motions
import numpy as np
from catalogue import BAND, CODE, TARGET
from plant import simulate

MECHANICAL = ("drive_compliance", "backlash")
DRAGS = ("viscous", "quadratic_drag", "film_memory", "eddy_drag_peak", "stribeck", "frictional_lag")


class Reject(Exception):
    pass


def rms(y):
    return float(np.sqrt(np.mean(np.square(y))))


def setup(rng, kind, law, names, seconds=None):
    """Machine, logger, loop and motion of one recording."""
    m = machines.draw(kind, law, rng)
    cfg = {}
    base_p = 0.3 if m["rotary"] else 0.5
    cfg["base"] = law != "coulomb_tanh" and rng.random() < base_p * 1.12
    if cfg["base"] and rng.random() < 0.3 and not any(q in DRAGS for q in names):
        m["viscous"] = machines.sig(rng.uniform(0.05, 0.35) * m["level"] / m["v"])
    fine = kind in ("nano_stage", "voice_coil_flexure")
    fs = float(rng.choice([200, 250, 400, 500, 1000, 2000, 2500, 4000, 5000], p=[0.08, 0.1, 0.08, 0.14, 0.26, 0.14, 0.08, 0.06, 0.06]))
    loop = fs * math.ceil((4000 if fine else 2000) / fs)
    sec = min(rng.uniform(15, 90), 130e3 / fs) if seconds is None else seconds
    sec = max(15.0, round(sec, 1))
    tick = 1.0 / loop
    cfg.update(fs=fs, tick=tick, sec=sec)
    w_drive = 2 * math.pi * 150 if any(q in MECHANICAL for q in names) else 0.0
    step = min(1e-4, 0.1 / m["wk"], 0.08 / w_drive if w_drive else 1.0, 1.5e-4 * 300 / m["wb"])
    cfg["nsub"] = max(1, math.ceil(tick / step))
    must = choose.PLACE[names[0]][1] if names else motions.KINDS
    for q in names[1:]:
        both = [k for k in must if k in choose.PLACE[q][1]]
        must = both or must
    n_kinds = int(rng.choice([1, 2, 3], p=[0.35, 0.4, 0.25]))
    kinds = [str(rng.choice(must))]
    for q in names[1:]:
        if kinds[0] not in choose.PLACE[q][1]:
            kinds.append(str(rng.choice(choose.PLACE[q][1])))
    while len(kinds) < n_kinds:
        kinds.append(str(rng.choice(motions.KINDS)))
    if not names and set(kinds) <= {"scan", "steps"}:
        kinds[0] = str(rng.choice(motions.HARD))
    kinds = [kinds[i] for i in rng.permutation(len(kinds))]
    mode = str(rng.choice(["p_pi", "pid", "pid_ff", "open"], p=[0.4, 0.22, 0.3, 0.08]))
    if mode == "open" and (names and names[0] in ("actuator_saturation", "dwell_aging", "sticky_brake", "chip_heap", "local_friction_spot", "gravity", "position_spring") or any(q in MECHANICAL for q in names)):
        mode = "p_pi"
    if kind == "spindle":
        mode, kinds = "speed_pi", ["speeds"]
        ref, seg, rep = motions.spinning(rng, m, tick, sec)
    elif mode == "open":
        kinds = ["pushes"]
        mid = 0.5 * (m["lo"] + m["hi"])
        m["lo"], m["hi"] = m["lo"] - mid, m["hi"] - mid
        ref, seg, rep = motions.pushing(rng, m, tick, sec, m["level"])
    else:
        ref, seg, rep = motions.reference(rng, m, tick, sec, kinds)
    cfg.update(mode=mode, kinds=kinds, seg=seg, rep=rep)
    number, ctl = machines.controller(m, rng, mode, tick)
    n = ref.shape[1]
    mech = np.zeros(23)
    mech[:5] = m["mass"], m["level"], m["viscous"], m["count"], rng.uniform(8e-5, 2.2e-4)
    mech[5] = 1.0 if rng.random() < 0.3 and loop >= 4000 else 0.0
    mech[6], mech[7] = m["ripple"], m["ripple_period"]
    mech[8] = rng.uniform(0.3, 0.6)
    mech[15], mech[16] = ref[0, 0], m["wander"] / 1.22
    mech[17:23] = m["waves"]
    cfg["late"] = bool(mech[5])
    levt = machines.level_in_time(rng, n, tick, ref[1])
    draw_logger(rng, cfg, m, names, n)
    return {"m": m, "cfg": cfg, "ref": ref, "mode": number, "ctl": ctl, "mech": mech, "levt": levt, "n": n}


def draw_logger(rng, cfg, m, names, n):
    how = {}
    r = rng.random()
    if r < 0.2:
        how["jitter"] = str(rng.choice(["true", "stamp"]))
    if 0.14 < r < 0.34:
        how["lost"] = machines.logu(rng, 5e-4, 5e-3)
    cfg["how"] = how
    actuator = any(q in ("actuator_dead_zone", "actuator_saturation") for q in names)
    cfg["effort"] = "command" if actuator or rng.random() < 0.45 else "current"
    cfg["noise"] = machines.logu(rng, 0.001, 0.02)
    cfg["bits"] = int(rng.choice([12, 14, 16]))
    add = set()
    for key, p in [("ref", 0.5), ("vel", 0.35), ("current", 0.15), ("voltage", 0.06), ("temperature", 0.15), ("random", 0.15), ("status", 0.2), ("segment", 0.13)]:
        if rng.random() < p:
            add.add(key)
    if cfg["mode"] in ("open", "speed_pi"):
        add.discard("ref")
    if "thermal_drift" in names and rng.random() < 0.6:
        add.add("temperature")
    cfg["columns"] = add
    cfg["kt"] = machines.sig(machines.logu(rng, 0.05, 2.0) * (30 if not m["rotary"] and m["mass"] > 20 else 1), 3)
    cfg["ohm"] = rng.uniform(0.4, 6.0)
    cfg["shuffle"] = rng.random() < 0.3
    t = np.arange(n) * cfg["tick"]
    cfg["heat"] = rng.uniform(19, 27) + rng.uniform(0, 4) * (1 - np.exp(-t / rng.uniform(20, 80))) + 0.1 * choose.colored(rng, n, cfg["tick"], 6.0)
    cfg["other"] = choose.other_axis(rng, m, n, cfg["tick"]) if rng.random() < 0.1 else None
    cfg["other_count"] = machines.sig(m["count"] * rng.uniform(1, 5), 2)


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
        s["cfg"]["nsub"] * halve, s["cfg"]["tick"], s["ref"], s["levt"], aux, mech, s["mode"], s["ctl"],
        m["code"], m["lawp"], m["bw"], m["bd"], codes, amps, ep, enc, act,
    )  # fmt: skip


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


def first_guess(name, goal, s, base, p):
    m = s["m"]
    std = float(np.std(base[:, 3]))
    v, x = base[:, 5], base[:, 0]
    f = goal * std
    red = m["mass"] * s["mech"][8] * (1 - s["mech"][8])
    table = {
        "viscous": f / rms(v), "quadratic_drag": f / rms(v * v), "position_spring": f / rms(x - p[0]),
        "gravity": 1.4 * f, "drive_compliance": 0.5 * m["xs"] / m["level"], "backlash": 2 * m["xs"],
        "actuator_dead_zone": f, "actuator_saturation": 1.0 / (0.75 * np.max(np.abs(base[:, 3]))),
        "rattling_mass": goal * m["mass"], "supply_sag": goal, "film_memory": f / rms(v), "eddy_drag_peak": 2 * f / rms(v),
        "gain_fading": goal, "amplifier_dropout": min(1.0, 3 * goal), "magnetic_hysteresis": goal * 2, "payload_change": 2 * goal * m["mass"],
        "sloshing_tank": goal * m["mass"], "rocking_base": goal, "leaking_air_spring": 3 * f, "wiper_relaxation": 2 * f / p[1] if p[1] else f,
        "channel_delay": 0.004,
    }  # fmt: skip
    if name in table:
        return min(table[name], cap(name, s, p)) if name in MECHANICAL else table[name]
    if name == "encoder_error":
        k = 2 * math.pi / p[0]
        return f / (m["mass"] * rms(v * v) * k * k + 0.05 * m["level"] / m["xs"])
    levels = ("stribeck", "coulomb_asymmetry", "position_friction", "local_friction_spot", "periodic_friction", "thermal_drift",
              "run_in", "dwell_aging", "load_dependent_friction", "frictional_lag", "sticky_brake")  # fmt: skip
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
        "stribeck": 1.3, "frictional_lag": 1.3, "coulomb_asymmetry": 0.5, "run_in": 1.5, "thermal_drift": 3.0, "dwell_aging": 0.6,
        "load_dependent_friction": 0.6, "local_friction_spot": 6.0, "periodic_friction": 0.75, "position_friction": 1.2,
        "encoder_error": 0.12 * p[0], "drive_compliance": 1.0 / (red * (2 * math.pi * 14.0) ** 2), "backlash": 0.02 * stroke,
        "actuator_dead_zone": 0.8 * m["level"], "rattling_mass": 0.4 * m["mass"], "supply_sag": 1.0, "gain_fading": 0.35,
        "amplifier_dropout": 1.0, "magnetic_hysteresis": 0.6, "payload_change": 0.6 * m["mass"], "sloshing_tank": 0.4 * m["mass"],
        "rocking_base": 0.4, "sticky_brake": 3.0, "channel_delay": 0.03,
    }.get(name, math.inf)  # fmt: skip


def size(s, name, sev, rng, base):
    """Find the amplitude at which the effect alone has its share."""
    p = choose.shape(name, rng, s["m"], s["ref"], s["cfg"]["tick"], base)
    if name in MECHANICAL:
        p[0], p[1], p[2] = rng.uniform(0.03, 0.1), float(rng.random() < 0.25), rng.uniform(90, 140)
        p[3] = float(rng.random() < 0.25) if name == "drive_compliance" else 0.0
    course, other = choose.outside(name, rng, s["m"], s["n"], s["cfg"]["tick"])
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
            g = math.log(max(seen[-1][1], 1e-9) / max(seen[-2][1], 1e-9)) / math.log(seen[-1][0] / seen[-2][0])
            g = min(max(g, 0.35), 6.0)
        amp *= min(max((goal / max(q, 1e-9)) ** (1 / g), 0.15), 8.0)
    if not seen or not BAND[sev][0] < seen[-1][1] < BAND[sev][1]:
        raise Reject("size " + name)
    return eff, out, seen[-1][1], other


def trial(rng, kind, law, wanted):
    """wanted: list of (name, severity).  Returns everything that is to be written."""
    names = [q for q, _ in wanted]
    s = setup(rng, kind, law, names)
    base = run(s, [])
    sane(s, base)
    m, cfg = s["m"], s["cfg"]
    effects, shares = [], []
    out = base
    for name, sev in wanted:
        eff, out, q, other = size(s, name, sev, rng, base)
        effects.append(eff)
        shares.append(q)
        if other is not None:
            cfg["other"] = other
    if len(wanted) > 1:
        out = run(s, effects)
    rough = any(q in (*MECHANICAL, "rattling_mass", "external_vibration", "amplifier_dropout") for q in names)
    sane(s, out, rough)
    total = share(s, out, effects)
    if "thermal_drift" in names:
        p = effects[names.index("thermal_drift")][2]
        heat = np.abs(out[:, 3] * out[:, 5])
        a = math.exp(-cfg["tick"] / p[0])
        temp = np.zeros(heat.size)
        run_sum = 0.0
        for i in range(0, heat.size, 50):
            blk = float(np.mean(heat[i : i + 50]))
            run_sum = run_sum * a**50 + (1 - a**50) * blk
            temp[i : i + 50] = run_sum
        cfg["heat"] = 22.0 + 9.0 * temp / (temp.max() + 1e-30)
    toml, fit_err = (None, None)
    if cfg["base"]:
        toml, fit_err = baseline.text(m, rng)
        if fit_err > 0.05:
            raise Reject("fit")
    delay = next((e[1] for e in effects if e[0] == "channel_delay"), 0.0)
    return {"s": s, "base": base, "out": out, "effects": effects, "shares": shares, "total": total, "toml": toml, "fit": fit_err, "delay": delay}
