"""Machines at random: law, mass, level, travel and drive, and the model that their user has of them."""

import numpy as np
from plant import virgin
from vector import *


# ================================================================ drawing a machine
def logu(r, a, b):
    return float(np.exp(r.uniform(np.log(a), np.log(b))))


LAWS = ["gms", "prandtl_ishlinskii", "dahl", "lugre", "elastoplastic", "bouc_wen", "iwan", "bristle"]


def draw_law(r, law, F0, sp):
    """element arrays or closed-form parameters so that 99 % of F0 is reached near sp"""
    k = np.zeros(0)
    lim = np.zeros(0)
    lp = np.zeros(4)
    fam = F_ELEM
    zeta = r.uniform(0.05, 0.25)
    info = {}
    if law == "gms":
        n = int(r.integers(4, 31))
        y = np.sort(np.exp(r.uniform(np.log(sp / r.uniform(8, 40)), np.log(sp), n)))
        y[-1] = sp
        w = r.dirichlet(np.full(n, r.uniform(1.5, 5)))
        lim = w * F0
        k = lim / y
        info = dict(n=n)
    elif law in ("prandtl_ishlinskii", "bristle"):
        n = 45 if law[0] == "p" else 32
        y = np.linspace(0.5, n - 0.5, n) / n
        a, b = r.uniform(0.8, 2.0), r.uniform(1.5, 5)  # beta-like density of yield distance
        w = y ** (a - 1) * (1 - y) ** (b - 1)
        w /= w.sum()
        lim = w * F0
        k = lim / (y * sp)
        info = dict(a=a, b=b)
        if law == "bristle":
            fam = F_BRISTLE
    elif law == "iwan":
        n = 50
        chi = r.uniform(-0.7, -0.1)
        e = np.geomspace(0.01, 1, n + 1)
        ph = 0.5 * (e[1:] + e[:-1])
        # density rho(phi)=R phi^chi of stiffness, plus a finite share slipping at the end
        kk = e[1:] ** (chi + 1) - e[:-1] ** (chi + 1)
        kk[-1] += r.uniform(0.0, 0.25) * kk.sum()
        k = kk
        lim = kk * ph * sp
        s = F0 / lim.sum()
        k = k * s
        lim = lim * s
        info = dict(chi=chi)
    elif law in ("dahl", "lugre"):
        fam = F_DAHL
        lp[0] = 4.6 * F0 / sp
        lp[1] = F0
        if law == "lugre":
            zeta = r.uniform(0.3, 0.9)
    elif law == "elastoplastic":
        fam = F_EP
        lp[2] = r.uniform(0.25, 0.75)
        lp[1] = F0
        lp[0] = F0 / sp * r.uniform(1.6, 2.6)
        info = dict(zba_over_zss=lp[2])
    elif law == "bouc_wen":
        fam = F_BW
        lp[1] = F0
        lp[2] = r.uniform(1.0, 2.5)
        lp[3] = r.uniform(0.5, 1.0)
        lp[0] = F0 / sp * {True: 4.4, False: 3.0}[lp[2] < 1.5]
        info = dict(n=lp[2], beta=lp[3])
    k0 = float(k.sum()) if k.size else float(lp[0])
    return dict(law=law, fam=fam, k=k, lim=lim, lp=lp, k0=k0, zeta=zeta, info={a: float(b) for a, b in info.items()})


def fit_blocks(r, L, F0, sp, N=6):
    """six Maxwell-slip blocks along the virgin curve of the law"""
    n = 6000
    d = np.arange(n + 1) * (2.5 * sp / n)
    f = virgin(L["fam"], L["k"], L["lim"], L["lp"], 2.5 * sp / n, n)
    q = np.array([0.22, 0.45, 0.66, 0.82, 0.93, 0.992])[-N:] * f[-1]
    dd = np.maximum.accumulate(np.interp(q, f, d))
    dd *= 1 + 1e-6 * np.arange(N)
    for i in range(1, N):
        dd[i] = max(dd[i], dd[i - 1] * 1.05)
    ff = np.interp(dd, d, f)
    ff[-1] = f[-1]
    s = np.diff(np.r_[0, ff]) / np.diff(np.r_[0, dd])
    s = np.minimum.accumulate(s)
    kk = s - np.r_[s[1:], 0]
    w = kk * dd
    keep = w > 1e-4 * w.sum()
    kk, w, dd = kk[keep], w[keep], dd[keep]
    w = w / w.sum()
    br = F0 * (1 + r.uniform(-0.045, 0.045))
    kk = w * br / dd * (1 + r.uniform(-0.07, 0.07))
    return br, kk, w


def draw_machine(r, law, need=()):
    mt = str(r.choice(["rolling", "plain", "nut"]))
    M = logu(r, 0.5, 200)
    rat = {"rolling": (0.15, 2.5), "plain": (1.0, 8.0), "nut": (0.5, 8.0)}[mt]
    F0 = float(np.clip(M * logu(r, *rat), 0.3, 400))
    L = logu(r, 2e-3, 1.0)
    sp = {"rolling": (3e-6, 1e-4), "plain": (1e-6, 3e-5), "nut": (1e-5, 2e-4)}[mt]
    sp = min(logu(r, *sp), L / 60)
    wv = 2 * np.pi * logu(r, 25, 75)
    qmax = min(5e-6, sp / r.uniform(6, 40), 0.012 * F0 / (M * wv * wv))
    q = max(1e-9, qmax * logu(r, 0.03, 1.0))
    while q > 1.5 * qmax and wv > 100:
        wv *= 0.8
        qmax = min(sp / 6, 0.012 * F0 / (M * wv * wv))
    drive = str(r.choice(["screw", "screw", "linear", "belt"])) if mt != "nut" else "screw"
    mech = {}
    if drive == "screw":
        leads = [l for l in (1e-3, 2e-3, 4e-3, 5e-3, 1e-2, 1.6e-2, 2e-2) if l <= max(2e-3, 1.2 * L)]
        mech["screw_lead_m"] = float(r.choice(leads))
        if r.random() < 0.85:
            mech["motor_period_m"] = mech["screw_lead_m"] / int(r.choice([3, 4, 5, 7, 12]))
    else:
        per = [p for p in (4e-3, 1e-2, 1.6e-2, 2.4e-2, 3.2e-2) if p <= max(4e-3, L)]
        if r.random() < 0.9:
            mech["motor_period_m"] = float(r.choice(per))
    if r.random() < 0.75 or "encoder_error" in need:
        cand = [p for p in (1e-6, 2e-6, 4e-6, 1e-5, 2e-5, 4e-5, 1e-4, 1e-3) if 30 <= p / q <= 40000]
        pe = float(r.choice(cand)) if cand else 400 * q
        q = pe / max(1, round(pe / q))
        mech["encoder_period_m"] = pe
    if "drive_compliance" in need or "backlash" in need:
        wv = min(wv, 2 * np.pi * 35)
    mech["encoder_count_m"] = q
    law_ = draw_law(r, law, F0, sp)
    return dict(
        mt=mt,
        M=M,
        F0=F0,
        L=L,
        sp=sp,
        wv=wv,
        q=q,
        drive=drive,
        mech=mech,
        law=law_,
        x0=float(r.choice([0.0, 0.0, -L / 2, r.uniform(-2, 2) * L])),
    )
