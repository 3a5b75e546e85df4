# SPDX-License-Identifier: Apache-2.0
"""The studio's page: the gripper in the middle; controls, answers and exports beside it."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import viser

from spiral_core import SpiralError
from spiral_gripper.files.catalog import available_grippers
from spiral_gripper.files.description import load_description
from spiral_gripper.studio.chart import AXES, SERIES, chart_data, chart_scales
from spiral_gripper.studio.controls import Controls
from spiral_gripper.studio.exports import FORMATS
from spiral_gripper.studio.scene import COLORINGS, Scene
from spiral_gripper.studio.session import Answer, Session
from spiral_gripper.studio.settings import settings_of
from spiral_gripper.studio.words import answer_text

# The approach takes this long, in so many frames a second.
APPROACH_SECONDS = 4.0
FRAMES_PER_SECOND = 30
START_RADIUS = 0.02  # of the object [m]


class Page:
    """One gripper on one page, shared by everybody who opens it.

    Args:
        server: serves the page.
        gripper: the name of a shipped gripper, or the path of a description file.

    Raises:
        DescriptionError: the file cannot be used.
    """

    def __init__(self, server: viser.ViserServer, gripper: str) -> None:
        self._server = server
        self._scene = Scene(server)
        self._lock = threading.RLock()  # controls and answers call from several threads
        self._playing = threading.Event()
        gui = server.gui
        gui.configure_theme(dark_mode=False, show_logo=False, show_share_button=False)
        names = tuple(dict.fromkeys((gripper, *available_grippers())))
        self._name = gui.add_dropdown("gripper", names, initial_value=gripper)
        self._words = gui.add_markdown("")
        self._to_wrap = gui.add_button("Set the wrap pressure")
        self._play = gui.add_button("Play the approach")
        self._chart = gui.add_uplot(
            chart_data(None, START_RADIUS, 0.0),
            SERIES,
            axes=AXES,
            scales=chart_scales(None, 1e5),
            legend={"show": False},
            aspect=1.5,
        )
        self._coloring = gui.add_dropdown("color", COLORINGS)
        self._export = gui.add_button_group("export", (*FORMATS, "html"))
        self._controls: Controls | None = None
        self._session: Session | None = None
        self._load(gripper)
        self._name.on_update(lambda _: self._load(self._name.value))
        self._coloring.on_update(lambda _: self._refresh())
        self._to_wrap.on_click(lambda _: self._set_wrap_pressure())
        self._play.on_click(lambda _: self._approach())
        self._export.on_click(lambda _: self._hand_out(self._export.value))

    def close(self) -> None:
        """End what runs in the background."""
        self._playing.clear()
        if self._session is not None:
            self._session.close()

    def _load(self, gripper: str) -> None:
        """Show another gripper, as its file describes it."""
        with self._lock:
            description = load_description(gripper)
            settings = settings_of(description, START_RADIUS)
            if self._controls is not None and self._session is not None:
                self._controls.remove()
                self._session.close()
            self._session = Session(description, settings, self._on_answer)
            self._controls = Controls(
                self._server.gui, settings, self._session.gripper, self._changed
            )
            self._scene.look_at_gripper(settings.length)
            self._refresh()

    def _changed(self) -> None:
        """Follow the sliders; where there is no such gripper, say why and keep the last one."""
        with self._lock:
            if self._session is None or self._controls is None:
                return
            try:
                self._session.update(self._controls.settings())
            except SpiralError as error:
                self._words.content = f"**There is no such gripper.** {error}"
                return
            self._refresh()

    def _on_answer(self, answer: Answer) -> None:
        """Show an answer unless the controls have moved on."""
        with self._lock:
            session = self._session
            if session is not None and session.answer is answer and session.current:
                self._scene.show_object(answer.placement)
                self._refresh()

    def _refresh(self) -> None:
        """Draw the shape at the settings, and say what is known of them."""
        with self._lock:
            session, controls = self._session, self._controls
            if session is None or controls is None:
                return
            settings, gripper = session.settings, session.gripper
            controls.set_pressure(settings.pressure, gripper.pressure_max)
            answer = session.answer if session.current else None
            try:
                state = session.shape()
            except SpiralError as error:
                self._words.content = f"**No shape.** {error}"
                return
            self._scene.show_gripper(state, gripper.tube.outer_radius, self._coloring.value)
            self._scene.show_gravity(settings.gravity_vector)
            self._words.content = answer_text(answer, settings, state)
            self._chart.scales = chart_scales(answer, gripper.pressure_max)
            self._chart.data = chart_data(answer, settings.object_radius, settings.pressure)

    def _wrap_pressure(self) -> float | None:
        """Return the pressure of the perfect wrap [Pa], where it is known."""
        session = self._session
        if session is None or not session.current or session.answer is None:
            return None
        wrap = session.answer.wrap
        return None if wrap is None else wrap.pressure

    def _set_pressure(self, pressure: float) -> None:
        """Show the shape at a pressure [Pa]."""
        with self._lock:
            if self._session is not None:
                self._session.update(replace(self._session.settings, pressure=pressure))
                self._refresh()

    def _set_wrap_pressure(self) -> None:
        """Go to the wrap, where there is one."""
        pressure = self._wrap_pressure()
        if pressure is not None:
            self._set_pressure(pressure)

    def _approach(self) -> None:
        """Raise the pressure from nothing to the wrap; a second click stops it."""
        pressure = self._wrap_pressure()
        if self._playing.is_set() or pressure is None:
            self._playing.clear()
            return
        self._playing.set()
        start = time.monotonic()
        while self._playing.is_set():
            share = min(1.0, (time.monotonic() - start) / APPROACH_SECONDS)
            self._set_pressure(share * pressure)
            if share == 1.0:
                break
            time.sleep(1.0 / FRAMES_PER_SECOND)
        self._playing.clear()

    def _hand_out(self, kind: str) -> None:
        """Send the shape, or the whole scene, as a file to those who look."""
        with self._lock:
            if self._session is None:
                return
            name = f"{self._session.gripper.name}.{kind}"
            if kind == "html":
                content = self._server.scene.as_html().encode()
            else:
                gripper = self._session.gripper
                content = FORMATS[kind](self._session.shape(), gripper.tube.outer_radius)
            self._server.send_file_download(name, content, save_immediately=True)
