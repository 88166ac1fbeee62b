"""A cell as an environment of Gymnasium (docs/python.md, "Learning and search"); needs takt[gym]."""
from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Callable, Sequence

import gymnasium
import numpy as np

from . import _cell
from ._cell import Arm, Cell
from ._errors import Error, refuse
from ._options import find_file

STICK, ENABLE = "gym action", "gym enable"
ACTS = ("twist", "cartesian_offset")
# Bounds of what may be observed: far beyond what any cell has, so that nothing is cut off.
_FAR, _FAST, _STRONG = 100.0, 1000.0, 1e5

Observation = np.ndarray
Reward = Callable[[Cell, Observation], float]


class TaktEnv(gymnasium.Env[Observation, np.ndarray]):
    """One arm of a scenario's cell, driven at its tool. Use make()."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, file: str | os.PathLike[str], *, arm: str, observe: Sequence[str], act: str, cycles: int,
                 seconds: float, scale: tuple[float, float], frame: str, start: Callable[[Cell], None] | None,
                 reward: Reward | None, success: Callable[[Cell, Observation], bool] | None, **options: Any):
        if act not in ACTS:
            raise refuse("unknown-name", "act", f"there is no '{act}'", "Use " + " or ".join(ACTS))
        if cycles < 1 or seconds <= 0 or min(scale) <= 0:
            raise refuse("out-of-range", "cycles", "cycles, seconds and scale are above 0", "Give positive numbers")
        self._file, self._options = find_file(file), options
        self._arm_name, self._observe, self._frame = arm, list(observe), frame
        self._cycles, self._seconds = cycles, seconds
        self._start, self._reward, self._success = start, reward, success
        self._cell: Cell | None = None
        self._seed: int | None = None
        self._open()
        assert self._cell is not None
        step_s = cycles * self._period
        most = np.repeat(np.asarray(scale, dtype=float), 3)
        self._factor: np.ndarray = most if act == "twist" else most / step_s
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (6,), np.float32)
        low, high = (np.concatenate([bound for _, _, bound in self._parts]) * sign for sign in (-1, 1))
        self.observation_space = gymnasium.spaces.Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32)
        self._close()

    # -- What Gymnasium asks for.
    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self._close()
        # Without a seed of the caller each episode draws its own, from that of the last reset that had one.
        self._seed = int(self.np_random.integers(1, 2**31)) if seed is None else seed
        self._open()
        cell = self.cell
        if self._start is not None:
            self._start(cell)
        self._end = cell.time + self._seconds
        cell.channel(STICK).write(np.zeros(6))
        cell.channel(ENABLE).write(True)
        cell.next_cycle()
        enabled: Any = cell.channel(ENABLE).sensor
        self._run = self._arm.jog.begin(channel=STICK, while_=enabled, until=~enabled, in_=self._frame)
        return self._look(), {"seed": self._seed, "time_s": cell.time}

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        cell = self.cell
        twist = np.clip(np.asarray(action, dtype=float), -1.0, 1.0) * self._factor
        cell.channel(STICK).write(twist)
        info: dict[str, Any] = {}
        failed = False
        try:
            cell._native.wait_seconds(self._cycles * self._period)
            failed = self._run.over
            if failed:
                self._run.wait()
        except Error as error:
            failed, info["failed"] = True, str(error)
        seen = self._look()
        value = float(self._reward(cell, seen)) if self._reward is not None else 0.0
        reached = self._success is not None and bool(self._success(cell, seen))
        info["time_s"] = cell.time
        over, late = failed or reached, cell.time >= self._end - 1e-9
        if over or late:
            info["success"] = reached and not failed
            self._close()
            info["digest"] = self._digest
        return seen, value, over, late and not over, info

    def close(self) -> None:
        self._close()

    # -- Beside it.
    @property
    def cell(self) -> Cell:
        """The cell of this episode."""
        if self._cell is None:
            raise refuse("not-possible-now", "", "the episode is over", "Call reset()")
        return self._cell

    @property
    def layout(self) -> dict[str, slice]:
        """Where each part of an observation stands."""
        places, begin = {}, 0
        for name, _, bound in self._parts:
            places[name] = slice(begin, begin + len(bound))
            begin += len(bound)
        return places

    def _open(self) -> None:
        has_channels = "channels" in json.loads(pathlib.Path(self._file).read_text())
        own = {STICK: {"type": "Twist", "unit": "m/s,rad/s", "timeout_s": 1.0}, ENABLE: {"type": "Boolean", "initial": False}}
        channels = {f"/channels/{name}": one for name, one in own.items()} if has_channels else {"/channels": own}
        changes = {"/expectations": [], "/operator": [], **channels, **(self._options.get("set") or {})}
        given = {**self._options, "set": changes, "quiet": True}
        if self._seed is not None:
            given["seed"] = self._seed
        self._cell = _cell.open(self._file, **given)
        self._arm: Arm = self._cell.arm(self._arm_name)
        begin, cycle = self._cell.time, self._cell.cycle
        self._cell.next_cycle()
        self._period = (self._cell.time - begin) / (self._cell.cycle - cycle)
        self._parts = [(name, *self._part(name)) for name in self._observe]

    def _close(self) -> None:
        if self._cell is None:
            return
        cell, self._cell = self._cell, None
        cell.channel(ENABLE).write(False)
        try:
            self._digest = cell.finish().digest
        except Error:
            self._digest = ""

    def _look(self) -> Observation:
        low, high = self.observation_space.low, self.observation_space.high  # type: ignore[attr-defined]
        seen = np.concatenate([read() for _, read, _ in self._parts])
        return np.asarray(np.clip(seen, low, high), dtype=np.float32)

    def _part(self, name: str) -> tuple[Callable[[], np.ndarray], np.ndarray]:
        """What is read, and the largest size of each number."""
        cell, arm = self._cell, self._arm
        assert cell is not None
        kind, _, of = name.partition(":")

        def sensed(sensor: Any, size: int) -> Callable[[], np.ndarray]:
            def read() -> np.ndarray:
                value = sensor.now()
                return np.zeros(size) if value is None else np.atleast_1d(value)
            return read

        if kind == "q":
            return (lambda: arm.measured_q), np.full(len(arm.q), _FAR)
        if kind == "dq":
            return sensed(arm.joint_velocities, len(arm.q)), np.full(len(arm.q), _FAST)
        if kind == "tool":
            bound = np.concatenate([np.full(3, _FAR), np.ones(9)])
            return (lambda: np.concatenate([arm.measured_tool[:3, 3], arm.measured_tool[:3, :3].ravel()])), bound
        if kind == "force":
            return sensed(cell.wrench(of).force, 3), np.full(3, _STRONG)
        if kind == "torque":
            return sensed(cell.wrench(of).torque, 3), np.full(3, _STRONG)
        if kind == "width":
            return sensed(cell.gripper(of).width, 1), np.full(1, _FAR)
        if kind == "channel":
            channel = cell.channel(of)
            if channel.type != "Real":
                raise refuse("unsupported", "observe", f"'{of}' carries a {channel.type}", "Observe a Real channel")
            return sensed(channel.sensor, 1), np.full(1, _FAST)
        raise refuse("unknown-name", "observe", f"there is no '{name}'",
                     'Use "q", "dq", "tool", "force:SENSOR", "torque:SENSOR", "width:GRIPPER" or "channel:NAME"')


def make(file: str | os.PathLike[str], *, arm: str = "", observe: Sequence[str] = ("tool",), act: str = "cartesian_offset",
         cycles: int = 20, seconds: float = 10.0, scale: tuple[float, float] | None = None, frame: str = "world",
         start: Callable[[Cell], None] | None = None, reward: Reward | None = None,
         success: Callable[[Cell, Observation], bool] | None = None, **options: Any) -> TaktEnv:
    """An environment: the cell of a scenario, one arm of which is driven at its tool, by a net with the arm's limits.

    observe: "q", "dq" (rad, rad/s, measured), "tool" (position, m, and rotation matrix, in the base), "force:SENSOR" (N),
    "torque:SENSOR" (Nm), "width:GRIPPER" (m), "channel:NAME"; a missing value is 0. An action is six numbers from -1 to 1,
    along and about the axes of `frame` ("world", a frame of the cell, "tcp"), times `scale`: act="cartesian_offset": the
    way in one action (default 0.002 m, 0.02 rad); "twist": a velocity (0.1 m/s, 0.5 rad/s). It lasts `cycles` cycles.
    start(cell): what the program does before each episode. reward(cell, observation); success(cell, observation) ends the
    episode; `seconds` is its longest time. Other options are those of takt.open(). Equal seeds and actions give equal
    digests (`info["digest"]` of the last step).
    """
    default = (0.1, 0.5) if act == "twist" else (0.002, 0.02)
    return TaktEnv(file, arm=arm, observe=observe, act=act, cycles=cycles, seconds=seconds, scale=scale or default, frame=frame,
                   start=start, reward=reward, success=success, **options)
