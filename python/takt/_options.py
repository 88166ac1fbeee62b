"""Options of a run, and where files are."""
from __future__ import annotations

import difflib
import json
import os
import pathlib
import sys
import tempfile
from typing import Any

from . import _takt
from ._errors import refuse

OPTIONS = ("seed", "set", "video", "record", "camera", "size", "fps", "realtime", "site", "models", "cooperating",
           "measure_times", "repeat", "core", "token")


def find_file(file: str | os.PathLike[str]) -> str:
    """As it is named, beside the program, among the installed scenarios, there also without '.json'."""
    path = pathlib.Path(os.fspath(file))
    if path.exists():
        return str(path)
    main = getattr(sys.modules.get("__main__"), "__file__", None)
    places = [pathlib.Path(main).resolve().parent / path] if main else []
    return next((str(one) for one in places if one.exists()), _takt.find_scenario(str(path)))


class Kept:
    """The recording of a run: the caller's file, or one that goes when nothing refers to it any more."""

    def __init__(self, record: Any):
        self.path: str | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        if record is True:
            self._folder = tempfile.TemporaryDirectory(prefix="takt-")
            self.path = os.path.join(self._folder.name, "run.mcap")
        elif record:
            self.path = os.fspath(record)


def text_of(value: Any) -> str:
    """A value of --set."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    return value if isinstance(value, str) else json.dumps(value)


def options_of(options: dict[str, Any]) -> tuple[str, Kept]:
    """What the core takes, as JSON, and the recording."""
    for name in options:
        if name not in OPTIONS:
            near = difflib.get_close_matches(name, OPTIONS, 1)
            raise refuse("unknown-key", name, f"there is no option '{name}'",
                         (f"Did you mean '{near[0]}'? " if near else "") + "Use " + ", ".join(OPTIONS))
    row: dict[str, Any] = {key: options[key] for key in ("camera", "size", "fps", "realtime", "measure_times", "cooperating", "repeat", "core")
                           if options.get(key) is not None}
    for key in ("video", "site", "token"):
        if options.get(key) is not None:
            row[key] = os.fspath(options[key])
    if options.get("seed") is not None:
        row["seed"] = str(options["seed"])
    changes = options.get("set") or {}
    if not isinstance(changes, dict):
        raise refuse("wrong-type", "set", f"unexpected value {changes!r}", 'Give {"/json/pointer": value}')
    row["sets"] = [f"{pointer}={text_of(value)}" for pointer, value in changes.items()]
    row["models"] = [os.fspath(one) for one in options.get("models") or []]
    kept = Kept(options.get("record"))
    if kept.path:
        row["record"] = kept.path
    return json.dumps(row), kept
