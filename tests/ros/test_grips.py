# SPDX-License-Identifier: Apache-2.0
"""What control loop, messages and clients make of grips, and all that a node tells of its work."""

import math
import re
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from difflib import ndiff
from functools import partial, reduce
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from core.grip_cases import DOWN, figures, table_of
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Vector3, Vector3Stamped
from ros.control_bench import Steps, rows
from ros.harness import all_finite, deliver, plan_request, serve, tick
from ros.local_nodes import change
from ros.records import agrees, told
from std_msgs.msg import Float64

from spiral_core import NotGrippableError, WrapCurve
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.grips import read_grips
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import ObjectRadius
from spiral_gripper_ros.actions.grasp import GraspServer
from spiral_gripper_ros.client.goals import result_of_wrap
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.grip import grip_to_msg
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.runtime.runtime import Outputs
from spiral_gripper_ros.tools.commands import grip_lines

NAMED = {
    "there": [Pose(position=Point(x=0.1), orientation=Quaternion(w=1.0))],
    "sideways": [Vector3(x=8.0)],
    "nowhere": [Vector3(x=math.nan)],
    "nothing": [Vector3()],
    "own": [Vector3(x=9.80665)],
    "against": [Vector3(x=-0.96, z=0.28)],
}
KINDS = {
    "object_radius_stamped": ObjectRadius,
    "object_pose": PoseStamped,
    "gravity": Vector3Stamped,
}
RUNTIME = "spiral_gripper_ros.runtime.runtime"


class KnownGrips(Steps):
    """A node in this process and its time; questions about grips are answered at once."""

    # The wrap begins, curls and is lost at these multiples of the tip criterion's pressure.
    onset, curling, loss = 0.98, 1.05, 1.3
    never = None  # radius that contact never wraps where the coil expects it
    error = 0.0  # of the table's forces
    lost = False  # whether the table holds nothing around 20 mm
    margin = None  # in the region of capture, if one is known

    def __init__(self, namespace, patch):
        self.time, self.told, self.asked, self.answers = 100.0, {}, [], []
        patch.setattr(f"{RUNTIME}.read_grips", self.table)
        patch.setattr(f"{RUNTIME}.read_regions", self.regions)
        self.node = GripperNode(namespace=namespace)
        self.runtime = self.node.runtime
        self.runtime.now = lambda: self.time
        self.runtime.outputs.publish = self.told.__setitem__
        self.runtime.outputs.publish_diagnostics = partial(self.told.__setitem__, "diagnostics")
        self.node.create_publisher = lambda _, topic, __: SimpleNamespace(
            publish=partial(self.told.__setitem__, topic)
        )
        self.runtime.background.grips = self
        self.runtime.background.solve_grip = self.solve
        self.set(**{"pressure.rate_up": 1.0e6, "radius.timeout": 600.0, "grip.ratio": 1.0})
        self.set(**{"publish.backbone_points": 3})
        self.executor = self.node.executor = Mock()
        assert self.node.start()

    # --- what the node asks --------------------------------------------------------------------

    def table(self, description):
        radii, curve = (0.006, 0.018, 0.022, 0.035), WrapCurve(description.gripper)
        held = radii[::3] if self.lost else radii
        return table_of(
            radii, [self.grip(curve, r) if r in held else None for r in radii], self.error
        )

    def grip(self, curve, radius):
        tip = curve.pressure_from_radius(radius)
        grip = figures(tip, curling=self.curling * tip, loss=self.loss * tip)
        return replace(grip, onset_wrap=self.onset * tip)

    def submit(self, *question):
        with ThreadPoolExecutor() as pool:
            return pool.submit(*question)

    def shutdown(self, **options):
        pass

    def solve(self, question, is_wanted):
        self.asked.append(question)
        if question.radius == self.never and question.pose is None:
            raise NotGrippableError(question.radius, "the tube passes by", 0.0, None)
        return self.grip(self.runtime.loaded.planner.curve, question.radius)

    def regions(self, _):
        region = SimpleNamespace(
            is_for=lambda *closing: not self.answers.append(closing),
            margin=lambda *line: self.answers.append(line) or self.margin,
        )
        return () if self.margin is None else (region,)

    # --- the steps of a course -----------------------------------------------------------------

    def give(self, **values):
        vars(self).update(values)

    def use(self, **multiples):
        """Load the gripper again, with a table of other windows."""
        self.give(**multiples)
        self.runtime.load()

    def set(self, **values):
        change(self.node, **values)

    def wrap(self, radius, duration=0.7, **values):
        """Offer a radius for long enough that its own grip is solved."""
        self.set(**{f"grip.{name}": value for name, value in values.items()})
        for _ in range(round(duration / 0.02)):
            self.time += 0.02
            deliver(self.node, "object_radius", Float64(data=radius))
            tick(self.node)

    def see(self):
        self.runtime.objects.offer((0.1, 0.02, 0.0), (0.0, 0.0, 1.0), self.time, 0.0, 600.0)

    def measure(self, pressure):
        deliver(self.node, "measured_pressure", Float64(data=pressure))

    def send(self, topic, age=0.0, frame_id="", **fields):
        """Let the node hear a message of this age with these fields, by their paths."""
        message = KINDS[topic]()
        message.header.frame_id = frame_id
        stamp = self.node.get_clock().now().nanoseconds - round(1e9 * age)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
        for path, value in fields.items():
            *parts, name = path.split(".")
            setattr(reduce(getattr, parts, message), name, value)
        deliver(self.node, topic, message)
        tick(self.node)

    def others(self, count):
        """Let so many nodes command the regulator."""
        name = self.node.resolve_topic_name("pressure_command")
        self.node.count_publishers = {name: round(count)}.get
        tick(self.node)

    def turn(self, *gravity):
        self.set(**{"gravity.vector": gravity})
        self.runtime.background.gravity.submit(int).result()  # planned for

    def grasp(self, part):
        """Grasp 20 mm with an overpressure of this part of the wrap's pressure."""
        planner, control = self.runtime.loaded.planner, self.runtime.control
        goal = GraspGoal(0.02, overpressure=part * planner.curve.pressure_from_radius(0.02))
        self.answers.append(control.start_grasp(self.time, goal, planner))

    def feedback(self):
        report = SimpleNamespace(progress=1.0, elapsed=1.0, plan=None)
        self.answers.append(GraspServer.told(self, Grasp.Feedback(), None, report))

    def plan(self, *radii, **fields):
        named = {name: NAMED.get(value, value) for name, value in fields.items()}
        request = plan_request(radii or [0.02], **{"backbone": False} | named)
        self.answers += serve(self.node, "plan_wrap", request).plans
        return self.answers[-1]

    def call(self, name):
        getattr(self.node if "_" in name else self.runtime.control, name)()

    # --- what is seen of it --------------------------------------------------------------------

    @property
    def seen(self):
        return self.runtime.control.snapshot()

    @property
    def words(self):
        """State, reason, target as a multiple of the tip criterion's pressure, and the grip."""
        seen, curve = self.seen, self.runtime.loaded.planner.curve
        part = seen.pressure_target / curve.pressure_from_radius(seen.radius or 0.02)
        held = "held" if seen.wrapped else "no"
        return f"{seen.state.name} {seen.refusal.reason.name} {part:.4g} {held}"


@pytest.fixture
def known(namespace, monkeypatch):
    """Its table, in the shipped one's place, has the same answers."""
    monkeypatch.setattr(Outputs, "markers_are_wanted", True)
    # tf2_msgs and tf2_ros are not on PyPI.
    monkeypatch.setitem(sys.modules, "tf2_ros", None)
    for name in ("tf2_msgs", "tf2_msgs.msg"):
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(TFMessage=SimpleNamespace))
    known = KnownGrips(namespace, monkeypatch)
    yield known
    known.node.vent()
    known.node.destroy_node()


# The end, and how many grips have been solved; the first message alone, then with its grip solved.
COURSES = """
TRACKING NONE 1.05 no 0: wrap 0.02 0.02 ratio=1.2
TRACKING NONE 1.05 held 1: wrap 0.02 ratio=1.2
TRACKING NONE 1.02 no 0: use onset=1.02 curling=1.1; wrap 0.02 0.02
TRACKING NONE 1.071 held 1: use onset=1.02 curling=1.1; wrap 0.02 ratio=1.05
TRACKING NONE 0.85 held 0: use onset=0.8 curling=0.9; wrap 0.02 0.1
TRACKING NONE 0.98 held 0: use onset=0.94 curling=1.02 error=1; wrap 0.02 0.1 ratio=nan
TRACKING NONE 1.04 no 0: use error=1; set measured_pressure.timeout=600; wrap 0.02 0.1 ratio=1.04;
  measure 8e4; wrap 0.02 0.02
TRACKING NONE 1.1 held 0: use curling=1.08; wrap 0.02 0.1 ratio=nan; wrap 0.02 0.1 contact=no
TRACKING NONE 1.03 no 0: use curling=1.08; wrap 0.02 0.02 ratio=nan
TRACKING NONE 1.03 held 1: use curling=1.08; wrap 0.02 ratio=nan
TRACKING NONE 1.1 held 0: use onset=1.15 curling=1.25; wrap 0.036 0.1 ratio=nan
TRACKING NONE 1.2 held 1: use onset=1.15 curling=1.25; wrap 0.036 ratio=nan
TRACKING NONE 1 held 0: wrap 0.02 0.4
HOLDING NOT_CERTIFIED 1 no 1: wrap 0.02 0.4; give never=0.02; wrap 0.02
TRACKING NONE 1 held 1: give never=0.02; wrap 0.02; give never=none; wrap 0.0215 0.4
WAITING NOT_CERTIFIED 0 no 0: use lost=yes; wrap 0.02 0.1; grasp 0
TRACKING NONE 1 held 0: use lost=yes; wrap 0.02 0.1; wrap 0.036
TRACKING NONE 1 held 0: use lost=yes; wrap 0.02 0.1; wrap 0.02 contact=no
GRASPING NONE 1.4 held 0: wrap 0.02 contact=no; grasp 0.4; wrap 0.02
GRASPING INVALID_REQUEST 1.4 no 1: wrap 0.02 contact=no; grasp 0.4; wrap 0.02; wrap 0.02 contact=yes
TRACKING NONE 1.1 held 0: use curling=1.08; turn 9 2 3; wrap 0.02 0.4 ratio=nan
TRACKING NONE 1.08 held 0: use curling=1.08; turn 9 2 3; wrap 0.02 0.4 ratio=nan; turn 9.8 0.5 0;
  wrap 0.02 0.2
TRACKING NONE 1.05 held 2: wrap 0.036 ratio=1.2; see; wrap 0.036
TRACKING NONE 1.05 held 2: see; wrap 0.036 ratio=1.2
TRACKING NONE 1.05 no 2: wrap 0.036 ratio=1.2; give onset=1.15; see; wrap 0.036
HOLDING NOT_CERTIFIED 1 held 2: give never=0.036; wrap 0.036; see; wrap 0.036
"""


@pytest.mark.parametrize("row", rows(COURSES))
def test_the_pressure_lies_within_the_window_of_the_grip_or_is_refused(known, row):
    expected, steps = row.split(": ")
    known.follow(steps)
    assert f"{known.words} {len(known.asked)}" == expected
    seen = known.seen
    assert {question.rate for question in known.asked} <= {1.0e6}  # of the node's ramp
    if seen.state is State.GRASPING or "; turn 9.8" in row:
        return  # held no more loosely now that its grip is known
    # What is planned is what is followed, with the same reason; contact itself decides if asked.
    answer = known.plan(seen.radius or 0.02)
    told_so = [figures.pressure for figures in answer.figures] or [answer.message]
    assert told_so == [seen.pressure_target if answer.success else seen.refusal.text]
    assert answer.reason == seen.refusal.reason
    exact = known.plan(seen.radius or 0.02, compute_grip=True)
    assert exact.success is (known.never is None)


def test_with_a_shipped_gripper_the_first_command_is_that_of_its_table(known, monkeypatch):
    monkeypatch.undo()
    known.use()
    table, curve = read_grips(known.runtime.loaded.description), known.runtime.loaded.planner.curve
    assert table.rate == Limits(pressure_cap=1.0e5).pressure_rate_up  # settling times as they are
    onset, highest, _ = table.window(0.02, curve.pressure_from_radius(0.02))
    known.wrap(0.02, duration=0.02, ratio=math.nan)
    assert known.seen.pressure_target == pytest.approx(0.5 * (onset + highest))


def test_without_a_table_that_can_be_used_one_line_says_how_to_make_it(
    known, tmp_path, monkeypatch
):
    monkeypatch.undo()
    mine, told = tmp_path / "mine.yaml", []
    shutil.copy(GRIPPERS.path / "prototype_p1.yaml", mine)
    known.runtime.log.tell_nothing_beside = told.append
    for action in ("read", "used"):
        for gripper in ("prototype_p1", str(mine)):
            known.set(gripper=gripper)
            known.wrap(0.02, duration=0.4)
        (error,) = told
        assert error.action == action
        assert f"spiral-gripper grip {mine} --table makes it" in str(error)
        told.clear()
        shutil.copy(GRIPPERS.path / "paper_design_70.grips.json", tmp_path / "mine.grips.json")


def test_a_stated_axis_of_the_object_is_the_same_in_either_sense(known, tmp_path):
    """And so is the window that is known for it."""
    mine, shipped = tmp_path / "mine.yaml", GRIPPERS.path / "prototype_p1.yaml"
    mine.write_text(shipped.read_text().replace("object_axis: fitted", "object_axis: [24, 0, -7]"))
    known.set(gripper=str(mine))
    known.use()
    plain, against = known.plan(), known.plan(axis="against", gravity="own")
    assert [len(answer.grip) for answer in (plain, against)] == [1, 1]


# What is told after each row is on record, as the difference from what was told before.
SESSION = """
set publish.robot_state_rate=10 object_pose.timeout=600; wrap 0.02 0.02
wrap 0.02 ratio=1.2 payload=1
feedback; plan backbone=yes; plan payload=0.02; plan compute_grip=yes friction_coefficient=0.4
grasp 0.4; wrap 0.02 0.1
call release; wrap 0.02 0.02; call rearm; wrap 0.02 0.1
set measured_pressure.timeout=600; measure 59500; wrap 0.02 0.02
see; give onset=0.8 curling=0.9 loss=1.9; wrap 0.02 0.02
wrap 0.02
wrap nan 0.02
others 2
others 2; others 1
send object_radius_stamped radius=0.2
send object_radius_stamped 60 radius=0.0201
send object_radius_stamped -60 radius=0.0201
send object_radius_stamped 1.9e9 radius=0.0201
send gravity vector.y=inf
send gravity 0 camera vector.y=9.8
wrap 0.02 0.02; set object_pose.timeout=1
send object_pose pose.position.y=nan
send object_pose pose.position.y=-1e4
send object_pose pose.orientation.w=1.002
send object_pose pose.orientation.w=0.998
send object_pose pose.orientation.y=nan
send object_pose pose.orientation.w=1e200
send object_pose 60
send object_pose -60
send object_pose 1.9e9
send object_pose 0 camera
call trigger_deactivate; call trigger_activate; set publish.robot_state_rate=0; wrap 0.02
use margin=-0.1; plan pose=there payload=0.02 friction_coefficient=0.4
use margin=0.1; plan pose=there
use margin=none; plan pose=there; plan pose=there compute_grip=yes
plan nan 0.02 0.001 inf 0 -1; plan axis=nothing; plan gravity=nowhere; plan length=0.01
plan pose=no_pose compute_grip=yes; plan payload=-1; plan friction_coefficient=-0.1;
  plan overpressure=1e6; plan overpressure=-1
use lost=yes; plan; plan gravity=own; plan friction_coefficient=0.3; plan gravity=sideways;
  plan compute_grip=yes; grasp 0; wrap 0.02 0.1
give never=0.02; plan compute_grip=yes
give never=none; use lost=no onset=0.98 curling=1.05; plan; plan gravity=own;
  plan friction_coefficient=0.3; plan friction_coefficient=0.5
use loss=1.1; plan overpressure=8e3; plan overpressure=8e3 gravity=own;
  plan overpressure=8e3 friction_coefficient=0.3
call trigger_deactivate
call trigger_cleanup; plan; call trigger_shutdown; plan
"""


def test_what_a_node_tells_in_a_session_is_that_on_record(known, capfd):
    found, last = [], {}
    for row in rows(SESSION):
        known.told.clear()
        known.answers.clear()
        known.follow(row)
        assert all_finite(known.told, *known.answers)
        found += [f"# {row}", *map(told, known.answers), f"told: {' '.join(sorted(known.told))}"]
        for topic, message in sorted(known.told.items()):
            before, last[topic] = last.get(topic, []), told(message).splitlines()
            changes = [one for one in ndiff(before, last[topic]) if one[0] in "+-"]
            found += [topic, *changes] if changes else []
        found += re.findall(r"\]: (.*)", capfd.readouterr().err)
    found = re.sub(r"\S+/config/", "", "\n".join(found))
    agrees("session", found.replace(known.node.get_namespace(), ""))


def test_the_message_tells_what_is_known_and_every_number_is_finite():
    """A shell and a Python program are told it too, or that it is not known."""
    grip, found = replace(figures(curling=None), computed_at=3.0), []
    # No time to settle differs from one that is not known, as where the grip is lost.
    for grips, pressure, payload, gravity in (
        (grip, 5.25e4, 0.02, DOWN),
        (grip, 5.25e4, None, DOWN),
        (grip, 5.25e4, 0.02, (0.0, 0.0, 0.0)),
        (replace(grip, settling=np.zeros(3)), 5.25e4, None, DOWN),
        (grip, 8.0e4, None, DOWN),
    ):
        (message,) = grip_to_msg(grips.answer(pressure, at_pose=True), 10.0, payload, gravity)
        assert all_finite(message)
        result = Grasp.Result(success=True, grip=[message])
        answer = SimpleNamespace(status=GoalStatus.STATUS_SUCCEEDED, result=result)
        found += [told(message, result_of_wrap(answer)), *grip_lines(message)]
    agrees("grip", "\n".join([*found, *grip_lines(None)]))
