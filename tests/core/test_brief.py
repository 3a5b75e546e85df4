# SPDX-License-Identifier: Apache-2.0
"""Values are shown on a few lines, with what they hold."""

from dataclasses import dataclass, field

import numpy as np

from spiral_core import (
    Rod,
    RodLoad,
    RodStatus,
    Section,
    solve_rod,
)
from spiral_core.brief import brief_repr

STATE = solve_rod(
    Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(0.0, 0.0, 5.0)), RodLoad()
)


@dataclass
class Held:
    """Every kind of field."""

    numbers: tuple
    text: str
    status: RodStatus
    small: float
    state: object
    hidden: int = field(default=3, repr=False)
    _private: int = 4

    __repr__ = brief_repr


def test_each_kind_of_field_is_short() -> None:
    held = Held((1.0, 2.5), "a name", RodStatus.CONVERGED, 1.0 / 3.0, STATE)
    assert repr(held) == (
        "Held(numbers=(1, 2.5), text='a name', status=CONVERGED, small=0.333333, state=<RodState>)"
    )
    many = Held((STATE, STATE), "x" * 500, RodStatus.CONVERGED, np.inf, np.zeros((9, 3)))
    assert "numbers=<2 of RodState>" in repr(many)
    assert "small=inf, state=<array (9, 3)>" in repr(many)
    assert len(repr(many)) < 200
    assert "numbers=(1,)" in repr(Held((1.0,), "", RodStatus.CONVERGED, 0.0, None))
    assert "numbers=<9 of int>" in repr(Held((0,) * 9, "", RodStatus.CONVERGED, 0.0, None))
