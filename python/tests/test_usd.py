"""Exported joints of OpenUSD: Pixar's library reads them, PhysX's schema knows every name, and PhysX moves them as the model's own simulation does.

In the long tier: the wheels are large. PhysX, which wants an older `packaging` than pytest, is in an environment of its own, whose interpreter
PRESLIDE_PHYSX names.
"""

import os
import subprocess

import numpy as np
import pytest

import preslide

pytest.importorskip("pxr", reason="OpenUSD is asked by `cargo xtask test --all python`")
from pxr import Usd, UsdPhysics

#: RMS of the difference over the motion's deviation: of steps of 1 ms, and of numbers of single precision.
AS_GOOD = 0.002

HINGE = """schema = "preslide.model/1"
motion = "rotary"
inertia = { inertia_kg_m2 = 0.004 }
friction = { kind = "coulomb", coulomb_Nm = 0.05, viscous_Nm_s_per_rad = 0.03 }
[[effects]]
id = "position_spring"
stiffness_Nm_per_rad = 0.2
centre_rad = -0.6
"""
CARRIAGE = """schema = "preslide.model/1"
motion = "linear"
inertia = { mass_kg = 3.0 }
friction = { kind = "coulomb", coulomb_N = 2.0, viscous_N_s_per_m = 40.0 }
"""
STICKING = """schema = "preslide.model/1"
motion = "linear"
inertia = { mass_kg = 3.0 }
[friction]
kind = "lugre"
stiffness_N_per_m = 1e5
damping_N_s_per_m = 10.0
breakaway_N = 3.0
coulomb_N = 2.0
stribeck_velocity_m_s = 0.01
stribeck_exponent = 2.0
"""


def value(prim, name):
    attribute = prim.GetAttribute(name)
    assert attribute and attribute.HasAuthoredValue(), name
    return attribute.Get()


def exported(text, folder):
    path = folder / "joint.usda"
    path.write_text(preslide.export(preslide.Model(text), usd=True), encoding="utf-8")
    return path


def test_openusd_reads_the_models_numbers(tmp_path):
    stage = Usd.Stage.Open(str(exported(HINGE, tmp_path)))
    prim = stage.GetDefaultPrim()
    assert prim.IsA(UsdPhysics.RevoluteJoint) and UsdPhysics.RevoluteJoint(prim).GetAxisAttr().Get() == "X"
    drive = UsdPhysics.DriveAPI.Get(prim, "angular")
    assert drive.GetTypeAttr().Get() == "force" and drive.GetDampingAttr().Get() == 0.0
    # What USD counts a degree, for a radian.
    assert np.degrees(drive.GetStiffnessAttr().Get()) == pytest.approx(0.2, rel=1e-6)
    assert np.radians(drive.GetTargetPositionAttr().Get()) == pytest.approx(-0.6, rel=1e-6)
    assert np.degrees(value(prim, "physxJointAxis:angular:viscousFrictionCoefficient")) == pytest.approx(0.03, rel=1e-6)
    assert value(prim, "physxJointAxis:angular:armature") == pytest.approx(0.004, rel=1e-6)
    for level in ("static", "dynamic"):
        assert value(prim, f"physxJointAxis:angular:{level}FrictionEffort") == pytest.approx(0.05, rel=1e-6)

    (tmp_path / "sticking").mkdir()
    stage = Usd.Stage.Open(str(exported(STICKING, tmp_path / "sticking")))
    prim = stage.GetDefaultPrim()
    assert prim.IsA(UsdPhysics.PrismaticJoint)
    assert value(prim, "physxJointAxis:linear:staticFrictionEffort") == 3.0
    assert value(prim, "physxJointAxis:linear:dynamicFrictionEffort") == 2.0


SCHEMA = """
import sys
from ovphysx.samples.python_samples.schema_support import physx_schema_paths
from pxr import Plug, Usd
for path in physx_schema_paths():
    Plug.Registry().RegisterPlugins(str(path))
stage = Usd.Stage.Open(sys.argv[1])
prim = stage.GetDefaultPrim()
known = set(prim.GetPrimDefinition().GetPropertyNames())
print(*sorted(set(prim.GetAuthoredPropertyNames()) - known))
print(*prim.GetAppliedSchemas())
"""

#: PhysX in a process of its own, on the joint as a reference in a scene: the force on it, and where it is.
PHYSX = """
import sys, numpy as np, ovstage, ovphysx
from ovphysx import PhysX
from ovphysx.samples.python_samples.schema_support import physx_schema_paths
from ovphysx.types import TensorType
scene, table, step, steps = sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4])
force = np.load(table)
PhysX.set_cpu_mode(True)
physx = PhysX()
ovstage.population.register_usd_schemas([str(path) for path in physx_schema_paths()])
stage = ovstage.Stage("scene")
ovstage.population.open_usd(stage, scene, ordinal=1, domains=ovstage.PopulationDomain.ALL)
stage.advance_write_floor(ordinal=1).wait()
physx.wait_task(physx.attach_ovstage(stage, read_ordinal=1))
physx.wait_all()
push = physx.create_tensor_binding(pattern="/World/robot", tensor_type=TensorType.ARTICULATION_DOF_ACTUATION_FORCE)
place = physx.create_tensor_binding(pattern="/World/robot", tensor_type=TensorType.ARTICULATION_DOF_POSITION)
now, out = np.zeros(place.shape, np.float32), []
for before, after in zip(force[:-1], force[1:]):
    place.read(now)
    out.append(now[0, 0])
    for i in range(steps):
        push.write(np.full(push.shape, before + (i + 0.5) / steps * (after - before), np.float32))
        physx.step_sync(step / steps)
place.read(now)
np.save(table, np.array([*out, now[0, 0]]))
"""

#: An articulation of a table on a base, of whose inertia the joint's armature has all but a part.
SCENE = """#usda 1.0
(
    defaultPrim = "World"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def PhysicsScene "scene"
    {
        float3 physics:gravityDirection = (0, 0, -1)
        float physics:gravityMagnitude = 0
    }
    def Xform "robot" (prepend apiSchemas = ["PhysicsArticulationRootAPI", "PhysxArticulationAPI"])
    {
        float physxArticulation:sleepThreshold = 0
        int physxArticulation:solverPositionIterationCount = 16
        int physxArticulation:solverVelocityIterationCount = 4
        def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
        {
            float physics:mass = 10
            float3 physics:diagonalInertia = (1, 1, 1)
        }
        def Xform "table" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI", "PhysxRigidBodyAPI"])
        {
            float physics:mass = MASS
            float3 physics:diagonalInertia = (MASS, MASS, MASS)
            float physxRigidBody:angularDamping = 0
            float physxRigidBody:linearDamping = 0
        }
        def PhysicsFixedJoint "root"
        {
            rel physics:body1 = </World/robot/base>
        }
        def "joint" (references = @./joint.usda@)
        {
            rel physics:body0 = </World/robot/base>
            rel physics:body1 = </World/robot/table>
            float physxJointAxis:INSTANCE:armature = ARMATURE
        }
    }
}
"""


def run(code, *arguments):
    """Runs a program in the environment of PhysX."""
    python = os.environ.get("PRESLIDE_PHYSX")
    if not python:
        pytest.skip("PhysX is asked by `cargo xtask test --all python`, on Linux and x86-64")
    done = subprocess.run([python, "-c", code, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


def test_physx_schema_knows_every_name(tmp_path):
    unknown, applied = run(SCHEMA, exported(HINGE, tmp_path)).split("\n")[:2]
    assert not unknown and "PhysxJointAxisAPI:angular" in applied, (unknown, applied)


@pytest.mark.parametrize(("text", "column", "most"), [(HINGE, "torque_Nm", 0.6), (CARRIAGE, "force_N", 9.0)])
def test_physx_moves_it_as_the_model(text, column, most, tmp_path):
    """From rest, through standstills."""
    step = 2e-3
    t = np.arange(0.0, 4.0, step)
    force = most * np.sin(2.9 * t) * np.sin(0.7 * t + 0.4)
    model = preslide.Model(text)
    simulated = preslide.simulate(model, force={"t_s": t, column: force})
    position = simulated.data["q_rad" if model.rotary else "x_m"]
    exported(text, tmp_path)
    own = 0.1 * model.inertia
    scene = SCENE.replace("MASS", f"{own:.9g}").replace("ARMATURE", f"{model.inertia - own:.9g}")
    (tmp_path / "scene.usda").write_text(scene.replace("INSTANCE", "angular" if model.rotary else "linear"), encoding="utf-8")
    table = tmp_path / "table.npy"
    np.save(table, force)
    run(PHYSX, tmp_path / "scene.usda", table, step, 2)
    apart = np.load(table) - position
    share = np.sqrt(np.mean(apart**2)) / np.std(position)
    print(f"{column}: {100 * share:.3f} % of the motion's deviation apart, RMS; largest {np.abs(apart).max():.2e}, mean {np.mean(apart):.2e}")
    assert share < AS_GOOD


def test_physx_holds_at_rest_and_slides_at_the_level_of_each(tmp_path):
    """Pushed below the level at rest it stays; above, it slides against the lower one."""
    exported(STICKING, tmp_path)
    scene = SCENE.replace("MASS", "0.3").replace("ARMATURE", "2.7").replace("INSTANCE", "linear")
    (tmp_path / "scene.usda").write_text(scene, encoding="utf-8")
    # 1 s at 2.8 N, 0.5 s at 3.2 N.
    table, step = tmp_path / "table.npy", 1e-3
    np.save(table, np.r_[np.full(1000, 2.8), np.full(501, 3.2)])
    run(PHYSX, tmp_path / "scene.usda", table, step, 1)
    out = np.load(table)
    slid = out[-1] - out[1000]
    print(f"at rest it crept {out[1000]:.2e} m, then slid {slid:.5f} m of {0.5 * (3.2 - 2.0) / 3.0 * 0.5**2:.5f}")
    # What holds it gives way a little.
    assert abs(out[1000]) < 5e-6
    assert slid == pytest.approx(0.5 * (3.2 - 2.0) / 3.0 * 0.5**2, rel=0.01)
