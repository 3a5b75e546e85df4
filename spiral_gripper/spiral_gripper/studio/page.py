# SPDX-License-Identifier: Apache-2.0
"""The studio's page: the gripper in the middle; controls, answers and exports beside it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import takewhile
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import viser

from spiral_core import RodState, SpiralError
from spiral_core.rod.motion.motion import Frame
from spiral_gripper.files.catalog import available_grippers
from spiral_gripper.files.description import (
    GripperDescription,
    load_description,
    parse_description,
)
from spiral_gripper.files.shown import axis_label, in_present_units, shown
from spiral_gripper.studio.charts import (
    PALE,
    RED,
    add_chart,
    chart_data,
    chart_scales,
    force_data,
    force_scales,
    update_chart,
)
from spiral_gripper.studio.controls import Controls
from spiral_gripper.studio.exports import EXPORTS, png
from spiral_gripper.studio.files import FileFolder
from spiral_gripper.studio.pull import FRAMES, pull_frames
from spiral_gripper.studio.scene import COLORINGS, FAINT, OPAQUE, Scene, node_values
from spiral_gripper.studio.session import Answer, Session
from spiral_gripper.studio.settings import settings_of
from spiral_gripper.studio.words import answer_text, closing_line, frame_text, holds, plain

# The approach takes this long, in so many frames a second.
APPROACH_SECONDS = 4.0
FRAMES_PER_SECOND = 30
PULL_SECONDS = 3.0
START_RADIUS = 0.02  # of the object [m]
PNG_WIDTH, PNG_HEIGHT = 1600, 1200


class StoppedError(Exception):
    """What was played is to show no more."""


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
        self._folder = TemporaryDirectory(prefix="studio_")  # of the file that is edited
        gui, shows = server.gui, in_present_units  # events come in threads of their own

        def on(act: Callable[[], None]) -> Callable[[object], None]:
            return shows(lambda _: act())

        gui.configure_theme(dark_mode=False, show_logo=False, show_share_button=False)
        names = tuple(dict.fromkeys((gripper, *available_grippers())))
        name = gui.add_dropdown("gripper", names, initial_value=gripper)
        self._words = gui.add_markdown("")
        for label, play in (
            ("Set the wrap pressure", self._set_wrap_pressure),
            ("Play the approach", partial(self._play, self._approach)),
            ("Play the closing in real time", partial(self._play, self._close_in_time)),
            ("Play the pull", partial(self._play, self._pull_away)),
        ):
            gui.add_button(label).on_click(on(play))
        radius, pressure = axis_label("object radius", "m"), axis_label("pressure", "Pa")
        self._chart = add_chart(gui, radius, pressure, {"tip criterion": RED})
        pulls = {"away from the base": RED, "towards the base": PALE}
        self._forces = add_chart(gui, pressure, axis_label("holding force", "N"), pulls)
        self._coloring = gui.add_dropdown("color", COLORINGS)
        export = gui.add_button_group("export", (*EXPORTS, "html", "png"))
        self._file = FileFolder(gui, shows(self._load_text))
        self._begin(load_description(gripper))
        self._coloring.on_update(on(self._refresh))
        export.on_click(shows(lambda event: self._hand_out(export.value, event.client)))
        choose = partial(self._file.attempt, lambda: self._show(load_description(name.value)))
        name.on_update(on(choose))

    def tick(self) -> None:
        """Update the time for which an answer has been computed; to be called regularly."""
        with self._lock:
            session = self._session
            if session.waited is None or self._playing.is_set() or self._impossible:
                return
            with suppress(SpiralError):  # the page says already that there is no shape
                self._words.content = self._said(session, session.shape())

    def _said(self, session: Session, state: RodState) -> str:
        """Return what is known of the shape that is shown."""
        settings = session.settings
        text = answer_text(session.known, settings, session.gripper, state, session.waited)
        closing = session.closing
        return f"{text}\n\n{closing_line(closing, settings.rate)}" if closing else text

    def close(self) -> None:
        """End what runs in the background."""
        self._playing.clear()
        self._session.close()
        self._folder.cleanup()

    def _load_text(self, text: str) -> None:
        """Show the gripper of an edited or a loaded file.

        Raises:
            DescriptionError: it cannot be used.
        """
        path = Path(self._folder.name) / "edited.yaml"
        description = parse_description(text, path)  # else the file stays that of what is shown
        path.write_text(text, encoding="utf-8")
        self._show(description)

    def _show(self, description: GripperDescription) -> None:
        """Show a gripper in place of the present one."""
        with self._lock:
            self._playing.clear()
            self._controls.remove()
            self._session.close()
            self._begin(description)

    def _begin(self, description: GripperDescription) -> None:
        """Show a gripper as its file describes it."""
        with self._lock:
            self._file.show(description)
            self._impossible = ""
            settings = settings_of(description, START_RADIUS)
            self._session = Session(description, settings, in_present_units(self._on_answer))
            gripper = self._session.gripper
            self._controls = Controls(self._server.gui, settings, gripper, self._changed)
            self._scene.look_at_gripper(settings.length)
            self._scene.show_mount(gripper.tube.outer_radius)
            self._refresh()

    def _changed(self) -> None:
        """Follow the sliders; where there is no such gripper, say why and keep the last one."""
        with self._lock:
            try:
                self._session.update(self._controls.settings())
                self._impossible = ""
            except SpiralError as error:
                self._impossible = f"**There is no such gripper.** {plain(error)}"
            self._refresh()

    def _on_answer(self, answer: Answer) -> None:
        """Show an answer unless the settings have changed since."""
        with self._lock:
            if self._session.known is answer:
                self._refresh()

    def _refresh(self) -> None:
        """Draw the shape at the settings, and say what is known of them, where they can be."""
        with self._lock:
            if self._impossible:
                self._words.content = self._impossible
                return
            session = self._session
            settings, gripper, answer = session.settings, session.gripper, session.known
            self._controls.set_pressure(settings.pressure, gripper.pressure_max)
            try:
                state = session.shape()
            except SpiralError as error:
                self._words.content = f"**No shape.** {plain(error)}"
                return
            self._draw(session, state, answer)
            self._words.content = self._said(session, state)
            most = gripper.pressure_max
            update_chart(self._chart, chart_data(answer, settings), chart_scales(answer, most))
            forces = force_data(answer, settings.pressure)
            update_chart(self._forces, forces, force_scales(answer, most))

    def _draw(self, session: Session, state: RodState, answer: Answer | None) -> None:
        """Draw the coil in contact with a ghost of the free one; where there is none, the free."""
        gripper, settings = session.gripper, session.settings
        point, outer = session.contact(), session.gripper.tube.outer_radius
        shown = state if point is None else point.state
        pressure = settings.pressure if point is None else point.pressure
        values = node_values(gripper, pressure, shown, self._coloring.value)
        self._scene.show_gripper(shown.positions, outer, values)
        self._scene.show_ghost(None if point is None else state.positions, outer)
        self._scene.show_gravity(settings.gravity_vector)
        opacity = FAINT if point is None else OPAQUE
        place = None if answer is None else answer.object_place()
        self._scene.show_object(place, opacity=opacity, taper=settings.taper)

    def _wrap_pressure(self) -> float | None:
        """Return the tip criterion's pressure [Pa], where it is known."""
        answer = self._session.known
        return None if answer is None or answer.wrap is None else answer.wrap.pressure

    def _set_pressure(self, pressure: float) -> None:
        """Show the shape at a pressure [Pa]."""
        with self._lock:
            self._session.update(replace(self._session.settings, pressure=pressure))
            self._refresh()

    def _set_wrap_pressure(self) -> None:
        """Go to the wrap, where there is one."""
        pressure = self._wrap_pressure()
        if pressure is not None and not self._impossible:
            self._set_pressure(pressure)

    def _play(self, show: Callable[[], None]) -> None:
        """Show something that takes its time; a second click stops it."""
        if self._playing.is_set():
            self._playing.clear()
            return
        if self._impossible:
            return
        self._playing.set()
        try:
            show()
        except SpiralError as error:
            self._words.content = f"**Not played.** {plain(error)}"
        except StoppedError:
            self._refresh()
        finally:
            self._playing.clear()

    def _goes_on(self, _: object = None) -> bool:
        """Return whether what is played has not been stopped."""
        return self._playing.is_set()

    def _approach(self) -> None:
        """Raise the pressure from nothing to the wrap."""
        pressure, start = self._wrap_pressure(), time.monotonic()
        while pressure is not None and self._goes_on():
            share = min(1.0, (time.monotonic() - start) / APPROACH_SECONDS)
            self._set_pressure(share * pressure)
            if share == 1.0:
                break
            time.sleep(1.0 / FRAMES_PER_SECOND)

    def _close_in_time(self) -> None:
        """Compute the closing at the rate that is set and show it in real time."""
        session = self._session

        def moved(done: int, total: int) -> None:
            known = session.known is not None and session is self._session
            if not (self._goes_on() and known):
                raise StoppedError
            self._words.content = f"**computing the closing ...** {100.0 * done / total:.0f} %"

        closing = session.close_in_time(moved)
        if closing is None:
            return
        outer = closing.setup.gripper.tube.outer_radius
        self._scene.show_ghost(None, outer)
        for frame in takewhile(self._goes_on, in_time(closing.frames)):
            with self._lock:
                self._scene.show_gripper(frame.state.positions, outer, None)
                self._words.content = frame_text(frame, closing.course.at(frame.time))
        if self._goes_on():
            time.sleep(PULL_SECONDS / 2.0)
        with self._lock:
            if session is self._session:  # else another gripper is shown by now
                self._set_pressure(closing.course.pressures[-1])
            self._refresh()

    def _pull_away(self) -> None:
        """Move the object out of the coil, away from the base."""
        session = self._session
        answer = session.known
        if answer is None or answer.grip is None:
            return
        place, outer = answer.object_place(), session.gripper.tube.outer_radius
        taper, pressure = session.settings.taper, session.settings.pressure
        if not holds(answer, pressure):
            self._words.content = f"**Nothing holds the object at {shown(pressure, 'Pa')}.**"
            time.sleep(PULL_SECONDS / 2.0)
            self._refresh()
            return
        frames = pull_frames(answer.grip, pressure)
        nearest = answer.grip.pressures[np.argmin(np.abs(answer.grip.pressures - pressure))]
        at = f" (solved at {shown(float(nearest), 'Pa')})"
        for frame in takewhile(self._goes_on, frames):
            with self._lock:
                self._scene.show_gripper(frame.state.positions, outer, None)
                self._scene.show_object(place, frame.displacement, taper=taper)
                distance = shown(float(np.linalg.norm(frame.displacement)), "m", 3)
                force = shown(frame.force, "N", 3)
                self._words.content = f"**pulled by {distance}: {force}**{at}"
            time.sleep(PULL_SECONDS / FRAMES)
        time.sleep(PULL_SECONDS / 2.0)
        self._refresh()

    def _hand_out(self, kind: str, client: viser.ClientHandle | None) -> None:
        """Send the shape, the picture or the whole scene as a file to those who look."""
        if self._impossible:  # the page says why
            return
        name = self._session.gripper.name
        if kind == "png" and client is not None:  # asked of the page: no lock that it may wait for
            picture = client.get_render(PNG_HEIGHT, PNG_WIDTH, transport_format="png")
            client.send_file_download(f"{name}.png", png(picture), save_immediately=True)
            return
        with self._lock:
            try:
                if kind == "html":
                    suffix, content = "html", self._server.scene.as_html().encode()
                else:
                    suffix, write = EXPORTS[kind]
                    content = write(self._session)
            except SpiralError as error:
                self._words.content = f"**No {kind}.** {plain(error)}"
                return
            self._server.send_file_download(f"{name}.{suffix}", content, save_immediately=True)


def in_time(frames: Sequence[Frame]) -> Iterator[Frame]:
    """Yield frames at their times; skip those that come late."""
    start = time.monotonic()
    for frame in frames:
        early = start + frame.time - time.monotonic()
        if early >= -1.0 / FRAMES_PER_SECOND or frame is frames[-1]:
            time.sleep(max(0.0, early))
            yield frame
