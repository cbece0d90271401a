"""Check the simulator itself: half the step, the nominal model's own rest, sizes.

    python check.py --seed 1

For each trial the final run is repeated at half the integration step.  Printed are
the difference of the position against the position's deviation and against the
presliding distance, the difference of the effort against its deviation, and both
shares of the effect.
"""

import argparse
from collections import Counter

import numpy as np

import motions
import sizing
import trials


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("--seed", type=int, default=1)
    ap.add_argument("--n-clean", type=int, default=30)
    ap.add_argument("--n-effect", type=int, default=34)
    ap.add_argument("--n-strange", type=int, default=12)
    a = ap.parse_args()
    print("trial what machine law effects | dx/std dx/xs du/std share share(h/2) rest without effect")
    rows = []
    for i, what, wanted, r, _ in trials.make(a.seed, a.n_clean, a.n_effect, a.n_strange, Counter()):
        s, out = r["s"], r["out"]
        fine = sizing.run(s, r["effects"], 2)
        w = max(1, int(0.002 / s["cfg"]["tick"]))
        x, xf = out[:, 0], fine[:, 0]
        u, uf = motions.smooth(out[:, 3], w), motions.smooth(fine[:, 3], w)
        dx, du = sizing.rms(x - xf), sizing.rms(u - uf) / np.std(u)
        q, qf = r["total"], sizing.share(s, fine, r["effects"])
        rest = sizing.share(s, r["base"], [])
        names = "+".join(n for n, _ in wanted)
        rows.append((dx / np.std(x), du, abs(qf / q - 1) if wanted else 0.0))
        m = s["m"]
        head = f"{i:3d} {what:7s} {m['kind']:18s} {m['law']:14s} {names:34s} {s['cfg']['mode']:8s}"
        print(
            head,
            f"| {dx / np.std(x):.1e} {dx / m['xs']:.1e} {du:.1e} {q:.4f} {qf:.4f} {rest:.1e}",
            flush=True,
        )
    rows = np.array(rows)
    for name, c in zip(("dx/std", "du/std", "share"), rows.T, strict=True):
        print(
            name,
            "median",
            f"{np.median(c):.1e}",
            "90 %",
            f"{np.quantile(c, 0.9):.1e}",
            "max",
            f"{c.max():.1e}",
        )


if __name__ == "__main__":
    main()
