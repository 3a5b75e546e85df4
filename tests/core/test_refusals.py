# SPDX-License-Identifier: Apache-2.0
"""Values that make no tube, actuator, gripper, design or motion are refused, by their field's name.

What a rod and its obstacles refuse is in ``test_rod_input``.
"""

import math
from dataclasses import replace
from functools import partial

import pytest
from core.actuator_cases import actuator, degrees
from core.contact_cases import gripper
from core.design_cases import LATEX, PAPER_EXAMPLE, PAPER_TUBE, angles
from core.gripper_cases import PRESSURE_MAX, linear_gripper, paper_gripper

from spiral_core import (
    CalibrationModel,
    Damping,
    Elastomer,
    ExtensionReading,
    FiberAngles,
    FreeActuation,
    Gent,
    Inertia,
    InvalidInputError,
    MeasuredActuation,
    MooneyRivlin,
    NeoHookean,
    ObjectProfile,
    Orifice,
    PressureCourse,
    Section,
    Supply,
    SwingReading,
    Tube,
    WrapCurve,
    Yeoh,
    design_gripper,
    design_space,
    feasibility_map,
    gripper_from_actuator,
    settling_after_move,
    settling_after_ramp,
    vibrations,
)
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.fibers import fiber_state
from spiral_core.actuator.uniform_law import energy_from_stretch, pressure_from_stretch
from spiral_core.rod.motion.swing import Swing
from spiral_core.wrap.helix import Helix
from spiral_core.wrap.wrap import line_force

NAN, INF = math.nan, math.inf
WRONG = (0.0, -1.0, NAN, INF, True, "1")
# A map of what is hopeless is soon told.
FREE = replace(PAPER_EXAMPLE, radius_max=1e3, radius_min=1e3)
HELICAL = replace(PAPER_EXAMPLE, elastomers=(Elastomer("section", LATEX.law, 950.0),))


def changed(value):
    """Return what makes a value with other fields."""
    return lambda **given: replace(value, **given)


def at_stretch(ask, *less):
    """Return the row of a function of an actuator and a stretch."""
    return lambda stretch: ask(actuator(), stretch), {"stretch": (1.1, *WRONG, *less)}


# A call; and for each of its arguments a good value, and what it must not be.
ARGUMENTS = [
    (
        Tube,
        dict.fromkeys(("inner_radius", "wall_thickness", "length"), (5e-3, *WRONG, 1.1e9, 1e300)),
    ),
    (FiberAngles, {"alpha": (1.5, 0.0, 1.6, NAN), "beta": (1.0, 1e-5)}),
    (NeoHookean, {"c1": (1.0, 0.0)}),
    (MooneyRivlin, {"c1": (1.0,), "c2": (0.0, INF)}),
    (Yeoh, {"c1": (1.0, -1.0), "c2": (0.0, NAN), "c3": (0.0, INF)}),
    (Gent, {"shear_modulus": (1.0, 0.0), "extension_limit": (1.0, -1.0)}),
    (
        changed(actuator()),
        {
            "tube": (actuator().tube, 4.7625e-3),
            "fibers": (actuator().fibers, (1.5, 1.0)),
            "material": (actuator().material, 870.0e3),
            "curvature_form": (actuator().curvature_form, "exact"),
            "twist_shear": (False, 1),
            "straight_fiber_radius": (None, 0.0),
        },
    ),
    (
        partial(UnloadedShape, 20.0, -10.0),
        {"backbone_length": (0.5, 0.0), "stretch": (1.1, 0.0)},
    ),
    (
        MeasuredActuation,
        {
            "pressures": (
                (0.0, 2.0e4, 4.0e4),
                (1.0, 2.0e4, 4.0e4),
                (0.0, 2.0e4, 2.0e4),
                (0.0, NAN, 4.0e4),
            ),
            "curvatures": ((0.0, 8.0, 8.0), (0.0, 8.0, 7.0), (0.0, 8.0)),
            "torsions": ((0.0, -4.0, -9.0), (0.0, INF, 9.0)),
            "backbone_length": (0.36, 0.0),
        },
    ),
    (partial(fiber_state, degrees(88.0, 60.0)), {"stretch": (1.1, 0.0, INF)}),
    at_stretch(energy_from_stretch),
    at_stretch(pressure_from_stretch, 0.999),
    at_stretch(unloaded_shape_from_stretch, 0.99),
    at_stretch(lambda own, stretch: FreeActuation(own).pressure_from_stretch(stretch), 0.9),
    (
        FreeActuation(actuator()).unloaded_shape,
        {"pressure": (1e4, -1e-300, NAN, True, "55 kPa")},
    ),
    (
        CalibrationModel,
        {
            "actuator": (actuator(),),
            "bending_stiffness": (1e-4, *WRONG),
            "torsional_stiffness": (1e-4, *WRONG),
            "law": (None, int),
            "fixed": ({}, {"c3": 1.0}, {"c1": 1.0, "c2": 1.0}),
        },
    ),
    (
        ExtensionReading,
        {
            "pressure": (1e4, -1.0),
            "extension": (1e-3, INF),
            "section_length": (0.1, 0.0),
            "error": (1e-4, 0.0),
            "pressure_error": (0.0, -1.0),
        },
    ),
    (SwingReading, {"time": (0.0, NAN), "displacement": (0.0, INF), "error": (1e-3, 0.0)}),
    (
        changed(PAPER_EXAMPLE),
        {
            "radius_min": (0.011, 0.0),
            "radius_max": (0.03, 0.01, 1e200),
            "tubes": ((PAPER_TUBE,), ()),
            "elastomers": ((LATEX,), ()),
            "fiber_angles_beta": ((1.0,), ()),
            "turns_required": (0.1, 0.0999, NAN),
            "object_length": (0.25, -1.0),
            "length_max": (None, 0.0),
            "pressure_max": (None, 0.0),
            "strain_max": (0.3, 0.0, 10.1),
            "gravity": ((0.0, 0.0, 9.8), (0.0, 0.0)),
            "object_axis": (None, (1.0, 1.0, 0.0)),
            "extra_mass_per_length": (0.0, -1.0),
            "end_allowance": (0.0, NAN),
            "payload": (None, 0.0),
            "friction_coefficient": (0.3, -0.1),
        },
    ),
    (
        changed(LATEX),
        {"law": (LATEX.law, 3.0), "density": (950.0, 0.0)},
    ),
    (
        partial(design_space, actuator(), [1.0]),
        {"turns_required": (1.0, 0.0), "stretch_max": (1.2, 1.01)},
    ),
    (
        partial(feasibility_map, FREE),
        {
            "fiber_angles_beta": ((1.0, 1.2), (1.2, 1.2)),
            "inner_radii": ((0.004, 0.005), (0.005,), (0.004, NAN)),
            "wall_thickness": (1e-3, 0.0),
        },
    ),
    (Helix, {"curvature": (20.0, *WRONG), "torsion": (10.0, NAN)}),
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
            "gravity": ((0.0, 0.0, 0.0), (1.0, 2.0)),
            "object_axis": (None, (1.0, 1.0, 0.0)),
            "turns_required": (1.0, 0.0),
            "friction_coefficient": (None, -0.1),
            "pressure_max": (1e4, 0.0, 2.0e5),
            "weight_per_length": (0.0, -1.0),
        },
    ),
    (
        paper_gripper("P1").unloaded_shape,
        {"pressure": (1e4, -1.0, NAN, 1.01 * PRESSURE_MAX)},
    ),
    (
        partial(gripper_from_actuator, "bad", actuator()),
        {"density": (930.0, 0.0), "extra_mass_per_length": (0.0, -1.0)},
    ),
    (
        lambda torsional: replace(
            paper_gripper("P1"), stiffness=Section.inextensible(1.0, torsional)
        ),
        {"torsional": (0.0101, 0.0099, 101.0)},
    ),
    (
        partial(line_force, Section.inextensible(3e-4, 2e-4), UnloadedShape(40.0, -15.0, 0.4)),
        {"radius": (0.02, NAN), "helix_angle": (1.0, NAN), "outer_radius": (0.005, NAN)},
    ),
    (
        WrapCurve(paper_gripper("P2")).wrap_for_radius,
        {"radius": (0.02, 0.0, NAN, True)},
    ),
    (Inertia, {"mass": (1.0, 0.0), "rotary": (1.0, -1.0)}),
    (partial(Inertia.round, 1100.0, 1e-3), {"bore": (0.0, 1e-3)}),
    (
        Damping,
        {"retardation_time": (0.0, -1.0), "air": (1.0, NAN), "drag_rate": (0.0, -1.0)},
    ),
    (Orifice, {"conductance": (1e-9, 0.0), "critical_ratio": (0.2, 1.0, -0.1)}),
    (Supply, {"orifice": (Orifice(1e-9),), "pressure": (5e5, -1.0)}),
    (
        PressureCourse,
        {"times": ((0.0, 1.0), (0.0,)), "pressures": ((0.0, 1.0), (0.0, -1.0), (0.0, NAN))},
    ),
    (
        lambda end: Swing(1.0, 40.0, 0.0, 2.0).settling_time(Damping(0.01), 0.1, end),
        {"end": (0.01, 0.0)},
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
    good = {name: values[0] for name, values in arguments.items()}
    call(**good)
    for field, (_, *wrong) in arguments.items():
        for value in wrong:
            with pytest.raises(InvalidInputError) as caught:
                call(**(good | {field: value}))
            assert caught.value.field == field, value
            assert field in str(caught.value)


def helical(gamma, wanted=HELICAL):
    return replace(
        wanted, fiber_angles_beta=angles(20.0), fiber_angles_gamma=(math.radians(gamma),)
    )


@pytest.mark.parametrize(
    ("said", "make"),
    [
        ("alpha, beta", lambda: FiberAngles(alpha=1.0, beta=1.0 + 9e-5)),
        ("alpha, beta", lambda: FiberAngles(alpha=math.pi / 2, beta=-math.pi / 2)),
        (r"c1 \+ c2", lambda: MooneyRivlin(c1=1.0, c2=-1.0)),
        ("radii", lambda: ObjectProfile([0.0], [0.01])),
        ("weight_per_length", lambda: vibrations(replace(gripper(), weight_per_length=0.0), 0.0)),
        ("turns", lambda: Helix(20.0, 10.0).length_for_turns(-1.0)),
        ("length", lambda: Helix(20.0, 10.0).turns(-0.1)),
        ("outer_radius", lambda: Helix(20.0, 10.0).object_radius(0.0)),
        ("rate", lambda: PressureCourse.ramp(0.0, 1e4, 1.0)),
        ("volume", lambda: Supply(Orifice(1e-9), 1.0).time_to_fill(lambda _: -1.0, 0.0, 1.0)),
        ("payload", lambda: replace(PAPER_EXAMPLE, payload=0.1, gravity=(0.0, 0.0, 0.0))),
        ("beta", lambda: replace(PAPER_EXAMPLE, fiber_angles_beta=(2.0,))),
        (".*cross", lambda: replace(PAPER_EXAMPLE, fiber_angles_beta=angles(88.0))),
        (
            ".*extend",
            lambda: design_gripper(
                replace(PAPER_EXAMPLE, fiber_angle_alpha=0.5, fiber_angles_beta=(-0.5,))
            ),
        ),
        ("fiber_angles_gamma .* at another angle than the wound families", lambda: helical(20.0)),
        ("fiber_angles_gamma .* from -30 to 30 degrees", lambda: helical(30.1)),
        ("fiber_angles_gamma .* from -30 to 30 degrees", lambda: helical(NAN)),
        (
            "fiber_angles_gamma .* latex belong to the uniform .* from 0.7 times these",
            lambda: helical(5.0, PAPER_EXAMPLE),
        ),
    ],
)
def test_arguments_that_do_not_fit_together_are_refused(said, make):
    with pytest.raises(InvalidInputError, match=f"^{said}"):
        make()
