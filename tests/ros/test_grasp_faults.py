# SPDX-License-Identifier: Apache-2.0
"""Goals of `grasp` to a node in this process, with parts that break."""

import pytest
from rclpy.action import CancelResponse
from rclpy.executors import SingleThreadedExecutor
from ros.grasp_goals import Goals, handle_of, refused, started

from spiral_gripper_msgs.action import Grasp
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.node.gripper_node import GripperNode

RADIUS = 0.02


@pytest.fixture
def inside(node, client):
    """Goals to a node in this process, which is spun by hand after each of the client's rounds."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    spin_once = client._spinner.spin_once

    def spin_both(timeout_sec):
        executor.spin_once(timeout_sec=0.0)
        spin_once(timeout_sec=min(timeout_sec, 0.001))

    client._spinner.spin_once = spin_both
    goals = Goals(client)
    yield goals
    goals.close()
    executor.shutdown()


def test_a_goal_is_commanded_at_once_not_at_the_next_tick(node):
    before = len(node.published)
    server, handle = node.goals._servers[0], handle_of(Grasp.Goal(object_radius=RADIUS))
    goal = server._execute(handle)
    goal.send(None)
    assert len(node.published) == before + 1
    assert server._cancel(handle) == CancelResponse.ACCEPT
    assert node.published[-1] == 0.0
    assert server._cancel(handle) == CancelResponse.REJECT
    with pytest.raises(StopIteration) as end:
        goal.send(None)
    assert end.value.value.reason == Reason.GRASP_CANCELED
    assert handle.ends == ["canceled"]


def test_an_exception_during_a_goal_is_logged_vents_and_ends_the_goal(node, inside, capfd):
    goal = started(inside.grasp(RADIUS, timeout=[600.0]))
    node.runtime.control._grasp.commanded = lambda *arguments: 1 // 0
    assert "ZeroDivisionError" in refused(goal, Reason.INTERNAL_ERROR)
    assert node.published[-1] == 0.0
    assert node.runtime.control.snapshot().state is State.FAULT
    log = capfd.readouterr().err
    assert "Traceback" in log
    assert "ZeroDivisionError" in log


def test_an_exception_at_the_start_of_a_goal_does_so_too(node, inside, capfd):
    node.runtime.control.start_grasp = lambda *arguments: 1 // 0
    assert "ZeroDivisionError" in refused(inside.grasp(RADIUS), Reason.INTERNAL_ERROR)
    assert node.runtime.control.snapshot().state is State.FAULT
    assert "Traceback" in capfd.readouterr().err


def test_a_fault_ends_the_goal(node, inside):
    goal = started(inside.grasp(RADIUS, timeout=[600.0]))
    node.runtime.fail("broken on purpose")
    assert "broken on purpose" in refused(goal, Reason.INTERNAL_ERROR)
    assert node.published[-1] == 0.0


@pytest.mark.parametrize("is_vented", [True, False])
def test_a_node_that_is_destroyed_during_a_goal_leaves_nothing_behind(namespace, client, is_vented):
    node = GripperNode(namespace=namespace)
    assert node.start()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    goals = Goals(client)

    def spin_until(condition):
        client.wait_until(lambda: (executor.spin_once(timeout_sec=0.01), condition())[1], "it")

    spin_until(goals._action.server_is_ready)
    request = goals._action.send_goal_async(Grasp.Goal(object_radius=RADIUS))
    spin_until(request.done)
    request.result().get_result_async()
    for _ in range(20):
        executor.spin_once(timeout_sec=0.01)
    spin_until(lambda: node.runtime.control.snapshot().state is State.GRASPING)
    if is_vented:
        node.vent()
    executor.remove_node(node)
    node.destroy_node()
    for _ in range(20):
        executor.spin_once(timeout_sec=0.01)
    assert not any(server.is_running for server in node.goals._servers)
    goals.close()
    executor.shutdown()
