# SPDX-License-Identifier: Apache-2.0
"""The rod's stiffness as a gripper file states it: measured, of the section, or of the annulus."""

from __future__ import annotations

from typing import Any, cast

from spiral_core import (
    ActuationLimitError,
    Actuator,
    InvalidInputError,
    Section,
    stiffness_from_actuator,
    stiffness_from_section,
)
from spiral_gripper.files.values import Values


def rod_stiffness(values: Values, actuator: Actuator) -> Section:
    """Return EI and GJ of a file's gripper.

    Args:
        values: of the file's fields.
        actuator: that they describe.

    Raises:
        InvalidInputError: the section's stiffness is asked for beside stated ones, past the
            pressure limit, or of fibers that have none.
    """
    names = [name for name in ("bending", "torsional") if f"stiffness.{name}" in values]
    stated: dict[str, Any] = {name: values[f"stiffness.{name}"] for name in names}
    if "stiffness.section_at" not in values:
        annulus = stiffness_from_actuator(actuator)
        both = {"bending": annulus.bending, "torsional": annulus.torsional} | stated
        return Section.inextensible(**both)
    pressure = cast("float", values["stiffness.section_at"])
    if stated:
        requirement = "left out where bending or torsional is stated"
        raise InvalidInputError("section_at", pressure, requirement)
    if not 0.0 <= pressure <= cast("float", values["limits.pressure_max"]):
        raise InvalidInputError("section_at", pressure, "from 0 to limits.pressure_max")
    try:
        return stiffness_from_section(actuator, pressure)
    except (InvalidInputError, ActuationLimitError) as error:
        requirement = f"a pressure at which the section has a stiffness: {error}"
        raise InvalidInputError("section_at", pressure, requirement) from None
