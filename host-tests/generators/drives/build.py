"""One trial: draw a machine, run it, find each effect's size, run them together."""

import math

import numpy as np

import baseline
import choose
import machines
import motions
from sizing import MECHANICAL, run, sane, settled, share, size, spread

DRAGS = ("viscous", "quadratic_drag", "film_memory", "eddy_drag_peak", "stribeck", "frictional_lag")


def setup(rng, kind, law, names, seconds=None):
    """Machine, logger, loop and motion of one recording."""
    m = machines.draw(kind, law, rng)
    cfg = {}
    base_p = 0.3 if m["rotary"] else 0.5
    cfg["base"] = law != "coulomb_tanh" and rng.random() < base_p * 1.3
    if cfg["base"] and rng.random() < 0.3 and not any(q in DRAGS for q in names):
        m["viscous"] = machines.sig(rng.uniform(0.05, 0.35) * m["level"] / m["v"])
    fine = kind in ("nano_stage", "voice_coil_flexure")
    fs = float(
        rng.choice(
            [200, 250, 400, 500, 1000, 2000, 2500, 4000, 5000],
            p=[0.08, 0.1, 0.08, 0.14, 0.26, 0.14, 0.08, 0.06, 0.06],
        )
    )
    loop = fs * math.ceil((4000 if fine else 2000) / fs)
    sec = min(rng.uniform(15, 90), 130e3 / fs) if seconds is None else seconds
    sec = max(15.0, round(sec, 1))
    if set(names) & {"thermal_drift", "run_in", "gain_fading", "payload_change"}:
        sec = max(sec, 35.0)
    elif names:
        sec = max(sec, 22.0)
    tick = 1.0 / loop
    m["f_max"] = min(fs / 25, 0.4 * m["wb"] / (2 * math.pi))
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
    if mode == "open" and (
        names
        and names[0]
        in (
            "actuator_saturation",
            "dwell_aging",
            "sticky_brake",
            "chip_heap",
            "local_friction_spot",
            "gravity",
            "position_spring",
        )
        or any(q in MECHANICAL for q in names)
    ):
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
    for key, p in [
        ("ref", 0.5),
        ("vel", 0.35),
        ("current", 0.15),
        ("voltage", 0.06),
        ("temperature", 0.15),
        ("random", 0.15),
        ("status", 0.2),
        ("segment", 0.13),
    ]:
        if rng.random() < p:
            add.add(key)
    if cfg["mode"] in ("open", "speed_pi"):
        add.discard("ref")
    if "thermal_drift" in names and rng.random() < 0.6:
        add.add("temperature")
    cfg["columns"] = add
    cfg["kt"] = machines.sig(
        machines.logu(rng, 0.05, 2.0) * (30 if not m["rotary"] and m["mass"] > 20 else 1), 3
    )
    cfg["ohm"] = rng.uniform(0.4, 6.0)
    cfg["shuffle"] = rng.random() < 0.3
    t = np.arange(n) * cfg["tick"]
    cfg["heat"] = (
        rng.uniform(19, 27)
        + rng.uniform(0, 4) * (1 - np.exp(-t / rng.uniform(20, 80)))
        + 0.1 * choose.colored(rng, n, cfg["tick"], 6.0)
    )
    cfg["other"] = choose.other_axis(rng, m, n, cfg["tick"]) if rng.random() < 0.1 else None
    cfg["other_count"] = machines.sig(m["count"] * rng.uniform(1, 5), 2)


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
    if wanted:
        spread(s, out, names)
    settled(s, out, effects, total)
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
        toml, fit_err, rest = baseline.text(m, rng, base[:, 1], cfg["tick"])
        if fit_err > 0.05 or rest > 0.05 * np.std(base[:, 3]):
            toml, fit_err = None, None  # no decent model of this machine in blocks: none is given
    delay = next((e[1] for e in effects if e[0] == "channel_delay"), 0.0)
    return {
        "s": s,
        "base": base,
        "out": out,
        "effects": effects,
        "shares": shares,
        "total": total,
        "toml": toml,
        "fit": fit_err,
        "delay": delay,
    }
