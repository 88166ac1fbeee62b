"""Printed by `python3 -m takt.stubs` from the tables of operations: do not edit."""
from collections.abc import Callable, Sequence
from typing import Any, Annotated, overload

import numpy
from numpy.typing import NDArray


def operations() -> str: ...

def data_folder() -> str: ...

def find_scenario(arg: str, /) -> str: ...

version: str = '0.1.0'

def run_scenario(arg0: str, arg1: str, /) -> str: ...

def check_scenario(arg0: str, arg1: str, /) -> str: ...

class Recording:
    def contents(self) -> str: ...

    def tables(self, arg: Sequence[str], /) -> list[tuple[Any, Any]]: ...

    def events(self, arg: str, /) -> str: ...

def open_recording(arg: str, /) -> Recording: ...

def compare(arg0: str, arg1: str, arg2: bool, arg3: str, /) -> str: ...

def fingerprint() -> dict[str, str]:
    """What the bits of a run depend on."""

class State:
    """Something that holds or does not hold in each cycle."""

    def now(self) -> bool | None:
        """Whether it holds now; None where that is not known."""

    def __and__(self, arg: State, /) -> State: ...

    def __or__(self, arg: State, /) -> State: ...

    def __invert__(self) -> State: ...

    def __bool__(self) -> bool: ...

    def held_for(self, seconds: float) -> State:
        """Holds once this has held so long without a break."""

    def once(self) -> State:
        """Holds from the first cycle on in which this did."""

class Real:
    """A number that changes: a reading, or a formula over others."""

    def now(self) -> float | None:
        """The value of now; None while there is none."""

    @overload
    def __add__(self, arg: Real, /) -> Real: ...

    @overload
    def __add__(self, arg: float, /) -> Real: ...

    def __radd__(self, arg: float, /) -> Real: ...

    @overload
    def __sub__(self, arg: Real, /) -> Real: ...

    @overload
    def __sub__(self, arg: float, /) -> Real: ...

    def __rsub__(self, arg: float, /) -> Real: ...

    @overload
    def __mul__(self, arg: Real, /) -> Real: ...

    @overload
    def __mul__(self, arg: float, /) -> Real: ...

    def __rmul__(self, arg: float, /) -> Real: ...

    @overload
    def __truediv__(self, arg: Real, /) -> Real: ...

    @overload
    def __truediv__(self, arg: float, /) -> Real: ...

    def __rtruediv__(self, arg: float, /) -> Real: ...

    def __neg__(self) -> Real: ...

    def __abs__(self) -> Real: ...

    @overload
    def __gt__(self, arg: Real, /) -> State: ...

    @overload
    def __gt__(self, arg: float, /) -> State: ...

    @overload
    def __lt__(self, arg: Real, /) -> State: ...

    @overload
    def __lt__(self, arg: float, /) -> State: ...

    @overload
    def __ge__(self, arg: Real, /) -> State: ...

    @overload
    def __ge__(self, arg: float, /) -> State: ...

    @overload
    def __le__(self, arg: Real, /) -> State: ...

    @overload
    def __le__(self, arg: float, /) -> State: ...

    def __eq__(self, arg: object, /) -> bool: ...

    def __ne__(self, arg: object, /) -> bool: ...

    def __bool__(self) -> bool: ...

    def near(self, value: float, tolerance: float) -> State:
        """Differs by at most the tolerance, in the unit of both."""

    def in_range(self, low: float, high: float) -> State: ...

    def low_pass(self, cutoff_Hz: float) -> Real:
        """First-order low pass, cutoff at -3 dB."""

    def derivative(self, cutoff_Hz: float) -> Real:
        """Change per second, smoothed."""

    def sqrt(self) -> Real: ...

    def is_silent(self) -> State:
        """The sensor does not answer."""

class Vector:
    """Three numbers that change."""

    def now(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')] | None: ...

    def __add__(self, arg: Vector, /) -> Vector: ...

    def __sub__(self, arg: Vector, /) -> Vector: ...

    def __rmul__(self, arg: float, /) -> Vector: ...

    def norm(self) -> Real: ...

    def dot(self, direction: Sequence[float] | NDArray[numpy.float64]) -> Real: ...

    @overload
    def distance(self, point: Sequence[float] | NDArray[numpy.float64]) -> Real: ...

    @overload
    def distance(self, point: Vector) -> Real: ...

    def low_pass(self, cutoff_Hz: float) -> Vector: ...

    def __getitem__(self, arg: int, /) -> Real: ...

class Pose:
    """A pose that changes."""

    def now(self) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')] | None:
        """4x4, m; None while it is not known."""

    def __matmul__(self, arg: Pose, /) -> Pose: ...

    def inverse(self) -> Pose: ...

    @property
    def position(self) -> Vector: ...

    def distance(self, other: Pose) -> Real: ...

    def angle(self, other: Pose) -> Real: ...

class Twist:
    """A velocity that changes."""

    @property
    def linear(self) -> Vector:
        """m/s"""

    @property
    def angular(self) -> Vector:
        """rad/s"""

class Wrench:
    """Force and torque that change."""

    @property
    def force(self) -> Vector:
        """N"""

    @property
    def torque(self) -> Vector:
        """Nm"""

    def low_pass(self, cutoff_Hz: float) -> Wrench: ...

class Joints:
    """One number per joint, which change."""

    def now(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None: ...

    def __getitem__(self, arg: int, /) -> Real: ...

    def __sub__(self, arg: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], /) -> Joints: ...

    def largest(self) -> Real:
        """The largest size of an element."""

class Cell:
    def names(self) -> str: ...

    def device_name(self, arg0: str, arg1: str, /) -> str: ...

    @property
    def time(self) -> float:
        """s, simulated"""

    @property
    def cycle(self) -> int: ...

    @property
    def title(self) -> str: ...

    def wait_seconds(self, arg: float, /) -> None: ...

    def wait_for_all(self) -> None: ...

    def wait_until(self, arg0: State, arg1: float, /) -> bool: ...

    def drive(self, arg: Callable[[], bool], /) -> None: ...

    def spend_step(self) -> None: ...

    def cancel(self) -> None: ...

    def step(self, arg: str, /) -> None: ...

    def print(self, arg: str, /) -> None: ...

    def expect(self, arg0: str, arg1: bool, arg2: str, /) -> None: ...

    def finish(self, why: str, run_again: Callable[[], str] | None) -> str: ...

    def force(self, arg: str, /) -> Real: ...

    def wrench(self, arg: str, /) -> Wrench: ...

    def pressing(self, arg0: Sequence[float] | NDArray[numpy.float64], arg1: str, /) -> Real: ...

    def input(self, arg: str, /) -> State: ...

    def analog_input(self, arg: str, /) -> Real: ...

    def distance(self, arg0: Sequence[str], arg1: Sequence[str], /) -> Real: ...

    def gripper_is(self, arg0: str, arg1: str, /) -> State: ...

    def gripper_width(self, arg: str, /) -> Real: ...

    def tool_pose(self, arg: str, /) -> Pose: ...

    def commanded_tool_pose(self, arg: str, /) -> Pose: ...

    def tool_twist(self, arg: str, /) -> Twist: ...

    def measured_joints(self, arg: str, /) -> Joints: ...

    def measured_velocities(self, arg: str, /) -> Joints: ...

    def measured_torques(self, arg: str, /) -> Joints: ...

    def q(self, arg: str, /) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    def measured_q(self, arg: str, /) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    def home(self, arg: str, /) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    def flange(self, arg: str, /) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]: ...

    def tool(self, arg: str, /) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]: ...

    def measured_tool(self, arg: str, /) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]: ...

    def frame_of(self, arg0: str, arg1: str, /) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]: ...

    def above(self, arg0: str, arg1: str, arg2: float, /) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]: ...

    def tcp(self, arg0: str, arg1: str, arg2: str, /) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]: ...

    def use_tool(self, arg0: str, arg1: str, arg2: str, /) -> None: ...

    def carry(self, arg0: str, arg1: float, /) -> None: ...

    def set_speed(self, arg0: str, arg1: float, /) -> None: ...

    def pause(self, arg: str, /) -> None: ...

    def resume(self, arg: str, /) -> None: ...

    def mode(self, arg: str, /) -> str: ...

    def interfaces(self, arg: str, /) -> list[str]: ...

    def frame(self, arg: str, /) -> Frame: ...

    def write_channel(self, arg0: str, arg1: str, /) -> None: ...

    def channel_value(self, arg: str, /) -> str: ...

    def channel_sensor(self, arg: str, /) -> object: ...

    def channel_description(self, arg: str, /) -> str: ...

def open_cell(arg0: str, arg1: str, /) -> Cell: ...

class Frame:
    """A frame of the cell, where the program believes it to be."""

    def offset(self, x: float, y: float, z: float) -> Frame:
        """The frame beside this one: so far along its axes, m."""

    def turned(self, roll: float, pitch: float, yaw: float) -> Frame:
        """The frame turned about its own axes, rad."""

    def then(self, X: Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]) -> Frame: ...

    def pose(self, in_: str = 'world') -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]:
        """Where it is now in another frame, 4x4, m."""

    def pose_in(self, other: str) -> Pose:
        """The same as a sensor."""

    def velocity_in(self, other: str) -> Twist: ...

    def keep_as(self, name: str) -> Frame:
        """Makes it a frame of the cell that rides on what this one rides on."""

class Goal:
    pass

def goal_pose(arg0: str, arg1: Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')], arg2: str, /) -> Goal: ...

def goal_joints(arg0: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], arg1: str, /) -> Goal: ...

def goal_joint(arg0: int, arg1: float, arg2: bool, /) -> Goal: ...

class Values:
    def __init__(self) -> None: ...

    def state(self, arg0: str, arg1: State, /) -> None: ...

    def goals(self, arg0: str, arg1: Sequence[Goal], /) -> None: ...

    @property
    def blend(self) -> float | None: ...

    @blend.setter
    def blend(self, arg: float | None, /) -> None: ...

    @property
    def X_FM(self) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')] | None: ...

    @X_FM.setter
    def X_FM(self, arg: Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')] | None, /) -> None: ...

class Run:
    """One execution of an activity."""

    @property
    def name(self) -> str: ...

    @property
    def state(self) -> str: ...

    @property
    def started(self) -> bool: ...

    @property
    def over(self) -> bool: ...

    @property
    def blended(self) -> bool:
        """It has taken over a motion."""

    @property
    def first_cycle(self) -> int:
        """-1: not yet"""

    @property
    def last_cycle(self) -> int:
        """-1: not yet"""

    @property
    def preparation(self) -> tuple[float, float]:
        """CPU time of planning, and of all until it could start, s."""

    def _outcome(self) -> str: ...

    def _reactions(self) -> str: ...

    def _diagnostics(self) -> str: ...

    def _require(self) -> None: ...

    def wait(self) -> None:
        """Returns when it has ended. Raises what made it fail."""

    def cancel(self) -> None:
        """Asks for an end in order: it brakes on its path."""

    def abort(self) -> None: ...

class Activity:
    """An operation that can be asked for as often as wanted."""

    def execute(self) -> Run:
        """Returns when it has ended. Raises what made it fail."""

    def begin(self) -> Run:
        """Returns when it has started, in motion if what runs may be left."""

    def schedule(self) -> Run:
        """
        Returns at once; it takes its turn behind what has its devices already.
        """

def activity(arg0: Cell, arg1: str, arg2: Values, /) -> Activity: ...

def execute(arg0: Cell, arg1: str, arg2: Values, /) -> Run | None: ...

def sequence(arg: Sequence[Activity], /) -> Activity: ...

def parallel(arg: Sequence[Activity], /) -> Activity: ...

def conditional(arg0: State, arg1: Activity, arg2: Activity, /) -> Activity: ...

def abort_if(arg0: Activity, arg1: State, /) -> Activity: ...

def with_subtasks(arg0: Activity, arg1: Sequence[tuple[Activity, float | None, State | None]], /) -> Activity: ...

class TwoArms:
    def _lin(self, arg0: Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')], arg1: str, arg2: Values, /) -> Activity: ...

    def _lin_by(self, arg0: Sequence[float] | NDArray[numpy.float64], arg1: str, arg2: Values, /) -> Activity: ...

    @property
    def centre(self) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]: ...

    @property
    def centre_by_follower(self) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')]: ...

def two_arms(arg0: Cell, arg1: str, arg2: str, arg3: Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')], /) -> TwoArms: ...

class Action:
    """What a command lets a device do."""

def action_ptp(arg0: Cell, arg1: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')], arg2: float, arg3: float, /) -> Action: ...

def action_lin(arg0: Cell, arg1: Annotated[NDArray[numpy.float64], dict(shape=(4, 4), order='F')], arg2: float, arg3: float, arg4: float | None, /) -> Action: ...

def action_hold_force(arg0: Cell, arg1: Real, arg2: Sequence[float] | NDArray[numpy.float64], arg3: float, arg4: float, /) -> Action: ...

@overload
def action_set(arg0: Cell, arg1: bool, /) -> Action: ...

@overload
def action_set(arg0: Cell, arg1: float, /) -> Action: ...

def action_hold(arg: Cell, /) -> Action: ...

class Effect:
    """What an event does."""

def effect_start(arg: Command, /) -> Effect: ...

def effect_stop(arg: Command, /) -> Effect: ...

def effect_cancel(arg: Command, /) -> Effect: ...

def effect_raise(arg: RaisedState, /) -> Effect: ...

class RaisedState:
    @property
    def state(self) -> State: ...

class Command:
    """Something that is to happen in real time."""

    @property
    def name(self) -> str: ...

    def on_entered(self, state: State, effect: Effect, after_s: float = 0.0, first_only: bool = False) -> None:
        """
        When the state becomes true while the command is active, then the effect.
        """

    def on_left(self, state: State, effect: Effect, after_s: float = 0.0, first_only: bool = False) -> None:
        """
        When the state ceases to be true while the command is active, then the effect.
        """

    def fails_if(self, state: State) -> None: ...

    @property
    def started(self) -> State:
        """A state: it has begun."""

    @property
    def active(self) -> State:
        """A state: it runs."""

    @property
    def completed(self) -> State:
        """A state: it ended in order."""

    @property
    def failed(self) -> State:
        """A state: it has failed."""

    @property
    def stopped(self) -> State:
        """A state: a stop has ended it."""

    @property
    def cancelled(self) -> State:
        """A state: its cancel was asked for."""

    @property
    def paused(self) -> State:
        """A state: people hold its arms still."""

def runtime_command(arg0: Cell, arg1: str, arg2: str, arg3: Action, /) -> Command: ...

def wait_command(arg0: Cell, arg1: str, arg2: float | State, arg3: float | None, /) -> Command: ...

class Transaction:
    """Commands in one real-time context."""

    def add(self, command: Command) -> None:
        """A command that an event starts."""

    def add_started(self, command: Command) -> None:
        """A command that starts in the cycle in which this does."""

    def raised(self, name: str) -> RaisedState:
        """A state that handlers in here may raise."""

    def as_command(self) -> Command: ...

def transaction(arg0: Cell, arg1: str, /) -> Transaction: ...

def command_activity(arg0: Cell, arg1: Command, /) -> Activity: ...
