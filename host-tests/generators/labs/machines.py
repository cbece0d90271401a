"""Draws of machines: sizes, friction law, controller, encoder, motion."""
import numpy as np

from friction import Law
from motions import MOTIONS, WITH_DWELL, reference

# name: rotary, mass, acceleration force over friction, pre-sliding way, travel, speed, acceleration, tick, bandwidth Hz
KINDS = {
    "ball_screw": (False, (5, 300), (0.2, 5), (2e-6, 3e-5), (0.1, 0.8), (0.02, 0.5), (0.3, 8), (1e-8, 1e-6), (12, 50)),
    "linear_motor": (False, (1, 50), (0.3, 8), (1e-6, 3e-5), (0.05, 0.5), (0.05, 1), (1, 15), (1e-9, 1e-7), (25, 90)),
    "nano_stage": (False, (0.3, 5), (0.02, 0.5), (3e-7, 8e-6), (1e-3, 2e-2), (5e-4, 2e-2), (0.02, 0.5), (1e-10, 3e-9), (30, 90)),
    "belt": (False, (1, 30), (0.3, 5), (2e-5, 3e-4), (0.2, 1), (0.1, 1.5), (1, 10), (1e-6, 1e-5), (7, 20)),
    "cylinder": (False, (2, 50), (0.05, 2), (2e-5, 3e-4), (0.05, 0.4), (0.02, 0.5), (0.3, 5), (2e-7, 5e-6), (6, 18)),
    "pump_spindle": (False, (0.5, 10), (0.005, 0.2), (3e-6, 5e-5), (0.02, 0.1), (5e-4, 2e-2), (0.02, 0.3), (5e-8, 1e-6), (8, 25)),
    "geared_joint": (True, (0.01, 20), (0.2, 4), (1e-4, 3e-3), (0.5, 4), (0.1, 2), (1, 15), (3e-6, 8e-5), (7, 22)),
    "direct_table": (True, (0.01, 5), (0.3, 8), (2e-5, 5e-4), (0.5, 6), (0.2, 6), (2, 40), (3e-7, 1e-5), (15, 55)),
    "gimbal": (True, (0.005, 1), (0.2, 5), (1e-4, 3e-3), (0.2, 1.5), (0.1, 3), (1, 20), (1e-6, 2e-5), (10, 40)),
}
RATES = np.array([200, 250, 400, 500, 800, 1000, 1600, 2000])


def spread(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


class Machine:
    """A drawn machine with its reference motion; `ok` is False where the draw does not fit together."""

    def __init__(self, rng):
        self.kind = str(rng.choice(list(KINDS)))
        self.rotary, *spans = KINDS[self.kind]
        self.mass, ratio, self.distance, travel, self.speed, self.acc, tick, self.bandwidth = (
            spread(rng, *span) for span in spans)
        self.half = travel / 2
        self.half = min(self.half, self.speed * rng.uniform(0.3, 1.2))
        self.acc = max(self.acc, 2 * self.speed ** 2 / self.half, 2 * self.speed)
        if self.kind == "nano_stage":
            self.level = spread(rng, 0.3, 3)
        else:
            self.level = self.mass * self.acc / ratio
        self.law = Law(rng, self.level, self.distance, self.mass, self.speed)
        self.viscous = 0.0 if rng.uniform() < 0.15 else self.level / self.speed * spread(rng, 0.02, 0.5)
        self.fs = float(RATES[min(len(RATES) - 1, np.searchsorted(RATES, 22 * self.bandwidth) + int(rng.integers(0, 2)))])
        self.cutoff = min(2 * self.bandwidth, self.fs / 6)
        self.with_base = False
        self.draw_control(rng, tick)
        self.motion = str(rng.choice(MOTIONS))
        self.dwells = self.motion in WITH_DWELL
        self.nsub = 2 * int(np.ceil(0.5 * max(4, self.law.max_rate(self.mass) / self.fs / 0.1, 6000 / self.fs)))
        cost = self.nsub * (self.law.k.size + 4) * self.fs
        time = min(spread(rng, 22, 150), spread(rng, 2e4, 1.15e5) / self.fs, max(20.0, 2e7 / cost))
        made = reference(rng, self.motion, self.half, self.speed, self.acc, self.distance, self.fs, time,
                         spread(rng, 0.02, 0.06) + 0.3 / self.bandwidth)
        self.ok = made is not None and self.nsub <= 60 and cost * len(made[0]) / self.fs < 4e7
        if self.ok:
            self.ref, self.production = made
            self.ref[:, 0] += rng.choice([0.0, rng.uniform(-0.2, 0.2) * self.half])
            n = len(self.ref)
            self.noise = rng.normal(size=(n, 6))
            t = np.arange(n) / self.fs / (n / self.fs)
            self.temperature = (rng.uniform(18, 28) + rng.uniform(2, 15) * (1 - np.exp(-t * rng.uniform(1, 4)))
                                + rng.uniform(0, 0.6) * np.sin(2 * np.pi * (t * rng.uniform(1, 4) + rng.uniform())))

    def draw_control(self, rng, tick):
        omega = 2 * np.pi * self.bandwidth / 1.6
        w_filter = min(6 * omega, 1.5 * self.fs)
        self.control = str(rng.choice(["pid", "cascade"]))
        if self.control == "pid":
            zeta = rng.uniform(0.7, 1.0)
            kp, kd, ki = omega ** 2, 2 * zeta * omega, omega ** 3 * rng.uniform(0.05, 0.25)
        else:                       # position P around speed PI
            k_speed, k_place = 1.6 * omega, 0.45 * omega
            w_int = 0.2 * omega
            kp, kd, ki = k_speed * (k_place + w_int), k_speed, k_speed * k_place * w_int
        self.n_tick = rng.uniform(0.3, 1.5)
        self.tick = min(tick, self.distance / 3, 0.08 * self.level / (self.mass * kd * w_filter * (0.3 + self.n_tick)))
        self.gains = np.array([kp, kd, ki, w_filter, rng.uniform(0.9, 1.05),
                               rng.choice([0.0, rng.uniform(0.4, 0.9)]) * self.level, 0.05 * self.speed,
                               rng.uniform(0.5, 1) * self.viscous])
        self.sensed = bool(rng.uniform() < 0.5)
        self.sensor_noise = self.level * spread(rng, 2e-3, 1e-2) if self.sensed else 0.0
        self.wander, self.white = (0.0, 0.0) if rng.uniform() < 0.15 else (spread(rng, 5e-4, 5e-3), spread(rng, 5e-4, 5e-3))
        if self.law.name == "lugre":     # its micro-damping would turn level noise into force spikes
            self.white *= 0.1
        self.wander_way = self.half * spread(rng, 0.02, 0.3)

    def plant(self):
        return np.array([self.mass, self.viscous, 1 / self.fs, self.tick, self.n_tick, self.wander, self.wander_way,
                         self.white])

    def labels(self):
        n, length = ("Nm", "rad") if self.rotary else ("N", "m")
        out = {"inertia_kg_m2" if self.rotary else "mass_kg": self.mass, "viscous": self.viscous,
               f"coulomb_{n}": self.level, f"presliding_{length}": self.distance,
               f"elements_{n}_per_{length}": self.law.k.tolist(), f"element_limits_{n}": self.law.w.tolist(),
               "bandwidth_Hz": self.bandwidth, "control": self.control, "production_cycle": self.production,
               f"encoder_tick_{length}": self.tick, "encoder_noise_ticks": self.n_tick,
               f"effort_sensor_noise_{n}": self.sensor_noise, "friction_wander": self.wander,
               "friction_white_noise": self.white, f"wander_way_{length}": self.wander_way, "steps_per_sample": self.nsub}
        return out | self.law.params
