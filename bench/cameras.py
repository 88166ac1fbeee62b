"""What live pictures cost: pictures a second and their age, and what the cycle noticed of them.

Usage: build/venv/bin/python bench/cameras.py [SCENARIO] [SECONDS] [CAMERA...]   (TAKT=... names another program)
Figures: docs/benchmarks.md, "Live cameras".
"""

import json
import os
import re
import signal
import struct
import subprocess
import sys
import time
import urllib.request

import websockets.sync.client

SCENARIO = sys.argv[1] if len(sys.argv) > 1 else "scenarios/teleoperation.json"
SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
CAMERAS = sys.argv[3:] or ["hand camera"]
POSES, PICTURE = 2, 3


def health(port):
    """Overruns, and the longest computing time of a cycle, ms."""
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/v1/state") as answer:
        said = json.load(answer)["health"]
    return said["overruns"], 1e3 * said["worst_cycle_s"]


def watch(port, cameras, size):
    """Pictures a second of each camera, their ages, ms, and their bytes."""
    begun, now, pictures, ages, sizes = time.monotonic(), 0.0, 0, [], []
    with websockets.sync.client.connect(
        f"ws://127.0.0.1:{port}/v1/stream", subprotocols=["takt.v1"], max_size=2**24
    ) as stream:
        stream.send(json.dumps({"op": "monitor", "id": 0, "poses": True, "every": 5}))
        for number, camera in enumerate(cameras, 1):
            stream.send(
                json.dumps(
                    {"op": "monitor", "id": number, "camera": camera, "width": size[0], "height": size[1], "every": 40}
                )
            )
        while time.monotonic() - begun < SECONDS:
            message = stream.recv(timeout=5)
            if isinstance(message, str):
                continue
            kind, frame, stamp = message[0], struct.unpack_from("<I", message, 4)[0], struct.unpack_from("<d", message, 16)[0]
            stream.send(json.dumps({"op": "ack", "frame": frame}))
            if kind == POSES:
                now = stamp
            elif kind == PICTURE:
                pictures += 1
                ages.append(1e3 * (max(now, stamp) - stamp))
                sizes.append(len(message))
    return pictures / SECONDS / max(1, len(cameras)), sorted(ages), sizes


def main():
    takt = os.environ.get("TAKT", "build/release/tools/takt")
    server = subprocess.Popen([takt, "serve", SCENARIO, "--port", "0"], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    port = None
    for line in server.stderr:
        if found := re.search(r"http://127\.0\.0\.1:(\d+)", line):
            port = int(found.group(1))
            break
    try:
        time.sleep(2)
        for title, cameras, size in (
            ("nobody looks", [], (320, 240)),
            ("320 x 240", CAMERAS, (320, 240)),
            ("480 x 360", CAMERAS, (480, 360)),
            ("640 x 480", CAMERAS, (640, 480)),
            ("nobody looks", [], (320, 240)),
        ):
            before, _ = health(port)
            rate, ages, sizes = watch(port, cameras, size)
            after, worst = health(port)
            line = f"{title:>14}: {after - before} overruns in {SECONDS:g} s, worst cycle since the start {worst:.2f} ms"
            if ages:
                p50, p99 = ages[len(ages) // 2], ages[int(0.99 * (len(ages) - 1))]
                line += f"; {rate:.1f} pictures/s of each, age p50 {p50:.0f} ms, p99 {p99:.0f} ms, {sum(sizes) / len(sizes) / 1e3:.0f} kB each"
            print(line, flush=True)
    finally:
        server.send_signal(signal.SIGINT)
        server.wait()


if __name__ == "__main__":
    main()
