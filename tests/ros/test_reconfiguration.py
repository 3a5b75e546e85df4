# SPDX-License-Identifier: Apache-2.0
"""Another gripper on a running node: refused if it is none, vented for, loaded, gripped with."""

import pytest
from rclpy.action import ActionClient
from ros.harness import DEADLINE, all_finite

from spiral_core import WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.control.states import Reason, State

RADIUS = 0.02
OTHER = "prototype_p1"


@pytest.fixture(scope="module")
def other():
    return WrapCurve(load_gripper(OTHER))


def description_of(name):
    return (GRIPPERS.path / f"{name}.yaml").read_text()


def wait_until_loaded(client, curve):
    client.wait_until(
        lambda: (
            client.wraps
            and list(client.wraps[-1].radius_range[1:]) == pytest.approx([curve.radius_max])
        ),
        "the other gripper",
    )


def test_another_gripper_vents_is_loaded_and_followed_after_rearm(active, other):
    active.wrap(RADIUS)
    assert active.set_parameter("gripper", OTHER).successful
    status = active.wait_for_state(State.RELEASED, Reason.RECONFIGURED)
    assert status.pressure_command == status.pressure_target == 0.0
    wait_until_loaded(active, other)
    active.wait_until(lambda: active.pressures[-1] == 0.0, "the vent")
    active.forget()
    for _ in range(5):
        active.send_radius(RADIUS)
        active.hear_more(1)
    assert set(active.pressures) == {0.0}
    assert active.status.state == State.RELEASED
    assert active.rearm().success
    status = active.wrap(RADIUS)
    assert status.pressure_command == pytest.approx(other.pressure_from_radius(RADIUS), rel=1e-9)
    told = active.wait_for_plan(RADIUS, status.pressure_target)
    margin = other.gripper.pressure_max - status.pressure_target
    assert told.plan[0].pressure_margin == pytest.approx(margin)
    active.wait_until(
        lambda: active.diagnostics and active.diagnostics[-1].hardware_id == OTHER, "diagnostics"
    )
    assert all_finite(*active.statuses, *active.backbones)


def test_a_grasp_goal_is_wish_enough_to_grip_with_the_other(active, other):
    active.wrap(RADIUS)
    assert active.set_parameter("gripper", OTHER).successful
    wait_until_loaded(active, other)
    client = ActionClient(active, Grasp, "grasp")
    assert client.wait_for_server(DEADLINE)
    sent = client.send_goal_async(Grasp.Goal(object_radius=RADIUS))
    active.wait_until(sent.done, "the goal's acceptance")
    ended = sent.result().get_result_async()
    active.wait_until(ended.done, "the goal's end")
    result = ended.result().result
    assert result.success
    expected = other.pressure_from_radius(RADIUS)
    assert result.pressure_command == pytest.approx(expected, rel=1e-9)
    client.destroy()


def test_the_limit_of_the_other_gripper_is_the_cap(active, tmp_path):
    file = tmp_path / "weak.yaml"
    text = description_of(OTHER)
    assert "pressure_max: 16 psi" in text
    file.write_text(text.replace("pressure_max: 16 psi", "pressure_max: 60 kPa"))
    assert active.set_parameter("gripper", str(file)).successful
    active.wait_for_state(State.RELEASED, Reason.RECONFIGURED)
    wait_until_loaded(active, WrapCurve(load_gripper(file)))
    assert active.rearm().success
    status = active.wrap(RADIUS)
    told = active.wait_for_plan(RADIUS, status.pressure_target)
    assert told.plan[0].pressure_margin == pytest.approx(6.0e4 - status.pressure_target)


def test_a_gripper_that_is_none_is_refused_and_the_grip_is_kept(active, tmp_path):
    pressure = active.wrap(RADIUS).pressure_command
    active.pressures.clear()
    file = tmp_path / "wrong.yaml"
    file.write_text(description_of(OTHER).replace("length:", "lenght:", 1))
    for name, reason in (("no_such_gripper", "no gripper has this name"), (str(file), "lenght")):
        result = active.set_parameter("gripper", name)
        assert not result.successful
        assert reason in result.reason
    active.hear_more()
    assert set(active.pressures) == {pressure}
    assert active.get_parameter_of_node("gripper") == "paper_design_70"


def test_a_gripper_that_cannot_coil_is_a_fault_until_a_good_one_is_loaded(active, other, tmp_path):
    active.wrap(RADIUS)
    file = tmp_path / "short.yaml"
    text = description_of(OTHER)
    assert "pressure_max: 16 psi" in text
    file.write_text(text.replace("pressure_max: 16 psi", "pressure_max: 1 kPa"))
    assert active.set_parameter("gripper", str(file)).successful
    status = active.wait_for_state(State.FAULT, Reason.INTERNAL_ERROR)
    assert "cannot be used" in status.reason_text
    assert status.pressure_command == 0.0
    # Re-armed with it, it still grips nothing and says why.
    assert active.rearm().success
    active.send_radius(RADIUS)
    status = active.wait_for_state(State.WAITING, Reason.NOT_CERTIFIED)
    assert "turns" in status.reason_text
    assert active.set_parameter("gripper", OTHER).successful
    wait_until_loaded(active, other)
    active.rearm()
    active.wrap(RADIUS)
    assert all_finite(*active.statuses)


def test_gravity_that_was_told_is_kept_for_the_other_gripper(active, other):
    gravity = (0.0, 0.0, -9.80665)
    before = active.wait_for_plan(RADIUS, active.wrap(RADIUS).pressure_target).radius_range
    active.send_gravity(gravity)
    expected = WrapCurve(other.gripper.with_mount(gravity, None))
    active.wait_until(lambda: active.wraps[-1].radius_range != before, "the gravity")
    assert active.set_parameter("gripper", OTHER).successful
    wait_until_loaded(active, expected)


def test_an_inactive_node_loads_the_other_gripper_too(active, other):
    assert active.transition("deactivate")
    active.pressures.clear()
    assert active.set_parameter("gripper", OTHER).successful
    active.wait_until(
        lambda: (
            [f.pressure for f in active.plan_wrap(RADIUS).figures]
            == pytest.approx([other.pressure_from_radius(RADIUS)], rel=1e-9)
        ),
        "a plan with the other gripper",
    )
    assert not any(active.pressures)
    assert active.transition("activate")
    active.wait_until_active()
    assert active.wrap(RADIUS).state == State.TRACKING


def test_the_same_gripper_again_reads_its_file_anew(active, tmp_path):
    file = tmp_path / "mine.yaml"
    for limit in ("16 psi", "60 kPa"):
        file.write_text(
            description_of(OTHER).replace("pressure_max: 16 psi", f"pressure_max: {limit}")
        )
        expected = WrapCurve(load_gripper(file))
        assert active.set_parameter("gripper", str(file)).successful
        wait_until_loaded(active, expected)
        active.wait_until(
            lambda expected=expected: (
                list(active.wraps[-1].radius_range[:1]) == pytest.approx([expected.radius_min])
            ),
            "the file as it is now",
        )
