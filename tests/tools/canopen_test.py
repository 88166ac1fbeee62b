#!/usr/bin/env python3
"""Emulated drives and a master that nobody of takt wrote: the package canopen, which knows one message per direction.

Usage: canopen_test.py TAKT
"""
import json
import logging
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

import can
import canopen
from canopen.objectdictionary import ODRecord, ODVariable, datatypes
from canopen.profiles.p402 import BaseNode402

TAKT = str(pathlib.Path(sys.argv.pop(1)).resolve())
ROOT = pathlib.Path(__file__).resolve().parents[2]
NODES = range(1, 7)
CYCLE = 0.02  # s
CYCLIC_POSITION = 8
TRIES = 5  # on a busy machine
logging.disable(logging.WARNING)  # that modes of operation are no process data here


class DatagramBus(can.BusABC):
    """Frames in datagrams, as docs/hardware-cia402.md has them."""

    def __init__(self, address):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(address)
        super().__init__(channel=address)

    def send(self, msg, timeout=None):
        head = struct.pack("<IB3x8s", msg.arbitration_id, len(msg.data), bytes(msg.data))
        self.socket.send(head + struct.pack("<I", zlib.crc32(head)))

    def _recv_internal(self, timeout):
        self.socket.settimeout(timeout)
        try:
            datagram = self.socket.recv(64)
        except OSError:
            return None, False
        identifier, size, data = struct.unpack("<IB3x8s", datagram[:16])
        return can.Message(arbitration_id=identifier, data=data[:size], is_extended_id=False, timestamp=time.time()), False

    def shutdown(self):
        super().shutdown()
        self.socket.close()


def dictionary(node):
    """What a master has to know of a drive; there is no EDS."""
    objects = canopen.ObjectDictionary()
    objects.node_id = node

    def variable(index, subindex, data_type):
        one = ODVariable(f"{index:04X}h {subindex}", index, subindex)
        one.data_type = data_type
        return one

    def record(index, types):
        one = ODRecord(f"{index:04X}h", index)
        for subindex, data_type in types.items():
            one.add_member(variable(index, subindex, data_type))
        objects.add_object(one)

    for index, data_type in ((0x1000, datatypes.UNSIGNED32), (0x1001, datatypes.UNSIGNED8), (0x1006, datatypes.UNSIGNED32),
                             (0x603F, datatypes.UNSIGNED16), (0x6040, datatypes.UNSIGNED16), (0x6041, datatypes.UNSIGNED16),
                             (0x6060, datatypes.INTEGER8), (0x6061, datatypes.INTEGER8), (0x6064, datatypes.INTEGER32),
                             (0x607A, datatypes.INTEGER32), (0x6502, datatypes.UNSIGNED32)):
        objects.add_object(variable(index, 0, data_type))
    record(0x60C2, {1: datatypes.UNSIGNED8, 2: datatypes.INTEGER8})
    for index in (0x1400, 0x1800):
        record(index, {0: datatypes.UNSIGNED8, 1: datatypes.UNSIGNED32, 2: datatypes.UNSIGNED8})
    for index in (0x1600, 0x1A00):
        record(index, {0: datatypes.UNSIGNED8, **dict.fromkeys(range(1, 5), datatypes.UNSIGNED32)})
    return objects


class Master:
    """All drives of an arm, each by RPDO1 with control word and target, and TPDO1 with status word and position."""

    def __init__(self, port):
        self.network = canopen.Network(DatagramBus(("127.0.0.1", port)))
        self.network.connect()
        self.nodes = [BaseNode402(node, dictionary(node)) for node in NODES]
        self.booted = set()
        for node in self.nodes:
            # s, for busy machines
            node.sdo.RESPONSE_TIMEOUT = node.TIMEOUT_SWITCH_STATE_SINGLE = 3.0
            node.TIMEOUT_SWITCH_STATE_FINAL = 10.0
            self.network.add_node(node)
            node.nmt.add_heartbeat_callback(lambda state, node=node: self.booted.add(node.id) if state == 0 else None)

    def set_up(self, node):
        assert node.sdo[0x1000].raw & 0xFFFF == 402
        node.sdo[0x60C2][1].raw = round(1000 * CYCLE)
        node.sdo[0x6060].raw = CYCLIC_POSITION
        for message, objects in ((node.rpdo[1], (0x6040, 0x607A)), (node.tpdo[1], (0x6041, 0x6064))):
            message.read()
            message.clear()
            for index in objects:
                message.add_variable(index)
            message.trans_type = 1
            message.enabled = True
            message.save()
        node.setup_402_state_machine(read_pdos=False)
        node.rpdo[1][0x607A].raw = node.sdo[0x6064].raw
        node.rpdo[1][0x6040].raw = 0

    def run(self):
        """Process data of all nodes at the pace of SYNC, until they are switched on."""
        for node in self.nodes:
            node.nmt.send_command(1)
            node.rpdo[1].start(CYCLE)
        self.network.sync.start(CYCLE)
        for node in self.nodes:
            node.state = "SWITCHED ON"
        for node in self.nodes:
            node.state = "OPERATION ENABLED"

    def reset(self):
        """Of all nodes. @return whether all of them have told that they are there again, within 5 s"""
        self.booted.clear()
        self.network.nmt.send_command(0x81)
        self.pause()
        end = time.monotonic() + 5.0
        while time.monotonic() < end and len(self.booted) < len(self.nodes):
            time.sleep(0.01)
        return len(self.booted) == len(self.nodes)

    def pause(self):
        self.network.sync.stop()
        for node in self.nodes:
            node.rpdo[1].stop()

    def enabled(self):
        return all(node.state == "OPERATION ENABLED" for node in self.nodes)

    def positions(self):
        return [node.tpdo[1][0x6064].raw for node in self.nodes]

    def move(self, increments, seconds):
        begin = [node.rpdo[1][0x607A].raw for node in self.nodes]
        steps = round(seconds / CYCLE)
        for i in range(1, steps + 1):
            share = i / steps
            smooth = share * share * (3.0 - 2.0 * share)
            for node, there in zip(self.nodes, begin):
                node.rpdo[1][0x607A].raw = there + round(smooth * increments)
            time.sleep(CYCLE)
        time.sleep(5 * CYCLE)

    def close(self):
        self.pause()
        self.network.disconnect()


class Drives(unittest.TestCase):
    def emulate(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        file = pathlib.Path(folder.name) / "cell.json"
        file.write_text(json.dumps({"devices": {"arm": {"model": "tx90"}}, "program": {"do": "wait", "seconds": 1}}))
        process = subprocess.Popen([TAKT, "emulate", str(file), "--backend", f"arm=cia402:127.0.0.1:{port},bridged_cycles=50"],
                                   stderr=subprocess.PIPE, text=True, cwd=ROOT)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.assertTrue(process.stderr.readline(), "it has ended")
        return process, port

    def attempt(self):
        """Moves the arm, resets its nodes in operation, and moves it again. @return whether the master kept its pace"""
        process, port = self.emulate()
        master = Master(port)
        try:
            for _ in range(2):
                for node in master.nodes:
                    master.set_up(node)
                master.run()
                before = master.positions()
                increments = 200_000  # 0.012 rad
                master.move(increments, 0.5)
                if not master.enabled():
                    return False
                for there, here in zip(before, master.positions()):
                    self.assertAlmostEqual(here - there, increments, delta=0.02 * increments)
                self.assertTrue(master.reset())
        except (RuntimeError, canopen.SdoCommunicationError) as late:  # a time-out of the library
            print(late, file=sys.stderr)
            return False
        finally:
            master.close()
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 0, errors)
        return True

    def test_a_master_with_one_message_per_direction_moves_the_arm_and_again_after_a_reset_of_its_nodes(self):
        self.assertTrue(any(self.attempt() for _ in range(TRIES)), "no try in which the master kept its pace")


if __name__ == "__main__":
    unittest.main()
