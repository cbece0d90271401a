"""Write simulated recordings of positioning machines with the truth about each.

    trials.py OUT --n-clean N --n-effect N --n-strange N --seed S [--only I]

Each OUT/NNN has rec.csv, label.json and, for a third of the machines, base.toml.
"""
import argparse
import json
from pathlib import Path

import numpy as np

import effects
import oracle
from effects import CATALOGUE, STRANGERS, STRUCTURAL
from machines import Machine
from plant import CODE, simulate

TARGET = {0.5: 0.04, 1: 0.09, 2: 0.18}
ALONE = [{"constant_force", "coulomb_asymmetry"}, {"stribeck", "frictional_lag"}, {"periodic_force", "encoder_error"},
         {"position_spring", "gravity"}, {"position_spring", "position_force"}, {"position_force", "gravity"},
         {"position_friction", "local_friction_spot"}, {"run_in", "thermal_drift"}]


class Rejected(Exception):
    """A draw that does not fit together: drawn again."""


def plan(seed, n_clean, n_effect, n_strange):
    """The kind and the effect names of every folder, in an order that tells nothing."""
    rng = np.random.default_rng([seed, 777])

    def cycle(names, n):
        return [str(x) for _ in range(n // len(names) + 1) for x in rng.permutation(names)][:n]
    n_pair, n_masked = round(0.25 * n_effect), round(0.15 * n_effect)
    jobs = [("clean", [])] * n_clean
    jobs += [("single", [name]) for name in cycle(CATALOGUE, n_effect - n_pair - n_masked)]
    for kind, n in (("pair", n_pair), ("masked", n_masked)):
        first, second = cycle(CATALOGUE, n), cycle(CATALOGUE, n)
        for a, b in zip(first, second):
            while a == b or {a, b} in ALONE or {a, b} <= STRUCTURAL:
                b = str(rng.choice(CATALOGUE))
            jobs.append((kind, [a, b]))
    jobs += [("unknown", [name]) for name in cycle(STRANGERS, n_strange)]
    return [jobs[i] for i in rng.permutation(len(jobs))]


def run(machine, drawn, refine=1):
    """Simulate; returns recorded x, effort and the truth columns (with the delay of a channel, if drawn)."""
    codes, p, tables, waves = np.zeros(2, int), np.zeros((2, 8)), np.zeros((2, 512)), np.zeros((len(machine.ref), 2))
    for e, effect in enumerate(drawn):
        codes[e], p[e], tables[e] = CODE[effect.name], effect.p, effect.table
        if effect.wave is not None:
            waves[:, e] = effect.wave
    low, high = machine.ref[:, 0].min(), machine.ref[:, 0].max()
    margin = 0.05 * (high - low)
    grid = np.array([low - margin, (high - low + 2 * margin) / 511])
    law = machine.law
    out, truth = simulate(machine.plant(), machine.gains, machine.ref, law.kind, law.k, law.w, law.extra, codes, p,
                          tables, grid, machine.temperature, waves, machine.noise, machine.nsub * refine)
    if not np.isfinite(out).all() or np.abs(out[-1]).max() == 0:
        raise Rejected("diverged")
    x, effort = out.T
    for e, effect in enumerate(drawn):
        if effect.name == "channel_delay":
            n = np.arange(len(x))
            late = np.interp(n - effect.p[0], n, effort)
            truth[:, 4 + e] = late - effort
            effort = late
    return x, effort, truth


def rough(effort, machine):
    """RMS of the effort above the band of the controller."""
    return (effort - oracle.low_pass(effort, machine.fs, machine.cutoff)).std()


def check_loop(machine, x, effort, clean_effort=None):
    """Reject a loop that rings or does not follow."""
    error = np.abs(machine.ref[:, 0] - x)
    friction = machine.level
    if error.max() > 0.1 * np.ptp(machine.ref[:, 0]) or error.std() > 0.05 * machine.ref[:, 0].std():
        raise Rejected("does not follow")
    if clean_effort is None:
        if rough(effort, machine) > 0.3 * friction:
            raise Rejected("noisy")
    elif rough(effort, machine) > 2 * rough(clean_effort, machine) + 0.08 * friction:
        raise Rejected("rings")


def scale(machine, drawn, targets, clean_effort):
    """Scale the strengths until each effect has its share; returns the last simulation and the shares."""
    past = None
    for effect in drawn:
        effect.p[0] = np.sign(effect.start) * np.clip(abs(effect.start), effect.low, effect.high)
    for _ in range(7):
        for effect in drawn:
            if effect.name == "actuator_saturation":
                effect.p[7] = effect.p[1] / effect.p[0]
        x, effort, truth = run(machine, drawn)
        share = oracle.shares(truth, machine)[:len(drawn)]
        now = np.log(np.abs([e.p[0] for e in drawn])), np.log(share + 1e-6)
        off = np.log(targets) - now[1]
        if np.abs(off).max() < 0.12:
            check_loop(machine, x, effort, clean_effort)
            return x, effort, truth, share
        slope = np.array([6.0 if e.name == "actuator_saturation" else 1.0 for e in drawn])
        if past is not None:
            with np.errstate(all="ignore"):
                slope = np.nan_to_num((now[1] - past[1]) / (now[0] - past[0]), nan=1.0, posinf=1.0, neginf=1.0)
        past = now
        step = np.clip(off / np.clip(slope, 0.4, 10.0), -1.8, 1.8)
        for effect, d in zip(drawn, step):
            wanted = abs(effect.p[0]) * np.exp(d)
            kept = np.clip(wanted, effect.low, effect.high)
            if kept == abs(effect.p[0]) and abs(d) > 0.12:
                raise Rejected("out of reach")
            effect.p[0] = np.sign(effect.p[0]) * kept
    raise Rejected("share not reached")


def draw_trial(seed, index, kind, names):
    """Draw until a machine, its motion and the effects fit together."""
    for attempt in range(400):
        rng = np.random.default_rng([seed, index, attempt])
        machine = Machine(rng)
        if not machine.ok:
            continue
        machine.with_base = index % 3 == 0 or "viscous" in names
        if not all(effects.suits(name, machine) for name in names):
            continue
        try:
            x, effort, truth = run(machine, [])
            check_loop(machine, x, effort)
            if (machine.mass * machine.ref[:, 2]).std() > 8 * truth[:, 3].std():
                raise Rejected("friction too small")
            drawn = [effects.draw(rng, name, machine, machine.ref, effort, machine.temperature) for name in names]
            severity = [float(rng.choice([0.5, 1, 2])) for _ in names]
            targets = [TARGET[s] for s in severity]
            if kind == "masked":
                severity = [float(rng.choice([1, 2])), 0.25]
                targets = [TARGET[severity[0]], TARGET[severity[0]] / 4]
            share = []
            if drawn:
                x, effort, truth, share = scale(machine, drawn, targets, effort)
        except Rejected:
            continue
        return rng, machine, drawn, severity, share, x, effort, truth, attempt
    raise RuntimeError(f"no draw fits for {index} {kind} {names}")


def label(kind, machine, drawn, severity, share, x, effort, truth):
    """The truth about a recording, with the oracle's verdict on each effect."""
    names, entries = [e.name for e in drawn], []
    params = machine.labels()
    for e, effect in enumerate(drawn):
        others = [i for i in range(len(drawn)) if i != e]
        verdict = oracle.verdict(x, effort, truth, machine, e, others, names)
        entries.append({"id": "unknown" if kind == "unknown" else effect.name, "raw": effect.name,
                        "severity": severity[e], "share": float(share[e])} | verdict)
        params |= {f"{effect.name}.{key}": value for key, value in effect.labels().items()}
        if effect.name == "viscous":
            params["viscous"] = machine.viscous + effect.p[0]
        if effect.name in ("position_force", "position_friction"):
            params[f"{effect.name}.profile"] = np.round(effect.table[::8], 5).tolist()
    return {"kind": kind, "law": machine.law.name, "machine": machine.kind, "motion": machine.motion,
            "effects": entries, "params": params}


def write_record(folder, rng, machine, drawn, x, effort):
    """rec.csv, with the optional columns drawn here."""
    n, length = ("Nm", "rad") if machine.rotary else ("N", "m")
    kind, force = ("angle", "torque") if machine.rotary else ("x", "force")
    columns = {"t_s": np.arange(len(x)) / machine.fs, f"{kind}_{length}": x, f"{force}_{n}": effort}
    if rng.uniform() < 0.6:
        columns[f"{kind}_ref_{length}"] = machine.ref[:, 0]
    thermal = any(e.name == "thermal_drift" for e in drawn)
    if rng.uniform() < (0.5 if thermal else 0.2):
        columns["temperature_C"] = np.round(machine.temperature + 0.05 * rng.normal(size=len(x)), 2)
    if rng.uniform() < 0.5:
        columns["segment"] = strokes(machine.ref[:, 1], 0.002 * machine.speed)
    formats = {"t_s": "%.6f", "segment": "%d", "temperature_C": "%.2f", f"{force}_{n}": "%.7g"}
    np.savetxt(folder / "rec.csv", np.column_stack(list(columns.values())) + 0.0, delimiter=",", comments="",
               header=",".join(columns), fmt=[formats.get(name, "%.12g") for name in columns])


def strokes(speed, threshold):
    """Number of the stroke: one more at each reversal of the reference."""
    moving = np.abs(speed) > threshold
    direction = np.sign(speed[moving])
    count = np.zeros(len(speed), int)
    count[np.flatnonzero(moving)[1:]] = np.diff(direction) != 0
    return np.cumsum(count)


def write_base(folder, rng, machine):
    """base.toml: the user's model, each number within 1 % of the truth."""
    def near(value):
        return value * (1 + 0.01 * rng.uniform(-1, 1))
    n, length = ("Nm", "rad") if machine.rotary else ("N", "m")
    blocks = machine.law.blocks(machine.law.extra[0] ** 2 / (2 * machine.acc) if machine.law.name == "tanh" else 0.0)
    text = ", ".join(f"{{ stiffness_{n}_per_{length} = {k:.6g}, weight = {w:.6f} }}" for k, w in blocks)
    (folder / "base.toml").write_text(
        'schema = "preslide.model/1"\n'
        f'motion = "{"rotary" if machine.rotary else "linear"}"\n\n[inertia]\n'
        f'{"inertia_kg_m2" if machine.rotary else "mass_kg"} = {near(machine.mass):.6g}\n\n[friction]\nkind = "gms"\n'
        f'breakaway_{n} = {near(machine.level):.6g}\nblocks = [ {text} ]\n'
        f'viscous_{n}_s_per_{length} = {near(machine.viscous):.6g}\n')


def write_trial(out, seed, index, kind, names):
    rng, machine, drawn, severity, share, x, effort, truth, attempt = draw_trial(seed, index, kind, names)
    effort = effort + machine.sensor_noise * rng.normal(size=len(effort))
    folder = Path(out) / f"{index:03d}"
    folder.mkdir(parents=True, exist_ok=True)
    write_record(folder, rng, machine, drawn, x, effort)
    if machine.with_base:
        write_base(folder, rng, machine)
    truths = label(kind, machine, drawn, severity, share, x, effort, truth)
    (folder / "label.json").write_text(json.dumps(truths, indent=1))
    verdicts = " ".join(f"{e['raw']}:{e['share']:.3f}:{'seen' if e['seen'] else 'hidden'}:z{e['z']:.1f}"
                        for e in truths["effects"])
    print(f"{index:03d} {kind} {machine.kind} {machine.law.name} {machine.motion} rows={len(x)} draws={attempt + 1} "
          f"{verdicts}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out")
    for name in ("clean", "effect", "strange"):
        parser.add_argument(f"--n-{name}", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    args = parser.parse_args()
    for index, (kind, names) in enumerate(plan(args.seed, args.n_clean, args.n_effect, args.n_strange)):
        if args.only is None or args.only == index:
            write_trial(args.out, args.seed, index, kind, names)


if __name__ == "__main__":
    main()
