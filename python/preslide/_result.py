"""What a command found."""

import copy
import html


class Error(Exception):
    """Why a command ended without its answer, in the words of the tool. `exit_code` is the tool's: 1 it failed, 2 bad input, 3 the data cannot tell."""

    def __init__(self, message, exit_code=2, result=None):
        super().__init__(message)
        self.exit_code = exit_code
        #: What was found nevertheless, such as a diagnosis that the recording does not say.
        self.result = result


class View:
    """A part of a result: its keys are attributes."""

    def __init__(self, values):
        self._values = values

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        values = self.__dict__.get("_values", {})
        try:
            return _view(values[name])
        except KeyError:
            raise AttributeError(f"no `{name}` here, but {', '.join(values)}") from None

    def __getitem__(self, name):
        return _view(self._values[name])

    def __iter__(self):
        return iter(self._values)

    def __len__(self):
        return len(self._values)

    def __dir__(self):
        return [*super().__dir__(), *self._values]

    def to_dict(self):
        """As the JSON file has it."""
        return copy.deepcopy(self._values)

    def __repr__(self):
        return f"View({', '.join(self._values)})"


def _view(value):
    if isinstance(value, dict):
        return View(value)
    if isinstance(value, list):
        return [_view(part) for part in value]
    return value


class Result(View):
    """What a command found. Printed, it is what the tool prints; its attributes are the keys of the tool's JSON file."""

    def __init__(self, command, values, text, warnings, model=None, data=None, code=None):
        super().__init__(values)
        self._command = command
        #: What the tool prints.
        self.text = text
        #: What it warns of.
        self.warnings = warnings
        #: The model that was found, where the command finds one.
        self.model = model
        #: Arrays by name, where the command makes a recording or a correction.
        self.data = data
        #: The correction of a simulation as Python code.
        self.code = code

    def corrector(self):
        """The correction of a simulation at work: `.force(t, x, v, a)`, called once for every sample in order, is what to add to its own force."""
        if self.code is None:
            raise Error("there is no correction here: nothing is stated that a simulation lacks")
        names = {}
        exec(compile(self.code, "correction.py", "exec"), names)  # What the tool wrote a moment ago.
        return names["Correction"]()

    def __str__(self):
        return self.text

    def __repr__(self):
        return f"<preslide {self._command}: {', '.join(self._values)}>"

    def _repr_html_(self):
        warned = "".join(f"<p><em>{html.escape(line)}</em></p>" for line in self.warnings)
        return f"<pre>{html.escape(self.text)}</pre>{warned}"

    def plot(self, ax=None):
        """Draws the answer with matplotlib; the axes that it drew in."""
        from ._plot import plot

        return plot(self._command, self, ax)
