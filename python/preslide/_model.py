"""A model file at work."""

import os

import numpy as np

from ._preslide import Model as _Model
from ._result import Error


def _column(values):
    return None if values is None else np.ascontiguousarray(values, dtype=np.float64)


class Model:
    """A model of an axis: from a file, or from the text of one."""

    def __init__(self, source):
        text, name = str(source), "model"
        if isinstance(source, os.PathLike) or "\n" not in text:
            name = text
            try:
                with open(source, encoding="utf-8") as file:
                    text = file.read()
            except OSError as error:
                raise Error(f"{source}: {error.strerror or error}") from None
        try:
            self._own = _Model(text)
        except ValueError as error:
            raise Error(f"{name}: {error}") from None

    @property
    def inertia(self):
        """Moving mass (kg) or moment of inertia (kg·m²); 0 where the model has none."""
        return self._own.inertia

    @property
    def rotary(self):
        """Whether the axis turns."""
        return self._own.rotary

    @property
    def breakaway(self):
        """Force (N or N·m) at which it breaks away from rest; None where its friction has no such force."""
        return self._own.breakaway

    def to_toml(self):
        """The model file's text."""
        return self._own.to_toml()

    def save(self, path):
        """Writes the model file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.to_toml())

    def force(self, t, x, v=None, a=None, *, temperature=None, load=None):
        """The force (N or N·m) that a motion takes at every sample.

        `t` in s, evenly spaced; `x` in m or rad; `v` and `a` by differences of `x` where they are not given. Without `a` of your own a noisy
        position makes a noisy inertial force: `preslide.simulate` filters it.
        """
        t, x = _column(t), _column(x)
        if t.shape != x.shape or t.size < 2:
            raise Error("t and x need as many samples each, two at least")
        v = np.gradient(x, t) if v is None else _column(v)
        a = np.gradient(v, t) if a is None else _column(a)
        try:
            return self._own._force(t, x, v, a, _column(temperature), _column(load))
        except ValueError as error:
            raise Error(str(error)) from None

    def stepper(self, rate):
        """The model a tick at a time, `rate` ticks a second (Hz), from rest: for simulators and loops that have but the present.

        `.step(x, v, a)` is the force that `force` has at that sample. Without `v` it takes the way since the last tick; without `a` the force of
        the inertia is left out. `temperature` and `load` are further arguments. `.reset()` goes back to rest.
        """
        if not rate > 0.0:
            raise Error(f"rate={rate}: give the ticks a second (Hz), above zero")
        try:
            return self._own.stepper(rate)
        except ValueError as error:
            raise Error(str(error)) from None

    def __repr__(self):
        return f"<preslide.Model, inertia {self.inertia:.4g}, breakaway {self.breakaway}>"
