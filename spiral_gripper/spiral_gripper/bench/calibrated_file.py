# SPDX-License-Identifier: Apache-2.0
"""A calibrated copy of a gripper description file, written beside the original.

The file's own comments and layout stay; only the fitted fields change, each with its confidence
interval as a comment. No file is ever overwritten.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from spiral_core import MeasuredActuation
from spiral_core.calibration.fit import Calibration
from spiral_core.calibration.model import constants_of
from spiral_core.calibration.regression import DEFAULT_LEVEL
from spiral_core.message import Message
from spiral_gripper.bench.report import FIELD_OF_QUANTITY
from spiral_gripper.files.catalog import GRIPPERS, read_description_text
from spiral_gripper.files.description import GripperDescription, parse_description
from spiral_gripper.files.description_text import changed_text, read_for_change, written
from spiral_gripper.files.errors import DescriptionError
from spiral_gripper.files.fields import CONSTANTS, law_name
from spiral_gripper.files.storage import FileError, write_file

if TYPE_CHECKING:
    from ruamel.yaml.comments import CommentedMap, CommentedSeq

# Ten digits: rounding in the file does not change the fitted pressures noticeably.
_DIGITS = 10


def write_calibrated_description(
    description: GripperDescription,
    calibration: Calibration,
    measured_files: Sequence[Path] = (),
    target: Path | None = None,
) -> Path:
    """Write a description file with the fitted values, and return where it is.

    Args:
        description: what was calibrated; its source is read again for its comments.
        calibration: the fit.
        measured_files: the files of measurements, to be named in the file.
        target: where to write; None puts ``<name>_calibrated.yaml`` beside the original (with a
            number, if there is one already), or into the current folder if the original is one
            of the package's own.

    Raises:
        FileError: the fitted values make no valid description (most often ``limits.pressure_max``
            is past the fitted actuator's limit), ``target`` exists, or it cannot be written.
    """
    text = calibrated_text(description, calibration, measured_files)
    return _write_new(description.source, text, target, "calibrated")


def write_measured_description(
    description: GripperDescription,
    actuation: MeasuredActuation,
    measured_files: Sequence[Path] = (),
    target: Path | None = None,
) -> Path:
    """Write a description file that holds a measured actuation curve, and return where it is.

    Args:
        description: the gripper whose actuation was measured.
        actuation: the curve.
        measured_files: the files of measurements, to be named in the file.
        target: as for :func:`write_calibrated_description`, with ``_measured`` in its name.

    Raises:
        FileError: most often because ``limits.pressure_max`` is past the end of the data.
    """
    root = read_for_change(read_description_text(description.source))
    root["measured"] = {
        "pressures": _quantities(actuation.pressures, 1e-3, "kPa"),
        "curvatures": _quantities(actuation.curvatures, 1.0, "rad/m"),
        "torsions": _quantities(actuation.torsions, 1.0, "rad/m"),
    }
    note = f"# The actuation curve was measured{_named('in', measured_files)}; "
    text = f"{note}the material gives the stiffness only.\n{changed_text(root)}"
    return _write_new(description.source, text, target, "measured")


def calibrated_text(
    description: GripperDescription, calibration: Calibration, measured_files: Sequence[Path] = ()
) -> str:
    """Return the text of a description file with the fitted values in place of its own."""
    root = read_for_change(read_description_text(description.source))
    _write_law(root["material"], calibration)
    root.pop("measured", None)  # it would stand for what was fitted
    for name in calibration.names:
        section, key = FIELD_OF_QUANTITY[name].split(".")
        if section != "material":
            if not isinstance(root.get(section), dict):
                root[section] = type(root)()
            _put(root[section], key, calibration.value(name), calibration, name)
    law = law_name(calibration.model.fitted_law)
    note = (
        f"# Calibrated: {law} fitted{_named('to', measured_files)}, "
        f"{len(calibration.readings)} readings; intervals are {DEFAULT_LEVEL:.0%}.\n"
    )
    return note + changed_text(root)


def _write_law(material: CommentedMap, calibration: Calibration) -> None:
    """Put a law and its constants into the material's section, and take out other constants."""
    law = calibration.model.fitted_law
    wanted = constants_of(law)
    material["law"] = law_name(law)
    others = [name for name in material if name in CONSTANTS and name not in wanted]
    orphaned = "".join(_comment_below(material, name) for name in others)
    for name in others:
        del material[name]
    place = list(material).index("law") + 1
    for name in wanted:
        value = float(getattr(calibration.actuator.material, name))
        if name not in material:
            material.insert(place, name, None)
        _put(material, name, value, calibration, name)
        place = list(material).index(name) + 1
    material.ca.items[wanted[-1]][2].value += orphaned


def _put(
    section: CommentedMap, key: str, value: float, calibration: Calibration, name: str
) -> None:
    """Set one field, with its interval as its comment in place of any older one."""
    section[key] = _text(name, value)
    if name not in calibration.names:
        comment = "held in the fit"
    elif name in calibration.at_bound:
        comment = "fitted; at the bound it was given"
    elif calibration.standard_errors[calibration.index(name)] > abs(calibration.value(name)):
        comment = "fitted, but not determined by the readings"
    else:
        low, high = (_text(name, end, digits=4) for end in calibration.interval(name))
        comment = f"fitted; {low} to {high}"
    rest = _comment_below(section, key)
    section.ca.items.pop(key, None)
    section.yaml_add_eol_comment(comment, key, column=0)
    if rest:
        section.ca.items[key][2].value += rest


def _comment_below(section: CommentedMap, key: str) -> str:
    """Return the comment lines between a field and the next one, to which they belong."""
    token = section.ca.items.get(key, [None, None, None])[2]
    return "" if token is None else "".join(token.value.partition("\n")[1:])


def _text(name: str, value: float, digits: int = _DIGITS) -> str | float:
    """Return the value of a fitted quantity as description files write it."""
    return written(FIELD_OF_QUANTITY[name], value, digits)


def _quantities(values: Sequence[float], factor: float, unit: str) -> CommentedSeq:
    from ruamel.yaml.comments import CommentedSeq

    items = CommentedSeq(f"{value * factor:.{_DIGITS}g} {unit}" for value in values)
    items.fa.set_flow_style()
    return items


def _named(preposition: str, files: Sequence[Path]) -> str:
    return f" {preposition} {', '.join(file.name for file in files)}" if files else ""


def _write_new(source: Path, text: str, target: Path | None, word: str) -> Path:
    """Write a text that is a valid description to a file that does not exist."""
    # Beside a gripper that is shipped with the package would be inside of the package.
    folder = Path() if source.parent == GRIPPERS.path else source.parent
    beside = folder / f"{source.stem}_{word}{source.suffix}"
    path, number = target or beside, 1
    while target is None and path.exists():
        number += 1
        path = beside.with_stem(f"{beside.stem}_{number}")
    try:
        parse_description(text, path)
    except DescriptionError as error:
        first = error.problems[0]
        found = f"{first.field}, {first.value} in {source}"
        reason = Message("{}, must be {}; change it there", found, first.requirement)
        raise FileError(str(path), "written", reason) from None
    write_file(path, text, replace=False)
    return path
