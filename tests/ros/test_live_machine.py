# SPDX-License-Identifier: Apache-2.0
"""Random sequences against a real node process: messages, goals, parameters, transitions, services.

Hypothesis generates them and does not shrink: a live node is not deterministic to the millisecond.
``make fuzz`` runs the long form.
"""

import itertools

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from lifecycle_msgs.msg import State as LifecycleState
from rclpy.action import ActionClient
from ros.harness import Client, RunningNode, all_finite
from ros.test_control_machine import FLOATS, RADII
from visualization_msgs.msg import MarkerArray

from spiral_gripper import load_gripper
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.control.target import LONGEST_STEP
from spiral_gripper_ros.parameters.table import PARAMETERS

pytestmark = pytest.mark.slow

GRIPPERS = ("paper_design_70", "prototype_p1", "prototype_p2")
HIGHEST = max(load_gripper(name).pressure_max for name in GRIPPERS)
RATE = 2.0e6  # [Pa/s], as Client.restore() sets it; no operation raises it

anything, radii = FLOATS, RADII.filter(lambda radius: radius is not None)
pressures = anything | st.floats(-2.0e3, 1.2e5)
gravities = st.tuples(*[anything] * 3) | st.permutations([9.80665, 0.0, 0.0])
odd_values = anything | st.integers(-5, 5000) | st.booleans() | st.text(max_size=8)
SETTABLE = [spec for spec in PARAMETERS if not spec.read_only and "rate_" not in spec.name]
GOALS = st.just(Grasp.Goal(object_radius=0.02, timeout=[1.0])) | st.builds(
    Grasp.Goal,
    mode=st.integers(0, 3),
    object_radius=radii,
    pressure=pressures,
    overpressure=st.lists(pressures, max_size=1),
    timeout=st.lists(anything, max_size=1),
    abort_policy=st.integers(0, 255),
)


def values(spec):
    """Return what draws a value that may be right or of any other kind."""
    good = [spec.default if spec.default != () else [0.0, 0.0, -9.80665], *spec.choices]
    drawn = st.sampled_from(good + list(GRIPPERS) * (spec.name == "gripper")) | odd_values
    if isinstance(spec.default, float) and spec.name != "publish.rate":
        drawn |= st.floats(spec.low, spec.high)
    return st.tuples(st.fixed_dictionaries({spec.name: drawn}))


def grasp(client, goal):
    client.goals.append(client.action.send_goal_async(goal))


def cancel(client):
    for future in client.goals[-3:]:
        if future.done() and future.result().accepted:
            future.result().cancel_goal_async()


def release(client):
    before = len(client.pressures)
    assert client.release().success
    # A goal on its way may grip again afterwards.
    client.wait_until(lambda: 0.0 in client.pressures[before:], "the vent of a release")


def transition(client, name):
    if client.transition(name) and name in ("deactivate", "cleanup"):
        client.wait_until(lambda: client.pressures[-1:] in ([], [0.0]), f"the vent of {name}")


def plan(client, radius, overpressure):
    if client.lifecycle_state() != LifecycleState.PRIMARY_STATE_UNCONFIGURED:
        assert all_finite(client.plan_wrap(radius, overpressure=overpressure))


NAMES = ["configure", "activate", "activate", "deactivate", "cleanup"]
# What can be done with a client, and what draws its arguments.
OPERATIONS = {
    Client.send_radius: st.tuples(radii),
    Client.send_measured: st.tuples(pressures),
    Client.send_gravity: st.tuples(gravities),
    Client.set_parameters: st.sampled_from(SETTABLE).flatmap(values),
    grasp: st.tuples(GOALS),
    cancel: st.just(()),
    release: st.just(()),
    Client.rearm: st.just(()),
    transition: st.tuples(st.sampled_from(NAMES)),
    plan: st.tuples(radii, pressures),
    Client.spin: st.tuples(st.floats(0.0, 0.1)),
}
STEP = st.one_of([st.tuples(st.just(act), drawn) for act, drawn in OPERATIONS.items()])


@pytest.mark.timeout(3600)
def test_whatever_comes_the_live_node_stays_safe_and_recovers():
    is_long = settings.get_current_profile_name() == "fuzz"
    client, seen, markers = Client("/fuzzed"), set(), []
    client.goals, client.action = [], ActionClient(client, Grasp, "grasp")
    client.create_subscription(MarkerArray, "markers", markers.append, 10)
    client.create_subscription(DiagnosticArray, "/diagnostics", markers.append, 10)

    @settings(
        max_examples=260 if is_long else 8,
        phases=[Phase.generate],
        deadline=None,
        derandomize=not is_long,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(sequence=st.lists(STEP, min_size=40, max_size=40))
    def fuzz(sequence):
        client.restore()
        for act, arguments in sequence:
            act(client, *arguments)
            client.spin()
            assert node.running, node.log()
        client.spin(0.05)
        commands = client.pressures
        assert all(0.0 <= pressure <= HIGHEST for pressure in commands)
        rises = [b - a for a, b in itertools.pairwise(commands)]
        assert max(rises, default=0.0) <= RATE * LONGEST_STEP * (1 + 1e-9)
        assert all_finite(*client.heard.values(), *markers)
        seen.update(State(status.state) for status in client.statuses)
        markers.clear()
        client.restore()
        held = client.wrap(0.02).pressure_command
        client.send_radius(0.2)
        assert client.wait_for_state(State.HOLDING).pressure_command == held > 0.0

    with RunningNode("/fuzzed") as node:
        client.wait_until_active()
        fuzz()
        assert node.stop() == 0, node.log()
        assert "Traceback" not in node.log(), node.log()
    client.close()
    assert {State.RELEASED, State.GRASPING} <= seen
