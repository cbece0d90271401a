#!/usr/bin/env python3
"""Simulated recordings of positioning axes, with the truth about each.

usage: trials.py OUT --n-clean 60 --n-effect 60 --n-strange 24 --seed 5001 [--jobs 1] [--only I] [--segment-per-pass]
Writes OUT/NNN/rec.csv, base.toml and label.json. Needs numpy and numba.

Written by an agent that had read neither the diagnosis nor another generator of the project; it is to stay so.
"""

import argparse
import json
import math
import os
import time

import numpy as np
from effects import *
from machines import *
from motion import *
from plant import sim
from vector import *


def lowpass(y, f):
    n = max(1, int(0.45 / f / TC))
    kz = np.ones(n) / n
    return np.convolve(np.convolve(y, kz, "same"), kz, "same")


class Unstable(Exception):
    pass


def shift(u, d):
    if d == 0:
        return u
    t = np.arange(u.size) * TC
    return np.interp(t - d, t, u)


def run(mc, pg, rd, specs, seed, refine=1):
    E, tab, delay = set_effects(specs, mc, rd["T"][0])
    L = mc["law"]
    M = mc["M"]
    wps = math.sqrt(L["k0"] / (M - E[TWO_M1] if E[TWO] else M))
    wmax = max(wps, math.sqrt(E[TWO_K] / E[TWO_M1]) * 1.5 if E[TWO] else 0)
    nsub = 5
    for nsub in (5, 10, 20, 25):
        if wmax * TC / nsub <= 0.12:
            break
    nsub *= refine
    dt = TC / nsub
    wv = mc["wv"]
    C = np.array(
        [
            mc["q"],
            wv / rd["cp"],
            wv * M,
            wv / rd["ci"],
            1 - math.exp(-rd["cf"] * wv * TC),
            M * rd["mff"],
            rd["ff"],
            rd["tauc"],
            20 * mc["F0"] + 5 * M * pg["amax"],
            0.02 * pg["v1"] + mc["sp"],
        ]
    )
    taud = 2 * L["zeta"] / math.sqrt(L["k0"] / M)
    o = sim(
        seed,
        pg["xr"],
        pg["vr"],
        pg["ar"],
        pg["seg"],
        rd["T"],
        nsub,
        dt,
        C,
        M,
        mc["F0"],
        mc["sp"],
        pg["amax"],
        L["fam"],
        L["k"],
        L["lim"],
        L["lp"],
        taud,
        rd["rn"],
        rd["gains"],
        E,
        tab,
    )
    xq, u, res, xt, F = o
    if delay != 0:
        res = res + shift(u, delay) - u
    F0 = mc["F0"]
    hf = u - lowpass(u, 60)
    still = lowpass((np.abs(pg["vr"]) > 0).astype(float), 5) < 1e-9
    err = np.abs(xt - pg["xr"])
    ok = (
        np.isfinite(u).all()
        and np.isfinite(xt).all()
        and err.max() < 0.25 * (pg["hi"] - pg["lo"]) + 30 * mc["sp"]
        and np.sqrt(np.mean(hf**2)) < 0.25 * F0
        and np.abs(u).max() < 8 * F0 + 3 * M * pg["amax"]
    )
    if ok and still.sum() > 100:
        ok = np.sqrt(np.mean(hf[still] ** 2)) < 0.12 * F0
    rl = lowpass(res, 80)[400:-50]
    share = float(np.sqrt(np.mean(rl**2)) / F0)
    return dict(
        xq=xq,
        u=shift(u, delay),
        share=share,
        peak=float(np.quantile(np.abs(rl), 0.999) / F0),
        ok=bool(ok),
        res=res,
        xt=xt,
        F=F,
        dt=dt,
        hf=float(np.sqrt(np.mean(hf**2)) / F0),
        err_rms=float(np.sqrt(np.mean(err**2))),
        err_max=float(err.max()),
        wps_dt=wps * dt,
    )


def calibrate(mc, pg, rd, s, target, seed):
    sh = 0.0
    for it in range(4):
        o = run(mc, pg, rd, [s], seed)
        if not o["ok"]:
            if it == 0 and s["key"] != "delay":
                s["amp"] *= 0.4
                continue
            raise Unstable(s["name"])
        sh = o["share"]
        if abs(math.log(max(sh, 1e-9) / target)) < 0.15:
            break
        a = (
            s["amp"] * float(np.clip(target / max(sh, 1e-9), 0.1, 8))
            if s["key"] != TWO_GAP
            else s["amp"] * float(np.clip((target / max(sh, 1e-9)) ** 1.5, 0.1, 6))
        )
        a = float(np.clip(a, s["lim"][0], s["lim"][1]))
        if abs(a / s["amp"] - 1) < 0.03 or it == 3:
            break
        s["amp"] = a
    else:
        raise Unstable(s["name"])
    return sh


def make(outdir, idx, kind, law, names, sev, seed, a):
    t0 = time.time()
    last = None
    for attempt in range(12):
        r = np.random.default_rng([seed, idx, attempt])
        try:
            mc = draw_machine(r, law, names)
            pg = programme(r, mc, names)
            n = pg["xr"].size
            if not (40 <= n * TC <= 120):
                raise Unstable("length")
            M, F0 = mc["M"], mc["F0"]
            specs = [draw_effect(r, nm, mc, pg) for nm in names]
            # temperature: always drifts a little; thermal effect needs several kelvin
            dT = next((s["temp"]["dT"] for s in specs if s["temp"]), r.uniform(0.1, 3.0))
            tt = np.arange(n) * TC
            Tn = n * TC
            sh = r.choice(["exp", "lin", "sin", "updown"])
            T0 = r.uniform(18, 27)
            tau = Tn * r.uniform(0.2, 0.6)
            T = {
                "exp": 1 - np.exp(-tt / tau),
                "lin": tt / Tn,
                "sin": np.sin(2 * np.pi * tt / Tn * r.uniform(0.4, 1.6)),
                "updown": np.minimum(tt / (0.6 * Tn), 1) - 0.7 * np.clip((tt - 0.6 * Tn) / (0.4 * Tn), 0, 1),
            }[str(sh)]
            T = T0 + dT * T * (1 if r.random() < 0.85 else -1)
            rd = dict(
                T=T,
                rn=np.array([r.uniform(0.01, 0.06), min(logu(r, 5e-5, 1e-3), 0.05 * mc["L"]), r.uniform(0.05, 0.15)]),
                gains=1 + r.uniform(0.005, 0.02) * r.normal(size=pg["nseg"]),
                cp=r.uniform(3.2, 5.5),
                ci=r.uniform(3.0, 6.0),
                cf=r.uniform(4, 7),
                mff=r.uniform(0.8, 1.05),
                ff=float(r.choice([0, 0, 0, 0.5, 0.8])),
                tauc=r.uniform(1e-4, 3.5e-4),
            )
            if law == "bristle":
                rd["rn"][0] *= 0.6
            sseed = int(r.integers(1, 2**31 - 1))
            fs_div = int(r.choice([4, 5, 6, 8]))
            for w in range(4):
                o = run(mc, pg, rd, [], sseed)
                if o["ok"]:
                    break
                mc["wv"] *= 0.7
            else:
                raise Unstable("clean")
            base = o["share"]
            shares = []
            target0 = []
            for s in specs:
                tg = r.uniform(0.06, 0.13) * sev
                target0.append(tg)
                shares.append(calibrate(mc, pg, rd, s, tg, sseed))
                if shares[-1] < 0.35 * tg and s["name"] not in (
                    "dwell_aging",
                    "drive_compliance",
                    "encoder_error",
                    "channel_delay",
                ):
                    raise Unstable("too weak " + s["name"])
                if shares[-1] < 0.012 * sev:
                    raise Unstable("negligible " + s["name"])
            if specs:
                o = run(mc, pg, rd, specs, sseed)
            if not o["ok"]:
                raise Unstable("final")
            break
        except Unstable as e:
            last = e
            continue
    else:
        raise RuntimeError(f"trial {idx}: {names} {last}")
    # ---------------- recording
    sel = slice(0, n, fs_div)
    t = tt[sel]
    m = t.size
    sg = F0 * logu(r, 5e-4, 1e-2)
    col = np.zeros(m)
    al = math.exp(-TC * fs_div / r.uniform(0.01, 0.05))
    z = r.normal(size=m)
    acc = 0.0
    qn = math.sqrt(1 - al * al)
    for i in range(m):
        acc = al * acc + qn * z[i]
        col[i] = acc
    force = o["u"][sel] + 0.95 * sg * r.normal(size=m) + 0.3 * sg * col
    Tm = np.round(T[sel] + r.uniform(0.01, 0.06) * r.normal(size=m), 2)
    seg = pg["seg"][sel] if not a.segment_per_pass else pg["seg"][sel] % pg["per"]
    d = os.path.join(outdir, f"{idx:03d}")
    os.makedirs(d, exist_ok=True)
    dec = max(3, 5 - int(math.floor(math.log10(F0))))
    fmt = f"%.6f,%.11g,%.11g,%.{dec}f,%.2f,%d,%d"
    xs, rs = o["xq"][sel].tolist(), pg["xr"][sel].tolist()
    with open(os.path.join(d, "rec.csv"), "w") as f:
        f.write("t_s,x_m,x_ref_m,force_N,temperature_C,segment,repeat\n")
        f.write(
            "\n".join(
                fmt % row
                for row in zip(t.tolist(), xs, rs, force.tolist(), Tm.tolist(), seg.tolist(), pg["rep"][sel].tolist())
            )
        )
        f.write("\n")
    br, kk, w = fit_blocks(r, mc["law"], F0, mc["sp"])
    mass = M * (1 + r.uniform(-0.009, 0.009))
    with open(os.path.join(d, "base.toml"), "w") as f:
        f.write(
            'schema = "preslide.model/1"\nmotion = "linear"\n[inertia]\nmass_kg = %.6g\n[friction]\nkind = "gms"\nbreakaway_N = %.6g\nblocks = [ '
            % (mass, br)
        )
        f.write(
            ", ".join("{ stiffness_N_per_m = %.6g, weight = %.5f }" % (x, y) for x, y in zip(kk, w))
            + " ]\nviscous_N_s_per_m = 0.0\n[mechanics]\n"
        )
        for nme in ("screw_lead_m", "motor_period_m", "encoder_period_m", "encoder_count_m"):
            if nme in mc["mech"]:
                f.write("%s = %.10g\n" % (nme, mc["mech"][nme]))
    P = dict(
        rms_share=[round(x, 4) for x in shares] if len(shares) > 1 else (round(o["share"], 4) if shares else 0.0),
        rms_share_all=round(o["share"], 4),
        peak_share=round(o["peak"], 4),
        target_share=[round(x, 4) for x in target0],
        base_residual_share=round(base, 6),
        machine=mc["mt"],
        drive=mc["drive"],
        mass_kg=M,
        level_N=F0,
        travel_m=mc["L"],
        presliding_m=mc["sp"],
        count_m=mc["q"],
        law=mc["law"]["info"],
        k0_N_per_m=mc["law"]["k0"],
        velocity_loop_Hz=mc["wv"] / 6.2832,
        random_friction=float(rd["rn"][0]),
        corr_length_m=float(rd["rn"][1]),
        bristle_sigma=float(rd["rn"][2]) if law == "bristle" else 0.0,
        stroke_gain_sigma=float(np.std(rd["gains"])),
        noise_N=sg,
        sample_Hz=1 / TC / fs_div,
        duration_s=n * TC,
        repeats=pg["R"],
        v_max=float(np.abs(pg["vr"]).max()),
        step_s=o["dt"],
        track_rms_m=o["err_rms"],
        track_max_m=o["err_max"],
        control_ripple=o["hf"],
        sim_seed=sseed,
        attempts=attempt + 1,
        effects={
            s["name"]: dict(
                amplitude=s["sg"] * s["amp"],
                parameter=(NAMES[s["key"]].lower() if isinstance(s["key"], int) else s["key"]),
                **s["par"],
            )
            for s in specs
        },
    )
    lab = dict(
        kind=kind,
        law=law,
        effects=[dict(id="unknown" if kind == "unknown" else s["name"], raw=s["name"], severity=sev) for s in specs],
        params=P,
    )
    json.dump(lab, open(os.path.join(d, "label.json"), "w"), indent=1, default=float)
    print(
        f"{idx:03d} {kind:7s} {law:18s} {'+'.join(names) or '-':45s} sev {sev} share {[round(x, 3) for x in shares]} all {o['share']:.3f} base {base:.1e} err {o['err_rms'] / mc['sp']:.2f}sp hf {o['hf']:.3f} T {n * TC:.0f}s try {attempt + 1} {time.time() - t0:.1f}s",
        flush=True,
    )
    return dict(mc=mc, pg=pg, rd=rd, specs=specs, seed=sseed, o=o)


def plan(a):
    r = np.random.default_rng([a.seed, 777])
    jobs = []
    off = int(r.integers(8))
    for i in range(a.n_clean):
        jobs.append(("clean", LAWS[(i + off) % 8], [], 1.0))
    npair = a.n_effect // 4
    ns = a.n_effect - npair
    seq = []
    while len(seq) < ns:
        seq += list(r.permutation(EFFECTS))
    cnt = {e: int(r.integers(3)) for e in EFFECTS}
    for i, e in enumerate(seq[:ns]):
        s = (1.0, 2.0, 0.5)[cnt[e] % 3]
        cnt[e] += 1
        jobs.append(("single", LAWS[(i + off) % 8] if i % 2 else str(r.choice(LAWS)), [str(e)], s))
    bad = [{"drive_compliance", "backlash"}, {"stribeck", "frictional_lag"}]
    pool = []
    for i in range(npair):
        while True:
            if len(pool) < 2:
                pool = list(r.permutation(EFFECTS)) + pool
            p = [str(pool.pop()), str(pool.pop())]
            if set(p) not in bad and p[0] != p[1]:
                break
        jobs.append(("pair", str(r.choice(LAWS)), p, 1.0))
    seq = []
    while len(seq) < a.n_strange:
        seq += list(r.permutation(STRANGERS))
    for i, e in enumerate(seq[: a.n_strange]):
        jobs.append(("unknown", LAWS[(i + off) % 8], [str(e)], (1.0, 2.0)[int(r.random() < 0.35)]))
    o = r.permutation(len(jobs))
    return [jobs[i] for i in o]


def one(x):
    try:
        return make(*x) and None
    except RuntimeError as e:
        print("FAILED", e, flush=True)


def main():
    p = argparse.ArgumentParser()
    p.add_argument("out")
    p.add_argument("--n-clean", type=int, default=60)
    p.add_argument("--n-effect", type=int, default=60)
    p.add_argument("--n-strange", type=int, default=24)
    p.add_argument("--seed", type=int, default=5001)
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--only", type=int, nargs="*")
    p.add_argument("--segment-per-pass", action="store_true", help="segment numbers start again in each pass")
    a = p.parse_args()
    os.makedirs(a.out, exist_ok=True)
    work = [(a.out, i, k, l, n, s, a.seed, a) for i, (k, l, n, s) in enumerate(plan(a)) if not a.only or i in a.only]
    if a.jobs > 1:
        import multiprocessing as mp

        with mp.Pool(a.jobs) as pool:
            list(pool.imap_unordered(one, work))
    else:
        for w in work:
            one(w)


if __name__ == "__main__":
    main()
