# SPDX-License-Identifier: Apache-2.0
"""The interface of an actuator model: an unloaded shape for each pressure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from spiral_core.errors import ActuationLimit
from spiral_core.validation import require_finite, require_positive


@dataclass(frozen=True, slots=True)
class UnloadedShape:
    """The uniform shape an actuator takes when nothing loads it.

    In the material frame (x tangent, y towards the straight fiber) its strain vector is
    (torsion, 0, curvature); see ``docs/conventions.md``.

    Args:
        curvature: curvature per length of ``backbone_length`` [1/m]; positive bends towards y.
        torsion: torsion, the same as the twist rate of the material frame [1/m]; positive is
            right-handed.
        backbone_length: length of the backbone that carries this shape [m], > 0.
        stretch: axial stretch of the tube (1 at rest), or None where a model does not know it.

    Raises:
        InvalidInputError: a value is not finite, or a length or stretch is not positive.

    Example:
        >>> UnloadedShape(curvature=20.0, torsion=-10.0, backbone_length=0.36).stretch is None
        True
    """

    curvature: float
    torsion: float
    backbone_length: float
    stretch: float | None = None

    def __post_init__(self) -> None:
        require_finite("curvature", self.curvature)
        require_finite("torsion", self.torsion)
        require_positive("backbone_length", self.backbone_length)
        if self.stretch is not None:
            require_positive("stretch", self.stretch)


@runtime_checkable
class ActuationModel(Protocol):
    """A model from pressure to unloaded shape: mechanical, or interpolating measured data."""

    @property
    def pressure_limit(self) -> float:
        """Largest gauge pressure the model answers for [Pa]."""
        ...

    @property
    def limit(self) -> ActuationLimit:
        """The reason for ``pressure_limit``."""
        ...

    def unloaded_shape(self, pressure: float) -> UnloadedShape:
        """Return the unloaded shape at a gauge pressure [Pa], 0 <= pressure <= pressure_limit.

        Raises:
            InvalidInputError: the pressure is negative or not finite.
            ActuationLimitError: the pressure is past ``pressure_limit``.
        """
        ...
