#!/usr/bin/env python3
"""Projects outside of takt, as their authors see it: an install, find_package(takt), a plug-in that is loaded, used and, if
it was built for another takt, refused.

Usage: examples_test.py BUILD_FOLDER COMPILER CCACHE SANITIZERS [EVERY [TESTS]]; the last two may be empty. The programs of the
course are cancelled, paused and aborted at every so many cycles; without EVERY three times each.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
COMPILER, CCACHE, SANITIZE = sys.argv[2:5]
EVERY = int(sys.argv[5]) if len(sys.argv) > 5 else None
sys.argv[1:] = sys.argv[6:]
# One place for each build folder, so that the compiler cache knows the files again.
SCRATCH = BUILD / "tests/examples/scratch"
PREFIX = SCRATCH / "prefix"


def call(*arguments, check=True):
    done = subprocess.run([str(one) for one in arguments], capture_output=True, text=True)
    if check and done.returncode != 0:
        raise AssertionError(f"{arguments}: {done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done


def build(source, name, flags=""):
    """Configures and builds a project against the install; returns its build folder."""
    folder = SCRATCH / name
    launcher = [f"-DCMAKE_CXX_COMPILER_LAUNCHER={CCACHE}"] if CCACHE else []
    if SANITIZE:  # a plug-in has to be built as takt is
        flags += f" -fsanitize={SANITIZE}"
    call("cmake", "-G", "Ninja", "-S", source, "-B", folder, f"-DCMAKE_PREFIX_PATH={PREFIX}",
         f"-DCMAKE_CXX_COMPILER={COMPILER}", "-DCMAKE_BUILD_TYPE=Debug", f"-DCMAKE_CXX_FLAGS={flags}", *launcher)
    call("cmake", "--build", folder)
    return folder


def takt(*arguments):
    return call(PREFIX / "bin/takt", *arguments, check=False)


def setUpModule():
    shutil.rmtree(SCRATCH, ignore_errors=True)
    call("cmake", "--install", BUILD, "--prefix", PREFIX)
    for variable in ("TAKT_ROOT", "LD_LIBRARY_PATH"):
        os.environ.pop(variable, None)


class Install(unittest.TestCase):
    def test_the_program_finds_its_data(self):
        self.assertIn("lwr4plus", takt("list").stdout)
        run = takt("run", PREFIX / "share/takt/scenarios/wave.json", "--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(json.loads(run.stdout)["result"], "passed")

    def test_no_path_of_the_build_is_left_in_it(self):
        for file in (PREFIX / "lib/cmake/takt").iterdir():
            text = file.read_text()
            self.assertNotIn(str(BUILD) + "/", text.replace(str(PREFIX), ""), file)
            self.assertNotIn(str(ROOT / "core"), text, file)

    def test_a_program_of_its_own_runs_a_net(self):
        folder = build(ROOT / "examples/library", "library")
        self.assertEqual(call(folder / "count").stdout, "3 seconds are 3000 cycles\n")


class Activities(unittest.TestCase):
    """The course examples/activities, built once, each program run as its reader runs it."""

    SOURCE = ROOT / "examples/activities"
    CPP_ONLY = {"11_welding"}  # it makes an interface of its own for a composed device, which Python does not have

    @classmethod
    def setUpClass(cls):
        cls.folder = build(cls.SOURCE, "activities")
        cls.reports = {}

    @classmethod
    def programs(cls):
        return sorted(file.stem for file in cls.SOURCE.glob("[0-9]*.cc"))

    def start(self, program, *arguments):
        done = call(self.folder / program, "--json", *arguments, check=False)
        self.assertTrue(done.stdout, f"{program} {arguments}: {done.stderr[-2000:]}")
        return done.returncode, json.loads(done.stdout)

    def report(self, program):
        """Of the run as it stands; it must hold."""
        if program not in self.reports:
            status, report = self.start(program)
            failed = [one for one in report["expectations"] if not one["passed"]]
            self.assertEqual((status, report["result"]), (0, "passed"), f"{program}: {failed} {report['diagnostics']}")
            self.reports[program] = report
        return self.reports[program]

    def test_each_program_does_what_it_says(self):
        self.assertGreaterEqual(len(self.programs()), 10)
        for program in self.programs():
            with self.subTest(program):
                report = self.report(program)
                self.assertGreaterEqual(len(report["expectations"]), 3)
                self.assertEqual(report["diagnostics"], [])

    def test_python_has_the_same_bits(self):
        """examples/python: the same programs, each with the digest of its twin."""
        python = {**os.environ, "PYTHONPATH": str(BUILD / "python")}
        self.assertEqual(set(self.programs()) - {file.stem for file in (ROOT / "examples/python").glob("[0-9]*.py")}, self.CPP_ONLY)
        for program in sorted(set(self.programs()) - self.CPP_ONLY):
            with self.subTest(program):
                done = subprocess.run([ROOT / "build/venv/bin/python3", "-B", ROOT / f"examples/python/{program}.py", "--json"],
                                      capture_output=True, text=True, env=python)
                self.assertTrue(done.stdout, done.stderr[-2000:])
                report, twin = json.loads(done.stdout), self.report(program)
                self.assertEqual((report["result"], report["digest"]), (twin["result"], twin["digest"]))

    def test_pick_and_place_is_short(self):
        text = (self.SOURCE / "02_pick_and_place.cc").read_text()
        lines = [line for line in text.split("\n") if line.strip() and not line.strip().startswith("//")]
        self.assertLess(len(lines), 25)

    def test_o7_each_event_brakes_when_the_certificate_says(self):
        events = {program: [one for one in self.report(program)["reactions"] if one["event_cycle"] >= 0]
                  for program in self.programs()}
        self.assertTrue({"03_screw", "06_start_of_motion", "08_screw_as_command"} <= {program for program in events if events[program]})
        for program, reactions in events.items():
            for one in reactions:
                with self.subTest(program, reaction=one):
                    cycles = one["braking_cycle"] - one["event_cycle"]
                    self.assertGreaterEqual(cycles, one["certified_cycles"]["least"])
                    self.assertLessEqual(cycles, one["certified_cycles"]["most"])

    def test_wrong_use_is_said_with_what_would_be_right(self):
        lines = "\n".join(self.report("09_wrong_use")["lines"])
        for text in ("no arm 'amr' (did you mean 'arm'", "'gripper' has no LinInterface (it offers GrippingInterface)",
                     "a goal: ", "the end of a guarded motion is unknown", "a rule: /both"):
            self.assertIn(text, lines)

    def test_what_is_wrong_with_the_cell_is_refused(self):
        status, report = self.start("01_first_motion", "--set", "/devices/arm/model=lwr4", "--set", "/devices/arm/colour=1")
        self.assertEqual((status, report["result"]), (2, "error"))
        pointers = {one["pointer"] for one in report["diagnostics"]}
        self.assertTrue({"/devices/arm/model", "/devices/arm/colour"} <= pointers, pointers)

    def test_an_install_without_its_data_says_so(self):
        program = self.folder / "01_first_motion"
        done = subprocess.run([str(program)], capture_output=True, text=True, env={**os.environ, "TAKT_ROOT": "/nowhere"})
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"'/nowhere/models' \(Set TAKT_ROOT.* \[not-found\]")
        done = call(program, "nothing.json", check=False)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"nothing.json: error: .* \[not-found\]")

    def test_a_seed_a_film_and_a_recording(self):
        video, recording = SCRATCH / "first.mp4", SCRATCH / "first.mcap"
        status, report = self.start("01_first_motion", "--seed", "7", "--video", video, "--size", "320x240", "--record", recording)
        self.assertEqual(status, 0, report["diagnostics"])
        self.assertEqual(report["products"], [str(recording), str(video)])
        for product in (video, recording):
            self.assertGreater(product.stat().st_size, 1000)

    def test_l6_p2_cancelled_paused_and_stopped_anywhere(self):
        """At every so many cycles, each time in a fork: no limit is broken, the devices come to rest and are free, the program ends
        soon; and the run that is tried is the one that is not."""
        for program in self.programs():
            whole = self.report(program)
            cycles = whole["cycles"]
            stride = EVERY or max(10, cycles // 30 * 10)
            if cycles <= stride:
                continue  # what moves nothing is over at once
            status, report = self.start(program, "--try-interruptions", stride)
            with self.subTest(program):
                tried = report["expectations"][-1]
                print(f"{program}: {tried['measured']}, every {stride} of {cycles} cycles", file=sys.stderr)
                self.assertEqual((status, report["result"], tried["name"]), (0, "passed", "interruptions"), tried)
                self.assertGreaterEqual(int(tried["measured"].split()[0]), 3 * (cycles // stride - 1))
                self.assertEqual(report["digest"], whole["digest"])

    def test_what_cannot_be_tried_is_refused(self):
        status, report = self.start("01_first_motion", "--try-interruptions", "10", "--realtime", "--record", SCRATCH / "no.mcap")
        self.assertEqual((status, report["result"]), (2, "error"))
        self.assertEqual([one["pointer"] for one in report["diagnostics"]], ["--try-interruptions"] * 2)
        self.assertEqual(self.start("01_first_motion", "--try-interruptions", "0")[0], 2)


class Plugin(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.source = ROOT / "examples/plugin"
        cls.plugin = build(cls.source, "plugin") / "fan.so"

    def test_its_primitives_are_known(self):
        shown = takt("primitives", "Smoothstep", "--json", "--plugin", self.plugin)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertIn("Smoothstep", shown.stdout)
        self.assertEqual(takt("primitives", "Smoothstep").returncode, 2)

    def test_its_device_and_primitives_run_a_scenario(self):
        run = takt("run", self.source / "spin_up.json", "--plugin", self.plugin, "--models", self.source / "models", "--json")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        report = json.loads(run.stdout)
        self.assertEqual(report["result"], "passed")
        self.assertEqual(len(report["expectations"]), 4)

    def test_its_fault_happens_and_its_expectation_sees_it(self):
        def run(*faults):
            done = takt("run", self.source / "spin_up.json", "--plugin", self.plugin, "--models", self.source / "models", "--json",
                        "--set", "/faults=" + json.dumps(faults))
            return done.returncode, json.loads(done.stdout)

        status, report = run({"at_s": 1, "do": "blocked_fan", "fan": "cooler"})
        self.assertEqual(status, 1)
        failed = [one["kind"] for one in report["expectations"] if not one["passed"]]
        self.assertIn("fan_speed", failed)
        self.assertNotIn("repeats", failed)
        status, report = run({"at_s": 0.5, "do": "blocked_fan", "fan": "cooler", "seconds": 0.1})
        self.assertEqual((status, report["result"]), (0, "passed"))
        status, report = run({"at_s": 1, "do": "blocked_fan", "fan": "heater", "second": 1}, {"at_s": 1, "do": "blocked"})
        self.assertEqual(status, 2)
        found = {(one["code"], one["pointer"]) for one in report["diagnostics"]}
        self.assertLessEqual({("unknown-name", "/faults/0/fan"), ("unknown-key", "/faults/0/second")}, found)
        self.assertIn("/faults/1/do", [pointer for _, pointer in found])

    def test_its_forms_are_in_the_schema(self):
        printed = takt("schema", "--plugin", self.plugin)
        self.assertEqual(printed.returncode, 0, printed.stderr)
        definitions = json.loads(printed.stdout)["definitions"]
        self.assertIn("blocked_fan", definitions["fault"]["properties"]["do"]["enum"])
        self.assertIn("fan_speed", definitions["expectation"]["properties"]["kind"]["enum"])
        self.assertIn("cage", definitions["object"]["properties"]["shape"]["enum"])
        self.assertIn({"$ref": "#/definitions/fan_settings"}, definitions["device_settings"]["anyOf"])

    def test_its_shape_is_one_of_objects(self):
        def run(cage):
            done = takt("run", self.source / "spin_up.json", "--plugin", self.plugin, "--models", self.source / "models", "--json",
                        "--set", "/objects=" + json.dumps({"cage": {"shape": "cage", "at": {"position_m": [0, 0, 1]}, **cage}}))
            return done.returncode, json.loads(done.stdout)

        sizes = {"radius_m": 0.2, "bar_radius_m": 0.005, "length_m": 0.3}
        status, report = run(sizes)
        self.assertEqual((status, report["result"]), (0, "passed"), report)
        status, report = run({**sizes, "bars": 0, "colour": 1})
        self.assertEqual(status, 2)
        found = {(one["code"], one["pointer"]) for one in report["diagnostics"]}
        self.assertEqual({("out-of-range", "/objects/cage/bars"), ("unknown-key", "/objects/cage/colour")}, found)

    def test_its_diagnostics_are_those_of_its_kind(self):
        broken = takt("run", self.source / "spin_up.json", "--plugin", self.plugin, "--models", self.source / "models",
                      "--set", "/devices/cooler/settings/speed_rad_s=4000", "--set", "/devices/cooler/settings/colour=1")
        self.assertEqual(broken.returncode, 2)
        self.assertIn("/devices/cooler/settings/speed_rad_s", broken.stderr)
        self.assertIn("/devices/cooler/settings/colour", broken.stderr)

    def test_without_it_the_kind_is_unknown(self):
        refused = takt("run", self.source / "spin_up.json", "--models", self.source / "models")
        self.assertEqual(refused.returncode, 2)
        self.assertRegex(refused.stderr, r"'fan'.* \[invalid-value\]")

    def test_twice_is_refused(self):
        refused = takt("list", "--plugin", self.plugin, "--plugin", self.plugin)
        self.assertEqual(refused.returncode, 2)
        self.assertRegex(refused.stderr, r"'fan'.* \[duplicate\]")

    def test_built_for_another_version_it_is_refused(self):
        other = SCRATCH / "other_version/core/base"
        other.mkdir(parents=True)
        version = (PREFIX / "include/takt/core/base/version.h").read_text()
        ours = ".".join(re.findall(r"#define TAKT_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", version))
        (other / "version.h").write_text(re.sub(r"(TAKT_VERSION_MAJOR) \d+", r"\1 7", version))
        folder = build(self.source, "plugin_of_other_version", f"-I{other.parents[1]}")
        refused = takt("list", "--plugin", folder / "fan.so", "--json")
        self.assertEqual(refused.returncode, 2)
        theirs = "7." + ours.split(".", 1)[1]
        self.assertRegex(refused.stderr, rf"fan.so: error: .*{theirs}.*{ours}.* \[incompatible\]")
        self.assertEqual(json.loads(refused.stdout)["result"], "error")


class OperationPlugin(unittest.TestCase):
    """An operation that a plug-in brings: a step, a command of a transaction, in the reference, with diagnostics of its table."""

    @classmethod
    def setUpClass(cls):
        cls.source = ROOT / "examples/operation"
        cls.plugin = build(cls.source, "operation") / "blink.so"

    def test_it_is_an_operation_among_others(self):
        shown = takt("operations", "blink", "--json", "--plugin", self.plugin)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        keys = [one["key"] for one in json.loads(shown.stdout)["operations"][0]["parameters"]]
        self.assertEqual(keys, ["output", "times", "on_s", "off_s"])
        self.assertEqual(takt("operations", "blink").returncode, 2)

    def test_it_runs_as_a_step_and_as_a_command(self):
        run = takt("run", self.source / "blink.json", "--plugin", self.plugin, "--json")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        report = json.loads(run.stdout)
        self.assertEqual((report["result"], len(report["expectations"])), ("passed", 3))

    def test_its_parameters_are_checked(self):
        broken = takt("run", self.source / "blink.json", "--plugin", self.plugin, "--json",
                      "--set", "/program/steps/0/times=0", "--set", "/program/steps/0/on_ms=1")
        self.assertEqual(broken.returncode, 2)
        found = {one["pointer"]: one for one in json.loads(broken.stdout)["diagnostics"]}
        self.assertEqual(found["/program/steps/0/times"]["code"], "out-of-range")
        self.assertEqual(found["/program/steps/0/on_ms"]["code"], "unknown-key")

    def test_without_it_the_step_is_unknown(self):
        refused = takt("run", self.source / "blink.json")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("blink", refused.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
