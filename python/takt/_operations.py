"""Operations as Python's functions, made from the tables of the core (docs/operations.md)."""
from __future__ import annotations

import functools
import json
import keyword
import math
from typing import Any

from . import _takt
from ._errors import refuse
from ._run_handles import Activity, Run

GOALS = ("to", "via", "base_to", "through")
DEVICES = ("arm", "gripper", "tool_changer", "output")
# Of planned motions, beside the table: what files do not have.
MOTION_EXTRAS = ("blend", "X_FM")


def python_name(key: str) -> str:
    """The keyword of a parameter: its key, with an underscore where Python has that word."""
    return key + "_" if keyword.iskeyword(key) else key


class Specification:
    """One operation: its row of the tables, and how its parameters are given in Python."""

    def __init__(self, table: dict[str, Any]):
        self.name: str = table["name"]
        self.doc: str = table["doc"]
        self.is_motion: bool = table["motion"]
        self.is_activity: bool = table["activity"]
        self.is_step: bool = table["step"]
        self.parameters: list[dict[str, Any]] = table["parameters"]
        self.by_python = {python_name(one["key"]): one["key"] for one in self.parameters}

    @property
    def device(self) -> dict[str, Any] | None:
        """The parameter that names who does it; None: the cell."""
        return next((one for one in self.parameters if one.get("names") in DEVICES), None)

    def free(self) -> list[dict[str, Any]]:
        """All parameters but the device."""
        device = self.device
        return [one for one in self.parameters if one is not device]

    def positional(self) -> list[dict[str, Any]]:
        """Those that may be given without a keyword: goals and what is required, else the first one."""
        named = [one for one in self.free() if one["key"] in ("to", "via", "through") or one["required"]]
        return named or [one for one in self.free() if one["key"] not in ("tool", "tcp")][:1]

    def docstring(self) -> str:
        lines = [self.doc, ""]
        for one in self.free():
            end = "required" if one["required"] else f"default {one['default']}" if one["default"] else "optional"
            lines.append(f"{python_name(one['key'])}: {one['doc']} ({one['says']}; {end})")
        if self.is_motion:
            lines += ["blend: share of its time from which the next motion may take over, 0.5 to 1 (optional)",
                      "X_FM: pose of the frame that moves, in the flange, 4x4 in m (optional)"]
        return "\n".join(lines)


@functools.cache
def specifications() -> dict[str, Specification]:
    return {one["name"]: Specification(one) for one in json.loads(_takt.operations())}


def plain(value: Any, pointer: str) -> Any:
    """A value as JSON has it."""
    if value is None or isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            raise refuse("invalid-value", pointer, f"{value} is not a number", "Give a finite number")
        return value
    if isinstance(value, dict):
        return {str(key): plain(one, f"{pointer}/{key}") for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(one, f"{pointer}/{index}") for index, one in enumerate(value)]
    if hasattr(value, "as_file"):  # conditions and steps of files
        return value.as_file()
    if hasattr(value, "tolist"):  # numpy, its scalars too
        return plain(value.tolist(), pointer)
    if isinstance(value, _takt.State):
        raise refuse("wrong-type", pointer, "a state of a cell inside of an object of files",
                     "Build it from takt.force, takt.input, takt.gripper, takt.distance")
    raise refuse("wrong-type", pointer, f"unexpected value {value!r}", "Give numbers, texts, lists, dictionaries or arrays")


def _goal(value: Any, key: str, arm: str) -> Any:
    """A goal as files have it, or a Goal of the core."""
    if value == "home" if isinstance(value, str) else isinstance(value, dict):
        return plain(value, "/" + key)
    if isinstance(value, _takt.Goal):
        return value
    if isinstance(value, _takt.Frame):
        return _takt.goal_pose(arm, value.pose(arm), key)
    shape = getattr(value, "shape", None)
    if shape == (4, 4):
        return _takt.goal_pose(arm, value, key)
    if shape is not None and len(shape) == 1:
        return _takt.goal_joints(value, key)
    if hasattr(value, "as_file"):
        return value.as_file()
    raise refuse("wrong-type", "/" + key, f"unexpected goal {value!r}",
                 'Give "home", a 4x4 array in the base of the arm (m), joint positions as an array (rad), a frame of the '
                 'cell, or an object of files like {"joints_deg": [...]}')


def _put_goals(key: str, given: Any, arm: str, row: dict[str, Any], values: _takt.Values) -> None:
    if key != "through":
        goal = _goal(given, key, arm)
        if isinstance(goal, _takt.Goal):
            values.goals(key, [goal])
        else:
            row[key] = goal
        return
    if not hasattr(given, "__iter__") or isinstance(given, (str, dict)):
        raise refuse("wrong-type", "/through", f"unexpected value {given!r}", "Give a list of goals")
    goals = [_goal(one, f"through/{index}", arm) for index, one in enumerate(given)]
    native = [isinstance(one, _takt.Goal) for one in goals]
    if all(native) and goals:
        values.goals(key, goals)
    elif any(native):
        raise refuse("conflict", "/through", "arrays and objects of files in one list", "Use goals of one kind")
    else:
        row[key] = goals


def written(spec: Specification, fixed: dict[str, Any], arguments: tuple[Any, ...], keywords: dict[str, Any]) -> tuple[str, _takt.Values]:
    """The call as a file would have it, and what files do not have."""
    given = dict(fixed)
    positional = spec.positional()
    if len(arguments) > len(positional):
        names = ", ".join(python_name(one["key"]) for one in positional)
        raise refuse("usage", "", f"{spec.name}() accepts {len(positional)} arguments without a keyword, "
                     f"not {len(arguments)}", f"Name the others: {spec.name}({names}, ..., KEY=VALUE)")
    for one, value in zip(positional, arguments):
        given[one["key"]] = value
    for name, value in keywords.items():
        key = spec.by_python.get(name, name)
        if key in given:
            raise refuse("duplicate", "/" + key, f"{spec.name}() got '{key}' twice", "Give it once")
        if value is not None:
            given[key] = value
    row: dict[str, Any] = {"do": spec.name}
    values = _takt.Values()
    arm = str(fixed.get("arm", ""))
    for key, value in given.items():
        if key in GOALS and spec.is_motion:
            _put_goals(key, value, arm, row, values)
        elif isinstance(value, _takt.State):
            values.state(key, value)
        elif spec.is_motion and key == "blend":
            values.blend = float(value)
        elif spec.is_motion and key == "X_FM":
            values.X_FM = value
        else:
            row[key] = plain(value, "/" + key)
    return json.dumps(row, allow_nan=False), values


class Operation:
    """An operation of a device: call it to carry it out, or make an activity of it."""

    __slots__ = ("_cell", "_spec", "_fixed")

    def __init__(self, cell: Any, spec: Specification, fixed: dict[str, Any]):
        self._cell, self._spec, self._fixed = cell, spec, fixed

    @property
    def __doc__(self) -> str:  # type: ignore[override]
        return self._spec.docstring()

    def __repr__(self) -> str:
        return f"<operation {self._spec.name} of {self._fixed or 'the cell'}>"

    def __call__(self, *arguments: Any, **keywords: Any) -> Run | None:
        """Carries it out and returns when it has ended. Raises OperationError if it did not come to its end."""
        text, values = written(self._spec, self._fixed, arguments, keywords)
        run = self._cell._blocking(_takt.execute, text, values)
        return Run(run) if run is not None else None

    def activity(self, *arguments: Any, **keywords: Any) -> Activity:
        """The same, to be carried out later: as a part of a composition, or beside others."""
        text, values = written(self._spec, self._fixed, arguments, keywords)
        return Activity(self._cell, _takt.activity(self._cell._native, text, values))

    def begin(self, *arguments: Any, **keywords: Any) -> Run:
        """Returns when it has started, in motion if what runs may be left."""
        return self.activity(*arguments, **keywords).begin()

    def schedule(self, *arguments: Any, **keywords: Any) -> Run:
        """Returns at once; it takes its turn behind what has its devices already."""
        return self.activity(*arguments, **keywords).schedule()


def _property(spec: Specification, device_key: str) -> property:
    def get(self: Any) -> Operation:
        return Operation(self._cell, spec, {device_key: self.name} if device_key else {})
    return property(get, doc=spec.docstring())


def operations_of(device: str) -> dict[str, property]:
    """The operations of a kind of device as properties of a class; "": those of the cell."""
    found = {}
    for spec in specifications().values():
        if not spec.is_step:
            continue
        row = spec.device
        if (row["names"] if row else "") != device:
            continue
        found[python_name(spec.name)] = _property(spec, row["key"] if row else "")
    return found
