# SPDX-License-Identifier: Apache-2.0
"""What is known of grips: a table over the radii, and the object in use, solved. No ROS."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from operator import mul
from typing import TypeAlias

from spiral_core.errors import SpiralError
from spiral_core.grip.curve import GripAnswer, GripCurve, GripQuestion
from spiral_core.grip.table import GripTable
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_gripper_ros.control.plan import WrapPlan
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.worker import EndedError

# Grips stand while gravity is within this of theirs [m/s^2]: a tenth of it.
GRAVITY_TOLERANCE = 1.0
# A grip on the object in use stands while the radius is within this fraction of its own, and the
# object within these [m], [rad] of its place.
RADIUS_TOLERANCE = 0.01
PLACE_TOLERANCE = 0.002
TURN_TOLERANCE = 0.05
# The object in use is computed once it has been the same for this time [s].
SETTLING = 0.5


@dataclass(frozen=True, slots=True)
class InUse:
    """The object in use.

    Args:
        radius: [m].
        seen: where it is, or None: laid into the coil.
    """

    radius: float
    seen: SeenObject | None = None

    @property
    def is_seen(self) -> bool:
        """Whether it is known where it is."""
        return self.seen is not None

    def is_like(self, other: InUse | None) -> bool:
        """Return whether a grip on the one stands for the other."""
        if other is None or self.is_seen is not other.is_seen:
            return False
        if not abs(self.radius - other.radius) <= RADIUS_TOLERANCE * self.radius:
            return False
        if self.seen is None or other.seen is None:
            return True
        along = abs(sum(map(mul, self.seen.axis, other.seen.axis)))
        near = math.dist(self.seen.center, other.seen.center) <= PLACE_TOLERANCE
        return near and along >= math.cos(TURN_TOLERANCE)


# Answers a question, in seconds, unless its answer is no longer wanted.
Solve: TypeAlias = Callable[[GripQuestion, Callable[[], bool]], GripCurve]


class GripFollower:
    """Knows the grips of a table, and keeps the grips on the object in use up to date.

    Those are the grip on the object laid into the coil, of which plans are made, and the one on the
    object where it is seen, if it is. One is solved at a time, the former first.

    One thread follows; any other may ask for answers meanwhile: what they read is exchanged whole.

    Args:
        gripper: as described.
        gravity: that is present [m/s^2].
        table: of the gripper's grips, or None.
        solve: called in the background.
        pool: runs the background work.
    """

    def __init__(
        self,
        gripper: Gripper,
        gravity: Vector,
        table: GripTable | None,
        solve: Solve,
        pool: Executor,
    ) -> None:
        self._gripper, self._gravity = gripper, gravity
        self._table = table
        self._solve, self._pool = solve, pool
        self._is_on, self._rate = True, math.nan
        # Of the object laid into the coil (False), and where it is seen (True).
        self._known: dict[bool, tuple[InUse, GripCurve | SpiralError | None]] = {}
        self._wanted: list[tuple[InUse, float]] = []  # and since when it has been the same
        self._turned_at = -math.inf  # when gravity changed
        self._job: tuple[InUse, Future[GripCurve]] | None = None
        self._outdated = threading.Event()  # the job's answer

    @property
    def in_use(self) -> InUse | None:
        """The object in use, or None."""
        return self._wanted[-1][0] if self._wanted else None

    def follow(
        self, now: float, gravity: Vector, rate: float, in_use: InUse | None, *, is_on: bool = True
    ) -> bool:
        """Take the grip that is solved, start the next one; return whether plans may differ now.

        Args:
            now: time [s], never decreasing.
            gravity: that is present [m/s^2].
            rate: of the ramps [Pa/s].
            in_use: the object in use.
            is_on: whether anything is known and computed.
        """
        taken = self._take()
        is_turned = math.dist(gravity, self._gravity) > GRAVITY_TOLERANCE
        is_switched = is_on is not self._is_on
        if is_turned:
            self._gravity, self._turned_at = gravity, now
        if is_turned or is_switched or rate != self._rate:
            self._is_on, self._rate = is_on, rate
            self.end()
        objects = [] if in_use is None else [InUse(in_use.radius)]
        if in_use is not None and in_use.is_seen:
            objects.append(in_use)
        self._wanted = [
            next((known for known in self._wanted if one.is_like(known[0])), (one, now))
            for one in objects
        ]
        if self._job is None and is_on and now - self._turned_at >= SETTLING:
            self._start(now)
        return taken or is_switched

    def table(self, gravity: Vector) -> GripTable | None:
        """Return the table of grips, if there is one for a gravity [m/s^2]."""
        table = self._table if self._is_on else None
        if table is None or math.dist(table.gravity, gravity) > GRAVITY_TOLERANCE:
            return None
        return table

    def answer(self, plan: WrapPlan, seen: SeenObject | None, pressure: float) -> GripAnswer | None:
        """Return the grip on an object at a pressure [Pa], or None if it is not known.

        Args:
            plan: of its wrap.
            seen: where it is, or None: laid into the coil.
            pressure: gauge [Pa].
        """
        radius, gravity = plan.wrap.object_radius, plan.gripper.gravity
        found, table = self.found(InUse(radius, seen), gravity), self.table(gravity)
        if isinstance(found, GripCurve):
            return found.answer(pressure, at_pose=seen is not None)
        if table is None or seen is not None:
            return None
        known = table.answer(radius, plan.laid.pressure, pressure)
        if known is None or table.rate == self._rate:
            return known
        return replace(known, settling=math.nan)

    def found(self, in_use: InUse, gravity: Vector) -> GripCurve | SpiralError | None:
        """Return the grip that was computed for this very object, or why it has none, if known."""
        known = self._known.get(in_use.is_seen)
        if known is None or math.dist(gravity, self._gravity) > GRAVITY_TOLERANCE:
            return None
        return known[1] if in_use.is_like(known[0]) else None

    def end(self) -> None:
        """Take back the question, and forget what is known of the object in use."""
        self._known = {}
        self._outdated.set()  # if the job runs, whatever it answers is for what was
        if self._job is not None:
            self._job[1].cancel()

    def _take(self) -> bool:
        """Take the grip that is solved; return whether plans are made of it."""
        if self._job is None or not self._job[1].done():
            return False
        (in_use, job), self._job = self._job, None
        if self._outdated.is_set() or isinstance(job.exception(), EndedError):
            return False  # a process that was killed is asked again
        try:
            self._known[in_use.is_seen] = in_use, job.result()
        except SpiralError as error:
            self._known[in_use.is_seen] = in_use, error
        except Exception:  # a defect, once
            self._known[in_use.is_seen] = in_use, None
            raise
        return not in_use.is_seen

    def _start(self, now: float) -> None:
        """Start the first question that has settled and is not answered yet."""
        for wanted, since in self._wanted:
            known = self._known.get(wanted.is_seen)
            is_known = known is not None and wanted.is_like(known[0])
            if not is_known and now - since >= SETTLING:
                self._ask(wanted)
                return

    def _ask(self, wanted: InUse) -> None:
        mounted = self._gripper.with_mount(self._gravity, self._gripper.object_axis)
        pose = None if wanted.seen is None else (wanted.seen.center, wanted.seen.axis)
        question = GripQuestion(mounted, wanted.radius, None, pose)
        outdated = self._outdated = threading.Event()
        self._job = wanted, self._pool.submit(self._solve, question, lambda: not outdated.is_set())
