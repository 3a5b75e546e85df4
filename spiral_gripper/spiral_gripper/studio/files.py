# SPDX-License-Identifier: Apache-2.0
"""The studio's description file: to load one, to edit it on the page."""

from __future__ import annotations

from collections.abc import Callable

import viser

from spiral_core import SpiralError
from spiral_gripper.files.catalog import read_description_text
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.studio.words import plain


class FileFolder:
    """The text of a description file, a button that uses it and one that loads another.

    Args:
        gui: where they are put.
        use: takes a file's text; it raises what is wrong with it.
    """

    def __init__(self, gui: viser.GuiApi, use: Callable[[str], None]) -> None:
        with gui.add_folder("Gripper file", expand_by_default=False):
            load = gui.add_upload_button("Load a file", mime_type=".yaml,.yml")
            self._text = gui.add_text("text", "", multiline=True)
            apply = gui.add_button("Use this text")
            self._said = gui.add_markdown("")

        load.on_upload(
            lambda _: self.attempt(lambda: use(load.value.content.decode("utf-8", "replace")))
        )
        apply.on_click(lambda _: self.attempt(lambda: use(self._text.value)))

    def show(self, description: GripperDescription) -> None:
        """Show the text of a description's file."""
        text = read_description_text(description.source)
        self._text.value = text  # type: ignore[misc]  # viser hides its setter
        self._said.content = ""

    def attempt(self, use: Callable[[], None]) -> None:
        """Use a file, or say what is wrong with it, a line for each problem."""
        try:
            use()
        except SpiralError as error:
            lines = "\n".join(f"- {line.strip()}" for line in plain(error).splitlines())
            self._said.content = f"**Not used:**\n\n{lines}"
