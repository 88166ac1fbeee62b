"""Programs whose core is in another process: the same programs, the same digests, and what is refused."""
import json
import os
import pathlib
import subprocess
import sys

import pytest
import takt

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests/serve"))
from served import Served  # noqa: E402

TAKT = os.environ.get("TAKT_PROGRAM", str(ROOT / "build/release/tools/takt"))
EXAMPLES = ROOT / "examples/python"
ARM = ROOT / "examples/activities/cells/arm.json"


@pytest.fixture
def serve(monkeypatch):
    """Starts a server of a cell in lock-step; its URL."""
    monkeypatch.chdir(ROOT)
    running = []

    def start(file):
        running.append(Served(TAKT, "--lockstep", file=file))
        return f"http://127.0.0.1:{running[-1].port}"

    yield start
    for one in running:
        if one.process.poll() is None:
            one.end()


def carried_out(program, *options):
    done = subprocess.run([sys.executable, "-B", EXAMPLES / f"{program}.py", "--json", *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return json.loads(done.stdout)


def held(report):
    """A server cannot repeat a run."""
    return sorted((one["name"], one["passed"]) for one in report["expectations"] if one["kind"] != "repeats")


def cell_of(program):
    """The file that a program names in its last line."""
    named = (EXAMPLES / f"{program}.py").read_text().rpartition('takt.main("')[2].partition('"')[0]
    beside = EXAMPLES / named
    return beside if beside.exists() else ROOT / "scenarios" / named


@pytest.mark.parametrize("program", sorted(one.stem for one in EXAMPLES.glob("[0-9]*.py")))
def test_each_program_of_the_course_is_the_same_there(program, serve):
    local = carried_out(program)
    remote = carried_out(program, "--core", serve(cell_of(program)))
    assert held(remote) == held(local)
    assert (remote["digest"], remote["cycles"]) == (local["digest"], local["cycles"])


def test_a_cell_is_opened_and_left_twice(serve):
    url = serve(ARM)
    for _ in range(2):
        with takt.open(ARM, core=url, quiet=True) as cell:
            arm = cell.arm()
            before = arm.tool
            arm.lin(arm.by(y=0.05), velocity_m_s=0.25)
            assert abs(arm.tool[1, 3] - before[1, 3] - 0.05) < 1e-6
            arm.ptp(arm.home)


def refused(attempt):
    with pytest.raises(takt.OpenError) as caught:
        attempt()
    return [(one.code, one.pointer) for one in caught.value.diagnostics]


def test_what_the_server_decides_is_refused(serve, tmp_path):
    url = serve(ARM)
    assert refused(lambda: takt.open(ARM, core=url, seed=3, video=tmp_path / "a.mp4")) == [("conflict", "video"), ("conflict", "seed")]
    assert refused(lambda: takt.open(ROOT / "examples/activities/cells/gripper.json", core=url)) == [("incompatible", "core")]
    assert refused(lambda: takt.run(ARM, core=url)) == [("unsupported", "core")]
    assert refused(lambda: takt.open(ARM, core="nonsense")) == [("invalid-value", "core")]
    assert refused(lambda: takt.open(ARM, token=tmp_path / "token")) == [("requires", "token")]
    with takt.open(ARM, core=url, quiet=True) as cell:
        assert refused(lambda: takt.open(ARM, core=url)) == [("conflict", "core")]
        assert cell.arm().q.shape == (7,)
