"""Types of the operations, printed from the tables of the core.

Usage: python3 -m takt.stubs FOLDER: writes _device_operations.pyi, _step_operations.pyi and _takt.pyi there. A test compares
them with those of the package. The last one needs nanobind (PYTHONPATH=build/release/python:build/release/_deps/nanobind-3.1.0).
"""
from __future__ import annotations

import pathlib
import re
import sys
import textwrap
from typing import Any

from ._operations import Specification, python_name, specifications

WIDTH = 118
CLASSES = {"arm": "ArmOperations", "gripper": "GripperOperations", "tool_changer": "ToolChangerOperations",
           "output": "OutputOperations", "": "CellOperations"}
HEAD = '''"""Printed by `python3 -m takt.stubs` from the tables of operations: do not edit."""
'''
PLAIN = {"boolean": "bool", "integer": "int", "number": "float", "numbers": "Numbers", "vector": "Numbers", "text": "str",
         "texts": "Sequence[str]", "name": "str"}


def type_of(row: dict[str, Any], at_once: bool) -> str:
    """The Python type of a parameter."""
    if row["type"] == "choice":
        return "Literal[" + ", ".join(f'"{one}"' for one in row["choices"]) + "]"
    if row["type"] == "condition":
        return "Until" if at_once else "Condition | Mapping[str, Any] | str"
    if row["type"] == "object":
        goal = "Goal" if at_once else "FileGoal"
        return {"goal": goal, "through": f"Sequence[{goal}]", "commands": "Mapping[str, Any]",
                "motion_steps": "Sequence[Any]"}.get(row["definition"], "Any")
    kind = PLAIN[row["type"]]
    return kind if at_once or row["type"] == "text" else f"{kind} | str"  # an expression is a text


def parameters(spec: Specification, at_once: bool) -> list[str]:
    """As they stand in a definition."""
    positional = [one for one in spec.positional() if at_once or one is not spec.device]
    listed = spec.free() if at_once else spec.parameters
    result = []
    for one in positional:
        default = "" if one["required"] else " | None = ..."
        result.append(f"{python_name(one['key'])}: {type_of(one, at_once)}{default}")
    result.append("*")
    for one in listed:
        if one not in positional:
            result.append(f"{python_name(one['key'])}: {type_of(one, at_once)} | None = ...")
    if at_once and spec.is_motion:
        result += ["blend: float | None = ...", "X_FM: Array | None = ..."]
    if not at_once and result[-1] == "*":
        result.pop()
    return result if result[-1] != "*" else result[:-1]


def definition(head: str, listed: list[str], tail: str, indent: int) -> str:
    """A definition, broken where the line is too long."""
    space = " " * indent
    line = f"{space}{head}({', '.join(listed)}){tail}"
    if len(line) <= WIDTH:
        return line
    inner = textwrap.wrap(", ".join(one.replace(" ", "\0") for one in listed), WIDTH - indent - 4, break_long_words=False)
    body = "\n".join(f"{space}    {one}".replace("\0", " ") for one in inner)
    return f"{space}{head}(\n{body}\n{space}){tail}"


def docstring(spec: Specification, indent: int) -> str:
    space = " " * indent
    lines = spec.docstring().split("\n")
    body = "\n".join(textwrap.fill(one, WIDTH, initial_indent=space, subsequent_indent=space + "    ") if one else ""
                     for one in lines[1:])
    return f'{space}"""{lines[0]}\n{body}\n{space}"""'


def of_device(spec: Specification) -> str:
    """One operation of a class: a step of its own is called, an activity has begin(), schedule() and activity() too."""
    kind, run = ("operation", "Run") if spec.is_activity else ("step", "None")
    head = definition(f"def {python_name(spec.name)}", ["self", *parameters(spec, True)], f" -> {run}:", 4)
    return f"    @{kind}\n{head}\n{docstring(spec, 8)}"


def device_operations() -> str:
    specs = [one for one in specifications().values() if one.is_step]
    text = HEAD + '''from typing import Any, Callable, Concatenate, Generic, Literal, Mapping, ParamSpec, Sequence

import numpy as np
import numpy.typing as npt

from ._run_handles import Activity, Run
from ._takt import Frame, State
from ._takt import Goal as CoreGoal
from .conditions import Condition

Array = npt.NDArray[np.float64]
Numbers = Sequence[float] | Array
Until = State | Condition | Mapping[str, Any]
Goal = Literal["home"] | Array | Frame | CoreGoal | Mapping[str, Any]
P = ParamSpec("P")

class Operation(Generic[P]):
    def __call__(self, *arguments: P.args, **keywords: P.kwargs) -> Run: ...
    def activity(self, *arguments: P.args, **keywords: P.kwargs) -> Activity: ...
    def begin(self, *arguments: P.args, **keywords: P.kwargs) -> Run: ...
    def schedule(self, *arguments: P.args, **keywords: P.kwargs) -> Run: ...

class StepOperation(Generic[P]):
    def __call__(self, *arguments: P.args, **keywords: P.kwargs) -> None: ...

def operation(method: Callable[Concatenate[Any, P], Run]) -> Operation[P]: ...
def step(method: Callable[Concatenate[Any, P], None]) -> StepOperation[P]: ...
'''
    for device, name in CLASSES.items():
        own = [one for one in specs if (one.device["names"] if one.device else "") == device]
        text += f"\nclass {name}:\n" + "\n".join(of_device(one) for one in own) + "\n"
    return text


def step_operations() -> str:
    text = HEAD + '''from typing import Any, Literal, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from ._tree import Step
from .conditions import Condition

Numbers = Sequence[float] | npt.NDArray[np.float64]
FileGoal = str | Mapping[str, Any]

'''
    specs = list(specifications().values())
    names = ", ".join(f'"{python_name(one.name)}"' for one in specs)
    text += textwrap.fill(f"__all__ = [{names}]", WIDTH, subsequent_indent="           ") + "\n\n"
    rows = []
    for one in specs:
        head = definition(f"def {python_name(one.name)}", parameters(one, False), " -> Step:", 0)
        rows.append(f"{head}\n{docstring(one, 4)}")
    return text + "\n\n".join(rows) + "\n"


def module() -> str:
    """The types of the module below the package."""
    from nanobind.stubgen import StubGen  # type: ignore[import-not-found]
    from . import _takt
    printer = StubGen(_takt, include_private=True)
    printer.put(_takt)
    text = str(printer.get())
    text = text.replace("Sequence[float]", "Sequence[float] | NDArray[numpy.float64]").replace("-> tuple:", "-> tuple[Any, Any]:")
    text = text.replace("list[tuple]", "list[tuple[Any, Any]]")
    return HEAD + re.sub(r"from typing import (.*)", r"from typing import Any, \1", text, count=1)


FILES = {"_device_operations.pyi": device_operations, "_step_operations.pyi": step_operations, "_takt.pyi": module}

if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    for file, printed in FILES.items():
        (pathlib.Path(sys.argv[1]) / file).write_text(printed())
