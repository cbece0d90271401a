"""Hysteretic friction laws, normalised: force in units of the sliding level.

Every law advances its own state along a displacement and gives a force whose
sliding limit is `level` (1 is the nominal machine).  The presliding stiffness
does not change with the level, as with a real junction.  The laws that have a
closed solution along the path use it, the others are stepped finely.
"""

import math

import numpy as np
from numba import njit

NAMES = [
    "gms",
    "iwan",
    "lugre",
    "lugre_s1",
    "dahl",
    "elastoplastic",
    "leuven",
    "bouc_wen",
    "coulomb_tanh",
    "coulomb_spring",
]
NB = 24  # room for states


@njit
def micro(p, dz, v, dt):
    """Damping of the junction, which fades as soon as it slides."""
    r = v / p[6]
    return p[1] * dz / dt * math.exp(-r * r)


@njit
def law_step(code, p, bw, bd, z, dx, v, dt, level):
    """Advance by dx; returns the force, updates z in place.

    p[0] presliding distance, p[1] micro damping time (s), p[2], p[3] shape,
    p[4] number of blocks, p[5] velocity of the regularisation, p[6] of the damping's fading.
    """
    if code == 0 or code == 1 or code == 9:
        n = int(p[4])
        f = 0.0
        for i in range(n):
            lim = bw[i] * level
            q = z[i] + dx * bw[i] / bd[i]
            if q > lim:
                q = lim
            elif q < -lim:
                q = -lim
            z[i] = q
            f += q
        return f
    if code == 8:
        return level * math.tanh(v / p[5])
    s = 1.0 if dx > 0.0 else -1.0
    xi = abs(dx) / p[0]
    if code == 2 or code == 3:
        old = z[0]
        lim = s * level
        z[0] = lim + (old - lim) * math.exp(-xi / level)
        if code == 2:
            return z[0]
        return z[0] + micro(p, z[0] - old, v, dt)
    if code == 4:
        q = 1.0 - s * z[0] / level
        q = max(q, 0.0)
        e = p[2]
        h = xi / level
        if abs(e - 1.0) < 1e-6:
            q *= math.exp(-h)
        elif e > 1.0:
            if q > 1e-12:
                q = (q ** (1.0 - e) + (e - 1.0) * h) ** (1.0 / (1.0 - e))
        else:
            r = q ** (1.0 - e) - (1.0 - e) * h
            q = r ** (1.0 / (1.0 - e)) if r > 0.0 else 0.0
        z[0] = s * level * (1.0 - q)
        return z[0]
    # the rest has no closed solution
    if xi > 40.0:
        xi = 40.0
    m = int(xi / 0.2) + 1
    h = xi / m
    old = z[0]
    f = 0.0
    for _ in range(m):
        if code == 5:  # elasto-plastic after Dupont
            w = z[0] / level
            a = 0.0
            if s * w > 0.0:
                r = abs(w)
                zb = p[2]
                if r >= 1.0:
                    a = 1.0
                elif r > zb:
                    a = 0.5 * math.sin(math.pi * (r - 0.5 * (1.0 + zb)) / (1.0 - zb)) + 0.5
            z[0] += s * h * (1.0 - a * s * w)
            f = z[0]
        elif code == 6:  # Leuven-like: hysteresis stack on a saturating deflection
            n = int(p[4])
            w = 0.0
            for i in range(n):
                w += z[1 + i]
            w = w / level
            r = s * w
            g = 1.0 - (r ** p[2] if r > 0.0 else -((-r) ** p[2]))
            if g < 0.0:
                g = 0.0
            if g > 1.5:
                g = 1.5
            dz = s * h * g
            f = 0.0
            z[0] += dz
            for i in range(n):
                q = z[1 + i] + dz * p[0] * bw[i] / bd[i]
                lim = bw[i] * level * 1.02
                q = min(max(q, -lim), lim)
                z[1 + i] = q
                f += q
        else:  # Bouc-Wen
            w = z[0] / level
            b = p[3]
            g = (1.0 if s * w > 0.0 else 1.0 - 2.0 * b) * abs(w) ** p[2]
            z[0] += s * h * (1.0 - g)
            f = z[0]
    if p[1] > 0.0 and code != 7:
        f += micro(p, z[0] - old, v, dt)
    return f


def draw(name, rng, xs, mass, level, v_max, dt_hint):
    """Parameters of one law: (code, p, bw, bd, initial stiffness over level/xs)."""
    code = NAMES.index(name)
    p = np.zeros(8)
    p[0] = xs
    bw = np.zeros(NB)
    bd = np.ones(NB)
    stiff = 1.0
    if name == "gms":
        n = int(rng.integers(3, 9))
        d = xs * np.exp(np.linspace(math.log(0.15), math.log(rng.uniform(1.5, 4.0)), n))
        d *= np.exp(rng.normal(0, 0.12, n))
        w = rng.dirichlet(np.full(n, 2.5))
        p[4], bw[:n], bd[:n] = n, w, np.sort(d)
    elif name == "iwan":
        n = 22
        d = xs * np.exp(np.linspace(math.log(0.08), math.log(rng.uniform(1.8, 6.0)), n))
        w = d ** rng.uniform(0.25, 0.9)
        w *= np.exp(-d / (xs * rng.uniform(1.5, 5.0)))
        p[4], bw[:n], bd[:n] = n, w / w.sum(), d
    elif name == "coulomb_spring":
        p[4], bw[0], bd[0] = 1, 1.0, xs
    elif name == "dahl":
        p[2] = rng.choice([0.6, 1.0, 1.4, 1.8, 2.0])
    elif name == "elastoplastic":
        p[2] = rng.uniform(0.3, 0.8)
    elif name == "leuven":
        n = int(rng.integers(4, 8))
        d = xs * np.exp(np.linspace(math.log(0.2), math.log(rng.uniform(1.5, 3.0)), n))
        p[4], bw[:n], bd[:n] = n, rng.dirichlet(np.full(n, 3.0)), d
        p[2] = rng.uniform(1.0, 3.0)
    elif name == "bouc_wen":
        p[2] = rng.uniform(0.8, 2.5)
        p[3] = rng.uniform(0.5, 0.95)
    elif name == "coulomb_tanh":
        p[5] = max(v_max * rng.uniform(0.004, 0.025), dt_hint * level / (0.25 * mass))
    if bw.any():
        stiff = float(np.sum(bw / bd)) * xs
    if name in ("lugre_s1", "leuven", "elastoplastic") and rng.random() < 0.8 or name == "lugre_s1":
        wn = math.sqrt(level / xs * stiff / mass)
        # force of micro damping: zeta * 2 sqrt(k m) dz/dt, with z in units of level
        p[1] = 2.0 * rng.uniform(0.15, 0.7) / wn
        if name == "leuven" or name == "elastoplastic":
            p[1] *= 0.5
        p[6] = rng.uniform(0.2, 0.5) * xs / p[1]
    return code, p, bw, bd, stiff


@njit
def walk(code, p, bw, bd, x, v, dt):
    """Force along a prescribed path."""
    z = np.zeros(NB + 2)
    f = np.zeros(x.size)
    for i in range(1, x.size):
        f[i] = law_step(code, p, bw, bd, z, x[i] - x[i - 1], v[i], dt, 1.0)
    return f
