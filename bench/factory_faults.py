#!/usr/bin/env python3
"""What Factory 2020 does when something goes wrong: each fault with the outcome that is expected of it, as a table.

  bench/factory_faults.py TAKT [--jobs N] [NAME...]     TAKT: the program; names: only faults that contain one of them
  bench/factory_faults.py --check                       runs nothing: only whether the scenario has the expectations named here

A fault is a change of the scenario. It ends as it should if the run has the expected result, something of its log or of its diagnostics has the expected
text, and every expectation holds that the fault does not break: forces, limits, arms that never touch each other. Exit status 1 if one does not.
"""
import argparse
import concurrent.futures
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENARIO = "scenarios/factory2020.json"
# What holds whatever happens, by the beginning of its name.
ALWAYS = ["the states follow", "bottom 1 was", "top 1 was", "screw 1 was", "workpiece 1 was", "the left arm", "the right arm", "the platform inside",
          "the arms did not pull", "the arms moved as one", "nothing touched", "nothing was lost", "done in time"]
# What has not happened yet when a run ends early.
EARLY = ["the states follow", "bottom 1 was", "top 1 was", "screw 1 was", "workpiece 1 was", "the left arm touched", "the right arm touched",
         "the left arm gripped", "the right arm gripped", "the arms did not pull", "the arms moved as one"]

# A bottom whose thread was cut askew by 6.5 degrees: its boss is four walls around an insert that leans.
BLOCK = {"shape": "box", "size_m": [0.036, 0.036, 0.03], "position_m": [0, 0, 0.015]}
WALLS = [{"shape": "box", "size_m": [0.018, 0.003, 0.01], "position_m": [0, y, 0.035]} for y in (-0.0075, 0.0075)] + [
    {"shape": "box", "size_m": [0.003, 0.012, 0.01], "position_m": [x, 0, 0.035]} for x in (-0.0075, 0.0075)]
INSERT = {"shape": "box", "size_m": [0.01, 0.01, 0.009], "position_m": [0, 0, 0.0347], "rpy_deg": [6.5, 0, 0],
          "bores": [{"position_m": [0, 0, 0.0045], "thread": "M6"}]}

FAULTS = [
    # name, changes, result, text, expectations that need not hold
    ("the platform is late", ["/program/steps/0/branches/0/steps/0/steps/0/speed=0.05"], "error", "until the platform is docked", EARLY),
    ("a container 13 mm off", ["/objects/tops box/at/position_m=[0.013,-0.1,0.56]"], "passed", "the tops not found where expected: once more", []),
    ("a container 60 mm off", ["/objects/tops box/at/position_m=[0.06,-0.1,0.56]"], "error", "tops", EARLY),
    ("a container that is not there", ["/objects/bottoms box/at/position_m=[0,-2.5,0]", "/objects/bottom #/at={\"in\":\"world\",\"position_m\":[2,0,0]}"],
     "error", "the bottoms not found where expected", EARLY + ["nothing touched"]),
    ("a top is missing", ["/objects/top #/copies/step_m=[-0.12,0,0]"], "failed", "workpiece 2 is skipped: no top", []),
    ("a bottom is missing", ["/objects/bottom #/copies/step_m=[0.14,0,0]"], "failed", "workpiece 2 is skipped: no bottom", []),
    # It is thrown out of the magazine, since a program that finds none in the belief is refused.
    ("a screw is missing", ['/faults=[{"do":"push","at_s":2,"body":"screw 2","force_N":[0.04,0,0.11],"seconds":0.1}]'], "failed",
     "workpiece 2 goes back unfinished: no screw", []),
    ("a top without its hole", ["/objects/top #/parts/0/bores=[]"], "failed", "workpiece 1 goes back unfinished", []),
    ("a thread that is too small", ["/objects/bottom #/parts/1/bores/0/thread=M5"], "failed", "workpiece 1 goes back unfinished", []),
    ("a crossed thread", ["/objects/bottom #/parts=" + json.dumps([BLOCK, *WALLS, INSERT])], "failed", "unfinished: the thread is crossed", []),
    ("a screw that jams", ["/objects/bottom #/parts/1/bores/0/depth_m=0.003"], "failed", "unfinished: the screw jams", []),
    ("a push while an arm touches", ['/faults=[{"do":"push","at_s":20,"body":"left/link7","force_N":[0,60,0],"seconds":0.3}]'], "passed",
     "the platform not found where expected: once more", []),
    ("a blow while a top is joined", ['/faults=[{"do":"push","at_s":86,"body":"right gripper/base","force_N":[0,0,-100],"seconds":0.1}]'], "passed",
     "once more, in a wider circle", ["top 1 was"]),
    ("a force sensor that is silent", ['/faults=[{"do":"sensor","at_s":86,"sensor":"right wrist","fault":"silent","seconds":60}]'], "error",
     "cannot be made", EARLY),
    ("an arm that stops by itself", ['/faults=[{"do":"stop","at_s":50,"arm":"left","category":1}]'], "error", "left", EARLY),
    ("an emergency stop with a container in both hands", ['/faults=[{"do":"emergency_stop","at_s":36,"category":1}]'], "error", "emergency", EARLY),
]


def run(takt, changes):
    scenario = json.loads((ROOT / SCENARIO).read_text())
    repeats = next(i for i, one in enumerate(scenario["expectations"]) if one["kind"] == "repeats")
    command = [takt, "run", SCENARIO, "--seed", "1", "--json", "--set", f'/expectations/{repeats}={{"kind":"duration","below_s":450}}']
    for change in changes:
        command += ["--set", change]
    ended = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    try:
        return json.loads(ended.stdout), ended.stderr
    except json.JSONDecodeError:
        return {"result": f"status {ended.returncode}", "expectations": [], "sim_time": 0.0}, ended.stderr


def judge(report, log, result, text, excused):
    """What is wrong, in words."""
    wrong = []
    if report["result"] != result:
        wrong.append(f"{report['result']} in place of {result}")
    said = log + json.dumps(report, ensure_ascii=False)
    if text not in said:
        wrong.append(f"nothing says '{text}'")
    for one in report.get("expectations", []):
        must = any(one["name"].startswith(name) for name in ALWAYS) and not any(one["name"].startswith(name) for name in excused)
        if must and not one["passed"]:
            wrong.append(f"{one['name']}: {one['measured']}")
    return wrong


def message_of(log, report):
    errors = [one["message"] for one in report.get("diagnostics", []) if one.get("severity") == "error"]
    said = re.findall(r"program log: (.*(?:is skipped|unfinished|once more).*?)(?:  \[|$)", log, re.M)
    return (errors[-1:] or said[-1:] or [""])[0].replace("|", "/")


def unknown_names():
    """Beginnings that no expectation of the scenario has, as they would judge or excuse nothing."""
    scenario = json.loads((ROOT / SCENARIO).read_text())
    known = [one["name"].replace("#", "1") for one in scenario["expectations"]]
    used = {*ALWAYS, *EARLY, *(name for *_, excused in FAULTS for name in excused)}
    return sorted(name for name in used if not any(one.startswith(name) for one in known))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("takt", nargs="?")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--check", action="store_true")
    given = parser.parse_intermixed_args()
    if unknown := unknown_names():
        parser.error(f"no expectation of {SCENARIO} begins with: {', '.join(map(repr, unknown))}")
    if given.check:
        return 0
    if given.takt is None:
        parser.error("TAKT is missing")
    if strange := [name for name in given.names if not any(name in one[0] for one in FAULTS)]:
        parser.error(f"no fault is named: {', '.join(map(repr, strange))}")
    chosen = [one for one in FAULTS if not given.names or any(name in one[0] for name in given.names)]
    takt = str(pathlib.Path(given.takt).resolve())
    print("| fault | ends | at | with |\n|---|---|---|---|")
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        runs = pool.map(lambda one: run(takt, one[1]), chosen)
        for (name, _, result, text, excused), (report, log) in zip(chosen, runs):
            wrong = judge(report, log, result, text, excused)
            failed += bool(wrong)
            print(f"| {name} | {report['result']} | {report.get('sim_time', 0.0):.1f} s | {message_of(log, report)} |{'  WRONG: ' + '; '.join(wrong) if wrong else ''}",
                  flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
