"""Reads a recording with readers that are not ours: the mcap library and Foxglove's own message classes.

Usage: mcap_readers.py WRITER. The program writes the file (write_sample_file.cc); every
number in it is a function of the cycle, see tests/record/support.h.
"""

import math
import os
import subprocess
import sys
import tempfile

from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from mcap.reader import NonSeekingReader, make_reader
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory

CYCLES = 240
failures = []


def check(condition, what):
    if not condition:
        failures.append(what)
        print(f"FAILED: {what}")


def write_file(program, path):
    subprocess.run([program, path], check=True)


def check_container(path):
    """Summary, checksums, attachments, metadata, order."""
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        check(summary is not None, "the file has a summary")
        statistics = summary.statistics
        check(statistics.message_count == CYCLES * 6 + 6 + 4 + 1, f"message count is {statistics.message_count}")
        check(statistics.chunk_count == 5 == len(summary.chunk_indexes), "240 ms in chunks of 50 ms are 5 chunks")
        check(statistics.message_end_time == (CYCLES - 1) * 1_000_000, "the last message is at 239 ms")
        check(len(summary.channels) == 9, "9 channels")
        messages = list(reader.iter_messages())
        check(len(messages) == statistics.message_count, "the summary counts what is there")
        times = [message.log_time for _, _, message in messages]
        check(times == sorted(times), "messages are in the order of time")
        check(len(list(reader.iter_messages(topics=["/digest"], starting_at=100_000_000, ending_before=110_000_000))) == 10,
              "a stretch of time is found through the indexes")
        attachments = list(reader.iter_attachments())
        check([(a.name, a.data) for a in attachments] == [("scenario.json", b'{"seed": 7}')], "the attachment")
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
        check(metadata["takt.run"]["scenario"] == "touch", "metadata of the run")
        check(metadata["takt.fingerprint"]["mujoco"] == "4.0.1", "fingerprint")
    with open(path, "rb") as file:
        records = list(StreamReader(file, validate_crcs=True).records)
        check(len(records) > CYCLES, "every record and every checksum holds")


def check_foxglove_messages(path):
    """Foxglove's own classes understand the bytes."""
    with open(path, "rb") as file:
        reader = make_reader(file)
        rows = {"/left/joints": [], "/frames": [], "/log": [], "/scene": []}
        for schema, channel, message in reader.iter_messages(topics=list(rows)):
            rows[channel.topic].append((schema.name, message))
    for k, (name, message) in enumerate(rows["/left/joints"]):
        check(name == "foxglove.JointStates", "schema name of joints")
        states = JointStates.FromString(message.data)
        check([j.name for j in states.joints] == ["a1", "a2", "a3"], "joint names")
        check(states.joints[1].position == math.sin(0.003 * k + 1), f"position in cycle {k}")
        check(states.joints[2].velocity == 0.3 * k, f"velocity in cycle {k}")
        check(math.isnan(states.joints[0].effort), "effort is null")
        check(states.timestamp.ToNanoseconds() == k * 1_000_000 == message.log_time, f"time in cycle {k}")
    for k, (name, message) in enumerate(rows["/frames"]):
        check(name == "foxglove.FrameTransforms", "schema name of frames")
        tool = FrameTransforms.FromString(message.data).transforms[1]
        check((tool.parent_frame_id, tool.child_frame_id) == ("base", "tool"), "frame names")
        check((tool.translation.x, tool.translation.z) == (k, 3 * k), f"translation in cycle {k}")
        check(FrameTransforms.FromString(message.data).transforms[0].rotation.w == 1.0, "w is w")
        check(tool.timestamp.ToNanoseconds() == k * 1_000_000, f"time of the frame in cycle {k}")
    check([name for name, _ in rows["/scene"]] == ["foxglove.SceneUpdate"], "one scene")
    entity = SceneUpdate.FromString(rows["/scene"][0][1].data).entities[0]
    check((entity.id, entity.frame_id, entity.frame_locked) == ("arm/link", "tool", True), "a shape on a frame")
    check([p.x for p in entity.triangles[0].points] == [0, 1, 2] and list(entity.triangles[0].indices) == [0, 1, 2]
          and entity.triangles[0].color.g == 0.5, "its triangle")
    log = Log.FromString(rows["/log"][1][1].data)
    check((log.level, log.name, log.message) == (Log.Level.WARNING, "left", "line 70"), "log line")


def check_own_messages(path):
    """The schemas inside the file are enough to decode takt's own messages."""
    seen = {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            seen.setdefault(channel.topic, []).append((message, decoded))
            if channel.topic == "/net/probe":
                k = message.log_time // 1_000_000
                check(decoded.speed == 0.25 * k, f"a sample has its column as a field, cycle {k}")
                check(math.isnan(decoded.force_z) if k % 2 == 0 else decoded.force_z == k, f"null and value, cycle {k}")
            if channel.topic == "/digest":
                expected = 0x9E3779B97F4A7C15 * (decoded.cycle + 1) % 2**64
                check(decoded.digest == expected, f"digest of cycle {decoded.cycle}")
            if channel.topic == "/left/wrench":
                check((decoded.frame, decoded.force.z) == ("tool", 5.0), "wrench")
            if channel.topic == "/sim/state":
                check(len(decoded.values) == 3, "state")
    check(seen["/events"][2][1].text == "cycle 80", "event")
    check(len(seen["/digest"]) == CYCLES, "a digest per cycle")


def check_truncated(path):
    """A file whose end is missing: other readers get the whole chunks too."""
    with open(path, "rb") as file:
        data = file.read()
    with open(path, "wb") as file:
        file.write(data[: int(len(data) * 0.6)])
    count = 0
    with open(path, "rb") as file:
        try:
            for _ in NonSeekingReader(file).iter_messages():
                count += 1
        except Exception as error:  # the reader reports the torn end in its own way
            print(f"torn end: {type(error).__name__}")
    with open(path, "rb") as file:
        streamed = 0
        try:
            for record in StreamReader(file).records:
                streamed += type(record).__name__ == "Message"
        except Exception as error:
            print(f"torn end: {type(error).__name__}")
    check(streamed > 200, f"{streamed} messages before the cut")


def main():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "foreign.mcap")
        write_file(sys.argv[1], path)
        check_container(path)
        check_foxglove_messages(path)
        check_own_messages(path)
        check_truncated(path)
    print("failures:", len(failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
