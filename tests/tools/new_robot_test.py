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


def box_in_collada(x, y, z, at):
    """A box of these half sides in mm as three.js, Blender and SolidWorks write it: a node with a matrix around it, Y up."""
    corners = [(i, j, k) for i in (-x, x) for j in (-y, y) for k in (-z, z)]
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
             (1, 5, 7), (1, 7, 3)]
    matrix = f"1 0 0 {at[0]} 0 1 0 {at[1]} 0 0 1 {at[2]} 0 0 0 1"
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="box"><mesh>
<source id="p"><float_array id="pa" count="24">{" ".join(str(v) for c in corners for v in c)}</float_array>
<technique_common><accessor source="#pa" count="8" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>{" ".join(str(i) for f in faces for i in f)}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>{matrix}</matrix><instance_geometry url="#box"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def two_colours_in_collada():
    """Two boxes beside each other, a red one and one that is half as bright as white."""
    plain = box_in_collada(100, 50, 50, (0, 0, 0)).replace(
        '<triangles count="12">', '<triangles count="12" material="paint">')
    effects = "".join(f'<effect id="e{i}"><profile_COMMON><technique sid="t"><lambert><diffuse><color>{c} 1</color></diffuse></lambert>'
                      f'</technique></profile_COMMON></effect>' for i, c in enumerate(("0.9 0.1 0", "0.5 0.5 0.5")))
    materials = "".join(f'<material id="m{i}" name="m{i}"><instance_effect url="#e{i}"/></material>' for i in range(2))
    nodes = "".join(
        f'<node id="n{i}"><matrix>1 0 0 {400 * i} 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#box"><bind_material>'
        f'<technique_common><instance_material symbol="paint" target="#m{i}"/></technique_common></bind_material>'
        '</instance_geometry></node>' for i in range(2))
    head, tail = plain.split("<library_visual_scenes>")
    end = tail[tail.index("</visual_scene>"):]
    return (head.replace("<library_geometries>", f"<library_effects>{effects}</library_effects>"
                         f"<library_materials>{materials}</library_materials><library_geometries>")
            + f'<library_visual_scenes><visual_scene id="s">{nodes}' + end)


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
                if name == "cobot":  # another way to raise its hand folds it into itself, and the rehearsal says so
                    folded = takt(*wave, "--set", '/program/steps/2/to={"joints_deg": [-73.9, -67.7, 149.1, 32.5, 83, -167.9]}')
                    self.assertIn("collision", {one["code"] for one in json.loads(folded.stdout)["diagnostics"]})
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

    def test_collada_is_read_with_its_unit_and_its_nodes(self):
        """A box of 500 x 120 x 120 mm in the axes of the file, moved by its node, whatever the file says of up."""
        package = self.path / "press_support"
        shutil.copytree(FOREIGN / "press_support", package)
        (package / "meshes/forearm.dae").write_text(box_in_collada(250, 60, 60, (0, 0, 250)))
        report = self.made("press_six", package / "urdf/press_six.urdf")
        self.assertNotIn("link 'link_3' mesh 'package://press_support/meshes/forearm.dae'", self.notes(report))
        link = next(l for l in xml.etree.ElementTree.parse(self.models / "press_six/press_six.urdf").iter("link")
                    if l.get("name") == "link_3")
        self.assertEqual(link.find("visual/geometry/mesh").get("filename"), "meshes/forearm.obj")
        rows = [line.split() for line in (self.models / "press_six/meshes/forearm.obj").read_text().splitlines()]
        corners = [[float(x) for x in row[1:]] for row in rows if row[0] == "v"]
        for axis, (low, high) in enumerate(((-0.25, 0.25), (-0.06, 0.06), (0.19, 0.31))):
            self.assertAlmostEqual(min(c[axis] for c in corners), low, places=6)
            self.assertAlmostEqual(max(c[axis] for c in corners), high, places=6)
        self.assertEqual(sum(row[0] == "f" for row in rows), 12)
        for broken in ("", "<COLLADA/>", box_in_collada(250, 60, 60, (0, 0, "nan"))):
            (package / "meshes/forearm.dae").write_text(broken)
            shutil.rmtree(self.models / "press_six")
            self.assertIn("link 'link_3' mesh 'package://press_support/meshes/forearm.dae'",
                          self.notes(self.made("press_six", package / "urdf/press_six.urdf")))

    def test_collada_keeps_its_colours(self):
        """A mesh of two colours becomes two visuals; a material of the URDF counts more; collisions stay whole."""
        package = self.path / "press_support"
        shutil.copytree(FOREIGN / "press_support", package)
        (package / "meshes/forearm.dae").write_text(two_colours_in_collada())
        urdf = package / "urdf/press_six.urdf"
        urdf.write_text(urdf.read_text().replace('<material name="undefined"/>', ""))
        self.made("press_six", package / "urdf/press_six.urdf")
        robot = xml.etree.ElementTree.parse(self.models / "press_six/press_six.urdf").getroot()
        colours = {m.get("name"): m.find("color").get("rgba") for m in robot.findall("material")}
        link = next(l for l in robot.iter("link") if l.get("name") == "link_3")
        seen = {colours[v.find("material").get("name")]: v.find("geometry/mesh").get("filename") for v in link.findall("visual")}
        self.assertEqual(set(seen), {"0.9 0.1 0 1", "0.5 0.5 0.5 1"})
        ends = {}
        for rgba, name in seen.items():
            rows = [line.split() for line in (self.models / "press_six" / name).read_text().splitlines()]
            ends[rgba] = max(float(row[1]) for row in rows if row[0] == "v")
            self.assertEqual(sum(row[0] == "f" for row in rows), 12)
        self.assertAlmostEqual(ends["0.9 0.1 0 1"], 0.1, places=6)
        self.assertAlmostEqual(ends["0.5 0.5 0.5 1"], 0.5, places=6)
        self.assertEqual(takt("validate", self.models / "press_six").returncode, 0)

    def test_xacro_is_expanded(self):
        """Includes, packages, arguments and expressions give what the plain file gives."""
        package = self.path / "some_description"
        (package / "urdf").mkdir(parents=True)
        (package / "package.xml").write_text("<package><name>curved_description</name></package>")
        text = (FOREIGN / FILES["curved"]).read_text()
        robot = text[text.index("<robot"):]
        head, rest = robot[:robot.index(">") + 1], robot[robot.index(">") + 1:]
        first = rest.index("<joint")
        joints = rest[first:rest.rindex("</robot>")].replace('velocity="1.2"', 'velocity="${speed * 0.6}"')
        namespace = ' xmlns:xacro="http://www.ros.org/wiki/xacro">'
        (package / "urdf/joints.xacro").write_text(f"<robot{namespace}{joints}</robot>")
        main = package / "urdf/curved.urdf.xacro"
        main.write_text(head[:-1] + namespace + '<xacro:arg name="speed" default="2"/><xacro:property name="speed" value="$(arg speed)"/>'
                        + rest[:first] + '<xacro:include filename="$(find curved_description)/urdf/joints.xacro"/></robot>')
        self.made("plain", FOREIGN / FILES["curved"])
        self.made("expanded", main)
        plain, expanded = (xml.etree.ElementTree.canonicalize((self.models / name / f"{name}.urdf").read_text().replace(name, "x"))
                           for name in ("plain", "expanded"))
        self.assertEqual(plain, expanded)
        report = self.made("slow", main, "--xacro", "speed:=1")
        self.assertIn("xacro", self.notes(report))
        limits = [l.get("velocity") for l in xml.etree.ElementTree.parse(self.models / "slow/slow.urdf").iter("limit")]
        self.assertIn("0.6", limits)
        self.assertNotIn("1.2", limits)
        self.assertIn("[requires]", self.new("b", FOREIGN / FILES["curved"], "--xacro", "a:=1").stderr)
        self.assertIn("[invalid-value]", self.new("b", main, "--xacro", "speed=1").stderr)
        main.write_text(main.read_text().replace("curved_description", "no_description"))
        self.assertIn("no_description", self.new("b", main).stderr)

    def test_an_arm_ends_before_its_gripper(self):
        """One driven finger that the others follow, as in a gripper with links, behind an arm whose flange has no name."""
        text = (FOREIGN / FILES["curved"]).read_text().replace("ee_link", "last_link")
        finger = '<limit lower="0" upper="0.8" velocity="2" effort="10"/></joint>'
        links = "".join(f'<link name="{name}"/>' for name in ("robotiq_base", "left_knuckle", "right_knuckle", "grasp"))
        gripper = (links + '<joint name="mount" type="fixed"><parent link="s6"/><child link="robotiq_base"/></joint>'
                   '<joint name="left" type="revolute"><parent link="robotiq_base"/><child link="left_knuckle"/><axis xyz="0 0 1"/>' + finger
                   + '<joint name="right" type="revolute"><parent link="robotiq_base"/><child link="right_knuckle"/><axis xyz="0 0 1"/>'
                   '<mimic joint="left"/>' + finger + '<joint name="tip" type="fixed"><parent link="left_knuckle"/><child link="grasp"/></joint>')
        file = self.path / "with_gripper.urdf"
        file.write_text(text.replace("</robot>", gripper + "</robot>"))
        report = self.made("with_gripper", file)
        file.write_text(text)
        alone = self.made("curved", file)
        self.assertEqual((report["flange"], report["joints"]), (alone["flange"], alone["joints"]))
        self.assertIn("not on the chain", self.notes(report)["joint 'left'"]["why"])

    def test_a_guessed_payload_carries_a_gripper(self):
        for name in ("press_six", "cobot", "seven"):
            self.made(name)
            device = json.loads((self.models / name / "device.json").read_text())
            mass = json.loads(takt("model", name, "--models", self.models, "--json").stdout)["mass"]
            self.assertAlmostEqual(device["payload_max_kg"], max(0.5, 0.1 * mass), delta=0.06 * mass)

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
        self.assertRegex(tilted.stderr, r"/program/steps/0/to: error: .*\b4 joints\b.* \[unreachable\]")

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
        self.refused(self.text('<robot xmlns:xacro="x"><xacro:include filename="a"/></robot>'), "xacro", "[invalid-value]")
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
        for folder in ("press_support", "mjcf"):
            shutil.copytree(FOREIGN / folder, self.path / folder)
        (self.path / "scenarios").symlink_to(ROOT / "scenarios")
        for command in commands:
            run = takt(*command.split()[1:], cwd=self.path)
            self.assertEqual(run.returncode, 0, command + "\n" + run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
