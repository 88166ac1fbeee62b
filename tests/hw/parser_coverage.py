#!/usr/bin/env python3
"""Branch coverage of the parsers of hardware protocols by their own tests.

    parser_coverage.py [BUILD [--least PERCENT] [--only NAME...]]

The sources of each parser and their tests are compiled once more with gcov's counters and linked against the libraries of
BUILD (build/release), which has to be built. Branches that only an exception takes do not count. Prints a row for each
parser and the lines whose branches are not all taken; exit status 1 below PERCENT.
"""
import argparse
import gzip
import json
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Parser: its sources, the tests that are for it, and the test program whose libraries both need.
PARSERS = {
    "fri": (["hw/fri/protocol/packet.cc"], ["tests/hw/fri/packet_test.cc"], "hw_fri"),
    "rtde": (
        ["hw/rtde/message.cc", "hw/rtde/package.cc", "hw/rtde/field.cc", "hw/rtde/dashboard_client.cc"],
        ["tests/hw/rtde/wire_test.cc", "tests/hw/rtde/client_test.cc", "tests/hw/rtde/dashboard_test.cc"],
        "hw_rtde",
    ),
    "script-ports": (
        ["hw/emulators/rtde/script_intake.cc"],
        ["tests/hw/rtde/script_service_test.cc", "tests/hw/rtde/programs_test.cc"],
        "hw_rtde",
    ),
    "urscript": (["languages/urscript/lexer.cc", "languages/urscript/parser.cc"], ["tests/languages/urscript/machine_test.cc", "tests/languages/urscript/corpus_test.cc", "tests/languages/urscript/limits_test.cc"], "languages_urscript"),
    "canopen": (
        ["hw/cia402/protocol/canopen.cc", "hw/cia402/protocol/drive_state.cc"],
        ["tests/hw/cia402/protocol_test.cc"],
        "hw_cia402",
    ),
    "can-datagrams": (["hw/can/datagram_can.cc"], ["tests/hw/can/datagram_can_test.cc"], "hw_can"),
    "wsg": (["hw/wsg/protocol/packet.cc", "hw/wsg/protocol/commands.cc"], ["tests/hw/wsg/packet_test.cc"], "hw_wsg"),
    "modbus": (["hw/modbus/protocol/frame.cc"], ["tests/hw/modbus/frame_test.cc"], "hw_modbus"),
}


def run(command, folder):
    """What it prints is shown only if it fails."""
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}\n{done.stderr}")


def compile_flags(build):
    """Of any test of the build: includes and standard are the same for all."""
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        if "test_hw_wire" not in entry["command"]:
            continue
        flags = []
        for i, word in enumerate(words):
            if word.startswith(("-I", "-D", "-std=")):
                flags.append(word)
            elif word == "-isystem":
                flags += [word, words[i + 1]]
        return next(word for word in words if word.endswith("++")), flags
    sys.exit(f"{build} has no test_hw_wire: is it a build of takt with its tests?")


def link_words(build, program):
    """The libraries that CMake links a test program with, without its objects."""
    out = subprocess.run(["ninja", "-C", build, "-t", "commands", "-s", program], capture_output=True, text=True, check=True)
    words = shlex.split(out.stdout.split("&&")[1])
    begin = next(i for i, word in enumerate(words) if word == "-o") + 2
    return [str(build / w) if w.endswith((".a", ".o")) and not w.startswith("/") else w for w in words[begin:]]


def branches_of(folder, sources):
    """(source, line) -> [taken, all] of branches that no exception takes; of a line in several instances the best."""
    counts = {}
    for notes in sorted(folder.glob("*.gcno")):
        run(["gcov", "--json-format", "--branch-probabilities", notes.name], folder)
    for report in folder.glob("*.gcov.json.gz"):
        for file in json.loads(gzip.decompress(report.read_bytes()))["files"]:
            path = (folder / file["file"]).resolve() if not file["file"].startswith("/") else pathlib.Path(file["file"])
            source = str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else ""
            if source not in sources:
                continue
            lines = (ROOT / source).read_text().splitlines()
            for line in file["lines"]:
                if lines[line["line_number"] - 1].lstrip().startswith("} catch ("):
                    continue  # which handler an exception finds
                taken = [branch["count"] > 0 for branch in line["branches"] if not branch["throw"]]
                if not taken:
                    continue
                key = (source, line["line_number"])
                known = counts.get(key)
                counts[key] = [a or b for a, b in zip(known, taken)] if known and len(known) == len(taken) else taken
    return counts


def measure(name, build):
    sources, tests, program = PARSERS[name]
    folder = build / "parser_coverage" / name
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.gc*"):
        old.unlink()
    compiler, flags = compile_flags(build)
    objects = []
    for i, source in enumerate(sources + tests):
        counted = ["--coverage", "-fno-inline"] if source in sources else []
        objects.append(f"{i}_{pathlib.Path(source).stem}.o")
        run([compiler, "-O0", "-g1", *counted, *flags, "-c", ROOT / source, "-o", objects[-1]], folder)
    # What is compiled here comes first: the libraries give the rest.
    libraries = link_words(build, f"tests/{program.replace('_', '/')}/test_{program}")
    run([compiler, "--coverage", *objects, "-Wl,--allow-multiple-definition", *libraries, "-o", "program"], folder)
    subprocess.run([folder / "program", "--gtest_brief=1"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    return branches_of(folder, sources)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("build", nargs="?", default=ROOT / "build/release", type=pathlib.Path)
    arguments.add_argument("--least", type=float, default=0.0, metavar="PERCENT")
    arguments.add_argument("--only", nargs="*", choices=sorted(PARSERS), default=list(PARSERS))
    options = arguments.parse_args()
    build = options.build.resolve()
    low = False
    for name in options.only:
        counts = measure(name, build)
        total = sum(len(taken) for taken in counts.values())
        taken = sum(sum(one) for one in counts.values())
        share = 100.0 * taken / total if total else 0.0
        low = low or share < options.least
        print(f"{name:14} {taken:4} of {total:4} branches  {share:5.1f} %")
        for (source, line), one in sorted(counts.items()):
            if not all(one):
                text = (ROOT / source).read_text().splitlines()[line - 1].strip()
                print(f"    {source}:{line}: {len(one) - sum(one)} of {len(one)} not taken: {text}")
    sys.exit(1 if low else 0)


if __name__ == "__main__":
    main()
