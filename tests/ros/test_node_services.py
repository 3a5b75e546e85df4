# SPDX-License-Identifier: Apache-2.0
"""`plan_wrap` and `design_gripper`, asked from another process."""

import math

import pytest
from geometry_msgs.msg import Vector3
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile
from ros.harness import DEADLINE, RunningNode, all_finite

from spiral_core import WrapCurve
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.srv import PlanWrap, PlanWraps
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.node import plan_service

FLOOD = 150  # three times what may wait


def test_plan_wrap_answers_what_the_core_answers(active, curve):
    wrap = curve.wrap_for_radius(0.025)
    answer = active.plan_wrap(0.025)
    assert answer.success
    assert answer.reason == Reason.NONE
    assert answer.stable
    assert answer.nearest_radius == 0.025
    assert answer.pressure == pytest.approx(wrap.pressure, rel=1e-9)
    assert answer.turns == pytest.approx(wrap.turns, rel=1e-6)
    assert answer.contact_length == pytest.approx(wrap.contact_length)
    assert answer.gripper_length_needed == pytest.approx(wrap.gripper_length_needed, rel=1e-6)
    assert answer.object_length_needed == pytest.approx(wrap.object_length_needed, rel=1e-6)
    assert (answer.radius_min, answer.radius_max) == (
        pytest.approx(curve.radius_min),
        pytest.approx(curve.radius_max),
    )
    axis = answer.object_axis
    assert (axis.x, axis.y, axis.z) == pytest.approx(wrap.coil.axis, abs=1e-6)
    assert len(answer.backbone.poses) == 50
    assert answer.backbone.header.frame_id == "gripper_base"
    assert not answer.grip.known  # no table is made in these tests


def test_plan_wrap_moves_nothing_and_is_answered_while_inactive(active):
    assert active.transition("deactivate")
    active.spin(0.1)
    active.pressures.clear()
    assert active.plan_wrap(0.02).success
    active.spin(0.1)
    assert active.pressures == []


def test_plan_wrap_without_a_gripper_says_so(active):
    assert active.transition("deactivate")
    assert active.transition("cleanup")
    answer = active.plan_wrap(0.02)
    assert not answer.success
    assert answer.reason == Reason.NOT_ACTIVE
    assert "configure" in answer.message
    assert "configure" in active.design_gripper(0.011, 0.03).message


def test_plan_wrap_for_a_tilted_arm_and_a_given_axis(active, gripper):
    gravity = (0.0, 0.0, -9.80665)
    x, y, z = WrapCurve(gripper.with_mount(gravity, None)).wrap_for_radius(0.02).coil.axis
    axis = (x, y, z + 0.05)
    unit = tuple(component / math.hypot(*axis) for component in axis)
    tilted = WrapCurve(gripper.with_mount(gravity, unit))
    radius = 0.5 * (tilted.radius_min + tilted.radius_max)
    expected = tilted.wrap_for_radius(radius)
    answer = active.plan_wrap(
        radius,
        gravity=[Vector3(x=gravity[0], y=gravity[1], z=gravity[2])],
        object_axis=[Vector3(x=axis[0], y=axis[1], z=axis[2])],
    )
    assert answer.success
    assert answer.pressure == pytest.approx(expected.pressure, rel=1e-9)
    given = answer.object_axis
    assert (given.x, given.y, given.z) == pytest.approx(unit)
    assert answer.radius_max == pytest.approx(tilted.radius_max)
    assert active.plan_wrap(radius).pressure != pytest.approx(expected.pressure, rel=1e-4)


def test_more_pressure_presses_more(active):
    loose, tight = active.plan_wrap(0.02), active.plan_wrap(0.02, overpressure=1.0e4)
    assert tight.pressure == pytest.approx(loose.pressure + 1.0e4)
    assert tight.line_force > loose.line_force


# --- many candidates at once -------------------------------------------------------------------


def plan_wraps(client, radii, **fields):
    return client.call(
        PlanWraps, "plan_wraps", PlanWraps.Request(object_radius=radii, **fields), deadline=DEADLINE
    )


def test_plan_wraps_answers_for_each_what_plan_wrap_answers(active):
    radii = [0.02, math.nan, 0.001, 0.025, -1.0, 0.2, 0.02]
    fields = {"payload": 0.02, "overpressure": 2.0e3, "object_length": 0.3}
    answers = plan_wraps(active, radii, **fields)
    assert all_finite(answers)
    for index, radius in enumerate(radii):
        one = active.plan_wrap(radius, **fields)
        for name in plan_service._LISTED:
            assert getattr(answers, name)[index] == getattr(one, name), (name, radius)
    assert list(answers.success) == [True, False, False, True, False, False, True]
    assert all(len(getattr(answers, name)) == len(radii) for name in plan_service._LISTED)


def test_plan_wraps_takes_an_axis_for_each_and_one_gravity(active):
    axes = [Vector3(x=0.3, y=0.8, z=0.5), Vector3(), Vector3(x=-0.3, y=-0.8, z=-0.5)]
    gravity = [Vector3(z=-9.80665)]
    answers = plan_wraps(active, [0.02] * 3, object_axis=axes, gravity=gravity)
    assert answers.reason[1] == Reason.INVALID_REQUEST
    for index in (0, 2):
        one = active.plan_wrap(0.02, object_axis=[axes[index]], gravity=gravity)
        assert (answers.success[index], answers.reason[index]) == (one.success, one.reason)
        assert answers.pressure[index] == one.pressure


def test_plan_wraps_takes_one_friction_for_all(active):
    answers = plan_wraps(active, [0.02, 0.025], friction_coefficient=-0.1)
    assert list(answers.reason) == [Reason.INVALID_REQUEST] * 2
    assert "friction_coefficient" in answers.message[0]
    assert all(plan_wraps(active, [0.02, 0.025], friction_coefficient=0.6).success)


def test_plan_wraps_of_nothing_is_an_empty_answer(active):
    answers = plan_wraps(active, [])
    assert not any(len(getattr(answers, name)) for name in plan_service._LISTED)


def test_axes_that_do_not_belong_to_the_radii_are_refused_for_all(active):
    answers = plan_wraps(active, [0.02, 0.025, 0.03], object_axis=[Vector3(z=1.0)] * 2)
    assert list(answers.success) == [False] * 3
    assert set(answers.reason) == {Reason.INVALID_REQUEST}
    assert "3, got 2" in answers.message[0]


def test_plan_wraps_without_a_gripper_says_so(active):
    assert active.transition("deactivate")
    assert active.transition("cleanup")
    answers = plan_wraps(active, [0.02, 0.025])
    assert list(answers.reason) == [Reason.NOT_ACTIVE] * 2
    assert "configure" in answers.message[1]


def long_batch():
    """Candidates that take long: each axis is planned for anew."""
    axes = [Vector3(x=0.1 + 1e-3 * i, y=0.9, z=0.4) for i in range(1000)]
    return PlanWraps.Request(object_radius=[0.02] * 1000, object_axis=axes)


def test_a_plan_does_not_wait_for_a_batch(client, namespace):
    with RunningNode(namespace) as node:
        client.wait_until_active()
        assert client.plan_wrap(0.02).success
        batches = client.create_client(PlanWraps, "plan_wraps")
        assert batches.wait_for_service(DEADLINE)
        answers = batches.call_async(long_batch())
        client.spin(0.5)
        assert client.plan_wrap(0.021).success
        # Nor does the end of the node: nobody wants the rest any more.
        assert node.stop() == 0, node.log()
        client.spin(0.5)
        assert not answers.done()
        assert "Traceback" not in node.log()


def test_a_batch_ends_with_the_gripper_that_it_plans_for(active):
    batches = active.create_client(PlanWraps, "plan_wraps")
    assert batches.wait_for_service(DEADLINE)
    answers = batches.call_async(long_batch())
    active.spin(0.5)
    assert active.transition("deactivate")
    assert active.transition("cleanup")
    active.wait_until(answers.done, "the answer")
    assert len(answers.result().reason) == 1000
    assert answers.result().reason[-1] == Reason.NOT_ACTIVE
    active.destroy_client(batches)


def test_an_object_that_is_too_short_is_refused(active):
    needed = active.plan_wrap(0.02).object_length_needed
    assert active.plan_wrap(0.02, object_length=1.01 * needed).success
    answer = active.plan_wrap(0.02, object_length=0.99 * needed)
    assert not answer.success
    assert answer.reason == Reason.OBJECT_TOO_SHORT


@pytest.mark.parametrize(
    ("radius", "fields", "reason"),
    [
        (math.nan, {}, Reason.RADIUS_NOT_FINITE),
        (math.inf, {}, Reason.RADIUS_NOT_FINITE),
        (-0.02, {}, Reason.RADIUS_NOT_POSITIVE),
        (0.0, {}, Reason.RADIUS_NOT_POSITIVE),
        (0.001, {}, Reason.RADIUS_TOO_SMALL),
        (0.2, {}, Reason.RADIUS_TOO_LARGE),
        (0.02, {"overpressure": 1.0e6}, Reason.PRESSURE_CAP),
        (0.02, {"overpressure": math.nan}, Reason.INVALID_REQUEST),
        (0.02, {"overpressure": -1.0}, Reason.INVALID_REQUEST),
        (0.02, {"object_length": math.nan}, Reason.INVALID_REQUEST),
        (0.02, {"friction_coefficient": -0.1}, Reason.INVALID_REQUEST),
        (0.02, {"payload": -0.1}, Reason.INVALID_REQUEST),
        (0.02, {"payload": math.inf}, Reason.INVALID_REQUEST),
        (0.02, {"gravity": [Vector3(x=math.nan)]}, Reason.GRAVITY_INVALID),
        (0.02, {"object_axis": [Vector3()]}, Reason.INVALID_REQUEST),
        (0.02, {"object_axis": [Vector3(y=math.inf)]}, Reason.INVALID_REQUEST),
    ],
)
def test_what_cannot_be_is_answered_with_the_reason_and_finite_numbers(
    active, radius, fields, reason
):
    answer = active.plan_wrap(radius, **fields)
    assert not answer.success
    assert answer.reason == reason
    assert answer.message
    assert all_finite(answer)


def test_the_nearest_radius_is_named(active, curve):
    answer = active.plan_wrap(0.2)
    assert answer.nearest_radius == pytest.approx(curve.radius_max)
    assert active.plan_wrap(answer.nearest_radius).success


def test_a_lower_cap_counts_for_plans_too(active):
    assert active.set_parameter("pressure_cap", 5.0e4).successful
    answer = active.plan_wrap(0.011)
    assert answer.reason == Reason.PRESSURE_CAP
    assert "50000" in answer.message


def test_every_request_of_a_flood_is_answered_if_with_busy(active):
    """The client's own queues are as deep as what it asks."""
    qos = QoSProfile(depth=FLOOD)
    plans = active.create_client(PlanWrap, "plan_wrap", qos_profile=qos)
    assert plans.wait_for_service(DEADLINE)
    request = PlanWrap.Request(object_radius=0.02)
    futures = [plans.call_async(request) for _ in range(FLOOD)]
    active.wait_until(lambda: all(future.done() for future in futures), "every plan")
    answers = [future.result() for future in futures]
    assert sum(answer.success for answer in answers) >= 50
    assert all(answer.success or answer.message.startswith("busy: ") for answer in answers)
    active.destroy_client(plans)


def test_twenty_goals_at_once_are_all_answered(active):
    options = {f"{name}_service_qos_profile": QoSProfile(depth=100) for name in ("goal", "result")}
    goals = ActionClient(active, Grasp, "grasp", **options)
    assert goals.wait_for_server(DEADLINE)
    sent = [goals.send_goal_async(Grasp.Goal(object_radius=0.02)) for _ in range(20)]
    active.wait_until(lambda: all(future.done() for future in sent), "every goal")
    results = [future.result().get_result_async() for future in sent]
    active.release()
    active.wait_until(lambda: all(future.done() for future in results), "every result")
    goals.destroy()


def test_more_grips_than_can_be_waited_for_are_refused(active):
    request = PlanWraps.Request(object_radius=[0.02] * 21, compute_grip=True)
    answer = active.call(PlanWraps, "plan_wraps", request)
    assert len(answer.message) == 21
    assert all("at most 20" in message for message in answer.message)
