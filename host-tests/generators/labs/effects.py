"""Draws of concealed effects: the catalogue and the strangers, with their parameters and label names.

In every effect p[0] is the strength, scaled later until the effect has the wanted share of the friction.
"""
from dataclasses import dataclass, field

import numpy as np

from plant import CODE

STRANGERS = ["cable_snap", "eddy_brake", "leaky_chamber", "lip_seal_flip", "thixotropic_grease", "sliding_cargo",
             "gust_bursts", "squeeze_film", "magnet_spot", "grease_starvation", "supply_sag", "magnet_heating",
             "amplifier_dropout", "payload_second_stroke"]
CATALOGUE = ["constant_force", "coulomb_asymmetry", "viscous", "quadratic_drag", "stribeck", "frictional_lag",
             "position_spring", "position_force", "position_friction", "local_friction_spot", "periodic_force",
             "periodic_friction", "encoder_error", "backlash", "drive_compliance", "channel_delay",
             "actuator_dead_zone", "actuator_saturation", "load_dependent_friction", "thermal_drift", "run_in",
             "dwell_aging", "creep", "external_vibration", "gravity"]
STRUCTURAL = {"backlash", "drive_compliance", "encoder_error", "channel_delay", "actuator_saturation",
              "actuator_dead_zone"}
CODE["channel_delay"] = 0           # made after the simulation, from the recorded channels


@dataclass
class Effect:
    """One drawn effect: p[0] starts at `start` and may go from `low` to `high`."""
    name: str
    p: np.ndarray
    start: float
    low: float
    high: float
    names: dict                     # label name -> index into p
    table: np.ndarray = field(default_factory=lambda: np.zeros(512))
    wave: np.ndarray | None = None

    def labels(self):
        return {key: float(self.p[i]) for key, i in self.names.items()}


def suits(name, machine):
    """Whether the effect can be drawn on this machine."""
    if name == "gravity":
        return machine.rotary and 2 * machine.half > 1.0
    if name == "viscous":
        return machine.with_base
    if name in ("dwell_aging", "creep"):
        return machine.dwells and machine.law.name != "tanh"
    if name in ("stribeck", "frictional_lag"):
        return machine.motion not in ("raster",)
    if name == "cable_snap":
        return machine.motion in ("point_to_point", "raster", "random", "sines", "chirp")
    return True


def _smooth_table(rng):
    u = np.linspace(0, 1, 512)
    y = sum(rng.normal() * np.exp(-((u - rng.uniform(-0.1, 1.1)) / rng.uniform(0.1, 0.35)) ** 2) for _ in range(6))
    y -= y.mean()
    return y / np.abs(y).max()


def _bursts(rng, n, fs, low, high):
    """Random coloured noise that comes in bursts of some seconds."""
    f = np.fft.rfftfreq(n, 1 / fs)
    shape = (f > low) * np.exp(-(f / high) ** 2)
    y = np.fft.irfft(shape * (rng.normal(size=f.size) + 1j * rng.normal(size=f.size)), n)
    gate = np.repeat(rng.uniform(size=int(n / fs) + 2) < 0.4, int(fs))[:n].astype(float)
    width = int(0.3 * fs)
    return y / y.std() * np.convolve(gate, np.full(width, 1 / width), "same")


def _drops(rng, n, fs):
    """Gate of short drop-outs (20 to 80 ms), about one a second."""
    y = np.zeros(n)
    for start in rng.integers(0, n, max(6, int(n / fs * rng.uniform(0.6, 2)))):
        y[start:start + int(rng.uniform(0.02, 0.08) * fs) + 1] = 1.0
    return y


def draw(rng, name, mach, ref, clean_u, temperature):
    """Draw the effect for the machine; clean_u is the command without it."""
    u = rng.uniform
    level, xs, speed, half, path = mach.level, mach.distance, mach.speed, mach.half, np.abs(np.diff(ref[:, 0])).sum()
    v_rms, span = ref[:, 1].std(), max(np.ptp(ref[:, 0]), 1e-9)
    centre, fs, cut = 0.5 * (ref[:, 0].max() + ref[:, 0].min()), mach.fs, mach.cutoff
    visited = ref[rng.integers(0, len(ref)), 0]
    N, L, F = ("Nm", "rad", "Nm") if mach.rotary else ("N", "m", "N")
    slow = np.quantile(np.abs(ref[:, 1])[np.abs(ref[:, 1]) > 0.01 * speed], [0.15, 0.5])
    v_s = u(*slow) if slow[1] > slow[0] else slow[1]
    sign = rng.choice([-1.0, 1.0])
    p, table, wave = np.zeros(8), np.zeros(512), None
    a = sign * level                # natural size of an added force
    period = min(max(np.exp(u(np.log(span / 60), np.log(span / 4))), 1.3 * v_rms / cut), span / 2)
    if mach.rotary:
        period = 2 * np.pi / max(1, round(2 * np.pi / period))
    cases = {
        "constant_force": (a, [], {f"force_{N}": 0}),
        "coulomb_asymmetry": (sign, [], {"asymmetry": 0}),
        "viscous": (level / v_rms, [], {f"viscous_error_{N}_s_per_{L}": 0}),
        "quadratic_drag": (level / v_rms ** 2 / 2, [], {f"drag_{N}_s2_per_{L}2": 0}),
        "stribeck": (2.0, [v_s, u(0.5, 2)], {"rise": 0, f"stribeck_speed_{L}_per_s": 1, "exponent": 2}),
        "frictional_lag": (2.0, [v_s, u(0.5, 2), np.exp(u(np.log(1e-3), np.log(0.05)))],
                           {"rise": 0, f"stribeck_speed_{L}_per_s": 1, "exponent": 2, "lag_s": 3}),
        "position_spring": (2.5 * a / span, [centre + u(-0.2, 0.2) * span], {f"stiffness_{N}_per_{L}": 0, f"zero_{L}": 1}),
        "position_force": (2 * a, [], {f"peak_{N}": 0}),
        "position_friction": (2.5 * sign, [], {"peak": 0}),
        "local_friction_spot": (3.0, [visited, span * u(0.03, 0.12)], {"rise": 0, f"place_{L}": 1, f"width_{L}": 2}),
        "periodic_force": (1.4 * a, [period, u(0, 6.28), rng.choice([0.0, u(0.2, 0.6)]), u(0, 6.28)],
                           {f"amplitude_{N}": 0, f"period_{L}": 1, "phase_rad": 2, "second_harmonic": 3, "phase2_rad": 4}),
        "periodic_friction": (1.4, [period, u(0, 6.28)], {"amplitude": 0, f"period_{L}": 1, "phase_rad": 2}),
        "encoder_error": (2 * xs, [max(period * u(0.2, 1), v_rms / cut), u(0, 6.28)],
                          {f"amplitude_{L}": 0, f"period_{L}": 1, "phase_rad": 2}),
        "backlash": (xs * 10, [u(0.2, 0.7), u(0.3, 0.8), 0, 0], {f"gap_{L}": 0, "load_share": 1, "motor_friction_share": 2,
                     f"contact_{N}_per_{L}": 3, f"contact_damping_{N}_s_per_{L}": 4}),
        "drive_compliance": (0.0, [u(0.2, 0.7), u(0.2, 0.9), 0, 0],
                             {f"compliance_{L}_per_{N}": 0, "load_share": 1, "motor_friction_share": 2,
                              f"joint_damping_{N}_s_per_{L}": 4}),
        "channel_delay": (20 * sign, [], {"effort_late_samples": 0}),
        "actuator_dead_zone": (1.3 * level, [rng.integers(0, 2)], {f"half_width_{N}": 0, "rejoins_the_line": 1}),
        "actuator_saturation": (4.0, [np.quantile(np.abs(clean_u), 0.999), 0], {f"limit_{N}": 7}),
        "load_dependent_friction": (1.5 / np.abs(clean_u).mean(), [], {f"rise_per_{F}": 0}),
        "thermal_drift": (2.0 * sign / max(np.ptp(temperature), 0.1), [temperature[0]], {"per_K": 0, "zero_C": 1}),
        "run_in": (2.0, [path * u(0.08, 0.4)], {"rise": 0, f"way_{L}": 1}),
        "dwell_aging": (1.0, [np.exp(u(np.log(0.02), np.log(0.5))), xs * u(1, 6)],
                        {"rise": 0, "time_s": 1, f"loss_way_{L}": 2}),
        "creep": (2.0, [], {"rate_per_s": 0}),
        "external_vibration": (1.4 * level, [min(np.exp(u(0, np.log(60))), 0.7 * cut), u(0, 6.28)],
                               {f"amplitude_{N}": 0, "frequency_Hz": 1, "phase_rad": 2}),
        "gravity": (1.5 * level, [u(-3, 3)], {f"amplitude_{N}": 0, "zero_rad": 1}),
        "cable_snap": (a, [centre, span * u(0.08, 0.2), u(0.01, 0.05)],
                       {f"force_{N}": 0, f"place_{L}": 1, f"half_width_{L}": 2, "snap_s": 3}),
        "eddy_brake": (1.2 * level, [v_rms * u(0.3, 0.8)], {f"peak_{N}": 0, f"peak_speed_{L}_per_s": 1}),
        "leaky_chamber": (4 * level / span, [u(0.1, 1.0)], {f"stiffness_{N}_per_{L}": 0, "leak_s": 1}),
        "lip_seal_flip": (2 * level, [span * u(0.05, 0.3), 0.01 * speed, 3 * xs],
                          {f"drag_{N}": 0, f"decay_{L}": 1, f"rise_{L}": 3}),
        "thixotropic_grease": (2 * level / v_rms, [u(2, 15), span * u(1, 10)],
                               {f"viscous_{N}_s_per_{L}": 0, "rebuild_s": 1, f"break_way_{L}": 2}),
        "sliding_cargo": (level, [mach.mass * u(0.2, 0.6), 0.005],
                          {f"hold_{N}": 0, "cargo_mass": 1, "regularisation_s": 2}),
        "gust_bursts": (2 * level, [], {f"rms_{N}": 0}),
        "squeeze_film": (2.0, [u(0.5, 5)], {"rise": 0, "time_s": 1}),
        "magnet_spot": (4.0, [visited, span * u(0.04, 0.12), v_rms * u(0.3, 0.8)],
                        {"rise": 0, f"place_{L}": 1, f"width_{L}": 2, f"speed_{L}_per_s": 3}),
        "grease_starvation": (2.0, [centre, span * u(0.3, 0.45), span * u(0.3, 3)],
                              {"rise": 0, f"centre_{L}": 1, f"half_band_{L}": 2, f"way_{L}": 3}),
        "supply_sag": (1.0, [np.mean(np.abs(clean_u * ref[:, 1])), u(0.05, 0.6)], {"sag": 0, "power_W": 1, "lag_s": 2}),
        "magnet_heating": (1.0, [clean_u.std(), len(ref) / fs * u(0.15, 0.6)], {"loss": 0, f"effort_{N}": 1, "lag_s": 2}),
        "amplifier_dropout": (2.0, [], {"loss": 0}),
        "payload_second_stroke": (mach.mass, [centre + 0.25 * span, centre], {"payload_mass": 0, f"pick_{L}": 1}),
    }
    start, rest, names = cases[name]
    p[1:1 + len(rest)] = rest
    low, high = 0.0, np.inf
    if name in ("coulomb_asymmetry", "position_friction", "periodic_friction"):
        high = 0.8
    elif name in ("stribeck", "frictional_lag", "run_in", "local_friction_spot", "magnet_spot", "squeeze_film"):
        high = 4.0
    elif name == "encoder_error":
        low, high = 1.5 * mach.tick, 0.4 * p[1] / (2 * np.pi)
    elif name in ("dwell_aging",):
        high = 1.5
    elif name in ("supply_sag", "magnet_heating", "amplifier_dropout"):
        high = 0.7
    elif name == "channel_delay":
        low, high = 0.7, 5.0
    elif name == "payload_second_stroke":
        high = 1.5 * mach.mass
    elif name == "creep":
        high = 20.0
    elif name == "actuator_saturation":     # start where the clean command loses 9 % of the friction
        size = np.abs(clean_u)
        limits = np.linspace(0.2, 1, 60) * p[1]
        lost = np.sqrt([np.mean(np.maximum(size - limit, 0) ** 2) for limit in limits])
        start, low, high = 10 * p[1] / limits[np.argmin(np.abs(lost - 0.09 * level))], 0.8, 20.0
    if name in ("backlash", "drive_compliance"):
        m2 = p[1] * mach.mass
        reduced = m2 * (1 - p[1])
        if name == "backlash":
            rate = 2 * np.pi * u(120, 350)
            p[3], p[4] = rate ** 2 * reduced, 2 * u(0.15, 0.4) * rate * reduced
            low, high = 2 * mach.tick, 0.1 * span
        else:
            low, high = (1 / (reduced * (2 * np.pi * f) ** 2) for f in (150, 8))
            start = 10 * np.sqrt(low * high)
            p[4] = 2 * u(0.01, 0.05) * np.sqrt(reduced / np.sqrt(low * high))
    if name in ("position_force", "position_friction"):
        table = _smooth_table(rng)
    elif name == "gust_bursts":
        wave = _bursts(rng, len(ref), fs, 0.2, min(8.0, 0.5 * cut))
    elif name == "amplifier_dropout":
        wave = _drops(rng, len(ref), fs)
    return Effect(name, p, 0.1 * start, low, high, names, table, wave)
