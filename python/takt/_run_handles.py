"""Activities and their runs."""
from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generator

from . import _takt
from ._errors import Diagnostic, diagnostics_of

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Reaction:
    """What an event did to a motion, in cycles, beside what was certified for its net."""

    activity: str
    event: str
    event_cycle: int
    braking_cycle: int
    least: int
    most: int


@dataclass(frozen=True)
class Outcome:
    """How a guarded motion, or a press, ended."""

    kind: str
    pressing: str
    X_BT: "np.ndarray | None" = None
    force: "np.ndarray | None" = None

    @property
    def touched(self) -> bool:
        return self.kind == "touched"


class Run:
    """One execution of an activity. `await run` in a coroutine waits for its end."""

    __slots__ = ("_native",)

    def __init__(self, native: _takt.Run):
        self._native = native

    def __repr__(self) -> str:
        return f"<run '{self.name}': {self.state}>"

    def __await__(self) -> Generator[Any, None, "Run"]:
        native = self._native
        if not native.over:
            yield lambda: native.over
        native._require()
        return self

    @property
    def name(self) -> str:
        return self._native.name

    @property
    def state(self) -> str:
        """queued, loaded, switching, running, returning, completed, cancelled or failed."""
        return self._native.state

    @property
    def started(self) -> bool:
        return self._native.started

    @property
    def over(self) -> bool:
        return self._native.over

    @property
    def blended(self) -> bool:
        """It has taken over a motion."""
        return self._native.blended

    @property
    def first_cycle(self) -> int:
        """The core's cycle of its first evaluation; -1: not yet."""
        return self._native.first_cycle

    @property
    def last_cycle(self) -> int:
        """The core's cycle of its last evaluation; -1: not yet."""
        return self._native.last_cycle

    @property
    def preparation(self) -> tuple[float, float]:
        """CPU time of planning, and of all until it could start, s."""
        return self._native.preparation

    @property
    def outcome(self) -> Outcome:
        """How it ended, of a guarded motion or a press."""
        row = json.loads(self._native._outcome())
        if "X_BT" in row or "force" in row:
            import numpy as np
            for key in ("X_BT", "force"):
                if key in row:
                    row[key] = np.array(row[key])
        return Outcome(**row)

    @property
    def reactions(self) -> list[Reaction]:
        return [Reaction(**one) for one in json.loads(self._native._reactions())]

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """What made it fail."""
        return diagnostics_of(json.loads(self._native._diagnostics())["diagnostics"])

    def wait(self) -> "Run":
        """Returns when it has ended. Raises OperationError if it did not come to its end."""
        self._native.wait()
        return self

    def cancel(self) -> None:
        """Asks for an end in order: it brakes on its path."""
        self._native.cancel()

    def abort(self) -> None:
        """The stop reaction, now."""
        self._native.abort()


class Activity:
    """An operation that can be asked for as often as wanted. `await activity` in a coroutine carries it out."""

    __slots__ = ("_cell", "_native")

    def __init__(self, cell: Any, native: _takt.Activity):
        self._cell, self._native = cell, native

    def execute(self) -> Run:
        """Returns when it has ended. Raises OperationError if it did not come to its end."""
        return Run(self._cell._blocked(self._native.execute))

    def begin(self) -> Run:
        """Returns when it has started, in motion if what runs may be left."""
        return Run(self._cell._blocked(self._native.begin))

    def schedule(self) -> Run:
        """Returns at once; it takes its turn behind what has its devices already."""
        return Run(self._native.schedule())

    def abort_if(self, state: _takt.State) -> "Activity":
        """The same, cancelled and failed as soon as the state holds or is unknown."""
        return Activity(self._cell, _takt.abort_if(self._native, state))

    def __await__(self) -> Generator[Any, None, Run]:
        return (yield from self.schedule().__await__())
