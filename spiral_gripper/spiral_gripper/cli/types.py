# SPDX-License-Identifier: Apache-2.0
"""Types of command-line arguments: quantities with their units, numbers, directions, files."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import reduce
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar

import click

if TYPE_CHECKING:
    from spiral_core import SpiralError
    from spiral_core.rod.types import Vector
    from spiral_gripper.files.units import Dimension

Decorated = TypeVar("Decorated", bound=Callable[..., object])

FIGURE_SUFFIXES = (".png", ".svg", ".pdf")
REPORT_SUFFIXES = (".md", ".html")
# The core's, stated here too so that --help loads nothing heavy; a test compares them.
DEFAULT_TURNS = 1.05
MOST_JOBS = 1024


class TypedValue(NamedTuple):
    """A value that was typed.

    Attributes:
        option: the option that it was given to.
        value: the value in SI.
        text: the text that was typed.
        dimension: name of the :class:`spiral_gripper.Dimension`; empty for a plain number.
    """

    option: str
    value: float
    text: str
    dimension: str


# What was typed, by the parameter's name: the core's name of the field.
Givens: TypeAlias = Mapping[str, list[TypedValue]]


class QuantityType(click.ParamType):  # type: ignore[type-arg]  # generic for the checker only
    """A number, with its unit if it has a dimension, converted to SI; nan and inf are refused.

    Args:
        dimension: name of a :class:`spiral_gripper.Dimension`; empty for a plain number.
        above: the value must be above this, in SI.
        least: the smallest value accepted, in SI.
        most: the largest value accepted, such as "10 m".
    """

    def __init__(
        self,
        dimension: str = "",
        *,
        above: float = -math.inf,
        least: float = -math.inf,
        most: str = "",
    ) -> None:
        self.dimension = dimension
        self.above, self.least, self.most = above, least, most
        self.name = dimension.lower() or "number"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the value in SI, or fail with a message that states the requirement."""
        from spiral_core import InvalidInputError

        if isinstance(value, (float, int)):
            return float(value)
        try:
            converted = self._parsed(value)
        except InvalidInputError as error:
            self.fail(f"it must be {error.requirement}, got {value!r}", param, ctx)
        _note(converted, str(value), self.dimension, param, ctx)
        most = self._parsed(self.most) if self.most else math.inf
        if not (self.above < converted and self.least <= converted <= most):
            bounds = {
                f"above {self.above:g}": self.above,
                f"at least {self.least:g}": self.least,
                f"at most {self.most}": most,
            }
            requirement = " and ".join(
                text for text, bound in bounds.items() if abs(bound) < math.inf
            )
            self.fail(f"it must be {requirement}, got {value!r}", param, ctx)
        return converted

    def _parsed(self, value: object) -> float:
        from spiral_gripper.files.units import Dimension, parse_number, parse_quantity

        if self.dimension:
            return parse_quantity(value, Dimension[self.dimension])
        return parse_number(str(value))


class FiberAngle(QuantityType):
    """The angle of a wound fiber to the tube's axis."""

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the angle [rad], or fail with a message that states the requirement."""
        angle = super().convert(value, param, ctx)
        if not 0.0 < abs(angle) <= 0.5 * math.pi:
            from spiral_gripper.files.fields import fiber_angle_requirement

            requirement = fiber_angle_requirement(angle, str(value))
            self.fail(f"it must be {requirement}, got {value!r}", param, ctx)
        return angle


class Suffixed(click.ParamType):  # type: ignore[type-arg]  # generic for the checker only
    """A file to write, whose suffix decides its format.

    Args:
        suffixes: those that are known.
        new: whether there may be no such file yet.
    """

    name = "file"

    def __init__(self, suffixes: tuple[str, ...], *, new: bool = False) -> None:
        self.suffixes = suffixes
        self.new = new

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> Path:
        """Return the path, or fail with a message that lists the suffixes."""
        path = Path(str(value))
        if path.suffix.lower() not in self.suffixes:
            self.fail(f"its name must end in {', '.join(self.suffixes)}, got {value!r}", param, ctx)
        if not path.parent.is_dir():
            self.fail(f"there is no folder {str(path.parent)!r}", param, ctx)
        if path.exists():
            if not path.is_file():
                self.fail(f"{path} is not a plain file", param, ctx)
            if self.new:
                self.fail(f"{path} exists already and is kept; name another file", param, ctx)
            return path
        try:
            TemporaryFile(dir=path.parent).close()
        except FileNotFoundError:  # such as /proc: the folder itself is there
            self.fail(f"{path.parent} takes no files: write to another folder", param, ctx)
        except OSError as error:
            from spiral_gripper.files.storage import reason_of

            self.fail(f"{path.parent} takes no files: {reason_of(error)}", param, ctx)
        return path


def _note(
    value: float,
    text: str,
    dimension: str,
    param: click.Parameter | None,
    ctx: click.Context | None,
) -> None:
    """Keep how a value was typed, for messages about it."""
    if param is None or ctx is None or not isinstance(ctx.obj, dict):
        return
    one = TypedValue(param.opts[0], value, text, dimension)
    ctx.obj.setdefault(str(param.name), []).append(one)


def note_unit(text: str, dimension: str) -> None:
    """Show quantities in the unit of a text, such as a file's, unless another one was typed."""
    context = click.get_current_context()
    (command,) = context.command.params[:1]
    _note(math.nan, text, dimension, command, context)


def typed_units(givens: Givens) -> dict[Dimension, str]:
    """Return the unit that was typed first for each kind of quantity."""
    from spiral_gripper.files.units import Dimension, unit_of

    units: dict[Dimension, str] = {}
    for one in _with_units(givens):
        dimension = Dimension[one.dimension]
        units.setdefault(dimension, unit_of(one.text, dimension))
    return units


def _with_units(givens: Givens) -> list[TypedValue]:
    return [one for values in givens.values() for one in values if one.dimension]


def error_text(error: SpiralError, givens: Givens) -> str:
    """Return the message of an error in the units, and with the values and options, as typed.

    Args:
        error: raised by the core or by the readers of files.
        givens: what was typed, by the parameter's name: the core's name of the field.

    Example:
        >>> from spiral_core import NotGrippableError
        >>> error = NotGrippableError(0.06, "too thick for 1.05 turns", -0.02218, 0.0378211)
        >>> print(error_text(error, {"radius": [TypedValue("--radius", 0.06, "6 cm", "LENGTH")]}))
        an object of radius 6 cm cannot be gripped: too thick for 1.05 turns; the nearest \
grippable radius is 3.782 cm
    """
    from spiral_core import InvalidInputError
    from spiral_core.message import Message, Quantity
    from spiral_gripper.files.shown import shown_message, units_shown
    from spiral_gripper.files.units import Dimension

    texts = {
        Quantity(one.value, Dimension[one.dimension].si_unit): one.text
        for one in _with_units(givens)
    }
    message: object = error
    if isinstance(error, InvalidInputError):
        for one in givens.get(error.field, ()):
            if one.value == error.value:
                message = Message("{} must be {}, got {}", one.option, error.requirement, one.text)
    with units_shown(typed_units(givens)):
        return shown_message(message, texts)


def typed(name: str) -> str:
    """Return how the value of an option of this command was typed, the last one of several."""
    return typed_all(name)[-1]


def typed_all(name: str) -> list[str]:
    """Return how the values of an option of this command that may be repeated were typed."""
    return [str(value.text) for value in click.get_current_context().obj[name]]


LENGTH = QuantityType("LENGTH")
POSITIVE_LENGTH = QuantityType("LENGTH", above=0.0)
PRESSURE = QuantityType("PRESSURE")
FIBER_ANGLE = FiberAngle("ANGLE")
SINGLE_FIBER_ANGLE = QuantityType("ANGLE")
ACCELERATION = QuantityType("ACCELERATION", least=0.0, most="10000 m/s^2")
MASS = QuantityType("MASS", above=0.0, most="1000 kg")
FORCE = QuantityType("FORCE", above=0.0, most="1000 kN")
TIME = QuantityType("TIME", above=0.0, most="600 s")
PRESSURE_RATE = QuantityType("PRESSURE_RATE", above=0.0, most="1000 bar/s")
NUMBER = QuantityType()
POSITIVE_NUMBER = QuantityType(above=0.0)
FRICTION = QuantityType(least=0.0, most="10")
FIGURE_FILE = Suffixed(FIGURE_SUFFIXES)
REPORT_FILE = Suffixed(REPORT_SUFFIXES)
YAML_FILE = Suffixed((".yaml",), new=True)


def option(
    name: str,
    kind: Any,  # noqa: ANN401  # click's types
    text: str,
    *,
    to: str = "",
    many: str = "",
    shown: object = None,
    **more: Any,  # noqa: ANN401  # of click.option
) -> Callable[[Decorated], Decorated]:
    """Return a decorator that adds an option.

    Args:
        name: with its hyphens.
        kind: of its value.
        text: its help.
        to: the parameter's name, if it is not the option's.
        many: likewise, of an option that may be repeated.
        shown: default that the help shows.
        more: of ``click.option``.
    """
    names = (name, *filter(None, (to or many,)))
    if shown is not None:
        more |= {"default": shown, "show_default": True}
    return click.option(*names, type=kind, help=text, multiple=bool(many), **more)


def flag(name: str, text: str, *, to: str = "") -> Callable[[Decorated], Decorated]:
    """Return a decorator that adds an option without a value; arguments as of :func:`option`."""
    return option(name, None, text, to=to, is_flag=True)


def together(*options: Callable[[Any], Any]) -> Callable[[Decorated], Decorated]:
    """Return a decorator that adds options, the first one on top."""
    return lambda function: reduce(lambda f, option: option(f), reversed(options), function)


def _choose_units(ctx: click.Context, param: click.Parameter, value: str | None) -> None:
    """Show figures in these units until the command has ended, and in messages too."""
    if value is None:
        return
    from spiral_core import InvalidInputError
    from spiral_gripper.files.shown import dimension_of, display_units

    units = [unit.strip() for unit in value.split(",")]
    try:
        ctx.with_resource(display_units(*units))
    except InvalidInputError as error:
        raise click.BadParameter(f"it must be {error.requirement}, got {error.value!r}") from None
    for unit in units:
        _note(math.nan, f"1 {unit}", dimension_of(unit).name, param, ctx)


def _keep(ctx: click.Context, param: click.Parameter, value: object) -> None:
    ctx.meta[str(param.name)] = value


def wanted(name: str) -> Any:  # noqa: ANN401  # a flag, a path, a number
    """Return what was given to an option that many commands have: ``json``, ``plot`` or ``jobs``.

    Outside a command, and where the command has no such option, it is None.
    """
    context = click.get_current_context(silent=True)
    return context and context.meta.get(name)


json_option = option(
    "--json",
    None,
    "Print JSON, in SI units, for programs.",
    is_flag=True,
    expose_value=False,
    callback=_keep,
)
# The units in which the command prints and draws.
units_option = option(
    "--units",
    str,
    'Units of tables, messages and pictures, such as "psi,mm".',
    to="display_units",
    metavar="UNITS",
    expose_value=False,
    is_eager=True,
    callback=_choose_units,
)
output_options = together(json_option, units_option)
plot_option = option(
    "--plot",
    FIGURE_FILE,
    "Write a picture to a .png, .svg or .pdf file.",
    expose_value=False,
    callback=_keep,
)
jobs_option = option(
    "--jobs",
    click.IntRange(1, MOST_JOBS),
    "Number of processes.  [default: one per core]",
    expose_value=False,
    callback=_keep,
)
results_option = option(
    "--results",
    Suffixed((".jsonl",)),
    "A .jsonl file with one line for each result; those found in it are not computed again.",
)
turns_option = option(
    "--turns",
    NUMBER,
    "Turns about the largest object.",
    to="turns_required",
    shown=str(DEFAULT_TURNS),
    metavar="N",
)
gripper_argument = click.argument("gripper", metavar="GRIPPER")
object_options = together(
    option("--radius", LENGTH, "Radius of a cylinder."),
    option(
        "--profile",
        click.Path(exists=True, dir_okay=False, path_type=Path),
        "CSV file of the object's radius along its axis, in place of --radius; its header: "
        "position [mm], radius [mm].",
    ),
)
place_options = together(
    option(
        "--place",
        LENGTH,
        "The object's middle in the base frame; by default where the free coil lies.",
        nargs=3,
        metavar="X Y Z",
    ),
    flag("--find-place", "Where the object is not held, look for a place near by where it is."),
)
mount_options = together(
    option(
        "--gravity-direction",
        NUMBER,
        "Direction of gravity in the base frame, where the tube leaves along +x: 1 0 0 "
        "for a gripper that hangs.",
        nargs=3,
        metavar="X Y Z",
    ),
    option(
        "--gravity-magnitude",
        ACCELERATION,
        'Acceleration of gravity; "0 m/s^2" leaves gravity out.',
    ),
    option(
        "--object-axis",
        NUMBER,
        "Direction of the object in the base frame; by default fitted to the coil.",
        nargs=3,
        metavar="X Y Z",
    ),
)
friction_option = option(
    "--friction",
    FRICTION,
    "Friction coefficient of tube and object; by default the gripper file's, or 0.3.",
    metavar="MU",
)
payload_option = option("--payload", MASS, "Mass of the object to carry.")
sensitivity_option = flag(
    "--sensitivity", "Change every input to both sides and print what that changes, the most first."
)


def unit_vector(name: str, vector: tuple[float, ...]) -> Vector:
    """Return the unit vector along three numbers.

    Raises:
        click.BadParameter: all three are zero.
    """
    _, exponent = math.frexp(max(map(abs, vector)))
    x, y, z = (math.ldexp(each, -exponent) for each in vector)  # the norm of any is a float
    norm = math.hypot(x, y, z)
    if not norm > 0.0:
        raise click.BadParameter("the three numbers must not all be zero", param_hint=name)
    return (x / norm, y / norm, z / norm)
