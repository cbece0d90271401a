"""Effects and strangers at random, by equation, with limits of their size."""

import math

import numpy as np
from machines import logu
from vector import *

EFFECTS = [
    "viscous",
    "quadratic_drag",
    "stribeck",
    "coulomb_asymmetry",
    "constant_force",
    "position_spring",
    "position_friction",
    "local_friction_spot",
    "periodic_force",
    "periodic_friction",
    "encoder_error",
    "channel_delay",
    "drive_compliance",
    "backlash",
    "thermal_drift",
    "run_in",
    "dwell_aging",
    "external_vibration",
    "load_dependent_friction",
    "frictional_lag",
]
STRANGERS = [
    "grease_bow_wave",
    "recent_acceleration",
    "hose_stick_slip",
    "seal_turns_at_one_end",
    "random_ball_jam",
    "amplifier_fade",
    "cable_chain_reversal",
    "pushed_chip",
    "viscoelastic_wiper",
    "two_state_film",
    "late_brake",
    "pressure_pulse",
    "previous_stroke_memory",
    "creeping_belt_ripple",
    "tilting_carriage",
    "loose_cover_plate",
]


def pick_period(r, mc, span, par):
    c = [
        (n, mc["mech"][n]) for n in ("motor_period_m", "screw_lead_m") if n in mc["mech"] and mc["mech"][n] < 0.6 * span
    ]
    if not c or r.random() < 0.25:
        p = span * logu(r, 0.04, 0.4)
        src = "free"
        p = max(p, 20 * mc["sp"])
    else:
        src, p = c[int(r.integers(len(c)))]
    par.update(period_m=float(p), period_source=src)
    return p


def draw_effect(r, name, mc, pg):
    """returns spec: fixed parameters + (amplitude setter, start amplitude, lo, hi)"""
    F0, M, _L, sp, v1 = mc["F0"], mc["M"], mc["L"], mc["sp"], pg["v1"]
    lo, hi = pg["lo"], pg["hi"]
    span = hi - lo
    par = {}
    fix = {}
    tab = None
    temp = None
    key = None
    amp = 0.1
    lim = (1e-4, 1.0)
    U = r.uniform
    if name == "viscous":
        key, amp, lim = VISC, 0.15 * F0 / v1, (0, 20 * F0 / v1)
    elif name == "quadratic_drag":
        key, amp, lim = QUAD, 0.2 * F0 / v1**2, (0, 40 * F0 / v1**2)
    elif name == "stribeck":
        key, amp, lim = STR_A, 0.25, (0, 1.2)
        fix = {STR_V: v1 * logu(r, 0.02, 0.3), STR_D: U(0.6, 2.0)}
    elif name == "coulomb_asymmetry":
        key, amp, lim = ASYM, 0.1 * r.choice([-1, 1]), (0, 0.6)
    elif name == "constant_force":
        key, amp, lim = CONST, 0.1 * F0 * r.choice([-1, 1]), (0, 3 * F0)
    elif name == "position_spring":
        key, amp, lim = SPR_K, 0.3 * F0 / span * (1 if U() < 0.85 else -1), (0, 20 * F0 / span)
        fix = {SPR_X: lo + U(0.2, 0.8) * span}
    elif name == "position_friction":
        s = np.linspace(0, 1, 512)
        tab = np.zeros(512)
        for i in range(1, 4):
            tab += r.normal() / i * np.cos(np.pi * i * s * U(0.7, 1.0) + U(0, 6.28))
        tab = (tab - tab.mean()) / np.abs(tab - tab.mean()).max()
        key, amp, lim = POSF, 0.2, (0, 0.75)
        fix = {POS_LO: lo - 0.03 * span, POS_HI: hi + 0.03 * span}
    elif name == "local_friction_spot":
        kd = int(r.integers(0, 3))
        key, amp, lim = SPOT_A, 0.5, (0, 3.0)
        fix = {SPOT_X: lo + U(0.25, 0.75) * span, SPOT_W: span * U(0.03, 0.12), SPOT_K: kd}
        par["shape"] = ["gauss", "flat", "triangle"][kd]
    elif name in ("periodic_force", "periodic_friction"):
        p = pick_period(r, mc, span, par)
        a2 = U(0, 0.5)
        ph, ph2 = U(0, 6.28), U(0, 6.28)
        if name == "periodic_force":
            key, amp, lim = PF_A, 0.14 * F0, (0, 1.5 * F0)
            fix = {PF_P: p, PF_PH: ph, PF_A2: a2, PF_PH2: ph2}
        else:
            key, amp, lim = PM_A, 0.15, (0, 0.6)
            fix = {PM_P: p, PM_PH: ph, PM_A2: a2, PM_PH2: ph2}
    elif name == "encoder_error":
        pe = mc["mech"]["encoder_period_m"]
        key, amp, lim = ENC_A, 0.005 * pe, (0, 0.03 * pe)
        fix = {ENC_P: pe, ENC_PH: U(0, 6.28), ENC_A2: U(0, 0.6), ENC_PH2: U(0, 6.28)}
        par["period_m"] = pe
    elif name == "channel_delay":
        key, amp, lim = "delay", 1.5e-3 * r.choice([-1, 1]), (3e-4, 5e-3)
    elif name == "drive_compliance":
        m1 = U(0.2, 0.6) * M
        m2 = M - m1
        enc = int(U() < 0.4)
        fr = mc["wv"] * U(4.0, 7.0)
        # amplitude = compliance (1/k); friction sits on the load
        kmin = (mc["wv"] * 2.8) ** 2 / (1 / m1 + 1 / m2)
        key, amp, lim = "compl", 1 / (fr**2 / (1 / m1 + 1 / m2)), (0, 1 / kmin)
        fix = {TWO: 1, TWO_M1: m1, TWO_ENC: enc, TWO_FM: 0.0}
        par.update(encoder="load" if enc else "motor", motor_mass_kg=m1, zeta=U(0.02, 0.08))
    elif name == "backlash":
        m1 = U(0.2, 0.5) * M
        k = (2 * np.pi * U(150, 300)) ** 2 * m1 * (M - m1) / M
        key, amp, lim = TWO_GAP, 3 * sp, (0.2 * sp, min(60 * sp, 2e-4 + 3 * sp, span / 20))
        fix = {
            TWO: 1,
            TWO_M1: m1,
            TWO_ENC: 0,
            TWO_FM: U(0.08, 0.2),
            TWO_K: k,
            TWO_C: 2 * 0.25 * math.sqrt(k * m1 * (M - m1) / M),
        }
        par.update(encoder="motor", k_N_per_m=k)
    elif name == "thermal_drift":
        key, amp, lim = TH_B, -0.03 if U() < 0.8 else 0.03, (0, 0.4)
        temp = dict(dT=U(3, 9))
    elif name == "run_in":
        key, amp, lim = RUN_A, 0.3, (0, 2.5)
        fix = {RUN_S: float(np.abs(pg["vr"]).sum() * TC * U(0.1, 0.4))}
    elif name == "dwell_aging":
        key, amp, lim = AGE_A, 0.25, (0, 0.45)
        fix = {AGE_T0: U(0.02, 0.1), AGE_D: sp * U(2, 30), AGE_V: 0.5 * sp}
    elif name == "external_vibration":
        key, amp, lim = VIB_A, 0.14 * F0, (0, 1.5 * F0)
        f = logu(r, 2, 45)
        fix = {VIB_W: 2 * np.pi * f, VIB_PH: U(0, 6.28)}
        par["f_Hz"] = f
    elif name == "load_dependent_friction":
        key, amp, lim = LOAD_A, 0.08, (0, 0.4)
    elif name == "frictional_lag":
        key, amp, lim = LAG_A, 0.25, (0, 1.2)
        fix = {LAG_V: v1 * logu(r, 0.05, 0.3), LAG_TAU: logu(r, 0.01, 0.12)}
        par["note"] = "Stribeck curve seen through a first-order lag of |v|"
    elif name in STRANGERS:
        S = STRANGERS.index(name) + 1
        key, amp, lim = STR_AMP, 0.2, (0, 1.5)
        p = []
        pg["vr"].size * TC
        path = float(np.abs(pg["vr"]).sum() * TC)
        if S == 1:
            p = [span * U(0.15, 0.6), span * U(0.02, 0.06), U(0.5, 2)]
        if S == 2:
            p = [U(0.2, 1.5)]
            amp = 1.0
            lim = (0, 12)
        if S == 3:
            p = [span * U(0.02, 0.15), U(0.1, 0.4)]
        if S == 4:
            sg = r.choice([-1, 1])
            xe = (hi - U(0.15, 0.4) * span) if sg > 0 else (lo + U(0.15, 0.4) * span)
            p = [xe, span * U(0.03, 0.1), int(pg["R"] * U(0.8, 1.6)), sg]
        if S == 5:
            p = [path / U(25, 60), path / 250 * U(0.5, 2)]
            lim = (0, 4)
        if S == 6:
            p = [U(3, 15)]
            lim = (0, 3)
        if S == 7:
            p = [U(0.05, 0.5), U(-0.3, 0.3)]
        if S == 8:
            p = [0.3 * span * U(), span * U(0.01, 0.04), span * U(0.02, 0.08)]
            lim = (0, 3)
        if S == 9:
            p = [span * U(0.05, 0.3), U(0.2, 2.0)]
        if S == 10:
            p = [U(2, 8)]
        if S == 11:
            p = [U(0.1, 0.4), U(0.1, 0.25)]
            lim = (0, 2)
        if S == 12:
            p = [logu(r, 0.7, 12)]
        if S == 13:
            p = [span]
        if S == 14:
            p = [span * U(0.04, 0.2), U(0.005, 0.05), U(0, 6)]
        if S == 15:
            p = [lo + U(0.3, 0.7) * span, span / 2]
        if S == 16:
            mm = M * U(0.02, 0.05)
            p = [span * U(0.01, 0.06), (2 * np.pi * U(20, 40)) ** 2 * mm, 0.2, mm, 0.01 * v1]
        fix = {STR_ID: S}
        fix.update({SP0 + i: float(a) for i, a in enumerate(p)})
        par["p"] = [float(a) for a in p]
    sg = -1.0 if amp < 0 else 1.0
    named = {NAMES[a].lower(): float(b) for a, b in fix.items() if not (SP0 <= a <= SP7)}
    par.update(named)
    return dict(name=name, key=key, sg=sg, amp=abs(amp), lim=lim, fix=fix, tab=tab, temp=temp, par=par)


def set_effects(specs, mc, T0):
    E = np.zeros(NE)
    tab = np.zeros(2)
    delay = 0.0
    E[STR_V] = E[LAG_V] = 1.0
    for s in specs:
        for a, b in s["fix"].items():
            E[a] = b
        if s["tab"] is not None:
            tab = s["tab"]
        a = s["sg"] * s["amp"]
        if s["key"] == "delay":
            delay = a
        elif s["key"] == "compl":
            m1 = E[TWO_M1]
            m2 = mc["M"] - m1
            kk = 1 / abs(a)
            E[TWO_K] = kk
            E[TWO_C] = 2 * s["par"]["zeta"] * math.sqrt(kk * m1 * m2 / mc["M"])
        else:
            E[s["key"]] = a
    E[TH_T0] = T0
    return E, tab, delay
