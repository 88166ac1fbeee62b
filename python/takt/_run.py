"""Runs of scenario files, with their own program or with one in Python."""
from __future__ import annotations

import argparse
import json
import os
import sys
from typing import Any, Callable

from . import _takt
from ._cell import Cell
from ._errors import Cancelled, OpenError
from ._options import find_file, options_of
from ._report import Report

Program = Callable[[Cell], None]


def run(file: str | os.PathLike[str], program: Program | None = None, *, record: Any = None, **options: Any) -> Report:
    """Runs a scenario file in this process and in lock-step: the same core, and the same digest, as `takt run`.

    program: a function of the cell in place of the file's program; it is called a second time where the file expects that
    it repeats. record: a file (MCAP), True for one that goes with the report, False for none; True if it is not given,
    but with `core`. core, token: URL of a `takt serve` of the same file that has the cell and its core, and the file with
    its token; for programs in Python. Other options: seed, set={"/json/pointer": value}, video, camera, size="1280x720",
    fps, realtime, site, models=[folder].

    Raises OpenError with all that is wrong; nothing has moved then. A first Ctrl-C cancels on the path, a second stops
    at once; both end in KeyboardInterrupt.
    """
    if record is None:
        record = options.get("core") is None
    if program is not None:
        return _run_program(file, program, {**options, "record": record})
    native, kept = options_of({**options, "record": record})
    report = Report(json.loads(_takt.run_scenario(find_file(file), native)), kept)
    if report.result == "interrupted":
        raise KeyboardInterrupt
    return report


def _run_program(file: Any, program: Program, options: dict[str, Any]) -> Report:
    cell = Cell(file, **options)

    def again() -> str:
        second = {key: value for key, value in options.items() if key not in ("record", "video")}
        other = Cell(file, **{**second, "quiet": True})
        with other:
            program(other)
        return other.report.digest

    error: BaseException | None = None
    try:
        program(cell)
    except (Exception, KeyboardInterrupt) as raised:
        error = raised
    report = cell.finish(error, again)
    if error is not None and not isinstance(error, Cancelled):
        raise error
    return report


def check(file: str | os.PathLike[str], **options: Any) -> dict[str, Any]:
    """Reads, builds and rehearses a scenario; nothing moves. Gives title, planned_duration (s), steps and warnings."""
    native, _ = options_of(options)
    return dict(json.loads(_takt.check_scenario(find_file(file), native)))


def main(file: str | os.PathLike[str], program: Program, arguments: list[str] | None = None, **options: Any) -> int:
    """The main program of a program of a cell: reads the command line, runs it, prints the verdict.

    Returns the exit status: 0 all expectations hold, 1 one does not, 2 the cell was refused and nothing moved, 3 the
    program broke off, 130 interrupted.
    """
    parser = argparse.ArgumentParser(description=program.__doc__ or "A program of a cell")
    parser.add_argument("FILE", nargs="?", default=os.fspath(file), help="scenario or cell file")
    parser.add_argument("--seed", help="in place of the file's")
    parser.add_argument("--set", action="append", default=[], metavar="JSON_POINTER=VALUE", help="several times")
    parser.add_argument("--video", metavar="OUT.mp4")
    parser.add_argument("--record", metavar="OUT.mcap")
    parser.add_argument("--camera", metavar="NAME")
    parser.add_argument("--core", metavar="URL", help="the cell is that of a takt serve, which has the same file")
    parser.add_argument("--token", metavar="FILE", help="with the server's token")
    parser.add_argument("--realtime", action="store_true", help="not faster than the wall clock")
    parser.add_argument("--json", action="store_true", help="the report as JSON on stdout")
    given = parser.parse_args(arguments)
    changes = dict(one.partition("=")[::2] for one in given.set)
    try:
        report = run(given.FILE, program, record=given.record or False, seed=given.seed, set=changes, video=given.video,
                     camera=given.camera, realtime=given.realtime, quiet=given.json, core=given.core,
                     token=given.token, **options)
    except OpenError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if given.json:
        print(json.dumps(report.report, indent=2))
    else:
        print(report)
    return {"passed": 0, "failed": 1, "interrupted": 130}.get(report.result, 3)
