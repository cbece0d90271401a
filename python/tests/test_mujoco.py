"""Exported joints in MuJoCo move as the model's own simulation does."""

import os
import pathlib
import re

import numpy as np
import pytest

import preslide

mujoco = pytest.importorskip("mujoco")

BENCH = pathlib.Path(__file__).resolve().parents[3] / "shared" / "benches" / "bam_xl330"
#: The servo's duty is what drives it; a torque in units of the full duty.
DUTY = {"torque_Nm": "duty"}
#: Steps of MuJoCo in a sample.
STEPS = 20
#: Half a minute together.
LONG = pytest.mark.skipif(os.environ.get("PRESLIDE_LONG") != "1", reason="long: `cargo xtask test --all python`")
#: RMS of the difference over the motion's deviation. Both solve the same equation; the steps and MuJoCo's soft friction are what differs.
AS_GOOD = 0.01


def element(xml):
    """What stands below the comments."""
    return xml[xml.index("<joint") :]


def moved(xml, t, position, velocity, force, given=1, weight=None):
    """Positions of a body on the exported joint under a force, from the last of the given samples on.

    `weight` is the torque of a pendulum and the angle at which it hangs: a point mass whose inertia is taken off the armature, as the export says.
    """
    joint, pull = element(xml), "0 0 0"
    # A hinge's inertia is its armature, but MuJoCo wants a body.
    inertial = "" if "<inertial" in joint else '<inertial pos="0 0 0" mass="1e-9" diaginertia="1e-12 1e-12 1e-12"/>'
    if weight is not None:
        torque, hangs = weight
        pull, lever = "0 0 -9.80665", 0.02
        mass = torque / 9.80665 / lever
        place = f"{-lever * np.sin(hangs):.17g} 0 {-lever * np.cos(hangs):.17g}"
        inertial = f'<inertial pos="{place}" mass="{mass:.17g}" diaginertia="1e-12 1e-12 1e-12"/>'
        joint = re.sub('armature="(.*?)"', lambda found: f'armature="{float(found[1]) - mass * lever**2:.17g}"', joint)
    joint = joint.replace("<joint", '<joint axis="0 -1 0"', 1)
    step = (t[-1] - t[0]) / (t.size - 1) / STEPS
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step:.17g}" gravity="{pull}" integrator="implicit"/><worldbody><body>'
        f"{joint}{inertial}</body></worldbody>"
        '<actuator><motor joint="axis"/></actuator></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = position[given - 1], velocity
    out = list(position[:given])
    for before, after in zip(force[given - 1 :], force[given:]):
        for i in range(STEPS):
            data.ctrl[0] = before + (i + 0.5) / STEPS * (after - before)
            mujoco.mj_step(model, data)
        out.append(data.qpos[0])
    return np.array(out)


def apart(out, position, name):
    share = np.sqrt(np.mean((out - position) ** 2)) / np.std(position)
    bias, most = np.mean(out - position), np.abs(out - position).max()
    print(f"{name}: {100 * share:.3f} % of the motion's deviation apart, RMS; largest {most:.2e}, mean {bias:.2e}")
    return share


@pytest.fixture(scope="module")
def servo():
    if not BENCH.is_dir():
        pytest.skip(f"SKIPPED: {BENCH} is not there")
    return [BENCH / f"xl330_kp400_{motion}.csv" for motion in ("sin_sin", "sin_time_square")]


@pytest.mark.parametrize("motion", ["sin_sin", "sin_time_square"])
def test_the_servos_joint_moves_as_its_model(servo, motion):
    """Identified at one gain of the servo's controller, moved by the duty that it took at half of it."""
    model = preslide.identify(*servo, map=DUTY).model
    simulated = preslide.simulate(model, force=BENCH / f"xl330_kp200_{motion}.csv", map=DUTY)
    t, position, velocity, force = simulated.data.values()
    out = moved(preslide.export(model, mjcf=True), t, position, velocity[0], force, given=20)
    assert apart(out, position, f"kp200_{motion}") < AS_GOOD


@LONG
def test_what_the_joint_cannot_hold_is_said(servo):
    """Fitted to its motion, the servo's friction is that of what its gear transmits, and a joint has none of it."""
    model = preslide.identify(*servo, map=DUTY, criterion="motion").model
    xml = preslide.export(model, mjcf=True)
    assert "Not in it: load_dependent_friction" in xml
    simulated = preslide.simulate(model, force=BENCH / "xl330_kp200_sin_sin.csv", map=DUTY)
    t, position, velocity, force = simulated.data.values()
    out = moved(xml, t, position, velocity[0], force, given=20)
    # Far from as good: were it near, the words would be wrong.
    assert apart(out, position, "without the gear's friction") > 10 * AS_GOOD


WEIGHT = """schema = "preslide.model/1"
motion = "rotary"
inertia = { inertia_kg_m2 = 0.004 }
friction = { kind = "coulomb", coulomb_Nm = 0.05, viscous_Nm_s_per_rad = 0.03 }
[[effects]]
id = "gravity"
force_Nm = 0.4
angle_rad = 0.3
[[effects]]
id = "position_spring"
stiffness_Nm_per_rad = 0.2
centre_rad = -0.6
[[effects]]
id = "actuator_saturation"
limit_Nm = 0.5
"""
CARRIAGE = """schema = "preslide.model/1"
motion = "linear"
inertia = { mass_kg = 3.0 }
friction = { kind = "coulomb", coulomb_N = 2.0, viscous_N_s_per_m = 40.0 }
"""


@pytest.mark.parametrize(("text", "column", "most", "weight"), [(WEIGHT, "torque_Nm", 0.6, (0.4, 0.3)), (CARRIAGE, "force_N", 9.0, None)])
def test_a_made_joint_moves_as_its_model(text, column, most, weight):
    """A hinge with a weight, a spring and an end of its drive; a slide: from rest, through standstills."""
    t = np.arange(0.0, 8.0, 2e-3)
    force = most * np.sin(2.9 * t) * np.sin(0.7 * t + 0.4)
    simulated = preslide.simulate(preslide.Model(text), force={"t_s": t, column: force})
    t, position, velocity, force = simulated.data.values()
    xml = preslide.export(preslide.Model(text), mjcf=True)
    assert ("Not in it: gravity" in xml) == (weight is not None)
    out = moved(xml, t, position, velocity[0], force, weight=weight)
    assert apart(out, position, column) < AS_GOOD


def test_a_mujoco_model_is_a_simulation_that_is_corrected():
    """`mj_inverse` gives the force of a motion; the machine is the same model with a cogging besides."""
    arm = mujoco.MjModel.from_xml_string(
        '<mujoco><option><flag contact="disable"/></option><worldbody><body><joint axis="0 -1 0" damping="0.05" frictionloss="0.2" '
        'solreffriction="0.004 1"/><inertial pos="0 0 -0.1" mass="0.4" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(arm)

    def simulation(motion):
        torque = []
        for data.qpos[0], data.qvel[0], data.qacc[0] in zip(motion["x"], motion["v"], motion["a"]):
            mujoco.mj_inverse(arm, data)
            torque.append(data.qfrc_inverse[0])
        return np.array(torque)

    t = np.arange(0.0, 30.0, 2e-3)
    waves = ((1.0, 2.1), (0.4, 5.3), (0.15, 11.9))
    x = sum(a * np.sin(w * t) for a, w in waves)
    v = sum(a * w * np.cos(w * t) for a, w in waves)
    acceleration = sum(-a * w * w * np.sin(w * t) for a, w in waves)
    machine = simulation({"x": x, "v": v, "a": acceleration}) + 0.05 * np.cos(12 * x)
    recording = {"t_s": t, "q_rad": x, "torque_Nm": machine + 2e-3 * np.random.default_rng(5).normal(size=t.size)}
    found = preslide.diagnose(recording, simulate=simulation)
    print(found)
    assert [e.id for e in found.effects if e.level == "confident"] == ["periodic_force"]
    added = found.data["torque_sim_corrected_Nm"] - found.data["torque_sim_Nm"]
    again = preslide.diagnose(recording, simulate=lambda motion: simulation(motion) + added)
    print(f"{found.baseline.nmse_test} % left without the correction, {again.baseline.nmse_test} % with it")
    assert again.baseline.nmse_test < 0.1 * found.baseline.nmse_test


@LONG
def test_a_mujoco_model_that_moves_under_the_recorded_force_is_corrected():
    """Force to motion, by `mj_step`: the machine is the same model with a cogging besides, moved by a controller."""
    step = 2e-3
    arm = mujoco.MjModel.from_xml_string(
        '<mujoco><option timestep="1e-3"><flag contact="disable"/></option><worldbody><body><joint axis="0 -1 0" damping="0.05" frictionloss="0.1" '
        'solreffriction="0.004 1"/><inertial pos="0 0 -0.1" mass="0.4" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody></mujoco>'
    )

    def moved(t, torque, start, beside=lambda t, x, v, a: 0.0):
        """`torque` of a time's number, of position and velocity."""
        data = mujoco.MjData(arm)
        data.qpos[0], data.qvel[0] = start
        out, applied = [], []
        for i, now in enumerate(t):
            out.append(data.qpos[0])
            applied.append(torque(i, data.qpos[0], data.qvel[0]))
            for _ in range(2):
                data.qfrc_applied[0] = applied[-1] - beside(now, data.qpos[0], data.qvel[0], 0.0)
                mujoco.mj_step(arm, data)
        return np.array(out), np.array(applied)

    t = np.arange(0.0, 30.0, step)
    path = sum(a * np.sin(w * t) for a, w in ((1.0, 2.1), (0.4, 5.3), (0.15, 11.9)))
    speed = np.diff(path, prepend=path[0]) / step
    position, torque = moved(t, lambda i, x, v: 60 * (path[i] - x) + 1.5 * (speed[i] - v), (0, 0), lambda t, x, v, a: 0.05 * np.cos(12 * x))
    recording = {"t_s": t, "q_rad": position, "torque_Nm": torque + 2e-3 * np.random.default_rng(5).normal(size=t.size)}

    def simulation(motion, *beside):
        start = motion["x"][0], (motion["x"][1] - motion["x"][0]) / step
        return moved(motion["t"], lambda i, *_: motion["force"][i], start, *beside)[0]

    found = preslide.diagnose(recording, simulate_motion=simulation)
    print(found)
    first = next(e for e in found.effects if e.level == "confident")
    assert first.id == "periodic_force" and abs(first.parameters.force_Nm.value / 0.05 - 1.0) < 0.05
    # Its own correction, and the motion once more.
    motion = {"t": t, "x": position, "force": recording["torque_Nm"]}
    without = apart(simulation(motion), position, "as it is")
    corrected = apart(simulation(motion, found.corrector().force), position, "corrected")
    assert without > 0.03 and corrected < 0.003


def test_urdf_is_read_with_the_models_numbers():
    joint = element(preslide.export(preslide.Model(CARRIAGE), urdf=True))
    assert "inertia" not in joint
    own = '<parent link="base"/><child link="table"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="100" velocity="1"/>'
    mass = '<inertial><mass value="3"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    robot = f'<robot name="axis"><link name="base"/><link name="table">{mass}</link>{joint.replace("</joint>", own + "</joint>")}</robot>'
    model = mujoco.MjModel.from_xml_string(robot)
    assert model.dof_frictionloss[0] == 2.0 and model.dof_damping[0] == 40.0
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_SLIDE
