"""Which machine and motion can show an effect, and the fixed numbers of its shape."""

import math

import numpy as np

import motions
from machines import logu

ANY = [
    "ball_screw_table",
    "lead_screw_nut",
    "belt_axis",
    "nano_stage",
    "rack_pinion",
    "voice_coil_flexure",
    "geared_joint",
    "rotary_table",
]
FAST = ["ball_screw_table", "belt_axis", "rack_pinion", "geared_joint", "rotary_table", "voice_coil_flexure"]
GEARED = ["ball_screw_table", "lead_screw_nut", "belt_axis", "rack_pinion", "geared_joint"]
VARIED, LONG, HARD = motions.VARIED, motions.LONG, motions.HARD
SLOW = ["jog", "random", "scan", "sines"]

# effect: machines, motions of which one must be there
PLACE = {
    "viscous": (ANY + ["spindle"], VARIED),
    "quadratic_drag": (ANY + ["spindle"], VARIED),
    "stribeck": (ANY + ["spindle"], SLOW),
    "coulomb_asymmetry": (ANY, LONG + ["sines"]),
    "constant_force": (ANY, motions.KINDS),
    "position_spring": (ANY[:-1] + ["voice_coil_flexure"] * 5, LONG + ["sines"]),
    "position_force": (ANY, LONG),
    "position_friction": (ANY, LONG),
    "local_friction_spot": (ANY, LONG),
    "periodic_force": (ANY + ["spindle"], LONG),
    "periodic_friction": (
        ["ball_screw_table", "lead_screw_nut", "belt_axis", "geared_joint", "rotary_table"],
        LONG,
    ),
    "encoder_error": (ANY, LONG + ["sines"]),
    "channel_delay": (ANY, HARD),
    "drive_compliance": (GEARED, HARD + ["scurve"]),
    "backlash": (GEARED, HARD + ["trap", "scurve"]),
    "thermal_drift": (ANY + ["spindle"], LONG + ["sines"]),
    "run_in": (ANY, LONG + ["sines"]),
    "dwell_aging": (ANY, ["trap", "scurve", "random", "steps"]),
    "external_vibration": (ANY + ["spindle"], motions.KINDS),
    "load_dependent_friction": (GEARED + ["voice_coil_flexure", "rotary_table"], HARD),
    "frictional_lag": (FAST + ["lead_screw_nut", "nano_stage"], ["sines", "chirp", "random"]),
    "gravity": (["geared_joint"], LONG + ["sines"]),
    "actuator_dead_zone": (ANY, VARIED),
    "actuator_saturation": (ANY, HARD),
    "axis_coupling": (ANY, motions.KINDS),
    "rattling_mass": (FAST, HARD + ["trap"]),
    "supply_sag": (FAST + ["spindle"], HARD),
    "film_memory": (FAST + ["lead_screw_nut"], ["random", "jog", "trap"]),
    "wiper_relaxation": (ANY, LONG),
    "sticky_brake": (ANY, ["trap", "random", "scurve"]),
    "gain_fading": (ANY, HARD),
    "eddy_drag_peak": (FAST + ["spindle"], ["jog", "random", "sines"]),
    "sloshing_tank": (["ball_screw_table", "belt_axis", "rack_pinion"], HARD + ["trap"]),
    "chip_heap": (
        ["ball_screw_table", "rack_pinion", "belt_axis", "lead_screw_nut"],
        ["trap", "scurve", "sines"],
    ),
    "leaking_air_spring": (ANY[:-2], LONG),
    "magnetic_hysteresis": (["voice_coil_flexure", "rotary_table", "nano_stage"], HARD),
    "amplifier_dropout": (ANY, VARIED),
    "payload_change": (FAST, HARD),
    "rocking_base": (["ball_screw_table", "belt_axis", "rack_pinion"], HARD + ["trap"]),
    "ball_entry_noise": (["ball_screw_table", "nano_stage"], LONG),
    "coolant_jet": (["ball_screw_table", "belt_axis", "rack_pinion", "spindle", "rotary_table"], LONG),
    "seal_adhesion": (ANY, ["trap", "random", "steps"]),
}
PAIRS = [
    ("viscous", "position_force"),
    ("stribeck", "viscous"),
    ("gravity", "viscous"),
    ("gravity", "stribeck"),
    ("constant_force", "stribeck"),
    ("periodic_force", "viscous"),
    ("position_spring", "viscous"),
    ("position_spring", "constant_force"),
    ("local_friction_spot", "constant_force"),
    ("quadratic_drag", "periodic_friction"),
    ("external_vibration", "stribeck"),
    ("axis_coupling", "viscous"),
    ("backlash", "viscous"),
    ("gravity", "load_dependent_friction"),
    ("drive_compliance", "constant_force"),
    ("thermal_drift", "position_force"),
    ("channel_delay", "constant_force"),
    ("periodic_force", "coulomb_asymmetry"),
    ("run_in", "viscous"),
    ("encoder_error", "constant_force"),
    ("actuator_dead_zone", "viscous"),
    ("axis_coupling", "position_friction"),
    ("position_spring", "external_vibration"),
    ("gravity", "periodic_force"),
    ("dwell_aging", "constant_force"),
    ("position_friction", "viscous"),
]


def bump_shape(p, rng, m):
    s = m["hi"] - m["lo"]
    p[0] = rng.normal(0, 0.7) if rng.random() < 0.6 else 0.0
    p[1], p[2] = m["lo"] + s * rng.uniform(0.25, 0.75), s * rng.uniform(0.06, 0.25)
    p[3] = rng.choice([-1, 1]) * rng.uniform(0.6, 1.5)
    p[4], p[5] = m["lo"] + s * rng.uniform(0.15, 0.85), s * rng.uniform(0.06, 0.2)
    p[6] = rng.normal(0, 0.6) if rng.random() < 0.6 else 0.0
    p[7], p[8] = 0.5 * (m["lo"] + m["hi"]), 0.5 * s


def shape(name, rng, m, ref, tick, base, fs):
    """Fixed numbers `p` of an effect; `base` is the run without it."""
    p = np.zeros(12)
    v = base[:, 5]
    vr = float(np.sqrt(np.mean(v**2))) + 1e-12
    total = float(np.sum(np.abs(v)) * tick)
    sec = v.size * tick
    s = m["hi"] - m["lo"]
    if name in ("stribeck", "frictional_lag"):
        p[0], p[1] = m["v"] * logu(rng, 0.015, 0.12), rng.choice([1.0, 1.0, 2.0, 0.6])
        if name == "frictional_lag":
            p[0], p[2] = m["v"] * logu(rng, 0.08, 0.35), logu(rng, 0.03, 0.2)
    elif name == "coulomb_asymmetry":
        p[0] = 2e-3 * m["v"]
    elif name == "position_spring":
        p[0] = m["lo"] + s * rng.uniform(0.4, 0.6)
    elif name in ("position_force", "position_friction"):
        bump_shape(p, rng, m)
    elif name == "local_friction_spot":
        p[0], p[1] = m["lo"] + s * rng.uniform(0.2, 0.8), s * rng.uniform(0.012, 0.05)
    elif name in ("periodic_force", "periodic_friction", "encoder_error"):
        q = m["lead"] / m["poles"] if name == "periodic_force" else m["lead"]
        if rng.random() < 0.25:
            q = s / rng.uniform(4.0, 25.0)
        if name == "encoder_error" and m["kind"] == "nano_stage" and rng.random() < 0.5:
            q = m["grating"]
        if q > s / 2.5:
            q = s / rng.uniform(4.0, 15.0)
        q = max(q, vr / min(0.1 * fs, 40.0))  # slow enough for the logger and the loop
        p[0], p[1] = q, rng.uniform(0, 6.28)
        if rng.random() < 0.5:
            p[2], p[3] = rng.uniform(0.1, 0.5), rng.uniform(0, 6.28)
    elif name == "thermal_drift":
        p[0], p[1], p[2] = sec * rng.uniform(0.15, 0.7), m["level"] * vr, rng.choice([-0.3, -0.3, 0.3])
    elif name == "run_in":
        p[0] = total * rng.uniform(0.1, 0.35)
    elif name == "dwell_aging":
        p[0], p[1], p[2] = rng.uniform(0.01, 0.05), m["xs"] * rng.uniform(10, 200), 1.5e-3 * m["v"]
        p[1] = max(p[1], m["v"] * rng.uniform(0.02, 0.15))
    elif name == "load_dependent_friction":
        p[0], p[1] = 2e-3, m["level"]
    elif name == "gravity":
        p[0] = rng.choice([0.0, -0.5 * math.pi]) + rng.normal(0, 0.15)
    elif name == "rattling_mass":
        p[0] = m["v"] ** 2 / m["a"] * rng.uniform(0.01, 0.06)
        p[1], p[2], p[3], p[4] = 2 * math.pi * rng.uniform(40, 80), 0.1, 0.1 * m["a"], 0.02 * m["v"]
    elif name == "supply_sag":
        p[0], p[2] = rng.uniform(0.3, 2.0), 0.3 * m["v"] / m["level"]
        p[1] = float(np.mean(np.maximum(base[:, 3] * v, 0) + p[2] * base[:, 3] ** 2))
    elif name == "film_memory":
        p[0], p[1], p[2] = rng.uniform(0.4, 2.5), vr, 0.25
    elif name == "wiper_relaxation":
        p[0], p[1] = rng.uniform(0.15, 1.0), s * rng.uniform(0.08, 0.4)
    elif name == "sticky_brake":
        p[0], p[1], p[2] = 3e-3 * m["v"], rng.uniform(0.03, 0.1), rng.uniform(0.1, 0.4)
    elif name == "eddy_drag_peak":
        p[0] = m["v"] * rng.uniform(0.12, 0.3)
    elif name == "sloshing_tank":
        p[0], p[1] = 2 * math.pi * rng.uniform(0.8, 3.0), rng.uniform(0.02, 0.08)
    elif name == "chip_heap":
        p[0], p[1], p[2], p[3] = (
            s * rng.uniform(0.03, 0.12),
            s * rng.uniform(0.03, 0.1),
            0.4 * s,
            0.5 * (m["lo"] + m["hi"]),
        )
    elif name == "leaking_air_spring":
        p[0], p[1] = 0.3 * s, rng.uniform(1.0, 5.0)
    elif name == "magnetic_hysteresis":
        p[0] = float(np.std(base[:, 3])) * rng.uniform(0.4, 0.8)
    elif name == "rocking_base":
        p[0], p[1], p[2] = 2 * math.pi * rng.uniform(3.0, 11.0), rng.uniform(0.02, 0.06), 1.0 / m["mass"]
    elif name == "ball_entry_noise":
        p[0], p[1] = s / rng.uniform(8.0, 40.0), 5e-3 * m["v"]
    elif name == "seal_adhesion":
        p[0], p[1], p[2] = 3e-3 * m["v"], rng.uniform(0.04, 0.12), m["xs"] * rng.uniform(2.0, 15.0)
        p[2] = max(p[2], s * 0.004)
    return p


def colored(rng, n, tick, tau):
    """Slow random walk with a memory, unit deviation."""
    k = max(1, int(tau / tick / 20))
    w = rng.normal(0, 1, n // k + 3)
    y = np.zeros(w.size)
    a = math.exp(-1 / 20)
    for i in range(1, w.size):
        y[i] = a * y[i - 1] + w[i]
    y = np.interp(np.arange(n) / k, np.arange(w.size), y)
    y = motions.smooth(y, 2 * k)
    return (y - y.mean()) / (y.std() + 1e-12)


def outside(name, rng, m, n, tick):
    """The time course that an effect takes from outside; second value: the other axis."""
    t = np.arange(n) * tick
    other = None
    if name == "external_vibration":
        f = logu(rng, 4.0, 45.0)
        y = np.sin(2 * math.pi * f * t + 0.3 * np.sin(2 * math.pi * 0.11 * t)) * (
            1 + 0.25 * np.sin(2 * math.pi * t * 0.07 + 1)
        )
    elif name == "axis_coupling":
        other = other_axis(rng, m, n, tick)
        vel = np.gradient(other, tick)
        acc = motions.smooth(np.gradient(vel, tick), 5)
        how = rng.integers(0, 4)
        parts = [acc / acc.std(), vel / vel.std(), (other - other.mean()) / other.std()]
        y = parts[how] if how < 3 else 0.7 * parts[0] + 0.5 * parts[2]
    elif name == "gain_fading":
        y = colored(rng, n, tick, rng.uniform(1.0, 5.0))
    elif name == "amplifier_dropout":
        y = np.zeros(n)
        at = 1.0
        while at < t[-1]:
            w = rng.uniform(0.02, 0.09)
            y[int(at / tick) : int((at + w) / tick)] = -1.0
            at += w + rng.exponential(rng.uniform(0.3, 0.9)) + 0.05
    elif name == "payload_change":
        y = np.zeros(n)
        a = rng.uniform(0.15, 0.5)
        y[int(a * n) : int((a + rng.uniform(0.25, 0.45)) * n)] = 1.0
    elif name == "coolant_jet":
        y = np.zeros(n)
        at, on = 0.5, False
        while at < t[-1]:
            d = rng.exponential(2.5) + 0.3
            if on:
                y[int(at / tick) : int((at + d) / tick)] = rng.uniform(0.8, 1.2)
            on = not on
            at += d
        y = motions.smooth(y, int(0.08 / tick)) * (1 + 0.1 * colored(rng, n, tick, 0.1))
    else:
        y = np.zeros(n)
    return y, other


def other_axis(rng, m, n, tick):
    """Motion of a neighbouring axis, in metres or radians."""
    size = (m["hi"] - m["lo"]) * rng.uniform(0.3, 1.5)
    q = dict(
        m, lo=-0.5 * size, hi=0.5 * size, v=m["v"] * rng.uniform(0.5, 1.5), a=m["a"] * rng.uniform(0.5, 2.0)
    )
    kinds = list(rng.choice(["trap", "random", "sines", "multisine"], 2, replace=False))
    ref, _, _ = motions.reference(rng, q, tick, n * tick, kinds)
    y = motions.smooth(ref[0][:n], int(0.01 / tick))
    return y if y.std() > 0 else size * np.sin(2 * math.pi * 0.4 * np.arange(n) * tick)
