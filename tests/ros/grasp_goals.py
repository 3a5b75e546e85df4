# SPDX-License-Identifier: Apache-2.0
"""Sends goals to an action as a user's node would."""

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile
from ros.harness import DESIGN_DEADLINE, all_finite

from spiral_gripper_msgs.action import Grasp


class Goal:
    """A goal on its way, with everything that was heard of it."""

    def __init__(self, client, action, request):
        self.client, self.feedback = client, []
        answer = action.send_goal_async(
            request, feedback_callback=lambda message: self.feedback.append(message.feedback)
        )
        client.wait_until(answer.done, "an answer to the goal")
        self.handle = answer.result()
        assert self.handle.accepted
        self._result = self.handle.get_result_async()

    @property
    def is_done(self):
        return self._result.done()

    @property
    def is_started(self):
        return self.feedback and self.feedback[-1].pressure_command > 0.0

    def end(self):
        """Wait for the end; return the goal's status and its result."""
        self.client.wait_until(self._result.done, "the end of the goal", DESIGN_DEADLINE)
        response = self._result.result()
        return response.status, response.result

    def cancel(self):
        """Cancel; return whether the node has accepted that."""
        answer = self.handle.cancel_goal_async()
        self.client.wait_until(answer.done, "an answer to the cancel request")
        return len(answer.result().goals_canceling) == 1


class Goals:
    """What a client of the harness sends to one action of a node."""

    def __init__(self, client, kind=Grasp, name="grasp"):
        self.client, self.kind = client, kind
        # A busy machine reads late: no feedback of a goal may fall out of the queue.
        queue = QoSProfile(depth=1000)
        self._action = ActionClient(client, kind, name, feedback_sub_qos_profile=queue)

    def close(self):
        self._action.destroy()

    def send(self, request):
        self.client.wait_until(self._action.server_is_ready, "the action")
        return Goal(self.client, self._action, request)

    def grasp(self, radius, **fields):
        return self.send(Grasp.Goal(object_radius=radius, **fields))


def started(goal):
    """Return a goal once its command is on the way."""
    goal.client.wait_until(lambda: goal.is_started, "the command to rise")
    return goal


def refused(goal, reason):
    """Return the message of a goal that has failed, for this reason."""
    status, result = goal.end()
    assert status == GoalStatus.STATUS_ABORTED
    assert not result.success
    assert result.reason == reason, result.message
    assert result.message
    assert all_finite(result)
    return result.message
