"""The integrator: controller, drive, one or two masses, friction, encoder.

Leapfrog with a fixed step; the controller runs on ticks of `nsub` steps.  Next
to the machine runs its nominal model (inertia, the law with the machine's own
ordinary imperfections) on what the encoder sees: the mean over a tick of what
that model does not explain is column 4 of `out`.
"""

import math

import numpy as np
from numba import njit

from effects import effect_step
from laws import NB, law_step

# out: 0 load position, 1 encoder before quantisation, 2 command, 3 current (as force),
#      4 unexplained force, 5 load velocity, 6 the drive's velocity estimate


@njit
def control(mode, c, st, xq, xr, vr, ar, ur, tick):
    """One tick.  c: mass, wb, ki share, filter, acc ff, friction ff, level, limit, vff."""
    m, wb = c[0], c[1]
    raw = (xq - st[0]) / tick
    st[0] = xq
    st[1] += c[3] * (raw - st[1])
    v = st[1]
    if mode == 0:  # P-PI
        ve = 0.25 * wb * (xr - xq) + c[8] * vr - v
        i = st[2] + ve * tick
        u = m * wb * (ve + c[2] * wb * i) + c[4] * m * ar
    elif mode == 1 or mode == 2:  # PID, PID with feed-forward
        e = xr - xq
        st[3] += c[3] * ((vr * c[8] - raw) - st[3])
        i = st[2] + e * tick
        u = m * (wb * wb * 0.45 * e + wb * st[3] + c[2] * wb * wb * wb * 0.45 * i)
        u += c[4] * m * ar + c[5] * c[6] * math.tanh(vr / c[9])
    elif mode == 3:  # open loop, held in the travel by a soft loop
        i = 0.0
        u = ur - m * (c[10] * c[10] * xq + 1.4 * c[10] * v)
    else:  # speed PI
        ve = vr - v
        i = st[2] + ve * tick
        u = m * wb * (ve + c[2] * wb * i) + c[4] * m * ar
    if u > c[7]:
        u = c[7]
    elif u < -c[7]:
        u = -c[7]
    else:
        st[2] = i
    return u


@njit
def seen(x, e):
    """Encoder reading; e: amplitude, period, phase, second harmonic, its phase."""
    if e[0] == 0.0:
        return x
    w = 2.0 * math.pi * x / e[1]
    return x + e[0] * (math.sin(w + e[2]) + e[3] * math.sin(2.0 * w + e[4]))


@njit
def simulate(nsub, tick, ref, levt, aux, mech, mode, ctl, lawc, lawp, bw, bd, codes, amps, ep, enc, act):
    """mech: mass, level, viscous, count, electric time, late ticks, ripple amplitude,
    ripple period, motor mass share, stiffness, damping, gap, two masses?, friction on motor?,
    encoder on load?, x0, wander amplitude, then three wave numbers and phases.
    act: dead zone, saturation (0: none)."""
    n = ref.shape[1]
    dt = tick / nsub
    out = np.zeros((n, 7))
    mass, level, visc, count = mech[0], mech[1], mech[2], mech[3]
    ka = 1.0 - math.exp(-dt / mech[4])
    two = mech[12] > 0.5
    mm, ml = mass * mech[8], mass * (1.0 - mech[8])
    fmot = mech[13] > 0.5
    eload = mech[14] > 0.5
    z = np.zeros(NB + 2)
    zs = np.zeros(NB + 2)
    es = np.zeros((2, 8))
    st = np.zeros(6)
    x = mech[15]
    v = 0.0
    xm, vm = x, 0.0
    f = 0.0
    fs = 0.0
    ucur = 0.0
    uhold = 0.0
    acc = 0.0
    net = 0.0
    ulate = 0.0
    xe = seen(x, enc)
    st[0] = math.floor(xe / count + 0.5) * count
    veold = 0.0
    x_start = x
    for k in range(n):
        xq = math.floor(xe / count + 0.5) * count
        uc = control(mode, ctl, st, xq, ref[0, k], ref[1, k], ref[2, k], ref[3, k], tick)
        out[k, 0] = x
        out[k, 1] = xe
        out[k, 2] = uc
        out[k, 3] = ucur
        out[k, 5] = v
        out[k, 6] = st[1]
        if mech[5] > 0.5:
            uhold = ulate
            ulate = uc
        else:
            uhold = uc
        wx = 0.0
        for j in range(3):
            wx += math.sin(mech[17 + 2 * j] * x + mech[18 + 2 * j])
        wx *= mech[16]
        k1 = min(k + 1, n - 1)
        tot = 0.0
        for j in range(nsub):
            r = j / nsub
            l0 = (1.0 - r) * levt[k] + r * levt[k1] + wx
            lv = l0
            fa = 0.0
            g = 1.0
            fr = level * f
            for q in range(2):
                if codes[q] > 0:
                    a = (1.0 - r) * aux[q, k] + r * aux[q, k1]
                    d1, f1, g1 = effect_step(codes[q], amps[q], ep[q], es[q], x, v, acc, dt, ucur, fr, net, a)
                    lv += d1
                    fa += f1
                    g *= g1
            lv = max(lv, 0.05)
            ua = ucur * g
            if act[0] > 0.0:
                ua = math.copysign(max(abs(ua) - act[0], 0.0), ua)
            if act[1] > 0.0:
                ua = min(max(ua, -act[1]), act[1])
            rip = mech[6] * math.sin(2.0 * math.pi * (xm if two else x) / mech[7])
            if two:
                d = xm - x
                half = 0.5 * mech[11]
                fc = 0.0
                if mech[11] == 0.0:
                    fc = mech[9] * d + mech[10] * (vm - v)
                elif d > half:
                    fc = max(0.0, mech[9] * (d - half) + mech[10] * (vm - v))
                elif d < -half:
                    fc = min(0.0, mech[9] * (d + half) + mech[10] * (vm - v))
                fm = ua - fc - rip
                fl = fc - fa - visc * v
                if fmot:
                    fm -= fr
                    net = fc
                else:
                    fl -= fr
                    net = fl + fa
                acc = fl / ml
                vm += dt * fm / mm
                v += dt * acc
                dxm = dt * vm
                dx = dt * v
                xm += dxm
                x += dx
                if fmot:
                    f = law_step(lawc, lawp, bw, bd, z, dxm, vm, dt, lv)
                else:
                    f = law_step(lawc, lawp, bw, bd, z, dx, v, dt, lv)
                xen = seen(x if eload else xm, enc)
            else:
                net = ua - fr - visc * v
                acc = (net - fa - rip) / mass
                v += dt * acc
                dx = dt * v
                x += dx
                f = law_step(lawc, lawp, bw, bd, z, dx, v, dt, lv)
                xen = seen(x, enc)
            dxe = xen - xe
            ve = dxe / dt
            tot += ucur - mass * (ve - veold) / dt - level * fs - visc * ve - rip
            fs = law_step(lawc, lawp, bw, bd, zs, dxe, ve, dt, l0)
            veold = ve
            xe = xen
            ucur += ka * (uhold - ucur)
        out[k, 4] = tot / nsub
        if not abs(x - x_start) < 1e6:
            out[k:, :] = np.nan
            break
    return out
