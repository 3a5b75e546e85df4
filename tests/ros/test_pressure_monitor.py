# SPDX-License-Identifier: Apache-2.0
import math
import random
from collections.abc import Iterable
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiral_gripper_ros.control.command_envelope import PARTS, CommandEnvelope
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.pressure_monitor import (
    HIGHEST_PRESSURE,
    LOWEST_PRESSURE,
    MOST_SAMPLES,
    PERSISTENCE,
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


class Bench:
    """A monitor, a command and a clock; a command and a message every 10 ms."""

    def __init__(self, command=5.0e4):
        self.monitor = PressureMonitor()
        self.limits = LIMITS
        self.now = 10.0
        self.command = command

    def run(self, duration, pressure=None):
        """Return the faults that were there, in order, each once in a row.

        Args:
            pressure: one, or one after another, or a function of time; None: no message.
        """
        faults = []
        for number in range(round(duration / PERIOD)):
            self.now += PERIOD
            self.monitor.check(self.now, self.limits)
            self.monitor.commanded(self.now, self.command, self.limits)
            value = pressure(self.now) if callable(pressure) else pressure
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
    """A bench whose measured pressure has been what is commanded for a second."""
    bench = Bench()
    assert bench.run(1.0, bench.command) == [Reason.NONE]
    return bench


def test_without_any_message_nothing_is_measured_and_nothing_is_wrong():
    bench = Bench()
    assert bench.run(5.0) == [Reason.NONE]
    assert bench.monitor.measured(bench.now) is None


def test_the_measured_pressure_is_smoothed_and_has_an_age(bench):
    bench.run(1.0, (4.98e4, 5.02e4))
    measured = bench.monitor.measured(bench.now + 0.25)
    assert measured.pressure == pytest.approx(5.0e4, abs=20.0)
    assert measured.age == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("factor", "reason"), [(0.7, Reason.PRESSURE_LOW), (1.3, Reason.PRESSURE_HIGH)]
)
def test_a_pressure_that_stays_off_the_command_is_a_fault_until_it_is_back(bench, factor, reason):
    assert bench.run(1.0, factor * bench.command) == [Reason.NONE, reason]
    assert f"{factor * bench.command:.6g} Pa" in bench.monitor.fault.text
    assert "pressure.tolerance 1000 Pa" in bench.monitor.fault.text
    assert bench.run(1.0, bench.command) == [reason, Reason.NONE]


def test_a_short_excursion_is_no_fault(bench):
    assert bench.run(0.5 * PERSISTENCE, 3.0e4) == [Reason.NONE]
    assert bench.run(1.0, bench.command) == [Reason.NONE]


def test_a_difference_within_the_tolerance_is_no_fault(bench):
    assert bench.run(2.0, bench.command - 999.0) == [Reason.NONE]
    assert bench.run(2.0, bench.command + 999.0) == [Reason.NONE]


def test_noise_is_no_fault_and_does_not_hide_one(bench):
    noise = random.Random(1)
    assert bench.run(10.0, lambda now: noise.gauss(bench.command, 800.0)) == [Reason.NONE]
    assert bench.run(1.0, lambda now: noise.gauss(4.0e4, 800.0))[-1] is Reason.PRESSURE_LOW


def test_at_the_boundary_the_fault_does_not_chatter(bench):
    noise = random.Random(1)
    boundary = bench.command - LIMITS.pressure_tolerance
    assert len(bench.run(60.0, lambda now: noise.gauss(boundary, 200.0))) <= 2
    assert bench.run(5.0, [boundary - 50.0] * 15 + [boundary + 50.0] * 15)[1:] == []


def test_a_pressure_that_was_off_is_back_well_within_the_tolerance(bench):
    bench.run(1.0, bench.command - 1100.0)
    assert bench.run(1.0, bench.command - 900.0) == [Reason.PRESSURE_LOW]
    assert bench.run(1.0, bench.command - 700.0)[-1] is Reason.NONE
    assert bench.run(1.0, bench.command - 900.0) == [Reason.NONE]


def test_while_the_command_ramps_a_lag_is_no_fault():
    bench = Bench(command=0.0)
    faults = bench.run(1.0, 0.0)
    for step in range(100):
        bench.command = 500.0 * step
        faults += bench.run(PERIOD, max(0.0, bench.command - 500.0 * 25))
    assert set(faults) == {Reason.NONE}


def test_a_vent_may_take_the_settling_time_and_no_longer(bench):
    bench.command = 0.0
    until = bench.now + LIMITS.pressure_settle_time
    assert bench.run(2.0, lambda now: 5.0e4 if now < until else 0.0) == [Reason.NONE]
    bench.command = 5.0e4
    bench.run(2.0, 5.0e4)
    bench.command = 0.0
    assert bench.run(0.3, 5.0e4) == [Reason.NONE]
    assert bench.run(0.3, 5.0e4) == [Reason.NONE, Reason.PRESSURE_HIGH]
    assert "does not vent" in bench.monitor.fault.text


def test_a_vented_sensor_at_the_airs_pressure_looks_absolute():
    bench = Bench(command=0.0)
    assert bench.run(1.0, 101325.0)[-1] is Reason.PRESSURE_HIGH
    assert (
        "looks like an absolute pressure: measured_pressure must be gauge"
        in bench.monitor.fault.text
    )
    bench.command = 5.0e4
    bench.run(1.0, 5.0e4)
    assert bench.run(1.0, 101325.0)[-1] is Reason.PRESSURE_HIGH
    assert "absolute" not in bench.monitor.fault.text


def test_what_was_in_force_before_the_first_command_is_not_known():
    bench = Bench(command=0.0)
    decaying = 3.0e4
    assert bench.run(LIMITS.pressure_settle_time, decaying) == [Reason.NONE]
    assert bench.run(1.0, 0.0) == [Reason.NONE]
    monitor = PressureMonitor()
    for step in range(100):
        monitor.offer(0.01 * step, 3.0e4, LIMITS)
    assert monitor.fault.reason is Reason.NONE
    assert monitor.measured(1.0).pressure == 3.0e4


def test_messages_that_stop_are_lost_after_the_timeout_and_found_again(bench):
    assert bench.run(0.49, None) == [Reason.NONE]
    assert bench.monitor.measured(bench.now) is not None
    assert bench.run(0.03, None) == [Reason.NONE, Reason.PRESSURE_LOST]
    assert bench.monitor.measured(bench.now) is None
    assert "measured_pressure.timeout" in bench.monitor.fault.text
    assert bench.run(PERSISTENCE, bench.command) == [Reason.PRESSURE_LOST]
    assert bench.run(0.1, bench.command) == [Reason.PRESSURE_LOST, Reason.NONE]


def test_a_sensor_slower_than_the_timeout_stays_lost(bench):
    message = [bench.command] + [None] * 99
    bench.run(1.0, message)
    assert bench.run(20.0, message) == [Reason.PRESSURE_LOST]


def test_a_slow_sensor_within_the_timeout_is_judged_by_what_was_commanded_when_it_spoke(bench):
    for command in (2.0e4, 5.0e4, 3.0e4, 6.0e4):
        bench.command = command
        assert bench.run(0.4, None) == [Reason.NONE]
        assert bench.run(PERIOD, command) == [Reason.NONE]


@pytest.mark.parametrize(
    "pressure",
    [
        math.nan,
        math.inf,
        -math.inf,
        math.nextafter(LOWEST_PRESSURE, -math.inf),
        math.nextafter(HIGHEST_PRESSURE, math.inf),
    ],
)
def test_an_impossible_pressure_is_dropped_with_the_reason(bench, pressure):
    refusal = bench.monitor.offer(bench.now, pressure, LIMITS)
    assert refusal.reason is Reason.PRESSURE_INVALID
    assert "measured_pressure must be a gauge pressure from -101325 to 1e+07 Pa" in refusal.text
    assert bench.monitor.measured(bench.now).pressure == pytest.approx(bench.command)
    assert bench.fault is Reason.NONE


def test_a_vacuum_is_a_pressure():
    monitor = PressureMonitor()
    assert monitor.offer(0.0, LOWEST_PRESSURE, LIMITS) is None
    assert monitor.offer(0.0, HIGHEST_PRESSURE, LIMITS) is None


def test_impossible_messages_among_good_ones_are_no_fault(bench):
    assert bench.run(5.0, (math.nan, math.nan, bench.command)) == [Reason.NONE]


def test_impossible_messages_do_not_hide_a_leak(bench):
    assert bench.run(1.0, (math.nan, 3.0e4))[-1] is Reason.PRESSURE_LOW


def test_a_stream_of_impossible_messages_is_invalid_and_then_lost(bench):
    assert bench.run(1.0, math.nan) == [Reason.NONE, Reason.PRESSURE_INVALID, Reason.PRESSURE_LOST]
    assert "last refused: measured_pressure must be" in bench.monitor.fault.text
    assert bench.run(1.0, math.nan) == [Reason.PRESSURE_LOST]
    assert bench.run(1.0, bench.command) == [Reason.PRESSURE_LOST, Reason.NONE]


def test_after_impossible_messages_good_ones_must_come_for_a_while(bench):
    assert bench.run(0.3, math.nan)[-1] is Reason.PRESSURE_INVALID
    assert bench.run(0.9 * PERSISTENCE, bench.command) == [Reason.PRESSURE_INVALID]
    assert bench.run(0.1, bench.command)[-1] is Reason.NONE


def test_a_sensor_that_never_says_anything_possible_is_lost_too():
    assert Bench().run(1.0, math.nan)[-1] is Reason.PRESSURE_LOST


def test_a_burst_of_late_messages_is_no_fault(bench):
    bench.command = 4.0e4
    bench.run(0.2, None)
    for _ in range(1000):
        bench.monitor.offer(bench.now, 5.0e4, LIMITS)
    assert bench.run(1.0, bench.command) == [Reason.NONE]


def test_a_stalled_process_hears_what_waits_before_it_calls_it_lost(bench):
    bench.now += 60.0
    bench.monitor.check(bench.now, LIMITS)
    bench.monitor.check(bench.now, LIMITS)
    assert bench.fault is Reason.NONE
    assert bench.run(1.0, bench.command) == [Reason.NONE]


@pytest.mark.parametrize("stall", [0.3, 0.7, 60.0])
def test_three_stalls_in_a_row_are_no_lost_pressure(bench, stall):
    bench.run(1.0, bench.command)
    for _ in range(3):
        bench.now += stall
        bench.monitor.check(bench.now, LIMITS)
        assert bench.fault is Reason.NONE
    assert bench.run(1.0, bench.command) == [Reason.NONE]
    assert bench.run(0.55, None)[-1] is Reason.PRESSURE_LOST


def test_stalls_that_let_a_message_through_may_go_on_for_ever(bench):
    for _ in range(100):
        bench.now += 0.7
        bench.monitor.check(bench.now, LIMITS)
        bench.monitor.offer(bench.now, bench.command, LIMITS)
        assert bench.fault is Reason.NONE


def test_forgetting_it_all_needs_a_new_first_message(bench):
    bench.run(1.0, math.nan)
    bench.monitor.forget()
    assert bench.run(5.0, None) == [Reason.NONE]
    assert bench.monitor.measured(bench.now) is None


def test_limits_that_change_count_at_once(bench):
    bench.run(1.0, 4.0e4)
    assert bench.fault is Reason.PRESSURE_LOW
    bench.limits = replace(LIMITS, pressure_tolerance=2.0e4)
    assert bench.run(1.0, 4.0e4) == [Reason.PRESSURE_LOW, Reason.NONE]


def test_hours_of_a_thousand_messages_a_second_take_little_memory():
    monitor = PressureMonitor()
    limits = replace(LIMITS, pressure_settle_time=60.0)
    for step in range(100_000):
        now = 0.001 * step
        monitor.commanded(now, float(step % 5000), limits)
        monitor.offer(now, float(step % 5000), limits)
    assert len(monitor._samples) <= MOST_SAMPLES
    assert len(monitor._envelope._parts) <= PARTS + 2


def test_a_clock_that_stands_still_takes_no_memory_either():
    monitor = PressureMonitor()
    for window in (0.0, 1.0):
        limits = replace(LIMITS, pressure_settle_time=window)
        for step in range(1000):
            monitor.commanded(1.0, float(step), limits)
            monitor.offer(1.0, float(step), limits)
    assert len(monitor._samples) <= MOST_SAMPLES
    assert len(monitor._envelope._parts) <= 2


COMMANDS = st.lists(
    st.tuples(st.floats(0.001, 0.5), st.floats(0.0, 1.0e5)), min_size=1, max_size=60
)


@given(commands=COMMANDS, window=st.sampled_from([0.0, 0.1, 1.0]))
def test_the_envelope_holds_every_command_of_the_window_and_little_more(commands, window):
    envelope, now, history = CommandEnvelope(), 0.0, []
    for wait, command in commands:
        now += wait
        envelope.add(now, command, window)
        history.append((now, command))
    low, high = envelope.bounds(now, window)
    if now - history[0][0] < window:
        assert (low, high) == (-math.inf, math.inf)
        return

    def in_force(since):
        later = [command for time, command in history if time > since]
        return [[command for time, command in history if time <= since][-1], *later]

    longest = window * (1.0 + 1.0 / PARTS) + max(wait for wait, _ in commands) + 1e-9
    least, most = in_force(now - window), in_force(max(now - longest, history[0][0]))
    assert low <= min(least)
    assert max(least) <= high
    assert min(most) <= low
    assert high <= max(most)


def test_the_envelope_knows_a_dip_between_two_commands_of_one_part():
    envelope = CommandEnvelope()
    for now, command in ((0.0, 5.0e4), (0.01, 1.0e4), (0.02, 4.0e4)):
        envelope.add(now, command, window=1.0)
    assert envelope.bounds(1.0, window=1.0) == (1.0e4, 5.0e4)
