"""Answers for machines: every key of every command's is in the schema, with its unit."""

import os
import re
from pathlib import Path

import pytest
from conftest import SCHEMA

#: The description of the project's own axis.
OWN_AXIS = Path(__file__).parents[2] / "axis.toml"

#: As `cargo xtask test --all python` asks.
LONG = os.environ.get("PRESLIDE_LONG") == "1"

#: What a key of a number ends in: its unit, or a percentage.
UNIT = re.compile(
    r"(^|_)(N|Nm|m|rad|s|Hz|K|kg|kg_m2|m_s|rad_s|N_per_m|Nm_per_rad|N_s_per_m|Nm_s_per_rad|N_per_m_s|m_per_N|N2_per_s|per_s|deg"
    r"|seconds|bytes|percent|nmse|cycles_mean|cycles_worst|m_per_cycle)$|^nmse_"
)


def numbers(definition):
    """Keys that hold numbers, with what the schema says of them."""
    keys = definition.get("properties", {}) | definition.get("patternProperties", {})
    for key, what in keys.items():
        held = what.get("items", what)
        if "number" in str(held.get("type")) or held.get("$ref") in ("#/$defs/estimate", "#/$defs/bounds"):
            # A pattern is that of both kinds of axis.
            yield re.sub(r"[\^$()]|\|.*", "", key), what | held


def test_every_number_has_its_unit():
    for name, definition in SCHEMA["$defs"].items():
        # A sibling has the unit, or a key that ends in it; an estimate's is that of its own key.
        if {"unit", "key", "parameter"} & definition.get("properties", {}).keys() or name == "estimate":
            continue
        for key, what in numbers(definition):
            assert what.get("unit") in ("1", "%") or UNIT.search(key), f"{name}: {key}"


@pytest.mark.parametrize(
    "command",
    [
        "identify {short} --criterion motion",
        "identify {recording} --predictor koopman",
        "identify {table}",
        "compare {short} --train 0..3 --test 3..5",
        "simulate {model} --ramp 0,1,0,0.5,-1@0.01",
        "simulate {model} --force {short}",
        "simulate {model} --reference {short} --controller {gains}",
        "tune {model} --cpu all --count 25nm --resonance 300Hz --axis {own_axis}",
        "diagnose {short}",
        "diagnose {short} --model {wrong} --experiment {motion}",
        "diagnose {twin} --simulated force_sim_N",
        "fleet {short} {recording} --output {fleet}",
        "plan --travel 4mm --speed 2mm/s --acceleration 0.1m/s2 --output {motion}",
        "plan --rotary --travel 90deg --speed 90deg/s --acceleration 720deg/s2 --output {motion}",
        "export {model} --output {source}",
        "export {model} --mjcf --output {source}",
        pytest.param("reproduce", marks=pytest.mark.skipif(not LONG, reason="20 s; PRESLIDE_LONG=1")),
    ],
)
def test_a_commands_answer_is_as_the_schema_says(command, tool, axis, tmp_path):
    done, answer = tool(*command.format(**files(axis, tmp_path)).split(), folder=tmp_path)
    # The tool holds the answer against the schema; that there is one is what is left.
    assert answer is not None, done.stderr


def files(axis, folder):
    """Paths of what the commands take."""
    made = {
        "table": "v_m_s,force_N\n" + "".join(f"{v},{3 * v + (2 if v > 0 else -2)}\n" for v in (0.01, 0.02, 0.05, 0.1, 0.2, -0.01, -0.05, -0.2)),
        "gains": 'schema = "preslide.controller/1"\nrate_Hz = 500\nproportional_N_per_m = 2e4\nderivative_N_s_per_m = 200\nlimit_N = 50\n',
        "wrong": (axis / "model.toml").read_text().replace("mass_kg = 3", "mass_kg = 4"),
        "twin": twin((axis / "short.csv").read_text()),
    }
    paths = {name: folder / f"{name}.{'csv' if ',' in text.split()[0] else 'toml'}" for name, text in made.items()}
    for name, text in made.items():
        paths[name].write_text(text)
    axis_files = {name: axis / f"{name}.csv" for name in ("short", "recording")}
    outputs = {name: folder / f"{name}_made.csv" for name in ("motion", "fleet", "source")}
    return paths | axis_files | outputs | {"model": axis / "model.toml", "own_axis": OWN_AXIS}


def twin(recording):
    """A recording with a simulation that has 20 % too much force."""
    head, *rows = recording.split()
    return f"{head},force_sim_N\n" + "".join(f"{row},{1.2 * float(row.split(',')[2])}\n" for row in rows)
