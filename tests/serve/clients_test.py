#!/usr/bin/env python3
"""Clients of takt serve that nobody of takt wrote, and that die: Python's http.client, killed and frozen while an arm moves.

Usage: clients_test.py TAKT
"""
import http.client
import json
import pathlib
import random
import re
import signal
import subprocess
import sys
import time
import unittest

from served import SCENARIO, Served, motion

TAKT = pathlib.Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else None
# What a client does that takes the lease, moves the arm and gives signs of life until something happens to it.
MOVER = """
import http.client, json, sys, time
port, net = int(sys.argv[1]), json.load(sys.stdin)
fence = None
def ask(method, path, body):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    headers = {"Content-Type": "application/json"}
    if fence: headers["Takt-Fence"] = str(fence)
    connection.request(method, path, json.dumps(body), headers)
    answer = json.loads(connection.getresponse().read())
    connection.close()
    return answer
fence = ask("POST", "/v1/lease", {"cycles": 300})["fence"]
number = ask("POST", "/v1/nets", {"net": net})["net"]
while ask("GET", f"/v1/nets/{number}", {})["state"] == "Loading": ask("PUT", "/v1/lease", {})
ask("POST", f"/v1/nets/{number}/start", {})
print(number, flush=True)
while True:
    ask("PUT", "/v1/lease", {})
    time.sleep(0.02)
"""


class Clients(unittest.TestCase):
    def test_ctrl_c_ends_with_0(self):
        for mode in ("--realtime", "--lockstep"):
            served = Served(TAKT, mode)
            status, errors = served.end()
            self.assertEqual(status, 0, errors)

    def silence(self, how):
        served = Served(TAKT, "--realtime")
        client = subprocess.Popen([sys.executable, "-c", MOVER, str(served.port)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        json.dump(motion(TAKT), client.stdin)
        client.stdin.close()
        number = int(client.stdout.readline())
        client.send_signal(how)
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline:
            state = served.ask("GET", f"/v1/nets/{number}")[1]
            if state["state"] == "Terminated":
                break
            time.sleep(0.01)
        self.assertEqual((state["state"], state["cause"]), ("Terminated", "cancelled"), state)
        arm = served.ask("GET", "/v1/arms/arm")[1]["state"]
        while not arm["at_rest"] and time.monotonic() < deadline:  # it is published after the states of nets
            time.sleep(0.01)
            arm = served.ask("GET", "/v1/arms/arm")[1]["state"]
        self.assertTrue(arm["at_rest"])
        self.assertFalse(arm["held"])
        if how == signal.SIGSTOP:  # who wakes up commands nothing any more
            client.send_signal(signal.SIGCONT)
        fence = served.ask("POST", "/v1/lease", {})[1]["fence"]
        self.assertEqual(fence, 2, "another client can take over at once")
        client.kill()
        client.wait()
        client.stdout.close()
        status, errors = served.end()
        self.assertEqual(status, 0, errors)

    def test_a_killed_client_leaves_the_arm_at_rest(self):
        self.silence(signal.SIGKILL)

    def test_a_frozen_client_leaves_the_arm_at_rest(self):
        self.silence(signal.SIGSTOP)

    def test_random_requests_get_described_answers(self):
        """Random methods, paths, headers and bodies: no error of the server, no answer that its description does not have."""
        served = Served(TAKT, "--lockstep")
        paths = served.ask("GET", "/v1/openapi.json")[1]["paths"]
        generator = random.Random(41)
        values = [None, True, -1, 0, 1, 2, 7, 2**31, 2**70, 0.5, 1e300, "", "x", "arm", "wrist", "net", [], [1], {}, {"net": 1},
                  {"name": "n", "primitives": [], "links": [{}]}, [{"net": 1, "states": ["Ready"]}], "\u0000", "a" * 500]
        fence = served.ask("POST", "/v1/lease", {})[1]["fence"]
        seen = set()
        connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=20)
        for _ in range(3000):
            path, methods = generator.choice(list(paths.items()))
            method, operation = generator.choice(list(methods.items()))
            if path == "/v1/lease" and method == "delete":
                continue
            target = re.sub(r"\{\w+\}", lambda _: generator.choice(["1", "2", "0", "-1", "99999999999", "arm", "%00", "%zz"]), path)
            if generator.random() < 0.3:
                target += "?" + generator.choice(["from=1", "from=-1", "most=3&most=4", "x", "from=1&most=99999", "%", "from="])
            body = None
            if method in ("post", "put"):
                schema = operation["requestBody"]["content"]["application/json"]["schema"]
                keys = list(schema["properties"]) + ["comment", "nonsense"]
                body = json.dumps({key: generator.choice(values) for key in keys if generator.random() < 0.6})
                if generator.random() < 0.1:
                    body = generator.choice(["", "{", "[" * 1000, "\xff", "nul", '{"a":1,"a":2}', '"' + "x" * 5000 + '"'])
            headers = {"Takt-Fence": generator.choice([str(fence)] * 6 + ["", "0", "x", "7"])}
            headers["Content-Type"] = generator.choice(["application/json"] * 6 + ["text/plain"])
            if generator.random() < 0.1 and path != "/v1/lease":
                headers["Idempotency-Key"] = generator.choice(["a", "b", "c"])
            connection.request(method.upper(), target, None if body is None else body.encode("latin-1"), headers)
            response = connection.getresponse()
            text = response.read()
            what = (method, target, body, response.status, text[:300])
            self.assertIn(str(response.status), operation["responses"], what)
            self.assertNotIn(response.status, (500, 503), what)
            media = response.getheader("Content-Type")
            self.assertIn(media, operation["responses"][str(response.status)]["content"], what)
            answer = json.loads(text) if media.endswith("json") else {}
            if response.status >= 400:
                self.assertEqual(media, "application/problem+json", what)
                self.assertEqual(answer["status"], response.status)
            else:
                schema = operation["responses"][str(response.status)]["content"][media]["schema"]
                self.assertLessEqual(set(schema.get("required", [])), set(answer), what)
            seen.add((method, path, response.status))
            if path == "/v1/lease" and response.status == 201:
                fence = answer["fence"]
        connection.close()
        self.assertEqual({path for _, path, status in seen}, set(paths))
        self.assertGreater(len(seen), 2 * len(paths))
        status, errors = served.end()
        self.assertEqual(status, 0, errors)

    def test_bad_arguments_are_refused(self):
        run = subprocess.run([TAKT, "serve", SCENARIO, "--address", "0.0.0.0", "--json"], capture_output=True, text=True)
        self.assertEqual(run.returncode, 2)
        self.assertEqual(json.loads(run.stdout)["diagnostics"][0]["code"], "requires")


if __name__ == "__main__":
    unittest.main()
