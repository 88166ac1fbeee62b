#!/usr/bin/env python3
"""Two emulated arms in real time, filmed and recorded, beside cyclictest. On an otherwise idle machine.

  realtime.py TAKT [--seconds 600] [--processor N] [--keep FOLDER]

An LWR 4+ behind FRI and a UR5 behind RTDE, their controllers in another process (takt emulate), wave for so long. Printed: overruns, how
late the cycle's thread and the cycles were, the same of cyclictest (rt-tests) with the same priority and period at the same time, and
the core's work per arm and cycle beside that of the same program in lock-step. Exit status 1: the run did not end as it should.
"""
import argparse
import json
import math
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
ARMS = {"left": "lwr4plus", "right": "ur5"}
ON_THE_WIRE = {"left": "fri:127.0.0.1:49940", "right": "rtde:127.0.0.4"}
IN_PROCESS = {"left": "fri", "right": "rtde"}
PRIORITY = 80  # of the cycle
HISTOGRAM_US = 20000


def wave(arm):
    """Steps from wherever the arm is, and home."""
    turns = [(0.08, -25), (-0.16, 50), (0.16, -50), (-0.16, 50), (0.08, -25)]
    steps = [{"do": "ptp", "arm": arm, "to": {"by_m": [-0.05, 0, 0.2], "by_rpy_deg": [0, -60, 0]}, "speed": 0.4}]
    steps += [{"do": "ptp", "arm": arm, "to": {"by_m": [0, y, 0], "by_rpy_deg": [roll, 0, 0]}, "speed": 0.5} for y, roll in turns]
    return steps + [{"do": "ptp", "arm": arm, "to": "home", "speed": 0.4}]


def scenario(rounds):
    return {
        "title": "Two arms wave",
        "time_limit_s": 3600,
        "devices": {name: {"model": model, "at": {"in": "world", "position_m": [0, 2 * i, 0]}} for i, (name, model) in enumerate(ARMS.items())},
        "cameras": {"overview": {"at": {"in": "world", "position_m": [3.5, 1, 1.8]}, "look_at": {"in": "world", "position_m": [0, 1, 0.5]}, "fovy_deg": 50}},
        "film": {"camera": "overview"},
        "program": {"do": "parallel", "branches": [{"do": "repeat", "times": rounds, "steps": wave(arm)} for arm in ARMS]},
        "expectations": [{"name": f"{arm} inside its limits", "kind": "limits", "arm": arm} for arm in ARMS],
    }


def backends(kinds):
    return [word for name, kind in kinds.items() for word in ("--backend", f"{name}={kind}")]


def run(takt, file, *options):
    done = subprocess.run([takt, "run", file, "--json", "--log", "none", *map(str, options)], cwd=ROOT, capture_output=True, text=True)
    if not done.stdout:
        sys.exit(done.stderr)
    report = json.loads(done.stdout)
    if report["result"] != "passed":
        print(json.dumps(report["diagnostics"], indent=1), file=sys.stderr)
    return report


class Cyclictest:
    """Measures from its beginning to end()."""

    def __init__(self):
        words = ["cyclictest", "--mlockall", "--quiet", f"--priority={PRIORITY}", "--interval=1000", f"--histogram={HISTOGRAM_US}"]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def end(self):
        """-> dict of microseconds, as takt reports wake-ups; None: it may not run here."""
        self.process.send_signal(signal.SIGINT)
        out, error = self.process.communicate()
        counts = [(int(us), int(count)) for us, count in re.findall(r"^(\d+)\s+(\d+)$", out, re.MULTILINE)]
        total = sum(count for _, count in counts)
        if total == 0:
            print("cyclictest:", error.strip() or "no result", file=sys.stderr)
            return None
        beyond = int(re.search(r"^# Histogram Overflows: 0*(\d+)", out, re.MULTILINE)[1])
        worst = int(re.search(r"^# Max Latencies: 0*(\d+)", out, re.MULTILINE)[1])

        def quantile(share):
            left = share * (total + beyond)
            for us, count in counts:
                left -= count
                if left <= 0:
                    return us
            return worst

        return {"count": total + beyond, "p50": quantile(0.5), "p99": quantile(0.99), "p999": quantile(0.999), "worst": worst}


def emulators(takt, file):
    """The controllers in a process of their own, once both listen."""
    process = subprocess.Popen([takt, "emulate", file, "--realtime", *backends(ON_THE_WIRE)], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    for _ in ARMS:
        line = process.stderr.readline()
        if not line.startswith("EMULATED"):
            sys.exit(line + process.stderr.read())
    return process


def in_real_time(takt, file, folder, processor):
    controllers = emulators(takt, file)
    beside = Cyclictest()
    options = ["--processor", processor] if processor is not None else []
    try:
        report = run(takt, file, "--realtime", "--video", folder / "film.mp4", "--record", folder / "run.mcap", *options, *backends(ON_THE_WIRE))
    finally:
        latencies = beside.end()
        controllers.send_signal(signal.SIGINT)
        controllers.communicate()
    return report, latencies


def tell(report, latencies, lock_step):
    real = report["realtime"]
    print(f"{report['sim_time']:.1f} s in real time, {report['cycles']} cycles, {report['frames']} pictures filmed, all recorded but "
          f"{real['cycles_not_recorded']} cycles; scheduling {'real-time' if real['realtime_scheduling'] else 'ordinary'}, memory "
          f"{'locked' if real['locked_memory'] else 'not locked'}; {report['result']}")
    print(f"overruns: {report['timing']['overruns']}; cycles that the program saw too late: {real['cycles_unseen']}")
    print(f"{'late, us':24}{'p50':>9}{'p99':>9}{'p99.9':>9}{'worst':>9}")
    for name, times in (("wake-ups of the cycle", real["wakeups"]), ("beginnings of cycles", real["begins"])):
        print(f"{name:24}" + "".join(f"{1e-3 * times[key]:9.0f}" for key in ("p50_ns", "p99_ns", "p999_ns", "worst_ns")))
    if latencies:
        print(f"{'cyclictest':24}" + "".join(f"{latencies[key]:9.0f}" for key in ("p50", "p99", "p999", "worst")) + f"   of {latencies['count']}")
    work = [one["timing"]["core_ns_per_cycle"] / len(ARMS) / 1e3 for one in (report, lock_step)]
    print(f"core work per arm and cycle: {work[0]:.2f} us in real time, {work[1]:.2f} us in lock-step ({lock_step['sim_time']:.1f} s)")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("takt", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--processor", type=int, metavar="N", help="the cycle has this one for itself")
    parser.add_argument("--keep", type=pathlib.Path, metavar="FOLDER", help="film, recording and report stay there")
    arguments = parser.parse_args()
    if not shutil.which("cyclictest"):
        sys.exit("cyclictest is missing: apt-get install rt-tests")
    takt = arguments.takt.resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        folder = folder.resolve()
        file = folder / "two_arms.json"
        file.write_text(json.dumps(scenario(1)))
        one = run(takt, file, "--models", ROOT / "models", *backends(IN_PROCESS))
        rounds = math.ceil(arguments.seconds / one["sim_time"])
        file.write_text(json.dumps(scenario(min(rounds, 5))))
        lock_step = run(takt, file, "--models", ROOT / "models", *backends(IN_PROCESS))
        file.write_text(json.dumps(scenario(rounds)))
        report, latencies = in_real_time(takt, file, folder, arguments.processor)
        (folder / "report.json").write_text(json.dumps({"run": report, "cyclictest_us": latencies}, indent=1))
    tell(report, latencies, lock_step)
    sys.exit(report["result"] != "passed")


if __name__ == "__main__":
    main()
