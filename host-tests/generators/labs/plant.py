"""Closed-loop simulation of one axis with up to two concealed effects.

Semi-implicit steps between the control samples.  Besides the recorded channels the simulation returns
"truth" columns, all averaged over a hold of the command: base friction along the measured motion and, for
each effect, the force that must be added to the machine's plain inverse dynamics to explain the command.
The recorder latches the encoder in the middle of a hold, so that a plain machine has no delay of its own.
"""
import numpy as np
from numba import njit

from friction import friction_step

FORCES = ["constant_force", "viscous", "quadratic_drag", "position_spring", "position_force", "periodic_force",
          "external_vibration", "gravity", "cable_snap", "eddy_brake", "leaky_chamber", "lip_seal_flip",
          "thixotropic_grease", "sliding_cargo", "gust_bursts"]
LEVELS = ["coulomb_asymmetry", "stribeck", "frictional_lag", "position_friction", "local_friction_spot",
          "periodic_friction", "load_dependent_friction", "thermal_drift", "run_in", "dwell_aging", "creep",
          "squeeze_film", "magnet_spot", "grease_starvation"]
ACTUATOR = ["actuator_dead_zone", "actuator_saturation", "supply_sag", "magnet_heating", "amplifier_dropout"]
STRUCTURE = ["backlash", "drive_compliance", "encoder_error", "payload_second_stroke"]
CODE = {name: 1 + i for i, name in enumerate(FORCES)}
CODE.update({name: 101 + i for i, name in enumerate(LEVELS)})
CODE.update({name: 201 + i for i, name in enumerate(ACTUATOR)})
CODE.update({name: 301 + i for i, name in enumerate(STRUCTURE)})
BACKLASH, COMPLIANCE, ENCODER, PAYLOAD = (CODE[n] for n in STRUCTURE)
(CONSTANT, VISCOUS, DRAG, SPRING, PROFILE, PERIODIC, VIBRATION, GRAVITY, SNAP, EDDY, LEAK, LIP, THIXO, CARGO,
 GUST) = (CODE[n] for n in FORCES)
(ASYMMETRY, STRIBECK, LAG, M_PROFILE, M_SPOT, M_PERIODIC, M_LOAD, M_THERMAL, M_RUN_IN, M_AGING, CREEP, M_FILM,
 M_MAGNET, M_STARVED) = (CODE[n] for n in LEVELS)
DEAD_ZONE, SATURATION, SAG, HEATING, DROPOUT = (CODE[n] for n in ACTUATOR)
BINS = 400


@njit(cache=True)
def profile(table, start, step, x):
    i = min(max((x - start) / step, 0.0), table.size - 1.001)
    j = int(i)
    return table[j] + (i - j) * (table[j + 1] - table[j])


@njit(cache=True)
def force_of(code, p, s, table, grid, t, x, v, wave, dt):
    """Added force of a force effect; p its parameters, s its states."""
    a = p[0]
    if code == CONSTANT:
        return a
    if code == VISCOUS:
        return a * v
    if code == DRAG:
        return a * v * abs(v)
    if code == SPRING:
        return a * (x - p[1])
    if code == PROFILE:
        return a * profile(table, grid[0], grid[1], x)
    if code == PERIODIC:
        phase = 2 * np.pi * x / p[1] + p[2]
        return a * (np.cos(phase) + p[3] * np.cos(2 * phase + p[4]))
    if code == VIBRATION:
        return a * np.sin(2 * np.pi * p[1] * t + p[2])
    if code == GRAVITY:
        return a * np.sin(x - p[1])
    if code == SNAP:                # bistable loop: snaps over beyond +-p[2] around p[1]
        if x > p[1] + p[2]:
            s[1] = 1.0
        elif x < p[1] - p[2]:
            s[1] = -1.0
        s[0] += (s[1] - s[0]) * min(1.0, dt / p[3])
        return a * s[0]
    if code == EDDY:
        return a * 2 * (v / p[1]) / (1 + (v / p[1]) ** 2)
    if code == LEAK:                # chamber pressure rises with stroke, leaks with p[1] seconds
        s[0] += dt * (v - s[0] / p[1])
        return a * s[0]
    if code == LIP:                 # a lip turns over at a reversal and drags until p[1] has been travelled
        if v * s[1] < 0 and abs(v) > p[2]:
            s[0] = 0.0
        if abs(v) > p[2]:
            s[1] = np.sign(v)
        s[0] += abs(v) * dt
        return a * s[1] * (s[0] / p[3]) * np.exp(-s[0] / p[1]) if s[0] < p[3] else a * s[1] * np.exp(-s[0] / p[1])
    if code == THIXO:               # structure s is broken by shearing, rebuilt with time
        s[0] += dt * ((1 - s[0]) / p[1] - abs(v) / p[2] * s[0])
        return a * s[0] * v
    if code == CARGO:               # a cargo of mass p[1], held by dry friction a only (taken along within p[2] s)
        drag = a * np.tanh((v - s[0]) * p[1] / p[2] / a)
        s[0] += dt * drag / p[1]
        return drag
    if code == GUST:
        return a * wave
    return 0.0


@njit(cache=True)
def level_of(code, p, s, seen, table, grid, t, x, v, slip, load, temperature, dt, out):
    """Level multipliers (out[0] for +, out[1] for -) and creep rate (out[2]) of a friction effect."""
    a, m, fast = p[0], 1.0, abs(v)
    out[2] = 0.0
    if code == ASYMMETRY:
        out[0], out[1] = 1 + a, 1 - a
        return
    if code == STRIBECK:
        m += a * np.exp(-(fast / p[1]) ** p[2])
    elif code == LAG:
        s[0] += (a * np.exp(-(fast / p[1]) ** p[2]) - s[0]) * dt / p[3]
        m += s[0]
    elif code == M_PROFILE:
        m += a * profile(table, grid[0], grid[1], x)
    elif code == M_SPOT:
        m += a * np.exp(-((x - p[1]) / p[2]) ** 2)
    elif code == M_PERIODIC:
        m += a * np.cos(2 * np.pi * x / p[1] + p[2])
    elif code == M_LOAD:
        s[0] += (abs(load) - s[0]) * min(1.0, dt / 0.004)
        m += a * s[0]
    elif code == M_THERMAL:
        m += a * (temperature - p[1])
    elif code == M_RUN_IN:
        s[0] += fast * dt
        m += a * np.exp(-s[0] / p[1])
    elif code == M_AGING:           # contact age s grows with time, is lost with slip over p[2]
        s[0] = s[0] * np.exp(-slip / p[2]) + dt
        m += a * np.log(1 + s[0] / p[1])
    elif code == CREEP:
        out[2] = a
    elif code == M_FILM:            # `seen` holds when each place was passed last
        i = int(min(max((x - grid[0]) / (grid[1] * (table.size - 1)) * BINS, 0), BINS - 1))
        if i != int(s[1]):
            s[0] = t - seen[i]
            s[1] = i
        seen[i] = t
        s[2] += (a * (1 - np.exp(-s[0] / p[1])) - s[2]) * min(1.0, fast * dt * BINS / (4 * grid[1] * table.size))
        m += s[2]
    elif code == M_MAGNET:
        m += a * np.exp(-((x - p[1]) / p[2]) ** 2 - (v / p[3]) ** 2)
    elif code == M_STARVED:         # an end of the travel brings fresh grease, path uses it up
        s[0] = 0.0 if abs(x - p[1]) > p[2] else s[0] + fast * dt
        s[1] += (a * (1 - np.exp(-s[0] / p[3])) - s[1]) * min(1.0, dt / 0.02)
        m += s[1]
    out[0] = out[1] = max(0.05, m)


@njit(cache=True)
def actuator(code, p, s, u, v, wave, dt):
    """Force that acts where u is commanded."""
    if code == DEAD_ZONE:
        if p[1] == 0:
            return u - min(max(u, -p[0]), p[0])
        size = abs(u)
        return u if size > 2 * p[0] else np.sign(u) * max(0.0, 2 * (size - p[0]))
    if code == SATURATION:
        limit = p[1] / p[0]
        return min(max(u, -limit), limit)
    if code == SAG:
        s[0] += (abs(u * v) / p[1] - s[0]) * dt / p[2]
        return u * max(0.3, 1 - p[0] * s[0])
    if code == HEATING:
        s[0] += ((u / p[1]) ** 2 - s[0]) * dt / p[2]
        return u * max(0.3, 1 - p[0] * s[0])
    return u * (1 - p[0] * wave)    # DROPOUT


@njit(cache=True)
def simulate(plant, gains, ref, law, k, w, extra, codes, p, tables, grid, temperature, waves, noise, nsub):
    """Return (recorded position before delay, command) and the truth columns
    [x, v_measured, a_measured, base friction, effect 1, effect 2, true friction]."""
    mass, b, ts, tick, n_tick, wander, wander_way, white = plant[:8]
    kp, kd, ki, w_filter, mass_ff, friction_ff, v_ff, b_ff = gains
    n, dt = ref.shape[0], ts / nsub
    out, truth = np.zeros((n, 2)), np.zeros((n, 7))
    s, seen, ml = np.zeros((2, 4)), np.full((2, BINS), -5.0), np.ones((2, 3))
    for e in range(2):
        s[e, 1] = -1.0 if codes[e] == SNAP or codes[e] == M_FILM else 0.0
        if codes[e] == THIXO:
            s[e, 0] = 1.0
    z = np.zeros((7, k.size))       # 0 full, 1 full at load, 2 base, 3 base at load, 4 base as measured, 5, 6 single
    m2, split, pos_e, payload_e = 0.0, 1.0, -1, -1
    two = -1
    for e in range(2):
        if codes[e] == BACKLASH or codes[e] == COMPLIANCE:
            two, m2, split = e, mass * p[e, 1], p[e, 2]
        elif codes[e] == ENCODER:
            pos_e = e
        elif codes[e] == PAYLOAD:
            payload_e = e
    m1 = mass - m2
    x = x2 = ref[0, 0]
    v = v2 = integral = v_hat = u_load = slip = 0.0
    dx, dx2, dxm, og, payload, at_end = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    xm = x + (p[pos_e, 0] * np.cos(2 * np.pi * x / p[pos_e, 1] + p[pos_e, 2]) if pos_e >= 0 else 0.0)
    vm, x_last = 0.0, np.round(xm / tick) * tick
    f_full = f_full2 = 0.0
    for i in range(n):
        y = np.round((xm + n_tick * tick * noise[i, 0]) / tick) * tick
        v_hat += ((y - x_last) / ts - v_hat) * (1 - np.exp(-w_filter * ts))
        x_last = y
        error = ref[i, 0] - y
        integral += ki * error * ts
        u = mass * (mass_ff * ref[i, 2] + kp * error + kd * (ref[i, 1] - v_hat) + integral)
        u += friction_ff * np.tanh(ref[i, 1] / v_ff) + b_ff * ref[i, 1]
        og += -og * min(1.0, abs(v) * ts / wander_way) + np.sqrt(2 * min(1.0, abs(v) * ts / wander_way)) * noise[i, 1]
        natural = 1 + wander * og + white * noise[i, 2]
        v_start, v2_start, vm_start = v, v2, vm
        out[i, 1] = u
        for j in range(nsub):
            t = (i + j / nsub) * ts
            added, acting, mp, mn, creep = 0.0, u, natural, natural, 0.0
            for e in range(2):
                c = codes[e]
                if c == 0 or c > 300:
                    continue
                if c < 100:
                    f = force_of(c, p[e], s[e], tables[e], grid, t, x, v, waves[i, e], dt)
                    added += f
                    truth[i, 4 + e] += f / nsub
                elif c < 200:
                    level_of(c, p[e], s[e], seen[e], tables[e], grid, t, x, v, slip, u_load, temperature[i], dt, ml[e])
                    mp *= ml[e, 0]
                    mn *= ml[e, 1]
                    creep += ml[e, 2]
                else:
                    f = actuator(c, p[e], s[e], acting, v, waves[i, e], dt)
                    truth[i, 4 + e] += (acting - f) / nsub
                    acting = f
            f_last = f_full
            f_full = friction_step(law, k, w, extra, z[0], dx, v, dt, mp, mn, creep)
            slip = abs(dx - (f_full - f_last) / k.sum()) if law != 5 else abs(dx)
            f_base = friction_step(law, k, w, extra, z[2], dx, v, dt, 1.0, 1.0, 0.0)
            f_measured = f_base
            for e in range(2):
                if 100 < codes[e] < 200:
                    f = friction_step(law, k, w, extra, z[5 + e], dx, v, dt, ml[e, 0], ml[e, 1], ml[e, 2])
                    truth[i, 4 + e] += (f - f_base) / nsub
            m_now = m1
            if two >= 0:
                f_full2 = friction_step(law, k, w, extra, z[1], dx2, v2, dt, mp, mn, creep)
                f_base2 = friction_step(law, k, w, extra, z[3], dx2, v2, dt, 1.0, 1.0, 0.0)
                truth[i, 4 + two] += (1 - split) * (b * (v2 - v) + f_base2 - f_base) / nsub
                gap = x - x2
                if codes[two] == BACKLASH:
                    gap = gap - 0.5 * p[two, 0] if gap > 0.5 * p[two, 0] else min(0.0, gap + 0.5 * p[two, 0])
                    joint = p[two, 3] * gap + (p[two, 4] * (v - v2) if gap != 0 else 0.0)
                    joint = max(0.0, joint) if gap > 0 else min(0.0, joint)
                else:
                    joint = gap / p[two, 0] + p[two, 4] * (v - v2)
                v2 = (v2 + dt * (joint - (1 - split) * f_full2) / m2) / (1 + dt * (1 - split) * b / m2)
                dx2 = dt * v2
                x2 += dx2
                added += joint
            if payload_e >= 0:      # taken at the upper end, put down when the upper end is reached again
                top = x > p[payload_e, 1]
                if top and at_end == 0.0:
                    payload = p[payload_e, 0] - payload
                at_end = 1.0 if top or (at_end == 1.0 and x > p[payload_e, 2]) else 0.0
                m_now = m1 + payload
            if pos_e >= 0:
                f_measured = friction_step(law, k, w, extra, z[4], dxm, vm, dt, 1.0, 1.0, 0.0)
                truth[i, 4 + pos_e] += (b * (v - vm) + f_base - f_measured) / nsub
            v_last = v
            v = (v + dt * (acting - added - split * f_full) / m_now) / (1 + dt * split * b / m_now)
            if payload_e >= 0:
                truth[i, 4 + payload_e] += payload * (v - v_last) / dt / nsub
            dx = dt * v
            x += dx
            xm_last, xm, vm = xm, x, v
            if pos_e >= 0:
                phase = 2 * np.pi * x / p[pos_e, 1] + p[pos_e, 2]
                xm += p[pos_e, 0] * np.cos(phase)
                vm = v * (1 - p[pos_e, 0] * 2 * np.pi / p[pos_e, 1] * np.sin(phase))
            dxm = xm - xm_last
            u_load = acting
            if j == nsub // 2:      # the recorder's latch
                out[i, 0] = np.round((xm_last + n_tick * tick * noise[i, 3]) / tick) * tick
                truth[i, 0] = xm_last
            truth[i, 1] += vm / nsub
            truth[i, 3] += f_measured / nsub
            truth[i, 6] += (f_full * split + (f_full2 * (1 - split) if two >= 0 else 0.0)) / nsub
        truth[i, 2] = (vm - vm_start) / ts
        if two >= 0:
            truth[i, 4 + two] += m2 * ((v2 - v2_start) - (v - v_start)) / ts
        if pos_e >= 0:
            truth[i, 4 + pos_e] += mass * ((v - v_start) - (vm - vm_start)) / ts
        if not abs(x) < 1e3:
            break
    return out, truth
