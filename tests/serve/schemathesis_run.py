#!/usr/bin/env python3
"""Schemathesis against takt serve: thousands of requests made from the OpenAPI description, with a fixed seed. No test of the gate:
it takes minutes and packages of its own (pip install schemathesis).

Usage: schemathesis_run.py TAKT SCHEMATHESIS [EXAMPLES]
"""
import pathlib
import re
import secrets
import subprocess
import sys
import tempfile

from served import Served

CHECKS = "not_a_server_error,status_code_conformance,response_schema_conformance,content_type_conformance,ignored_auth"
SEED = 41
# Operations that are left out, and why.
EXCLUDED = {"steps": "one order runs 100 000 cycles: minutes", "stream": "it becomes a WebSocket",
            "picture": "drawing takes 0.1 s and more"}
# They change who holds the lease, so they have a run of their own, after the others.
LEASE = ("take_lease", "renew_lease", "release_lease")


def run(program, served, fence, options, examples, folder):
    command = [program, "run", f"http://127.0.0.1:{served.port}/v1/openapi.json", "--checks", CHECKS, "--seed", str(SEED),
               "--max-examples", str(examples), "--phases", "coverage,fuzzing", "--continue-on-failure", "--no-color",
               "-H", f"Authorization: Bearer {served.token}", "-H", f"Takt-Fence: {fence}", *options]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)  # it leaves files behind
    print(done.stdout[-6000:], done.stderr[-2000:])
    counted = re.search(r"([\d,]+) generated", done.stdout)
    return done.returncode, int(counted.group(1).replace(",", "")) if counted else 0


def main():
    takt, program = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    examples = int(sys.argv[3]) if len(sys.argv) > 3 else 500
    token = secrets.token_hex(24)
    with tempfile.TemporaryDirectory() as folder:
        tokens = pathlib.Path(folder) / "tokens"
        tokens.touch(mode=0o600)
        tokens.write_text(f"operator anna {token}\n")
        served = Served(takt, "--lockstep", "--tokens", str(tokens), token=token)
        fence = served.ask("POST", "/v1/lease", {})[1]["fence"]
        all_but = [word for name in (*EXCLUDED, *LEASE) for word in ("--exclude-operation-id", name)]
        only = [word for name in LEASE for word in ("--include-operation-id", name)]
        results = [run(program, served, fence, options, examples, folder) for options in (all_but, only)]
        alive = served.ask("GET", "/v1/state")[0]
        status, errors = served.end()
        print(f"{sum(count for _, count in results)} requests; the server answers {alive} afterwards and ends with {status}")
        sys.exit(max(code for code, _ in results) or alive != 200 or status != 0)


if __name__ == "__main__":
    main()
