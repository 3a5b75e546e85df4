# SPDX-License-Identifier: Apache-2.0
"""The studio's controls: sliders in the units that are shown, read as settings in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable

import viser

from spiral_core import FreeActuation, Gripper
from spiral_gripper.files.shown import axis_label, in_present_units, in_units, scale_of
from spiral_gripper.studio.settings import Settings

Slider = viser.GuiSliderHandle[float]
# A slider has so many steps or more, up to ten times as many.
STEPS = 300


class Controls:
    """Sliders for everything that may change while one looks.

    Args:
        gui: where they are put.
        settings: what they show at first.
        gripper: bounds the pressure; fibers and length of a measured one are fixed.
        on_change: called after any of them was moved.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        settings: Settings,
        gripper: Gripper,
        on_change: Callable[[], None],
    ) -> None:
        self._gui = gui
        self._gravity = settings.gravity
        measured = not isinstance(gripper.actuation, FreeActuation)
        self._quiet = False
        turn = math.pi
        folders = {
            "Object and pressure": (
                ("pressure", "pressure", "Pa", 0.0, gripper.pressure_max),
                ("object_radius", "object radius", "m", 2e-3, 0.08),
                ("taper", "object taper", "rad", -turn / 9.0, turn / 9.0),
                ("friction", "friction", "1", 0.0, 1.5),
                ("rate", "closing rate", "Pa/s", 1e3, 2e5),
            ),
            "Gripper": (
                ("alpha", "fiber angle α", "rad", -turn / 2.0, turn / 2.0),
                ("beta", "fiber angle β", "rad", -turn / 2.0, turn / 2.0),
                ("length", "length", "m", 0.02, 2.0),
            ),
            "Mount": (
                ("tilt", "tilt from hanging", "rad", 0.0, turn),
                ("roll", "roll", "rad", -turn, turn),
            ),
        }
        angles = dict(zip(("alpha", "beta"), settings.angles, strict=False))
        # By the name of the setting: the slider, and the SI unit of what it shows.
        self._sliders: dict[str, tuple[Slider, str]] = {}
        for folder, sliders in folders.items():
            with gui.add_folder(folder):
                for name, label, unit, low, high in sliders:
                    if name in ("alpha", "beta") and name not in angles:
                        continue
                    value = angles[name] if name in angles else getattr(settings, name)
                    slider = self._quantity(label, unit, low, high, value)
                    slider.disabled = measured and folder == "Gripper"
                    self._sliders[name] = slider, unit
        self.pressure = self._sliders["pressure"][0]
        changed = in_present_units(lambda _: None if self._quiet else on_change())
        for slider, _ in self._sliders.values():
            slider.on_update(changed)

    def settings(self) -> Settings:
        """Return what the sliders say."""
        values = {
            name: s.value / scale_of(unit).factor for name, (s, unit) in self._sliders.items()
        }
        angles = tuple(values.pop(name) for name in ("alpha", "beta") if name in values)
        return Settings(angles=angles, gravity=self._gravity, **values)

    def set_pressure(self, pressure: float, pressure_max: float) -> None:
        """Show a pressure, and the largest there is [Pa], without calling anybody."""
        self._quiet = True
        top, value = (float(in_units(each, "Pa")) for each in (pressure_max, pressure))
        self.pressure.max = _rounded(top, self.pressure.step)
        self.pressure.value = _rounded(value, self.pressure.step)  # type: ignore[misc]  # viser hides its setter
        self._quiet = False

    def remove(self) -> None:
        """Take the sliders off the page."""
        for slider, _ in self._sliders.values():
            slider.remove()

    def _quantity(self, name: str, unit: str, low: float, high: float, value: float) -> Slider:
        """Return a slider in the unit shown; its ends and its value are in SI."""
        least, most, first = in_units([low, high, value], unit).tolist()
        step = 10.0 ** math.floor(math.log10(max(abs(least), abs(most)) / STEPS))
        ends = min(_rounded(least, step), first), max(_rounded(most, step), first)
        label = name if unit == "1" else axis_label(name, unit)
        return self._gui.add_slider(label, *ends, step, first)


def _rounded(value: float, step: float) -> float:
    """Return a multiple of a step, a power of ten, next to a value."""
    return round(value, max(0, round(-math.log10(step))))
