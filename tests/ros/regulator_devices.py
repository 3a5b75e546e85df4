# SPDX-License-Identifier: Apache-2.0
"""Simulated devices for the adapter: one on a pseudo-terminal, one with Modbus TCP."""

import asyncio
import os
import pty
import select
import threading
import time
import tty
from typing import NamedTuple

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from spiral_gripper_ros.regulators.line_protocol import LineBuffer, check_sum


class SetPoint(NamedTuple):
    """What the adapter sends, as the device reads it."""

    sequence: int
    number: float
    watchdog_ms: int


def set_point_from_line(line):
    """Return the set-point of a line, or None if its check sum is wrong."""
    body, _, check = line.decode("ascii", errors="replace").rpartition("*")
    if check != check_sum(body):
        return None
    kind, sequence, number, watchdog = body.split()
    assert kind == "S"
    return SetPoint(int(sequence), float(number), int(watchdog))


def measurement_line(sequence, number, state):
    """Return a device's answer as it is sent."""
    body = f"M {sequence} {'-' if number is None else format(number, '.3f')} {state}"
    return f"{body}*{check_sum(body)}\n".encode("ascii")


class LineDevice:
    """What a microcontroller does, as the protocol says: answers good lines, vents without them.

    Its pressure follows a set-point at once, but after a vent of its own only from 0 on.

    Attributes:
        heard: every message that was taken.
        has_vented: whether it waits for a set-point of 0; set it as a restart does.
        mode: "": good; "mute": hears nothing; "garbage", "old", "high", "refused": answers so.
    """

    def __init__(self):
        self._controller, self._device = pty.openpty()
        tty.setraw(self._device)
        self.port = os.ttyname(self._device)
        self.heard, self.mode, self._good_until, self.running = [], "", 0.0, True
        self.has_vented = True
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def pressure(self):
        return 0.0 if self.waits else self.heard[-1].number

    @property
    def waits(self):
        return self.has_vented or time.monotonic() >= self._good_until

    def close(self):
        """Unplug it."""
        if self.running:
            self.running = False
            self._thread.join()
            os.close(self._controller)
            os.close(self._device)

    def _run(self):
        buffer = LineBuffer()
        while self.running:
            if select.select([self._controller], [], [], 0.01)[0]:
                for line in buffer.lines(os.read(self._controller, 1000)):
                    message = set_point_from_line(line)
                    if message and self.mode != "mute":
                        self._hear(message)

    def _hear(self, message):
        if self.mode != "refused":
            self.has_vented = self.waits and message.number != 0.0
            self._good_until = time.monotonic() + 1.0e-3 * message.watchdog_ms
            self.heard.append(message)
        number = 2.0e7 if self.mode == "high" else self.pressure
        state = "watchdog" if self.has_vented else "ok"
        state = "refused" if self.mode == "refused" else state
        answer = measurement_line(message.sequence, number, state)
        old = measurement_line((message.sequence - 1) % 65536, 1.0, "ok")
        answers = {"garbage": bytes(range(128, 256)) * 4 + answer[:-5] + b"0000\n", "old": old}
        good = b"\x00\xff boot message\r\n" + old + answer.replace(b"\n", b"\r\n")
        os.write(self._controller, answers.get(self.mode, good))


class ModbusServer:
    """A Modbus TCP server on this machine, with 100 registers.

    Attributes:
        registers: what they hold, as read by clients; they may be overwritten.
        written: each write of a client: (first register, values).
        fault: "refuses": it answers with an exception of the protocol.
        delay: time before each answer [s].
    """

    def __init__(self, port=0):
        self.port, self.registers, self.written = port, {}, []
        self.fault, self.delay = "", 0.0
        self._loop, ready = asyncio.new_event_loop(), threading.Event()
        self._thread = threading.Thread(target=self._run, args=(ready,), daemon=True)
        self._thread.start()
        assert ready.wait(60.0)

    def close(self):
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._server.serving.set_result, True)
            self._thread.join(60.0)
            self._loop.close()

    def _run(self, ready):
        async def serve():
            registers = SimData(0, count=100, datatype=DataType.REGISTERS)
            device = SimDevice(1, [registers], action=self._act)
            self._server = ModbusTcpServer(device, address=("127.0.0.1", self.port))
            await self._server.serve_forever(background=True)
            self.port = self._server.transport.sockets[0].getsockname()[1]
            ready.set()
            await self._server.serving
            self._server.close()
            await asyncio.sleep(0.05)

        self._loop.run_until_complete(serve())

    async def _act(self, function, start, address, count, registers, values):
        await asyncio.sleep(self.delay)
        if self.fault == "refuses":
            return ExcCodes.DEVICE_FAILURE
        own = range(address, address + count)
        if values:
            self.written.append((address, list(values)))
            self.registers.update(zip(own, values, strict=True))
        for register in own:
            registers[register - start] = self.registers.get(register, 0)
        return None
