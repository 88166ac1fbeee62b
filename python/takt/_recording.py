"""Channels of recordings as arrays (docs/python.md, "Data")."""
from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _takt
from ._errors import Diagnostic, RecordingError

if TYPE_CHECKING:
    import numpy as np


def _no_such(what: str, name: str, choices: list[str]) -> RecordingError:
    from difflib import get_close_matches
    near = get_close_matches(name, choices, 1)
    hint = (f"Did you mean '{near[0]}'? " if near else "") + "There are " + ", ".join(sorted(choices)[:30])
    return RecordingError([Diagnostic("error", "unknown-name", f"the recording has no {what} '{name}'", hint, name)])


def _need(module: str, extra: str) -> Any:
    import importlib
    try:
        return importlib.import_module(module)
    except ImportError:
        raise RecordingError([Diagnostic("error", "requires", f"{module} is not installed",
                                         f"Install it: pip install 'takt[{extra}]'")]) from None


class Curve:
    """Values over time. `values` has a row for each sample, and a column for each of `columns`; NaN: there was none."""

    def __init__(self, name: str, time: "np.ndarray", values: "np.ndarray", columns: list[str], unit: str):
        self.name, self.time, self.values, self.columns, self.unit = name, time, values, columns, unit

    def __len__(self) -> int:
        return len(self.time)

    def __array__(self, dtype: Any = None, copy: Any = None) -> "np.ndarray":
        import numpy as np
        return np.array(self.values, dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        return f"<curve '{self.name}' [{self.unit}]: {len(self.time)} samples of {', '.join(self.columns)}>"

    def __getitem__(self, column: str) -> "Curve":
        """One of its columns as a curve."""
        if column not in self.columns:
            raise _no_such("column", column, self.columns)
        index = self.columns.index(column)
        values = self.values if self.values.ndim == 1 else self.values[:, index]
        return Curve(f"{self.name}.{column}", self.time, values, [column], self.unit)

    def norm(self) -> "Curve":
        """The length of each row."""
        import numpy as np
        length = np.abs(self.values) if self.values.ndim == 1 else np.linalg.norm(self.values, axis=1)
        return Curve(f"|{self.name}|", self.time, length, ["norm"], self.unit)

    def _flat(self) -> "np.ndarray":
        """The only column, without what is not there; of several the length of each row."""
        import numpy as np
        values = self.values if self.values.ndim == 1 else self.norm().values
        return np.asarray(values[~np.isnan(values)])

    # Features, as `takt compare` has them; of several columns those of their length.
    @property
    def max(self) -> float:
        return float(self._flat().max())

    @property
    def min(self) -> float:
        return float(self._flat().min())

    @property
    def end(self) -> float:
        return float(self._flat()[-1])

    @property
    def peak(self) -> float:
        """The greatest magnitude."""
        return float(abs(self._flat()).max())

    @property
    def mean(self) -> float:
        """Over time."""
        import numpy as np
        values = self.values if self.values.ndim == 1 else self.norm().values
        known = ~np.isnan(values)
        time, values = self.time[known], values[known]
        if len(time) < 2 or time[-1] == time[0]:
            return float(values[0])
        return float(np.sum((values[1:] + values[:-1]) / 2 * np.diff(time)) / (time[-1] - time[0]))

    @property
    def duration(self) -> float:
        """From the first value to the last, s."""
        return float(self.time[-1] - self.time[0])

    def settling(self, within: float) -> float:
        """From then on (s) it stays within so much of its last value."""
        import numpy as np
        values = self.values if self.values.ndim == 1 else self.norm().values
        outside = np.flatnonzero(~(np.abs(values - values[-1]) <= within))
        return float(self.time[0] if len(outside) == 0 else self.time[min(outside[-1] + 1, len(values) - 1)])

    def path(self) -> float:
        """The length of the way up and down; of several columns of the way in space."""
        import numpy as np
        steps = np.diff(self.values, axis=0)
        return float(np.nansum(np.abs(steps) if steps.ndim == 1 else np.linalg.norm(steps, axis=1)))

    def plot(self, axes: Any = None) -> Any:
        """Draws it with matplotlib. Returns the axes."""
        if axes is None:
            axes = _need("matplotlib.pyplot", "plot").figure().add_subplot()
        lines = axes.plot(self.time, self.values)
        for line, label in zip(lines, self.columns):
            line.set_label(label)
        axes.set_xlabel("time [s]")
        axes.set_ylabel(f"{self.name} [{self.unit}]" if self.unit else self.name)
        axes.legend(fontsize="small")
        return axes

    def to_arrow(self) -> Any:
        """A table of pyarrow: time_s and the columns."""
        pyarrow = _need("pyarrow", "arrow")
        columns = [self.values] if self.values.ndim == 1 else list(self.values.T)
        fields = [pyarrow.field("time_s", pyarrow.float64())]
        fields += [pyarrow.field(name, pyarrow.float64(), metadata={"unit": self.unit}) for name in self.columns]
        return pyarrow.table([self.time, *columns], schema=pyarrow.schema(fields))


class Channel:
    """A topic of a recording: columns over time. Groups of columns are attributes: .position, .force."""

    def __init__(self, recording: "Recording", header: dict[str, Any]):
        self._recording, self._header = recording, header
        self._values: tuple[Any, list[Any]] | None = None

    @property
    def topic(self) -> str:
        return str(self._header["topic"])

    @property
    def columns(self) -> list[str]:
        return list(self._header["columns"])

    @property
    def units(self) -> dict[str, str]:
        """The unit of each column."""
        return dict(zip(self._header["columns"], self._header["units"]))

    def __len__(self) -> int:
        return int(self._header["rows"])

    def __repr__(self) -> str:
        return f"<channel '{self.topic}': {len(self)} rows of {', '.join(self.columns[:8])}>"

    def _read(self) -> tuple[Any, list[Any]]:
        if self._values is None:
            self._recording._read([self])
        assert self._values is not None
        return self._values

    @property
    def time(self) -> "np.ndarray":
        """s"""
        import numpy as np
        return np.asarray(self._read()[0])

    def __getitem__(self, column: str) -> Curve:
        """One column, "a1.position", or all of a group: "position"."""
        import numpy as np
        time, values = self._read()
        if column in self.columns:
            index = self.columns.index(column)
            return Curve(column, time, values[index], [column], self._header["units"][index])
        found = self._groups().get(column)
        if found is None:
            raise _no_such("column", column, self.columns + list(self._groups()))
        names = [self.columns[index] for index in found]
        return Curve(column, time, np.column_stack([values[index] for index in found]), names,
                     self._header["units"][found[0]])

    def _groups(self) -> dict[str, list[int]]:
        """Columns that belong together: "force.x" to "force.z", "a1.position" to "a7.position"."""
        groups: dict[str, list[int]] = {}
        for index, name in enumerate(self.columns):
            first, _, last = name.rpartition(".")
            for group in {first, last} - {""}:
                groups.setdefault(group, []).append(index)
        return groups

    def __getattr__(self, name: str) -> Curve:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except RecordingError as error:
            raise AttributeError(str(error)) from None

    def to_arrow(self) -> Any:
        """A table of pyarrow: time_s and the columns, each with its unit as metadata. The numbers are not copied."""
        pyarrow = _need("pyarrow", "arrow")
        time, values = self._read()
        fields = [pyarrow.field("time_s", pyarrow.float64())]
        fields += [pyarrow.field(name, pyarrow.float64(), metadata={"unit": unit}) for name, unit in self.units.items()]
        return pyarrow.table([time, *values], schema=pyarrow.schema(fields))


class Device:
    """The channels of a device: its groups of columns are attributes, whichever of its channels has them."""

    def __init__(self, name: str, channels: list[Channel]):
        self._name, self._channels = name, channels

    @property
    def channels(self) -> list[Channel]:
        return list(self._channels)

    def __repr__(self) -> str:
        return f"<channels of '{self._name}': {', '.join(one.topic for one in self._channels)}>"

    def __getitem__(self, column: str) -> Curve:
        offered: list[str] = []
        for one in self._channels:
            if column in one.columns or column in one._groups():
                curve = one[column]
                curve.name = f"{self._name} {column}"
                return curve
            offered += one.columns + list(one._groups())
        raise _no_such("column", column, offered)

    def __getattr__(self, name: str) -> Curve:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except RecordingError as error:
            raise AttributeError(str(error)) from None


class Recording:
    """A recording (MCAP), of takt or of another program: recording["left"].position, recording["/left/wrench"]."""

    def __init__(self, path: str | os.PathLike[str]):
        self.path = os.fspath(path)
        self._native = _takt.open_recording(self.path)
        self._contents = json.loads(self._native.contents())
        self._channels = {one["topic"]: Channel(self, one) for one in self._contents["tables"]}

    @property
    def topics(self) -> list[str]:
        """Topics of numbers."""
        return list(self._channels)

    @property
    def metadata(self) -> dict[str, dict[str, str]]:
        return dict(self._contents["metadata"])

    @property
    def damage(self) -> list[str]:
        """What of the file is not whole, in words."""
        return list(self._contents["damage"])

    @property
    def duration(self) -> float:
        """s"""
        return float(self._contents["end"] - self._contents["start"])

    def events(self, topic: str = "/program") -> list[dict[str, Any]]:
        """time, cycle, source, name, text, step of each."""
        return list(json.loads(self._native.events(topic))["events"])

    def __contains__(self, name: str) -> bool:
        return name in self._channels or bool(self._of_device(name))

    def _of_device(self, name: str) -> list[Channel]:
        found = [one for topic, one in self._channels.items() if topic.startswith(f"/{name}/") or topic == f"/{name}"]
        return sorted(found, key=lambda one: one.topic.endswith("/command"))  # what was measured first

    def __getitem__(self, name: str) -> Device | Channel:
        """A topic, or a device with all of its topics."""
        if name in self._channels:
            return self._channels[name]
        found = self._of_device(name)
        if not found:
            devices = {topic.split("/")[1] for topic in self._channels if topic.startswith("/")}
            raise _no_such("device or topic", name, list(self._channels) + sorted(devices))
        return Device(name, found)

    def _read(self, channels: list[Channel]) -> None:
        for one, values in zip(channels, self._native.tables([one.topic for one in channels])):
            one._values = values

    def to_arrow(self, name: str | None = None) -> Any:
        """A topic, or a part of a device ("left.position"), as a table of pyarrow with time in s. Without a name all
        topics, as a dict of tables; that reads the file once, and not once for each topic."""
        if name is None:
            self._read([one for one in self._channels.values() if one._values is None])
            return {topic: one.to_arrow() for topic, one in self._channels.items()}
        if name in self._channels:
            return self._channels[name].to_arrow()
        device, _, column = name.partition(".")
        if not column:
            raise _no_such("topic", name, list(self._channels))
        return self[device][column].to_arrow()

    def __repr__(self) -> str:
        return f"<recording '{self.path}': {len(self._channels)} channels, {self.duration:.3f} s>"


def open_recording(path: str | os.PathLike[str]) -> Recording:
    """Opens a recording, also a truncated one. Raises RecordingError."""
    return Recording(path)


@dataclass(frozen=True)
class Column:
    """One column of a comparison."""

    topic: str
    column: str
    unit: str
    passed: bool
    max_deviation: float | None


class Comparison:
    """Two recordings held against each other, as `takt compare` does."""

    def __init__(self, row: dict[str, Any]):
        self.report = row

    @property
    def passed(self) -> bool:
        return self.report["result"] == "passed" if "result" in self.report else bool(self.report["passed"])

    @property
    def columns(self) -> list[Column]:
        keys = ("topic", "column", "unit", "passed", "max_deviation")
        return [Column(**{key: one.get(key) for key in keys}) for one in self.report["columns"]]

    def __str__(self) -> str:
        return str(self.report["text"])

    def __repr__(self) -> str:
        return f"<comparison: {'passed' if self.passed else 'failed'}, {len(self.columns)} columns>"


def _path_of(what: Any) -> str:
    recording = getattr(what, "recording", what)
    return str(os.fspath(getattr(recording, "path", recording)))


def compare(a: Any, b: Any, *, equal_digests: bool = False, report: str | os.PathLike[str] | None = None) -> Comparison:
    """Compares two runs, recordings or files of recordings. equal_digests: one differing bit is a failure; report: an HTML
    page with the curves."""
    page = os.fspath(report) if report is not None else ""
    return Comparison(json.loads(_takt.compare(_path_of(a), _path_of(b), equal_digests, page)))
