"""Types of command-line arguments: quantities with their units, numbers, directions, files."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeVar

import click

Decorated = TypeVar("Decorated", bound=Callable[..., object])

FIGURE_SUFFIXES: Final = (".png", ".svg", ".pdf")
REPORT_SUFFIXES: Final = (".md", ".html")


class Quantity(click.ParamType):  # type: ignore[type-arg]  # generic for the checker only
    """A number with its unit, to SI.

    Args:
        dimension: name of a :class:`spiral_gripper.Dimension`.
    """

    def __init__(self, dimension: str) -> None:
        self.dimension = dimension
        self.name = dimension.lower()

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the value in SI, or fail with what would be right."""
        from spiral_core import InvalidInputError
        from spiral_gripper.files.units import Dimension, parse_quantity

        if isinstance(value, float):
            return value
        try:
            return parse_quantity(value, Dimension[self.dimension])
        except InvalidInputError as error:
            self.fail(f"it must be {error.requirement}, got {value!r}", param, ctx)


class Number(click.ParamType):  # type: ignore[type-arg]  # generic for the checker only
    """A plain finite number; nan and inf, which ``float`` reads, are none."""

    name = "number"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number, or fail with what would be right."""
        from spiral_core import InvalidInputError
        from spiral_gripper.files.units import parse_number

        if isinstance(value, (float, int)):
            return float(value)
        try:
            return parse_number(str(value))
        except InvalidInputError as error:
            self.fail(f"it must be {error.requirement}, got {value!r}", param, ctx)


class Suffixed(click.ParamType):  # type: ignore[type-arg]  # generic for the checker only
    """A file to write, whose suffix decides its format.

    Args:
        suffixes: those that are known.
    """

    name = "file"

    def __init__(self, suffixes: tuple[str, ...]) -> None:
        self.suffixes = suffixes

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> Path:
        """Return the path, or fail with the suffixes there are."""
        path = Path(str(value))
        if path.suffix.lower() not in self.suffixes:
            self.fail(f"its name must end in {', '.join(self.suffixes)}, got {value!r}", param, ctx)
        if not path.parent.is_dir():
            self.fail(f"there is no folder {str(path.parent)!r}", param, ctx)
        return path


LENGTH: Final = Quantity("LENGTH")
PRESSURE: Final = Quantity("PRESSURE")
ANGLE: Final = Quantity("ANGLE")
ACCELERATION: Final = Quantity("ACCELERATION")
NUMBER: Final = Number()
FIGURE_FILE: Final = Suffixed(FIGURE_SUFFIXES)
REPORT_FILE: Final = Suffixed(REPORT_SUFFIXES)
YAML_FILE: Final = Suffixed((".yaml",))


def json_option(function: Decorated) -> Decorated:
    """Add ``--json``."""
    return click.option(
        "--json", "as_json", is_flag=True, help="Print JSON, in SI units, for programs."
    )(function)


def plot_option(function: Decorated) -> Decorated:
    """Add ``--plot``."""
    return click.option(
        "--plot", type=FIGURE_FILE, metavar="FILE", help="Draw it to a .png, .svg or .pdf file."
    )(function)


def gripper_argument(function: Decorated) -> Decorated:
    """Add the gripper: the name of a shipped one, or a description file."""
    return click.argument("gripper", metavar="GRIPPER")(function)


def mount_options(function: Decorated) -> Decorated:
    """Add ``--gravity-direction``, ``--gravity-magnitude`` and ``--object-axis``."""
    for option in (
        click.option(
            "--object-axis",
            type=NUMBER,
            nargs=3,
            metavar="X Y Z",
            help="Direction of the object in the base frame; by default fitted to the coil.",
        ),
        click.option(
            "--gravity-magnitude",
            type=ACCELERATION,
            metavar="ACCELERATION",
            help='"0 m/s^2" leaves gravity out.',
        ),
        click.option(
            "--gravity-direction",
            type=NUMBER,
            nargs=3,
            metavar="X Y Z",
            help="In the base frame, where the tube leaves along +x: 1 0 0 hangs straight down.",
        ),
    ):
        function = option(function)
    return function


def unit_vector(name: str, vector: tuple[float, ...]) -> tuple[float, float, float]:
    """Return the unit vector along three numbers.

    Raises:
        click.BadParameter: all three are zero.
    """
    x, y, z = vector
    norm = math.hypot(x, y, z)
    if not norm > 0.0:
        raise click.BadParameter("the three numbers must not all be zero", param_hint=name)
    return (x / norm, y / norm, z / norm)
