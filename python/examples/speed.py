"""How long a preslide.Model takes for a sample from Python, and in Rust: `python python/examples/speed.py`, from the repository."""

import pathlib
import subprocess
import tempfile
import time

import numpy as np

import preslide

SAMPLES, STEP = 1_000_000, 1e-4
#: Of them, ticks that are stepped one by one.
TICKS = 200_000
#: Four blocks, as `identify` recommends for a ball screw.
MODEL = """schema = "preslide.model/1"
motion = "linear"
inertia = { mass_kg = 95.0 }

[friction]
kind = "gms"
breakaway_N = 20.0
viscous_N_s_per_m = 200.0
blocks = [
  { stiffness_N_per_m = 4e5, weight = 0.4 },
  { stiffness_N_per_m = 1e5, weight = 0.3 },
  { stiffness_N_per_m = 2e4, weight = 0.2 },
  { stiffness_N_per_m = 5e3, weight = 0.1 },
]
"""


def best(run, samples):
    """Nanoseconds a sample, the best of five."""
    times = []
    for _ in range(5):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return 1e9 * min(times) / samples


t = np.arange(SAMPLES) * STEP
x, v, a = 0.02 * np.sin(2.1 * t), 0.042 * np.cos(2.1 * t), -0.0882 * np.sin(2.1 * t)
model = preslide.Model(MODEL)
python = best(lambda: model.force(t, x, v, a), SAMPLES)
now = [column[:TICKS].tolist() for column in (x, v, a)]


def ticks(step):
    for one in zip(*now):
        step(*one)


stepped = best(lambda: ticks(model.stepper(1 / STEP).step), TICKS)
nothing = best(lambda: ticks(lambda x, v, a: x), TICKS)
with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "model.toml"
    model.save(file)
    command = ["cargo", "run", "--quiet", "--release", "--example", "model_speed", "--", str(file), str(SAMPLES)]
    rust, tick = map(float, subprocess.run(command, check=True, capture_output=True, text=True).stdout.split())
print(f"{SAMPLES} samples, four blocks: Python {python:.1f} ns a sample, Rust {rust:.1f} ns, {python / rust:.2f} times")
print(f"a tick at a time: Python {stepped:.1f} ns a call, of which a loop with an empty function takes {nothing:.1f} ns; Rust {tick:.1f} ns")
