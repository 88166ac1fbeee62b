#!/usr/bin/env python3
"""Latencies of takt serve on this machine, with a client in another process: LOAD until Ready, START until its event is read,
a request that only looks, STOP. Percentiles in ms; the client (Python) is part of each.

Usage: bench/serve.py build/release/tools/takt [--count N]
"""
import argparse
import http.client
import json
import pathlib
import re
import signal
import subprocess
import tempfile
import time

SCENARIO = "scenarios/touch.json"


class Client:
    def __init__(self, port):
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
        self.headers = {"Content-Type": "application/json"}

    def ask(self, method, path, body=None):
        self.connection.request(method, path, None if body is None else json.dumps(body), self.headers)
        return json.loads(self.connection.getresponse().read())


def percentile(values, share):
    ordered = sorted(values)
    return 1e3 * ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def line(name, values):
    p50, p99, worst = (percentile(values, share) for share in (0.5, 0.99, 1.0))
    print(f"| {name} | {p50:.2f} | {p99:.2f} | {worst:.2f} |")


def measure(client, guarded, count):
    client.headers["Takt-Fence"] = str(client.ask("POST", "/v1/lease", {"cycles": 5000})["fence"])
    brief = {"name": "brief", "primitives": [{"id": "end", "type": "Termination", "parameters": {"condition": True}}]}
    looks, loads, starts = [], [], []
    following = client.ask("GET", "/v1/events")["next"]
    for _ in range(count):
        begin = time.perf_counter()
        client.ask("GET", "/v1/state")
        looks.append(time.perf_counter() - begin)
        begin = time.perf_counter()
        net = client.ask("POST", "/v1/nets", {"net": guarded})["net"]
        while (state := client.ask("GET", f"/v1/nets/{net}")["state"]) == "Loading":
            pass
        loads.append(time.perf_counter() - begin)
        assert state == "Ready", state
        client.ask("DELETE", f"/v1/nets/{net}")
        net = client.ask("POST", "/v1/nets", {"net": brief})["net"]
        while client.ask("GET", f"/v1/nets/{net}")["state"] == "Loading":
            pass
        begin = time.perf_counter()
        request = client.ask("POST", f"/v1/nets/{net}/start", {})["request"]
        done = False
        while not done:
            page = client.ask("GET", f"/v1/events?from={following}")
            following = page["next"]
            done = any(event["kind"] == "done" and event["request"] == request for event in page["events"])
        starts.append(time.perf_counter() - begin)
        client.ask("DELETE", f"/v1/nets/{net}")
    print("| what | p50 ms | p99 ms | worst ms |\n|---|---|---|---|")
    line("a request that only looks", looks)
    line("LOAD of a guarded motion, until Ready is read", loads)
    line("START, until its event is read (a cycle of 1 ms included)", starts)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("takt", type=pathlib.Path)
    arguments.add_argument("--count", type=int, default=300)
    options = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "net.json"
        subprocess.run([options.takt, "net", SCENARIO, "--step", "touch the top", "--dump", file], check=True, capture_output=True)
        guarded = json.loads(file.read_text())
    served = subprocess.Popen([options.takt, "serve", SCENARIO, "--port", "0", "--json"], stderr=subprocess.PIPE,
                              stdout=subprocess.PIPE, text=True)
    found = None
    while found is None:
        found = re.search(r"http://127\.0\.0\.1:(\d+)", served.stderr.readline())
    client = Client(int(found.group(1)))
    while not client.ask("GET", "/v1/state")["connected"]:
        time.sleep(0.01)
    measure(client, guarded, options.count)
    served.send_signal(signal.SIGINT)
    report = json.loads(served.communicate(timeout=30)[0])
    print(f"\n{report['cycles']} cycles, {report['overruns']} overruns")


if __name__ == "__main__":
    main()
