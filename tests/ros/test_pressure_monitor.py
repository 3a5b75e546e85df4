# SPDX-License-Identifier: Apache-2.0
"""The measured pressure compared with the commands: what is a fault, from when, until when."""

import math
import pickle
import random
from collections.abc import Iterable
from dataclasses import replace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from ros.control_bench import rows

from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.pressure_monitor import (
    HIGHEST_PRESSURE,
    LOWEST_PRESSURE,
    PARTS,
    CommandEnvelope,
    PressureMonitor,
)
from spiral_gripper_ros.control.states import Reason

LIMITS = Limits(
    pressure_cap=1.0e5,
    measured_pressure_timeout=0.5,
    pressure_settle_time=0.3,
    pressure_tolerance=1.0e3,
)
PERIOD = 0.01
NONE, LOW, HIGH = Reason.NONE, Reason.PRESSURE_LOW, Reason.PRESSURE_HIGH
LOST, INVALID = Reason.PRESSURE_LOST, Reason.PRESSURE_INVALID


class Bench:
    """A monitor and a clock; a command and a message every 10 ms."""

    def __init__(self):
        self.monitor = PressureMonitor()
        self.limits = LIMITS
        self.now = 10.0

    def run(self, command, duration, pressure=None):
        """Return the faults that were there, in order, each once in a row.

        Args:
            command: in force [Pa].
            duration: of all this [s].
            pressure: one, or one after another, or a function without arguments; None: no message.
        """
        faults = []
        for number in range(round(duration / PERIOD)):
            self.now += PERIOD
            self.monitor.check(self.now, self.limits)
            self.monitor.commanded(self.now, command, self.limits)
            value = pressure() if callable(pressure) else pressure
            if isinstance(value, Iterable):
                value = value[number % len(value)]
            if value is not None:
                self.monitor.offer(self.now, value, self.limits)
            if not faults or faults[-1] is not self.fault:
                faults.append(self.fault)
        return faults

    @property
    def fault(self):
        return self.monitor.fault.reason


@pytest.fixture
def bench():
    """A bench whose measured pressure has been what is commanded, 50 kPa, for a second."""
    bench = Bench()
    assert bench.run(5.0e4, 1.0, 5.0e4) == [NONE]
    return bench


# Command, duration, measured pressure ("-": no message; several: one after the other), and the
# faults that are there meanwhile.
COURSES = """
5e4 1 3.5e4 NONE LOW; 5e4 1 5e4 LOW NONE
5e4 1 6.5e4 NONE HIGH; 5e4 1 5e4 HIGH NONE
5e4 0.1 3e4 NONE; 5e4 1 5e4 NONE
5e4 2 49001 NONE; 5e4 2 50999 NONE
5e4 1 48900 NONE LOW; 5e4 1 49100 LOW; 5e4 1 49300 LOW NONE; 5e4 1 49100 NONE
0 0.3 5e4 NONE; 0 0.3 5e4 NONE HIGH
0 0.3 5e4 NONE; 0 2 0 NONE
5e4 0.49 - NONE; 5e4 0.03 - NONE LOST; 5e4 0.2 5e4 LOST; 5e4 0.1 5e4 LOST NONE
2e4 0.4 - NONE; 2e4 0.01 2e4 NONE; 5e4 0.4 - NONE; 5e4 0.01 5e4 NONE; 3e4 0.4 - NONE
5e4 5 nan,nan,5e4 NONE
5e4 1 nan,3e4 NONE LOW
5e4 1 nan NONE INVALID LOST; 5e4 1 5e4 LOST NONE
5e4 0.3 nan NONE INVALID; 5e4 0.18 5e4 INVALID; 5e4 0.1 5e4 INVALID NONE
"""
REASONS = {"NONE": NONE, "LOW": LOW, "HIGH": HIGH, "LOST": LOST, "INVALID": INVALID}
# A ramp whose lag takes nearly the settling time; a sensor slower than the time-out.
RAMP = "; ".join(f"{5e4 - 500 * i} 0.01 {5e4 - 500 * max(i - 25, 0)} NONE" for i in range(100))
SLOW = f"5e4 1 5e4{',-' * 99} NONE LOST; 5e4 20 5e4{',-' * 99} LOST"


@pytest.mark.parametrize("course", [*rows(COURSES), RAMP, SLOW])
def test_a_pressure_is_a_fault_once_it_stays_off_the_commands_until_it_is_back(bench, course):
    for step in course.split("; "):
        command, duration, pressures, *expected = step.split()
        told = [None if one == "-" else float(one) for one in pressures.split(",")]
        found = bench.run(float(command), float(duration), told)
        assert found == [REASONS[name] for name in expected], step


@pytest.mark.parametrize(("command", "is_told"), [(0.0, True), (5.0e4, False)])
def test_a_vented_sensor_at_the_airs_pressure_looks_absolute(bench, command, is_told):
    bench.run(command, 1.0, command)
    assert bench.run(command, 1.0, 101325.0) == [NONE, HIGH]
    assert ("looks like an absolute pressure" in bench.monitor.fault.text) is is_told


def test_noise_is_no_fault_does_not_hide_one_and_does_not_make_it_chatter(bench):
    noise = random.Random(1)
    assert bench.run(5.0e4, 10.0, lambda: noise.gauss(5.0e4, 800.0)) == [NONE]
    assert bench.run(5.0e4, 1.0, lambda: noise.gauss(4.0e4, 800.0)) == [NONE, LOW]
    assert len(bench.run(5.0e4, 60.0, lambda: noise.gauss(4.9e4, 200.0))) <= 2
    assert len(bench.run(5.0e4, 5.0, [4.895e4] * 15 + [4.905e4] * 15)) == 1


def test_without_any_message_nothing_is_measured_and_nothing_is_wrong(bench):
    bench.run(5.0e4, 1.0, (4.98e4, 5.02e4))
    measured = bench.monitor.measured(bench.now + 0.25)
    assert measured.pressure == pytest.approx(5.0e4, abs=20.0)
    assert measured.age == pytest.approx(0.25)
    bench.run(5.0e4, 1.0)
    assert bench.monitor.measured(bench.now) is None
    bench.monitor.forget()
    assert bench.run(5.0e4, 5.0) == [NONE]
    bench.monitor.forget()
    assert bench.run(5.0e4, 1.0, math.nan)[-1] is LOST  # nothing possible was ever said
    bench.monitor.forget()  # and what was in force before the first command is not known
    assert bench.run(0.0, LIMITS.pressure_settle_time, 3.0e4) == [NONE]


def test_an_impossible_pressure_is_dropped(bench):
    for bound in (LOWEST_PRESSURE, HIGHEST_PRESSURE):
        for pressure in (math.nan, bound * math.inf, math.nextafter(bound, 9.0 * bound)):
            assert bench.monitor.offer(bench.now, pressure, LIMITS).reason is INVALID
        assert bench.monitor.measured(bench.now).pressure == pytest.approx(5.0e4)
    assert bench.monitor.offer(bench.now, LOWEST_PRESSURE, LIMITS) is None
    assert bench.monitor.offer(bench.now, HIGHEST_PRESSURE, LIMITS) is None


def test_a_burst_of_late_messages_is_no_fault(bench):
    bench.run(4.0e4, 0.2)
    for _ in range(1000):
        bench.monitor.offer(bench.now, 5.0e4, LIMITS)
    assert bench.run(4.0e4, 1.0, 4.0e4) == [NONE]


@pytest.mark.parametrize("stall", [0.3, 60.0])
def test_stalls_in_a_row_are_no_lost_pressure_if_what_waits_is_heard(bench, stall):
    for stalls in (3, *[1] * 100):
        for _ in range(stalls):
            bench.now += stall
            bench.monitor.check(bench.now, LIMITS)
            bench.monitor.check(bench.now, LIMITS)
            assert bench.fault is NONE
        bench.monitor.offer(bench.now, 5.0e4, LIMITS)
    assert bench.run(5.0e4, 1.0, 5.0e4) == [NONE]
    assert bench.run(5.0e4, 0.55)[-1] is LOST


@pytest.mark.parametrize(("period", "window"), [(0.001, 60.0), (0.0, 0.0), (0.0, 1.0)])
def test_hours_of_messages_at_any_rate_take_little_memory(period, window):
    monitor, limits = PressureMonitor(), replace(LIMITS, pressure_settle_time=window)
    for step in range(20_000):
        monitor.commanded(period * step, float(step % 5000), limits)
        monitor.offer(period * step, float(step % 5000), limits)
    assert len(pickle.dumps(monitor)) < 5000


@example([(0.01, 5.0e4), (0.01, 1.0e4), (0.01, 4.0e4), (0.97, 4.0e4)], 1.0)  # a short dip
@given(
    commands=st.lists(
        st.tuples(st.floats(0.001, 0.5), st.floats(0.0, 1.0e5)), min_size=1, max_size=60
    ),
    window=st.sampled_from([0.0, 0.1, 1.0]),
)
def test_the_envelope_holds_every_command_of_the_window_and_little_more(commands, window):
    envelope, now, history = CommandEnvelope(), 0.0, []
    for pause, command in commands:
        now += pause
        envelope.add(now, command, window)
        history.append((now, command))
    low, high = envelope.bounds(now, window)
    if now - history[0][0] < window:
        assert (low, high) == (-math.inf, math.inf)
        return

    def in_force(since):
        later = [command for time, command in history if time > since]
        return [[command for time, command in history if time <= since][-1], *later]

    longest = window * (1.0 + 1.0 / PARTS) + max(pause for pause, _ in commands) + 1e-9
    first = history[0][0]
    least, most = in_force(max(now - window, first)), in_force(max(now - longest, first))
    assert min(most) <= low <= min(least)
    assert max(least) <= high <= max(most)
