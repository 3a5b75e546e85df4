# SPDX-License-Identifier: Apache-2.0
"""Draw the figures of docs/derivations/section.md. Run by ``make figures``."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from spiral_core import (
    Actuator,
    CurvatureForm,
    FiberAngles,
    InvalidInputError,
    MooneyRivlin,
    SingleFiber,
    Tube,
    stiffness_from_actuator,
)
from spiral_core.actuator.actuation import FreeActuation, section_stiffness
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.section import FiberSet, motion_at, section_path

FIGURES = Path(__file__).parent / "figures"
TUBE = Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.5)
LATEX = MooneyRivlin(c1=130.0e3, c2=15.0e3)
COLORS = {50: "#0072B2", 60: "#009E73", 70: "#D55E00", -88: "#555555"}
STRETCH = 1.1
ALPHA = 88.0


def actuator(beta: float, gamma: float = 0.0) -> Actuator:
    """Return an actuator with alpha = 88 degrees; angles in degrees."""
    return Actuator(
        TUBE,
        FiberAngles(math.radians(ALPHA), math.radians(beta)),
        LATEX,
        curvature_form=CurvatureForm.EXACT,
        single_fibers=(SingleFiber(math.radians(gamma)),),
    )


def draw_strains(stretches: Axes, energies: Axes) -> None:
    """Draw the axial stretch and the energy around the section of three actuators."""
    angles = (np.arange(24) + 0.5) * 180.0 / 24
    for beta in (50, 60, 70):
        path = section_path(actuator(beta).fiber_set)
        motion = motion_at(path.fibers, np.array([path.strain_from_stretch(STRETCH)]))
        ring = motion.ring
        axial = 1.0 + ring.stretch_change - ring.bend * np.cos(np.radians(angles))
        label = f"β = {beta}°"
        stretches.plot(angles, axial, color=COLORS[beta], label=label)
        density = LATEX.c1 * motion.first[0] + LATEX.c2 * motion.second[0]
        energies.plot(angles, density * 1e-3, color=COLORS[beta], label=label)
    for axes, name in ((stretches, "axial stretch"), (energies, "energy density [kJ/m³]")):
        axes.set(xlabel="angle from the straight fiber [deg]", ylabel=name)
        axes.grid(alpha=0.3)
    stretches.legend(frameon=False)


def energy_shares(beta: float, stretch: float) -> tuple[float, float, float]:
    """Return the shares of stretch, twist and bending in the wall's energy.

    Stretch is the energy of the wall stretched evenly, its shear left out; twist is what the shear
    adds to that; bending is what the section's uneven strains add to both.
    """
    bent = actuator(beta)
    even = bent.without_single_fibers().fiber_set

    def energy(fibers: FiberSet) -> float:
        far = section_path(fibers).strain_from_stretch(stretch)
        motion = motion_at(fibers, np.array([far]))
        density = LATEX.c1 * motion.first[0] + LATEX.c2 * motion.second[0]
        return float((density * motion.share[0]).sum())

    whole, sheared = energy(bent.fiber_set), energy(even)
    stretched = energy(replace(even, twist_shear=False))
    return stretched / whole, (sheared - stretched) / whole, (whole - sheared) / whole


def draw_energy_shares(stacked: Axes, lines: Axes) -> None:
    """Draw the shares over the stretch: all of them at 60 degrees, bending and twist at three."""
    stretches = np.linspace(1.005, 1.25, 50)
    shares = np.array([energy_shares(60.0, float(x)) for x in stretches]).T
    stacked.stackplot(
        stretches,
        100.0 * shares,
        labels=("stretch", "twist", "bending"),
        colors=("#7ba7b4", "#e3a857", "#c8553d"),
    )
    stacked.set(ylabel="share of the energy [%], β = 60°", xlim=(1.005, 1.25), ylim=(0.0, 100.0))
    stacked.legend(frameon=True, loc="lower right")
    for beta in (50, 60, 70):
        _, twist, bending = 100.0 * np.array([energy_shares(beta, float(x)) for x in stretches]).T
        lines.plot(stretches, bending, color=COLORS[beta], label=f"bending, β = {beta}°")
        lines.plot(stretches, twist, "--", color=COLORS[beta], label=f"twist, β = {beta}°")
    lines.set(ylabel="share of the energy [%]", ylim=(0.0, 55.0))
    lines.legend(frameon=False, ncols=2, loc="upper center")
    for axes in (stacked, lines):
        axes.set(xlabel="mean axial stretch")
        axes.grid(alpha=0.3)


def draw_single_fiber(curvatures: Axes, torsions: Axes) -> None:
    """Draw curvature and torsion over the single fiber's angle, at one stretch."""
    for beta in (50, 60, 70, -88):
        angles, shapes = [], []
        for gamma in np.arange(-45.0, 45.1, 2.5).tolist():
            try:
                shape = unloaded_shape_from_stretch(actuator(beta, gamma), STRETCH)
            except InvalidInputError:  # parallel to the family
                continue
            angles.append(gamma)
            shapes.append(shape)
        scale = TUBE.inner_radius
        label = f"β = {beta}°"
        curvatures.plot(
            angles, [s.curvature * scale for s in shapes], color=COLORS[beta], label=label
        )
        torsions.plot(angles, [s.torsion * scale for s in shapes], color=COLORS[beta], label=label)
    curvatures.set(xlabel="angle γ of the single fiber [deg]", ylabel="curvature × radius")
    torsions.set(xlabel="angle γ of the single fiber [deg]", ylabel="torsion × radius")
    for axes in (curvatures, torsions):
        axes.grid(alpha=0.3)
    curvatures.legend(frameon=False)


def draw_stiffness(bends: Axes, twists: Axes) -> None:
    """Draw the section's stiffness over pressure, next to the annulus' EI and GJ."""
    pressures = np.linspace(0.0, 110.0e3, 45)
    for beta in (50, 60, 70):
        section = actuator(beta)
        annulus, actuation = stiffness_from_actuator(section), FreeActuation(section)
        found = [section_stiffness(actuation, float(p)) for p in pressures]
        for axes, name, unit, line in (
            (bends, "bending", annulus.bending, "-"),
            (bends, "sideways", annulus.bending, "--"),
            (twists, "torsional", annulus.torsional, "-"),
        ):
            values = [getattr(stiffness, name) / unit for stiffness in found]
            label = f"{'sideways' if name == 'sideways' else 'in plane'}, β = {beta}°"
            axes.plot(pressures * 1e-3, values, line, color=COLORS[beta], label=label)
    bends.set(ylabel="bending stiffness / EI", ylim=(0.0, 7.5))
    bends.legend(frameon=False, ncols=2, loc="upper center")
    twists.set(ylabel="torsional stiffness / GJ", ylim=(0.0, None))
    for axes in (bends, twists):
        axes.axhline(1.0, color="#555555", linewidth=1.0, linestyle=":")
        axes.set(xlabel="pressure [kPa]")
        axes.grid(alpha=0.3)
    twists.annotate("annulus", (2.0, 1.4), color="#555555")


def main() -> None:
    """Write section_strains, energy_shares, single_fiber and section_stiffness (.png)."""
    mpl.use("Agg")
    FIGURES.mkdir(exist_ok=True)
    for name, draw in (
        ("section_strains", draw_strains),
        ("energy_shares", draw_energy_shares),
        ("single_fiber", draw_single_fiber),
        ("section_stiffness", draw_stiffness),
    ):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained")
        draw(left, right)
        figure.savefig(FIGURES / f"{name}.png", dpi=110)


if __name__ == "__main__":
    main()
