# SPDX-License-Identifier: Apache-2.0
"""Figures in the units that the reader chose, wherever they are printed or drawn."""

from contextlib import suppress
from types import SimpleNamespace

import pytest

from spiral_core import InvalidInputError
from spiral_core.design.margin import Constraint, Margin
from spiral_core.message import Message, Quantity
from spiral_gripper import display_units
from spiral_gripper.files.shown import number, shown, shown_message, shown_range
from spiral_gripper.reports.tables import margin_rows


def test_units_made_of_others_follow_the_chosen_ones_until_the_end_of_the_block():
    with suppress(ZeroDivisionError), display_units("lbf", "in", "psi", "rad"):
        for value, unit in (
            (6894.757293, "Pa/s"),
            (4.4482216 * 0.0254, "N m"),
            (4.4482216 / 0.0254, "N/m"),
            (4.4482216 * 0.0254**2, "N m^2"),
        ):
            assert shown(value, unit).split()[0] == "1"
        assert shown_range(0.0254, 0.0508) == "1 in to 2 in"
        raise ZeroDivisionError
    assert (shown(0.5, "N m"), shown(500.0, "N/m")) == ("500 N mm", "0.5 N/mm")
    assert shown_range(0.012341, 0.023459) == "12.35 mm to 23.45 mm"  # within
    assert (number(2e5, "Pa"), shown(2.0, "m"), shown(0.9, "m")) == ("200", "2 m", "900 mm")


def test_a_message_is_shown_part_by_part_and_other_text_as_it_is():
    limit = Message("at most {}", Quantity(6894.757, "Pa"))
    text = Message("tube of {}; {}", "10 mm x 1 mm", limit)
    assert str(text) == "tube of 10 mm x 1 mm; at most 6894.76 Pa"
    with display_units("psi", "in"):
        assert shown_message(text) == "tube of 10 mm x 1 mm; at most 1 psi"


@pytest.mark.parametrize("units", [("psi", "kPa"), ("",), ("g/m",), ("%",), ("MM",)])
def test_what_is_no_unit_of_these_is_refused(units):
    with pytest.raises(InvalidInputError, match="units must be"), display_units(*units):
        pass


def test_a_margin_that_rounds_to_nothing_has_no_minus():
    met = Margin(Constraint.TURNS, 1.05 - 1e-12, 1.05)
    assert met.sentence.endswith("(met, +0.0 %)")
    assert margin_rows(SimpleNamespace(margins=(met,)))[0][-1] == "+0.0 %"
