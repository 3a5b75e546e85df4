# SPDX-License-Identifier: Apache-2.0
"""Packing: the numbers that go in come out, and names agree with the interfaces."""

import re
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from ros.control_bench import snapshot
from ros.harness import all_finite
from std_msgs.msg import Header

import spiral_gripper_msgs.msg as messages
from spiral_core import WrapRegime
from spiral_core.errors import SpiralError
from spiral_gripper import load_description
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.snapshot import MeasuredPressure
from spiral_gripper_ros.control.states import Reason, Refusal, State
from spiral_gripper_ros.messages.conversions import (
    REGIMES,
    backbone_to_msg,
    quaternion_from_msg,
    status_to_msg,
    vector_from_msg,
    wrap_to_msg,
)
from spiral_gripper_ros.messages.diagnostics import CLOCK_STANDS_STILL, Health, diagnostics_to_msg
from spiral_gripper_ros.planning.grip_follower import GripFollower
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper
from spiral_gripper_ros.planning.object_pose import rotated
from spiral_gripper_ros.planning.planner import NoPlanner

INTERFACES = Path(__file__).parents[2] / "spiral_gripper_msgs"
FILES = sorted(str(p.relative_to(INTERFACES)) for p in INTERFACES.glob("*/*.[ams][csr][tgv]*"))
LEAK = Refusal(Reason.PRESSURE_LOW, "a leak")
JUMP = Refusal(Reason.RADIUS_JUMP, "jumped")


def definition(name):
    return (INTERFACES / name).read_text(encoding="utf-8")


def constants(kind, prefix=""):
    """Return the constants of a message whose names begin so, without their beginning."""
    return {
        name.removeprefix(prefix): getattr(kind, name)
        for name in re.findall(rf"uint8 ({prefix}\w+)=", definition(f"msg/{kind.__name__}.msg"))
    }


def test_states_and_reasons_have_the_numbers_of_the_message():
    assert constants(GripStatus, "STATE_") == {state.name: state.value for state in State}
    assert constants(messages.Reason) == {reason.name: reason.value for reason in Reason}
    assert set(constants(GripStatus, "REGIME_").values()) == set(REGIMES.values())
    assert set(REGIMES) == {None, *WrapRegime}


@pytest.mark.parametrize("name", FILES)
def test_every_number_of_an_interface_says_its_unit_and_the_package_exports_it(name):
    fields = re.findall(r"^(float64(?:\[.*?\])?) (\w+)(.*)$", definition(name), re.MULTILINE)
    assert fields or name == "msg/Reason.msg"
    for _, field, rest in fields:
        assert re.search(r"#.*(\[[\w/^ ]+\]|SI)", rest), f"{field} of {name} names no unit"
    assert not name.startswith("msg") or hasattr(messages, Path(name).stem)


@pytest.fixture
def loaded(planner):
    grips = GripFollower(planner.gripper, planner.gravity, None, None, None)
    loaded = LoadedGripper(load_description("paper_design_70"), planner.gravity, None, grips)
    loaded.planner = planner
    return loaded


def test_the_backbone_has_the_ends_and_the_frames_of_the_shape(planner):
    state = planner.plan(0.02).wrap.state
    assert len(backbone_to_msg(state, 10_000, Header()).poses) == len(state.positions)
    message = backbone_to_msg(state, 11, Header(frame_id="base"))
    assert (message.header.frame_id, len(message.poses)) == ("base", 11)
    for index in (0, -1):
        pose = message.poses[index]
        assert vector_from_msg(pose.position) == tuple(state.positions[index])
        tangent = rotated(quaternion_from_msg(pose.orientation), (1.0, 0.0, 0.0))
        assert tangent == pytest.approx(state.tangents[index], abs=1e-12)


def test_nothing_known_is_all_finite_and_empty(loaded):
    loaded.planner = NoPlanner((9.8, 0.0, 0.0), SpiralError("nothing"))
    message = status_to_msg(snapshot(State.WAITING), loaded, Header())
    told = wrap_to_msg(snapshot(State.WAITING), loaded, 1.0e5, None, Header())
    assert all_finite(message, told)
    assert (message.wrapped, message.regime) == (False, GripStatus.REGIME_UNKNOWN)
    unknown = (message.object_radius, told.radius_range, told.plan, told.object_offset)
    assert not any(map(len, (*unknown, message.measured_pressure)))


def test_a_status_carries_the_snapshot_and_the_wrap_its_plan(planner, loaded):
    plan = planner.plan(0.02)
    target, measured = plan.pressure + 5.0e3, 0.9 * plan.pressure
    loaded.update_shape(plan.pressure, 0.02)
    loaded.update_measured_shape(measured, 0.02, tolerance=1.0e3)
    numbers = {"pressure_target": target, "pressure_command": 1.0e4}
    seen = snapshot(
        State.HOLDING,
        JUMP,
        radius=0.02,
        plan=plan,
        pressure_fault=LEAK,
        wrapped=True,
        measured=MeasuredPressure(measured, 0.05),
        **numbers,
    )
    assert status_to_msg(seen, loaded, Header()) == GripStatus(
        state=State.HOLDING,
        reason=Reason.RADIUS_JUMP,
        reason_text="jumped",
        fault=Reason.PRESSURE_LOW,
        fault_text="a leak",
        object_radius=[0.02],
        measured_pressure=[measured],
        regime=GripStatus.REGIME_OVERHANG,
        wrapped=True,
        **numbers,
    )
    told = wrap_to_msg(seen, loaded, 1.0e5, None, Header())
    (figures,) = told.plan
    assert (figures.object_radius, figures.pressure) == (0.02, target)
    assert figures.overpressure == pytest.approx(5.0e3)
    assert figures.pressure_margin == 1.0e5 - target
    assert figures.line_force == plan.line_force(target)
    assert figures.turns_margin == pytest.approx(figures.turns - planner.gripper.turns_required)
    lowest, highest = told.radius_range
    assert list(figures.radius_margin) == [min(0.02 - lowest, highest - 0.02)]


def test_a_wrap_that_is_pressed_by_overpressure_is_shown_as_perfect(planner, loaded):
    loaded.update_shape(1.15 * planner.plan(0.02).pressure, 0.02)
    for wrapped, regime in ((False, WrapRegime.CURLING), (True, WrapRegime.PERFECT_WRAP)):
        assert loaded.shown_regime(snapshot(State.TRACKING, radius=0.02, wrapped=wrapped)) is regime


def diagnosed(state, clock_stands_still=False, **fields):
    health = Health("/node", "id", 3, clock_stands_still)
    return diagnostics_to_msg(health, snapshot(state, **fields), Header().stamp).status[0]


OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
WORSE = {State.FAULT: ERROR}
WORSE |= dict.fromkeys((State.HOLDING, State.RAMPING_DOWN, State.VENTED, State.TAKEN_OVER), WARN)


@pytest.mark.parametrize("state", State)
def test_the_level_of_the_diagnostics_is_that_of_the_worst(state):
    assert diagnosed(state).level == WORSE.get(state, OK)
    still = diagnosed(state, clock_stands_still=True)
    assert still.level == max(WORSE.get(state, OK), WARN)
    assert still.message == f"{state.name.lower().replace('_', ' ')}; {CLOCK_STANDS_STILL}"
    worse = diagnosed(state, clock_stands_still=True, pressure_fault=LEAK)
    assert worse.level == ERROR
    assert "a leak" in worse.message
    assert CLOCK_STANDS_STILL in worse.message


def test_the_diagnostics_hold_what_is_measured():
    measured = MeasuredPressure(6.0e4, 0.125)
    status = diagnosed(State.GRASPING, measured=measured, pressure_fault=LEAK, wrapped=True)
    values = {pair.key: pair.value for pair in status.values}
    assert values["grasping"] == values["wrapped"] == "True"
    assert values["measured_pressure [Pa]"] == "60000"
    assert values["measured_pressure age [s]"] == "0.125"
    assert values["pressure fault"] == "PRESSURE_LOW"
    assert values["internal errors"] == "3"
