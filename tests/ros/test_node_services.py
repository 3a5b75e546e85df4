# SPDX-License-Identifier: Apache-2.0
"""`plan_wrap` and `design_gripper`, asked from another process."""

import math

import pytest
from geometry_msgs.msg import Vector3
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile
from ros.harness import DEADLINE, RunningNode, all_finite, plan_request

from spiral_core import WrapCurve
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import ObjectToWrap
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.control.states import Reason

FLOOD = 150  # three times what may wait


def test_plan_wrap_answers_what_the_core_answers(active, curve):
    wrap = curve.wrap_for_radius(0.025)
    answer = active.plan_wrap(0.025)
    assert answer.success
    assert answer.reason == Reason.NONE
    (figures,) = answer.figures
    assert figures.stable
    assert figures.object_radius == 0.025
    assert figures.pressure == pytest.approx(wrap.pressure, rel=1e-9)
    assert figures.turns == pytest.approx(wrap.turns, rel=1e-6)
    assert figures.contact_length == pytest.approx(wrap.contact_length)
    lengths = (*figures.gripper_length_needed, *figures.object_length_needed)
    expected = (wrap.gripper_length_needed, wrap.object_length_needed)
    assert lengths == pytest.approx(expected, rel=1e-6)
    assert list(answer.radius_range) == pytest.approx([curve.radius_min, curve.radius_max])
    (axis,) = answer.object_axis
    assert (axis.x, axis.y, axis.z) == pytest.approx(wrap.coil.axis, abs=1e-6)
    assert len(answer.backbone.poses) == 50
    assert answer.backbone.header.frame_id == "gripper_base"
    assert not answer.grip  # no table is made in these tests


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
        axis=[Vector3(x=axis[0], y=axis[1], z=axis[2])],
    )
    assert answer.success
    assert answer.figures[0].pressure == pytest.approx(expected.pressure, rel=1e-9)
    (given,) = answer.object_axis
    assert (given.x, given.y, given.z) == pytest.approx(unit)
    assert answer.radius_range[1] == pytest.approx(tilted.radius_max)
    assert active.plan_wrap(radius).figures[0].pressure != pytest.approx(
        expected.pressure, rel=1e-4
    )


def test_more_pressure_presses_more(active):
    loose, tight = active.plan_wrap(0.02), active.plan_wrap(0.02, overpressure=1.0e4)
    bare = active.plan_wrap(0.02, overpressure=0.0)
    assert bare.figures[0].overpressure == 0.0
    assert tight.figures[0].pressure == pytest.approx(bare.figures[0].pressure + 1.0e4)
    assert tight.figures[0].line_force > loose.figures[0].line_force


# --- many candidates at once -------------------------------------------------------------------


def test_many_are_answered_as_each_by_itself(active):
    radii = [0.02, math.nan, 0.001, 0.025, -1.0, 0.2, 0.02]
    fields = {"payload": 0.02, "overpressure": 2.0e3, "length": 0.3}
    answers = active.plan_wraps(radii, **fields)
    assert all_finite(*answers)
    assert [answer.success for answer in answers] == [True, False, False, True, False, False, True]
    for radius, answer in zip(radii, answers, strict=True):
        one = active.plan_wrap(radius, **fields)
        assert (answer.success, answer.reason, answer.message) == (
            one.success,
            one.reason,
            one.message,
        )
        assert [f.pressure for f in answer.figures] == [f.pressure for f in one.figures]
        assert len(answer.backbone.poses) == len(one.backbone.poses) == 50 * answer.success
    assert not active.plan_wrap(0.02, backbone=False).backbone.poses


def test_each_has_an_axis_of_its_own_and_all_one_gravity(active):
    axes = [Vector3(x=0.3, y=0.8, z=0.5), Vector3(), Vector3(x=-0.3, y=-0.8, z=-0.5)]
    gravity = [Vector3(z=-9.80665)]
    objects = [ObjectToWrap(radius=0.02, axis=[axis]) for axis in axes]
    request = PlanWrap.Request(objects=objects, gravity=gravity)
    answers = active.call(PlanWrap, "plan_wrap", request).plans
    assert answers[1].reason == Reason.INVALID_REQUEST
    for index in (0, 2):
        one = active.plan_wrap(0.02, axis=[axes[index]], gravity=gravity)
        assert (answers[index].success, answers[index].reason) == (one.success, one.reason)
        assert [f.pressure for f in answers[index].figures] == [f.pressure for f in one.figures]


def test_a_friction_that_cannot_be_is_named(active):
    answers = active.plan_wraps([0.02, 0.025], friction_coefficient=-0.1)
    assert [answer.reason for answer in answers] == [Reason.INVALID_REQUEST] * 2
    assert "friction_coefficient" in answers[0].message
    answers = active.plan_wraps([0.02, 0.025], friction_coefficient=0.6)
    assert all(answer.success for answer in answers)


def test_nothing_is_an_empty_answer(active):
    assert not active.plan_wraps([])


def test_many_without_a_gripper_are_refused_each(active):
    assert active.transition("deactivate")
    assert active.transition("cleanup")
    answers = active.plan_wraps([0.02, 0.025])
    assert [answer.reason for answer in answers] == [Reason.NOT_ACTIVE] * 2
    assert "configure" in answers[1].message


def long_batch():
    """Candidates that take long: each axis is planned for anew."""
    axes = [Vector3(x=0.1 + 1e-3 * i, y=0.9, z=0.4) for i in range(1000)]
    return PlanWrap.Request(objects=[ObjectToWrap(radius=0.02, axis=[axis]) for axis in axes])


def test_a_plan_does_not_wait_for_a_batch(client, namespace):
    with RunningNode(namespace) as node:
        client.wait_until_active()
        assert client.plan_wrap(0.02).success
        batches = client.create_client(PlanWrap, "plan_wrap")
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
    batches = active.create_client(PlanWrap, "plan_wrap")
    assert batches.wait_for_service(DEADLINE)
    answers = batches.call_async(long_batch())
    active.spin(0.5)
    assert active.transition("deactivate")
    assert active.transition("cleanup")
    active.wait_until(answers.done, "the answer")
    assert len(answers.result().plans) == 1000
    assert answers.result().plans[-1].reason == Reason.NOT_ACTIVE
    active.destroy_client(batches)


def test_an_object_that_is_too_short_is_refused(active):
    needed = active.plan_wrap(0.02).figures[0].object_length_needed[0]
    assert active.plan_wrap(0.02, length=1.01 * needed).success
    answer = active.plan_wrap(0.02, length=0.99 * needed)
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
        (0.02, {"length": math.nan}, Reason.INVALID_REQUEST),
        (0.02, {"length": 0.0}, Reason.INVALID_REQUEST),
        (0.02, {"friction_coefficient": -0.1}, Reason.INVALID_REQUEST),
        (0.02, {"payload": -0.1}, Reason.INVALID_REQUEST),
        (0.02, {"payload": math.inf}, Reason.INVALID_REQUEST),
        (0.02, {"gravity": [Vector3(x=math.nan)]}, Reason.GRAVITY_INVALID),
        (0.02, {"axis": [Vector3()]}, Reason.INVALID_REQUEST),
        (0.02, {"axis": [Vector3(y=math.inf)]}, Reason.INVALID_REQUEST),
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
    assert list(answer.nearest_radius) == pytest.approx([curve.radius_max])
    assert active.plan_wrap(answer.nearest_radius[0]).success


def test_a_lower_cap_counts_for_plans_too(active):
    assert active.set_parameter("pressure.cap", 5.0e4).successful
    answer = active.plan_wrap(0.011)
    assert answer.reason == Reason.PRESSURE_CAP
    assert "50000" in answer.message


def test_every_request_of_a_flood_is_answered_if_with_busy(active):
    """The client's own queues are as deep as what it asks."""
    qos = QoSProfile(depth=FLOOD)
    plans = active.create_client(PlanWrap, "plan_wrap", qos_profile=qos)
    assert plans.wait_for_service(DEADLINE)
    request = plan_request([0.02])
    futures = [plans.call_async(request) for _ in range(FLOOD)]
    active.wait_until(lambda: all(future.done() for future in futures), "every plan")
    answers = [future.result().plans[0] for future in futures]
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
    answers = active.plan_wraps([0.02] * 21, compute_grip=True)
    assert len(answers) == 21
    assert all("at most 20" in answer.message for answer in answers)
