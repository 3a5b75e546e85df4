# SPDX-License-Identifier: Apache-2.0
"""What makes no sense is refused by its field's name: fields of values, arguments of calls."""

from dataclasses import MISSING, fields, is_dataclass, replace
from functools import partial
from inspect import signature
from math import inf, nan, pi

import numpy as np
from core.actuator_cases import actuator, degrees
from core.contact_cases import gripper
from core.design_cases import LATEX, PAPER_EXAMPLE, angles
from core.gripper_cases import PRESSURE_MAX, linear_gripper, paper_gripper
from core.recorded import recorded, said
from core.rod_cases import SIX

import spiral_core
from spiral_core import (
    ApproachTask,
    CalibrationModel,
    Clamped,
    Cylinder,
    Damping,
    Elastomer,
    FiberAngles,
    Free,
    FreeActuation,
    Guided,
    Inertia,
    MeasuredActuation,
    MooneyRivlin,
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
    ShapeReading,
    SignedDistance,
    Sphere,
    Supply,
    Tube,
    WrapCurve,
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
HELICAL = replace(PAPER_EXAMPLE, elastomers=(Elastomer("section", LATEX.law, 950.0),))
TURNED = Guided(orientation=(0.0, 0.0, 0.0, 1.0))


def needed(kind):
    """Return the types that a kind of values cannot do without."""
    needs = (each for each in fields(kind) if each.default is each.default_factory is MISSING)
    return [each.type for each in needs]


THINGS = [
    *(
        kind(*(1.5 - 0.1 * k for k in range(len(needed(kind)))))
        for kind in map(partial(getattr, spiral_core), spiral_core.__all__)
        if is_dataclass(kind) and fields(kind) and {*needed(kind)} <= {"float"}
        if not issubclass(kind, Exception)
    ),
    *(ShapeReading(1.5, (1.5,) * 3, 1.5, 1.5), SignedDistance(len, 0.1), SHAPE, ACTUATOR, CLEAR),
    *(LATEX, PAPER_EXAMPLE.tubes[0], FILLED, COIL, PLAIN, PROBLEM, TURNED),
]
# What every field of a value is asked to be; every argument of a call, of the numbers.
WRONG = {
    "nan": NAN,
    "inf": INF,
    "1e12": 1e12,
    "0": 0.0,
    "-1": -1.0,
    "x": "x",
    "()": (),
    "True": True,
}


def of_section(*given):
    """Return a rod some of whose stiffnesses are changed."""
    given += (6e-4, 5e-4)[len(given) :]
    return replace(FREE, section=Section.varying(*given))


def among(shape, **given):
    """Solve a rod next to an obstacle of a shape."""
    problem = replace(PROBLEM, obstacles=(replace(CLEAR, shape=shape),))
    return solve_contact(problem, **given)


START = solve_contact(PROBLEM, elements=16)
INERTIA = Inertia(0.03, 1e-7)

# A value, or a call and good arguments for it; and what else its arguments must not be.
ARGUMENTS = [
    *((thing, {}) for thing in THINGS),
    (degrees(88.0, 60.0), {"alpha": [1.6], "beta": [1e-5, 1.5359]}),
    (
        MEASURED,
        {
            "pressures": [(0.5, 1.0, 2.0), (0.0, 2.0, 2.0)],
            "curvatures": [(0.0, 8.0, 7.0)],
        },
    ),
    (partial(fiber_state, degrees(88.0, 60.0)), 1.1, {}),
    *(
        (call, 1.1, {"stretch": [0.999]})
        for call in (
            partial(unloaded_shape_from_stretch, ACTUATOR),
            FreeActuation(ACTUATOR).pressure_from_stretch,
        )
    ),
    (partial(FreeActuation), ACTUATOR, {}),
    *(
        (call, 5e4, {"pressure": wrong})
        for call, *wrong in (
            (FreeActuation(ACTUATOR).unloaded_shape,),
            (paper_gripper("P1").unloaded_shape, 1.001 * PRESSURE_MAX),
            (CURVE.state_at_pressure, 1.001 * PRESSURE_MAX),
            (CURVE.wrap_at_pressure, 1.001 * PRESSURE_MAX),
            (CURVE.radius_from_pressure, 0.999 * CURVE.pressure_min),
        )
    ),
    (CURVE.wrap_for_radius, 0.02, {}),
    (CalibrationModel(ACTUATOR), {"fixed": [{"c3": 1.0}, {"c1": 1.0, "c2": 1.0}]}),
    (
        PAPER_EXAMPLE,
        {
            "radius_max": [0.01],
            "turns_required": [0.0999],
            "strain_max": [10.1],
            "object_axis": [(1.0, 1.0, 0.0)],
            "fiber_angles_beta": [(2.0,), angles(88.0)],
        },
    ),
    (partial(design_space, ACTUATOR), [1.0], {"turns_required": [], "stretch_max": [1.01]}),
    (
        # A map of what is hopeless is soon told.
        partial(feasibility_map, replace(PAPER_EXAMPLE, radius_min=1e3, radius_max=1e3)),
        *((1.0, 1.2), (0.004, 0.005), 5e-3),
        {"fiber_angles_beta": [(1.2, 1.2)], "inner_radii": [(0.005,), (0.004, NAN)]},
    ),
    (
        ObjectProfile([0.0, 0.1], [0.01, 0.01]),
        {"positions": [[0.1, 0.1], [0.0, INF]], "radii": [[0.01], [0.01, 0.0]]},
    ),
    (linear_gripper(), {"object_axis": [(1.0, 1.0, 0.0)], "pressure_max": [2.0e5]}),
    (partial(gripper_from_actuator, "bad", ACTUATOR), 1.0, {}),
    (partial(line_force, PLAIN, SHAPE), *(1.0,) * 3, {}),
    (
        Section(SIX.stiffness),
        {
            "stiffness": [
                *(np.eye(2), (0.0, 1.0, 1.0), -np.eye(6)),
                *(np.triu(np.ones((n, n))) for n in (3, 6)),
                (10**400, 1.0, 1.0),
            ],
            # Of a matrix that has them.
            "extension": [1.0],
            "shear": [1.0],
        },
    ),
    (Section.inextensible, 4e-4, 9e-4, 4e-4, 0.0, {"coupling": [6e-4, -6e-4]}),
    (Section.round, 1e-3, 1e6, 4e5, {"bore": [1e-3]}),
    (
        ROD,
        {
            "friction_radius": [4e-3],
            "breaks": [(0.3, 0.2), (0.4,), (0.0,), ("a",), np.array((0.5,)), np.array(0.1)],
        },
    ),
    (PROBLEM, {"obstacles": [(Plane(),)], "point_loads": [(PointLoad(0.5),)]}),
    (
        Profile(EVEN, (0.1,) * 4),
        # Not increasing; too few; and a spline that passes through the axis.
        {"heights": [(0.0, *EVEN[:3])], "radii": [(1.0,), (0.1, 1e-3, 1e-3, 0.1)]},
    ),
    (partial(Obstacle.along, Plane(), EVEN[:3]), (0, 0, 1), {"axis": [(0, 0, 0)]}),
    (CLEAR.moved, EVEN[:3], EVEN[:3], {"rotation": [(0.0, 0.0)]}),
    (
        partial(solve_rod, FREE, LOAD),
        {
            "element": [],
            # Too few, as each element would turn too far.
            "elements": [1, 2.5, 20_001],
            "start": [
                *(np.eye(2), replace(STATE, orientations=STATE.orientations[:5])),
                replace(STATE, orientations=STATE.orientations[:1], arc_lengths=np.zeros(1)),
                replace(STATE, orientations=STATE.orientations * NAN),
            ],
        },
    ),
    # Too few elements to see the obstacle.
    (partial(among, Cylinder(1e-3)), {"elements": [12]}),
    (partial(find_equilibria, FREE, LOAD), 1, {"seed": []}),
    (partial(follow_contact, [PROBLEM]), {"largest_increment": [], "smallest_increment": []}),
    (partial(follow_contact, start=START), [PROBLEM], {"elements": [13]}),
    (
        partial(solve_motion, lambda _: PROBLEM, INERTIA, (0.0, 0.01), elements=16),
        {"tolerance": [], "longest_step": []},
    ),
    (TASK, {"tilt_max": [4.0]}),
    (LAID, {"elements": [1, 2.5]}),
    (
        partial(close_misplaced, LAID),
        *(58.98e3, (0.0,) * 5),
        {
            "pressure": [1e6],
            "misplacement": [(0.0,) * 4, (NAN, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, -0.02)],
            "payload": [],
        },
    ),
    (Inertia.round, 1100.0, 1e-3, {"bore": [1e-3]}),
    (Orifice(1.0), {"critical_ratio": [1.0]}),
    (
        PressureCourse((0.0, 1.0), (0.0, 1e4)),
        {"times": [(0.0,)], "pressures": [(0.0, -1.0)]},
    ),
    (partial(Swing(1.0, 40.0, 0.0, 2.0).settling_time, Damping(0.01)), 0.1, 0.01, {}),
    (partial(settling_after_ramp, gripper(), 3e4), 1e4, {}),
    (partial(settling_after_move, gripper(), 0.0), 0.0, {}),
    (partial(vibrations, gripper(), 0.0), {"count": []}),
    *((ask, 1.0, {}) for ask in (COIL.length_for_turns, COIL.turns)),
    (partial(COIL.object_radius), 1e-3, {}),
    (PressureCourse.ramp, 1.0, 1e4, 1.0, {}),
]


def test_what_each_argument_must_be_is_recorded():
    """By its name, with what is taken: a good one, and what may be zero, signed or empty."""
    found = {}
    for what, *given, more in ARGUMENTS:
        names = [each.name for each in fields(what) if each.init] if is_dataclass(what) else []
        call = partial(replace, what) if names else what
        good = dict(zip(names or signature(what).parameters, given, strict=False))
        call(**good)
        kind = type(what) if names else getattr(what, "func", what)
        for field in {*names, *good, *more}:
            asked = 0 if isinstance(good.get(field), list | tuple) else 8 if names else 5
            answers = {}
            for label, value in (*[*WRONG.items()][:asked], *enumerate(more.get(field, ()))):
                answer = said(partial(call, **good | {field: value}))
                answer = answer.partition(", got")[0] if isinstance(answer, str) else "taken"
                answer = answer.removeprefix(f"InvalidInputError: {field} must be ")
                answers[answer] = f"{answers.get(answer, ':')} {label}"
            found.setdefault("; ".join(map("".join, answers.items())), []).append(
                f"{kind.__qualname__}.{field}"
            )
    recorded("refusals/arguments", {key: " ".join(sorted(of)) for key, of in found.items()})


def jumping(s):
    """Return what jumps, by little, where no break says so."""
    return 1.0 + 1e-3 * (s > 0.1234)


JUMPS = [
    of_section(6e-4, 5e-4, None, lambda s: 1e-5 * jumping(s)),
    replace(FREE, rest_strain=lambda s: np.outer(jumping(s), (-5.0, 0.0, 10.0))),
]


def stiff(*given):
    """Return a gripper of this stiffness."""
    return replace(linear_gripper(), stiffness=Section.inextensible(*given))


def distance(slope):
    """Return the rod next to a floor as a user would write it."""
    return among(SignedDistance(lambda p: (p[:, 2] + 1.0, 0.0 * p + (0.0, 0.0, slope)), 0.03))


# Calls that are refused: of functions, and of what does not fit together.
TOGETHER = {
    of_section: [(-1.0,)],
    solve_rod: [
        (of_section(lambda s: s[:, None] + 1.0), LOAD),
        (of_section(6e-4, 5e-4, None, lambda s: NAN * s), LOAD),
        (of_section(6e-4, lambda s: s - 0.2), LOAD),
        (replace(FREE, section=lambda _: PLAIN), LOAD),
        (replace(FREE, rest_strain=lambda s: np.ones(len(s))), LOAD),
        (FREE, RodLoad(np.zeros_like)),
        ("rod", LOAD),
        (RodProblem(FREE), LOAD),
        (FREE, 3.0),
        # In what units?
        (replace(FREE, length=300000.0),),
        (of_section(1e-300, 1e-300), LOAD),
        (RodProblem(replace(ROD, radius=0.0), obstacles=(TINY,)),),
        *((rod, LOAD) for rod in JUMPS),
    ],
    find_equilibria: [(rod, LOAD) for rod in (*JUMPS, replace(FREE, radius=1e-3))],
    follow_path: [
        ([],),
        ([(FREE, LOAD), (replace(FREE, breaks=(0.1,)), LOAD)],),
        ([(FREE, 3.0)],),
        *(([(rod, LOAD)],) for rod in JUMPS),
    ],
    among: [(SignedDistance(lambda p: (p, p), 0.03),)],
    distance: [(3.0,)],
    lambda start: follow_rod([RodProblem(FREE, LOAD)] * 2, start=start, stop_at_event=True): [
        (STATE,),
        (STATE.positions,),
    ],
    follow_contact: [
        *((stations,) for stations in ([], PROBLEM)),
        ([replace(PROBLEM, tip=tip) for tip in (Guided(), TURNED)],),
        ([PROBLEM, replace(PROBLEM, obstacles=(Obstacle(Plane(), (0, 0, -1)),))],),
        ([PROBLEM, replace(PROBLEM, tip=Pinned((0.3, 0, 0)))],),
        ([PROBLEM, replace(PROBLEM, rod=replace(ROD, radius=0.5))],),
    ],
    partial(solve_motion, elements=16): [
        *((lambda _: PROBLEM, INERTIA, times) for times in ((), (0.0, 0.0), (0.0, NAN))),
        *(
            (problem, INERTIA, (0.0, 0.01))
            for problem in (
                lambda _: None,
                lambda time: RodProblem(ROD, base=Free() if time else Clamped()),
                lambda _: RodProblem(Rod(0.4, SIX)),
                lambda time: RodProblem(Rod(0.4, SIX) if time else ROD),
            )
        ),
    ],
    partial(solve_rods, elements=20): [
        *((length, 1.0, 1.0, (0, 0, 1), np.eye(3)) for length in (NAN, -1.0, (0.3, 0.4))),
        (0.3, 1.0, 1.0, (0, NAN), np.eye(3)),
    ],
    partial(GripTable, gravity=(9.8, 0.0, 0.0), rate=1.5e4): [
        (radii, (None, None), (0.0,)) for radii in ((0.02, 0.01), (NAN, 0.01), (0.01, 0.02, 0.03))
    ],
    FiberAngles: [(1.0, 1.0 + 9e-5), (pi / 2, -pi / 2)],
    MooneyRivlin: [(1.0, -1.0)],
    partial(coil_from_state, STATE): [((NAN, 0.0, 1.0),), ((2.0, 0.0, 0.0),)],
    stiff: [(1e-4, 1e-4, 1.1e-2), (1.0, 101.0)],
    # Millimeters taken for meters, for one.
    WrapCurve: [(paper_gripper("P1", (1e300, 0.0, 0.0)),), (linear_gripper(length=361.0),)],
    design_gripper: [(replace(PAPER_EXAMPLE, fiber_angle_alpha=0.5, fiber_angles_beta=(-0.5,)),)],
    vibrations: [(replace(gripper(), weight_per_length=0.0), 0.0)],
    partial(follow_contact, start=START): [
        ([replace(PROBLEM, obstacles=())],),
        ([replace(PROBLEM, point_loads=(PointLoad(0.123),))],),
    ],
    settling_after_ramp: [(gripper(), -1.0, 1e4)],
    START.on_obstacle: [(1,)],
    FILLED.time_to_fill: [(lambda _: -1.0, 0.0, 1.0)],
    partial(replace, PAPER_EXAMPLE, gravity=(0.0, 0.0, 0.0), payload=0.1): [()],
    partial(replace, HELICAL, fiber_angles_gamma=angles(20.0), fiber_angles_beta=angles(20.0)): [
        ()
    ],
    # An element that turns by nearly a full turn at rest, or more, looks all but straight.
    partial(solve_rods, elements=8): [
        (length, 1.0, 1.0, (0, 0, 1), np.eye(3)) for length in (50.0, "x", ())
    ],
    partial(solve_rod, elements=3): [
        *((replace(FREE, rest_strain=(0, 0, k), breaks=(0.28, 0.29)), LOAD) for k in (18, 1e308)),
        (replace(FREE, rest_strain=(0, 0, 50), radius=1e-3), LOAD),
    ],
    Obstacle: [(Plane,)],
    # As long elements would not see the obstacle.
    partial(solve_contact, replace(PROBLEM, rod=replace(ROD, length=4.0)), start=START): [()],
    partial(solve_motion, lambda _: PROBLEM, INERTIA, (0.0, 0.01), start=STATE, elements=0): [()],
}


def test_what_does_not_fit_together_is_refused():
    """And a jump is taken where a break declares it."""
    said_of = (said(call, *given) for call in TOGETHER for given in TOGETHER[call])
    found = {f"{k}": f"{each}".partition(", got")[0] for k, each in enumerate(said_of)}
    recorded("refusals/together", found)
    for rod in JUMPS:
        assert solve_rod(replace(rod, breaks=(0.1234,)), LOAD).stable
