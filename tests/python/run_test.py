"""Runs of scenario files in the Python process: the same bits as the command line, refusals, Ctrl-C, threads."""
import os
import pathlib
import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest
import takt

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_a_run_has_the_digest_of_the_command_line(touched, command_line):
    report = command_line("run", "scenarios/touch.json", "--set", "/expectations=[]")
    assert touched.passed and touched.result == "passed"
    assert (touched.digest, touched.cycles) == (report["digest"], report["cycles"])
    assert [one["text"] for one in touched.events] == [one["text"] for one in report["events"]]


def test_seed_and_values_count(command_line):
    run = takt.run("wave.json", seed=3, record=False, set={"/expectations": []})
    assert run.digest == command_line("run", "scenarios/wave.json", "--seed", 3, "--set", "/expectations=[]")["digest"]


def test_expectations_are_those_of_the_file():
    run = takt.run("wave.json", record=False, set={"/expectations": [{"name": "soon", "kind": "duration", "below_s": 0.001}]})
    assert (run.result, run.passed) == ("failed", False)
    assert [(one.name, one.passed) for one in run.expectations] == [("soon", False)]


def test_a_film_is_made(tmp_path):
    film = tmp_path / "wave.mp4"
    takt.run("wave.json", video=film, size="160x120", fps=2, record=False, set={"/expectations": []})
    assert film.stat().st_size > 1000


def test_all_that_is_wrong_with_a_file_is_said():
    with pytest.raises(takt.OpenError) as refused:
        takt.run("wave.json", set={"/devices/arm/model": "lwr4", "/devices/arm/colour": 1})
    assert {one.pointer for one in refused.value.diagnostics} >= {"/devices/arm/model", "/devices/arm/colour"}
    assert {one.code for one in refused.value.diagnostics} >= {"unknown-name", "unknown-key"}


def test_a_file_that_is_not_there():
    with pytest.raises(takt.OpenError) as refused:
        takt.run("nothing.json")
    assert refused.value.code in ("not-found", "file-not-readable")


def test_wrong_options_have_names():
    with pytest.raises(takt.UsageError) as refused:
        takt.run("wave.json", sed=3)
    assert (refused.value.code, refused.value.pointer) == ("unknown-key", "sed")
    with pytest.raises(takt.OpenError) as refused:
        takt.run("wave.json", seed="three", size="big")
    assert {one.pointer for one in refused.value.diagnostics} == {"seed", "size"}


def test_other_threads_run_meanwhile():
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)
    thread = threading.Thread(target=count)
    thread.start()
    takt.run("wave.json", record=False, set={"/expectations": []})
    done.set()
    thread.join()
    assert counted > 20


INTERRUPTED = """
    import os, signal, sys, threading, time, takt
    signal.signal(signal.SIGINT, signal.default_int_handler)  # who starts this may ignore it
    def kill():
        time.sleep(0.4)
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=kill, daemon=True).start()
    try:
        {work}
    except KeyboardInterrupt:
        print("interrupted")
"""


@pytest.mark.parametrize("work", ["takt.run('wave.json', record=sys.argv[1], set={'/program': {'do': 'wait', 'seconds': 3000}, '/expectations': [], '/time_limit_s': 3600})",
                                  "takt.open('wave.json', record=sys.argv[1], set={'/time_limit_s': 3600}).wait(3000)"])
def test_ctrl_c_ends_in_order(work, tmp_path):
    program = textwrap.dedent(INTERRUPTED.format(work=work))
    recording = tmp_path / "run.mcap"
    done = subprocess.run([sys.executable, "-c", program, str(recording)], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "interrupted\n"), done.stderr
    if "run(" in work:
        assert takt.open_recording(recording).damage == []


def test_check_moves_nothing():
    checked = takt.check("touch.json")
    assert checked["steps"] > 5 and checked["planned_duration"] > 5
