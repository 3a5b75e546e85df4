# SPDX-License-Identifier: Apache-2.0
"""The gripper's Python client: wrap, wait, release, without knowledge of ROS.

It spins a node of its own within its calls: in a script, or inside another node's callback.
"""

from __future__ import annotations

import time
from typing import Any

from geometry_msgs.msg import Pose
from rclpy.action import ActionClient
from rclpy.task import Future
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from spiral_core.validation import require_non_negative, require_positive
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.msg import GripStatus, ObjectToWrap, PlannedWrap, Wrap
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.client.answers import (
    NoAnswerError,
    RequestRefusedError,
    WrapResult,
    no_node_in,
)
from spiral_gripper_ros.client.connection import Connection
from spiral_gripper_ros.client.goals import (
    LateCancel,
    goal_with,
    non_negative,
    result_of_wrap,
)
from spiral_gripper_ros.control.limits import AbortPolicy
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.messages.qos import LATEST

# is_done and status let messages arrive for so long [s].
GLANCE = 0.1
# A node that is silent for so long is asked for a sign of life; it has as long for it, less a
# glance [s]. Its status comes more often, but not while a simulated clock stands still.
SILENCE = 1.0
LOST = "the node was killed, hangs or cannot be reached: nothing has been heard of it for"
# A grip takes seconds, behind other grips minutes [s].
GRIP_TIMEOUT = 300.0
# After so many statuses without a word about the wrap it is forgotten: each tick tells of both.
FORGOTTEN = 20


class SpiralGripper:
    """A gripper whose node runs, here or on another machine; a context manager.

    Every wait has an end: what does not come in time is a :class:`NoAnswerError` that names it.
    If nobody has initialized rclpy, this does, in a context of its own, for as long as it is open.

    Args:
        namespace: of the gripper's node, such as "/left".
        answer_timeout: longest time that the node may take to answer [s], > 0.

    Example::

        with SpiralGripper() as gripper:
            gripper.wait_until_active(timeout=60.0)
            gripper.wrap(radius=0.02)
            print(gripper.wait(timeout=20.0).message)
            gripper.release()
    """

    def __init__(self, namespace: str = "", answer_timeout: float = 10.0) -> None:
        self._namespace, self._answer_timeout = namespace, answer_timeout
        self._statuses = 0
        self._status: GripStatus | None = None
        self._planned: Wrap | None = None
        self._told = 0  # statuses heard when last told of the wrap
        self._probed_at: float | None = None
        self._connect()

    def _connect(self) -> None:
        self._goal: Any = None
        self._result: Future | None = None
        self._late = LateCancel()
        self._feedback: Grasp.Feedback | None = None
        self._link = Connection(self._namespace, self._answer_timeout, self._missing)
        node = self._link.node
        self._grasp = ActionClient(node, Grasp, "grasp")
        self._plan = node.create_client(PlanWrap, "plan_wrap")
        self._vent = node.create_client(Trigger, "vent")
        self._rearm = node.create_client(Trigger, "rearm")
        self._alive = node.create_publisher(Empty, "keep_alive", 1)
        self._heard = time.monotonic()
        node.create_subscription(GripStatus, "status", self._on_status, LATEST)
        node.create_subscription(Wrap, "wrap", self._on_wrap, LATEST)

    def close(self) -> None:
        """End the connection, once; the gripper goes on with what it does."""
        if not self._link.closed:
            self._link.spin_until(lambda: self._late.is_over, GLANCE)
            self._grasp.destroy()
        self._link.close()

    def __enter__(self) -> SpiralGripper:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- the gripper ---------------------------------------------------------------------------

    def wait_until_active(self, timeout: float) -> None:
        """Wait until the gripper's node is active.

        Args:
            timeout: longest wait [s], > 0; the first start ever of a node compiles for 15 to 60 s.

        Raises:
            NoAnswerError: it is not; the message says what there is and how to go on.
        """
        require_positive("timeout", timeout)
        seen = self._statuses

        def is_active() -> bool:
            fresh = self._statuses > seen and self._status is not None
            active = fresh and self._status.state != State.INACTIVE  # type: ignore[union-attr]
            return active and self._grasp.server_is_ready()

        if not self._link.spin_until(is_active, timeout):
            raise NoAnswerError(self._missing(), timeout)

    @property
    def status(self) -> GripStatus | None:
        """The newest status of the gripper, or None without one; takes up to a tenth of a second.

        It is as old as its stamp says: a node that has died is not heard of any more.
        """
        seen = self._statuses
        self._link.spin_until(lambda: self._statuses > seen, GLANCE)
        return self._status

    @property
    def planned(self) -> Wrap | None:
        """What is planned for the object in use and what holds it; None without a message.

        Takes a tenth of a second.
        """
        self._link.spin_until(lambda: False, GLANCE)
        return self._planned

    def plan(
        self,
        radius: float,
        overpressure: float | None = None,
        payload: float | None = None,
        friction: float | None = None,
        *,
        compute_grip: bool = False,
        pose: Pose | None = None,
    ) -> PlannedWrap:
        """Ask whether an object can be wrapped, and at which pressure; moves nothing.

        Args:
            radius: of the object [m], > 0.
            overpressure: above the wrap's pressure [Pa], >= 0; None: that of the default grip.
            payload: mass of the object [kg]; None: not known.
            friction: between tube and object, with ``compute_grip``; None: the gripper's own.
            compute_grip: wait for the grip on exactly this object, else it is of the node's table.
            pose: of the object in the base frame, z along its axis; None: where the coil wraps it.

        Returns:
            The answer of `plan_wrap`; what cannot be wrapped is an answer too.

        Raises:
            InvalidInputError: a figure is not possible.
            NoAnswerError: the node does not answer.
        """
        asked = ObjectToWrap(
            radius=require_positive("radius", radius),
            payload=non_negative("payload", payload),
            friction_coefficient=non_negative("friction", friction),
            pose=[] if pose is None else [pose],
        )
        request = PlanWrap.Request(objects=[asked], backbone=True, compute_grip=compute_grip)
        request.overpressure = non_negative("overpressure", overpressure)
        patience = GRIP_TIMEOUT if compute_grip else 0.0
        return self._link.call(self._plan, request, patience).plans[0]

    def release(self) -> None:
        """Vent; the gripper stays vented until `rearm` or the next wrap.

        It does so even after ROS was shut down in this program, as by rclpy's own Ctrl-C; what was
        being wrapped is then forgotten here.

        Raises:
            NoAnswerError: the node does not answer.
        """
        try:
            self._link.call(self._vent, Trigger.Request())
        except Exception:
            # rclpy shuts ROS down at Ctrl-C for who asks it.
            if self._link.closed or self._link.node.context.ok():
                raise
            self._link.close()
            self._connect()
            self._link.call(self._vent, Trigger.Request())

    def rearm(self) -> None:
        """Follow `object_radius` again, after a release or a fault.

        Raises:
            RequestRefusedError: there is nothing to re-arm, for instance; its message says.
            NoAnswerError: the node does not answer.
        """
        answer = self._link.call(self._rearm, Trigger.Request())
        if not answer.success:
            raise RequestRefusedError("rearm", answer.message)

    def keep_alive(self) -> None:
        """Tell the node that this client is alive.

        With the node's parameter ``keep_alive.timeout`` a grip is vented unless this is called more
        often than that.
        """
        self._alive.publish(Empty())

    # --- one wrap ------------------------------------------------------------------------------

    def wrap(
        self,
        radius: float | None,
        overpressure: float | None = None,
        timeout: float | None = None,
        abort_policy: AbortPolicy | str | None = None,
    ) -> bool:
        """Start to wrap an object, in place of what is being wrapped; does not wait for the end.

        Args:
            radius: of the object [m], > 0, or None for the radius that is being followed.
            overpressure: held above the wrap's pressure [Pa], >= 0; None: that of the default grip.
            timeout: longest time until the wrap is reached [s], > 0; None: as the node's
                parameter says.
            abort_policy: what becomes of the pressure if it fails or is canceled, "vent" or
                "hold"; None: as the parameter says.

        Returns:
            Whether the node has accepted the goal. Why it cannot be done is in :meth:`result`.

        Raises:
            InvalidInputError: a figure is not possible.
            NoAnswerError: the node does not answer. If the goal is accepted later, the next call
                of this object that hears of it cancels it, as after an interrupt.
        """
        goal = goal_with(timeout, abort_policy)
        goal.mode, goal.overpressure = (
            goal.MODE_FOLLOWED,
            non_negative("overpressure", overpressure),
        )
        if radius is not None:
            goal.mode, goal.object_radius = goal.MODE_RADIUS, require_positive("radius", radius)
        return self._send(goal)

    def press(
        self,
        pressure: float,
        timeout: float | None = None,
        abort_policy: AbortPolicy | str | None = None,
    ) -> bool:
        """Start to go to a pressure, whatever it wraps: for a bench, a jog, a calibration.

        Args:
            pressure: gauge [Pa], >= 0; the node refuses what is above ``pressure.cap``.
            timeout: longest time until it is reached [s], > 0; None: as the parameter says.
            abort_policy: as of :meth:`wrap`; so are the answer and the errors.
        """
        goal = goal_with(timeout, abort_policy)
        goal.mode, goal.pressure = goal.MODE_PRESSURE, require_non_negative("pressure", pressure)
        return self._send(goal)

    def _send(self, goal: Grasp.Goal) -> bool:
        """Send a goal in place of what runs; return whether it is accepted."""
        self._link.require(self._grasp.server_is_ready)
        self._goal = self._result = self._feedback = None
        answers: list[Any] = []

        def send() -> None:
            answers.append(self._grasp.send_goal_async(goal, feedback_callback=self._on_feedback))

        try:
            self._link.run(send)  # where no interrupt comes between sending and knowing of it
            handle = self._link.answer(answers[0], "grasp")
            self._heard = time.monotonic()
            if handle.accepted:
                self._goal, self._result = handle, handle.get_result_async()
                self._told = self._statuses
        except NoAnswerError as error:
            self._late = LateCancel(*answers)
            late = "it may still start; it is canceled as soon as it answers; release() vents"
            raise NoAnswerError(f"{error.missing}: {late}", error.timeout) from None
        except BaseException:  # Ctrl-C: the node may have accepted what is not known here yet
            self._link.run(lambda: None)  # what was to be sent has been
            self._goal, self._result, self._late = None, None, LateCancel(*answers)
            raise
        return bool(handle.accepted)

    def is_done(self) -> bool:
        """Return whether no wrap is running; takes up to a tenth of a second.

        Raises:
            NoAnswerError: the node is gone, so that the end of the wrap will never be known.
        """
        if self._result is None or self._link.spin_until(self._result.done, GLANCE):
            return True
        if not self._grasp.server_is_ready():
            raise NoAnswerError(self._missing(), GLANCE)
        if self._is_lost():
            silence = time.monotonic() - self._heard
            raise NoAnswerError(f"{LOST} {silence:.1f} s; how the wrap ends is not known", silence)
        if self._statuses - self._told > FORGOTTEN:  # a node that was started in its place
            self._result, self._told = self._goal.get_result_async(), self._statuses
        return False

    def feedback(self) -> Grasp.Feedback | None:
        """Return the newest feedback on the wrap; None if there is none yet."""
        return self._feedback

    def result(self) -> WrapResult | None:
        """Return how the last wrap has ended; None: there is none, or it has not ended."""
        if self._result is None or not self._result.done():
            return None
        return result_of_wrap(self._result.result())

    def wait(self, timeout: float) -> WrapResult:
        """Wait until the wrap has ended and return how.

        Args:
            timeout: longest wait [s], > 0.

        Raises:
            RequestRefusedError: no wrap has been started.
            NoAnswerError: it has not ended in time and goes on, or the node is gone or silent.
        """
        deadline = time.monotonic() + require_positive("timeout", timeout)
        if self._result is None:
            raise RequestRefusedError("wait", "no wrap has been started")
        while not self.is_done():
            if time.monotonic() > deadline:
                raise NoAnswerError("the wrap has not ended; it goes on", timeout)
        return result_of_wrap(self._result.result())

    def cancel(self) -> bool:
        """Cancel the wrap; return whether it was still running. :meth:`wait` tells how it ended.

        Raises:
            NoAnswerError: the node does not answer.
        """
        was_late = not self._late.is_over
        self._link.require(lambda: self._late.is_over)
        if self._result is None or self._result.done():
            return was_late
        self._link.require(self._grasp.server_is_ready)
        answer = self._link.answer(self._goal.cancel_goal_async(), "grasp (cancel)")
        return len(answer.goals_canceling) > 0

    # --- inside --------------------------------------------------------------------------------

    def _is_lost(self) -> bool:
        """Return whether the node is silent and has not answered a question either."""
        now = time.monotonic()
        if now - self._heard <= SILENCE:
            self._probed_at = None
        elif self._probed_at is None:
            self._probed_at = now
            self._plan.call_async(PlanWrap.Request()).add_done_callback(self._on_sign)
        return self._probed_at is not None and now - self._probed_at > SILENCE - 2.0 * GLANCE

    def _on_status(self, status: GripStatus) -> None:
        self._status = status
        self._statuses += 1
        self._heard = time.monotonic()

    def _on_wrap(self, planned: Wrap) -> None:
        self._planned = planned

    def _on_sign(self, _: Future) -> None:
        self._heard = time.monotonic()

    def _on_feedback(self, message: Any) -> None:  # noqa: ANN401
        self._feedback = message.feedback
        self._told = self._statuses

    def _missing(self) -> str:
        """Return what there is of the gripper's node, and how to go on."""
        namespace = self._link.node.get_namespace()
        node = f"{namespace.rstrip('/')}/spiral_gripper"
        if not self._vent.service_is_ready():
            return no_node_in(namespace)
        return (
            f"the node {node} is there but not active: `ros2 lifecycle set {node} configure`, "
            "then `activate`; its log says why if that fails"
        )
