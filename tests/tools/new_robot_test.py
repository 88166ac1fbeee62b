#!/usr/bin/env python3
"""`takt new robot`: URDFs in the manner of others become models that move, without a line of C++; bad ones are refused,
whole, with words. docs/adding-an-arm.md is followed as it stands."""
import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
FOREIGN = ROOT / "tests/tools/foreign"
FILES = {"press_six": "press_support/urdf/press_six.urdf", "cobot": "cobot.urdf", "seven": "seven.urdf",
         "curved": "curved.urdf", "scara": "scara.urdf", "five": "five.urdf"}


def takt(*arguments, cwd=ROOT, timeout=120):
    return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=timeout, cwd=cwd)


class WithFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        self.models = self.path / "models"

    def new(self, name, file, *options):
        return takt("new", "robot", name, "--urdf", file, "--out", self.models, "--json", *options)

    def made(self, name, file=None, *options):
        run = self.new(name, file or FOREIGN / FILES[name], *options)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return json.loads(run.stdout)

    def notes(self, report):
        return {note["key"]: note for note in report["notes"]}


class Foreign(WithFolder):
    def test_every_machine_becomes_a_model_that_waves(self):
        ways = {"press_six": "parallel elbow", "cobot": "three parallel axes", "seven": "seven_joint7 held",
                "curved": "elimination", "scara": "nearest turn", "five": "nearest turn"}
        for name in FILES:
            with self.subTest(machine=name):
                report = self.made(name)
                device = self.models / name / "device.json"
                self.assertEqual(takt("validate", device).returncode, 0)
                figures = json.loads(takt("model", name, "--models", self.models, "--json").stdout)
                self.assertIn(ways[name], figures["inverse_kinematics"])
                self.assertEqual(figures["joints"], report["joints"])
                # Arms of few joints take long ways to turn the tool as near as they can.
                wave = ["run", "scenarios/wave.json", "--models", self.models, "--set", f"/devices/arm/model={name}",
                        "--set", "/expectations/2/below_s=40", "--json"]
                if name == "cobot":  # the waypoints fold it into itself, and the rehearsal says so
                    self.assertIn("collision", {one["code"] for one in json.loads(takt(*wave).stdout)["diagnostics"]})
                    wave += ["--set", '/collisions={"off": "the waypoints were not chosen for this arm"}']
                wave = takt(*wave)
                self.assertEqual(wave.returncode, 0, wave.stdout + wave.stderr)
                self.assertEqual(json.loads(wave.stdout)["result"], "passed")

    def test_what_was_guessed_is_said_and_written_down(self):
        report = self.made("press_six")
        notes = self.notes(report)
        self.assertEqual((report["base"], report["flange"]), ("base_link", "tool0"))
        self.assertIn("no such file", notes["link 'link_2' mesh 'package://press_support/meshes/lost.stl'"]["why"])
        self.assertIn("link 'link_1' mass", notes)
        self.assertIn("joint 'joint_a2' limit effort", notes)
        self.assertNotIn("joint 'joint_a2' limit velocity", notes, "the file has one")
        for key in ("/home_rad", "/limits/jerk_rad_s3", "/limits/cartesian/linear_velocity_m_s", "/payload_max_kg"):
            self.assertIn(f"device.json {key}", notes)
        text = (self.models / "press_six/README.md").read_text()
        for note in report["notes"]:
            self.assertIn(f"| {note['key']} | {note['value']} | {note['why']} |", text)

    def test_meshes_are_found_converted_and_copied(self):
        self.made("press_six")
        folder = self.models / "press_six"
        foot = (folder / "meshes/foot.stl").read_bytes()
        self.assertEqual(len(foot), 84 + 50 * struct.unpack("<I", foot[80:84])[0], "text became binary")
        names = {m.get("filename") for m in xml.etree.ElementTree.parse(folder / "press_six.urdf").iter("mesh")}
        self.assertEqual(names, {"meshes/foot.stl", "meshes/arm.stl"})
        # The forearm's looks are of a format that is not read: its collision box is seen instead.
        link = next(l for l in xml.etree.ElementTree.parse(folder / "press_six.urdf").iter("link")
                    if l.get("name") == "link_3")
        self.assertEqual(link.find("visual/geometry/box").get("size"), "0.5 0.12 0.12")

    def test_packages_may_lie_elsewhere(self):
        far = self.path / "far/urdf"
        shutil.copytree(FOREIGN / "press_support", self.path / "packages/press_support")
        far.mkdir(parents=True)
        shutil.copy(FOREIGN / FILES["press_six"], far / "press.urdf")
        lost = self.made("without", far / "press.urdf")
        self.assertIn("link 'base_link' mesh 'package://press_support/meshes/foot.stl'", self.notes(lost))
        found = self.made("with", far / "press.urdf", "--packages", self.path / "packages")
        self.assertNotIn("link 'base_link' mesh 'package://press_support/meshes/foot.stl'", self.notes(found))

    def test_couplings_and_fingers_are_frozen(self):
        report = self.made("cobot")
        notes = self.notes(report)
        self.assertIn("mimics 'left_finger_joint'", notes["joint 'right_finger_joint'"]["why"])
        self.assertIn("not on the chain", notes["joint 'left_finger_joint'"]["why"])
        self.assertEqual(len(report["joints"]), 6)
        self.assertIn("uniform box", notes["link 'base_link_inertia' inertia"]["value"])

    def test_arms_of_few_joints_reach_places_and_say_how_the_tool_is_turned(self):
        report = self.made("five")
        self.assertEqual((report["flange"], len(report["joints"])), ("l5", 5), "the fingers are no part of the arm")
        check = takt("run", "scenarios/wave.json", "--dry-run", "--models", self.models, "--set",
                     "/devices/arm/model=five")
        self.assertEqual(check.returncode, 0, check.stderr)
        self.assertRegex(check.stderr, r"/program/steps/\d+/to: (note|warning): .*\b5 joints .*[0-9.]+ deg")
        self.made("scara")
        tilted = takt("run", "scenarios/wave.json", "--models", self.models, "--set", "/devices/arm/model=scara", "--set",
                      '/program/steps/0/to={"by_m": [0, 0, -0.02], "by_rpy_deg": [0, 20, 0]}')
        self.assertEqual(tilted.returncode, 2)
        self.assertRegex(tilted.stderr, r"/program/steps/0/to: error: .*\b4 joints .* \[unreachable\]")

    def test_missing_limits_get_slow_ones(self):
        report = self.made("seven")
        notes = self.notes(report)
        self.assertEqual(notes["joint 'seven_joint2' limit velocity"]["value"], "1 rad/s")
        self.assertEqual(notes["joint 'seven_joint2' limit lower"]["value"], "-3.14159 rad")
        figures = json.loads(takt("model", "seven", "--models", self.models, "--json").stdout)
        self.assertIsNone(figures["lower"][0], "an endless joint stays one")
        self.assertEqual(figures["velocity"][1], 1)

    def test_joints_have_the_order_of_the_chain(self):
        """Whatever order the file has them in: it is that of home_rad, limits and --fk."""
        tree = xml.etree.ElementTree.parse(FOREIGN / FILES["cobot"])
        robot = tree.getroot()
        joints = robot.findall("joint")
        for joint in joints:
            robot.remove(joint)
        robot.extend(reversed(joints))
        file = self.path / "backwards.urdf"
        tree.write(file)
        report = self.made("cobot", file)
        figures = json.loads(takt("model", "cobot", "--models", self.models, "--json").stdout)
        self.assertEqual(report["joints"], figures["joints"])

    def test_base_and_flange_may_be_given(self):
        report = self.made("cobot", None, "--base", "base_link", "--flange", "flange", "--title", "A Cobot")
        self.assertEqual(report["flange"], "flange")
        self.assertEqual(json.loads((self.models / "cobot/device.json").read_text())["title"], "A Cobot")
        self.assertNotIn("flange", self.notes(report))

    def test_the_same_file_gives_the_same_model(self):
        first = self.made("seven")
        content = (self.models / "seven/device.json").read_bytes()
        shutil.rmtree(self.models / "seven")
        self.assertEqual(self.made("seven")["notes"], first["notes"])
        self.assertEqual((self.models / "seven/device.json").read_bytes(), content)


class Bad(WithFolder):
    """Nothing is left behind, and the words name what is wrong."""

    def refused(self, file, *words, name="bad", options=()):
        run = self.new(name, file, *options)
        self.assertEqual(run.returncode, 2, run.stdout + run.stderr)
        self.assertEqual(json.loads(run.stdout)["result"], "error")
        for word in words:
            self.assertIn(word, run.stderr)
        self.assertFalse((self.models / name).exists())
        self.assertEqual([p for p in self.models.glob(".*")] if self.models.exists() else [], [])

    def changed(self, old, new, base="curved"):
        text = (FOREIGN / FILES[base]).read_text()
        self.assertIn(old, text)
        file = self.path / "bad.urdf"
        file.write_text(text.replace(old, new, 1))
        return file

    def text(self, content):
        file = self.path / "bad.urdf"
        file.write_text(content)
        return file

    def test_files_that_are_no_urdf(self):
        self.refused(self.path / "none.urdf", "[not-found]")
        self.refused(self.text("<robot"), "line 1")
        self.refused(self.text("<model/>"), "<robot>")
        self.refused(self.text('<robot xmlns:xacro="x"><xacro:include filename="a"/></robot>'), "xacro", "[syntax]")
        self.refused(self.text('<!DOCTYPE x [<!ENTITY a "b">]><robot name="x"/>'), "DOCTYPE")
        self.refused(self.text("<robot name='x'>" + "<a>" * 100_000 + "</a>" * 100_000 + "</robot>"), "line", "[syntax]")
        self.refused(self.text("<robot name='x'>" + "<link name='a'/>" * 200_000 + "</robot>"), "line")

    def test_robots_that_are_none(self):
        self.refused(self.text("<robot name='x'><link name='a'/></robot>"), "[invalid-value]")
        self.refused(self.changed('<parent link="s4"/>', '<parent link="s6"/>'), "[invalid-value]")
        self.refused(self.changed('<child link="s6"/>', '<child link="s5"/>'), "'s5'", "[duplicate]")
        self.refused(self.changed('<child link="s6"/>', '<child link="s7"/>'), "'s7'", "[unknown-name]")
        self.refused(self.changed('xyz="0 -0.41 0"', 'xyz="0 nan 0"'), "nan", "[syntax]")
        self.refused(self.changed('velocity="1.2"', 'velocity="-1.2"'), "-1.2", "[out-of-range]")
        self.refused(self.changed('<joint name="j3" type="revolute">', '<joint name="j3" type="floating">'), "floating", "[unsupported]")
        self.refused(self.changed('axis xyz="0 0 1"', 'axis xyz="0 0 0"'), "[out-of-range]")
        self.refused(self.changed('<mass value="8.4"/>', '<mass value="-8.4"/>', "cobot"), "-8.4 kg", "[out-of-range]")

    def test_all_is_said_at_once(self):
        file = self.changed('velocity="1.2"', 'velocity="-1.2"')
        file.write_text(file.read_text().replace('xyz="0 -0.41 0"', 'xyz="0 nan 0"'))
        self.refused(file, "-1.2", "nan")

    def test_too_few_joints(self):
        text = (FOREIGN / FILES["scara"]).read_text()
        for joint, kind in (("lift", "prismatic"), ("turn", "revolute")):
            text = text.replace(f'<joint name="{joint}" type="{kind}">', f'<joint name="{joint}" type="fixed">')
        self.refused(self.text(text), " 2 ", "3 to 12", "[invalid-value]")

    def test_options(self):
        good = FOREIGN / FILES["curved"]
        self.refused(good, "[invalid-name]", name="Bad-Name")
        self.refused(good, "'tol'", "[unknown-name]", options=("--flange", "tol"))
        self.refused(good, "'s6'", "'s1'", "[invalid-value]", options=("--base", "s6", "--flange", "s1"))
        self.refused(good, "[not-found]", options=("--packages", self.path / "none"))
        self.made("curved")
        run = self.new("curved", good)
        self.assertEqual(run.returncode, 2)
        self.assertIn("[duplicate]", run.stderr)

    def test_meshes_that_cannot_be_used_are_replaced(self):
        def stl(triangles, corner=b"\0" * 50):
            return b" " * 80 + struct.pack("<I", triangles) + corner * triangles
        nan = struct.pack("<12fH", 0, 0, 0, float("nan"), 0, 0, 1, 0, 0, 0, 1, 0, 0)
        for content, word in ((stl(1_000_000), "triangles"), (stl(0), "no triangle"), (b"solid x\nvertex 1 2\n", "vertex"),
                              (b"\0" * 200, "binary STL"), (stl(1, nan), "1e6")):
            (self.path / "part.stl").write_bytes(content)
            file = self.changed('<link name="s2"/>', '<link name="s2"><visual><geometry><mesh filename="part.stl"/>'
                                '</geometry></visual></link>')
            report = self.made("meshes", file)
            self.assertIn(word, self.notes(report)["link 's2' mesh 'part.stl'"]["why"])
            shutil.rmtree(self.models / "meshes")


class ByHand(WithFolder):
    """Bad meshes in a model that somebody wrote by hand: a clear error when it is built."""

    def test_meshes_of_a_model(self):
        shutil.copytree(ROOT / "models/io_block", self.models / "io_block")
        urdf = self.models / "io_block/io_block.urdf"
        urdf.write_text(urdf.read_text().replace('<box size="0.15 0.07 0.096"/>', '<mesh filename="part.stl"/>', 1))
        triangle = struct.pack("<12fH", 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
        for content in (None, b"", b"solid x", b" " * 80 + struct.pack("<I", 1_000_000) + triangle * 1_000_000,
                        b" " * 80 + struct.pack("<I", 4_000_000_000) + triangle):
            if content is not None:
                (self.models / "io_block/part.stl").write_bytes(content)
            run = takt("model", "io_block", "--models", self.models, "--image", self.path / "x.png", "--size=32x32")
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertIn("part.stl" if content is None else "error", run.stderr)


class Page(WithFolder):
    def test_the_page_is_followed_as_it_stands(self):
        """Every command of docs/adding-an-arm.md, in its order, in a folder that has what the page says."""
        page = (ROOT / "docs/adding-an-arm.md").read_text()
        commands = [line for block in re.findall(r"```sh\n(.*?)```", page, re.S) for line in block.splitlines()]
        commands = [line for line in commands if line.startswith("./takt ")]
        self.assertGreaterEqual(len(commands), 6)
        shutil.copytree(FOREIGN / "press_support", self.path / "press_support")
        (self.path / "scenarios").symlink_to(ROOT / "scenarios")
        for command in commands:
            run = takt(*command.split()[1:], cwd=self.path)
            self.assertEqual(run.returncode, 0, command + "\n" + run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
