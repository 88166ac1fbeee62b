#!/usr/bin/env python3
"""The pages of docs/ do what they say: the generated reference is up to date, the tutorial runs step by step, and every
example of a how-to page is accepted.

A comment before a JSON block says what the block is: '<!-- file -->' the whole file, '<!-- merge: POINTER -->' keys that are
added, '<!-- set: POINTER -->' a new value, '<!-- complete -->' what the file is in the end, '<!-- steps: FILE -->' a program
for the cell of a scenario, '<!-- cell: FILE -->' keys that are added to a scenario.
"""
import copy
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"(?:<!-- (\w+)(?:: (\S+))? -->\n)?```json\n(.*?)```", re.DOTALL)


def takt(*arguments):
    return subprocess.run([str(TAKT), *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=ROOT)


def blocks(page):
    """The JSON blocks of a page: what to do with each, its target, its content."""
    return [(action, target, json.loads(text)) for action, target, text in BLOCK.findall(page.read_text())]


def merge(into, what):
    for key, value in what.items():
        if isinstance(value, dict) and isinstance(into.get(key), dict):
            merge(into[key], value)
        else:
            into[key] = copy.deepcopy(value)


def parent_of(document, pointer):
    keys = pointer.strip("/").split("/")
    for key in keys[:-1]:
        document = document[key]
    return document, keys[-1]


def at(document, pointer):
    for key in filter(None, pointer.split("/")):
        document = document[key]
    return document


def without_lines(diagnostic):
    """Line and column depend on how a file is laid out."""
    return re.sub(r"json:\d+:\d+:", "json:", diagnostic).strip()


class Search(unittest.TestCase):
    def test_one_file_has_every_section_and_every_link_leads_somewhere(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "docs.html"
            subprocess.run(["/usr/bin/python3", "-B", str(ROOT / "docs/make_search.py"), str(out)], check=True)
            page = out.read_text()
        ids, links = set(re.findall(r'id="([^"]+)"', page)), set(re.findall(r'href="#([^"]+)"', page))
        self.assertEqual(links - ids, set())
        self.assertGreater(len(links), 100)
        for file in (ROOT / "docs").rglob("*.md"):
            self.assertIn(f'id="{file.relative_to(ROOT / "docs").as_posix().replace("/", "-").removesuffix(".md")}"', page)
        self.assertNotRegex(page, r'<(script|link|img)[^>]*(src|href)="(http|//)', "nothing is loaded from elsewhere")
        self.assertEqual(re.findall(r'<img[^>]*src="(?!data:image/)', page), [], "pictures are in the file")
        section = re.search(r'<section id="film-failures">.*?</section>', page, re.DOTALL).group(0)
        self.assertIn("a second longer", section)


class Generated(unittest.TestCase):
    def test_the_reference_of_scenario_files_is_what_the_script_prints(self):
        printed = subprocess.run([sys.executable, "-B", str(ROOT / "schemas/make_reference.py")], capture_output=True, text=True, check=True)
        self.assertEqual((ROOT / "docs/scenario-reference.md").read_text(), printed.stdout,
                         "run: python3 schemas/make_reference.py > docs/scenario-reference.md")

    def test_the_schema_is_what_the_program_prints(self):
        checked = subprocess.run([sys.executable, "-B", str(ROOT / "schemas/make_schema.py"), "--check", str(TAKT)],
                                 capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, "run: python3 schemas/make_schema.py " + checked.stderr)

    def test_references_in_the_schema_lead_somewhere_and_each_definition_is_used(self):
        schema = json.loads((ROOT / "schemas/scenario.schema.json").read_text())
        used = set(re.findall(r'"#/definitions/(\w+)"', json.dumps(schema)))
        self.assertEqual(used - set(schema["definitions"]), set())
        self.assertEqual(set(schema["definitions"]) - used, set(), "definitions that nothing refers to")

    def test_every_row_of_the_reference_has_a_meaning(self):
        for row in re.findall(r"^\| `.*$", (ROOT / "docs/scenario-reference.md").read_text(), re.MULTILINE):
            self.assertNotRegex(row, r"\|\s*\|$")


class FaultTable(unittest.TestCase):
    def test_each_test_that_the_table_of_faults_names_is_there(self):
        text = (ROOT / "docs/testing.md").read_text()
        table = text[text.index("## Faults and what must come of them"):]
        table = table[:table.index("\n## ", 1)]
        rows = [line for line in table.splitlines() if line.startswith("| ") and not line.startswith("| fault |")]
        self.assertGreater(len(rows), 25)
        sources = "\n".join(file.read_text() for pattern in ("*.cc", "*.py", "CMakeLists.txt") for file in (ROOT / "tests").rglob(pattern))
        known = set(re.findall(r"\bTEST(?:_F|_P)?\((\w+),\s*(\w+)\)", sources))
        for row in rows:
            names = re.findall(r"`([^`]+)`", row.split("|")[3])
            self.assertTrue(names, row)
            for name in names:
                if "." in name and " " not in name:
                    self.assertIn(tuple(name.split(".")), known, row)
                elif name.startswith("test_"):
                    self.assertIn(f"def {name}(", sources, row)
                elif name.startswith("fuzz_"):
                    self.assertIn(f"takt_fuzz({name[5:-6]} ", sources, row)
                elif " " not in name:
                    self.assertIn(name, sources, row)


class Tutorial(unittest.TestCase):
    PAGE = ROOT / "docs/tutorial.md"

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "plinth.json"

    def states(self):
        """The file after each block, and the complete file that the page shows."""
        document, states, complete = {}, [], None
        for action, target, content in blocks(self.PAGE):
            if action == "complete":
                complete = content
                continue
            if action == "file":
                document = content
            elif action == "merge":
                merge(at(document, target), content)
            elif action == "set":
                parent, key = parent_of(document, target)
                parent[key] = content
            else:
                self.fail(f"a block without a comment that says what it is: {content}")
            states.append(copy.deepcopy(document))
        return states, complete

    def run_file(self, document, *options):
        self.file.write_text(json.dumps(document))
        return takt("run", self.file, "--json", *options)

    def test_every_step_leaves_a_file_that_runs(self):
        states, _ = self.states()
        self.assertGreater(len(states), 8)
        for state in states:
            run = self.run_file(state)
            self.assertEqual((run.returncode, json.loads(run.stdout)["result"]), (0, "passed"), run.stderr)

    def test_the_steps_lead_to_the_complete_file(self):
        states, complete = self.states()
        self.assertEqual(states[-1], complete)

    def test_what_the_page_says_of_mistakes_is_true(self):
        said = re.findall(r"^plinth\.json(.*)$", self.PAGE.read_text(), re.MULTILINE)
        _, complete = self.states()
        misspelt = copy.deepcopy(complete)
        misspelt["program"]["steps"][2]["until"]["sensor"] = "wirst"
        for document, expected in (({}, said[0]), (misspelt, said[1])):
            self.file.write_text(json.dumps(document))
            check = takt("validate", self.file)
            self.assertEqual((check.returncode, without_lines(check.stderr)), (2, without_lines(f"{self.file}{expected}")))

    def test_what_the_page_says_of_other_values_is_true(self):
        states, complete = self.states()
        out_of_reach = self.run_file(states[0], "--set", "/program/steps/0/to/by_m=[0,0,2]")
        self.assertEqual(out_of_reach.returncode, 2)
        self.assertIn("/program/steps/0", out_of_reach.stderr)
        without_contact = self.run_file(complete, "--set", "/program/steps/2/to/by_m=[0,0,-0.01]", "--set", "/seed=3")
        self.assertEqual(without_contact.returncode, 3, without_contact.stdout)
        self.assertEqual(self.run_file(complete, "--seed", "4").returncode, 0)
        too_fast = self.run_file(complete, "--set", "/program/steps/2/velocity_m_s=0.05")
        self.assertEqual((too_fast.returncode, json.loads(too_fast.stdout)["result"]), (1, "failed"))


class HowTo(unittest.TestCase):
    """Every JSON block of a how-to page is accepted in the cell of the scenario that the comment before it names."""

    def document(self, action, target, content):
        document = json.loads((ROOT / target).read_text())
        for name, net in document.get("nets", {}).items():
            document["nets"][name] = json.loads((ROOT / target).parent.joinpath(net).read_text())
        if action == "cell":
            if "program" in content:
                document.pop("program")
            merge(document, content)
            return document
        self.assertEqual(action, "steps", f"a block without a comment that says what it is: {content}")
        for key in ("expectations", "operator", "faults"):
            document.pop(key, None)
        document.get("film", {}).pop("cuts", None)
        document["program"] = {"do": "sequence", "steps": content if isinstance(content, list) else [content]}
        return document

    def test_examples_are_accepted(self):
        pages = sorted((ROOT / "docs/how-to").glob("*.md"))
        self.assertGreater(len(pages), 10)
        with tempfile.TemporaryDirectory() as folder:
            checked = 0
            for page in pages:
                for number, (action, target, content) in enumerate(blocks(page)):
                    file = pathlib.Path(folder) / f"{page.stem}-{number}.json"
                    file.write_text(json.dumps(self.document(action, target, content)))
                    check = takt("validate", file)
                    self.assertEqual(check.returncode, 0, f"{page.name}, block {number}:\n{check.stderr}")
                    checked += 1
            self.assertGreater(checked, 20)


if __name__ == "__main__":
    unittest.main()
