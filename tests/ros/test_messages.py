# SPDX-License-Identifier: Apache-2.0
"""Packing: the numbers that go in come out, and names agree with the interfaces."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from ros.control_bench import snapshot
from std_msgs.msg import Header

import spiral_gripper_msgs.msg as messages
from spiral_core import WrapRegime
from spiral_core.errors import SpiralError
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
from spiral_gripper_ros.planning.object_pose import rotated
from spiral_gripper_ros.planning.planner import NoPlanner

INTERFACES = Path(__file__).parents[2] / "spiral_gripper_msgs"
FILES = sorted(str(p.relative_to(INTERFACES)) for p in INTERFACES.glob("*/*.[ams][csr][tgv]*"))
LEAK = Refusal(Reason.PRESSURE_LOW, "a leak")


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


def test_the_backbone_has_the_ends_and_the_frames_of_the_shape(planner):
    state = planner.plan(0.02).wrap.state
    poses = backbone_to_msg(state, 11, Header()).poses
    assert len(poses) == 11
    for index in (0, -1):
        assert vector_from_msg(poses[index].position) == tuple(state.positions[index])
        tangent = rotated(quaternion_from_msg(poses[index].orientation), (1.0, 0.0, 0.0))
        assert tangent == pytest.approx(state.tangents[index], abs=1e-12)


def loaded(planner, regime=None):
    """Return what a loaded gripper tells."""
    return SimpleNamespace(
        shown_regime=lambda _: regime, planner=planner, is_regime_from_contact=True
    )


def test_nothing_known_is_all_finite_and_empty():
    nothing = loaded(NoPlanner((9.8, 0.0, 0.0), SpiralError("nothing")))
    told = snapshot(State.WAITING), nothing
    assert status_to_msg(*told, Header()) == GripStatus(state=State.WAITING)
    wrap = wrap_to_msg(*told, 1.0e5, None, Header())
    assert wrap == messages.Wrap(regime_from_contact=True)


def test_a_status_carries_the_snapshot_and_the_wrap_its_plan(planner):
    plan, gripper = planner.plan(0.02), loaded(planner, WrapRegime.OVERHANG)
    target = plan.pressure + 5.0e3
    told = {"pressure_target": target, "pressure_command": 1.0e4, "wrapped": True}
    known = {"radius": 0.02, "plan": plan, "measured": MeasuredPressure(4.0e4, 0.05)}
    jumped = Refusal(Reason.RADIUS_JUMP, "jumped")
    seen = snapshot(State.HOLDING, jumped, pressure_fault=LEAK, **known, **told)
    assert status_to_msg(seen, gripper, Header(frame_id="base")) == GripStatus(
        header=Header(frame_id="base"),
        state=State.HOLDING,
        reason=Reason.RADIUS_JUMP,
        reason_text="jumped",
        fault=Reason.PRESSURE_LOW,
        fault_text="a leak",
        object_radius=[0.02],
        measured_pressure=[4.0e4],
        regime=GripStatus.REGIME_OVERHANG,
        **told,
    )
    wrap = wrap_to_msg(seen, gripper, 1.0e5, None, Header())
    (figures,), (lowest, highest) = wrap.plan, wrap.radius_range
    assert figures.object_radius == 0.02
    assert figures.pressure == target
    assert figures.overpressure == pytest.approx(5.0e3)
    assert figures.pressure_margin == 1.0e5 - target
    assert figures.line_force == plan.line_force(target)
    assert figures.turns_margin == pytest.approx(figures.turns - planner.gripper.turns_required)
    assert list(figures.radius_margin) == [min(0.02 - lowest, highest - 0.02)]


def diagnosed(state, clock_stands_still=False, **fields):
    health = Health("/node", "id", 3, clock_stands_still)
    return diagnostics_to_msg(health, snapshot(state, **fields), Header().stamp).status[0]


WARNINGS = {State.HOLDING, State.RAMPING_DOWN, State.VENTED, State.TAKEN_OVER}
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@pytest.mark.parametrize("state", State)
def test_the_diagnostics_have_the_level_of_the_worst_and_what_is_measured(state):
    level = ERROR if state is State.FAULT else WARN if state in WARNINGS else OK
    assert diagnosed(state).level == level
    still = diagnosed(state, clock_stands_still=True)
    assert still.level == max(level, WARN)
    assert still.message == f"{state.name.lower().replace('_', ' ')}; {CLOCK_STANDS_STILL}"
    measured = MeasuredPressure(6.0e4, 0.125)
    worse = diagnosed(state, True, measured=measured, pressure_fault=LEAK, wrapped=True)
    assert worse.level == ERROR
    assert worse.message.endswith(f"a leak; {CLOCK_STANDS_STILL}")
    assert {pair.key: pair.value for pair in worse.values}.items() >= {
        "grasping": str(state is State.GRASPING),
        "wrapped": "True",
        "measured_pressure [Pa]": "60000",
        "measured_pressure age [s]": "0.125",
        "pressure fault": "PRESSURE_LOW",
        "internal errors": "3",
    }.items()
