"""Conditions as files have them, for steps of a program tree, handlers and captures of transactions:
`force("wrist") > 5`, `input("barrier") & ~gripper("left", "holding")`. A program at once has cell.force(...) besides."""
from __future__ import annotations

from typing import Any

from ._errors import refuse

__all__ = ["Condition", "Quantity", "analog", "channel", "distance", "force", "gripper", "input", "internal_force", "torque"]


class Condition:
    """Something that holds or does not hold in each cycle, in the form of files."""

    def __init__(self, row: dict[str, Any]):
        self._row = row

    def as_file(self) -> dict[str, Any]:
        return self._row

    def __and__(self, other: "Condition") -> "Condition":
        return self._joined("all", other)

    def __or__(self, other: "Condition") -> "Condition":
        return self._joined("any", other)

    def __invert__(self) -> "Condition":
        return Condition({"not": self._row})

    def held_for(self, seconds: float) -> "Condition":
        """Of a state in a transaction: once it has held so long without a break."""
        return Condition({**self._row, "held_for_s": float(seconds)})

    def _joined(self, key: str, other: "Condition") -> "Condition":
        if not isinstance(other, Condition):
            raise refuse("wrong-type", "", f"unexpected value {other!r}", "Combine conditions of takt.conditions")
        return Condition({key: [one for side in (self._row, other._row)
                                for one in (side[key] if set(side) == {key} else [side])]})

    def __bool__(self) -> bool:
        raise refuse("unsupported", "", "a condition has no truth value in Python: it holds or not in each cycle",
                     "Combine conditions with & | ~ in place of and, or, not")

    def __repr__(self) -> str:
        return f"<condition {self._row}>"


class Quantity:
    """A number that conditions compare: `quantity > 5`."""

    def __init__(self, row: dict[str, Any], unit: str):
        self._row, self._unit = row, unit

    def __gt__(self, threshold: float) -> Condition:
        return self._compared("above", threshold)

    def __lt__(self, threshold: float) -> Condition:
        return self._compared("below", threshold)

    def _compared(self, word: str, threshold: float) -> Condition:
        if not isinstance(threshold, (int, float)) or isinstance(threshold, bool):
            raise refuse("wrong-type", "", f"unexpected value {threshold!r}", "Compare with a number")
        return Condition({**self._row, f"{word}_{self._unit}" if self._unit else word: threshold})

    def __bool__(self) -> bool:
        raise refuse("unsupported", "", "a quantity has no truth value in Python", "Compare it with > or <")


def force(sensor: str, component: str = "") -> Quantity:
    """The size of the force that a sensor feels, or its component x, y or z, N."""
    row = {"sensor": sensor}
    return Quantity(row | {"quantity": f"force_{component}"} if component else row, "N")


def torque(sensor: str, component: str = "") -> Quantity:
    """The size of the torque, or its component x, y or z, Nm."""
    return Quantity({"sensor": sensor, "quantity": f"torque_{component}" if component else "torque"}, "Nm")


def internal_force(one_sensor: str, other_sensor: str) -> Quantity:
    """What two arms do to the part that both hold, N."""
    return Quantity({"internal_force": [one_sensor, other_sensor]}, "N")


def distance(one: str, other: str) -> Quantity:
    """The smallest distance of two devices, objects or bodies, m."""
    return Quantity({"distance": [one, other]}, "m")


def analog(name: str, unit: str) -> Quantity:
    """An analog input in its own unit."""
    return Quantity({"input": name}, unit)


def input(name: str) -> Condition:
    """A digital input is true."""
    return Condition({"input": name, "is": True})


def gripper(name: str, state: str) -> Condition:
    """A gripper is moving, holding, lost, open or closed."""
    return Condition({"gripper": name, "is": state})


def channel(name: str) -> Condition:
    """A Boolean channel is true."""
    return Condition({"channel": name, "is": True})
