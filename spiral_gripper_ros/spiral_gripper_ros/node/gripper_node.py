"""The lifecycle node: messages in, the decisions of its control logic out.

What it promises is written in ``docs/node.md``; what it decides is decided in
:mod:`spiral_gripper_ros.control.grip_control`.
"""

from __future__ import annotations

from typing import Any, cast

from geometry_msgs.msg import Vector3Stamped
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64

from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.grasping.grasp_server import GraspServer
from spiral_gripper_ros.node.background import Background
from spiral_gripper_ros.node.control_clock import ControlClock
from spiral_gripper_ros.node.conversions import frame_problem, status_to_msg, vector_from_msg
from spiral_gripper_ros.node.declared_parameters import DeclaredParameters
from spiral_gripper_ros.node.diagnosis import Diagnosis
from spiral_gripper_ros.node.display import Display
from spiral_gripper_ros.node.grip_log import GripLog
from spiral_gripper_ros.node.guards import (
    answer_impossible_transitions,
    guarded_callback,
    guarded_transition,
)
from spiral_gripper_ros.node.outputs import Outputs
from spiral_gripper_ros.node.parameters import (
    gravity_problem,
    limits_from_values,
    measured_scale,
    number,
)
from spiral_gripper_ros.node.proposed_gripper import ProposedGripper
from spiral_gripper_ros.node.qos import NEWEST
from spiral_gripper_ros.node.services import Services
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper, gravity_or_own
from spiral_gripper_ros.planning.planner import NoPlanner, WrapPlan

NODE_NAME = "spiral_gripper"
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
        self.internal_errors = 0
        self._proposed = ProposedGripper()
        self._declared = DeclaredParameters(self, self._apply, judge=self._proposed.refusal)
        self.values = self._declared.values()
        self.limits = self._limits()
        self.control: GripControl[WrapPlan] = GripControl(self.limits)
        self.time = ControlClock(self)
        self.outputs = Outputs(self, str(self.values["frame_id"]))
        self.background = Background()
        self._gravity: tuple[float, ...] = ()
        self.log = GripLog(self.get_logger())
        self._display = Display(self)
        self._served = Services(self)
        self.grasps = GraspServer(self)
        self._inputs: list[Subscription] = []
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
        self._gravity = self._given_gravity()
        self.loaded = LoadedGripper.ready(
            str(self.values["gripper"]), self._gravity, self.background.gravity
        )
        self._use_limits()
        self.outputs.configure()
        self._inputs = [
            self.create_subscription(Float64, "object_radius", self._on_radius, NEWEST),
            self.create_subscription(Vector3Stamped, "gravity", self._on_gravity, NEWEST),
            self.create_subscription(FluidPressure, "measured_pressure", self._on_measured, NEWEST),
        ]
        self._tell_range(self.loaded)
        return super().on_configure(state)

    @guarded_transition
    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start to follow radii, from 0 Pa."""
        result = super().on_activate(state)
        self.time.choose()
        self.control.activate()
        self._start_timers()
        self.publish()
        self.log.tell_others(self.count_publishers("pressure_command"))
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
        return super().on_shutdown(state)

    @guarded_transition
    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Vent and go back to "unconfigured"."""
        self._unload()
        return super().on_error(state)

    def vent(self) -> None:
        """Command 0 Pa, in any state, wait until it is out, and let goals end."""
        self._stop()
        self.outputs.flush()
        if self.executor is not None:
            self.grasps.end(self.executor)

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

    # --- inputs --------------------------------------------------------------------------------

    @guarded_callback
    def _on_radius(self, message: Float64) -> None:
        if self.loaded is None or not self.is_active:
            return
        now = self.now()
        if self.control.offer_radius(now, message.data, self.loaded.planner):
            self.outputs.publish_pressure(self.control.command(now))
            # The next radius must not wait for the rest: that follows with the next tick, which a
            # simulated clock may never let come.
            if self.time.is_simulated:
                self._tell(now)

    @guarded_callback
    def _on_measured(self, message: FluidPressure) -> None:
        if self.is_active:
            pressure = measured_scale(self.values).to_gauge(message.fluid_pressure)
            self.control.offer_measured(self.now(), pressure)

    @guarded_callback
    def _on_gravity(self, message: Vector3Stamped) -> None:
        if self.loaded is None:
            return
        gravity = vector_from_msg(message.vector)
        problem = frame_problem(
            message.header.frame_id, str(self.values["frame_id"])
        ) or gravity_problem(gravity)
        if problem is not None:
            self.control.refuse(Refusal(Reason.GRAVITY_INVALID, problem))
            return
        self._gravity = gravity
        self.loaded.mount.want(gravity, number(self.values, "gravity_hysteresis"))

    @guarded_callback
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

    @guarded_callback
    def _apply(self, names: set[str]) -> None:
        """Let changed parameters take effect at once."""
        self.values = self._declared.values()
        if "gravity" in names:
            self._gravity = self._given_gravity()
        if "gripper" in names:
            self._load_another()
        elif "gravity" in names and self.loaded is not None:
            self.loaded.mount.want(gravity_or_own(self._gravity, self.loaded.gripper), 0.0)
        self._use_limits()
        if not names.isdisjoint({"publish_rate", "marker_rate"}) and self.is_active:
            self._start_timers()

    def _load_another(self) -> None:
        """Vent, and have the proposed gripper planned for in the background."""
        description = self._proposed.description
        if self.loaded is None or description is None:
            return
        self.control.reload()
        if self.is_active:
            self.publish()
        self.loaded = LoadedGripper.loading(description, self._gravity, self.background.gravity)

    # --- outputs -------------------------------------------------------------------------------

    def publish(self) -> None:
        """Publish the pressure that is commanded now; then, why, and the shapes."""
        now = self.now()
        self.outputs.publish_pressure(self.control.command(now))
        self._tell(now)

    def _tell(self, now: float) -> None:
        """Publish what belongs to the pressure that has just been commanded."""
        if self.loaded is not None:
            self._show(self.loaded, now)
        self.grasps.tick()

    def _show(self, loaded: LoadedGripper, now: float) -> None:
        """Bring the shapes up to date, see how the object is held, and publish what is news."""
        seen = self.control.snapshot()
        measured = None if seen.measured is None else seen.measured.pressure
        moved = loaded.update_shape(seen.pressure_command, seen.radius)
        measured_moved = loaded.update_measured_shape(
            measured, seen.radius, self.limits.pressure_tolerance
        )
        self.control.observe(now, loaded.regime)
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
        self._timer = self.create_timer(period, self._on_tick, clock=self.time.clock)
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
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        self._inputs = []
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
