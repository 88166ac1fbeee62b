#!/usr/bin/env python3
"""Physics and speed of scenarios, with one or more builds of takt in turn, so that a busy machine treats all alike.

    bench/cells.py [--runs N] [--set POINTER=VALUE] [--scenario FILE ...] BINARY [BINARY ...]

Run from the root of the repository, without film and recording. Of each scenario and binary: the least of N runs of
each figure, in us a cycle of 1 ms as `takt run --json` measures them (`timing`; clock reads included). "all, CPU" is
the CPU time of the whole process over its cycles, and times real time follows from it: reading, planning and building
the world count. Without the expectation that repeats the run. A Markdown table on stdout.
"""

import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys

SCENARIOS = ["touch", "pick", "carry", "screw", "factory2020"]
PARTS = ["physics", "controller", "core", "program", "digest"]


def run(binary, scenario, settings):
    """One run. Raises RuntimeError where there is no report."""
    command = [binary, "run", str(scenario), "--json"]
    for setting in settings:
        command += ["--set", setting]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        report = json.loads(done.stdout)
    except json.JSONDecodeError as error:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()[-500:]}") from error
    report["cpu"] = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return report


def figures(report):
    """us a cycle, and times real time of the loop and of the whole process."""
    cycles = report["cycles"]
    row = {part: 1e6 * report["timing"][part] / cycles for part in PARTS}
    row["all"] = 1e6 * report["wall_time"] / cycles
    row["process"] = 1e6 * report["cpu"] / cycles
    return row


def without_repeat(scenario, folder):
    """A copy beside the others without the expectation that runs everything twice."""
    cell = json.loads(scenario.read_text())
    cell["expectations"] = [e for e in cell.get("expectations", []) if "repeats" not in json.dumps(e)]
    copy = folder / f".{scenario.stem}.cells.json"
    copy.write_text(json.dumps(cell))
    return copy


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--set", action="append", default=[], dest="settings", metavar="POINTER=VALUE")
    parser.add_argument("--scenario", action="append", type=pathlib.Path)
    parser.add_argument("binary", nargs="+")
    given = parser.parse_args()
    scenarios = given.scenario or [pathlib.Path("scenarios") / f"{name}.json" for name in SCENARIOS]
    print("| scenario | takt | physics | controller | core | program | digest | all, wall | all, CPU | times real time | result |")
    print("|" + "---|" * 11)
    for scenario in scenarios:
        copy = without_repeat(scenario, scenario.parent)
        try:
            best = {binary: {} for binary in given.binary}
            result = {}
            for _ in range(given.runs):
                for binary in given.binary:
                    report = run(binary, copy, given.settings)
                    result[binary] = f"{report['result']}, {report['sim_time']:.3f} s, {report['digest'][:8]}"
                    for part, value in figures(report).items():
                        best[binary][part] = min(value, best[binary].get(part, value))
        finally:
            os.unlink(copy)
        for binary in given.binary:
            row = best[binary]
            cells = [f"{row[part]:.1f}" for part in [*PARTS, "all", "process"]]
            print(f"| {scenario.stem} | {binary} | {' | '.join(cells)} | {1e3 / row['process']:.1f} | {result[binary]} |")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
