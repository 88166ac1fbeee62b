"""What tests of the Python package share."""
import json
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TAKT = os.environ.get("TAKT_PROGRAM", str(ROOT / "build/release/tools/takt"))


@pytest.fixture
def command_line():
    """The report of `takt VERB ... --json`."""
    def run(*arguments):
        done = subprocess.run([TAKT, *map(str, arguments), "--json"], capture_output=True, text=True, cwd=ROOT)
        return json.loads(done.stdout)
    return run


@pytest.fixture(scope="session")
def touched():
    """One run of a scenario with a sensor and an arm, recorded."""
    import takt
    return takt.run(ROOT / "scenarios/touch.json", set={"/expectations": []})
