#!/usr/bin/env python3
"""Behaviour trees from outside: what a tree does in a cell, and what is said of a bad one.

Usage: behavior_tree_test.py TAKT
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = json.loads((ROOT / "scenarios/tree.json").read_text())


class Tree(unittest.TestCase):
    def run_tree(self, body, expectations=(), **more):
        """The cell of the scenario with another tree."""
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "tree.xml").write_text(f'<root BTCPP_format="4">\n<BehaviorTree ID="Main">\n{body}\n</BehaviorTree>\n</root>\n')
            scenario = {**SCENARIO, "expectations": list(expectations), **more,
                        "program": {"do": "tree", "name": "tree", "tree": "tree.xml"}}
            scenario.pop("$schema")
            (folder / "s.json").write_text(json.dumps(scenario))
            done = subprocess.run([str(TAKT), "run", str(folder / "s.json"), "--json"], capture_output=True, text=True, timeout=300,
                                  cwd=ROOT)
            return done.returncode, json.loads(done.stdout)

    def test_all_that_is_wrong_is_said_at_once_with_line_and_column(self):
        status, report = self.run_tree('<Sequence>\n<over place="x"/>\n<ovr place="0"/>\n<over plce="0"/>\n<lin to="{goal}"/>\n'
                                       '<Holds condition="force(\'wrst\') > 5[N]"/>\n</Sequence>')
        self.assertEqual(status, 2)
        lines = {(one["code"], one["line"]) for one in report["diagnostics"] if one["severity"] == "error"}
        for expected in (("unknown-name", 5), ("unsupported", 7)):
            self.assertIn(expected, lines)
        self.assertTrue({6, 8} <= {line for _, line in lines}, lines)

    def test_a_value_of_the_wrong_type_is_found_before_anything_moves(self):
        status, report = self.run_tree('<Sequence>\n<over place="x"/>\n</Sequence>')
        self.assertEqual((status, {one["line"] for one in report["diagnostics"] if one["severity"] == "error"}), (2, {4}), report)

    def test_a_leaf_that_is_halted_brakes_before_the_next_one_begins(self):
        body = ('<Sequence><over place="-0.08"/><ForceSuccess><Timeout msec="300"><over place="0.08"/></Timeout></ForceSuccess>'
                '<home/></Sequence>')
        status, report = self.run_tree(body, [{"kind": "limits"}, {"kind": "step", "step": "home"}])
        self.assertEqual(status, 0, report["diagnostics"])

    def test_a_tree_whose_root_fails_fails_the_program(self):
        status, report = self.run_tree("<Sequence><home/><AlwaysFailure/></Sequence>")
        self.assertEqual(status, 3)
        self.assertIn(("condition-not-met", "/program"), [(one["code"], one["pointer"]) for one in report["diagnostics"]])

    def test_conditions_over_sensors_and_operations_are_leaves(self):
        body = ('<Sequence><over place="0.08"/><tare/><Fallback><Holds condition="force(\'wrist\') > 3[N]"/>'
                '<lin to=\'{"by_m": [0, 0, -0.02]}\' velocity_m_s="0.05"/></Fallback><wait seconds="0.1"/></Sequence>')
        status, report = self.run_tree(body, [{"kind": "limits"}])
        self.assertEqual(status, 0, report["diagnostics"])


if __name__ == "__main__":
    unittest.main()
