# SPDX-License-Identifier: Apache-2.0
"""The measured pressure compared with the commands: what is a fault, from when, until when."""

import math
import pickle
import random
from bisect import bisect_right
from dataclasses import replace
from itertools import cycle, groupby, islice

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from ros.control_bench import rows, value

from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.pressure_monitor import (
    PARTS,
    CommandEnvelope,
    PressureMonitor,
)

LIMITS = Limits(
    pressure_cap=1.0e5,
    measured_pressure_timeout=0.5,
    pressure_settle_time=0.3,
    pressure_tolerance=1.0e3,
)


class Bench:
    """A monitor and a clock; a command and a message every 10 ms."""

    def __init__(self):
        self.monitor, self.now = PressureMonitor(), 10.0

    def run(self, command, duration, *pressures):
        """Return the faults that were there, in order, each once in a row.

        Args:
            command: in force [Pa].
            duration: of all this [s].
            pressures: one after another, again and again [Pa]; None: no message.
        """
        faults = []
        for pressure in islice(cycle(pressures), round(duration / 0.01)):
            self.now += 0.01
            self.monitor.check(self.now, LIMITS)
            self.monitor.commanded(self.now, command, LIMITS)
            if pressure is not None:
                self.monitor.offer(self.now, pressure, LIMITS)
            faults.append(self.fault)
        return [fault for fault, _ in groupby(faults)]

    @property
    def fault(self):
        return self.monitor.fault.reason.name.removeprefix("PRESSURE_")


@pytest.fixture
def bench():
    """A bench whose measured pressure has been what is commanded, 50 kPa, for a second."""
    bench = Bench()
    assert bench.run(5.0e4, 1.0, 5.0e4) == ["NONE"]
    return bench


# Command, duration, measured pressure (none: no message; several: one after the other), and the
# faults that are there meanwhile. After "forget" what was in force is not known.
COURSES = """
5e4 1 3.5e4 NONE LOW; 5e4 1 5e4 LOW NONE
5e4 1 6.5e4 NONE HIGH; 5e4 1 5e4 HIGH NONE
5e4 0.1 3e4 NONE; 5e4 1 5e4 NONE
5e4 2 49001 NONE; 5e4 2 50999 NONE
5e4 1 48900 NONE LOW; 5e4 1 49100 LOW; 5e4 1 49300 LOW NONE; 5e4 1 49100 NONE
0 0.3 5e4 NONE; 0 0.3 5e4 NONE HIGH
0 0.3 5e4 NONE; 0 2 0 NONE
5e4 0.49 none NONE; 5e4 0.03 none NONE LOST; 5e4 0.2 5e4 LOST; 5e4 0.1 5e4 LOST NONE
2e4 0.4 none NONE; 2e4 0.01 2e4 NONE; 5e4 0.4 none NONE; 5e4 0.01 5e4 NONE; 3e4 0.4 none NONE
5e4 5 nan,nan,5e4 NONE
5e4 1 nan,3e4 NONE LOW
5e4 1 nan NONE INVALID LOST; 5e4 1 5e4 LOST NONE
5e4 0.3 nan NONE INVALID; 5e4 0.18 5e4 INVALID; 5e4 0.1 5e4 INVALID NONE
5e4 1 inf NONE INVALID LOST
5e4 1 -101325.01 NONE INVALID LOST
5e4 1 10000000.01 NONE INVALID LOST
5e4 1 -101325 NONE LOW
5e4 1 1e7 NONE HIGH
5e4 1 none NONE LOST; forget; 5e4 5 none NONE; 5e4 1 nan NONE INVALID LOST
forget; 0 0.3 3e4 NONE; 0 0.3 3e4 NONE HIGH
"""
# A ramp whose lag takes nearly the settling time; a sensor slower than the time-out.
RAMP = "; ".join(f"{5e4 - 500 * i} 0.01 {5e4 - 500 * max(i - 25, 0)} NONE" for i in range(100))
SLOW = f"5e4 1 5e4{',none' * 99} NONE LOST; 5e4 20 5e4{',none' * 99} LOST"


@pytest.mark.parametrize("course", [*rows(COURSES), RAMP, SLOW])
def test_a_pressure_is_a_fault_once_it_stays_off_the_commands_until_it_is_back(bench, course):
    for step in course.split("; "):
        if step == "forget":
            bench.monitor.forget()
            continue
        command, duration, pressures, *expected = step.split()
        told = map(value, pressures.split(","))
        assert bench.run(float(command), float(duration), *told) == expected, step


@pytest.mark.parametrize(("period", "silence"), [(0.02, 0.25), (0.2, 0.3), (2.0, 3.0)])
def test_a_silence_is_one_if_it_is_longer_than_the_sensor_usually_waits(period, silence):
    monitor = PressureMonitor()
    assert not monitor.misses(0.0, 0.25)
    for step in range(5):
        monitor.offer(step * period, 5.0e4, LIMITS)
        assert step == 0 or not monitor.misses((step + 0.99) * period, 0.25)
    last = 4 * period
    assert not monitor.misses(last + 0.99 * silence, 0.25)
    assert monitor.misses(last + 1.01 * silence, 0.25)


def test_a_vented_sensor_at_the_airs_pressure_looks_absolute(bench):
    for command in (5.0e4, 0.0):
        assert bench.run(command, 1.0, command)[-1] == "NONE"
        assert bench.run(command, 1.0, 101325.0) == ["NONE", "HIGH"]
        looks = "looks like an absolute pressure" in bench.monitor.fault.text
        assert looks is (command == 0.0)


def test_noise_is_no_fault_does_not_hide_one_and_does_not_make_it_chatter(bench):
    noise = random.Random(1)

    def noisy(duration, mean, deviation):
        readings = [noise.gauss(mean, deviation) for _ in range(6000)]
        return bench.run(5.0e4, duration, *readings)

    assert noisy(10.0, 5.0e4, 800.0) == ["NONE"]
    assert noisy(1.0, 4.0e4, 800.0) == ["NONE", "LOW"]
    assert len(noisy(60.0, 4.9e4, 200.0)) <= 2
    assert len(bench.run(5.0e4, 5.0, *[4.895e4] * 15, *[4.905e4] * 15)) == 1


def test_what_is_measured_is_smoothed(bench):
    bench.run(5.0e4, 1.0, 4.98e4, 5.02e4, math.nan, 1.0e8)
    assert bench.monitor.measured == pytest.approx(5.0e4, abs=20.0)
    assert bench.monitor.age(bench.now + 0.25) == pytest.approx(0.27)  # of what was believed
    bench.run(5.0e4, 1.0, None)
    assert bench.monitor.measured is bench.monitor.age(bench.now) is None


def test_a_burst_of_late_messages_is_no_fault(bench):
    bench.run(4.0e4, 0.2, None)
    for _ in range(1000):
        bench.monitor.offer(bench.now, 5.0e4, LIMITS)
    assert bench.run(4.0e4, 1.0, 4.0e4) == ["NONE"]


@pytest.mark.parametrize("stall", [0.3, 60.0])
def test_stalls_in_a_row_are_no_lost_pressure_if_what_waits_is_heard(bench, stall):
    for stalls in (3, *[1] * 100):
        for _ in range(stalls):
            bench.now += stall
            for _ in range(2):
                bench.monitor.check(bench.now, LIMITS)
        assert bench.fault == "NONE"
        bench.monitor.offer(bench.now, 5.0e4, LIMITS)
    assert bench.run(5.0e4, 1.0, 5.0e4) == ["NONE"]
    assert bench.run(5.0e4, 0.55, None)[-1] == "LOST"


@pytest.mark.parametrize(("period", "window"), [(0.001, 60.0), (0.0, 0.0), (0.0, 1.0)])
def test_hours_of_messages_at_any_rate_take_little_memory(period, window):
    monitor, limits = PressureMonitor(), replace(LIMITS, pressure_settle_time=window)
    for step in range(20_000):
        for hear in (monitor.commanded, monitor.offer):
            hear(period * step, float(step % 5000), limits)
    assert len(pickle.dumps(monitor)) < 5000


@example([(0.01, 5.0e4), (0.01, 1.0e4), (0.01, 4.0e4), (0.97, 4.0e4)], 1.0)  # a short dip
@given(
    commands=st.lists(
        st.tuples(st.floats(0.001, 0.5), st.floats(0.0, 1.0e5)), min_size=1, max_size=60
    ),
    window=st.sampled_from([0.0, 0.1, 1.0]),
)
def test_the_envelope_holds_every_command_of_the_window_and_little_more(commands, window):
    envelope, now, times = CommandEnvelope(), 0.0, []
    for pause, command in commands:
        now += pause
        envelope.add(now, command, window)
        times.append(now)
    low, high = envelope.bounds(now, window)
    if now - times[0] < window:
        assert low == -math.inf
        assert high == math.inf
        return

    def in_force(since):
        first = max(bisect_right(times, since) - 1, 0)
        return [command for _, command in commands[first:]]

    longest = window * (1.0 + 1.0 / PARTS) + max(pause for pause, _ in commands) + 1e-9
    least, most = in_force(now - window), in_force(now - longest)
    assert min(most) <= low <= min(least)
    assert max(least) <= high <= max(most)
