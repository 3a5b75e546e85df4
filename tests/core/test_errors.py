# SPDX-License-Identifier: Apache-2.0
"""Every error carries its figures, says them in one line, and travels between processes."""

import pickle
from enum import Enum
from math import pi

import pytest
from core.recorded import recorded

from spiral_core.errors import (
    ActuationLimit,
    ActuationLimitError,
    InvalidInputError,
    NoCoilError,
    NotGrippableError,
    SolverError,
)
from spiral_core.message import Message, Quantity
from spiral_core.validation import require_in_range

END, HALF = ActuationLimit.DATA_END, 0.5 * pi


class Status(Enum):
    STALLED = "the line search stalled; use fewer elements"


def refused(*arguments):
    with pytest.raises(InvalidInputError) as caught:
        require_in_range(*arguments)
    return caught.value


# Two that are past a bound never show the bound itself; a coil that closed, or an actuator that
# ends, is no reason to ask for more pressure; the nearest radius is rounded into the range.
EXAMPLES = [
    InvalidInputError("positions", "a\n" * 500, "3 finite numbers"),
    refused("pressure", 55000.0001, 0.0, 55e3, "Pa"),
    refused("alpha", 1.5707964, -HALF, HALF, "rad"),
    ActuationLimitError(END, "pressure", 150000.04, 150000.01),
    ActuationLimitError(ActuationLimit.FIBER_LOCKING, "stretch", 2.1, 2.0),
    SolverError(Status.STALLED, 3.0e-4, 17),
    NoCoilError(1.04999, 1.05, 5.0e4),
    NoCoilError(7.0, 10.0, 5e4, 6e4),
    NoCoilError(0.0, 1.05, 5e4, 1e3),
    NoCoilError(0.4, 1.05, 5e4, at_actuator_limit=True),
    *(NotGrippableError(radius, "no", -1.0, 0.01234565) for radius in (0.05, 0.005)),
]


def test_message_is_one_line_and_travels_with_its_figures():
    for error in EXAMPLES:
        copy = pickle.loads(pickle.dumps(error))
        assert (type(copy), vars(copy), str(copy)) == (type(error), vars(error), str(error))
        assert "\n" not in str(error)
    recorded("errors/said", {f"{k}": str(error) for k, error in enumerate(EXAMPLES)})


def test_a_message_keeps_its_quantities_wherever_it_travels():
    reason = Message("above {}", Quantity(1.0e5, "Pa"))
    said = str(pickle.loads(pickle.dumps(NotGrippableError(0.05, reason, -0.004, 0.01234567))))
    assert said.told(lambda q: q.text(1.0e3, f"milli{q.unit}", 3)) == (
        "an object of radius 50 millim cannot be gripped: above 1e+08 milliPa; "
        "the nearest grippable radius is 12.3 millim"
    )
