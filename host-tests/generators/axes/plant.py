"""The axis and its friction, stepped in time: hysteresis laws, effects, strangers, controller."""

import math

import numpy as np
from numba import njit
from vector import *


@njit(cache=True, fastmath=False)
def hyst(fam, st, dx, k, lim, lp, mp, mn, jit):
    """advance hysteresis by dx; returns (force, tangent stiffness of what still sticks)"""
    if fam == 0 or fam == 4:
        F = 0.0
        K = 0.0
        for i in range(k.size):
            f = st[i] + k[i] * dx
            li = lim[i] * jit[i]
            u = li * mp
            l = -li * mn
            if f > u:
                f = u
            elif f < l:
                f = l
            else:
                K += k[i]
            st[i] = f
            F += f
        return F, K
    s = lp[0]
    Fc = lp[1]
    F = st[0]
    if dx == 0.0:
        return F, s
    sg = 1.0 if dx > 0 else -1.0
    m = mp if dx > 0 else mn
    Fs = Fc * m
    if fam == 1:
        F = sg * Fs + (F - sg * Fs) * math.exp(-s * abs(dx) / Fs)
        K = s * (1 - sg * F / Fs)
        if K < 0:
            K = 0.0
        st[0] = F
        return F, K
    n = int(abs(dx) * s / Fs / 0.05) + 1
    if n > 40:
        n = 40
    h = dx / n
    K = s
    for _ in range(n):
        if fam == 2:
            z = abs(F)
            zb = lp[2] * Fs
            al = 0.0
            if F * sg > 0:
                if z >= Fs:
                    al = 1.0
                elif z > zb:
                    al = 0.5 + 0.5 * math.sin(math.pi * (z - 0.5 * (Fs + zb)) / (Fs - zb))
            K = s * (1 - al * sg * F / Fs)
        else:
            r = abs(F) / Fs
            if r > 1:
                r = 1.0
            K = (
                s * (1 - r ** lp[2] * (lp[3] + (1 - lp[3]) * (-1.0 if F * sg < 0 else 1.0) * 1.0))
                if False
                else s * (1 - r ** lp[2] * (lp[3] * (1.0 if F * sg > 0 else -1.0) + (1 - lp[3])))
            )
        F += K * h
        if F > Fc * mp:
            F = Fc * mp
        if F < -Fc * mn:
            F = -Fc * mn
    if K < 0:
        K = 0.0
    st[0] = F
    return F, K


@njit(cache=True)
def virgin(fam, k, lim, lp, dx, n):
    st = np.zeros(max(k.size, 1))
    jit = np.ones(max(k.size, 1))
    out = np.zeros(n + 1)
    for i in range(n):
        out[i + 1], _ = hyst(fam, st, dx, k, lim, lp, 1.0, 1.0, jit)
    return out


@njit(cache=True)
def sim(seed, xr, vr, ar, seg, Tt, nsub, dt, C, M, F0, sp_, amax, fam, k, lim, lp, taud, rn, gains, E, ptab):
    np.random.seed(seed)
    N = xr.size
    oxq = np.zeros(N)
    ou = np.zeros(N)
    ores = np.zeros(N)
    oxt = np.zeros(N)
    oF = np.zeros(N)
    nk = max(k.size, 1)
    st = np.zeros(nk)
    s2 = np.zeros(nk)
    jit = np.ones(nk)
    j0 = np.ones(nk)
    j1 = np.ones(nk)
    # rn: sigma, corr length, bristle sigma
    rs = rn[0]
    h = rn[1] / 6.0
    rho = math.exp(-1 / 6.0)
    rq = math.sqrt(1 - rho * rho)
    bs = rn[2]
    r0 = np.random.normal() * rs
    r1 = rho * r0 + rq * rs * np.random.normal()
    rp = 0.0
    if fam == 4:
        for i in range(nk):
            j0[i] = 1 + bs * np.random.normal()
            j1[i] = 1 + rho * (j0[i] - 1) + rq * bs * np.random.normal()
    g = gains[seg[0]]
    q = C[0]
    Kp = C[1]
    Kv = C[2]
    wi = C[3]
    af = C[4]
    mff = C[5]
    ff = C[6]
    tauc = C[7]
    sat = C[8]
    vff = C[9]
    x = xr[0]
    v = 0.0
    x1 = x
    v1 = 0.0
    two = E[TWO] > 0
    m1 = E[TWO_M1]
    m2 = M - m1
    fm = E[TWO_FM]
    zm = 0.0
    xqp = q * math.floor(x / q + 0.5)
    ve = 0.0
    I = 0.0
    u = 0.0
    uc = 0.0
    xmp = x
    vmp = 0.0
    if E[ENC_A] != 0.0:
        xmp = x + E[ENC_A] * (
            math.sin(2 * math.pi * x / E[ENC_P] + E[ENC_PH])
            + E[ENC_A2] * math.sin(4 * math.pi * x / E[ENC_P] + E[ENC_PH2])
        )
    vm_old = 0.0
    path = 0.0
    tr = 0.0
    vl = 0.0
    uf = 0.0
    F = 0.0
    K = 0.0
    S = int(E[STR_ID])
    A = E[STR_AMP]
    p0 = E[SP0]
    p1 = E[SP1]
    p2 = E[SP2]
    p3 = E[SP3]
    p4 = E[SP4]
    ss = np.zeros(12)
    dirn = 1.0
    ext = x
    xrev = x
    trev = -10.0
    plen = 0.0
    drev = 3 * sp_
    if S == 5:
        ss[0] = p0 * -math.log(np.random.random() + 1e-12)
    if S == 3:
        ss[0] = x
    if S == 8:
        ss[0] = x + p0
    if S == 10:
        ss[0] = -p0 * math.log(np.random.random() + 1e-12)
    npt = ptab.size
    mp = 1.0
    mn = 1.0
    for n in range(N):
        # ---------------- controller tick
        xm = xmp
        xq = q * math.floor(xm / q + 0.5)
        d = (xq - xqp) / TC
        xqp = xq
        ve += af * (d - ve)
        oxq[n] = xq
        ou[n] = u
        oxt[n] = x
        oF[n] = F
        e = xr[n] - xq
        ev = vr[n] + Kp * e - ve
        ucn = mff * ar[n] + Kv * ev + I + ff * F0 * math.tanh(vr[n] / vff)
        if abs(ucn) < sat:
            I += wi * Kv * ev * TC
        uc = min(max(ucn, -sat), sat)
        su = 0.0
        sh = 0.0
        gt = gains[seg[n]]
        for j in range(nsub):
            t = n * TC + j * dt
            u += (uc - u) * dt / tauc
            # ---------------- multipliers
            m = 1.0
            fx = 0.0
            av = abs(v)
            if E[VISC] != 0.0:
                fx += E[VISC] * v
            if E[QUAD] != 0.0:
                fx += E[QUAD] * v * av
            if E[STR_A] != 0.0:
                m *= 1 + E[STR_A] * math.exp(-((av / E[STR_V]) ** E[STR_D]))
            fx += E[CONST]
            if E[SPR_K] != 0.0:
                fx += E[SPR_K] * (x - E[SPR_X])
            if E[POSF] != 0.0:
                w = (x - E[POS_LO]) / (E[POS_HI] - E[POS_LO]) * (npt - 1)
                if w < 0:
                    w = 0.0
                if w > npt - 1.001:
                    w = npt - 1.001
                iw = int(w)
                m *= 1 + E[POSF] * (ptab[iw] + (w - iw) * (ptab[iw + 1] - ptab[iw]))
            if E[SPOT_A] != 0.0:
                w = abs(x - E[SPOT_X]) / E[SPOT_W]
                b = 0.0
                if E[SPOT_K] == 0:
                    b = math.exp(-w * w)
                elif E[SPOT_K] == 1:
                    b = 0.5 * (1 - math.tanh((w - 1) / 0.12))
                else:
                    b = max(0.0, 1 - 0.7 * w)
                m *= 1 + E[SPOT_A] * b
            if E[PF_A] != 0.0:
                ph = 2 * math.pi * x / E[PF_P]
                fx += E[PF_A] * (math.sin(ph + E[PF_PH]) + E[PF_A2] * math.sin(2 * ph + E[PF_PH2]))
            if E[PM_A] != 0.0:
                ph = 2 * math.pi * x / E[PM_P]
                m *= 1 + E[PM_A] * (math.sin(ph + E[PM_PH]) + E[PM_A2] * math.sin(2 * ph + E[PM_PH2]))
            if E[TH_B] != 0.0:
                m *= 1 + E[TH_B] * (Tt[n] - E[TH_T0])
            if E[RUN_A] != 0.0:
                m *= 1 + E[RUN_A] * math.exp(-path / E[RUN_S])
            if E[AGE_A] != 0.0:
                if av < E[AGE_V]:
                    tr += dt
                m *= 1 + E[AGE_A] * math.log10(1 + tr / E[AGE_T0])
            if E[VIB_A] != 0.0:
                fx += E[VIB_A] * math.sin(E[VIB_W] * t + E[VIB_PH])
            if E[LOAD_A] != 0.0:
                uf += (abs(u) - uf) * dt / 0.003
                m *= 1 + E[LOAD_A] * uf / F0
            if E[LAG_A] != 0.0:
                vl += (av - vl) * dt / E[LAG_TAU]
                m *= 1 + E[LAG_A] * math.exp(-vl / E[LAG_V])
            # ---------------- strangers
            ufac = 1.0
            if S > 0:
                rev = False
                if dirn > 0:
                    if x > ext:
                        ext = x
                    if x < ext - drev:
                        rev = True
                else:
                    if x < ext:
                        ext = x
                    if x > ext + drev:
                        rev = True
                if rev:
                    plen = abs(ext - xrev)
                    xrev = ext
                    trev = t
                    dirn = -dirn
                    ext = x
                adx = av * dt
                if S == 1:  # grease bow wave and the deposits left at stroke ends
                    ss[0] += adx / p0 * (1 - ss[0])
                    if rev:
                        sl = 1 if dirn < 0 else 3
                        ss[sl] = max(ss[sl], ss[0])
                        ss[sl + 1] = xrev
                        ss[0] = 0.0
                    b1 = math.exp(-(((x - ss[2]) / p1) ** 2))
                    b2 = math.exp(-(((x - ss[4]) / p1) ** 2))
                    m += A * (ss[0] + p2 * (ss[1] * b1 + ss[3] * b2))
                    ss[1] *= 1 - min(0.5, b1 * adx / (6 * p1))
                    ss[3] *= 1 - min(0.5, b2 * adx / (6 * p1))
                elif S == 2:  # friction rises with recent acceleration
                    ss[0] += (abs(ar[n]) / amax - ss[0]) * dt / p0
                    m += A * ss[0]
                elif S == 3:  # hose that sticks and slips on its tray: saw-tooth force
                    f = (x - ss[0]) / p0
                    if ss[1] == 0.0 and abs(f) > ss[2] + 1.0:
                        ss[1] = 1.0
                    if ss[1] == 1.0:
                        ss[0] += (x - ss[0]) * dt / 0.015
                        if abs(f) < p1:
                            ss[1] = 0.0
                            ss[2] = 0.35 * np.random.normal()
                            if ss[2] < -0.5:
                                ss[2] = -0.5
                    fx += A * F0 * f
                elif S == 4:  # seal at one end turns after N passes
                    b = (x - p0) * p3 / p1
                    if b > 0.3 and ss[1] == 0.0:
                        ss[1] = 1.0
                        ss[0] += 1
                    if b < 0:
                        ss[1] = 0.0
                    if ss[0] > p2 and b > 0:
                        m += A * math.tanh(b) * min(3.0, 1.0 + 0.15 * (ss[0] - p2))
                elif S == 5:  # balls jam at random in the return channel
                    if path > ss[0] and ss[1] == 0.0:
                        ss[1] = path
                        ss[2] = -math.log(np.random.random() + 1e-12)
                        ss[3] = p1 * (0.5 + np.random.random())
                    if ss[1] > 0:
                        w = (path - ss[1]) / ss[3]
                        if w < 1:
                            m += A * ss[2] * (w if w < 0.8 else (1 - w) * 4)
                        else:
                            ss[1] = 0.0
                            ss[0] = path - p0 * math.log(np.random.random() + 1e-12)
                elif S == 6:  # amplifier fades with heat
                    ss[0] += ((u / F0) ** 2 - ss[0]) * dt / p0
                    ufac = 1 / (1 + A * ss[0])
                elif S == 7:  # cable chain: direction and time since reversal
                    ts = t - trev
                    fx += A * F0 * dirn * (math.exp(-ts / p0) - p1) * (1 - math.exp(-ts / 0.02))
                elif S == 8:  # chip pushed ahead, creeps back
                    ss[0] -= p1 * dt
                    if x > ss[0]:
                        ss[0] = x
                    w = (ss[0] - x) / p2
                    m += A * math.exp(-w * w)
                elif S == 9:  # viscoelastic wiper (Maxwell element)
                    ss[0] += v * dt / p0 - ss[0] * dt / p1
                    fx += A * F0 * math.tanh(ss[0])
                elif S == 10:  # lubricant film with two states
                    if t > ss[0]:
                        ss[0] = t - p0 * math.log(np.random.random() + 1e-12)
                        ss[1] = 1 - ss[1]
                    ss[2] += (ss[1] - ss[2]) * dt / 0.06
                    m += A * ss[2]
                elif S == 11:  # brake opens late after a rest
                    if abs(vr[n]) < 1e-12:
                        ss[0] += dt
                        if ss[0] > p1:
                            ss[1] = 1.0
                    else:
                        if ss[0] > 0 and ss[1] > 0.5:
                            ss[2] = t
                        ss[0] = 0.0
                        if t > ss[2] + p0:
                            ss[1] -= ss[1] * dt / 0.05
                    m += A * ss[1]
                elif S == 12:  # lubrication pressure pulses with wandering frequency
                    if j == 0:
                        ss[1] += -ss[1] * TC / 3.0 + math.sqrt(2 * TC / 3.0) * 0.15 * np.random.normal()
                    ss[0] += 2 * math.pi * p0 * (1 + ss[1]) * dt
                    m += A * math.sin(ss[0])
                elif S == 13:  # friction remembers the length of the previous stroke
                    m += A * min(1.5, plen / p0)
                elif S == 14:  # ripple of a belt whose teeth creep with the path
                    fx += A * F0 * math.sin(2 * math.pi * (x + p1 * path) / p0 + p2)
                elif S == 15:  # tilting carriage: lever arm times direction
                    m += A * dirn * (x - p0) / p1
                elif S == 16:  # loose cover plate: dragged with play, own mass hitting stops
                    ss[1] += (-ss[1] / p2) * dt
                    ss[0] += ss[1] * dt
                    gpr = x - ss[0]
                    f = 0.0
                    if gpr > p0:
                        f = (gpr - p0) * p1 + 0.3 * math.sqrt(p1 * p3) * (v - ss[1])
                    elif gpr < -p0:
                        f = (gpr + p0) * p1 + 0.3 * math.sqrt(p1 * p3) * (v - ss[1])
                    sgv = math.tanh(ss[1] / p4)
                    ss[1] += dt * (f - A * F0 * sgv) / p3
                    fx += f
            if m < 0.15:
                m = 0.15
            # ---------------- never repeating friction along the path
            gs = 1 + r0 + (r1 - r0) * rp
            g += (gt - g) * dt / 0.03
            gs *= g
            if gs < 0.2:
                gs = 0.2
            mp = m * gs * (1 + E[ASYM])
            mn = m * gs * (1 - E[ASYM])
            # ---------------- dynamics
            if not two:
                v += dt * (u * ufac - F - taud * K * v - fx) / M
                x += v * dt
                dxl = v * dt
                xm = x
            else:
                gap = 0.5 * E[TWO_GAP]
                dl = x1 - x
                fc = 0.0
                if dl > gap:
                    fc = E[TWO_K] * (dl - gap) + E[TWO_C] * (v1 - v)
                elif dl < -gap:
                    fc = E[TWO_K] * (dl + gap) + E[TWO_C] * (v1 - v)
                if E[TWO_GAP] > 0:
                    if dl > gap and fc < 0:
                        fc = 0.0
                    if dl < -gap and fc > 0:
                        fc = 0.0
                sm = 4.6 * fm * F0 / sp_
                if fm > 0:
                    zd = v1 * dt
                    sgz = 1.0 if zd > 0 else -1.0
                    zm = sgz * fm * F0 + (zm - sgz * fm * F0) * math.exp(-sm * abs(zd) / (fm * F0))
                v1 += (
                    dt
                    * (u * ufac - fc - zm - (0.02 * math.sqrt(sm * m1) * v1 if abs(zm) < 0.9 * fm * F0 else 0.0))
                    / m1
                )
                v += dt * (fc - (1 - fm) * (F + taud * K * v) - fx) / m2
                x1 += v1 * dt
                x += v * dt
                dxl = v * dt
                xm = x1 if E[TWO_ENC] == 0 else x
            adx = abs(dxl)
            path += adx
            if E[AGE_A] != 0.0:
                tr *= math.exp(-adx / E[AGE_D])
            rp += adx / h
            while rp >= 1.0:
                rp -= 1.0
                r0 = r1
                r1 = rho * r0 + rq * rs * np.random.normal()
                if fam == 4:
                    for i in range(nk):
                        j0[i] = j1[i]
                        j1[i] = max(0.3, 1 + rho * (j0[i] - 1) + rq * bs * np.random.normal())
            if fam == 4:
                for i in range(nk):
                    jit[i] = j0[i] + (j1[i] - j0[i]) * rp
            F, K = hyst(fam, st, dxl, k, lim, lp, mp, mn, jit)
            if E[ENC_A] != 0.0:
                ph = 2 * math.pi * xm / E[ENC_P]
                xm = xm + E[ENC_A] * (math.sin(ph + E[ENC_PH]) + E[ENC_A2] * math.sin(2 * ph + E[ENC_PH2]))
            dxs = xm - xmp
            F2, K2 = hyst(fam, s2, dxs, k, lim, lp, gs, gs, jit)
            sh += F2 + taud * K2 * dxs / dt
            su += u
            vmp = dxs / dt
            xmp = xm
        ores[n] = su / nsub - M * (vmp - vm_old) / TC - sh / nsub
        vm_old = vmp
        if not (abs(x) < 1e3):
            break
    return oxq, ou, ores, oxt, oF
