"""Write recordings of simulated drives: OUT/NNN/rec.csv, base.toml (some), label.json.

    python trials.py OUT --n-clean 30 --n-effect 34 --n-strange 12 --seed 1

The order is shuffled.  The same seed gives the same bytes.  Needs numpy and numba.
"""

import argparse
import json
import os
import pathlib
import time
from collections import Counter

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import build
import choose
import laws
import machines
import record
import sizing
from catalogue import KNOWN, STRANGE

SEVERITIES = [0.5, 1.0, 2.0]


def cycle(rng, items, n):
    """n items, each as often as the others, in random order."""
    out = []
    while len(out) < n:
        out += [items[i] for i in rng.permutation(len(items))]
    return out[:n]


def plan(rng, n_clean, n_effect, n_strange):
    """The list of trials: (what, [(effect, severity)])."""
    jobs = [("clean", [])] * n_clean
    n_pair = int(round(0.27 * n_effect))
    sev = cycle(rng, SEVERITIES, n_effect)
    for name, q in zip(cycle(rng, KNOWN, n_effect - n_pair), sev, strict=False):
        jobs.append(("single", [(name, q)]))
    for pair in cycle(rng, choose.PAIRS, n_pair):
        jobs.append(
            ("pair", [(pair[0], float(rng.choice([1.0, 2.0]))), (pair[1], float(rng.choice([1.0, 2.0])))])
        )
    for name, q in zip(cycle(rng, STRANGE, n_strange), cycle(rng, SEVERITIES, n_strange), strict=True):
        jobs.append(("unknown", [(name, q)]))
    return [jobs[i] for i in rng.permutation(len(jobs))]


def places(wanted):
    ok = list(choose.PLACE[wanted[0][0]][0]) if wanted else list(machines.KINDS)
    for name, _ in wanted[1:]:
        ok = [k for k in ok if k in choose.PLACE[name][0]]
    return ok


def label(what, wanted, r):
    m, cfg = r["s"]["m"], r["s"]["cfg"]
    effects = []
    for (name, sev), eff, q in zip(wanted, r["effects"], r["shares"], strict=True):
        effects.append(
            {
                "id": "unknown" if what == "unknown" else name,
                "raw": name,
                "severity": sev,
                "size": float(f"{eff[1]:.6g}"),
                "share": round(q, 4),
            }
        )
    lu = "rad" if m["rotary"] else "m"
    keys = ["mass", "level", "xs", "viscous", "count", "lead", "v", "a", "lo", "hi", "wander", "ripple"]
    params = {k: float(f"{m[k]:.6g}") for k in keys}
    # what every machine here has besides: the ripple of its motor, and a friction level that wanders in three waves
    params["wave_lengths"] = [float(f"{2 * np.pi / q:.6g}") for q in m["waves"][::2]]
    params |= {
        "length_unit": lu,
        "motor_period": m["lead"] / m["poles"],
        "rate_Hz": cfg["fs"],
        "seconds": cfg["sec"],
        "loop_Hz": 1 / cfg["tick"],
    }
    params |= {
        "law_numbers": [float(f"{q:.6g}") for q in m["lawp"]],
        "bandwidth_rad_s": float(f"{m['wb']:.5g}"),
        "stamps": cfg["how"],
    }
    params |= {
        "effort": cfg["effort"],
        "noise": float(f"{cfg['noise']:.3g}"),
        "base_fit": None if r["fit"] is None else round(r["fit"], 4),
    }
    params |= {
        "effect_numbers": [[float(f"{q:.6g}") for q in e[2]] for e in r["effects"]],
        "joint_share": round(r["total"], 4),
    }
    return {
        "kind": what,
        "law": m["law"],
        "effects": effects,
        "machine": m["kind"],
        "controller": cfg["mode"],
        "motion": cfg["kinds"],
        "params": params,
    }


def make(seed, n_clean, n_effect, n_strange, refused, verbose=False):
    """Build the trials one after the other: (number, what, wanted, result, its generator)."""
    rng = np.random.default_rng([seed, 7001])
    jobs = plan(rng, n_clean, n_effect, n_strange)
    law_list = cycle(rng, laws.NAMES, len(jobs))
    kind_list = cycle(rng, list(machines.KINDS), len(jobs))
    for i, (what, wanted) in enumerate(jobs):
        ok = places(wanted)
        for attempt in range(60):
            own = np.random.default_rng([seed, i, attempt])
            kind = ok[int(own.integers(0, len(ok)))] if wanted else kind_list[i]
            try:
                r = build.trial(own, kind, law_list[i], wanted)
                break
            except sizing.Reject as e:
                refused[f"{e}"] += 1
                if verbose:
                    print(i, kind, law_list[i], wanted, e, flush=True)
        else:
            raise SystemExit(f"trial {i}: {what} {wanted} found no machine")
        yield i, what, wanted, r, own


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("out", type=pathlib.Path)
    ap.add_argument("--n-clean", type=int, default=30)
    ap.add_argument("--n-effect", type=int, default=34)
    ap.add_argument("--n-strange", type=int, default=12)
    ap.add_argument("--seed", type=int, default=1)
    ap.add_argument("--verbose", action="store_true")
    a = ap.parse_args()
    begin = time.time()
    counts, refused = Counter(), Counter()
    for i, what, wanted, r, own in make(a.seed, a.n_clean, a.n_effect, a.n_strange, refused, a.verbose):
        d = a.out / f"{i:03d}"
        d.mkdir(parents=True, exist_ok=True)
        s = r["s"]
        record.write(d / "rec.csv", record.sample(s["m"], s["cfg"], r["out"], s["ref"], own, r["delay"]))
        (d / "base.toml").unlink(missing_ok=True)
        if r["toml"] is not None:
            (d / "base.toml").write_text(r["toml"])
        lab = label(what, wanted, r)
        (d / "label.json").write_text(json.dumps(lab, indent=1) + "\n")
        counts.update([what, lab["machine"], lab["law"]])
        counts["with base.toml"] += r["toml"] is not None
        if a.verbose:
            print(
                i, what, lab["machine"], lab["law"], cfg_line(lab), f"{time.time() - begin:.0f} s", flush=True
            )
    n = a.n_clean + a.n_effect + a.n_strange
    print(f"{n} trials in {time.time() - begin:.0f} s")
    print(dict(sorted(counts.items())))
    print("refused draws:", dict(refused))


def cfg_line(lab):
    e = [(q["raw"], q["severity"], q["share"]) for q in lab["effects"]]
    p = lab["params"]
    how = f"{lab['controller']} {lab['motion']} {p['rate_Hz']:.0f} Hz {p['seconds']} s"
    return f"{how} {e} fit {p['base_fit']}"


if __name__ == "__main__":
    main()
