# SPDX-License-Identifier: Apache-2.0
"""Names of shipped files, and paths, to files on disk."""

from __future__ import annotations

import os
from dataclasses import dataclass
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path

from spiral_gripper.files.errors import DescriptionError, Problem, ProblemKind
from spiral_gripper.files.storage import FileError, read_text

_SUFFIX = ".yaml"


@dataclass(frozen=True, slots=True)
class ShippedFiles:
    """One kind of files shipped with the package.

    Attributes:
        noun: what messages call one of them.
        folder: below the package's configuration; empty for the folder itself.
    """

    noun: str
    folder: str = ""

    @property
    def path(self) -> Path:
        """The folder of the files."""
        return Path(str(files("spiral_gripper"))) / "config" / self.folder

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the files, in alphabetical order."""
        return tuple(sorted(file.stem for file in self.path.glob(f"*{_SUFFIX}")))


GRIPPERS = ShippedFiles("gripper")
TUBING = ShippedFiles("tubing", "tubing")


def available_grippers() -> tuple[str, ...]:
    """Return the names of the grippers shipped with the package, in alphabetical order.

    Example:
        >>> "prototype_p1" in available_grippers()
        True
    """
    return GRIPPERS.names


def find_description(
    name_or_path: str | os.PathLike[str], shipped: ShippedFiles = GRIPPERS
) -> Path:
    """Return the path of a file from its name or path.

    Text without a folder and without a suffix is the name of a shipped file, whatever the current
    folder holds; anything else is a path.

    Args:
        name_or_path: ``"prototype_p1"``, ``"my_gripper.yaml"``, ``"./mine"`` or any path object.
        shipped: where names are looked up.

    Raises:
        DescriptionError: no shipped file has this name; the message lists those there are.

    Example:
        >>> find_description("prototype_p1").name
        'prototype_p1.yaml'
    """
    path = Path(name_or_path)
    if name_or_path != path.name or path.suffix:  # a path object never equals text
        return path
    if path.name in shipped.names:
        return shipped.path / f"{path.name}{_SUFFIX}"
    reason = f"no {shipped.noun} has this name; {_shipped_names(path, shipped)}"
    raise _unreadable(path.name, reason)


def read_description_text(path: Path, shipped: ShippedFiles = GRIPPERS) -> str:
    """Return the text of a file; the message about a missing one lists the files of ``shipped``.

    Raises:
        DescriptionError: there is no such file, or it cannot be read.
    """
    try:
        return read_text(path)
    except FileError as error:
        there = os.path.exists(path)  # noqa: PTH110  # also where a name is too long to look up
        advice = "" if there else f"; {_shipped_names(path, shipped)}"
        raise _unreadable(str(path), f"{error.reason}{advice}") from None


def _shipped_names(path: Path, shipped: ShippedFiles) -> str:
    """Return advice: the shipped file with the most similar name, and the list of all."""
    nearest = get_close_matches(path.stem, shipped.names, n=1)
    hint = f"did you mean {nearest[0]}? " if nearest else ""
    nouns = f"{shipped.noun}s are" if len(shipped.names) > 1 else f"{shipped.noun} is"
    known = ", ".join(shipped.names)
    return f"{hint}the shipped {nouns} {known}; write a path for any other file"


def _unreadable(file: str, reason: str) -> DescriptionError:
    place = (file or '""', None, None)
    return DescriptionError([Problem(ProblemKind.UNREADABLE, *place, "", None, reason)])
