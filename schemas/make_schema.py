#!/usr/bin/env python3
"""Brings the schemas up to date with the tables that the program has.

  python3 schemas/make_schema.py [TAKT]            writes them again
  python3 schemas/make_schema.py --check [TAKT]    exit status 1 if that would change one

TAKT is the program, build/release/tools/takt by default. `takt schema scenario` prints what scenario files may hold, from the tables
that read them. Definitions that have no table yet are in by_hand.json; the program prints none of them.
"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BY_HAND = ROOT / "schemas/by_hand.json"
WIDTH = 120


def text_of(value, indent, lead=0):
    """JSON that fits on a line stays on one line."""
    line = json.dumps(value, ensure_ascii=False)
    if len(line) + indent + lead + 1 <= WIDTH or not isinstance(value, (dict, list)) or not value:
        return line
    inner, space = indent + 2, " " * (indent + 2)
    if isinstance(value, list):
        parts = [text_of(one, inner) for one in value]
        opening, closing = "[", "]"
    else:
        parts = [f"{json.dumps(key)}: {text_of(one, inner, len(key) + 4)}" for key, one in value.items()]
        opening, closing = "{", "}"
    return opening + "\n" + ",\n".join(space + part for part in parts) + "\n" + " " * indent + closing


def with_rules(name, definition, by_hand):
    """Rules about several keys of an operation that its table does not have."""
    if name + "_rules" not in by_hand:
        return definition
    return {**definition, "allOf": definition.get("allOf", []) + [{"$ref": f"#/definitions/{name}_rules"}]}


def scenario(takt):
    """The whole text of scenario.schema.json."""
    printed = json.loads(subprocess.run([takt, "schema", "scenario"], capture_output=True, text=True, check=True).stdout)
    by_hand = json.loads(BY_HAND.read_text())
    both = sorted(set(by_hand) & set(printed["definitions"]))
    if both:
        sys.exit(f"by hand and from a table: {', '.join(both)}")
    definitions = {name: with_rules(name, one, by_hand) for name, one in printed["definitions"].items()}
    return text_of({**printed, "definitions": {**definitions, **by_hand}}, 0) + "\n"


def main():
    arguments = [one for one in sys.argv[1:] if one != "--check"]
    takt = arguments[0] if arguments else str(ROOT / "build/release/tools/takt")
    file, text = ROOT / "schemas/scenario.schema.json", scenario(takt)
    if "--check" in sys.argv:
        return 0 if text == file.read_text() else 1
    file.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
