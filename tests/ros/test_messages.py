# SPDX-License-Identifier: Apache-2.0
"""Packing: the numbers that go in come out, and names agree with the interfaces."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from ros.control_bench import snapshot
from ros.records import agrees
from std_msgs.msg import Header

import spiral_gripper_msgs.msg as messages
from spiral_core import WrapRegime
from spiral_core.errors import SpiralError
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State
from spiral_gripper_ros.messages.conversions import (
    REGIMES,
    backbone_to_msg,
    quaternion_from_msg,
    status_to_msg,
    vector_from_msg,
    wrap_to_msg,
)
from spiral_gripper_ros.messages.diagnostics import Health, diagnostics_to_msg
from spiral_gripper_ros.planning.object_pose import rotated
from spiral_gripper_ros.planning.planner import NoPlanner

INTERFACES = Path(__file__).parents[2] / "spiral_gripper_msgs"
FILES = sorted(str(p.relative_to(INTERFACES)) for p in INTERFACES.glob("*/*.[ams][csr][tgv]*"))


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


def test_nothing_known_is_all_finite_and_empty():
    planner = NoPlanner((9.8, 0.0, 0.0), SpiralError("nothing"))
    own = {"shown_regime": lambda _: None, "planner": planner, "is_regime_from_contact": True}
    told = snapshot(State.WAITING), SimpleNamespace(**own)
    assert status_to_msg(*told, Header()) == GripStatus(state=State.WAITING)
    wrap = wrap_to_msg(*told, 1.0e5, None, Header())
    assert wrap == messages.Wrap(regime_from_contact=True)


def diagnosed(state, clock_stands_still=False, **fields):
    health = Health("/node", "id", 3, clock_stands_still)
    return diagnostics_to_msg(health, snapshot(state, **fields), Header().stamp).status[0]


def test_the_diagnostics_of_every_state_are_those_on_record():
    found = [
        f"{one.level[0]} {one.message}"
        for state in State
        for still in (False, True)
        for fault in (NOT_REFUSED, Refusal(Reason.PRESSURE_LOW, "a leak"))
        for one in [diagnosed(state, still, pressure_fault=fault)]
    ]
    agrees("diagnostics", "\n".join(found))
