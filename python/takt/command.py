"""Commands of one's own, with event handlers (docs/command-layer.md): who starts and cancels whom is written out, and the
cell carries it out as one activity. `cell.as_activity(command)` makes it one."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _takt
from ._takt import Action, Command, Effect, RaisedState

if TYPE_CHECKING:
    import numpy as np

    from ._cell import Arm, Cell, Device

__all__ = ["Action", "Command", "Effect", "RaisedState", "Transaction", "cancel", "hold", "hold_force", "lin", "ptp",
           "raise_state", "runtime", "set_value", "start", "stop", "wait"]


def ptp(arm: "Arm", q: "np.ndarray", *, speed: float = 1.0, acceleration: float = 1.0) -> Action:
    """To joint positions (rad); speed, acceleration: shares of the limits."""
    return _takt.action_ptp(arm._cell._native, q, speed, acceleration)


def lin(arm: "Arm", X_BT: "np.ndarray", *, speed: float = 1.0, acceleration: float = 1.0,
        velocity_m_s: float | None = None) -> Action:
    """The tool centre point on a line to a pose in the arm's base."""
    return _takt.action_lin(arm._cell._native, X_BT, speed, acceleration, velocity_m_s)


def hold_force(pressing: _takt.Real, direction: Any, *, cell: "Cell", force_N: float = 10.0, gain: float = 2e-4) -> Action:
    """Presses along a direction of the base, until it is cancelled. gain: m/s for each N."""
    return _takt.action_hold_force(cell._native, pressing, list(direction), force_N, gain)


def set_value(device: "Device", value: bool | float) -> Action:
    """Sets an output, and is done in the cycle in which it does."""
    return _takt.action_set(device._cell._native, value)


def hold(device: "Device") -> Action:
    """Holds an arm at rest where it is, until it is cancelled."""
    return _takt.action_hold(device._cell._native)


def runtime(name: str, device: "Device", action: Action) -> Command:
    """An action on a device."""
    return _takt.runtime_command(device._cell._native, name, device.name, action)


def wait(cell: "Cell", name: str, what: float | _takt.State, timeout_s: float | None = None) -> Command:
    """Lets time pass (s), or waits for a state."""
    return _takt.wait_command(cell._native, name, float(what) if isinstance(what, int) else what, timeout_s)


class Transaction:
    """Commands in one real-time context. It has ended when all that were started have, and nothing in it can start."""

    def __init__(self, cell: "Cell", name: str):
        self._native = _takt.transaction(cell._native, name)
        self.command: Command = self._native.as_command()

    def add(self, *commands: Command) -> "Transaction":
        """Commands that an event starts."""
        for one in commands:
            self._native.add(one)
        return self

    def add_started(self, *commands: Command) -> "Transaction":
        """Commands that start in the cycle in which this does."""
        for one in commands:
            self._native.add_started(one)
        return self

    def raised(self, name: str) -> RaisedState:
        """A state that handlers in here may raise."""
        return self._native.raised(name)

    def on_entered(self, state: _takt.State, effect: Effect, *, after_s: float = 0.0) -> "Transaction":
        self.command.on_entered(state, effect, after_s=after_s)
        return self


def start(command: Command) -> Effect:
    return _takt.effect_start(command)


def stop(command: Command) -> Effect:
    return _takt.effect_stop(command)


def cancel(command: Command) -> Effect:
    return _takt.effect_cancel(command)


def raise_state(state: RaisedState) -> Effect:
    return _takt.effect_raise(state)
