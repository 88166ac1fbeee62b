#!/usr/bin/env python3
"""takt net from outside: the picture holds every primitive and link, and nothing runs through a box; the net of a scenario's
step; what a net costs; bad input.

Usage: net_test.py TAKT
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
SVG = "{http://www.w3.org/2000/svg}"

FIVE = {
    "name": "five",
    "primitives": [
        {"id": "time", "type": "Stopwatch", "parameters": {"running": True}},
        {"id": "late", "type": "GreaterThan", "parameters": {"b": 1.5}},
        {"id": "cancel", "type": "Cancel"},
        {"id": "either", "type": "Or"},
        {"id": "end", "type": "Termination"},
    ],
    "links": [
        {"from": "time.elapsed", "to": "late.a"},
        {"from": "late.value", "to": "either.a"},
        {"from": "cancel.requested", "to": "either.b"},
        {"from": "either.value", "to": "end.condition"},
    ],
}


def gate(number):
    """A fragment that counts while it is active, with a fragment in it."""
    inner = {"name": "", "primitives": [{"id": "count", "type": "CycleCounter", "parameters": {"counted": True}}], "links": []}
    return {
        "id": f"part{number}",
        "net": {
            "name": "",
            "primitives": [{"id": "time", "type": "Stopwatch", "parameters": {"running": True}},
                           {"id": "late", "type": "GreaterThan", "parameters": {"b": 0.01 * number}}],
            "links": [{"from": "time.elapsed", "to": "late.a"}],
            "fragments": [{"id": "inner", "net": inner, "inputs": [], "outputs": [{"port": "count", "from": "count.count"}]}],
        },
        "inputs": [],
        "outputs": [{"port": "late", "from": "late.value"}, {"port": "count", "from": "inner.count"}],
    }


def nested():
    net = json.loads(json.dumps(FIVE))
    net["name"] = "nested"
    net["fragments"] = [gate(1), gate(2)]
    net["primitives"] += [{"id": "delayed", "type": "Or"}, {"id": "shown", "type": "MonitorInteger"},
                          {"id": "flag", "type": "MonitorBoolean"}]
    net["links"] += [{"from": "late.value", "to": "part1.active"}, {"from": "part1.late", "to": "part2.active"},
                     {"from": "part2.count", "to": "shown.value"}, {"from": "part2.late", "to": "delayed.a"},
                     {"from": "delayed.value", "to": "delayed.b", "delayed": True, "initial": False},
                     {"from": "delayed.value", "to": "flag.value"}]
    return net


def chain(count, fragments_of=None):
    """Additions in a row, each also reading one far behind it; in fragments if asked for."""
    add = lambda i: {"id": f"a{i}", "type": "Add", "parameters": {"b": 1.0} if i < 7 or fragments_of else {}}
    tail = [{"id": "late", "type": "GreaterThan", "parameters": {"b": 1e9}}, {"id": "end", "type": "Termination"},
            {"id": "source", "type": "Stopwatch", "parameters": {"running": True}}]
    net = {"name": f"chain of {count}", "primitives": tail, "links": [{"from": "late.value", "to": "end.condition"}]}
    if not fragments_of:
        net["primitives"] += [add(i) for i in range(count - 3)]
        net["links"] += [{"from": f"a{i}.value" if i >= 0 else "source.elapsed", "to": f"a{i + 1}.a"} for i in range(-1, count - 4)]
        net["links"] += [{"from": f"a{i - 7}.value", "to": f"a{i}.b"} for i in range(7, count - 3)]
        net["links"].append({"from": f"a{count - 4}.value", "to": "late.a"})
        return net
    net["fragments"] = []
    before = "source.elapsed"
    for f in range(count // fragments_of):
        inner = {"name": "", "primitives": [add(i) for i in range(fragments_of)],
                 "links": [{"from": f"a{i}.value", "to": f"a{i + 1}.a"} for i in range(fragments_of - 1)]}
        net["fragments"].append({"id": f"f{f}", "net": inner, "inputs": [{"port": "in", "to": "a0.a"}],
                                 "outputs": [{"port": "out", "from": f"a{fragments_of - 1}.value"}]})
        net["links"].append({"from": before, "to": f"f{f}.in"})
        before = f"f{f}.out"
    net["links"].append({"from": before, "to": "late.a"})
    return net


class Picture:
    """An SVG as boxes and sampled curves."""

    def __init__(self, file):
        root = xml.etree.ElementTree.parse(file).getroot()
        self.text = " ".join(one.text or "" for one in root.iter(SVG + "text"))
        self.cards, self.wires, self.frames = {}, [], {}
        for group in root.iter(SVG + "g"):
            if group.get("class") == "card":
                self.cards[group.get("data-id")] = self.box(group.find(SVG + "rect"))
        for path in root.iter(SVG + "path"):
            if path.get("class") == "wire":
                self.wires.append((path.get("data-wire"), self.curve(path.get("d")), path))
        for rect in root.iter(SVG + "rect"):
            if rect.get("class") == "frame":
                self.frames[rect.get("data-id")] = self.box(rect)

    @staticmethod
    def box(rect):
        x, y, w, h = (float(rect.get(key)) for key in ("x", "y", "width", "height"))
        return x, y, x + w, y + h

    @staticmethod
    def curve(d):
        points = [tuple(map(float, pair.split(","))) for pair in re.findall(r"-?[\d.]+,-?[\d.]+", d)]
        samples = []
        for i in range(0, len(points) - 3, 3):
            p = points[i:i + 4]
            for k in range(40):
                t = k / 40
                b = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3)
                samples.append(tuple(sum(b[j] * p[j][c] for j in range(4)) for c in (0, 1)))
        return samples + [points[-1]]

    def overlaps(self):
        """Pairs of cards that cover each other."""
        found = []
        cards = sorted(self.cards.items(), key=lambda one: one[1])
        for i, (a, p) in enumerate(cards):
            for b, q in cards[i + 1:]:
                if q[0] >= p[2]:
                    break
                if p[1] < q[3] and q[1] < p[3]:
                    found.append((a, b))
        return found

    def crossings(self, margin=2.0):
        """Wires that run through a card."""
        found = []
        for name, samples, _ in self.wires:
            for card, (x0, y0, x1, y1) in self.cards.items():
                if any(x0 + margin < x < x1 - margin and y0 + margin < y < y1 - margin for x, y in samples):
                    found.append((name, card))
        return found


class NetTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)
        self.addCleanup(self.folder.cleanup)

    def write(self, net, name="net.json"):
        file = self.path / name
        file.write_text(json.dumps(net))
        return file

    def takt(self, *arguments, status=0):
        done = subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=ROOT)
        self.assertEqual(done.returncode, status, done.stdout[-3000:] + done.stderr[-3000:])
        return done

    def draw(self, *arguments):
        out = self.path / "net.svg"
        self.takt("net", *arguments, "--graph", out)
        return Picture(out)


class Graph(NetTest):
    def test_five_primitives(self):
        picture = self.draw(self.write(FIVE))
        self.assertEqual(set(picture.cards), {one["id"] for one in FIVE["primitives"]})
        self.assertEqual({name for name, _, _ in picture.wires}, {f"{one['from']}|{one['to']}" for one in FIVE["links"]})
        self.assertEqual(picture.overlaps(), [])
        self.assertEqual(picture.crossings(), [])
        for text in ("five", "Stopwatch", "b = 1.5", "slowest reaction"):
            self.assertIn(text, picture.text)
        self.assertLess(picture.cards["time"][0], picture.cards["late"][0], "from left to right")
        self.assertEqual(max(picture.cards, key=lambda one: picture.cards[one][2]), "end", "the end stands rightmost")
        critical = [name for name, _, path in picture.wires if path.get("stroke-width") == "2.6"]
        self.assertIn("either.value|end.condition", critical)

    def test_fragments_are_frames_around_their_primitives(self):
        net = nested()
        picture = self.draw(self.write(net))
        self.assertEqual(set(picture.frames), {"part1", "part1/inner", "part2", "part2/inner"})
        for card, (x0, y0, x1, y1) in picture.cards.items():
            around = card.rpartition("/")[0] or (card[:-len(".active")] if card.endswith(".active") else "")
            for frame, (fx0, fy0, fx1, fy1) in picture.frames.items():
                inside = fx0 <= x0 and x1 <= fx1 and fy0 <= y0 and y1 <= fy1
                belongs = around == frame or around.startswith(frame + "/")
                self.assertEqual(inside, belongs, f"{card} in {frame}")
        self.assertEqual(picture.crossings(), [])
        delayed = [path for name, _, path in picture.wires if name == "delayed.value|delayed.b"]
        self.assertTrue(delayed[0].get("stroke-dasharray"))
        self.assertIn("may rest", picture.text)
        self.assertIn("delayed by one cycle", picture.text)

    def test_the_net_of_a_step_of_a_scenario(self):
        steps = json.loads(self.takt("net", "scenarios/touch.json", "--json").stdout)["steps"]
        self.assertIn("touch the top", [one["step"] for one in steps])
        dumped = self.path / "dumped.json"
        picture = self.draw("scenarios/touch.json", "--step", "touch the top", "--dump", dumped)
        report = json.loads(self.takt("net", dumped, "--scenario", "scenarios/touch.json", "--json").stdout)
        self.assertEqual({one["id"] for one in report["primitives"]}, set(picture.cards))
        self.assertEqual(len(report["links"]), len(picture.wires))
        listed = [one["primitives"] for one in steps if one["step"] == "touch the top"]
        self.assertEqual(listed, [len(report["primitives"])], "the list counts what the net counts")
        self.assertIn("null can reach a stop or a device", picture.text)
        self.assertEqual(picture.overlaps(), [])
        self.assertEqual(picture.crossings(), [])

    def test_labels_are_free_of_escapes(self):
        """Ids of channels cannot have '/' and write it as %2f; people see the name."""
        picture = self.draw("scenarios/touch.json", "--step", "touch the top")
        self.assertNotIn("%2f", picture.text)
        self.assertIn("operator/override", picture.text)
        self.assertTrue(any("%2f" in one for one in picture.cards), "ids stay as they are in the net")

    def test_three_hundred(self):
        picture = self.draw(self.write(chain(300)))
        self.assertEqual(len(picture.cards), 300)
        self.assertEqual(picture.overlaps(), [])
        self.assertEqual(picture.crossings(), [])

    def test_many_are_drawn_as_closed_fragments(self):
        picture = self.draw(self.write(chain(10000, fragments_of=100)))
        self.assertEqual(len(picture.cards), 103)
        self.assertIn("fragment of 100 primitives", picture.text)

    def test_too_many_are_an_error(self):
        refused = self.takt("net", self.write(chain(10000)), "--graph", self.path / "net.svg", status=2)
        self.assertRegex(refused.stderr, r"10000 .*1000.* \[too-large\]")


class Bench(NetTest):
    def test_cost_of_a_cycle_and_of_each_primitive(self):
        shown = self.takt("net", self.write(chain(300)), "--bench", "--seconds", "0.5", "--json")
        bench = json.loads(shown.stdout)["bench"]
        self.assertEqual(len(bench["primitives"]), 300)
        self.assertAlmostEqual(sum(one["share"] for one in bench["primitives"]), 1.0, places=6)
        means = [one["ns"]["mean"] for one in bench["primitives"]]
        self.assertEqual(means, sorted(means, reverse=True), "the dearest first")
        self.assertGreater(bench["cycle_ns"], 0)
        self.assertLessEqual(bench["cycle"]["p50"], bench["cycle"]["p99"])
        self.assertLessEqual(bench["cycle"]["p99"], bench["cycle"]["largest"])
        text = self.takt("net", self.write(FIVE), "--bench", "--seconds", "0.1").stdout
        self.assertIn("cycles a second", text)

    def test_what_costs_more_is_seen_to(self):
        """One primitive that does inverse kinematics costs more than all arithmetic around it."""
        shown = self.takt("net", "scenarios/touch.json", "--step", "touch the top", "--bench", "--seconds", "0.5", "--json")
        bench = json.loads(shown.stdout)["bench"]
        self.assertEqual(bench["primitives"][0]["type"], "InverseKinematics")
        self.assertEqual(bench["ended"], "")


class Check(NetTest):
    def test_tables(self):
        text = self.takt("net", self.write(nested())).stdout
        for words in ("reaction certificate", "order of evaluation", "part2/inner/count"):
            self.assertIn(words, text)
        report = json.loads(self.takt("net", self.write(FIVE), "--check", "--json").stdout)
        self.assertEqual(len(report["primitives"]), 5)
        for key in ("order", "resources", "reactions", "null_paths", "links", "diagnostics"):
            self.assertIn(key, report)

    def test_bad_input(self):
        unknown = self.takt("net", "scenarios/touch.json", "--step", "touch teh top", status=2)
        self.assertRegex(unknown.stderr, r"'touch the top'.* \[unknown-name\]")
        self.assertIn("[invalid-value]", self.takt("net", self.write(FIVE), "--step", "a", status=2).stderr)
        lost = self.takt("net", self.write(FIVE), "--graph", self.path / "no" / "net.svg", status=2)
        self.assertIn("[file-not-writable]", lost.stderr)
        for option in (["--graph", self.path / "a.svg"], ["--dump", self.path / "a.json"], ["--bench"]):
            unnamed = self.takt("net", "scenarios/touch.json", *option, status=2)
            self.assertRegex(unnamed.stderr, rf"{option[0]}: error: .*--step NAME.* \[requires\]")


if __name__ == "__main__":
    unittest.main(verbosity=2)
