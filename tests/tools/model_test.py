#!/usr/bin/env python3
"""`takt model` from outside: figures, kinematics with branch names, pictures."""
import json
import math
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree
import zlib

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
MODELS = sorted(folder.name for folder in (ROOT / "models").iterdir() if (folder / "device.json").exists())


def takt(*arguments):
    return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=ROOT)


def answer(*arguments):
    run = takt(*arguments, "--json")
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def pixels(file):
    """Width, height and rows of red, green, blue of an 8 bit PNG (all filters)."""
    data, at, packed = file.read_bytes(), 8, b""
    width = height = 0
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            assert (depth, colour) == (8, 2)
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    raw, rows, before = zlib.decompress(packed), [], bytes(3 * width)
    for y in range(height):
        line = bytearray(raw[y * (3 * width + 1):(y + 1) * (3 * width + 1)])
        kind, line = line[0], line[1:]
        for i in range(3 * width):
            left, up, corner = (line[i - 3] if i > 2 else 0), before[i], (before[i - 3] if i > 2 else 0)
            guess = left + up - corner
            nearest = min((left, up, corner), key=lambda v: abs(guess - v))
            line[i] = (line[i] + (0, left, up, (left + up) // 2, nearest)[kind]) & 255
        rows.append(bytes(line))
        before = rows[-1]
    return width, height, rows


class Model(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)
        self.addCleanup(self.folder.cleanup)

    def test_figures_of_every_model(self):
        for name in MODELS:
            figures = answer("model", name)
            self.assertEqual(figures["model"], name)
            self.assertAlmostEqual(sum(link["mass"] for link in figures["links"]), figures["mass"], places=9)
            text = takt("model", name)
            self.assertEqual(text.returncode, 0)
            self.assertIn("kg", text.stdout)

    def test_figures_of_an_arm(self):
        figures = answer("model", "tx90")
        self.assertEqual(figures["kind"], "arm")
        self.assertEqual(figures["inverse_kinematics"], "closed form: spherical wrist, parallel elbow")
        self.assertEqual(figures["cycle_ms"], 4)
        self.assertEqual(len(figures["jerk"]), 6)
        self.assertEqual(figures["held_joints"], [])
        self.assertEqual(answer("model", "lwr4plus")["held_joints"], ["e1"])
        text = takt("model", "tx90").stdout
        for word in ("deg/s3", "armature", "payload", "147.5", "spherical wrist"):
            self.assertIn(word, text)

    def test_forward_names_branch_singularity_and_limits(self):
        fk = answer("model", "tx90", "--fk=0,0.5,1.8,0,0.7,0")
        self.assertEqual(fk["branch"], "front, up, no flip")
        self.assertEqual((fk["shoulder"], fk["elbow"], fk["wrist"]), ("front", "up", "no flip"))
        self.assertFalse(fk["singularity"]["singular"])
        self.assertEqual(fk["limit_margin"]["joint"], "j3")
        self.assertAlmostEqual(fk["limit_margin"]["distance"], math.radians(145) - 1.8)
        stretched = answer("model", "tx90", "--fk=0,0.5,0,0,0.7,0")["singularity"]
        self.assertTrue(stretched["singular"])
        self.assertEqual(stretched["nearest"], "elbow")
        text = takt("model", "lwr4plus", "--fk=0,-0.5,0,1.5,0,-1,0").stdout
        self.assertIn("arm angle         0.0000 deg", text)

    def test_inverse_names_every_branch(self):
        pose = "--ik=0.5,0.1,0.5,0,0,1,0"
        ik = answer("model", "tx90", pose, "--branches")
        self.assertEqual(len(ik["solutions"]), len(ik["branches"]))
        names = [branch["branch"] for branch in ik["branches"]]
        self.assertEqual(len(set(names)), len(names))
        self.assertIn("front, up, no flip", names)
        self.assertGreater(len(answer("model", "tx90", pose)["solutions"]), len(names), "turns of axes 4 and 6")

    def test_arm_angle_and_held_joint(self):
        at = {"--held=0.3": lambda q, branch: q[2] - 0.3, "--arm-angle=0.4": lambda q, branch: branch["arm_angle"] - 0.4}
        for option, off in at.items():
            ik = answer("model", "lwr4plus", "--ik=0.5,0.1,0.4,0,0,1,0", option)
            self.assertGreater(len(ik["solutions"]), 0)
            for q, branch in zip(ik["solutions"], ik["branches"]):
                self.assertAlmostEqual(off(q, branch), 0, places=8)

    def test_pictures_show_something(self):
        for name in ("lwr4plus", "wsg50", "io_block"):
            file = self.path / f"{name}.png"
            run = takt("model", name, "--image", file, "--size", "160x120")
            self.assertEqual(run.returncode, 0, run.stderr)
            width, height, rows = pixels(file)
            self.assertEqual((width, height), (160, 120))
            # The model fills the picture: what is neither floor nor sky reaches over half of its height or width.
            background = rows[0][:3]
            differs = [[max(abs(row[3 * x + k] - background[k]) for k in range(3)) > 60 for x in range(width)]
                       for row in rows]
            high = [y for y in range(height) if any(differs[y])]
            wide = [x for x in range(width) if any(row[x] for row in differs)]
            self.assertTrue(max(high) - min(high) > 60 or max(wide) - min(wide) > 80, name)
        again = self.path / "again.png"
        takt("model", "io_block", "--image", again, "--size", "160x120")
        self.assertEqual(again.read_bytes(), file.read_bytes(), "the same bytes again")

    def test_a_posture_changes_the_picture(self):
        images = []
        for posture in ("0,0,0,0,0,0", "0,1,1,0,0,0"):
            file = self.path / "posture.png"
            self.assertEqual(takt("model", "tx90", "--image", file, "--size=80x80", "--posture", posture).returncode, 0)
            images.append(file.read_bytes())
        self.assertNotEqual(*images)

    def test_reach_is_a_drawing_with_axes(self):
        file = self.path / "reach.svg"
        run = takt("model", "ur5", "--reach", file)
        self.assertEqual(run.returncode, 0, run.stderr)
        root = xml.etree.ElementTree.parse(file).getroot()
        texts = [text.text for text in root.iter("{http://www.w3.org/2000/svg}text")]
        for words in ("any orientation", "height above the base, m", "0: singular"):
            self.assertIn(words, texts)
        fields = [r for r in root.iter("{http://www.w3.org/2000/svg}rect")]
        self.assertGreater(len(fields), 500)
        self.assertLess(file.stat().st_size, 1_000_000)

    def test_a_work_space_that_takes_long_says_how_far_it_is(self):
        # Six joints of which one slides have no closed form.
        urdf = (pathlib.Path(__file__).parent / "foreign/five.urdf")
        made = takt("new", "robot", "five", "--urdf", urdf, "--out", self.path)
        self.assertEqual(made.returncode, 0, made.stderr)
        file = self.path / "reach.svg"
        begin = time.monotonic()
        run = takt("model", "five", "--models", self.path, "--reach", file)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("reach", run.stderr)
        if time.monotonic() - begin > 3:
            self.assertIn("the work space is sampled:", run.stderr)
        slow = subprocess.Popen([str(TAKT), "model", "five", "--models", str(self.path), "--reach", str(self.path / "b.svg")],
                                stderr=subprocess.DEVNULL)
        time.sleep(0.3)
        slow.send_signal(signal.SIGINT)
        self.assertEqual(slow.wait(timeout=20), 130)
        self.assertFalse((self.path / "b.svg").exists())

    def test_a_flange_that_cannot_be_there(self):
        run = takt("model", "lwr4plus", "--ik=5,0,0,1,0,0,0")
        self.assertEqual(run.returncode, 1)
        self.assertIn("cannot be there", run.stderr)
        self.assertIn("OUTSIDE by", takt("model", "lwr4plus", "--fk=9,0,0,0,0,0,0").stdout)

    def test_bad_questions(self):
        for arguments, word in (
                (("wsg50", "--fk=1"), "[invalid-value]"), (("ur5", "--fk=1,2"), "[wrong-size]"),
                (("ur5", "--ik=1,2"), "[wrong-size]"), (("ur5", "--ik=0,0,0,2,0,0,0"), "[out-of-range]"),
                (("ur5", "--ik=0.5,0,0.3,0,0,1,0", "--arm-angle=1"), "--arm-angle: error"),
                (("ur5", "--ik=0.5,0,0.3,0,0,1,0", "--held=1"), "--held: error"),
                (("ur5", "--reach", self.path / "reach.pdf"), "[invalid-value]"),
                (("ur5", "--reach", self.path / "none/reach.svg"), "[file-not-writable]"),
                (("ur5", "--image", self.path / "x.png", "--size=12"), "--size: error"),
                (("ur5", "--image", self.path / "x.png", "--size=8x8"), "16"),
                (("ur5", "--image", self.path / "none/x.png"), "[file-not-writable]"),
                (("ur5", "--image", self.path / "x.png", "--posture=1,2"), "--posture: error"),
                (("ur5", "--image", self.path / "x.jpg"), "--image: error"),
                (("ur55",), "ur5")):
            run = takt("model", *arguments)
            self.assertEqual(run.returncode, 2, (arguments, run.stderr))
            self.assertIn(word, run.stderr)


if __name__ == "__main__":
    unittest.main()
