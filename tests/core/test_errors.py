# SPDX-License-Identifier: Apache-2.0
"""Every error carries its figures, says them in one line, and travels between processes."""

import pickle
import re
from enum import Enum
from math import pi

import pytest

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


# Errors, and patterns of their messages; two that are past a bound never show the bound itself.
EXAMPLES = [
    (InvalidInputError("positions", "a\n" * 500, "3 finite numbers"), r"^.{,180}\.\.\.$"),
    (refused("pressure", 55000.0001, 0.0, 55e3, "Pa"), "55000 Pa, got 55000.1 Pa"),
    (refused("alpha", 1.5707964, -HALF, HALF, "rad"), "90 deg, got 90.0001 deg"),
    (ActuationLimitError(END, "pressure", 150000.04, 150000.01), "150001 Pa .* 150000 Pa"),
    (
        ActuationLimitError(ActuationLimit.FIBER_LOCKING, "stretch", 2.1, 2.0),
        "^stretch 2.1 is past its limit 2: a fiber family",
    ),
    (SolverError(Status.STALLED, 3.0e-4, 17), r"elements \(residual 0.0003, 17 iterations\)$"),
    (
        NoCoilError(1.04999, 1.05, 5.0e4),
        r"makes 1.04 turns at most \(at 50000 Pa\).*raise the pressure limit",
    ),
    # A coil that closed, or an actuator that ends, is no reason to ask for more pressure.
    (NoCoilError(7.0, 10.0, 5e4, 6e4), "^(?!.*raise).* at 60000 Pa the coil has closed on itself"),
    (NoCoilError(0.0, 1.05, 5e4, 1e3), "no pressure up to 50000 Pa leaves room for an object"),
    (NoCoilError(0.4, 1.05, 5e4, at_actuator_limit=True), "^(?!.*raise)"),
    # The nearest radius is rounded into the range.
    (NotGrippableError(0.05, "no", -1.0, 0.01234565), "nearest grippable radius is 0.0123456 m"),
    (NotGrippableError(0.005, "no", -1.0, 0.01234565), "nearest grippable radius is 0.0123457 m"),
]


def test_message_is_one_line_and_travels_with_its_figures():
    for error, shown in EXAMPLES:
        copy = pickle.loads(pickle.dumps(error))
        assert (type(copy), vars(copy), str(copy)) == (type(error), vars(error), str(error))
        assert re.search(shown, str(error))
        assert "\n" not in str(error)


def test_a_message_keeps_its_quantities_wherever_it_travels():
    reason = Message("above {}", Quantity(1.0e5, "Pa"))
    said = str(pickle.loads(pickle.dumps(NotGrippableError(0.05, reason, -0.004, 0.01234567))))
    assert said.told(lambda q: q.text(1.0e3, f"milli{q.unit}", 3)) == (
        "an object of radius 50 millim cannot be gripped: above 1e+08 milliPa; "
        "the nearest grippable radius is 12.3 millim"
    )
