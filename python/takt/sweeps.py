"""Runs a scenario many times, and says how often it holds (docs/sweeps.md).

  takt sweep touch.json OUT --seeds 1000 [--vary /json/pointer=1,2,3] [--between /json/pointer=0.1,0.5] [--jobs 8]
  takt sweep OUT                  goes on with it, and prints the report
  takt sweep OUT --point 0042     runs that point alone, here: for other engines
  takt sweep scenarios/benchmarks --seeds 50   each scenario of a folder, held against its golden statistics
"""
from __future__ import annotations

import argparse
import json
import os
import pathlib
import subprocess
import sys
import threading
from queue import Empty, Queue
from typing import IO, Any, Iterable, Mapping, Sequence

from ._errors import Error
from ._sweep_folder import Between, Point, Sweep, SweepError, between, points_of
from ._sweep_golden import against_golden, bless, golden_file, worse
from ._sweep_report import Distribution, PairedComparison, Share, SweepReport, mcnemar, paired

__all__ = ["Between", "Distribution", "PairedComparison", "Point", "Share", "Sweep", "SweepError", "SweepReport",
           "against_golden", "between", "bless", "main", "mcnemar", "paired", "points_of", "run", "run_on", "run_points", "sweep"]

TRIES = 2  # a point that ends its process so often has crashed


class _Worker(threading.Thread):
    """A process that runs points, one after the other; a new one where it died."""

    def __init__(self, sweep: Sweep, waiting: "Queue[str]", told: "Queue[tuple[str, str]]"):
        super().__init__(daemon=True)
        self._sweep, self._waiting, self._told = sweep, waiting, told
        self._process: "subprocess.Popen[str] | None" = None
        self._stopping = False

    def run(self) -> None:
        try:
            while True:
                identity = self._waiting.get_nowait()
                self._told.put((identity, self._one(identity)))
        except Empty:
            pass
        finally:
            self.stop()

    def stop(self) -> None:
        self._stopping = True
        if self._process is not None:
            self._process.terminate()
            self._process.wait()
            self._process = None

    def _one(self, identity: str) -> str:
        code = 0
        for _ in range(TRIES):
            process = self._process
            if process is None:
                command = [sys.executable, "-m", "takt", "sweep", str(self._sweep.folder), "--worker"]
                process = self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                                           start_new_session=True)  # Ctrl-C is for the starter
            answer = self._ask(process, identity)
            if answer:
                return answer
            if self._stopping:
                return "stopped"
            code = process.wait()
            self._process = None
        point = self._sweep.point(identity)
        try:
            self._sweep.store(identity, {**point.row(), "result": "crashed", "diagnostics": [f"the process ended with {code}"]})
        except SweepError as error:
            return f"error {error}"
        return "done"

    @staticmethod
    def _ask(process: "subprocess.Popen[str]", identity: str) -> str:
        writer: IO[str] | None = process.stdin
        reader: IO[str] | None = process.stdout
        if writer is None or reader is None:
            return ""
        try:
            writer.write(identity + "\n")
            writer.flush()
            return reader.readline().strip()
        except BrokenPipeError:
            return ""


def _work(folder: str) -> int:
    """A worker: ids on standard input, an answer each on standard output."""
    sweep = Sweep(folder)
    answers = os.fdopen(os.dup(1), "w")  # whatever else prints must not be taken for an answer
    os.dup2(2, 1)
    for line in sys.stdin:
        try:
            sweep.run_point(line.strip())
            answer = "done"
        except SweepError as error:
            answer = "error " + str(error).replace("\n", " ")
        print(answer, file=answers, flush=True)
    return 0


def run(sweep: Sweep, jobs: int | None = None, progress: bool = False, unlike: bool = False) -> SweepReport:
    """Runs what has no result yet in local processes, one for each processor. May be called again after whatever."""
    sweep.check()
    missing = sweep.missing()
    waiting: "Queue[str]" = Queue()
    told: "Queue[tuple[str, str]]" = Queue()
    for identity in missing:
        waiting.put(identity)
    count = min(jobs or os.cpu_count() or 1, len(missing))
    workers = [_Worker(sweep, waiting, told) for _ in range(count)]
    for worker in workers:
        worker.start()
    try:
        for done in range(len(missing)):
            identity, answer = told.get()
            if answer.startswith("error "):
                raise SweepError(_row("file-not-writable", identity, answer[6:]))
            if progress:
                print(f"\r{done + 1} of {len(missing)}", end="", file=sys.stderr, flush=True)
    finally:
        with waiting.mutex:
            waiting.queue.clear()
        for worker in workers:
            worker.stop()
        if progress and missing:
            print(file=sys.stderr)
    return SweepReport(sweep, unlike)


def run_points(folder: str, identities: Sequence[str]) -> None:
    """Runs some points in this process, wherever it is: the folder has to be one that all machines see."""
    made = Sweep(folder)
    made.check()
    for identity in identities:
        if not made.result_file(identity).exists():
            made.run_point(identity)


def run_on(sweep: Sweep, executor: Any, chunk: int = 20, unlike: bool = False) -> SweepReport:
    """Runs what has no result yet on an engine: whatever has submit(function, arguments...) and gives futures with result(), as
    concurrent.futures, a dask.distributed.Client or an MPI pool do. chunk: points of one task."""
    sweep.check()
    missing = sweep.missing()
    chunks = [missing[begin:begin + chunk] for begin in range(0, len(missing), chunk)]
    futures = [executor.submit(run_points, str(sweep.folder.resolve()), one) for one in chunks]
    failures = []
    for future in futures:
        try:
            future.result()
        except Exception as error:  # a task that died: its points have no result, and the others go on
            failures.append(error)
    if failures and sweep.missing():
        raise SweepError(_row("system", str(sweep.folder), f"{len(failures)} of {len(chunks)} tasks failed: {failures[0]!r}"))
    return SweepReport(sweep, unlike)


def _row(code: str, pointer: str, message: str) -> Any:
    from ._errors import Diagnostic
    return [Diagnostic("error", code, message, "Remove the cause, and run the sweep again: it goes on where it was", pointer)]


def sweep(file: str | os.PathLike[str], folder: str | os.PathLike[str], *, seeds: int | Iterable[int] = 100,
          vary: Mapping[str, Any] | None = None, sampling: str = "random", jobs: int | None = None,
          progress: bool = False) -> SweepReport:
    """Runs a scenario with each seed, and with each combination of the values of `vary` ({"/json/pointer": [values]}, or
    between(low, high)). The folder is resumed where it is there."""
    return run(Sweep.create(file, folder, points_of(seeds, vary, sampling)), jobs, progress)


def _values(text: str) -> tuple[str, list[Any]]:
    pointer, equals, rest = text.partition("=")
    if not equals or not pointer.startswith("/"):
        raise argparse.ArgumentTypeError(f"'{text}' is not JSON_POINTER=VALUE,VALUE")
    try:
        return pointer, list(json.loads(f"[{rest}]"))
    except ValueError:
        return pointer, rest.split(",")


def _range(text: str) -> tuple[str, Between]:
    pointer, values = _values(text)
    if len(values) != 2:
        raise argparse.ArgumentTypeError(f"'{text}' is not JSON_POINTER=LOW,HIGH")
    return pointer, between(*values)


def _scenarios(folder: pathlib.Path) -> list[pathlib.Path]:
    """Scenario files of a folder, without goldens."""
    files = [one for one in sorted(folder.glob("*.json")) if not one.name.endswith(".golden.json")]
    if not files:
        raise SweepError(_row("not-found", str(folder), "there is neither a sweep nor a scenario in this folder"))
    return files


def _opened(given: argparse.Namespace) -> list[Sweep]:
    """The sweep of a folder, or new ones: of a scenario, or of each scenario of a folder."""
    path = pathlib.Path(given.FILE)
    if (path / "sweep.json").exists():
        return [Sweep(path)]
    points = points_of(range(given.first_seed, given.first_seed + given.seeds), dict(given.vary + given.between), given.sampling)
    if path.is_dir():
        out = pathlib.Path(given.OUT or path.resolve().name + ".sweep")
        return [Sweep.create(one, out / one.stem, points) for one in _scenarios(path)]
    return [Sweep.create(given.FILE, given.OUT or path.stem + ".sweep", points)]


def _finish(made: Sweep, report: SweepReport, given: argparse.Namespace) -> tuple[dict[str, Any], str, bool]:
    """Files, the report as JSON and as text, and whether it holds."""
    (made.folder / "table.csv").write_text(made.table(given.unlike))
    (made.folder / "report.html").write_text(report.html())
    row, text = report.as_dict(), str(report)
    if given.bless:
        text += f"\n  wrote {bless(made, given.bless)}"
    compared = [(str(golden_file(made.scenario)), against_golden(made))]
    if given.against:
        other = pathlib.Path(given.against)
        beside = other if (other / "sweep.json").exists() else other / made.folder.name
        compared.append((str(beside), paired(Sweep(beside), made)))
    held, row["against"] = report.passed.count == report.passed.of and not report.missing, []
    for name, one in compared:
        if one is None:
            continue
        held = not worse(one) and not report.missing
        row["against"].append({"first": name, "both": one.both, "only_first": one.only_a, "only_second": one.only_b,
                               "neither": one.neither, "p": one.p, "worse": worse(one)})
        text += f"\n  against {name}: {one}" + (": worse" if worse(one) else "")
    return row, text, held


def main(arguments: list[str] | None = None) -> int:
    """Exit status: 0 all passed, or it is not worse than its golden or --against; 1 it is; 2 bad input, 3 a result could not
    be stored, 130 interrupted."""
    parser = argparse.ArgumentParser(prog="takt sweep", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("FILE", help="scenario, or a folder of them; or the folder of a sweep, to go on with it")
    parser.add_argument("OUT", nargs="?", help="folder of the sweep; default: NAME.sweep")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--vary", type=_values, action="append", default=[], metavar="POINTER=A,B,C")
    parser.add_argument("--between", type=_range, action="append", default=[], metavar="POINTER=LOW,HIGH")
    parser.add_argument("--sampling", choices=("random", "latin"), default="random")
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--point", metavar="ID", action="append", help="run these points only, in this process")
    parser.add_argument("--against", metavar="FOLDER", help="another sweep on equal points, or the folder of several: McNemar's test")
    parser.add_argument("--bless", metavar="REASON", help="write golden statistics beside the scenario")
    parser.add_argument("--unlike", action="store_true", help="accept results of unlike builds and classes of CPU")
    parser.add_argument("--json", action="store_true", help="the report as JSON on stdout, of several a list")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    rows, held = [], True
    try:
        if given.worker:
            return _work(given.FILE)
        for made in _opened(given):
            if given.point:
                made.check()
                for identity in given.point:
                    made.run_point(identity)
                continue
            row, text, holds = _finish(made, run(made, given.jobs, sys.stderr.isatty(), given.unlike), given)
            rows.append(row)
            held = held and holds
            if not given.json:
                print(text)
    except KeyboardInterrupt:
        return 130
    except Error as error:
        print(error, file=sys.stderr)
        return 3 if error.code == "file-not-writable" else 2
    if given.json and rows:
        print(json.dumps(rows[0] if len(rows) == 1 else rows, indent=2))
    return 0 if held else 1
