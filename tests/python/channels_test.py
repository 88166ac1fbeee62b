"""Channels that a program writes and reads."""
import pathlib

import numpy as np
import pytest
import takt

ARM = pathlib.Path(__file__).resolve().parents[2] / "examples/activities/cells/arm.json"
CHANNELS = {
    "enable": {"type": "Boolean", "initial": False},
    "count": {"type": "Integer", "initial": 3},
    "level": {"type": "Real", "unit": "m", "timeout_s": 0.01},
    "word": {"type": "String", "initial": "a"},
    "way": {"type": "Vector", "unit": "m"},
    "place": {"type": "Frame"},
    "stick": {"type": "Twist", "unit": "m/s,rad/s", "timeout_s": 0.1},
    "pull": {"type": "Wrench", "unit": "N,N*m"},
    "posture": {"type": "Joints", "unit": "rad"},
    "made": {"type": "Real", "writer": "net"},
}


@pytest.fixture
def cell():
    with takt.open(ARM, quiet=True, set={"/channels": CHANNELS}) as opened:
        yield opened


def written(cell, name, value):
    channel = cell.channel(name)
    channel.write(value)
    cell.next_cycle()
    return channel.value


def test_a_value_of_each_type_comes_back(cell):
    assert set(CHANNELS) < set(cell.names["channel"])
    assert cell.channel("enable").value is False and cell.channel("count").value == 3
    assert written(cell, "enable", True) is True
    assert written(cell, "count", -7) == -7
    assert written(cell, "level", 0.25) == 0.25
    assert written(cell, "word", "home") == "home"
    for name, value in (("way", [1, 2, 3.5]), ("stick", np.arange(6.0)), ("pull", np.ones(6)), ("posture", np.zeros(7))):
        assert (written(cell, name, value) == np.asarray(value)).all()
    for axis in ([1, 0, 0], [0.6, 0, 0.8], [0, 0, 1]):
        for angle in (0.0, 1.0, np.pi, 4.0):
            K = np.cross(np.eye(3), axis) * -1
            X = np.eye(4)
            X[:3, :3] += np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
            X[:3, 3] = (0.1, -0.2, 0.3)
            assert np.abs(written(cell, "place", X) - X).max() < 1e-12


def test_a_value_counts_from_the_next_cycle_on_until_it_is_too_old(cell):
    level = cell.channel("level")
    assert level.value is None
    level.write(1.0)
    assert level.value is None
    cell.next_cycle()
    assert level.value == 1.0
    for _ in range(12):
        cell.next_cycle()
    assert level.value is None
    assert written(cell, "level", 2.0) == 2.0 and written(cell, "level", None) is None


def test_a_jog_goes_after_a_channel_and_a_state_ends_it(cell):
    arm, stick, enable = cell.arm(), cell.channel("stick"), cell.channel("enable")
    before = arm.tool
    enable.write(True)
    cell.next_cycle()
    run = arm.jog.begin(channel="stick", while_=enable.sensor, until=~enable.sensor)
    for _ in range(300):
        stick.write([0, 0.05, 0, 0, 0, 0])
        cell.next_cycle()
    moved = arm.tool[1, 3] - before[1, 3]
    assert 0.005 < moved < 0.016
    enable.write(False)
    run.wait()
    assert np.abs(arm.tool[[0, 2], 3] - before[[0, 2], 3]).max() < 1e-4


def test_sensors_are_formulas(cell):
    cell.channel("level").write(0.4)
    cell.channel("way").write([3, 4, 0])
    cell.next_cycle()
    assert (2 * cell.channel("level").sensor).now() == pytest.approx(0.8)
    assert cell.channel("way").sensor.norm().now() == pytest.approx(5.0)


def refused(attempt):
    with pytest.raises(takt.Error) as caught:
        attempt()
    return type(caught.value).__name__, caught.value.code


def test_wrong_use(cell):
    assert refused(lambda: cell.channel("levle")) == ("OperationError", "unknown-name")
    assert refused(lambda: cell.channel("made").write(1.0)) == ("OperationError", "conflict")
    level = cell.channel("level")
    assert refused(lambda: level.write("high"))[0] == "OperationError"
    assert refused(lambda: level.write(float("nan"))) == ("UsageError", "invalid-value")
    assert refused(lambda: level.write(object())) == ("UsageError", "wrong-type")
    assert refused(lambda: cell.channel("stick").write([1, 2, 3])) == ("UsageError", "wrong-size")
    assert refused(lambda: cell.channel("place").write(np.zeros((4, 4)))) == ("UsageError", "invalid-value")
    assert refused(lambda: cell.channel("count").write(0.5))[1] == "syntax"
    assert refused(lambda: cell.channel("word").sensor) == ("UsageError", "unsupported")
    assert refused(lambda: cell.arm().freedrive(while_=cell.channel("enable").sensor)) == ("OperationError", "unknown-key")
    assert "level" in repr(level) and level.unit == "m" and level.type == "Real" and level.writer == "outside"
