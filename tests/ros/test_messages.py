"""Packing: the numbers that go in come out, and names agree with the interfaces."""

import math
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from ros.harness import all_finite
from std_msgs.msg import Header

import spiral_gripper_msgs.msg as messages
from spiral_core import WrapRegime
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.conversions import REGIMES, backbone_to_msg, status_to_msg
from spiral_gripper_ros.diagnostics import diagnostics_to_msg
from spiral_gripper_ros.planner import GripperPlanner
from spiral_gripper_ros.states import Reason, Refusal, State
from spiral_gripper_ros.supervisor import Snapshot

INTERFACES = Path(__file__).parents[2] / "spiral_gripper_msgs"


@pytest.fixture(scope="module")
def planner(gripper):
    return GripperPlanner(gripper)


def constants(prefix):
    return {
        name.removeprefix(prefix): getattr(GripStatus, name)
        for name in re.findall(rf"uint8 ({prefix}\w+)=", _definition("msg/GripStatus.msg"))
    }


def _definition(name):
    return (INTERFACES / name).read_text(encoding="utf-8")


def test_states_and_reasons_have_the_numbers_of_the_message():
    assert constants("STATE_") == {state.name: state.value for state in State}
    assert constants("REASON_") == {reason.name: reason.value for reason in Reason}
    assert set(constants("REGIME_").values()) == set(REGIMES.values())
    assert set(REGIMES) == {None, *WrapRegime}


@pytest.mark.parametrize(
    "name", sorted(str(p.relative_to(INTERFACES)) for p in INTERFACES.glob("*/*.[ms][sr][gv]"))
)
def test_every_number_of_an_interface_says_its_unit(name):
    fields = re.findall(r"^(float64(?:\[\])?) (\w+)(.*)$", _definition(name), re.MULTILINE)
    assert fields
    for _, field, rest in fields:
        assert re.search(r"#.*(\[[\w/^ ]+\]|SI)", rest), f"{field} of {name} names no unit"


def test_the_backbone_has_the_ends_and_the_frames_of_the_shape(planner):
    state = planner.plan(0.02).wrap.state
    message = backbone_to_msg(state, 11, Header(frame_id="base"))
    assert message.header.frame_id == "base"
    assert len(message.poses) == 11
    for pose, index in ((message.poses[0], 0), (message.poses[-1], -1)):
        p, q = pose.position, pose.orientation
        assert (p.x, p.y, p.z) == tuple(state.positions[index])
        assert (q.x, q.y, q.z, q.w) == tuple(state.orientations[index])


def test_a_poses_x_axis_is_the_tangent(planner):
    state = planner.plan(0.02).wrap.state
    poses = backbone_to_msg(state, 10_000, Header()).poses
    assert len(poses) == len(state.positions)
    q = np.array([(p.orientation.x, p.orientation.y, p.orientation.z) for p in poses])
    w = np.array([p.orientation.w for p in poses])[:, None]
    x_axis = np.array([1.0, 0.0, 0.0])
    tangents = x_axis + 2.0 * np.cross(q, np.cross(q, x_axis) + w * x_axis)
    assert tangents == pytest.approx(state.tangents, abs=1e-12)


def snapshot(**fields):
    return Snapshot(
        **{
            "state": State.WAITING,
            "refusal": Refusal(Reason.NO_RADIUS, "no object_radius"),
            "radius": None,
            "plan": None,
            "radius_age": None,
            "pressure_target": 0.0,
            "pressure_command": 0.0,
            "accepted": 0,
            "refused": Counter(),
            **fields,
        }
    )


def test_a_status_without_anything_known_is_all_finite():
    message = status_to_msg(snapshot(), None, (0.0, math.inf), 1.0e5, Header())
    assert all_finite(message)
    assert not message.valid
    assert message.regime == GripStatus.REGIME_UNKNOWN


def test_a_status_carries_the_snapshot_and_the_plan(planner):
    plan = planner.plan(0.02)
    message = status_to_msg(
        snapshot(
            state=State.HOLDING,
            refusal=Refusal(Reason.RADIUS_JUMP, "jumped"),
            radius=0.02,
            plan=plan,
            radius_age=0.25,
            pressure_target=plan.pressure,
            pressure_command=1.0e4,
            accepted=7,
            refused=Counter({Reason.RADIUS_JUMP: 2, Reason.RADIUS_STALE: 1}),
        ),
        planner.shape(1.0e4, 0.02),
        planner.radius_range,
        1.0e5,
        Header(),
    )
    assert (message.state, message.reason) == (State.HOLDING, Reason.RADIUS_JUMP)
    assert message.reason_text == "jumped"
    assert (message.object_radius, message.radius_age) == (0.02, 0.25)
    assert (message.pressure_target, message.pressure_command) == (plan.pressure, 1.0e4)
    assert (message.radii_accepted, message.radii_refused) == (7, 3)
    assert message.regime == GripStatus.REGIME_OVERHANG
    assert message.pressure_margin == 1.0e5 - plan.pressure
    assert message.turns_margin == pytest.approx(message.turns - planner.gripper.turns_required)
    assert message.radius_margin == min(0.02 - message.radius_min, message.radius_max - 0.02)
    assert message.tip.x == planner.shape(1.0e4, 0.02).state.tip_position[0]


@pytest.mark.parametrize(
    ("state", "level"),
    [
        (State.TRACKING, DiagnosticStatus.OK),
        (State.HOLDING, DiagnosticStatus.WARN),
        (State.VENTED, DiagnosticStatus.WARN),
        (State.FAULT, DiagnosticStatus.ERROR),
    ],
)
def test_the_level_of_the_diagnostics_is_that_of_the_state(state, level):
    message = diagnostics_to_msg("/node", "id", snapshot(state=state), 0, Header().stamp)
    assert message.status[0].level == level


def test_every_state_has_a_level():
    for state in State:
        assert diagnostics_to_msg("/node", "", snapshot(state=state), 0, Header().stamp).status


def test_the_package_exports_what_its_files_define():
    defined = {path.stem for path in INTERFACES.glob("msg/*.msg")}
    assert all(hasattr(messages, name) for name in defined)
