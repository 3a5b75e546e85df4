# SPDX-License-Identifier: Apache-2.0
"""The function ``plot``, which draws any result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure

from spiral_core import Grip, Gripper, Wrap, WrapCurve, regime_chart
from spiral_core.calibration.fit import Calibration
from spiral_core.design.charts import RegimeChart
from spiral_core.design.report import DesignReport
from spiral_core.design.sweep import FeasibilityMap
from spiral_core.errors import InvalidInputError
from spiral_core.grip.closing import TimedClosing
from spiral_core.wrap.placement import place_object
from spiral_gripper.bench.residual_plot import residual_figure
from spiral_gripper.files.shown import shown
from spiral_gripper.reports.closing.plots import close_figure
from spiral_gripper.reports.grip.plots import grip_figure
from spiral_gripper.reports.plots import design_figure, feasibility_figure, regime_figure
from spiral_gripper.reports.shaded import tube_surface
from spiral_gripper.reports.shape_plots import shape_figure

# A curve's chart begins at this fraction of the largest radius.
_SMALLEST = 0.25


def plot(result: object) -> Figure:
    """Return a picture of a result, units on its axes; ``figure.savefig`` writes it.

    Args:
        result: a Grip (force against pressure, the coil on its object), a Wrap (the free coil from
            two sides), a WrapCurve or a RegimeChart (pressure against radius), a Gripper (its
            WrapCurve), a DesignReport, a FeasibilityMap, a Calibration (readings and residuals), or
            a TimedClosing (contact, pressure and speed against time).

    Raises:
        InvalidInputError: there is no picture of a value of this kind.

    Example:
        >>> from spiral_core import WrapCurve
        >>> from spiral_gripper import load_gripper
        >>> figure = plot(WrapCurve(load_gripper("paper_design_70")))
        >>> figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()
        ('object radius [mm]', 'pressure [kPa]')
    """
    for kind, draw in _PICTURES.items():
        if isinstance(result, kind):
            return draw(result)
    known = ", ".join(kind.__name__ for kind in _PICTURES)
    raise InvalidInputError("result", type(result).__name__, f"one of {known}")


def _wrap(wrap: Wrap) -> Figure:
    title = f"{shown(wrap.object_radius, 'm')} at {shown(wrap.pressure, 'Pa')}"
    tube = tube_surface(wrap.state.positions, wrap.outer_radius)
    return shape_figure([tube], title, place_object(wrap))


def _curve(curve: WrapCurve) -> Figure:
    smallest = max(curve.radius_min, _SMALLEST * curve.radius_max)
    return regime_figure(regime_chart(curve, smallest, curve.radius_max), curve.gripper.name)


_PICTURES: dict[type, Callable[[Any], Figure]] = {
    Grip: lambda grip: grip_figure(grip, grip.setup.gripper.name),
    Wrap: _wrap,
    WrapCurve: _curve,
    Gripper: lambda gripper: _curve(WrapCurve(gripper)),
    RegimeChart: lambda chart: regime_figure(chart, "pressure against radius"),
    Calibration: lambda fit: residual_figure(fit, fit.gripper.name if fit.gripper else "readings"),
    TimedClosing: close_figure,
    DesignReport: design_figure,
    FeasibilityMap: feasibility_figure,
}
