#!/usr/bin/env python3
"""Figures of the Python package (docs/benchmarks.md, "Python").

Usage: PYTHONPATH=build/release/python build/venv/bin/python3 bench/python.py [CPP_PROGRAM]
CPP_PROGRAM: 06_start_of_motion of examples/activities, for the start of a motion in C++.
"""
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
CELLS = ROOT / "examples/activities/cells"


def best(work, times=5):
    """The shortest of several, s."""
    def once():
        begin = time.perf_counter()
        work()
        return time.perf_counter() - begin
    return min(once() for _ in range(times))


def row(name, value, unit, wanted=""):
    print(f"| {name} | {value:.3g} {unit} | {wanted} |")


def imports():
    program = "import time; t = time.perf_counter(); import takt; print(time.perf_counter() - t)"
    taken = [float(subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout)
             for _ in range(7)]
    row("`import takt`", 1e3 * statistics.median(taken), "ms", "< 300 ms")


def state(takt):
    with takt.open(CELLS / "arm.json", quiet=True) as cell:
        arm, pose = cell.arm(), cell.arm().tool_pose.position[0]
        count = 5000
        for name, read, wanted in (("`cell.time`", lambda: cell.time, "< 2 us"), ("`arm.q`", lambda: arm.q, "< 2 us"),
                                   ("a formula's `now()`", pose.now, "builds and evaluates it, as in C++")):
            row(name, 1e6 * best(lambda: [read() for _ in range(count)]) / count, "us", wanted)


def start_of_motion(takt, twin):
    """CPU time from the call to a net that is ready to start, medians, and the wall time of the call before that."""
    done = subprocess.run([sys.executable, "-B", ROOT / "examples/python/06_start_of_motion.py"], capture_output=True, text=True,
                          check=True)
    print("Python:", done.stdout.split("\n")[1])
    with takt.open(CELLS / "arm.json", quiet=True) as cell:
        arm = cell.arm()
        goal = arm.by(y=0.01)
        count = 2000
        row("making an activity of `lin`", 1e6 * best(lambda: [arm.lin.activity(goal, speed=0.5) for _ in range(count)]) / count, "us")
        times = []
        for _ in range(20):
            run = arm.lin(goal)
            times.append(run.preparation[1])
            arm.lin(arm.by(y=-0.01))
        row("ready to start, LIN of one arm, CPU time", 1e3 * statistics.median(times), "ms")
    if twin:
        lines = json.loads(subprocess.run([twin, "--json"], capture_output=True, text=True, check=True).stdout)["lines"]
        print("C++:", lines[1])


def loop(takt):
    """1 000 cycles with a step of Python in each, against the same cycles in one call."""
    with takt.open(CELLS / "arm.json", quiet=True) as cell:
        arm = cell.arm()

        def stepped():
            for _ in range(1000):
                cell.next_cycle()
                arm.q
        with_python, without = best(stepped), best(lambda: cell.wait(1.0))
        row("1 000 cycles with a step of Python each", 1e3 * with_python, "ms", f"{100 * without / with_python:.0f} % of one call's rate (>= 30 %)")


def to_arrow(takt):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "run.mcap"
        with takt.open(CELLS / "arm.json", quiet=True, record=path, set={"/time_limit_s": 100}) as cell:
            cell.wait(60.0)

        def read():
            takt.open_recording(path).to_arrow()
        row("60 s of recording to Arrow, all topics", best(read, 3), "s", "< 0.5 s")


def sweep(takt):
    points = takt.sweeps.points_of(60, {"/expectations": [[]], "/program": [{"do": "wait", "seconds": 0.001}]})
    with tempfile.TemporaryDirectory() as folder:
        made = takt.sweeps.Sweep.create("wave.json", folder, points)
        settings = {"record": False, "set": points[0].set}
        alone = best(lambda: takt.run("wave.json", seed=1, **settings), 30)
        stored = best(lambda: made.run_point("0000"), 30)
        row("a point of a sweep beyond its run", 1e3 * (stored - alone), "ms", "< 5 ms")
        begin = time.perf_counter()
        takt.sweeps.run(made, jobs=1)
        row("a sweep of short runs, each, start of the worker included", 1e3 * (time.perf_counter() - begin) / len(points), "ms")


if __name__ == "__main__":
    imports()
    import takt
    state(takt)
    start_of_motion(takt, sys.argv[1] if len(sys.argv) > 1 else None)
    loop(takt)
    to_arrow(takt)
    sweep(takt)
