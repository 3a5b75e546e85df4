"""The lifecycle node: messages in, the supervisor's decisions out.

What it promises is written in ``docs/node.md``; what it decides is decided in
:mod:`spiral_gripper_ros.supervisor`.
"""

from __future__ import annotations

import sys
from typing import Any, cast

import rclpy
from geometry_msgs.msg import Vector3Stamped
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from std_msgs.msg import Float64

from spiral_gripper_ros.background import Background
from spiral_gripper_ros.conversions import backbone_to_msg, status_to_msg, vector_from_msg
from spiral_gripper_ros.declared_parameters import DeclaredParameters
from spiral_gripper_ros.diagnostics import diagnostics_to_msg
from spiral_gripper_ros.guards import guarded_callback, guarded_transition
from spiral_gripper_ros.limits import Limits
from spiral_gripper_ros.loaded_gripper import LoadedGripper
from spiral_gripper_ros.outputs import Outputs
from spiral_gripper_ros.parameters import gravity_problem, limits_from_values
from spiral_gripper_ros.planner import WrapPlan
from spiral_gripper_ros.services import Services
from spiral_gripper_ros.states import Reason, Refusal
from spiral_gripper_ros.stop_signals import StopSignals
from spiral_gripper_ros.supervisor import Supervisor

NODE_NAME = "spiral_gripper"
DIAGNOSTICS_PERIOD = 1.0
# What may be commanded while no gripper is loaded [Pa]; nothing is: the supervisor is inactive.
NO_GRIPPER_PRESSURE = 1.0
# How long the executor may sleep before it looks whether it was asked to stop [s].
LONGEST_SLEEP = 0.05
# The interpreter lets another thread run after this time [s] instead of 5 ms: a question that is
# answered in the background then delays a radius by less.
SWITCH_INTERVAL = 0.0005
# Newest wins: what came before the newest estimate is of no use to anyone.
NEWEST = QoSProfile(
    depth=1,
    reliability=qos_profile_sensor_data.reliability,
    durability=qos_profile_sensor_data.durability,
)


class GripperNode(LifecycleNode):  # type: ignore[misc]
    """Turns object radii into wrap pressures and predicted shapes.

    Args:
        options: passed on to rclpy's node.
    """

    def __init__(self, **options: Any) -> None:  # noqa: ANN401
        super().__init__(NODE_NAME, **options)
        self.loaded: LoadedGripper | None = None
        self._declared = DeclaredParameters(self, lambda: self.loaded is None, self._apply)
        self.values = self._declared.values()
        self.limits = self._limits()
        self.supervisor: Supervisor[WrapPlan] = Supervisor(self.limits)
        self.outputs = Outputs(self, str(self.values["frame_id"]))
        self.background = Background()
        self._served = Services(self)
        self._inputs: list[Subscription] = []
        self._timer: Timer | None = None
        self._internal_errors = 0
        self.create_timer(DIAGNOSTICS_PERIOD, self._on_diagnostics)

    # --- life cycle ----------------------------------------------------------------------------

    def start(self) -> bool:
        """Configure and activate; return whether that worked."""
        success = TransitionCallbackReturn.SUCCESS
        return bool(self.trigger_configure() == success and self.trigger_activate() == success)

    @guarded_transition
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the gripper, solve its whole range once, and connect."""
        gravity = cast("tuple[float, ...]", self.values["gravity"])
        self.loaded = LoadedGripper(str(self.values["gripper"]), gravity, self.background.gravity)
        self._use_limits()
        self.outputs.configure()
        self._inputs = [
            self.create_subscription(Float64, "object_radius", self._on_radius, NEWEST),
            self.create_subscription(Vector3Stamped, "gravity", self._on_gravity, NEWEST),
        ]
        low, high = self.loaded.planner.radius_range
        self.get_logger().info(
            f"{self.loaded.gripper.name}: grips radii from {low:.4g} to {high:.4g} m"
        )
        return super().on_configure(state)

    @guarded_transition
    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start to follow radii, from 0 Pa."""
        result = super().on_activate(state)
        self.supervisor.activate()
        self._start_timer()
        self.publish()
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
        """Command 0 Pa, in any state, and wait until it is out."""
        self._stop()
        self.outputs.flush()

    def fail(self, text: str) -> None:
        """Vent because of an internal error (see :mod:`spiral_gripper_ros.guards`)."""
        self._internal_errors += 1
        self.supervisor.fail(text)
        self.outputs.publish_pressure(0.0)

    def destroy_node(self) -> None:
        """End the background work and destroy the node."""
        self.background.end()
        super().destroy_node()

    # --- inputs --------------------------------------------------------------------------------

    @guarded_callback
    def _on_radius(self, message: Float64) -> None:
        if self._timer is None or self.loaded is None:
            return
        if self.supervisor.offer_radius(self._now(), message.data, self.loaded.planner):
            self.publish()

    @guarded_callback
    def _on_gravity(self, message: Vector3Stamped) -> None:
        if self.loaded is None:
            return
        gravity = vector_from_msg(message.vector)
        problem = self._frame_problem(message.header.frame_id) or gravity_problem(gravity)
        if problem is not None:
            self.supervisor.refuse(Refusal(Reason.GRAVITY_INVALID, problem))
            return
        self.loaded.mount.want(gravity, cast("float", self.values["gravity_hysteresis"]))

    @guarded_callback
    def _on_tick(self) -> None:
        if self.loaded is None:
            return
        planner = self.loaded.mount.poll()
        if planner is not None:
            self.supervisor.replan(planner)
        self.publish()

    def _apply(self, names: set[str]) -> None:
        """Let changed parameters take effect at once."""
        self.values = self._declared.values()
        self._use_limits()
        if "gravity" in names and self.loaded is not None:
            gravity = cast("tuple[float, ...]", self.values["gravity"])
            self.loaded.mount.want(self.loaded.gravity_or_own(gravity), 0.0)
        if "publish_rate" in names and self._timer is not None:
            self._start_timer()

    # --- outputs -------------------------------------------------------------------------------

    def publish(self) -> None:
        """Publish the pressure that the supervisor commands now; then, why, and the shape."""
        self.outputs.publish_pressure(self.supervisor.command(self._now()))
        if self.loaded is None:
            return
        snapshot = self.supervisor.snapshot()
        changed = self.loaded.update_shape(snapshot.pressure_command, snapshot.radius)
        shape, header = self.loaded.shape, self.outputs.header()
        grippable = self.loaded.planner.radius_range
        self.outputs.publish_status(
            status_to_msg(snapshot, shape, grippable, self.limits.pressure_cap, header)
        )
        if changed and shape is not None:
            points = cast("int", self.values["backbone_points"])
            self.outputs.publish_backbone(backbone_to_msg(shape.state, points, header))

    @guarded_callback
    def _on_diagnostics(self) -> None:
        name = self.get_fully_qualified_name()
        gripper = "" if self.loaded is None else self.loaded.gripper.name
        stamp = self.get_clock().now().to_msg()
        self.outputs.publish_diagnostics(
            diagnostics_to_msg(
                name, gripper, self.supervisor.snapshot(), self._internal_errors, stamp
            )
        )

    # --- inside --------------------------------------------------------------------------------

    def _now(self) -> float:
        return float(self._control_clock().now().nanoseconds) * 1e-9

    def _control_clock(self) -> Clock:
        """Return a clock that no correction of the wall clock disturbs, or the simulated one."""
        simulated = self.get_parameter("use_sim_time").value
        return self.get_clock() if simulated else _STEADY_CLOCK

    def _start_timer(self) -> None:
        self._stop_timer()
        period = 1.0 / cast("float", self.values["publish_rate"])
        self._timer = self.create_timer(period, self._on_tick, clock=self._control_clock())

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self.destroy_timer(self._timer)
        self._timer = None

    def _stop(self) -> None:
        """Vent; the vent is the last command until the next activation."""
        self._stop_timer()
        self.supervisor.deactivate()
        self.publish()

    def _unload(self) -> None:
        self._stop()
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        self._inputs = []
        self.outputs.cleanup()
        self.loaded = None

    def _limits(self) -> Limits:
        own = NO_GRIPPER_PRESSURE if self.loaded is None else self.loaded.gripper.pressure_max
        return limits_from_values(self.values, own)

    def _use_limits(self) -> None:
        self.limits = self._limits()
        self.supervisor.reconfigure(self.limits)

    def _frame_problem(self, frame_id: str) -> str | None:
        own = self.values["frame_id"]
        if frame_id in ("", own):
            return None
        return f"gravity must be given in the frame {own!r} (or an unnamed one), got {frame_id!r}"


_STEADY_CLOCK = Clock(clock_type=ClockType.STEADY_TIME)


def main(args: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; return the process's exit code."""
    signals = StopSignals()
    sys.setswitchinterval(SWITCH_INTERVAL)
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = GripperNode()
    except (ParameterException, ValueError) as error:
        rclpy.logging.get_logger(NODE_NAME).fatal(f"bad parameter at start: {error}")
        rclpy.try_shutdown()
        return 1
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        if node.values["autostart"] and not node.start():
            return 1
        signals.defer()
        while not signals.requested:
            executor.spin_once(timeout_sec=LONGEST_SLEEP)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        signals.defer()
        node.vent()
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
