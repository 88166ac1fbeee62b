#!/usr/bin/env python3
"""Makes the visual meshes of the models from a few lines of dimensions.

Each models/NAME/geometry.json lists meshes; a mesh is a list of closed solids (lathe, loft, box, extrude), see
docs/models.md. Output: models/NAME/meshes/MESH.obj with normals, in metres. The same input gives the
same bytes.

  make_meshes.py                  all models beside this script
  make_meshes.py DIR...           these model folders
  make_meshes.py --inertia DIR    prints mass, centre and inertia of each link of DIR's URDF, its meshes taken as solids
                                  of uniform density scaled to the link's mass
"""
import json
import math
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

CREASE = math.radians(40)  # 24 segments bend by 15 degrees, bevels by 45


class Solid:
    """A closed surface: vertices [(x, y, z)] and triangles [(i, j, k)], counter-clockwise seen from outside."""

    def __init__(self):
        self.vertices = []
        self.triangles = []

    def ring(self, points):
        """Adds points (one alone is a pole) and returns their indices."""
        first = len(self.vertices)
        self.vertices.extend(points)
        return list(range(first, first + len(points)))

    def bridge(self, lower, upper):
        """Joins two rings of equal length, or a ring and a pole; `upper` is further along the solid's axis."""
        n = max(len(lower), len(upper))
        for i in range(n):
            j = (i + 1) % n
            if len(lower) == 1:
                self.triangles.append((lower[0], upper[j], upper[i]))
            elif len(upper) == 1:
                self.triangles.append((lower[i], lower[j], upper[0]))
            else:
                self.triangles.append((lower[i], lower[j], upper[j]))
                self.triangles.append((lower[i], upper[j], upper[i]))


def stack(rings):
    """Closed solid from rings along an axis; the first and the last are poles."""
    solid = Solid()
    indices = [solid.ring(points) for points in rings]
    for lower, upper in zip(indices, indices[1:]):
        solid.bridge(lower, upper)
    return solid


def lathe(spec):
    """Turns points [[r, z], ...] about z. Ends off the axis are closed by a flat face."""
    points, segments = list(spec["points"]), spec.get("segments", 24)
    if points[0][0] > 0:
        points.insert(0, [0, points[0][1]])
    if points[-1][0] > 0:
        points.append([0, points[-1][1]])

    def ring(r, z):
        if r == 0:
            return [(0.0, 0.0, z)]
        angles = [2 * math.pi * i / segments for i in range(segments)]
        return [(r * math.cos(a), r * math.sin(a), z) for a in angles]

    return stack([ring(r, z) for r, z in points])


def sphere(spec):
    """A ball about the origin."""
    radius, segments = spec["radius"], spec.get("segments", 24)
    angles = [math.pi * k / (segments // 2) for k in range(1, segments // 2)]
    points = [[0, -radius]] + [[radius * math.sin(a), -radius * math.cos(a)] for a in angles] + [[0, radius]]
    return lathe({"points": points, "segments": segments})


def spline(values, steps):
    """Catmull-Rom curve through rows of numbers, passing each; steps[i] pieces between row i and row i + 1."""
    rows = [values[0]] + values + [values[-1]]
    result = []
    for p, q, r, s, pieces in zip(rows, rows[1:], rows[2:], rows[3:], steps):
        for k in range(pieces):
            t = k / pieces
            weights = (-t + 2 * t**2 - t**3, 2 - 5 * t**2 + 3 * t**3, t + 4 * t**2 - 3 * t**3, t**3 - t**2)
            result.append([sum(w * v for w, v in zip(weights, column)) / 2 for column in zip(p, q, r, s)])
    return result + [list(values[-1])]


def loft(spec):
    """A shell between two curves in the y-z plane: rows [inner y, inner z, outer y, outer z, half width, exponent].

    Each row is a section: a superellipse whose one axis is the chord from inner to outer, the other is x. A straight
    piece of tube down to z = -length is put in front of the first row. Both ends get a bevel and a flat face.
    """
    rows, segments, bevel = spec["rows"], spec.get("segments", 24), spec.get("bevel", 0.001)
    curve = spline(rows, spec.get("steps", [1] * (len(rows) - 1)))
    if "length" in spec:
        y_in, _, y_out, _, width, exponent = rows[0]
        curve.insert(0, [y_in, -spec["length"], y_out, -spec["length"], width, exponent])

    def power(x, exponent):
        return math.copysign(abs(x) ** (2 / exponent), x)

    def section(row, shrink, shift):
        y_in, z_in, y_out, z_out, width, exponent = row
        chord_y, chord_z = (y_out - y_in) / 2, (z_out - z_in) / 2
        size = math.hypot(chord_y, chord_z)
        centre_y, centre_z = (y_in + y_out) / 2 - shift * chord_z / size, (z_in + z_out) / 2 + shift * chord_y / size
        points = []
        for i in range(segments):
            a = 2 * math.pi * i / segments
            u = power(math.sin(a), exponent) * (1 - shrink / size)
            points.append((power(math.cos(a), exponent) * (width - shrink), centre_y + chord_y * u,
                           centre_z + chord_z * u))
        return points, [(0.0, centre_y, centre_z)]

    first, first_pole = section(curve[0], bevel, -bevel)
    last, last_pole = section(curve[-1], bevel, bevel)
    middle = [section(row, 0, 0)[0] for row in curve]
    return stack([first_pole, first] + middle + [last, last_pole])


def inset(outline, distance):
    """The convex outline with each edge moved inwards."""
    result = []
    for before, corner, after in zip(outline[-1:] + outline, outline, outline[1:] + outline[:1]):
        edges = ((before, corner), (corner, after))
        (ax, ay), (bx, by) = (((q[1] - p[1]) / math.dist(p, q), (p[0] - q[0]) / math.dist(p, q)) for p, q in edges)
        f = distance / (1 + ax * bx + ay * by)
        result.append([corner[0] - f * (ax + bx), corner[1] - f * (ay + by)])
    return result


def extrude(spec):
    """A convex polygon [[x, y], ...], counter-clockwise, from z[0] to z[1]; its edges there are bevelled."""
    outline, (low, high), bevel = spec["polygon"], spec["z"], spec.get("bevel", 0.0)
    x, y = (sum(c) / len(outline) for c in zip(*outline))

    def ring(distance, z):
        return [(px, py, z) for px, py in inset(outline, distance)]

    rings = [[(x, y, low)], ring(0, low + bevel), ring(0, high - bevel), [(x, y, high)]]
    if bevel > 0:
        rings[1:1], rings[-1:-1] = [ring(bevel, low)], [ring(bevel, high)]
    return stack(rings)


def box(spec):
    """A box of the given size about its centre; vertical edges rounded by `round`, the others bevelled."""
    x, y, z = (s / 2 for s in spec["size"])
    radius, bevel = spec.get("round", 0.0), spec.get("bevel", 0.0)
    if radius == 0:
        outline = [[-x, -y], [x, -y], [x, y], [-x, y]]
    else:
        outline = []
        for sx, sy, start in ((-1, -1, 180), (1, -1, 270), (1, 1, 0), (-1, 1, 90)):
            for k in range(4):
                a = math.radians(start + 30 * k)
                outline.append([sx * (x - radius) + radius * math.cos(a), sy * (y - radius) + radius * math.sin(a)])
    return extrude({"polygon": outline, "z": [-z, z], "bevel": bevel})


SHAPES = {"lathe": lathe, "sphere": sphere, "loft": loft, "extrude": extrude, "box": box}
AXES = {"z": lambda p: p, "y": lambda p: (p[1], p[2], p[0]), "x": lambda p: (p[2], p[0], p[1])}


def place(solid, spec):
    """Applies `mirror` (letters of axes), `axis` (the solid's z becomes that axis) and `at`, in this order."""
    signs = [-1 if letter in spec.get("mirror", "") else 1 for letter in "xyz"]
    turn, shift = AXES[spec.get("axis", "z")], spec.get("at", [0, 0, 0])
    moved = Solid()
    moved.vertices = [
        tuple(c + d for c, d in zip(turn(tuple(s * c for s, c in zip(signs, p))), shift)) for p in solid.vertices
    ]
    flipped = signs[0] * signs[1] * signs[2] < 0
    moved.triangles = [(i, k, j) if flipped else (i, j, k) for i, j, k in solid.triangles]
    return moved


def copies(solid, spec):
    """`tilt_deg` turns the solid about x; `around`: {count, radius, start_deg}: copies on a circle about z, the first at
    start_deg."""
    around = spec.get("around")
    if "tilt_deg" in spec:
        c, s = math.cos(math.radians(spec["tilt_deg"])), math.sin(math.radians(spec["tilt_deg"]))
        tilted = Solid()
        tilted.vertices = [(x, c * y - s * z, s * y + c * z) for x, y, z in solid.vertices]
        tilted.triangles, solid = solid.triangles, tilted
    if around is None:
        return [solid]
    result = []
    for k in range(around["count"]):
        a = 2 * math.pi * k / around["count"] + math.radians(around.get("start_deg", 0))
        c, s = math.cos(a), math.sin(a)
        copy = Solid()
        copy.vertices = [(c * (x + around["radius"]) - s * y, s * (x + around["radius"]) + c * y, z)
                         for x, y, z in solid.vertices]
        copy.triangles = solid.triangles
        result.append(copy)
    return result


def solids_of(parts, curves):
    """The solids of one mesh. A part names one shape; `rows`, `points`, `steps`, `polygon` may name a curve of the file."""
    result = []
    for part in parts:
        shape = next(key for key in SHAPES if key in part)
        spec = dict(part[shape])
        for key in ("rows", "points", "steps", "polygon"):
            if isinstance(spec.get(key), str):
                spec[key] = curves[spec[key]]
        for solid in copies(SHAPES[shape](spec), part):
            result.append(place(solid, part))
    return result


def direction(u, v, w):
    """Twice the area of triangle u v w times its outward normal."""
    a, b = [q - p for p, q in zip(u, v)], [q - p for p, q in zip(u, w)]
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def corner_normals(solid):
    """A unit normal for each corner of each triangle: the mean, weighted by area, of the faces around that vertex that
    bend away from this one by less than CREASE. So round shapes look round and edges stay sharp."""
    areas = [direction(*(solid.vertices[i] for i in triangle)) for triangle in solid.triangles]
    units = [[c / math.hypot(*n) for c in n] for n in areas]
    around = {}
    for face, triangle in enumerate(solid.triangles):
        for vertex in triangle:
            around.setdefault(vertex, []).append(face)
    result = []
    for face, triangle in enumerate(solid.triangles):
        corners = []
        for vertex in triangle:
            near = [f for f in around[vertex] if sum(p * q for p, q in zip(units[f], units[face])) > math.cos(CREASE)]
            total = [sum(c) for c in zip(*(areas[f] for f in near))]
            corners.append(tuple(c / math.hypot(*total) for c in total))
        result.append(corners)
    return result


def obj(solids):
    """Wavefront OBJ with normals. Rounded to 0.1 um, so that the text does not hang on the last bit of a sine."""
    points, normals, faces = {}, {}, []

    def index(table, row, digits):
        return table.setdefault(" ".join(f"{round(c, digits) + 0.0:.{digits}f}" for c in row), len(table) + 1)

    for solid in solids:
        places = [index(points, p, 7) for p in solid.vertices]
        for triangle, corners in zip(solid.triangles, corner_normals(solid)):
            pairs = [f"{places[v]}//{index(normals, n, 4)}" for v, n in zip(triangle, corners)]
            faces.append("f " + " ".join(pairs))
    lines = [f"v {p}" for p in points] + [f"vn {n}" for n in normals] + faces
    return ("\n".join(lines) + "\n").encode()


def make(folder):
    """Writes the meshes of one model; files that would not change keep their time stamp. @return triangle count."""
    geometry = json.loads((folder / "geometry.json").read_text())
    out = folder / "meshes"
    out.mkdir(exist_ok=True)
    total = 0
    for name, parts in geometry["meshes"].items():
        solids = solids_of(parts, geometry.get("curves", {}))
        total += sum(len(solid.triangles) for solid in solids)
        data = obj(solids)
        path = out / f"{name}.obj"
        if not path.exists() or path.read_bytes() != data:
            path.write_bytes(data)
    for path in sorted(out.iterdir()):
        if path.suffix in (".obj", ".stl") and path.stem + path.suffix not in [f"{n}.obj" for n in geometry["meshes"]]:
            path.unlink()
    return total


def moments(solids):
    """Volume, first moment and second moments (xx, yy, zz, xy, xz, yz) of solids of density 1 (signed tetrahedra)."""
    volume, first, second = 0.0, [0.0] * 3, [0.0] * 6
    for solid in solids:
        for i, j, k in solid.triangles:
            a, b, c = solid.vertices[i], solid.vertices[j], solid.vertices[k]
            det = (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                   a[2] * (b[0] * c[1] - b[1] * c[0]))
            volume += det / 6
            s = [p + q + r for p, q, r in zip(a, b, c)]
            for m in range(3):
                first[m] += det * s[m] / 24
            for m, (p, q) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
                second[m] += det * (s[p] * s[q] + a[p] * a[q] + b[p] * b[q] + c[p] * c[q]) / 120
    return volume, first, second


def link_inertia(link, geometry):
    """Mass (from the URDF), centre and inertia (ixx iyy izz ixy ixz iyz) about it, link axes.

    All meshes of the link are taken as solids of the same density; where the geometry's `mass_kg` names meshes of the
    link, those only, each uniform with its mass.
    """
    names = [pathlib.Path(m.get("filename")).stem for m in link.iterfind("visual/geometry/mesh")]
    masses = geometry.get("mass_kg", {})
    weighed = [n for n in names if n in masses] or names
    parts = [moments(solids_of(geometry["meshes"][n], geometry.get("curves", {}))) for n in weighed]
    densities = [masses.get(n, part[0]) / part[0] for n, part in zip(weighed, parts)]
    mass = float(link.find("inertial/mass").get("value"))
    scale = mass / sum(d * part[0] for d, part in zip(densities, parts))

    def total(which, index):
        return scale * sum(d * part[which][index] for d, part in zip(densities, parts))

    centre = [total(1, m) / mass for m in range(3)]
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    xx, yy, zz, xy, xz, yz = (total(2, m) - mass * centre[p] * centre[q] for m, (p, q) in enumerate(pairs))
    return mass, centre, (yy + zz, xx + zz, xx + yy, -xy, -xz, -yz)


def print_inertia(folder):
    geometry = json.loads((folder / "geometry.json").read_text())
    for link in ElementTree.parse(next(folder.glob("*.urdf"))).iterfind("link"):
        if link.find("inertial") is None or link.find("visual/geometry/mesh") is None:
            continue
        mass, centre, inertia = link_inertia(link, geometry)
        print(link.get("name"), f"mass {mass:g}", "centre", *(f"{c:.5f}" for c in centre))
        print("  inertia", *(f'{n}="{v:.7f}"' for n, v in zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), inertia)))


def main(arguments):
    here = pathlib.Path(__file__).resolve().parent
    if arguments[:1] == ["--inertia"]:
        for name in arguments[1:]:
            print_inertia(pathlib.Path(name))
        return 0
    folders = [pathlib.Path(a) for a in arguments] or sorted(p.parent for p in here.glob("*/geometry.json"))
    for folder in folders:
        print(f"{folder.name}: {make(folder)} triangles")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
