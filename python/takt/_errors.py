"""Exceptions of takt: one tree, with the diagnostics that files get (docs/diagnostics.md)."""
from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Diagnostic:
    """One thing that is wrong: where, what, and what would be right."""

    severity: str
    code: str
    message: str
    hint: str = ""
    pointer: str = ""
    file: str = ""
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        place = self.file
        if self.line is not None:
            place += f":{self.line}:{self.column}"
        if self.pointer:
            place += f"{':' if place else ''}{self.pointer}"
        hint = f" ({self.hint})" if self.hint else ""
        return f"{place + ': ' if place else ''}{self.message}{hint} [{self.code}]"


class Error(Exception):
    """Whatever takt refuses. `diagnostics` has all that is wrong, `code` and `pointer` are those of the first error."""

    def __init__(self, diagnostics: list[Diagnostic]):
        super().__init__("\n".join(str(one) for one in diagnostics if one.severity == "error") or "no diagnostics")
        self.diagnostics = diagnostics

    @property
    def code(self) -> str:
        """The stable name of what is wrong: "unknown-name", "out-of-range"."""
        return self._first().code

    @property
    def pointer(self) -> str:
        """Where it is: a JSON pointer into the file, or the parameter of the call."""
        return self._first().pointer

    def _first(self) -> Diagnostic:
        errors = [one for one in self.diagnostics if one.severity == "error"]
        return (errors or self.diagnostics or [Diagnostic("error", "internal", "")])[0]

    def __reduce__(self):  # type: ignore[no-untyped-def]
        return type(self), (self.diagnostics,)


class OpenError(Error):
    """A file, or an option of a run, was refused; nothing has moved."""


class OperationError(Error):
    """What a program asked of a cell was refused, or did not come to its end."""


class Cancelled(Error):
    """The program was cancelled by the operator; everything has come to rest."""


class RecordingError(Error):
    """A recording cannot be read, or has no such channel."""


class UsageError(Error, TypeError):
    """A Python object of the wrong kind, or a call at the wrong time."""


_KINDS = {kind.__name__: kind for kind in (OpenError, OperationError, Cancelled, RecordingError, UsageError)}


def diagnostics_of(rows: list[dict[str, Any]]) -> list[Diagnostic]:
    return [Diagnostic(**row) for row in rows]


def _in_python(row: dict[str, Any]) -> dict[str, Any]:
    """Options have the names of the command line, without its dashes."""
    if not row.get("pointer", "").startswith("--"):
        return row
    return {key: re.sub(r"--([a-z]+)", r"\1", value) if isinstance(value, str) else value for key, value in row.items()}


def made(kind: str, text: str) -> Error:
    """The exception that the core raises."""
    return _KINDS[kind](diagnostics_of([_in_python(row) for row in json.loads(text)["diagnostics"]]))


def refuse(code: str, pointer: str, message: str, hint: str) -> UsageError:
    return UsageError([Diagnostic("error", code, message, hint, pointer)])


def as_rows(error: BaseException) -> str:
    """The same back, for the report of a run."""
    if isinstance(error, Error):
        rows = [{"code": one.code, "pointer": one.pointer, "file": one.file, "message": one.message, "hint": one.hint}
                for one in error.diagnostics if one.severity == "error"]
    else:
        rows = [{"code": "internal", "pointer": "", "message": f"the program raised {type(error).__name__}: {error}"}]
    return json.dumps(rows)
