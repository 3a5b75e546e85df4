"""Drift of logged grips: what is suggested, and that nothing is suggested without need."""

import math

import numpy as np
import pytest
from core.calibration_cases import LAWS, spiral

from spiral_core import (
    DriftKind,
    GripRecord,
    InvalidInputError,
    WrapCurve,
    gripper_from_actuator,
    suggest_drift_correction,
)

RADII = (0.011, 0.014, 0.017, 0.02, 0.024, 0.028, 0.031)


@pytest.fixture(scope="module")
def curve():
    gripper = gripper_from_actuator("g", spiral(LAWS[0]), density=950.0, pressure_max=110.0e3)
    return WrapCurve(gripper)


def log(curve, change, noise=0.0, seed=1):
    """Return a log of grips whose pressures were changed by a function."""
    generator = np.random.default_rng(seed)
    return [
        GripRecord(r, change(curve.pressure_from_radius(r)) + noise * generator.standard_normal())
        for r in RADII
    ]


def test_a_softened_gripper_shows_as_a_factor(curve):
    found = suggest_drift_correction(curve, log(curve, lambda p: 0.92 * p, noise=300.0))
    assert found.kind is DriftKind.FACTOR
    assert found.interval.low < 0.92 < found.interval.high < 1.0
    assert found.scatter_after < 0.2 * found.scatter_before
    assert "calibrate again" in str(found)


def test_a_shifted_sensor_shows_as_an_offset(curve):
    found = suggest_drift_correction(curve, log(curve, lambda p: p + 4.0e3, noise=300.0))
    assert found.kind is DriftKind.OFFSET
    assert found.interval.low < 4.0e3 < found.interval.high
    assert found.scatter_after == pytest.approx(300.0, rel=0.5)


def test_a_log_without_drift_suggests_nothing_in_most_cases(curve):
    found = [
        suggest_drift_correction(curve, log(curve, lambda p: p, noise=500.0, seed=seed)).kind
        for seed in range(300)
    ]
    # At most 5 % by construction; 300 logs scatter by 1.3 %.
    assert found.count(DriftKind.NONE) >= 0.91 * len(found)


def test_nothing_is_changed(curve):
    before = curve.pressure_from_radius(0.02)
    records = log(curve, lambda p: 0.8 * p)
    copy = list(records)
    found = suggest_drift_correction(curve, records)
    assert found.correction == pytest.approx(0.8)
    assert records == copy
    assert curve.pressure_from_radius(0.02) == before


def test_radii_out_of_range_are_named_and_not_used(curve):
    found = suggest_drift_correction(
        curve, [*log(curve, lambda p: 0.9 * p), GripRecord(0.5, 5.0e4)]
    )
    assert found.not_grippable == (0.5,)
    assert found.correction == pytest.approx(0.9)


def test_too_few_grips_are_refused(curve):
    records = [*log(curve, lambda p: p)[:3], GripRecord(0.5, 5.0e4)]
    with pytest.raises(InvalidInputError, match="at least 4"):
        suggest_drift_correction(curve, records)
    for values in ((0.0, 1.0e4), (0.02, 0.0), (math.nan, 1.0e4), (0.02, math.inf)):
        with pytest.raises(InvalidInputError):
            GripRecord(*values)
