"""A cell that a program works with (docs/python.md, "Programs at once")."""
from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Callable, Coroutine, Iterable

from . import _takt
from ._channels import CellChannel
from ._device_operations import ArmOperations, CellOperations, GripperOperations, OutputOperations, ToolChangerOperations
from ._errors import as_rows, refuse
from ._operations import specifications, written
from ._options import find_file, options_of
from ._report import Report
from ._run_handles import Activity, Run

if TYPE_CHECKING:
    import numpy as np


class Device:
    """Something of the cell that can be commanded."""

    def __init__(self, cell: "Cell", name: str):
        self._cell, self._name = cell, name

    @property
    def name(self) -> str:
        return self._name

    @property
    def interfaces(self) -> list[str]:
        """What it offers, as C++ names it."""
        return self._cell._native.interfaces(self._name)

    def __repr__(self) -> str:
        return f"<{type(self).__name__.lower()} '{self._name}'>"

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        from difflib import get_close_matches
        offered = [one for one in dir(type(self)) if not one.startswith("_")]
        near = get_close_matches(name, offered, 1)
        raise AttributeError(f"{self!r} has no '{name}'" + (f": did you mean '{near[0]}'?" if near else "") +
                             f" It has {', '.join(offered)}")


class Arm(Device, ArmOperations):
    """An arm, or a base. Joint positions are arrays in rad (m of sliding joints), poses 4x4 arrays in its base, m."""

    @property
    def q(self) -> "np.ndarray":
        """The set point of now."""
        return self._cell._native.q(self._name)

    @property
    def measured_q(self) -> "np.ndarray":
        return self._cell._native.measured_q(self._name)

    @property
    def home(self) -> "np.ndarray":
        """The posture of its model."""
        return self._cell._native.home(self._name)

    @property
    def flange(self) -> "np.ndarray":
        """Where the flange is by the set point of now."""
        return self._cell._native.flange(self._name)

    @property
    def tool(self) -> "np.ndarray":
        """Where the tool centre point is by the set point of now."""
        return self._cell._native.tool(self._name)

    @property
    def measured_tool(self) -> "np.ndarray":
        return self._cell._native.measured_tool(self._name)

    @property
    def mode(self) -> str:
        """The control mode that it is in."""
        return self._cell._native.mode(self._name)

    def frame(self, name: str) -> "np.ndarray":
        """A frame of the cell in the base."""
        return self._cell._native.frame_of(self._name, name)

    def above(self, frame: str, height: float) -> "np.ndarray":
        """A tool pose that looks down the z axis of a frame, from this height (m) above it."""
        return self._cell._native.above(self._name, frame, height)

    def by(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> dict[str, Any]:
        """A goal: so far (m) from wherever it will be, along the axes of the base."""
        return {"by_m": [float(x), float(y), float(z)], "in": self._name}

    def joint(self, index: int, q: float) -> _takt.Goal:
        """A goal: one joint (from 0) at this position, rad or m; the others rest."""
        return _takt.goal_joint(index, q, False)

    def joint_by(self, index: int, by: float) -> _takt.Goal:
        """A goal: one joint (from 0) by so much, rad or m; the others rest."""
        return _takt.goal_joint(index, by, True)

    def tcp(self, tool: str, tcp: str = "") -> "np.ndarray":
        """The pose of a tool centre point in the flange, for X_FM."""
        return self._cell._native.tcp(self._name, tool, tcp)

    def use_tool(self, tool: str = "", tcp: str = "") -> None:
        """The tool that counts from now on; without a name the one that the cell declares."""
        self._cell._native.use_tool(self._name, tool, tcp)

    def carry(self, mass_kg: float) -> None:
        """Sets the arm at rest to carry a further point mass at its tool centre point."""
        self._cell._native.carry(self._name, mass_kg)

    def put_down(self) -> None:
        self._cell._native.carry(self._name, 0.0)

    def set_speed(self, rate: float) -> None:
        """Override of its motions, 0 to 1."""
        self._cell._native.set_speed(self._name, rate)

    def pause(self) -> None:
        self._cell._native.pause(self._name)

    def resume(self) -> None:
        self._cell._native.resume(self._name)

    # Sensors.
    @property
    def tool_pose(self) -> _takt.Pose:
        """The tool centre point in the base, measured, as a sensor."""
        return self._cell._native.tool_pose(self._name)

    @property
    def commanded_tool_pose(self) -> _takt.Pose:
        return self._cell._native.commanded_tool_pose(self._name)

    @property
    def tool_twist(self) -> _takt.Twist:
        return self._cell._native.tool_twist(self._name)

    @property
    def joints(self) -> _takt.Joints:
        """Joint positions, measured, as a sensor."""
        return self._cell._native.measured_joints(self._name)

    @property
    def joint_velocities(self) -> _takt.Joints:
        return self._cell._native.measured_velocities(self._name)

    @property
    def joint_torques(self) -> _takt.Joints:
        return self._cell._native.measured_torques(self._name)


class Gripper(Device, GripperOperations):
    """A gripper."""

    @property
    def width(self) -> _takt.Real:
        """Distance of the fingers as a sensor, m."""
        return self._cell._native.gripper_width(self._name)

    def is_(self, state: str) -> _takt.State:
        """moving, holding, lost, open or closed."""
        return self._cell._native.gripper_is(state, self._name)


class ToolChanger(Device, ToolChangerOperations):
    """The robot side of a tool changer."""


class Output(Device, OutputOperations):
    """A digital or an analog output."""


class TwoArms:
    """Two arms as one actuator that moves one frame C, the common motion centre. Poses are in the world, m."""

    def __init__(self, cell: "Cell", leader: str, follower: str, X_WC: "np.ndarray"):
        self._cell, self._leader = cell, leader
        self._native = _takt.two_arms(cell._native, leader, follower, X_WC)

    def lin(self, X_WC: "np.ndarray", **parameters: Any) -> Activity:
        """C on a straight line to a pose, as an activity; parameters are those of lin."""
        text, values = self._parameters(parameters)
        return Activity(self._cell, self._native._lin(X_WC, text, values))

    def lin_by(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, **parameters: Any) -> Activity:
        """C by so far (m) from wherever it will be, along the axes of the world, as an activity."""
        text, values = self._parameters(parameters)
        return Activity(self._cell, self._native._lin_by([x, y, z], text, values))

    def _parameters(self, parameters: dict[str, Any]) -> tuple[str, _takt.Values]:
        return written(specifications()["lin"], {"arm": self._leader}, ("home",), parameters)

    @property
    def centre(self) -> "np.ndarray":
        return self._native.centre

    @property
    def centre_by_follower(self) -> "np.ndarray":
        return self._native.centre_by_follower


class Cell(CellOperations):
    """A simulated cell in this process, or with `core` that of a server. In lock-step its time stands still between two
    calls, so a run repeats to the bit. Use it in a `with` block; afterwards it has a report: passed, digest, expectations, events."""

    def __init__(self, file: str | os.PathLike[str], **options: Any):
        self._file, self._options = find_file(file), options
        self._echo = not options.pop("quiet", False)
        native, self._kept = options_of(options)
        self._native = _takt.open_cell(self._file, native)
        self._tasks: list[_Task] = []
        self._inside = False
        self._report: Report | None = None

    @property
    def _cell(self) -> "Cell":
        return self

    def __enter__(self) -> "Cell":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: Any) -> None:
        if self._report is None:
            self.finish(error)

    def finish(self, error: BaseException | None = None, run_again: Callable[[], str] | None = None) -> Report:
        """Ends the run: waits for what was begun, or cancels it if there is an error, and judges the expectations. Once;
        leaving the `with` block does it. run_again: gives the digest of a second run, for the expectation "repeats"."""
        from ._errors import Cancelled
        ended = error is None or isinstance(error, (Cancelled, KeyboardInterrupt))
        text = self._native.finish("[]" if ended else as_rows(error), run_again)  # type: ignore[arg-type]
        self._report = Report(json.loads(text), self._kept)
        return self._report

    @property
    def report(self) -> Report:
        """The verdict, after the `with` block."""
        if self._report is None:
            raise refuse("not-possible-now", "", "the run of this cell goes on", "Ask after its 'with' block")
        return self._report

    def __getattr__(self, name: str) -> Any:
        if name in ("passed", "digest", "expectations", "events", "lines"):
            return getattr(self.report, name)
        return Device.__getattr__(self, name)  # type: ignore[arg-type]

    def __repr__(self) -> str:
        return f"<cell '{self._native.title}'>" if self._report is None else f"<cell, {self._report.result}>"

    # -- Devices and frames by name; without a name the only one of its kind.
    def arm(self, name: str = "") -> Arm:
        return Arm(self, self._native.device_name("arm", name))

    def gripper(self, name: str = "") -> Gripper:
        return Gripper(self, self._native.device_name("gripper", name))

    def tool_changer(self, name: str = "") -> ToolChanger:
        return ToolChanger(self, self._native.device_name("tool_changer", name))

    def output(self, name: str = "") -> Output:
        return Output(self, self._native.device_name("output", name))

    def two_arms(self, leader: Arm, follower: Arm, X_WC: "np.ndarray") -> TwoArms:
        """Two arms as one; X_WC: where the frame is now that both move. Both rest."""
        return TwoArms(self, leader.name, follower.name, X_WC)

    def frame(self, name: str) -> _takt.Frame:
        return self._native.frame(name)

    @property
    def names(self) -> dict[str, list[str]]:
        """The names of all that it has, by kind."""
        return dict(json.loads(self._native.names()))

    # -- Sensors and states.
    def force(self, sensor: str = "") -> _takt.Real:
        """The size of the force that a force/torque sensor feels, N."""
        return self._native.force(sensor)

    def wrench(self, sensor: str = "") -> _takt.Wrench:
        return self._native.wrench(sensor)

    def pressing(self, direction: Iterable[float], sensor: str = "") -> _takt.Real:
        """With how much force the tool presses along a direction of its arm's base, N."""
        return self._native.pressing(list(direction), sensor)

    def input(self, name: str = "") -> _takt.State:
        return self._native.input(name)

    def analog_input(self, name: str = "") -> _takt.Real:
        return self._native.analog_input(name)

    def channel(self, name: str) -> CellChannel:
        """A channel, to write and to read."""
        return CellChannel(self, name)

    def distance(self, side_a: str | list[str], side_b: str | list[str]) -> _takt.Real:
        """The smallest distance of two sides, m: devices, objects and bodies ("arm/link_3")."""
        sides = [[side] if isinstance(side, str) else list(side) for side in (side_a, side_b)]
        return self._native.distance(*sides)

    def gripper_is(self, state: str, gripper: str = "") -> _takt.State:
        return self._native.gripper_is(state, gripper)

    # -- Time.
    @property
    def time(self) -> float:
        """s, simulated."""
        return self._native.time

    @property
    def cycle(self) -> int:
        return self._native.cycle

    def wait_until(self, state: _takt.State, timeout_s: float = 60.0) -> bool:
        """Until it holds. False: it did not in time."""
        return bool(self._blocked(lambda: self._native.wait_until(state, timeout_s)))

    def wait_for_all(self) -> None:
        """Until all that was begun is over. Raises OperationError for what has failed and nobody has asked about."""
        self._blocked(self._native.wait_for_all)

    def next_cycle(self) -> None:
        """Lets one cycle pass."""
        self._blocked(self._native.spend_step)

    # -- Several as one.
    def sequence(self, *parts: Activity) -> Activity:
        """One after the other in one real-time context, in the cycle after the end of the one before."""
        return Activity(self, _takt.sequence([one._native for one in parts]))

    def parallel(self, *parts: Activity) -> Activity:
        """All begin in the same cycle; over when all are."""
        return Activity(self, _takt.parallel([one._native for one in parts]))

    def conditional(self, condition: _takt.State, then: Activity, otherwise: Activity) -> Activity:
        return Activity(self, _takt.conditional(condition, then._native, otherwise._native))

    def with_subtasks(self, main: Activity, *subtasks: tuple[Activity, "float | _takt.State"]) -> Activity:
        """Each subtask begins at a share of the path of `main`, or when a state holds."""
        rows = [(one._native, at if isinstance(at, (int, float)) else None, at if isinstance(at, _takt.State) else None)
                for one, at in subtasks]
        return Activity(self, _takt.with_subtasks(main._native, rows))

    def as_activity(self, command: Any) -> Activity:
        """A command, or a transaction, of takt.command as an activity; it is planned anew each time."""
        return Activity(self, _takt.command_activity(self._native, getattr(command, "command", command)))

    # -- Coroutines.
    def run(self, *coroutines: Coroutine[Any, Any, Any]) -> list[Any]:
        """Runs coroutines beside each other to their ends. In them `await` runs, activities, cell.when(...)."""
        tasks = [_Task(one, self) for one in coroutines]

        def over() -> bool:
            if all(task.done for task in tasks):
                return True
            while any([task.poll() for task in tasks]):
                pass
            return False
        self._blocked(lambda: self._native.drive(over))
        return [task.result() for task in tasks]

    def when(self, holds: Callable[[], bool]) -> "_When":
        """In a coroutine: goes on in the first cycle in which it holds."""
        return _When(holds)

    def cycles(self, count: int) -> "_When":
        """In a coroutine: so many cycles."""
        until = self.cycle + count
        return _When(lambda: self.cycle >= until)

    # -- What people see.
    def step(self, name: str) -> None:
        """The part of the program that begins now, for the film, the recording and the expectation "step"."""
        self._native.step(name)

    def print(self, line: object) -> None:
        """A line for the user: on stdout, in the report and in the recording."""
        self._native.print(str(line))
        if self._echo:
            print(line, flush=True)

    def expect(self, name: str, passed: "bool | np.bool_", measured: object = "") -> None:
        """A statement of the program's own for the verdict."""
        self._native.expect(name, bool(passed), str(measured))

    def cancel(self) -> None:
        """Ends the program in order: whatever moves comes to rest on its path."""
        self._native.cancel()

    # -- Below.
    def _blocked(self, work: Callable[[], Any]) -> Any:
        if self._inside:
            raise refuse("not-possible-now", "", "a coroutine must not block: it would stop the loop that runs it",
                         "Use await")
        return work()

    def _blocking(self, work: Callable[..., Any], *arguments: Any) -> Any:
        return self._blocked(lambda: work(self._native, *arguments))


class _When:
    def __init__(self, holds: Callable[[], bool]):
        self._holds = holds

    def __await__(self):  # type: ignore[no-untyped-def]
        if not self._holds():
            yield self._holds


class _Task:
    """A coroutine, and what it waits for."""

    def __init__(self, coroutine: Coroutine[Any, Any, Any], cell: Cell):
        if not hasattr(coroutine, "send"):
            raise refuse("wrong-type", "", f"unexpected value {coroutine!r}", "Call an 'async def' function, and give that")
        self._coroutine, self._cell = coroutine, cell
        self._holds: Callable[[], bool] | None = None
        self._result: Any = None
        self.done = False
        self._resume()

    def poll(self) -> bool:
        """Goes on if it can. False: it waits, or is over."""
        if self.done or (self._holds is not None and not self._holds()):
            return False
        self._resume()
        return True

    def result(self) -> Any:
        return self._result

    def _resume(self) -> None:
        self._cell._inside = True
        try:
            self._holds = self._coroutine.send(None)
        except StopIteration as end:
            self.done, self._result = True, end.value
        finally:
            self._cell._inside = False


def open(file: str | os.PathLike[str], **options: Any) -> Cell:
    """Opens the cell of a scenario file; its program is not looked at. The file is searched as it is named, beside the
    program, and among the installed scenarios.

    Options: seed, set={"/pointer": value}, video, record, camera, models=[folder], realtime, cooperating=[[arm, ...]],
    quiet; core=URL, token=file: the cell is that of a `takt serve` of the same file, which then decides on seed, pictures
    and recordings. Raises OpenError with all that is wrong; nothing has moved then.
    """
    return Cell(file, **options)
