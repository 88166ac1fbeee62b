"""Programs as trees: written, validated and run as files; conditions as files have them; printed types."""
import json
import pathlib
import subprocess
import sys

import pytest
import takt
from takt import conditions, stubs

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_a_tree_is_a_scenario_file(tmp_path, command_line):
    side = [takt.lin({"by_m": [0, 0.05 * (-1) ** i, 0]}, velocity_m_s=0.2, name=f"side {i}") for i in range(2)]
    scenario = takt.Scenario("wave.json", takt.sequence(takt.ptp("home"), *side, times=2), expectations=[], title="sides")
    assert scenario.check()["title"] == "sides"
    run = scenario.run(record=False)
    path = tmp_path / "sides.json"
    scenario.save(path)
    report = command_line("run", path)
    assert run.passed and run.digest == report["digest"]


def test_nodes_are_those_of_files():
    tree = takt.try_(takt.branch((conditions.input("door") & ~conditions.gripper("hand", "holding"), takt.log("open")),
                                 otherwise=takt.fail("closed")),
                     retry=2, recover=takt.ptp("home"), on_error=[takt.log("$why")], error_as="why", finally_=takt.stop())
    assert tree.as_file() == {
        "do": "try", "retry": 2,
        "steps": [{"do": "branch", "cases": [{"when": {"all": [{"input": "door", "is": True},
                                                               {"not": {"gripper": "hand", "is": "holding"}}]},
                                              "steps": [{"do": "log", "text": "open"}]}],
                   "else": [{"do": "fail", "text": "closed"}]}],
        "on_error": {"as": "why", "steps": [{"do": "log", "text": "$why"}]},
        "recover": [{"do": "ptp", "to": "home"}], "finally": [{"do": "stop"}]}
    loop = takt.repeat(takt.for_each("x", takt.let(y="$x"), in_=[1, 2]), while_="$y < 3", as_="n", at_most=5)
    assert loop.as_file()["while"] == "$y < 3" and loop.as_file()["steps"][0]["as"] == "x"
    assert takt.parallel(takt.ptp("home"), takt.call("p", with_={"a": 1}, as_="r"), end="first").as_file()["branches"][1] == {
        "do": "call", "program": "p", "with": {"a": 1}, "as": "r"}


def test_every_node_of_files_is_there():
    page = (ROOT / "docs/programs.md").read_text()
    kinds = [row.split("`")[1] for row in page.split("## Nodes")[1].split("## Variables")[0].split("\n") if row.startswith("| `") and "| `do`" not in row]
    names = {"try": "try_"}
    assert "for_each" in kinds
    for kind in kinds:
        assert callable(getattr(takt, names.get(kind, kind), None)), kind


def test_what_is_wrong_is_told_with_pointers():
    with pytest.raises(takt.OpenError) as refused:
        takt.Scenario("wave.json", takt.sequence(takt.lin({"by_m": [0, 0, 9]}), takt.lin("home", velocity=1))).check()
    assert {one.pointer.split("/")[1] for one in refused.value.diagnostics} == {"program"}
    assert "unknown-key" in {one.code for one in refused.value.diagnostics}
    for attempt in (lambda: takt.sequence("ptp"), lambda: takt.ptp(object()), lambda: takt.ptp("home", to="home"),
                    lambda: takt.ptp("home", "home"), lambda: bool(conditions.force("w") > 5),
                    lambda: conditions.force("w") > "5", lambda: conditions.input("a") & True):
        with pytest.raises(takt.UsageError):
            attempt()


def test_conditions_are_those_of_files():
    assert (conditions.force("w") > 5).as_file() == {"sensor": "w", "above_N": 5}
    assert (conditions.torque("w", "z") < 1).as_file() == {"sensor": "w", "quantity": "torque_z", "below_Nm": 1}
    assert (conditions.distance("a", "b") < 0.1).as_file() == {"distance": ["a", "b"], "below_m": 0.1}
    assert (conditions.analog("level", "m") > 0.1).as_file() == {"input": "level", "above_m": 0.1}
    assert (conditions.internal_force("l", "r") > 40).as_file() == {"internal_force": ["l", "r"], "above_N": 40}
    assert conditions.channel("c").held_for(1).as_file() == {"channel": "c", "is": True, "held_for_s": 1.0}


@pytest.mark.parametrize("name", sorted(stubs.FILES))
def test_printed_types_are_up_to_date(name):
    assert (ROOT / "python/takt" / name).read_text() == stubs.FILES[name](), "python3 -m takt.stubs python/takt"


def test_every_operation_is_a_method_and_a_step():
    specs = stubs.specifications()
    owners = [takt.Arm, takt.Gripper, takt.ToolChanger, takt.Output, takt.Cell]
    for name, spec in specs.items():
        assert callable(getattr(takt, name))
        if spec.is_step:
            assert sum(hasattr(owner, name) for owner in owners) == 1, name
            assert all(one["doc"] for one in spec.parameters)


def test_types_of_the_examples_and_the_package():
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", f"--cache-dir={ROOT}/build/mypy", "--no-error-summary",
                           *map(str, sorted((ROOT / "examples/python").glob("*.py")))],
                          capture_output=True, text=True, cwd=ROOT / "python")
    assert done.returncode == 0, done.stdout


def test_wrong_types_are_found(tmp_path):
    program = tmp_path / "wrong.py"
    program.write_text('import takt\ndef f(cell: takt.Cell) -> None:\n    cell.arm().lin("home", velocity_m_s="fast")\n'
                       '    cell.gripper().grip(force=3)\n')
    done = subprocess.run([sys.executable, "-m", "mypy", f"--cache-dir={ROOT}/build/mypy", str(program)], capture_output=True, text=True,
                          cwd=ROOT / "python")
    assert done.returncode == 1 and "[arg-type]" in done.stdout and "[call-arg]" in done.stdout, done.stdout
