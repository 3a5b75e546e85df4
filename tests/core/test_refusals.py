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
from core.design_cases import LATEX, PAPER_EXAMPLE, angles
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
from spiral_core.actuator.uniform_law import pressure_from_stretch
from spiral_core.rod.motion.swing import Swing
from spiral_core.wrap.helix import Helix
from spiral_core.wrap.wrap import line_force

NAN, INF = math.nan, math.inf
POSITIVE = (1.0, 0.0, -1.0, NAN, INF, True, "1")
NATURAL = (0.0, -1.0, NAN, INF)
FINITE = (1.0, NAN, INF)
PRESSURE = (1e4, -1.0, -1e-300, NAN, INF, True, "55 kPa")
DIMENSION = (5e-3, 0.0, NAN, 1.1e9, 1e300)
HELICAL = replace(PAPER_EXAMPLE, elastomers=(Elastomer("section", LATEX.law, 950.0),))
SHAPE = UnloadedShape(40.0, -15.0, 0.4)


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
    (
        lambda torsional: replace(
            paper_gripper("P1"), stiffness=Section.inextensible(1.0, torsional)
        ),
        {"torsional": (0.0101, 0.0099, 101.0)},
    ),
    (
        partial(line_force, Section.inextensible(3e-4, 2e-4), SHAPE),
        dict.fromkeys(("radius", "helix_angle", "outer_radius"), (1.0, NAN)),
    ),
    (
        WrapCurve(paper_gripper("P2")).wrap_for_radius,
        {"radius": (0.02, *POSITIVE[1:-1])},
    ),
    (Inertia, {"mass": POSITIVE, "rotary": POSITIVE}),
    (partial(Inertia.round, 1100.0, 1e-3), {"bore": (0.0, 1e-3)}),
    (Damping, {"retardation_time": NATURAL, "air": NATURAL, "drag_rate": NATURAL}),
    (Orifice, {"conductance": POSITIVE, "critical_ratio": (0.2, 1.0, -0.1)}),
    (partial(Supply, Orifice(1e-9)), {"pressure": POSITIVE}),
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
        ("radii", ObjectProfile, {"positions": [0.0], "radii": [0.01]}),
        ("turns", COIL.length_for_turns, {"turns": -1.0}),
        ("length", COIL.turns, {"length": -0.1}),
        ("outer_radius", COIL.object_radius, {"outer_radius": 0.0}),
        ("rate", PressureCourse.ramp, {"rate": 0.0, "pressure": 1e4, "wait": 1.0}),
        ("payload", changed(PAPER_EXAMPLE), {"payload": 0.1, "gravity": (0.0, 0.0, 0.0)}),
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
    ],
)
def test_arguments_that_do_not_fit_together_are_refused(said, call, arguments):
    with pytest.raises(InvalidInputError, match=f"^{said}"):
        call(**arguments)


def test_what_does_not_extend_weighs_nothing_or_fills_backwards_is_refused():
    with pytest.raises(InvalidInputError, match="extend"):
        design_gripper(replace(PAPER_EXAMPLE, fiber_angle_alpha=0.5, fiber_angles_beta=(-0.5,)))
    with pytest.raises(InvalidInputError, match="weight_per_length"):
        vibrations(replace(gripper(), weight_per_length=0.0), 0.0)
    with pytest.raises(InvalidInputError, match="volume"):
        Supply(Orifice(1e-9), 1.0).time_to_fill(lambda _: -1.0, 0.0, 1.0)
