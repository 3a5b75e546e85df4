# SPDX-License-Identifier: Apache-2.0
"""Identifiability: whether the readings determine each parameter, and what to measure if not.

A change of the parameters acts on the readings through the Jacobian of the weighted residuals. If a
combination of parameters changes the residuals hardly at all, the readings do not determine it,
however small the residuals are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.calibration.model import FittedQuantity
from spiral_core.calibration.readings import ShapeReading
from spiral_core.calibration.result import Calibration
from spiral_core.errors import InvalidInputError

# Condition index above which regression texts call parameters collinear.
CONDITION_MAX = 30.0
# Effect on all readings together, in standard errors, of changing a combination of parameters by
# their own magnitude, below which they are not fitted but left over.
UNSEEN = 1e-3
# Share of a weak direction below which a parameter is not counted as part of it.
SHARE_MIN = 0.2
# Relative standard error above which a parameter is called undetermined by itself.
RELATIVE_ERROR_MAX = 0.5

_STIFFNESSES = {
    FittedQuantity.BENDING_STIFFNESS.value,
    FittedQuantity.TORSIONAL_STIFFNESS.value,
}


@dataclass(frozen=True, slots=True)
class WeakDirection:
    """A combination of parameters that the readings hardly determine.

    Attributes:
        names: the parameters that take part.
        condition: how many times weaker its effect is than the strongest combination's.
        stretch_min: least stretch among the readings, by the fitted actuator.
        stretch_max: largest stretch among them.
        advice: what to measure, or what to fix.
    """

    __repr__ = brief_repr

    names: tuple[str, ...]
    condition: float
    stretch_min: float
    stretch_max: float
    advice: str

    def __str__(self) -> str:
        return (
            f"{' and '.join(self.names)} cannot be told apart over stretches "
            f"{self.stretch_min:.3f} to {self.stretch_max:.3f} "
            f"(condition index {self.condition:.3g}): {self.advice}"
            if len(self.names) > 1
            else f"{self.names[0]} is not determined: {self.advice}"
        )


def require_seen(calibration: Calibration) -> None:
    """Refuse a fit of parameters on which no reading depends.

    Args:
        calibration: the fit; parameters at their bounds are not looked at.

    Raises:
        InvalidInputError: changing some combination of parameters by their own magnitude moves all
            readings together by less than a thousandth of their error.
    """
    names = [name for name in calibration.names if name not in calibration.at_bound]
    columns = [calibration.index(name) for name in names]
    scales = np.array(calibration.model.scales())[columns] / max(calibration.error_scale, 1.0)
    effects = calibration.jacobian[calibration.fitted][:, columns] * scales
    if not names:
        return
    _, singular, directions = np.linalg.svd(effects, full_matrices=False)
    if singular[-1] >= UNSEEN:
        return
    shares = zip(names, np.abs(directions[-1]), strict=True)
    unseen = tuple(name for name, share in shares if share >= SHARE_MIN)
    pressures = [reading.pressure for reading in calibration.readings]
    raise InvalidInputError(
        "readings",
        f"{len(pressures)} readings from {min(pressures):.6g} Pa to {max(pressures):.6g} Pa",
        f"such that they depend on {' and '.join(unseen)} ({_advice(calibration, unseen)})",
    )


def condition_indices(calibration: Calibration) -> tuple[float, ...]:
    """Return how much weaker each combination of parameters acts than the strongest, from 1 up.

    Ratios of the singular values of the Jacobian, its columns scaled to length one.

    Source: D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics, 1980, ch. 3.
    """
    singular, _ = _directions(calibration)
    return tuple(float(singular[0] / max(one, np.finfo(np.float64).tiny)) for one in singular)


def weak_directions(calibration: Calibration) -> tuple[WeakDirection, ...]:
    """Return the combinations of parameters that the readings do not determine, the weakest first.

    Empty if all are determined. A weak combination may be harmless: the pressure for a radius may
    not depend on it either, which its uncertainty shows.

    Args:
        calibration: the fit.
    """
    singular, directions = _directions(calibration)
    found: list[WeakDirection] = []
    for value, direction in zip(singular[::-1], directions[::-1], strict=True):
        condition = float(singular[0] / max(value, np.finfo(np.float64).tiny))
        shares = zip(calibration.names, direction, strict=True)
        names = tuple(name for name, share in shares if abs(share) >= SHARE_MIN)
        if condition > CONDITION_MAX:
            found.append(_weak(calibration, names, condition))
    named = {name for weak in found for name in weak.names}
    relative = calibration.standard_errors / np.abs(calibration.values)
    for name, error in zip(calibration.names, relative, strict=True):
        if name not in named and error > RELATIVE_ERROR_MAX:
            found.append(_weak(calibration, (name,), condition_indices(calibration)[-1]))
    return tuple(found)


def _directions(calibration: Calibration) -> tuple[np.ndarray, np.ndarray]:
    """Return singular values and right vectors of the Jacobian with columns of length one."""
    jacobian = calibration.jacobian[calibration.fitted]
    lengths = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(lengths > 0.0, lengths, 1.0)
    _, singular, directions = np.linalg.svd(scaled, full_matrices=False)
    return singular, directions


def _weak(calibration: Calibration, names: tuple[str, ...], condition: float) -> WeakDirection:
    stretches = [
        calibration.actuation.stretch_from_pressure(reading.pressure)
        for reading in calibration.readings
    ]
    return WeakDirection(
        names, condition, min(stretches), max(stretches), _advice(calibration, names)
    )


def _advice(calibration: Calibration, names: tuple[str, ...]) -> str:
    """Return what would tell these parameters apart."""
    has_shapes = any(isinstance(reading, ShapeReading) for reading in calibration.readings)
    if _STIFFNESSES & set(names):
        if not has_shapes:
            return (
                "only a shape that gravity bends depends on EI and GJ; "
                "measure positions of a long actuator, or leave them to the material"
            )
        return (
            "measure shapes in a second mount, with gravity across the tube, and at low pressure "
            "where the weight bends and twists it most"
        )
    if FittedQuantity.STRAIGHT_FIBER_RADIUS.value in names:
        return (
            "a bend angle sees stretch over radius only; "
            "add the extension of a straight section, or fix straight_fiber_radius"
        )
    if len(names) == 1:
        return "measure at higher pressures and more often, or fix it"
    return (
        "measure to a larger stretch, or a section wound at angles farther from 90 degrees (there "
        "I1 = I2), or fix one of them, or choose a law with fewer constants"
    )
