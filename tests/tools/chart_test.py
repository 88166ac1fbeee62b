#!/usr/bin/env python3
"""State charts from outside: checked, drawn, tried alone, and as what coordinates a cell.

Usage: chart_test.py TAKT
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = ROOT / "scenarios/charts.json"
HEAD = '<scxml xmlns="http://www.w3.org/2005/07/scxml" xmlns:takt="urn:takt:charts" version="1.0">'


def takt(*arguments):
    done = subprocess.run([str(TAKT), *map(str, arguments), "--json"], capture_output=True, text=True, timeout=300, cwd=ROOT)
    return done.returncode, json.loads(done.stdout), done.stderr


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def file(self, name, text):
        path = pathlib.Path(self.folder.name) / name
        path.write_text(text)
        return path

    def chart(self, inside, name="chart.scxml"):
        return self.file(name, f"{HEAD}\n{inside}\n</scxml>\n")


class Alone(Folder):
    def test_a_chart_runs_on_a_clock_that_jumps(self):
        chart = self.chart('<state id="a"><onentry><send event="late" delay="1500ms"/></onentry>'
                           '<transition event="late" target="b"/></state><final id="b"/>')
        status, said, _ = takt("chart", chart, "--run")
        self.assertEqual((status, said["over"]), (0, True))
        entered = [(one["time_s"], one["text"]) for one in said["trace"] if one["what"] == "entered"]
        self.assertEqual(entered, [(0, "a"), (1.5, "b")])

    def test_events_and_sensors_come_from_a_file(self):
        chart = self.chart('<state id="a"><transition event="go" cond="_event.data.n == 3" target="b"/></state>'
                           '<state id="b"><transition takt:cond="force(\'wrist\') > 5[N]" target="c"/></state><state id="c"/>')
        events = self.file("e.jsonl", '{"time_s": 1, "event": "go", "data": {"n": 3}}\n'
                                      '{"time_s": 2, "sensors": {"force(\'wrist\') > 5[N]": true}}\n')
        status, said, _ = takt("chart", chart, "--events", events)
        self.assertEqual((status, said["states_at_end"]), (0, ["c"]))
        self.assertEqual([one["time_s"] for one in said["trace"] if one["text"] == "c"], [2])

    def test_all_faults_are_said_at_once_with_their_places(self):
        chart = self.chart('<state id="a"><transition event="x" target="nowhere"/></state>\n<state id="a" colour="red"/>')
        events = self.file("e.jsonl", '{"time_s": 2, "event": "x"}\n{"time_s": 1, "event": "y", "sort": 1}\nno json\n')
        status, said, _ = takt("chart", chart, "--events", events)
        self.assertEqual(status, 2)
        found = [(one["code"], pathlib.Path(one["file"]).name, one["line"]) for one in said["diagnostics"]]
        self.assertIn(("unknown-name", "chart.scxml", 2), found)
        self.assertIn(("duplicate", "chart.scxml", 3), found)
        self.assertIn(("unknown-key", "chart.scxml", 3), found)
        self.assertIn(("unknown-key", "e.jsonl", 2), found)
        self.assertIn(("invalid-value", "e.jsonl", 2), found)
        self.assertIn(("syntax", "e.jsonl", 3), found)

    def test_a_script_without_an_end_is_a_fault_of_the_run(self):
        status, said, _ = takt("chart", self.chart('<state id="a"><onentry><script>for(;;);</script></onentry></state>'), "--run")
        self.assertEqual((status, said["result"]), (3, "failed"))

    def test_the_picture_has_every_state(self):
        out = pathlib.Path(self.folder.name) / "chart.svg"
        status, _, _ = takt("chart", ROOT / "scenarios/charts/right.scxml", "--svg", out)
        self.assertEqual(status, 0)
        words = set(re.findall(r"[\w.]+", "".join(xml.etree.ElementTree.parse(out).getroot().itertext())))
        states = re.findall(r'<(?:state|parallel|final) id="(\w+)"', (ROOT / "scenarios/charts/right.scxml").read_text())
        self.assertLessEqual(set(states), words)


class InACell(Folder):
    """Runs the scenario with charts of the test's own in its place."""

    def scenario(self, charts, **changes):
        document = json.loads(SCENARIO.read_text())
        document.pop("$schema")
        document["program"]["charts"] = charts
        document["expectations"] = [{"kind": "duration", "below_s": 30}]
        document.update(changes)
        return self.file("scenario.json", json.dumps(document))

    def run_with(self, inside, **changes):
        self.chart(inside)
        return takt("run", self.scenario({"only": "chart.scxml"}, **changes), "--log", "none")

    def test_two_charts_agree_and_two_runs_are_equal(self):
        digests = set()
        for _ in range(2):
            status, said, errors = takt("run", SCENARIO, "--log", "none")
            self.assertEqual(status, 0, errors)
            digests.add(said["digest"])
        self.assertEqual(len(digests), 1)
        texts = [one["text"] for one in said["events"] if one["source"] == "chart"]
        self.assertIn("left: crossed: 2", texts)
        self.assertLess(texts.index("right: moves"), texts.index("left: crossed: 2"))

    def test_a_failure_comes_back_with_its_code(self):
        status, said, _ = self.run_with(
            '<state id="a"><invoke id="x" type="takt:wait"><param name="until" expr="({sensor: \'none\', above_N: 5})"/></invoke></state>')
        self.assertEqual(status, 2)
        self.assertEqual({pathlib.Path(one["file"]).name for one in said["diagnostics"] if one["severity"] == "error"}, {"chart.scxml"})

    def test_a_program_that_fails_is_an_event(self):
        programs = {"fails": {"steps": [{"do": "fail", "text": "no part"}]}}
        status, said, _ = self.run_with(
            '<state id="a"><invoke id="x" type="takt:fails"/>'
            '<transition event="error.platform.x" cond="_event.data.code == \'condition-not-met\' || _event.data.code" target="b"/>'
            '<transition event="done.invoke.x" target="c"/></state><final id="b"/>'
            '<final id="c"><donedata><param name="failure" expr="\'it was done\'"/></donedata></final>', programs=programs)
        self.assertEqual(status, 0, said["diagnostics"])

    def test_a_final_state_with_a_failure_fails_the_program(self):
        status, said, _ = self.run_with('<final id="a"><donedata><param name="failure" expr="\'no\'"/></donedata></final>')
        self.assertEqual(status, 3)
        self.assertIn("condition-not-met", [one["code"] for one in said["diagnostics"]])

    def test_a_state_that_is_left_cancels_what_it_runs(self):
        status, said, errors = self.run_with(
            '<state id="a"><onentry><send event="enough" delay="300ms"/></onentry>'
            '<invoke id="x" type="takt:left to"><param name="angle" expr="-0.8"/></invoke>'
            '<transition event="enough" target="b"/><transition event="done.invoke.x" target="wrong"/></state>'
            '<state id="b"><invoke id="y" type="takt:left to"><param name="angle" expr="-1.2"/></invoke>'
            '<transition event="done.invoke.y" target="end"/><transition event="error.platform" target="wrong"/></state>'
            '<final id="end"/><final id="wrong"><donedata><param name="failure" expr="\'wrong\'"/></donedata></final>')
        self.assertEqual(status, 0, errors)

    def test_a_guard_over_sensors_is_true_between_the_cycles(self):
        status, said, errors = self.run_with(
            '<state id="a"><transition takt:cond="time() > 0.5[s]" target="b"/></state><final id="b"/>')
        self.assertEqual(status, 0, errors)
        times = [one["time_s"] for one in said["events"] if one["source"] == "chart" and one["text"] == "only: b"]
        self.assertTrue(times and 0.5 <= times[0] < 0.51, times)

    def test_what_is_wrong_is_said_before_anything_moves(self):
        status, said, _ = self.run_with(
            '<state id="a"><invoke type="takt:nothing"/></state>'
            '<state id="b"><invoke type="takt:left to"><param name="angel" expr="1"/></invoke>'
            '<transition takt:cond="force(1) > 2" target="a"/><transition cond="a b" target="a"/>'
            '<transition event="x" target="a"><send event="x" target="#_scxml_nobody"/></transition></state>')
        self.assertEqual(status, 2)
        codes = {one["code"] for one in said["diagnostics"] if one["severity"] == "error"}
        self.assertLessEqual({"unknown-name", "missing", "syntax"}, codes)
        self.assertEqual({pathlib.Path(one["file"]).name for one in said["diagnostics"] if one["severity"] == "error"}, {"chart.scxml"})

    def test_two_charts_that_drive_one_arm_are_a_conflict(self):
        one = '<state id="a"><invoke type="takt:left to"><param name="angle" expr="1"/></invoke></state>'
        self.chart(one)
        self.chart(one, "other.scxml")
        status, said, _ = takt("run", self.scenario({"one": "chart.scxml", "two": "other.scxml"}), "--log", "none")
        self.assertEqual(status, 2)
        self.assertIn("resource-conflict", [each["code"] for each in said["diagnostics"]])


if __name__ == "__main__":
    unittest.main()
