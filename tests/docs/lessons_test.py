#!/usr/bin/env python3
"""The lessons run, and their pages say what comes of it: every command below "Try it" ends as the line after it says, every
excerpt is a part of its file, every lesson has a page, a picture and a row in the table.
"""
import json
import pathlib
import re
import shlex
import struct
import subprocess
import sys
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = ROOT / "docs/lessons"
FILES = sorted((ROOT / "scenarios/lessons").glob("*.json"))
EXCERPT = re.compile(r"<!-- part: (\S+) -->\n```json\n(.*?)```", re.DOTALL)
TRY = re.compile(r"^\$ \./takt (run .*)\n(passed|failed|refused|error)\b", re.MULTILINE)
PICTURE = re.compile(r'!\[([^\]]+)\]\((images/\S+\.jpg) "at ([\d.]+) s"\)')
STATUS = {"passed": 0, "failed": 1, "refused": 2, "error": 3}
LARGEST_PICTURE = 40_000  # bytes


def takt(*arguments):
    return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=ROOT)


def page_of(file):
    return PAGES / f"{file.stem}.md"


def at(document, pointer):
    for key in pointer.strip("/").split("/"):
        document = document[int(key)] if isinstance(document, list) else document[key]
    return document


def jpeg_size(data):
    """Width and height as its frame header says."""
    i = 2
    while data[i] == 0xFF:
        marker, length = data[i + 1], struct.unpack(">H", data[i + 2:i + 4])[0]
        if 0xC0 <= marker <= 0xC2:
            height, width = struct.unpack(">HH", data[i + 5:i + 9])
            return width, height
        i += 2 + length
    raise ValueError("no frame header")


class Lessons(unittest.TestCase):
    def test_they_are_twenty_one_and_numbered_without_a_gap(self):
        self.assertEqual([file.stem[:3] for file in FILES], [f"{n:02}-" for n in range(1, 22)])
        self.assertEqual([page_of(file) for file in FILES], sorted(PAGES.glob("[0-9]*.md")), "a page for each, and no other")

    def test_the_table_has_a_row_for_each(self):
        rows = re.findall(r"^\| \[(\d+)\]\((\S+)\) \| .+ \|$", (PAGES / "README.md").read_text(), re.MULTILINE)
        self.assertEqual(rows, [(str(n), f"{file.stem}.md") for n, file in enumerate(FILES, 1)])

    def test_a_page_has_the_title_and_parts_of_its_file(self):
        for file in FILES:
            with self.subTest(file.name):
                document, text = json.loads(file.read_text()), page_of(file).read_text()
                self.assertEqual(text.splitlines()[0], f"# {document['title']}")
                excerpts = EXCERPT.findall(text)
                self.assertTrue(excerpts)
                for pointer, excerpt in excerpts:
                    self.assertEqual(json.loads(excerpt), at(document, pointer), pointer)

    def test_a_page_has_a_picture_of_its_run(self):
        for file in FILES:
            with self.subTest(file.name):
                pictures = PICTURE.findall(page_of(file).read_text())
                self.assertEqual([name for _, name, _ in pictures], [f"images/{file.stem}.jpg"])
                data = (PAGES / pictures[0][1]).read_bytes()
                self.assertLess(len(data), LARGEST_PICTURE)
                self.assertEqual(jpeg_size(data), (640, 360))

    def test_each_is_valid_without_an_error(self):
        for file in FILES:
            with self.subTest(file.name):
                check = takt("validate", file)
                self.assertEqual(check.returncode, 0, check.stderr)

    def test_every_command_of_a_page_ends_as_the_page_says(self):
        for file in FILES:
            tries = TRY.findall(page_of(file).read_text())
            commands = re.findall(r"^\$ .*$", page_of(file).read_text(), re.MULTILINE)
            self.assertEqual(len(tries), len(commands), f"{file.name}: a command without what comes of it")
            self.assertGreater(len(tries), 1, file.name)
            self.assertEqual(tries[0], (f"run scenarios/lessons/{file.name}", "passed"))
            for command, said in tries:
                with self.subTest(command):
                    run = takt(*shlex.split(command), "--json")
                    self.assertEqual(run.returncode, STATUS[said], run.stdout[-1000:] + run.stderr[-1000:])
                    if said in ("passed", "failed"):
                        verdicts = [one["passed"] for one in json.loads(run.stdout)["expectations"]]
                        self.assertTrue(verdicts)
                        self.assertEqual(all(verdicts), said == "passed")


if __name__ == "__main__":
    unittest.main()
