#!/usr/bin/env python3
"""Benchmarks of assembly: a few seeds of each hold, and what cannot succeed ends by itself with a reason.

usage: assembly_test.py TAKT
"""
import json
import pathlib
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PEG_INSERT = ROOT / "scenarios/benchmarks/peg_insert.json"
NUT_THREAD = ROOT / "scenarios/benchmarks/nut_thread.json"
TAKT = ""


def takt(*arguments):
    """@return exit status and the report"""
    done = subprocess.run([TAKT, *map(str, arguments), "--json"], capture_output=True, text=True, timeout=300)
    return done.returncode, json.loads(done.stdout)


class PegInsert(unittest.TestCase):
    def test_seeds(self):
        status, report = takt("verify", PEG_INSERT, "--seeds", 6)
        self.assertEqual((status, report["passed"]), (0, 6), report["expectations"])
        low, high = report["interval_95"]
        self.assertAlmostEqual(low, 0.6097, places=3)  # Wilson, 6 of 6
        self.assertEqual(high, 1.0)
        self.assertEqual(len({one["digest"] for one in report["variations"]}), 6, "each seed is another episode")

    def ends_with_a_reason(self, *changes):
        options = [one for change in changes for one in ("--set", change)]
        status, report = takt("run", PEG_INSERT, "--seed", 3, *options)
        self.assertEqual((status, report["result"]), (3, "error"))
        self.assertEqual([one["code"] for one in report["diagnostics"] if one["severity"] == "error"], ["raised"])
        self.assertFalse(report["expectations"][0]["passed"])
        self.assertLess(report["sim_time"], 25)

    def test_a_hole_that_is_too_narrow(self):
        self.ends_with_a_reason("/objects/block/bores/0/radius_m=0.0039")

    def test_a_part_that_is_not_there(self):
        self.ends_with_a_reason("/objects/block/at/position_m=[0.3,0.3,-0.1]")

    def test_noise_beyond_the_search(self):
        self.ends_with_a_reason("/objects/block/at/position_m=[0.012,0.012,-0.1]")

    def test_a_size_that_is_none_is_refused(self):
        status, report = takt("run", PEG_INSERT, "--set", "/objects/block/bores/0/radius_m=-0.004")
        self.assertEqual((status, report["diagnostics"][0]["pointer"]), (2, "/objects/block/bores/0/radius_m"))


class NutThread(unittest.TestCase):
    def test_seeds(self):
        status, report = takt("verify", NUT_THREAD, "--seeds", 2)
        self.assertEqual((status, report["passed"]), (0, 2), report["expectations"])

    def ends_with(self, code, change):
        status, report = takt("run", NUT_THREAD, "--seed", 3, "--set", change)
        self.assertEqual((status, report["result"]), (3, "error"))
        self.assertEqual([one["code"] for one in report["diagnostics"] if one["severity"] == "error"], [code])
        self.assertFalse(report["expectations"][0]["passed"])
        self.assertLess(report["sim_time"], 25)

    def test_a_thread_that_does_not_fit(self):
        self.ends_with("condition-not-met", '/objects/nut/parts/0/bores/0/thread="M8"')

    def test_a_bolt_that_is_not_there(self):
        self.ends_with("condition-not-met", "/objects/bolt/at/position_m=[0.3,0.3,0]")

    def test_noise_beyond_the_search(self):
        self.ends_with("raised", "/objects/bolt/at/position_m=[0.013,0.013,0]")

    def test_a_length_that_is_none_is_refused(self):
        status, report = takt("run", NUT_THREAD, "--set", "/objects/bolt/screw/length_m=-0.02")
        self.assertEqual((status, report["diagnostics"][0]["pointer"]), (2, "/objects/bolt/screw/length_m"))


if __name__ == "__main__":
    TAKT = sys.argv.pop(1)
    unittest.main()
