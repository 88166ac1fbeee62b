#!/usr/bin/env python3
"""Brings scenario.schema.json up to date with the tables that the program has (docs/tables.md).

  python3 schemas/make_schema.py [TAKT]            writes the file again
  python3 schemas/make_schema.py --check [TAKT]    exit status 1 if that would change it

TAKT is the program, build/release/tools/takt by default. `takt schema` prints a definition per operation, and that of
expectations; they stand at the end of the file, after a line that says so. All that is above that line is written by hand: what has no table, and
rules about several keys of an operation NAME in a definition NAME_rules, which this script puts into allOf of the printed one.
"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCHEMA = ROOT / "schemas/scenario.schema.json"
PRINTED = '    "printed": {"$comment": "Definitions from here on: takt schema; see schemas/make_schema.py."},\n'
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
    if name + "_rules" not in by_hand:
        return definition
    return {**definition, "allOf": [{"$ref": f"#/definitions/{name}_rules"}]}


def schema(takt):
    """The whole text of scenario.schema.json."""
    printed = json.loads(subprocess.run([takt, "schema"], capture_output=True, text=True, check=True).stdout)
    by_hand, _, old = SCHEMA.read_text().partition(PRINTED)
    if not old:
        sys.exit(f"{SCHEMA} lacks the line\n{PRINTED}")
    names = json.loads(by_hand.rstrip().rstrip(",") + "}}")["definitions"]
    both = sorted(set(names) & set(printed["definitions"]))
    if both:
        sys.exit(f"by hand and from a table: {', '.join(both)}")
    definitions = [f'    "{name}": {text_of(with_rules(name, one, names), 4, len(name) + 4)}'
                   for name, one in printed["definitions"].items()]
    return by_hand + PRINTED + ",\n".join(definitions) + "\n  }\n}\n"


def main():
    arguments = [one for one in sys.argv[1:] if one != "--check"]
    text = schema(arguments[0] if arguments else str(ROOT / "build/release/tools/takt"))
    if "--check" in sys.argv:
        return 0 if text == SCHEMA.read_text() else 1
    SCHEMA.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
