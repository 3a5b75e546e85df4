# SPDX-License-Identifier: Apache-2.0
"""Answers as they were recorded: what commands print, what pictures and pages show.

A file in ``records`` is a list of cases, each below a line with a dollar sign. A case has the words
that were recorded, and the whole numbers; other numbers may differ by one unit of the last digit.
``RECORD=1 pytest tests/edge`` records what was changed on purpose: git shows how it differs.
"""

import math
import re
from difflib import unified_diff
from itertools import zip_longest
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import Collection
from matplotlib.colors import to_rgba_array
from matplotlib.figure import FigureBase
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.spines import Spine
from matplotlib.text import Text
from records import RECORDING, alike

RECORDS = Path(__file__).parent / "records"
# What rounding decides: how far contact sinks in, what is left after the coil snaps; click's words;
# where the package is.
VAGUE = re.compile(
    r"(?<=sinks in by )\S+|(?<=^after that ).*|(?<=^after_loss).*|No such option.*?(?= Give|$)"
    r"|\S+(?=/edited.yaml)|(?<=^source: ).*(?=/config/)"
)
NEAR_ZERO = 1e-9
# Of artists: what our code sets.
SET = (
    "text", "label", "fontsize", "color", "facecolor", "edgecolor", "linewidth", "linestyle",
    "marker", "markersize", "sizes", "array", "clim", "hatch", "xlim", "ylim", "aspect",
    "subplotspec",
)  # fmt: skip
# Of most artists, or nothing: not written.
USUAL = (
    "",
    "nan nan",
    "'None'",
    "8.000",
    "6.000",
    "0.000 0.000 0.000 1.000",
    "1.000 1.000 1.000 1.000",
)


def cases(name):
    """Return the lines of each case of a file, by what was asked."""
    text = (RECORDS / name).read_text("utf-8")
    found = re.findall(r"^\$ ?(.*)\n((?:(?!\$).*\n)*)", text, re.MULTILINE)
    return {asked: answer.splitlines() for asked, answer in found}


def written(case):
    """Return the text that a case is about, with its line ends."""
    return case.encode().decode("unicode_escape")


def changed(text, case):
    """Return a text with a case's changes: what stands in it, what is written instead."""
    for change in written(case).split("; "):
        old, _, new = change.partition(" ->")
        assert old in text
        text = text.replace(old, new.removeprefix(" "))
    return text


def check(name, case, lines):
    """Compare lines with those of a case, or record them."""
    kept, plain = cases(name), [VAGUE.sub("...", line) for line in lines]
    pairs = zip_longest(plain, kept[case], fillvalue="")
    found = [then if alike(now, then) else now for now, then in pairs]
    changed = "\n".join(unified_diff(kept[case], found, "recorded", "now", n=0, lineterm=""))
    if not RECORDING:
        assert not changed, changed
    elif changed:
        answers = (kept | {case: plain}).items()
        text = "".join("\n".join((f"$ {each}".rstrip(), *answer, "")) for each, answer in answers)
        (RECORDS / name).write_text(text, "utf-8")


def document(value, name=""):
    """Yield the lines of a JSON document: one for a list of figures, or a column of a table."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        is_table = "{" not in str([*value[0].values()])
        columns = {key: [row[key] for row in value] for key in value[0]} if is_table else {}
        value = columns or dict(enumerate(value))
    if not isinstance(value, dict):
        yield f"{name}: {figures(value, 6)}"
        return
    for key, each in value.items():
        yield from document(each, f"{name}.{key}".lstrip("."))


def figures(value, digits):
    """Return numbers with so many digits of the largest: of many some, and the mean."""
    if isinstance(value, str | int | None):
        return str(value)
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError):
        return str(value)
    flat = array.ravel()
    largest = np.nanmax(np.abs(flat), initial=NEAR_ZERO)
    decimals = max(0, digits - 1 - math.floor(math.log10(largest))) if largest > NEAR_ZERO else 0
    if flat.size > 6:
        flat = [*flat[[0, flat.size // 3, -1]], np.nanmean(flat)]
    text = " ".join(f"{0.0 if abs(each) < NEAR_ZERO else each:.{decimals}f}" for each in flat)
    return text if array.size == len(flat) else f"{array.shape} {text}"


def picture(figure):
    """Yield a line for each artist of a figure: its kind, what was set, where it is."""
    yield f"picture {figures(figure.get_size_inches(), 3)}"
    for artist in artists(figure):
        if isinstance(artist, Text) and not artist.get_text():
            continue
        values = ((name, getattr(artist, f"get_{name}", str)()) for name in SET)
        texts = ((name, setting(name, value)) for name, value in values)
        words = (f"{name} {text}" for name, text in texts if text not in USUAL)
        yield " ".join((type(artist).__name__, *words, place(artist))).strip()


def artists(parent):
    """Yield what was put into a figure, without what belongs to its axes."""
    for child in parent.get_children():
        if isinstance(child, Axis):
            yield child.label
        elif isinstance(child, Legend):
            yield from (child.get_texts()[0], child.get_title())
        elif (
            not isinstance(child, Spine)
            and child is not parent.patch
            and str(child.get_label()) != "<colorbar>"
        ):
            yield child
            if isinstance(child, Axes | FigureBase):
                yield from artists(child)


def setting(name, value):
    """Return the value of an artist's property, of many colors the mean; "" where none is set."""
    is_text = isinstance(value, str)
    if value is None or (value[:1] in ("", "_") if is_text else name == "linestyle"):
        return ""
    if "color" in name:
        colors = to_rgba_array(value)
        return figures(colors.mean(axis=0), 3) if len(colors) else ""
    return repr(value) if is_text else figures(value, 4)


def place(artist):
    """Return the extent and the mean of an artist's points, in the units of its axes."""
    points = np.empty((0, 2))
    if isinstance(artist, Line2D):
        points = artist.get_xydata()
    elif isinstance(artist, Patch):
        points = artist.get_path().transformed(artist.get_patch_transform()).vertices
    elif isinstance(artist, Collection):
        offsets, paths = artist.get_offsets(), artist.get_paths()
        points = offsets if len(offsets) > 1 else np.concatenate([one.vertices for one in paths])
    elif isinstance(artist, Text) and artist in getattr(artist.axes, "texts", ()):
        return figures(artist.get_position(), 4)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 2:
        return "".join(figures(point, 4) for point in points)
    many = len(points) > 1000  # faces that are seen from their edge: rounding decides how many
    ends = np.array([each(points, axis=0) for each in (np.min, np.max, np.mean)[: 3 - many]])
    across, up = (figures(column, 4) for column in ends.T)
    return f"{'many' if many else len(points)} points {across}, {up}"
