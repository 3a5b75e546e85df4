# SPDX-License-Identifier: Apache-2.0
"""Node and simulator together, as two processes: the loop that a real gripper closes."""

import pytest
from ros.simulation_harness import RADIUS, Observer, closed_loop, seconds

from spiral_gripper_ros.control.states import Reason, State

PATIENT_NODE = {"radius.timeout": 600.0, "grasp.timeout": 600.0}
# A node that a busy machine holds up for a moment is not taken for a dead one.
PATIENT_REGULATOR = {"watchdog_timeout": 2.0}


@pytest.fixture(scope="module")
def shared_loop():
    """A node and a simulator that the tests here share."""
    namespace = "/simulated_loop"
    observer = Observer(namespace)
    node, simulator = closed_loop(namespace, PATIENT_NODE, PATIENT_REGULATOR)
    with node, simulator:
        observer.wait_until_active()
        observer.wait_for_simulator()
        yield observer
        assert node.stop() == 0, node.log()
        assert simulator.stop() == 0, simulator.log()
    observer.close()


@pytest.fixture
def loop(shared_loop):
    """The same, without a fault, holding the object."""
    shared_loop.inject("none")
    assert shared_loop.set_parameter("pressure.fault_policy", "report").successful
    if shared_loop.status.state in (State.RELEASED, State.FAULT):
        shared_loop.wait_until(lambda: shared_loop.rearm().success, "the end of a fault")
    shared_loop.wait_until(lambda: is_held(shared_loop), "the object to be held")
    shared_loop.forget()
    shared_loop.hear_more(1)
    return shared_loop


def is_held(loop):
    status = loop.status
    return (
        loop.grip == "perfect wrap"
        and status is not None
        and status.wrapped
        and status.measured_pressure
        and status.fault == Reason.NONE
    )


def wait_for_fault(loop, reason):
    loop.wait_until(lambda: loop.status is not None and loop.status.fault == reason, reason.name)
    assert loop.status.fault_text or reason is Reason.NONE


def wait_for_the_vent(loop):
    loop.wait_until(lambda: loop.true_pressure < 10.0, "the vent")


def test_the_object_is_wrapped_and_the_node_knows_it_from_what_is_measured(loop):
    def is_settled():
        status = loop.status
        pressures = (*status.measured_pressure, loop.true_pressure)
        return status.wrapped and all(abs(p - status.pressure_command) < 10.0 for p in pressures)

    loop.wait_until(is_settled, "real, measured and commanded pressure to be one")
    assert list(loop.status.object_radius) == pytest.approx([RADIUS], abs=1e-6)


def test_a_leak_is_noticed_as_a_low_pressure(loop):
    loop.inject("leak")
    wait_for_fault(loop, Reason.PRESSURE_LOW)
    loop.wait_until(lambda: not loop.status.wrapped and loop.grip == "overhang", "nothing is held")


def test_a_lost_link_is_noticed_and_the_regulator_vents_by_itself(loop):
    loop.inject("lost_link")
    wait_for_fault(loop, Reason.PRESSURE_LOST)
    wait_for_the_vent(loop)
    loop.inject("none")
    loop.wait_until(lambda: is_held(loop), "the end of the fault")


def test_a_link_that_comes_back_inflates_nothing_before_somebody_has_looked(loop):
    assert loop.set_parameter("pressure.fault_policy", "vent").successful
    loop.inject("lost_link")
    loop.wait_for_state(State.FAULT, Reason.PRESSURE_LOST)
    loop.inject("none")
    wait_for_fault(loop, Reason.NONE)
    wait_for_the_vent(loop)
    assert max(loop.next_true_pressures(10)) < 10.0
    assert loop.rearm().success
    loop.wait_until(lambda: is_held(loop), "the object to be held")


def test_a_stuck_valve_is_noticed_when_it_should_vent(loop):
    loop.inject("stuck_valve")
    before = loop.next_true_pressures()
    assert loop.release().success
    wait_for_fault(loop, Reason.PRESSURE_HIGH)
    loop.wait_until(lambda: loop.status.pressure_command == 0.0, "the command to vent")
    assert loop.next_true_pressures() == before
    assert min(before) > 3.0e4
    loop.inject("none")
    wait_for_the_vent(loop)
    wait_for_fault(loop, Reason.NONE)


def test_a_stuck_valve_is_noticed_when_it_should_fill(loop):
    assert loop.release().success
    wait_for_the_vent(loop)
    loop.inject("stuck_valve")
    assert loop.rearm().success
    wait_for_fault(loop, Reason.PRESSURE_LOW)


@pytest.mark.slow
def test_everything_runs_in_simulated_time(namespace):
    observer = Observer(namespace)
    own_time = {**PATIENT_REGULATOR, "publish_clock": "true", "real_time_factor": 4.0}
    node, simulator = closed_loop(namespace, {**PATIENT_NODE, "use_sim_time": "true"}, own_time)
    with node, simulator:
        observer.wait_until(lambda: is_held(observer), "the object to be held")
        stamp = seconds(observer.status.header.stamp)
        assert stamp > 0.0
        # A machine's clock would be decades ahead.
        observer.wait_until(
            lambda: observer.clocks and seconds(observer.clocks[-1].clock) >= stamp,
            "the same clock",
        )
        assert node.stop() == simulator.stop() == 0
    observer.close()
