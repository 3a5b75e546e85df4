# SPDX-License-Identifier: Apache-2.0
"""`plan_wrap`, asked from another process."""

import math

import pytest
from geometry_msgs.msg import Vector3
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile
from ros.harness import DEADLINE, RunningNode, all_finite, design_request, plan_request

from spiral_core import WrapCurve
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import ObjectToWrap
from spiral_gripper_msgs.srv import DesignGripper, PlanWrap
from spiral_gripper_ros.control.states import Reason

FLOOD = 150  # three times what may wait
UPRIGHT = Vector3(z=-9.80665)


def vector(of):
    return of.x, of.y, of.z


def test_plan_wrap_answers_what_the_core_answers_and_moves_nothing(active, curve):
    assert active.transition("deactivate")
    active.spin(0.1)
    active.pressures.clear()
    wrap = curve.wrap_for_radius(0.025)
    answer = active.plan_wrap(0.025)
    assert (answer.success, answer.reason) == (True, Reason.NONE)
    (figures,) = answer.figures
    assert figures.pressure == pytest.approx(wrap.pressure, rel=1e-9)
    assert list(figures.object_length_needed) == pytest.approx([wrap.object_length_needed])
    assert list(answer.radius_range) == pytest.approx([curve.radius_min, curve.radius_max])
    assert vector(answer.object_axis[0]) == pytest.approx(wrap.coil.axis, abs=1e-6)
    assert len(answer.backbone.poses) == 50
    assert answer.backbone.header.frame_id == "gripper_base"
    assert not answer.grip  # no table is made in these tests
    assert not active.plan_wrap(0.025, backbone=False).backbone.poses
    assert not active.pressures
    assert active.transition("cleanup")
    for answer in active.plan_wraps([0.02, 0.025]):
        assert (answer.success, answer.reason) == (False, Reason.NOT_ACTIVE)
        assert "configure" in answer.message
    request = design_request(0.011, 0.03)
    assert "configure" in active.call(DesignGripper, "design_gripper", request).message


def test_plan_wrap_for_a_tilted_arm_and_a_given_axis(active, gripper):
    axis = (-0.6, 0.0, -0.8)
    tilted = WrapCurve(gripper.with_mount(vector(UPRIGHT), axis))
    radius = 0.5 * (tilted.radius_min + tilted.radius_max)
    given = {"gravity": [UPRIGHT], "axis": [Vector3(x=-6.0, z=-8.0)]}
    answer = active.plan_wrap(radius, **given)
    wanted = pytest.approx(tilted.pressure_from_radius(radius), rel=1e-9)
    assert answer.figures[0].pressure == wanted
    assert vector(answer.object_axis[0]) == pytest.approx(axis)
    assert answer.radius_range[1] == pytest.approx(tilted.radius_max)
    assert [f.pressure for f in active.plan_wrap(radius).figures] != [wanted]


def test_what_is_asked_beside_the_radius_counts(active):
    plan = active.plan_wrap
    bare, tight = (plan(0.02, overpressure=more).figures[0] for more in (0.0, 1.0e4))
    assert tight.pressure == pytest.approx(bare.pressure + 1.0e4)
    assert tight.line_force > bare.line_force
    (needed,) = bare.object_length_needed
    assert plan(0.02, length=1.01 * needed).success
    assert plan(0.02, length=0.99 * needed).reason == Reason.OBJECT_TOO_SHORT
    assert plan(0.02, friction_coefficient=0.6).success
    (nearest,) = plan(0.2).nearest_radius
    assert plan(nearest).success


def test_many_are_answered_as_each_by_itself_an_axis_of_its_own_each(active):
    objects = [
        *(ObjectToWrap(radius=radius) for radius in (0.02, math.nan, 0.025, 0.2)),
        *(ObjectToWrap(radius=0.02, axis=[Vector3(x=0.3, y=y, z=0.5)]) for y in (0.8, -0.8)),
    ]

    def ask(*asked):
        request = PlanWrap.Request(objects=asked, overpressure=[2.0e3], gravity=[UPRIGHT])
        plans = active.call(PlanWrap, "plan_wrap", request).plans
        assert all_finite(*plans)
        return [(plan.success, plan.reason, plan.message) for plan in plans]

    answers = ask(*objects)
    assert [success for success, _, _ in answers[:4]] == [True, False, True, False]
    assert [ask(one) for one in objects] == [[answer] for answer in answers]
    assert ask() == []


def test_what_cannot_be_is_answered_with_the_reason_and_finite_numbers(active):
    for radius, fields, reason in (
        (math.inf, {}, Reason.RADIUS_NOT_FINITE),
        (0.001, {}, Reason.RADIUS_TOO_SMALL),
        (0.02, {"overpressure": 1.0e6}, Reason.PRESSURE_CAP),
        (0.02, {"length": 0.0}, Reason.INVALID_REQUEST),
        (0.02, {"friction_coefficient": -0.1}, Reason.INVALID_REQUEST),
        (0.02, {"payload": math.inf}, Reason.INVALID_REQUEST),
        (0.02, {"gravity": [Vector3(x=math.nan)]}, Reason.GRAVITY_INVALID),
        (0.02, {"axis": [Vector3()]}, Reason.INVALID_REQUEST),
    ):
        answer = active.plan_wrap(radius, **fields)
        assert (answer.success, answer.reason) == (False, reason)
        assert answer.message
        assert all_finite(answer)


def begin_long_batch(client):
    """Ask for candidates that take long: each axis is planned for anew."""
    axes = [Vector3(x=0.1 + 1e-3 * i, y=0.9, z=0.4) for i in range(1000)]
    objects = [ObjectToWrap(radius=0.02, axis=[axis]) for axis in axes]
    batches = client.create_client(PlanWrap, "plan_wrap")
    assert batches.wait_for_service(DEADLINE)
    answers = batches.call_async(PlanWrap.Request(objects=objects))
    client.spin(0.5)
    return answers


def test_a_plan_does_not_wait_for_a_batch(client, namespace):
    with RunningNode(namespace) as node:
        client.wait_until_active()
        assert client.plan_wrap(0.02).success
        answers = begin_long_batch(client)
        assert client.plan_wrap(0.021).success
        # Nor does the end of the node: nobody wants the rest any more.
        assert node.stop() == 0, node.log()
        client.spin(0.5)
        assert not answers.done()
        assert "Traceback" not in node.log()


def test_a_batch_ends_with_the_gripper_that_it_plans_for(active):
    answers = begin_long_batch(active)
    assert active.transition("deactivate")
    assert active.transition("cleanup")
    active.wait_until(answers.done, "the answer")
    assert len(answers.result().plans) == 1000
    assert answers.result().plans[-1].reason == Reason.NOT_ACTIVE


def test_every_request_of_a_flood_is_answered_if_with_busy(active):
    """The client's own queues are as deep as what it asks."""
    plans = active.create_client(PlanWrap, "plan_wrap", qos_profile=QoSProfile(depth=FLOOD))
    options = {f"{name}_service_qos_profile": QoSProfile(depth=100) for name in ("goal", "result")}
    goals = ActionClient(active, Grasp, "grasp", **options)
    assert plans.wait_for_service(DEADLINE)
    assert goals.wait_for_server(DEADLINE)

    def wait_for(futures):
        active.wait_until(lambda: all(future.done() for future in futures), "every answer")
        return [future.result() for future in futures]

    request = plan_request([0.02])
    answers = [one.plans[0] for one in wait_for([plans.call_async(request) for _ in range(FLOOD)])]
    assert sum(answer.success for answer in answers) >= 50
    assert all(answer.success or answer.message.startswith("busy: ") for answer in answers)
    goal = Grasp.Goal(object_radius=0.02)
    taken = wait_for([goals.send_goal_async(goal) for _ in range(20)])
    results = [one.get_result_async() for one in taken]
    active.release()
    wait_for(results)
    goals.destroy()


def test_more_grips_than_can_be_waited_for_are_refused(active):
    answers = active.plan_wraps([0.02] * 21, compute_grip=True)
    assert len(answers) == 21
    assert all("at most 20" in answer.message for answer in answers)
