from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Union, overload

import numpy as np

__version__: str

#: A path, or columns by name: a mapping of arrays, a pandas or a polars frame.
Recording = Union[str, PathLike[str], Mapping[str, Any], Any]
#: Called with what is being done, the steps done, and how many there are (0 where nobody knows).
Progress = Callable[[str, int, int], object]
#: Time (s), position, velocity and acceleration under `t`, `x`, `v`, `a`; to the force or torque. Forward, with the recorded `force` besides: to
#: the position, or to position and force.
Simulation = Callable[[dict[str, np.ndarray]], Any]

class Error(Exception):
    exit_code: int
    result: Result | None

class View:
    def __getattr__(self, name: str) -> Any: ...
    def __getitem__(self, name: str) -> Any: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def to_dict(self) -> dict[str, Any]: ...

class Result(View):
    text: str
    warnings: list[str]
    model: Model | None
    data: dict[str, np.ndarray] | None
    code: str | None
    def corrector(self) -> Corrector: ...
    def plot(self, ax: Any = None) -> Any: ...

class Corrector:
    def force(self, t: float, x: float, v: float, a: float, *measured: float) -> float: ...
    def terms(self, t: float, x: float, v: float, a: float, *measured: float) -> dict[str, float]: ...
    def reset(self) -> None: ...

class Model:
    def __init__(self, source: str | PathLike[str]) -> None: ...
    @property
    def inertia(self) -> float: ...
    @property
    def rotary(self) -> bool: ...
    @property
    def breakaway(self) -> float | None: ...
    def to_toml(self) -> str: ...
    def save(self, path: str | PathLike[str]) -> None: ...
    def force(
        self,
        t: Sequence[float] | np.ndarray,
        x: Sequence[float] | np.ndarray,
        v: Sequence[float] | np.ndarray | None = None,
        a: Sequence[float] | np.ndarray | None = None,
        *,
        temperature: np.ndarray | None = None,
        load: np.ndarray | None = None,
    ) -> np.ndarray: ...
    def stepper(self, rate: float) -> Stepper: ...

class Stepper:
    def step(
        self, x: float, v: float | None = None, a: float | None = None, temperature: float | None = None, load: float | None = None
    ) -> float: ...
    def reset(self) -> None: ...

def identify(*recordings: Recording, progress: Progress | None = None, **options: Any) -> Result: ...
def compare(*recordings: Recording, progress: Progress | None = None, **options: Any) -> Result: ...
def diagnose(
    *recordings: Recording,
    model: Model | Result | str | PathLike[str] | None = None,
    simulate: Simulation | None = None,
    simulate_motion: Simulation | None = None,
    simulated: Recording | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Result: ...
def simulate(
    model: Model | Result | str | PathLike[str],
    *,
    motion: Recording | None = None,
    force: Recording | None = None,
    reference: Recording | None = None,
    controller: str | PathLike[str] | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Result: ...
def tune(
    model: Model | Result | str | PathLike[str],
    *,
    recording: Recording | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Result: ...
def fleet(
    *recordings: str | PathLike[str], output: str | PathLike[str] | None = None, progress: Progress | None = None, **options: Any
) -> dict[str, np.ndarray] | None: ...
@overload
def export(
    model: Model | Result | str | PathLike[str], *, lang: Literal["c"], name: str = "stage_model", progress: Progress | None = None, **options: Any
) -> dict[str, str]: ...
@overload
def export(model: Model | Result | str | PathLike[str], *, progress: Progress | None = None, **options: Any) -> str: ...
