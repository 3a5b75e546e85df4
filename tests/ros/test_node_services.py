# SPDX-License-Identifier: Apache-2.0
"""`plan_wrap`, asked from another process."""

import pytest
from geometry_msgs.msg import Vector3
from rclpy.qos import QoSProfile
from ros.harness import DEADLINE, RunningNode, plan_request

from spiral_core import WrapCurve
from spiral_gripper_msgs.msg import ObjectToWrap
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.messages.conversions import vector_from_msg

FLOOD = 150  # three times what may wait
UPRIGHT = Vector3(z=-9.80665)


def test_plan_wrap_answers_what_the_core_answers_and_moves_nothing(active, gripper):
    assert active.transition("deactivate")
    active.spin(0.1)
    active.pressures.clear()
    known = WrapCurve(gripper.with_mount(vector_from_msg(UPRIGHT), (-0.6, 0.0, -0.8)))
    radius = 0.5 * (known.radius_min + known.radius_max)
    axis = Vector3(x=-6.0, z=-8.0)
    wrap = known.wrap_for_radius(radius)
    answer = active.plan_wrap(radius, gravity=[UPRIGHT], axis=[axis])
    (figures,) = answer.figures
    assert figures.pressure == pytest.approx(wrap.pressure, rel=1e-9)
    assert vector_from_msg(answer.object_axis[0]) == pytest.approx(wrap.coil.axis, abs=1e-6)
    assert len(answer.backbone.poses) == 50
    assert not active.pressures
    assert active.transition("cleanup")
    assert "configure" in active.plan_wrap(0.02).message


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
        answers = begin_long_batch(client)
        begin_long_batch(client)  # which waits for the first
        assert client.plan_wrap(0.021).success
        # Nor does the end of the node: nobody wants the rest any more.
        assert node.stop() == 0, node.log()
        client.spin(0.5)
        assert not answers.done()
        assert "Traceback" not in node.log()


def test_a_batch_ends_with_the_gripper_that_it_plans_for(active):
    answers = begin_long_batch(active)
    for transition in ("deactivate", "cleanup"):
        assert active.transition(transition)
    active.wait_until(answers.done, "the answer")
    assert len(answers.result().plans) == 1000
    assert answers.result().plans[-1].reason == Reason.NOT_ACTIVE


def test_every_request_of_a_flood_is_answered_if_with_busy(active):
    """The client's own queues are as deep as what it asks."""
    plans = active.create_client(PlanWrap, "plan_wrap", qos_profile=QoSProfile(depth=FLOOD))
    assert plans.wait_for_service(DEADLINE)
    futures = [plans.call_async(plan_request([0.02])) for _ in range(FLOOD)]
    active.wait_until(lambda: all(future.done() for future in futures), "every answer")
    answers = [future.result().plans[0] for future in futures]
    assert sum(answer.success for answer in answers) >= 50
    assert all(answer.success or answer.message.startswith("busy: ") for answer in answers)


def test_more_grips_than_can_be_waited_for_are_refused(active):
    request = plan_request([0.02] * 21, compute_grip=True)
    answers = active.call(PlanWrap, "plan_wrap", request).plans
    assert ["at most 20" in answer.message for answer in answers] == [True] * 21
