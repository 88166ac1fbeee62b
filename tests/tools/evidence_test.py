#!/usr/bin/env python3
"""What a run shows and keeps, from outside: the log, recordings that stand alone, tables, recovery, JUnit, interruptions.

Usage: evidence_test.py TAKT
"""
import copy
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]

SHORT = {
    "devices": {"left arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
                "wrist": {"model": "ft_gamma", "on": "left arm"}, "probe": {"model": "probe_ball", "on": "wrist"}},
    "objects": {"block": {"shape": "box", "size_m": [0.4, 0.4, 0.2], "at": {"position_m": [0.55, 0, 0.1]}}},
    "cameras": {"c": {"at": {"position_m": [1.6, -1.3, 1.0]}, "look_at": {"position_m": [0.4, 0, 0.3]}}},
    "program": {"do": "sequence", "name": "main", "steps": [
        {"do": "ptp", "name": "above", "to": {"in": "block", "position_m": [0, 0, 0.12], "rpy_deg": [180, 0, 0]}},
        {"do": "tare"},
        {"do": "lin", "name": "touch", "to": {"by_m": [0, 0, -0.04]}, "velocity_m_s": 0.02,
         "until": {"sensor": "wrist", "above_N": 5}},
        {"do": "log", "text": "touched"},
        {"do": "lin", "name": "away", "to": {"by_m": [0, 0, 0.02]}}]},
    "expectations": [{"kind": "event", "source": "left arm", "event": "touch", "times": 1},
                     {"name": "soft", "kind": "value", "value": "$force('wrist')", "during": "touch", "at_most": 100}],
}


def takt(*arguments, env=None, timeout=300):
    return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=timeout, cwd=ROOT,
                          env={**os.environ, **(env or {})})


class WithFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def write(self, document, name="short.json"):
        file = self.path / name
        file.write_text(json.dumps(document))
        return file

    def good(self, *arguments, status=0, env=None):
        run = takt(*arguments, env=env)
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        return run

    def recorded(self, document=None, name="a.mcap", *options):
        record = self.path / name
        run = self.good("run", self.write(document or SHORT), "--record", record, "--json", *options)
        return record, json.loads(run.stdout)


class Log(WithFolder):
    def test_a_run_tells_its_story_everywhere_alike(self):
        record, report = self.recorded()
        events = json.loads(self.good("events", record, "--json").stdout)["events"]
        self.assertEqual(events, sorted(report["events"], key=lambda one: one["time_s"]))
        names = {(one["source"], one["name"]) for one in events}
        for wanted in (("program", "begin"), ("program", "log"), ("contact", "contact"), ("contact", "parted"), ("left arm", "touch")):
            self.assertIn(wanted, names)
        text = self.good("events", record, "--level", "info").stdout
        self.assertIn("touched", text)
        self.assertIn("[main / touch]", text)
        self.assertNotIn("begin", text)
        only = self.good("events", record, "--source", "contact").stdout.splitlines()
        self.assertTrue(only and all(" contact" in line for line in only))

    def test_stderr_tells_as_much_as_is_asked_for(self):
        file = self.write(SHORT)
        self.assertIn("touched", self.good("run", file).stderr)
        self.assertIn("above", self.good("run", file, "--log", "debug").stderr)
        self.assertEqual(self.good("run", file, "--log", "none").stderr, "")
        self.assertIn("[unknown-name]", self.good("run", file, "--log", "loud", status=2).stderr)
        self.assertIn("[unknown-name]", self.good("events", file, "--level", "loud", status=2).stderr)

    def test_a_fault_is_told_with_joint_and_contact(self):
        ram = json.loads(json.dumps(SHORT))
        ram["program"]["steps"][2] = {"do": "lin", "name": "ram", "to": {"by_m": [0, 0, -0.08]}, "velocity_m_s": 0.2,
                                      "until": {"sensor": "wrist", "above_N": 5000}, "on_end": "continue"}
        ram["expectations"] = []
        run = self.good("run", self.write(ram), status=3)
        fault = next(line for line in run.stderr.splitlines() if "error: left arm fault" in line)
        self.assertRegex(fault, r"joint \w+ .*'probe/\w+' pressed 'block' with \d+\.\d N at \d+\.\d+ s.*\[main / ram\]")


class Alone(WithFolder):
    def test_a_recording_needs_nothing_else(self):
        """Models of its own, in a folder that is gone afterwards, on a machine that has no models at all."""
        models = self.path / "models"
        shutil.copytree(ROOT / "models/lwr4plus", models / "my_arm")
        (models / "my_arm/lwr4plus.urdf").rename(models / "my_arm/my_arm.urdf")
        device = json.loads((models / "my_arm/device.json").read_text())
        device.update({"name": "my_arm", "urdf": "my_arm.urdf"})
        (models / "my_arm/device.json").write_text(json.dumps(device))
        own = json.loads(json.dumps(SHORT))
        own["devices"]["left arm"]["model"] = "my_arm"
        a, _ = self.recorded(own, "a.mcap")
        b, _ = self.recorded(own, "b.mcap", "--set", "/program/steps/0/speed=0.6")
        shutil.rmtree(models)
        empty = {"TAKT_ROOT": str(self.path)}
        film = self.path / "film.mp4"
        self.good("render", a, "--video", film, "--size", "160x120", "--fps", 5, env=empty)
        self.assertGreater(film.stat().st_size, 1000)
        difference = json.loads(self.good("compare", a, b, "--json", status=1, env=empty).stdout)["first_difference"]
        self.assertTrue(difference["bit"], "both were run again with the models that they carry")

    def test_topics_have_no_blanks(self):
        record, _ = self.recorded()
        self.good("export", record, "--csv", self.path / "tables")
        self.assertTrue((self.path / "tables/left_arm_joint_states.csv").exists())


class Tables(WithFolder):
    def test_csv_has_what_the_recording_has(self):
        record, report = self.recorded()
        folder = self.path / "tables"
        products = json.loads(self.good("export", record, "--csv", folder, "--json").stdout)["products"]
        self.assertEqual(sorted(products), sorted(str(file) for file in folder.iterdir()))
        with open(folder / "left_arm_set_point.csv", newline="") as file:
            rows = list(csv.reader(file))
        self.assertEqual(len(rows), report["cycles"] + 1)
        self.assertEqual(rows[0][0], "time_s")
        self.assertTrue(all("[rad" in cell for cell in rows[0][1:]), rows[0])
        with open(folder / "left_arm_status.csv", newline="") as file:
            status = list(csv.DictReader(file))
        self.assertEqual({row["phase.name"] for row in status} - {"", "following", "frozen", "not ready"}, set())
        self.assertIn("following", {row["phase.name"] for row in status})
        with open(folder / "program.csv", newline="") as file:
            self.assertIn("main / touch", {row["step"] for row in csv.DictReader(file)})

    def test_a_trajectory_in_the_tum_format(self):
        record, _ = self.recorded()
        out = self.path / "flange.txt"
        self.good("export", record, "--tum", out, "--frame", "left arm/flange")
        for line in out.read_text().splitlines():
            numbers = [float(number) for number in line.split(" ")]
            self.assertEqual(len(numbers), 8)
            self.assertAlmostEqual(sum(q * q for q in numbers[4:]), 1.0, places=9)
        wrong = self.good("export", record, "--tum", out, "--frame", "left arm/flnge", status=2).stderr
        self.assertRegex(wrong, r"left arm/flange.*\[unknown-name\]")

    def test_bad_questions(self):
        record, _ = self.recorded()
        self.assertIn("[missing]", self.good("export", record, status=2).stderr)
        self.assertIn("[requires]", self.good("export", record, "--frame", "x", status=2).stderr)
        self.assertIn("[unknown-name]", self.good("export", record, "--csv", self.path / "t", "--topic", "/none", status=2).stderr)
        self.assertIn("[file-not-writable]", self.good("export", record, "--csv", record / "t", status=2).stderr)


class Recovery(WithFolder):
    def test_a_cut_recording_becomes_whole(self):
        record, _ = self.recorded()
        cut, whole = self.path / "cut.mcap", self.path / "whole.mcap"
        data = record.read_bytes()
        cut.write_bytes(data[:len(data) * 2 // 3])
        answer = json.loads(self.good("recover", cut, whole, "--json").stdout)
        self.assertGreater(answer["messages"], 1000)
        self.assertTrue(answer["lost"])
        compared = json.loads(self.good("compare", cut, whole, "--json").stdout)
        self.assertTrue(compared["identical"])
        self.good("events", whole)
        self.assertIn("[file-not-writable]", self.good("recover", cut, cut, status=2).stderr)
        self.assertIn("[syntax]", self.good("recover", self.write(SHORT), whole, status=2).stderr)


class Golden(WithFolder):
    def blessed(self):
        pick = json.loads((ROOT / "scenarios/pick.json").read_text())
        pick["expectations"] = []
        pick["golden"] = {"tolerances": [{"topic": "/*/gripper", "column": "force", "kind": "report_only"}]}
        file = self.write(pick, "pick.json")
        self.good("bless", file, "--reason", "a test")
        self.good("verify", file)
        return file, pick

    def outside(self, file):
        """Topics of the golden that a run leaves."""
        run = takt("verify", file, "--json")
        self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
        columns = json.loads(run.stdout)["scenarios"][0]["golden"]["columns"]
        return {one["topic"] for one in columns if not one["passed"]}

    def test_a_run_that_is_perturbed_leaves_its_golden(self):
        file, pick = self.blessed()
        golden = json.loads((self.path / "pick.golden.json").read_text())
        topics = {column["topic"] for column in golden["columns"]}
        self.assertNotIn(("/gripper/gripper", "force"), {(one["topic"], one["column"]) for one in golden["columns"]})
        self.assertTrue({"/gripper/gripper", "/signals", "/objects", "/arm/set_point"} <= topics, topics)

        def changed(change):
            document = json.loads(json.dumps(pick))
            change(document, {one["name"]: one for one in document["program"]["steps"]})
            self.write(document, "pick.json")
            return self.outside(file)

        self.assertIn("/objects", changed(lambda all, _: all["objects"]["part"].update(vary={"position_m": [0.003, 0, 0]})))
        self.assertIn("/gripper/gripper", changed(lambda _, step: step["grip"].update(speed_m_s=0.08)))
        self.assertIn("/signals", changed(lambda _, step: step["lamp on"].update(value=False)))
        self.assertIn("/arm/set_point", changed(lambda _, step: step["lift"].update(speed=0.3)))
        self.assertIn("/program", changed(lambda all, _: all["program"]["steps"].insert(3, {"do": "wait", "seconds": 0.1})))


class Verify(WithFolder):
    def test_junit_has_a_case_for_each_expectation(self):
        failing = json.loads(json.dumps(SHORT))
        failing["expectations"][1]["at_most"] = 1
        files = self.write(SHORT, "a.json"), self.write(failing, "b.json"), self.write({"title": "nothing"}, "c.json")
        out = self.path / "junit.xml"
        self.good("verify", *files, "--junit", out, status=2)
        suites = {suite.get("name"): suite for suite in xml.etree.ElementTree.parse(out).getroot()}
        a, b, c = (suites[str(file)] for file in files)
        self.assertEqual((a.get("tests"), a.get("failures"), a.get("errors")), ("3", "0", "0"))
        self.assertEqual((b.get("failures"), b.get("errors")), ("1", "0"))
        self.assertEqual(next(case.get("name") for case in b if case.find("failure") is not None), "soft")
        self.assertEqual(c.get("errors"), "1")

    def test_interruptions_are_tried_at_every_nth_cycle(self):
        file = self.write(SHORT)
        run = json.loads(self.good("verify", file, "--cancel-every", 400, "--abort-every", 800, "--json").stdout)
        tries = run["scenarios"][0]["interruptions"]
        cycles = run["scenarios"][0]["run"]["cycles"]
        self.assertTrue(tries["held"])
        self.assertAlmostEqual(tries["cancels"], cycles / 400, delta=2)
        self.assertAlmostEqual(tries["aborts"], cycles / 800, delta=2)
        self.assertEqual((tries["pauses"], tries["failures"]), (0, []))
        self.assertIn("interruptions", self.good("verify", file, "--pause-every", 1500).stdout)

    def test_faults_are_tried_at_every_nth_cycle(self):
        """A program that gives up, and one that goes on after the fault, which is cancelled."""
        handled = json.loads(json.dumps(SHORT))
        handled["program"] = {"do": "try", "steps": [handled["program"]], "on_error": {"steps": [{"do": "wait", "seconds": 60}]}}
        for document in (SHORT, handled):
            run = json.loads(self.good("verify", self.write(document), "--fault-every", 300, "--json").stdout)["scenarios"][0]
            tries = run["interruptions"]
            self.assertTrue(tries["held"], tries["failures"])
            self.assertAlmostEqual(tries["faults"], run["run"]["cycles"] / 300, delta=2)


    def test_faults_of_all_devices_are_tried_in_turn(self):
        """With an arm and a sensor every fourth fault is the sensor's; a program that needs it fails, and ends in order."""
        tries = json.loads(self.good("verify", self.write(SHORT), "--fault-every", 100, "--json").stdout)["scenarios"][0]["interruptions"]
        self.assertTrue(tries["held"], tries["failures"])
        self.assertGreater(tries["faults"], 15)


class Films(WithFolder):
    """What a film is by its frames; what is in a picture is tested in tests/sim and tests/cell/film."""
    def frames(self, film):
        probe = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-select_streams", "v", "-show_entries",
                                "stream=nb_read_frames", "-of", "default=nw=1:nk=1", str(film)], capture_output=True, text=True)
        return int(probe.stdout)

    def test_any_part_of_a_recording_with_any_camera(self):
        record, report = self.recorded()
        film, again = self.path / "film.mp4", self.path / "again.mp4"
        small = ("--size", "160x120", "--fps", 10)
        part = ("--from", 0.5, "--to", 1.5, "--eye", "2,-1,1.5", "--look-at", "0.4,0,0.3", "--show", "traces,frames")
        answer = json.loads(self.good("render", record, "--video", film, *small, *part, "--jobs", 1, "--json").stdout)
        self.assertAlmostEqual(answer["frames"], 10, delta=1)
        self.assertEqual(self.frames(film), answer["frames"])
        self.good("render", record, "--video", again, *small, *part, "--jobs", 4)
        self.assertEqual(film.read_bytes(), again.read_bytes(), "the film is the same with any number of jobs")
        self.good("render", record, "--video", again, *small, "--from", 0.5, "--to", 1.5, "--camera", "fit")
        self.assertNotEqual(film.read_bytes(), again.read_bytes())
        for options, code in ((("--eye", "1,2,3"), "requires"), (("--eye", "1,1,1", "--look-at", "1,1,1"), "invalid-value"),
                              (("--show", "wires"), "unknown-name"), (("--from", 900), "out-of-range"),
                              (("--from", 1, "--to", 0.5), "out-of-range")):
            self.assertIn(f"[{code}]", self.good("render", record, "--video", film, *small, *options, status=2).stderr, options)

    def test_a_run_is_filmed_in_part(self):
        film = self.path / "film.mp4"
        run = json.loads(self.good("run", self.write(SHORT), "--video", film, "--size", "160x120", "--fps", 10, "--video-from", 0.5,
                                   "--video-to", 1.0, "--camera", "fit", "--show", "commanded", "--json").stdout)
        self.assertEqual(self.frames(film), 6)
        self.assertEqual(run["result"], "passed")
        self.assertIn("[requires]", self.good("run", self.write(SHORT), "--video-to", 1, status=2).stderr)

    def test_a_failed_verify_films_the_seconds_around_the_failure(self):
        failing = json.loads(json.dumps(SHORT))
        failing["expectations"][1]["at_most"] = 1
        file, films = self.write(failing), self.path / "films"
        run = json.loads(self.good("verify", file, "--failures", films, "--json", status=1).stdout)["scenarios"][0]
        self.assertEqual(pathlib.Path(run["film"]).parent, films)
        length = min(3.0, run["run"]["sim_time"]) + 1.0
        self.assertAlmostEqual(self.frames(run["film"]), 25 * length, delta=3)
        cache = {**os.environ, "XDG_CACHE_HOME": str(self.path / "cache")}
        run = json.loads(self.good("verify", file, "--json", status=1, env=cache).stdout)["scenarios"][0]
        self.assertEqual(pathlib.Path(run["film"]).parent, self.path / "cache/takt/failures", "nothing lies in the current folder")
        self.good("verify", file, "--failures", self.path / "none", "--no-film", status=1)
        self.assertFalse((self.path / "none").exists())
        self.assertNotIn("film", json.loads(self.good("verify", self.write(SHORT), "--failures", films, "--json").stdout)["scenarios"][0])


class New(WithFolder):
    def test_a_new_scenario_validates_and_passes_at_once(self):
        for arm in ("lwr4plus", "ur5", "tx90"):
            made = json.loads(self.good("new", "scenario", f"first-{arm}", "--arm", arm, "--out", self.path, "--json").stdout)
            self.assertEqual(takt("validate", made["file"]).stderr, "", arm)
            report = json.loads(self.good("run", made["file"], "--json").stdout)
            self.assertEqual(report["result"], "passed", report["expectations"])
            text = pathlib.Path(made["file"]).read_text()
            self.assertNotRegex(text, r"\.\d{7,}", "numbers as a person writes them")
            self.assertNotRegex(text, r"\n\s*-?\d", "vectors on one line")
            self.assertTrue((pathlib.Path(made["file"]).parent / json.loads(text)["$schema"]).is_file())
        self.good("new", "scenario", "first", "--out", self.path / "not" / "there")
        self.assertIn("[file-not-writable]", self.good("new", "scenario", "first-ur5", "--out", self.path, status=2).stderr)
        self.assertIn("[invalid-name]", self.good("new", "scenario", "a/b", "--out", self.path, status=2).stderr)
        self.assertRegex(self.good("new", "scenario", "c", "--arm", "ur6", "--out", self.path, status=2).stderr, "ur5.*unknown-name")
        self.assertIn("[missing]", self.good("new", "robot", "c", "--out", self.path, status=2).stderr)

    def test_a_new_tool_touches_at_once(self):
        made = json.loads(self.good("new", "tool", "pin", "--out", self.path, "--length", 0.11, "--mass", 0.2, "--json").stdout)
        self.assertEqual(self.good("validate", made["folder"]).stderr, "")
        figures = json.loads(self.good("model", "pin", "--models", self.path, "--json").stdout)
        self.assertAlmostEqual(figures["mass"], 0.2)
        touching = json.loads(json.dumps(SHORT))
        touching["devices"]["probe"]["model"] = "pin"
        self.recorded(touching, "a.mcap", "--set", "/expectations=[]", "--models", self.path)
        self.assertIn("[duplicate]", self.good("new", "tool", "pin", "--out", self.path, status=2).stderr)
        self.assertIn("[out-of-range]", self.good("new", "tool", "long", "--length", 9, "--out", self.path, status=2).stderr)

    def test_a_new_gripper_picks_at_once(self):
        for name, options in (("grip", ()), ("large", ("--stroke", 0.2, "--force", 300, "--mass", 1.5, "--length", 0.2))):
            self.good("new", "gripper", name, "--out", self.path, *options)
            self.assertEqual(self.good("validate", self.path / name).stderr, "")
            run = self.good("run", "scenarios/pick.json", "--models", self.path, "--set", f"/devices/gripper/model={name}", "--json")
            self.assertEqual(json.loads(run.stdout)["result"], "passed")


class Resimulation(WithFolder):
    """The commands of a recording, carried out again."""

    def test_the_same_commands_give_the_same_states_to_the_bit(self):
        record, report = self.recorded()
        again = json.loads(self.good("run", "--resim", record, "--json").stdout)
        self.assertEqual((again["result"], again["cycles"]), ("passed", report["cycles"]))
        self.assertGreater(again["columns"], 30)
        differing = [one for one in again["comparison"]["columns"]
                     if one["max_difference"] != 0.0 and not one["column"].startswith("wanted_")]
        self.assertEqual(differing, [])

    def test_modes_grippers_outputs_and_brakes_are_commands_too(self):
        compliant = copy.deepcopy(SHORT)
        compliant["program"]["steps"] = [
            {"do": "control_mode", "mode": "cartesian_impedance"},
            {"do": "hold", "seconds": 0.5, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": [500, 800, 2000]}},
            {"do": "control_mode", "mode": "position"}, {"do": "lin", "to": {"by_m": [0, 0, 0.05]}}]
        compliant["faults"] = [{"do": "push", "body": "left arm/link7", "force_N": [0, 20, 0], "at_s": 0.4, "seconds": 0.2}]
        compliant["expectations"] = []
        stopped = {**SHORT, "faults": [{"do": "emergency_stop", "category": 0, "at_s": 0.5}], "expectations": []}
        pick = json.loads((ROOT / "scenarios/pick.json").read_text())
        pick.pop("$schema")
        for name, document, status in (("compliant", compliant, 0), ("stopped", stopped, 3), ("pick", pick, 0)):
            with self.subTest(name):
                record = self.path / f"{name}.mcap"
                self.good("run", self.write(document, f"{name}.json"), "--record", record, status=status)
                again = json.loads(self.good("run", "--resim", record, "--json").stdout)
                differing = [(one["topic"], one["column"]) for one in again["comparison"]["columns"]
                             if one["max_difference"] != 0.0 and not one["column"].startswith("wanted_")]
                self.assertEqual(differing, [])

    def test_another_plant_is_seen(self):
        record, _ = self.recorded()
        run = self.good("run", "--resim", record, "--set", "/plant_mass_scale=1.3", "--json", "--report", self.path / "r.html", status=1)
        failed = {one["topic"] for one in json.loads(run.stdout)["comparison"]["columns"] if not one["passed"]}
        self.assertIn("/left_arm/joint_states", failed)
        self.assertIn("<svg", (self.path / "r.html").read_text())

    def test_it_is_recorded_as_any_run_and_can_be_carried_out_again(self):
        record, _ = self.recorded()
        self.good("run", "--resim", record, "--record", self.path / "b.mcap")
        again = json.loads(self.good("run", "--resim", self.path / "b.mcap", "--json").stdout)
        self.assertEqual(again["result"], "passed")

    def test_what_cannot_be_carried_out_again_is_refused(self):
        record, _ = self.recorded()
        self.assertIn("[conflict]", self.good("run", self.path / "short.json", "--resim", record, status=2).stderr)
        self.assertIn("[conflict]", self.good("run", "--resim", record, "--step", status=2).stderr)
        self.good("run", status=2)
        document = {**SHORT, "expectations": [{"kind": "duration", "below_s": 0.1}]}
        last = self.path / "last.mcap"
        self.good("run", self.write(document), "--record", last, "--record-last", "0.5", status=1)
        self.assertIn("[incompatible]", self.good("run", "--resim", last, status=2).stderr)


class Replay(WithFolder):
    """A recorded run again, in any cycle."""

    def talk(self, record, *lines):
        run = subprocess.run([str(TAKT), "replay", str(record), "--interactive", "--every", "300"], input="\n".join(lines) + "\nq\n",
                             capture_output=True, text=True, timeout=300, cwd=ROOT)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stdout

    def test_it_is_the_recorded_run(self):
        record, report = self.recorded()
        end = json.loads(self.good("replay", record, "--json").stdout)
        self.assertEqual((end["result"], end["cycles"], end["end"]["ended"]), ("passed", report["cycles"], "passed"))

    def test_a_cycle_shows_the_same_whichever_way_one_comes_to_it(self):
        record, _ = self.recorded()
        first = self.talk(record, "cycle 900", "ports *")
        there_and_back = self.talk(record, "cycle 1500", "ports *", "back 1200", "next 3", "cycle 900", "ports *")
        values = [line for line in first.splitlines() if " = " in line]
        self.assertGreater(len(values), 100)
        self.assertEqual([line for line in there_and_back.splitlines() if " = " in line][-len(values):], values)

    def test_what_goes_on_from_a_snapshot_ends_as_recorded(self):
        record, _ = self.recorded()
        told = self.talk(record, "cycle 950", "ports *", "end", "cycle 301", "end")
        ends = [line for line in told.splitlines() if "the run has ended" in line]
        self.assertEqual(ends, ["  the run has ended: passed"] * 2)
        self.assertNotIn("not as recorded", told)

    def test_ports_are_those_that_the_recording_has(self):
        record, _ = self.recorded()
        folder = self.path / "csv"
        self.good("export", record, "--csv", folder)
        with open(next(folder.glob("*set_point*")), newline="") as file:
            rows = list(csv.DictReader(file))
        row = min(rows, key=lambda one: abs(float(one["time_s"]) - 0.5))
        at = json.loads(self.good("replay", record, "--at", "0.5", "--ports", "*", "--json").stdout)["at"]
        self.assertEqual(at["cycle"], 500)
        sent = {float(row[name]) for name in row if name.endswith("position [rad]")}
        self.assertGreater(len(sent), 5)
        arm = next(block for block in at["blocks"] if block["name"] == "device 'left arm'")
        self.assertEqual(sent - set(arm["values"].values()), set())

    def test_a_cancel_is_traced_back_to_the_sample(self):
        record, report = self.recorded()
        touch = next(one for one in report["events"] if one["source"] == "left arm" and one["name"] == "touch")
        cancels = json.loads(self.good("replay", record, "--why", "--json").stdout)["end"]["cancels"]

        def changes(change):
            yield change
            for one in change["from"]:
                yield from changes(one)

        found = [one for one in cancels if one["net"] == "touch" and any("wrist" in change["port"] and change["source"] for change in changes(one["change"]))]
        self.assertEqual(len(found), 1, "one motion was cancelled by the sensor")
        # It fires before the arm has come to rest, which the program tells.
        self.assertIn(touch["cycle"] - found[0]["change"]["cycle"], range(0, 200))
        self.assertEqual((found[0]["change"]["before"], found[0]["change"]["after"]), ("false", "true"))

    def test_a_program_that_was_entered_at_a_step_is_entered_there_again(self):
        record, report = self.recorded({**SHORT, "expectations": []}, "from.mcap", "--from", "away")
        end = json.loads(self.good("replay", record, "--json").stdout)
        self.assertEqual((end["result"], end["cycles"]), ("passed", report["cycles"]))
        self.assertNotIn("above", self.talk(record, "end"))
        whole, _ = self.recorded()
        self.assertNotEqual(json.loads(self.good("replay", whole, "--json").stdout)["cycles"], report["cycles"])

    def test_another_run_is_told_from_its_first_cycle_on(self):
        record, _ = self.recorded(None, "slow.mcap", "--backend", "left arm=slow:8ms")  # which is in no recording
        end = json.loads(self.good("replay", record, "--json", status=1).stdout)["end"]
        self.assertFalse(end["digest_equal"])
        self.assertLess(end["first_difference"], 100)

    def test_bad_questions(self):
        self.good("replay", self.path / "none.mcap", status=2)
        record, _ = self.recorded()
        self.assertIn("[conflict]", self.good("replay", record, "--interactive", "--why", status=2).stderr)


class Verdicts(WithFolder):
    def test_the_recording_has_what_became_of_the_expectations(self):
        document = {**SHORT, "expectations": [*SHORT["expectations"], {"name": "too short", "kind": "duration", "below_s": 0.1}]}
        record = self.path / "a.mcap"
        report = json.loads(self.good("run", self.write(document), "--record", record, "--json", status=1).stdout)
        events = json.loads(self.good("events", record, "--source", "expectation", "--json").stdout)["events"]
        self.assertEqual([one["name"] == "held" for one in events], [one["passed"] for one in report["expectations"]])
        for event, one in zip(events, report["expectations"]):
            self.assertEqual(event["text"], f"{one['name']}: {one['measured']}")


class LastSeconds(WithFolder):
    def test_they_are_kept_if_something_goes_wrong(self):
        record = self.path / "last.mcap"
        self.good("run", self.write(SHORT), "--record", record, "--record-last", 1)
        self.assertFalse(record.exists(), "nothing went wrong")
        failing = json.loads(json.dumps(SHORT))
        failing["expectations"][1]["at_most"] = 1
        report = json.loads(self.good("run", self.write(failing), "--record", record, "--record-last", 1, "--json", status=1).stdout)
        self.assertEqual(report["products"], [str(record)])
        self.good("export", record, "--csv", self.path / "tables")
        with open(self.path / "tables/left_arm_set_point.csv", newline="") as file:
            times = [float(row[0]) for row in list(csv.reader(file))[1:]]
        self.assertAlmostEqual(times[-1], report["sim_time"], delta=0.002)
        self.assertTrue(1.0 <= times[-1] - times[0] < 1.3, times[-1] - times[0])
        self.assertIn("[requires]", self.good("run", self.write(SHORT), "--record-last", 1, status=2).stderr)

    def test_the_site_file_is_in_the_recording(self):
        site = self.path / "site.json"
        site.write_text(json.dumps({"devices": {"left arm": {"backend": "slow", "cycle_ms": 8}}}))
        record = self.path / "a.mcap"
        run = takt("run", self.write(SHORT), "--site", site, "--record", record, "--set", "/expectations=[]")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn(site.read_bytes(), record.read_bytes(), "attachments are not compressed")


class Compared(WithFolder):
    def test_the_report_has_both_films(self):
        a, _ = self.recorded(name="a.mcap")
        b, _ = self.recorded(None, "b.mcap", "--set", "/program/steps/0/speed=0.6")
        page = self.path / "report.html"
        self.good("compare", a, b, "--quick", "--films", "--report", page, status=1)
        text = page.read_text()
        self.assertEqual(text.count("<video"), 2)
        self.assertIn(">touch<", text.replace("<title>", "<"), "steps are on the axis")
        self.assertLess(len(text), 1 << 20)
        columns = {one["column"] for one in json.loads(self.good("compare", a, b, "--quick", "--json", status=1).stdout)["columns"]}
        self.assertIn("left arm/flange.rotation", columns)
        self.assertFalse({one for one in columns if one.endswith(".qw")})
        self.assertIn("[requires]", self.good("compare", a, b, "--films", status=2).stderr)


if __name__ == "__main__":
    unittest.main()
