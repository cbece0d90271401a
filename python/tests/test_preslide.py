"""The functions are the tool's commands: equal answers, equal words, equal errors."""

import csv
import json
import os
import pathlib
import re

import numpy as np
import pytest

import preslide

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared"


#: Commands, each with its recording and what it is asked; comparing twenty models takes long.
ASKED = {
    "identify": ("recording.csv", {}),
    "compare": ("short.csv", {"train": "0..3", "test": "3..5"}),
    "diagnose": ("recording.csv", {}),
}


def plain(values):
    """An answer without how long it took."""
    return {key: value for key, value in values.items() if key != "seconds"}


def columns(path):
    with open(path, newline="") as file:
        rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    return {name: np.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}


@pytest.fixture(scope="module")
def answers(axis):
    """What each command on a recording finds."""
    return {command: getattr(preslide, command)(axis / file, **options) for command, (file, options) in ASKED.items()}


@pytest.mark.parametrize("command", ASKED)
def test_an_answer_is_what_the_tool_writes(command, answers, tool, axis, tmp_path):
    file, options = ASKED[command]
    options = [part for key, value in options.items() for part in (f"--{key}", value)]
    done, written = tool(command, axis / file, *options, folder=tmp_path)
    found = answers[command]
    assert plain(found.to_dict()) == plain(written)
    text = done.stdout
    if command == "diagnose":
        # The command that follows names a model file, which there is none of from Python.
        text, last = text.rsplit("Next: ", 1)
        assert last.count("\n") == 1
    assert found.text == text


def test_simulate_tune_and_export_are_the_tools(tool, axis, tmp_path):
    model, file = axis / "model.toml", axis / "recording.csv"
    done, written = tool("simulate", model, "--motion", file, folder=tmp_path)
    found = preslide.simulate(model, motion=file)
    assert plain(found.to_dict()) == plain(written) and found.text == done.stdout
    assert list(found.data)[0] == "t_s" and len(found.data["t_s"]) == len(columns(file)["t_s"])

    done, written = tool("tune", model, "--count", "25nm", folder=tmp_path)
    found = preslide.tune(preslide.Model(model), count="25nm")
    # A model that is no file is named as if it were one here.
    assert plain(found.to_dict()) == plain(written) and found.text == done.stdout.replace(str(model), "model.toml")

    done, _ = tool("export", model, folder=tmp_path, json_file=False)
    # The hash and the name of the file are the tool's, too.
    assert preslide.export(model) == done.stdout
    pair = preslide.export(model, lang="c", rate=20000, name="axis_model")
    assert sorted(pair) == ["axis_model.c", "axis_model.h"] and "axis_model_step(" in pair["axis_model.h"]


def test_arrays_and_frames_are_what_the_file_is(axis):
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    file = axis / "recording.csv"
    of_file = preslide.identify(file)
    for frame in (columns(file), pandas.DataFrame(columns(file)), polars.DataFrame(columns(file))):
        found = preslide.identify(frame)
        assert found.recording == "recording.npz"
        assert plain(found.to_dict()) | {"recording": ""} == plain(of_file.to_dict()) | {"recording": ""}


def test_attributes_words_and_model(axis):
    found = preslide.identify(axis / "recording.csv", train="0..6")
    mass = found.fit.parameters.mass_kg
    assert mass.ci95[0] <= mass.value <= mass.ci95[1]
    assert found["fit"]["parameters"].to_dict() == found.to_dict()["fit"]["parameters"]
    assert str(found) == found.text and "<pre>" in found._repr_html_()
    assert abs(found.model.inertia - mass.value) < 1e-3 * mass.value
    with pytest.raises(AttributeError, match="no `mass` here, but"):
        found.fit.mass
    again = preslide.Model(found.model.to_toml())
    assert again.to_toml() == found.model.to_toml()


def test_errors_are_the_tools_words(tool, axis, tmp_path):
    for arguments, options in (
        (["nowhere.csv"], {}),
        ([axis / "recording.csv"], {"train": "7..3"}),
        ([axis / "recording.csv"], {"no_such": 1}),
    ):
        flags = [part for key, value in options.items() for part in ("--" + key.replace("_", "-"), value)]
        done, _ = tool("identify", *arguments, *flags, folder=tmp_path)
        with pytest.raises(preslide.Error) as refused:
            preslide.identify(*arguments, **options)
        assert refused.value.exit_code == done.returncode
        assert str(refused.value).splitlines()[0] in done.stderr
    with pytest.raises(preslide.Error, match="different lengths"):
        preslide.identify({"t_s": [0.0, 1.0], "x_m": [0.0]})
    with pytest.raises(preslide.Error, match="result.model"):
        preslide.identify(axis / "recording.csv", output="m.toml")


def test_progress_is_heard_and_what_it_raises_arrives(axis):
    heard = []
    preslide.identify(axis / "recording.csv", progress=lambda *step: heard.append(step))
    assert heard[0][0] == "identify" and all(what and 0 < done <= of for what, done, of in heard)

    def tired(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        preslide.identify(axis / "recording.csv", progress=tired)


def test_a_model_computes_what_simulate_does(axis):
    file, model = axis / "recording.csv", preslide.Model(axis / "model.toml")
    found = preslide.simulate(model, motion=file)
    t, x, v, force = found.data.values()
    inertial = preslide.simulate(preslide.Model(axis / "model.toml"), motion=file)
    assert np.array_equal(inertial.data["force_N"], force)
    # Without inertia, which simulate takes from a filtered acceleration.
    own = model.force(t, x, v, np.zeros_like(x))
    of_mass = force - own
    a = np.gradient(v, t)
    inside = slice(50, -50)
    share = np.sum(of_mass[inside] * a[inside]) / np.sum(a[inside] ** 2)
    left = of_mass[inside] - share * a[inside]
    print(f"inertia {share} of {model.inertia}, {np.sqrt(np.mean(left**2))} N RMS left, bias {np.mean(left)}")
    assert abs(share / model.inertia - 1.0) < 0.01
    assert np.sqrt(np.mean(left**2)) < 0.02 * np.sqrt(np.mean(force**2))


def test_a_stepper_has_the_bits_of_the_arrays(axis):
    model = preslide.Model(axis / "model.toml")
    data = columns(axis / "short.csv")
    t, x = data["t_s"], data["x_m"]
    v = np.gradient(x, t)
    a = np.gradient(v, t)
    whole = model.force(t, x, v, a)
    stepper = model.stepper((t.size - 1) / (t[-1] - t[0]))
    for _ in range(2):
        assert np.array_equal([stepper.step(*now) for now in zip(x, v, a)], whole)
        stepper.reset()
    # Without a velocity it is the way since the last tick.
    assert stepper.step(x[0]) == stepper.step(x[0])
    step = (t[-1] - t[0]) / (t.size - 1)
    back = np.diff(x, prepend=x[0]) / step
    stepper.reset()
    found, wanted = [stepper.step(now) for now in x], model.force(t, x, back, np.zeros_like(x))
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12)
    for rate, why in ((0.0, "above zero"), (-5.0, "above zero")):
        with pytest.raises(preslide.Error, match=why):
            model.stepper(rate)
    delayed = preslide.Model(model.to_toml() + '\n[[effects]]\nid = "channel_delay"\ndelay_s = 1e-3\n')
    with pytest.raises(preslide.Error, match="channel_delay: it cannot be computed tick by tick"):
        delayed.stepper(1e3)


def test_a_simulation_of_ones_own_is_called_and_corrected():
    """A machine with a cogging that its simulation lacks."""
    t = np.arange(0.0, 40.0, 1e-3)
    waves = ((0.02, 2.1), (0.007, 7.3), (0.0025, 17.9))
    x = sum(a * np.sin(w * t) for a, w in waves)
    v = sum(a * w * np.cos(w * t) for a, w in waves)
    acceleration = sum(-a * w * w * np.sin(w * t) for a, w in waves)
    seed = 7
    noise = 0.01 * np.random.default_rng(seed).normal(size=t.size)
    print(f"seed {seed}")

    def friction(v):
        return 2.0 * np.tanh(v / 1e-3) + 4.0 * v

    machine = 3.0 * acceleration + friction(v) + 0.2 * np.cos(2 * np.pi * x / 8e-3) + noise
    asked = []

    def simulate(motion):
        asked.append(sorted(motion))
        return 3.0 * motion["a"] + friction(motion["v"])

    found = preslide.diagnose({"t_s": t, "x_m": x, "force_N": machine}, simulate=simulate)
    print(found)
    assert asked == [["a", "t", "v", "x"]]
    assert found.verdict == "missing-physics"
    first = next(e for e in found.effects if e.level == "confident")
    assert first.id == "periodic_force"
    assert abs(first.parameters.force_N.value / 0.2 - 1.0) < 0.05
    assert abs(first.parameters.period_m.value / 8e-3 - 1.0) < 0.01
    assert found.correction.nmse_corrected < 0.2 * found.correction.nmse_simulation
    # The simulation with the correction, called again, is consistent; the code adds what the table has.
    corrector = found.corrector()

    def added(motion):
        return np.array([corrector.force(*now) for now in zip(*(motion[key] for key in "txva"))])

    again = preslide.diagnose({"t_s": t, "x_m": x, "force_N": machine}, simulate=lambda m: simulate(m) + added(m))
    assert again.verdict == "consistent", again.text
    with pytest.raises(preslide.Error, match="there is no correction"):
        again.corrector()
    corrector.reset()
    own = found.data["force_sim_corrected_N"] - found.data["force_sim_N"]
    motion = {"t": t, "x": x, "v": v, "a": acceleration}
    np.testing.assert_allclose(added(motion)[100:-100], own[100:-100], atol=2e-3)
    with pytest.raises(preslide.Error, match="finite number"):
        preslide.diagnose({"t_s": t, "x_m": x, "force_N": machine}, simulate=lambda m: [1.0])


def test_what_a_simulation_answers_wrongly_is_said():
    """That one moves forward and is corrected is shown on the page, which runs below."""
    t = np.arange(0.0, 5.0, 1e-3)
    x = 0.02 * np.sin(2.1 * t)
    recording, asked = {"t_s": t, "x_m": x, "force_N": np.cos(t)}, []
    for answer, why in (([1.0], "finite number"), ((x, x, x), "position and force"), (x * np.nan, "finite number")):

        def simulate_motion(motion, answer=answer):
            asked.append(sorted(motion))
            return answer

        with pytest.raises(preslide.Error, match=why):
            preslide.diagnose(recording, simulate_motion=simulate_motion)
    assert asked == 3 * [["a", "force", "t", "v", "x"]]
    with pytest.raises(preslide.Error, match="one of model, simulate"):
        preslide.diagnose(recording, simulate=lambda motion: x, simulate_motion=lambda motion: x)


def test_a_simulation_in_a_file_of_its_own():
    twins = SHARED / "cases" / "twins"
    if not twins.exists():
        pytest.skip(f"SKIPPED: {twins} is not there")
    found = preslide.diagnose(twins / "joint_clean.rec.csv", simulated=str(twins / "joint_clean.twin.csv"))
    assert found.verdict == "parameters-differ"


@pytest.mark.skipif(os.environ.get("PRESLIDE_LONG") != "1", reason="half a minute: `cargo xtask test --all python`")
def test_a_gap_behind_a_spring_that_the_simulation_has():
    twins = SHARED / "cases" / "twins"
    if not twins.exists():
        pytest.skip(f"SKIPPED: {twins} is not there")
    found = preslide.diagnose(twins / "ballscrew_backlash.force.csv", simulated="force_sim_N")
    print(found)
    truth = json.loads((twins / "ballscrew_backlash.truth.json").read_text())["truth"]["backlash"]["gap"]
    gap = next(e for e in found.effects if e.id == "backlash")
    assert gap.level == "confident" and not gap.in_simulation and found.verdict == "missing-physics"
    low, high = gap.parameters.gap_m.ci95
    assert low < truth < high and abs(gap.parameters.gap_m.value / truth - 1.0) < 0.25
    # The table's column over all samples.
    assert found.correction.nmse_corrected < 0.25 * found.correction.nmse_simulation


def test_plots_draw(answers, axis):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    for result in (*answers.values(), preslide.simulate(axis / "model.toml", motion=axis / "recording.csv")):
        ax = result.plot()
        assert (ax.lines or ax.patches) and ax.get_xlabel()
    # The last: what a motion takes is a force.
    assert ax.get_ylabel() == "force (N)"
    with pytest.raises(preslide.Error, match="nothing to draw"):
        preslide.tune(axis / "model.toml", count="25nm").plot()


@pytest.mark.parametrize("page", ["python/README.md", "docs/src/python.md"])
def test_what_the_pages_show_runs(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    for block in blocks:
        names = {}
        exec(compile(block, page, "exec"), names)
        said = capsys.readouterr().out
        assert said.strip(), block
        if "confident" in block:
            assert "['periodic_force']" in said.splitlines()[-1], said[-400:]
        if "corrector" in block:
            without, corrected = map(float, said.splitlines()[-2].split())
            assert corrected < 0.1 * without and said.strip().endswith("consistent"), said[-400:]
