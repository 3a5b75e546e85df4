# SPDX-License-Identifier: Apache-2.0
"""The option ``--sensitivity``: what every input changes, against the commands' own answers."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from edge.recorded import cases
from numpy.testing import assert_allclose

from spiral_core.grip.window import (
    DIFFERENCE_TOLERANCE,
    PRESSURE_TOLERANCE,
    grip_window,
)
from spiral_core.wrap.curve import WrapCurve
from spiral_gripper.cli import workers
from spiral_gripper.files.description import load_description, parse_description
from spiral_gripper.reports.grip import sensitivity
from spiral_gripper.reports.grip.document import GripQuestion, setup_of
from spiral_gripper.reports.grip.sensitivity import (
    GRIP,
    METHODS,
    Sensitivity,
    Varied,
    solve_sensitivity,
)

RADIUS = 0.02
DESCRIPTION = load_description("paper_design_70")
QUESTION = GripQuestion(DESCRIPTION.gripper, RADIUS, None)


def edited(old, new):
    """Return the description of a file in which a text was replaced."""
    text = DESCRIPTION.source.read_text("utf-8").replace(old, new)
    return parse_description(text, DESCRIPTION.source)


def varied(description):
    """Return what every input changes of the tip criterion."""
    question = replace(QUESTION, gripper=description.gripper)
    with ThreadPoolExecutor(1) as pool:
        asked = (question, description, None, 0.0, pool)
        return solve_sensitivity(METHODS["tip"], *asked, progress=lambda *_: None)


def test_changes_of_the_tip_criterion_are_the_commands_answers():
    every = varied(DESCRIPTION)
    found = {each.input.name: each for each in every.inputs}
    base, thicker = every.base["pressure"], edited("thickness: 0.794 mm", "thickness: 0.894 mm")
    for pressure, description, radius in (
        (base, DESCRIPTION, RADIUS),
        (found["object's radius"].more["pressure"], DESCRIPTION, RADIUS + 1e-3),
        (found["wall"].more["pressure"], thicker, RADIUS),
        (found["c1"].more["pressure"], edited("130 kPa", "143 kPa"), RADIUS),
    ):
        curve = WrapCurve(description.gripper)
        assert_allclose(pressure, curve.pressure_from_radius(radius), 1e-9)
    sizes = [each.size(every.base, "pressure") for each in every.inputs]
    assert sizes == sorted(sizes, reverse=True)
    # The energy is linear in the constants and the weight: all of them by a tenth is the pressure.
    factors = [found[name] for name in ("c1", "c2", "gravity or mass")]
    tenths = sum(each.changes(every.base, "pressure")[1] for each in factors)
    assert_allclose(tenths, 0.1 * base, 2e-3)  # of second order in the changes


def test_an_input_without_such_a_gripper_comes_first():
    """A family at 89.5 degrees cannot be at 90.5."""
    every = varied(edited("alpha: 88 deg", "alpha: 89.5 deg"))
    first = every.inputs[0]
    assert (first.input.name, first.more) == ("fiber angle alpha", {})
    assert next(every.table().columns[1].cells).endswith("/ none")


def test_a_pressure_is_not_raised_above_the_limit_and_what_is_unknown_is_no_loss():
    setup, limit = setup_of(QUESTION)[0], QUESTION.gripper.pressure_max
    changes = []
    for pressure in (0.0, 0.5 * limit, 0.97 * limit, limit):
        *_, last = sensitivity.inputs_of(GRIP, QUESTION, DESCRIPTION, setup, pressure)
        if last.name == "pressure":
            changes.append([side[1] / pressure - 1.0 for side in (last.less, last.more)])
            assert last.more[1] <= limit
    assert_allclose(changes, [(-0.05, 0.05), (1.0 - 1.0 / 0.97, 1.0 / 0.97 - 1.0)])
    base = dict.fromkeys(GRIP.columns, 2.0)
    unknown = Sensitivity(last, base | {GRIP.ranked: math.nan}, base | {GRIP.ranked: 2.5})
    lost = Sensitivity(last, base | {GRIP.ranked: None}, {})
    assert (unknown.size(base, GRIP.ranked), lost.size(base, GRIP.ranked)) == (0.5, math.inf)
    cells = Varied(GRIP, base, (unknown, lost)).table().columns[1].cells
    assert list(cells) == ["? / +25", "none / none"]


def test_an_onset_is_sharp_enough_to_be_compared():
    """To 1e-5: a radius 1e-4 thinner raises it by what one 1e-2 thinner raises it, over 100."""
    onset, *thinner = (
        METHODS["wrap"].solve(replace(QUESTION, radius=share * RADIUS), 0.0)["onset_wrap"]
        for share in (1.0, 0.9999, 0.99)
    )
    rise, rise_of_more = (each - onset for each in thinner)
    assert_allclose(rise, 0.01 * rise_of_more, 0, 2 * DIFFERENCE_TOLERANCE * onset)
    window = grip_window(setup_of(QUESTION)[0], until_wrapped=True)
    assert_allclose(window.onset_wrap, onset, PRESSURE_TOLERANCE)


@pytest.mark.long
def test_commands_print_what_inputs_change(recorded, monkeypatch):
    """Friction and pressure of a grip."""
    every, wanted = sensitivity.inputs_of, {"friction", "pressure"}
    few = lambda *asked: (each for each in every(*asked) if each.name in wanted)  # noqa: E731
    monkeypatch.setattr(sensitivity, "inputs_of", few)
    monkeypatch.setattr(workers, "process_pool", lambda _: ThreadPoolExecutor(1))
    (asked,) = cases("sensitivity.txt")
    recorded("sensitivity.txt", asked)
