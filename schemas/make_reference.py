#!/usr/bin/env python3
"""Prints docs/scenario-reference.md from scenario.schema.json: every key of a scenario file but the parameters of operations.

  python3 schemas/make_reference.py > docs/scenario-reference.md

Those parameters are on docs/operations-reference.md, which the program prints. A test (docs_test.py) compares both pages with
what is printed. A definition is shown as a section if SECTIONS names it; any other definition is described where it is used.
"""
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Definition, title, first sentence. The order is that of the page.
SECTIONS = [
    ("place", "Pose", "A pose in a frame. Frames: x forward, y left, z up in the world."),
    ("frame", "Frame", "A pose by its name; with `vary` it is drawn."),
    ("variation", "Variation", "How far a pose may be drawn from the one that the file gives, from the seed and a name."),
    ("parameter_range", "Parameter range", "The values that a parameter may have."),
    ("device", "Device", "An arm, base, sensor, tool, gripper or I/O block."),
    ("object", "Object", "A physical object: a model, one shape, or several shapes."),
    ("part", "Part of an object", "A shape with a pose in the object's frame."),
    ("material", "Material", "How a surface answers a touch ([contacts.md](contacts.md))."),
    ("contact_rule", "Contact rule", "What two materials do together, where it is not what follows from the two."),
    ("collisions", "Collisions", "What may not meet, and what may ([world.md](world.md))."),
    ("allowed_contact", "Allowed contact", "Two bodies, devices or objects that are not checked against each other."),
    ("camera", "Camera", "A camera of the film."),
    ("film", "Film", "What the film shows."),
    ("channel", "Channel", "A value that nets exchange with each other and with the outside."),
    ("operator_action", "Operator action", "What an operator does at the panel, at a given time or step."),
    ("tolerance", "Golden tolerance", "How closely columns of a recording have to follow the golden ([recording.md](recording.md#comparing))."),
    ("sub_program", "Called program", "A program that the step `call` runs."),
    ("declarations", "Variables", "Variables by name. The short form is a value: number, Boolean, text, list, expression or pose."),
    ("condition", "Condition", "A comparison of a measured value, the state of a device, or a combination of conditions."),
    ("goal", "Goal", "Where a motion ends: one of these forms."),
    ("handlers", "Event handlers", "A list of event handlers of a command or transaction."),
    ("state", "State", "What an event handler watches: one of these forms. Each may have `held_for_s`."),
    ("captured", "Captured value", "A value that a transaction captures, or that an analog output follows: one of its keys but `quantity`."),
]
NODES = ["sequence", "parallel", "charts", "tree", "krl", "urscript", "branch", "repeat", "for_each", "call", "try", "let", "log", "fail", "stop", "motions"]
ELSEWHERE = {"step": "[step](#steps)", "command": "[command](#commands)", "expectation": "[expectation](#expectations)",
             "fault": "[fault](#faults)", "device_settings": "[settings](#device-settings)",
             "compliance": "[compliance](operations-reference.md#compliance)", "value": "value"}
IN_EVERY_COMMAND = [{"$ref": "#/definitions/starts"}, {"$ref": "#/definitions/handlers"}]


def anchor(title):
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


class Page:
    def __init__(self, schema, operations):
        self.definitions = schema["definitions"]
        self.schema = schema
        self.operations = operations
        self.titles = {name: title for name, title, _ in SECTIONS}

    def resolve(self, node):
        """A reference to a definition without a section is replaced by the definition."""
        while isinstance(node, dict) and "$ref" in node:
            node = self.definitions[node["$ref"].rsplit("/", 1)[1]]
        return node

    def section_of(self, node):
        if isinstance(node, dict) and "$ref" in node:
            name = node["$ref"].rsplit("/", 1)[1]
            if name in ELSEWHERE:
                return ELSEWHERE[name]
            if name in self.titles:
                return f"[{self.titles[name].lower()}](#{anchor(self.titles[name])})"
            return self.section_of(self.definitions[name])
        if isinstance(node, dict) and "properties" not in node:
            return next(filter(None, map(self.section_of, node.get("allOf", []))), None)
        return None

    def description(self, node):
        while isinstance(node, dict):
            if "description" in node:
                return node["description"]
            if "$ref" in node:
                node = self.resolve(node)
            elif len(node.get("allOf", [])) == 1:
                node = node["allOf"][0]
            else:
                return ""
        return ""

    def keyword(self, node, key):
        node = self.resolve(node)
        if not isinstance(node, dict):
            return None
        if key in node:
            return node[key]
        for part in node.get("allOf", []) + node.get("anyOf", []):
            found = self.keyword(part, key)
            if found is not None:
                return found
        return None

    def range_of(self, node):
        words = []
        for key, word in (("exclusiveMinimum", "above"), ("minimum", "at least"), ("maximum", "at most")):
            if key in node:
                words.append(f"{word} {node[key]}" if node[key] < 1e9 else "")
        return "".join(", " + word for word in words if word)

    def array_type(self, node):
        low, high = node.get("minItems", 0), node.get("maxItems")
        items = self.type_of(node["items"]) if "items" in node else "value"
        if not high:
            return f"array of {items}"
        count = f"{high}" if high == low else f"{low} to {high}"
        return f"array of {count}: {items}"

    def type_of(self, node):
        section = self.section_of(node)
        if section:
            return section
        node = self.resolve(node)
        if not isinstance(node, dict):
            return "value"
        if "const" in node:
            return f"`{json.dumps(node['const'])}`" if node["const"] is not True else "true"
        if "enum" in node:
            return ", ".join(f"`{one}`" for one in node["enum"])
        if "anyOf" in node and "type" not in node:
            kinds = []
            for one in node["anyOf"]:
                kind = self.type_of(one)
                if kind not in kinds:
                    kinds.append(kind)
            return " or ".join(kinds)
        if "oneOf" in node and "type" not in node:
            return " or ".join(self.type_of(one) for one in node["oneOf"])
        if len(node.get("allOf", [])) == 1 and "properties" not in node:
            return self.type_of(node["allOf"][0])
        kind = node.get("type")
        if isinstance(kind, list):
            return " or ".join({"string": "text", "array": "array", "object": "object"}.get(one, one) for one in kind)
        if kind == "object" or "properties" in node:
            more = node.get("additionalProperties")
            inner = self.type_of(more) if isinstance(more, dict) else None
            return f"object: name to {inner}" if inner else "object"
        if kind == "array":
            return self.array_type(node)
        if node.get("pattern") == "^\\$":
            return "expression"
        names = {"string": "text", "integer": "whole number", "number": "number", "boolean": "true or false", None: "value"}
        return names[kind] + self.range_of(node)

    def row(self, key, node, required):
        text = self.description(node)
        default = self.keyword(node, "default")
        written = re.search(r"; default: (.+?)\.$", text)
        if written:
            text, default_text = text[: written.start()] + ".", written.group(1)
        elif default is not None:
            default_text = json.dumps(default).strip('"')
        else:
            default_text = "**required**" if key in required else ""
        return f"| `{key}` | {self.type_of(node)} | {default_text} | {link(text)} |"

    def rows(self, node, prefix=""):
        """A row per key; the keys of an object that is described in place follow it as key/key."""
        rows = []
        for key, value in node.get("properties", {}).items():
            if isinstance(value, bool) or value in IN_EVERY_COMMAND:
                continue
            rows.append(self.row(prefix + key, value, [prefix + one for one in node.get("required", [])]))
            inner = value.get("items", value) if isinstance(value, dict) else value
            if not self.section_of(inner) and "properties" in inner:
                rows += self.rows(inner, prefix + key + "/")
        return rows

    def table(self, node):
        rows = self.rows(node) + self.rows_of_kinds(node)
        if not rows:
            return ["No further keys."]
        return ["| key | type | default | meaning |", "|---|---|---|---|"] + rows

    def rows_of_kinds(self, node):
        """The keys of an object that depend on which kind it is: one row for all kinds that have the same."""
        kinds = {}
        for one in node.get("allOf", []):
            chosen = one.get("if", {}).get("properties", {})
            for key, value in chosen.items():
                for row in self.rows(one["then"]):
                    start, text = row[:-2].rsplit(" | ", 1)
                    kinds.setdefault((start, text), []).append(f"`{value['const']}`")
        return [f"{start} | With {', '.join(names)}: {lower_first(text)} |" for (start, text), names in kinds.items()]

    def forms(self, node):
        """A table of the alternatives of a definition."""
        rows = ["| form | meaning |", "|---|---|"]
        for one in node["anyOf"]:
            resolved = self.resolve(one)
            if "const" in resolved:
                rows.append(f"| `{json.dumps(resolved['const'])}` | {link(resolved.get('description', ''))} |")
                continue
            if "properties" not in resolved:
                if self.section_of(one):
                    rows.append(f"| {self.section_of(one)} | {link(self.description(one))} |")
                elif resolved.get("pattern"):
                    rows.append(f"| expression | {link(resolved.get('description', ''))} |")
                continue
            required = resolved.get("required", [])
            choice = [key for one in resolved.get("oneOf", []) for key in one["required"]]
            keys = [f"`{key}`" + ("" if key in required else " (optional)") for key in resolved["properties"]
                    if key != "held_for_s" and key not in choice]
            keys += [" or ".join(f"`{key}`" for key in choice)] if choice else []
            keys += [f"`{pattern_words(key)}` (optional)" for key in resolved.get("patternProperties", {}) if "above" in key]
            parts = [resolved.get("description", "")]
            for key, value in resolved["properties"].items():
                if key != "held_for_s" and self.description(value):
                    parts.append(f"`{key}`: {self.description(value)}")
            rows.append(f"| {', '.join(keys)} | {link(' '.join(part for part in parts if part))} |")
        return rows

    def section(self, name, title, intro):
        node = self.definitions[name]
        if name == "handlers":
            node = node["items"]
        lines = [f"## {title}", intro, ""]
        if name == "declarations":
            node = node["additionalProperties"]["anyOf"][1]
        lines += self.forms(node) if "anyOf" in node and "properties" not in node else self.table(node)
        return lines + [""]

    def steps(self):
        kinds = self.definitions["step_operations"]["enum"]
        lines = ["## Steps", "A step is an object; `do` names its type. Every step may have a `name`: "
                 + lower_first(self.description(self.definitions["step"]["properties"]["name"])), "",
                 "Operations, whose parameters are in the [reference of operations](operations-reference.md): "
                 + ", ".join(f"[`{kind}`](operations-reference.md#{kind})" for kind in kinds if kind in self.operations) + ".", "",
                 "The others build the tree of the program ([programs.md](programs.md)):", ""]
        for kind in NODES:
            node = self.definitions[kind]
            lines += [f"### {kind}", *([link(node["description"]), ""] if "description" in node else []), *self.table(node), ""]
        return lines

    def commands(self):
        kinds = self.definitions["command_operations"]["enum"]
        node = self.definitions["ptp"]["properties"]
        return ["## Commands", "A command of a [transaction](programs.md#transactions) is written like a step of the same type, without "
                "`name`: " + ", ".join(f"`{kind}`" for kind in kinds) + ". Two more keys:", "",
                "| key | type | default | meaning |", "|---|---|---|---|", self.row("start", node["start"], []),
                f"| `on` | array of [event handlers](#event-handlers) |  | Event handlers of this command. |", ""]

    def kinds(self, name, key):
        """A table for each kind of an object whose key says of which kind it is."""
        lines = []
        for one in self.definitions[name]["allOf"]:
            kind, body = one["if"]["properties"][key]["const"], one["then"]
            lines += [f"### {kind}", body["description"], "", *self.table(body), ""]
        return lines

    def expectations(self):
        return ["## Expectations", "Statements about the run. Only expectations may use the true state of the simulation. Each has a `kind` and "
                "may have a `name`: " + lower_first(self.description(self.definitions["expectation"]["properties"]["name"])), "",
                *self.kinds("expectation", "kind")]

    def faults(self):
        return ["## Faults", "What happens to the machines, or what a person does at the cabinet, at a given time. Each has `at_s`, simulated time "
                "in s, and `do`, its kind; default: `stop`.", "", *self.kinds("fault", "do")]

    def settings(self):
        """A table for each kind of device that has settings."""
        lines = ["## Device settings", "What `settings` of a device may say, by the kind of its model.", ""]
        for one in self.definitions["device_settings"]["anyOf"]:
            body = self.resolve(one)
            others = body.get("additionalProperties")
            lines += [f"### {one['$ref'].rsplit('/', 1)[1].removesuffix('_settings')}", body["description"], "",
                      *self.table(others if isinstance(others, dict) else body), ""]
        return lines

    def render(self):
        lines = ["# Reference of scenario files", "",
                 "This page is printed by `python3 schemas/make_reference.py` from [scenario.schema.json](../schemas/scenario.schema.json); a test "
                 "keeps it up to date. For an introduction see [scenarios.md](scenarios.md) and the [tutorial](tutorial.md).", "",
                 "In every object a key `comment`, and keys that begin with `$`, are allowed and ignored. Any other unknown key is an error. "
                 "Inside a program any value but those of `do` and `name` may be an [expression](programs.md#expressions).", "",
                 "## Top level"]
        lines += self.table(self.schema) + [""]
        for name, title, intro in SECTIONS:
            lines += self.section(name, title, intro)
            if name == "device":
                lines += self.settings()
            if name == "camera":
                lines += self.steps()
            if name == "operator_action":
                lines += self.commands()
        lines += self.faults()
        lines += self.expectations()
        return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).rstrip() + "\n"


def pattern_words(pattern):
    return "above_UNIT or below_UNIT" if "above" in pattern else pattern


def lower_first(text):
    return text[:1].lower() + text[1:]


def link(text):
    """Names of pages in a description become links."""
    return re.sub(r"docs/([\w/-]+\.md)(#[\w-]+)?", lambda m: f"[{m.group(1)}]({m.group(1)}{m.group(2) or ''})", text)


def reference():
    schema = json.loads((ROOT / "schemas/scenario.schema.json").read_text())
    page = (ROOT / "docs/operations-reference.md").read_text()
    operations = set(re.findall(r"^## (\w+)$", page.split("\n# Objects")[0], re.MULTILINE))
    return Page(schema, operations).render()


if __name__ == "__main__":
    sys.stdout.write(reference())
