"""Kinds of machine and the draw of one of them: masses, friction, encoder, loops."""

import math

import numpy as np

import laws

# mass (kg or kg m^2), sliding level (N or N m), presliding distance, stroke, top speed,
# encoder count, control bandwidth (Hz), screw lead / motor pole pitch, encoder period
KINDS = {
    "ball_screw_table": dict(
        rot=False,
        mass=(60, 320),
        level=(40, 240),
        xs=(3e-6, 3e-5),
        stroke=(0.08, 0.5),
        v=(0.05, 0.3),
        count=(5e-8, 1e-6),
        bw=(12, 32),
        lead=[0.005, 0.01, 0.016, 0.02],
        poles=5,
        grating=[2e-5, 4e-5],
    ),
    "lead_screw_nut": dict(
        rot=False,
        mass=(3, 25),
        level=(3, 28),
        xs=(4e-6, 6e-5),
        stroke=(0.01, 0.09),
        v=(0.004, 0.04),
        count=(2e-8, 5e-7),
        bw=(15, 40),
        lead=[0.001, 0.002, 0.00254, 0.004],
        poles=7,
        grating=[1e-5, 2e-5],
    ),
    "belt_axis": dict(
        rot=False,
        mass=(1.0, 9.0),
        level=(3, 26),
        xs=(2.5e-5, 4e-4),
        stroke=(0.2, 0.9),
        v=(0.15, 1.4),
        count=(2e-6, 2e-5),
        bw=(7, 20),
        lead=[0.06, 0.075, 0.1, 0.12],
        poles=4,
        grating=[1e-4, 1e-3],
    ),
    "nano_stage": dict(
        rot=False,
        mass=(0.6, 6.0),
        level=(0.35, 5.0),
        xs=(1e-6, 5e-5),
        stroke=(0.002, 0.04),
        v=(0.002, 0.06),
        count=(1e-9, 2e-8),
        bw=(25, 70),
        lead=[0.024, 0.03, 0.032, 0.0004, 0.0006],
        poles=1,
        grating=[4e-6, 1e-5, 2e-5],
    ),
    "rack_pinion": dict(
        rot=False,
        mass=(40, 260),
        level=(50, 420),
        xs=(2e-5, 2.5e-4),
        stroke=(0.4, 2.0),
        v=(0.2, 1.2),
        count=(1e-6, 8e-6),
        bw=(7, 16),
        lead=[0.02, 0.05, 0.1],
        poles=4,
        grating=[1e-4, 4e-5],
    ),
    "voice_coil_flexure": dict(
        rot=False,
        mass=(0.05, 0.8),
        level=(0.08, 1.2),
        xs=(2e-6, 8e-5),
        stroke=(0.0015, 0.018),
        v=(0.008, 0.15),
        count=(5e-9, 2e-7),
        bw=(20, 60),
        lead=[0.004, 0.01],
        poles=1,
        grating=[4e-6, 2e-5],
    ),
    "geared_joint": dict(
        rot=True,
        mass=(0.25, 6.0),
        level=(1.2, 18.0),
        xs=(5e-5, 1.2e-3),
        stroke=(0.6, 3.0),
        v=(0.3, 2.6),
        count=(4e-6, 6e-5),
        bw=(6, 18),
        lead=[0.0628318, 0.1256637, 0.0785398],
        poles=4,
        grating=[1e-3, 3.07e-3],
    ),
    "rotary_table": dict(
        rot=True,
        mass=(0.01, 1.8),
        level=(0.05, 4.5),
        xs=(1.5e-5, 5e-4),
        stroke=(0.5, 9.0),
        v=(0.3, 7.0),
        count=(2e-7, 2e-6),
        bw=(15, 45),
        lead=[0.2855993, 0.3926991, 0.5711987],
        poles=1,
        grating=[3.4907e-4, 6.9813e-4],
    ),
    "spindle": dict(
        rot=True,
        mass=(0.002, 0.06),
        level=(0.05, 0.8),
        xs=(3e-4, 5e-3),
        stroke=(4.0, 60.0),
        v=(8.0, 90.0),
        count=(5e-6, 1e-4),
        bw=(6, 18),
        lead=[1.5707963, 2.0943951],
        poles=1,
        grating=[0.01227185, 0.0061359],
    ),
}


def logu(rng, lo, hi):
    return float(math.exp(rng.uniform(math.log(lo), math.log(hi))))


def sig(x, n=4):
    return float(f"{x:.{n}g}")


def draw(kind, law, rng):
    """One machine as a dict of plain numbers."""
    k = KINDS[kind]
    m = {"kind": kind, "law": law, "rotary": k["rot"]}
    m["mass"] = sig(logu(rng, *k["mass"]))
    # levels that belong to the mass: within a factor of the range's geometric relation
    t = (math.log(m["mass"]) - math.log(k["mass"][0])) / math.log(k["mass"][1] / k["mass"][0])
    t = min(max(0.5 * t + 0.5 * rng.random() + rng.normal(0, 0.08), 0.0), 1.0)
    lo, hi = k["level"]
    m["level"] = sig(lo * (hi / lo) ** t)
    stroke = logu(rng, *k["stroke"])
    m["v"] = sig(logu(rng, *k["v"]), 3)
    ratio = logu(rng, 0.35, 4.0)
    m["a"] = sig(ratio * m["level"] / m["mass"], 3)
    if kind != "spindle":
        stroke = min(stroke, rng.uniform(2.0, 6.0) * m["v"])
    # the top speed has to be reached within the travel
    m["v"] = min(m["v"], math.sqrt(0.3 * stroke * m["a"]))
    m["lo"], m["hi"] = -0.5 * stroke, 0.5 * stroke
    if rng.random() < 0.5:
        off = stroke * rng.uniform(0.0, 1.2)
        m["lo"], m["hi"] = m["lo"] + off, m["hi"] + off
    wb = 2 * math.pi * logu(rng, *k["bw"])
    # the presliding spring against the mass stays below what the loops can see
    w_max = min(1500.0, 12.0 * wb)
    xs = logu(rng, *k["xs"])
    xs = max(xs, 1.5 * m["level"] / (m["mass"] * w_max**2))
    m["xs"] = sig(min(xs, 0.02 * stroke))
    code, p, bw, bd, stiff = laws.draw(law, rng, m["xs"], m["mass"], m["level"], m["v"], 6e-5)
    m.update(code=code, lawp=p, bw=bw, bd=bd, stiff=stiff, wb=wb)
    m["wk"] = math.sqrt(m["level"] / m["xs"] * stiff / m["mass"])
    m["lead"] = float(rng.choice(k["lead"]))
    m["poles"] = k["poles"]
    m["grating"] = float(rng.choice(k["grating"]))
    count = logu(rng, *k["count"])
    wf = 6.0 * wb
    m["wf"] = wf
    count = min(count, 0.02 * m["level"] / (m["mass"] * wb * wf), m["xs"] * rng.uniform(0.08, 0.5))
    m["count"] = sig(count, 2)
    # ordinary imperfection of a healthy machine
    m["wander"] = rng.uniform(0.006, 0.02)
    waves = np.zeros(6)
    for j, turns in enumerate((rng.uniform(0.4, 1.3), rng.uniform(1.5, 4.0), rng.uniform(4.0, 11.0))):
        waves[2 * j] = 2 * math.pi * turns / stroke
        waves[2 * j + 1] = rng.uniform(0, 6.28)
    m["waves"] = waves
    m["ripple"] = m["level"] * rng.uniform(0.001, 0.009)
    m["ripple_period"] = m["lead"] / m["poles"]
    m["viscous"] = 0.0
    return m


def level_in_time(rng, n, tick, v_ref):
    """The sliding level's ordinary life: a slow walk and a little from stroke to stroke."""
    t = np.arange(n) * tick
    y = np.ones(n)
    a = rng.uniform(0.003, 0.015)
    for _ in range(3):
        y += a * np.sin(2 * math.pi * t * rng.uniform(0.2, 2.5) / t[-1] + rng.uniform(0, 6.28)) / 1.7
    s = np.sign(v_ref)
    if np.any(s):
        idx = np.where(s != 0, np.arange(n), 0)
        np.maximum.accumulate(idx, out=idx)
        s = s[idx]
    strokes = np.concatenate([[0], np.cumsum(np.diff(s) != 0)]).astype(int)
    g = rng.normal(0, rng.uniform(0.002, 0.012), strokes[-1] + 1)
    y += g[strokes]
    w = max(1, int(0.01 / tick))
    c = np.cumsum(np.concatenate([np.full(w, y[0]), y]))
    return (c[w:] - c[:-w]) / w


def controller(m, rng, mode, tick, ff_ok=True):
    """Gains of one loop.  Returns (mode number, name, parameters)."""
    names = {"p_pi": 0, "pid": 1, "pid_ff": 2, "open": 3, "speed_pi": 4}
    c = np.zeros(12)
    c[0] = m["mass"] * rng.uniform(0.85, 1.1)
    c[1] = m["wb"]
    c[2] = rng.uniform(0.12, 0.3)
    c[3] = 1.0 - math.exp(-m["wf"] * tick)
    c[4] = rng.uniform(0.8, 1.1) if mode == "pid_ff" or rng.random() < 0.3 else 0.0
    c[5] = rng.uniform(0.5, 1.0) if mode == "pid_ff" and rng.random() < 0.6 else 0.0
    c[6] = m["level"]
    c[7] = 8.0 * (m["level"] + m["mass"] * m["a"])
    c[8] = rng.uniform(0.8, 1.0) if mode in ("p_pi", "pid_ff") else rng.choice([0.0, 1.0])
    if mode == "pid" and c[8] == 0.0:
        c[8] = 1.0
    c[9] = 0.02 * m["v"] + 2e-9
    c[10] = 2 * math.pi * rng.uniform(0.05, 0.2)
    return names[mode], c
