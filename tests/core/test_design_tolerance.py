# SPDX-License-Identifier: Apache-2.0
"""How far an object may be shifted, as a limit of a design."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from types import SimpleNamespace

import numpy as np
import pytest
from core.design_cases import PAPER_EXAMPLE
from core.gripper_cases import paper_gripper
from core.recorded import recorded
from numpy.testing import assert_allclose

from spiral_core import InvalidInputError, SpiralError, design_gripper, lay_into_coil
from spiral_core.design import closing
from spiral_core.design.margin import Constraint, Margin
from spiral_core.grip import capture
from spiral_core.grip.capture import CaptureOutcome, close_misplaced, safe_shift
from spiral_core.grip.grip import recommended_grip
from spiral_core.grip.window import WindowEnd

SHIFTED = replace(
    PAPER_EXAMPLE, object_length=None, fiber_angles_beta=(radians(60.0),), tolerance=5e-3
)
ONE = replace(SHIFTED, radius_min=0.02, radius_max=0.02)


@pytest.mark.parametrize(
    ("region", "size", "aim"),
    [
        # A disc of 9 mm: its middle to half a step, what is left from there to a quarter.
        (lambda x, y: np.hypot(x - 6e-3, y + 3e-3) <= 9.1e-3, 7.5e-3, (6.25e-3, -2.5e-3)),
        # A strip away from the base, open across; one across, with a hole farther out.
        (lambda x, y: -1e-3 <= x <= 13e-3, 6.25e-3, (6.25e-3, 0.0)),
        (lambda x, y: abs(y) <= 6e-3 and not 4.9e-3 < x < 5.1e-3, 5e-3, (-6.25e-3, 0.0)),
        (lambda x, y: True, 10e-3, (0.0, 0.0)),
        (lambda x, y: x or y, 0.0, (0.0, 0.0)),
    ],
)
def test_a_shift_counts_from_the_middle_of_what_is_safe(region, size, aim, monkeypatch):
    def close(_, pressure, off, payload):
        assert (pressure, payload, *off[2:]) == (40e3, 0.02, 0.0, 0.0, 0.0)
        outcome = CaptureOutcome.HOLDS if region(*off[:2]) else CaptureOutcome.PASSES_BY
        return SimpleNamespace(outcome=outcome)

    monkeypatch.setattr(capture, "close_misplaced", close)
    setup = lay_into_coil(paper_gripper("70 degrees"), 0.02)
    found, middle = safe_shift(setup, 40e3, 0.02, 5e-3)
    assert_allclose((found, *middle), (size, *aim), atol=1e-12)


@pytest.mark.parametrize("safe", [0.0, 3e-3, "none"])
def test_what_is_not_safe_enough_is_not_feasible(safe, monkeypatch):
    def recommended(*_):
        if safe == "none":
            raise SpiralError(safe)
        return SimpleNamespace(pressure=4e4)

    monkeypatch.setattr(closing, "safe_shift", lambda *_: (safe, (1e-3, 2e-3)))
    monkeypatch.setattr(closing, "recommended_grip", recommended)
    told = []
    report = design_gripper(ONE, lambda *call: told.append(call))
    recorded(f"design/shift {safe}", [report.steps[-1], report.binding, report.outlook])
    assert all(done < total for done, total, _ in told)


def test_only_what_is_wrapped_is_shifted(monkeypatch):
    """What binds is that it is not wrapped; without contact there is no tolerance."""
    monkeypatch.setattr(
        closing,
        "grip_window",
        lambda *_, **__: SimpleNamespace(onset_wrap=None, end=WindowEnd.LOST),
    )
    monkeypatch.setattr(closing, "find_place", lambda _: None)
    monkeypatch.setattr(closing, "safe_shift", None)
    report = design_gripper(ONE)
    assert report.binding == Margin(Constraint.WRAPPED, 0.0, 1.0)
    with pytest.raises(InvalidInputError, match="contact"):
        design_gripper(ONE, contact=False)


@pytest.mark.slow
def test_shifts_within_the_safe_one_hold_on_twice_the_elements():
    """Seven in eight directions about the aim."""
    report = design_gripper(SHIFTED)
    assert report.feasible
    rng = np.random.default_rng(8)
    for one in report.tried[0].closed:
        setup = lay_into_coil(report.design.gripper, min(one.radius, report.design.radius_max))
        pressure = recommended_grip(setup).pressure
        assert 5e-3 <= one.safe_shift <= 10e-3
        for angle, size in zip(
            rng.uniform(0.0, 2.0 * np.pi, 7), rng.uniform(0.2, 0.9, 7), strict=True
        ):
            x, y = np.array(one.aim) + size * one.safe_shift * np.array(
                (np.cos(angle), np.sin(angle))
            )
            closed = close_misplaced(setup, pressure, (x, y, 0.0, 0.0, 0.0), elements=180)
            assert closed.outcome is CaptureOutcome.HOLDS
