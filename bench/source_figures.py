#!/usr/bin/env python3
"""Figures of the source text: lines by folder, lengths of functions, the largest class. Needs universal-ctags.

  bench/source_figures.py [FOLDER...]     default: the folders of the command, activity, operation and program layers

Lines are those of .h and .cc files, comments included. The length of a function is its number of lines from its head to its
closing brace; that of a class likewise. Lambdas count as part of their function.
"""
import json
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
UPPER_HALF = ["core/expression", "core/command", "core/activity", "core/operations", "core/program"]


def sources(folder):
    return sorted(path for path in (ROOT / folder).rglob("*") if path.suffix in (".h", ".cc"))


def tags(paths):
    """Functions and classes with a body: kind, name, file, number of lines."""
    printed = subprocess.run(["ctags", "--languages=C++", "--langmap=C++:+.h", "--kinds-C++=fcs", "--fields=+neK", "--output-format=json",
                              "-o", "-", *map(str, paths)], capture_output=True, text=True, check=True)
    for line in printed.stdout.splitlines():
        tag = json.loads(line)
        if "end" in tag:
            yield tag["kind"], tag["name"], str(pathlib.Path(tag["path"]).relative_to(ROOT)), tag["end"] - tag["line"] + 1


def main():
    folders = sys.argv[1:] or UPPER_HALF
    print(f"{'folder':<24}{'files':>7}{'lines':>8}")
    total = 0
    paths = []
    for folder in folders:
        files = sources(folder)
        lines = sum(len(path.read_text().splitlines()) for path in files)
        total += lines
        paths += files
        print(f"{folder:<24}{len(files):>7}{lines:>8}")
    print(f"{'together':<24}{len(paths):>7}{total:>8}")
    found = list(tags(paths))
    lengths = sorted(length for kind, _, _, length in found if kind == "function")
    classes = sorted(((length, name, path) for kind, name, path, length in found if kind in ("class", "struct")), reverse=True)
    if not lengths:
        return 0
    print(f"\nfunctions: {len(lengths)}; median {statistics.median(lengths):g} lines, p90 {lengths[int(0.9 * (len(lengths) - 1))]}, "
          f"longest {lengths[-1]}")
    print("largest classes: " + ", ".join(f"{name} {length} lines ({path})" for length, name, path in classes[:3]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
