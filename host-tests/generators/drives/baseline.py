"""The machine's model as a commissioning engineer would keep it: base.toml.

Elastic-sliding blocks are fitted by non-negative least squares to loops of the
machine's own law at amplitudes from below to far above its presliding distance.
"""

import math

import numpy as np

import laws
from machines import sig


def loops(xs, rng):
    """A path of sines with growing and falling amplitudes, and its velocity."""
    sizes = xs * np.array([0.3, 0.8, 2.0, 5.0, 14.0, 4.0, 1.2, 0.5, 9.0])
    sizes *= np.exp(rng.normal(0, 0.1, sizes.size))
    n = 500
    x, dt = [np.zeros(1)], 1.0 / n
    for a in sizes:
        ph = np.arange(1, 2 * n + 1) * 2 * math.pi * dt
        x.append(x[-1][-1] * np.cos(ph / 4) * (ph < 2 * math.pi) * (np.cos(ph / 4) > 0) + a * np.sin(ph))
    x = np.concatenate(x)
    # resample so that no step is long against the presliding distance
    s = np.concatenate([[0], np.cumsum(np.abs(np.diff(x)))])
    m = int(s[-1] / (0.04 * xs))
    u = np.linspace(0, s[-1], m)
    x = np.interp(u, s, x)
    # unhurried: micro damping and speed play no role
    dt = 1e-2
    return x, np.gradient(x, dt), dt


def nnls(a, b):
    """Non-negative least squares, active set."""
    g, h = a.T @ a, a.T @ b
    n = h.size
    w = np.zeros(n)
    free = np.zeros(n, dtype=bool)
    for _ in range(20 * n):
        grad = h - g @ w
        cand = np.where(free, -np.inf, grad)
        j = int(np.argmax(cand))
        if cand[j] < 1e-9 * abs(h).max():
            break
        free[j] = True
        while True:
            idx = np.where(free)[0]
            s = np.linalg.lstsq(g[np.ix_(idx, idx)], h[idx], rcond=None)[0]
            if (s > 0).all():
                w[:] = 0
                w[idx] = s
                break
            old = w[idx]
            neg = s <= 0
            t = np.min(old[neg] / (old[neg] - s[neg] + 1e-300))
            w[idx] = old + t * (s - old)
            free[idx[w[idx] <= 1e-12]] = False
            w[~free] = 0
    return w


def fit(m, rng):
    """Blocks (stiffness, weight), breakaway, and the fit's relative rms error."""
    x, v, dt = loops(m["xs"], rng)
    f = laws.walk(m["code"], m["lawp"], m["bw"], m["bd"], x, v, dt)
    d = m["xs"] * np.exp(np.linspace(math.log(0.06), math.log(9.0), int(rng.integers(7, 12))))
    if m["law"] == "coulomb_spring":
        d = m["xs"] * np.array([0.5, 0.75, 1.0, 1.3, 2.0])
    cols = np.zeros((x.size, d.size))
    p = np.zeros(8)
    p[4] = 1
    one = np.zeros(laws.NB)
    one[0] = 1.0
    for j, q in enumerate(d):
        yd = np.ones(laws.NB)
        yd[0] = q
        cols[:, j] = laws.walk(9, p, one, yd, x, v, dt)
    w = nnls(cols, f)
    err = float(np.sqrt(np.mean((cols @ w - f) ** 2)) / np.std(f))
    keep = w > 0.004 * w.sum()
    w, d = w[keep], d[keep]
    total = float(w.sum()) * m["level"]
    return w / w.sum() * 1.0, total * (w / w.sum()) / d, total, err


def along(m, w, k, total, x, tick):
    """RMS of blocks minus law along a machine's own run, as a force."""
    v = np.gradient(x, tick)
    law = laws.walk(m["code"], m["lawp"], m["bw"], m["bd"], x, v, tick)
    p = np.zeros(8)
    p[4] = w.size
    bw, bd = np.zeros(laws.NB), np.ones(laws.NB)
    bw[: w.size], bd[: w.size] = w * total / m["level"], w * total / k
    blocks = laws.walk(9, p, bw, bd, x, v, tick)
    return m["level"] * float(np.sqrt(np.mean((law - blocks) ** 2)))


def text(m, rng, x, tick):
    """base.toml of this machine, the fit's error, and its error along x as a force."""
    w, k, total, err = fit(m, rng)
    rest = along(m, w, k, total, x, tick)
    rot = m["rotary"]
    fu, su, vu = ("Nm", "Nm_per_rad", "Nm_s_per_rad") if rot else ("N", "N_per_m", "N_s_per_m")
    lu = "rad" if rot else "m"
    mass = m["mass"] * (1 + rng.normal(0, 0.008))
    w = [sig(q) for q in w]
    w[int(np.argmax(w))] += 1.0 - sum(w)
    blocks = [
        f"  {{ stiffness_{su} = {sig(q, 6):.6g}, weight = {b:.4g} }}," for q, b in zip(k, w, strict=True)
    ]
    lines = ['schema = "preslide.model/1"', f'motion = "{"rotary" if rot else "linear"}"', "", "[inertia]"]
    lines += [
        f"inertia_kg_m2 = {mass:.5g}" if rot else f"mass_kg = {mass:.5g}",
        "",
        "[friction]",
        'kind = "gms"',
    ]
    lines += [
        f"breakaway_{fu} = {total:.5g}",
        "blocks = [",
        *blocks,
        "]",
        f"viscous_{vu} = {float(m['viscous']):.6g}",
    ]
    mech = []
    if m["kind"] in ("ball_screw_table", "lead_screw_nut"):
        mech.append(f"screw_lead_m = {m['lead']:.6g}")
    if rng.random() < 0.8:
        mech.append(f"motor_period_{lu} = {m['lead'] / m['poles']:.6g}")
    if rng.random() < 0.6:
        mech.append(f"encoder_period_{lu} = {m['grating']:.6g}")
    if rng.random() < 0.8:
        mech.append(f"encoder_count_{lu} = {m['count']:.4g}")
    if mech:
        lines += ["", "[mechanics]", *mech]
    out = "\n".join(lines) + "\n"
    return fix_floats(out), err, rest


def fix_floats(s):
    """TOML wants a point or an exponent in a float: 5 becomes 5.0."""
    out = []
    for line in s.splitlines():
        for key in ("= ",):
            parts = line.split(key)
            for i in range(1, len(parts)):
                num = parts[i].split(",")[0].split(" ")[0]
                if num and num.lstrip("-").isdigit():
                    parts[i] = num + ".0" + parts[i][len(num) :]
            line = key.join(parts)
        out.append(line)
    return "\n".join(out) + "\n"
