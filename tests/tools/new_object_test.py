#!/usr/bin/env python3
"""`takt new object`: a mesh becomes a model whose convex parts leave the hollows open, with the masses of the solid."""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]


def takt(*arguments, timeout=300):
    return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=timeout, cwd=ROOT)


def quad(faces, a, b, c, d):
    faces += [(a, b, c), (a, c, d)]


def open_box(x, y, z, wall):
    """An open box with its floor on z = 0: outer size and wall. A closed surface."""
    points, faces = [], []
    for inner in (0, 1):
        for top in (0, 1):
            for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                points.append((sx * (x / 2 - inner * wall), sy * (y / 2 - inner * wall), z if top else inner * wall))
    quad(faces, 3, 2, 1, 0)
    for k in range(4):
        n = (k + 1) % 4
        quad(faces, k, n, 4 + n, 4 + k)
        quad(faces, 4 + k, 4 + n, 12 + n, 12 + k)
        quad(faces, 12 + k, 12 + n, 8 + n, 8 + k)
    quad(faces, 8, 9, 10, 11)
    return points, faces


def cylinder(radius, height, sides):
    points, faces = [(0, 0, 0), (0, 0, height)], []
    for k in range(sides):
        angle = 2 * math.pi * k / sides
        points += [(radius * math.cos(angle), radius * math.sin(angle), h) for h in (0, height)]
    for k in range(sides):
        a, b = 2 + 2 * k, 2 + 2 * ((k + 1) % sides)
        quad(faces, a, b, b + 1, a + 1)
        faces += [(0, b, a), (1, a + 1, b + 1)]
    return points, faces


def obj(mesh, scale=1.0):
    points, faces = mesh
    return "".join("v %.9g %.9g %.9g\n" % tuple(scale * c for c in p) for p in points) + "".join(
        "f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)


def stl(mesh):
    points, faces = mesh
    rows = ["solid thing"]
    for face in faces:
        rows += ["facet normal 0 0 0", "outer loop", *("vertex %.9g %.9g %.9g" % points[i] for i in face), "endloop",
                 "endfacet"]
    return "\n".join([*rows, "endsolid"]) + "\n"


def volume(mesh):
    points, faces = mesh
    total = 0.0
    for face in faces:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (points[i] for i in face)
        total += (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)) / 6
    return total


def read_obj(path):
    points, faces = [], []
    for line in path.read_text().splitlines():
        word, *rest = line.split()
        (points if word == "v" else faces).append(
            tuple(float(c) for c in rest) if word == "v" else tuple(int(c) - 1 for c in rest))
    return points, faces


class Objects(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        self.models = self.path / "models"

    def new(self, name, text, *options, suffix=".obj"):
        file = self.path / (name + suffix)
        file.write_text(text)
        return takt("new", "object", name, "--mesh", file, "--out", self.models, "--json", *options)

    def made(self, name, text, *options, suffix=".obj"):
        run = self.new(name, text, *options, suffix=suffix)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return json.loads(run.stdout)

    def parts(self, name):
        return [read_obj(file) for file in sorted((self.models / name / "meshes").glob("part_*.obj"))]

    def test_an_open_box_keeps_its_hollow(self):
        box = open_box(0.3, 0.2, 0.1, 0.01)
        report = self.made("bin", stl(box), "--density", 600, suffix=".stl")
        self.assertAlmostEqual(report["mass_kg"], 600 * volume(box), delta=1e-6)
        self.assertAlmostEqual(report["filled_share"], volume(box) / 0.006, places=5)
        parts = self.parts("bin")
        self.assertEqual(len(parts), report["parts"])
        self.assertGreaterEqual(len(parts), 5)
        self.assertLessEqual(len(parts), 12)
        self.assertAlmostEqual(sum(map(volume, parts)), volume(box), delta=0.05 * volume(box))
        for points, _ in parts:
            # None of them reaches into the hollow: a part lies beside one of the inner walls, or below the floor.
            walls = [max(p[2] for p in points) < 0.015, min(p[0] for p in points) > 0.135, max(p[0] for p in points) < -0.135,
                     min(p[1] for p in points) > 0.085, max(p[1] for p in points) < -0.085]
            self.assertTrue(any(walls), points)
        self.assertEqual(takt("validate", self.models / "bin/device.json").returncode, 0)
        figures = json.loads(takt("model", "bin", "--models", self.models, "--json").stdout)
        self.assertAlmostEqual(figures["mass"], report["mass_kg"], places=6)

    def test_what_falls_into_it_lands_on_its_floor(self):
        self.made("bin", obj(open_box(0.3, 0.2, 0.1, 0.01)), "--mass", 1.5)
        scenario = self.path / "drop.json"
        scenario.write_text(json.dumps({
            "objects": {
                "bin": {"model": "bin", "at": {"in": "world"}},
                "die": {"shape": "box", "size_m": [0.03, 0.03, 0.03], "mass_kg": 0.05, "fixed": False,
                        "at": {"in": "world", "position_m": [0.05, 0.03, 0.05]}}},
            "program": {"do": "wait", "seconds": 1.0},
            "expectations": [{"kind": "object_pose", "object": "die", "in": "world", "position_m": [0.05, 0.03, 0.025],
                              "position_within_m": 0.001}]}))
        run = takt("run", scenario, "--models", self.models, "--models", ROOT / "models")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_a_surface_without_walls_gets_some(self):
        corners = [(x, y, z) for z in (0, 0.1) for x, y in ((0, 0), (0.2, 0), (0.2, 0.2), (0, 0.2))]
        faces = []
        for a, b, c, d in ((3, 2, 1, 0), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)):
            quad(faces, a, b, c, d)
        report = self.made("tray", obj((corners, faces)), "--density", 600)
        self.assertTrue(any(note["key"] == "surface" for note in report["notes"]))
        parts = self.parts("tray")
        self.assertAlmostEqual(report["mass_kg"], 600 * sum(map(volume, parts)), delta=1e-3 * report["mass_kg"])
        self.assertAlmostEqual(report["filled_share"], report["mass_kg"] / 600 / (0.2 * 0.2 * 0.1), delta=1e-3)
        for points, _ in parts:
            hollow = [all(low < p[i] < high for p in points) for i, (low, high) in enumerate(((0.05, 0.15), (0.05, 0.15)))]
            self.assertFalse(all(hollow) and max(p[2] for p in points) > 0.05, points)

    def test_a_convex_mesh_is_its_own_part(self):
        mesh = cylinder(20, 50, 48)  # in mm, and turned inside out
        report = self.made("pin", obj((mesh[0], [f[::-1] for f in mesh[1]])), "--scale", 0.001, "--mass", 0.3)
        self.assertEqual(report["parts"], 1)
        self.assertAlmostEqual(report["filled_share"], 1.0, places=6)
        for got, wanted in zip(report["size_m"], (0.04, 0.04, 0.05)):
            self.assertAlmostEqual(got, wanted, places=6)
        self.assertAlmostEqual(report["centre_m"][2], 0.025, places=6)
        urdf = (self.models / "pin/pin.urdf").read_text()
        # Of a prism of 48 sides: m (3 r^2 (1 - small) + h^2) / 12.
        ixx = float(urdf.split('ixx="')[1].split('"')[0])
        self.assertAlmostEqual(ixx, 0.3 * (3 * 0.02**2 + 0.05**2) / 12, delta=0.01 * ixx)

    def test_the_same_mesh_gives_the_same_files(self):
        text = obj(open_box(0.2, 0.2, 0.08, 0.008))
        self.made("first", text)
        self.made("second", text)
        for file in sorted((self.models / "first/meshes").iterdir()):
            self.assertEqual(file.read_bytes(), (self.models / "second/meshes" / file.name).read_bytes(), file.name)

    def test_bad_input_is_refused_whole(self):
        good = obj(open_box(0.2, 0.2, 0.1, 0.01))
        cases = {"a flat mesh": ("flat", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", []),
                 "a corner that is not there": ("corner", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", []),
                 "no triangle": ("empty", "v 0 0 0\n", []),
                 "a material": ("stuff", good, ["--material", "stele"]),
                 "a scale": ("scaled", good, ["--scale", "0"]),
                 "a concavity": ("hollow", good, ["--concavity", "nan"])}
        for what, (name, text, options) in cases.items():
            with self.subTest(what):
                run = self.new(name, text, *options)
                self.assertEqual(run.returncode, 2, run.stdout + run.stderr)
                self.assertTrue(json.loads(run.stdout)["diagnostics"])
                self.assertFalse((self.models / name).exists())
        run = takt("new", "object", "Bad Name", "--mesh", self.path / "none.stl", "--out", self.models, "--json",
                   "--scale", "-1", "--most-parts", "0", "--material", "stele")
        wrong = {one["pointer"] for one in json.loads(run.stdout)["diagnostics"]}
        self.assertEqual(wrong, {"NAME", "--mesh", "--scale", "--most-parts", "--material"})
        self.assertEqual(takt("new", "object", "thing").returncode, 2)
        self.assertEqual(takt("new", "robot", "thing").returncode, 2)


if __name__ == "__main__":
    unittest.main()
