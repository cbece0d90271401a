"""What a logger makes of a run: sampling, stamps, quantisation, noise, columns."""

import numpy as np


def at(row, t, tick):
    """Cubic interpolation of tick values at times t."""
    n = row.size
    i = np.clip((t / tick).astype(np.int64), 1, n - 3)
    r = t / tick - i
    a, b, c, d = row[i - 1], row[i], row[i + 1], row[i + 2]
    return b + 0.5 * r * (c - a + r * (2 * a - 5 * b + 4 * c - d + r * (3 * (b - c) + d - a)))


def held(row, t, tick):
    return row[np.clip((t / tick + 1e-6).astype(np.int64), 0, row.size - 1)]


def stamps(rng, n, fs, how):
    """(sampling instants, logged stamps, kept rows)"""
    t = np.arange(n) / fs
    true, log = t.copy(), t.copy()
    keep = np.ones(n, dtype=bool)
    if "jitter" in how:
        e = min(rng.uniform(0.005, 0.06) / fs, 1e-4) * np.clip(rng.normal(0, 1, n), -2.5, 2.5)
        log += e
        if how["jitter"] == "true":
            true += e
        log -= min(log[0], 0.0)
    if "lost" in how:
        keep = rng.random(n) >= how["lost"]
        if rng.random() < 0.3:  # and a burst
            i = int(rng.integers(n // 5, n - 60))
            keep[i : i + int(rng.integers(3, 25))] = False
        keep[0] = True
    return np.maximum(true, 0.0), log, keep


def sample(m, cfg, out, ref, rng, delay):
    """Columns of the recording.  delay > 0: the effort is logged late, < 0: the position."""
    tick, fs = cfg["tick"], cfg["fs"]
    n = int((out.shape[0] - 4) * tick * fs)
    true, log, keep = stamps(rng, n, fs, cfg["how"])
    tx = np.maximum(true + min(delay, 0.0), 0.0)
    tu = np.maximum(true - max(delay, 0.0), 0.0)
    whole = "jitter" not in cfg["how"]
    x = held(out[:, 1], tx, tick) if whole and delay >= 0 else at(out[:, 1], tx, tick)
    x = np.floor(x / m["count"] + 0.5) * m["count"]
    if cfg["effort"] == "command":
        row = out[:, 2]
        if cfg["late"]:
            row = np.concatenate([[0.0], row[:-1]])
        u = held(row, tu, tick)
    else:
        u = at(out[:, 3], tu, tick)
    dev = float(np.std(u))
    u = u + rng.normal(0, cfg["noise"] * dev, n)
    lsb = 2.6 * float(np.max(np.abs(u))) / 2 ** cfg["bits"]
    u = np.floor(u / lsb + 0.5) * lsb
    rot = m["rotary"]
    pos, eff, vel, pref = (
        ("q_rad", "torque_Nm", "qd_rad_s", "q_ref_rad") if rot else ("x_m", "force_N", "v_m_s", "x_ref_m")
    )
    cols = {"t_s": (log, "%.7f" if "jitter" in cfg["how"] else "%.6f"), pos: (x, "%.12g"), eff: (u, "%.7g")}
    add = cfg["columns"]
    if "ref" in add:
        cols[pref] = (held(ref[0], true, tick), "%.9g")
    if "vel" in add:
        cols[vel] = (held(out[:, 6], tx, tick), "%.6g")
    if "current" in add:
        kt = cfg["kt"]
        cols["current_A"] = ((u + rng.normal(0, 0.004 * dev, n)) / kt, "%.5g")
    if "voltage" in add:
        kt = cfg["kt"]
        v = held(out[:, 6], true, tick)
        cols["voltage_V"] = (u / kt * cfg["ohm"] + kt * v + rng.normal(0, 0.01 * dev / kt, n), "%.5g")
    if "temperature" in add:
        cols["temperature_C"] = (
            np.floor((held(cfg["heat"], true, tick) + rng.normal(0, 0.03, n)) / 0.0625 + 0.5) * 0.0625,
            "%.4f",
        )
    if cfg["other"] is not None:
        q = cfg["other_count"]
        cols["y_m"] = (np.floor(held(cfg["other"], true, tick) / q + 0.5) * q, "%.9g")
    if "random" in add:
        w = np.cumsum(rng.normal(0, 1, n)) / np.sqrt(fs) if rng.random() < 0.5 else rng.normal(0, 1, n)
        cols["aux_1"] = (w, "%.5g")
    if "status" in add:
        mv = np.abs(held(out[:, 5], true, tick)) > 0.02 * m["v"]
        cols["status"] = (np.where(mv, 3, 1), "%d")
    if "segment" in add:
        cols["segment"] = (held(cfg["seg"], true, tick), "%d")
        cols["repeat"] = (held(cfg["rep"], true, tick), "%d")
    head = list(cols)
    first, rest = head[:3], head[3:]
    if cfg["shuffle"]:
        rest = [rest[i] for i in rng.permutation(len(rest))]
    head = first + rest
    return {h: (cols[h][0][keep], cols[h][1]) for h in head}


def write(path, cols):
    rows = np.column_stack([np.asarray(c[0], dtype=float) for c in cols.values()])
    rows[rows == 0.0] = 0.0  # no minus zero
    line = ",".join(c[1] for c in cols.values()) + "\n"
    with open(path, "w", newline="\n") as f:
        f.write(",".join(cols) + "\n")
        for i in range(0, rows.shape[0], 4096):
            part = rows[i : i + 4096]
            f.write((line * part.shape[0]) % tuple(part.ravel().tolist()))
