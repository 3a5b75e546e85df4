# SPDX-License-Identifier: Apache-2.0
"""The lifecycle node: messages in, the decisions of its control logic out.

What it promises is written in ``docs/node.md``; what it decides is decided in
:mod:`spiral_gripper_ros.control.grip_control`.
"""

from __future__ import annotations

from typing import Any, cast

from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.timer import Timer

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.grasping.grasp_server import GraspServer
from spiral_gripper_ros.node.background import Background
from spiral_gripper_ros.node.control_clock import ControlClock
from spiral_gripper_ros.node.conversions import status_to_msg
from spiral_gripper_ros.node.declared_parameters import DeclaredParameters
from spiral_gripper_ros.node.diagnosis import Diagnosis
from spiral_gripper_ros.node.display import Display
from spiral_gripper_ros.node.grip_log import GripLog
from spiral_gripper_ros.node.guards import (
    ErrorLog,
    answer_impossible_transitions,
    guarded_transition,
    log_on_error,
    vent_on_error,
)
from spiral_gripper_ros.node.inputs import Inputs
from spiral_gripper_ros.node.outputs import Outputs
from spiral_gripper_ros.node.parameters import limits_from_values, number
from spiral_gripper_ros.node.proposed_gripper import ProposedGripper
from spiral_gripper_ros.node.services import Services
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper, gravity_or_own
from spiral_gripper_ros.planning.planner import NoPlanner, WrapPlan

NODE_NAME = "spiral_gripper"
NOT_CONFIGURED = "the node has no gripper yet: configure it first"
SHUT_DOWN = "the node has been shut down by its lifecycle: start it anew"
# What may be commanded while no gripper is loaded [Pa]; nothing is: the node is inactive.
NO_GRIPPER_PRESSURE = 1.0


class GripperNode(LifecycleNode):  # type: ignore[misc]
    """Turns object radii and grasp goals into wrap pressures and predicted shapes.

    Args:
        options: passed on to rclpy's node.
    """

    def __init__(self, **options: Any) -> None:  # noqa: ANN401
        super().__init__(NODE_NAME, **options)
        answer_impossible_transitions(self)
        self.loaded: LoadedGripper | None = None
        self.gravity: tuple[float, ...] = ()  # heard, or of the parameter; () as described
        self.errors = ErrorLog(self.get_logger())
        self.not_configured = NOT_CONFIGURED
        self._proposed = ProposedGripper()
        self._declared = DeclaredParameters(
            self, vent_on_error(self, self._apply), judge=self._proposed.refusal
        )
        self.values = self._declared.values()
        self.limits = self._limits()
        self.control: GripControl[WrapPlan] = GripControl(self.limits)
        self.time = ControlClock(self)
        self.outputs = Outputs(self, str(self.values["frame_id"]))
        self.background = Background()
        self.log = GripLog(self.get_logger())
        self._display = Display(self)
        self._served = Services(self)
        self.grasps = GraspServer(self)
        self.inputs: Inputs | None = None
        self.tell = log_on_error(self, self._tell)
        self._timer: Timer | None = None
        self._diagnosis = Diagnosis(self)

    # --- life cycle ----------------------------------------------------------------------------

    def start(self) -> bool:
        """Configure and activate; return whether that worked."""
        success = TransitionCallbackReturn.SUCCESS
        return bool(self.trigger_configure() == success and self.trigger_activate() == success)

    @guarded_transition
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the gripper, solve its whole range once, and connect."""
        self.gravity = self._given_gravity()
        self.loaded = LoadedGripper.ready(
            str(self.values["gripper"]), self.gravity, self.background.gravity
        )
        self._use_limits()
        self.outputs.configure()
        self.inputs = Inputs(self)
        self._tell_range(self.loaded)
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
        self.time.choose()
        self.control.activate(take_over=self.values["activation"] == "take_over")
        self._start_timers()
        self.publish()
        self.log.tell_limits(self.limits)
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
        """Vent and forget the gripper, for good."""
        self._unload()
        self.not_configured = SHUT_DOWN
        return super().on_shutdown(state)

    @guarded_transition
    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Vent and go back to "unconfigured"."""
        self._unload()
        return super().on_error(state)

    def vent(self) -> None:
        """Command 0 Pa, in any state, and wait until it is out."""
        self._stop()
        self.outputs.flush()

    def fail(self, text: str) -> None:
        """Vent because of an internal error (see :mod:`spiral_gripper_ros.node.guards`)."""
        self.control.fail(text)
        self.outputs.publish_pressure(0.0)
        self.grasps.tick()

    def destroy_node(self) -> None:
        """End the background work and destroy the node."""
        self.background.end()
        self.grasps.destroy()
        super().destroy_node()

    # --- the control loop ----------------------------------------------------------------------

    def _on_tick(self) -> None:
        self.take_planner()
        self.publish()

    def take_planner(self) -> None:
        """Plan with what has become ready in the background: other gravity or another gripper."""
        if self.loaded is None:
            return
        was_loading = self.loaded.is_loading
        planner = self.loaded.mount.poll()
        if planner is None:
            return
        if was_loading and isinstance(planner, NoPlanner):
            text = f"{self.loaded.gripper.name} cannot be used: {planner.error}"
            self.get_logger().error(text)
            self.control.fail(text)
            return
        self.control.replan(planner)
        if was_loading:
            self._tell_range(self.loaded)

    # --- parameters ----------------------------------------------------------------------------

    def _apply(self, names: set[str]) -> None:
        """Let changed parameters take effect at once."""
        self.values = self._declared.values()
        if "gravity" in names:
            self.gravity = self._given_gravity()
        if "gripper" in names:
            self._load_another()
        elif "gravity" in names and self.loaded is not None:
            self.loaded.mount.want(gravity_or_own(self.gravity, self.loaded.gripper), 0.0)
            self.control.note_gravity(self.now(), is_heard=False)
        self._use_limits()
        if "publish_rate" in names and self.is_active:
            self._start_timers()
        elif self.is_active and not names.isdisjoint({"marker_rate", "robot_state_rate"}):
            self._display.start()
        self.time.guard()

    def _load_another(self) -> None:
        """Vent, and have the proposed gripper planned for in the background."""
        description = self._proposed.description
        if self.loaded is None or description is None:
            return
        self.control.reload()
        if self.is_active:
            self.publish()
        self.loaded = LoadedGripper.loading(description, self.gravity, self.background.gravity)

    # --- outputs -------------------------------------------------------------------------------

    def publish(self) -> None:
        """Publish the pressure that is commanded now; then, why, and the shapes."""
        now = self.now()
        self.command(now)
        self.tell(now)

    def command(self, now: float) -> None:
        """Publish the pressure that is commanded at a time [s], unless one is to be taken over."""
        pressure = self.control.command(now)
        if not self.control.is_silent:
            self.outputs.publish_pressure(pressure)

    def _tell(self, now: float) -> None:
        """Publish what belongs to the pressure that has just been commanded."""
        try:
            if self.loaded is not None:
                self._show(self.loaded, now)
        except Exception:
            self.control.observe(now, None)  # how the object is held is not known
            raise
        finally:
            self.grasps.tick()

    def _show(self, loaded: LoadedGripper, now: float) -> None:
        """Bring the shapes up to date, see how the object is held, and publish what is news."""
        seen = self.control.snapshot()
        measured = None if seen.measured is None else seen.measured.pressure
        moved = loaded.update_shape(seen.pressure_command, seen.radius)
        measured_moved = loaded.update_measured_shape(
            measured, seen.radius, self.limits.pressure_tolerance
        )
        pressure = seen.pressure_command if measured is None else measured
        self.control.observe(now, loaded.regime, loaded.line_force(seen.plan, pressure))
        snapshot, header = self.control.snapshot(), self.outputs.header()
        self.outputs.publish_status(
            status_to_msg(snapshot, loaded, self.limits.pressure_cap, header)
        )
        points = int(number(self.values, "backbone_points"))
        if moved:
            self.outputs.publish_backbone(loaded.shape, points, header)
        if measured_moved:
            self.outputs.publish_measured_backbone(loaded.measured_shape, points, header)
        self.log.tell(now, snapshot)

    @property
    def is_active(self) -> bool:
        """Whether the control loop runs."""
        return self._timer is not None

    # --- inside --------------------------------------------------------------------------------

    def _tell_range(self, loaded: LoadedGripper) -> None:
        name, radii = loaded.gripper.name, loaded.planner.radius_range
        self.log.tell_range(name, radii, self.limits.pressure_cap)

    def now(self) -> float:
        """Return the time of the control loop [s]."""
        return self.time.now()

    def _start_timers(self) -> None:
        self._stop_timers()
        period = 1.0 / number(self.values, "publish_rate")
        tick = vent_on_error(self, self._on_tick)
        self._timer = self.create_timer(period, tick, clock=self.time.clock)
        self._display.start()

    def _stop_timers(self) -> None:
        if self._timer is not None:
            self.destroy_timer(self._timer)
        self._timer = None
        self._display.stop()

    def _stop(self) -> None:
        """Vent; the vent is the last command until the next activation."""
        self._stop_timers()
        self.control.deactivate()
        self.publish()

    def _unload(self) -> None:
        self._stop()
        if self.inputs is not None:
            self.inputs.destroy()
        self.inputs = None
        self.outputs.cleanup()
        self.loaded = None

    def _given_gravity(self) -> tuple[float, ...]:
        return cast("tuple[float, ...]", self.values["gravity"])

    def _limits(self) -> Limits:
        own = NO_GRIPPER_PRESSURE if self.loaded is None else self.loaded.gripper.pressure_max
        return limits_from_values(self.values, own)

    def _use_limits(self) -> None:
        self.limits = self._limits()
        self.control.reconfigure(self.limits)
