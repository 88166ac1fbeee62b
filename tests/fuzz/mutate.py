#!/usr/bin/env python3
"""Runs takt on mutated files and command lines, and holds it to what it promises of any input.

    mutate.py TAKT [--cases N] [--seed S] [--only KIND] [--case K] [--keep FOLDER] [--jobs N]

Cases are made from the shipped scenarios, models, nets, a site and a recording: scenario, device, site, net, recording,
arguments; with --only mjcf models of MuJoCo that are imported. Case K of a seed is always the same one. It fails if
- the exit status is not 0, 1, 2, 3 or 130, or it is not 0 and there is no message (status 1: no answer);
- it takes more than 20 s of processor time, 120 s in all, or 1 GiB of memory;
- a message is that of a crash: a sanitizer, the C++ runtime, takt's own last catch.
Inputs that fail are kept in FOLDER with the command that shows them. Exit status 1 then. docs/testing.md has figures.
"""
import argparse
import concurrent.futures
import copy
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
MOST_CPU_S, MOST_WALL_S = 20, 120
MOST_MEMORY = 1 << 30
MOST_ADDRESSES = 6 << 30  # of a process gone wild: MOST_MEMORY is judged by what was in use
MOST_FILE = 512 << 20
STATUSES = (0, 1, 2, 3, 130)
CRASH = re.compile(r"AddressSanitizer|ThreadSanitizer|LeakSanitizer|runtime error:|terminate called|internal:|"
                   r"Assertion|stack smashing|double free|corrupted|basic_string|vector::|std::|json\.exception")

EXTREMES = (0, -1, 1e300, -1e300, 1e-300, 1e-9)
NUMBERS = (0, -0.0, 1, -1, 0.5, 2, 7, 1e-300, -1e-300, 1e-9, 1e-5, 1e9, 1e300, -1e300, 1.7976931348623157e308, 2**31, 2**53 + 1,
           2**63, 2**64 - 1, -2**63, 360, 1e6, 0.1 + 0.2)
TEXTS = ("", " ", "world", "home", "$", "$$", "$1/0", "$x", "$text([1,2])", "../x", "/etc/passwd", "a/b", "~0", "\u0000",
         "\u00e9\u20ac\U0001f600", "%s%n", "x" * 70, "\u20ac" * 3000, "x" * 100000, "nan", "NaN", "inf", "-0", "null", "1e999")


# -- JSON --------------------------------------------------------------------------------------------------------------

MOST_DEPTH = 70  # of a path: deeper than any document that is read, and short enough for 300 copies of such a value


def places(value, at=()):
    """All paths into a document, as far as MOST_DEPTH."""
    yield at
    if len(at) >= MOST_DEPTH:
        return
    if isinstance(value, dict):
        for key in value:
            yield from places(value[key], at + (key,))
    elif isinstance(value, list):
        for i, element in enumerate(value):
            yield from places(element, at + (i,))


def value_at(document, path):
    for step in path:
        document = document[step]
    return document


def replace(document, path, value):
    if not path:
        return value
    value_at(document, path[:-1])[path[-1]] = value
    return document


def deep(rng):
    value = rng.choice([1, "x", None])
    for _ in range(rng.choice([5, 63, 64, 65, 3000])):
        value = [value] if rng.random() < 0.5 else {"a": value}
    return value


def other_value(rng, old, words):
    if isinstance(old, (int, float)) and not isinstance(old, bool) and rng.random() < 0.8:
        if rng.random() < 0.3:
            return rng.choice(EXTREMES)
        return rng.choice(NUMBERS) if rng.random() < 0.5 else old * rng.choice([-1, 0, 0.001, 0.5, 1.01, 2, 10, 1e3, 1e6])
    if isinstance(old, str) and rng.random() < 0.8:
        if rng.random() < 0.25:
            return ""
        return rng.choice(words) if rng.random() < 0.6 else rng.choice(TEXTS)
    return rng.choice([rng.choice(NUMBERS), rng.choice(TEXTS), True, False, None, [], {}, [old], {"a": old}, deep(rng)])


def mutate_json(rng, document, words):
    """One change somewhere."""
    path = rng.choice(list(places(document)))
    old = value_at(document, path)
    kind = rng.randrange(8)
    if kind == 0 and path:
        parent = value_at(document, path[:-1])
        del parent[path[-1]]
    elif kind == 1 and path and isinstance(path[-1], str):
        parent = value_at(document, path[:-1])
        parent[rng.choice(words + list(TEXTS))] = parent.pop(path[-1])
    elif kind == 2 and isinstance(old, list) and old:
        old.extend(copy.deepcopy(rng.choice(old)) for _ in range(rng.choice([1, 2, 300])))
    elif kind == 3 and isinstance(old, dict) and old:
        for _ in range(rng.choice([1, 2, 300])):
            old[f"{rng.choice(words)}{rng.randrange(1000)}"] = copy.deepcopy(rng.choice(list(old.values())))
    elif kind == 4:
        return replace(document, path, copy.deepcopy(value_at(document, rng.choice(list(places(document))))))
    else:
        return replace(document, path, other_value(rng, old, words))
    return document


def words_of(document):
    words = {str(step) for path in places(document) for step in path}
    words |= {value_at(document, path) for path in places(document) if isinstance(value_at(document, path), str)}
    return sorted(words)


def mutate_bytes(rng, data):
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 5, 40])):
        at = rng.randrange(len(data) + 1)
        kind = rng.randrange(5)
        if kind == 0 and at < len(data):
            data[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            del data[at:at + rng.choice([1, 3, 100])]
        elif kind == 2:
            data[at:at] = rng.choice([b"\x00", b"\xff", b'"', b"{", b"[" * 5000, b"1e999", b"NaN", b"\xc3", b",", b'"a":1,'])
        elif kind == 3:
            del data[at:]
        else:
            other = rng.randrange(len(data) + 1)
            data[at:at] = data[other:other + rng.choice([2, 20, 400])]
    return bytes(data)


def mutated_text(rng, document):
    """A JSON file: mostly changed as a document, sometimes as bytes, sometimes with keys that come twice."""
    document = copy.deepcopy(document)
    words = words_of(document)
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        document = mutate_json(rng, document, words)
    try:
        text = json.dumps(document, ensure_ascii=rng.random() < 0.5).encode("utf-8", "replace")
    except RecursionError:
        text = b"[" * 3000
    kind = rng.random()
    if kind < 0.1:
        return mutate_bytes(rng, text)
    if kind < 0.13 and text.startswith(b"{") and len(document):
        key = rng.choice(list(document)) if isinstance(document, dict) else "a"
        return b"{" + json.dumps(key).encode() + b": 1," + text[1:]
    return text


# -- Recordings --------------------------------------------------------------------------------------------------------

MAGIC = b"\x89MCAP0\r\n"
TIMES = (0, 1, 10**9, 10**18, 2**62, 2**62 + 1, 2**63 - 1, 2**63, 2**64 - 1)


def records_of(data):
    at, found = len(MAGIC), []
    while at + 9 <= len(data):
        op, size = data[at], struct.unpack_from("<Q", data, at + 1)[0]
        if at + 9 + size > len(data):
            break
        found.append((op, data[at + 9:at + 9 + size]))
        at += 9 + size
    return found


def record(op, body):
    return struct.pack("<BQ", op, len(body)) + body


def text_field(text):
    return struct.pack("<I", len(text)) + text


def bomb(size):
    """A frame of zstd that unpacks to `size` bytes: blocks of one repeated byte."""
    frame, left = b"\x28\xb5\x2f\xfd" + b"\xe0" + struct.pack("<Q", size), size
    while left > 0:
        block = min(left, 128 << 10)
        left -= block
        frame += struct.pack("<I", block << 3 | 1 << 1 | (left == 0))[:3] + b"\x00"
    return frame


def chunk(rng, data, raw_size, compression=b""):
    return record(6, struct.pack("<QQQI", rng.choice(TIMES), rng.choice(TIMES), raw_size, 0) + text_field(compression) +
                  struct.pack("<Q", len(data)) + data)


def message(rng, channel):
    payload = rng.choice([b"", rng.randbytes(20), b"\x0a\x00" * 200, b"\x12\x00" * 5000, b"\x10" + b"\xff" * 9 + b"\x01"])
    return record(5, struct.pack("<HIQQ", channel, 0, rng.choice(TIMES), rng.choice(TIMES)) + payload)


def hostile_record(rng):
    kind = rng.randrange(7)
    if kind == 0:
        size = rng.choice([1 << 20, 32 << 20, 200 << 20, 4 << 30])
        return chunk(rng, bomb(size), size, b"zstd") * rng.choice([1, 60])
    if kind == 1:
        raw = b"".join(message(rng, rng.randrange(30)) for _ in range(rng.choice([1, 50])))
        return chunk(rng, raw, rng.choice([len(raw), 0, 2**64 - 1]))
    if kind == 2:
        return b"".join(message(rng, rng.randrange(30)) for _ in range(rng.choice([1, 50])))
    if kind == 3:
        return record(15, struct.pack("<I", rng.choice([0, 1]))) * rng.choice([1, 20000])
    if kind == 4:
        seed = rng.choice([b"", b"x", b"-1", b"1e9", b"99999999999999999999999"])
        pair = text_field(b"seed") + text_field(seed)
        return record(12, text_field(b"takt.run") + struct.pack("<I", len(pair)) + pair)
    if kind == 5:
        return record(4, struct.pack("<HH", rng.randrange(40), rng.randrange(12)) + text_field(rng.choice([b"/state", b"/x", b""])) +
                      text_field(b"protobuf") + struct.pack("<I", 0)) * rng.choice([1, 5000])
    scenario = json.dumps(mutate_json(rng, json.loads((ROOT / "scenarios/touch.json").read_text()), ["a"])).encode()
    body = struct.pack("<QQ", 0, 0) + text_field(b"scenario.json") + text_field(b"application/json")
    return record(9, body + struct.pack("<Q", len(scenario)) + scenario + struct.pack("<I", 0))


def mutated_recording(rng, data):
    if rng.random() < 0.25:
        return mutate_bytes(rng, data)
    records = [record(op, body) for op, body in records_of(data)]
    for _ in range(rng.choice([1, 1, 2, 5])):
        at = rng.randrange(len(records))
        kind = rng.randrange(6)
        if kind == 0:
            del records[at]
        elif kind == 1:
            records[at:at] = [records[at]] * rng.choice([1, 2, 50])
        elif kind == 2:
            records[at] = bytes([rng.randrange(0, 18)]) + records[at][1:]
        elif kind == 3:
            records[at] = records[at][:9] + mutate_bytes(rng, records[at][9:] or b"\0")
        elif kind == 4:
            records.insert(at, hostile_record(rng))
        else:
            records = [one for one in records if one[0] not in (6, 7)] + [hostile_record(rng), hostile_record(rng)]
        if not records:
            break
    return MAGIC + b"".join(records) + rng.choice([MAGIC, b""])


# -- Command lines -----------------------------------------------------------------------------------------------------

VALUES = ("", " ", "0", "-1", "1", "1e9", "1e300", "nan", "inf", "0x10", "99999999999999999999", "128x96", "128x96garbage", "0x0",
          "-4x-4", "99999x99999", "x", "128x", "/", "/x=1", "/seed=2", "/seed=1e999", "/program=[]", "/=1", "=", "a=b", "arm=slow:8ms",
          "arm=slow:0ms", "arm=slow:1e300ms", "arm=:", "\u20ac", "a" * 5000, "/nowhere/file", "..", "/dev/null", "--", "1,2,3",
          "0,0,0,0,0,0", "0,-0.5,0,1.5,0,-1,0", "nan,nan,nan,nan,nan,nan,nan", "0.5,0,0.5,0,1,0,0", "1e300,0,0,1,0,0,0", "home", "arm")
NUMERIC = ("", "0", "-1", "1e300", "nan", "0x10", "2.5", "99999999999999999999")
TYPICAL = {"--fps": NUMERIC, "--seed": NUMERIC, "--seconds": NUMERIC, "--arm-angle": NUMERIC, "--held": NUMERIC,
           "--size": ("0x0", "-4x-4", "128x96garbage", "99999x99999", "63x64", "x", "128x", "64x64")}
VERBS = {
    "run": (["{root}/scenarios/touch.json", "--dry-run"], ["--size", "--fps", "--seed", "--set", "--site", "--backend", "--models", "--from",
                                                    "--plugin", "--camera", "--json", "--realtime", "--record-blocks"]),
    "validate": (["{root}/scenarios/touch.json"], ["--models", "--json", "--plugin"]),
    "verify": ([], ["--models", "--json"]),
    "compare": (["{recording}", "{recording}", "--quick"], ["--report", "--json", "--models"]),
    "render": (["{recording}", "--video", "{out}.mp4", "--size", "64x64", "--fps", "2"], ["--size", "--fps", "--camera", "--json"]),
    "bless": (["{out}.json", "--reason", "x"], ["--reason", "--json"]),
    "net": (["{root}/scenarios/nets/torch.net.json"], ["--check", "--scenario", "--step", "--graph", "--dump", "--json", "--seconds"]),
    "model": (["lwr4plus"], ["--fk", "--ik", "--arm-angle", "--held", "--branches", "--size", "--posture", "--json"]),
    "primitives": ([], ["--json", "--markdown", "PathClock"]),
    "new": (["robot", "x", "--urdf", "{root}/tests/tools/foreign/five.urdf", "--out", "{out}"], ["--base", "--flange", "--title", "--packages"]),
    "list": ([], ["--json", "--models"]),
}


def mutated_arguments(rng, scratch, recording):
    verb = rng.choice(list(VERBS))
    words, options = VERBS[verb]
    words = list(words)
    for _ in range(rng.choice([1, 1, 2, 3])):
        option = rng.choice(options)
        value = rng.choice(TYPICAL.get(option, VALUES) if rng.random() < 0.5 else VALUES)
        if option in words and words.index(option) + 1 < len(words):
            words[words.index(option) + 1] = value
        else:
            at = rng.randrange(len(words) + 1) if rng.random() < 0.3 else len(words)
            words[at:at] = [option, value] if rng.random() < 0.8 else [option]
    if rng.random() < 0.1 and words:
        words[rng.randrange(len(words))] = rng.choice(VALUES)
    for mark, path in (("{root}", ROOT), ("{recording}", recording), ("{out}", scratch / "out")):
        words = [word.replace(mark, str(path)) for word in words]
    return [verb] + [word.replace("\0", "") for word in words]


# -- Cases -------------------------------------------------------------------------------------------------------------

class Corpus:
    """What cases begin with."""

    def __init__(self, takt, folder):
        def load(pattern, without=()):
            files = [file for file in sorted(ROOT.glob(pattern)) if not any(part in file.name for part in without)]
            return [(file, json.loads(file.read_text())) for file in files]
        self.scenarios = load("scenarios/*.json", ["golden"]) + load("scenarios/nets/*.json", [".net."])
        self.nets = load("scenarios/nets/*.net.json")
        self.devices = load("models/*/device.json")
        self.site = {"devices": {"arm": {"backend": "slow", "cycle_ms": 4, "dead_time_ms": 5},
                                 "wrist": {"backend": "slow", "cycle_ms": 8}}}
        short = json.loads((ROOT / "scenarios/touch.json").read_text())
        short["program"]["steps"] = short["program"]["steps"][:1]
        short["expectations"], short["film"] = [], {}
        (folder / "short.json").write_text(json.dumps(short))
        self.recording = folder / "short.mcap"
        made = subprocess.run([takt, "run", folder / "short.json", "--record", self.recording, "--json"], cwd=ROOT, capture_output=True)
        if made.returncode:
            raise SystemExit(f"the recording to begin with could not be made: {made.stderr.decode()}")
        self.recorded = self.recording.read_bytes()


def make_case(kind, rng, corpus, scratch):
    """Writes what is mutated into `scratch`. @return the arguments of takt"""
    file = scratch / "case.json"
    if kind == "scenario":
        source, document = rng.choice(corpus.scenarios)
        file.write_bytes(mutated_text(rng, document))
        for net in source.parent.glob("*.net.json"):
            shutil.copy(net, scratch)
        if rng.random() < 0.3:
            return ["run", file, "--json", "--set", "/time_limit_s=0.5", *rng.choice([[], ["--record", scratch / "a.mcap"]])]
        return ["validate", file] if rng.random() < 0.8 else ["run", file, "--dry-run", "--json"]
    if kind == "device":
        source, document = rng.choice(corpus.devices)
        model = scratch / source.parent.name
        shutil.copytree(source.parent, model, symlinks=True)
        if rng.random() < 0.7:
            (model / "device.json").write_bytes(mutated_text(rng, document))
        else:
            urdf = rng.choice(sorted(model.glob("*.urdf")))
            urdf.write_bytes(mutate_bytes(rng, urdf.read_bytes()))
        return rng.choice([["validate", model], ["model", model.name, "--models", scratch, "--json"]])
    if kind == "site":
        file.write_bytes(mutated_text(rng, corpus.site))
        return rng.choice([["validate", file], ["run", ROOT / "scenarios/touch.json", "--site", file, "--dry-run"]])
    if kind == "net":
        file.write_bytes(mutated_text(rng, rng.choice(corpus.nets)[1]))
        return rng.choice([["validate", file], ["net", file, "--json"], ["net", file, "--scenario", ROOT / "scenarios/touch.json"]])
    if kind == "recording":
        bad = scratch / "bad.mcap"
        bad.write_bytes(mutated_recording(rng, corpus.recorded))
        pair = [bad, corpus.recording] if rng.random() < 0.5 else [corpus.recording, bad]
        film = ["render", bad, "--video", scratch / "out.mp4", "--size", "64x64", "--fps", "2"]
        return film if rng.random() < 0.3 else ["compare", *pair, *rng.choice([[], ["--quick"], ["--report", scratch / "out.html"]])]
    if kind == "mjcf":
        model = scratch / "mjcf"
        shutil.copytree(ROOT / "tests/tools/foreign/mjcf", model)
        changed = model / rng.choice(["arm_with_hand.xml", "drives.xml", "hand.xml", "assets/limb.obj"])
        changed.write_bytes(mutate_bytes(rng, changed.read_bytes()))
        top = "hand.xml" if changed.name == "hand.xml" else "arm_with_hand.xml"
        return ["new", "robot", "x", "--mjcf", model / top, "--out", scratch / "models"]
    return mutated_arguments(rng, scratch, corpus.recording)


KINDS = ("scenario", "scenario", "scenario", "scenario", "device", "device", "site", "net", "recording", "recording", "arguments",
         "arguments")
ON_REQUEST = ("mjcf",)  # with --only: the cases of a seed stay what they were


def limit():
    os.setpgid(0, 0)
    resource.setrlimit(resource.RLIMIT_CPU, (2 * MOST_CPU_S, 2 * MOST_CPU_S + 5))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_ADDRESSES, MOST_ADDRESSES))
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_FILE, MOST_FILE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(command, folder):
    """@return what is wrong, or nothing; and the message of takt"""
    with open(folder / "stderr", "wb") as said, open(folder / "stdout", "wb") as answered:
        process = subprocess.Popen([str(word) for word in command], cwd=folder, stdin=subprocess.DEVNULL, stdout=answered,
                                   stderr=said, preexec_fn=limit)
        status, usage, in_time = wait_for(process, MOST_WALL_S)
    message_text = (folder / "stderr").read_bytes().decode("utf-8", "replace")
    code = os.waitstatus_to_exitcode(status)
    process.returncode = code
    if not in_time:
        return f"more than {MOST_WALL_S} s", message_text
    cpu = usage.ru_utime + usage.ru_stime
    crash = CRASH.search(message_text)
    if code not in STATUSES:
        return f"status {code}", message_text
    # What does not hold is the answer; what is wrong is said beside it.
    silent = not message_text.strip() and not (code == 1 and (folder / "stdout").stat().st_size)
    if code != 0 and silent:
        return f"status {code} without a message", message_text
    if crash:
        return f"'{crash.group()}' in the message", message_text
    if cpu > MOST_CPU_S:
        return f"{cpu:.1f} s of processor time", message_text
    if usage.ru_maxrss * 1024 > MOST_MEMORY:
        return f"{usage.ru_maxrss >> 10} MiB of memory", message_text
    return None, message_text


def wait_for(process, seconds):
    """os.wait4 with a limit of time. @return status, usage, False if it was ended"""
    late = threading.Event()

    def end():
        late.set()
        os.killpg(process.pid, signal.SIGKILL)
    timer = threading.Timer(seconds, end)
    timer.start()
    _, status, usage = os.wait4(process.pid, 0)
    timer.cancel()
    return status, usage, not late.is_set()


def try_case(takt, seed, number, only, corpus, keep):
    rng = random.Random(f"{seed}/{number}")
    kind = only or rng.choice(KINDS)
    scratch = pathlib.Path(tempfile.mkdtemp(prefix="takt-mutate-"))
    try:
        command = [takt, *make_case(kind, rng, corpus, scratch)]
        wrong, said = run(command, scratch)
        if not wrong:
            return None
        where = keep / f"{seed}-{number}"
        shutil.rmtree(where, ignore_errors=True)
        shutil.copytree(scratch, where, symlinks=True)
        shown = " ".join(repr(str(word).replace(str(scratch), str(where))) for word in command)
        (where / "command").write_text(f"{wrong}\n{shown}\n")
        return f"case {number} ({kind}): {wrong}\n  {shown[:600]}\n  {said[:600]}"
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("takt", type=lambda path: str(pathlib.Path(path).resolve()))
    parser.add_argument("--cases", type=int, default=10000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=sorted({*KINDS, *ON_REQUEST}))
    parser.add_argument("--case", type=int, help="this one alone")
    parser.add_argument("--keep", type=pathlib.Path, default=ROOT / "build/mutated")
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    os.environ.pop("TAKT_ROOT", None)
    os.environ["MALLOC_ARENA_MAX"] = "2"
    sys.setrecursionlimit(20000)
    failures = []
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        corpus = Corpus(given.takt, pathlib.Path(folder))
        numbers = range(given.first, given.first + given.cases) if given.case is None else [given.case]
        tries = pool.map(lambda n: try_case(given.takt, given.seed, n, given.only, corpus, given.keep), numbers)
        for tried, found in enumerate(tries, 1):
            if tried % 500 == 0:
                print(f"{tried} cases, {len(failures)} failed", file=sys.stderr, flush=True)
            if found:
                print(found, flush=True)
                failures.append(found)
    print(f"{len(numbers)} cases, {len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
