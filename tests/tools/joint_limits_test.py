#!/usr/bin/env python3
"""Programs at the ends of joint ranges, near singular wrists and around joints that turn without end, as a user writes
them."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
START = [-168.5408440973835, -0.4738280460454553, 77.14406875770658, 48.26775521636345, 80.29693114046174, -125.32126745238122]
LIMITS = [{"kind": "limits", "arm": "arm"}]


def link(name, z=0.08, size="0.08 0.08 0.15", mass=2.0):
    shape = f'<origin xyz="0 0 {z}"/><geometry><box size="{size}"/></geometry>'
    return (f'<link name="{name}"><inertial><origin xyz="0 0 0.05"/><mass value="{mass}"/><inertia ixx="0.02" iyy="0.02" izz="0.02" '
            f'ixy="0" ixz="0" iyz="0"/></inertial><visual>{shape}</visual><collision>{shape}</collision></link>')


def endless_arm():
    """Six axes, the first, fourth and last without limits."""
    joints = [("a1", "base_link", 0.3, "0 0 1", ""), ("a2", "l1", 0.1, "0 1 0", "2.0"), ("a3", "l2", 0.4, "0 1 0", "2.5"),
              ("a4", "l3", 0.2, "0 0 1", ""), ("a5", "l4", 0.2, "0 1 0", "2.1"), ("a6", "l5", 0.1, "0 0 1", "")]
    text = '<robot name="endless">' + link("base_link", 0.15, "0.2 0.2 0.3", 5) + "".join(link(f"l{i}") for i in range(1, 7))
    for i, (name, parent, z, axis, most) in enumerate(joints, 1):
        range_ = f'lower="-{most}" upper="{most}" ' if most else ""
        text += (f'<joint name="{name}" type="{"revolute" if most else "continuous"}"><origin xyz="0 0 {z}"/><parent link="{parent}"/>'
                 f'<child link="l{i}"/><axis xyz="{axis}"/><limit {range_}velocity="2" effort="200"/></joint>')
    return text + ('<link name="tool0"/><joint name="t" type="fixed"><origin xyz="0 0 0.08"/><parent link="l6"/><child link="tool0"/></joint>'
                   '</robot>')


class Programs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def takt(self, *arguments):
        return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=ROOT)

    def run_program(self, program, model="tx90", start=None, expectations=LIMITS, verb="run"):
        arm = {"model": model, "at": {"position_m": [0, 0, 0.75]}}
        if start:
            arm["start_deg"] = start
        file = self.path / "program.json"
        file.write_text(json.dumps({"devices": {"arm": arm}, "collisions": {"off": "free"}, "time_limit_s": 900, "program": program,
                                    "expectations": expectations}))
        run = self.takt(verb, file, "--models", self.path, "--json")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return json.loads(run.stdout)

    def test_a_start_at_a_limit_runs(self):
        """The encoder rounds 360 deg to 6.28319 rad; 170 deg is an ulp more than the limit of the URDF."""
        self.run_program({"do": "lin", "to": {"by_m": [0, 0, 0.05]}}, "ur5", [0, -90, -90, -90, 90, 360])
        self.run_program({"do": "ptp", "to": {"joints_deg": [0, 30, 0, -90, 0, 60, 0]}}, "lwr4plus", [170, 30, 0, -90, 0, 60, 0])

    def test_a_pose_at_a_limit_is_the_posture_there(self):
        by_joints = self.run_program({"do": "ptp", "to": {"joints_deg": [-180.0, *START[1:]]}}, start=START)
        quaternion = [0.02583693002423404, 0.3991864570849505, 0.8002791509476679, -0.44669442137256166]
        place = [-0.4915630542387518, -0.12355879696548389, 0.9410121061633231]
        by_pose = self.run_program({"do": "ptp", "to": {"in": "arm", "position_m": place, "quaternion": quaternion}}, start=START)
        self.assertEqual(by_joints["sim_time"], by_pose["sim_time"])

    def test_a_pose_near_a_singular_wrist_is_found_with_any_number_of_digits(self):
        place = [0.092134037, 0.321054324, 0.423511535]
        quaternion = [-0.13106309, 0.612027339, 0.750678744, 0.211486232]
        for digits in (5, 6, 7, 8, 9):
            goal = {"in": "arm", "position_m": [round(x, digits) for x in place], "quaternion": [round(x, digits) for x in quaternion]}
            self.run_program({"do": "ptp", "to": goal}, verb="validate", expectations=[])

    def test_an_endless_joint_goes_to_the_nearest_turn(self):
        (self.path / "endless.urdf").write_text(endless_arm())
        made = self.takt("new", "robot", "endless", "--urdf", self.path / "endless.urdf", "--out", self.path)
        self.assertEqual(made.returncode, 0, made.stderr)
        home = [round(57.29577951308232 * q, 4) for q in json.loads((self.path / "endless/device.json").read_text())["home_rad"]]
        there, back = [170, *home[1:]], [-170, *home[1:]]
        turns = [{"do": "ptp", "name": "there", "to": {"joints_deg": there}},
                 {"do": "ptp", "name": "on", "to": {"joints_deg": back}, "speed": 0.5}]
        near = self.run_program({"do": "sequence", "steps": turns}, "endless", home)["sim_time"]
        turns[1]["to"]["absolute"] = True
        absolute = self.run_program({"do": "sequence", "steps": turns}, "endless", home)["sim_time"]
        self.assertGreater(absolute - near, 4.0, "340 deg at 1 rad/s, and 20 deg")
        many = [{"do": "repeat", "times": 6, "steps": [{"do": "ptp", "to": {"by_rpy_deg": [0, 0, 170]}}]}]
        times = [self.run_program({"do": "sequence", "steps": many + last}, "endless", home)["sim_time"]
                 for last in ([], [{"do": "ptp", "to": "home"}], [{"do": "ptp", "to": {"home": True, "absolute": True}}])]
        self.assertLess(times[1] - times[0], 6.0)
        self.assertGreater(times[2] - times[0], 7.0, "1020 deg at 2 rad/s")


if __name__ == "__main__":
    unittest.main()
