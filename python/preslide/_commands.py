"""The tool's commands as functions."""

import csv
import json
import os
import pathlib
import tempfile

import numpy as np

from ._model import Model
from ._preslide import run
from ._result import Error, Result

#: Options that name what the result has anyway.
_OWN = ("output", "json")


def _is_path(recording):
    return isinstance(recording, (str, os.PathLike))


def _columns(recording):
    """Columns of a mapping or a frame, by name."""
    names = list(recording.keys() if hasattr(recording, "keys") else recording.columns)
    return {str(name): np.asarray(recording[name]) for name in names}


def _file(recording, folder, name):
    """A path of the recording; arrays go into the folder."""
    if _is_path(recording):
        return os.fspath(recording)
    columns = _columns(recording)
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise Error(f"columns of different lengths: {', '.join(f'{n} {k}' for n, k in lengths.items())}")
    path = folder / f"{name}.npz"
    numbers = {key: column for key, column in columns.items() if np.issubdtype(column.dtype, np.number)}
    np.savez(path, **{key: column.astype(np.float64) for key, column in numbers.items()})
    return str(path)


def _files(recordings, folder):
    names = ["recording"] if len(recordings) == 1 else [f"recording{i + 1}" for i in range(len(recordings))]
    return [_file(recording, folder, name) for recording, name in zip(recordings, names)]


def _model_file(model, folder, name="model"):
    if isinstance(model, Result):
        model = model.model
    if isinstance(model, Model):
        path = folder / f"{name}.toml"
        model.save(path)
        return str(path)
    return os.fspath(model)


def _options(options):
    """Options as the command line has them."""
    arguments = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            arguments.append(option)
        elif isinstance(value, dict):
            arguments += [part for key, column in value.items() for part in (option, f"{key}={column}")]
        elif isinstance(value, (list, tuple)):
            arguments += [part for one in value for part in (option, str(one))]
        else:
            arguments += [option, os.fspath(value) if _is_path(value) else str(value)]
    return arguments


def _run(command, arguments, folder, progress, makes=None, fails=True):
    """Runs a command; its result, with the file that it makes."""
    answer, made = folder / "answer.json", folder / f"made{makes}" if makes else None
    arguments = [command, *arguments, "--json", str(answer)]
    if made:
        arguments += ["-o", str(made)]
    code = folder / "correction.py" if command == "diagnose" and makes == ".csv" else None
    if code:
        arguments += ["-o", str(code)]
    said, told, failure = run(arguments, progress)
    # Files of our own are nobody's business.
    own = str(folder) + os.sep
    said = said.replace(f" --model {made}", "")
    kept = [line for line in said.splitlines(keepends=True) if not any(file and str(file) in line for file in (made, code))]
    said, told = "".join(kept).replace(own, ""), [line.replace(own, "") for line in told if not line.startswith("wrote ")]
    result = None
    if answer.exists():
        values = json.loads(answer.read_text(encoding="utf-8").replace(json.dumps(own)[1:-1], ""))
        model = Model(made) if makes == ".toml" and made.exists() else None
        data = _table(made) if makes == ".csv" and made.exists() else None
        text = code.read_text(encoding="utf-8").replace(own, "") if code and code.exists() else None
        result = Result(command, values, said, told, model, data, text)
    if failure and (fails or result is None):
        raise Error(failure[0].replace(own, ""), failure[1], result)
    return result


def _table(path):
    table = np.genfromtxt(path, delimiter=",", names=True, deletechars="", replace_space=" ")
    return {name: table[name] for name in table.dtype.names}


def _folder():
    return tempfile.TemporaryDirectory(prefix="preslide-")


def _without_own(options):
    for name in _OWN:
        if name in options:
            raise Error(f"`{name}` is what the result holds: result.model, result.data, result.to_dict()")


def identify(*recordings, progress=None, **options):
    """Fit a rigid body and a friction model to recordings. `result.model` is the recommended one."""
    _without_own(options)
    with _folder() as name:
        folder = pathlib.Path(name)
        return _run("identify", _files(recordings, folder) + _options(options), folder, progress, ".toml")


def compare(*recordings, progress=None, **options):
    """Fit every friction model to one recording: error fitted and held out, memory, cost."""
    _without_own(options)
    with _folder() as name:
        folder = pathlib.Path(name)
        return _run("compare", _files(recordings, folder) + _options(options), folder, progress)


def diagnose(*recordings, model=None, simulate=None, simulate_motion=None, simulated=None, progress=None, **options):
    """Name and size the physics that a model or a simulation lacks, with proof on held-out data.

    `simulate` is your own simulation: a function of a dictionary of arrays (`t`, `x`, `v`, `a` in SI) to the force that it needs for that
    motion. `result.data` is then the correction, term by term, `result.correction.nmse_corrected` what is left with it (% of the variance), and
    `result.corrector()` adds it to any motion. `simulate_motion` is a forward one: of the same dictionary with the recorded `force` to the position
    that it reaches; or to position and force, where its own controller moves it. `simulated` names a column or a file instead.
    """
    _without_own(options)
    if sum(given is not None for given in (model, simulate, simulate_motion, simulated)) > 1:
        raise Error("give one of model, simulate, simulate_motion and simulated: each is what the recording is compared with")
    with _folder() as name:
        folder = pathlib.Path(name)
        if simulate is not None or simulate_motion is not None:
            return _with_simulation(recordings, simulate, simulate_motion, folder, progress, options)
        arguments = _options(options)
        if model is not None:
            arguments += ["--model", _model_file(model, folder)]
        if simulated is not None:
            file = simulated if isinstance(simulated, str) else _file(simulated, folder, "simulated")
            arguments += ["--simulated", os.fspath(file)]
        makes = ".toml" if simulated is None else ".csv"
        return _run("diagnose", _files(recordings, folder) + arguments, folder, progress, makes)


#: Columns of a recording for motion and effort, and their names in a simulation.
_POSITION = {"x_m": "x_sim_m", "q_rad": "q_sim_rad"}
_EFFORT = {"force_N": "force_sim_N", "friction_N": "friction_sim_N", "torque_Nm": "torque_sim_Nm"}


def _with_simulation(recordings, simulate, simulate_motion, folder, progress, options):
    name = "simulate" if simulate_motion is None else "simulate_motion"
    if len(recordings) != 1 or _is_path(recordings[0]):
        raise Error(f"{name}=… takes one recording as arrays or a frame: t_s, x_m or q_rad, and force_N or torque_Nm")
    columns = _columns(recordings[0])
    position = next((key for key in _POSITION if key in columns), None)
    effort = next((key for key in _EFFORT if key in columns), None)
    if "t_s" not in columns or position is None or effort is None:
        raise Error(f"{name}=… needs t_s, x_m or q_rad, and force_N or torque_Nm; the recording has {', '.join(columns)}")
    # The motion as the tool sees it: filtered, so that a simulation may differentiate nothing.
    t, x = columns["t_s"].astype(float), columns[position].astype(float)
    motion = _motion(t, x, position, folder, progress)
    if simulate is not None:
        answers = {_EFFORT[effort]: simulate(motion)}
    else:
        answer = simulate_motion(motion | {"force": columns[effort].astype(float)})
        parts = answer if isinstance(answer, tuple) else (answer,)
        if len(parts) > 2:
            raise Error(f"{name}=… gave {len(parts)} arrays; give the position, or position and force")
        answers = dict(zip((_POSITION[position], _EFFORT[effort]), parts))
    for column, values in answers.items():
        columns[column] = np.asarray(values, dtype=float)
        if columns[column].shape != t.shape or not np.isfinite(columns[column]).all():
            raise Error(f"{name}=… gave {columns[column].shape} values, not one finite number for each of the {t.size} samples")
    arguments = [_file(columns, folder, "recording"), "--simulated", ",".join(answers), *_options(options)]
    return _run("diagnose", arguments, folder, progress, ".csv")


def _motion(t, x, position, folder, progress):
    """Time, position, velocity and acceleration by the tool's own filter: the force of a mass of 1 without friction."""
    kind, inertia, coulomb = ("rotary", "inertia_kg_m2", "coulomb_Nm") if position == "q_rad" else ("linear", "mass_kg", "coulomb_N")
    unit = folder / "unit.toml"
    unit.write_text(
        f'schema = "preslide.model/1"\nmotion = "{kind}"\ninertia = {{ {inertia} = 1.0 }}\nfriction = {{ kind = "coulomb", {coulomb} = 1e-12 }}\n',
        encoding="utf-8",
    )
    file = _file({"t_s": t, position: x}, folder, "motion")
    moved = _run("simulate", [str(unit), "--motion", file], folder, progress, ".csv").data
    names = list(moved)
    return {"t": t, "x": x, "v": moved[names[2]], "a": moved[names[3]]}


def simulate(model, *, motion=None, force=None, reference=None, controller=None, progress=None, **options):
    """The force that a motion takes, or the motion under a force or a controller; `result.data` has the arrays."""
    _without_own(options)
    with _folder() as name:
        folder = pathlib.Path(name)
        arguments = [_model_file(model, folder)]
        for option, recording in (("motion", motion), ("force", force), ("reference", reference)):
            if recording is not None:
                arguments += [f"--{option}", _file(recording, folder, option)]
        if controller is not None:
            arguments += ["--controller", os.fspath(controller)]
        return _run("simulate", arguments + _options(options), folder, progress, ".csv")


def tune(model, *, recording=None, progress=None, **options):
    """Choose number of blocks and arithmetic for a cycle budget."""
    _without_own(options)
    with _folder() as name:
        folder = pathlib.Path(name)
        arguments = [_model_file(model, folder), *_options(options)]
        if recording is not None:
            arguments += ["--recording", _file(recording, folder, "recording")]
        return _run("tune", arguments, folder, progress)


def fleet(*recordings, output=None, progress=None, **options):
    """Watch many axes: columns of the table by name, a row for each recording (texts, and numbers with NaN for none).

    `recordings` are folders, files or patterns; `output` keeps the table (`.parquet` or `.csv`) and, beside it, the rows as they are made, so that the
    next call reads only what is new. With `part="1/8"` one of eight workers makes its rows and there is no table.
    """
    with _folder() as folder:
        table = os.path.join(folder, "fleet.csv")
        tables = [os.fspath(output), table] if output is not None else [table]
        outputs = [part for name in tables for part in ("-o", name)]
        _, _, failure = run(["fleet", *map(os.fspath, recordings), *outputs, *_options(options)], progress)
        if failure and not os.path.exists(table):
            raise Error(*failure)
        return None if "part" in options else _mixed_table(table)


def _mixed_table(path):
    """Columns of numbers and of texts."""
    with open(path, newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    table = {}
    for name, cells in zip(head, zip(*rows)):
        try:
            table[name] = np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            table[name] = np.array(cells, dtype=object)
    return table


def export(model, *, name="stage_model", progress=None, **options):
    """A model as Rust source for the firmware: the source; with `lang="c"` a dictionary of two files, `name` before every name in them."""
    _without_own(options)
    with _folder() as folder:
        pair = [pathlib.Path(folder, name + ending) for ending in (".c", ".h")] if options.get("lang") == "c" else []
        output = ["-o", str(pair[0])] if pair else []
        said, _, failure = run(["export", _model_file(model, pathlib.Path(folder)), *_options(options), *output], progress)
        if failure:
            raise Error(failure[0].replace(folder + os.sep, ""), failure[1])
        return {file.name: file.read_text(encoding="utf-8") for file in pair} or said
