#!/usr/bin/env python3
"""What a core by network promises (docs/remote.md), asked of one that runs: for clients and gateways that somebody else wrote.

Usage: conformance.py URL [--token-file FILE] [--only NAME]...

URL is that of `takt serve` in real time, or of what stands before it. The cell must be at rest and held by nobody; nets that it
starts drive no device, but for `jogging`, which moves the first arm by less than 2 mm. The checks of streams need the package
`websockets`; without it they count as not run. Exit status: 0 all passed, 1 one failed, 2 wrong use, 3 some were not run.
"""
import argparse
import asyncio
import contextlib
import http.client
import json
import pathlib
import re
import struct
import sys
import time
import urllib.parse

try:
    import websockets
except ImportError:
    websockets = None

# Runs until it is cancelled, and counts.
IDLE = {"name": "conformance",
        "primitives": [{"id": "count", "type": "CycleCounter", "parameters": {"counted": True}}, {"id": "cancel", "type": "Cancel"},
                       {"id": "end", "type": "Termination"}],
        "links": [{"from": "cancel.requested", "to": "end.condition"}]}
SECONDS = 10.0  # for what happens by itself
CHECKS = []


class Failure(Exception):
    """A promise that is not kept."""


def expect(holds, text):
    if not holds:
        raise Failure(text)


def check(function):
    CHECKS.append(function)
    return function


class Answer:
    def __init__(self, response, data):
        self.status, self.headers, self.data = response.status, {k.lower(): v for k, v in response.getheaders()}, data

    @property
    def json(self):
        return json.loads(self.data)

    def __str__(self):
        return f"{self.status} {self.data[:200]!r}"


class Core:
    def __init__(self, url, token):
        parts = urllib.parse.urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            sys.exit(f"'{url}' is no address of a server (allowed: http://HOST:PORT, https://HOST)")
        self.tls, self.host, self.path = parts.scheme == "https", parts.netloc, parts.path.rstrip("/")
        self.token, self.fence = token, None

    def ask(self, method, path, body=None, headers=None, timeout=20):
        kind = http.client.HTTPSConnection if self.tls else http.client.HTTPConnection
        connection = kind(self.host, timeout=timeout)
        sent = {"Authorization": f"Bearer {self.token}"} if self.token else {}
        if self.fence is not None:
            sent["Takt-Fence"] = str(self.fence)
        data = body if body is None or isinstance(body, bytes) else json.dumps(body).encode()
        if data is not None:
            sent["Content-Type"] = "application/json"
        with contextlib.closing(connection):
            connection.request(method, self.path + path, data, sent | (headers or {}))
            response = connection.getresponse()
            return Answer(response, response.read())

    def get(self, path):
        answer = self.ask("GET", path)
        expect(answer.status == 200, f"GET {path}: {answer}")
        return answer.json

    @contextlib.contextmanager
    def lease(self, **how):
        """Holds all devices, or those of `how`."""
        answer = self.ask("POST", "/v1/lease", {"cycles": 2000} | how)
        expect(answer.status == 201, f"the lease is not to be had: {answer}")
        self.fence = answer.json["fence"]
        try:
            yield self.fence
        finally:
            self.ask("DELETE", "/v1/lease")
            self.fence = None

    def load(self, net):
        answer = self.ask("POST", "/v1/nets", {"net": net})
        expect(answer.status == 202, f"LOAD: {answer}")
        number = answer.json["net"]
        self.await_state(number, "Ready", "Rejected")
        return number

    def await_state(self, net, *states):
        return until(f"net {net} is {' or '.join(states)}",
                     lambda: (found := self.get(f"/v1/nets/{net}"))["state"] in states and found)

    def events_from(self, number):
        return self.get(f"/v1/events?from={number}")["events"]

    def next_event(self):
        number = 1
        while (page := self.get(f"/v1/events?from={number}"))["events"]:
            number = page["next"]
        return number

    @contextlib.asynccontextmanager
    async def stream(self):
        ticket = self.ask("POST", "/v1/tickets", {}).json["ticket"]
        scheme = "wss" if self.tls else "ws"
        async with websockets.connect(f"{scheme}://{self.host}{self.path}/v1/stream?ticket={ticket}",
                                      subprotocols=["takt.v1"], compression=None) as stream:
            hello = json.loads(await asyncio.wait_for(stream.recv(), SECONDS))
            expect(hello["op"] == "hello" and hello["protocol"] == "takt.v1", f"the first message is {hello}")
            yield stream


def until(what, holds):
    deadline = time.monotonic() + SECONDS
    while not (found := holds()):
        expect(time.monotonic() < deadline, f"not within {SECONDS:g} s: {what}")
        time.sleep(0.01)
    return found


def expect_problem(answer, status, pointer=None):
    expect(answer.status == status, f"{status} was due: {answer}")
    expect(answer.headers.get("content-type") == "application/problem+json", f"no problem answer: {answer.headers}")
    expect(answer.json["status"] == status and answer.json["title"], f"{answer}")
    if pointer is not None:
        found = [one["pointer"] for one in answer.json["diagnostics"]]
        expect(pointer in found, f"a diagnostic at '{pointer}' was due, there are {found}")


# -- Requests -----------------------------------------------------------------------------------------------------------------


@check
def description(core):
    """What is described is there, and answers as described."""
    document = core.get("/v1/openapi.json")
    expect(document["openapi"].startswith("3.1"), document["openapi"])
    for path, methods in document["paths"].items():
        operation = methods.get("get")
        if operation is None or "{" in path or path in ("/v1/stream", "/v1/scene"):
            continue
        answer = core.ask("GET", path)
        expect(str(answer.status) in operation["responses"], f"GET {path}: {answer} is not described")
        if answer.status != 200 or "json" not in answer.headers["content-type"]:
            continue
        described = operation["responses"]["200"]["content"]["application/json"]["schema"].get("properties", {})
        missing = set(described) - set(answer.json)
        expect(not missing or path == "/v1/openapi.json", f"GET {path} lacks {sorted(missing)}")


@check
def errors(core):
    """Bad input gets a problem answer that names the place, all findings at once."""
    expect_problem(core.ask("GET", "/v1/nothing"), 404)
    expect_problem(core.ask("PATCH", "/v1/state"), 405)
    expect_problem(core.ask("GET", "/v1/events?from=0"), 422, "?from")
    expect_problem(core.ask("POST", "/v1/tickets", b"{"), 400)
    expect_problem(core.ask("POST", "/v1/tickets", b"[" * 100), 400)
    expect_problem(core.ask("POST", "/v1/lease", {"cycles": -1, "devices": ["no such device"]}), 422, "/cycles")
    expect_problem(core.ask("GET", "/v1/nets/999999999"), 404)


@check
def page_of_another_site(core):
    """A request for another host, or from a page of another origin, is refused."""
    expect(core.ask("GET", "/v1/state", headers={"Host": "evil.example"}).status in (403, 404, 421), "another host is served")
    expect(core.ask("GET", "/v1/state", headers={"Origin": "http://evil.example"}).status == 403, "another origin is served")
    expect("access-control-allow-origin" not in core.ask("GET", "/v1/state").headers, "every page may read answers")


@check
def get_changes_nothing(core):
    """GET of every route leaves no event, no net and no lease behind."""
    before, nets = core.next_event(), core.get("/v1/nets")
    for path, methods in core.get("/v1/openapi.json")["paths"].items():
        if "get" in methods and path != "/v1/stream":
            core.ask("GET", re.sub(r"\{\w+\}", "1", path))
    expect(core.next_event() == before, "an event came")
    expect(core.get("/v1/nets") == nets and core.get("/v1/lease")["leases"] == [], "a net or a lease came")


@check
def time_goes_on(core):
    """Cycles go on without gaps at the declared period."""
    first, begin = core.get("/v1/state"), time.monotonic()
    expect(first["realtime"], "the cell does not run in real time")
    time.sleep(0.5)
    second, elapsed = core.get("/v1/state"), time.monotonic() - begin
    ran = second["time_s"] - first["time_s"]
    expect(ran > 0 and second["cycle"] > first["cycle"], "time stands")
    expect(ran < elapsed + 0.1, f"{ran:.3f} s in {elapsed:.3f} s")
    expect(second["digest"] != first["digest"], "the digest stands")


@check
def one_holder(core):
    """A device has one holder; who holds nothing, or held it formerly, commands nothing."""
    expect_problem(core.ask("POST", "/v1/nets", {"net": IDLE}, headers={"Takt-Fence": "99999999"}), 409, "Takt-Fence")
    with core.lease() as fence:
        expect_problem(core.ask("POST", "/v1/lease", {}), 409, "/take_over")
        number = core.load(IDLE)
        newer = core.ask("POST", "/v1/lease", {"take_over": True}).json["fence"]
        expect(newer > fence, f"fence {newer} after {fence}")
        expect_problem(core.ask("POST", f"/v1/nets/{number}/start", {}), 409, "Takt-Fence")
        core.fence = newer
    expect(core.get("/v1/lease")["leases"] == [], "a released lease is held")


@check
def silence(core):
    """Who is silent for the cycles of the lease loses it; what runs comes to its end."""
    with core.lease(cycles=300):
        number = core.load(IDLE)
        core.ask("POST", f"/v1/nets/{number}/start", {})
        core.await_state(number, "Running")
        ended = core.await_state(number, "Terminated")
        expect(ended["cause"] == "cancelled", f"{ended}")
        expect(core.get("/v1/lease")["leases"] == [], "the lease goes on")
        expect_problem(core.ask("PUT", "/v1/lease", {}), 409)


@check
def life_of_a_net(core):
    """LOAD, START, CANCEL; every change of state is an event, in order, numbered without gaps."""
    begin = core.next_event()
    with core.lease():
        number = core.load(IDLE)
        expect(core.get(f"/v1/nets/{number}")["state"] == "Ready", "it is refused")
        expect(core.ask("POST", f"/v1/nets/{number}/start", {}).status == 202, "START is refused")
        core.await_state(number, "Running")
        expect(core.ask("DELETE", f"/v1/nets/{number}").status == 409, "an active net is unloaded")
        core.ask("POST", f"/v1/nets/{number}/cancel", {})
        core.await_state(number, "Terminated")
        events = until("the events have come", lambda: (
            found := core.events_from(begin)) and any("Terminated" in str(one) for one in found) and found)
        numbers = [one["sequence"] for one in events]
        expect(numbers == list(range(begin, begin + len(numbers))), f"numbers {numbers} from {begin} on")
        cycles = [one["cycle"] for one in events]
        expect(cycles == sorted(cycles), f"cycles {cycles}")
        expect(core.ask("DELETE", f"/v1/nets/{number}").status == 200, "it is not unloaded")


@check
def rejected(core):
    """A net with faults is rejected with all of them, each with its place."""
    with core.lease():
        number = core.load({"name": "bad", "primitives": [{"id": "a", "type": "Nonsense"}, {"id": "b", "type": "Abs"}]})
        state = core.get(f"/v1/nets/{number}")
        expect(state["state"] == "Rejected", state["state"])
        expect(len(state["diagnostics"]) >= 2, f"{state['diagnostics']}")
        expect(all(one["code"] and one["message"] for one in state["diagnostics"]), "a diagnostic without code or message")
        expect(core.ask("POST", f"/v1/nets/{number}/start", {}).status in (202, 409), "START of it")
        time.sleep(0.1)
        expect(core.get(f"/v1/nets/{number}")["state"] == "Rejected", "it was started")


@check
def once(core):
    """A repeated request with the same key is carried out once; a command that comes too late is not."""
    with core.lease():
        key = {"Idempotency-Key": f"conformance-{time.time_ns()}"}
        first, second = (core.ask("POST", "/v1/nets", {"net": IDLE}, headers=key) for _ in range(2))
        expect(first.json == second.json, f"{first} and {second}")
        number = first.json["net"]
        core.await_state(number, "Ready")
        late = core.ask("POST", f"/v1/nets/{number}/start", {"expires_at_cycle": 1})
        expect_problem(late, 409, "/expires_at_cycle")
        time.sleep(0.1)
        expect(core.get(f"/v1/nets/{number}")["state"] == "Ready", "it was started")


@check
def start_together(core):
    """A rule starts two nets in one cycle."""
    with core.lease():
        nets = [core.load(IDLE) for _ in range(3)]
        rule = {"condition": [{"net": nets[0], "states": ["Running"]}], "action": {"start": nets[1:]}}
        answer = core.ask("POST", "/v1/rules", rule)
        expect(answer.status == 202, f"{answer}")
        core.ask("POST", f"/v1/nets/{nets[0]}/start", {})
        first = [core.await_state(number, "Running")["first_cycle"] for number in nets[1:]]
        expect(first[0] == first[1], f"cycles {first}")


@check
def stop(core):
    """STOP needs no lease, and ends every net."""
    with core.lease() as fence:
        number = core.load(IDLE)
        core.ask("POST", f"/v1/nets/{number}/start", {})
        core.await_state(number, "Running")
        core.fence = None
        expect(core.ask("POST", "/v1/stop", {}).status == 200, "STOP is refused")
        core.fence = fence
        core.await_state(number, "Terminated")


@check
def watches(core):
    """A watch has the values of a port."""
    with core.lease():
        number = core.load(IDLE)
        port = {"net": number, "port": "count.count", "keep": 1000}
        answer = core.ask("POST", "/v1/watches", port)
        expect(answer.status == 201, f"{answer}")
        watch = answer.json["watch"]
        core.ask("POST", f"/v1/nets/{number}/start", {})
        core.await_state(number, "Running")
        values = until("values come", lambda: core.get(f"/v1/watches/{watch}").get("values"))
        cycles = [one["cycle"] for one in values]
        expect(cycles == list(range(cycles[0], cycles[0] + len(cycles))), f"a value is missing: {cycles}")
        expect(core.ask("DELETE", f"/v1/watches/{watch}").status == 200, "it does not end")


@check
def token(core):
    """Where there are tokens nothing is told, and nothing done, without one."""
    if not core.token:
        return "no token was given"
    own, core.token = core.token, None
    try:
        for method, path in (("GET", "/v1/state"), ("POST", "/v1/stop"), ("POST", "/v1/lease")):
            expect(core.ask(method, path, {} if method == "POST" else None).status == 401, f"{method} {path} without a token")
        core.token = own[:-1] + ("x" if own[-1] != "x" else "y")
        expect(core.ask("GET", "/v1/state").status == 401, "another token of the same length is taken")
    finally:
        core.token = own
    return None


# -- Streams ------------------------------------------------------------------------------------------------------------------


def streams(function):
    """A check that needs WebSockets."""
    def run(core):
        if websockets is None:
            return "the package 'websockets' is not installed"
        return asyncio.run(asyncio.wait_for(function(core), 4 * SECONDS))

    run.__name__, run.__doc__ = function.__name__, function.__doc__
    return check(run)


async def message(stream, op):
    """The next message of a kind; others are passed over."""
    while True:
        found = await asyncio.wait_for(stream.recv(), SECONDS)
        if isinstance(found, str) and json.loads(found)["op"] == op:
            return json.loads(found)


@streams
async def ticket_once(core):
    """A ticket is good for one stream."""
    ticket = core.ask("POST", "/v1/tickets", {}).json["ticket"]
    address = f"{'wss' if core.tls else 'ws'}://{core.host}{core.path}/v1/stream?ticket={ticket}"
    async with websockets.connect(address, subprotocols=["takt.v1"]):
        pass
    try:
        async with websockets.connect(address, subprotocols=["takt.v1"]):
            raise Failure("it was good twice")
    except websockets.exceptions.InvalidHandshake:
        pass


@streams
async def events_resume(core):
    """Events of a stream come in order, each once, also over a reconnect."""
    begin = core.next_event()
    with core.lease():
        async def some():
            number = core.load(IDLE)
            core.ask("POST", f"/v1/nets/{number}/start", {})
            core.ask("POST", f"/v1/nets/{number}/cancel", {})
            core.await_state(number, "Terminated")

        await some()
        seen, begin_next = [], begin
        for _ in range(2):
            async with core.stream() as stream:
                await stream.send(json.dumps({"op": "events", "from": begin_next}))
                found = await message(stream, "events")
                seen += [one["sequence"] for one in found["events"]]
                begin_next = found["next"]
            await some()
    expect(len(seen) > 3 and seen == list(range(begin, begin + len(seen))), f"{seen} from {begin} on")


@streams
async def newest_values(core):
    """Frames are numbered without gaps; a client that does not acknowledge gets no more than its window, then the newest."""
    arm = next(one["name"] for one in core.get("/v1/devices")["devices"] if one["kind"] == "arm")
    async with core.stream() as stream:
        await stream.send(json.dumps({"op": "window", "frames": 2}))
        await stream.send(json.dumps({"op": "monitor", "id": 7, "arm": arm, "value": "q_measured", "every": 10}))
        frames = []
        with contextlib.suppress(asyncio.TimeoutError):
            while True:
                found = await asyncio.wait_for(stream.recv(), 0.5)
                if isinstance(found, bytes):
                    frames.append(struct.unpack_from("<BBHIq", found))
        expect([one[3] for one in frames] == [1, 2], f"frames {[one[3] for one in frames]} of a window of 2")
        expect(all(one[0] == 1 and one[1] == 1 for one in frames), "kind and version")
        await stream.send(json.dumps({"op": "ack", "frame": 2}))
        while not isinstance(found := await asyncio.wait_for(stream.recv(), SECONDS), bytes):
            pass
        _, _, _, number, cycle = struct.unpack_from("<BBHIq", found)
        expect(number == 3, f"frame {number} after 2")
        expect(cycle > frames[-1][4] + 100, "old values were queued")


@streams
async def broken_message(core):
    """A message that cannot be carried out is answered; one that is no object closes this stream only."""
    async with core.stream() as other, core.stream() as stream:
        await stream.send(json.dumps({"op": "monitor", "id": 1, "arm": "no such arm", "value": "q_measured", "every": 1}))
        found = await message(stream, "problem")
        expect(found["for"] == "monitor" and found["id"] == 1 and found["diagnostics"], f"{found}")
        await stream.send("[1")
        try:
            while True:
                await asyncio.wait_for(stream.recv(), SECONDS)
        except websockets.exceptions.ConnectionClosed as closed:
            code = (closed.rcvd or closed.sent).code
            expect(code in (1007, 1008), f"closed with {code}")
        await other.send(json.dumps({"op": "events"}))
        await other.ping()


@streams
async def jogging(core):
    """A jogging that falls silent ends in the core; a move that comes twice is refused."""
    arm = next(one["name"] for one in core.get("/v1/devices")["devices"] if one["kind"] == "arm")
    with core.lease() as fence:
        async with core.stream() as stream:
            await stream.send(json.dumps({"op": "jog", "jog": 1, "fence": fence, "arm": arm, "space": "tool", "timeout_cycles": 100,
                                          "linear_max_m_s": 0.01}))
            await message(stream, "jogging")
            move = json.dumps({"op": "move", "jog": 1, "sequence": 1, "linear": [0, 0, 0.005], "angular": [0, 0, 0]})
            await stream.send(move)
            await message(stream, "moved")
            await stream.send(move)
            found = await message(stream, "problem")
            expect(found["status"] == 409, f"{found}")
            ended = await message(stream, "jog_ended")
            expect(ended["reason"] == "silent", f"{ended}")
        until("the arm is at rest", lambda: core.get(f"/v1/arms/{urllib.parse.quote(arm)}")["state"]["at_rest"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("url", metavar="URL")
    parser.add_argument("--token-file", type=pathlib.Path, metavar="FILE", help="the token of an operator")
    parser.add_argument("--only", action="append", choices=[one.__name__ for one in CHECKS], metavar="NAME")
    arguments = parser.parse_args()
    core = Core(arguments.url, arguments.token_file.read_text().strip() if arguments.token_file else None)
    try:
        core.ask("GET", "/v1/state")
    except OSError as fault:
        sys.exit(f"nobody answers at {arguments.url}: {fault}")
    failed = skipped = 0
    for one in CHECKS:
        if arguments.only and one.__name__ not in arguments.only:
            continue
        try:
            why = one(core)
            skipped += why is not None
            print(f"{'not run' if why else 'ok':8} {one.__name__}: {why or one.__doc__}", flush=True)
        except (Failure, OSError, KeyError, ValueError, asyncio.TimeoutError) as fault:
            failed += 1
            print(f"{'FAILED':8} {one.__name__}: {one.__doc__} {type(fault).__name__}: {fault}", flush=True)
    print(f"{failed} failed, {skipped} not run")
    return 1 if failed else 3 if skipped else 0


if __name__ == "__main__":
    sys.exit(main())
