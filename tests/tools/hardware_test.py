#!/usr/bin/env python3
"""Driver and emulated controller in two processes, over sockets: what they say, how they end. The interface's cycle is 20 ms,
so that a busy machine is in time. Where it is not, five late cycles in a second stop the nets, which is tested elsewhere: such
a run is repeated, with a fresh emulator."""
import json
import pathlib
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

TAKT = str(pathlib.Path(sys.argv.pop(1)).resolve())
ROOT = pathlib.Path(__file__).resolve().parents[2]
CELL = {
    "time_limit_s": 60,
    "devices": {"arm": {"model": "lwr4plus"}},
    "program": {"do": "sequence", "steps": [
        {"do": "ptp", "to": {"joints_deg": [5, -30, 0, 90, 0, -60, 0]}, "speed": 0.3},
        {"do": "ptp", "to": "home", "speed": 0.3},
    ]},
}


TRIES = 5  # of a run that the machine was too slow for
LATE = re.compile(r"\(overrun\)|silent for too long|newest sample is \d+ ms old")


def too_slow_for(run):
    """The report says that a net was stopped since somebody was late too often: the cycle, or the emulated controller."""
    if run.returncode != 3:
        return False
    return any(one["code"] == "stopped" and LATE.search(one["message"]) for one in json.loads(run.stdout)["diagnostics"])


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class TwoProcesses(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.file = pathlib.Path(self.folder.name) / "cell.json"
        self.file.write_text(json.dumps(CELL))
        self.backend = f"arm=fri:127.0.0.1:{free_port()},cycle=20ms,margin=60ms"

    def emulate(self, *arguments):
        process = subprocess.Popen([TAKT, "emulate", str(self.file), "--backend", self.backend, "--json", *arguments],
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)
        self.addCleanup(process.stdin.close)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        self.assertIn("EMULATED: arm as fri", process.stderr.readline())
        return process

    def run_takt(self, *arguments):
        return subprocess.run([TAKT, "run", str(self.file), "--backend", self.backend, "--realtime", "--json", *arguments],
                              capture_output=True, text=True, timeout=120, cwd=ROOT)

    def beside_emulator(self, run, emulate=None):
        """An emulator and what run() gives beside it, from the first try that the machine was fast enough for."""
        for tries in range(1, TRIES + 1):
            emulator = (emulate or self.emulate)()
            done = run()
            if tries == TRIES or not too_slow_for(done):
                return emulator, done
            emulator.terminate()
            emulator.communicate(timeout=30)

    def test_a_program_moves_the_emulated_arm_and_is_refused_when_it_stands_elsewhere(self):
        emulator, run = self.beside_emulator(self.run_takt)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        report = json.loads(run.stdout)
        self.assertEqual(report["result"], "passed")
        self.assertEqual(report["site"]["realities"], {"arm": "EMULATED"})
        self.assertIn("devices: arm EMULATED", run.stderr)
        self.assertIn("FRI state CMD", run.stderr)
        elsewhere = self.run_takt("--set", "/devices/arm/start_deg=[0, -30, 0, 80, 0, -60, 0]")
        self.assertEqual(elsewhere.returncode, 3, elsewhere.stderr)
        self.assertRegex(elsewhere.stderr, r"'arm'.* a3 .* \[condition-not-met\]")
        emulator.send_signal(signal.SIGINT)
        out, err = emulator.communicate(timeout=30)
        self.assertEqual(emulator.returncode, 0, err)
        self.assertEqual(json.loads(out)["result"], "ended")
        self.assertIn("CMD: position", err)
        self.assertIn("MON: friStop", err)

    def site(self, master, backend):
        kind, _, rest = backend.partition("=")[2].partition(":")
        address, *settings = (rest or "virtual").split(",")
        binding = {"backend": kind, "address": address}
        for one in settings:
            key, _, value = one.partition("=")
            binding[key + "_ms"] = int(value.removesuffix("ms"))
        file = self.file.with_name("site.json")
        file.write_text(json.dumps({"master_clock": master, "devices": {"arm": binding}}))
        return str(file)

    def run_with_site(self, site, *arguments):
        return subprocess.run([TAKT, "run", str(self.file), "--site", site, "--json", *arguments], capture_output=True,
                              text=True, timeout=120, cwd=ROOT)

    def test_the_clock_of_the_arm_may_be_the_master(self):
        # From half a period off the way is 2.5 s.
        self.file.write_text(json.dumps(CELL | {"program": {"do": "wait", "seconds": 6}}))
        site = self.site("arm", self.backend)
        _, run = self.beside_emulator(lambda: self.run_with_site(site, "--realtime"))
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        master = json.loads(run.stdout)["site"]["master_clock"]
        self.assertEqual(master["device"], "arm")
        self.assertGreater(master["cycles"], 1000)
        self.assertLessEqual(master["off_ns"]["p50"], 500_000)

    def test_a_master_that_has_no_clock_of_its_own_is_refused(self):
        for master, backend in (("arm", "arm=fri:virtual"), ("nobody", self.backend), ("arm", "arm=cia402:127.0.0.1:20599")):
            site = self.site(master, backend)
            run = self.run_with_site(site, "--realtime")
            self.assertEqual(run.returncode, 2, run.stdout + run.stderr)
            errors = [(one["code"], one["file"], one["pointer"]) for one in json.loads(run.stdout)["diagnostics"] if one["severity"] == "error"]
            self.assertIn(("incompatible", str(site), "/master_clock"), errors, backend)

    def kill_while_it_moves(self):
        """Kills a driver a second into a slow motion. @return whether it was still moving the arm then"""
        slow = ["--set", "/program/steps/0/speed=0.02", "--log", "debug"]
        driver = subprocess.Popen([TAKT, "run", str(self.file), "--backend", self.backend, "--realtime", *slow],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=ROOT)
        self.addCleanup(driver.stderr.close)
        self.addCleanup(driver.kill)
        begun = any("program begin: ptp" in line for line in driver.stderr)
        time.sleep(1.0)
        running = driver.poll() is None
        driver.kill()
        driver.wait()
        return begun and running and not re.search(r"program (end|failed)|error:", driver.stderr.read())

    def test_a_driver_that_is_killed_leaves_an_arm_that_stands(self):
        for _ in range(TRIES):
            emulator = self.emulate()
            moved = self.kill_while_it_moves()
            time.sleep(3.0)
            emulator.send_signal(signal.SIGTERM)
            _, err = emulator.communicate(timeout=30)
            if moved:
                break
        self.assertTrue(moved, "no driver moved the arm when it was killed")
        self.assertEqual(emulator.returncode, 0, err)
        self.assertRegex(err, "MON: (20 answers missing in a row|communication quality)")

    def test_an_arm_that_was_stopped_moves_again_only_after_somebody_has_reset_it(self):
        def type_in(emulator, line, answer):
            emulator.stdin.write(line + "\n")
            emulator.stdin.flush()
            for said in emulator.stderr:
                if answer in said:
                    return
            self.fail(f"no answer '{answer}' to '{line}'")

        def stopped_and_reset():
            emulator = self.emulate()
            emulator.stderr.readline()  # what may be typed
            type_in(emulator, "reset the arm", "is neither 'reset ARM' nor 'stop ARM'")
            type_in(emulator, "stop arm", "arm: stopped at the machine")
            refused = self.run_takt()
            self.assertEqual(refused.returncode, 3, refused.stdout + refused.stderr)
            self.assertFalse(too_slow_for(refused), "no motion began")
            type_in(emulator, "reset arm", "arm: reset")
            return emulator

        _, run = self.beside_emulator(self.run_takt, stopped_and_reset)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def test_faults_of_machines_happen_to_emulated_ones_and_others_are_refused(self):
        self.file.write_text(json.dumps(CELL | {"faults": [
            {"at_s": 0.5, "do": "push", "body": "arm/link4", "force_N": [0, 5, 0], "seconds": 0.2},
            {"at_s": 1.0, "do": "stop", "arm": "arm"}]}))
        emulator = self.emulate()
        for fault in (r"0\.500 s  push: arm/link4", r"1\.000 s  stop: arm category 1"):
            self.assertTrue(any(re.search(fault, line) for line in emulator.stderr), fault)
        run = self.run_takt("--set", "/faults=[]")
        self.assertEqual(run.returncode, 3, run.stdout + run.stderr)
        self.file.write_text(json.dumps(CELL | {"faults": [{"at_s": 1.0, "do": "emergency_stop", "category": 1}]}))
        refused = subprocess.run([TAKT, "emulate", str(self.file), "--backend", self.backend, "--json"],
                                 capture_output=True, text=True, timeout=60, cwd=ROOT)
        self.assertEqual(refused.returncode, 2, refused.stderr)
        errors = [(one["code"], one["pointer"]) for one in json.loads(refused.stdout)["diagnostics"]]
        self.assertIn(("unsupported", "/faults/0"), errors)

    def test_a_clock_that_has_lost_time_is_told(self):
        emulator = self.emulate()
        emulator.stderr.readline()  # what may be typed
        emulator.send_signal(signal.SIGSTOP)
        time.sleep(1.0)
        emulator.send_signal(signal.SIGCONT)
        lost = next(found for line in emulator.stderr if (found := re.search(r"clock: lost (\d+\.\d+) s", line)))
        self.assertGreater(float(lost.group(1)), 0.5)
        emulator.send_signal(signal.SIGINT)
        out, err = emulator.communicate(timeout=30)
        self.assertEqual(emulator.returncode, 0, err)
        report = json.loads(out)
        self.assertIn("over-budget", [one["code"] for one in report["diagnostics"]])
        self.assertGreater(report["overruns"], 500)

    def test_without_a_controller_the_run_says_what_to_check(self):
        run = self.run_takt("--set", "/time_limit_s=60")
        self.assertEqual(run.returncode, 3, run.stdout)
        self.assertIn("[device-fault]", run.stderr)

    def test_bad_usage(self):
        nothing = subprocess.run([TAKT, "emulate", str(self.file)], capture_output=True, text=True, cwd=ROOT)
        self.assertEqual(nothing.returncode, 2)
        self.assertIn("[requires]", nothing.stderr)
        products = subprocess.run([TAKT, "emulate", str(self.file), "--backend", self.backend, "--record", "a.mcap",
                                   "--video", "a.mp4"], capture_output=True, text=True, cwd=ROOT)
        self.assertEqual(products.returncode, 2)
        for option in ("--record", "--video"):
            self.assertIn(f"{option}: error", products.stderr)
        self.assertEqual(products.stderr.count("[not-possible-now]"), 2)
        lock_step = subprocess.run([TAKT, "run", str(self.file), "--backend", self.backend], capture_output=True,
                                   text=True, cwd=ROOT)
        self.assertEqual(lock_step.returncode, 2)
        self.assertIn("--realtime", lock_step.stderr)


class UrTerminals(unittest.TestCase):
    """An arm and the terminals of its controller over one connection. Ports of a UR are fixed, so the address is drawn."""

    CELL = {
        "time_limit_s": 60,
        "devices": {
            "arm": {"model": "ur5"},
            "io": {"model": "io_block", "at": {"in": "world", "position_m": [1, 1, 0]}},
        },
        "program": {"do": "sequence", "steps": [
            {"do": "set", "output": "io/do3", "value": True},
            {"do": "ptp", "to": {"joints_deg": [5, -100, -90, -80, 90, 90]}, "speed": 0.3},
            {"do": "set", "output": "io/do3", "value": False},
            {"do": "wait", "seconds": 0.2},
        ]},
        "expectations": [
            {"kind": "signal", "signal": "io/do3", "is": False, "rises": 1},
            {"kind": "signal", "signal": "io/di2", "is": True},
        ],
    }

    def test_outputs_and_inputs_go_over_the_connection_of_the_arm(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "cell.json"
            file.write_text(json.dumps(self.CELL))
            host = f"127.{random.randint(1, 250)}.{random.randint(1, 250)}.{random.randint(1, 250)}"
            backends = ["--backend", f"arm=rtde:{host},margin=60ms", "--backend", "io=terminals:arm"]
            closed = '/devices/io/settings={"di2": {"script": [{"at_s": 0, "value": true}]}}'
            for _ in range(TRIES):
                emulator = subprocess.Popen([TAKT, "emulate", str(file), *backends, "--set", closed], cwd=ROOT,
                                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                self.addCleanup(emulator.stderr.close)
                self.addCleanup(emulator.kill)
                self.assertIn("EMULATED: arm as rtde", emulator.stderr.readline())
                run = subprocess.run([TAKT, "run", str(file), *backends, "--realtime", "--json"], capture_output=True,
                                     text=True, timeout=120, cwd=ROOT)
                if not too_slow_for(run):
                    break
                emulator.terminate()
                emulator.wait(timeout=30)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
            self.assertEqual(json.loads(run.stdout)["site"]["realities"], {"arm": "EMULATED", "io": "EMULATED"})
            emulator.send_signal(signal.SIGINT)
            self.assertEqual(emulator.wait(timeout=30), 0)

    def test_blocks_and_arms_that_do_not_fit_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "cell.json"
            file.write_text(json.dumps(self.CELL))
            for backends, text in ((["io=terminals:arm"], "'arm' has no driver"),
                                   (["io=terminals:leg", "arm=rtde"], "there is no arm 'leg'"),
                                   (["io=terminals", "arm=rtde"], "'of'"),
                                   (["arm=terminals:arm"], "is of kind 'arm'"),
                                   (["arm=cia402", "io=terminals:arm"], "offers no terminals")):
                arguments = [word for one in backends for word in ("--backend", one)]
                run = subprocess.run([TAKT, "run", str(file), *arguments], capture_output=True, text=True, timeout=60, cwd=ROOT)
                self.assertEqual(run.returncode, 2, f"{backends}: {run.stderr}")
                self.assertIn(text, run.stderr)


if __name__ == "__main__":
    unittest.main()
