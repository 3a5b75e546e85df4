# SPDX-License-Identifier: Apache-2.0
"""The take-over of a pressure, and what happens when nobody is heard."""

import pytest
from ros.control_bench import LIMITS, TICK, WRAP, Bench
from ros.fakes import RegulatorFault

from spiral_gripper_ros.control.limits import FaultPolicy, TimeoutPolicy
from spiral_gripper_ros.control.states import Reason, State


@pytest.fixture
def restarted():
    """A bench that starts again while 40 kPa are held."""
    bench = Bench()
    bench.regulator.pressure = 4.0e4
    bench.control.activate(take_over=True)
    return bench


def agree(bench, *pressures, radius=None):
    """Measure and command for longer than it takes to agree; return what is commanded."""
    commands = []
    for step in range(14):
        bench.now += TICK
        bench.control.offer_measured(bench.now, pressures[step % len(pressures)])
        if radius is not None:
            bench.radius(radius)
        command = bench.control.command(bench.now)
        commands += [] if bench.control.is_silent else [command]
    return commands


@pytest.mark.parametrize("held", [0.0, 10.0, 4.0e4])
def test_a_pressure_that_agrees_is_the_first_command_and_stands(restarted, held):
    bench, taken = restarted, held if held > LIMITS.pressure_tolerance else 0.0
    assert bench.grasp().reason is Reason.TAKEN_OVER  # nothing starts before it is known
    assert not bench.radius(0.02)
    assert set(agree(bench, held)) == {taken}
    assert bench.state is (State.TAKEN_OVER if taken else State.WAITING)
    assert {bench.control.command(bench.now + TICK * step) for step in range(100)} == {taken}
    assert not bench.seen.wrapped


@pytest.mark.parametrize("fault", [RegulatorFault.LOST, RegulatorFault.NAN])
def test_without_a_possible_pressure_it_starts_from_zero_after_the_time_out(restarted, fault):
    restarted.regulator.fault = fault
    for _ in range(round(5.0 / TICK) - 2):  # longer than measured_pressure.timeout
        restarted.tick()
        assert restarted.control.is_silent
    assert restarted.run(0.1)[-1] == 0.0
    assert (restarted.state, restarted.control.is_silent) == (State.WAITING, False)


def test_three_stalls_do_not_end_the_wait_for_a_pressure(restarted):
    restarted.is_measured = False
    restarted.follow("leap 10; wait 0.02; leap 10; wait 0.02; leap 10; wait 0.02")
    assert restarted.control.is_silent
    assert agree(restarted, 4.0e4)[-1] == 4.0e4


@pytest.mark.parametrize(
    ("pressures", "why"),
    [
        ((2.5e5,), "above pressure.cap"),
        ((101325.0,), "absolute"),
        ((-101325.0,), "below 0"),
        ((0.0, 6.275e4), "agree"),
        ((0.0,) * 5 + (6.275e4,) * 5, "agree"),
    ],
)
def test_readings_that_cannot_be_held_or_disagree_are_waited_out_and_then_taken_over(
    restarted, pressures, why
):
    for _ in range(50):  # for far longer than all time-outs
        assert not agree(restarted, *pressures)
    assert restarted.reason is Reason.TAKEN_OVER
    assert why in restarted.seen.refusal.text
    assert agree(restarted, 4.0e4)[-1] == 4.0e4
    assert restarted.state is State.TAKEN_OVER


@pytest.mark.parametrize("end", ["call release", "call deactivate", "call fail broken"])
def test_a_pressure_that_was_measured_once_is_waited_for_until_something_vents(restarted, end):
    restarted.tick()
    restarted.is_measured = False
    restarted.run(20.0)
    assert restarted.control.is_silent
    restarted.follow(end)
    state = restarted.state
    assert not restarted.control.is_silent
    assert set(agree(restarted, 4.0e4)) == {0.0}
    assert restarted.state is state


@pytest.mark.parametrize(
    ("limits", "state", "reason"),
    [
        ({"radius_timeout": 0.5}, State.VENTED, Reason.RADIUS_STALE),
        ({"keep_alive_timeout": 0.5}, State.RELEASED, Reason.CLIENT_LOST),
        ({"gravity_timeout": 0.5}, State.FAULT, Reason.GRAVITY_STALE),
    ],
)
def test_silence_vents_but_a_stall_is_no_silence_of_what_has_come_meanwhile(limits, state, reason):
    policies = {"radius": TimeoutPolicy.VENT, "gravity": FaultPolicy.VENT}
    named = {f"{name}_timeout_policy": policy for name, policy in policies.items()}
    bench = Bench(**{"radius_timeout": 600.0} | limits | named)
    bench.is_measured = False

    def speak():
        bench.radius(0.02)
        bench.control.keep_alive(bench.now)
        bench.control.hear_gravity(bench.now)

    for _ in range(100):
        speak()
        bench.tick()
    for _ in range(3):  # the timer comes first, then what has waited
        bench.now += 1.2
        assert bench.tick() == WRAP
        speak()
    assert bench.run(0.48)[-1] == WRAP
    assert bench.run(0.04)[-1] == 0.0
    assert (bench.state, bench.reason) == (state, reason)


def test_gravity_grows_stale_and_is_reported(bench):
    bench.follow("limit gravity_timeout=2; track")
    assert bench.seen.gravity_age is None
    bench.control.hear_gravity(bench.now, age=0.5)
    bench.follow("call deactivate; leap 1; call activate; wait 0.02")
    assert bench.seen.gravity_age == pytest.approx(1.5, abs=2.0 * TICK)  # as old as it is
    assert bench.seen.gravity_fault.reason is Reason.NONE
    bench.run(1.0, radius=0.02)
    assert (bench.seen.gravity_fault.reason, bench.reason) == (Reason.GRAVITY_STALE, Reason.NONE)
    bench.control.forget_gravity()
    bench.tick()
    assert bench.seen.gravity_fault.reason is Reason.NONE
