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
from spiral_gripper_msgs.msg import GripStatus
from spiral_gripper_ros.control.states import NOT_REFUSED, Reason, Refusal, State
from spiral_gripper_ros.messages.conversions import REGIMES, status_to_msg
from spiral_gripper_ros.messages.diagnostics import diagnostics_to_msg

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
def test_every_number_of_an_interface_says_its_unit(name):
    fields = re.findall(r"^(float64(?:\[.*?\])?) (\w+)(.*)$", definition(name), re.MULTILINE)
    assert fields or name == "msg/Reason.msg"
    for _, field, rest in fields:
        assert re.search(r"#.*(\[[\w/^ ]+\]|SI)", rest), f"{field} of {name} names no unit"


def test_the_status_states_gravity_s_fault_unless_the_pressure_has_one():
    gravity, leak = Refusal(Reason.GRAVITY_STALE, "silent"), Refusal(Reason.PRESSURE_LOW, "a leak")
    loaded = SimpleNamespace(shown_regime=lambda snapshot: None)
    for pressure, told in ((NOT_REFUSED, gravity), (leak, leak)):
        seen = snapshot(State.TRACKING, pressure_fault=pressure, gravity_fault=gravity)
        status = status_to_msg(seen, loaded, Header())
        assert (status.fault, status.fault_text) == (told.reason, told.text)


def test_the_diagnostics_of_every_state_are_those_on_record():
    found = [
        f"{one.level[0]} {one.message}"
        for state in State
        for still in (False, True)
        for fault in (NOT_REFUSED, Refusal(Reason.PRESSURE_LOW, "a leak"))
        for one in diagnostics_to_msg(
            snapshot(state, pressure_fault=fault),
            Header().stamp,
            "/node",
            "id",
            3,
            clock_stands_still=still,
        ).status
    ]
    agrees("diagnostics", "\n".join(found))
