#!/usr/bin/env python3
"""Regression of real programs, from outside: a minute of two arms becomes a golden, and one changed speed is named.

Usage: regression_test.py TAKT
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
MOST_BYTES = 100_000


def moves(arm, rounds, phase):
    """Out, down, up and home, each round elsewhere; each step has a name of its own."""
    steps = []
    for i in range(rounds):
        turn = round(20 * math.sin(1.7 * i + phase), 1) or 5.0
        by = [round(size * math.cos(rate * i + phase), 3) for size, rate in ((0.06, 2.3), (0.14, 1.9), (0.05, 3.1))]
        steps += [
            {"do": "ptp", "name": f"{arm} out {i}", "arm": arm, "speed": 0.35,
             "to": {"by_m": by, "by_rpy_deg": [turn if abs(turn) > 7 else 8.0, 0, 0]}},
            {"do": "lin", "name": f"{arm} down {i}", "arm": arm, "velocity_m_s": 0.08, "to": {"by_m": [0, 0, -0.06]}},
            {"do": "lin", "name": f"{arm} up {i}", "arm": arm, "velocity_m_s": 0.08, "to": {"by_m": [0, 0, 0.06]}},
            {"do": "ptp", "name": f"{arm} home {i}", "arm": arm, "speed": 0.4, "to": "home"}]
    return steps


def two_arms(rounds):
    """An LWR, and a UR5 whose controller has a cycle of 8 ms."""
    return {"title": "Two arms", "seed": 1, "time_limit_s": 120,
            "devices": {"left": {"model": "lwr4plus", "at": {"in": "world", "position_m": [0, 0.8, 0.75]}},
                        "right": {"model": "ur5", "at": {"in": "world", "position_m": [0, -0.8, 0.75]}}},
            "program": {"do": "parallel", "name": "both", "branches": [
                {"do": "sequence", "name": "left arm", "steps": moves("left", rounds, 0.3)},
                {"do": "sequence", "name": "right arm", "steps": moves("right", rounds, 1.1)}]},
            "expectations": [{"kind": "limits", "name": "limits", "arm": "left"}]}


class Regression(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)

    def takt(self, *arguments, status=0):
        run = subprocess.run([TAKT, *map(str, arguments)], capture_output=True, text=True, timeout=900, check=False)
        self.assertEqual(run.returncode, status, run.stdout[-4000:] + run.stderr[-4000:])
        return run.stdout

    def write(self, scenario):
        file = self.path / "two.json"
        file.write_text(json.dumps(scenario))
        return file

    def test_a_minute_of_two_arms_is_a_golden_of_less_than_100_kB(self):
        file = self.write(two_arms(24))
        self.takt("bless", file, "--reason", "a test")
        golden = json.loads((self.path / "two.golden.json").read_text())
        size = (self.path / "two.golden.json").stat().st_size
        self.assertGreater(golden["end_s"], 60)
        self.assertLess(size, MOST_BYTES)
        print(f"{golden['end_s']} s of two arms: {size} bytes, {len(golden['columns'])} columns")
        topics = {column["topic"] for column in golden["columns"]}
        self.assertEqual(topics, {f"/{arm}/{what}" for arm in ("left", "right") for what in ("set_point", "joint_states")})
        held = {tuple(column["curve"]["hold"]) for column in golden["columns"] if "hold" in column["curve"]}
        self.assertEqual({every for every, _ in held}, {8}, "the staircase of the controller is recognised")
        self.assertIn("two.json: passed", self.takt("verify", file))

    def test_one_changed_speed_is_named_first(self):
        """Of either arm, of each kind of motion: the step, before anything else, and its value where both are known."""
        scenario = two_arms(3)
        file = self.write(scenario)
        self.takt("bless", file, "--reason", "a test")
        before = self.path / "before.mcap"
        self.takt("run", file, "--record", before)
        for branch, index, key in ((0, 4, "speed"), (1, 5, "velocity_m_s"), (0, 6, "velocity_m_s"), (1, 9, "velocity_m_s")):
            changed = json.loads(json.dumps(scenario))
            step = changed["program"]["branches"][branch]["steps"][index]
            step[key] = round(step[key] * 1.03, 6)
            self.write(changed)
            name = step["name"]
            with self.subTest(step=name):
                report = json.loads(self.takt("verify", file, "--no-film", "--json", status=1))["scenarios"][0]["golden"]
                self.assertTrue(report["departure"]["step"].endswith("/ " + name), report["departure"])
                other = [one for one in report["durations"] if not one["same"] and one["step"].endswith("/ " + name)]
                if key == "velocity_m_s":  # a joint motion may be as long as before: its accelerations decide
                    self.assertEqual(len(other), 1)
                    self.assertLess(other[0]["a_s"], other[0]["b_s"])
                self.assertEqual(report["missing"], [])
                text = self.takt("verify", file, "--no-film", status=1).splitlines()
                self.assertNotIn("passed", text[0])
                first = next(line for line in text if line.startswith("first departure:"))
                self.assertIn(f"/ {name}'", first)
                self.assertLess(text.index(first), min(i for i, line in enumerate(text) if line.startswith("outside:")))
                after = self.path / "after.mcap"
                self.takt("run", file, "--record", after)
                compared = json.loads(self.takt("compare", after, before, "--quick", "--json", status=1))
                self.assertTrue(compared["departure"]["step"].endswith("/ " + name), compared["departure"])
                self.assertEqual([one["pointer"] for one in compared["scenario_differences"]],
                                 [f"/program/branches/{branch}/steps/{index}/{key}"])


if __name__ == "__main__":
    unittest.main()
