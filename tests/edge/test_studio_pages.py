# SPDX-License-Identifier: Apache-2.0
"""The studio's page without a browser: after each step it shows what was recorded."""

import re
import time
from types import SimpleNamespace

import pytest
import trimesh
from edge.recorded import cases, changed, check, figures

from spiral_core.grip import grip
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.studio import page

TEXT = (GRIPPERS.path / "paper_design_70.yaml").read_text("utf-8")
# What the page said.
HEARD = []


class Part(SimpleNamespace):
    """A part of a page: it keeps what is set, and whom to call."""

    def __setattr__(self, name, value):
        super().__setattr__(name, value)
        if name == "content":
            HEARD.append(value)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def on_click(self, call):
        self.call = call

    on_update = on_upload = on_click


class Server:
    """Keeps the parts of a page and of its scene by their names."""

    def __init__(self):
        self.initial_camera = Part()
        self.parts = {"camera": self.initial_camera}
        self.gui = self.scene = self

    def __getattr__(self, kind):
        def add(name, *given, **options):
            if not isinstance(name, str) or kind == "add_markdown":
                name, given = f"{kind} {len(self.parts)}", (name, *given)
            part = self.parts[name] = Part(given=given, **options)
            if kind == "add_slider":
                part.step, part.value = given[-2:]
            elif kind in ("add_dropdown", "add_text", "add_button_group"):
                part.value = options.get("initial_value", "")
            part.remove = lambda: self.remove_by_name(name)
            return part

        return add

    def configure_theme(self, **_):
        pass

    def remove_by_name(self, name):
        self.parts.pop(name, None)

    def as_html(self):
        return "html"

    def shown(self):
        """Return what the parts keep, by part and name."""
        lines = {
            f"{part} {name}": told(value)
            for part, kept in self.parts.copy().items()
            for name, value in vars(kept).items()
            if not callable(value)
        }
        return {name: line for name, line in lines.items() if line not in ("", "None")}


def told(value):
    """Return a value of a part in a line: figures, words, the first line of a file."""
    if isinstance(value, trimesh.Trimesh):
        value = value.vertices, value.visual.vertex_colors
    if isinstance(value, dict):
        return ", ".join(f"{name} {told(each)}" for name, each in value.items())
    if isinstance(value, tuple):
        return ", ".join(map(told, value))
    if isinstance(value, bytes):
        return value.decode("latin-1").partition("\n")[0][:100]
    return re.sub(r"\s+", " ", figures(value, 4)[:800])


# From the file's text on, each step computes a grip.
@pytest.mark.parametrize("count", [19, pytest.param(None, marks=pytest.mark.slow)])
def test_the_page_shows_what_was_recorded(count, monkeypatch):
    monkeypatch.setattr(grip, "FORCE_PRESSURES", 2)
    slept = []
    clock = SimpleNamespace(sleep=slept.append, monotonic=lambda: sum(slept))
    monkeypatch.setattr(page, "time", clock)
    server, before = Server(), {}
    opened = page.Page(server, "paper_design_70")
    for case in [*cases("studio.txt")][:count]:
        HEARD.clear()
        slept.clear()
        name, _, value = case.partition(" = ")
        part = server.parts.get(name, Part())
        if name == "text":
            part.value, part = changed(TEXT, value), server.parts["Use this text"]
        elif value:
            part.value = value if isinstance(part.value, str) else float(value)
        getattr(part, "call", str)(SimpleNamespace(client=None))
        said, waits = list(HEARD), figures(slept, 4)
        while any("computing" in each for each in server.shown().values()):
            time.sleep(0.01)
        opened.tick()  # waits until all is shown
        after = server.shown()
        lines = [f"{name}: {now}" for name, now in after.items() if before.get(name) != now]
        lines += [f"{name}: gone" for name in before.keys() - after.keys()]
        if slept:
            lines += [f"waits {waits}", *map(told, said[:: max(1, len(said) // 3)])]
        check("studio.txt", case, sorted(lines))
        before = after
    opened.close()
