# SPDX-License-Identifier: Apache-2.0
"""Charts of grips, sections and calibrations: what is drawn is what was computed."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import QuadMesh

from spiral_core import (
    CalibrationModel,
    ExtensionReading,
    FreeActuation,
    InvalidInputError,
    NeoHookean,
    WrapCurve,
    calibrate,
    pressure_uncertainty,
)
from spiral_core.grip.grip import GripCase, GripOutcome
from spiral_gripper import display_units, load_description, plot
from spiral_gripper.bench.residual_plot import pressure_figure
from spiral_gripper.cli.main import run
from spiral_gripper.reports.grip.plots import MOST_PANELS, window_figure
from spiral_gripper.reports.plots import section_figure

HELD = GripOutcome("", 5.7e4, 5.5e4, 6.2e4, 8.7e4, 5.9e4, 0.15, 0.3, 0.22, 0.1)


@pytest.fixture(scope="module")
def description():
    return load_description("paper_design_70")


@pytest.fixture(scope="module")
def fit(description):
    truth = replace(description.actuator, material=NeoHookean(c1=1.5e5))
    stretch = FreeActuation(truth).stretch_from_pressure
    noise = np.random.default_rng(3).normal(size=6)
    readings = [
        ExtensionReading(p, 0.1 * (stretch(p) - 1.0) + 2e-4 * e, 0.1, 2e-4)
        for p, e in zip(np.linspace(1e4, 6e4, 6).tolist(), noise.tolist(), strict=True)
    ]
    return calibrate(CalibrationModel(truth, gripper=description.gripper), readings)


def test_the_band_is_the_interval_of_the_calibration(fit):
    figure = pressure_figure(fit, "mine", 0.95)
    (axes,) = figure.axes
    band = next(area for area in axes.collections if area.get_hatch())
    corners = band.get_paths()[0].vertices
    radius = corners[:, 0].min()
    (one,) = pressure_uncertainty(fit, [1e-3 * radius], 0.95)
    drawn = sorted({round(p, 6) for r, p in corners.tolist() if r == radius})
    assert drawn == pytest.approx([1e-3 * end for end in one.interval], rel=1e-6)
    curve = WrapCurve(fit.gripper)
    assert 1e-3 * one.pressure == pytest.approx(1e-3 * curve.pressure_from_radius(1e-3 * radius))


def test_without_a_gripper_there_is_no_band(fit):
    alone = replace(fit, model=replace(fit.model, gripper=None))
    assert pressure_figure(alone, "mine", 0.95) is None


def test_a_calibration_has_a_picture(fit):
    residuals = plot(fit).axes[1].get_lines()[1].get_ydata()
    assert residuals == pytest.approx(fit.residuals)


def test_a_section_is_stretched_away_from_the_straight_fiber(description):
    figure = section_figure(description.actuator, [0.0, 6e4], "mine")
    rest, pressed = (
        np.ravel(
            next(one for one in axes.collections if isinstance(one, QuadMesh)).get_array().data
        )
        for axes in figure.axes[:2]
    )
    assert rest == pytest.approx(1.0)
    assert pressed.argmin() in (0, 180, 181, 361)  # the fiber's angle, on both walls
    stretch = FreeActuation(description.actuator).stretch_from_pressure(6e4)
    assert pressed[:180].mean() == pytest.approx(stretch, rel=1e-6)


def test_windows_are_drawn_over_the_radius_in_the_units_wanted(description):
    cases = [GripCase(description.gripper, r, 0.3) for r in (0.02, 0.01, 0.03)]
    refused = GripOutcome("too thick")
    with display_units("psi", "in"):
        (axes,) = window_figure(cases, [HELD, replace(HELD, loss=None), refused]).axes
    recommended = next(line for line in axes.get_lines() if line.get_label() == "recommended")
    radii, pressures = recommended.get_xydata().T
    assert radii == pytest.approx(np.array([0.01, 0.02, 0.03]) / 0.0254)
    assert pressures[:2] == pytest.approx(5.9e4 / 6894.757293)
    assert np.isnan(pressures[2])
    assert axes.get_ylabel() == "pressure [psi]"


def test_more_panels_than_a_page_holds_are_refused(description):
    cases = [GripCase(description.gripper, 0.02, 0.1 * k) for k in range(MOST_PANELS + 1)]
    with pytest.raises(InvalidInputError, match="at most 3 panels"):
        window_figure(cases, [HELD] * len(cases))


def test_the_section_on_the_command_line(tmp_path, capsys):
    picture = tmp_path / "section.png"
    asked = ["chart", "section", "paper_design_70", "--plot", str(picture)]
    assert run([*asked, "--pressure", "5 kPa", "--pressure", "6 psi"]) == 0
    assert picture.stat().st_size > 10_000
    assert run([*asked, *["--pressure", "5 kPa"] * 4]) == 2
    assert "up to three times" in capsys.readouterr().err
