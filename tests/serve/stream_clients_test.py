#!/usr/bin/env python3
"""Streams of takt serve with clients that nobody of takt wrote: websockets, aiohttp, websocket-client; broken frames by wsproto.

Usage: stream_clients_test.py TAKT, with the Python of the tests' environment (build/venv).
"""
import asyncio
import base64
import json
import pathlib
import re
import secrets
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import aiohttp
import websocket
import websockets.sync.client
import wsproto
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from wsproto.events import AcceptConnection, BytesMessage, CloseConnection, Ping, Pong, Request, TextMessage

from served import Served

TAKT = pathlib.Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else None
PROTOCOL = "takt.v1"

# A client that jogs an arm until something happens to it.
JOGGER = """
import json, sys, time, http.client
import websockets.sync.client
port = int(sys.argv[1])
connection = http.client.HTTPConnection("127.0.0.1", port)
connection.request("POST", "/v1/lease", '{"cycles": 60000}', {"Content-Type": "application/json"})
fence = json.loads(connection.getresponse().read())["fence"]
with websockets.sync.client.connect(f"ws://127.0.0.1:{port}/v1/stream", subprotocols=["takt.v1"]) as stream:
    stream.send(json.dumps({"op": "jog", "jog": 1, "fence": fence, "arm": "arm", "space": "tool", "timeout_cycles": 100}))
    while json.loads(stream.recv())["op"] != "jogging": pass
    for sequence in range(10**6):
        stream.send(json.dumps({"op": "move", "jog": 1, "sequence": sequence, "linear": [0, 0, 0.03 if sequence // 50 % 2 else -0.03]}))
        stream.recv()
        if sequence == 20: print("moves", flush=True)
        time.sleep(0.02)
"""


def read_values(frame):
    """A frame of values: its number, its cycle, and by id (type, cycle, bytes; None: null)."""
    kind, version, count, number, cycle = struct.unpack_from("<BBHIq", frame)
    assert (kind, version) == (1, 1), frame[:16]
    at, values = 16, {}
    for _ in range(count):
        identity, value_type, null, length, when = struct.unpack_from("<IBBHq", frame, at)
        values[identity] = value_type, when, None if null else frame[at + 16:at + 16 + length]
        at += 16 + (length + 7) // 8 * 8
    assert at == len(frame)
    return number, cycle, values


class ByWebsockets:
    def __init__(self, port, target):
        self.connection = websockets.sync.client.connect(f"ws://127.0.0.1:{port}{target}", subprotocols=[PROTOCOL])
        self.stream = self.connection.__enter__()
        self.protocol = self.stream.subprotocol

    def send(self, message):
        self.stream.send(json.dumps(message))

    def receive(self):
        return self.stream.recv(timeout=10)

    def close(self):
        self.connection.__exit__(None, None, None)


class ByWebsocketClient:
    def __init__(self, port, target):
        self.stream = websocket.create_connection(f"ws://127.0.0.1:{port}{target}", subprotocols=[PROTOCOL], timeout=10,
                                                  suppress_origin=True)
        self.protocol = self.stream.getsubprotocol()

    def send(self, message):
        self.stream.send(json.dumps(message))

    def receive(self):
        return self.stream.recv()

    def close(self):
        self.stream.close()


class ByAiohttp:
    def __init__(self, port, target):
        self.loop = asyncio.new_event_loop()
        self.session = self.run(self.open_session())
        self.stream = self.run(self.session.ws_connect(f"http://127.0.0.1:{port}{target}", protocols=[PROTOCOL]))
        self.protocol = self.stream.protocol

    @staticmethod
    async def open_session():
        return aiohttp.ClientSession()

    def run(self, what):
        return self.loop.run_until_complete(asyncio.wait_for(what, 10))

    def send(self, message):
        self.run(self.stream.send_str(json.dumps(message)))

    def receive(self):
        return self.run(self.stream.receive()).data

    def close(self):
        self.run(self.stream.close())
        self.run(self.session.close())
        self.loop.close()


class Raw:
    """A connection whose bytes are one's own, and what wsproto makes of the answers."""

    def __init__(self, port):
        self.protocol = wsproto.WSConnection(wsproto.ConnectionType.CLIENT)
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=10)
        self.events = []
        self.code = None
        self.send(self.protocol.send(Request(host=f"127.0.0.1:{port}", target="/v1/stream", subprotocols=[PROTOCOL])))
        self.await_event(AcceptConnection)
        self.await_event(TextMessage)  # hello

    def send(self, data):
        self.socket.sendall(data)

    def await_event(self, kind):
        """The next event of this kind; None: the connection has ended before."""
        while True:
            for event in self.events:
                self.events.remove(event)
                if isinstance(event, CloseConnection):
                    self.code = event.code
                if isinstance(event, kind):
                    return event
            try:
                data = self.socket.recv(65536)
            except ConnectionError:
                return None
            if not data:
                return None
            self.protocol.receive_data(data)
            self.events += list(self.protocol.events())

    def text(self, text, **how):
        return bytearray(self.protocol.send(TextMessage(data=text, **how)))


class Streams(unittest.TestCase):
    def served(self, *options):
        served = Served(TAKT, *options)

        def end():
            status, errors = served.end()
            self.assertEqual(status, 0, errors)
        self.addCleanup(end)
        return served

    def test_what_the_page_promises_is_kept(self):
        with tempfile.TemporaryDirectory() as folder:
            tokens, own = pathlib.Path(folder) / "tokens", pathlib.Path(folder) / "token"
            token = secrets.token_hex(24)
            tokens.touch(mode=0o600)
            tokens.write_text(f"operator anna {token}\n")
            own.write_text(token)
            served = Served(TAKT, "--realtime", "--tokens", tokens, token=token)
            asked = subprocess.run([sys.executable, "-B", pathlib.Path(__file__).parent / "conformance.py",
                                    f"http://127.0.0.1:{served.port}", "--token-file", own], capture_output=True, text=True)
            self.assertEqual(served.end()[0], 0)
            self.assertEqual(asked.returncode, 0, asked.stdout + asked.stderr)

    def test_each_client_reads_events_and_values(self):
        served = self.served("--lockstep")
        fence = str(served.ask("POST", "/v1/lease", {})[1]["fence"])
        for kind in (ByWebsockets, ByWebsocketClient, ByAiohttp):
            with self.subTest(kind.__name__):
                ticket = served.ask("POST", "/v1/tickets", {})[1]["ticket"]
                stream = kind(served.port, f"/v1/stream?ticket={ticket}")
                self.assertEqual(stream.protocol, PROTOCOL)
                hello = json.loads(stream.receive())
                self.assertEqual((hello["op"], hello["protocol"]), ("hello", PROTOCOL))
                stream.send({"op": "events", "from": hello["next"]})
                stream.send({"op": "monitor", "id": 5, "arm": "arm", "value": "q_measured", "every": 10})
                status, loaded = served.ask("POST", "/v1/nets", {"net": {"name": "brief", "primitives": [
                    {"id": "end", "type": "Termination", "parameters": {"condition": True}}]}}, **{"Takt-Fence": fence})
                self.assertEqual(status, 202)
                net = loaded["net"]
                while served.ask("GET", f"/v1/nets/{net}")[1]["state"] == "Loading":
                    time.sleep(0.001)
                served.ask("POST", f"/v1/nets/{net}/start", {}, **{"Takt-Fence": fence})
                served.ask("POST", "/v1/steps", {"cycles": 100}, **{"Takt-Fence": fence})
                expected, ended, frames = hello["next"], False, 0
                while not ended or frames < 2:
                    message = stream.receive()
                    if isinstance(message, bytes):
                        number, cycle, values = read_values(message)
                        self.assertEqual(values[5][0], 9)
                        frames += 1
                        stream.send({"op": "ack", "frame": number})
                        joints = struct.unpack(f"<{len(values[5][2]) // 8}d", values[5][2])
                        newest = served.ask("GET", "/v1/arms/arm")[1]
                        if newest["cycle"] == cycle + 1:
                            self.assertEqual(list(joints), newest["state"]["q_measured"])
                        served.ask("POST", "/v1/steps", {"cycles": 10}, **{"Takt-Fence": fence})
                        continue
                    for event in json.loads(message).get("events", []):
                        self.assertEqual(event["sequence"], expected)
                        expected += 1
                        ended = ended or (event["net"] == net and event.get("state") == "Terminated")
                stream.close()

    def test_broken_frames_close_that_connection_only(self):
        served = self.served("--lockstep")
        other = ByWebsockets(served.port, "/v1/stream")
        other.receive()

        def reserved(raw):
            frame = raw.text('{"op": "unmonitor", "id": 1}')
            frame[0] |= 0x40
            return frame

        def unmasked(_):
            return b"\x81\x02{}"

        def unknown_opcode(raw):
            frame = raw.text("{}")
            frame[0] = 0x83
            return frame

        def continuation_of_nothing(raw):
            frame = raw.text("{}")
            frame[0] = 0x80
            return frame

        def two_at_once(raw):
            return raw.text('{"op": ', message_finished=False) + b"\x81\x82\0\0\0\0{}"

        def fragmented_ping(_):
            return b"\x09\x80\0\0\0\0"

        def long_ping(_):
            return b"\x89\xfe\x01\x00\0\0\0\0" + bytes(256)

        def oversize(_):
            return b"\x81\xff" + struct.pack(">Q", 1 << 40) + b"\0\0\0\0"

        def negative_size(_):
            return b"\x81\xff" + struct.pack(">Q", 1 << 63) + b"\0\0\0\0"

        def bad_text(_):
            return b"\x81\x82\0\0\0\0\xc3\x28"

        def bad_close(_):
            return b"\x88\x81\0\0\0\0\x03"

        for broken in (reserved, unmasked, unknown_opcode, continuation_of_nothing, two_at_once, fragmented_ping, long_ping,
                       oversize, negative_size, bad_text, bad_close):
            with self.subTest(broken.__name__):
                raw = Raw(served.port)
                raw.send(bytes(broken(raw)))
                self.assertIsNone(raw.await_event(TextMessage), "no answer, but an end")
                self.assertIn(raw.code, (None, 1002, 1007, 1009))
                raw.socket.close()
                other.send({"op": "unmonitor", "id": 1})
                self.assertEqual(json.loads(other.receive())["status"], 404, "others do not notice")
        other.close()

    def test_fragments_and_pings_are_no_errors(self):
        raw = Raw(self.served("--lockstep").port)
        self.addCleanup(raw.socket.close)
        text = '{"op": "unmonitor", "id": 1}'
        for i, letter in enumerate(text):
            raw.send(bytes(raw.text(letter, message_finished=i == len(text) - 1)))
            if i == 5:
                raw.send(raw.protocol.send(Ping(payload=b"now")))
        self.assertEqual(raw.await_event(Pong).payload, b"now")
        self.assertEqual(json.loads(raw.await_event(TextMessage).data)["status"], 404)
        raw.send(raw.protocol.send(BytesMessage(data=b"{}")))
        raw.await_event(CloseConnection)
        self.assertEqual(raw.code, 1003)

    def test_a_stream_that_does_not_read_delays_nobody(self):
        served = self.served("--realtime")
        asleep = ByWebsockets(served.port, "/v1/stream")
        asleep.send({"op": "window", "frames": 64})
        asleep.send({"op": "monitor", "id": 1, "poses": True})
        before = served.ask("GET", "/v1/state")[1]["cycle"]
        time.sleep(1)
        self.assertGreater(served.ask("GET", "/v1/state")[1]["cycle"] - before, 800)
        asleep.close()

    def test_a_thousand_dropped_streams_leave_nothing(self):
        served = self.served("--lockstep")

        def resident_kB():
            status = pathlib.Path(f"/proc/{served.process.pid}/status").read_text()
            return int(re.search(r"VmRSS:\s+(\d+)", status).group(1))

        def drop():
            raw = Raw(served.port)
            for message in ({"op": "monitor", "id": 1, "poses": True}, {"op": "events", "from": 1}):
                raw.send(bytes(raw.text(json.dumps(message))))
            raw.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # a reset
            raw.socket.close()
        for _ in range(100):
            drop()
        before = resident_kB()
        for _ in range(1000):
            drop()
        self.assertLess(resident_kB() - before, 4096)
        self.assertEqual(served.ask("GET", "/v1/state")[0], 200)

    def test_foxglove_shows_frames_joints_scene_and_log(self):
        served = self.served("--lockstep")
        fence = {"Takt-Fence": str(served.ask("POST", "/v1/lease", {})[1]["fence"])}
        for offered, target in ((["foxglove.websocket.v1"], "/"), (["foxglove.sdk.v1"], "/"),
                                (["foxglove.websocket.v1", "foxglove.sdk.v1"], "/v1/stream")):
            with self.subTest(offered), websockets.sync.client.connect(
                    f"ws://127.0.0.1:{served.port}{target}", subprotocols=offered, max_size=None) as stream:
                self.assertEqual(stream.subprotocol, offered[-1])
                info = json.loads(stream.recv(timeout=10))
                self.assertEqual((info["op"], info["capabilities"]), ("serverInfo", ["time"]))
                channels = {one["topic"]: one for one in json.loads(stream.recv(timeout=10))["channels"]}
                messages = {}
                for one in channels.values():
                    self.assertEqual((one["encoding"], one["schemaEncoding"]), ("protobuf", "protobuf"))
                    pool = descriptor_pool.DescriptorPool()
                    for file in descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(one["schema"])).file:
                        pool.Add(file)
                    messages[one["id"]] = message_factory.GetMessageClass(pool.FindMessageTypeByName(one["schemaName"]))
                stream.send(json.dumps({"op": "subscribe", "subscriptions": [
                    {"id": 100 + one["id"], "channelId": one["id"]} for one in channels.values()]}))
                net = served.ask("POST", "/v1/nets", {"net": {"name": "brief", "primitives": [
                    {"id": "end", "type": "Termination", "parameters": {"condition": True}}]}}, **fence)[1]["net"]
                while served.ask("GET", f"/v1/nets/{net}")[1]["state"] == "Loading":
                    time.sleep(0.001)
                served.ask("POST", f"/v1/nets/{net}/start", {}, **fence)
                served.ask("POST", "/v1/steps", {"cycles": 40}, **fence)
                came, lines, times = {}, [], 0
                while set(came) != set(messages) or not times or not any("Terminated" in line for line in lines):
                    data = stream.recv(timeout=10)
                    self.assertIsInstance(data, bytes)
                    if data[0] == 2:
                        times += 1
                        continue
                    code, subscription, stamp = struct.unpack_from("<BIQ", data)
                    self.assertEqual(code, 1)
                    message = messages[subscription - 100].FromString(data[13:])
                    came[subscription - 100] = message
                    if subscription - 100 == channels["/log"]["id"]:
                        lines.append(message.message)
                bodies = served.ask("GET", "/v1/scene")[1]["bodies"]
                frames = [one.child_frame_id for one in came[channels["/tf"]["id"]].transforms]
                self.assertEqual(frames, [body["name"] for body in bodies[1:]])
                scene = came[channels["/scene"]["id"]]
                self.assertLessEqual({entity.frame_id for entity in scene.entities}, {body["name"] for body in bodies})
                joints = [joint.position for joint in came[channels["/arm/joint_states"]["id"]].joints]
                for measured, shown in zip(served.ask("GET", "/v1/arms/arm")[1]["state"]["q_measured"], joints, strict=True):
                    self.assertAlmostEqual(measured, shown, places=3)
                stream.send(json.dumps({"op": "unsubscribe", "subscriptionIds": [101, 7]}))
                stream.send(json.dumps({"op": "advertise", "channels": []}))
                stream.send(b"\x01\x00")
                stream.send("[")
                problems = []
                while len(problems) < 4:
                    message = stream.recv(timeout=10)
                    if isinstance(message, str):
                        problems.append(json.loads(message))
                self.assertEqual([(one["op"], one["level"]) for one in problems], [("status", 2)] * 4)

    def silence(self, how):
        served = self.served("--realtime")
        client = subprocess.Popen([sys.executable, "-c", JOGGER, str(served.port)], stdout=subprocess.PIPE, text=True)
        self.assertEqual(client.stdout.readline().strip(), "moves")
        self.assertTrue(served.ask("GET", "/v1/arms/arm")[1]["state"]["held"])
        client.send_signal(how)
        deadline = time.monotonic() + 20
        state = {"held": True}
        while state["held"] and time.monotonic() < deadline:
            time.sleep(0.01)
            state = served.ask("GET", "/v1/arms/arm")[1]["state"]
        self.assertEqual((state["held"], state["at_rest"]), (False, True))
        if how == signal.SIGSTOP:  # who wakes up moves nothing any more
            client.send_signal(signal.SIGCONT)
            time.sleep(0.3)
            self.assertFalse(served.ask("GET", "/v1/arms/arm")[1]["state"]["held"])
        client.kill()
        client.wait()
        client.stdout.close()

    def test_a_killed_jogger_leaves_the_arm_at_rest(self):
        self.silence(signal.SIGKILL)

    def test_a_frozen_jogger_leaves_the_arm_at_rest(self):
        self.silence(signal.SIGSTOP)


if __name__ == "__main__":
    unittest.main()
