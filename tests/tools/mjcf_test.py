#!/usr/bin/env python3
"""MuJoCo's models in and out, from outside: a foreign one becomes a device that waves; cells run in MuJoCo's own Python.
Runs in the environment of the tests, with the MuJoCo that takt was built with."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
MUJOCO = pathlib.Path(sys.argv.pop(1)).resolve()  # the folder of its Python package
ROOT = pathlib.Path(__file__).resolve().parents[2]
FOREIGN = ROOT / "tests/tools/foreign/mjcf"
sys.path.insert(0, str(MUJOCO.parent))
import mujoco  # noqa: E402


def takt(*arguments, timeout=120):
    return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=timeout, cwd=ROOT)


class WithFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        self.models = self.path / "models"

    def made(self, *arguments):
        run = takt("new", "robot", *arguments, "--out", self.models, "--json")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return json.loads(run.stdout)

    def refused(self, *arguments):
        run = takt("new", "robot", *arguments, "--out", self.models, "--json")
        self.assertEqual(run.returncode, 2, run.stdout + run.stderr)
        return json.loads(run.stdout)["diagnostics"]

    def passed(self, *arguments):
        run = takt("run", *arguments, "--models", self.models, "--json")
        self.assertEqual(json.loads(run.stdout)["result"], "passed", run.stdout + run.stderr)


class In(WithFolder):
    def test_an_arm_becomes_a_device_that_waves(self):
        report = self.made(FOREIGN / "arm_with_hand.xml")
        self.assertEqual(report["folder"], str(self.models / "arm_with_hand"))
        self.assertFalse([note for note in report["notes"] if note["key"].startswith("wave")], report["notes"])
        self.assertEqual(takt("validate", self.models / "arm_with_hand/device.json").returncode, 0)
        self.passed("scenarios/wave.json", "--set", "/devices/arm/model=arm_with_hand")

    def test_a_hand_moves_the_joints_of_a_finger(self):
        report = self.made("hand", "--mjcf", FOREIGN / "hand.xml")
        self.assertEqual(report["joints"], ["index_spread", "index_knuckle", "index_middle", "index_tip"])
        self.assertEqual(report["flange"], "index_end")
        self.assertIn("wave", {note["key"] for note in report["notes"]})
        self.passed(self.models / "hand/wave.json")

    def test_a_gripper_can_be_left_out(self):
        report = self.made("bare", "--mjcf", FOREIGN / "arm_with_hand.xml", "--without", "finger_left", "--without",
                           "finger_right")
        self.assertEqual(len(report["joints"]), 6)
        self.assertNotIn("finger_left", (self.models / "bare/bare.urdf").read_text())

    def test_what_is_wrong_with_the_options_is_said(self):
        wrong = self.refused("x", "--mjcf", FOREIGN / "hand.xml", "--xacro", "a:=1")
        self.assertEqual((wrong[0]["code"], wrong[0]["pointer"]), ("requires", "--xacro"))
        wrong = self.refused("x", "--mjcf", self.path / "none.xml")
        self.assertEqual(wrong[0]["code"], "not-found")
        wrong = self.refused("x", "--mjcf", FOREIGN / "hand.xml", "--flange", "index_en")
        self.assertEqual((wrong[0]["code"], wrong[0]["pointer"]), ("unknown-name", "--flange"))


class Out(WithFolder):
    SCENARIOS = ("touch", "factory2020", "pick", "screw", "tool_change", "mobile", "vacuum", "drive")

    def exported(self, scenario, *options):
        out = self.path / scenario
        run = takt("export", f"scenarios/{scenario}.json", "--mjcf", out, "--json", *options)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return json.loads(run.stdout), out / f"{scenario}.xml"

    def test_mujoco_steps_them_for_ten_seconds_without_a_warning(self):
        for scenario in self.SCENARIOS:
            with self.subTest(scenario=scenario):
                report, file = self.exported(scenario)
                self.assertEqual(report["products"][0], str(file))
                model = mujoco.MjModel.from_xml_path(str(file))
                data = mujoco.MjData(model)
                self.assertEqual(model.nkey, 1)
                mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
                while data.time < 10.0:
                    mujoco.mj_step(model, data, 100)
                self.assertEqual([w.number for w in data.warning if w.number], [], scenario)

    def test_the_head_of_the_file_says_what_it_lacks(self):
        report, file = self.exported("screw")
        head = file.read_text().split("-->")[0]
        for one in report["lacks"]:
            self.assertIn(one.replace("--", "- -"), head)
        self.assertTrue(any(one.startswith("Threads") for one in report["lacks"]), report["lacks"])

    def test_a_value_of_the_scenario_can_be_changed(self):
        _, file = self.exported("wave", "--set", "/devices/arm/at/position_m/2=0.8")
        model = mujoco.MjModel.from_xml_path(str(file))
        base = min(i for i in range(model.nbody) if model.body(i).name.startswith("arm/"))
        self.assertAlmostEqual(model.body_pos[base][2], 0.8, places=12)

    def test_options_of_recordings_and_of_scenarios_do_not_mix(self):
        for options, code, pointer in ((("--mjcf", self.path / "o", "--csv", self.path / "c"), "conflict", "--mjcf"),
                                       (("--csv", self.path / "c", "--seed", "3"), "requires", "--seed")):
            run = takt("export", "scenarios/touch.json", "--json", *options)
            self.assertEqual(run.returncode, 2)
            one = json.loads(run.stdout)["diagnostics"][0]
            self.assertEqual((one["code"], one["pointer"]), (code, pointer))


if __name__ == "__main__":
    unittest.main()
