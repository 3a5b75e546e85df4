# SPDX-License-Identifier: Apache-2.0
"""What makes no sense is refused by its field's name: fields of values, arguments of calls."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from functools import partial

import numpy as np
import pytest
from core.actuator_cases import actuator, degrees
from core.contact_cases import gripper
from core.design_cases import LATEX, PAPER_EXAMPLE, angles
from core.gripper_cases import PRESSURE_MAX, linear_gripper, paper_gripper
from core.rod_cases import SIX
from numpy.typing import NDArray

from spiral_core import (
    ApproachTask,
    CalibrationModel,
    Capsule,
    Clamped,
    Cone,
    Cylinder,
    Damping,
    Elastomer,
    ExtensionReading,
    FiberAngles,
    Free,
    FreeActuation,
    Gent,
    Guided,
    Inertia,
    InvalidInputError,
    MeasuredActuation,
    MooneyRivlin,
    NeoHookean,
    ObjectProfile,
    Obstacle,
    Orifice,
    Pinned,
    Plane,
    PointLoad,
    PressureCourse,
    Profile,
    Rod,
    RodLoad,
    RodProblem,
    Section,
    SignedDistance,
    Sphere,
    Supply,
    SwingReading,
    Tube,
    WrapCurve,
    Yeoh,
    design_gripper,
    design_space,
    feasibility_map,
    find_equilibria,
    follow_rod,
    gripper_from_actuator,
    lay_into_coil,
    settling_after_move,
    settling_after_ramp,
    solve_motion,
    solve_rod,
    solve_rods,
    vibrations,
)
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.fibers import fiber_state
from spiral_core.actuator.uniform_law import pressure_from_stretch
from spiral_core.grip.capture import close_misplaced
from spiral_core.rod.contact.solve import follow_contact, solve_contact
from spiral_core.rod.motion.swing import Swing
from spiral_core.rod.path import follow_path
from spiral_core.wrap.coil import coil_from_state
from spiral_core.wrap.helix import Helix
from spiral_core.wrap.wrap import line_force

Array = NDArray[np.float64]
NAN, INF = math.nan, math.inf
POSITIVE = (1.0, 0.0, -1.0, NAN, INF, True, "1")
NATURAL = (0.0, -1.0, NAN, INF, "x")
FINITE = (1.0, NAN, INF)
PRESSURE = (1e4, -1.0, -1e-300, NAN, INF, True, "55 kPa")
DIMENSION = (5e-3, 0.0, NAN, 1.1e9, 1e300)
HELICAL = replace(PAPER_EXAMPLE, elastomers=(Elastomer("section", LATEX.law, 950.0),))
TASK = ApproachTask(paper_gripper("70 degrees"), 0.015, (0.0, 0.0, 1.0), (0.0, 0.0, -9.80665), 0.02)
LAID, CURVE = lay_into_coil(TASK.gripper, 0.020), WrapCurve(paper_gripper("P2"))
HEAVY, LONG = paper_gripper("P1", (1e300, 0.0, 0.0)), linear_gripper(length=361.0)
SHAPE = UnloadedShape(40.0, -15.0, 0.4)


PLAIN = Section((2e-4, 3e-4, 3e-4))
ROD = Rod(0.4, PLAIN, 3e-3)
FREE = Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(-5.0, 0.0, 10.0))
LOAD = RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02))
CLEAR = Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.07), (0.0, 1.0, 0.0))
PROBLEM = RodProblem(ROD, obstacles=(CLEAR,))
STATE = solve_rod(FREE, LOAD, elements=10)
NO_STARTS = (
    *(np.eye(2), np.full((5, 3), NAN), "x"),
    replace(STATE, orientations=STATE.orientations[:5]),
    replace(STATE, orientations=STATE.orientations[:1], arc_lengths=np.zeros(1)),
    replace(STATE, orientations=STATE.orientations * NAN),
)
NO_COUNTS = (1, True, 2.5, 20_001)
TWISTED = tuple(replace(PROBLEM, tip=Guided(orientation=q)) for q in (None, (0.0, 0.0, 0.0, 1.0)))


def six(above, below):
    """Return a 6x6 stiffness whose twist and stretch are coupled by fractions of their own."""
    matrix = np.diag((1e-4, 1e-4, 1e-4, 1e2, 1e2, 1e2))
    matrix[0, 3], matrix[3, 0] = 0.1 * above, 0.1 * below
    return matrix


def of_section(bending=6e-4, **given):
    """Return a rod some of whose stiffnesses are changed."""
    varying = Section.varying(**{"bending": bending, "torsional": 5e-4} | given)
    return replace(FREE, section=varying)


def among(shape, elements=None):
    """Solve a rod next to an obstacle of a shape."""
    problem = replace(PROBLEM, obstacles=(replace(CLEAR, shape=shape),))
    return solve_contact(problem, elements=elements)


def solved():
    """Return a state to start from."""
    return solve_contact(PROBLEM, elements=16)


def moving(problem=lambda _: PROBLEM, times=(0.0, 0.01), **given):
    """Let a straight rod go."""
    return solve_motion(problem, Inertia(0.03, 1e-7), times, elements=16, **given)


def distances(function):
    return among(SignedDistance(function, 0.03))


THINGS = [
    *(PLAIN, ROD, LOAD, Pinned(), Clamped(), Guided(orientation=(0.0, 0.0, 0.0, 1.0)), CLEAR),
    *(PointLoad(0.1), RodProblem(ROD), Cylinder(0.1), Sphere(0.1), Cone(0.1, 0.1)),
    *(Capsule(0.1, 0.1), SignedDistance(distances, 0.1)),
]


@pytest.mark.parametrize("thing", THINGS)
def test_every_field_is_checked(thing):
    for field in {each.name for each in fields(thing)} - {"inside", "function"}:
        for value in (NAN, "x", -1.0)[: 2 if field in ("slope", "at") else 3]:
            with pytest.raises(InvalidInputError, match=field) as caught:
                replace(thing, **{field: value})
            assert caught.value.field == field


def changed(value):
    """Return what makes a value with other fields."""
    return lambda **given: replace(value, **given)


# A call; and for each of its arguments a good value (... leaves it out), and what it must not be.
ARGUMENTS = [
    (Tube, dict.fromkeys(("inner_radius", "wall_thickness", "length"), DIMENSION)),
    (FiberAngles, {"alpha": (1.5, 0.0, 1.6, NAN), "beta": (1.0, 1e-5)}),
    (NeoHookean, {"c1": POSITIVE}),
    (MooneyRivlin, {"c1": (1.0,), "c2": (0.0, INF)}),
    (Yeoh, {"c1": POSITIVE, "c2": FINITE, "c3": FINITE}),
    (Gent, {"shear_modulus": POSITIVE, "extension_limit": POSITIVE}),
    (
        changed(actuator()),
        {
            "tube": (..., 4.7625e-3),
            "fibers": (..., (1.5, 1.0)),
            "material": (..., 870.0e3),
            "curvature_form": (..., "exact"),
            "twist_shear": (..., 1),
            "straight_fiber_radius": (..., 0.0),
        },
    ),
    (partial(UnloadedShape, 20.0, -10.0), {"backbone_length": POSITIVE, "stretch": POSITIVE}),
    (
        MeasuredActuation,
        {
            "pressures": ((0.0, 2.0, 4.0), (1.0, 2.0, 4.0), (0.0, 2.0, 2.0), (0.0, NAN, 4.0)),
            "curvatures": ((0.0, 8.0, 8.0), (0.0, 8.0, 7.0), (0.0, 8.0)),
            "torsions": ((0.0, -4.0, -9.0), (0.0, INF, 9.0)),
            "backbone_length": POSITIVE,
        },
    ),
    (partial(fiber_state, degrees(88.0, 60.0)), {"stretch": (1.1, 0.0, INF)}),
    (partial(pressure_from_stretch, actuator()), {"stretch": (1.1, 0.999, NAN, True)}),
    (partial(unloaded_shape_from_stretch, actuator()), {"stretch": (1.1, 0.99, NAN)}),
    (FreeActuation, {"actuator": (actuator(), Tube(4e-3, 1e-3, 0.3))}),
    (FreeActuation(actuator()).pressure_from_stretch, {"stretch": (1.1, 0.9, NAN)}),
    (FreeActuation(actuator()).unloaded_shape, {"pressure": PRESSURE}),
    (paper_gripper("P1").unloaded_shape, {"pressure": (*PRESSURE, 1.01 * PRESSURE_MAX)}),
    (
        partial(CalibrationModel, actuator()),
        {
            "bending_stiffness": POSITIVE,
            "torsional_stiffness": POSITIVE,
            "law": (..., int),
            "fixed": (..., {"c3": 1.0}, {"c1": 1.0, "c2": 1.0}),
        },
    ),
    (
        ExtensionReading,
        {
            "pressure": NATURAL,
            "extension": FINITE,
            "section_length": POSITIVE,
            "error": POSITIVE,
            "pressure_error": NATURAL,
        },
    ),
    (SwingReading, {"time": FINITE, "displacement": FINITE, "error": POSITIVE}),
    (
        changed(PAPER_EXAMPLE),
        {
            "radius_min": (..., *POSITIVE[1:]),
            "radius_max": (..., 0.01, INF, 1e200),
            **dict.fromkeys(("tubes", "elastomers", "fiber_angles_beta"), (..., ())),
            "turns_required": (0.1, 0.0999, NAN),
            **dict.fromkeys(("object_length", "length_max", "pressure_max", "payload"), POSITIVE),
            "strain_max": (0.3, 0.0, 10.1),
            "gravity": (..., (0.0, 0.0)),
            "object_axis": (..., (1.0, 1.0, 0.0)),
            "extra_mass_per_length": NATURAL,
            "end_allowance": NATURAL,
            "friction_coefficient": NATURAL,
        },
    ),
    (changed(LATEX), {"law": (..., 3.0), "density": POSITIVE}),
    (
        partial(design_space, actuator(), [1.0]),
        {"turns_required": POSITIVE, "stretch_max": (1.2, 1.01, NAN)},
    ),
    (
        # A map of what is hopeless is soon told.
        partial(feasibility_map, replace(PAPER_EXAMPLE, radius_min=1e3, radius_max=1e3)),
        {
            "fiber_angles_beta": ((1.0, 1.2), (1.2, 1.2)),
            "inner_radii": ((0.004, 0.005), (0.005,), (0.004, NAN)),
            "wall_thickness": DIMENSION[:3],
        },
    ),
    (Helix, {"curvature": POSITIVE, "torsion": FINITE}),
    (
        ObjectProfile,
        {
            "positions": ([0.0, 0.1], [0.1, 0.1], [0.0, INF], "ab"),
            "radii": ([0.01, 0.01], [0.01], [0.01, 0.0]),
        },
    ),
    (
        changed(linear_gripper()),
        {
            "gravity": (..., (1.0, 2.0)),
            "object_axis": (..., (1.0, 1.0, 0.0)),
            "turns_required": POSITIVE,
            "friction_coefficient": NATURAL,
            "pressure_max": (1e4, 0.0, 2.0e5),
            "weight_per_length": NATURAL,
        },
    ),
    (
        partial(gripper_from_actuator, "bad", actuator()),
        {"density": POSITIVE, "extra_mass_per_length": NATURAL},
    ),
    *(
        (
            lambda torsional: replace(
                paper_gripper("P1"), stiffness=Section.inextensible(1.0, torsional)
            ),
            {"torsional": torsional},
        )
        for torsional in ((0.0101, 0.0099), (99.0, 101.0))
    ),
    (
        partial(line_force, Section.inextensible(3e-4, 2e-4), SHAPE),
        dict.fromkeys(("radius", "helix_angle", "outer_radius"), (1.0, NAN)),
    ),
    (CURVE.wrap_for_radius, {"radius": (0.02, *POSITIVE[1:-1])}),
    (CURVE.wrap_at_pressure, {"pressure": (5e4, 0.0, NAN, 1.001 * PRESSURE_MAX)}),
    (CURVE.radius_from_pressure, {"pressure": (5e4, 0.999 * CURVE.pressure_min, NAN)}),
    (CURVE.state_at_pressure, {"pressure": (0.0, -1.0, 1.001 * PRESSURE_MAX)}),
    (
        Section,
        {
            "stiffness": (
                six(0.5, 0.5),
                ((1, 1, 0), (0, 1, 0), (0, 0, 1)),
                ((1, 2, 0), (2, 1, 0), (0, 0, 1)),
                *(np.eye(2), (0.0, 1.0, 1.0), (1.0, 1.0), six(0.1, 0.2), six(1.1, 1.1)),
            ),
            "extension": (..., 1.0),
            "shear": (..., 1.0),
        },
    ),
    (partial(Section, (1.0, 1.0, 1.0)), {"extension": (..., 0.0)}),
    (
        Section.inextensible,
        {
            "bending": (4e-4, 0.0),
            "torsional": (9e-4, NAN),
            "sideways": (..., 0.0),
            "coupling": (..., 6e-4, -6e-4),
        },
    ),
    (
        lambda **given: solve_rod(of_section(**given), LOAD),
        {
            "bending": (..., -1.0, lambda s: NAN * s, lambda s: s[:, None] + 1.0),
            "torsional": (..., -1.0, lambda s: NAN * s),
            "sideways": (..., 0.0),
            "coupling": (..., NAN, lambda s: s[:2]),
        },
    ),
    (
        lambda **given: solve_rod(replace(FREE, **given), LOAD),
        {
            "section": (
                PLAIN,
                lambda _: PLAIN,
                of_section(torsional=lambda s: s - 0.2).section,
                of_section(coupling=lambda s: 6e-4 + 0.0 * s).section,
            ),
            "rest_strain": (..., lambda s: np.ones(len(s))),
        },
    ),
    (
        partial(Section.round, 1e-3),
        {"young": (1e6, 0.0), "shear_modulus": (4e5, 0.0), "bore": (..., 1e-3, -1e-4)},
    ),
    (
        changed(ROD),
        {
            "length": (..., 0.0),
            "friction_radius": (..., 4e-3),
            "breaks": (..., (0.3, 0.2), (0.4,), (0.0,), (0.2, 0.2), ("a",), (NAN,)),
        },
    ),
    (
        partial(RodProblem, ROD),
        {"obstacles": (..., (Plane(),), CLEAR), "point_loads": (..., (0.1,))},
    ),
    (lambda at: RodProblem(ROD, point_loads=(PointLoad(at),)), {"at": (0.4, 0.5)}),
    (
        Profile,
        # One number; not increasing; too few; and a spline that passes through the axis.
        {
            "heights": ((0.0, 0.01, 0.02, 0.03), 0.1, (0.0, 0.0, 0.02, 0.03)),
            "radii": ((0.1, 0.1, 0.1, 0.1), (1.0,), (0.1, 1e-3, 1e-3, 0.1)),
        },
    ),
    (partial(Obstacle.along, Plane(), (0, 0, 0)), {"axis": ((0, 0, 1), (0, 0, 0))}),
    (CLEAR.moved, {"translation": (..., (NAN, 0, 0)), "rotation": (..., (0.0, 0.0))}),
    # Too few elements to see the obstacle.
    (partial(among, Cylinder(1e-3)), {"elements": (800, 12, 12.0)}),
    (
        distances,
        {
            "function": (
                lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, 1.0)),
                lambda p: (p, p),
                lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, 3.0)),
            )
        },
    ),
    (
        solve_rod,
        {
            "rod": (FREE, "rod", RodProblem(FREE)),
            "load": (LOAD, 3.0),
            "element": (..., "mixed"),
            "elements": (..., *NO_COUNTS),
            "start": (..., *NO_STARTS),
        },
    ),
    (
        lambda distributed: solve_rod(FREE, RodLoad(distributed)),
        {"distributed": ((0.0, 0.0, 1.0), np.zeros_like)},
    ),
    # Each element would turn too far.
    (partial(solve_rod, replace(FREE, length=1.0), LOAD), {"elements": (8, 5)}),
    (
        follow_path,
        {
            "rods": ((FREE, FREE), (), FREE, [FREE, replace(FREE, breaks=(0.1,))]),
            "loads": (LOAD, [LOAD], [LOAD] * 3, 3.0),
        },
    ),
    (
        partial(follow_rod, [RodProblem(FREE, LOAD)] * 2, stop_at_event=True),
        {"start": (None, STATE, STATE.positions)},
    ),
    (
        partial(find_equilibria, FREE, LOAD),
        {"starts": (2, 0, True, 2.5), "seed": (..., -1)},
    ),
    (
        lambda radius: find_equilibria(replace(FREE, radius=radius), LOAD, starts=1),
        {"radius": (0.0, 1e-3)},
    ),
    (
        partial(solve_rods, bending=1.0, torsional=1.0, distributed=((1, 0, 0),) * 3),
        {
            "lengths": (0.3, -1.0, NAN, (0.3, 0.4)),
            "rest_strains": ((0, 0, 1), (0, 1)),
            "elements": (20, 1, True, 20_001),
        },
    ),
    (
        follow_contact,
        {
            "problems": (
                *([PROBLEM], [], PROBLEM, TWISTED),
                [PROBLEM, replace(PROBLEM, obstacles=(Obstacle(Plane(), (0, 0, -1)),))],
                [PROBLEM, replace(PROBLEM, tip=Pinned((0.3, 0, 0)))],
                [PROBLEM, replace(PROBLEM, rod=replace(ROD, radius=0.5))],
            ),
            "largest_increment": (..., 0.0, NAN),
            "smallest_increment": (..., 0.0, 2.0),
        },
    ),
    (
        lambda **given: follow_contact(start=solved(), **given),
        {
            "problems": (
                [PROBLEM],
                [replace(PROBLEM, obstacles=())],
                [replace(PROBLEM, point_loads=(PointLoad(0.123),))],
            ),
            "elements": (16, 13),
        },
    ),
    (lambda index: solved().on_obstacle(index), {"index": (0, 1)}),
    (
        moving,
        {
            "times": (..., (), (0.0, 0.0), (0.0, NAN)),
            "tolerance": (..., 0.0),
            "longest_step": (..., INF),
            "problem": (
                ...,
                lambda _: None,
                lambda time: RodProblem(ROD, base=Free() if time else Clamped()),
            ),
        },
    ),
    (
        changed(TASK),
        {
            "radius": (..., 0.0, None),
            "payload": (..., -1.0),
            "tilt_max": (..., 4.0, 0.0, NAN),
        },
    ),
    (
        partial(close_misplaced, LAID),
        {
            "pressure": (58.98e3, 0.0, 1e6, NAN),
            "misplacement": (
                (0.0,) * 5,
                *((0.0,) * 4, (NAN, 0.0, 0.0, 0.0, 0.0)),
            ),
            "payload": (0.010, 0.0),
        },
    ),
    (Inertia, {"mass": POSITIVE, "rotary": POSITIVE}),
    (partial(Inertia.round, 1100.0, 1e-3), {"bore": (0.0, 1e-3)}),
    (Damping, {"retardation_time": NATURAL, "air": NATURAL, "drag_rate": NATURAL}),
    (Orifice, {"conductance": POSITIVE, "critical_ratio": (0.2, 1.0, -0.1)}),
    (partial(Supply, Orifice(1e-9)), {"pressure": POSITIVE}),
    (partial(Supply, pressure=1.0), {"orifice": (Orifice(1e-9), None, 1e-9)}),
    (
        PressureCourse,
        {"times": ((0.0, 1.0), (0.0,)), "pressures": ((0.0, 1.0), (0.0, -1.0), (0.0, NAN))},
    ),
    (
        lambda end: Swing(1.0, 40.0, 0.0, 2.0).settling_time(Damping(0.01), 0.1, end),
        {"end": (0.01, 0.0, NAN)},
    ),
    (
        partial(settling_after_ramp, gripper()),
        {"pressure": (3e4, -1.0), "rate": (1e4, 0.0)},
    ),
    (partial(settling_after_move, gripper(), 0.0), {"speed": (0.0, NAN)}),
    (partial(vibrations, gripper(), 0.0), {"count": (1, 0)}),
]


@pytest.mark.parametrize("number", range(len(ARGUMENTS)))
def test_good_arguments_are_taken_and_a_wrong_one_is_refused_by_name(number):
    call, arguments = ARGUMENTS[number]
    good = {name: values[0] for name, values in arguments.items() if values[0] is not ...}
    call(**good)
    for field, (_, *wrong) in arguments.items():
        for value in wrong:
            with pytest.raises(InvalidInputError) as caught:
                call(**(good | {field: value}))
            assert caught.value.field == field, value
            assert field in str(caught.value)


COIL, STEEP = Helix(20.0, 10.0), {"fiber_angles_beta": angles(20.0)}


@pytest.mark.parametrize(
    ("said", "call", "arguments"),
    [
        ("alpha, beta", FiberAngles, {"alpha": 1.0, "beta": 1.0 + 9e-5}),
        ("alpha, beta", FiberAngles, {"alpha": math.pi / 2, "beta": -math.pi / 2}),
        (r"c1 \+ c2", MooneyRivlin, {"c1": 1.0, "c2": -1.0}),
        *(
            (f"norm of {field}", changed(TASK), {field: (0.0, 0.0, 0.0)})
            for field in ("object_axis", "gravity")
        ),
        (
            "radius",
            partial(close_misplaced, LAID, 58.98e3),
            {"misplacement": (0.0, 0.0, 0.0, 0.0, -0.02)},
        ),
        *(
            (".*axis", partial(coil_from_state, STATE), {"axis": axis})
            for axis in ((NAN, 0.0, 1.0), (0.0, 0.0, 0.0), (2.0, 0.0, 0.0))
        ),
        *(
            (
                ".*at most 100 times as stiff",
                changed(linear_gripper()),
                {"stiffness": Section.inextensible(1e-4, 1e-4, **given)},
            )
            for given in ({"sideways": 1.1e-2}, {"coupling": 0.99e-4})
        ),
        (
            "section.*couple bending with stretch",
            moving,
            {"problem": lambda _: RodProblem(Rod(0.4, SIX))},
        ),
        (
            "section.*couple bending with",
            moving,
            {"problem": lambda time: RodProblem(Rod(0.4, SIX) if time else ROD)},
        ),
        ("radii", ObjectProfile, {"positions": [0.0], "radii": [0.01]}),
        ("turns", COIL.length_for_turns, {"turns": -1.0}),
        ("length", COIL.turns, {"length": -0.1}),
        ("outer_radius", COIL.object_radius, {"outer_radius": 0.0}),
        ("rate", PressureCourse.ramp, {"rate": 0.0, "pressure": 1e4, "wait": 1.0}),
        ("payload", changed(PAPER_EXAMPLE), {"payload": 0.1, "gravity": (0.0, 0.0, 0.0)}),
        ("elements must be at most 20000", WrapCurve, {"gripper": HEAVY}),
        # Millimeters taken for meters.
        (r"length must be at most [\d.]+ m, so that no", WrapCurve, {"gripper": LONG}),
        # In what units?
        *(
            ("elements", partial(solve_rod, rod), {})
            for rod in (
                replace(FREE, length=300000.0),
                RodProblem(replace(FREE, section=Section.inextensible(1e-300, 1e-300)), LOAD),
                RodProblem(FREE, RodLoad((1e300, 0.0, 0.0))),
                RodProblem(
                    replace(ROD, radius=0.0), obstacles=(Obstacle(Sphere(1e-9), (0, 0, 1)),)
                ),
            )
        ),
        ("beta", changed(PAPER_EXAMPLE), {"fiber_angles_beta": (2.0,)}),
        (".*cross", changed(PAPER_EXAMPLE), {"fiber_angles_beta": angles(88.0)}),
        (
            "fiber_angles_gamma .* latex belong to the uniform .* from 0.7 times these",
            changed(PAPER_EXAMPLE),
            {"fiber_angles_gamma": angles(5.0)},
        ),
        (
            "fiber_angles_gamma .* at another angle than the wound families",
            changed(HELICAL),
            {"fiber_angles_gamma": angles(20.0), **STEEP},
        ),
        *(
            (
                "fiber_angles_gamma .* from -30 to 30 degrees",
                changed(HELICAL),
                {"fiber_angles_gamma": angles(gamma)},
            )
            for gamma in (-30.1, NAN)
        ),
        (
            ".*extend",
            lambda **given: design_gripper(replace(PAPER_EXAMPLE, **given)),
            {"fiber_angle_alpha": 0.5, "fiber_angles_beta": (-0.5,)},
        ),
        ("weight", lambda: vibrations(replace(gripper(), weight_per_length=0.0), 0.0), {}),
        ("volume", lambda: Supply(Orifice(1e-9), 1.0).time_to_fill(lambda _: -1.0, 0.0, 1.0), {}),
    ],
)
def test_arguments_that_do_not_fit_together_are_refused(said, call, arguments):
    with pytest.raises(InvalidInputError, match=f"^{said}"):
        call(**arguments)


def jumping(s):
    """Return what jumps, by little, where no break says so."""
    return 1.0 + 1e-3 * (s > 0.1234)


JUMPS = {
    "section": of_section(coupling=lambda s: 1e-5 * jumping(s)),
    "rest_strain": replace(FREE, rest_strain=lambda s: jumping(s)[:, None] * (-5.0, 0.0, 10.0)),
}


@pytest.mark.parametrize("field", JUMPS)
def test_a_jump_that_no_break_declares_is_refused(field):
    for ask in (solve_rod, find_equilibria, lambda rod, load: follow_path([rod], load)):
        with pytest.raises(InvalidInputError, match=r"breaks.*a jump at 0\.1234 m") as caught:
            ask(JUMPS[field], LOAD)
        assert caught.value.field == field
    assert solve_rod(replace(JUMPS[field], breaks=(0.1234,)), LOAD).stable
