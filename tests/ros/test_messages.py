# SPDX-License-Identifier: Apache-2.0
"""Packing: the numbers that go in come out, and names agree with the interfaces."""

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
from spiral_core.errors import SpiralError
from spiral_gripper import load_description
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.snapshot import MeasuredPressure, Snapshot
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State
from spiral_gripper_ros.messages.conversions import (
    REGIMES,
    backbone_to_msg,
    status_to_msg,
)
from spiral_gripper_ros.messages.diagnostics import CLOCK_STANDS_STILL, Health, diagnostics_to_msg
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.planning.planner import GripperPlanner, NoPlanner

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
    "name", sorted(str(p.relative_to(INTERFACES)) for p in INTERFACES.glob("*/*.[ams][csr][tgv]*"))
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


@pytest.fixture
def loaded(planner):
    return LoadedGripper(load_description("paper_design_70"), planner, None)


def test_a_status_without_anything_known_is_all_finite(loaded):
    loaded.mount.planner = NoPlanner((9.8, 0.0, 0.0), SpiralError("nothing"))
    message = status_to_msg(snapshot(), loaded, 1.0e5, Header())
    assert all_finite(message)
    assert not message.valid
    assert not message.measured
    assert not message.wrapped
    assert message.regime == message.measured_regime == GripStatus.REGIME_UNKNOWN


def test_a_status_carries_the_snapshot_and_the_plan(planner, loaded):
    plan = planner.plan(0.02)
    loaded.update_shape(1.0e4, 0.02)
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
            refused=Counter(
                {Reason.RADIUS_JUMP: 2, Reason.RADIUS_STALE: 1, Reason.PRESSURE_INVALID: 50}
            ),
        ),
        loaded,
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
    assert message.line_force == plan.line_force
    assert message.turns_margin == pytest.approx(message.turns - planner.gripper.turns_required)
    assert message.radius_margin == min(0.02 - message.radius_min, message.radius_max - 0.02)
    assert message.tip.x == planner.shape(1.0e4, 0.02).state.tip_position[0]


def test_a_status_carries_what_is_measured(planner, loaded):
    perfect = planner.plan(0.02).pressure
    loaded.update_measured_shape(0.9 * perfect, 0.02, tolerance=1.0e3)
    message = status_to_msg(
        snapshot(
            radius=0.02,
            plan=planner.plan(0.02),
            measured=MeasuredPressure(0.9 * perfect, 0.05),
            pressure_fault=Refusal(Reason.PRESSURE_LOW, "a leak"),
            wrapped=True,
        ),
        loaded,
        1.0e5,
        Header(),
    )
    assert message.measured
    assert message.wrapped
    assert (message.measured_pressure, message.measured_age) == (0.9 * perfect, 0.05)
    assert (message.pressure_fault, message.pressure_fault_text) == (Reason.PRESSURE_LOW, "a leak")
    assert message.measured_regime == GripStatus.REGIME_OVERHANG
    tip = planner.shape(0.9 * perfect, 0.02).state.tip_position
    assert (message.measured_tip.x, message.measured_tip.y) == (tip[0], tip[1])


def test_overpressure_adds_to_the_line_force(planner, loaded):
    plan = planner.plan(0.02)
    target = plan.pressure + 5.0e3
    pressed = snapshot(radius=0.02, plan=plan, pressure_target=target)
    message = status_to_msg(pressed, loaded, 1.0e5, Header())
    assert message.line_force == planner.line_force(plan.wrap, target) > plan.line_force
    assert message.pressure_margin == 1.0e5 - target


LEAK = Refusal(Reason.PRESSURE_LOW, "a leak")


def told(now, clock_stands_still=False):
    health = Health("/node", "id", 3, clock_stands_still)
    return diagnostics_to_msg(health, now, Header().stamp).status[0]


@pytest.mark.parametrize(
    ("fields", "level"),
    [
        ({"state": State.TRACKING}, DiagnosticStatus.OK),
        ({"state": State.GRASPING}, DiagnosticStatus.OK),
        ({"state": State.HOLDING}, DiagnosticStatus.WARN),
        ({"state": State.VENTED}, DiagnosticStatus.WARN),
        ({"state": State.FAULT}, DiagnosticStatus.ERROR),
        ({"state": State.TRACKING, "pressure_fault": LEAK}, DiagnosticStatus.ERROR),
    ],
)
def test_the_level_of_the_diagnostics_is_that_of_the_worst(fields, level):
    assert told(snapshot(**fields)).level == level


def test_a_clock_that_stands_still_is_warned_of_and_hides_nothing_worse():
    still = told(snapshot(state=State.TRACKING, refusal=NOT_REFUSED), clock_stands_still=True)
    assert still.level == DiagnosticStatus.WARN
    assert still.message == f"tracking; {CLOCK_STANDS_STILL}"
    worse = told(snapshot(state=State.TRACKING, pressure_fault=LEAK), clock_stands_still=True)
    assert worse.level == DiagnosticStatus.ERROR
    assert "a leak" in worse.message
    assert CLOCK_STANDS_STILL in worse.message


def test_the_diagnostics_hold_what_is_measured():
    measured = MeasuredPressure(6.0e4, 0.125)
    status = told(
        snapshot(state=State.GRASPING, measured=measured, pressure_fault=LEAK, wrapped=True)
    )
    values = {pair.key: pair.value for pair in status.values}
    assert values["grasping"] == values["wrapped"] == "True"
    assert values["measured_pressure [Pa]"] == "60000"
    assert values["measured_pressure age [s]"] == "0.125"
    assert values["pressure fault"] == "PRESSURE_LOW"
    assert values["internal errors"] == "3"


def test_every_state_has_a_level():
    for state in State:
        assert told(snapshot(state=state))


def test_the_package_exports_what_its_files_define():
    defined = {path.stem for path in INTERFACES.glob("msg/*.msg")}
    assert all(hasattr(messages, name) for name in defined)
