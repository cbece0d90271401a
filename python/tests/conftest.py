"""What the tests share: the tool as a program, whose every answer is held against its schema, and recordings that it makes."""

import json
import os
import pathlib
import subprocess

import jsonschema
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


#: What every key of an answer is, and in which unit.
SCHEMA = json.loads((ROOT / "docs" / "src" / "answers.schema.json").read_text())


def conforms(answer):
    """Fails on a key that the schema of the answer lacks, and on one that the answer lacks."""
    name = answer["schema"].removeprefix("preslide.").partition("/")[0]
    # The definition alone: of all of them together no error says what is wrong.
    jsonschema.validate(answer, {"$ref": f"#/$defs/{name}", "$defs": SCHEMA["$defs"]})


@pytest.fixture(scope="session")
def tool():
    """Runs the tool's program; its JSON file."""
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release" / "preslide"
    assert program.exists(), f"{program} is not there: cargo build --release"

    def run(*arguments, folder, json_file=True):
        answer = folder / "tool.json"
        more = ["--json", str(answer)] if json_file else []
        done = subprocess.run([program, *map(str, arguments), *more], capture_output=True, text=True)
        values = json.loads(answer.read_text()) if json_file and answer.exists() else None
        if values is not None:
            conforms(values)
        return done, values

    return run


@pytest.fixture(scope="session")
def axis(tool, tmp_path_factory):
    """A folder with recording.csv, of a made machine, its first five seconds in short.csv, and the model.toml that the tool identifies of it."""
    folder = tmp_path_factory.mktemp("axis")
    seed, step = 11, 2e-3
    print(f"seed {seed}")
    t = np.arange(0.0, 16.0, step)
    x = 0.02 * np.sin(2.1 * t) + 0.007 * np.sin(7.3 * t)
    v, a = np.gradient(x, t), np.gradient(np.gradient(x, t), t)
    friction = np.zeros_like(t)
    for stiffness, slips in ((40e3, 2e-5), (3e3, 4e-4)):
        deflection = 0.0
        for i in range(1, t.size):
            deflection = min(max(deflection + x[i] - x[i - 1], -slips), slips)
            friction[i] += stiffness * deflection
    noise = 0.02 * np.random.default_rng(seed).normal(size=t.size)
    force = 3.0 * a + friction + 4.0 * v + noise
    rows = np.column_stack([t, np.round(x / 10e-9) * 10e-9, force])
    file, model = folder / "recording.csv", folder / "model.toml"
    for name, part in ((file, rows), (folder / "short.csv", rows[t < 5.0])):
        np.savetxt(name, part, delimiter=",", header="t_s,x_m,force_N", comments="", fmt="%.9g")
    done, _ = tool("identify", file, "-o", model, folder=folder)
    assert done.returncode == 0, done.stderr
    return folder
