#!/usr/bin/env python3
"""Recordings that another writer makes (the mcap library), given to every verb that reads recordings: what takt cannot read
is named and is never a success.

Usage: foreign_recordings_test.py TAKT, with the Python of the tests' environment (build/venv).
"""
import itertools
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

from foxglove_schemas_protobuf.Log_pb2 import Log
from mcap.writer import CompressionType, IndexType, Writer
from mcap_protobuf.schema import build_file_descriptor_set

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()

COMPRESSIONS = [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD]
ENCODINGS = {"protobuf": "protobuf", "json": "jsonschema", "cdr": "ros2msg", "ros1": "ros1msg"}


def message(encoding, text):
    if encoding == "protobuf":
        return Log(message=text, name="node", level=Log.Level.INFO).SerializeToString()
    return json.dumps({"data": text}).encode()


def write(file, texts, encoding="protobuf", compression=CompressionType.LZ4, chunked=True, summary=True):
    with open(file, "wb") as stream:
        writer = Writer(stream, compression=compression, use_chunking=chunked, use_statistics=summary,
                        repeat_channels=summary, repeat_schemas=summary, use_summary_offsets=summary,
                        index_types=IndexType.ALL if summary else IndexType.NONE)
        writer.start()
        data = build_file_descriptor_set(Log).SerializeToString() if encoding == "protobuf" else b"string data"
        schema = writer.register_schema("foxglove.Log" if encoding == "protobuf" else "std_msgs/String",
                                        ENCODINGS[encoding], data)
        channel = writer.register_channel("/log", encoding, schema)
        for i, text in enumerate(texts):
            writer.add_message(channel, i * 10**9, message(encoding, text), i * 10**9)
        writer.finish()
    return file


class ForeignRecordings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def takt(self, *arguments, status):
        run = subprocess.run([TAKT, *map(str, arguments)], capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        return run

    def test_every_container_is_compared_and_recovered(self):
        a, b, c, out = (self.path / f"{name}.mcap" for name in ("a", "b", "c", "out"))
        for encoding, compression, chunked, summary in itertools.product(ENCODINGS, COMPRESSIONS, (True, False), (True, False)):
            if not chunked and compression != CompressionType.NONE:
                continue
            with self.subTest(encoding=encoding, compression=compression.name, chunked=chunked, summary=summary):
                form = {"encoding": encoding, "compression": compression, "chunked": chunked, "summary": summary}
                write(a, ["one", "two", "three"], **form)
                write(b, ["one", "TWO", "three"], **form)
                write(c, [], **form)
                same = json.loads(self.takt("compare", a, a, "--json", status=0).stdout)
                self.assertEqual(same["judged"]["a"], {"channels": 1, "channels_in_file": 1, "messages": 3, "messages_in_file": 3})
                self.assertIn("3 of 3 messages", self.takt("compare", a, b, status=1).stdout)
                for pair in ((a, c), (c, a), (c, c)):
                    self.takt("compare", *pair, status=1)
                recovered = json.loads(self.takt("recover", a, out, "--json", status=0).stdout)
                self.assertEqual((recovered["messages"], recovered["lost"]), (3, []))
                self.takt("compare", out, a, status=0)

    def test_what_is_not_decoded_is_named_and_no_success(self):
        file, tables = self.path / "a.mcap", self.path / "tables"
        for encoding in ENCODINGS:
            write(file, ["one", "two"], encoding=encoding)
            with self.subTest(encoding=encoding):
                if encoding == "protobuf":
                    self.assertIn("two", self.takt("events", file, status=0).stdout)
                    self.takt("export", file, "--csv", tables, status=0)
                    self.assertIn("two", (tables / "log.csv").read_text())
                    continue
                for arguments in (("events", file), ("export", file, "--csv", tables)):
                    answer = self.takt(*arguments, "--json", status=2)
                    self.assertIn("/log", answer.stdout)
                    self.assertIn(encoding, answer.stdout)
                    self.assertIn("[unsupported]", answer.stderr)

    def test_a_flipped_bit_is_never_the_same(self):
        """Of each byte of the chunk one bit, in either file."""
        whole, rotten = self.path / "a.mcap", self.path / "b.mcap"
        data = write(whole, ["one", "two", "three"]).read_bytes()
        begin = data.index(b"lz4")
        for at in range(begin + 12, data.index(b"\x07", begin + 500), 97):
            rotten.write_bytes(data[:at] + bytes([data[at] ^ 4]) + data[at + 1:])
            with self.subTest(byte=at):
                self.takt("compare", rotten, whole, status=1)
                self.takt("compare", whole, rotten, status=1)
                self.takt("events", rotten, status=2)


if __name__ == "__main__":
    unittest.main()
