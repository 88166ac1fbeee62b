"""Tests of the models as data: every model's files fit together; the arms have the published figures."""
import json
import math
import pathlib
import random
import re
import sys
import unittest
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODELS = ROOT / "models"
sys.path.insert(0, str(MODELS))
import make_meshes  # noqa: E402

TENSOR = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
FOLDERS = sorted(p.parent for p in MODELS.glob("*/device.json"))


def device_of(folder):
    return json.loads((folder / "device.json").read_text())


def urdf_of(folder):
    return ElementTree.parse(folder / device_of(folder)["urdf"]).getroot()


def numbers(element, attribute, default):
    text = element.get(attribute) if element is not None else None
    return [float(x) for x in (text or default).split()]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def rotation(axis, angle):
    """Rodrigues' formula as a 4x4 matrix."""
    x, y, z = axis
    c, s, v = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
    return [[c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0],
            [y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0],
            [z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0], [0, 0, 0, 1]]


def translation(x, y, z):
    return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]


def origin_pose(element):
    x, y, z = numbers(element, "xyz", "0 0 0")
    roll, pitch, yaw = numbers(element, "rpy", "0 0 0")
    turn = product(rotation((0, 0, 1), yaw), product(rotation((0, 1, 0), pitch), rotation((1, 0, 0), roll)))
    return product(translation(x, y, z), turn)


def joints_between(robot, base, tip):
    """Joints from base to tip, outwards."""
    parent_joint = {j.find("child").get("link"): j for j in robot.iterfind("joint")}
    chain = []
    while tip != base:
        chain.insert(0, parent_joint[tip])
        tip = parent_joint[tip].find("parent").get("link")
    return chain


def movable(robot, device):
    return [j for j in joints_between(robot, device["base"], device["flange"]) if j.get("type") != "fixed"]


def forward(robot, device, q):
    pose, rest = translation(0, 0, 0), list(q)
    for joint in joints_between(robot, device["base"], device["flange"]):
        pose = product(pose, origin_pose(joint.find("origin")))
        if joint.get("type") != "fixed":
            pose = product(pose, rotation(numbers(joint.find("axis"), "xyz", "1 0 0"), rest.pop(0)))
    return pose


def dh(rows, q):
    """Standard Denavit-Hartenberg: rows (d, a, alpha); T = Rz(q) Tz(d) Tx(a) Rx(alpha)."""
    pose = translation(0, 0, 0)
    for (d, a, alpha), angle in zip(rows, q):
        step = product(product(rotation((0, 0, 1), angle), translation(a, 0, d)), rotation((1, 0, 0), alpha))
        pose = product(pose, step)
    return pose


def eigenvalues(ixx, iyy, izz, ixy, ixz, iyz):
    """Of a symmetric 3x3 matrix, ascending (trigonometric solution of the cubic)."""
    mean = (ixx + iyy + izz) / 3
    a, b, c = ixx - mean, iyy - mean, izz - mean
    p = math.sqrt((a * a + b * b + c * c + 2 * (ixy**2 + ixz**2 + iyz**2)) / 6)
    if p < 1e-12 * abs(mean):  # a multiple of the identity
        return [mean] * 3
    det = a * (b * c - iyz**2) - ixy * (ixy * c - iyz * ixz) + ixz * (ixy * iyz - b * ixz)
    phi = math.acos(max(-1, min(1, det / (2 * p**3)))) / 3
    return sorted(mean + 2 * p * math.cos(phi + 2 * math.pi * k / 3) for k in range(3))


def obj_triangles(data):
    """Triangles of an OBJ: three corners of (place, normal)."""
    rows = [line.split() for line in data.decode().splitlines()]
    places, normals = ([tuple(map(float, r[1:])) for r in rows if r[0] == key] for key in ("v", "vn"))
    for row in rows:
        if row[0] == "f":
            pairs = [corner.split("//") for corner in row[1:]]
            yield [(places[int(v) - 1], normals[int(n) - 1]) for v, n in pairs]


class EveryModel(unittest.TestCase):
    def each(self):
        return [(folder, device_of(folder), urdf_of(folder)) for folder in FOLDERS]

    def test_there_are_models(self):
        self.assertLessEqual({"lwr4plus", "ur5", "tx90"}, {f.name for f in FOLDERS})

    def test_names_agree(self):
        for folder, device, robot in self.each():
            with self.subTest(model=folder.name):
                self.assertEqual(device["name"], folder.name)
                self.assertEqual(robot.get("name"), folder.name)
                self.assertTrue((folder / "README.md").exists())

    def test_named_links_exist_and_base_is_the_root(self):
        for folder, device, robot in self.each():
            with self.subTest(model=folder.name):
                links = [link.get("name") for link in robot.iterfind("link")]
                children = [j.find("child").get("link") for j in robot.iterfind("joint")]
                for key in ("base", "flange", "measuring", "tcp"):
                    if key in device:
                        self.assertIn(device[key], links, key)
                self.assertEqual([link for link in links if link not in children], [device["base"]])

    def test_mesh_paths_stay_inside_and_are_made(self):
        for folder, _, robot in self.each():
            with self.subTest(model=folder.name):
                names = [m.get("filename") for m in robot.iterfind(".//mesh")]
                made = json.loads((folder / "geometry.json").read_text())["meshes"] if names else {}
                for name in names:
                    self.assertRegex(name, r"^meshes/[a-z0-9_]+\.obj$")
                    self.assertIn(pathlib.Path(name).stem, made)
                self.assertEqual({pathlib.Path(n).stem for n in names}, set(made), "a mesh that no link uses")

    def test_collision_shapes_are_convex_primitives_at_most_three_a_link(self):
        for folder, device, robot in self.each():
            with self.subTest(model=folder.name):
                for link in robot.iterfind("link"):
                    shapes = [s.tag for s in link.iterfind("collision/geometry/*")]
                    self.assertTrue(set(shapes) <= {"cylinder", "sphere", "box"}, shapes)
                    if device["kind"] == "arm":
                        self.assertLessEqual(len(shapes), 3, link.get("name"))

    def test_inertias_belong_to_bodies(self):
        for folder, _, robot in self.each():
            with self.subTest(model=folder.name):
                for inertial in robot.iterfind("link/inertial"):
                    self.assertGreater(float(inertial.find("mass").get("value")), 0)
                    tensor = [float(inertial.find("inertia").get(k)) for k in TENSOR]
                    low, middle, high = eigenvalues(*tensor)
                    self.assertGreater(low, 0)
                    self.assertLessEqual(high, (low + middle) * (1 + 1e-6))

    def test_inertias_are_those_of_the_geometry(self):
        for folder, _, robot in self.each():
            with self.subTest(model=folder.name):
                for link in robot.iterfind("link"):
                    if link.find("inertial") is None or link.find("visual/geometry/mesh") is None:
                        continue
                    geometry = json.loads((folder / "geometry.json").read_text())
                    computed = make_meshes.link_inertia(link, geometry)[2]
                    written = [float(link.find("inertial/inertia").get(k)) for k in TENSOR]
                    for c, w in zip(computed, written):
                        self.assertAlmostEqual(c, w, delta=0.002 * max(computed) + 1e-7, msg=link.get("name"))

    def test_lists_have_one_entry_per_joint(self):
        for folder, device, robot in self.each():
            with self.subTest(model=folder.name):
                if device["kind"] != "arm":
                    continue
                joints = movable(robot, device)
                for values in (device["home_rad"], device["armature_kg_m2"], device["limits"]["acceleration_rad_s2"],
                               device["limits"]["jerk_rad_s3"], *device["control"]["gains"].values(),
                               *(v for v in device["sensors"]["torque"].values() if isinstance(v, list))):
                    self.assertEqual(len(values), len(joints))
                for q, joint in zip(device["home_rad"], joints):
                    limit = joint.find("limit")
                    self.assertTrue(float(limit.get("lower")) < q < float(limit.get("upper")), joint.get("name"))
                self.assertTrue(set(device.get("held_joints", [])) <= {j.get("name") for j in joints})

    def test_figures_in_the_readme_of_an_arm_are_those_of_its_files(self):
        """The README has the sources; a figure that was changed in one place only has none."""
        for folder, device, robot in self.each():
            if device["kind"] != "arm":
                continue
            with self.subTest(model=folder.name):
                rows = {name: value for name, value in
                        re.findall(r"^\| ([^|]+) \| ([^|]+) \|", (folder / "README.md").read_text(), re.MULTILINE)}
                limits = [joint.find("limit") for joint in movable(robot, device)]

                def figures(row):
                    values = [float(x) for x in re.findall(r"(?<![\w.])[\d.]+(?![\w.])", rows[row].split("; ")[0])]
                    return values * len(limits) if "all" in rows[row] else values

                self.assertEqual(figures("accelerations"), device["limits"]["acceleration_rad_s2"])
                self.assertEqual(figures("torques"), [float(limit.get("effort")) for limit in limits])
                for given, limit in zip(figures("velocities"), limits, strict=True):
                    self.assertAlmostEqual(math.radians(given), float(limit.get("velocity")), 9)
                self.assertEqual(figures("start tolerance"), [device["start_tolerance_rad"]])
                self.assertEqual(figures("control cycle"), [device["cycle_ms"]])
                loads = figures("load")
                self.assertEqual(loads[-1], device["payload_max_kg"])
                self.assertEqual(loads[0], device.get("payload_rated_kg", device["payload_max_kg"]))

    def test_schema_knows_every_key(self):
        schema = json.loads((ROOT / "schemas/device.schema.json").read_text())
        for folder, device, _ in self.each():
            with self.subTest(model=folder.name):
                kind = schema["definitions"][device["kind"]]
                self.assertEqual(set(device) - set(kind["properties"]), set())
                self.assertEqual(set(kind.get("required", []) + schema["required"]) - set(device), set())


class Meshes(unittest.TestCase):
    FOLDERS = sorted(p.parent for p in MODELS.glob("*/geometry.json"))

    def meshes(self):
        for folder in self.FOLDERS:
            geometry = json.loads((folder / "geometry.json").read_text())
            for name, parts in geometry["meshes"].items():
                yield folder, name, make_meshes.solids_of(parts, geometry.get("curves", {}))

    def test_files_are_made_and_of_these_bytes(self):
        for folder, name, solids in self.meshes():
            with self.subTest(model=folder.name, mesh=name):
                self.assertEqual((folder / f"meshes/{name}.obj").read_bytes(), make_meshes.obj(solids))

    def test_solids_are_closed_and_turned_outwards(self):
        for folder, name, solids in self.meshes():
            with self.subTest(model=folder.name, mesh=name):
                for solid in solids:
                    edges = {}
                    for corners in obj_triangles(make_meshes.obj([solid])):
                        a, b, c = (place for place, _ in corners)
                        self.assertEqual(len({a, b, c}), 3, "a triangle without area")
                        outward = make_meshes.direction(a, b, c)
                        for _, normal in corners:
                            self.assertAlmostEqual(math.hypot(*normal), 1, places=3)
                            self.assertGreater(sum(p * q for p, q in zip(outward, normal)), 0)
                        for edge in ((a, b), (b, c), (c, a)):
                            edges[edge] = edges.get(edge, 0) + 1
                    for (a, b), count in edges.items():
                        self.assertEqual((count, edges.get((b, a))), (1, 1), "each edge twice, once in each direction")
                    self.assertGreater(make_meshes.moments([solid])[0], 0)

    def test_triangle_budgets(self):
        for folder in self.FOLDERS:
            geometry = json.loads((folder / "geometry.json").read_text())
            count = sum(len(s.triangles) for parts in geometry["meshes"].values()
                        for s in make_meshes.solids_of(parts, geometry.get("curves", {})))
            moves = (folder / "device.json").exists() and device_of(folder)["kind"] in ("arm", "base")
            budget = 7000 if moves else 1500
            self.assertLessEqual(count, budget, folder.name)

    def test_moments_of_known_bodies(self):
        volume, first, second = make_meshes.moments([make_meshes.box({"size": [0.2, 0.4, 0.6]})])
        self.assertAlmostEqual(volume, 0.048)
        self.assertAlmostEqual(first[2], 0)
        self.assertAlmostEqual(second[2], 0.048 * 0.36 / 12)
        cone = make_meshes.lathe({"points": [[0.5, 0], [0, 1]], "segments": 720})
        volume, first, _ = make_meshes.moments([cone])
        self.assertAlmostEqual(volume, math.pi * 0.25 / 3, places=4)
        self.assertAlmostEqual(first[2] / volume, 0.25, places=6)


class Lwr4plus(unittest.TestCase):
    FOLDER = MODELS / "lwr4plus"
    H = math.pi / 2
    DH = [(0.3105, 0, H), (0, 0, -H), (0.400, 0, -H), (0, 0, H), (0.390, 0, H), (0, 0, -H), (0.078, 0, 0)]

    def setUp(self):
        self.device, self.robot = device_of(self.FOLDER), urdf_of(self.FOLDER)
        self.joints = movable(self.robot, self.device)

    def test_joint_names_and_limits(self):
        self.assertEqual([j.get("name") for j in self.joints], ["a1", "a2", "e1", "a3", "a4", "a5", "a6"])
        table = zip(self.joints, (170, 120, 170, 120, 170, 120, 170), (110, 110, 128, 128, 204, 184, 184),
                    (176, 176, 100, 100, 100, 38, 38))
        for joint, degrees, speed, torque in table:
            limit = {k: float(v) for k, v in joint.find("limit").attrib.items()}
            self.assertAlmostEqual(limit["upper"], math.radians(degrees), places=14)
            self.assertEqual(limit["lower"], -limit["upper"])
            self.assertAlmostEqual(limit["velocity"], math.radians(speed), places=14)
            self.assertEqual(limit["effort"], torque)

    def test_forward_kinematics_equals_the_table(self):
        random.seed(1)
        for _ in range(1000):
            q = [random.uniform(float(j.find("limit").get("lower")), float(j.find("limit").get("upper")))
                 for j in self.joints]
            expected, actual = dh(self.DH, q), forward(self.robot, self.device, q)
            for row_e, row_a in zip(expected, actual):
                for e, a in zip(row_e, row_a):
                    self.assertAlmostEqual(e, a, delta=1e-12)

    def test_upright_and_home(self):
        upright = forward(self.robot, self.device, [0] * 7)
        self.assertAlmostEqual(upright[2][3], 1.1785)
        home = forward(self.robot, self.device, self.device["home_rad"])
        self.assertAlmostEqual(home[0][3], 0.538, places=3)
        self.assertAlmostEqual(home[2][3], 0.384, places=3)
        self.assertAlmostEqual(home[2][2], -1, places=6)

    def test_mass_and_holding_torque(self):
        pose, gravity, reach = translation(0, 0, 0), 9.81, 0.0
        total = sum(float(m.get("value")) for m in self.robot.iterfind("link/inertial/mass"))
        self.assertAlmostEqual(total, 16.0, delta=0.48)
        links = {link.get("name"): link for link in self.robot.iterfind("link")}
        for joint in self.joints:
            pose = product(pose, origin_pose(joint.find("origin")))
            link = links[joint.find("child").get("link")]
            z = numbers(link.find("inertial/origin"), "xyz", "0 0 0")[2] + pose[2][3] - 0.3105
            if joint.get("name") != "a1":
                reach += float(link.find("inertial/mass").get("value")) * z
        self.assertAlmostEqual(gravity * reach, 42.4, delta=0.1)

    def test_shape_of_the_arm(self):
        """Widths that make an LWR: tubes of 0.12 m, elbows out to 0.094 m on alternating sides, foot 0.162 m."""
        geometry = json.loads((self.FOLDER / "geometry.json").read_text())

        def bounds(name):
            solids = make_meshes.solids_of(geometry["meshes"][name], geometry["curves"])
            points = [p for solid in solids for p in solid.vertices]
            return [(min(c), max(c)) for c in zip(*points)]

        for number, side in ((1, 1), (2, -1), (3, -1), (4, 1)):
            (x_low, x_high), y, _ = bounds(f"link{number}_shell")
            low, high = y if side > 0 else (-y[1], -y[0])
            self.assertAlmostEqual(x_high - x_low, 0.12, delta=0.001)
            self.assertAlmostEqual(low, -0.060, delta=0.001)
            self.assertAlmostEqual(high, 0.094, delta=0.001)
        (x_low, x_high), _, _ = bounds("base_body")
        self.assertAlmostEqual(x_high - x_low, 0.162, delta=0.001)


class SixAxes:
    """What the six-axis arms have in common; a class below gives the published figures: DH rows (d, a, alpha), zero
    angles, degrees, degrees per second, Nm, masses, holding torques of axes 2 and 3 with the arm level."""

    ZERO = (0, 0, 0, 0, 0, 0)

    def setUp(self):
        folder = MODELS / self.NAME
        self.device, self.robot = device_of(folder), urdf_of(folder)
        self.joints = movable(self.robot, self.device)

    def masses(self):
        return [float(m.get("value")) for m in self.robot.iterfind("link/inertial/mass")]

    def test_names_and_limits(self):
        self.assertEqual([j.get("name") for j in self.joints], self.JOINTS)
        for joint, (low, high), speed, torque in zip(self.joints, self.RANGES_DEG, self.SPEEDS_DEG_S, self.TORQUES_NM):
            limit = {k: float(v) for k, v in joint.find("limit").attrib.items()}
            self.assertAlmostEqual(limit["lower"], math.radians(low), places=14)
            self.assertAlmostEqual(limit["upper"], math.radians(high), places=14)
            self.assertAlmostEqual(limit["velocity"], math.radians(speed), places=14)
            self.assertEqual(limit["effort"], torque)

    def test_forward_kinematics_equals_the_table(self):
        random.seed(1)
        for _ in range(1000):
            q = [random.uniform(float(j.find("limit").get("lower")), float(j.find("limit").get("upper")))
                 for j in self.joints]
            expected = dh(self.DH, [angle + zero for angle, zero in zip(q, self.ZERO)])
            for row_e, row_a in zip(expected, forward(self.robot, self.device, q)):
                for e, a in zip(row_e, row_a):
                    self.assertAlmostEqual(e, a, delta=1e-9)

    def test_home_points_straight_down_and_reaches_to_x(self):
        home = forward(self.robot, self.device, self.device["home_rad"])
        for value, expected in zip((home[0][3], home[1][3], home[2][3]), self.HOME_M):
            self.assertAlmostEqual(value, expected, places=3)
        self.assertAlmostEqual(home[2][2], -1, places=6)
        self.assertAlmostEqual(home[0][0], -1, places=6)

    def test_masses_and_holding_torques(self):
        self.assertEqual(self.masses(), self.MASSES_KG)
        self.assertAlmostEqual(sum(self.masses()), self.TOTAL_KG, delta=0.03 * self.TOTAL_KG)
        links, pose, places = {link.get("name"): link for link in self.robot.iterfind("link")}, translation(0, 0, 0), []
        for joint, angle in zip(self.joints, self.LEVEL):
            pose = product(pose, origin_pose(joint.find("origin")))
            axis_x = pose[0][3]
            pose = product(pose, rotation(numbers(joint.find("axis"), "xyz", "1 0 0"), angle))
            inertial = links[joint.find("child").get("link")].find("inertial")
            centre = numbers(inertial.find("origin"), "xyz", "0 0 0")
            x = pose[0][3] + sum(r * c for r, c in zip(pose[0], centre))
            places.append((axis_x, x, float(inertial.find("mass").get("value"))))
        for axis, expected in zip((1, 2), self.HOLDING_NM):
            torque = 9.81 * sum(m * (x - places[axis][0]) for _, x, m in places[axis:])
            self.assertAlmostEqual(abs(torque), expected, delta=0.1)


class Ur5(SixAxes, unittest.TestCase):
    NAME, JOINTS = "ur5", ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
    H = math.pi / 2
    DH = [(0.089159, 0, H), (0, -0.425, 0), (0, -0.39225, 0), (0.10915, 0, H), (0.09465, 0, -H), (0.0823, 0, 0)]
    RANGES_DEG, SPEEDS_DEG_S, TORQUES_NM = [(-360, 360)] * 6, [180] * 6, [150, 150, 150, 28, 28, 28]
    MASSES_KG, TOTAL_KG = [1.35, 3.7, 8.393, 2.33, 1.219, 1.219, 0.1879], 18.4
    HOME_M, LEVEL, HOLDING_NM = (0.555, -0.109, 0.357), [0] * 6, (53.8, 15.6)


class Tx90(SixAxes, unittest.TestCase):
    NAME, JOINTS = "tx90", ["j1", "j2", "j3", "j4", "j5", "j6"]
    H = math.pi / 2
    DH = [(0.478, 0.050, -H), (0.050, 0.425, 0), (0, 0, H), (0.425, 0, -H), (0, 0, H), (0.100, 0, 0)]
    ZERO = (0, -H, H, 0, 0, 0)
    RANGES_DEG = [(-180, 180), (-130, 147.5), (-145, 145), (-270, 270), (-115, 140), (-270, 270)]
    SPEEDS_DEG_S, TORQUES_NM = [400, 400, 430, 540, 475, 760], [636, 332, 152, 68, 58, 22]
    MASSES_KG, TOTAL_KG = [22.365, 35.261, 27.049, 15.621, 9.456, 1.184, 0.065], 111
    HOME_M, LEVEL, HOLDING_NM = (0.563, 0.050, 0.446), [0, H, 0, 0, 0, 0], (189.2, 33.6)

    def test_inertias_agree_with_the_rescaled_published_ones(self):
        """Moments about the axes, ours of our geometry, within 22 % of each link's largest."""
        published = [(.2013, .1825, .1701), (.4628, .4349, .3269), (.8855, .9418, .1135), (.1226, .1184, .0713),
                     (.0900, .0799, .0302), (.0023, .0023, .0008)]
        for inertia, row in zip(self.robot.iterfind("link/inertial/inertia"), published):
            for key, value in zip(TENSOR, row):
                self.assertAlmostEqual(float(inertia.get(key)), value, delta=0.22 * max(row))


class Wsg50(unittest.TestCase):
    """A URDF without a device file."""

    def setUp(self):
        self.robot = ElementTree.parse(MODELS / "wsg50/wsg50.urdf").getroot()

    def test_stroke_and_mass(self):
        fingers = [j for j in self.robot.iterfind("joint") if j.get("type") == "prismatic"]
        self.assertEqual([numbers(j.find("axis"), "xyz", "")[0] for j in fingers], [1, -1])
        self.assertEqual(sum(float(j.find("limit").get("upper")) for j in fingers), 0.110)
        self.assertEqual(sum(float(j.find("limit").get("effort")) for j in fingers), 80)
        total = sum(float(m.get("value")) for m in self.robot.iterfind("link/inertial/mass"))
        self.assertAlmostEqual(total, 1.2, places=9)

    def test_inertias_are_those_of_the_geometry_and_mirrored(self):
        geometry = json.loads((MODELS / "wsg50/geometry.json").read_text())
        centres = {}
        for link in [one for one in self.robot.iterfind("link") if one.find("inertial") is not None]:
            _, centre, computed = make_meshes.link_inertia(link, geometry)
            centres[link.get("name")] = numbers(link.find("inertial/origin"), "xyz", "0 0 0")
            for c, w in zip(centre, centres[link.get("name")]):
                self.assertAlmostEqual(c, w, delta=1e-4)
            for c, k in zip(computed, TENSOR):
                self.assertAlmostEqual(c, float(link.find("inertial/inertia").get(k)), delta=0.002 * max(computed))
        self.assertEqual(centres["finger_left"][0], -centres["finger_right"][0])

    def test_pads_meet_when_closed(self):
        geometry = json.loads((MODELS / "wsg50/geometry.json").read_text())
        left, right = ([p[0] for s in make_meshes.solids_of(geometry["meshes"][f"finger_{side}_pad"], {})
                        for p in s.vertices] for side in ("left", "right"))
        self.assertAlmostEqual(min(left), 0, places=9)
        self.assertAlmostEqual(max(right), 0, places=9)


class Stack(unittest.TestCase):
    def test_sensor_and_probe(self):
        sensor = urdf_of(MODELS / "ft_gamma")
        total = sum(float(m.get("value")) for m in sensor.iterfind("link/inertial/mass"))
        self.assertAlmostEqual(total, 0.521, places=3)
        probe, device = urdf_of(MODELS / "probe_ball"), device_of(MODELS / "probe_ball")
        tcp = next(j for j in probe.iterfind("joint") if j.find("child").get("link") == device["tcp"])
        balls = [c for c in probe.iterfind("link/collision") if c.find("geometry/sphere") is not None]
        self.assertEqual(len(balls), 1)
        self.assertEqual(float(balls[0].find("geometry/sphere").get("radius")), device["ball_radius_m"])
        self.assertEqual(numbers(balls[0].find("origin"), "xyz", "0 0 0"), numbers(tcp.find("origin"), "xyz", "0 0 0"))

    def test_texts_name_no_place_of_one_machine(self):
        for path in [p for folder in FOLDERS for p in folder.glob("*.*")]:
            self.assertIsNone(re.search(r"/(home|tmp|work|usr)/", path.read_text()), path.name)


class YoubotBase(unittest.TestCase):
    FOLDER = MODELS / "youbot_base"

    def setUp(self):
        self.device, self.robot = device_of(self.FOLDER), urdf_of(self.FOLDER)

    def test_mass_is_that_of_the_source(self):
        total = sum(float(m.get("value")) for m in self.robot.iterfind("link/inertial/mass"))
        self.assertAlmostEqual(total, 22 + 2.4 + 4 * 1.4, places=9)

    def test_wheels_stand_on_the_floor_where_the_drive_says(self):
        drive = self.device["drive"]
        joints = {j.get("name"): j for j in self.robot.iterfind("joint")}
        for name, ahead, left in zip(drive["wheels"], (1, 1, -1, -1), (1, -1, 1, -1)):
            x, y, z = numbers(joints[name].find("origin"), "xyz", "0 0 0")
            self.assertAlmostEqual(x, ahead * drive["wheelbase_m"] / 2)
            self.assertAlmostEqual(y, left * drive["track_m"] / 2)
            self.assertAlmostEqual(z, drive["wheel_radius_m"])

    def test_rollers_are_as_high_as_the_wheel_and_cross_as_an_x_from_above(self):
        geometry = json.loads((self.FOLDER / "geometry.json").read_text())
        for mesh, sign in (("rollers_left", 1), ("rollers_right", -1)):
            solids = make_meshes.solids_of(geometry["meshes"][mesh], geometry["curves"])
            for solid in solids:
                highest = max(math.hypot(x, z) for x, _, z in solid.vertices)
                self.assertAlmostEqual(highest, self.device["drive"]["wheel_radius_m"], delta=0.0005)
            top = max(solids, key=lambda s: sum(p[2] for p in s.vertices) / len(s.vertices))
            middle = [sum(c) / len(top.vertices) for c in zip(*top.vertices)]
            cross = sum((p[0] - middle[0]) * (p[1] - middle[1]) for p in top.vertices)
            self.assertGreater(sign * cross, 0, "on the left in front the upper rollers point ahead and to the left")


if __name__ == "__main__":
    unittest.main()
