# SPDX-License-Identifier: Apache-2.0
"""Every error carries its figures, says them in one line, and travels between processes."""

from __future__ import annotations

import math
import pickle
import re
from enum import Enum

import pytest

from spiral_core import errors
from spiral_core.errors import (
    ActuationLimit,
    ActuationLimitError,
    InvalidInputError,
    NoCoilError,
    NotGrippableError,
    SolverError,
    SpiralError,
)
from spiral_core.message import Message, Quantity
from spiral_core.validation import require_in_range

LIMIT = ActuationLimit.DATA_END
HALF = 0.5 * math.pi


def raised(check, *arguments) -> InvalidInputError:
    with pytest.raises(InvalidInputError) as caught:
        check(*arguments)
    return caught.value


class Status(Enum):
    STALLED = "the line search stalled; use fewer elements"


EXAMPLES = [
    InvalidInputError("length", float("nan"), "a positive finite number"),
    ActuationLimitError(ActuationLimit.LIMIT_POINT, "pressure", 9.0e4, 8.0e4),
    SolverError(Status.STALLED, 3.0e-4, 17),
    NoCoilError(0.8, 1.05, 1.0e5),
    NotGrippableError(0.005, "the tube fills the coil", -0.004, 0.009),
    NotGrippableError(0.005, "the tube fills the coil", -0.004, None),
]


def test_every_error_of_the_tree_has_an_example() -> None:
    defined = {kind for kind in vars(errors).values() if isinstance(kind, type)}
    errors_defined = {kind for kind in defined if issubclass(kind, SpiralError)} - {SpiralError}
    assert errors_defined == {type(error) for error in EXAMPLES}


@pytest.mark.parametrize("error", EXAMPLES, ids=lambda error: type(error).__name__)
def test_message_is_one_line(error: SpiralError) -> None:
    assert str(error)
    assert "\n" not in str(error)


@pytest.mark.parametrize("error", EXAMPLES[1:], ids=lambda error: type(error).__name__)
def test_survives_pickling_with_its_attributes(error: SpiralError) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert vars(copy) == vars(error)
    assert str(copy) == str(error)


def test_invalid_input_names_field_value_and_requirement() -> None:
    error = InvalidInputError("wall_thickness", -1.0, "a positive finite number")
    assert (error.field, error.value, error.requirement) == (
        "wall_thickness",
        -1.0,
        "a positive finite number",
    )
    assert str(error) == "wall_thickness must be a positive finite number, got -1.0"
    assert isinstance(error, ValueError)


def test_long_and_multiline_values_are_shortened() -> None:
    message = str(InvalidInputError("positions", "a\n" * 500, "3 finite numbers"))
    assert len(message) < 180
    assert message.endswith("...")


@pytest.mark.parametrize("limit", ActuationLimit)
def test_actuation_limit_advises(limit: ActuationLimit) -> None:
    error = ActuationLimitError(limit, "pressure", 9.0e4, 8.0e4)
    assert (error.limit, error.quantity, error.value, error.bound) == (
        limit,
        "pressure",
        9.0e4,
        8.0e4,
    )
    assert str(error) == f"pressure 90000 Pa is past its limit 80000 Pa: {limit.value}"
    assert len(limit.value.split()) > 8


def test_a_stretch_has_no_unit() -> None:
    error = ActuationLimitError(ActuationLimit.FIBER_LOCKING, "stretch", 2.1, 2.0)
    assert str(error).startswith("stretch 2.1 is past its limit 2: a fiber family")


def test_solver_error_gives_advice_residual_and_iterations() -> None:
    error = SolverError(Status.STALLED, 3.0e-4, 17)
    assert (error.status, error.residual, error.iterations) == (Status.STALLED, 3.0e-4, 17)
    assert str(error) == f"{Status.STALLED.value} (residual 0.0003, 17 iterations)"


def test_not_grippable_names_the_nearest_that_is() -> None:
    error = NotGrippableError(0.005, "too thin", -0.004, 0.009)
    assert (error.radius, error.constraint, error.margin, error.nearest_radius) == (
        0.005,
        "too thin",
        -0.004,
        0.009,
    )
    assert "the nearest grippable radius is 0.009 m" in str(error)
    assert str(NotGrippableError(0.005, "too short", -0.004, None)) == (
        "the object cannot be gripped: too short"
    )


@pytest.mark.parametrize(("radius", "shown"), [(0.05, "0.0123456"), (0.005, "0.0123457")])
def test_the_nearest_radius_is_rounded_into_the_range(radius: float, shown: str) -> None:
    assert f"grippable radius is {shown} m" in str(
        NotGrippableError(radius, "no", -1.0, 0.01234565)
    )


def test_a_coil_that_closed_is_no_reason_to_ask_for_more_pressure() -> None:
    limited = str(NoCoilError(1.04999, 1.05, 5.0e4))
    assert "makes 1.04 turns at most (at 50000 Pa)" in limited
    assert "raise the pressure limit" in limited
    closed = str(NoCoilError(7.0, 10.0, 5.0e4, closes_at=6.0e4))
    assert "at 60000 Pa the coil has closed on itself" in closed
    assert "raise the pressure limit" not in closed
    nothing = str(NoCoilError(0.0, 1.05, 5.0e4, closes_at=1.0e3))
    assert "no pressure up to 50000 Pa leaves room for an object" in nothing
    assert "raise" not in str(NoCoilError(0.4, 1.05, 5.0e4, at_actuator_limit=True))


def test_a_message_keeps_its_quantities_wherever_it_travels() -> None:
    reason = Message("above {}", Quantity(1.0e5, "Pa"))
    error = pickle.loads(pickle.dumps(NotGrippableError(0.05, reason, -0.004, 0.01234567)))
    said = str(error)
    assert isinstance(said, Message)
    assert str(said) is said
    digits = said.told(lambda q: q.text(1.0e3, f"milli{q.unit}", 3))
    assert digits == (
        "an object of radius 50 millim cannot be gripped: above 1e+08 milliPa; "
        "the nearest grippable radius is 12.3 millim"
    )


@pytest.mark.parametrize(
    ("error", "shown"),
    [
        (ActuationLimitError(LIMIT, "pressure", 150000.04, 150000.01), "150001 Pa .* 150000 Pa"),
        (
            raised(require_in_range, "pressure", 55000.0001, 0.0, 55e3, "Pa"),
            "55000 Pa, got 55000.1",
        ),
        (
            raised(require_in_range, "alpha", 1.5707964, -HALF, HALF, "rad"),
            "90 deg, got 90.0001 deg",
        ),
        (raised(require_in_range, "alpha", -1.5707964, -HALF, HALF, "rad"), "got -90.0001 deg"),
        (raised(require_in_range, "elements", 1, 2, 100), "from 2 to 100, got 1$"),
        (raised(require_in_range, "time", math.inf, 0.0, math.inf, "s"), "got inf"),
        (InvalidInputError("pressure", 200000, "less", "Pa"), "got 200000 Pa"),
        (InvalidInputError("pressures", [1.0, 2], "less", "Pa"), "got 1 Pa, 2 Pa"),
    ],
)
def test_a_value_has_its_unit_and_is_never_shown_as_the_bound_that_it_is_past(error, shown) -> None:
    assert re.search(shown, str(error))
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
