# SPDX-License-Identifier: Apache-2.0
"""Values that make no tube, actuator, gripper or motion are refused, by the name of their field.

What a rod and its obstacles refuse is in ``test_rod_input``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from core.actuator_cases import actuator, degrees
from core.contact_cases import gripper
from core.gripper_cases import PRESSURE_MAX, linear_gripper, paper_gripper
from core.questions import Question, wrong_arguments

from spiral_core import (
    CalibrationModel,
    Damping,
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
    Tube,
    WrapCurve,
    Yeoh,
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
# A call with good arguments; and for each of them, what it must not be.
ARGUMENTS: list[Question] = [
    (
        Tube,
        {"inner_radius": 5e-3, "wall_thickness": 1e-3, "length": 0.5},
        dict.fromkeys(("inner_radius", "wall_thickness", "length"), (*WRONG, 1.1e9, 1e300)),
    ),
    (
        FiberAngles,
        {"alpha": 1.5, "beta": 1.0},
        {"alpha": (0.0, 1.6, NAN), "beta": (1e-5, -1.6)},
    ),
    (NeoHookean, {"c1": 1.0}, {"c1": (0.0, NAN)}),
    (MooneyRivlin, {"c1": 1.0, "c2": 0.0}, {"c2": (INF,)}),
    (Yeoh, {"c1": 1.0, "c2": 0.0, "c3": 0.0}, {"c1": (-1.0,), "c2": (NAN,), "c3": (INF,)}),
    (
        Gent,
        {"shear_modulus": 1.0, "extension_limit": 1.0},
        {"shear_modulus": (0.0,), "extension_limit": (-1.0,)},
    ),
    (
        lambda **given: replace(actuator(), **given),
        {},
        {
            "tube": (4.7625e-3,),
            "fibers": ((1.5, 1.0),),
            "material": (870.0e3,),
            "curvature_form": ("exact",),
            "twist_shear": (1,),
            "straight_fiber_radius": (0.0, NAN),
        },
    ),
    (
        UnloadedShape,
        {"curvature": 20.0, "torsion": -10.0, "backbone_length": 0.5, "stretch": 1.1},
        {
            "curvature": (NAN,),
            "torsion": (INF,),
            "backbone_length": (0.0, -0.5),
            "stretch": (0.0, NAN),
        },
    ),
    (
        MeasuredActuation,
        {
            "pressures": (0.0, 2.0e4, 4.0e4, 6.0e4),
            "curvatures": (0.0, 8.0, 8.0, 30.0),
            "torsions": (0.0, -4.0, -9.0, -14.0),
            "backbone_length": 0.36,
        },
        {
            "pressures": (
                (0.0, 2.0e4),
                (1.0, 2.0e4, 4.0e4, 6.0e4),
                (0.0, 2.0e4, 2.0e4, 6.0e4),
                (0.0, 2.0e4, NAN, 6.0e4),
            ),
            "curvatures": ((0.0, 8.0, 7.0, 30.0), (-1.0, 8.0, 9.0, 30.0), (0.0, 8.0, 9.0)),
            "torsions": ((0.0, INF, 9.0, 10.0),),
            "backbone_length": (0.0,),
        },
    ),
    (
        lambda stretch: fiber_state(degrees(88.0, 60.0), stretch),
        {"stretch": 1.1},
        {"stretch": (0.0, -1.0, NAN, INF)},
    ),
    *(
        (
            lambda stretch, ask=ask: ask(actuator(), stretch),
            {"stretch": 1.1},
            {"stretch": (*WRONG, *less)},
        )
        for ask, less in (
            (energy_from_stretch, ()),
            (pressure_from_stretch, (0.999,)),
            (unloaded_shape_from_stretch, (0.99,)),
            (lambda a, stretch: FreeActuation(a).pressure_from_stretch(stretch), (0.9,)),
        )
    ),
    (
        lambda pressure: FreeActuation(actuator()).unloaded_shape(pressure),
        {"pressure": 1e4},
        {"pressure": (-1.0, -1e-300, NAN, INF, True, "55 kPa")},
    ),
    (
        CalibrationModel,
        {"actuator": actuator()},
        dict.fromkeys(("bending_stiffness", "torsional_stiffness"), WRONG),
    ),
    (Helix, {"curvature": 20.0, "torsion": 10.0}, {"curvature": WRONG, "torsion": (NAN, INF)}),
    (
        ObjectProfile,
        {"positions": [0.0, 0.1], "radii": [0.01, 0.01]},
        {
            "positions": ([0.1, 0.1], [0.0, INF], "ab"),
            "radii": ([0.01], [0.01, 0.0], [0.01, NAN]),
        },
    ),
    (
        lambda **given: replace(linear_gripper(), **given),
        {},
        {
            "gravity": ((0.0, NAN, 0.0), (1.0, 2.0)),
            "object_axis": ((1.0, 1.0, 0.0),),
            "turns_required": (0.0, INF),
            "friction_coefficient": (-0.1, NAN),
            "pressure_max": (0.0, 2.0e5),
            "weight_per_length": (-1.0,),
        },
    ),
    (
        lambda pressure: paper_gripper("P1").unloaded_shape(pressure),
        {"pressure": 1e4},
        {"pressure": (-1.0, NAN, 1.01 * PRESSURE_MAX, INF, True)},
    ),
    (
        lambda **given: gripper_from_actuator("bad", actuator(), **given),
        {"density": 930.0},
        {"density": (0.0,), "extra_mass_per_length": (-1.0,)},
    ),
    (
        lambda torsional: replace(
            paper_gripper("P1"), stiffness=Section.inextensible(1.0, torsional)
        ),
        {"torsional": 0.0101},
        {"torsional": (0.0099, 101.0, 1e-9, 1e9)},
    ),
    (
        lambda **given: line_force(
            Section.inextensible(3e-4, 2e-4), UnloadedShape(40.0, -15.0, 0.4), **given
        ),
        {"radius": 0.02, "helix_angle": 1.0, "outer_radius": 0.005},
        dict.fromkeys(("radius", "helix_angle", "outer_radius"), (NAN,)),
    ),
    (
        lambda radius: WrapCurve(paper_gripper("P2")).wrap_for_radius(radius),
        {"radius": 0.02},
        {"radius": (0.0, -0.01, NAN, INF, True)},
    ),
    (Inertia, {"mass": 1.0, "rotary": 1.0}, {"mass": (0.0,), "rotary": (-1.0,)}),
    (
        lambda bore: Inertia.round(1100.0, 1e-3, bore),
        {"bore": 0.0},
        {"bore": (1e-3,)},
    ),
    (
        Damping,
        {"retardation_time": 0.0},
        {"retardation_time": (-1.0,), "air": (NAN,), "drag_rate": (-1.0,)},
    ),
    (
        Orifice,
        {"conductance": 1e-9, "critical_ratio": 0.2},
        {"conductance": (0.0,), "critical_ratio": (1.0, -0.1)},
    ),
    (Supply, {"orifice": Orifice(1e-9), "pressure": 5e5}, {"pressure": (-1.0,)}),
    (
        PressureCourse,
        {"times": (0.0, 1.0), "pressures": (0.0, 1.0)},
        {"times": ((0.0,),), "pressures": ((0.0, -1.0), (0.0, NAN))},
    ),
    (
        lambda end: Swing(1.0, 40.0, 0.0, 2.0).settling_time(Damping(0.01), 0.1, end),
        {"end": 0.01},
        {"end": (0.0, -1.0, NAN)},
    ),
    (
        lambda pressure=3e4, rate=1e4: settling_after_ramp(gripper(), pressure, rate),
        {},
        {"rate": (0.0,), "pressure": (-1.0,)},
    ),
    (lambda speed: settling_after_move(gripper(), 0.0, speed), {"speed": 0.0}, {"speed": (NAN,)}),
    (lambda count: vibrations(gripper(), 0.0, count), {"count": 1}, {"count": (0,)}),
]


@pytest.mark.parametrize(("number", "field", "value"), list(wrong_arguments(ARGUMENTS)))
def test_a_wrong_argument_is_refused_by_name(number: int, field: str, value: object) -> None:
    call, good, _ = ARGUMENTS[number]
    with pytest.raises(InvalidInputError) as caught:
        call(**(good | {field: value}))
    assert caught.value.field == field
    assert field in str(caught.value)


@pytest.mark.parametrize("number", range(len(ARGUMENTS)))
def test_good_arguments_are_taken(number: int) -> None:
    call, good, _ = ARGUMENTS[number]
    call(**good)


@pytest.mark.parametrize(
    ("field", "make"),
    [
        ("alpha, beta", lambda: FiberAngles(alpha=1.0, beta=1.0)),
        ("alpha, beta", lambda: FiberAngles(alpha=1.0, beta=1.0 + 9e-5)),
        ("alpha, beta", lambda: FiberAngles(alpha=math.pi / 2, beta=-math.pi / 2)),
        ("c1 + c2", lambda: MooneyRivlin(c1=1.0, c2=-1.0)),
        ("radii", lambda: ObjectProfile([0.0], [0.01])),
        ("weight_per_length", lambda: vibrations(replace(gripper(), weight_per_length=0.0), 0.0)),
        ("turns", lambda: Helix(20.0, 10.0).length_for_turns(-1.0)),
        ("turns", lambda: Helix(20.0, 10.0).object_length(-1.0)),
        ("length", lambda: Helix(20.0, 10.0).turns(-0.1)),
        ("outer_radius", lambda: Helix(20.0, 10.0).object_radius(0.0)),
        ("rate", lambda: PressureCourse.ramp(0.0, 1e4, 1.0)),
        ("volume", lambda: Supply(Orifice(1e-9), 1.0).time_to_fill(lambda _: -1.0, 0.0, 1.0)),
    ],
)
def test_arguments_that_do_not_fit_together_are_refused(
    field: str, make: Callable[[], object]
) -> None:
    with pytest.raises(InvalidInputError) as caught:
        make()
    assert caught.value.field == field
