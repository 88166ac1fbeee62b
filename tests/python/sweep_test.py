"""Sweeps: points, results that any engine writes, resuming, crashes, statistics."""
import json
import os
import pathlib
import subprocess
import sys
import textwrap

import pytest
import takt
from takt import sweeps

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHORT = {"/expectations": [[]], "/program": [{"do": "lin", "to": {"by_m": [0, 0.02, 0]}}]}


def start(*arguments, patch="", tmp_path=None):
    """The command line; `patch` is Python that each process runs before anything else."""
    environment = dict(os.environ)
    if patch:
        (tmp_path / "sitecustomize.py").write_text(textwrap.dedent(patch))
        environment["PYTHONPATH"] = f"{tmp_path}:{environment['PYTHONPATH']}"
    return subprocess.run([sys.executable, "-B", "-m", "takt", "sweep", *map(str, arguments)], capture_output=True, text=True,
                          env=environment, timeout=120)


def created(folder, seeds=4):
    return sweeps.Sweep.create("wave.json", folder, sweeps.points_of(seeds, SHORT))


def test_points_are_every_seed_with_every_combination():
    points = sweeps.points_of([5, 7], {"/a": [1, 2], "/b": ["x"]})
    assert [(one.id, one.seed, one.set["/a"]) for one in points] == [("0000", 5, 1), ("0001", 7, 1), ("0002", 5, 2), ("0003", 7, 2)]


def test_ranges_are_sampled_alike_everywhere():
    latin = sweeps.points_of(10, {"/a": sweeps.between(0, 1), "/b": sweeps.between(5, 6)}, "latin")
    assert sorted(int(10 * one.set["/a"]) for one in latin) == list(range(10))
    assert latin == sweeps.points_of(10, {"/b": sweeps.between(5, 6), "/a": sweeps.between(0, 1)}, "latin")
    drawn = sweeps.points_of(3, {"/a": sweeps.between(0, 1)})
    assert [one.set for one in drawn] == [one.set for one in sweeps.points_of(5, {"/a": sweeps.between(0, 1)})[:3]]


@pytest.mark.parametrize("arguments", [(0,), (3, {"a": [1]}), (3, {"/a": "text"}), (3, {"/a": 5}), (3, {}, "sobol"), (3, {"/a": []})])
def test_wrong_points_are_refused(arguments):
    with pytest.raises(takt.UsageError):
        sweeps.points_of(*arguments)


def test_wilson_and_mcnemar():
    assert sweeps.Share(0, 10).interval == pytest.approx((0.0, 0.2775), abs=1e-4)
    assert sweeps.Share(5, 10).interval == pytest.approx((0.2366, 0.7634), abs=1e-4)
    assert sweeps.Share(10, 10).interval == pytest.approx((0.7225, 1.0), abs=1e-4)
    assert sweeps.mcnemar(1, 9) == pytest.approx(0.021484375)
    assert sweeps.mcnemar(0, 0) == 1.0 and sweeps.mcnemar(5, 5) == 1.0


def test_a_sweep_and_the_same_point_by_point(tmp_path):
    report = sweeps.run(created(tmp_path / "a"), jobs=2)
    assert (report.passed.count, report.passed.of, report.missing) == (4, 4, 0)
    alone = created(tmp_path / "b")
    for identity in reversed(alone.missing()):
        assert start(tmp_path / "b", "--point", identity).returncode == 0
    assert alone.table() == sweeps.Sweep(tmp_path / "a").table()
    row = alone.results()[2]
    run = takt.run("wave.json", seed=row["seed"], set=row["set"], record=False)
    assert run.digest == row["digest"]


def test_any_executor_runs_a_sweep(tmp_path):
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context
    made, other = created(tmp_path / "a"), created(tmp_path / "b")
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        report = sweeps.run_on(made, pool, chunk=3)
    assert report.passed.count == 4 and report.missing == 0
    sweeps.run(other, jobs=1)
    assert made.table() == other.table()


def test_what_is_there_is_not_run_again(tmp_path):
    made = created(tmp_path / "a")
    sweeps.run(made, jobs=1)
    before = {one.name: one.stat().st_mtime_ns for one in (tmp_path / "a/results").iterdir()}
    made.result_file("0002").write_text("")  # as after a loss of power
    done = start(tmp_path / "a", "--json")
    assert (done.returncode, json.loads(done.stdout)["passed"]) == (0, 4), done.stderr
    after = {one.name: one.stat().st_mtime_ns for one in (tmp_path / "a/results").iterdir()}
    assert {name for name in before if before[name] != after[name]} == {"0002.json"}
    assert (tmp_path / "a/table.csv").read_text() == made.table()
    assert "Wilson" not in (tmp_path / "a/report.html").read_text() and "<h1>" in (tmp_path / "a/report.html").read_text()


def test_another_sweep_in_the_folder_is_refused(tmp_path):
    created(tmp_path / "a")
    with pytest.raises(sweeps.SweepError) as refused:
        created(tmp_path / "a", seeds=5)
    assert refused.value.code == "conflict"
    scenario = tmp_path / "own.json"
    takt.Scenario("wave.json").save(scenario)
    made = sweeps.Sweep.create(scenario, tmp_path / "b", sweeps.points_of(1))
    scenario.write_text(scenario.read_text() + "\n")
    with pytest.raises(sweeps.SweepError) as refused:
        sweeps.run(made)
    assert refused.value.code == "conflict"
    assert start(tmp_path / "nothing").returncode == 2


def test_refused_values_are_a_row(tmp_path):
    points = sweeps.points_of(1, {**SHORT, "/devices/arm/model": ["lwr4plus", "lwr4"]})
    report = sweeps.run(sweeps.Sweep.create("wave.json", tmp_path / "a", points), jobs=1)
    assert [row["result"] for row in report.rows] == ["passed", "refused"]
    assert report.failures == [("unknown-name /devices/arm/model", ["0001"])]
    assert report.sensitivity()["/devices/arm/model"]["lwr4"].count == 0


def test_many_numbers_are_put_into_stretches(tmp_path):
    made = sweeps.Sweep.create("wave.json", tmp_path / "a", sweeps.points_of(9, {"/a": sweeps.between(0, 1)}, "latin"))
    for identity in made.missing():
        point = made.point(identity)
        made.store(identity, {**point.row(), "result": "passed" if point.set["/a"] < 0.5 else "failed", "expectations": []})
    groups = list(sweeps.SweepReport(made).sensitivity()["/a"].values())
    assert len(groups) == 4 and sum(one.of for one in groups) == 9
    assert groups[0].share == 1.0 and groups[3].share == 0.0


def test_a_point_that_ends_its_process_is_a_row(tmp_path):
    created(tmp_path / "a")
    done = start(tmp_path / "a", "--jobs", 1, "--json", tmp_path=tmp_path, patch="""
        import os, signal, sys
        if "--worker" in sys.orig_argv:
            import takt._sweep_folder
            run = takt._sweep_folder.Sweep.run_point
            def die(self, identity):
                if identity == "0001":
                    os.kill(os.getpid(), signal.SIGKILL)
                return run(self, identity)
            takt._sweep_folder.Sweep.run_point = die
        """)
    assert done.returncode == 1, done.stderr
    report = json.loads(done.stdout)
    assert (report["passed"], report["missing"], report["failures"][0]["points"]) == (3, 0, ["0001"])


def test_a_full_disk_ends_with_the_point_and_goes_on_later(tmp_path):
    made = created(tmp_path / "a", seeds=2)
    done = start(tmp_path / "a", "--jobs", 1, tmp_path=tmp_path, patch="""
        import resource, sys
        if "--worker" in sys.orig_argv:
            resource.setrlimit(resource.RLIMIT_FSIZE, (50, 50))
        """)
    assert (done.returncode, made.missing()) == (3, ["0000", "0001"]), done.stderr
    assert list((tmp_path / "a/results").iterdir()) == []
    assert start(tmp_path / "a").returncode == 0


def test_a_killed_starter_leaves_whole_results(tmp_path):
    made = created(tmp_path / "a", seeds=40)
    running = subprocess.Popen([sys.executable, "-B", "-m", "takt", "sweep", tmp_path / "a", "--jobs", "2"])
    while len(made.missing()) > 36:
        assert running.poll() is None
    running.kill()
    running.wait()
    done = start(tmp_path / "a", "--json")
    assert json.loads(done.stdout)["passed"] == 40
    assert all(json.loads(one.read_text())["result"] == "passed" for one in (tmp_path / "a/results").glob("*.json"))


def test_unlike_results_are_refused(tmp_path):
    made = created(tmp_path / "a", seeds=2)
    sweeps.run(made, jobs=1)
    row = json.loads(made.result_file("0000").read_text())
    row["fingerprint"]["compiler"] = "another"
    made.store("0000", row)
    with pytest.raises(sweeps.SweepError) as refused:
        made.results()
    assert refused.value.code == "incompatible"
    assert start(tmp_path / "a").returncode == 2
    assert start(tmp_path / "a", "--unlike").returncode == 0


def test_two_versions_on_equal_points(tmp_path):
    good, bad = created(tmp_path / "a"), created(tmp_path / "b")
    for made in (good, bad):
        sweeps.run(made, jobs=1)
    for identity in ("0000", "0003"):
        bad.store(identity, {**json.loads(bad.result_file(identity).read_text()), "result": "failed"})
    compared = sweeps.paired(good, bad)
    assert (compared.both, compared.only_a, compared.only_b, compared.neither) == (2, 2, 0, 0)
    assert compared.p == 0.5


def test_folders_goldens_and_two_versions(tmp_path):
    """Each scenario of a folder is a sweep; golden statistics are beside it, and another sweep may be held against it."""
    bench = tmp_path / "bench"
    bench.mkdir()
    text = json.loads((ROOT / "scenarios/wave.json").read_text())
    text |= {"expectations": [], "program": SHORT["/program"][0]}
    for name in ("a", "b"):
        (bench / f"{name}.json").write_text(json.dumps(text))
    first = start(bench, tmp_path / "one", "--seeds", 3, "--jobs", 1, "--json")
    assert first.returncode == 0, first.stderr
    assert [row["points"] for row in json.loads(first.stdout)] == [3, 3]
    again = start(bench, tmp_path / "two", "--seeds", 3, "--jobs", 1, "--json", "--against", tmp_path / "one")
    assert [row["against"][0]["both"] for row in json.loads(again.stdout)] == [3, 3]


def test_golden_statistics(tmp_path):
    scenario = tmp_path / "w.json"
    scenario.write_text((ROOT / "scenarios/wave.json").read_text())
    made = sweeps.Sweep.create(scenario, tmp_path / "a", sweeps.points_of(8))
    for point in made.points:
        made.store(point.id, {**point.row(), "result": "passed", "fingerprint": {}, "expectations": []})
    assert sweeps.against_golden(made) is None
    assert sweeps.bless(made, "looked at").name == "w.sweep.golden.json"
    same = sweeps.against_golden(made)
    assert same is not None and (same.both, same.p) == (8, 1.0)
    for point in made.points[:7]:
        made.store(point.id, {**point.row(), "result": "failed", "fingerprint": {}, "expectations": []})
    now = sweeps.against_golden(made)
    assert now is not None and (now.both, now.only_a, now.only_b) == (1, 7, 0) and now.p == pytest.approx(2 / 128)
    assert start(tmp_path / "a").returncode == 1, "worse than its golden, and no chance"
    (tmp_path / "w.sweep.golden.json").write_text("{}")
    with pytest.raises(sweeps.SweepError) as refused:
        sweeps.against_golden(made)
    assert refused.value.code == "syntax"
    varied = sweeps.Sweep.create(scenario, tmp_path / "b", sweeps.points_of(1, {"/seed": [1]}))
    with pytest.raises(sweeps.SweepError):
        sweeps.bless(varied, "no golden of varied values")


def test_the_verb_hands_over(tmp_path):
    program = os.environ["TAKT_PROGRAM"]
    created(tmp_path / "a", seeds=2)
    environment = {**os.environ, "TAKT_PYTHON": sys.executable}
    done = subprocess.run([program, "sweep", tmp_path / "a", "--jobs", "1", "--json"], env=environment, capture_output=True, text=True)
    assert (done.returncode, json.loads(done.stdout)["passed"]) == (0, 2), done.stderr
    bare = subprocess.run([program, "sweep", tmp_path / "a", "--json"], env={**environment, "TAKT_PYTHON": "false"}, capture_output=True,
                          text=True)
    assert (bare.returncode, json.loads(bare.stdout)["diagnostics"][0]["code"]) == (2, "requires")
