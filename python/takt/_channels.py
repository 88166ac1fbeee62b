"""Channels of a cell: values that a program writes, and that nets and states read (docs/channels.md)."""
from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ._errors import refuse

if TYPE_CHECKING:
    from . import _takt
    from ._cell import Cell

_HALVES = {"Twist": ("linear", "angular"), "Wrench": ("force", "torque")}


class CellChannel:
    """One channel. A Frame is a 4x4 array (m), a Twist or Wrench six numbers: linear, then angular; Vector and Joints are
    arrays; Boolean, Integer, Real and String what Python calls so."""

    def __init__(self, cell: "Cell", name: str):
        self._cell, self.name = cell, name
        self._description: dict[str, str] = json.loads(cell._native.channel_description(name))

    @property
    def type(self) -> str:
        return self._description["type"]

    @property
    def unit(self) -> str:
        return self._description["unit"]

    @property
    def writer(self) -> str:
        """"outside": this program may write it; "net"."""
        return self._description["writer"]

    def write(self, value: Any) -> None:
        """Nets and states see it from the next cycle on; None: null. Without a new value it is null after its timeout."""
        self._cell._native.write_channel(self.name, json.dumps(self._in_file(value)))

    @property
    def value(self) -> Any:
        """The value of this cycle; None: null, or older than its timeout."""
        return self._in_python(json.loads(self._cell._native.channel_value(self.name)))

    @property
    def sensor(self) -> "_takt.State | _takt.Real | _takt.Vector | _takt.Frame | _takt.Twist | _takt.Wrench | _takt.Joints":
        """For conditions and formulas: a Boolean is a State."""
        sensor: Any = self._cell._native.channel_sensor(self.name)
        return sensor  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        return f"<channel '{self.name}', {self.type}>"

    def _in_file(self, value: Any) -> Any:
        if value is None or isinstance(value, (bool, str)):
            return value
        try:
            array = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise refuse("wrong-type", "/value", f"unexpected value {value!r}", f"Write a {self.type}") from None
        if not np.isfinite(array).all():
            raise refuse("invalid-value", "/value", f"{value!r} is not finite", "Write None for no value")
        if self.type == "Frame":
            return self._pose_in_file(array)
        if self.type in _HALVES:
            if array.shape != (6,):
                raise refuse("wrong-size", "/value", f"{array.shape} is not the shape of a {self.type}", "Give six numbers")
            return dict(zip(_HALVES[self.type], (array[:3].tolist(), array[3:].tolist())))
        if self.type == "Integer" and array.shape == () and float(array).is_integer():
            return int(array)
        return array.tolist()

    @staticmethod
    def _pose_in_file(X: "np.ndarray") -> Any:
        if X.shape != (4, 4) or np.abs(X[:3, :3] @ X[:3, :3].T - np.eye(3)).max() > 1e-6 or np.linalg.det(X[:3, :3]) < 0:
            raise refuse("invalid-value", "/value", "no pose", "Give a 4x4 array with a rotation and a position (m)")
        return {"position": X[:3, 3].tolist(), "quaternion": _quaternion(X[:3, :3])}

    def _in_python(self, value: Any) -> Any:
        if value is None or isinstance(value, (bool, int, float, str)):
            return value
        if self.type == "Frame":
            X = np.eye(4)
            X[:3, :3], X[:3, 3] = _rotation(value["quaternion"]), value["position"]
            return X
        if self.type in _HALVES:
            return np.concatenate([value[half] for half in _HALVES[self.type]])
        return np.asarray(value)


def _quaternion(R: "np.ndarray") -> list[float]:
    """w, x, y, z: of the four ways to compute it, the one that divides by the largest number."""
    squares = np.array([1 + R[0, 0] + R[1, 1] + R[2, 2], 1 + R[0, 0] - R[1, 1] - R[2, 2],
                        1 - R[0, 0] + R[1, 1] - R[2, 2], 1 - R[0, 0] - R[1, 1] + R[2, 2]])
    largest = int(squares.argmax())
    x, y, z = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    xy, xz, yz = R[1, 0] + R[0, 1], R[0, 2] + R[2, 0], R[2, 1] + R[1, 2]
    rows = [(squares[0], x, y, z), (x, squares[1], xy, xz), (y, xy, squares[2], yz), (z, xz, yz, squares[3])]
    wxyz = np.array(rows[largest])
    return [float(one) for one in wxyz / math.sqrt(wxyz @ wxyz)]


def _rotation(wxyz: list[float]) -> "np.ndarray":
    w, v = wxyz[0], np.array(wxyz[1:])
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.asarray(np.eye(3) + 2 * w * cross + 2 * cross @ cross)
