"""Circles of modules: a module is a header with its source file, and modules that include each other, however far around,
can only be understood and tested together. None may come; those that are left from earlier days are listed in circles.txt,
which only gets shorter. 'circles.py --write' writes that list anew."""
import collections
import pathlib
import re
import sys

INCLUDE = re.compile(r'^#include "([^"]+)\.h"', re.MULTILINE)
FOLDERS = ("app/", "serve/", "core/", "hw/", "record/", "cell/", "sim/", "tools/")


def modules(root, names):
    """Name of each module and what it includes, by its header or its source file."""
    files = [name for name in names if name.startswith(FOLDERS) and name.endswith((".h", ".cc"))]
    known = {name.rsplit(".", 1)[0] for name in files}
    graph = collections.defaultdict(set)
    for name in files:
        module = name.rsplit(".", 1)[0]
        graph[module] |= {other for other in INCLUDE.findall((root / name).read_text()) if other in known and other != module}
    return graph


def circles(graph):
    """The circles as lists of modules, by Tarjan's algorithm without recursion."""
    index, low, stack, on_stack, found = {}, {}, [], set(), []
    for start in sorted(graph):
        if start in index:
            continue
        work = [(start, iter(sorted(graph[start])))]
        index[start] = low[start] = len(index)
        stack.append(start)
        on_stack.add(start)
        while work:
            module, others = work[-1]
            for other in others:
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    on_stack.add(other)
                    work.append((other, iter(sorted(graph[other]))))
                    break
                if other in on_stack:
                    low[module] = min(low[module], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[module])
                if low[module] == index[module]:
                    members = []
                    while not members or members[-1] != module:
                        members.append(stack.pop())
                        on_stack.discard(members[-1])
                    if len(members) > 1:
                        found.append(sorted(members))
    return sorted(found)


def diagnostics(root, names):
    """(file, line, text) of each module in a circle that is not listed, and of each listed one that is in none."""
    listed = [line.strip() for line in (root / "lint/circles.txt").read_text().split("\n")]
    found = circles(modules(root, names))
    inside = {module for circle in found for module in circle}
    for circle in found:
        fresh = [module for module in circle if module not in listed]
        if fresh:
            yield (fresh[0] + ".h", 1, "a circle of modules that include each other: " + ", ".join(circle))
    for number, module in enumerate(listed, 1):
        if module and not module.startswith("#") and module not in inside:
            yield ("lint/circles.txt", number, f"{module} is in no circle any more: delete this line")


def main():
    import lint
    found = circles(modules(lint.ROOT, lint.tracked()))
    if sys.argv[1:] == ["--write"]:
        text = "# Modules that include each other in a circle, circle by circle (circles.py). This list only gets shorter.\n"
        text += "\n".join("\n".join(circle) + "\n" for circle in found)
        pathlib.Path(lint.ROOT / "lint/circles.txt").write_text(text)
    print(f"{len(found)} circles with {sum(len(circle) for circle in found)} modules")


if __name__ == "__main__":
    main()
