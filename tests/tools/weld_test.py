#!/usr/bin/env python3
"""A seam in a simulated cell, with what may come between: faults of the torch and of its input, pauses, cancels.

Usage: weld_test.py TAKT
"""
import json
import pathlib
import subprocess
import sys
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = ROOT / "scenarios/weld.json"
OFF = [{"name": f"{signal} is off", "kind": "signal", "signal": f"torch/{signal}", "is": False}
       for signal in ("gas", "arc", "wire", "established")]
LIMITS = {"kind": "limits"}


def seam(**more):
    return {"kind": "seam", "object": "workpiece", "line": "edge", "within_m": 0.003, **more}


def run(*sets, expectations=()):
    short = (("/program/steps/2", {"do": "wait", "seconds": 0.1}), ("/program/steps/3", {"do": "wait", "name": "home", "seconds": 0.1}),
             ("/expectations", [*OFF, LIMITS, *expectations]))
    arguments = [f"--set={pointer}={json.dumps(value)}" for pointer, value in (*short, *sets)]
    done = subprocess.run([str(TAKT), "run", str(SCENARIO), "--json", "--log", "none", *arguments], capture_output=True, text=True,
                          timeout=300, cwd=ROOT)
    return done.returncode, json.loads(done.stdout)


def errors(report):
    return [(one["code"], one["pointer"]) for one in report["diagnostics"] if one["severity"] == "error"]


def missed(report):
    return [one["name"] for one in report["expectations"] if not one["passed"]]


class Weld(unittest.TestCase):
    def fails(self, fault, code, pointer):
        """The step fails; and where the program goes on after that, everything is off and within the limits."""
        faults = ("/faults", [fault])
        status, report = run(faults)
        self.assertEqual((status, errors(report)), (3, [(code, pointer)]))
        weld = json.loads(SCENARIO.read_text())["program"]["steps"][1]
        status, report = run(faults, ("/program/steps/1", {"do": "try", "steps": [weld], "on_error": {"steps": []}}))
        self.assertEqual((status, missed(report)), (0, []), report["diagnostics"])

    def test_no_ignition_fails_the_step_with_everything_off(self):
        self.fails({"do": "torch", "fault": "no_ignition", "at_s": 1, "seconds": 60}, "condition-not-met",
                   "/program/steps/1/ignition_timeout_s")

    def test_a_lost_arc_fails_the_step_with_everything_off(self):
        self.fails({"do": "torch", "fault": "lost", "at_s": 10, "seconds": 1}, "condition-not-met", "/program/steps/1")

    def test_a_lost_arc_is_lit_again_without_a_gap(self):
        status, report = run(("/faults", [{"do": "torch", "fault": "lost", "at_s": 10, "seconds": 0.5}]),
                             ("/program/steps/1/restarts", 1), expectations=[seam()])
        self.assertEqual((status, missed(report)), (0, []), report["diagnostics"])

    def test_an_input_that_is_silent_is_an_arc_that_is_out(self):
        self.fails({"do": "sensor", "sensor": "torch/established", "fault": "silent", "at_s": 10, "seconds": 0.3}, "sensor-silent",
                   "/program/steps/1/torch")

    def test_a_pause_leaves_no_gap(self):
        status, report = run(("/operator", [{"at_s": 10, "do": "pause"}, {"at_s": 12, "do": "resume"}]), expectations=[seam()])
        self.assertEqual((status, missed(report)), (0, []), report["diagnostics"])

    def test_a_cancel_leaves_the_begin_of_a_seam(self):
        status, report = run(("/operator", [{"at_s": 10, "do": "cancel"}]), expectations=[seam()])
        self.assertEqual(missed(report), ["seam"])
        self.assertEqual(errors(report), [])

    def test_a_torch_that_is_too_far_away_lights_no_arc(self):
        status, report = run(("/program/steps/1/stick_out_m", 0.03))
        self.assertEqual((status, errors(report)), (3, [("condition-not-met", "/program/steps/1/ignition_timeout_s")]))

    def test_bad_lines_and_torches_are_said_at_once(self):
        status, report = run(("/objects/workpiece/lines/edge/points/1/position_m", [0.0305, 0.08, 0.008]),
                             ("/objects/workpiece/lines/bow/points/0/via_m", [0, 0, 0]),
                             ("/program/steps/1/travel_m_s", -1), ("/faults", [{"do": "torch", "fault": "cold", "at_s": 1}]))
        self.assertEqual(status, 2)
        pointers = {pointer for _, pointer in errors(report)}
        self.assertLessEqual({"/objects/workpiece/lines/edge/points/1/position_m", "/objects/workpiece/lines/bow/points/0/via_m"},
                             pointers)


if __name__ == "__main__":
    unittest.main()
