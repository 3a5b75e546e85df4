# SPDX-License-Identifier: Apache-2.0
r"""The line protocol of a regulator on a serial line, without the line.

ASCII, one message a line, ended by ``\n`` (``\r\n`` is accepted), each with a check sum::

    S <sequence> <set-point> <watchdog_ms>*<check>      adapter to device
    M <sequence> <measured> <state>*<check>             device to adapter, once per S

``sequence`` is an integer from 0 to 65535, which the answer repeats; numbers are decimal, in the
device's unit; ``measured`` is ``-`` where there is no transmitter. ``check`` is the CRC-16/CCITT-
FALSE (polynomial 0x1021, start 0xFFFF) of everything before the ``*``, as four hexadecimal digits.
``state`` is ``ok``, ``watchdog`` (it has vented by itself), ``refused`` (it does not take this
set-point) or ``fault``.

The device ignores lines whose check sum is wrong. It vents when it starts, and once no good line
has come for the ``watchdog_ms`` of the last one; then it stays vented and answers ``watchdog``
until a set-point is a vent.
"""

from __future__ import annotations

import binascii
import re
from typing import NamedTuple

SEQUENCE_END = 65536
# Longer than any line of the protocol: longer input without a line end is dropped.
LINE_LENGTH_MAX = 80
# Set-points with more digits are too long for a line.
NUMBERS = (-1.0e9, 1.0e9)
# What a device says of itself, and what is wrong then.
VENTED = "watchdog"
STATES = {
    "ok": "",
    VENTED: "the device has vented by its watchdog, or has just started",
    "refused": "the device refuses the set-point",
    "fault": "the device reports a fault",
}
_NUMBER = r"[+-]?\d+(?:\.\d*)?"
_MEASUREMENT = re.compile(rf"M (\d{{1,5}}) ({_NUMBER}|-) ({'|'.join(STATES)})")


class Measurement(NamedTuple):
    """What the device answers.

    Args:
        sequence: of the set-point that it answers.
        number: measured, in the device's unit; None: no transmitter.
        state: one of ``STATES``.
    """

    sequence: int
    number: float | None
    state: str


def check_sum(body: str) -> str:
    """Return the check sum of a line's body.

    Example:
        >>> check_sum("123456789")  # the published check value of CRC-16/CCITT-FALSE
        '29B1'
    """
    return f"{binascii.crc_hqx(body.encode('ascii'), 0xFFFF):04X}"


def set_point_line(sequence: int, number: float, watchdog_ms: int) -> bytes:
    r"""Return a set-point as it is sent.

    Args:
        sequence: 0 to 65535.
        number: set-point in the device's unit.
        watchdog_ms: how long it is good for [ms].

    Example:
        >>> set_point_line(7, 50000.0, 500)
        b'S 7 50000.000 500*D16A\n'
    """
    body = f"S {sequence} {number:.3f} {watchdog_ms}"
    return f"{body}*{check_sum(body)}\n".encode("ascii")


def measurement_from_line(line: bytes) -> Measurement | None:
    """Return the answer of a line, or None if it is none: garbage, NaN, a wrong check sum.

    Example:
        >>> measurement_from_line(b"M 7 49990.5 ok*0000") is None
        True
    """
    try:
        body, _, check = line.decode("ascii").rpartition("*")
    except UnicodeDecodeError:
        return None
    match = _MEASUREMENT.fullmatch(body)
    if match is None or check != check_sum(body) or int(match[1]) >= SEQUENCE_END:
        return None
    number = None if match[2] == "-" else float(match[2])
    return Measurement(int(match[1]), number, match[3])


class LineBuffer:
    r"""Cuts what arrives into lines; a line that does not end is dropped.

    Example:
        >>> buffer = LineBuffer()
        >>> buffer.lines(b"ab"), buffer.lines(b"c\r\nd")
        ([], [b'abc'])
    """

    def __init__(self) -> None:
        self._rest = b""

    def lines(self, received: bytes) -> list[bytes]:
        """Return the lines that are complete now."""
        *complete, self._rest = (self._rest + received).split(b"\n")
        if len(self._rest) > LINE_LENGTH_MAX:
            self._rest = b""
        return [line.rstrip(b"\r") for line in complete]

    def clear(self) -> None:
        """Forget what has come of a line that is not complete."""
        self._rest = b""
