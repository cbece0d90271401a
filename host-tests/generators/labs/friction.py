"""Friction laws: one incremental step for each law, and the draw of a law's parameters.

A law is a set of element stiffnesses k, element limits w (their sum is the friction level) and a few
extra numbers.  Level multipliers (mp for motion in +, mn for motion in -) scale the limits, not the
stiffness.  `creep` (1/s) lets loaded elements slip slowly.
"""
import numpy as np
from numba import njit
from scipy.optimize import nnls

STOPS, GMS, DAHL, LUGRE, BOUC_WEN, TANH, BRISTLE = range(7)


@njit(cache=True)
def friction_step(law, k, w, extra, z, dx, v, dt, mp, mn, creep):
    """Advance the element forces z over the displacement dx (speed v, time dt); return the force."""
    if law == TANH:
        s = np.tanh(v / extra[0])
        return w[0] * s * (0.5 * (mp + mn) + 0.5 * (mp - mn) * s)
    direction = 1.0 if dx > 0 else -1.0
    m = mp if dx > 0 else mn
    force = 0.0
    for i in range(k.size):
        f = z[i]
        if creep > 0:
            f -= f * min(0.5, creep * dt * (f / w[i]) ** 2)
        limit = m * w[i]
        if law == STOPS or law == GMS:
            f_old = f
            f += k[i] * dx
            hi, lo = mp * w[i], -mn * w[i]
            if law == GMS and f_old > hi:       # a slipping element follows a falling level at a finite rate
                hi += (f_old - hi) * np.exp(-extra[0] * dt)
            elif law == GMS and f_old < lo:
                lo += (f_old - lo) * np.exp(-extra[0] * dt)
            f = min(hi, max(lo, f))
        elif law == BOUC_WEN:
            h = k[i] * abs(dx) / limit
            if h > 25.0:
                f = direction * limit
            elif h > 0:
                n = int(h / 0.05) + 1
                for _ in range(n):
                    f += _bouc_wen_slope(f, limit, direction, extra) * k[i] * dx / n
        else:                       # relaxation towards the limit with distance, solved exactly
            h = k[i] * abs(dx) / limit
            r = 1.0 - direction * f / limit
            n = extra[0] if law == DAHL else 1.0
            if abs(r) < 1e-10 or h > 1e3:
                r = 0.0
            elif r < 0 or abs(n - 1.0) < 1e-3:
                r *= np.exp(-h)
            elif r > 0:
                q = r ** (1.0 - n) - (1.0 - n) * h
                r = q ** (1.0 / (1.0 - n)) if q > 0 else 0.0
            f_new = direction * limit * (1.0 - r) if h > 0 else f
            if law == LUGRE:
                force += extra[0] * (f_new - z[i]) / (k[i] * dt)
            f = f_new
        z[i] = f
        force += f
    return force


@njit(cache=True)
def _bouc_wen_slope(f, limit, direction, extra):
    loading = 1.0 if f * direction > 0 else 2.0 * extra[1] - 1.0
    return 1.0 - loading * (abs(f) / limit) ** extra[0]


class Law:
    """A drawn friction law: name, numerical kind, elements and label entries."""

    def __init__(self, rng, level, distance, mass, speed):
        self.level, self.distance = level, distance
        self.name = str(rng.choice(["gms", "dahl", "lugre", "bouc_wen", "tanh", "prandtl_ishlinskii",
                                    "leuven_power", "bristle_bed"]))
        self.extra, self.params = np.zeros(3), {}
        single_k, single_w = np.array([level / distance]), np.array([level])
        if self.name == "gms":
            n = int(rng.integers(5, 41))
            yields = np.sort(np.exp(rng.uniform(np.log(0.08), np.log(2.0), n))) * distance
            self.elements(GMS, yields, rng.dirichlet(np.full(n, 3.0)))
            self.extra[0] = np.exp(rng.uniform(np.log(50), np.log(500)))
            self.params["gms_attraction_per_s"] = self.extra[0]
        elif self.name == "prandtl_ishlinskii":
            yields = np.geomspace(0.05, 3.0, 40) * distance
            u = np.log(yields / distance)
            density = (np.exp(-((u + rng.uniform(0.3, 2)) / rng.uniform(0.3, 1)) ** 2)
                       + rng.uniform(0, 1) * np.exp(-((u - rng.uniform(0, 0.8)) / 0.3) ** 2))
            self.elements(STOPS, yields, density / density.sum())
        elif self.name == "leuven_power":
            power = rng.uniform(0.35, 0.8)
            nodes = np.concatenate([[0.0], np.geomspace(0.01, 1.0, 60)])
            slope = np.append(np.diff(nodes ** power) / np.diff(nodes), 0.0)
            self.elements(STOPS, nodes[1:] * distance, -np.diff(slope) * nodes[1:])
            self.params["virgin_power"] = power
        elif self.name == "bristle_bed":
            yields = np.exp(rng.normal(-0.7, rng.uniform(0.4, 0.9), 40)).clip(0.05, 3) * distance
            self.elements(BRISTLE, yields, rng.dirichlet(np.full(40, 2.0)))
        elif self.name == "tanh":
            self.kind, self.k, self.w = TANH, single_k, single_w
            self.extra[0] = speed * np.exp(rng.uniform(np.log(0.004), np.log(0.03)))
            self.params["tanh_speed"] = self.extra[0]
        else:
            self.kind = {"dahl": DAHL, "lugre": LUGRE, "bouc_wen": BOUC_WEN}[self.name]
            self.k, self.w = single_k, single_w
            if self.name == "dahl":
                self.extra[0] = self.params["dahl_exponent"] = rng.uniform(0.5, 2.0)
            elif self.name == "lugre":
                self.extra[0] = 2 * rng.uniform(0.05, 0.6) * np.sqrt(level / distance * mass)
                self.params["sigma1"] = self.extra[0]
            else:
                self.extra[0] = self.params["bouc_wen_exponent"] = rng.uniform(0.7, 3.0)
                self.extra[1] = self.params["bouc_wen_beta"] = rng.uniform(0.5, 1.0)

    def elements(self, kind, yields, shares):
        self.kind, self.w = kind, shares * self.level
        self.k = self.w / yields

    def max_rate(self, mass):
        """Fastest natural rate (1/s) that the law makes with the mass."""
        if self.kind == TANH:
            return 0.5 * self.level / (self.extra[0] * mass)
        return np.sqrt(self.k.sum() / mass)

    def virgin_curve(self, x):
        z, out, last = np.zeros(self.k.size), np.zeros(x.size), 0.0
        for i, xi in enumerate(x):
            out[i] = friction_step(self.kind, self.k, self.w, self.extra, z, xi - last, 1.0, 1e9, 1.0, 1.0, 0.0)
            last = xi
        return out

    def blocks(self, reversal_distance):
        """Stops (stiffness, share) fitted to the virgin curve; for tanh the mean way of a reversal is the yield."""
        if self.kind == TANH:
            return [(self.level / reversal_distance, 1.0)]
        x = np.geomspace(0.02, 12.0, 200) * self.distance
        yields = np.geomspace(0.04, 10.0, 10) * self.distance
        shares, _ = nnls(np.minimum(x[:, None] / yields, 1.0), self.virgin_curve(x) / self.level)
        keep = shares > 1e-3
        shares = shares[keep] / shares[keep].sum()
        return [(s * self.level / y, s) for s, y in zip(shares, yields[keep])]
