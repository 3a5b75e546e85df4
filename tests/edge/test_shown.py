# SPDX-License-Identifier: Apache-2.0
"""Figures in the units that the reader chose, wherever they are printed or drawn."""

import json
import re
from contextlib import suppress
from types import SimpleNamespace

import pytest

from spiral_core import InvalidInputError
from spiral_core.design.margin import Constraint, Margin
from spiral_core.message import Message, Quantity
from spiral_gripper import display_units
from spiral_gripper.files.shown import number, shown, shown_message, shown_range
from spiral_gripper.reports.tables import margin_rows

WRAP = ["wrap", "paper_design_70", "--radius", "20 mm"]
DESIGN = ["design", "--radius-min", "12 mm", "--radius-max", "25 mm", "--tube", "9.5 mm x 0.8 mm"]


def test_units_made_of_others_follow_the_chosen_ones_until_the_end_of_the_block():
    with suppress(ZeroDivisionError), display_units("lbf", "in", "psi", "rad"):
        assert shown(6894.757293, "Pa/s") == "1 psi/s"
        assert shown(4.4482216 * 0.0254, "N m") == "1 lbf in"
        assert shown(4.4482216 / 0.0254, "N/m") == "1 lbf/in"
        assert shown(4.4482216 * 0.0254**2, "N m^2") == "1 lbf in^2"
        assert shown(1.5, "rad") == "1.5 rad"
        assert shown_range(0.0254, 0.0508) == "1 in to 2 in"
        raise ZeroDivisionError
    assert (shown(0.5, "N m"), shown(500.0, "N/m")) == ("500 N mm", "0.5 N/mm")
    assert (number(2e5, "Pa"), shown(2.0, "m"), shown(0.9, "m")) == ("200", "2 m", "900 mm")


def test_a_message_is_shown_part_by_part_and_other_text_as_it_is():
    limit = Message("at most {}", Quantity(6894.757, "Pa"))
    text = Message("tube of {}; {}; {}", "10 mm x 1 mm", Quantity(0.254, "m"), limit)
    assert str(text) == "tube of 10 mm x 1 mm; 0.254 m; at most 6894.76 Pa"
    with display_units("psi", "in"):
        assert shown_message(text) == "tube of 10 mm x 1 mm; 10 in; at most 1 psi"
        assert shown_message("254 mm") == "254 mm"


@pytest.mark.parametrize("units", [("psi", "kPa"), ("furlong",), ("",), ("g/m",), ("%",), ("MM",)])
def test_what_is_no_unit_of_these_is_refused(units):
    with pytest.raises(InvalidInputError, match="units must be"), display_units(*units):
        pass


def test_a_command_prints_in_the_chosen_units_and_forgets_them(said):
    assert "8.274 psi" in said(*WRAP, "--units", "psi, in")
    document = json.loads(said(*WRAP, "--json", "--units", "psi,in"))
    assert document["pressure"] == pytest.approx(55.47e3, rel=1e-3)  # as the table has it
    refused = said(*WRAP[:-1], "60 mm", "--units", "in", code=2)
    assert "the nearest grippable radius is 1.489 in" in refused
    refused = said(*WRAP, "--units", "psi,furlong", code=2)
    assert "pressure: kPa, psi, bar" in refused.partition("got 'furlong'")[0]
    assert "kPa" in said("shape", "prototype_p1", "--pressure", "8 kPa")


NOT_MET = r"not feasible: .*[\d.]+ psi, .*at most 2\.90\d* psi"


@pytest.mark.parametrize(
    ("arguments", "code", "verdict"),
    [
        (DESIGN, 0, r"feasible: .* length [\d.]+ in, [\d.]+ psi to [\d.]+ psi"),
        ([*DESIGN, "--pressure-max", "20 kPa"], 1, NOT_MET),
        ([*WRAP[:-1], "0.8 in", "--pressure", "8 psi"], 0, "0.8 in"),
        (["winding-sheet", "prototype_p1"], 0, "in"),
    ],
)
def test_no_usual_unit_is_left_where_all_are_chosen(said, arguments, code, verdict):
    printed = said(*arguments, "--units", "psi,in,rad,lbf,oz", code=code)
    assert re.search(verdict, printed)
    named = printed.replace("9.5 mm x 0.8 mm", "")  # the tube's name, as it was typed
    assert re.findall(r"\d (?:mm|m|kPa|Pa|deg|N|N mm|kg)\b", named) == []


def test_a_margin_that_rounds_to_nothing_has_no_minus():
    met = Margin(Constraint.TURNS, 1.05 - 1e-12, 1.05)
    assert met.sentence.endswith("(met, +0.0 %)")
    assert margin_rows(SimpleNamespace(margins=(met,))) == [
        ("turns", "1.05", "at least 1.05", "+0.0 %")
    ]
    assert Margin(Constraint.TURNS, 1.0, 1.05).sentence.endswith("(violated, -4.8 %)")
