# SPDX-License-Identifier: Apache-2.0
"""What control loop, messages and clients make of grips."""

import math
import shutil
from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from core.grip_cases import DOWN, figures, table_of
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from rclpy.parameter import Parameter
from ros.harness import all_finite, deliver, plan_request
from scipy.spatial.transform import Rotation
from std_msgs.msg import Float64, Header

from spiral_core import NotGrippableError, WrapCurve
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.grips import read_grips
from spiral_gripper.files.regions import StoredRegion
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.actions.grasp import GraspServer
from spiral_gripper_ros.client.goals import result_of_wrap
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.messages.conversions import vector_from_msg
from spiral_gripper_ros.messages.grip import grip_to_msg
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.node.plan_service import PlanContext, answer_plan_wrap
from spiral_gripper_ros.runtime.runtime import Outputs
from spiral_gripper_ros.tools.commands import grip_lines


class KnownGrips:
    """A node in this process and its time; questions about grips are answered at once.

    Its table has the same answers where ``patch`` puts it in the shipped one's place.
    """

    def __init__(self, namespace, patch=lambda *_: None):
        self.time, self.told, self.asked = 100.0, {}, []
        # The wrap begins, curls and is lost at these multiples of the tip criterion's pressure.
        self.onset, self.curling, self.loss = 0.98, 1.05, 1.3
        self.never = None  # radius that contact never wraps
        self.lost = ()  # radii of the table that are not held
        patch("spiral_gripper_ros.runtime.runtime.read_grips", self.table)
        self.node = GripperNode(namespace=namespace)
        self.runtime = self.node.runtime
        self.runtime.now = lambda: self.time
        self.runtime.outputs.publish = self.told.__setitem__
        self.runtime.background.grips = self
        self.runtime.background.solve_grip = self.solve
        self.set({"pressure.rate_up": 1.0e6, "radius.timeout": 600.0, "grip.ratio": 1.0})
        assert self.node.start()

    def table(self, description):
        radii, curve = (0.006, *(self.lost or (0.018,)), 0.035), WrapCurve(description.gripper)
        grips = [self.figures(curve.pressure_from_radius(radius)) for radius in radii]
        return table_of(
            radii, [None if r in self.lost else each for r, each in zip(radii, grips, strict=True)]
        )

    def use(self, **multiples):
        """Load the gripper again, with a table of other windows."""
        for name, value in multiples.items():
            setattr(self, name, value)
        self.runtime.load()

    def set(self, values):
        self.node.set_parameters([Parameter(name, value=value) for name, value in values.items()])

    def submit(self, solve, *question):
        answer = Future()
        try:
            answer.set_result(solve(*question))
        except NotGrippableError as error:
            answer.set_exception(error)
        return answer

    def shutdown(self, **options):
        pass

    def solve(self, question, is_wanted):
        self.asked.append(question)
        if question.radius == self.never:
            raise NotGrippableError(question.radius, "the tube passes by", 0.0, None)
        return self.figures(self.runtime.loaded.planner.curve.pressure_from_radius(question.radius))

    def figures(self, tip):
        grip = figures(tip, curling=self.curling * tip, loss=self.loss * tip)
        return replace(grip, onset_wrap=self.onset * tip)

    def follow(self, radius, duration=0.7, **values):
        """Follow a radius for long enough that its own grip is solved."""
        self.set({f"grip.{name}": value for name, value in values.items()})
        for _ in range(round(duration / 0.02)):
            self.time += 0.02
            if radius is not None:
                deliver(self.node, "object_radius", Float64(data=radius))
            for timer in self.node.timers:
                timer.callback()
        return self.seen

    @property
    def seen(self):
        return self.runtime.control.snapshot()

    def grasp(self, overpressure):
        goal, planner = GraspGoal(0.02, overpressure=overpressure), self.runtime.loaded.planner
        return self.runtime.control.start_grasp(self.time, goal, planner)

    def plan(self, **fields):
        """Return the answer of `plan_wrap` about an object of 20 mm."""
        loaded, limits = self.runtime.loaded, self.runtime.limits
        asked = (loaded.planner, loaded.gripper, limits, 9, Header(), lambda: True)
        known = loaded.grip, self.runtime.solved_grip, self.time, loaded.regions
        context = PlanContext(*asked, *known)
        return answer_plan_wrap(plan_request([0.02], **fields), PlanWrap.Response(), context).plans[
            0
        ]


@pytest.fixture
def known(namespace, monkeypatch):
    monkeypatch.setattr(Outputs, "markers_are_wanted", True)
    known = KnownGrips(namespace, monkeypatch.setattr)
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


def test_the_grip_that_is_known_is_told(known):
    seen = known.follow(0.02, ratio=1.2)
    told = known.told["wrap"]
    (grip,) = told.grip
    assert seen.wrapped
    assert list(grip.onset_curling) == pytest.approx([seen.pressure_target])
    assert grip.holding_force_away > grip.holding_force_towards > 0.0
    assert not grip.payload_margin
    assert told.plan[0].contact_length == grip.contact_length > 0.0
    server = GraspServer(known.node, known.runtime, Grasp, "another")
    report = SimpleNamespace(progress=1.0, elapsed=1.0, plan=None)
    feedback = server.told(Grasp.Feedback(), None, report)
    assert feedback.settling_time == grip.settling_time
    assert grip.settling_time[0] > 0.0
    for goal in (Grasp.Goal(payload=[-1.0]), Grasp.Goal(mode=3), Grasp.Goal(abort_policy=3)):
        assert server.goal(goal).reason is Reason.INVALID_REQUEST
    server.destroy()
    known.follow(0.02, duration=0.1, payload=1.0)
    weight = grip.holding_force_down[0] - known.told["wrap"].grip[0].payload_margin[0]
    assert weight == pytest.approx(9.80665)
    assert all_finite(known.told["status"], known.told["wrap"])


def seen_at(place, axis, shift=(0.0, 0.0, 0.0)):
    """Return the pose of an object whose z axis is along another one."""
    turn = Rotation.align_vectors([axis], [(0.0, 0.0, 1.0)])[0].as_quat()
    x, y, z, w = turn.tolist()
    point = Point(**dict(zip("xyz", np.add(place, shift).tolist(), strict=True)))
    return [Pose(position=point, orientation=Quaternion(x=x, y=y, z=z, w=w))]


def test_an_object_that_is_seen_has_its_margin_in_the_region_of_capture(known, monkeypatch):
    plan, gripper = known.plan(), known.runtime.loaded.gripper
    axis, place = (
        np.array([getattr(of[0], each) for each in "xyz"])
        for of in (plan.object_axis, plan.object_center)
    )
    away = np.cross(axis, (1.0, 0.0, 0.0))
    away /= np.linalg.norm(away)
    region = StoredRegion(
        radius=0.02,
        pressure=plan.figures[0].pressure,
        payload=0.02,
        friction=0.3,
        gravity=gripper.gravity,
        center=place.tolist(),
        frame=[axis.tolist(), away.tolist(), np.cross(axis, away).tolist()],
        semi_axes=(0.01, 0.02, 0.1, 0.2),
    )
    monkeypatch.setattr("spiral_gripper_ros.runtime.runtime.read_regions", lambda _: (region,))
    known.runtime.load()
    here = seen_at(place, axis)
    assert known.plan(pose=here, payload=0.02).capture_margin[0] == pytest.approx(1.0)
    for part in (0.5, 1.0, 2.0):
        beside = seen_at(place, -axis, 0.01 * part * away + 0.3 * axis)
        found = known.plan(pose=beside)
        assert found.capture_margin[0] == pytest.approx(1.0 - part)
        assert ("it may be missed" in found.message) is (part > 1.0 + 1e-9) or part == 1.0
    tilted = seen_at(place, math.cos(0.05) * axis + math.sin(0.05) * np.cross(away, axis))
    assert known.plan(pose=tilted).capture_margin[0] == pytest.approx(0.5)
    for other in (
        {},
        {"pose": here, "payload": 0.03},
        {"pose": here, "friction_coefficient": 0.4},
        {"pose": here, "overpressure": 1e4},
        {"pose": here, "gravity": [Vector3(x=9.0)]},
    ):
        found = known.plan(**other)
        assert found.success
        assert not found.capture_margin
    skewed = [Pose(orientation=Quaternion(w=2.0))]
    assert known.plan(pose=skewed).reason == Reason.INVALID_REQUEST


def test_a_radius_that_contact_never_wraps_is_refused_once_that_is_known(known):
    held = known.follow(0.02, duration=0.4).pressure_command
    known.never = 0.02
    seen = known.follow(0.02)
    assert (seen.state, seen.refusal.reason) == (State.HOLDING, Reason.NOT_CERTIFIED)
    assert "the tube passes by" in seen.refusal.text
    assert (seen.pressure_command, seen.wrapped) == (held, False)
    answer = known.plan()
    assert not answer.success
    assert "the tube passes by" in answer.message
    known.never = None
    assert known.plan(compute_grip=True).success  # asked of contact anew
    assert known.follow(0.0215, duration=0.1).state is State.TRACKING


def test_a_radius_that_the_table_does_not_hold_is_refused_from_the_first_message_on(known):
    known.lost = (0.018, 0.022)
    known.use()
    seen = known.follow(0.02, duration=0.1)
    assert not known.asked
    assert (seen.state, seen.refusal.reason) == (State.WAITING, Reason.NOT_CERTIFIED)
    assert "the table of grips has no pressure that wraps it; it holds 0.006 m" in seen.refusal.text
    assert seen.pressure_command == 0.0
    answer = known.plan()
    assert (answer.success, answer.reason) == (False, Reason.NOT_CERTIFIED)
    assert known.grasp(0.0).reason is Reason.NOT_CERTIFIED
    exact = known.plan(compute_grip=True)  # contact itself decides
    assert (exact.success, len(exact.grip)) == (True, 1)
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
    assert not known.follow(0.02, contact=True).wrapped
    assert known.seen.pressure_command == pytest.approx(1.4 * pressure)
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
    told = known.told["wrap"]
    assert (told.regime_from_contact, told.grip[0].at_pose) == (True, True)
    assert known.told["status"].regime == GripStatus.REGIME_CURLING
    assert place() == (0.1, 0.02, 0.0)


def test_with_a_shipped_gripper_the_first_command_is_that_of_its_table_and_stays(namespace):
    known = KnownGrips(namespace)
    loaded = known.runtime.loaded
    tip = loaded.planner.curve.pressure_from_radius(0.02)
    table = read_grips(loaded.description)
    assert table.rate == Limits(pressure_cap=1.0e5).pressure_rate_up  # settling times as they are
    onset, highest, _ = table.window(0.02, tip)
    first = known.follow(0.02, duration=0.02, ratio=math.nan)
    assert first.pressure_target == pytest.approx(0.5 * (onset + highest))
    assert known.told["wrap"].grip[0].onset_wrap == pytest.approx(onset)
    assert known.follow(0.02, duration=2.0).pressure_target == first.pressure_target
    assert known.told["wrap"].grip[0].onset_wrap == pytest.approx(0.98 * tip)  # its own
    known.node.vent()
    known.node.destroy_node()


def test_away_from_the_tables_gravity_nothing_is_recommended(known):
    def turn(*gravity):
        known.set({"gravity.vector": gravity})
        known.runtime.background.gravity.submit(int).result()  # planned for

    known.use(curling=1.08)
    turn(9.0, 2.0, 3.0)
    seen = known.follow(0.02, duration=0.4, ratio=math.nan)
    assert seen.pressure_target == pytest.approx(1.1 * seen.plan.pressure)
    assert not known.told["wrap"].grip
    turn(9.8, 0.5, 0.0)
    seen = known.follow(0.02, duration=0.2)
    assert seen.plan.recommended == pytest.approx(1.03 * seen.plan.wrap.pressure)
    # Not held more loosely, now that its grip is known.
    assert seen.pressure_target == pytest.approx(1.08 * seen.plan.wrap.pressure)


def test_an_object_is_not_held_more_loosely_once_its_grip_is_no_longer_known(known):
    known.use(curling=1.4, loss=math.inf)
    tight = known.follow(0.02, duration=0.4, ratio=math.nan)
    multiple = tight.pressure_target / tight.plan.pressure
    assert multiple > 1.15
    known.set({"gravity.vector": (9.0, 2.0, 3.0)})
    known.runtime.background.gravity.submit(int).result()  # planned for
    seen = known.follow(0.02, duration=0.4)
    assert seen.plan.recommended is None
    assert seen.pressure_target == pytest.approx(multiple * seen.plan.pressure)
    loose = known.follow(0.03, duration=0.4)  # another object
    assert loose.pressure_target == pytest.approx(1.1 * loose.plan.pressure)


def test_without_a_table_that_can_be_used_one_line_says_how_to_make_it(namespace, tmp_path):
    text = (GRIPPERS.path / "prototype_p1.yaml").read_text(encoding="utf-8")
    mine = tmp_path / "mine.yaml"
    mine.write_text(text, encoding="utf-8")
    known, told = KnownGrips(namespace), []
    known.runtime.log.tell_nothing_beside = told.append
    known.set({"gripper": str(mine)})
    known.follow(0.02, duration=0.4)
    shutil.copy(GRIPPERS.path / "paper_design_70.grips.json", tmp_path / "mine.grips.json")
    known.set({"gripper": "prototype_p1"})
    known.set({"gripper": str(mine)})
    known.follow(0.02, duration=0.4)
    assert known.runtime.loaded.grips.table(DOWN) is None
    assert [error.action for error in told] == ["read", "used"]
    assert all(f"spiral-gripper grip {mine} --table makes it" in str(error) for error in told)
    known.node.vent()
    known.node.destroy_node()


def message_of(pressure=5.25e4, payload=0.02, gravity=DOWN, **changed):
    grip = replace(figures(curling=None), computed_at=3.0, **changed)
    answer = grip.answer(pressure, at_pose=True)
    (message,) = grip_to_msg(answer, 10.0, payload, gravity)
    assert all_finite(message)
    return message


def test_the_message_tells_what_is_known_and_every_number_is_finite():
    message = message_of()
    assert (message.at_pose, message.age) == (True, 7.0)
    assert (list(message.onset_curling), list(message.loss)) == ([], [8.0e4])
    assert list(message.holding_force_down) == pytest.approx([0.5])
    assert list(message.payload_margin) == pytest.approx([0.5 - 0.02 * 9.80665])
    assert not message_of(payload=None).payload_margin
    assert not message_of(gravity=(0.0, 0.0, 0.0)).holding_force_down
    assert not grip_to_msg(None, 10.0, 0.02, DOWN)
    # No time to settle differs from one that is not known, as where the grip is lost.
    assert list(message_of(settling=np.zeros(3)).settling_time) == [0.0]
    assert not message_of(settling=np.full(3, math.nan)).settling_time
    assert not message_of(8.0e4).settling_time


def test_a_shell_and_a_python_program_are_told_the_grip_or_that_it_is_not_known():
    assert "not known (yet)" in "\n".join(grip_lines(None))
    grip = message_of()
    assert "1 N away from the base, 0.1 N towards it" in "\n".join(grip_lines(grip))
    result = Grasp.Result(success=True, grip=[grip])
    told = result_of_wrap(SimpleNamespace(status=GoalStatus.STATUS_SUCCEEDED, result=result))
    assert (told.holding_force_away, told.holding_force_towards) == pytest.approx((1.0, 0.1))
