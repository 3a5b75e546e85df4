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
        with gui.add_folder("Object and pressure"):
            top = gripper.pressure_max
            self.pressure = self._quantity("pressure", "Pa", 0.0, top, settings.pressure)
            self._radius = self._quantity("object radius", "m", 2e-3, 0.08, settings.object_radius)
            self._taper = self._angle("object taper", settings.taper, -20.0, 20.0)
            self._friction = self._slider("friction", 0.0, 1.5, 0.05, settings.friction)
            self._rate = self._quantity("closing rate", "Pa/s", 1e3, 2e5, settings.rate)
        with gui.add_folder("Gripper"):
            self._angles = tuple(
                self._angle(f"fiber angle {name}", angle, -90.0, 90.0)
                for name, angle in zip("αβ", settings.angles, strict=False)
            )
            self._length = self._quantity("length", "m", 0.02, 2.0, settings.length)
            for slider in (*self._angles, self._length):
                slider.disabled = measured
        with gui.add_folder("Mount"):
            self._tilt = self._angle("tilt from hanging", settings.tilt, 0.0, 180.0)
            self._roll = self._angle("roll", settings.roll, -180.0, 180.0)
        changed = in_present_units(lambda _: None if self._quiet else on_change())
        for slider in self._sliders:
            slider.on_update(changed)

    @property
    def _sliders(self) -> tuple[Slider, ...]:
        return (
            self.pressure, self._radius, self._taper, self._friction, self._rate, *self._angles,
            self._length, self._tilt, self._roll,
        )  # fmt: skip

    def settings(self) -> Settings:
        """Return what the sliders say."""
        return Settings(
            pressure=self._si(self.pressure, "Pa"),
            object_radius=self._si(self._radius, "m"),
            angles=tuple(self._si(slider, "rad") for slider in self._angles),
            length=self._si(self._length, "m"),
            tilt=self._si(self._tilt, "rad"),
            roll=self._si(self._roll, "rad"),
            gravity=self._gravity,
            friction=self._friction.value,
            taper=self._si(self._taper, "rad"),
            rate=self._si(self._rate, "Pa/s"),
        )

    def set_pressure(self, pressure: float, pressure_max: float) -> None:
        """Show a pressure, and the largest there is [Pa], without calling anybody."""
        self._quiet = True
        top, value = (float(in_units(each, "Pa")) for each in (pressure_max, pressure))
        self.pressure.max = _rounded(top, self.pressure.step)
        self.pressure.value = _rounded(value, self.pressure.step)  # type: ignore[misc]  # viser hides its setter
        self._quiet = False

    def remove(self) -> None:
        """Take the sliders off the page."""
        for slider in self._sliders:
            slider.remove()

    def _angle(self, name: str, value: float, low: float, high: float) -> Slider:
        """Return a slider of an angle [rad]; its ends are in degrees."""
        return self._quantity(name, "rad", math.radians(low), math.radians(high), value)

    def _quantity(self, name: str, unit: str, low: float, high: float, value: float) -> Slider:
        """Return a slider in the unit shown; its ends and its value are in SI."""
        least, most, first = in_units([low, high, value], unit).tolist()
        step = 10.0 ** math.floor(math.log10(max(abs(least), abs(most)) / STEPS))
        ends = _rounded(least, step), _rounded(most, step)
        return self._slider(axis_label(name, unit), *ends, step, first)

    def _si(self, slider: Slider, unit: str) -> float:
        """Return what a slider says in SI."""
        return slider.value / scale_of(unit).factor

    def _slider(self, label: str, low: float, high: float, step: float, value: float) -> Slider:
        """Return a slider whose range holds its first value."""
        return self._gui.add_slider(label, min(low, value), max(high, value), step, value)


def _rounded(value: float, step: float) -> float:
    """Return a multiple of a step, a power of ten, next to a value."""
    return round(value, max(0, round(-math.log10(step))))
