#!/usr/bin/env python3
"""A suction cup holds what the pressure of the air and the friction of its lip hold, and no more.

Usage: vacuum_test.py TAKT
"""
import json
import pathlib
import subprocess
import sys
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
FILE = ROOT / "scenarios/vacuum.json"
MODEL = json.loads((ROOT / "models/vacuum_cup30/device.json").read_text())
FORCE = MODEL["vacuum_max_Pa"] * MODEL["area_m2"]  # N
WEIGHT = 9.81  # N, of the plate
FRICTION = 0.8  # rubber on steel, models/materials.json

HOLD = {"do": "hold", "name": "hold", "seconds": 2, "abort_if": {"input": "cup/holding", "is": False}}


def run(*sets):
    arguments = [f"--set={pointer}={json.dumps(value)}" for pointer, value in sets]
    done = subprocess.run([str(TAKT), "run", str(FILE), "--json", "--log", "none", *arguments], capture_output=True, text=True,
                          timeout=300, cwd=ROOT)
    return done, json.loads(done.stdout)


def pushed(force):
    """The plate hangs still for two seconds, and is pushed for 0.3 s; only whether it stays counts."""
    return run(("/program/steps/7", HOLD), ("/program/steps/8/on_end", "continue"), ("/expectations", [{"kind": "step", "step": "away"}]),
               ("/faults", [{"do": "push", "body": "plate", "force_N": force, "at_s": 5.2, "seconds": 0.3}]))


class Vacuum(unittest.TestCase):
    def test_the_materials_are_those_of_this_test(self):
        materials = json.loads((ROOT / "models/materials.json").read_text())["materials"]
        self.assertEqual((MODEL["material"], materials["rubber"]["friction"]), ("rubber", FRICTION))

    def test_along_the_axis_it_holds_the_force_of_the_air(self):
        most = FORCE - WEIGHT
        for share, status in ((0.9, 0), (1.1, 3)):
            done, report = pushed([0, 0, -share * most])
            self.assertEqual(done.returncode, status, (share, report["diagnostics"]))

    def test_across_it_holds_the_friction_of_the_lip(self):
        most = FRICTION * (FORCE - WEIGHT)
        for share, status in ((0.85, 0), (1.15, 3)):
            done, report = pushed([share * most, 0, 0])
            self.assertEqual(done.returncode, status, (share, report["diagnostics"]))

    def test_a_lip_over_an_edge_does_not_get_tight(self):
        done, report = run(("/program/steps/0/to/position_m", [0.055, 0, 0.05]))
        self.assertEqual(done.returncode, 3)
        self.assertEqual([(one["code"], one["pointer"]) for one in report["diagnostics"] if one["severity"] == "error"],
                         [("timeout", "/program/steps/4/until")])

    def test_without_suction_nothing_is_held(self):
        done, report = run(("/program/steps/3/value", False))
        self.assertEqual(done.returncode, 3)
        self.assertEqual(report["diagnostics"][0]["pointer"], "/program/steps/4/until")

    def test_what_is_too_heavy_for_the_motion_is_lost(self):
        done, report = run(("/objects/plate/mass_kg", 4))  # 39 N at rest of 42 N: too much once it is accelerated
        self.assertEqual(done.returncode, 3)
        self.assertEqual([one["code"] for one in report["diagnostics"] if one["severity"] == "error"], ["abort-condition"])


if __name__ == "__main__":
    unittest.main()
