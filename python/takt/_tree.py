"""Programs as trees: steps and nodes as objects, written as a scenario file like any other (docs/programs.md)."""
from __future__ import annotations

import copy
import json
import os
import pathlib
import tempfile
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Iterator, Mapping

from ._errors import OpenError, Diagnostic, refuse
from ._operations import plain
from ._options import find_file

if TYPE_CHECKING:
    from ._report import Report

__all__ = ["Scenario", "Step", "branch", "call", "charts", "fail", "for_each", "krl", "let", "log", "parallel", "repeat", "sequence", "stop", "tree",
           "try_"]


class Step:
    """A step or a node of a program tree, as files have it. step.named("approach") gives it a name."""

    def __init__(self, row: dict[str, Any]):
        self._row = row

    def as_file(self) -> dict[str, Any]:
        return self._row

    def named(self, name: str) -> "Step":
        """The same with a name for people, film and expectations."""
        return Step({**self._row, "name": name})

    def __repr__(self) -> str:
        return f"<step {self._row.get('name', self._row['do'])}>"


def _rows(steps: Any, pointer: str) -> list[dict[str, Any]]:
    rows = []
    for index, one in enumerate([steps] if isinstance(steps, Step) else steps):
        if not isinstance(one, (Step, dict)):
            raise refuse("wrong-type", f"{pointer}/{index}", f"unexpected step {one!r}",
                         "Give steps: takt.lin(...), takt.sequence(...)")
        rows.append(plain(one, f"{pointer}/{index}"))
    return rows


def _node(kind: str, **keys: Any) -> Step:
    return Step({"do": kind, **{key: plain(value, "/" + key) for key, value in keys.items() if value is not None}})


def sequence(*steps: Step, times: int | None = None, variables: Mapping[str, Any] | None = None,
             frames: list[str] | None = None) -> Step:
    """One step after the other."""
    return _node("sequence", times=times, variables=variables, frames=frames, steps=_rows(steps, "/steps"))


def parallel(*branches: Step, end: str | None = None) -> Step:
    """Branches side by side; end="first": the first one that completes ends the others."""
    return _node("parallel", end=end, branches=_rows(branches, "/branches"))


def branch(*cases: tuple[Any, Any], otherwise: Any = None) -> Step:
    """The first case whose condition is true: branch((condition, [steps]), ..., otherwise=[steps])."""
    rows = [{"when": plain(when, f"/cases/{index}/when"), "steps": _rows(steps, f"/cases/{index}/steps")}
            for index, (when, steps) in enumerate(cases)]
    step = _node("branch", cases=rows)
    return step if otherwise is None else Step({**step.as_file(), "else": _rows(otherwise, "/else")})


def repeat(*steps: Step, times: Any = None, while_: Any = None, until: Any = None, as_: str | None = None,
           at_most: int | None = None) -> Step:
    """Repeats its steps: so many times, while a condition is true, or until it is."""
    keys = {"times": times, "while": while_, "until": until, "as": as_, "at_most": at_most}
    return _node("repeat", **keys, steps=_rows(steps, "/steps"))


def for_each(as_: str, *steps: Step, in_: Any = None, grid: Mapping[str, Any] | None = None, index: str | None = None) -> Step:
    """One round for each element of a list, or each pose of a grid."""
    return _node("for_each", **{"as": as_, "in": in_, "grid": grid, "index": index, "steps": _rows(steps, "/steps")})


def call(program: str, *, with_: Mapping[str, Any] | None = None, as_: str | None = None) -> Step:
    """Runs a program of the scenario's programs."""
    return _node("call", **{"program": program, "with": with_, "as": as_})


def charts(charts: Mapping[str, Any], **keys: Any) -> Step:
    """Runs state charts (SCXML) that coordinate what they invoke: name to a file of the folder of the scenario."""
    return _node("charts", charts=dict(charts), **keys)


def tree(tree: Any, *, main: str | None = None, **keys: Any) -> Step:
    """Runs a behaviour tree (BehaviorTree.CPP 4) whose leaves are programs: a file of the folder of the scenario.

    `main`: the tree to run; default: main_tree_to_execute of the file, or its only one.
    """
    return _node("tree", tree=tree, main=main, **keys)


def krl(program: Any, *, arm: str | None = None, map: Mapping[str, Any] | None = None, **keys: Any) -> Step:
    """Runs a program in KRL on one arm: a file (.src) of the folder of the scenario.

    `map`: what its numbers and names are in the cell (docs/krl.md).
    """
    return _node("krl", program=program, arm=arm, map=None if map is None else dict(map), **keys)


def urscript(program: Any, *, arm: str | None = None, map: Mapping[str, Any] | None = None, **keys: Any) -> Step:
    """Runs a program in URScript on one arm: a file (.script) of the folder of the scenario.

    `map`: what its numbers and names are in the cell (docs/urscript.md).
    """
    return _node("urscript", program=program, arm=arm, map=None if map is None else dict(map), **keys)


def try_(*steps: Step, retry: int | None = None, recover: Any = None, on_error: Any = None, error_as: str | None = None,
         finally_: Any = None) -> Step:
    """After a failure tries again, after `recover`; then runs `on_error`, in which `error_as` is a text with the failure;
    `finally_` runs in any case."""
    handler = None
    if on_error is not None:
        handler = {**({"as": error_as} if error_as else {}), "steps": _rows(on_error, "/on_error/steps")}
    keys: dict[str, Any] = {"steps": _rows(steps, "/steps"), "retry": retry, "on_error": handler}
    if recover is not None:
        keys["recover"] = _rows(recover, "/recover")
    if finally_ is not None:
        keys["finally"] = _rows(finally_, "/finally")
    return _node("try", **keys)


def let(**values: Any) -> Step:
    """Assigns values to variables, one after the other."""
    return _node("let", values=values)


def log(text: str) -> Step:
    """Writes a line into the recording."""
    return _node("log", text=text)


def fail(text: str) -> Step:
    """Fails with a text."""
    return _node("fail", text=text)


def stop() -> Step:
    """Ends the program in order."""
    return _node("stop")


class Scenario:
    """A scenario as an object: a cell, out of a file or a dictionary, and a program. `scenario.data` is what a file has."""

    def __init__(self, cell: str | os.PathLike[str] | Mapping[str, Any], program: Step | None = None, *,
                 expectations: list[dict[str, Any]] | None = None, title: str | None = None,
                 programs: Mapping[str, Any] | None = None):
        self._folder: pathlib.Path | None = None
        if isinstance(cell, Mapping):
            self.data: dict[str, Any] = copy.deepcopy(plain(dict(cell), ""))
        else:
            path = pathlib.Path(find_file(cell))
            self._folder = path.resolve().parent
            self.data = _read(path)
        if program is not None:
            self.data["program"] = program.as_file()
        if programs is not None:
            self.data["programs"] = plain(programs, "/programs")
        if expectations is not None:
            self.data["expectations"] = plain(expectations, "/expectations")
        if title is not None:
            self.data["title"] = title

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it as a file. Models and nets that it names are found beside that."""
        pathlib.Path(path).write_text(self.text())

    def text(self) -> str:
        return json.dumps(self.data, indent=2) + "\n"

    def check(self, **options: Any) -> dict[str, Any]:
        """Reads, builds and rehearses it; nothing moves. Raises OpenError with all that is wrong."""
        from ._run import check
        with self._as_file() as path:
            return check(path, **options)

    def run(self, **options: Any) -> "Report":
        """As takt.run()."""
        from ._run import run
        with self._as_file() as path:
            return run(path, **options)

    @contextmanager
    def _as_file(self) -> Iterator[str]:
        """Beside the cell's file, where what it names is found."""
        folder = self._folder if self._folder is not None and os.access(self._folder, os.W_OK) else None
        with tempfile.NamedTemporaryFile("w", prefix=".takt-", suffix=".json", dir=folder) as file:
            file.write(self.text())
            file.flush()
            yield file.name


def _read(path: pathlib.Path) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text())
    except OSError as error:
        raise OpenError([Diagnostic("error", "not-found", f"the file cannot be read: {error.strerror}", "Check the path",
                                    file=str(path))]) from None
    except ValueError as error:
        raise OpenError([Diagnostic("error", "syntax", str(error), "Check it with 'takt validate'", file=str(path))]) from None
    return dict(data)
