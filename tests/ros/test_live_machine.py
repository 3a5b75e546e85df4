# SPDX-License-Identifier: Apache-2.0
"""Random sequences against a real node process: messages, goals, parameters, transitions, services.

Hypothesis generates them and does not shrink: a live node is not deterministic to the millisecond.
``make fuzz`` runs the long form.
"""

import itertools
import math
import sys

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from lifecycle_msgs.msg import State as LifecycleState
from rclpy.action import ActionClient
from ros.harness import Client, RunningNode, all_finite
from std_msgs.msg import Float64
from visualization_msgs.msg import MarkerArray

from spiral_gripper import load_gripper
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.control.target import LONGEST_STEP
from spiral_gripper_ros.parameters.table import PARAMETERS

pytestmark = pytest.mark.slow

GRIPPER = "paper_design_70"
RATE = 2.0e6  # [Pa/s], as Client.restore() sets it; no operation raises it
STEPS = 40

anything = st.floats(allow_nan=True, allow_infinity=True)
radii = st.one_of(anything, st.floats(0.003, 0.05), st.sampled_from([0.011, 0.02, 0.03]))
pressures = st.one_of(anything, st.floats(-2.0e3, 1.2e5))
vectors = st.one_of(
    st.tuples(anything, anything, anything),
    st.sampled_from([(9.80665, 0.0, 0.0), (0.0, 9.80665, 0.0), (-9.80665, 0.0, 0.0)]),
)
SETTABLE = [spec for spec in PARAMETERS if not spec.read_only and "rate_" not in spec.name]
odd_values = st.one_of(
    anything, st.integers(-5, 5000), st.booleans(), st.text(max_size=8), st.sampled_from([[1.0]])
)


@st.composite
def parameters(draw):
    """A parameter with a value that may be right or of any other kind."""
    spec = draw(st.sampled_from(SETTABLE))
    good = [st.just(spec.default if spec.default != () else [0.0, 0.0, -9.80665])]
    if spec.choices:
        good.append(st.sampled_from(spec.choices))
    elif isinstance(spec.default, float) and spec.name != "publish.rate":
        good.append(st.floats(spec.low, spec.high))
    elif spec.name == "gripper":
        good.append(st.sampled_from(["prototype_p1", "prototype_p2", GRIPPER]))
    return spec.name, draw(st.one_of(*good, odd_values))


OPERATIONS = st.one_of(
    st.tuples(st.just("radius"), radii),
    st.tuples(st.just("radius"), st.sampled_from([0.02, 0.0201])),
    st.tuples(st.just("measured"), pressures),
    st.tuples(st.just("gravity"), vectors),
    st.tuples(st.just("parameter"), parameters()),
    st.tuples(
        st.just("goal"),
        st.tuples(
            st.integers(0, 3),
            radii,
            st.lists(pressures, max_size=1),
            st.lists(anything, max_size=1),
            st.integers(0, 255),
        ),
    ),
    st.tuples(
        st.just("goal"),
        st.tuples(
            st.just(Grasp.Goal.MODE_RADIUS),
            st.just(0.02),
            st.just([]),
            st.just([1.0]),
            st.integers(0, 2),
        ),
    ),
    st.tuples(st.just("cancel"), st.none()),
    st.tuples(st.sampled_from(["release", "rearm"]), st.none()),
    st.tuples(
        st.just("transition"),
        st.sampled_from(["configure", "activate", "activate", "deactivate", "cleanup"]),
    ),
    st.tuples(st.just("plan"), st.tuples(radii, pressures)),
    st.tuples(st.just("wait"), st.floats(0.0, 0.1)),
)


class Fuzzer(Client):
    """A client that also measures, grasps and listens to everything."""

    def __init__(self, namespace):
        super().__init__(namespace)
        self.steps = 0
        self.seen = set()
        self._goals = []
        self._pressure = self.create_publisher(Float64, "measured_pressure", 1)
        self._grasp = ActionClient(self, Grasp, "grasp")
        self.others = []
        self.create_subscription(PoseArray, "measured_backbone", self.others.append, 10)
        self.create_subscription(MarkerArray, "markers", self.others.append, 10)
        self.create_subscription(DiagnosticArray, "/diagnostics", self.others.append, 10)

    def do(self, operation, value):
        """Do one step of a sequence, whatever the node makes of it."""
        self.steps += 1
        getattr(self, f"_do_{operation}")(value)
        self.spin(0.0)

    def _do_radius(self, value):
        self.send_radius(value)

    def _do_measured(self, value):
        self._pressure.publish(Float64(data=value))

    def _do_gravity(self, value):
        self.send_gravity(value)

    def _do_parameter(self, value):
        self.set_parameter(*value)

    def _do_goal(self, value):
        mode, figure, overpressure, timeout, policy = value
        goal = Grasp.Goal(
            mode=mode,
            object_radius=figure,
            pressure=1e6 * figure,
            overpressure=overpressure,
            timeout=timeout,
            abort_policy=policy,
        )
        self._goals.append(self._grasp.send_goal_async(goal))

    def _do_cancel(self, _):
        for future in self._goals[-3:]:
            if future.done() and future.result().accepted:
                future.result().cancel_goal_async()

    def _do_release(self, _):
        before = len(self.pressures)
        assert self.release().success
        # A goal on its way may grip again afterwards.
        self.wait_until(lambda: 0.0 in self.pressures[before:], "the vent of a release")

    def _do_rearm(self, _):
        self.rearm()

    def _do_transition(self, name):
        if self.transition(name) and name in ("deactivate", "cleanup"):
            self.wait_until(lambda: self.pressures[-1:] in ([], [0.0]), f"the vent of {name}")

    def _do_plan(self, value):
        radius, overpressure = value
        if self.lifecycle_state() != LifecycleState.PRIMARY_STATE_UNCONFIGURED:
            assert all_finite(self.plan_wrap(radius, overpressure=overpressure))

    def _do_wait(self, duration):
        self.spin(duration)

    def check(self):
        """Check everything that has been heard, and forget it."""
        self.spin(0.05)
        pressures, statuses = self.pressures, self.statuses
        assert all(map(math.isfinite, pressures))
        assert min(pressures, default=0.0) >= 0.0
        assert max(pressures, default=0.0) <= HIGHEST
        rises = [b - a for a, b in itertools.pairwise(pressures)]
        assert max(rises, default=0.0) <= RATE * LONGEST_STEP * (1 + 1e-9)
        assert all_finite(*statuses, *self.backbones, *self.others)
        self.seen |= {State(status.state) for status in statuses}
        for received in (pressures[:-1], statuses[:-1], self.backbones, self.others):
            received.clear()


HIGHEST = max(load_gripper(name).pressure_max for name in (GRIPPER, "prototype_p1", "prototype_p2"))


@pytest.fixture(scope="module")
def fuzzed():
    namespace = "/fuzzed"
    client = Fuzzer(namespace)
    with RunningNode(namespace) as node:
        client.wait_until_active()
        yield client, node
        assert node.stop() == 0, node.log()
        assert "Traceback" not in node.log(), node.log()
    client.close()


@pytest.mark.timeout(3600)
def test_whatever_comes_the_live_node_stays_safe_and_recovers(fuzzed, capsys):
    client, node = fuzzed
    is_long = settings.get_current_profile_name() == "fuzz"
    examples = 260 if is_long else 8

    @settings(
        max_examples=examples,
        phases=[Phase.generate],
        deadline=None,
        derandomize=not is_long,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(sequence=st.lists(OPERATIONS, min_size=STEPS, max_size=STEPS))
    def fuzz(sequence):
        client.restore()
        for operation, value in sequence:
            client.do(operation, value)
            assert node.running, node.log()
        client.check()
        client.restore()
        assert client.wrap(0.02).pressure_command > 0.0

    fuzz()
    assert client.steps >= examples * STEPS
    if is_long:
        assert client.steps >= 10_000
        with capsys.disabled():
            sys.stdout.write(f"\n{client.steps} steps of a live node\n")
    assert {State.TRACKING, State.HOLDING, State.RELEASED, State.GRASPING} <= client.seen
