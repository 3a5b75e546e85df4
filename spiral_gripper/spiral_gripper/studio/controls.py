# SPDX-License-Identifier: Apache-2.0
"""The studio's controls: sliders in the units of the bench, read as settings in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable

import viser

from spiral_core import FreeActuation, Gripper
from spiral_gripper.studio.settings import Settings

Slider = viser.GuiSliderHandle[float]


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
            top = round(1e-3 * gripper.pressure_max, 1)
            self.pressure = self._slider("pressure [kPa]", 0.0, top, 0.1, 1e-3 * settings.pressure)
            self._radius = self._slider(
                "object radius [mm]", 2.0, 80.0, 0.1, 1e3 * settings.object_radius
            )
            self._taper = self._angle("object taper [deg]", settings.taper, -20.0, 20.0)
            self._friction = self._slider("friction", 0.0, 1.5, 0.05, settings.friction)
        with gui.add_folder("Gripper"):
            self._angles = tuple(
                self._angle(f"fiber angle {name} [deg]", angle, -90.0, 90.0)
                for name, angle in zip("αβ", settings.angles, strict=False)
            )
            self._length = self._slider("length [mm]", 20.0, 2000.0, 1.0, 1e3 * settings.length)
            for slider in (*self._angles, self._length):
                slider.disabled = measured
        with gui.add_folder("Mount"):
            self._tilt = self._angle("tilt from hanging [deg]", settings.tilt, 0.0, 180.0)
            self._roll = self._angle("roll [deg]", settings.roll, -180.0, 180.0)
        for slider in self._sliders:
            slider.on_update(lambda _: None if self._quiet else on_change())

    @property
    def _sliders(self) -> tuple[Slider, ...]:
        return (
            self.pressure, self._radius, self._taper, self._friction, *self._angles, self._length,
            self._tilt, self._roll,
        )  # fmt: skip

    def settings(self) -> Settings:
        """Return what the sliders say."""
        return Settings(
            pressure=1e3 * self.pressure.value,
            object_radius=1e-3 * self._radius.value,
            angles=tuple(math.radians(slider.value) for slider in self._angles),
            length=1e-3 * self._length.value,
            tilt=math.radians(self._tilt.value),
            roll=math.radians(self._roll.value),
            gravity=self._gravity,
            friction=self._friction.value,
            taper=math.radians(self._taper.value),
        )

    def set_pressure(self, pressure: float, pressure_max: float) -> None:
        """Show a pressure, and the largest there is [Pa], without calling anybody."""
        self._quiet = True
        self.pressure.max = round(1e-3 * pressure_max, 1)
        self.pressure.value = round(1e-3 * pressure, 1)  # type: ignore[misc]  # viser hides its setter
        self._quiet = False

    def remove(self) -> None:
        """Take the sliders off the page."""
        for slider in self._sliders:
            slider.remove()

    def _angle(self, label: str, value: float, low: float, high: float) -> Slider:
        return self._slider(label, low, high, 0.5, math.degrees(value))

    def _slider(self, label: str, low: float, high: float, step: float, value: float) -> Slider:
        """Return a slider whose range holds its first value."""
        return self._gui.add_slider(label, min(low, value), max(high, value), step, value)
