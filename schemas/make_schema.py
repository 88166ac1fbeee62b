#!/usr/bin/env python3
"""Brings the schemas up to date with the tables that the program has (docs/tables.md).

  python3 schemas/make_schema.py [TAKT]            writes the files again
  python3 schemas/make_schema.py --check [TAKT]    exit status 1 if that would change one

TAKT is the program, build/release/tools/takt by default. `takt schema KIND` prints the schema of a kind of file. In
scenario.schema.json the definitions above the line that says so are written by hand: what has no table yet, and rules
about several keys of an operation NAME in a definition NAME_rules, which this script puts into allOf of the printed one.
"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FILES = ["scenario", "site", "materials"]
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


def path_of(kind):
    return ROOT / f"schemas/{kind}.schema.json"


def by_hand():
    """The lines of definitions that are written by hand."""
    text = path_of("scenario").read_text()
    lines, found, _ = text.partition('  "definitions": {\n')[2].partition(PRINTED)
    if not found:
        sys.exit(f"{path_of('scenario')} lacks the line\n{PRINTED}")
    return lines


def text_of_file(kind, takt):
    """The whole text of a schema."""
    printed = json.loads(subprocess.run([takt, "schema", kind], capture_output=True, text=True, check=True).stdout)
    if kind != "scenario":
        return text_of(printed, 0) + "\n"
    lines, definitions = by_hand(), printed.pop("definitions")
    names = json.loads("{" + lines.rstrip().rstrip(",") + "}")
    both = sorted(set(names) & set(definitions))
    if both:
        sys.exit(f"by hand and from a table: {', '.join(both)}")
    for name in definitions:
        if name + "_rules" in names:
            definitions[name]["allOf"] = [{"$ref": f"#/definitions/{name}_rules"}]
    entries = [f'    "{name}": {text_of(one, 4, len(name) + 4)}' for name, one in definitions.items()]
    return (text_of(printed, 0).removesuffix("\n}") + ',\n  "definitions": {\n' + lines + PRINTED + ",\n".join(entries) + "\n  }\n}\n")


def main():
    arguments = [one for one in sys.argv[1:] if one != "--check"]
    takt = arguments[0] if arguments else str(ROOT / "build/release/tools/takt")
    texts = {kind: text_of_file(kind, takt) for kind in FILES}
    if "--check" in sys.argv:
        return 1 if any(text != path_of(kind).read_text() for kind, text in texts.items()) else 0
    for kind, text in texts.items():
        path_of(kind).write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
