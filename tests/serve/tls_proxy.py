#!/usr/bin/env python3
"""takt serve behind a reverse proxy with TLS: the configuration of docs/remote-tls.md, with other paths and ports, is
tried with requests, STOP, a stream and jogging. No test of the gate, since nginx is no package of the build.

Usage: build/venv/bin/python3 tests/serve/tls_proxy.py TAKT NGINX
"""
import http.client
import json
import pathlib
import re
import secrets
import socket
import ssl
import subprocess
import sys
import tempfile
import time

import websockets.sync.client

from served import Served

TAKT, NGINX = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/remote-tls.md"
NAME = "cell.example"


def configuration(folder, port, upstream):
    """What the page says, here."""
    text = re.search(r"```\n(map .*?)```", PAGE.read_text(), re.S).group(1)
    text = text.replace("listen 443 ssl", f"listen 127.0.0.1:{port} ssl").replace(":8700", f":{upstream}")
    text = re.sub(r"/etc/ssl/\w+/", f"{folder}/", text)
    temporary = "".join(f"{what}_temp_path {folder}/{what};\n" for what in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
    return (f"daemon off; pid {folder}/pid; error_log {folder}/error.log;\nevents {{}}\n"
            f"http {{\naccess_log off;\n{temporary}{text}}}\n")


def main():
    token, watcher = secrets.token_hex(24), secrets.token_hex(24)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        tokens = folder / "tokens"
        tokens.touch(mode=0o600)
        tokens.write_text(f"operator anna {token}\nobserver wall {watcher}\n")
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={NAME}", "-addext",
                        f"subjectAltName=DNS:{NAME}", "-keyout", folder / f"{NAME}.key", "-out", folder / f"{NAME}.pem"],
                       check=True, capture_output=True)
        trust = ssl.create_default_context(cafile=folder / f"{NAME}.pem")
        served = Served(TAKT, "--realtime", "--tokens", str(tokens), "--host", NAME, token=token)
        port = served.port + 1 if served.port < 65000 else served.port - 1
        (folder / "nginx.conf").write_text(configuration(folder, port, served.port))
        proxy = subprocess.Popen([NGINX, "-p", folder, "-e", folder / "error.log", "-c", folder / "nginx.conf"])
        time.sleep(0.5)

        def ask(method, path, body=None, with_token=token, **headers):
            connection = http.client.HTTPSConnection(NAME, port, context=trust, timeout=10)
            connection._create_connection = lambda _, *rest: socket.create_connection(("127.0.0.1", port), *rest)
            headers |= {"Host": NAME, "Authorization": f"Bearer {with_token}", "Content-Type": "application/json"}
            connection.request(method, path, None if body is None else json.dumps(body), headers)
            response = connection.getresponse()
            return response.status, json.loads(response.read())

        def stream():
            ticket = ask("POST", "/v1/tickets", {})[1]["ticket"]
            return websockets.sync.client.connect(f"wss://{NAME}/v1/stream?ticket={ticket}", subprotocols=["takt.v1"],
                                                  sock=socket.create_connection(("127.0.0.1", port)), ssl=trust,
                                                  server_hostname=NAME, origin=f"https://{NAME}")

        try:
            assert ask("GET", "/v1/state")[0] == 200
            assert ask("GET", "/v1/state", with_token="0" * 48)[0] == 401
            assert ask("POST", "/v1/lease", {}, with_token=watcher)[0] == 403
            fence = ask("POST", "/v1/lease", {"cycles": 5000})[1]["fence"]
            with stream() as one:
                assert json.loads(one.recv())["name"] == "anna"
                one.send(json.dumps({"op": "jog", "jog": 1, "fence": fence, "arm": "arm", "space": "tool", "timeout_cycles": 300}))
                assert json.loads(one.recv())["op"] == "jogging"
                for sequence in range(50):
                    one.send(json.dumps({"op": "move", "jog": 1, "sequence": sequence, "linear": [0, 0, 0.03]}))
                    assert json.loads(one.recv())["op"] == "moved"
                    time.sleep(0.02)
                assert ask("POST", "/v1/stop", {}, with_token=watcher)[0] == 200
                assert json.loads(one.recv(timeout=5))["reason"] == "stopped"
            print("requests, roles, a stream, jogging and STOP pass")
        finally:
            proxy.terminate()
            proxy.wait()
            served.end()


if __name__ == "__main__":
    main()
