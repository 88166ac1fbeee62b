"""Statistics of a sweep."""
from __future__ import annotations

import html
import math
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._sweep_folder import Sweep

Z_95 = 1.959963984540054


@dataclass(frozen=True)
class Share:
    """So many of so many, with the 95 % interval of Wilson."""

    count: int
    of: int

    @property
    def share(self) -> float:
        return self.count / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        if self.of == 0:
            return (0.0, 1.0)
        n, p, z = self.of, self.share, Z_95
        middle = p + z * z / (2 * n)
        width = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
        low, high = (middle - width) / (1 + z * z / n), (middle + width) / (1 + z * z / n)
        return (0.0 if self.count == 0 else low, 1.0 if self.count == n else high)

    def __str__(self) -> str:
        low, high = self.interval
        return f"{self.count} of {self.of}: {100 * self.share:.1f} % (95 %: {100 * low:.1f} to {100 * high:.1f} %)"


@dataclass(frozen=True)
class Distribution:
    """Of a number that an expectation measured."""

    name: str
    unit: str
    values: list[float]

    def quantile(self, share: float) -> float:
        ordered = sorted(self.values)
        place = share * (len(ordered) - 1)
        low = math.floor(place)
        return ordered[low] + (place - low) * (ordered[min(low + 1, len(ordered) - 1)] - ordered[low])

    def __str__(self) -> str:
        return f"{self.name}: {self.quantile(0):.6g} / {self.quantile(0.5):.6g} / {self.quantile(1):.6g} {self.unit}"


MOST_GROUPS = 12


def _labels(values: list[Any]) -> list[str]:
    """What each value is called in a group; many numbers are put into four stretches."""
    numbers = [one for one in values if isinstance(one, (int, float)) and not isinstance(one, bool)]
    if len(numbers) < len(values) or len(set(numbers)) <= MOST_GROUPS // 2:
        return [str(one) for one in values]
    low, high, stretches = min(numbers), max(numbers), 4
    edges = [low + (high - low) * i / stretches for i in range(stretches + 1)]
    places = [min(stretches - 1, int(stretches * (one - low) / (high - low))) for one in numbers]
    return [f"{edges[place]:.4g} to {edges[place + 1]:.4g}" for place in places]


def mcnemar(only_a: int, only_b: int) -> float:
    """The exact two-sided probability of so uneven a pair of counts where both versions are equally good."""
    n, k = only_a + only_b, min(only_a, only_b)
    if n == 0:
        return 1.0
    return min(1.0, 2.0 * sum(math.comb(n, i) for i in range(k + 1)) / 2.0 ** n)


class SweepReport:
    """What the results of a sweep say."""

    def __init__(self, sweep: "Sweep", unlike: bool = False):
        self.rows = sweep.results(unlike)
        self.title = sweep.scenario.name
        self.missing = len(sweep.points) - len(self.rows)

    @property
    def passed(self) -> Share:
        return Share(sum(row["result"] == "passed" for row in self.rows), len(self.rows))

    @property
    def expectations(self) -> dict[str, Share]:
        """How often each expectation held, of those that were judged."""
        held: Counter[str] = Counter()
        judged: Counter[str] = Counter()
        for row in self.rows:
            for one in row.get("expectations", []):
                judged[one["name"]] += one["judged"]
                held[one["name"]] += one["judged"] and one["passed"]
        return {name: Share(held[name], count) for name, count in judged.items() if count}

    @property
    def failures(self) -> list[tuple[str, list[str]]]:
        """Kinds of failures with the ids of their points, the most frequent first."""
        kinds: dict[str, list[str]] = {}
        for row in self.rows:
            if row["result"] == "passed":
                continue
            broken = [one["name"] for one in row.get("expectations", []) if one["judged"] and not one["passed"]]
            kind = ", ".join([*broken, *row.get("diagnostics", [])]) or row["result"]
            kinds.setdefault(kind, []).append(row["id"])
        return sorted(kinds.items(), key=lambda one: (-len(one[1]), one[0]))

    @property
    def distributions(self) -> list[Distribution]:
        """Least, median and greatest of every number that expectations measured."""
        found: dict[tuple[str, str], list[float]] = {}
        for row in self.rows:
            for one in row.get("expectations", []):
                if one["value"] is not None and one["judged"]:
                    found.setdefault((one["name"], one["unit"]), []).append(one["value"])
        return [Distribution(name, unit, values) for (name, unit), values in found.items()]

    def sensitivity(self) -> dict[str, dict[str, Share]]:
        """For each varied pointer: how often the runs with a value passed; of many numbers those of four equal stretches."""
        result: dict[str, dict[str, Share]] = {}
        for pointer in sorted({one for row in self.rows for one in row["set"]}):
            groups: dict[str, list[bool]] = {}
            for label, row in zip(_labels([row["set"].get(pointer) for row in self.rows]), self.rows):
                groups.setdefault(label, []).append(row["result"] == "passed")
            if len(groups) <= MOST_GROUPS:
                result[pointer] = {label: Share(sum(held), len(held)) for label, held in sorted(groups.items())}
        return result

    def as_dict(self) -> dict[str, Any]:
        low, high = self.passed.interval
        return {"title": self.title, "points": len(self.rows) + self.missing, "missing": self.missing,
                "passed": self.passed.count, "share": self.passed.share, "interval_95": [low, high],
                "expectations": {name: [one.count, one.of] for name, one in self.expectations.items()},
                "failures": [{"kind": kind, "points": ids} for kind, ids in self.failures]}

    def __str__(self) -> str:
        rows = [f"{self.title}: passed {self.passed}"]
        if self.missing:
            rows.append(f"  {self.missing} points have no result yet")
        rows += [f"  {name:<28} {one}" for name, one in self.expectations.items()]
        rows += [f"  {len(ids):>5} x {kind} (first: {ids[0]})" for kind, ids in self.failures[:20]]
        for pointer, groups in self.sensitivity().items():
            rows += [f"  {pointer} = {value:<12} {share}" for value, share in groups.items()]
        rows += [f"  least / median / greatest  {one}" for one in self.distributions]
        return "\n".join(rows)

    def html(self) -> str:
        """One page that needs nothing else."""
        return ("<!doctype html><meta charset='utf-8'><title>" + html.escape(self.title) + "</title>"
                "<style>body{font:14px sans-serif;margin:2em}td,th{padding:.2em .8em;text-align:left}</style>"
                f"<h1>{html.escape(self.title)}</h1><p>passed {html.escape(str(self.passed))}</p>"
                + _rows("Expectations", [(name, str(one)) for name, one in self.expectations.items()])
                + _rows("Failures", [(str(len(ids)), kind, ", ".join(ids[:12])) for kind, ids in self.failures])
                + _rows("Values", [(one.name, one.unit, *(f"{one.quantile(q):.6g}" for q in (0, .05, .5, .95, 1)))
                                   for one in self.distributions]))


def _rows(title: str, rows: list[tuple[str, ...]]) -> str:
    if not rows:
        return ""
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<h2>{title}</h2><table>{body}</table>"


@dataclass(frozen=True)
class PairedComparison:
    """Two sweeps on equal points."""

    both: int
    only_a: int
    only_b: int
    neither: int

    @property
    def p(self) -> float:
        """McNemar's exact test: how likely so uneven a pair of counts is where both are equally good."""
        return mcnemar(self.only_a, self.only_b)

    def __str__(self) -> str:
        if not self.both + self.only_a + self.only_b + self.neither:
            return "no seed is in both: nothing to compare"
        return (f"both pass {self.both}, only the first {self.only_a}, only the second {self.only_b}, neither {self.neither}; "
                f"p = {self.p:.3g}")


def paired(a: "Sweep", b: "Sweep") -> PairedComparison:
    """Holds the points that both have, by seed and values, against each other."""
    def held(sweep: "Sweep") -> dict[str, bool]:
        return {repr((row["seed"], sorted(row["set"].items(), key=str))): row["result"] == "passed"
                for row in sweep.results(unlike=True)}
    first, second = held(a), held(b)
    counts = Counter((first[key], second[key]) for key in first if key in second)
    return PairedComparison(counts[True, True], counts[True, False], counts[False, True], counts[False, False])
