# SPDX-License-Identifier: Apache-2.0
"""What makes no sense is refused by its field's name: fields of values, arguments of calls."""

from dataclasses import fields, replace
from functools import partial
from inspect import signature
from math import inf, nan, pi

import numpy as np
import pytest
from core.actuator_cases import actuator, degrees
from core.contact_cases import gripper
from core.design_cases import LATEX, PAPER_EXAMPLE, angles
from core.gripper_cases import PRESSURE_MAX, linear_gripper, paper_gripper
from core.rod_cases import SIX

from spiral_core import (
    ApproachTask,
    BendReading,
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
    GripReading,
    Guided,
    Inertia,
    InvalidInputError,
    MeasuredActuation,
    MooneyRivlin,
    NeoHookean,
    ObjectProfile,
    Obstacle,
    OneFamily,
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
    ShapeReading,
    SignedDistance,
    SingleFiber,
    Sphere,
    Supply,
    SwingReading,
    Tube,
    TwistReading,
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
from spiral_core.grip.table import GripTable
from spiral_core.rod.contact.solve import follow_contact, solve_contact
from spiral_core.rod.motion.swing import Swing
from spiral_core.rod.path import follow_path
from spiral_core.wrap.coil import coil_from_state
from spiral_core.wrap.helix import Helix
from spiral_core.wrap.wrap import line_force

NAN, INF = nan, inf
TASK = ApproachTask(paper_gripper("70 degrees"), 0.015, (0.0, 0.0, 1.0), (0.0, 0.0, -9.80665), 0.02)
LAID, CURVE = lay_into_coil(TASK.gripper, 0.020), WrapCurve(paper_gripper("P2"))
PLAIN = Section((2e-4, 3e-4, 3e-4))
ROD = Rod(0.4, PLAIN, 3e-3)
FREE = Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(-5.0, 0.0, 10.0))
LOAD = RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02))
CLEAR = Obstacle.along(Cylinder(0.03), (0.2, 0.0, -0.07), (0.0, 1.0, 0.0))
PROBLEM = RodProblem(ROD, obstacles=(CLEAR,))
TINY = Obstacle(Sphere(1e-9), (0, 0, 1))
STATE = solve_rod(FREE, LOAD, elements=10)
TUBE, COIL, FILLED = Tube(1.5, 1.5, 1.5), Helix(20.0, 10.0), Supply(Orifice(1e-9), 1.0)
SHAPE = UnloadedShape(40.0, -15.0, 0.4)
MEASURED = MeasuredActuation((0.0, 1.0, 2.0), (0.0, 8.0, 8.0), (0.0, -4.0, -9.0), 0.3)
ACTUATOR, EVEN = actuator(), (0.0, 0.01, 0.02, 0.03)
TABLE = GripTable((0.01, 0.02), (None, None), (0.0,), (9.8, 0.0, 0.0), 1.5e4)
HELICAL = replace(PAPER_EXAMPLE, elastomers=(Elastomer("section", LATEX.law, 950.0),))
TURNED = Guided(orientation=(0.0, 0.0, 0.0, 1.0))
THINGS = [
    *(kind(1.5) for kind in (NeoHookean, OneFamily, Orifice, Cylinder, Sphere)),
    *(kind(1.5, 1.5) for kind in (MooneyRivlin, Gent, Inertia, Cone, Capsule)),
    *(kind(1.5, 1.5, 1.5) for kind in (Yeoh, Damping, GripReading, SwingReading)),
    *(kind(1.5, 1.5, 1.5, 1.5) for kind in (ExtensionReading, BendReading, TwistReading)),
    *(ShapeReading(1.5, (1.5,) * 3, 1.5, 1.5), PointLoad(0.1), SignedDistance(len, 0.1), SHAPE),
    *(ACTUATOR, CalibrationModel(ACTUATOR), PAPER_EXAMPLE, PAPER_EXAMPLE.tubes[0], LATEX, TUBE),
    *(linear_gripper(), TASK, LAID, FILLED, COIL, PLAIN, ROD, LOAD, CLEAR, PROBLEM, SingleFiber()),
    *(degrees(88.0, 60.0), Pinned(), Clamped(), TURNED, PressureCourse((0.0, 1.0), (0.0, 1e4))),
]
SIGNED = """OneFamily.angle FiberAngles.alpha FiberAngles.beta UnloadedShape.curvature
UnloadedShape.torsion Helix.torsion MooneyRivlin.c1 MooneyRivlin.c2 Yeoh.c2 Yeoh.c3 Cone.slope
SwingReading.time SwingReading.displacement ExtensionReading.extension BendReading.bend_angle
TwistReading.twist SingleFiber.angle SingleFiber.position PointLoad.at"""
NEVER_ZERO = "OneFamily.angle FiberAngles.alpha FiberAngles.beta"
NATURAL = """Orifice.critical_ratio Damping.retardation_time Damping.air Damping.drag_rate
GripReading.pressure_error ExtensionReading.pressure ExtensionReading.pressure_error
BendReading.pressure BendReading.pressure_error TwistReading.pressure TwistReading.pressure_error
ShapeReading.pressure ShapeReading.pressure_error DesignRequirement.friction_coefficient
DesignRequirement.extra_mass_per_length DesignRequirement.end_allowance Supply.dead_volume
Gripper.weight_per_length Gripper.friction_coefficient Rod.radius Rod.friction_radius
Obstacle.friction"""
POSSIBLY_EMPTY = """Actuator.single_fibers CalibrationModel.quantities Rod.breaks
RodProblem.point_loads RodProblem.obstacles"""
# What a field may be only if it is named here.
TAKEN = {
    NAN: set(),
    "x": set(),
    INF: {"Section.extension", "Section.shear"},
    (): {*POSSIBLY_EMPTY.split()},
    -1.0: {*SIGNED.split()},
    0.0: {*SIGNED.split(), *NATURAL.split()} - {*NEVER_ZERO.split()},
}


def refused(field, call, **arguments):
    """Expect that a call is refused by the name of a field."""
    with pytest.raises(InvalidInputError, match=f"^{field}") as caught:
        call(**arguments)
    assert caught.value.field == field, arguments


def test_every_field_is_checked():
    for thing in THINGS:
        # A name may be anything; what a function returns is seen when it is called.
        others = {"name", "inside", "function", "fiber_angle_alpha"}
        for field in {each.name for each in fields(thing)} - others:
            for value, taken in TAKEN.items():
                if f"{type(thing).__name__}.{field}" in taken:
                    replace(thing, **{field: value})
                else:
                    refused(field, partial(replace, thing), **{field: value})


def of_section(bending=6e-4, torsional=5e-4, **given):
    """Return a rod some of whose stiffnesses are changed."""
    return replace(FREE, section=Section.varying(bending, torsional, **given))


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


def changed(value):
    """Return what makes a value with other fields."""
    return lambda **given: replace(value, **given)


# A call and good arguments for it; and what each of its arguments must not be, besides NaN.
ARGUMENTS = [
    (changed(TUBE), dict.fromkeys(("inner_radius", "wall_thickness", "length"), (1.1e9,))),
    (FiberAngles, 1.5, 1.0, {"alpha": [1.6], "beta": [1e-5]}),
    (
        changed(MEASURED),
        {
            "pressures": [(0.5, 1.0, 2.0), (0.0, 2.0, 2.0)],
            "curvatures": [(0.0, 8.0, 7.0), (0.0, 8.0)],
            "torsions": [(0.0, INF, 9.0)],
            "backbone_length": [0.0],
        },
    ),
    (fiber_state, degrees(88.0, 60.0), 1.1, {"stretch": [0.0, INF]}),
    *(
        (call, 1.1, {"stretch": [0.999, True]})
        for call in (
            partial(pressure_from_stretch, ACTUATOR),
            partial(unloaded_shape_from_stretch, ACTUATOR),
            FreeActuation(ACTUATOR).pressure_from_stretch,
        )
    ),
    (FreeActuation, ACTUATOR, {"actuator": [TUBE]}),
    *(
        (call, 5e4, {"pressure": [-1e-300, True, "55 kPa", *wrong]})
        for call, *wrong in (
            (FreeActuation(ACTUATOR).unloaded_shape, INF),
            (paper_gripper("P1").unloaded_shape, 1.001 * PRESSURE_MAX),
            (CURVE.state_at_pressure, 1.001 * PRESSURE_MAX),
            (CURVE.wrap_at_pressure, 1.001 * PRESSURE_MAX, 0.0),
            (CURVE.radius_from_pressure, 0.999 * CURVE.pressure_min),
        )
    ),
    (CURVE.wrap_for_radius, 0.02, {"radius": [0.0, -1.0, INF, True]}),
    (
        CalibrationModel,
        ACTUATOR,
        {"law": [int], "fixed": [{"c3": 1.0}, {"c1": 1.0, "c2": 1.0}]},
    ),
    (
        changed(PAPER_EXAMPLE),
        {
            "radius_max": [0.01, 1e200],
            "length_max": [0.0],
            "payload": [0.0],
            "turns_required": [0.0999],
            "strain_max": [10.1],
            "gravity": [(0.0, 0.0)],
            "object_axis": [(1.0, 1.0, 0.0)],
        },
    ),
    (design_space, ACTUATOR, [1.0], {"turns_required": [0.0, INF], "stretch_max": [1.01]}),
    (
        # A map of what is hopeless is soon told.
        feasibility_map,
        replace(PAPER_EXAMPLE, radius_min=1e3, radius_max=1e3),
        *((1.0, 1.2), (0.004, 0.005), 5e-3),
        {
            "fiber_angles_beta": [(1.2, 1.2)],
            "inner_radii": [(0.005,), (0.004, NAN)],
            "wall_thickness": [0.0],
        },
    ),
    (
        ObjectProfile,
        [0.0, 0.1],
        [0.01, 0.01],
        {"positions": [[0.1, 0.1], [0.0, INF], "ab"], "radii": [[0.01], [0.01, 0.0]]},
    ),
    (changed(linear_gripper()), {"object_axis": [(1.0, 1.0, 0.0)], "pressure_max": [2.0e5]}),
    (
        partial(gripper_from_actuator, density=1.0),
        "bad",
        ACTUATOR,
        {"density": [0.0], "extra_mass_per_length": [-1.0]},
    ),
    (
        line_force,
        PLAIN,
        SHAPE,
        *(1.0,) * 3,
        dict.fromkeys(("radius", "helix_angle", "outer_radius"), ()),
    ),
    (
        Section,
        SIX.stiffness,
        {
            "stiffness": [
                *(np.eye(2), (0.0, 1.0, 1.0), (1.0, 1.0), -np.eye(6)),
                *(np.triu(np.ones((n, n))) for n in (3, 6)),
            ],
            # Of a matrix that has them.
            "extension": [1.0],
            "shear": [1.0],
        },
    ),
    (
        Section.inextensible,
        4e-4,
        9e-4,
        {"bending": [0.0], "torsional": (), "sideways": [0.0], "coupling": [6e-4, -6e-4]},
    ),
    (
        lambda **given: solve_rod(of_section(**given), LOAD),
        {
            "bending": [-1.0, lambda s: NAN * s, lambda s: s[:, None] + 1.0],
            "torsional": [-1.0],
            "sideways": [0.0],
            "coupling": [lambda s: s[:2]],
        },
    ),
    (
        lambda **given: solve_rod(replace(FREE, **given), LOAD),
        {
            "section": [
                lambda _: PLAIN,
                of_section(torsional=lambda s: s - 0.2).section,
                of_section(coupling=lambda s: 6e-4 + 0.0 * s).section,
            ],
            "rest_strain": [lambda s: np.ones(len(s))],
        },
    ),
    (
        Section.round,
        1e-3,
        1e6,
        4e5,
        {"young": [0.0], "shear_modulus": [0.0], "bore": [1e-3, -1e-4]},
    ),
    (changed(ROD), {"friction_radius": [4e-3], "breaks": [(0.3, 0.2), (0.4,), (0.0,), ("a",)]}),
    (RodProblem, ROD, {"obstacles": [(Plane(),), CLEAR], "point_loads": [(0.1,)]}),
    (lambda at=0.4: RodProblem(ROD, point_loads=(PointLoad(at),)), {"at": [0.5]}),
    (
        Profile,
        EVEN,
        (0.1,) * 4,
        # One number; not increasing; too few; and a spline that passes through the axis.
        {"heights": [0.1, (0.0, *EVEN[:3])], "radii": [(1.0,), (0.1, 1e-3, 1e-3, 0.1)]},
    ),
    (Obstacle.along, Plane(), EVEN[:3], (0, 0, 1), {"axis": [(0, 0, 0)]}),
    (CLEAR.moved, {"translation": [(NAN, 0, 0)], "rotation": [(0.0, 0.0)]}),
    # Too few elements to see the obstacle.
    (among, Cylinder(1e-3), {"elements": [12, 12.0]}),
    (
        lambda function=lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, 1.0)): among(
            SignedDistance(function, 0.03)
        ),
        {"function": [lambda p: (p, p), lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, 3.0))]},
    ),
    (
        solve_rod,
        FREE,
        LOAD,
        {
            "rod": ["rod", RodProblem(FREE)],
            "load": [3.0],
            "element": ["mixed"],
            "elements": [1, True, 2.5, 20_001],
            "start": [
                *(np.eye(2), "x", replace(STATE, orientations=STATE.orientations[:5])),
                replace(STATE, orientations=STATE.orientations[:1], arc_lengths=np.zeros(1)),
                replace(STATE, orientations=STATE.orientations * NAN),
            ],
        },
    ),
    (
        lambda distributed=EVEN[:3]: solve_rod(FREE, RodLoad(distributed)),
        {"distributed": [np.zeros_like]},
    ),
    # Each element would turn too far.
    (solve_rod, replace(FREE, length=1.0), LOAD, {"elements": [5]}),
    (
        follow_path,
        (FREE, FREE),
        LOAD,
        {"rods": [(), FREE, [FREE, replace(FREE, breaks=(0.1,))]], "loads": [[LOAD] * 3, 3.0]},
    ),
    (
        partial(follow_rod, stop_at_event=True),
        [RodProblem(FREE, LOAD)] * 2,
        {"start": [STATE, STATE.positions]},
    ),
    (partial(find_equilibria, starts=2), FREE, LOAD, {"starts": [0, 2.5], "seed": [-1]}),
    (
        lambda radius=0.0: find_equilibria(replace(FREE, radius=radius), LOAD, starts=1),
        {"radius": [1e-3]},
    ),
    (
        partial(solve_rods, elements=20),
        0.3,
        1.0,
        1.0,
        (0, 0, 1),
        np.eye(3),
        {"lengths": [-1.0, (0.3, 0.4)], "rest_strains": [(0, 1)], "elements": [1]},
    ),
    (
        follow_contact,
        [PROBLEM],
        {
            "problems": [
                *([], PROBLEM, [replace(PROBLEM, tip=tip) for tip in (Guided(), TURNED)]),
                *(
                    [PROBLEM, replace(PROBLEM, **other)]
                    for other in (
                        {"obstacles": (Obstacle(Plane(), (0, 0, -1)),)},
                        {"tip": Pinned((0.3, 0, 0))},
                        {"rod": replace(ROD, radius=0.5)},
                    )
                ),
            ],
            "largest_increment": [0.0],
            "smallest_increment": [0.0, 2.0],
        },
    ),
    (
        partial(follow_contact, start=solved()),
        [PROBLEM],
        {
            "problems": [
                [replace(PROBLEM, obstacles=())],
                [replace(PROBLEM, point_loads=(PointLoad(0.123),))],
            ],
            "elements": [13],
        },
    ),
    (solved().on_obstacle, 0, {"index": [1]}),
    (
        moving,
        {
            "times": [(), (0.0, 0.0), (0.0, NAN)],
            "tolerance": [0.0],
            "longest_step": [INF],
            "problem": [
                lambda _: None,
                lambda time: RodProblem(ROD, base=Free() if time else Clamped()),
            ],
        },
    ),
    (changed(TASK), {"tilt_max": [4.0]}),
    (changed(LAID), {"elements": [1, 2.5]}),
    (changed(TABLE), {"radii": [(0.01,), (0.02, 0.01), (0.0, 0.01), (NAN, 0.01)]}),
    (
        close_misplaced,
        LAID,
        58.98e3,
        (0.0,) * 5,
        {
            "pressure": [0.0, 1e6],
            "misplacement": [(0.0,) * 4, (NAN, 0.0, 0.0, 0.0, 0.0)],
            "payload": [0.0],
        },
    ),
    (Inertia.round, 1100.0, 1e-3, {"bore": [1e-3]}),
    (Orifice, 1.0, {"critical_ratio": [1.0]}),
    (
        PressureCourse,
        (0.0, 1.0),
        (0.0, 1.0),
        {"times": [(0.0,)], "pressures": [(0.0, -1.0)]},
    ),
    (Swing(1.0, 40.0, 0.0, 2.0).settling_time, Damping(0.01), 0.1, 0.01, {"end": [0.0]}),
    (settling_after_ramp, gripper(), 3e4, 1e4, {"pressure": [-1.0], "rate": [0.0]}),
    (settling_after_move, gripper(), 0.0, 0.0, {"speed": ()}),
    (vibrations, gripper(), 0.0, {"count": [0]}),
    (COIL.length_for_turns, 1.0, {"turns": [-1.0]}),
    (COIL.turns, 0.1, {"length": [-0.1]}),
    (COIL.object_radius, 1e-3, {"outer_radius": [0.0]}),
    (PressureCourse.ramp, 1.0, 1e4, 1.0, {"rate": [0.0]}),
]


# Functions and sequences.
LISTS = ("function", "problem", "times", "fiber_angles_beta", "inner_radii", "radii")


def test_good_arguments_are_taken_and_a_wrong_one_is_refused_by_name():
    for call, *given, arguments in ARGUMENTS:
        call(*given)
        good = dict(zip(signature(call).parameters, given, strict=False))
        for field, wrong in arguments.items():
            for value in (NAN, *wrong)[field in LISTS :]:
                refused(field, call, **good | {field: value})


# Where what is wrong is no single argument; the message and the call.
TOGETHER = [
    ("alpha, beta", FiberAngles, 1.0, 1.0 + 9e-5),
    ("alpha, beta", FiberAngles, pi / 2, -pi / 2),
    (r"c1 \+ c2", MooneyRivlin, 1.0, -1.0),
    *(
        (f"norm of {field}", partial(replace, TASK, **{field: (0.0, 0.0, 0.0)}))
        for field in ("object_axis", "gravity")
    ),
    ("radius", close_misplaced, LAID, 58.98e3, (0.0, 0.0, 0.0, 0.0, -0.02)),
    *((".*axis", coil_from_state, STATE, axis) for axis in ((NAN, 0.0, 1.0), (2.0, 0.0, 0.0))),
    *(
        (said, partial(replace, linear_gripper(), stiffness=Section.inextensible(*given)))
        for said, *given in (
            (".*at most 100 times as stiff", 1e-4, 1e-4, 1.1e-2),
            (".*at most 100 times as stiff", 1e-4, 1e-4, None, 0.99e-4),
            ("torsional must be from", 1.0, 0.0099),
            ("torsional must be from", 1.0, 101.0),
        )
    ),
    *(
        ("section.*couple bending with stretch", moving, problem)
        for problem in (
            lambda _: RodProblem(Rod(0.4, SIX)),
            lambda time: RodProblem(Rod(0.4, SIX) if time else ROD),
        )
    ),
    ("payload", partial(replace, PAPER_EXAMPLE, payload=0.1, gravity=(0.0, 0.0, 0.0))),
    # In what units?
    *(
        ("elements must be at most 20000", *ask)
        for ask in (
            (WrapCurve, paper_gripper("P1", (1e300, 0.0, 0.0))),
            (solve_rod, replace(FREE, length=300000.0)),
            (solve_rod, of_section(1e-300, 1e-300), LOAD),
        )
    ),
    ("elements", solve_rod, RodProblem(replace(ROD, radius=0.0), obstacles=(TINY,))),
    # Millimeters taken for meters.
    (r"length must be at most [\d.]+ m, so that no", WrapCurve, linear_gripper(length=361.0)),
    ("beta", partial(replace, PAPER_EXAMPLE, fiber_angles_beta=(2.0,))),
    (".*cross", partial(replace, PAPER_EXAMPLE, fiber_angles_beta=angles(88.0))),
    (
        "fiber_angles_gamma .* at another angle than the wound families",
        partial(replace, HELICAL, fiber_angles_gamma=angles(20.0), fiber_angles_beta=angles(20.0)),
    ),
    (
        ".*extend",
        lambda: design_gripper(
            replace(PAPER_EXAMPLE, fiber_angle_alpha=0.5, fiber_angles_beta=(-0.5,))
        ),
    ),
    ("grips, errors", partial(replace, TABLE, grips=(None,))),
    ("friction", partial(replace, LAID, obstacle=Obstacle(Cylinder(0.02), friction=11.0))),
    ("weight", vibrations, replace(gripper(), weight_per_length=0.0), 0.0),
    ("volume", FILLED.time_to_fill, lambda _: -1.0, 0.0, 1.0),
]


def test_arguments_that_do_not_fit_together_are_refused():
    for said, call, *given in TOGETHER:
        with pytest.raises(InvalidInputError, match=f"^{said}"):
            call(*given)


def jumping(s):
    """Return what jumps, by little, where no break says so."""
    return 1.0 + 1e-3 * (s > 0.1234)


def test_a_jump_that_no_break_declares_is_refused():
    for field in ["section", "rest_strain"]:
        rod = {
            "section": of_section(coupling=lambda s: 1e-5 * jumping(s)),
            "rest_strain": replace(
                FREE, rest_strain=lambda s: np.outer(jumping(s), (-5.0, 0.0, 10.0))
            ),
        }[field]
        for ask in (solve_rod, find_equilibria, lambda rod, load: follow_path([rod], load)):
            with pytest.raises(InvalidInputError, match=r"breaks.*a jump at 0\.1234 m") as caught:
                ask(rod, LOAD)
            assert caught.value.field == field
        assert solve_rod(replace(rod, breaks=(0.1234,)), LOAD).stable
