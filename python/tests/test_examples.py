"""The notebook runs, and finds what it put in."""

import pathlib
import re

import pytest

NOTEBOOK = pathlib.Path(__file__).resolve().parents[1] / "examples" / "axis.ipynb"


def test_the_notebook_runs():
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300).execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    outputs = [output for cell in cells for output in cell.outputs]
    said = "".join(output.text for output in outputs if output.output_type == "stream" and output.name == "stdout")
    print(said)
    mass = float(re.search(r"^([0-9.]+) \[", said, re.MULTILINE)[1])
    assert abs(mass / 3.0 - 1.0) < 0.01
    assert "['periodic_force']" in said
    without, corrected = map(float, re.search(r"([0-9.e-]+) ([0-9.e-]+) % of the variance, without", said).groups())
    left = float(re.search(r"([0-9.e-]+) % of the variance left", said)[1])
    # The cogging is 0.3 % of the variance.
    assert corrected < 0.05 * without and left < 0.05 * without
    assert '<joint name="axis" type="slide"' in said
    assert any("image/png" in output.get("data", {}) for output in outputs), "no picture"
    assert any("text/html" in output.get("data", {}) for output in outputs), "no page of the result"
