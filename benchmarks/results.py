# SPDX-License-Identifier: Apache-2.0
"""What a section of the benchmark gives: tables to read, and values for goals and JSON."""

from __future__ import annotations

from dataclasses import dataclass, field

MEGABYTE = 1024.0**2


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is measured: repeats of short and long calls, sizes of samples, peers to ask."""

    short: int = 2000
    long: int = 300
    batch: int = 1000
    rods: int = 10_000
    questions: int = 20_000
    contacts: int = 2000
    closings: int = 1000
    grips: int = 1000
    collocation_rods: int = 60
    starts: int = 5
    simulated: float = 4.0
    compile_anew: bool = True
    peers: tuple[str, ...] = ("pyelastica", "mujoco")


SMOKE = Effort(
    short=3,
    long=2,
    batch=64,
    rods=6,
    questions=100,
    contacts=2,
    closings=1,
    grips=1,
    collocation_rods=1,
    starts=1,
    simulated=0.01,
    compile_anew=False,
    peers=(),
)


@dataclass(frozen=True, slots=True)
class Table:
    """Cells are texts, ready to be shown."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


@dataclass(frozen=True, slots=True)
class Section:
    """Tables, and figures by name (times in seconds)."""

    tables: tuple[Table, ...]
    values: dict[str, float] = field(default_factory=dict)


def micro(seconds: float) -> str:
    """Return a time in microseconds, to three digits."""
    return f"{three_digits(seconds * 1e6)} µs"


def milli(seconds: float) -> str:
    """Return a time in milliseconds, to three digits."""
    return f"{three_digits(seconds * 1e3)} ms"


def three_digits(value: float) -> str:
    """Return a positive number to three significant digits, without an exponent."""
    if value >= 100.0:
        return f"{value:.0f}"
    return f"{value:.1f}" if value >= 10.0 else f"{value:.2f}"
