#!/usr/bin/env python3
"""`takt new robot` with what makers write: half a range, locked joints, placeholders, flat meshes, later versions of URDF.
A file never gets more range than it allows; what is accepted, the simulator builds; what a guess cannot do is said."""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
RANGES = {"a1": (-2.9, 2.9), "a2": (-2.0, 2.0), "a3": (-2.5, 2.5), "a4": (-3.0, 3.0), "a5": (-2.1, 2.1), "a6": (-6.0, 6.0)}
PLACES = {"a1": (0.3, "0 0 1"), "a2": (0.1, "0 1 0"), "a3": (0.4, "0 1 0"), "a4": (0.2, "0 0 1"), "a5": (0.2, "0 1 0"),
          "a6": (0.1, "0 0 1")}


def link(name, mass=2.0, inertia=0.02, shape='<box size="0.08 0.08 0.15"/>', at=0.08):
    seen = f'<origin xyz="0 0 {at}"/><geometry>{shape}</geometry>'
    return (f'<link name="{name}"><inertial><origin xyz="0 0 0.05"/><mass value="{mass}"/><inertia ixx="{inertia}" iyy="{inertia}" '
            f'izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial><visual>{seen}</visual><collision>{seen}</collision></link>')


def joint(name, parent, child, kind="revolute", limit="", z=0.0, axis="0 0 1", origin=""):
    return (f'<joint name="{name}" type="{kind}"><origin xyz="0 0 {z}"{origin}/><parent link="{parent}"/><child link="{child}"/>'
            f'<axis xyz="{axis}"/><limit {limit} velocity="2" effort="200"/></joint>')


class Mini:
    """Six axes as text, with parts that a test replaces."""

    def __init__(self):
        self.links = {"base_link": link("base_link", 5.0, shape='<box size="0.2 0.2 0.3"/>', at=0.15)}
        self.links.update({f"l{i}": link(f"l{i}", 3.4 - 0.4 * i) for i in range(1, 7)})
        self.limits = {name: f'lower="{low}" upper="{high}"' for name, (low, high) in RANGES.items()}
        self.origins = {name: "" for name in RANGES}
        self.more, self.attributes = "", ""

    def text(self):
        joints = "".join(
            joint(name, f"l{i - 1}" if i > 1 else "base_link", f"l{i}", "revolute", self.limits[name], *PLACES[name], self.origins[name])
            for i, name in enumerate(RANGES, 1))
        return (f'<robot name="mini"{self.attributes}>' + "".join(self.links.values()) + joints + self.more + '<link name="tool0"/>'
                '<joint name="t" type="fixed"><origin xyz="0 0 0.08"/><parent link="l6"/><child link="tool0"/></joint></robot>')


def ball_in_collada(rings, sides):
    """A ball of 0.05 m: rings from pole to pole."""
    points = [(0.05 * math.sin(math.pi * i / rings) * math.cos(2 * math.pi * k / sides),
               0.05 * math.sin(math.pi * i / rings) * math.sin(2 * math.pi * k / sides), 0.05 * math.cos(math.pi * i / rings))
              for i in range(rings + 1) for k in range(sides)]
    faces = []
    for i in range(rings):
        for k in range(sides):
            a, b, c, d = (sides * (i + u) + (k + v) % sides for u, v in ((0, 0), (0, 1), (1, 0), (1, 1)))
            faces += ([(a, c, d)] if i < rings - 1 else []) + ([(a, d, b)] if i > 0 else [])
    numbers, corners = " ".join(f"{x:.6f}" for p in points for x in p), " ".join(str(i) for f in faces for i in f)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit name="meter" meter="1"/></asset>
<library_geometries><geometry id="ball"><mesh><source id="p"><float_array id="pa" count="{3 * len(points)}">{numbers}</float_array>
<technique_common><accessor source="#pa" count="{len(points)}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(faces)}"><input semantic="VERTEX" source="#v" offset="0"/><p>{corners}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#ball"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


class Cases(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        self.models = self.path / "models"
        self.mini = Mini()

    def takt(self, *arguments):
        return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=ROOT)

    def new(self, name, *options, file="mini.urdf"):
        (self.path / file).write_text(self.mini.text())
        return self.takt("new", "robot", name, "--urdf", self.path / file, "--out", self.models, "--json", *options)

    def made(self, name, *options, file="mini.urdf"):
        run = self.new(name, *options, file=file)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.notes = {note["key"]: note for note in json.loads(run.stdout)["notes"]}
        self.assertEqual(self.takt("validate", self.models / name / "device.json").returncode, 0)
        return json.loads(self.takt("model", name, "--models", self.models, "--json").stdout)

    def warnings(self):
        return [key for key, note in self.notes.items() if note["why"].startswith("WARNING")]

    def test_a_plain_arm_has_no_warning(self):
        self.made("plain")
        self.assertEqual(self.warnings(), [])

    def test_a_bound_that_is_missing_is_zero(self):
        self.mini.limits["a2"] = 'upper="1.2"'
        self.mini.limits["a3"] = 'lower="-1.4"'
        limits = self.made("halves")
        self.assertEqual((limits["lower"][1], limits["upper"][1]), (0.0, 1.2))
        self.assertEqual((limits["lower"][2], limits["upper"][2]), (-1.4, 0.0))
        self.assertIn("joint 'a2' limit lower", self.notes)
        self.assertIn("joint 'a3' limit upper", self.notes)

    def test_equal_bounds_are_a_locked_joint(self):
        self.mini.limits["a4"] = 'lower="0.5" upper="0.5"'
        figures = self.made("locked")
        self.assertEqual(figures["joints"], ["a1", "a2", "a3", "a5", "a6"])
        self.assertIn("0.5", self.notes["joint 'a4'"]["value"])
        urdf = xml.etree.ElementTree.parse(self.models / "locked/locked.urdf")
        origin = next(j for j in urdf.iter("joint") if j.get("name") == "a4").find("origin")
        self.assertAlmostEqual(float(origin.get("rpy").split()[2]), 0.5)

    def test_masses_count_once(self):
        """A link that moves and has no mass itself, whose body is fixed to it."""
        body = self.mini.links["l3"].replace('"l3"', '"body3"')
        whole = self.made("whole")["mass"]
        self.mini.links["l3"] = '<link name="l3"/>' + body
        self.mini.more = '<joint name="f3" type="fixed"><parent link="l3"/><child link="body3"/></joint>'
        self.assertAlmostEqual(self.made("parts")["mass"], whole, places=9)
        wave = self.takt("run", "scenarios/wave.json", "--models", self.models, "--set", "/devices/arm/model=parts")
        self.assertEqual(wave.returncode, 0, wave.stderr)

    def test_what_is_accepted_the_simulator_builds(self):
        """Meshes in a plane, straight or tilted, of no size, and bodies without weight: replaced with a note."""
        flat = "v 0 0 0\nv 0.1 0 {0}\nv 0.1 0.1 {0}\nv 0 0.1 0\nf 1 2 3\nf 1 3 4\n"
        solid = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
        cases = {"flat": (flat.format(0), ""), "tilted": (flat.format(0.05), ""), "line": ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", ""),
                 "shrunk": (solid, ' scale="1e-7 1e-7 1e-7"')}
        for name, (content, scale) in cases.items():
            with self.subTest(mesh=name):
                (self.path / f"{name}.obj").write_text(content)
                self.mini.links["l5"] = link("l5", shape=f'<mesh filename="{name}.obj"{scale}/>')
                self.made(name)
                self.assertIn(f"link 'l5' mesh '{name}.obj'", self.notes)
                self.assertEqual(self.takt("model", name, "--models", self.models, "--image", self.path / "x.png", "--size=32x32").returncode, 0)
        self.mini.links["l5"] = link("l5")
        self.mini.links["l6"] = link("l6", 1e-9, 1e-18)
        self.made("light")
        self.assertIn("link 'l6' mass", self.notes)

    def test_validate_asks_the_simulator(self):
        """A model written by hand with a mesh that no hull can be made of."""
        self.made("hand")
        (self.models / "hand/flat.obj").write_text("v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3\nf 1 3 4\n")
        urdf = self.models / "hand/hand.urdf"
        urdf.write_text(urdf.read_text().replace('<box size="0.08 0.08 0.15"/>', '<mesh filename="flat.obj"/>'))
        self.assertEqual(self.takt("validate", self.models / "hand/device.json").returncode, 2)

    def test_a_rail_is_what_is_held(self):
        self.mini.links = {"rail": link("rail", 20, shape='<box size="3 0.2 0.1"/>', at=0), **self.mini.links}
        self.mini.more = ('<joint name="rail_joint" type="prismatic"><parent link="rail"/><child link="base_link"/><axis xyz="0 1 0"/>'
                          '<limit lower="-1.5" upper="1.5" velocity="1" effort="2000"/></joint>')
        self.made("rail")
        self.assertEqual(json.loads((self.models / "rail/device.json").read_text())["held_joints"], ["rail_joint"])

    def test_ranges_beyond_half_a_turn_have_a_home(self):
        self.mini.limits["a1"] = 'lower="3.5" upper="6.0"'
        self.made("beyond")
        home = json.loads((self.models / "beyond/device.json").read_text())["home_rad"][0]
        self.assertTrue(3.5 <= home <= 6.0, home)

    def test_a_placeholder_is_no_torque_limit(self):
        self.mini.limits["a2"] += ' effort="1"'
        text = self.mini.text().replace('effort="1" velocity="2" effort="200"', 'velocity="2" effort="1"')
        self.mini.text = lambda: text
        self.made("weak")
        note = self.notes["joint 'a2' limit effort"]
        self.assertIn("placeholder", note["why"])
        self.assertGreater(float(note["value"].split()[0]), 50.0)
        wave = self.takt("run", "scenarios/wave.json", "--models", self.models, "--set", "/devices/arm/model=weak")
        self.assertEqual(wave.returncode, 0, wave.stderr)

    def test_what_the_guesses_cannot_do_is_said(self):
        """An arm that can hardly turn its hand cannot wave."""
        self.mini.limits["a5"] = 'lower="-0.1" upper="0.1"'
        self.made("stiff")
        self.assertTrue(any(key.startswith("wave ") for key in self.warnings()), self.notes.keys())
        text = (self.models / "stiff/README.md").read_text()
        for note in self.notes.values():
            self.assertIn(note["why"], text)

    def test_the_flange_is_no_camera(self):
        self.mini.more = ('<link name="camera_optical_frame"/><joint name="c" type="fixed"><parent link="l6"/>'
                          '<child link="camera_optical_frame"/></joint>')
        text = self.mini.text().replace('<link name="tool0"/>', "").replace(
            '<joint name="t" type="fixed"><origin xyz="0 0 0.08"/><parent link="l6"/><child link="tool0"/></joint>', "")
        self.mini.text = lambda: text
        self.made("eyes")
        self.assertEqual(json.loads((self.models / "eyes/device.json").read_text())["flange"], "l6")

    def test_a_camera_that_floats_is_left_out(self):
        self.mini.more = ('<link name="camera"/><joint name="fl" type="floating"><parent link="base_link"/><child link="camera"/></joint>')
        self.made("floating")
        self.assertIn("joint 'fl'", self.notes)
        self.assertNotIn("camera", (self.models / "floating/floating.urdf").read_text())

    def test_later_versions_of_urdf(self):
        """A quaternion of URDF 1.1 is read; in URDF 1.0 it is no attribute, and that is said."""
        self.mini.origins["a3"] = ' quat_xyzw="0.7071067811865475 0 0 0.7071067811865476"'
        self.made("v10")
        self.assertIn("quat_xyzw of origin", self.notes["left out"]["value"])
        for version in ("1.1", "1.2"):
            self.mini.attributes = f' version="{version}"'
            name = "v" + version.replace(".", "")
            self.made(name)
            urdf = xml.etree.ElementTree.parse(self.models / name / f"{name}.urdf")
            rpy = next(j for j in urdf.iter("joint") if j.get("name") == "a3").find("origin").get("rpy").split()
            self.assertAlmostEqual(float(rpy[0]), 1.5707963267948966, places=8)
        self.mini.links["l5"] = link("l5", shape='<capsule radius="0.04" length="0.1"/>')
        self.made("capsule")
        self.assertIn("capsules", self.notes)

    def test_xacro_says_why_and_needs_no_elements(self):
        self.mini.limits["a3"] = 'lower="-2.5" upper="${pi/2}"'
        self.mini.attributes = ' xmlns:xacro="http://www.ros.org/wiki/xacro"'
        limits = self.made("expr", file="expr.urdf.xacro")
        self.assertAlmostEqual(limits["upper"][2], 1.5707963267948966, places=9)
        self.mini.more = '<xacro:property name="c" value="${xacro.load_yaml(\'limits.yaml\')}"/><link name="${c[\'x\']}"/>'
        run = self.new("noyaml", file="noyaml.xacro")
        self.assertEqual(run.returncode, 2)
        self.assertIn("limits.yaml", run.stderr)

    def test_a_large_collada_file_is_read(self):
        """A ball of 96 000 triangles: their corners are shared, so our own file is not too large for our reader."""
        (self.path / "ball.dae").write_text(ball_in_collada(160, 300))
        self.mini.links["l5"] = link("l5", shape='<mesh filename="ball.dae"/>')
        self.made("ball")
        self.assertNotIn("link 'l5' mesh 'ball.dae'", self.notes)
        self.assertEqual((self.models / "ball/meshes/ball.obj").read_text().count("\nf "), 2 * 300 * 160 - 2 * 300)

    def test_a_gripper_can_be_left_out(self):
        hand = link("hand", 0.7) + link("finger", 0.05)
        self.mini.more = (hand + '<joint name="h" type="fixed"><parent link="l6"/><child link="hand"/></joint>'
                          + joint("f", "hand", "finger", "prismatic", 'lower="0" upper="0.04"', axis="0 1 0"))
        with_hand = self.made("with_hand")["mass"]
        self.assertIn("--without", self.notes["joint 'f'"]["why"])
        self.assertAlmostEqual(self.made("bare", "--without", "hand")["mass"], with_hand - 0.75, places=9)
        self.assertIn("[unknown-name]", self.new("x", "--without", "hnd").stderr)
        self.assertIn("[invalid-value]", self.new("x", "--without", "l4", "--flange", "tool0").stderr)

    @unittest.skipIf(os.geteuid() == 0, "root reads every folder")
    def test_a_folder_above_that_cannot_be_read(self):
        above = self.path / "above"
        (above / "package").mkdir(parents=True)
        self.mini.attributes = ' xmlns:xacro="http://www.ros.org/wiki/xacro"'
        self.mini.more = '<xacro:property name="p" value="$(find package)"/>'
        above.chmod(0o311)
        try:
            self.made("hidden", file="above/package/mini.xacro")
        finally:
            above.chmod(0o755)


class Millimetres(unittest.TestCase):
    def test_the_scale_is_proposed(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            (path / "part.obj").write_text("v 0 0 0\nv 12 0 0\nv 0 12 0\nv 0 0 12\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
            run = subprocess.run([str(TAKT), "new", "object", "part", "--mesh", str(path / "part.obj"), "--out", folder, "--json"],
                                 capture_output=True, text=True, timeout=120, cwd=ROOT)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertTrue(any("--scale 0.001" in note["why"] for note in json.loads(run.stdout)["notes"]))


if __name__ == "__main__":
    unittest.main()
