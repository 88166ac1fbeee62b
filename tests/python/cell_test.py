"""Programs at once: the twins of the course, wrong use, states, threads and forks."""
import json
import math
import os
import pathlib
import subprocess
import sys
import threading

import numpy as np
import pytest
import takt

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples/python"
CELLS = ROOT / "examples/activities/cells"


@pytest.fixture
def cell():
    with takt.open(CELLS / "gripper.json", quiet=True) as opened:
        yield opened


@pytest.mark.parametrize("program", sorted(one.stem for one in EXAMPLES.glob("[0-9]*.py")))
def test_each_program_of_the_course_holds(program):
    """The test `examples` holds the digests against those of the programs in C++."""
    done = subprocess.run([sys.executable, "-B", EXAMPLES / f"{program}.py", "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    report = json.loads(done.stdout)
    assert report["result"] == "passed" and len(report["expectations"]) >= 3


def refused(attempt):
    with pytest.raises(takt.Error) as caught:
        attempt()
    return type(caught.value).__name__, caught.value.code, caught.value.pointer


def test_wrong_use_is_told_before_anything_moves(cell):
    arm, hand = cell.arm(), cell.gripper()
    before = arm.q
    assert refused(lambda: cell.arm("amr")) == ("OperationError", "unknown-name", "")
    assert refused(lambda: arm.lin(arm.by(z=0.1), velocity=0.25)) == ("OperationError", "unknown-key", "/velocity")
    assert refused(lambda: arm.lin(arm.by(z=0.1), velocity_m_s="fast"))[1:] == ("out-of-range", "/velocity_m_s")
    assert refused(lambda: arm.lin([1, 2, 3])) == ("UsageError", "wrong-type", "/to")
    assert refused(lambda: arm.lin(np.zeros((4, 4)))) == ("UsageError", "invalid-value", "/to")
    assert refused(lambda: arm.lin(np.eye(3))) == ("UsageError", "wrong-type", "/to")
    assert refused(lambda: arm.ptp(np.array([math.nan] * 7)))[1:] == ("wrong-size", "/to")
    assert refused(lambda: arm.ptp(np.zeros(3)))[0] == "OperationError"
    assert refused(lambda: hand.grip(force_N=math.inf)) == ("UsageError", "invalid-value", "/force_N")
    assert refused(lambda: hand.grip(force_N=object()))[1:] == ("wrong-type", "/force_N")
    assert refused(lambda: arm.lin())[1] == "missing"
    assert refused(lambda: arm.lin("home", "home"))[1] == "usage"
    assert refused(lambda: arm.lin("home", to="home"))[1] == "duplicate"
    assert refused(lambda: hand.grip(until=cell.gripper_is("open")))[1:] == ("unknown-key", "/until")
    assert refused(lambda: cell.tare(sensor="wrist"))[1] in ("unknown-name", "invalid-value")
    assert (arm.q == before).all()


def test_a_method_that_is_not_there_names_the_nearest(cell):
    with pytest.raises(AttributeError, match="lin"):
        cell.arm().linn


def test_a_goal_out_of_reach(cell):
    assert refused(lambda: cell.arm().lin(cell.arm().by(y=2.0)))[1] == "unreachable"


def test_goals_come_back_to_the_bit(cell):
    arm = cell.arm()
    goal = arm.tool
    goal[:3, 3] += (0.01, 0.02, 0.03)
    arm.lin(goal)
    assert np.abs(arm.tool - goal).max() < 1e-6
    q = arm.home
    q[0] += 0.1
    arm.ptp(q)
    assert (arm.q == q).all()


def test_states_have_no_truth_value(cell):
    closed = cell.gripper_is("closed")
    for attempt in (lambda: bool(closed), lambda: closed and closed, lambda: not closed,
                    lambda: 1 < cell.gripper().width < 2):
        assert refused(attempt)[:2] == ("UsageError", "unsupported")
    assert refused(lambda: cell.gripper().width == 0.1)[:2] == ("UsageError", "unsupported")


def test_operators_mean_what_python_means(cell):
    width = cell.gripper().width
    now = width.now()
    for formula, value in ((width + 1, now + 1), (1 - width, 1 - now), (2 * width, 2 * now), (width / 2, now / 2),
                           (-width, -now), (abs(-width), now), (width * width, now * now)):
        assert formula.now() == pytest.approx(value)
    opened = cell.gripper_is("open")
    for state, value in ((width > now - 1, True), (width >= now, True), (width < now, False), (width <= now, True),
                         (~opened, not opened.now()), (opened | ~opened, True), (opened & ~opened, False),
                         (width.near(now, 1e-9), True)):
        assert state.now() is value


def test_a_guarded_motion_tells_how_it_ended(cell):
    arm = cell.arm()
    line = arm.tool[1, 3] + 0.05
    run = arm.lin(arm.by(y=0.2), velocity_m_s=0.1, until=arm.tool_pose.position[1] > line)
    assert run.outcome.touched and line < run.outcome.X_BT[1, 3] < line + 0.001
    assert line < arm.tool[1, 3] < line + 0.02
    assert run.state == "completed"


def test_a_failure_says_why(cell):
    arm = cell.arm()
    never = arm.tool_pose.position[2] > 100.0
    assert refused(lambda: arm.lin(arm.by(y=0.05), until=never))[1] == "condition-not-met"


def test_runs_are_cancelled(cell):
    arm = cell.arm()
    run = arm.lin.begin(arm.by(y=0.2), velocity_m_s=0.05)
    cell.wait(0.5)
    run.cancel()
    assert run.wait().state == "cancelled"


def test_coroutines_must_not_block(cell):
    arm = cell.arm()

    async def wrong():
        arm.lin(arm.by(y=0.05))
    assert refused(lambda: cell.run(wrong()))[:2] == ("UsageError", "not-possible-now")


def test_what_a_coroutine_raises_comes_out(cell):
    async def broken():
        await cell.cycles(3)
        raise ValueError("mine")
    with pytest.raises(ValueError, match="mine"):
        cell.run(broken())


def test_two_runs_have_equal_digests():
    def program(cell):
        arm = cell.arm()
        arm.lin(arm.by(y=0.05), speed=0.5)
    first, second = (takt.run(CELLS / "arm.json", program, record=False) for _ in range(2))
    assert first.digest == second.digest


def test_another_thread_is_refused(cell):
    caught = []

    def use():
        try:
            cell.wait(0.01)
        except takt.UsageError as error:
            caught.append(error.code)
    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert caught == ["not-possible-now"]


def test_a_child_of_a_fork_is_refused(cell):
    child = os.fork()
    if child == 0:
        try:
            cell.wait(0.01)
        except takt.UsageError:
            os._exit(7)
        os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


def test_a_cell_that_has_ended_is_refused():
    with takt.open(CELLS / "arm.json", quiet=True) as opened:
        arm = opened.arm()
        assert refused(lambda: opened.report)[1] == "not-possible-now"
    assert opened.report.result == "passed"
    assert refused(lambda: arm.q)[1] == "not-possible-now"
    assert refused(lambda: opened.wait(1))[1] == "not-possible-now"


def test_an_exception_of_the_program_is_the_verdict():
    with pytest.raises(ZeroDivisionError):
        with takt.open(CELLS / "arm.json", quiet=True) as opened:
            opened.arm().lin.begin(opened.arm().by(y=0.1))
            1 / 0
    assert opened.report.result == "error"
    assert [one.code for one in opened.report.diagnostics] == ["internal"]


def test_exceptions_can_be_pickled():
    import pickle
    with pytest.raises(takt.OpenError) as caught:
        takt.open("nothing.json")
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.code, str(again)) == (caught.value.code, str(caught.value))
