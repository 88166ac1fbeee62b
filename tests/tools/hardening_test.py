#!/usr/bin/env python3
"""What surrounds a run: streams, signals, limits, pipes, options and files that are not as they should be. Whatever it is, takt
ends with a status of its own and says why."""
import json
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree

TAKT = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
TOUCH = ROOT / "scenarios/touch.json"


def takt(*arguments, timeout=120, **options):
    options.setdefault("cwd", ROOT)
    return subprocess.run([str(TAKT), *map(str, arguments)], stdout=options.pop("stdout", subprocess.PIPE),
                          stderr=options.pop("stderr", subprocess.PIPE), text=True, errors="replace", timeout=timeout, **options)


def short_scenario(steps=1):
    document = json.loads(TOUCH.read_text())
    document["program"]["steps"] = document["program"]["steps"][:steps]
    document["expectations"], document["film"] = [], {}
    return document


class WithFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def write(self, document, name="scenario.json"):
        file = self.path / name
        file.write_text(document if isinstance(document, str) else json.dumps(document))
        return file

    def refused(self, *arguments, said, **options):
        result = takt(*arguments, **options)
        self.assertEqual(result.returncode, 2, f"{arguments}: {result.stdout}{result.stderr}")
        self.assertIn(said, result.stderr)
        return result


class Streams(WithFolder):
    def test_closed_and_full_streams(self):
        closed = lambda *streams: lambda: [os.close(stream) for stream in streams]  # noqa: E731
        bad = self.write("{", "bad.json")
        self.assertEqual(takt("validate", bad, stderr=None, preexec_fn=closed(1, 2)).returncode, 2)
        self.assertEqual(takt("validate", bad, stdout=None, preexec_fn=closed(0, 1)).returncode, 2)
        self.assertEqual(takt("list", stdout=None, preexec_fn=closed(1)).returncode, 3, "its output is lost")
        self.assertEqual(takt("list", stderr=None, preexec_fn=closed(2)).returncode, 0)
        self.assertEqual(takt("--help", stdout=None, preexec_fn=closed(1)).returncode, 3)
        with open("/dev/full", "w") as full:
            self.assertEqual(takt("validate", bad, stderr=full).returncode, 2)
            for arguments in (["list"], ["primitives"], ["primitives", "--json"], ["--help"]):
                lost = takt(*arguments, stdout=full)
                self.assertEqual(lost.returncode, 3, arguments)
                self.assertIn("the output could not be written", lost.stderr)
            self.assertEqual(takt("primitives", stdout=full, stderr=full).returncode, 3)

    def test_no_file_gets_the_number_of_a_closed_stream(self):
        record = self.path / "a.mcap"
        run = takt("run", self.write(short_scenario()), "--record", record, stdout=None, stderr=None,
                   preexec_fn=lambda: [os.close(stream) for stream in (0, 1, 2)])
        self.assertEqual(run.returncode, 3)
        self.assertEqual(takt("compare", record, record).returncode, 0)

    def test_a_reader_that_has_gone(self):
        reader, writer = os.pipe()
        os.close(reader)
        self.assertEqual(takt("primitives", stdout=writer).returncode, 3)
        os.close(writer)


class Signals(WithFolder):
    def start(self, *arguments, **options):
        return subprocess.Popen([str(TAKT), *map(str, arguments)], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)

    def wait_for(self, condition, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, "it never began")
            time.sleep(0.05)

    def test_a_hang_up_cancels_like_an_interrupt(self):
        for one in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
            record = self.path / f"{one}.mcap"
            run = self.start("run", TOUCH, "--realtime", "--record", record)
            self.wait_for(lambda file=record: file.exists() and file.stat().st_size > 20000)
            run.send_signal(one)
            run.communicate(timeout=60)
            self.assertEqual(run.returncode, 130)
            self.assertNotIn("truncated", takt("compare", record, record).stdout)

    def test_under_nohup_a_hang_up_changes_nothing(self):
        run = self.start("run", self.write(short_scenario()), "--realtime",
                         preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        time.sleep(1)
        run.send_signal(signal.SIGHUP)
        run.communicate(timeout=60)
        self.assertEqual(run.returncode, 0)

    def test_the_second_interrupt_ends_also_with_an_ffmpeg_that_hangs(self):
        fake = self.path / "ffmpeg"
        fake.write_text(f"#!/bin/sh\ntouch {self.path}/started\nsleep 300\n")
        fake.chmod(0o755)
        run = self.start("run", TOUCH, "--video", self.path / "a.mp4", env={**os.environ, "PATH": f"{self.path}:/usr/bin:/bin"})
        self.wait_for((self.path / "started").exists)
        time.sleep(2)
        begin = time.monotonic()
        run.send_signal(signal.SIGINT)
        time.sleep(0.5)
        run.send_signal(signal.SIGINT)
        run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130)
        self.assertLess(time.monotonic() - begin, 15)

    def test_an_interrupt_leaves_neither_temporary_files_nor_half_a_film(self):
        temporary, film, record = self.path / "tmp", self.path / "film.mp4", self.path / "a.mcap"
        temporary.mkdir()
        self.assertEqual(takt("run", TOUCH, "--record", record).returncode, 0)
        film.write_text("the film of yesterday")
        for arguments in (("render", record, "--video", film), ("compare", record, record, "--report", self.path / "c.html", "--films"),
                          ("run", "--resim", record), ("replay", record)):
            verb = self.start(*arguments, env={**os.environ, "TMPDIR": str(temporary)})
            self.wait_for(lambda: any(temporary.iterdir()))
            time.sleep(0.5)
            verb.send_signal(signal.SIGINT)
            verb.communicate(timeout=60)
            self.assertEqual(verb.returncode, 130, arguments[0])
            self.wait_for(lambda: not any(temporary.iterdir()), seconds=10)
            self.assertEqual(film.read_text(), "the film of yesterday")
        self.assertEqual(sorted(file.name for file in self.path.iterdir()), ["a.mcap", "film.mp4", "tmp"])

    def test_the_report_of_an_interrupted_verify_says_so(self):
        out = self.path / "junit.xml"
        verify = self.start("verify", ROOT / "scenarios", "--junit", out)
        time.sleep(2)
        verify.send_signal(signal.SIGINT)
        verify.communicate(timeout=60)
        self.assertEqual(verify.returncode, 130)
        suites = xml.etree.ElementTree.parse(out).getroot()
        count = lambda what: sum(int(suite.get(what)) for suite in suites)  # noqa: E731
        self.assertGreaterEqual(count("errors"), 1)
        self.assertGreaterEqual(count("skipped"), 1, "what was not run or not judged")
        self.assertEqual(count("failures"), 0)

    def test_a_report_that_cannot_be_written_is_refused_first(self):
        begin = time.monotonic()
        for arguments in (("verify", ROOT / "scenarios", "--junit", self.path / "none/out.xml"),
                          ("verify", TOUCH, "--seeds", "9", "--report", self.path / "none/out.html")):
            self.refused(*arguments, said="none")
        self.assertLess(time.monotonic() - begin, 20)

    def test_other_verbs_end_with_130(self):
        film = self.start("verify", ROOT / "scenarios")
        time.sleep(1)
        film.send_signal(signal.SIGTERM)
        film.communicate(timeout=60)
        self.assertEqual(film.returncode, 130)


class CutRecordings(WithFolder):
    def test_a_recording_that_was_cut_is_replayed_as_far_as_it_goes(self):
        record = self.path / "a.mcap"
        self.assertEqual(takt("run", TOUCH, "--record", record).returncode, 0)
        whole = json.loads(takt("replay", record, "--json").stdout)
        record.write_bytes(record.read_bytes()[:record.stat().st_size * 7 // 10])
        replay = takt("replay", record, "--json")
        self.assertEqual(replay.returncode, 0, replay.stdout + replay.stderr)
        cut = json.loads(replay.stdout)
        self.assertLess(cut["cycles"], whole["cycles"])
        self.assertEqual(cut["end"]["cycle"], cut["cycles"] - 1)
        self.assertIsNone(cut["end"]["first_difference"])


class Limits(WithFolder):
    def test_a_file_that_may_not_grow(self):
        file, report, record = self.write(short_scenario()), self.path / "report.html", self.path / "b.mcap"
        self.assertEqual(takt("run", file, "--record", record).returncode, 0)
        most = record.stat().st_size * 4 // 5  # what the recording begins with has room, the run has not
        stops = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))  # noqa: E731
        small = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))  # noqa: E731
        run = takt("run", file, "--record", self.path / "a.mcap", preexec_fn=stops)
        self.assertEqual(run.returncode, 3)
        self.assertIn("File too large", run.stderr)
        refused = takt("compare", record, record, "--report", report, preexec_fn=small)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("File too large", refused.stderr)
        self.assertEqual(sorted(file.name for file in self.path.iterdir()), ["a.mcap", "b.mcap", "scenario.json"])

    def test_no_folder_for_temporary_files(self):
        missing = {**os.environ, "TMPDIR": str(self.path / "none")}
        file = self.write(short_scenario())
        self.refused("bless", file, "--reason", "a test", said="TMPDIR", env=missing)
        self.refused("net", ROOT / "scenarios/nets/torch.net.json", "--graph", self.path / "a.svg", "--scenario",
                     ROOT / "scenarios/nets/torch.json", said="TMPDIR", env=missing)

    def test_little_memory_for_a_film(self):
        # Libraries that draw do not all look whether they were given memory.
        for mib in range(300, 460, 20):
            run = takt("run", self.write(short_scenario()), "--video", self.path / "a.mp4", "--size", "64x64",
                       preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (mib << 20, mib << 20)))
            self.assertIn(run.returncode, (0, 2, 3), f"{mib} MiB: {run.stderr}")
            self.assertTrue(run.returncode == 0 or run.stderr)

    @unittest.skipUnless(os.geteuid() == 0, "only root can become a user who has no processes yet")
    def test_few_threads(self):
        def few(count):
            def limit():
                resource.setrlimit(resource.RLIMIT_NPROC, (count, count))
                os.setgid(60000 + os.getpid() % 5000)
                os.setuid(60000 + os.getpid() % 5000)
            return limit
        self.path.chmod(0o777)
        record = self.path / "a.mcap"
        self.assertEqual(takt("run", self.write(short_scenario()), "--record", record).returncode, 0)
        for count in (1, 2, 3, 4, 6, 8):
            for i, arguments in enumerate((["run", self.path / "scenario.json", "--record", self.path / "b.mcap", "--video",
                                            self.path / "b.mp4", "--size", "64x64"],
                                           ["render", record, "--video", self.path / "c.mp4", "--size", "64x64", "--fps", "2"],
                                           ["model", "ur5", "--image", self.path / "d.png", "--size", "64x64"])):
                run = takt(*arguments, preexec_fn=few(count), timeout=60)
                self.assertIn(run.returncode, (0, 2, 3), f"{count}, {i}: {run.stderr}")
                self.assertTrue(run.returncode == 0 or run.stderr)
                for product in ("b.mcap", "b.mp4", "c.mp4", "d.png"):
                    (self.path / product).unlink(missing_ok=True)

    def test_a_crash_names_what_was_done(self):
        run = subprocess.Popen([str(TAKT), "verify", str(ROOT / "scenarios")], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               text=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0)))
        time.sleep(0.5)
        run.send_signal(signal.SIGSEGV)
        said = run.communicate(timeout=60)[1]
        self.assertEqual(run.returncode, 3)
        self.assertIn("internal: invalid access to memory; while doing: takt verify", said)

    def test_little_memory(self):
        for mib in (600, 1000):
            run = takt("validate", TOUCH, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (mib << 20, mib << 20)))
            self.assertIn(run.returncode, (0, 2, 3), f"{mib} MiB: {run.stderr}")
            self.assertTrue(run.returncode == 0 or run.stderr)

    def test_paths_that_are_too_long_or_lead_nowhere(self):
        long = "a" * 5000
        for verb in (["validate", long], ["verify", long], ["run", long], ["compare", long, long], ["net", long], ["model", long],
                     ["render", long, "--video", self.path / "a.mp4"], ["bless", long, "--reason", "x"],
                     ["run", TOUCH, "--record", long], ["run", TOUCH, "--video", long + ".mp4"]):
            result = takt(*verb)
            self.assertEqual(result.returncode, 2, f"{verb[0]}: {result.stderr[:300]}")
            self.assertTrue(result.stderr)
        (self.path / "loop").symlink_to("loop")
        self.refused("verify", self.path / "loop", said="loop")


class Options(WithFolder):
    def test_options_take_one_value_each(self):
        file = self.write(short_scenario())
        for option in (["--models", ROOT / "models"], ["--set", "/seed=3"], ["--backend", "arm=slow:8ms"]):
            self.assertEqual(takt("run", *option, file, "--dry-run").returncode, 0, option)
        self.assertEqual(takt("model", "--fk", "0,0,0,0,0,0,0", "lwr4plus").returncode, 0)
        self.refused("run", file, "--plugin", "/none.so", said="/none.so")

    def test_a_folder_of_models_that_is_not_there(self):
        for verb in (["run", TOUCH, "--dry-run"], ["validate", TOUCH], ["list"]):
            self.refused(*verb, "--models", "/nonexist", said="--models: error: '/nonexist'")

    def test_numbers_that_are_none(self):
        for arguments, said in ((["--seed", "-1"], "--seed: error: '-1'"), (["--seed", "1e3"], "--seed"),
                                (["--seed", ""], "--seed"), (["--size", "128x96garbage"], "--size: error: '128x96garbage'"),
                                (["--size", "128"], "--size"),
                                (["--fps", "0"], "--fps: error: 0 pictures per second (Choose 1 to 120) [out-of-range]"),
                                (["--fps", "-1"], "--fps"), (["--fps", "1000"], "--fps")):
            self.refused("run", TOUCH, *arguments, "--dry-run", said=said)
        self.refused("model", "lwr4plus", "--fk", "nan,0,0,0,0,0,0", said="--fk: error: nan")
        self.refused("model", "lwr4plus", "--ik", "1e300,0,0,1,0,0,0", said="--ik")

    def test_render_checks_its_options(self):
        record = self.path / "a.mcap"
        self.assertEqual(takt("run", self.write(short_scenario()), "--record", record).returncode, 0)
        for arguments, said in ((["--fps", "0"], "--fps: error: 0 "), (["--fps", "-5"], "--fps"),
                                (["--size", "128x96garbage"], "--size: error: '128x96garbage' is not a size")):
            self.refused("render", record, "--video", self.path / "a.mp4", *arguments, said=said)
        before = record.read_bytes()
        self.refused("render", record, "--video", record, said="[file-not-writable]")
        self.refused("compare", record, record, "--report", record, said="[file-not-writable]")
        self.assertEqual(record.read_bytes(), before)

    def test_products_replace_no_input(self):
        file = self.write(short_scenario())
        before = file.read_bytes()
        self.refused("run", file, "--record", file, said="--record: error:")
        (self.path / "link.mcap").symlink_to(file)
        self.refused("run", file, "--record", self.path / "link.mcap", said="[file-not-writable]")
        self.refused("run", file, "--record", self.path / "a.mp4", "--video", self.path / "a.mp4", said="[conflict]")
        os.mkfifo(self.path / "pipe")
        self.refused("run", file, "--record", self.path / "pipe", said="[file-not-writable]")
        self.assertEqual(file.read_bytes(), before)

    def test_what_is_refused_leaves_nothing_and_replaces_nothing(self):
        file, kept = self.write(short_scenario()), self.path / "kept.mcap"
        kept.write_text("kept")
        before = sorted(self.path.iterdir())
        self.refused("run", file, "--video", self.path / "a.mp4", "--camera", "none", "--record", self.path / "a.mcap", said="'none'")
        self.refused("run", file, "--video", self.path / "a.txt", "--record", kept, said="[invalid-value]")
        self.assertEqual(sorted(self.path.iterdir()), before)
        self.assertEqual(kept.read_text(), "kept")

    def test_a_device_that_cannot_be_written_stays(self):
        # A link to a device, so that a fault here does not cost the machine its /dev/full.
        full = self.path / "full.png"
        full.symlink_to("/dev/full")
        self.refused("model", "ur5", "--image", full, "--size", "64x64", said="[file-not-writable]")
        self.assertTrue(full.is_symlink())
        self.assertTrue(pathlib.Path("/dev/full").is_char_device())

    def test_bless_wants_a_reason(self):
        for reason in ("", " \t"):
            self.refused("bless", self.write(short_scenario()), "--reason", reason, said="--reason: error:")
        self.assertEqual([file.name for file in self.path.iterdir()], ["scenario.json"])


class Files(WithFolder):
    def changed(self, change):
        document = short_scenario(12)
        change(document["program"]["steps"])
        return self.write(document)

    def test_an_empty_name_of_any_step(self):
        for name in ("blend", "can", "carry", "drive", "mobile", "pick", "screw", "search", "sort", "touch", "wave"):
            document = json.loads((ROOT / f"scenarios/{name}.json").read_text())
            for i, step in enumerate(document["program"].get("steps", [])):
                kept = step.get("name")
                step["name"] = ""
                result = self.refused("validate", self.write(document), said=f"/program/steps/{i}/name")
                self.assertIn("[wrong-type]", result.stderr)
                step.pop("name")
                if kept is not None:
                    step["name"] = kept

    def test_a_direction_that_is_too_long(self):
        document = json.loads((ROOT / "scenarios/lessons/10-press.json").read_text())
        press = next(step for step in document["program"]["steps"] if step["do"] == "press")
        press["direction"] = [0, 0, 1e300]
        self.refused("validate", self.write(document), said="[out-of-range]")

    def test_a_text_that_doubles_itself(self):
        document = short_scenario()
        document["program"] = {"do": "sequence", "variables": {"word": "ab"}, "steps": [
            {"do": "repeat", "times": 60, "as": "i", "steps": [{"do": "let", "values": {"word": "$word + word"}}]}]}
        self.refused("validate", self.write(document), said="[too-large]", timeout=20)

    def test_many_keys(self):
        document = short_scenario()
        document["frames"] = {f"frame {i}": {"position_m": [0, 0, 0]} for i in range(40000)}
        begin = time.monotonic()
        result = takt("validate", self.write(document), timeout=60)
        self.assertIn(result.returncode, (0, 2), result.stderr[:500])
        self.assertLess(time.monotonic() - begin, 20)

    def test_a_stop_is_told_in_words(self):
        for what, said in (({"do": "stop", "category": 0}, "stopped by category 0"), ({"do": "stop", "category": 1}, "stopped by category 1"),
                           ({"do": "emergency_stop", "category": 0}, "(device): emergency_stop"),
                           ({"do": "emergency_stop", "category": 1}, "(device): emergency_stop")):
            document = short_scenario(2)
            document["faults"] = [{"at_s": 0.5, **what}]
            self.write(document)
            for backend in ([], ["--backend", "arm=slow:8ms"]):
                run = takt("run", self.path / "scenario.json", *backend)
                self.assertEqual(run.returncode, 3, run.stderr)
                self.assertIn(said, run.stderr)
                self.assertNotRegex(run.stderr, r"fault \d")

    def test_small_blends(self):
        document = json.loads((ROOT / "scenarios/blend.json").read_text())
        text = json.dumps(document)
        self.assertIn("blend_m", text)
        for blend in ("1e-300", "1e-9"):
            self.refused("validate", self.write(text.replace('"blend_m": 0.', f'"blend_m": {blend}, "$was": 0.')),
                         said="1e-05", timeout=20)


if __name__ == "__main__":
    os.environ.pop("TAKT_ROOT", None)
    unittest.main(verbosity=1)
