# SPDX-License-Identifier: Apache-2.0
"""Node and simulator together, as two processes: the loop that a real gripper closes."""

import pytest
from ros.simulation_harness import (
    RADIUS,
    Observer,
    RunningSimulator,
    closed_loop,
    seconds,
)

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
    assert loop.status.fault_text


def test_the_object_is_wrapped_and_the_node_knows_it_from_what_is_measured(loop):
    def settled():
        status = loop.status
        if status is None:
            return False
        command = status.pressure_command
        return status.wrapped and all(
            abs(p - command) < 10.0 for p in (*status.measured_pressure, loop.true_pressure)
        )

    loop.wait_until(settled, "real, measured and commanded pressure to be one")
    assert list(loop.status.object_radius) == pytest.approx([RADIUS], abs=1e-6)


def test_a_leak_is_noticed_as_a_low_pressure(loop):
    loop.inject("leak")
    wait_for_fault(loop, Reason.PRESSURE_LOW)
    loop.wait_until(
        lambda: not loop.status.wrapped and loop.grip == "overhang",
        "the node to see that nothing is held",
    )
    loop.inject("none")
    loop.wait_until(lambda: is_held(loop), "the end of the fault")


def test_a_lost_link_is_noticed_and_the_regulator_vents_by_itself(loop):
    loop.inject("lost_link")
    wait_for_fault(loop, Reason.PRESSURE_LOST)
    loop.wait_until(lambda: loop.true_pressure < 10.0, "the watchdog's vent")
    loop.inject("none")
    loop.wait_until(lambda: is_held(loop), "the end of the fault")


def test_a_link_that_comes_back_inflates_nothing_before_somebody_has_looked(loop):
    assert loop.set_parameter("pressure.fault_policy", "vent").successful
    loop.inject("lost_link")
    loop.wait_for_state(State.FAULT, Reason.PRESSURE_LOST)
    loop.inject("none")
    loop.wait_until(lambda: loop.status.fault == Reason.NONE, "the link")
    loop.wait_until(lambda: loop.true_pressure < 10.0, "the vent")
    loop.truths.clear()
    loop.wait_until(lambda: len(loop.truths) > 10, "the truth")
    assert max(message.data for message in loop.truths) < 10.0
    assert loop.rearm().success
    loop.wait_until(lambda: is_held(loop), "the object to be held")


def test_a_stuck_valve_is_noticed_when_it_should_vent(loop):
    loop.inject("stuck_valve")
    before = loop.next_true_pressure()
    assert loop.release().success
    wait_for_fault(loop, Reason.PRESSURE_HIGH)
    loop.wait_until(lambda: loop.status.pressure_command == 0.0, "the command to vent")
    assert before > 3.0e4
    assert loop.next_true_pressure() == before
    loop.inject("none")
    loop.wait_until(lambda: loop.true_pressure < 10.0, "the vent")
    loop.wait_until(lambda: loop.status.fault == Reason.NONE, "the end of the fault")


def test_a_stuck_valve_is_noticed_when_it_should_fill(loop):
    assert loop.release().success
    loop.wait_until(lambda: loop.true_pressure < 10.0, "the vent")
    loop.inject("stuck_valve")
    assert loop.rearm().success
    wait_for_fault(loop, Reason.PRESSURE_LOW)


def test_a_stopped_estimator_leaves_the_object_held(loop):
    held = loop.pressures[-1]
    loop.set_simulated("radius_source", dropout_probability=1.0)
    loop.wait_for_silence(loop.radii, loop.truths, "the estimator to stop")
    loop.pressures.clear()
    loop.hear_more()
    assert set(loop.pressures) == {held}
    loop.wait_until(lambda: is_held(loop), "the object to be held")
    loop.set_simulated("radius_source", dropout_probability=0.0)


@pytest.mark.slow
def test_an_uncalibrated_gripper_does_not_hold_what_the_node_believes_it_holds(namespace):
    observer = Observer(namespace)
    node, simulator = closed_loop(namespace, PATIENT_NODE, {"stiffness_factor": 1.5})
    with node, simulator:
        observer.wait_until_active()
        observer.wait_for_simulator()
        observer.wait_until(
            lambda: observer.status.wrapped and observer.grip == "overhang", "the disagreement"
        )
    observer.close()


@pytest.mark.slow
def test_everything_runs_in_simulated_time(namespace):
    observer = Observer(namespace)
    # No radius before the node is heard: discovery takes DDS up to three seconds, the ramp less.
    simulated = {
        **PATIENT_REGULATOR,
        "publish_clock": "true",
        "real_time_factor": 4.0,
        "dropout_probability": 1.0,
    }
    node, simulator = closed_loop(
        namespace, {**PATIENT_NODE, "use_sim_time": "true", "pressure.rate_up": 2.0e4}, simulated
    )
    with node, simulator:
        observer.wait_until_active()
        observer.wait_for_simulator()
        observer.wait_until(lambda: observer.clocks, "the clock")
        observer.set_simulated("radius_source", dropout_probability=0.0)
        observer.wait_until(lambda: is_held(observer), "the object to be held")
        ramp = [
            (seconds(status.header.stamp), status.pressure_command)
            for status in observer.statuses
            if 0.0 < status.pressure_command < status.pressure_target
        ]
        (first, low), (last, high) = ramp[0], ramp[-1]
        # 57 kPa at 20 kPa/s: most of three seconds, on the simulated clock.
        assert last - first > 1.0
        assert high - low <= 2.0e4 * (last - first) + 1.0
        assert seconds(observer.clocks[0].clock) <= first
        # A machine's clock would be decades ahead.
        observer.wait_until(lambda: seconds(observer.clocks[-1].clock) >= last, "the same clock")
        assert node.stop() == 0, node.log()
        assert simulator.stop() == 0, simulator.log()
    observer.close()


@pytest.mark.slow
def test_the_simulator_lives_in_the_time_of_somebody_elses_clock(namespace):
    master, slave = Observer(f"{namespace}/master"), Observer(f"{namespace}/slave")
    with (
        RunningSimulator(f"{namespace}/master", {"publish_clock": "true"}) as clock,
        RunningSimulator(f"{namespace}/slave", {"use_sim_time": "true"}),
    ):
        slave.wait_for_simulator()
        master.wait_for_simulator()
        stamp = seconds(slave.shapes[-1].header.stamp)
        # A machine's clock would be decades ahead.
        master.wait_until(lambda: seconds(master.shapes[-1].header.stamp) >= stamp, "the same time")
        # Its time stands still when the clock does.
        assert clock.stop() == 0, clock.log()
        slave.spin(0.3)
        slave.measured.clear()
        slave.spin(0.5)
        assert slave.measured == []
    for observer in (master, slave):
        observer.close()
