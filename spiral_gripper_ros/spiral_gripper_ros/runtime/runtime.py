# SPDX-License-Identifier: Apache-2.0
"""The running gripper with its publishers: services, actions, inputs and displays use it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, LifecyclePublisher
from std_msgs.msg import Float64, Header
from visualization_msgs.msg import MarkerArray

from spiral_core.errors import SpiralError
from spiral_core.grip.curve import GripAnswer, GripCurve, GripQuestion
from spiral_gripper import GripperDescription, load_description
from spiral_gripper.files.grips import grips_path, read_grips
from spiral_gripper.files.regions import read_regions
from spiral_gripper.files.storage import FileError
from spiral_gripper_msgs.msg import Grip, GripStatus, Wrap
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.refusals import RECONFIGURED
from spiral_gripper_ros.control.states import Refusal, refusal_from_error
from spiral_gripper_ros.messages.conversions import (
    backbone_to_msg,
    status_to_msg,
    wrap_to_msg,
)
from spiral_gripper_ros.messages.grip import grip_to_msg
from spiral_gripper_ros.messages.qos import COMMAND, LATEST
from spiral_gripper_ros.parameters.table import GripperParameters
from spiral_gripper_ros.planning.grip_follower import GripFollower, InUse
from spiral_gripper_ros.planning.loaded_gripper import LoadedGripper, gravity_or_own, tube_at
from spiral_gripper_ros.planning.object_pose import ObjectWatch, SeenObject
from spiral_gripper_ros.process.guards import ErrorLog, log_on_error
from spiral_gripper_ros.runtime.background import Background
from spiral_gripper_ros.runtime.control_clock import ControlClock
from spiral_gripper_ros.runtime.event_log import EventLog

# How long a stopping node waits until everyone has acknowledged the vent [s].
ACKNOWLEDGE_TIMEOUT = 0.5

_MANAGED = {
    "status": GripStatus,
    "wrap": Wrap,
    "backbone": PoseArray,
    "measured_backbone": PoseArray,
    "markers": MarkerArray,
}
Beside = TypeVar("Beside")
NOT_CONFIGURED = "the node has no gripper yet: configure it first"
# What may be commanded while no gripper is loaded [Pa]; nothing is: the node is inactive.
NO_GRIPPER_PRESSURE = 1.0


class Runtime:
    """One gripper, its control logic, and its publishers, clock and log.

    Args:
        node: the ROS node whose publishers, clock and logger are used.
        values: of the node's parameters.
        errors: where exceptions are noted.

    Attributes:
        values: of the parameters, now.
        limits: what bounds the commands.
        control: decides what is commanded.
        clock: time of the control loop.
        loaded: the gripper; None before the node is configured.
        gravity: heard, or of the parameter [m/s^2]; () as described.
        outputs: the publishers.
        background: threads for what takes longer than a callback may.
        objects: where the object has been seen.
        logger: of the node.
        log: what operators read.
        errors: exceptions caught so far.
        is_active: whether the control loop runs.
        commanded_at: when the last command was published [s].
        has_commanded: whether this activation has commanded anything; only then its end vents.
        not_configured: why there is no gripper.
        on_published: called after each publication of a command and its status, and while the clock
            stands still.
    """

    def __init__(self, node: LifecycleNode, values: GripperParameters, errors: ErrorLog) -> None:
        self.values = values
        self.loaded: LoadedGripper | None = None
        self.gravity: tuple[float, ...] = ()
        self.limits = self._limits()
        self.control = GripControl(self.limits)
        self.errors = errors
        self.clock = ControlClock(node, self.errors)
        self.outputs = Outputs(node, values.frame_id)
        self.background = Background()
        self.objects = ObjectWatch()
        self.logger = node.get_logger()
        self.log = EventLog(self.logger)
        self.is_active = self.has_commanded = False
        self.commanded_at = -math.inf
        self._wrap_told: tuple[object, ...] | None = None
        self._curve: GripCurve | None = None  # of which backbones were published
        self.not_configured = NOT_CONFIGURED
        self.on_published: Callable[[], None] = lambda: None
        self.tell = log_on_error(self.errors, self._tell)

    # --- the gripper ---------------------------------------------------------------------------

    def load(self) -> LoadedGripper:
        """Load the gripper that the parameters name, solve its whole range once, and return it.

        Raises:
            SpiralError: the description cannot be used, or the gripper cannot coil.
        """
        self.use_gravity()
        loaded = self._made(load_description(self.values.gripper))
        loaded.load()
        self.loaded = loaded
        self.use_limits()
        return loaded

    def load_another(self, description: GripperDescription | None) -> None:
        """Vent, and have another gripper planned for in the background; the loaded one is kept."""
        if self.loaded is None or description is None:
            return
        if self.loaded.planner.error is None and description == self.loaded.description:
            return
        self.control.release(RECONFIGURED)
        if self.is_active:
            self.publish()
        self.loaded.grips.end()
        self.loaded = self._made(description)
        self.loaded.refresh()

    def unload(self) -> None:
        """Forget the gripper."""
        self.outputs.cleanup()
        if self.loaded is not None:
            self.loaded.grips.end()
        self.loaded = None

    def use_limits(self) -> None:
        """Let the limits follow the parameters and the gripper."""
        self.limits = self._limits()
        self.control.reconfigure(self.limits)

    def use_gravity(self) -> None:
        """Take gravity from the parameter."""
        self.gravity = self.values.gravity.vector
        self.control.forget_gravity()
        if self.loaded is not None:
            self.loaded.want(gravity_or_own(self.gravity, self.loaded.gripper), 0.0)

    def take_planner(self) -> None:
        """Plan with what has become ready in the background: other gravity or another gripper."""
        loaded = self.loaded
        if loaded is None:
            return
        was_loading = loaded.is_loading
        planner = loaded.poll()
        if planner is None:
            return
        if was_loading and planner.error is not None:
            text = f"{loaded.gripper.name} cannot be used: {planner.error}"
            self.logger.error(text)
            self.control.fail(text)
            return
        self.control.replan(planner)
        if was_loading:
            self.tell_range(loaded)

    def tell_range(self, loaded: LoadedGripper) -> None:
        """Log which radii the gripper grips."""
        radii, cap = loaded.planner.held_range, self.limits.pressure_cap
        self.log.tell_range(loaded.gripper.name, radii, cap)

    def seen_object(self) -> SeenObject | None:
        """Return where the object is, if that is known and young enough."""
        return self.objects.seen(self.now(), self.values.object_pose.timeout)

    def follow_grips(self) -> None:
        """Have the grip on the object in use solved; plan again once it is: it may be refused."""
        if self.loaded is None:
            return
        radius, loaded, values = self.control.snapshot().radius, self.loaded, self.values
        in_use = None if radius is None else InUse(radius, self.seen_object())
        given = self.now(), loaded.gravity, values.pressure.rate_up, in_use
        if loaded.grips.follow(*given, is_on=values.grip.contact):
            self.control.replan(loaded.planner)

    def solve_grip(self, question: GripQuestion, is_wanted: Callable[[], bool]) -> GripCurve:
        """Return the grip on one object for the present ramp, in seconds; called in the background.

        Args:
            question: what is asked.
            is_wanted: whether somebody still waits.

        Raises:
            SpiralError: the object cannot be held, or the node has ended.
        """
        rate = self.values.pressure.rate_up
        figures = self.background.solve_grip(replace(question, rate=rate), is_wanted)
        return replace(figures, computed_at=self.now())

    def grip(self, pressure: float) -> GripAnswer | None:
        """Return what holds the object in use at a gauge pressure [Pa], if it is known."""
        plan = self.control.snapshot().plan
        if self.loaded is None or plan is None:
            return None
        return self.loaded.grips.answer(plan, self.seen_object(), pressure)

    def grip_message(self, answer: GripAnswer | None, payload: float | None = None) -> list[Grip]:
        """Return the message of that, as a list of one if it is known.

        Args:
            answer: what is known.
            payload: mass of the object [kg]; None: that of the parameter.
        """
        payload = self.values.grip.payload if payload is None else payload
        gravity = () if self.loaded is None else self.loaded.gravity
        return grip_to_msg(answer, self.now(), payload, gravity)

    def diameter(self) -> float:
        """Return the diameter of the object while it is held [m], as of a parallel gripper.

        Else what the present pressure wraps by the tip criterion; the open position if nothing.
        """
        opening, snapshot = self.values.gripper_cmd.open_position, self.control.snapshot()
        if self.loaded is None:
            return opening
        if snapshot.plan is not None and snapshot.wrapped:
            return 2.0 * snapshot.plan.wrap.object_radius
        return self.loaded.planner.wrapped_diameter(snapshot.pressure, opening)

    def rearm(self) -> Refusal | None:
        """Follow radii again after a release or a fault; return why not if that cannot be."""
        loaded = self.loaded
        if self.is_active and loaded is not None and not loaded.is_loading and loaded.planner.error:
            return refusal_from_error(loaded.planner.error)
        return self.control.rearm()

    # --- commands ------------------------------------------------------------------------------

    def now(self) -> float:
        """Return the time of the control loop [s]."""
        return self.clock.now()

    def publish(self) -> None:
        """Publish the pressure that is commanded now, then the status and the shapes."""
        now = self.now()
        self.command(now)
        self.tell(now)

    def command(self, now: float) -> None:
        """Publish the pressure that is commanded at a time [s], unless one is to be taken over."""
        pressure = self.control.command(now, time.monotonic())
        if not self.control.is_silent:
            self.outputs.publish_pressure(pressure)
            self.has_commanded, self.commanded_at = self.is_active, now

    def stop(self) -> None:
        """Vent, as the last command; a node that has commanded nothing stays silent."""
        try:
            self.control.deactivate()
        finally:
            self._vent()
        self.has_commanded = False
        self.tell(self.now())

    def fail(self, text: str) -> None:
        """Vent because of an internal error (see :mod:`spiral_gripper_ros.runtime.guards`)."""
        try:
            self.control.fail(text)
        finally:
            self._vent()
        self.tell(self.now())

    # --- inside --------------------------------------------------------------------------------

    def _vent(self) -> None:
        """Publish 0 Pa, whatever the control logic is able to."""
        if self.is_active or self.has_commanded:
            self.outputs.publish_pressure(0.0)

    def _tell(self, now: float) -> None:
        """Publish what belongs to the pressure that has just been commanded."""
        try:
            if self.loaded is not None:
                self._show(self.loaded, now)
        except Exception:
            self.control.observe(None)  # how the object is held is not known
            raise
        finally:
            self.on_published()

    def _show(self, loaded: LoadedGripper, now: float) -> None:
        """Update the shapes and the grip, and publish those that have changed."""
        seen, tolerance = self.control.snapshot(), self.limits.pressure_tolerance
        pressure, measured, radius = seen.pressure, seen.measured_pressure, seen.radius
        moved = {
            "backbone": loaded.update_shape(seen.pressure_command, radius),
            "measured_backbone": loaded.update_measured_shape(measured, radius, tolerance),
        }
        self.follow_grips()
        seen_object, grip = self.seen_object(), self.grip(pressure)
        force = None if grip is None else grip.normal_force
        if grip is None and seen.plan is not None and not seen.plan.is_wrapped(pressure):
            with suppress(SpiralError):  # a pressure beyond the description
                force = seen.plan.line_force(pressure)
        self.control.observe(loaded.regime(seen), force)
        snapshot, header = self.control.snapshot(), self.outputs.header()
        self.outputs.publish("status", status_to_msg(snapshot, loaded, header))
        told = (
            *(self.is_active, snapshot.plan, snapshot.pressure_target, seen_object),
            *(None if grip is None else grip.computed_at, loaded.is_regime_from_contact),
            *(loaded.planner.held_range, self.limits.pressure_cap, self.values.grip.payload),
        )
        if any(moved.values()) or told != self._wrap_told:
            self._wrap_told = told
            known = self.limits.pressure_cap, grip, seen_object, now, header
            wrap = wrap_to_msg(snapshot, loaded, *known)
            wrap.grip = self.grip_message(grip)
            self.outputs.publish("wrap", wrap)
        curve, points = loaded.curve(radius, seen_object), self.values.publish.backbone_points
        is_other, self._curve = curve is not self._curve, curve
        shapes = (
            (seen.pressure_command, loaded.commanded),
            (loaded.measured.pressure, loaded.measured),
        )
        for (name, has_moved), (at, free) in zip(moved.items(), shapes, strict=True):
            tube = tube_at(curve, at, free.shape)
            if tube is not None and (has_moved or is_other):
                self.outputs.publish(name, backbone_to_msg(tube, points, header))
        self.log.tell(now, snapshot)

    def _made(self, description: GripperDescription) -> LoadedGripper:
        """Return a gripper that is still to be planned for."""
        gravity, pools = gravity_or_own(self.gravity, description.gripper), self.background
        table = self._beside(read_grips, description)
        if table is not None:
            table = replace(table, computed_at=self.now())
            radii, held = len(table.radii), sum(grip is not None for grip in table.grips)
            self.logger.info(f"{grips_path(description)}: {held} of {radii} radii are held")
        grips = GripFollower(description.gripper, gravity, table, self.solve_grip, pools.grips)
        regions = self._beside(read_regions, description) or ()
        if regions:
            self.logger.info(f"regions of capture beside the description: {len(regions)}")
        return LoadedGripper(description, gravity, pools.gravity, grips, regions)

    def _beside(
        self, read: Callable[[GripperDescription], Beside], description: GripperDescription
    ) -> Beside | None:
        """Return what a file beside a description holds; log why that cannot be used."""
        try:
            return read(description)
        except FileError as error:
            self.log.tell_nothing_beside(error)
        return None

    def _limits(self) -> Limits:
        own = NO_GRIPPER_PRESSURE if self.loaded is None else self.loaded.gripper.pressure_max
        return self.values.limits(own)


class Outputs:
    """The node's publishers.

    ``pressure_command`` and ``/diagnostics`` exist as long as the node, in every lifecycle state,
    so that a vent always gets out; the others are lifecycle publishers.

    Args:
        node: the node that publishes.
        frame_id: frame of the stamped messages.
    """

    def __init__(self, node: LifecycleNode, frame_id: str) -> None:
        self._node = node
        self._frame_id = frame_id
        self._pressure = node.create_publisher(Float64, "pressure_command", COMMAND)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._managed: dict[str, LifecyclePublisher] = {}

    def configure(self) -> None:
        """Create the lifecycle publishers."""
        for name, kind in _MANAGED.items():
            self._managed[name] = self._node.create_lifecycle_publisher(kind, name, LATEST)

    def cleanup(self) -> None:
        """Destroy the lifecycle publishers."""
        for publisher in self._managed.values():
            self._node.destroy_lifecycle_publisher(publisher)
        self._managed.clear()

    def header(self) -> Any:  # noqa: ANN401
        """Return a header with the present time and the gripper's frame."""
        return Header(stamp=self._node.get_clock().now().to_msg(), frame_id=self._frame_id)

    def publish_pressure(self, pressure: float) -> None:
        """Publish a gauge pressure [Pa]; anything that is not a finite number goes out as 0."""
        self._pressure.publish(Float64(data=pressure if math.isfinite(pressure) else 0.0))

    def publish(self, name: str, message: Any) -> None:  # noqa: ANN401
        """Publish status, markers or a shape on the topic of this name, if the node is active."""
        publisher = self._managed.get(name)
        if publisher is not None:
            publisher.publish(message)

    @property
    def markers_are_wanted(self) -> bool:
        """Whether anybody subscribes to ``markers``."""
        publisher = self._managed.get("markers")
        return publisher is not None and publisher.get_subscription_count() > 0

    def publish_diagnostics(self, diagnostics: DiagnosticArray) -> None:
        """Publish the diagnostics."""
        self._diagnostics.publish(diagnostics)

    def flush(self) -> None:
        """Wait until the last pressure is acknowledged, or for ``ACKNOWLEDGE_TIMEOUT``."""
        self._pressure.wait_for_all_acked(Duration(seconds=ACKNOWLEDGE_TIMEOUT))
