"""Hints of diagnostics: each says what to do, as a sentence that begins with a verb in the imperative. Texts that are put
together in the run (nearest_choice and the like) are not looked at."""
import re

CALL = re.compile(r"\b(error|warning|failure|broken|fault_of)\(")
LITERALS = re.compile(r'"((?:\\.|[^"\\])*)"')
ASSIGNED = re.compile(r'\bhint = (?:fmt::format\(\s*)?"((?:\\.|[^"\\])*)"')
VERBS = set("""Accept Acknowledge Add Allow Ask Attach Begin Bless Break Build Call Change Check Choose Close Compose Convert Create
Declare Decrease Define Delete Drill Drive Drop End Expand Feed Fix Fold Forward Free Give Go Include Increase Install
Keep Lay Lead Leave Let Lighten Limit Link List Load Log Lower Make Mark Measure Merge Model Mount Move Name Narrow
Open Pass Plan Power Press Provide Put Raise Rebuild Record Reduce Reinstall Release Remove Rename Repeat Replace
Report Reset Rest Restart Reverse Rotate Run Save Say See Send Set Shorten Show Shut Simplify Simulate Slow Sort Split
Start State Step Stop Switch Take Tell Touch Try Turn Unload Update Use Wait Watch Widen Write""".split())


def arguments(text, opening):
    """The arguments of a call as texts; `opening` is the position of its parenthesis."""
    depth, begin, at, found = 0, opening + 1, opening, []
    while at < len(text):
        character = text[at]
        if character == '"':
            at += 1
            while text[at] != '"':
                at += 2 if text[at] == "\\" else 1
        elif character in "([{":
            depth += 1
        elif character in ")]}":
            depth -= 1
            if depth == 0:
                return found + [text[begin:at].strip()]
        elif character == "," and depth == 1:
            found.append(text[begin:at].strip())
            begin = at + 1
        at += 1
    return found


def hint_of(call, words):
    """The hint among the arguments of a call, or nothing."""
    codes = [number for number, word in enumerate(words) if word.startswith("Code::k")]
    if not codes:
        return None
    number = codes[0] + (2 if call == "fault_of" else 3)
    if number <= len(words) and re.fullmatch(r'"C\d+"', words[number - 1]):
        number += 1  # a rule of the command layer has its id before the message
    return words[number] if number < len(words) else None


def diagnostics(name, text):
    """(file, line, text) of each hint that does not begin with a verb."""
    hints = [(match.start(), match.group(1)) for match in ASSIGNED.finditer(text)]
    for match in CALL.finditer(text):
        hint = hint_of(match.group(1), arguments(text, match.end() - 1))
        if hint is not None and hint.startswith(('"', 'fmt::format("')):
            hints.append((match.start(), LITERALS.search(hint).group(1)))
    for place, first in hints:
        word = re.match(r"[A-Za-z]+", first)
        if first and not first.startswith("{}") and (word is None or word.group(0) not in VERBS):
            yield (name, text[:place].count("\n") + 1,
                   f"the hint '{first[:40]}' does not begin with what to do (lint/hints.py lists verbs)")
