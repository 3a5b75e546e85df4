# SPDX-License-Identifier: Apache-2.0
"""Draw figures of the derivations of actuator, wrap, rod, motion. Run by ``make figures``."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from spiral_core import (
    Actuator,
    Damping,
    FiberAngles,
    FreeActuation,
    Gripper,
    PressureCourse,
    RodLoad,
    RodProblem,
    WrapCurve,
    close_on,
    lay_into_coil,
    regime_chart,
    solve_motion,
    solve_rod,
)
from spiral_core.grip.closing import inertia_of
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.motion.inertia import UNDAMPED
from spiral_core.wrap.placement import place_object
from spiral_gripper import load_description
from spiral_gripper.reports.style import (
    COLORS,
    CURLING_COLOR,
    DPI,
    OVERHANG_COLOR,
    color_of,
    panels,
    paper_style,
)

FIGURES = Path(__file__).parent / "figures"
BETAS = (50.0, 60.0, 70.0)  # [deg]
OBJECT_RADIUS = 0.02  # [m]
PRESSURE, HIGHEST = 60e3, 150e3  # [Pa]
ELEMENTS = (8, 12, 16, 24, 32, 48, 64, 96)
FINEST = 512
SWING_TIME = 3.0  # [s]
RATES = (20e3, 60e3, 200e3)  # [Pa/s]


def actuator_figure(actuator: Actuator) -> Figure:
    """Return pressure against stretch, and curvature and torsion against pressure.

    Args:
        actuator: whose tube and elastomer are taken, with the angle beta varied.
    """
    figure, (left, right) = panels(2)
    for number, beta in enumerate(BETAS):
        fibers = FiberAngles(actuator.fiber_pair.alpha, math.radians(beta))
        actuation = FreeActuation(replace(actuator, fibers=fibers))
        pressures = np.linspace(0.0, HIGHEST, 80)
        shapes = [actuation.unloaded_shape(float(pressure)) for pressure in pressures]
        color, label = color_of(number), f"β = {beta:.0f}°"
        stretches = [shape.stretch for shape in shapes]
        left.plot(stretches, 1e-3 * pressures, color=color, label=label)
        right.plot(1e-3 * pressures, [shape.curvature for shape in shapes], color=color)
        torsions = [abs(shape.torsion) for shape in shapes]
        right.plot(1e-3 * pressures, torsions, "--", color=color)
    left.set(xlabel="stretch λ₁", ylabel="pressure [kPa]")
    right.set(xlabel="pressure [kPa]", ylabel="curvature (—), |torsion| (- -) [1/m]")
    left.legend()
    return figure


def wrap_figure(gripper: Gripper) -> Figure:
    """Return the tangent's angle to the axis along a wrap, and the pressures of the regimes."""
    figure, (left, right) = panels(2)
    curve, light = WrapCurve(gripper), WrapCurve(gripper.with_mount((0.0, 0.0, 0.0), None))
    hanging = curve.wrap_for_radius(OBJECT_RADIUS)
    weightless = light.wrap_for_radius(light.radius_from_pressure(hanging.pressure))
    styles = (("-", "hanging"), ("--", "gravity zero"))
    for (style, label), wrap in zip(styles, (hanging, weightless), strict=True):
        positions, arcs = wrap.state.positions, wrap.state.arc_lengths
        tangents = np.diff(positions, axis=0) / np.diff(arcs)[:, None]
        angles = np.degrees(np.arccos(np.clip(tangents @ place_object(wrap).axis, -1.0, 1.0)))
        along = 0.5e3 * (arcs[1:] + arcs[:-1])
        left.plot(along, angles, style, color=COLORS[0], label=label)
        left.plot(along[-1], angles[-1], "o", ms=4, color=COLORS[2])
    left.set(xlabel="along the tube [mm]", ylabel="tangent to axis, θ [deg]")
    left.legend()
    chart = regime_chart(curve, 0.3 * curve.radius_max, curve.radius_max)
    radii = 1e3 * chart.radius
    tip, top = 1e-3 * chart.tip, 1.2e-3 * chart.tip.max()
    right.fill_between(radii, 0.0, tip, color=OVERHANG_COLOR, alpha=0.5, lw=0.0)
    right.fill_between(radii, tip, top, color=CURLING_COLOR, alpha=0.5, lw=0.0)
    right.plot(radii, tip, color=COLORS[0], label="perfect wrap, hanging")
    inside = [r for r in chart.radius if light.radius_min < r < light.radius_max]
    pressures = [1e-3 * light.pressure_from_radius(float(r)) for r in inside]
    right.plot(1e3 * np.array(inside), pressures, "--", color=COLORS[0], label="gravity zero")
    for x, y, text in ((0.25, 0.25, "overhang"), (0.75, 0.75, "curling")):
        right.text(x, y, text, transform=right.transAxes, ha="center")
    right.set(xlabel="object radius [mm]", ylabel="pressure [kPa]", ylim=(0.0, top))
    right.legend(loc="upper right")
    return figure


def rod_figure(gripper: Gripper) -> Figure:
    """Return a coil with and without its weight, and the tip's error against the elements."""
    figure, (left, right) = panels(2)
    shape = gripper.unloaded_shape(PRESSURE)
    rod, load = gripper.rod(shape), gripper.load(shape)
    styles = (("-", COLORS[0], "hanging"), ("--", COLORS[2], "gravity zero"))
    for (style, color, label), pulls in zip(styles, (load, RodLoad()), strict=True):
        state = solve_rod(rod, pulls)
        y, x = 1e3 * state.positions[:, 1], -1e3 * state.positions[:, 0]
        left.plot(y, x, style, color=color, label=label)
    left.set(xlabel="y [mm]", ylabel="-x, upwards [mm]")
    left.set_aspect("equal", adjustable="datalim")
    left.legend()
    _draw_errors(right, gripper)
    return figure


def _draw_errors(axes: Axes, gripper: Gripper) -> None:
    """Draw the tip's error against the number of elements, and what is estimated for it."""
    shape = gripper.unloaded_shape(PRESSURE)
    rod, load = gripper.rod(shape), gripper.load(shape)
    exact = solve_rod(rod, load, elements=FINEST, estimate_error=False).tip_position
    errors, counts = [], []
    for count in ELEMENTS:
        state = solve_rod(rod, load, elements=count, estimate_error=False, throw=False)
        if state.stable:
            counts.append(count)
            errors.append(float(np.linalg.norm(state.tip_position - exact)) / rod.length)
    axes.loglog(counts, errors, "o-", ms=3, color=COLORS[0], label="tip")
    slope = errors[-1] * (np.array(counts) / counts[-1]) ** -4.0
    axes.loglog(counts, slope, ":", color=COLORS[2], label="fourth order")
    axes.set(xlabel="elements N", ylabel="error / length")
    axes.legend()


def motion_figure(gripper: Gripper) -> Figure:
    """Return a tube that swings, with three dampings, and closings at three rates."""
    figure, (left, right) = panels(2)
    setup = lay_into_coil(gripper, OBJECT_RADIUS)
    problem = setup.closing_problem(0.0)
    hanging = RodProblem(problem.rod, problem.load)
    pulled = replace(hanging, load=replace(hanging.load, tip_force=(0.0, 0.02, 0.0)))
    start = solve_contact(pulled, elements=setup.element_count)
    times = np.linspace(0.0, SWING_TIME, 151)
    dampings = (
        (UNDAMPED, ":", "undamped"),
        (Damping(retardation_time=0.016), "-", "T = 16 ms"),
        (Damping(retardation_time=0.05), "--", "T = 50 ms"),
    )
    for number, (damping, style, label) in enumerate(dampings):
        motion = solve_motion(
            lambda _: hanging, inertia_of(gripper), times.tolist(), damping=damping, start=start
        )
        tips = [1e3 * frame.state.positions[-1, 1] for frame in motion.frames]
        left.plot(motion.times, tips, style, color=color_of(number), label=label)
    left.set(xlabel="time [s]", ylabel="y of the tip [mm]")
    left.set_ylim(-180.0, 240.0)
    left.legend(loc="upper center", ncols=3, columnspacing=1.0, handlelength=1.4)
    pressure = 1.15 * float(setup.tip_pressure or PRESSURE)
    for number, rate in enumerate(RATES):
        closing = close_on(setup, PressureCourse.ramp(rate, pressure, 1.0))
        at = [min(closing.course.at(frame.time), pressure) for frame in closing.frames]
        share = [100.0 * part for part in closing.contact_fractions]
        label = f"{1e-3 * rate:.0f} kPa/s"
        right.plot(1e-3 * np.array(at), share, color=color_of(number), label=label)
    right.set(xlabel="pressure [kPa]", ylabel="in contact [% of the tube]")
    right.legend(title="pressure rises at")
    return figure


def main() -> None:
    """Write the figures into docs/figures."""
    described = load_description("paper_design_70")
    with paper_style():
        figures = {
            "actuator": actuator_figure(described.actuator),
            "wrap": wrap_figure(described.gripper),
            "rod": rod_figure(described.gripper),
            "motion": motion_figure(described.gripper),
        }
        for name, figure in figures.items():
            figure.savefig(FIGURES / f"{name}.png", dpi=DPI // 2)


if __name__ == "__main__":
    main()
