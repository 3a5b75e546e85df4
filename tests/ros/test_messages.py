# SPDX-License-Identifier: Apache-2.0
"""Packing: the numbers that go in come out, and names agree with the interfaces."""

import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from ros.grip_stand_ins import unknown_grips
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
    wrap_to_msg,
)
from spiral_gripper_ros.messages.diagnostics import CLOCK_STANDS_STILL, Health, diagnostics_to_msg
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.planning.planner import GripperPlanner, NoPlanner

INTERFACES = Path(__file__).parents[2] / "spiral_gripper_msgs"


@pytest.fixture(scope="module")
def planner(gripper):
    return GripperPlanner(gripper)


def constants(kind, prefix=""):
    """Return the constants of a message whose names begin so, without their beginning."""
    return {
        name.removeprefix(prefix): getattr(kind, name)
        for name in re.findall(rf"uint8 ({prefix}\w+)=", _definition(f"msg/{kind.__name__}.msg"))
    }


def _definition(name):
    return (INTERFACES / name).read_text(encoding="utf-8")


def test_states_and_reasons_have_the_numbers_of_the_message():
    assert constants(GripStatus, "STATE_") == {state.name: state.value for state in State}
    assert constants(messages.Reason) == {reason.name: reason.value for reason in Reason}
    assert set(constants(GripStatus, "REGIME_").values()) == set(REGIMES.values())
    assert set(REGIMES) == {None, *WrapRegime}


@pytest.mark.parametrize(
    "name", sorted(str(p.relative_to(INTERFACES)) for p in INTERFACES.glob("*/*.[ams][csr][tgv]*"))
)
def test_every_number_of_an_interface_says_its_unit(name):
    fields = re.findall(r"^(float64(?:\[.*?\])?) (\w+)(.*)$", _definition(name), re.MULTILINE)
    assert fields or name == "msg/Reason.msg"
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
    grips = unknown_grips(planner.gripper, planner.gravity)
    return LoadedGripper(load_description("paper_design_70"), planner, None, grips)


def test_nothing_known_is_all_finite_and_empty(loaded):
    loaded.mount.planner = NoPlanner((9.8, 0.0, 0.0), SpiralError("nothing"))
    message = status_to_msg(snapshot(), loaded, Header())
    told = wrap_to_msg(snapshot(), loaded, 1.0e5, None, Header())
    assert all_finite(message, told)
    assert not message.wrapped
    assert message.regime == GripStatus.REGIME_UNKNOWN
    assert not any(map(len, (message.object_radius, message.measured_pressure)))
    assert not any(map(len, (told.radius_range, told.plan, told.object_offset)))


def test_a_status_is_small():
    def leaves(message):
        kinds = message.get_fields_and_field_types()
        nested = (getattr(message, name) for name in kinds)
        return sum(
            leaves(one) if hasattr(one, "get_fields_and_field_types") else 1 for one in nested
        )

    assert leaves(GripStatus()) <= 16


def test_a_status_carries_the_snapshot_and_the_wrap_its_plan(planner, loaded):
    plan = planner.plan(0.02)
    loaded.update_shape(1.0e4, 0.02)
    seen = snapshot(
        state=State.HOLDING,
        refusal=Refusal(Reason.RADIUS_JUMP, "jumped"),
        radius=0.02,
        plan=plan,
        pressure_target=plan.pressure,
        pressure_command=1.0e4,
    )
    message = status_to_msg(seen, loaded, Header())
    assert (message.state, message.reason) == (State.HOLDING, Reason.RADIUS_JUMP)
    assert message.reason_text == "jumped"
    assert list(message.object_radius) == [0.02]
    assert (message.pressure_target, message.pressure_command) == (plan.pressure, 1.0e4)
    assert message.regime == GripStatus.REGIME_OVERHANG
    told = wrap_to_msg(seen, loaded, 1.0e5, None, Header())
    (figures,) = told.plan
    assert (figures.object_radius, figures.pressure) == (0.02, plan.pressure)
    assert figures.pressure_margin == 1.0e5 - plan.pressure
    assert figures.line_force == plan.line_force
    assert figures.turns_margin == pytest.approx(figures.turns - planner.gripper.turns_required)
    lowest, highest = told.radius_range
    assert list(figures.radius_margin) == [min(0.02 - lowest, highest - 0.02)]


def test_a_status_carries_what_is_measured(planner, loaded):
    perfect = planner.plan(0.02).pressure
    loaded.update_measured_shape(0.9 * perfect, 0.02, tolerance=1.0e3)
    seen = snapshot(
        radius=0.02,
        plan=planner.plan(0.02),
        measured=MeasuredPressure(0.9 * perfect, 0.05),
        pressure_fault=Refusal(Reason.PRESSURE_LOW, "a leak"),
        wrapped=True,
    )
    message = status_to_msg(seen, loaded, Header())
    assert message.wrapped
    assert list(message.measured_pressure) == [0.9 * perfect]
    assert (message.fault, message.fault_text) == (Reason.PRESSURE_LOW, "a leak")
    assert message.regime == GripStatus.REGIME_OVERHANG


def test_overpressure_adds_to_the_line_force(planner, loaded):
    plan = planner.plan(0.02)
    target = plan.pressure + 5.0e3
    pressed = snapshot(radius=0.02, plan=plan, pressure_target=target, overpressure=5.0e3)
    (figures,) = wrap_to_msg(pressed, loaded, 1.0e5, None, Header()).plan
    assert figures.overpressure == pytest.approx(5.0e3)
    assert figures.line_force == planner.line_force(plan.wrap, target) > plan.line_force
    assert figures.pressure_margin == 1.0e5 - target


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
