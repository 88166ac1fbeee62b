"""Names in unnamed namespaces, folder by folder: files of a folder are compiled together (cmake/TaktLayers.cmake), where a
name that two of them give to different things does not compile. Knows as much C++ as that takes."""
import collections
import pathlib
import re

# Comments, strings and characters, so that their braces do not count.
NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])\'', re.DOTALL)
NAMESPACE = re.compile(r"\bnamespace\s*([\w:]*)\s*$")
TYPE = re.compile(r"(?:^|\s)(?:struct|class|enum(?:\s+class)?|union)\s+(\w+)\s*(?::[^:].*|final.*)?$", re.DOTALL)
ALIAS = re.compile(r"^using\s+(\w+)\s*=\s*(.*)$", re.DOTALL)
VARIABLE = re.compile(r"([A-Za-z_]\w*)\s*(?:\[[^\]]*\]\s*)?(?:=.*)?$", re.DOTALL)
FUNCTION = re.compile(r"([A-Za-z_]\w*)\s*\((.*)\)\s*(?:const|noexcept|->\s*[\w:<>]+|\s)*$", re.DOTALL)


def parameters(text):
    """The types of parameters, more or less: what makes two functions of one name different."""
    return re.sub(r"\s+", " ", re.sub(r"\s*\w+\s*(?==|,|$)", "", re.sub(r"=[^,]*", "", text))).strip()


def meaning(statement):
    """(name, kind) of what is declared; two that are equal in both may be declared side by side."""
    statement = re.sub(r"^\s*(?:template\s*<[^{}]*?>\s*(?=[\w\[]))", "", statement.strip())
    statement = re.sub(r"\[\[[^\]]*\]\]\s*", "", statement)
    if not statement or statement.startswith(("using namespace", "#", "static_assert", "extern", "friend", "case")):
        return None
    alias = ALIAS.match(statement)
    if alias:
        return alias.group(1), "alias " + re.sub(r"\s+", "", alias.group(2))
    if statement.startswith("using"):
        return None
    kind = TYPE.search(statement)
    if kind:
        return kind.group(1), "type"
    head = statement.split("=")[0] if "(" not in statement.split("=")[0] else statement
    function = FUNCTION.search(head)
    if function:
        # Macros, such as TEST, and members of a class are no names of the namespace.
        if function.group(1).isupper() or re.match(r"[A-Z]+_", function.group(1)) or head[: function.start()].endswith("::"):
            return None
        return function.group(1), "function (" + parameters(function.group(2)) + ")"
    variable = VARIABLE.search(head.split("{")[0].strip())
    if variable and re.match(r"(?:inline |static |const |constexpr |constinit |thread_local )", statement):
        return variable.group(1), "variable"
    return None


def declared(text):
    """All (named namespace, name, kind, line) that a file declares in its unnamed namespaces."""
    text = NOISE.sub(lambda match: ("" if match.group(0)[0] == "/" else "0") + "\n" * match.group(0).count("\n"), text)
    text = re.sub(r"^\s*#(?:[^\n]*\\\n)*[^\n]*", lambda match: "\n" * match.group(0).count("\n"), text, flags=re.MULTILINE)
    stack, begin = [], 0
    for match in re.finditer(r"[{};]", text):
        at, sign = match.start(), match.group(0)
        statement = text[begin:at]
        open_here = all(kind == "namespace" for kind, _ in stack)
        unnamed = open_here and any(name == "" for _, name in stack)
        if sign == "{":
            space = NAMESPACE.search(statement)
            stack.append(("namespace", space.group(1)) if space else ("block", "block"))
            if not space and unnamed:
                found = meaning(statement)
                if found:
                    yield "::".join(name for _, name in stack[:-1] if name), *found, text.count("\n", 0, at) + 1
            begin = at + 1
        elif sign == "}":
            if stack:
                stack.pop()
            begin = at + 1
        else:
            if unnamed:
                found = meaning(statement)
                if found and found[1] != "type":
                    yield "::".join(name for _, name in stack if name), *found, text.count("\n", 0, at) + 1
            begin = at + 1


def collisions(root, names):
    """(file, line, text) for each name that an earlier file of the same folder has for something else."""
    for folder, files in sorted(by_folder(root, names).items()):
        seen = {}
        for file in sorted(files):
            own = set()
            for space, name, kind, line in declared((pathlib.Path(root) / file).read_text(errors="replace")):
                other = seen.get((space, name))
                clash = other and other[0] != file and (other[1] == kind if kind.startswith("function") else
                                                        not (kind.startswith("alias") and other[1] == kind))
                if clash and name not in own:
                    yield file, line, f"'{name}' is in the unnamed namespace of {other[0]} too; they are compiled together"
                own.add(name)
                seen.setdefault((space, name), (file, kind))


def by_folder(root, names):
    """The files of each folder that takt_layer or takt_tests compiles together."""
    folders = collections.defaultdict(list)
    for name in names:
        path = pathlib.PurePath(name)
        folder = path.parent if (pathlib.Path(root) / path.parent / "CMakeLists.txt").is_file() else path.parent.parent
        made = pathlib.Path(root) / folder / "CMakeLists.txt"
        if path.suffix != ".cc" or not made.is_file():
            continue
        call = re.search(r"takt_(?:layer|tests)\(([^)]*)\)", made.read_text())
        if call and path.name not in call.group(1).partition("ALONE")[2].split():
            folders[str(folder)].append(name)  # the rooms of a layer are compiled together
    return folders
