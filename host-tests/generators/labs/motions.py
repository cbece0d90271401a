"""Reference motions as used in practice: each repeats a pattern, exactly only as a production cycle."""
import numpy as np

MOTIONS = ["point_to_point", "raster", "sines", "chirp", "random", "triangles", "speed_passes", "nested"]
WITH_DWELL = {"point_to_point", "speed_passes", "nested"}


def move(distance, speed, acc, fs):
    """Samples of a trapezoidal move from 0 to distance (first sample left out)."""
    size = abs(distance)
    if size == 0:
        return np.zeros(0)
    speed = min(speed, np.sqrt(size * acc))
    total = size / speed + speed / acc
    t = (np.arange(max(4, int(np.ceil(total * fs)))) + 0.5) / fs
    way = np.cumsum(np.clip(np.minimum(np.minimum(acc * t, speed), acc * (total - t)), 0, None))
    return distance * way / way[-1]


def chain(points, speeds, dwells, acc, fs):
    """Moves through the points, starting and ending at 0."""
    out, here = [], 0.0
    for point, speed, dwell in zip(list(points) + [0.0], list(speeds) + [speeds[-1]], list(dwells) + [0.0]):
        way = move(point - here, speed, acc, fs)
        out += [here + way, np.full(int(dwell * fs), point)]
        here = point
    return np.concatenate(out)


def _plan(rng, kind, half, speed, acc, tiny):
    """Draw the numbers of a pattern (what stays the same from one repetition to the next)."""
    n = int(rng.integers(4, 9))
    plan = dict(points=rng.uniform(-1, 1, n) * half, speeds=speed * rng.uniform(0.15, 1, n),
                dwells=rng.uniform(0.15, 1.5, n))
    if kind == "raster":
        way = half * rng.uniform(0.3, 1)
        plan = dict(points=way * np.tile([1, -1], 3), speeds=np.full(6, speed * rng.uniform(0.3, 1)),
                    dwells=np.zeros(6))
    elif kind == "triangles":
        size = half * np.exp(rng.uniform(np.log(0.08), 0, 4))
        plan = dict(points=np.concatenate([[s, -s, s, -s] for s in size]),
                    speeds=np.repeat(speed * rng.uniform(0.2, 1, 4), 4), dwells=np.zeros(16))
    elif kind == "speed_passes":
        speeds = speed * np.exp(rng.uniform(np.log(0.04), 0, 7))
        way = np.repeat(np.minimum(half, np.minimum(0.6 * np.median(speeds), 1.5 * speeds)), 2)
        plan = dict(points=way * np.tile([1, -1], 7), speeds=np.repeat(speeds, 2),
                    dwells=np.repeat(rng.uniform(0, 0.6, 7), 2))
    elif kind == "nested":
        points, speeds = [], []
        for centre in rng.uniform(-1, 1, 3) * half:
            sizes = tiny * np.geomspace(rng.uniform(10, 60), rng.uniform(0.3, 2), 5)
            points += [centre] + [centre + s * sign for s in sizes for sign in (-1, 1)]
            speeds += [speed] + [max(6 * s, speed / 300) for s in sizes for _ in range(2)]
        plan = dict(points=np.array(points), speeds=np.array(speeds), dwells=rng.uniform(0.05, 0.25, len(points)))
    elif kind == "sines":
        size = half * np.exp(rng.uniform(np.log(0.03), 0, 4))
        top = np.minimum(speed / size, np.sqrt(acc / size))
        plan = dict(size=size, omega=np.minimum(top * rng.uniform(0.4, 1, 4), 40.0))
    elif kind == "chirp":
        size = half * rng.uniform(0.3, 1)
        top = min(speed / (0.15 * size), np.sqrt(acc / (0.15 * size)), 60.0)
        plan = dict(size=size, low=top * rng.uniform(0.03, 0.1), high=top, time=rng.uniform(8, 20))
    return plan


def _waves(rng, kind, plan, vary, speed, acc, fs):
    """One repetition of the sine or chirp pattern."""
    if kind == "chirp":
        n = int(plan["time"] * fs)
        s = np.sin(np.pi * np.arange(n) / n) ** 2          # up and down again
        omega = plan["low"] * (plan["high"] / plan["low"]) ** s
        size = np.minimum(np.minimum(plan["size"], 0.8 * speed / omega), 0.8 * acc / omega ** 2)
        drift = 1 + 0.15 * np.sin(2 * np.pi * (rng.uniform() + np.arange(n) / n))
        return size * drift * np.sin(np.cumsum(omega) / fs) * np.clip(10 * np.sin(np.pi * np.arange(n) / n), 0, 1)
    out = []
    for size, omega in zip(plan["size"], plan["omega"]):
        n = int(6 * 2 * np.pi / omega * fs)
        cycle = 6 * np.arange(n) / n
        out.append(size * (1 + vary * rng.normal()) * np.sin(2 * np.pi * cycle) * np.clip(np.minimum(cycle, 6 - cycle), 0, 1))
    return np.concatenate(out)


def _random(rng, n, fs, half, speed, acc):
    """A pattern of band-limited noise, three times, each with a part of its own."""
    third = n // 3
    f = np.fft.rfftfreq(third, 1 / fs)
    band = min(speed / half, np.sqrt(acc / half)) / (2 * np.pi) * rng.uniform(2, 8)
    band = max(band, 10 * fs / third)
    shape = (f > 0) * np.exp(-(f / band) ** 2)

    def noise():
        y = np.fft.irfft(shape * (rng.normal(size=f.size) + 1j * rng.normal(size=f.size)), third)
        return y / np.abs(y).max()
    common = noise()
    x = np.concatenate([common + 0.2 * noise() * np.clip(np.minimum(np.arange(third), np.arange(third)[::-1]) / fs, 0, 1)
                        for _ in range(3)])
    dt = 1 / fs
    rate = np.gradient(x, dt)
    return x * min(half, speed / np.abs(rate).max(), acc / np.abs(np.gradient(rate, dt)).max())


def reference(rng, kind, half, speed, acc, tiny, fs, time, smooth_time):
    """Reference (position, speed, acceleration), or None where the pattern does not fit into 120,000 rows."""
    production = rng.uniform() < 0.3
    if kind == "random":
        x = _random(rng, int(time * fs), fs, half, speed, acc)
        x *= np.clip(np.minimum(np.arange(x.size), np.arange(x.size)[::-1]) / fs, 0, 1)
    else:
        plan, vary = _plan(rng, kind, half, speed, acc, tiny), 0.0 if production else 0.04
        x = np.zeros(int(0.5 * fs))
        repeats = 0
        while repeats < 2 or (repeats < 3 and x.size < 60 * fs) or x.size < time * fs:
            if kind in ("sines", "chirp"):
                part = _waves(rng, kind, plan, vary, speed, acc, fs)
            else:
                n = len(plan["points"])
                points = plan["points"] * (1 + vary * rng.normal()) + 0.1 * vary * half * rng.normal()
                part = chain(points, plan["speeds"] * (1 + vary * rng.normal(size=n)).clip(0.8, 1.2),
                             plan["dwells"] * (1 + 3 * vary * rng.normal(size=n)).clip(0.6, 1.4), acc, fs)
            x = np.concatenate([x, part])
            repeats += 1
            if x.size > 120_000:
                return None
    if x.size > 180 * fs or x.size < 20 * fs:
        return None
    width = 2 * int(smooth_time * fs / 2) + 3
    kernel = np.hanning(width + 2)[1:-1]
    x = np.convolve(np.pad(x, width, mode="edge"), kernel / kernel.sum(), "same")[width:-width]
    v = np.gradient(x, 1 / fs)
    return np.column_stack([x, v, np.gradient(v, 1 / fs)]), production
