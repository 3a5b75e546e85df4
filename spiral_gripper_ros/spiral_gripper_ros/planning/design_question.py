# SPDX-License-Identifier: Apache-2.0
"""The inputs of a design as plain values, and its answer in a worker process. No ROS."""

from __future__ import annotations

import math
import resource
import time
from dataclasses import dataclass

from spiral_core.design.procedure import design_gripper
from spiral_core.design.report import DesignReport
from spiral_core.design.requirement import (
    DEFAULT_BETAS,
    DEFAULT_END_ALLOWANCE,
    DesignRequirement,
    Elastomer,
    Preference,
    TubeSize,
)
from spiral_core.errors import InvalidInputError
from spiral_core.rod.types import Vector
from spiral_core.validation import require_direction
from spiral_gripper import GripperDescription, available_tubing, load_tubing
from spiral_gripper_ros.planning.worker import EndedError

# Each is estimated, and the promising ones are solved as rods, at some tens of milliseconds each.
MOST_COMBINATIONS = 2000
# A design with one tube and four angles takes seconds, and half a minute more where kernels are not
# compiled yet; the most processor time that is spent on one [s].
LONGEST_DESIGN = 300.0
# Memory that numpy, numba and the kernels do not reach by far [bytes].
LARGEST_MEMORY = 2_000_000_000


@dataclass(frozen=True, slots=True)
class DesignQuestion:
    """The values of a ``DesignGripper`` request; 0, or empty: as the gripper.

    Args:
        object_radius_min: [m].
        object_radius_max: [m].
        object_length: [m].
        length_max: [m].
        pressure_max: [Pa].
        strain_max: axial strain.
        turns_required: turns about the largest object.
        tubing: name of a shipped list of tubing.
        tube_inner_radii: [m].
        tube_wall_thicknesses: [m].
        fiber_angles_beta: [rad].
        fiber_angle_alpha: [rad].
        fiber_angles_gamma: [rad]; empty: straight.
        end_allowance: [m].
        gravity: [m/s^2].
        object_axis: direction, of any length; None: the gripper's own.
        preference: name of a :class:`Preference` in lower case.
    """

    object_radius_min: float
    object_radius_max: float
    object_length: float
    length_max: float
    pressure_max: float
    strain_max: float
    turns_required: float
    tubing: str
    tube_inner_radii: tuple[float, ...]
    tube_wall_thicknesses: tuple[float, ...]
    fiber_angles_beta: tuple[float, ...]
    fiber_angle_alpha: float
    fiber_angles_gamma: tuple[float, ...]
    end_allowance: float
    gravity: Vector
    object_axis: Vector | None
    preference: str


def design(
    question: DesignQuestion, description: GripperDescription, longest: float = LONGEST_DESIGN
) -> DesignReport:
    """Return the report on a question; to be called in a process of its own.

    Args:
        question: what is asked.
        description: of the gripper that stands for what the question leaves open.
        longest: processor time after which the design is given up [s].

    Raises:
        SpiralError: the question cannot be answered, or needs too much time or memory.
    """
    # The kernel's limits: of memory, and of a step that never ends.
    limits = {
        resource.RLIMIT_DATA: LARGEST_MEMORY,
        resource.RLIMIT_CPU: math.ceil(time.process_time() + 2.0 * longest),
    }
    before = {limit: resource.getrlimit(limit) for limit in limits}
    begin = time.process_time()

    def look(*_: object) -> None:
        """Give up between two steps: an exception in the midst of a kernel's return is fatal."""
        if time.process_time() - begin > longest:
            raise TimeoutError

    try:
        for limit, most in limits.items():
            bounds = [most, *(bound for bound in before[limit] if bound >= 0)]
            resource.setrlimit(limit, (min(bounds), before[limit][1]))
        return design_gripper(requirement_from_question(question, description), look)
    except MemoryError:
        needs = f"it needs more than {1e-9 * LARGEST_MEMORY:g} GB of memory"
        raise EndedError(f"no design: {needs}") from None
    except TimeoutError:
        spent = f"not done within {longest:g} s of processor time"
        raise EndedError(f"no design: {spent}") from None
    finally:
        for limit, both in before.items():
            resource.setrlimit(limit, both)


def requirement_from_question(
    question: DesignQuestion, description: GripperDescription
) -> DesignRequirement:
    """Return the requirement that a question states; missing values are those of the gripper.

    Raises:
        InvalidInputError: a value is out of its range.
    """
    gripper, actuator = description.gripper, description.actuator
    own = Elastomer(gripper.name, actuator.material, description.density, actuator.pressure_law)
    tubes, elastomer = _on_offer(question, description, own)
    angles = question.fiber_angles_beta or DEFAULT_BETAS
    single_angles = question.fiber_angles_gamma or (0.0,)
    if len(tubes) * len(angles) * len(single_angles) > MOST_COMBINATIONS:
        raise InvalidInputError(
            "combinations of tube and angles",
            f"{len(tubes)} x {len(angles)} x {len(single_angles)}",
            f"at most {MOST_COMBINATIONS}",
        )
    return DesignRequirement(
        radius_min=question.object_radius_min,
        radius_max=question.object_radius_max,
        tubes=tubes,
        elastomers=(elastomer,),
        fiber_angles_beta=angles,
        fiber_angles_gamma=single_angles,
        fiber_angle_alpha=_given(question.fiber_angle_alpha, actuator.fiber_pair.alpha),
        turns_required=_given(question.turns_required, gripper.turns_required),
        object_length=_limit(question.object_length),
        length_max=_limit(question.length_max),
        pressure_max=_given(question.pressure_max, gripper.pressure_max),
        strain_max=_limit(question.strain_max),
        gravity=question.gravity,
        object_axis=gripper.object_axis
        if question.object_axis is None
        else require_direction("object_axis", question.object_axis),
        curvature_form=actuator.curvature_form,
        extra_mass_per_length=description.extra_mass_per_length,
        end_allowance=_given(question.end_allowance, DEFAULT_END_ALLOWANCE),
        preference=_preference(question.preference),
    )


def _on_offer(
    question: DesignQuestion, description: GripperDescription, own: Elastomer
) -> tuple[tuple[TubeSize, ...], Elastomer]:
    """Return the tubes on offer and their material."""
    radii, walls = question.tube_inner_radii, question.tube_wall_thicknesses
    if len(radii) != len(walls):
        raise InvalidInputError(
            "tube_wall_thicknesses", walls, f"as many as tube_inner_radii, {len(radii)}"
        )
    if question.tubing and radii:
        raise InvalidInputError("tubing", question.tubing, "empty where tube_inner_radii are given")
    if question.tubing:
        if question.tubing not in available_tubing():  # a path could be a pipe
            names = ", ".join(available_tubing())
            raise InvalidInputError("tubing", question.tubing, f"a shipped list: {names}")
        tubing = load_tubing(question.tubing)
        return tubing.sizes, tubing.elastomer
    tube = description.actuator.tube
    sizes = tuple(zip(radii, walls, strict=True)) or ((tube.inner_radius, tube.wall_thickness),)
    return tuple(TubeSize(_size_name(r, t), r, t) for r, t in sizes), own


def _size_name(inner_radius: float, wall_thickness: float) -> str:
    return f"{2e3 * inner_radius:.4g} x {1e3 * wall_thickness:.4g} mm"


def _limit(value: float) -> float | None:
    """Return a limit, or None for the 0 that stands for "none given"."""
    return None if value == 0.0 else value


def _given(value: float, default: float) -> float:
    """Return a value, or the default for the 0 that stands for "none given"."""
    return default if value == 0.0 else value


def _preference(name: str) -> Preference:
    names = {preference.name.lower(): preference for preference in Preference}
    if not name:
        return Preference.LEAST_STRAIN
    if name not in names:
        raise InvalidInputError("preference", name, f"one of {', '.join(names)}")
    return names[name]
