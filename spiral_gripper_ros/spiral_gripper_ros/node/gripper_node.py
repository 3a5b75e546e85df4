# SPDX-License-Identifier: Apache-2.0
"""The lifecycle node: transitions, parameters, the timer of the control loop.

``docs/safety.md`` states its contract. :mod:`spiral_gripper_ros.control` decides the command;
:mod:`spiral_gripper_ros.runtime.runtime` publishes it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from spiral_core.errors import InvalidInputError, SpiralError
from spiral_gripper import GripperDescription, load_description
from spiral_gripper_ros.actions.servers import GoalServers
from spiral_gripper_ros.node.diagnosis import Diagnosis
from spiral_gripper_ros.node.display import Display
from spiral_gripper_ros.node.inputs import Inputs
from spiral_gripper_ros.node.services import Services
from spiral_gripper_ros.parameters.declared import DeclaredParameters
from spiral_gripper_ros.parameters.spec import ParameterValue
from spiral_gripper_ros.parameters.table import GripperParameters
from spiral_gripper_ros.process.guards import ErrorLog, guard_services
from spiral_gripper_ros.runtime.guards import guarded_transition, vent_on_error
from spiral_gripper_ros.runtime.repetition import Repetition
from spiral_gripper_ros.runtime.runtime import Runtime

DISPLAY_RATES = {"publish.marker_rate", "publish.robot_state_rate"}
NODE_NAME = "spiral_gripper"
SHUT_DOWN = "the node has been shut down by its lifecycle: start it anew"


class GripperNode(LifecycleNode):  # type: ignore[misc]
    """Lifecycle node from object radii and grasp goals to wrap pressures and predicted shapes.

    Args:
        options: passed on to rclpy's node.
    """

    _is_made = False

    def __init__(self, **options: Any) -> None:  # noqa: ANN401
        super().__init__(NODE_NAME, **options)
        errors = self.errors = ErrorLog(self.get_logger())
        guard_services(self, errors)
        self._proposed: GripperDescription | None = None
        self._declared = DeclaredParameters(
            self, self._on_change, GripperParameters, judge=self._judge
        )
        self.runtime = Runtime(self, self._declared.values(), errors)
        self.goals = GoalServers(self, self.runtime)
        self._ticks = Repetition(self, vent_on_error(self.runtime, self._on_tick))
        self._display = Display(self, self.runtime)
        Services(self, self.runtime)
        Diagnosis(self, self.runtime)
        # Returns whether the kernels are there; a process that compiles them lets it wait.
        self.wait_for_kernels: Callable[[], bool] = lambda: True
        self._inputs: Inputs | None = None
        self._is_made = True

    # --- life cycle ----------------------------------------------------------------------------

    def start(self) -> bool:
        """Configure and activate; return whether that worked."""
        success = TransitionCallbackReturn.SUCCESS
        return bool(self.trigger_configure() == success and self.trigger_activate() == success)

    @guarded_transition
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the gripper, solve its whole range once, and connect."""
        if not self.wait_for_kernels():
            return TransitionCallbackReturn.FAILURE
        loaded = self.runtime.load()
        self._inputs = Inputs(self, self.runtime)
        self.runtime.outputs.configure()
        self.runtime.tell_range(loaded)
        return super().on_configure(state)

    @guarded_transition
    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start to follow radii, from 0 Pa, or from the measured pressure."""
        if isinstance(self.executor, MultiThreadedExecutor):
            raise InvalidInputError(
                "executor",
                "MultiThreadedExecutor",
                "one of a single thread: callbacks share state",
            )
        result = super().on_activate(state)
        runtime = self.runtime
        runtime.clock.choose()
        runtime.objects.forget()
        runtime.control.activate(take_over=runtime.values.activation == "take_over")
        if runtime.values.gravity.frame:
            runtime.control.expect_gravity(runtime.now())
        self._start_timers()
        runtime.publish()
        runtime.log.tell_limits(runtime.limits)
        return result

    @guarded_transition
    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Vent and stop."""
        self._stop()
        return super().on_deactivate(state)

    @guarded_transition
    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the gripper."""
        self._unload()
        return super().on_cleanup(state)

    @guarded_transition
    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Vent and forget the gripper; the node cannot be configured again."""
        self._unload()
        self.runtime.not_configured = SHUT_DOWN
        return super().on_shutdown(state)

    @guarded_transition
    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Vent and go back to "unconfigured"."""
        self._unload()
        return super().on_error(state)

    def vent(self) -> None:
        """Vent, if anything has been commanded, and wait until the message is delivered."""
        self._stop()
        self.runtime.outputs.flush()

    def destroy_node(self) -> None:
        """End the background work and destroy the node."""
        if self._is_made:  # rclpy of Kilted also destroys one whose parameters cannot be
            self.runtime.background.end()
            self.goals.destroy()
        super().destroy_node()

    # --- inside --------------------------------------------------------------------------------

    def _judge(self, proposed: Mapping[str, ParameterValue]) -> str | None:
        """Read the gripper among proposed parameters; return why it cannot be used, or None."""
        self._proposed = None
        try:
            if "gripper" in proposed:
                self._proposed = load_description(str(proposed["gripper"]))
        except SpiralError as error:
            return str(error)
        return None

    def _on_change(self, names: set[str]) -> None:
        vent_on_error(self.runtime, self._apply)(names)

    def _apply(self, names: set[str]) -> None:
        """Let changed parameters take effect at once."""
        runtime = self.runtime
        runtime.values = self._declared.values()
        if "gravity.vector" in names:
            runtime.use_gravity()
        if "gripper" in names:
            runtime.load_another(self._proposed)
        runtime.use_limits()
        if runtime.is_active and "publish.rate" in names:
            self._start_timers()
        elif runtime.is_active and names & DISPLAY_RATES:
            self._display.start()
        runtime.clock.guard()

    def _on_tick(self) -> None:
        self.runtime.take_planner()
        self.runtime.publish()

    def _start_timers(self) -> None:
        self._ticks.start(self.runtime.values.publish.rate, self.runtime.clock.clock)
        self.runtime.is_active = True
        self._display.start()

    def _stop(self) -> None:
        """Vent; the vent is the last command until the next activation."""
        self._ticks.stop()
        self.runtime.is_active = False
        self._display.stop()
        self.runtime.stop()

    def _unload(self) -> None:
        self._stop()
        if self._inputs is not None:
            self._inputs.destroy()
        self._inputs = None
        self.runtime.unload()
