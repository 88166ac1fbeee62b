"""Golden statistics: what a sweep of a scenario came to when a person last looked at it (docs/sweeps.md)."""
from __future__ import annotations

import json
import pathlib
from collections import Counter
from typing import Any

from ._sweep_folder import Sweep, _broken, _store
from ._sweep_report import PairedComparison, SweepReport

SUFFIX = ".sweep.golden.json"
SIGNIFICANT = 0.05


def golden_file(scenario: pathlib.Path) -> pathlib.Path:
    return scenario.with_name(scenario.stem + SUFFIX)


def bless(sweep: Sweep, reason: str) -> pathlib.Path:
    """Writes what the sweep came to beside its scenario. Only a whole sweep without varied values can be one."""
    report = SweepReport(sweep)
    if report.missing or any(one.set for one in sweep.points):
        raise _broken("invalid-value", str(sweep.folder), "golden statistics are those of whole sweeps over seeds alone",
                      "Run all points, without --vary and --between")
    failed = [row["seed"] for row in report.rows if row["result"] != "passed"]
    values = {one.name: {"unit": one.unit, "median": one.quantile(0.5), "greatest": one.quantile(1)} for one in report.distributions}
    path = golden_file(sweep.scenario)
    _store(path, {"reason": reason, "seeds": [one.seed for one in sweep.points], "failed": failed, "values": values})
    return path


def against_golden(sweep: Sweep) -> "PairedComparison | None":
    """The golden is the first, the sweep the second version, on the seeds that both have. None: there is no golden."""
    path = golden_file(sweep.scenario)
    if not path.exists():
        return None
    try:
        golden: dict[str, Any] = json.loads(path.read_text())
        failed = set(golden["failed"])
        first = {seed: seed not in failed for seed in golden["seeds"]}
    except (ValueError, KeyError, TypeError) as error:
        raise _broken("syntax", str(path), f"not the statistics of a sweep: {error}", "Write it anew with --bless REASON") from None
    second = {row["seed"]: row["result"] == "passed" for row in sweep.results(unlike=True) if not row["set"]}
    counts = Counter((first[seed], second[seed]) for seed in first if seed in second)
    return PairedComparison(counts[True, True], counts[True, False], counts[False, True], counts[False, False])


def worse(compared: PairedComparison) -> bool:
    """The second version is worse, and that is no chance."""
    return compared.only_a > compared.only_b and compared.p < SIGNIFICANT
