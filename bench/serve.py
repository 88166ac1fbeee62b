#!/usr/bin/env python3
"""Latencies of takt serve on this machine, with a client in another process: LOAD until Ready, START until its event is read,
a request that only looks, STOP; by streams an event, and a velocity by hand until it moves the set points; what many monitors cost
the cycle. Percentiles in ms; the client (Python) is part of each.

Usage: build/venv/bin/python3 bench/serve.py build/release/tools/takt [--count N] (with the environment that ./takt test makes)
"""
import argparse
import http.client
import json
import pathlib
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time

import websockets.sync.client

SCENARIO = "scenarios/touch.json"
BRIEF = {"name": "brief", "primitives": [{"id": "end", "type": "Termination", "parameters": {"condition": True}}]}


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


def load(client, net):
    """The number of a net that is ready to be started."""
    number = client.ask("POST", "/v1/nets", {"net": net})["net"]
    while (state := client.ask("GET", f"/v1/nets/{number}")["state"]) == "Loading":
        pass
    assert state == "Ready", state
    return number


def measure(client, guarded, count):
    client.headers["Takt-Fence"] = str(client.ask("POST", "/v1/lease", {"cycles": 5000})["fence"])
    looks, loads, starts = [], [], []
    following = client.ask("GET", "/v1/events")["next"]
    for _ in range(count):
        begin = time.perf_counter()
        client.ask("GET", "/v1/state")
        looks.append(time.perf_counter() - begin)
        begin = time.perf_counter()
        net = load(client, guarded)
        loads.append(time.perf_counter() - begin)
        client.ask("DELETE", f"/v1/nets/{net}")
        net = load(client, BRIEF)
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


# A client with monitors of every cycle, for so many seconds; it tells how many frames came.
WATCHER = """
import json, struct, sys, time
import websockets.sync.client
port, monitors, seconds = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
with websockets.sync.client.connect(f"ws://127.0.0.1:{port}/v1/stream", subprotocols=["takt.v1"], max_size=None) as stream:
    stream.send(json.dumps({"op": "window", "frames": 64}))
    for i in range(monitors):
        value = ["q_measured", "q_commanded", "dq_measured", "tau_measured"][i % 4]
        stream.send(json.dumps({"op": "monitor", "id": i, "arm": "arm", "value": value}))
    frames, until = 0, time.monotonic() + seconds
    while time.monotonic() < until:
        message = stream.recv()
        if isinstance(message, bytes):
            frames += 1
            if frames % 16 == 0: stream.send(json.dumps({"op": "ack", "frame": struct.unpack_from("<I", message, 4)[0]}))
    print(frames)
"""


def stream_of(port):
    return websockets.sync.client.connect(f"ws://127.0.0.1:{port}/v1/stream", subprotocols=["takt.v1"])


def measure_events(client, stream, count):
    """START by HTTP until its event has come by the stream."""
    hello = json.loads(stream.recv())
    stream.send(json.dumps({"op": "events", "from": hello["next"]}))
    starts = []
    for _ in range(count):
        net = load(client, BRIEF)
        begin = time.perf_counter()
        request = client.ask("POST", f"/v1/nets/{net}/start", {})["request"]
        done = False
        while not done:
            message = json.loads(stream.recv())
            done = any(event["kind"] == "done" and event["request"] == request for event in message.get("events", []))
        starts.append(time.perf_counter() - begin)
        client.ask("DELETE", f"/v1/nets/{net}")
    line("START by HTTP, until its event has come by a stream (a cycle of 1 ms included)", starts)


def measure_jogging(client, stream, count):
    """A move until a frame shows that q_commanded of the arm changes."""
    fence = int(client.headers["Takt-Fence"])
    stream.send(json.dumps({"op": "jog", "jog": 1, "fence": fence, "arm": "arm", "space": "joints", "timeout_cycles": 1000}))
    while json.loads(stream.recv())["op"] != "jogging":
        pass
    joints = len(client.ask("GET", "/v1/arms/arm")["data_sheet"]["joint_names"])
    stream.send(json.dumps({"op": "monitor", "id": 1, "arm": "arm", "value": "q_commanded"}))
    moves, sequence, resting = [], 0, None
    for i in range(min(count, 100)):
        for rate in (0.02 if i % 2 else -0.02, 0.0):
            begin, waits = time.perf_counter(), rate != 0.0
            sequence += 1
            stream.send(json.dumps({"op": "move", "jog": 1, "sequence": sequence, "rates": [rate] + [0.0] * (joints - 1)}))
            until = time.perf_counter() + (1.0 if waits else 0.15)
            while time.perf_counter() < until:
                message = stream.recv()
                if not isinstance(message, bytes):
                    continue
                stream.send(json.dumps({"op": "ack", "frame": struct.unpack_from("<I", message, 4)[0]}))
                position = message[32:40]
                if waits and resting is not None and position != resting:
                    moves.append(time.perf_counter() - begin)
                    break
                if not waits:
                    resting = position
    stream.send(json.dumps({"op": "unjog", "jog": 1}))
    line("a velocity by hand, until a frame shows that the set point moves (a cycle or two included)", moves)


def measure_monitors(takt, clients, monitors, seconds):
    served, port = serve(takt)
    watchers = [subprocess.Popen([sys.executable, "-c", WATCHER, str(port), str(monitors), str(seconds)], stdout=subprocess.PIPE,
                                 text=True) for _ in range(clients)]
    if not watchers:
        time.sleep(seconds)
    frames = [int(watcher.communicate()[0]) for watcher in watchers]
    report = end(served)
    print(f"{clients} clients with {monitors} monitors each, {seconds:g} s: {sum(frames)} frames, {report['cycles']} cycles, "
          f"{report['overruns']} overruns")


def serve(takt):
    served = subprocess.Popen([takt, "serve", SCENARIO, "--port", "0", "--json"], stderr=subprocess.PIPE, stdout=subprocess.PIPE,
                              text=True)
    found = None
    while found is None:
        found = re.search(r"http://127\.0\.0\.1:(\d+)", served.stderr.readline())
    port = int(found.group(1))
    client = Client(port)
    while not client.ask("GET", "/v1/state")["connected"]:
        time.sleep(0.01)
    return served, port


def end(served):
    served.send_signal(signal.SIGINT)
    return json.loads(served.communicate(timeout=30)[0])


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("takt", type=pathlib.Path)
    arguments.add_argument("--count", type=int, default=300)
    options = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "net.json"
        subprocess.run([options.takt, "net", SCENARIO, "--step", "touch the top", "--dump", file], check=True, capture_output=True)
        guarded = json.loads(file.read_text())
    served, port = serve(options.takt)
    client = Client(port)
    measure(client, guarded, options.count)
    with stream_of(port) as stream:
        measure_events(client, stream, options.count)
    with stream_of(port) as stream:
        measure_jogging(client, stream, options.count)
    report = end(served)
    print(f"\n{report['cycles']} cycles, {report['overruns']} overruns\n")
    for clients, monitors in ((0, 0), (5, 40)):
        measure_monitors(options.takt, clients, monitors, 10.0)


if __name__ == "__main__":
    main()
