# SPDX-License-Identifier: Apache-2.0
"""Actuators and synthetic bench tests that the calibration tests share."""

from dataclasses import astuple, replace
from functools import partial

import numpy as np
import pytest
from core import actuator_cases

from spiral_core import (
    BendReading,
    CalibrationModel,
    ExtensionReading,
    FreeActuation,
    Gent,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    TwistReading,
    Yeoh,
    calibrate,
)

TUBE = replace(actuator_cases.PAPER_TUBE, length=0.361)
LAWS = (
    NeoHookean(130.0e3),
    MooneyRivlin(90.0e3, 40.0e3),
    Yeoh(130.0e3, -10.0e3, 20.0e3),
    Gent(260.0e3, 3.0),
)

PRESSURES = tuple(np.linspace(8.0e3, 96.0e3, 12).tolist())


def actuator(material, alpha=75.0, beta=-75.0, **choices):
    """Return an actuator; angles in degrees, by default a pair that tells C1 and C2 apart."""
    return actuator_cases.actuator(alpha, beta, material, tube=TUBE, **choices)


def spiral(material):
    """Return the actuator of a spiral gripper, whose C1 and C2 act nearly alike."""
    return actuator(material, 88.0, 70.0)


def extensions(truth, pressures, error=2.0e-4, noise=None, pressure_noise=0.0):
    """Return readings of a 100 mm section; ``noise`` is the generator of the random errors."""
    uniform = truth.pressure_law is PressureLaw.UNIFORM
    actuation = FreeActuation(truth if uniform else truth.without_single_fibers())
    readings = []
    for pressure in pressures:
        off, mistake = (0.0, 0.0) if noise is None else noise.standard_normal(2)
        stretch = actuation.stretch_from_pressure(pressure + pressure_noise * off)
        extension = 0.1 * (stretch - 1.0) + error * mistake
        readings.append(ExtensionReading(pressure, extension, 0.1, error, pressure_noise))
    return readings


def of_shape(kind, rate, truth, pressures, noise=None, error=0.02):
    """Return readings of a curvature or a torsion along the finished actuator."""
    mistakes = np.zeros(len(pressures)) if noise is None else noise.standard_normal(len(pressures))
    shapes = map(FreeActuation(truth).unloaded_shape, pressures)
    return [
        kind(p, getattr(x, rate) * x.backbone_length + error * mistake, TUBE.length, error)
        for p, x, mistake in zip(pressures, shapes, mistakes, strict=True)
    ]


bends = partial(of_shape, BendReading, "curvature")
twists = partial(of_shape, TwistReading, "torsion")


def noisy(truth, seed=4, pressures=PRESSURES):
    """Return extensions with random errors."""
    return extensions(truth, pressures, noise=np.random.default_rng(seed))


def fitted(truth, readings, robust=False, **model):
    """Return the fit of an actuator's own law, or of what ``model`` says, to readings."""
    return calibrate(CalibrationModel(truth, **model), readings, robust=robust)


def refused(said):
    """Expect that an input is refused with these words."""
    return pytest.raises(InvalidInputError, match=said)


def start_from(truth, factor=1.4):
    """Return the same actuator with a material that is off by a factor."""
    constants = (factor * constant for constant in astuple(truth.material))
    return replace(truth, material=type(truth.material)(*constants))
