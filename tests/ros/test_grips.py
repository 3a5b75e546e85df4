# SPDX-License-Identifier: Apache-2.0
"""What control loop, messages and clients make of grips."""

import math
import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from core.grip_cases import DOWN, figures, table_of
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from rclpy.parameter import Parameter
from ros.harness import all_finite, deliver, plan_request, serve, tick
from std_msgs.msg import Float64

from spiral_core import NotGrippableError, WrapCurve
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.grips import read_grips
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.actions.grasp import GraspServer
from spiral_gripper_ros.client.goals import result_of_wrap
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import vector_from_msg
from spiral_gripper_ros.messages.grip import grip_to_msg
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.runtime.runtime import Outputs
from spiral_gripper_ros.tools.commands import grip_lines

RUNTIME = "spiral_gripper_ros.runtime.runtime"


class KnownGrips:
    """A node in this process and its time; questions about grips are answered at once."""

    # The wrap begins, curls and is lost at these multiples of the tip criterion's pressure.
    onset, curling, loss = 0.98, 1.05, 1.3
    never = None  # radius that contact never wraps
    lost = ()  # radii of the table that are not held

    def __init__(self, namespace, patch):
        self.time, self.told, self.asked = 100.0, {}, []
        patch.setattr(f"{RUNTIME}.read_grips", self.table)
        self.node = GripperNode(namespace=namespace)
        self.runtime = self.node.runtime
        self.runtime.now = lambda: self.time
        self.runtime.outputs.publish = self.told.__setitem__
        self.runtime.background.grips = self
        self.runtime.background.solve_grip = self.solve
        self.set({"pressure.rate_up": 1.0e6, "radius.timeout": 600.0, "grip.ratio": 1.0})
        self.executor = self.node.executor = Mock()
        assert self.node.start()

    def table(self, description):
        radii, curve = (0.006, 0.018, 0.022, 0.035), WrapCurve(description.gripper)
        return table_of(radii, [None if r in self.lost else self.grip(curve, r) for r in radii])

    def grip(self, curve, radius):
        tip = curve.pressure_from_radius(radius)
        grip = figures(tip, curling=self.curling * tip, loss=self.loss * tip)
        return replace(grip, onset_wrap=self.onset * tip)

    def use(self, **multiples):
        """Load the gripper again, with a table of other windows."""
        vars(self).update(multiples)
        self.runtime.load()

    def set(self, values):
        self.node.set_parameters([Parameter(name, value=value) for name, value in values.items()])

    def submit(self, *question):
        with ThreadPoolExecutor() as pool:
            return pool.submit(*question)

    def shutdown(self, **options):
        pass

    def solve(self, question, is_wanted):
        self.asked.append(question)
        if question.radius == self.never:
            raise NotGrippableError(question.radius, "the tube passes by", 0.0, None)
        return self.grip(self.runtime.loaded.planner.curve, question.radius)

    def follow(self, radius, duration=0.7, **values):
        """Follow a radius for long enough that its own grip is solved."""
        self.set({f"grip.{name}": value for name, value in values.items()})
        for _ in range(round(duration / 0.02)):
            self.time += 0.02
            deliver(self.node, "object_radius", Float64(data=radius))
            tick(self.node)
        return self.runtime.control.snapshot()

    def turn(self, *gravity):
        self.set({"gravity.vector": gravity})
        self.runtime.background.gravity.submit(int).result()  # planned for

    def grasp(self, overpressure):
        goal, planner = GraspGoal(0.02, overpressure=overpressure), self.runtime.loaded.planner
        return self.runtime.control.start_grasp(self.time, goal, planner)

    def plan(self, **fields):
        """Return the answer of `plan_wrap` about an object of 20 mm."""
        return serve(self.node, "plan_wrap", plan_request([0.02], **fields)).plans[0]


@pytest.fixture
def known(namespace, monkeypatch):
    """Its table, in the shipped one's place, has the same answers."""
    monkeypatch.setattr(Outputs, "markers_are_wanted", True)
    known = KnownGrips(namespace, monkeypatch)
    yield known
    known.node.vent()
    known.node.destroy_node()


@pytest.mark.parametrize(
    ("onset", "curling", "ratio", "part"),
    [
        (0.98, 1.05, 1.2, 1.05),
        (1.02, 1.1, 1.0, 1.02),
        (0.8, 0.9, 1.0, 0.9),
        (0.98, 1.08, math.nan, 1.03),  # what the grip recommends
    ],
)
def test_the_pressure_lies_within_the_window(known, onset, curling, ratio, part):
    known.use(onset=onset, curling=curling)
    seen = known.follow(0.02, duration=0.02, ratio=ratio)  # the first command
    assert not known.asked
    assert seen.pressure_target == pytest.approx(part * seen.plan.wrap.pressure, rel=1e-3)
    assert known.plan().figures[0].pressure == seen.pressure_target
    assert known.follow(0.02).pressure_target == seen.pressure_target
    assert {question.rate for question in known.asked} == {1.0e6}  # of the node's ramp


def test_where_the_table_ends_the_grip_that_is_solved_decides(known):
    known.use(onset=1.15, curling=1.25)
    tip = known.runtime.loaded.planner.curve.pressure_from_radius(0.036)
    assert known.follow(0.036, 0.1, ratio=math.nan).pressure_target == pytest.approx(1.1 * tip)
    request = plan_request([0.036], compute_grip=True)
    (exact,) = serve(known.node, "plan_wrap", request).plans
    assert exact.figures[0].pressure == pytest.approx(1.2 * tip)
    seen = known.follow(0.036)
    assert seen.pressure_target == exact.figures[0].pressure
    assert known.follow(0.0361).pressure_target == pytest.approx(seen.pressure_target, rel=0.01)


def test_the_grip_that_is_known_is_told(known):
    seen = known.follow(0.02, ratio=1.2, payload=1.0)
    told = known.told["wrap"]
    (grip,) = told.grip
    assert seen.wrapped
    assert list(grip.onset_curling) == pytest.approx([seen.pressure_target])
    assert grip.holding_force_down[0] - grip.payload_margin[0] == pytest.approx(9.80665)
    assert told.plan[0].contact_length == grip.contact_length > 0.0
    report = SimpleNamespace(progress=1.0, elapsed=1.0, plan=None)
    feedback = GraspServer.told(known, Grasp.Feedback(), None, report)
    assert feedback.settling_time == grip.settling_time
    assert grip.settling_time[0] > 0.0
    assert all_finite(known.told["status"], told)


def test_an_object_that_is_seen_has_its_margin_in_the_region_of_capture(known, monkeypatch):
    asked, own = [], known.runtime.loaded.gripper
    region = Mock(is_for=lambda *closing: not asked.append(closing), margin=Mock(return_value=-0.1))
    monkeypatch.setattr(f"{RUNTIME}.read_regions", lambda _: (region,))
    known.runtime.load()
    pose = [Pose(position=Point(x=0.1), orientation=Quaternion(w=1.0))]
    found = known.plan(pose=pose, payload=0.02, friction_coefficient=0.4)
    region.margin.assert_called_once_with((0.1, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert list(found.capture_margin) == [-0.1]
    assert "it may be missed" in found.message
    assert asked == [(found.figures[0].pressure, 0.02, own.gravity, 0.4, 0.02)]
    region.margin.return_value = 0.1
    assert "it may be missed" not in known.plan(pose=pose).message
    assert not known.plan().capture_margin
    monkeypatch.setattr(f"{RUNTIME}.read_regions", lambda _: ())
    known.runtime.load()
    assert "pose is not judged" in known.plan(pose=pose).message
    assert "judged" not in known.plan(pose=pose, compute_grip=True).message + known.plan().message


def test_a_radius_that_contact_never_wraps_is_refused_once_that_is_known(known):
    held = known.follow(0.02, duration=0.4).pressure_command
    known.never = 0.02
    seen = known.follow(0.02)
    assert seen.state is State.HOLDING
    assert seen.refusal.reason is Reason.NOT_CERTIFIED
    assert seen.pressure_command == held
    assert not seen.wrapped
    answer = known.plan()
    assert not answer.success
    assert "the tube passes by" in answer.message
    assert answer.message == seen.refusal.text
    known.never = None
    assert known.plan(compute_grip=True).success  # asked of contact anew
    assert known.follow(0.0215, duration=0.1).state is State.TRACKING


def test_a_radius_that_the_table_does_not_hold_is_refused_from_the_first_message_on(known):
    known.use(lost=(0.018, 0.022))
    seen = known.follow(0.02, duration=0.1)
    assert not known.asked
    assert seen.state is State.WAITING
    assert seen.pressure_command == 0.0
    for refusal in (seen.refusal, known.plan(), known.grasp(0.0)):
        assert refusal.reason == Reason.NOT_CERTIFIED
    nearest = "the table of grips has no pressure that wraps it; it holds 0.006 m"
    assert nearest in seen.refusal.text
    exact = known.plan(compute_grip=True)  # contact itself decides
    assert exact.success
    assert len(exact.grip) == 1
    known.never = 0.02
    assert "the tube passes by" in known.plan(compute_grip=True).message
    known.never = None
    assert known.plan(gravity=[Vector3(x=8.0)]).success  # the table is not for this
    assert known.follow(0.036).state is State.TRACKING  # beyond the table the tip decides
    assert known.follow(0.02, contact=False).state is State.TRACKING


def test_past_a_loss_that_becomes_known_later_nothing_is_wrapped(known):
    pressure = known.follow(0.02, contact=False).plan.pressure
    known.grasp(0.4 * pressure)
    assert known.follow(0.02).wrapped
    seen = known.follow(0.02, contact=True)
    assert not seen.wrapped
    assert seen.pressure_command == pytest.approx(1.4 * pressure)
    assert known.told["wrap"].grip[0].holding_force_away == 0.0


def test_where_the_object_is_seen_the_regime_and_the_drawing_are_those_of_the_contact(known):
    def place():
        (held,) = (one for one in known.told["markers"].markers if one.ns == "object")
        return vector_from_msg(held.pose.position)

    known.set({"object_pose.timeout": 600.0})
    known.follow(0.02)
    assert place() == (0.1, 0.0, 0.0)
    assert not known.told["wrap"].regime_from_contact
    known.onset, known.curling, known.loss = 0.8, 0.9, 1.9  # there; the table's stay
    known.runtime.objects.offer((0.1, 0.02, 0.0), (0.0, 0.0, 1.0), known.time, 0.0, 600.0)
    known.follow(0.02, duration=0.02)
    assert not known.told["wrap"].grip  # the table does not stand for a place of its own
    known.follow(0.02)
    assert known.told["wrap"].regime_from_contact
    assert known.told["wrap"].grip[0].at_pose
    assert known.told["status"].regime == GripStatus.REGIME_CURLING
    assert place() == (0.1, 0.02, 0.0)


def test_with_a_shipped_gripper_the_first_command_is_that_of_its_table(known, monkeypatch):
    monkeypatch.undo()
    known.use()
    table, curve = read_grips(known.runtime.loaded.description), known.runtime.loaded.planner.curve
    assert table.rate == Limits(pressure_cap=1.0e5).pressure_rate_up  # settling times as they are
    onset, highest, _ = table.window(0.02, curve.pressure_from_radius(0.02))
    first = known.follow(0.02, duration=0.02, ratio=math.nan)
    assert first.pressure_target == pytest.approx(0.5 * (onset + highest))


def test_away_from_the_tables_gravity_nothing_is_recommended(known):
    known.use(curling=1.08)
    known.turn(9.0, 2.0, 3.0)
    seen = known.follow(0.02, duration=0.4, ratio=math.nan)
    assert seen.pressure_target == pytest.approx(1.1 * seen.plan.pressure)
    assert not known.told["wrap"].grip
    known.turn(9.8, 0.5, 0.0)
    seen = known.follow(0.02, duration=0.2)
    assert seen.plan.recommended == pytest.approx(1.03 * seen.plan.wrap.pressure)
    # Not held more loosely, now that its grip is known.
    assert seen.pressure_target == pytest.approx(1.08 * seen.plan.wrap.pressure)


def test_without_a_table_that_can_be_used_one_line_says_how_to_make_it(
    known, tmp_path, monkeypatch
):
    monkeypatch.undo()
    mine, told = tmp_path / "mine.yaml", []
    shutil.copy(GRIPPERS.path / "prototype_p1.yaml", mine)
    known.runtime.log.tell_nothing_beside = told.append
    for action in ("read", "used"):
        for gripper in ("prototype_p1", str(mine)):
            known.set({"gripper": gripper})
            known.follow(0.02, duration=0.4)
        (error,) = told
        assert error.action == action
        assert f"spiral-gripper grip {mine} --table makes it" in str(error)
        told.clear()
        shutil.copy(GRIPPERS.path / "paper_design_70.grips.json", tmp_path / "mine.grips.json")


def message_of(pressure=5.25e4, payload=0.02, gravity=DOWN, **changed):
    grip = replace(figures(curling=None), computed_at=3.0, **changed)
    (message,) = grip_to_msg(grip.answer(pressure, at_pose=True), 10.0, payload, gravity)
    assert all_finite(message)
    return message


def test_the_message_tells_what_is_known_and_every_number_is_finite():
    message = message_of()
    assert message.at_pose
    assert message.age == 7.0
    assert list(message.onset_curling) == []
    assert list(message.loss) == [8.0e4]
    assert list(message.holding_force_down) == pytest.approx([0.5])
    assert list(message.payload_margin) == pytest.approx([0.5 - 0.02 * 9.80665])
    assert not message_of(payload=None).payload_margin
    assert not message_of(gravity=(0.0, 0.0, 0.0)).holding_force_down
    # No time to settle differs from one that is not known, as where the grip is lost.
    assert list(message_of(settling=np.zeros(3)).settling_time) == [0.0]
    assert not message_of(8.0e4).settling_time
    # A shell and a Python program are told it too, or that it is not known.
    assert "not known (yet)" in "\n".join(grip_lines(None))
    assert "1 N away from the base, 0.1 N towards it" in "\n".join(grip_lines(message))
    result = Grasp.Result(success=True, grip=[message])
    told = result_of_wrap(SimpleNamespace(status=GoalStatus.STATUS_SUCCEEDED, result=result))
    assert told.holding_force_away == pytest.approx(1.0)
    assert told.holding_force_towards == pytest.approx(0.1)
