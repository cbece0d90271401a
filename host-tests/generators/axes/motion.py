"""Programmes of motion: strokes, creeps, sines, small steps and rests, in identical passes."""

import numpy as np
from machines import logu
from vector import *


# ================================================================ reference programme
def stroke(dist, V, tr):
    a = abs(dist)
    if a < V * tr:
        V = a / tr
        tc = 0.0
    else:
        tc = a / V - tr
    n = max(8, int(round((2 * tr + tc) / TC)))
    t = (np.arange(n) + 0.5) * TC
    T = n * TC
    s = np.clip(np.minimum(t, T - t) / tr, 0, 1)
    v = s - np.sin(2 * np.pi * s) / (2 * np.pi)
    return v * (dist / (v.sum() * TC))


def rest(T):
    return np.zeros(max(1, int(round(T / TC))))


def programme(r, mc, effects):
    """velocity sequence of one pass as list of pieces"""
    L, sp, M, F0 = mc["L"], mc["sp"], mc["M"], mc["F0"]
    tr = logu(r, 0.08, 0.35)
    amax = r.uniform(0.6, 4.0) * F0 / M
    v1 = min(0.9 * L / r.uniform(0.5, 2.0), amax * tr / 2.0, 1.2)
    while v1 < 0.3 * L and tr < 0.7:
        tr *= 1.3
        v1 = min(0.9 * L, amax * tr / 2.0, 1.2)
    v1 = max(v1, 8 * sp)
    budget = r.uniform(11, 25)
    span = min(0.9 * L, 4.0 * v1)
    lo, hi = 0.05 * L + (0.9 * L - span) * r.random(), 0.0
    hi = lo + span
    start = lo + r.uniform(0.0, 0.25) * span
    pos = start
    P = []
    used = 0.0
    rests = [0.05, 0.15, 0.3, 0.6, 1.2]
    if "dwell_aging" in effects or "late_brake" in effects:
        rests += [2.0, 4.0, 0.4]

    def add(v):
        nonlocal used, pos
        P.append(v)
        used += v.size * TC
        pos += v.sum() * TC

    def go(x, V, rt=None):
        d = x - pos
        if abs(d) < 2 * sp:
            return
        add(
            np.r_[
                stroke(d, V, tr if abs(d) > V * tr * 0.3 else max(0.05, tr / 2)),
                rest(rt if rt else float(r.choice(rests))),
            ]
        )

    mic = max(sp, 2 * mc["q"])
    kinds = ["long", "creep", "sine", "revs", "steps", "mid", "long", "slow", "sine2"]
    r.shuffle(kinds)
    order = ["long"] + [k for k in kinds]
    for kd in order:
        if used > budget:
            break
        if kd == "long":
            V = v1 * r.uniform(0.6, 1.0)
            go(hi - r.uniform(0, 0.1) * span, V)
            go(lo + r.uniform(0, 0.1) * span, V)
        elif kd == "mid":
            for _ in range(int(r.integers(2, 5))):
                go(lo + r.random() * span, v1 * logu(r, 0.1, 0.8))
        elif kd == "slow":
            V = v1 * logu(r, 0.02, 0.15)
            dd = min(V * 1.5, 0.4 * span) * (1 if pos < (lo + hi) / 2 else -1)
            p = pos
            go(pos + dd, V, 0.2)
            go(p, V, 0.3)
        elif kd == "creep":
            V = mic * logu(r, 3, 25)
            T = r.uniform(1.0, 2.5)
            dd = V * T * (1 if pos < (lo + hi) / 2 else -1)
            dd = np.sign(dd) * min(abs(dd), 0.4 * span)
            for sg in (1, -1):
                add(np.r_[stroke(sg * dd, V, 0.15), rest(0.3)])
        elif kd in ("sine", "sine2"):
            f = logu(r, 0.4, 2.5)
            nc = int(r.integers(3, 7))
            T = nc / f
            if T > 5:
                nc = max(2, int(5 * f))
                T = nc / f
            n = int(round(T / TC))
            t = np.arange(n) * TC
            am = mic * logu(r, 2, 12) if kd == "sine" else mic * logu(r, 10, 120)
            am = min(am, 0.2 * span, 0.8 * v1 / (2 * np.pi * f), 1.5 * amax / (2 * np.pi * f) ** 2)
            a0 = r.uniform(0.15, 0.5)
            env = a0 + (1 - a0) * t / T if r.random() < 0.5 else 1 - (1 - a0) * t / T
            env = (
                env
                * np.clip(np.minimum(t, T - t) * f * 2, 0, 1) ** 2
                * (3 - 2 * np.clip(np.minimum(t, T - t) * f * 2, 0, 1))
            )
            dr = 1 if pos < (lo + hi) / 2 else -1
            X = dr * am * env * np.sin(2 * np.pi * t / T * nc)
            v = np.diff(np.r_[X, 0.0]) / TC
            add(np.r_[v, rest(0.3)])
        elif kd == "revs":
            sz = mic * np.exp(r.uniform(np.log(1.0), np.log(40), int(r.integers(4, 8))))
            sg = 1 if pos < (lo + hi) / 2 else -1
            v = []
            for a in sz:
                a = min(a, 0.2 * span)
                v.append(stroke(sg * a, max(a / 0.25, 4 * mic), 0.12))
                v.append(rest(0.06))
                sg = -sg
            add(np.concatenate(v + [rest(0.2)]))
        elif kd == "steps":
            a = mic * logu(r, 0.4, 6)
            nst = int(r.integers(3, 6))
            sg = 1 if pos < (lo + hi) / 2 else -1
            v = []
            for i in range(2 * nst):
                v.append(stroke((sg if i < nst else -sg) * a, 1e9, 0.04))
                v.append(rest(0.25))
            add(np.concatenate(v))
    go(start if abs(pos - start) > 4 * sp else start + 0.3 * span, v1 * 0.7)
    go(start, v1 * 0.7, 0.5)
    # exact closure: put the rest into the last piece
    d = start - pos
    if d != 0.0:
        add(np.r_[stroke(d, 1e9, 0.1), rest(0.2)])
    Tp = used
    R = int(np.clip(round(r.uniform(55, 110) / Tp), 3, 6))
    while R * Tp < 41:
        R += 1
    R = min(R, 6)
    vr = []
    seg = []
    rep = []
    s = 0
    for i in range(R):
        for v in P:
            vr.append(v)
            seg.append(np.full(v.size, s))
            rep.append(np.full(v.size, i))
            s += 1
    vr = np.concatenate(vr)
    seg = np.concatenate(seg).astype(np.int64)
    rep = np.concatenate(rep).astype(np.int64)
    vr = np.r_[np.zeros(800), vr]
    seg = np.r_[np.zeros(800, np.int64), seg]
    rep = np.r_[np.zeros(800, np.int64), rep]
    xr = mc["x0"] + start + np.cumsum(vr) * TC
    ar = np.gradient(vr) / TC
    kz = np.ones(9) / 9
    ar = np.convolve(ar, kz, "same")
    return dict(
        xr=xr,
        vr=vr,
        ar=ar,
        seg=seg,
        rep=rep,
        R=R,
        nseg=s,
        per=len(P),
        v1=v1,
        lo=mc["x0"] + lo,
        hi=mc["x0"] + hi,
        amax=max(np.abs(ar).max(), 1e-9),
        tr=tr,
    )
