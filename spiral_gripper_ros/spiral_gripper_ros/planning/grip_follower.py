# SPDX-License-Identifier: Apache-2.0
"""Grips solved in the background: a table over the radii, and the object in use. No ROS."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from typing import TypeAlias

from spiral_core.errors import SpiralError
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_gripper_ros.planning.grip_figures import GripAnswer, GripFigures, GripQuestion
from spiral_gripper_ros.planning.grip_table import RefiningTable, table_radii
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.worker import EndedError

# The table's radii keep this fraction away from the ends of the range, where nothing is held.
MARGIN = 0.03
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

    def is_like(self, other: InUse | None) -> bool:
        """Return whether a grip on the one stands for the other."""
        if other is None or (self.seen is None) is not (other.seen is None):
            return False
        if not abs(self.radius - other.radius) <= RADIUS_TOLERANCE * self.radius:
            return False
        return self.seen is None or other.seen is None or _is_near(self.seen, other.seen)


# Answers a question, in seconds, unless its answer is no longer wanted.
Solve: TypeAlias = Callable[[GripQuestion, Callable[[], bool]], GripFigures]


class GripFollower:
    """Keeps the table of grips and the grip on the object in use up to date, one at a time.

    One thread follows; any other may ask for answers meanwhile: what they read is exchanged whole.

    Args:
        gripper: as described.
        gravity: that is present [m/s^2].
        solve: called in the background.
        pool: runs the background work.
    """

    def __init__(
        self,
        gripper: Gripper,
        gravity: Vector,
        solve: Solve,
        pool: Executor,
    ) -> None:
        self._gripper, self._gravity = gripper, gravity
        self._solve, self._pool = solve, pool
        self._count = 0
        self._table: RefiningTable | None = None
        self._in_use: tuple[InUse, GripFigures | SpiralError | None] | None = None
        self._wanted: InUse | None = None
        self._wanted_at = 0.0
        self._turned_at = -math.inf  # when gravity changed
        self._job: tuple[float | InUse | None, Future[GripFigures]] | None = None
        self._outdated = threading.Event()  # the job's answer

    def follow(
        self,
        now: float,
        gravity: Vector,
        radius_range: tuple[float, float],
        count: int,
        in_use: InUse | None,
    ) -> bool:
        """Take the grips that are solved and start the next one; return whether one was taken.

        Args:
            now: time [s], never decreasing.
            gravity: that is present [m/s^2].
            radius_range: of the radii that can be wrapped [m].
            count: of the table's radii; 0: nothing is computed.
            in_use: the object in use.
        """
        taken = self._take(now)
        if math.dist(gravity, self._gravity) > GRAVITY_TOLERANCE:
            self._gravity, self._turned_at = gravity, now
            self._forget()
        low, high = radius_range
        has_table = count > 1 and math.isfinite(high)
        if count != self._count or (has_table and self._table is None):
            self._forget()
            self._count = count
            if has_table:
                radii = table_radii((1.0 + MARGIN) * low, (1.0 - MARGIN) * high, count)
                self._table = RefiningTable(radii)
        if in_use is None or not in_use.is_like(self._wanted):
            self._wanted, self._wanted_at = in_use, now
        if self._job is None and count and now - self._turned_at >= SETTLING:
            self._start(now)
        return taken

    def answer(self, in_use: InUse, tip_pressure: float, pressure: float) -> GripAnswer | None:
        """Return the grip on an object at a pressure [Pa], or None if it is not known.

        Args:
            in_use: the object.
            tip_pressure: of its wrap by the tip criterion [Pa].
            pressure: gauge [Pa].
        """
        found, table = self.found(in_use), self._table
        if isinstance(found, GripFigures):
            return found.answer(pressure, at_pose=in_use.seen is not None)
        if table is None or in_use.seen is not None:
            return None
        return table.answer(in_use.radius, tip_pressure, pressure)

    def window(self, radius: float, tip_pressure: float) -> tuple[float, float, float] | None:
        """Return where the wrap of a radius [m] begins, curls and is lost [Pa], if that is known.

        Args:
            radius: of the object [m].
            tip_pressure: of its wrap by the tip criterion [Pa].
        """
        table = self._table
        return None if table is None else table.window(radius, tip_pressure)

    def found(self, in_use: InUse) -> GripFigures | SpiralError | None:
        """Return the grip that was computed for this very object, or why it has none, if known."""
        known = self._in_use
        return None if known is None or not in_use.is_like(known[0]) else known[1]

    def end(self) -> None:
        """Take back the question; another gripper or another life follows."""
        self._outdated.set()
        if self._job is not None:
            self._job[1].cancel()

    def _forget(self) -> None:
        self._table = self._in_use = None
        self.end()
        if self._job is not None:  # if it runs, whatever it answers is for what was
            self._job = None, self._job[1]

    def _take(self, now: float) -> bool:
        if self._job is None or not self._job[1].done():
            return False
        (what, job), self._job = self._job, None
        if what is None or job.cancelled() or isinstance(job.exception(), EndedError):
            return False  # a process that was killed is asked again
        error, grip = job.exception(), None
        if error is None:
            grip = replace(job.result(), computed_at=now)
        if isinstance(what, InUse):  # None: a defect, raised below
            self._in_use = what, error if isinstance(error, SpiralError) else grip
        elif self._table is not None:
            self._table = self._table.added(what, grip)
        if error is not None and not isinstance(error, SpiralError):
            raise error
        return True

    def _start(self, now: float) -> None:
        wanted, table = self._wanted, self._table
        is_known = (
            self._in_use is not None and wanted is not None and wanted.is_like(self._in_use[0])
        )
        if wanted is not None and not is_known and now - self._wanted_at >= SETTLING:
            self._ask(wanted, wanted)
        elif table is not None and (radius := table.next_radius()) is not None:
            self._ask(radius, InUse(radius))

    def _ask(self, what: float | InUse, asked: InUse) -> None:
        mounted = self._gripper.with_mount(self._gravity, self._gripper.object_axis)
        pose = None if asked.seen is None else (asked.seen.center, asked.seen.axis)
        question = GripQuestion(mounted, asked.radius, None, pose)
        outdated = self._outdated = threading.Event()
        self._job = what, self._pool.submit(self._solve, question, lambda: not outdated.is_set())


def _is_near(one: SeenObject, other: SeenObject) -> bool:
    near = math.dist(one.center, other.center) <= PLACE_TOLERANCE
    along = abs(math.fsum(a * b for a, b in zip(one.axis, other.axis, strict=True)))
    return near and along >= math.cos(TURN_TOLERANCE)
