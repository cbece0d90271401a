"""The oracle: can an effect be seen in the recorded data by one who knows its true column?

Recorded effort and all columns pass the same zero-phase low-pass.  The regression has acceleration, velocity,
the true friction law along the true motion, a constant, 12 stop columns, the other effect and the effect.
"seen" holds for 16 contiguous pieces of the record.  "seen_dealt" deals 64 chunks round to the 16 pieces: an effect
that lives in a few places of the record (run-in, saturation) cannot reach z = 3 over contiguous pieces.

"_fitted" is the same for one who knows the column of the effect but, as everybody who has only the record, not the
friction: in place of the true law it has the stop columns and curves of the speed, which it must fit.
"""
import numpy as np
from numba import njit
from scipy.signal import butter, sosfiltfilt

PIECES = 16


@njit(cache=True)
def stop_column(x, limit):
    out = np.zeros(x.size)
    for i in range(1, x.size):
        out[i] = min(limit, max(-limit, out[i - 1] + x[i] - x[i - 1]))
    return out / limit


def low_pass(columns, fs, cutoff):
    return sosfiltfilt(butter(3, cutoff / (0.5 * fs), output="sos"), columns, axis=0)


def shares(truth, machine):
    """Force share of each effect: RMS of what it adds over RMS of the base friction, after the low-pass."""
    smooth = low_pass(truth[:, 3:6], machine.fs, machine.cutoff)
    power = (smooth ** 2).mean(axis=0)
    return np.sqrt(power[1:] / power[0])


def verdict(x, effort, truth, machine, which, others, names):
    """Label entries of the verdict on the effect in truth column 4 + which."""
    known = judged(x, effort, truth, machine, which, others, names, [truth[:, 3]])
    speed = np.gradient(low_pass(x, machine.fs, machine.cutoff), 1 / machine.fs)
    curves = [np.tanh(speed / (part * machine.speed)) for part in (0.003, 0.01, 0.03, 0.1, 0.3)]
    fitted = judged(x, effort, truth, machine, which, others, names, curves)
    return known | {f"{key}_fitted": value for key, value in fitted.items()}


def judged(x, effort, truth, machine, which, others, names, friction):
    """The verdict of one who has these columns of the friction besides the stops."""
    fs, dt = machine.fs, 1 / machine.fs
    smooth_x = low_pass(x, fs, machine.cutoff)
    yields = np.geomspace(0.2 * machine.distance, min(30 * machine.distance, 0.05 * np.ptp(x)), 12)
    speed = np.gradient(smooth_x, dt)
    columns = [np.gradient(speed, dt)] + friction + [stop_column(smooth_x, limit) for limit in yields]
    if "viscous" not in names:      # a concealed viscous error: the velocity column is taken from the user's model
        columns.append(speed)
    else:
        effort = effort - machine.viscous * speed
    columns += [truth[:, 4 + i] for i in others] + [truth[:, 4 + which], effort]
    edge = int(0.5 * fs)
    data = low_pass(np.column_stack(columns), fs, machine.cutoff)[edge:-edge:max(1, int(fs / (5 * machine.cutoff)))]
    if not {"constant_force", "coulomb_asymmetry"} & {names[which]}:
        data = np.column_stack([np.ones(len(data)), data])
    data /= np.sqrt((data ** 2).mean(axis=0)) + 1e-300
    scale = np.sqrt((low_pass(truth[:, 4 + which], fs, machine.cutoff)[edge:-edge] ** 2).mean()) / np.sqrt(
        (low_pass(effort, fs, machine.cutoff)[edge:-edge] ** 2).mean())
    n = data.shape[1] - 1
    plain, full = np.arange(n - 1), np.arange(n)

    def solve(gram, use):
        return np.linalg.solve(gram[np.ix_(use, use)] + 1e-9 * len(data) * np.eye(use.size), gram[use, n])

    def left(gram, use, theta):
        return gram[n, n] - 2 * theta @ gram[use, n] + theta @ gram[np.ix_(use, use)] @ theta

    chunks = np.array([part.T @ part for part in np.array_split(data, 4 * PIECES)])
    total = chunks.sum(axis=0)
    coefficient = solve(total, full)[-1] / scale
    found = {}
    for suffix, pieces in (("", chunks.reshape(PIECES, 4, n + 1, n + 1).sum(axis=1)),
                           ("_dealt", chunks.reshape(4, PIECES, n + 1, n + 1).sum(axis=0))):
        before = np.array([left(g, plain, solve(total - g, plain)) for g in pieces])
        after = np.array([left(g, full, solve(total - g, full)) for g in pieces])
        drop = before - after
        z = float(drop.mean() / (drop.std(ddof=1) / np.sqrt(PIECES) + 1e-300))
        gain = float(drop.sum() / before.sum())
        found["seen" + suffix] = bool(z >= 3 and gain >= 0.05 and 0.6 <= coefficient <= 1.6)
        found["z" + suffix] = z
        found["oracle_gain" + suffix] = gain
    return found | {"oracle_coefficient": float(coefficient)}
