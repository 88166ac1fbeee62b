#!/usr/bin/env python3
"""Measures what evidence costs, from outside, with the built program. On an otherwise idle machine.

  evidence.py TAKT cost [--runs 5] [--scenario FILE]     what recording everything at 1 kHz adds to a run, in pairs of runs
  evidence.py TAKT compare [--seconds 60]                comparing two recordings of so many seconds; size of the report
  evidence.py TAKT kills [--count 1000] [--jobs 4]       runs that are killed at random times, so many beside each other: what an
                                                         official reader gets back

"kills" needs the mcap package: --python build/venv/bin/python, which ./takt test makes. Exit status 1: a target is missed.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import random
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
COST, COMPARE_S, REPORT_BYTES, LOSS_S = 0.05, 2.0, 1 << 20, 0.1  # the targets

# Reads the files that it is given and prints for each the newest time in it, ns, and whether the reader refuses it.
READER = """
import sys
from mcap.stream_reader import StreamReader
from mcap.exceptions import EndOfFile
for path in sys.argv[1:]:
    last, damaged = 0, 0
    with open(path, "rb") as file:
        try:
            for record in StreamReader(file, validate_crcs=True).records:
                last = max(last, getattr(record, "message_end_time", 0), getattr(record, "log_time", 0))
        except EndOfFile:
            pass
        except Exception as error:
            damaged = 1
            print(path, type(error).__name__, error, file=sys.stderr)
    print(last, damaged)
"""


def run(takt, *arguments):
    begin = time.monotonic()
    done = subprocess.run([takt, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True)
    return time.monotonic() - begin, done


class Cost:
    """One run: wall time of the run, share of its loop that hands over rows, processor time of the process with all threads."""

    def __init__(self, takt, scenario, *options):
        with tempfile.TemporaryFile() as out:
            process = subprocess.Popen([takt, "run", scenario, "--log", "none", "--set", "/expectations=[]", "--json", *map(str, options)],
                                       cwd=ROOT, stdout=out, stderr=subprocess.DEVNULL)
            _, _, usage = os.wait4(process.pid, 0)
            out.seek(0)
            report = json.loads(out.read())
        self.wall, self.loop, self.sim = report["wall_time"], report["timing"]["recording"] / report["wall_time"], report["sim_time"]
        self.cpu = usage.ru_utime + usage.ru_stime


def cost(takt, arguments, folder):
    pairs = []
    for i in range(arguments.runs):  # in turn, each first once in two, so that both meet the same machine
        runs = [lambda: Cost(takt, arguments.scenario), lambda: Cost(takt, arguments.scenario, "--record", folder / "a.mcap")]
        first, second = (runs if i % 2 == 0 else runs[::-1])
        one, other = first(), second()
        pairs.append((one, other) if i % 2 == 0 else (other, one))
    wall = statistics.median(b.wall / a.wall - 1 for a, b in pairs)
    cpu = statistics.median(b.cpu - a.cpu for a, b in pairs)
    sim = pairs[0][1].sim
    print(f"{arguments.scenario}: {sim:.1f} s simulated, {arguments.runs} pairs of runs, medians: wall time {pairs[0][0].wall:.3f} s and "
          f"{100 * wall:+.1f} %; the loop's own share {100 * statistics.median(b.loop for _, b in pairs):.1f} %; processor time {cpu:+.3f} s of "
          f"{statistics.median(a.cpu for a, _ in pairs):.3f} s, {1e3 * cpu / sim:.1f} ms per recorded second; "
          f"{(folder / 'a.mcap').stat().st_size / 1e6 / sim:.2f} MB per recorded second")
    return wall < COST


def compare(takt, arguments, folder):
    scenario = json.loads((ROOT / "scenarios/wave.json").read_text())
    scenario["expectations"] = []
    scenario["program"] = {"do": "sequence", "steps": [{"do": "repeat", "times": 1000, "steps": scenario["program"]["steps"]}]}
    scenario["time_limit_s"] = arguments.seconds
    file = folder / "long.json"
    file.write_text(json.dumps(scenario))
    for name, seed in (("a", 1), ("b", 2)):
        run(takt, "run", file, "--log", "none", "--record", folder / f"{name}.mcap", "--seed", seed, "--models", ROOT / "models")
    took, done = run(takt, "compare", folder / "a.mcap", folder / "b.mcap", "--quick", "--report", folder / "r.html", "--json")
    result = json.loads(done.stdout)
    size = (folder / "r.html").stat().st_size
    print(f"two recordings of {result['end_a_s']:.1f} and {result['end_b_s']:.1f} s, {len(result['columns'])} columns: {took:.2f} s, "
          f"report of {size / 1e6:.2f} MB")
    return took < COMPARE_S and size < REPORT_BYTES


def kill_one(takt, scenario, record, after_s):
    """The newest time that a run told before it was killed, s, or None if it had not told any."""
    process = subprocess.Popen([takt, "run", scenario, "--realtime", "--record", record, "--models", ROOT / "models"], cwd=ROOT,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    process.stderr.readline()  # it runs
    time.sleep(after_s)
    os.kill(process.pid, signal.SIGKILL)
    told = re.findall(r"^ *([\d.]+) s  (?:info: )?program log", process.stderr.read(), re.MULTILINE)
    process.wait()
    return float(told[-1]) if told else None


def kills(takt, arguments, folder):
    scenario = {"devices": {"arm": {"model": "lwr4plus"}}, "time_limit_s": 600,
                "program": {"do": "repeat", "times": 9000, "steps": [{"do": "wait", "seconds": 0.01}, {"do": "log", "text": "."}]}}
    file = folder / "ticks.json"
    file.write_text(json.dumps(scenario))
    chance = random.Random(arguments.seed)
    delays = [chance.uniform(0.05, 1.5) for _ in range(arguments.count)]
    losses, damaged = [], 0
    for begin in range(0, arguments.count, 50):  # their files are read together
        batch = range(begin, min(begin + 50, arguments.count))
        records = [folder / f"killed{i}.mcap" for i in batch]
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            told = list(pool.map(lambda i, record: kill_one(takt, file, record, delays[i]), batch, records))
        runs = [(last, record) for last, record in zip(told, records) if last is not None]
        read = subprocess.run([arguments.python, "-c", READER, *(record for _, record in runs)], stdout=subprocess.PIPE, text=True, check=True)
        for (last_told, _), line in zip(runs, read.stdout.splitlines(), strict=True):
            last, refused = map(int, line.split())
            damaged += refused
            losses.append(last_told - last / 1e9)
        for record in records:
            record.unlink(missing_ok=True)
        print(f"  {batch[-1] + 1}: worst loss {1e3 * max(losses):.0f} ms", file=sys.stderr)
    print(f"{len(losses)} kills ({arguments.count - len(losses)} more before the first line): {damaged} files that the official reader refuses, "
          f"loss of {1e3 * statistics.median(losses):.0f} ms in the middle and {1e3 * max(losses):.0f} ms at most")
    return damaged == 0 and max(losses) <= LOSS_S


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("takt")
    parser.add_argument("what", choices=["cost", "compare", "kills"])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--scenario", default="scenarios/touch.json")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--count", type=int, default=int(os.environ.get("TAKT_KILLS", 1000)))
    parser.add_argument("--jobs", type=int, default=4, help="runs at a time: in real time they need little of a processor")
    parser.add_argument("--seed", type=int, default=1, help="of the times of the kills")
    parser.add_argument("--python", default=str(ROOT / "build/venv/bin/python"))
    arguments = parser.parse_args()
    takt = str(pathlib.Path(arguments.takt).resolve())
    with tempfile.TemporaryDirectory() as folder:
        held = {"cost": cost, "compare": compare, "kills": kills}[arguments.what](takt, arguments, pathlib.Path(folder))
    sys.exit(0 if held else 1)


main()
