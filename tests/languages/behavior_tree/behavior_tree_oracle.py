#!/usr/bin/env python3
"""Random behaviour trees, ticked by takt and by BehaviorTree.CPP (behaviortreepy): equal traces of ticks.

Usage: behavior_tree_oracle.py TRACE_PROGRAM [TREES [SEED]]; without behaviortreepy it is skipped (77).
"""
import contextlib
import json
import os
import random
import subprocess
import sys

try:
    import behaviortreepy as bt
except ImportError:
    print("skipped: behaviortreepy is not installed")
    sys.exit(77)

TICKS = 25
RULE = "more than one async child"  # a rule of the library's reader that takt does not have
ENTRIES = ("a", "b", "c")
WORDS = ("x", "y", "z")  # of the entry "word"
CONTROLS = ("Sequence", "AsyncSequence", "AsyncFallback", "ReactiveSequence", "SequenceWithMemory", "Fallback", "ReactiveFallback", "Parallel", "ParallelAll",
            "IfThenElse", "WhileDoElse", "Switch2", "Switch3")
DECORATORS = ("Inverter", "ForceSuccess", "ForceFailure", "Repeat", "RetryUntilSuccessful", "KeepRunningUntilFailure", "RunOnce")


class Tree:
    """A random tree as XML, with the patterns of its leaves."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.leaves = {}
        self.subtrees = []
        body = self.node(0)
        trees = [f'<BehaviorTree ID="Main">{body}</BehaviorTree>', *self.subtrees]
        self.xml = f'<root BTCPP_format="4" main_tree_to_execute="Main">{"".join(trees)}</root>'
        self.entries = {name: self.random.randrange(4) for name in ENTRIES}
        self.entries["word"] = self.random.choice(WORDS)

    def condition(self):
        name, op = self.random.choice(ENTRIES), self.random.choice(("==", "!=", "&lt;", "&lt;=", ">", ">="))
        text = f"{name} {op} {self.random.randrange(4)}"
        if self.random.random() < 0.2:
            text += self.random.choice((" &amp;&amp; ", " || ")) + f"{self.random.choice(ENTRIES)} == {self.random.randrange(4)}"
        return text

    def script(self):
        name, other = self.random.choice(ENTRIES), self.random.choice(ENTRIES)
        return self.random.choice((f"{name} += 1", f"word = '{self.random.choice(WORDS)}'", f"{name} = 0", f"{name} := {self.random.randrange(4)}",
                                   f"{name} = {other} > 1 ? 0 : {other} + 1", f"{name} -= 1; {other} = {name} * 2"))

    def around(self, plain=False):
        """Scripts before and after a node."""
        if plain or self.random.random() > 0.25:
            return ""
        text = ""
        if self.random.random() < 0.5:
            text += f' {self.random.choice(("_failureIf", "_successIf", "_skipIf", "_while"))}="{self.condition()}"'
        if self.random.random() < 0.6:
            text += f' {self.random.choice(("_onHalted", "_onFailure", "_onSuccess", "_post"))}="{self.script()}"'
        return text

    def leaf(self, instant=False, plain=False):
        name = f"L{len(self.leaves)}"
        longest = 0 if instant else self.random.choice((0, 0, 1, 3))
        self.leaves[name] = [f"{self.random.randint(0, longest)}{self.random.choice('SF')}" for _ in range(self.random.randint(1, 3))]
        return f"<{name}{self.around(plain)}/>"

    def node(self, depth, instant=False, plain=False):
        kind = self.random.random()
        if instant or depth > 4 or kind < 0.3 * depth:
            small = self.random.random()
            if small < 0.15:
                return f'<Script code="{self.script()}"{self.around(plain)}/>'
            if small < 0.3:
                return f'<ScriptCondition code="{self.condition()}"{self.around(plain)}/>'
            if small < 0.4:
                return f"<{self.random.choice(('AlwaysSuccess', 'AlwaysFailure'))}{self.around(plain)}/>"
            return self.leaf(instant, plain)
        if self.random.random() < 0.3:
            return self.decorator(depth)
        if len(self.subtrees) < 3 and self.random.random() < 0.08:
            return self.subtree(depth)
        return self.control(depth)

    def subtree(self, depth):
        number = len(self.subtrees)
        self.subtrees.append("")
        remapped = self.random.choice((' _autoremap="true"', ' a="{b}" b="{c}" c="{a}" word="{word}"', ' a="{=}" b="{=}" c="{=}" word="{=}"'))
        self.subtrees[number] = f'<BehaviorTree ID="Sub{number}">{self.node(depth + 1)}</BehaviorTree>'
        return f'<SubTree ID="Sub{number}"{remapped}{self.around()}/>'

    def control(self, depth):
        name = self.random.choice(CONTROLS)
        ports, count, first_plain = "", self.random.randint(1, 4), False
        if name == "Parallel":
            ports = f' success_count="{self.random.choice([-1, -2, 1, count])}" failure_count="{self.random.choice([1, -1, count])}"'
        elif name == "ParallelAll":
            ports = f' max_failures="{self.random.randint(1, count)}"'
        elif name in ("IfThenElse", "WhileDoElse"):
            count, first_plain = self.random.randint(2, 3), True
        elif name.startswith("Switch"):
            cases = int(name[-1])
            count = cases + 1
            ports = ' variable="{word}"' + "".join(f' case_{i + 1}="{WORDS[i]}"' for i in range(cases))
        children = [self.node(depth + 1, instant=first_plain and i == 0, plain=first_plain and i == 0) for i in range(count)]
        return f"<{name}{ports}{self.around()}>{''.join(children)}</{name}>"

    def decorator(self, depth):
        name = self.random.choice(DECORATORS)
        ports = {"Repeat": f' num_cycles="{self.random.randint(1, 3)}"',
                 "RetryUntilSuccessful": f' num_attempts="{self.random.randint(1, 3)}"',
                 "RunOnce": f' then_skip="{self.random.choice(("true", "false"))}"'}.get(name, "")
        return f"<{name}{ports}{self.around()}>{self.node(depth + 1)}</{name}>"

    def task(self):
        return {"xml": self.xml, "ticks": TICKS, "leaves": self.leaves, "entries": self.entries}


class Oracle:
    """What BehaviorTree.CPP does with a tree."""

    def __init__(self, tree):
        self.tree, self.started, self.running, self.events = tree, {}, {}, []
        factory = bt.BehaviorTreeFactory()
        for name, patterns in tree.leaves.items():
            if all(one.startswith("0") for one in patterns):  # a condition: over in each of its ticks
                factory.register_simple_action(name, self.starter(name))
            else:
                factory.register_simple_stateful_action(name, self.starter(name), self.runner(name), self.halter(name))
        board = bt.Blackboard.create()
        for name, value in tree.entries.items():
            (board.set_string if isinstance(value, str) else board.set_int)(name, value)
        factory.register_behavior_tree_from_text(tree.xml)
        self.made = factory.create_tree("Main", board)

    def starter(self, name):
        def start(node):
            patterns = self.tree.leaves[name]
            pattern = patterns[self.started.get(name, 0) % len(patterns)]
            self.started[name] = self.started.get(name, 0) + 1
            self.running[name] = [int(pattern[0]), bt.NodeStatus.SUCCESS if pattern[1] == "S" else bt.NodeStatus.FAILURE]
            self.events.append("start " + name)
            return self.state(name)
        return start

    def runner(self, name):
        def run(_):
            self.running[name][0] -= 1
            self.events.append("run " + name)
            return self.state(name)
        return run

    def halter(self, name):
        return lambda _: self.events.append("halt " + name)

    def state(self, name):
        left, end = self.running[name]
        return bt.NodeStatus.RUNNING if left > 0 else end

    def trace(self):
        ticks = []
        for _ in range(TICKS):
            self.events.clear()
            status = self.made.tick_exactly_once()
            ticks.append([status.name, *self.events])
        board = self.made.root_blackboard()
        return {"ticks": ticks, "entries": {name: board.get_string(name) if name == "word" else board.get_double(name)
                                            for name in self.tree.entries}}


@contextlib.contextmanager
def silent():
    """The library says what it does on stdout."""
    sys.stdout.flush()
    before = os.dup(1)
    with open(os.devnull, "wb") as nothing:
        os.dup2(nothing.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(before, 1)
        os.close(before)


def main():
    program, trees = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 300
    first = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    made = [Tree(seed) for seed in range(first, first + trees)]
    lines = "".join(json.dumps(tree.task()) + "\n" for tree in made)
    done = subprocess.run([program], input=lines, capture_output=True, text=True, check=True)
    wrong = refused = 0
    for seed, (tree, line) in enumerate(zip(made, done.stdout.splitlines(), strict=True), first):
        ours = json.loads(line)
        try:
            with silent():
                theirs = Oracle(tree).trace()
        except Exception as error:  # what it throws has no common base
            theirs = {"error": str(error)}
        if "error" in theirs and ("error" in ours or RULE in theirs["error"]):
            refused += 1
            continue
        if ours == theirs:
            continue
        wrong += 1
        if wrong > 3:
            continue
        print(f"seed {seed}: {tree.xml}\n  leaves {tree.leaves}\n  entries {tree.entries}")
        if "error" in ours or "error" in theirs:
            print("  takt  ", ours.get("error", "runs"), "\n  oracle", theirs.get("error", "runs"))
            continue
        for number, (a, b) in enumerate(zip(ours["ticks"], theirs["ticks"])):
            if a != b:
                print(f"  tick {number}\n  takt   {a}\n  oracle {b}")
                break
        else:
            print("  entries", ours["entries"], theirs["entries"])
    print(f"{trees} trees of {TICKS} ticks, {refused} refused by both, {wrong} differ")
    return 1 if wrong or refused > trees // 5 else 0


if __name__ == "__main__":
    sys.exit(main())
