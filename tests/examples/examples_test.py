#!/usr/bin/env python3
"""Projects outside of takt, as their authors see it: an install, find_package(takt), a plug-in that is loaded, used and, if
it was built for another takt, refused.

Usage: examples_test.py BUILD_FOLDER COMPILER CCACHE SANITIZERS; the last two may be empty
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
sys.argv[1:] = []
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
        self.assertEqual(len(report["expectations"]), 3)

    def test_its_findings_are_those_of_its_kind(self):
        broken = takt("run", self.source / "spin_up.json", "--plugin", self.plugin, "--models", self.source / "models",
                      "--set", "/devices/cooler/settings/speed_rad_s=4000", "--set", "/devices/cooler/settings/colour=1")
        self.assertEqual(broken.returncode, 2)
        self.assertIn("/devices/cooler/settings/speed_rad_s", broken.stderr)
        self.assertIn("/devices/cooler/settings/colour", broken.stderr)

    def test_without_it_the_kind_is_unknown(self):
        refused = takt("run", self.source / "spin_up.json", "--models", self.source / "models")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("is of kind 'fan', which is no device of a cell", refused.stderr)

    def test_twice_is_refused(self):
        refused = takt("list", "--plugin", self.plugin, "--plugin", self.plugin)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("a plug-in 'fan' is loaded already", refused.stderr)

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
        self.assertIn(f"fan.so: error: is built for takt {theirs}; this is takt {ours}", refused.stderr)
        self.assertEqual(json.loads(refused.stdout)["result"], "error")


if __name__ == "__main__":
    unittest.main(verbosity=2)
