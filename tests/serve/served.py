"""A takt serve in another process, and what tests ask of it."""
import http.client
import json
import pathlib
import re
import signal
import subprocess
import tempfile
import time

SCENARIO = "scenarios/touch.json"


class Served:
    def __init__(self, takt, *options, token=None, file=SCENARIO):
        self.token = token
        self.process = subprocess.Popen([takt, "serve", file, "--port", "0", *options], stderr=subprocess.PIPE, text=True)
        while True:
            line = self.process.stderr.readline()
            found = re.search(r"http://127\.0\.0\.1:(\d+)", line)
            if found or not line:
                break
        self.port = int(found.group(1))
        while not self.ask("GET", "/v1/state")[1]["connected"]:
            time.sleep(0.01)

    def ask(self, method, path, body=None, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        if self.token is not None:
            headers["Authorization"] = f"Bearer {self.token}"
        if body is not None:
            headers["Content-Type"] = "application/json"
        connection.request(method, path, None if body is None else json.dumps(body), headers)
        response = connection.getresponse()
        answer = response.status, json.loads(response.read())
        connection.close()
        return answer

    def end(self):
        self.process.send_signal(signal.SIGINT)
        _, errors = self.process.communicate(timeout=30)
        return self.process.returncode, errors


def motion(takt):
    """The net of a step of the scenario, which moves the arm for a second or two."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "net.json"
        subprocess.run([takt, "net", SCENARIO, "--step", "above the block", "--dump", file], check=True, capture_output=True)
        return json.loads(file.read_text())
