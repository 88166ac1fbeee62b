#!/usr/bin/env python3
"""Builds and runs the tests that belong to a name, and no more (called by './takt test NAME...').

    run_tests.py BUILD JOBS NAME[:FILTER]... [ctest options]
    run_tests.py BUILD JOBS --fast | --list

NAME is a test ('core_base', or the beginning 'proof_'), a folder ('core/rcc'), a source file ('core/base/json.cc') or a
file of tests ('tests/core/base/json_test.cc'). FILTER selects cases of a test program, as --gtest_filter does.
"""
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
ADDED = re.compile(r'^add_test\((?:\[=\[(.+?)\]=\]|"(.+?)"|(\S+)) (.*)\)$', re.MULTILINE)
SUITES = re.compile(r"^\s*(?:TYPED_)?TEST(?:_[FP])?\(\s*(\w+)", re.MULTILINE)
CASES = re.compile(r"^\s*(?:RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)\(\s*(\w+)", re.MULTILINE)


class Test:
    """One registered test: its name, its command, and what has to be built for it."""

    def __init__(self, name, command, build):
        self.name, self.command = name, command
        self.targets = [str(pathlib.Path(word).relative_to(build)) for word in command if self._is_built(word, build)]
        if any("/build/fuzz/" in word for word in command):
            self.targets.append("fuzz_programs")
        if str(build) in command:  # it installs what was built, or counts it
            self.targets.append("all")

    @staticmethod
    def _is_built(word, build):
        path = pathlib.Path(word)
        if not path.is_absolute() or build not in path.parents:
            return False
        return path.name == "takt" or path.name.startswith(("test_", "proof_", "write_"))

    @property
    def program(self):
        """The test program of googletest, or nothing."""
        return self.command[0] if pathlib.Path(self.command[0]).name.startswith(("test_", "proof_")) else None


def registered(build):
    """All tests that the build folder knows, in order of their names."""
    tests = []
    for path in build.rglob("CTestTestfile.cmake"):
        for match in ADDED.finditer(path.read_text()):
            name = next(group for group in match.groups()[:3] if group)
            tests.append(Test(name, re.findall(r'"((?:[^"\\]|\\.)*)"', match.group(4)), build))
    return sorted(tests, key=lambda test: test.name)


def suites_of(path):
    """A filter for everything that one file of tests holds."""
    text = path.read_text()
    names = sorted(set(SUITES.findall(text)) | set(CASES.findall(text)))
    return ":".join(f"{name}.*:*/{name}.*:{name}/*" for name in names)


def test_of_folder(folder, tests):
    """The tests of the nearest folder above that has some."""
    parts = list(pathlib.PurePath(folder).parts)
    while parts:
        found = [test for test in tests if test.name == "_".join(parts)]
        if found:
            return found
        parts.pop()
    return []


def of_source(path, tests):
    """(tests, filter) for a file: its mirrored tests, those that its folder's README names, else the whole folder's."""
    relative = path.relative_to(ROOT)
    if relative.parts[0] == "tests":
        return test_of_folder(pathlib.PurePath(*relative.parts[1:-1]), tests), suites_of(path)
    for folder in (relative.parent, relative.parent.parent):  # the tests of a layer with rooms lie in one folder
        mirrored = ROOT / "tests" / folder / (path.stem + "_test.cc")
        if mirrored.exists():
            return test_of_folder(folder, tests), suites_of(mirrored)
    readme = path.parent / "README.md"
    named = re.findall(rf"^\| `{re.escape(path.stem)}` \| (.*tests/.*)$", readme.read_text(), re.MULTILINE) if readme.exists() else []
    files = [ROOT / name for line in named for name in re.findall(r"`(tests/[\w/.]+\.cc)`", line)]
    if files:
        found = {test.name: test for file in files for test in test_of_folder(file.relative_to(ROOT / "tests").parent, tests)}
        return list(found.values()), ":".join(suites_of(file) for file in files)
    return test_of_folder(relative.parent, tests), None


def select(word, tests):
    """(tests, filter) that belong to what the user wrote; ends the program if there is nothing."""
    name, _, cases = word.partition(":")
    exact = [test for test in tests if test.name == name]
    if exact:
        return exact, cases or None
    path = (ROOT / name).resolve()
    if path.is_file() and ROOT in path.parents:
        found, all_cases = of_source(path, tests)
        if found:
            return found, cases or all_cases
    if path.is_dir() and ROOT in path.parents:
        folder = "_".join(part for part in path.relative_to(ROOT).parts if part != "tests")
        found = [test for test in tests if test.name == folder or test.name.startswith(folder + "_")]
        if found:
            return found, cases or None
    begun = [test for test in tests if test.name.startswith(name)] or [test for test in tests if name in test.name]
    if begun:
        return begun, cases or None
    print(f"takt: nothing is tested under '{name}'. Name a test ('./takt test --list'), a folder or a file.", file=sys.stderr)
    sys.exit(2)


def build_targets(build, jobs, targets):
    if targets:
        subprocess.run(["cmake", "--build", str(build), "-j", jobs, "--target", *sorted(set(targets))], check=True,
                       stdout=sys.stderr)


def labelled(build, label):
    """Names of the tests with this label."""
    answer = subprocess.run(["ctest", "--test-dir", str(build), "--show-only=json-v1", "-L", label], capture_output=True,
                            text=True, check=True)
    return {test["name"] for test in json.loads(answer.stdout)["tests"]}


def run_with_ctest(build, jobs, tests, options):
    build_targets(build, jobs, [target for test in tests for target in test.targets])
    names = "|".join(re.escape(test.name) for test in tests)
    return subprocess.run(["ctest", "--test-dir", str(build), "--output-on-failure", "--parallel", jobs, "-R", f"^({names})$",
                           *options], cwd=ROOT).returncode


def main():
    build, jobs, words = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3:]
    tests = registered(build)
    if words == ["--list"]:
        print("\n".join(test.name for test in tests))
        return 0
    if words[0] == "--fast":
        fast = labelled(build, "fast")
        return run_with_ctest(build, jobs, [test for test in tests if test.name in fast], words[1:])
    names = [word for word in words if not word.startswith("-")]
    options = [word for word in words if word.startswith("-")]
    status, whole = 0, []
    for name in names:
        selected, cases = select(name, tests)
        if not cases:
            whole += selected
            continue
        for test in (test for test in selected if test.program):
            build_targets(build, jobs, test.targets)
            status |= subprocess.run([test.program, "--gtest_filter=" + cases], cwd=ROOT).returncode
    if whole:
        status |= run_with_ctest(build, jobs, whole, options)
    return 1 if status else 0


if __name__ == "__main__":
    sys.exit(main())
