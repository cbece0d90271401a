"""Friction of positioning axes: from a recording to parameters, a diagnosis and a model that runs.

Each function is a command of the `preslide` tool, run in this process. A recording is a path, a mapping of column names to arrays, a pandas or a
polars frame; columns are named as in files: `t_s`, `x_m` or `q_rad`, and an effort such as `force_N`. Options are those of the command line, with
underscores: `identify(axis, train="0..20", map={"force_N": "35.15*voltage_V"})`.
"""

from ._commands import compare, diagnose, export, fleet, identify, simulate, tune
from ._model import Model
from ._preslide import __version__
from ._result import Error, Result

__all__ = ["Error", "Model", "Result", "__version__", "compare", "diagnose", "export", "fleet", "identify", "simulate", "tune"]
