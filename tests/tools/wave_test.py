#!/usr/bin/env python3
"""Every arm of models/ runs the same program, and the command line says the same of it as the files do."""
import json
import math
import pathlib
import random
import subprocess
import sys
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/models"))
import models_test as files  # noqa: E402

ARMS = [folder for folder in files.FOLDERS if files.device_of(folder)["kind"] == "arm"]


def takt(*arguments):
    return subprocess.run([str(TAKT), *arguments], capture_output=True, text=True, timeout=300, cwd=ROOT)


def listed(values):
    return ",".join(repr(float(v)) for v in values)


class EveryArm(unittest.TestCase):
    def test_waves(self):
        self.assertGreaterEqual(len(ARMS), 3)
        for folder in ARMS:
            with self.subTest(arm=folder.name):
                run = takt("run", "scenarios/wave.json", "--json", "--set", f"/devices/arm/model={folder.name}")
                self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
                report = json.loads(run.stdout)
                self.assertEqual(report["result"], "passed")
                self.assertTrue(all(one["passed"] for one in report["expectations"]))
                # A cycle longer than the core's is kept in simulation too; one of 1 ms is the core's own.
                cycle_ms = files.device_of(folder)["cycle_ms"]
                arm = report["site"]["devices"]["arm"]
                self.assertEqual(arm["cycle_ns"], 1e6 * cycle_ms if cycle_ms > 1 else 0)
                self.assertEqual(arm["delay_ns"]["most"], 1e6 * (2 * cycle_ms + 1) if cycle_ms > 1 else 0)

    def test_works_on_the_base_if_the_base_can_carry_it(self):
        passed = 0
        for folder in ARMS:
            with self.subTest(arm=folder.name):
                run = takt("run", "scenarios/mobile.json", "--json", "--set", f"/devices/arm/model={folder.name}")
                if run.returncode == 2:
                    self.assertIn("'payload_max_kg' of 'youbot_base'", run.stderr)
                    continue
                self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
                passed += 1
        self.assertGreaterEqual(passed, 2)

    def test_waves_through_a_wire_with_faults(self):
        for backend in ("arm=slow:8ms", "arm=slow:4ms,drift=-100ppm,loss=1%,repeat=1%,reorder=1%", "arm=slow:100ms"):
            with self.subTest(backend=backend):
                run = takt("run", "scenarios/wave.json", "--json", "--backend", backend)
                self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_forward_kinematics_is_that_of_a_second_reader(self):
        random.seed(2)
        for folder in ARMS:
            device, robot = files.device_of(folder), files.urdf_of(folder)
            limits = [j.find("limit") for j in files.movable(robot, device)]
            for _ in range(5):
                q = [random.uniform(float(limit.get("lower")), float(limit.get("upper"))) for limit in limits]
                with self.subTest(arm=folder.name, q=q):
                    answer = json.loads(takt("model", folder.name, "--json", f"--fk={listed(q)}").stdout)
                    for row_e, row_a in zip(files.forward(robot, device, q), answer["pose"]):
                        for expected, actual in zip(row_e, row_a):
                            self.assertAlmostEqual(expected, actual, delta=1e-9)
                    masses = [float(m.get("value")) for m in robot.iterfind("link/inertial/mass")]
                    self.assertAlmostEqual(answer["mass"], sum(masses), places=9)

    def test_inverse_kinematics_leads_back(self):
        """A pose a hand's width below home, flange still down (half a turn about y): every answer gives that pose."""
        for folder in ARMS:
            with self.subTest(arm=folder.name):
                device, robot = files.device_of(folder), files.urdf_of(folder)
                home = files.forward(robot, device, device["home_rad"])
                goal = (home[0][3], home[1][3], home[2][3] - 0.1)
                answer = json.loads(takt("model", folder.name, "--json", f"--ik={listed((*goal, 0, 0, 1, 0))}").stdout)
                solutions = answer["solutions"]
                self.assertGreater(len(solutions), 0)
                for q in solutions:
                    pose = files.forward(robot, device, q)
                    self.assertLess(math.dist(goal, [pose[i][3] for i in range(3)]), 1e-6)
                    for row, expected in zip(pose, ((-1, 0, 0), (0, 1, 0), (0, 0, -1))):
                        self.assertLess(math.dist(row[:3], expected), 1e-6)


if __name__ == "__main__":
    unittest.main()
