#!/usr/bin/env python3
"""Clients of takt serve that die while they move an arm by hand: connections that are reset, that are closed, and that only fall
silent, at random times. Each time the arm has to be at rest and free within the timeout and the time to brake, and a new client
moves it; no guard trips meanwhile. Prints the cycles from the last velocity to rest.

Usage: build/venv/bin/python3 bench/serve_deaths.py build/release/tools/takt [--count N] [--seed N]
"""
import argparse
import json
import pathlib
import random
import socket
import struct
import sys
import time

import websockets.sync.client

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/serve"))
from served import Served  # noqa: E402

TIMEOUT = 100  # cycles
MOST = 1000  # cycles: any arm of the project has come to rest by then


def jog(served, fence):
    socket_ = socket.create_connection(("127.0.0.1", served.port))
    connection = websockets.sync.client.connect(f"ws://127.0.0.1:{served.port}/v1/stream", sock=socket_, subprotocols=["takt.v1"])
    stream = connection.__enter__()
    stream.send(json.dumps({"op": "jog", "jog": 1, "fence": fence, "arm": "arm", "space": "tool", "timeout_cycles": TIMEOUT,
                            "linear_max_m_s": 0.2}))
    while json.loads(stream.recv(timeout=10))["op"] != "jogging":
        pass
    return socket_, connection, stream


def die(how, socket_, connection):
    if how == "reset":
        socket_.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        socket_.shutdown(socket.SHUT_RD)
        socket_.close()
    elif how == "closed":
        connection.__exit__(None, None, None)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("takt", type=pathlib.Path)
    arguments.add_argument("--count", type=int, default=100)
    arguments.add_argument("--seed", type=int, default=41)
    options = arguments.parse_args()
    generator = random.Random(options.seed)
    served = Served(options.takt.resolve(), "--realtime")
    fence = served.ask("POST", "/v1/lease", {"cycles": 600000})[1]["fence"]
    rests, late, early = {"reset": [], "closed": [], "silent": []}, 0, 0
    for number in range(options.count):
        how = generator.choice(list(rests))
        socket_, connection, stream = jog(served, fence)
        direction = (-1) ** number * 0.15
        for sequence in range(generator.randrange(5, 25)):
            stream.send(json.dumps({"op": "move", "jog": 1, "sequence": sequence, "linear": [0, 0, direction]}))
            answer = json.loads(stream.recv(timeout=10))
            if answer["op"] != "moved":  # the machine was busy for so long that it counts as silent
                early += 1
                break
            moved = answer
            time.sleep(generator.uniform(0.0, 0.03))
        die(how, socket_, connection)
        while True:
            arm = served.ask("GET", "/v1/arms/arm")[1]
            if not arm["state"]["held"] and arm["state"]["at_rest"]:
                break
            if arm["cycle"] - moved["cycle"] > 10 * MOST:
                sys.exit(f"{how}: the arm is not at rest")
            time.sleep(0.002)
        cycles = arm["cycle"] - moved["cycle"]
        rests[how].append(cycles)
        late += cycles > MOST
        if how == "silent":
            socket_.close()
    stopped = [event for event in served.ask("GET", "/v1/events?from=1")[1]["events"] if event["kind"] == "stopped"]
    status, _ = served.end()
    print("| how | deaths | cycles to rest, median | most |\n|---|---|---|---|")
    for how, cycles in rests.items():
        print(f"| {how} | {len(cycles)} | {sorted(cycles)[len(cycles) // 2]} | {max(cycles)} |")
    print(f"{early} of them were silent before, on a busy machine; {late} late, {len(stopped)} stopped by a guard, the server ends with {status}")
    sys.exit(bool(late or stopped or status))


if __name__ == "__main__":
    main()
