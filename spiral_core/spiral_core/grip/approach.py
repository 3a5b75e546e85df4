# SPDX-License-Identifier: Apache-2.0
"""The approach: how an arm should hold the gripper to grip an object that stands in the world."""

from __future__ import annotations

import math
import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from spiral_core.errors import NoCoilError, NotGrippableError, SolverError, SpiralError
from spiral_core.grip.capture import (
    CaptureOutcome,
    CaptureRegion,
    Misplacement,
    capture_region,
    close_misplaced,
    middle_of,
)
from spiral_core.grip.grip import Grip, recommended_grip
from spiral_core.grip.holding import Pull, holding_force
from spiral_core.grip.places import FARTHEST_SHIFT, evenly, missing_to_wrap
from spiral_core.grip.setup import GripSetup, lay_into_coil, vector_of
from spiral_core.grip.window import GripPoint, WindowEnd, grip_window
from spiral_core.numerics.tasks import Progress, resume
from spiral_core.rod.contact.obstacles import Quaternion
from spiral_core.rod.types import Array, Vector
from spiral_core.validation import (
    require_direction,
    require_finite,
    require_in_range,
    require_kind,
    require_non_negative,
    require_positive,
    require_vector,
)
from spiral_core.wrap.gripper import Gripper

# Directions of gravity in the base frame that a search begins with: in a coarse one, in a full one.
COARSE_DIRECTIONS, DIRECTIONS = 24, 60
# Fewer where the arm cannot tilt: they are not closer than this to each other [rad].
CLOSEST = math.radians(3.0)
# Turns of the object about gravity; tried are those nearest to the free coil's axis, and to lines
# that lean from it: the end to which the coil advances toward the base. Objects that lean so are
# often held with larger errors, others with more force.
TURNS, LEANS = 36, np.radians((0.0, 12.0, 24.0))
# Below this sine of the angle between gravity and object, 5 degrees, a turn about gravity changes
# nothing that counts; below the second one it is not defined. Steps of such turns.
UPRIGHT, PARALLEL, ALIKE = 0.087, 1e-3, 120
# Poses are compared on so many elements, at these fractions of the tip criterion's pressure.
SCREEN_ELEMENTS = 45
SCREEN_PRESSURES = (0.3, 0.6, 0.75, 0.85, 0.9, *np.arange(0.94, 1.31, 0.04).tolist())
# Of what grips 3 % wraps later, and holds with no error; the rest passes the object by, at twice
# the cost.
SCREEN_GIVE_UP = 1.0
# Poses that are reported differ by more than this angle [rad], and there are so many.
LEAST_ANGLE, REPORTED = math.radians(20.0), 3
# Where fewer distinct ones grip, others are tried around so many that come nearest, so many around
# each: turned [rad] and shifted by up to these parts of a box.
NEAREST, AROUND, PARTS = 4, 10, (1.0, 0.5, 0.25)
LARGEST_TURN = math.radians(25.0)
# Of the best so many distinct ones are judged by their region of capture.
JUDGED = 12
# They are judged by errors of the pose in each direction alone: multiples of a millimeter and a
# degree; on the way there by two of them. Regions that differ by less than half a millimeter are
# equal [m].
ERRORS, FIRST_ERRORS = (2.0, 4.0, 6.0, 9.0, 13.0, 18.0), (4.0, 9.0)
# Components of an error and their senses; those in which a grip is lost most often come first.
WAYS = ((3, 1), (0, -1), (2, 1), (2, -1), (3, -1), (0, 1), (1, -1), (1, 1))
UNIT_ERRORS = np.array((1e-3, 1e-3, math.radians(1.0), math.radians(1.0), 1e-3))
EQUAL_REGIONS = 0.5e-3
# Components of an error along which the middle of the region is looked for, one after the other, in
# so many millimeters or degrees, so often at most.
CENTERED, CENTER_STEP, CENTER_STEPS = (0, 1, 3, 2, 0, 1), 3.0, 6

# Reasons that differ in figures alone are counted together.
FIGURE = re.compile(r"\d+(\.\d+)?")
REFUSALS = (NotGrippableError, NoCoilError, SolverError)
# Name of the stage, numbers of the pose and, in the region of capture, of the misplacement.
Key = tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class ApproachTask:
    """An object that stands in the world, and what the arm may do.

    Args:
        gripper: in any mount; with its friction, or the default's.
        radius: of the cylinder [m], at most the tube's length.
        object_axis: direction of its axis in the world, in either sense, of any length.
        gravity: acceleration in the world [m/s^2], not zero.
        payload: mass of the object [kg]; None: force counts, not its ratio to a weight.
        tilt_max: largest angle between the tube at the base and gravity [rad], in (0, pi].

    Raises:
        InvalidInputError: a value is out of its range.
    """

    gripper: Gripper
    radius: float
    object_axis: Vector
    gravity: Vector
    payload: float | None = None
    tilt_max: float = math.pi

    def __post_init__(self) -> None:
        require_kind("gripper", self.gripper, Gripper)
        require_positive("radius", self.radius)
        require_in_range("radius", self.radius, 0.0, self.gripper.tube.length, "m")
        if self.payload is not None:
            require_positive("payload", self.payload)
        require_positive("tilt_max", self.tilt_max)
        require_in_range("tilt_max", self.tilt_max, 0.0, math.pi, "rad")
        _ = self.axis  # checked with gravity

    @property
    def down(self) -> Array:
        """Direction of gravity in the world (3,)."""
        return np.array(require_direction("gravity", self.gravity))

    @property
    def axis(self) -> Array:
        """Direction of the object in the world (3,), in the sense that is nearer to gravity."""
        axis = np.array(require_direction("object_axis", self.object_axis))
        return axis if axis @ self.down >= 0.0 else -axis

    @property
    def sine(self) -> float:
        """Sine of the angle between gravity and the object."""
        return float(np.linalg.norm(np.cross(self.axis, self.down)))

    def mounted(self, gravity: Vector, axis: Vector | None = None) -> Gripper:
        """Return the gripper with gravity along a unit vector in the base frame."""
        magnitude = math.hypot(*self.gravity)
        return self.gripper.with_mount(vector_of(magnitude * np.array(gravity)), axis)


@dataclass(frozen=True, slots=True)
class BasePose:
    """Where gravity and object are as the base sees them: all that a grip depends on.

    Args:
        gravity: its direction in the base frame, a unit vector.
        axis: the object's direction there, at its angle to gravity in the world.
        shift: of the object from where it lies in the free coil, in the base frame [m].
    """

    gravity: Vector
    axis: Vector
    shift: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Trial:
    """What a pose was found to do, as plain numbers.

    Args:
        refusal: why it does not grip; empty if it does.
        missing: how far it stays from the wrap (:func:`missing_to_wrap`).
        pressure: recommended [Pa].
        force: that holds the object against gravity [N].
        size: of the region of capture [m], as far as known: largest root of the sum of squares of
            the errors of the pose, two shifts and two tilts, a degree counted as a millimeter.
        center: misplacement of the object (5,) by which the pose was changed for this; or empty.

    Raises:
        InvalidInputError: a value is not finite; ``missing`` may be infinite.
    """

    refusal: str
    missing: float = math.inf
    pressure: float = 0.0
    force: float = 0.0
    size: float = 0.0
    center: Misplacement = ()

    def __post_init__(self) -> None:
        if self.center:
            object.__setattr__(self, "center", require_vector("center", self.center, 5))
        for name in ("pressure", "force", "size"):
            require_finite(name, getattr(self, name))
        if self.missing != math.inf:
            require_non_negative("missing", self.missing)

    @property
    def score(self) -> tuple[float, ...]:
        """The larger the better: it grips; its region in half millimeters; force; how near."""
        regions = math.floor(self.size / EQUAL_REGIONS + 1e-9)
        return (not self.refusal, regions, self.force, -self.missing)


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """A base pose that grips.

    Args:
        task: the object in the world.
        pose: what the base sees.
        point: the grip at the recommended pressure.
        found: pressure, force and, unless the answer is coarse, the size of the region of capture.
        region: of capture at that pressure, without its outlines; None in a coarse answer.
    """

    task: ApproachTask
    pose: BasePose
    point: GripPoint
    found: Trial
    region: CaptureRegion | None = None

    @property
    def orientation(self) -> Quaternion:
        """Of the base in the world: unit quaternion, scalar last."""
        x, y, z, w = base_rotation(self.task, self.pose).as_quat().tolist()
        return (x, y, z, w)

    @property
    def position(self) -> Vector:
        """Of the base in the world, relative to the middle of what is gripped of the object [m]."""
        center = np.array(self.point.setup.obstacle.position)
        return vector_of(base_rotation(self.task, self.pose).apply(-center))


@dataclass(frozen=True, slots=True, eq=False)
class ApproachAnswer:
    """How an arm should hold the gripper.

    Args:
        task: what was asked.
        approaches: the best first, each more than 20 degrees from the others; at most three.
        tried: what each pose was found to do, on few elements; the best on the usual ones.
    """

    task: ApproachTask
    approaches: tuple[Approach, ...]
    tried: Mapping[BasePose, Trial]

    @property
    def gripping(self) -> int:
        """Number of poses tried that grip."""
        return sum(not trial.refusal for trial in self.tried.values())

    @property
    def nearest(self) -> BasePose:
        """The best pose of those tried; where none grips, the one that comes nearest."""
        return max(self.tried, key=lambda pose: self.tried[pose].score)

    @property
    def reasons(self) -> Counter[str]:
        """Why poses do not grip, with their numbers; of alike ones the first."""
        alike: dict[str, str] = {}
        refusals = [trial.refusal for trial in self.tried.values() if trial.refusal]
        return Counter(alike.setdefault(FIGURE.sub("", each), each) for each in refusals)


Stage = Callable[[ApproachTask, BasePose], Trial]
Found = Any  # a Trial, or the CaptureOutcome of a misplacement


def approach_setup(task: ApproachTask, pose: BasePose, elements: int | None = None) -> GripSetup:
    """Return the setup of a base pose.

    Raises:
        NotGrippableError: no pressure coils the gripper to this radius in this pose.
        NoCoilError: it makes no coil.
        SolverError: a shape could not be certified.
    """
    gripper = task.mounted(pose.gravity, pose.axis)
    setup = lay_into_coil(gripper, task.radius, elements=elements)
    return replace(setup, obstacle=setup.obstacle.moved(pose.shift))


def centered(task: ApproachTask, pose: BasePose, center: Misplacement) -> BasePose:
    """Return a pose in which the object lies where a misplacement (5,) of it puts it.

    The base is turned with the object: their angle to gravity stays the object's in the world.

    Raises:
        NotGrippableError, NoCoilError, SolverError: see :func:`approach_setup`.
    """
    if not any(center):
        return pose
    setup = approach_setup(task, pose)
    turn = Rotation.from_rotvec(np.array(center[2:4]) @ setup.frame[1:])
    gravity, axis = (vector_of(turn.apply(each)) for each in (pose.gravity, pose.axis))
    there = setup.moved(np.array((0.0, *center[:4]))).obstacle.position
    here = approach_setup(task, BasePose(gravity, axis)).obstacle.position
    return BasePose(gravity, axis, vector_of(np.subtract(there, here)))


def base_rotation(task: ApproachTask, pose: BasePose) -> Rotation:
    """Return the rotation from the base frame to the world.

    Of an object along gravity any turn about it is the same; one of them is returned.
    """
    gravity = np.array(pose.gravity)
    if task.sine < PARALLEL:
        return _aligned(task.down, gravity)
    return Rotation.align_vectors((task.down, task.axis), (gravity, pose.axis))[0]


def _aligned(there: Array, seen: Array) -> Rotation:
    """Return a rotation from one unit vector to another."""
    square = [np.cross(each, np.eye(3)[np.argmin(np.abs(each))]) for each in (there, seen)]
    return Rotation.align_vectors((there, square[0]), (seen, square[1]))[0]


def angle_between(task: ApproachTask, first: BasePose, second: BasePose) -> float:
    """Return the angle by which two base orientations differ, by the object's symmetry [rad].

    Along gravity, to 5 degrees, any turn about gravity is one of the object; level, half a turn.
    """
    level = bool(task.axis @ task.down < PARALLEL)
    turns = _turns(task.down, ALIKE if task.sine < UPRIGHT else 1 + level)
    one, other = (base_rotation(task, pose) for pose in (first, second))
    return float((one.inv() * turns * other).magnitude().min())


def tilt_of(pose: BasePose) -> float:
    """Return the angle between the tube at the base and gravity [rad].

    Example:
        >>> level = (0.0, 1.0, 0.0)
        >>> round(math.degrees(tilt_of(BasePose(gravity=level, axis=level))), 6)
        90.0
    """
    return math.acos(min(max(pose.gravity[0], -1.0), 1.0))


def candidate_poses(task: ApproachTask, directions: int = DIRECTIONS) -> tuple[BasePose, ...]:
    """Return the base poses that a search begins with, well spread within the limit of the tilt.

    Gravity lies along each axis of the base frame, hanging, upright and level, and along a spiral
    on the sphere. The object is turned about gravity to where it lies nearest to the axis of the
    coil that hangs there freely, and to lines that lean from it.
    """
    height = 1.0 - math.cos(task.tilt_max)
    directions = min(directions, math.ceil(2.0 * math.pi * height / CLOSEST**2))
    number = np.arange(directions) + 0.5
    x = 1.0 - height * number / directions
    turn, across = number * math.pi * (3.0 - math.sqrt(5.0)), np.sqrt(1.0 - x * x)
    spiral = np.stack((x, across * np.cos(turn), across * np.sin(turn)), axis=1)
    downs = np.concatenate((np.eye(3), 0.0 - np.eye(3), spiral))
    poses = [pose for down in downs for pose in _turned(task, down)]
    return tuple(pose for pose in poses if tilt_of(pose) <= task.tilt_max)


def _turned(task: ApproachTask, down: Array) -> list[BasePose]:
    """Return the poses of a direction of gravity: the object turned about it."""
    gravity = vector_of(down)
    if task.sine < PARALLEL:
        return [BasePose(gravity, gravity)]
    axes = _turns(down, TURNS).apply(_aligned(down, task.down).apply(task.axis))
    try:
        along, away, _ = lay_into_coil(task.mounted(gravity), task.radius).frame
    except REFUSALS:  # as every pose of this direction will be
        return [BasePose(gravity, vector_of(axes[0]))]
    lines = np.outer(along, np.cos(LEANS)) - np.outer(away, np.sin(LEANS))
    nearest = np.abs(axes @ lines).round(9).argmax(axis=0).tolist()  # the first of equal ones
    return [BasePose(gravity, vector_of(axes[turn])) for turn in dict.fromkeys(nearest)]


def _turns(axis: Array, count: int) -> Rotation:
    """Return evenly spaced turns about an axis."""
    return Rotation.from_rotvec(2.0 * math.pi * np.arange(count)[:, None] / count * axis)


def coarse_grip(task: ApproachTask, pose: BasePose) -> GripPoint | Trial:
    """Return the grip of a pose on few elements, without payload, or why there is none."""
    try:
        setup = approach_setup(task, pose, SCREEN_ELEMENTS)
        pressures = np.array(SCREEN_PRESSURES) * (setup.tip_pressure or 0.0)
        looked_at = np.unique(np.minimum(pressures, setup.gripper.pressure_max))
        window = grip_window(setup, looked_at, give_up=SCREEN_GIVE_UP)
        if window.onset_wrap is None:
            passed = WindowEnd.PASSED_BY if window.is_cut_short else window.end
            return Trial(passed.value, missing_to_wrap(window))
        return window.at(Grip(window, (), {}).recommended_pressure())
    except REFUSALS as error:
        return Trial(_reason(error))


def screen(task: ApproachTask, pose: BasePose) -> Trial:
    """Return whether a pose grips, and with what force, on few elements."""
    found = coarse_grip(task, pose)
    return found if isinstance(found, Trial) else _held(found)


def screen_shifted(task: ApproachTask, pose: BasePose) -> Trial:
    """Return what :func:`screen` does, and whether the pose holds with first errors."""
    found = coarse_grip(task, pose)
    return found if isinstance(found, Trial) else _sized(found, None, FIRST_ERRORS)


def judge(task: ApproachTask, pose: BasePose) -> Trial:
    """Return what a pose holds, and the size of its region of capture by one error at a time.

    Or of the pose in which the object lies in the middle of that region, where that is better.
    """
    try:
        point = gripped(task, pose)
    except REFUSALS as error:  # of a pose that wraps on few elements
        return Trial(_reason(error), 0.0)
    found = [_sized(point, task.payload, ERRORS)]
    center = _middle(task, point)
    with suppress(*REFUSALS):
        moved = centered(task, pose, center)
        if tilt_of(moved) > task.tilt_max:  # the shifts alone
            center = (*center[:2], 0.0, 0.0, 0.0)
            moved = centered(task, pose, center)
        if any(center):
            sized = _sized(gripped(task, moved), task.payload, ERRORS)
            found.append(replace(sized, center=center))
    return max(found, key=lambda trial: trial.score)


def _sized(point: GripPoint, payload: float | None, sizes: Sequence[float]) -> Trial:
    """Return what a grip holds, and with which of some errors.

    What holds with some errors is taken to hold with smaller ones: half of the sizes are asked.
    """
    held = bisect_left(sizes, True, key=lambda size: not holds_shifted(point, size, payload))
    return _held(point, (0.0, *sizes)[held])


def _middle(task: ApproachTask, point: GripPoint) -> Misplacement:
    """Return the misplacement (5,) of the object to the middle of a grip's region of capture."""
    holds, steps = partial(_holds, point, task.payload), CENTER_STEP * np.diag(UNIT_ERRORS)
    return tuple(middle_of(holds, [steps[way] for way in CENTERED], CENTER_STEPS).tolist())


def holds_shifted(point: GripPoint, size: float, payload: float | None = None) -> bool:
    """Return whether a grip holds with each error of the pose alone, millimeters and degrees."""
    errors = size * np.diag(UNIT_ERRORS)
    if errors[2, 2] >= point.setup.balance_angle:  # the tube may fall to another side
        return False
    return all(_holds(point, payload, sense * errors[way]) for way, sense in WAYS)


def _holds(point: GripPoint, payload: float | None, off: Array) -> bool:
    """Return whether a grip holds with a misplacement (5,), by few elements."""
    closed = close_misplaced(point.setup, point.pressure, off, payload, SCREEN_ELEMENTS)
    return closed.outcome is CaptureOutcome.HOLDS


def gripped(task: ApproachTask, pose: BasePose) -> GripPoint:
    """Return the grip of a pose at its recommended pressure."""
    return recommended_grip(approach_setup(task, pose), task.payload)


def _held(point: GripPoint, error: float = 0.0) -> Trial:
    """Return what a grip holds, with errors up to a number of millimeters and degrees.

    A force along gravity that is not known counts as none.
    """
    force = holding_force(point, Pull.DOWN).force
    return Trial("", 0.0, point.pressure, 0.0 if math.isnan(force) else force, 1e-3 * error)


def _reason(error: SpiralError) -> str:
    """Return why a pose does not grip."""
    return error.constraint if isinstance(error, NotGrippableError) else str(error)


def find_approaches(
    task: ApproachTask,
    *,
    coarse: bool = False,
    executor: Executor | None = None,
    progress: Progress | None = None,
    known: Mapping[Key, Found] | None = None,
    keep: Callable[[Key, Found], None] | None = None,
) -> ApproachAnswer:
    """Return the base poses that grip an object best.

    Poses spread over all orientations within the limit are closed on few elements and, unless
    coarse, with first errors of the pose. If hardly any grips, others follow around those that come
    nearest, turned and shifted. Of those that differ, first those that hold with larger errors,
    then the strongest, the region of capture is estimated, and the pose moved to its middle; the
    three best of all get their whole region.

    Args:
        task: the object in the world, and the limit of the arm.
        coarse: only whether it grips, and a pose: no regions of capture.
        executor: where; None computes here.
        progress: called with the number of results of a stage that are new, and that it needs.
        known: results of an interrupted search; they are not computed again.
        keep: called with the key and the value of each new result, in order.

    Returns:
        At most three approaches, the best first; none where no pose tried grips: the answer then
        has the reasons and the nearest pose.
    """
    search = Search(task, executor, progress, dict(known or {}), keep)
    tried = search.screened(coarse=coarse)
    best = search.judged(tried, coarse=coarse)
    approaches: list[Approach] = []
    while len(approaches) < REPORTED:
        left = distinct(task, best, REPORTED)[len(approaches) :]
        if not left or best[left[0]].refusal:
            break
        pose = left[0]
        try:
            point = gripped(task, pose)
        except REFUSALS as error:
            best[pose] = Trial(_reason(error), 0.0)
            continue
        approach = Approach(task, pose, point, _held(point))
        approaches.append(approach if coarse else search.with_region(approach))
    approaches.sort(key=lambda each: each.found.score, reverse=True)
    return ApproachAnswer(task, tuple(approaches), tried | best)


def distinct(task: ApproachTask, trials: Mapping[BasePose, Trial], count: int) -> list[BasePose]:
    """Return the best poses that differ by more than 20 degrees, the best first."""
    found: list[BasePose] = []
    for pose in sorted(trials, key=lambda each: trials[each].score, reverse=True):
        if len(found) < count and all(
            angle_between(task, pose, other) > LEAST_ANGLE for other in found
        ):
            found.append(pose)
    return found


@dataclass(frozen=True, slots=True)
class Search:
    """Results for poses, here or on an executor, each computed once.

    Args:
        task: the object in the world, and the limit of the arm.
        executor: see :func:`find_approaches`, as are the others.
        progress: of each stage.
        known: results by key.
        keep: called with each new one.
    """

    task: ApproachTask
    executor: Executor | None = None
    progress: Progress | None = None
    known: dict[Key, Found] = field(default_factory=dict)
    keep: Callable[[Key, Found], None] | None = None

    def screened(self, *, coarse: bool) -> dict[BasePose, Trial]:
        """Return what poses do on few elements: spread out, then around the nearest."""
        task = self.task
        stage, directions = (screen, COARSE_DIRECTIONS) if coarse else (screen_shifted, DIRECTIONS)
        tried = self.solve(stage, candidate_poses(task, directions))
        for part in PARTS[: 1 if coarse else None]:
            if not any(tried[pose].refusal for pose in distinct(task, tried, REPORTED)):
                break
            tried |= self.solve(stage, self.around(distinct(task, tried, NEAREST), part))
        return tried

    def judged(self, tried: Mapping[BasePose, Trial], *, coarse: bool) -> dict[BasePose, Trial]:
        """Return the poses that grip; unless coarse the best, centered, with a region's size."""
        gripping = {pose: trial for pose, trial in tried.items() if not trial.refusal}
        if coarse:
            return gripping
        found = self.solve(judge, distinct(self.task, gripping, JUDGED))
        return {centered(self.task, pose, trial.center): trial for pose, trial in found.items()}

    def solve(self, stage: Stage, poses: Sequence[BasePose]) -> dict[BasePose, Trial]:
        """Return what poses do."""
        keys = {pose: _key(stage.__name__, pose) for pose in poses}
        items = {key: pose for pose, key in keys.items()}
        task = partial(stage, self.task)
        resume(task, items, self.known, self.keep, self.executor, self.progress)
        return {pose: self.known[key] for pose, key in keys.items()}

    def around(self, poses: Sequence[BasePose], part: float) -> list[BasePose]:
        """Return others around poses, turned and shifted by up to a part of the box."""
        reach = FARTHEST_SHIFT * (self.task.radius + self.task.gripper.tube.outer_radius)
        others = []
        for pose, step in product(poses, part * evenly(AROUND, 6)):
            shift = vector_of(pose.shift + reach * step[3:])
            for turned in (step[:3], step[0] * np.eye(3)[0]):  # or rolled alone
                turn = Rotation.from_rotvec(LARGEST_TURN * turned)
                gravity, axis = (vector_of(turn.apply(each)) for each in (pose.gravity, pose.axis))
                if tilt_of(BasePose(gravity, axis)) <= self.task.tilt_max:
                    others.append(BasePose(gravity, axis, shift))
                    break
        return others

    def with_region(self, approach: Approach) -> Approach:
        """Return an approach with its region of capture, and the size of that."""
        head, point = _key("capture", approach.pose), approach.point
        region = capture_region(
            point.setup,
            point.pressure,
            self.task.payload,
            outlines=False,
            executor=self.executor,
            progress=self.progress,
            known={key[10:]: one for key, one in self.known.items() if key[:10] == head},
            keep=lambda place, outcome: self.note((*head, *place), outcome),
        )
        errors = [*(region.semi_axes / UNIT_ERRORS)[:4], np.degrees(point.setup.balance_angle)]
        size = 1e-3 * float(min(errors))
        return replace(approach, found=replace(approach.found, size=size), region=region)

    def note(self, key: Key, found: Found) -> None:
        """Keep a result."""
        self.known[key] = found
        if self.keep is not None:
            self.keep(key, found)


def _key(stage: str, pose: BasePose) -> Key:
    return (stage, *pose.gravity, *pose.axis, *pose.shift)
