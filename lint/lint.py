#!/usr/bin/env python3
"""Rules of the house that a compiler does not know. Prints every diagnostic as FILE:LINE: text; exit status 1 if any.

Rules: layers include only downwards; headers have '#pragma once'; no left-over marks; no path or registry of a machine;
no heavy header in a header of ours; every folder of code has a README; links in Markdown files lead to a file and, with
an anchor, to a heading; files of the repository that a page names exist; every row of docs/semantics.md is named by a test
or says which issue brings it; no file over 600 lines; no capturing lambda inside of a co_await expression; no name twice in
the unnamed namespaces of a folder (unnamed.py); namespaces are folders;
no new circle of modules (circles.py); hints say what to do (hints.py); tests
ask for codes and pointers of diagnostics, not for their words; every code of a diagnostic is asked for by a test.
"""
import pathlib
import re
import subprocess
import sys

import circles
import hints
import unnamed

ROOT = pathlib.Path(__file__).resolve().parent.parent

# A layer may include its own folder and those listed; docs/architecture.md draws the same picture.
CORE = ["core/base", "core/net", "core/plugin", "core/kinematics", "core/motion", "core/world", "core/collision", "core/planning",
        "core/device", "core/primitives", "core/rcc", "core/expression", "core/command", "core/command/actions",
        "core/activity", "core/operations", "core/program/language", "core/program/tree"]
# Rooms of a layer that is one library, from the bottom up: a room may include those before it.
ROOMS = {
    "core/operations": ["review", "table", "command", "motion", "grasp", "online", "force", "process", "basic"],
    "sim": ["model", "contact", "machines", "world", "plain", "film"],
    "languages": ["xml", "script", "scxml", "behavior_tree", "program"],
    "cell": ["file", "build", "faults", "judge", "run", "replay"],
}
# What still looks upwards. This list only gets shorter.
UPWARD = {
    ("sim/model/solids.cc", "sim/contact/solid_contact.h"),
}


def up_to(layer):
    """The layers of CORE below this one."""
    return CORE[:CORE.index(layer)]


MAY_INCLUDE = {
    "core/base": [],
    "core/net": ["core/base"],
    "core/plugin": ["core/base", "core/net"],
    "core/kinematics": ["core/base"],
    "core/motion": ["core/base", "core/kinematics"],
    "core/world": ["core/base"],
    "core/collision": ["core/base", "core/kinematics", "core/world"],
    "core/planning": ["core/base", "core/kinematics", "core/motion", "core/world", "core/collision"],
    "core/device": ["core/base", "core/net", "core/kinematics", "core/motion", "core/world"],
    "core/emulation": ["core/base", "core/net", "core/kinematics", "core/motion", "core/device"],
    "core/primitives": ["core/base", "core/net", "core/kinematics", "core/motion", "core/world", "core/collision", "core/device"],
    "core/rcc": ["core/base", "core/net", "core/kinematics", "core/motion", "core/device"],
    "core/expression": up_to("core/expression"),
    "core/command": up_to("core/command"),
    "core/command/actions": up_to("core/command/actions"),
    "core/activity": up_to("core/activity"),
    "core/operations": up_to("core/operations"),
    "core/program/language": up_to("core/operations"),
    "core/program/tree": up_to("core/program/tree"),
    # The language of UR's programs by itself, for the front end and for the emulated controller.
    "languages/urscript": ["core/base", "core/kinematics", "core/motion"],
    "languages": CORE + ["languages/urscript"],
    "record": ["core/base"],
    "sim": CORE,
    "hw": CORE + ["core/emulation", "languages/urscript"],
    "cell": CORE + ["core/emulation", "languages", "sim", "record"],
    "app/interfaces": up_to("core/program/language"),
    "app/remote": CORE + ["core/emulation", "sim", "record", "cell"],
    "app": CORE + ["core/emulation", "sim", "record", "cell", "app/interfaces", "app/remote"],
    "serve": CORE + ["core/emulation", "sim", "record", "cell"],
    "python": CORE + ["core/emulation", "sim", "record", "cell", "app", "app/interfaces"],
    "tools/import": CORE + ["sim"],
    "tools": CORE + ["core/emulation", "languages", "hw", "sim", "record", "cell", "app", "app/interfaces", "serve", "tools/import"],
}
# GCC 12 destroys such a lambda twice.
AWAITED_LAMBDA = re.compile(r"co_await\b[^;{}]*\[[&=\w][^\]]*\]\s*(\(|\{|mutable)")
# It moves texts of parameters bit by bit.
AWAITED_PARAMETERS = re.compile(r"co_await\b[^;{}]*\b(press|search|hold|jog|follow|close|open|set|freedrive|perform)\([^;{}]*\{")
HEAVY = re.compile(r'#include <(nlohmann/json\.hpp|mujoco/|boost/beast|google/protobuf|urdf)')
# Descriptions hold JSON by value.
HEAVY_ALLOWED = {"core/net/description.h", "cell/file/description.h", "cmake/pch.h"}
MARKS = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X|HA" r"CK)\b")
MACHINE = re.compile(r"(^|[^A-Za-z0-9_.])/(work|farm|root|home)/|pypi\.o" r"rg|pythonhos" r"ted|deb\.deb" r"ian")


# Names that were dialect, and the field's own (style: a quantity is a noun, what changes state is a verb). New rows are
# welcome.
DIALECT = {
    "sight": "eval_context", "making": "build", "Stance": "KinematicState", "Softness": "ToolCompliance",
    "OffsetRoom": "OffsetBudget", "Woven": "WeavingMotion", "Strand": "ControlLine", "Reality": "BackendMode",
    "Situation": "CellState", "Meanwhile": "ConcurrentMotions", "MotionBeside": "ConcurrentMotion",
    "MeantTouch": "IntendedContact", "tool_misfit": "tool_mismatch", "gives_way_as_it_can": "check_compliance",
    "lets_go": "update_hold", "look_after_connection": "service_connection", "dress_stage": "add_scene_props",
    "see_arm": "update_arm_frames", "see_flanges": "update_flange_frames", "lose_time": "invalidate_timing",
    "kPatience": "kAnswerTimeout", "kLostWay": "kPartLostDistance", "add_news": "append_new",
    "may_be_left": "can_blend_out", "may_go_on": "can_blend_from",
}
DIALECT_NAME = re.compile(r"\b(" + "|".join(DIALECT) + r")\b")
NOT_CODE = re.compile(r'"(?:\\.|[^"\\])*"|//.*$')

# Words in what a test looks for: two words in a row, as no name, key, pointer or number has them.
WORDS = r'"(?:[^"\\\n]|\\.)*?[A-Za-z]{2,},? [a-z]{2,}(?:[^"\\\n]|\\.)*"'
LOOKS_FOR_WORDS = re.compile(r"\b(?:HasSubstr|StartsWith|EndsWith|ContainsRegex|MatchesRegex|find|contains|starts_with|ends_with)"
                             r"\(\s*(?:std::string\()?" + WORDS)
LOOKS_AT_MESSAGE = re.compile(r"(?:\.|->|::)(?:message|hint)\b\s*(?:,|==|!=|\.(?:find|contains|starts_with|ends_with)\b)")
LOOKS_IN_OUTPUT = re.compile(r"assert(?:In|NotIn|Regex)\(\s*[rf]?" + WORDS + r"[^\n]*\bstderr\b")
# What prints, and what others say: each with the reason why its words are the subject.
QUOTING_TESTS = {
    "tests/core/base/diagnostics_test.cc": "how diagnostics are printed",
    "tests/core/base/text_location_test.cc": "how locations are printed",
    "tests/core/base/json_test.cc": "suggestions for mistyped names",
    "tests/core/base/last_catch_test.cc": "what the process says of an exception that nobody caught",
    "tests/core/rcc/last_catch_test.cc": "what the process says of an exception that nobody caught",
    "tests/record/compare_test.cc": "notes of a comparison, which are texts",
    "tests/record/damage_test.cc": "damage of a recording, a list of texts",
    "tests/record/hostile_test.cc": "damage of a recording, a list of texts",
    "tests/record/recorder_test.cc": "why a recording stopped, and what it holds",
    "tests/hw/rtde/dashboard_test.cc": "answers of UR's dashboard server",
    "tests/hw/rtde/programs_test.cc": "errors of UR's controller, which its clients read",
    "tests/hw/rtde/client_test.cc": "what a driver says of a controller",
    "tests/hw/rtde/driver_test.cc": "faults of a driver, numbers with words",
    "tests/hw/rtde/terminals_test.cc": "faults of a driver, and why a block does not fit",
    "tests/languages/urscript/machine_test.cc": "errors of UR's controller, which its clients read",
    "tests/hw/fri/client_test.cc": "faults of a driver, numbers with words",
    "tests/hw/fri/controller_test.cc": "what KUKA's controller shows",
    "tests/tools/hardware_test.py": "what KUKA's controller shows",
    "tests/proofs/interruptions_are_safe.cc": "the cause with which a net ended, a text",
    "tests/supply/supply_test.py": "what CMake says",
    "tests/tools/hardening_test.py": "what the process and the operating system say",
    "tests/tools/model_test.py": "progress and tables of `takt model`",
}


def tracked():
    names = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True,
                           check=True)
    return [name for name in names.stdout.split("\n") if name and (ROOT / name).is_file()]


def layer_of(name):
    matches = [layer for layer in MAY_INCLUDE if name.startswith(layer + "/")]
    return max(matches, key=len) if matches else None


def looks_up(layer, name, included):
    """Whether this include of the same layer leads from a room to one above it."""
    rooms = ROOMS.get(layer, [])
    room, target = (path[len(layer) + 1:].split("/")[0] for path in (name, included))
    if room not in rooms or target not in rooms or (name, included) in UPWARD:
        return False
    return rooms.index(target) > rooms.index(room)


def home_of(name):
    """The namespace that a file's folder has; folders of one protocol share one, and so do the rooms of a layer."""
    layer = layer_of(name)
    if layer is None or layer == "core/base":
        return "takt"
    words = layer.removeprefix("core/").split("/")
    return f"takt::{words[0]}"


def check_namespace(name, lines, say):
    """Namespaces are folders: what a file declares is in that of its folder. Beside it others are named in advance."""
    opened = {}
    for number, line in enumerate(lines, 1):
        match = re.match(r"namespace (takt[\w:]*) \{", line)
        if match:
            opened.setdefault(match.group(1), number)
    home = home_of(name)
    if opened and not any(one == home or one.startswith(home + "::") for one in opened):
        one, number = next(iter(opened.items()))
        say(name, number, f"namespace {one} in a folder of {home}")


def check_code(name, lines, say):
    layer = layer_of(name)
    if layer is not None:
        check_namespace(name, lines, say)
    header = name.endswith(".h")
    # The precompiled headers are main files to the compiler, which warns about the pragma there.
    if header and not name.startswith("cmake/") and not any(line.startswith("#pragma once") for line in lines):
        say(name, 1, "a header needs '#pragma once'")
    if len(lines) > 600:
        say(name, len(lines), f"{len(lines)} lines: split it so that each file says one thing (600 at most)")
    for number, line in enumerate(lines, 1):
        if len(line) > 120:
            say(name, number, f"{len(line)} columns (120 at most)")
        if header and HEAVY.search(line) and name not in HEAVY_ALLOWED and not name.startswith("tests/"):
            say(name, number, "heavy header inside a header: include it in the .cc file")
        for match in DIALECT_NAME.finditer(NOT_CODE.sub("", line)):
            say(name, number, f"'{match.group(1)}' is dialect: {DIALECT[match.group(1)]}")
        included = re.match(r'#include "([^"]+)"', line)
        if layer and included:
            target = layer_of(included.group(1))
            if target and target != layer and target not in MAY_INCLUDE[layer]:
                say(name, number, f"{layer} may not know {target}")
            elif target == layer and looks_up(layer, name, included.group(1)):
                say(name, number, f"{name} may not know {included.group(1)}, which lies in a room above")


def check_options(name, lines, say):
    """Options of the compiler in a file would reach the files behind it in its batch."""
    depth = 0
    for number, line in enumerate(lines, 1):
        if re.match(r"\s*#pragma GCC (push|pop)_options", line):
            depth += 1 if "push" in line else -1
        elif re.match(r"\s*#pragma GCC (optimize|target)", line) and depth == 0:
            say(name, number, "options without '#pragma GCC push_options' reach the next files of the batch")
    if depth != 0:
        say(name, len(lines), "'#pragma GCC push_options' without 'pop_options'")


def check_awaits(name, text, say):
    for match in AWAITED_PARAMETERS.finditer(text):
        say(name, text[: match.start()].count("\n") + 1, "parameters inside of a co_await expression: name them before")
    for match in AWAITED_LAMBDA.finditer(text):
        say(name, text[: match.start()].count("\n") + 1, "a capturing lambda inside of a co_await expression: name it before")


def check_quotes(name, text, say):
    """Tests ask for codes and pointers, so that every message may be reworded (docs/testing.md)."""
    if name in QUOTING_TESTS:
        return
    rules = [LOOKS_IN_OUTPUT] if name.endswith(".py") else [LOOKS_FOR_WORDS, LOOKS_AT_MESSAGE]
    for rule in rules:
        for match in rule.finditer(text):
            line = text[text.rfind("\n", 0, match.start()) + 1: match.start()]
            if re.search(r"\b(log|lines|page|svg|picture)\b", line):
                continue  # of what a run logs, or of a page, the words are the subject
            say(name, text[: match.start()].count("\n") + 1, "a test that looks for the words of a message: ask for code, "
                "pointer and names (tests/support/reports.h), or list the file in QUOTING_TESTS with the reason")


def check_codes(names, say):
    """Every code is reported by some code and asked for by some test."""
    codes = re.findall(r'\{Code::(k\w+), "([\w-]+)"', (ROOT / "core/base/diagnostics.cc").read_text())

    def texts(folders, suffixes):
        return "\n".join((ROOT / name).read_text(errors="replace") for name in names
                         if name.startswith(folders) and name.endswith(suffixes) and not name.startswith("core/base/diagnostics"))

    sources = texts(("core/", "sim/", "hw/", "cell/", "record/", "app/", "serve/", "tools/"), (".cc", ".h"))
    tests = texts("tests/", (".cc", ".h", ".py"))
    for code, name in codes:
        if code != "kNote" and not re.search(rf"Code::{code}\b", sources):
            say("core/base/diagnostics.h", 1, f"nothing reports the code '{name}'")
        if code != "kNote" and not re.search(rf"Code::{code}\b|\[{name}\]", tests):
            say("core/base/diagnostics.h", 1, f"no test asks for the code '{name}'")


def check_text(name, lines, say):
    for number, line in enumerate(lines, 1):
        if MARKS.search(line):
            say(name, number, "left-over mark: do it or write an issue")
        if MACHINE.search(line):
            say(name, number, "a path or registry of one machine")


def anchors_of(page):
    """The anchors of the headings of a Markdown page."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#+ +(.+?) *$", text, re.MULTILINE)
    plain = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in plain}


def check_links(name, text, say):
    for match in re.finditer(r"\]\(([^)#\s]*)(#[^)]*)?\)", text):
        target, anchor = match.group(1), match.group(2)
        if re.match(r"[a-z]+:", target) or not (target or anchor):
            continue
        page = (ROOT / name).parent.joinpath(target) if target else ROOT / name
        line = text[: match.start()].count("\n") + 1
        if not page.exists():
            say(name, line, f"the link '{target}' leads nowhere")
        elif anchor and page.suffix == ".md" and anchor[1:] not in anchors_of(page):
            say(name, line, f"the link '{target}{anchor}' leads to no heading")


PATH_IN_TEXT = re.compile(r"`((?:core|sim|hw|record|cell|app|tools|tests|models|schemas|lint|bench|cmake|docs)/[\w/.-]+\.[a-z]+)`")


def check_paths(name, text, names, say):
    """Files of the repository that a page names."""
    for match in PATH_IN_TEXT.finditer(text):
        if match.group(1) not in names:
            say(name, text[: match.start()].count("\n") + 1, f"there is no file '{match.group(1)}'")


def check_folders(names, say):
    folders = {str(pathlib.PurePath(name).parent) for name in names if name.endswith((".cc", ".h"))}
    for folder in sorted(folders):
        if not folder.startswith("tests/") and folder != "cmake" and folder + "/README.md" not in names:
            say(folder + "/README.md", 1, "this folder lacks its README: what belongs here, what does not")
        elif folder + "/README.md" in names and not (ROOT / folder / "README.md").read_text().startswith("# "):
            say(folder + "/README.md", 1, "a README begins with a heading, '# ...' (clang-format spoils Markdown files)")


def check_semantics(names, say):
    """Row ids of docs/semantics.md: tested, or promised for a later issue."""
    tests = "\n".join((ROOT / name).read_text(errors="replace") for name in names
                      if name.startswith("tests/") and name.endswith((".cc", ".py", ".h")))
    for number, line in enumerate((ROOT / "docs/semantics.md").read_text().split("\n"), 1):
        row = re.match(r"\| ([NOLPSTDU]\d+) \|.*\| ([^|]+) \|$", line)
        if not row:
            continue
        ident, status = row.group(1), row.group(2).strip()
        if status.startswith("tested"):
            if not re.search(rf"(?<![A-Z0-9]){ident}(?![0-9])", tests):
                say("docs/semantics.md", number, f"row {ident} says it is tested, but no test names it")
        elif not status.startswith("open"):
            say("docs/semantics.md", number, f"row {ident}: the last column says 'tested' or 'open: issue N'")


def main():
    diagnostics = []

    def say(name, number, text):
        diagnostics.append(f"{name}:{number}: {text}")

    names = tracked()
    known = set(names)
    for name in names:
        if name.startswith("LICENSE") or name.endswith((".png", ".stl")):
            continue
        text = (ROOT / name).read_text(errors="replace")
        lines = text.split("\n")
        if name.endswith((".cc", ".h")):
            check_code(name, lines, say)
            check_options(name, lines, say)
            check_awaits(name, text, say)
            if not name.startswith(("tests/", "bench/", "examples/")):
                for hint in hints.diagnostics(name, text):
                    say(*hint)
        if name.startswith("tests/") and name.endswith((".cc", ".h", ".py")):
            check_quotes(name, text, say)
        if name != "lint/lint.py":
            check_text(name, lines, say)
        if name.endswith(".md"):
            check_links(name, text, say)
            check_paths(name, text, known, say)
    check_folders(known, say)
    check_codes(names, say)
    check_semantics(names, say)
    for collision in unnamed.collisions(ROOT, names):
        say(*collision)
    for circle in circles.diagnostics(ROOT, names):
        say(*circle)
    print("\n".join(diagnostics) if diagnostics else "lint: no diagnostics")
    return 1 if diagnostics else 0


if __name__ == "__main__":
    sys.exit(main())
