"""Channels of runs and recordings as arrays and tables, features, comparison."""
import pathlib

import numpy as np
import pytest
import takt

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_channels_of_a_run(touched):
    position = touched["arm"].position
    assert position.unit == "rad" and position.values.shape == (len(position.time), len(position.columns))
    assert position.time[-1] == pytest.approx(touched.sim_time, abs=0.002)
    assert np.diff(position.time).min() > 0
    force = touched["wrist"].force
    assert force.unit == "N" and force.columns == ["force.x", "force.y", "force.z"]
    assert force.peak == pytest.approx(np.nanmax(np.linalg.norm(force.values, axis=1)))


def test_a_column_is_not_copied(touched):
    channel = touched["/arm/joint_states"]
    assert np.shares_memory(channel["a1.position"].values, channel["a1.position"].values)
    assert channel.units["a1.position"] == "rad"


def test_features_by_hand():
    curve = takt.Curve("x", np.array([0.0, 1.0, 3.0, 4.0]), np.array([0.0, 2.0, -4.0, -4.0]), ["x"], "m")
    assert (curve.max, curve.min, curve.end, curve.peak, curve.duration) == (2.0, -4.0, -4.0, 4.0, 4.0)
    assert curve.path() == 8.0
    assert curve.settling(0.5) == 3.0
    assert curve.mean == pytest.approx((1.0 + 2 * -1.0 + -4.0) / 4)


def test_to_arrow(touched):
    table = touched.to_arrow("arm.position")
    assert table.column_names[0] == "time_s" and table.num_rows == len(touched["arm"].position)
    whole = touched.to_arrow("/arm/joint_states")
    assert whole.schema.field("a1.position").metadata[b"unit"] == b"rad"
    assert whole["a1.position"].to_numpy().tolist() == touched["/arm/joint_states"]["a1.position"].values.tolist()


def test_all_topics_are_read_at_once(touched):
    whole = takt.open_recording(touched.recording.path)
    tables = whole.to_arrow()
    assert list(tables) == whole.topics
    for topic in whole.topics:
        alone = takt.open_recording(touched.recording.path).to_arrow(topic)
        assert tables[topic].schema.equals(alone.schema, check_metadata=True)
        assert tables[topic].num_rows == alone.num_rows == len(whole[topic])
        assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(tables[topic].columns, alone.columns))


def test_arrays_are_those_of_the_command_line(touched, tmp_path, command_line):
    import csv
    command_line("export", touched.recording.path, "--topic", "/arm/joint_states", "--csv", tmp_path)
    rows = list(csv.reader((tmp_path / "arm_joint_states.csv").open()))
    column = [float(row[1]) for row in rows[1:]]
    name = rows[0][1].split(" ")[0]
    assert touched["/arm/joint_states"][name].values.tolist() == column


def test_plot(touched):
    axes = touched["wrist"].force.plot()
    assert len(axes.lines) == 3 and "[N]" in axes.get_ylabel()


def test_unknown_channels_have_the_nearest_name(touched):
    for attempt in (lambda: touched["amr"], lambda: touched["arm"]["postion"], lambda: touched["/arm/joint_states"]["a1.x"],
                    lambda: touched.to_arrow("arm.x"), lambda: touched.to_arrow("arm")):
        with pytest.raises(takt.RecordingError) as caught:
            attempt()
        assert caught.value.code == "unknown-name"


def test_a_recording_of_its_own(touched, tmp_path):
    path = tmp_path / "run.mcap"
    takt.run("wave.json", record=path, set={"/expectations": []})
    recording = takt.open_recording(path)
    assert recording.topics and recording.damage == [] and recording.duration > 1
    assert recording.metadata["takt.run"]
    assert recording.events()
    path.write_bytes(path.read_bytes()[:-3000])
    assert takt.open_recording(path).damage
    with pytest.raises(takt.RecordingError) as caught:
        takt.open_recording(ROOT / "README.md")
    assert caught.value.code
    with pytest.raises(takt.RecordingError):
        takt.open_recording(tmp_path / "nothing.mcap")


def test_a_run_without_a_recording_says_so():
    run = takt.run("wave.json", record=False, set={"/expectations": []})
    with pytest.raises(takt.UsageError) as caught:
        run["arm"]
    assert caught.value.code == "requires"


def test_compare(touched, tmp_path):
    same = takt.compare(touched, touched, equal_digests=True)
    assert same.passed and same.columns
    other = takt.run("touch.json", seed=7, set={"/expectations": []})
    page = tmp_path / "page.html"
    differs = takt.compare(other, touched, equal_digests=True, report=page)
    assert not differs.passed and page.stat().st_size > 1000
