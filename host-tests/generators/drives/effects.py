"""Forces and friction levels of the effects, one integration step at a time.

`effect_step` returns (relative friction level to add, force to add, factor on
the actuator's force).  `p` are fixed numbers, `s` the effect's own states.
"""

import math

from numba import njit


@njit
def bumps(p, x):
    """A smooth map over the travel: a step, a hill and a bowl."""
    a = p[0] * math.tanh((x - p[1]) / p[2])
    b = p[3] * math.exp(-0.5 * ((x - p[4]) / p[5]) ** 2)
    c = (x - p[7]) / p[8]
    return a + b + p[6] * (c * c - 0.3)


@njit
def tones(p, x):
    w = 2.0 * math.pi * x / p[0]
    return math.sin(w + p[1]) + p[2] * math.sin(2.0 * w + p[3])


@njit
def effect_step(c, amp, p, s, x, v, acc, dt, u, fr, net, aux):
    dl = 0.0
    fa = 0.0
    g = 1.0
    av = abs(v)
    if c == 1:
        fa = amp * v
    elif c == 2:
        fa = amp * v * av
    elif c == 3:
        dl = amp * math.exp(-((av / p[0]) ** p[1]))
    elif c == 4:
        dl = amp * math.tanh(v / p[0])
    elif c == 5:
        fa = amp
    elif c == 6:
        fa = amp * (x - p[0])
    elif c == 7:
        fa = amp * bumps(p, x)
    elif c == 8:
        dl = amp * bumps(p, x)
    elif c == 9:
        dl = amp * math.exp(-0.5 * ((x - p[0]) / p[1]) ** 2)
    elif c == 10:
        fa = amp * tones(p, x)
    elif c == 11:
        dl = amp * tones(p, x)
    elif c == 16:
        s[0] += dt / p[0] * (abs(fr * v) / p[1] - s[0])
        dl = amp * p[2] * s[0]
    elif c == 17:
        s[0] += av * dt
        dl = amp * math.exp(-s[0] / p[0])
    elif c == 18:
        if av < p[2]:
            s[0] += dt
        else:
            s[0] *= math.exp(-av * dt / p[1])
        dl = amp * math.log1p(s[0] / p[0])
    elif c == 19 or c == 25:
        fa = amp * aux
    elif c == 20:
        s[0] += dt / p[0] * (abs(net) / p[1] - s[0])
        dl = amp * s[0]
    elif c == 21:
        tgt = math.exp(-((av / p[0]) ** p[1]))
        s[0] += dt / p[2] * (tgt - s[0])
        dl = amp * s[0]
    elif c == 22:
        fa = amp * math.sin(x - p[0])
    elif c > 100:
        return strange_step(c, amp, p, s, x, v, acc, dt, u, fr, net, aux)
    return dl, fa, g


@njit
def strange_step(c, amp, p, s, x, v, acc, dt, u, fr, net, aux):
    dl = 0.0
    fa = 0.0
    g = 1.0
    av = abs(v)
    if c == 101:  # loose mass between two stops
        if s[2] == 0.0:
            s[0] = x
            s[2] = 1.0
        d = s[0] - x
        rel = s[1] - v
        f = 0.0  # on the loose mass, per its own kilogram
        if d > p[0]:
            f = min(0.0, -p[1] * p[1] * (d - p[0]) - 2.0 * p[2] * p[1] * rel)
        elif d < -p[0]:
            f = max(0.0, -p[1] * p[1] * (d + p[0]) - 2.0 * p[2] * p[1] * rel)
        f -= p[3] * math.tanh(rel / p[4])
        s[1] += f * dt
        s[0] += s[1] * dt
        fa = amp * f
    elif c == 102:  # bus capacitor
        pw = max(u * v, 0.0) + p[2] * u * u
        s[0] += dt / p[0] * (pw / p[1] - s[0])
        g = 1.0 / (1.0 + amp * s[0])
    elif c == 103:  # film that builds with motion and is squeezed out
        s[0] += dt / p[0] * (av / p[1] - s[0])
        fa = amp * v / (p[2] + s[0])
    elif c == 104:  # visco-elastic wiper
        s[0] += v * dt - s[0] * dt / p[0]
        s[0] = min(max(s[0], -p[1]), p[1])
        fa = amp * s[0]
    elif c == 105:  # brake that lets go late
        if av < p[0]:
            s[0] += dt
            if s[0] > p[1]:
                s[2] += 1.0
                r = math.sin(s[2] * 12.9898) * 43758.5453
                s[1] = 0.4 + 1.2 * (r - math.floor(r))
                s[0] = -1e9
        else:
            s[0] = 0.0 if s[0] > 0.0 or s[0] < -1e8 else s[0]
            s[1] -= dt / p[2] * s[1]
        dl = amp * s[1]
    elif c == 106 or c == 112:
        g = 1.0 + amp * aux
        if c == 112 and g < 0.0:
            g = 0.0
    elif c == 107:
        fa = amp * v / (1.0 + (v / p[0]) ** 2)
    elif c == 108:  # free liquid surface; its mass at rest is in the carriage's
        q = s[0]
        f = p[0] * p[0] * q + 2.0 * p[1] * p[0] * s[1]
        s[1] += dt * (-acc - f)
        s[0] += dt * s[1]
        fa = -amp * (f + acc)
    elif c == 109:  # chips pushed to the ends, slipping back
        if s[2] == 0.0:
            s[0] = p[2]
            s[1] = -p[2]
            s[2] = 1.0
        s[0] -= p[0] * dt
        s[1] += p[0] * dt
        if x - p[3] > s[0]:
            s[3] = min(1.0, s[3] + (x - p[3] - s[0]) / p[1])
            s[0] = x - p[3]
        else:
            s[3] = max(0.0, s[3] - dt / 0.02)
        if x - p[3] < s[1]:
            s[4] = min(1.0, s[4] + (s[1] - x + p[3]) / p[1])
            s[1] = x - p[3]
        else:
            s[4] = max(0.0, s[4] - dt / 0.02)
        fa = amp * (s[3] - s[4])
    elif c == 110:  # cushion with a small orifice
        q = s[0]
        s[0] += v * dt / p[0] * (1.0 + 0.35 * math.tanh(q))
        s[0] -= dt / p[1] * (math.sqrt(q) if q > 0.0 else -math.sqrt(-q))
        fa = amp * s[0]
    elif c == 111:  # iron that keeps some of its field
        s[0] = min(max(s[0] + u - s[1], -p[0]), p[0])
        s[1] = u
        fa = amp * s[0]
    elif c == 113:  # part taken up and put down again
        if aux > 0.0:
            fa = amp * acc * aux
    elif c == 114:  # soft feet under the base
        qa = -amp * net * p[2] - p[0] * p[0] * s[0] - 2.0 * p[1] * p[0] * s[1]
        s[1] += dt * qa
        s[0] += dt * s[1]
        fa = qa / p[2]
    elif c == 115:  # balls entering the loaded zone
        r = x / p[0]
        cell = math.floor(r)
        if cell != s[0]:
            s[0] = cell
            s[1] = (s[1] * 1103515245.0 + 12345.0) % 2147483648.0
        k = s[1] / 2147483648.0
        h = math.sin(math.pi * (r - cell))
        fa = amp * (k * k * 2.0) * h * h * math.tanh(v / p[1])
    elif c == 116:
        fa = amp * aux
    elif c == 117:  # lip that sticks to the rail after a rest
        if av < p[0]:
            s[0] += dt
            if s[0] > p[1]:
                s[1] = x
                s[2] = 1.0
        else:
            s[0] = 0.0
        if s[2] > 0.0:
            d = (x - s[1]) / p[2]
            if abs(d) > 8.0:
                s[2] = 0.0
            fa = amp * d * math.exp(1.0 - abs(d))
    return dl, fa, g
