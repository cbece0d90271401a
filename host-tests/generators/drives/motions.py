"""Reference motions, as an application or a commissioning engineer programs them.

A `Plan` appends pieces to a position profile at the controller's tick; the
pieces join at rest.  Velocity and acceleration are differences of the profile.
"""

import numpy as np

KINDS = ["trap", "scurve", "random", "sines", "chirp", "multisine", "jog", "scan", "steps"]
VARIED = ["random", "sines", "chirp", "multisine", "jog"]
LONG = ["trap", "scurve", "random", "jog"]
HARD = ["random", "sines", "chirp", "multisine"]


class Plan:
    def __init__(self, tick, x0):
        self.tick, self.x = tick, x0
        self.parts, self.seg, self.rep = [], [], []
        self.cur_seg, self.cur_rep, self.n = 0, 0, 0

    def add(self, arr):
        self.parts.append(arr)
        self.seg.append(np.full(arr.size, self.cur_seg))
        self.rep.append(np.full(arr.size, self.cur_rep))
        self.n += arr.size
        if arr.size:
            self.x = float(arr[-1])

    @property
    def time(self):
        return self.n * self.tick

    def dwell(self, t):
        self.add(np.full(max(1, int(t / self.tick)), self.x))

    def move(self, target, v, a):
        d = target - self.x
        s, d = np.sign(d), abs(d)
        if d <= 0:
            return
        if v * v / a > d:
            v = np.sqrt(a * d)
        ta, tc = v / a, d / v - v / a
        t = np.arange(1, int((2 * ta + tc) / self.tick) + 2) * self.tick
        y = np.where(
            t < ta,
            0.5 * a * t * t,
            np.where(t < ta + tc, v * (t - 0.5 * ta), d - 0.5 * a * np.maximum(2 * ta + tc - t, 0) ** 2),
        )
        y[-1] = d
        self.add(self.x + s * y)

    def wave(self, t, y, fade):
        w = np.clip(np.minimum(t, t[-1] - t) / fade, 0, 1)
        self.add(self.x + y * (w * w * (3 - 2 * w)))


def freq_for(rng, amp, v, a, f_max):
    """A frequency at which this amplitude stays within speed, acceleration and the loop's band."""
    w = min(v / amp, np.sqrt(a / amp), 2 * np.pi * f_max)
    return w * rng.uniform(0.45, 1.0) / (2 * np.pi)


def piece(kind, plan, rng, m, until):
    """Append pieces of one kind until the time is used up."""
    lo, hi, v, a = m["lo"], m["hi"], m["v"], m["a"]
    stroke, mid = hi - lo, 0.5 * (hi + lo)
    ends = (lo + stroke * rng.uniform(0, 0.15), hi - stroke * rng.uniform(0, 0.15))
    vv = v * rng.uniform(0.5, 1.0)
    pause = rng.uniform(0.0, 0.5) if rng.random() < 0.7 else 0.0
    if kind in ("sines", "chirp", "multisine") and abs(plan.x - mid) > 0.05 * stroke:
        plan.move(mid + rng.uniform(-0.05, 0.05) * stroke, vv, a)
        plan.dwell(0.2)
    while plan.time < until:
        left = until - plan.time
        if kind in ("trap", "scurve"):
            for e in ends:
                plan.move(e, vv, a)
                plan.dwell(pause + 1e-6)
        elif kind == "random":
            size = stroke * np.exp(rng.uniform(np.log(0.02), 0.0))
            to = plan.x + size * (1 if rng.random() < 0.5 else -1)
            if not lo <= to <= hi:
                to = rng.uniform(lo, hi)
            sp = max(v * np.exp(rng.uniform(np.log(0.06), 0.0)), abs(to - plan.x) / rng.uniform(0.8, 3.5))
            plan.move(to, min(sp, v), a * rng.uniform(0.4, 1.0))
            plan.dwell(rng.exponential(0.12) + 0.01)
        elif kind == "sines":
            amp = 0.42 * stroke * np.exp(rng.uniform(np.log(0.01), 0.0))
            f = freq_for(rng, amp, v, a, m["f_max"])
            dur = min(max(6 / f, 2.0), max(left, 2 / f), 14.0)
            t = np.arange(1, int(dur / plan.tick)) * plan.tick
            plan.wave(t, amp * np.sin(2 * np.pi * f * t), min(1.5 / f, dur / 4))
        elif kind == "chirp":
            amp = 0.3 * stroke * np.exp(rng.uniform(np.log(0.03), 0.0))
            f1 = freq_for(rng, amp, v, a, m["f_max"])
            f0 = f1 * rng.uniform(0.03, 0.2)
            dur = min(max(left, 4.0), 25.0)
            t = np.arange(1, int(dur / plan.tick)) * plan.tick
            ph = 2 * np.pi * f0 * dur / np.log(f1 / f0) * (np.exp(t / dur * np.log(f1 / f0)) - 1)
            plan.wave(t, amp * np.sin(ph), min(1.0, dur / 6))
        elif kind == "multisine":
            n = int(rng.integers(3, 8))
            amp = 0.35 * stroke * np.exp(rng.uniform(np.log(0.05), 0.0)) / np.sqrt(n)
            f1 = freq_for(rng, amp * np.sqrt(n), v, a, m["f_max"])
            fr = f1 * np.sort(rng.uniform(0.1, 1.3, n))
            dur = min(max(left, 3.0), 20.0)
            t = np.arange(1, int(dur / plan.tick)) * plan.tick
            y = sum(
                amp * (0.5 + 0.5 * fr[0] / f) * np.sin(2 * np.pi * f * t + rng.uniform(0, 6.28)) for f in fr
            )
            plan.wave(t, y, min(1.0, dur / 6))
        elif kind == "jog":
            for sp in np.exp(np.linspace(np.log(0.08), 0.0, int(rng.integers(4, 8)))):
                d = min(stroke, max(0.05 * stroke, sp * v * rng.uniform(1.0, 2.2)))
                to = mid + 0.5 * d * (1 if plan.x < mid else -1)
                plan.move(to, sp * v, a)
                plan.dwell(0.15)
                plan.cur_rep += 1
                plan.move(2 * mid - to, sp * v, a)
                plan.dwell(0.15)
                if plan.time > until:
                    break
        elif kind == "scan":
            sv = v * np.exp(rng.uniform(np.log(0.03), np.log(0.25)))
            inner = min(0.12 * stroke, m["xs"] * np.exp(rng.uniform(np.log(1.0), np.log(60.0))))
            s = 1.0 if plan.x < mid else -1.0
            run = min(0.3 * stroke, sv * rng.uniform(0.4, 1.5))
            plan.move(np.clip(plan.x + s * run, lo, hi), sv, a)
            iv = min(sv, inner * rng.uniform(2.0, 8.0))
            plan.move(plan.x - s * inner, iv, a)
            if rng.random() < 0.4:
                plan.move(plan.x + s * inner * 0.5, iv, a)
                plan.move(plan.x - s * inner * 0.4, iv, a)
            if rng.random() < 0.25:
                plan.move(np.clip(mid + rng.uniform(-0.4, 0.4) * stroke, lo, hi), vv, a)
        else:  # steps
            size = max(m["xs"] * 2.0, stroke * 0.004) * np.exp(rng.uniform(0, np.log(12.0)))
            n = int(rng.integers(3, 9))
            s = 1.0 if plan.x < mid else -1.0
            for _ in range(n):
                plan.move(np.clip(plan.x + s * size, lo, hi), v, a)
                plan.dwell(rng.uniform(0.1, 0.4))
        plan.cur_rep += 1


def smooth(x, n):
    if n < 2:
        return x
    y = np.concatenate([np.full(n, x[0]), x, np.full(n, x[-1])])
    c = np.cumsum(y)
    y = (c[n:] - c[:-n]) / n
    return y[n // 2 : n // 2 + x.size]


def reference(rng, m, tick, seconds, kinds):
    """Rows: position, velocity, acceleration, force; and (segment, repeat)."""
    n = int(round(seconds / tick))
    plan = Plan(tick, m["lo"] + (m["hi"] - m["lo"]) * rng.uniform(0.3, 0.6))
    plan.dwell(rng.uniform(0.2, 0.8))
    cut = np.cumsum(rng.dirichlet(np.full(len(kinds), 6.0))) * seconds
    for kind, until in zip(kinds, cut, strict=True):
        plan.cur_seg += 1
        plan.cur_rep = 0
        piece(kind, plan, rng, m, until)
    plan.dwell(0.5)
    if plan.n < n:
        plan.dwell((n - plan.n) * tick)
    x = np.concatenate(plan.parts)
    gain = rng.uniform(0.3, 0.8) if "scurve" in kinds else rng.uniform(0.02, 0.12)
    soft = gain * m["v"] / m["a"]
    x = smooth(smooth(x, int(min(soft, 0.15) / tick)), int(min(soft, 0.1) / tick / 3))[: n + 2]
    x = np.concatenate([x, np.full(max(0, n + 2 - x.size), x[-1])])
    ref = np.zeros((4, n))
    ref[0] = x[:n]
    v = np.gradient(x, tick)
    ref[1] = v[:n]
    ref[2] = np.gradient(v, tick)[:n]
    pad = lambda q: np.resize(np.concatenate(q), n) if plan.n < n else np.concatenate(q)[:n]  # noqa: E731
    return ref, pad(plan.seg), pad(plan.rep)


def spinning(rng, m, tick, seconds):
    """Speed programme of a spindle: levels, ramps, overrides, now and then the other way."""
    n = int(round(seconds / tick))
    v = np.zeros(n)
    seg = np.zeros(n, dtype=int)
    i, cur, sgn, k = int(0.5 / tick), 0.0, rng.choice([-1.0, 1.0]), 0
    while i < n:
        k += 1
        if rng.random() < 0.22:
            sgn = -sgn
        to = sgn * m["v"] * np.exp(rng.uniform(np.log(0.08), 0.0))
        if rng.random() < 0.1:
            to = 0.0
        a = m["a"] * rng.uniform(0.4, 1.0)
        r = max(1, int(abs(to - cur) / a / tick))
        h = int(rng.uniform(0.4, 2.5) / tick)
        e = min(n, i + r)
        v[i:e] = cur + (to - cur) * np.arange(1, r + 1)[: e - i] / r
        e2 = min(n, e + h)
        v[e:e2] = to
        if rng.random() < 0.35:
            f = rng.uniform(0.5, 3.0)
            t = np.arange(e2 - e) * tick
            w = min(0.3 * abs(to), 0.6 * m["a"] / (2 * np.pi * f))
            v[e:e2] += (
                w
                * np.sin(2 * np.pi * f * t)
                * np.clip(t / 0.2, 0, 1)
                * np.clip((t[-1] - t if t.size else t) / 0.2, 0, 1)
            )
        seg[i:e2] = k
        i, cur = e2, to
    v = smooth(v, int(0.02 / tick))
    ref = np.zeros((4, n))
    ref[0] = np.cumsum(v) * tick
    ref[1] = v
    ref[2] = np.gradient(v, tick)
    return ref, seg, np.zeros(n, dtype=int)


def pushing(rng, m, tick, seconds, level):
    """Force programme for open loop: sines and multisines around the friction level."""
    n = int(round(seconds / tick))
    u = np.zeros(n)
    seg = np.zeros(n, dtype=int)
    i, k = int(0.4 / tick), 0
    f_lo = 0.35 * np.sqrt(m["a"] / (0.4 * (m["hi"] - m["lo"]))) / (2 * np.pi)
    while i < n:
        k += 1
        dur = rng.uniform(4.0, 12.0)
        e = min(n, i + int(dur / tick))
        t = np.arange(e - i) * tick
        amp = level * np.exp(rng.uniform(np.log(0.5), np.log(3.0)))
        f0 = min(max(f_lo * np.exp(rng.uniform(0.7, 2.5)), 1.5 / dur), 0.4 * m["f_max"])
        y = np.sin(2 * np.pi * f0 * t)
        if rng.random() < 0.6:
            for _ in range(int(rng.integers(1, 5))):
                y += rng.uniform(0.2, 0.7) * np.sin(
                    2 * np.pi * f0 * rng.uniform(0.6, 4.0) * t + rng.uniform(0, 6.28)
                )
            y /= 1.3
        w = np.clip(np.minimum(t, t[-1] - t + tick) / 0.4, 0, 1)
        u[i:e] = amp * y * w
        seg[i:e] = k
        i = e
    ref = np.zeros((4, n))
    ref[3] = u
    return ref, seg, np.zeros(n, dtype=int)
