"""Many runs of one scenario: a folder of points and results, whoever runs them (docs/sweeps.md)."""
from __future__ import annotations

import csv
import hashlib
import io
import itertools
import json
import os
import pathlib
import random
from dataclasses import dataclass
from typing import Any, Iterable, Mapping, Sequence

from . import _takt
from ._errors import Diagnostic, Error, OpenError, refuse
from ._options import find_file, text_of

FORMAT = 1
MOST_POINTS = 1_000_000


class SweepError(Error):
    """A sweep that is not what it was, or cannot be stored."""


def _broken(code: str, pointer: str, message: str, hint: str) -> SweepError:
    return SweepError([Diagnostic("error", code, message, hint, pointer)])


@dataclass(frozen=True)
class Point:
    """One run: its seed, and what is changed in the scenario."""

    id: str
    seed: int
    set: dict[str, Any]

    def row(self) -> dict[str, Any]:
        return {"id": self.id, "seed": self.seed, "set": self.set}


@dataclass(frozen=True)
class Between:
    """Values of a range, one for each seed."""

    low: float
    high: float


def between(low: float, high: float) -> Between:
    """Values of a range: as many as there are seeds, drawn at random or as a Latin hypercube."""
    if not (isinstance(low, (int, float)) and isinstance(high, (int, float)) and low < high):
        raise refuse("invalid-value", "vary", f"a range from {low!r} to {high!r}", "Give low < high")
    return Between(float(low), float(high))


def _samples(ranges: Mapping[str, Between], count: int, sampling: str, seed: int) -> list[dict[str, float]]:
    """A value of each range for each of `count` points; the same for equal arguments, on every machine."""
    columns: dict[str, list[float]] = {}
    for pointer, one in sorted(ranges.items()):
        source = random.Random(f"{seed} {pointer}")
        if sampling == "latin":
            shares = [(index + source.random()) / count for index in range(count)]
            source.shuffle(shares)
        else:
            shares = [source.random() for _ in range(count)]
        columns[pointer] = [one.low + share * (one.high - one.low) for share in shares]
    return [{pointer: values[index] for pointer, values in columns.items()} for index in range(count)]


def points_of(seeds: int | Iterable[int], vary: Mapping[str, Any] | None = None, sampling: str = "random",
              seed: int = 1) -> list[Point]:
    """Every seed with every combination of the lists; values of ranges are new for each seed."""
    if sampling not in ("random", "latin"):
        raise refuse("unknown-name", "sampling", f"there is no sampling '{sampling}'", "Use random or latin")
    numbers = list(range(1, seeds + 1)) if isinstance(seeds, int) else [int(one) for one in seeds]
    lists, ranges = {}, {}
    for pointer, values in (vary or {}).items():
        if not pointer.startswith("/"):
            raise refuse("invalid-value", "vary", f"'{pointer}' is not a JSON pointer", "Begin it with /")
        if isinstance(values, Between):
            ranges[pointer] = values
        elif isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
            raise refuse("wrong-type", "vary" + pointer, f"unexpected value {values!r}", "Give a list, or takt.between(low, high)")
        else:
            lists[pointer] = list(values)
    grid = [dict(zip(lists, values)) for values in itertools.product(*lists.values())]
    count = len(numbers) * len(grid)
    if not 0 < count <= MOST_POINTS:
        raise refuse("out-of-range", "seeds", f"{count} points", f"Give 1 to {MOST_POINTS}")
    drawn = _samples(ranges, len(numbers), sampling, seed)
    width = max(4, len(str(count - 1)))
    rows = [(number, {**values, **sample}) for values in grid for number, sample in zip(numbers, drawn)]
    return [Point(f"{index:0{width}}", number, changes) for index, (number, changes) in enumerate(rows)]


def _hash(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()


def fingerprint() -> dict[str, str]:
    """What the bits of a run depend on: build and class of CPU."""
    return dict(_takt.fingerprint())


class Sweep:
    """The folder of a sweep. Who runs a point writes results/ID.json by a rename; what has no result is to be run."""

    def __init__(self, folder: str | os.PathLike[str]):
        self.folder = pathlib.Path(folder)
        try:
            self.header = json.loads((self.folder / "sweep.json").read_text())
            if self.header["format"] != FORMAT:
                raise ValueError(f"format {self.header['format']}")
            self.points = [Point(**one) for one in self.header["points"]]
        except OSError:
            raise _broken("not-found", str(self.folder), "there is no sweep.json", "Create a sweep first") from None
        except (ValueError, KeyError, TypeError) as error:
            raise _broken("syntax", str(self.folder / "sweep.json"), f"not a sweep: {error}", "Create it anew") from None
        self._by_id = {one.id: one for one in self.points}

    @staticmethod
    def create(file: str | os.PathLike[str], folder: str | os.PathLike[str], points: Sequence[Point]) -> "Sweep":
        """A new folder; one that is there has to be of the same sweep, and goes on."""
        path = pathlib.Path(find_file(file)).resolve()
        try:
            scenario = path.read_bytes()
        except OSError as error:
            raise OpenError([Diagnostic("error", "not-found", f"the file cannot be read: {error.strerror}", "Check the path",
                                        file=str(path))]) from None
        header = {"format": FORMAT, "scenario": str(path), "scenario_sha256": _hash(scenario), "fingerprint": fingerprint(),
                  "points": [one.row() for one in points]}
        target = pathlib.Path(folder)
        if (target / "sweep.json").exists():
            there = Sweep(target)
            differs = [key for key in ("scenario_sha256", "points") if there.header[key] != json.loads(json.dumps(header))[key]]
            if differs:
                raise _broken("conflict", str(target), f"the folder has another sweep: its {' and '.join(differs)} differ",
                              "Choose another folder, or remove this one")
            return there
        (target / "results").mkdir(parents=True, exist_ok=True)
        _store(target / "sweep.json", header)
        return Sweep(target)

    @property
    def scenario(self) -> pathlib.Path:
        return pathlib.Path(self.header["scenario"])

    def point(self, identity: str) -> Point:
        return self._by_id[identity]

    def result_file(self, identity: str) -> pathlib.Path:
        return self.folder / "results" / f"{identity}.json"

    def missing(self) -> list[str]:
        """Points without a result, in order."""
        there = {one.name for one in (self.folder / "results").glob("*.json") if one.stat().st_size > 0}
        return [one.id for one in self.points if f"{one.id}.json" not in there]

    def check(self) -> None:
        """Refuses to go on with a scenario that is not the one that the sweep began with."""
        if not self.scenario.exists() or _hash(self.scenario.read_bytes()) != self.header["scenario_sha256"]:
            raise _broken("conflict", str(self.scenario), "the scenario is not the one that the sweep began with",
                          "Restore it, or begin a sweep in another folder")

    def run_point(self, identity: str) -> dict[str, Any]:
        """Runs one point here and stores what came of it; a refused scenario is a result, too."""
        point = self.point(identity)
        row: dict[str, Any] = {**point.row(), "fingerprint": fingerprint()}
        settings = {"seed": str(point.seed), "sets": [f"{key}={text_of(value)}" for key, value in point.set.items()],
                    "repeat": False}
        try:
            report = json.loads(_takt.run_scenario(str(self.scenario), json.dumps(settings)))
        except OpenError as error:
            row |= {"result": "refused", "diagnostics": [f"{one.code} {one.pointer}" for one in error.diagnostics]}
        else:
            if report["result"] == "interrupted":
                raise KeyboardInterrupt
            keys = ("result", "digest", "cycles", "sim_time", "expectations", "wall_time")
            row |= {key: report[key] for key in keys}
            row["diagnostics"] = [f"{one['code']} {one['pointer']}" for one in report["diagnostics"]
                                  if one["severity"] == "error"]
        self.store(identity, row)
        return row

    def store(self, identity: str, row: dict[str, Any]) -> None:
        _store(self.result_file(identity), row)

    def results(self, unlike: bool = False) -> list[dict[str, Any]]:
        """What is there, by id. Refuses results of unlike builds or classes of CPU, unless asked for."""
        rows = []
        for one in self.points:
            file = self.result_file(one.id)
            if file.exists() and file.stat().st_size > 0:
                rows.append(json.loads(file.read_text()))
        prints = {json.dumps(row["fingerprint"], sort_keys=True) for row in rows if "fingerprint" in row}
        if len(prints) > 1 and not unlike:
            raise _broken("incompatible", str(self.folder), f"the results come from {len(prints)} unlike builds or classes of CPU",
                          "Run them anew on one kind, or allow it (unlike=True, --unlike)")
        return rows

    def table(self, unlike: bool = False) -> str:
        """CSV: a row for each result, by id. Wall time and machine are not in it: it is equal wherever it was run."""
        rows = self.results(unlike)
        pointers = sorted({pointer for one in self.points for pointer in one.set})
        names = list(dict.fromkeys(one["name"] for row in rows for one in row.get("expectations", [])))
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["id", "seed", *pointers, "result", "digest", "cycles", *names, "diagnostics"])
        for row in rows:
            found = {one["name"]: one for one in row.get("expectations", [])}
            held = ["" if name not in found else _cell(found[name]) for name in names]
            writer.writerow([row["id"], row["seed"], *(text_of(row["set"].get(one, "")) for one in pointers), row["result"],
                             row.get("digest", ""), row.get("cycles", ""), *held, "; ".join(row.get("diagnostics", []))])
        return text.getvalue()


def _cell(expectation: dict[str, Any]) -> str:
    """Of an expectation with a number that number, else what became of it."""
    if not expectation["judged"]:
        return "open"
    value = expectation["value"]
    return ("" if expectation["passed"] else "FAIL ") + ("ok" if value is None and expectation["passed"] else
                                                          "" if value is None else repr(value))


def _store(path: pathlib.Path, row: dict[str, Any]) -> None:
    """Whole or not at all, whoever is killed; after a loss of power it may be empty, and counts as missing."""
    half = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with half.open("w") as file:
            json.dump(row, file, indent=1)
            file.write("\n")
        half.rename(path)
    except OSError as error:
        half.unlink(missing_ok=True)
        raise _broken("file-not-writable", str(path), f"the result cannot be stored: {error.strerror}",
                      "Make room, and run the sweep again: it goes on where it was") from None
