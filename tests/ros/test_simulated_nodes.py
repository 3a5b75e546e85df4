# SPDX-License-Identifier: Apache-2.0
"""The simulator as a process: what it hears, publishes, serves, and how it starts and ends."""

import math
import signal

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from ros.harness import all_finite
from ros.simulation_harness import QUIET, RADIUS, REGULATOR, Observer, RunningSimulator, seconds
from std_msgs.msg import Float64

from spiral_gripper_ros.messages.qos import LATEST
from spiral_gripper_ros.simulation.main import main
from spiral_gripper_ros.simulation.radius_estimator import RadiusEstimator, RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters
from spiral_gripper_ros.simulation.simulated_gripper import SimulatedGripper

WRAP = 57.0e3


@pytest.fixture(scope="module")
def shared_observer():
    """A simulator in a time of its own, three times as fast, that the tests here share."""
    namespace = "/simulated_nodes"
    observer = Observer(namespace)
    parameters = {**QUIET, "radius": RADIUS, "publish_clock": "true", "real_time_factor": 3.0}
    with RunningSimulator(namespace, parameters) as simulator:
        observer.wait_for_simulator()
        yield observer
        assert simulator.stop() == 0, simulator.log()
        assert "Traceback" not in simulator.log()
    observer.close()


@pytest.fixture
def observer(shared_observer):
    """The same, vented, without a fault, with patience for slow machines."""
    shared_observer.inject("none")
    (result,) = shared_observer.set_simulated(REGULATOR, watchdog_timeout=60.0)
    assert result.successful
    settle(shared_observer, 0.0)
    return shared_observer


def settle(observer, pressure):
    observer.measured.clear()
    observer.command_until(
        pressure,
        lambda: observer.measured and abs(observer.pressure - pressure) < 1.0,
        f"{pressure} Pa",
    )


def test_the_measured_pressure_follows_the_command_with_the_lag_that_is_documented(observer):
    # Some seconds, in which a busy machine hears enough messages.
    observer.set_simulated(REGULATOR, time_constant=1.0)
    observer.command_until(4.0e4, lambda: observer.pressure > 3.0e4, "the pressure to rise")
    start = len(observer.measured)
    observer.wait_until(lambda: observer.pressure > 3.99e4, "most of the way")
    gaps = 4.0e4 - np.array([message.data for message in observer.measured[start:]])
    observer.set_simulated(REGULATOR, time_constant=0.1)
    # At 50 Hz each gap is exp(-0.02 s / 1 s) of the one before; a message may be lost on the way.
    periods = -np.diff(np.log(gaps)) / 0.02
    assert len(periods) >= 3
    assert np.allclose(periods, np.round(periods), rtol=1e-6, atol=1e-6)
    assert np.median(periods) == pytest.approx(1.0)


def test_silence_makes_the_watchdog_vent_and_the_diagnostics_say_so(observer):
    heard = []
    subscription = observer.create_subscription(DiagnosticArray, "/diagnostics", heard.append, 10)
    settle(observer, WRAP)
    observer.set_simulated(REGULATOR, watchdog_timeout=0.5)
    observer.wait_until(lambda: observer.pressure < 1.0, "the vent")

    def levels():
        own = f"/simulated_nodes/{REGULATOR}: regulator"
        return [s.level for message in heard for s in message.status if s.name == own]

    observer.wait_until(lambda: DiagnosticStatus.WARN in levels(), "the diagnostics")
    observer.destroy_subscription(subscription)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, 1.0e9])
def test_a_command_that_cannot_be_keeps_no_watchdog_quiet(observer, bad):
    settle(observer, WRAP)
    observer.set_simulated(REGULATOR, watchdog_timeout=0.5)
    observer.command_until(bad, lambda: observer.pressure < 1.0, "the vent")


def test_faults_come_and_go_by_their_services(observer):
    settle(observer, WRAP)
    observer.inject("leak")
    observer.command_until(WRAP, lambda: observer.pressure < 0.7 * WRAP, "the leak")
    observer.inject("stuck_valve")
    stuck = observer.next_true_pressure()
    observer.measured.clear()
    observer.command_until(0.0, lambda: len(observer.measured) > 20, "measurements")
    assert {message.data for message in observer.measured} == {stuck}
    observer.inject("lost_link")
    observer.wait_for_silence(observer.measured, observer.truths, "the link to be lost")
    observer.command_until(WRAP, lambda: len(observer.truths) > 40, "the truth")
    assert observer.measured == []
    observer.inject("none")
    observer.command_until(WRAP, lambda: observer.measured, "measurements")
    settle(observer, WRAP)


def test_a_fault_comes_at_once_by_its_parameter_and_a_bad_one_is_refused_with_the_reason(observer):
    settle(observer, WRAP)
    (good,) = observer.set_simulated(REGULATOR, fault="leak")
    assert good.successful
    observer.command_until(WRAP, lambda: observer.pressure < 0.7 * WRAP, "the leak")
    (bad,) = observer.set_simulated(REGULATOR, fault="typhoon")
    assert not bad.successful
    assert "one of none, leak, stuck_valve, lost_link" in bad.reason
    (low,) = observer.set_simulated(REGULATOR, time_constant=-1.0)
    assert not low.successful
    assert "time_constant out of range" in low.reason


def test_the_truth_is_told(observer, gripper):
    observer.command_until(WRAP, lambda: observer.grip == "perfect wrap", "the wrap")
    settle(observer, WRAP)
    assert observer.next_true_pressure() == pytest.approx(WRAP, abs=1.0)
    assert observer.true_radii[-1].data == RADIUS
    expected = SimulatedGripper(gripper).shape(WRAP).tip_position

    def told():
        tip = observer.shapes[-1].poses[-1].position
        # What is left of the way changes it by micrometers.
        return np.allclose((tip.x, tip.y, tip.z), expected, rtol=0.0, atol=1e-5)

    observer.wait_until(told, "the shape")
    assert all_finite(observer.truths[-1], observer.shapes[-1], observer.measured[-1])
    assert observer.shapes[-1].header.frame_id == "gripper_base"


def test_the_radii_are_estimated_with_the_errors_that_are_set_at_once(observer):
    observer.wait_until(lambda: observer.radii, "a radius")
    assert observer.radii[-1].data == RADIUS
    observer.set_simulated("radius_source", radius=0.01, estimate_bias=0.005)
    observer.wait_until(
        lambda: (
            observer.radii[-1].data == pytest.approx(0.015) and observer.true_radii[-1].data == 0.01
        ),
        "the bias",
    )
    observer.set_simulated("radius_source", nan_probability=1.0)
    observer.wait_until(lambda: math.isnan(observer.radii[-1].data), "a NaN")
    observer.set_simulated("radius_source", profile="none")
    observer.wait_until(lambda: observer.grip == "no object", "the object to go")
    observer.wait_for_silence(observer.radii, observer.truths, "the estimator to see nothing")
    observer.set_simulated(
        "radius_source", profile="constant", radius=RADIUS, estimate_bias=0.0, nan_probability=0.0
    )
    observer.wait_until(lambda: observer.radii and observer.radii[-1].data == RADIUS, "the object")


def test_its_clock_runs_in_even_steps_and_stamps_its_messages(observer):
    observer.clocks.clear()
    observer.wait_until(lambda: len(observer.clocks) > 100, "the clock")
    times = np.array([seconds(message.clock) for message in observer.clocks])
    steps = np.diff(times) / 0.01
    # Best effort: a tick may be lost on the way, but none comes twice or in between.
    assert np.allclose(steps, np.round(steps), atol=1e-6)
    assert steps.min() >= 0.999
    observer.shapes.clear()
    observer.wait_until(
        lambda: (
            {seconds(message.header.stamp) for message in observer.shapes}
            & {seconds(message.clock) for message in observer.clocks}
        ),
        "a shape at a time of the clock",
    )


def test_its_errors_follow_from_its_seed(namespace):
    alone = Observer(namespace)
    parameters = {"seed": 5, "estimate_rate": 100.0, "radius": RADIUS, "estimate_noise": 1e-4}
    with RunningSimulator(namespace, parameters):
        alone.wait_until(lambda: len(alone.radii) >= 100, "estimates")
    alone.close()
    estimator = RadiusEstimator(RadiusParameters(**parameters), RADIUS)
    expected = [estimate for second in range(1, 60) for estimate in estimator.estimates(second)]
    assert {message.data for message in alone.radii} <= set(expected)


def test_a_command_that_was_latched_before_it_came_is_not_followed(namespace):
    observer = Observer(namespace)
    latched = observer.create_publisher(Float64, "pressure_command", LATEST)
    latched.publish(Float64(data=WRAP))
    with RunningSimulator(namespace, {"watchdog_timeout": 60.0}):
        observer.wait_for_simulator()
        observer.wait_until(lambda: latched.get_subscription_count() >= 2, "the regulator")
        observer.truths.clear()
        observer.wait_until(lambda: len(observer.truths) > 10, "the truth")
        assert observer.true_pressure == 0.0
        latched.publish(Float64(data=WRAP))
        observer.wait_until(lambda: observer.true_pressure > 1.0e4, "a command that is new")
    observer.close()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_signal_ends_it_in_order(namespace, number):
    observer = Observer(namespace)
    with RunningSimulator(namespace) as simulator:
        observer.wait_for_simulator()
        assert simulator.stop(number) == 0, simulator.log()
        assert "Traceback" not in simulator.log()
    observer.close()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"falt": "leak"}, "did you mean fault?"),
        ({"fault": "typhoon"}, "one of none, leak"),
        ({"gripper": "no_such_gripper"}, "no gripper has this name"),
    ],
)
def test_a_start_that_cannot_be_ends_with_the_reason(client, namespace, parameters, message):
    with RunningSimulator(namespace, parameters) as simulator:
        client.wait_until(lambda: not simulator.running, "the end of the process")
        assert simulator.exit_code == 1
        assert message in simulator.log()
        assert "Traceback" not in simulator.log()


def test_help_tells_every_parameter(capsys):
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    specs = SimulatedRegulatorParameters.specs() + RadiusParameters.specs()
    assert all(f"  {spec.name} (" in text for spec in specs)
