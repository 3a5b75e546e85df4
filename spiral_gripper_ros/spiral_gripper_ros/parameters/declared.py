# SPDX-License-Identifier: Apache-2.0
"""The table of parameters on a node: declaration, reading, checks of changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, Generic

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from spiral_gripper_ros.parameters.spec import (
    ParameterSpec,
    ParametersT,
    ParameterValue,
    may_be_unset,
)

# A vector that is not set: files and `ros2 param` can read and write this value.
UNSET_VECTOR = (math.nan, math.nan, math.nan)


class DeclaredParameters(Generic[ParametersT]):
    """Declares parameters on a node and refuses invalid values.

    Args:
        node: a node whose parameters these become.
        changed: called with the names after good values were set.
        kind: the parameters.
        judge: says why proposed values that these allow cannot be used, or None if they can;
            not asked about the values given at start.

    Raises:
        InvalidInputError: a value given at start (file, command line) is bad; it says why.
    """

    def __init__(
        self,
        node: Node,
        changed: Callable[[set[str]], None],
        kind: type[ParametersT],
        *,
        judge: Callable[[dict[str, ParameterValue]], str | None] = lambda proposed: None,
    ) -> None:
        self._node, self._judge = node, judge
        self._kind, self._table = kind, kind.specs()
        for spec in self._table:
            # rclpy cannot tell the type of an empty array: it is all NaN.
            default = list(UNSET_VECTOR) if spec.default == () else spec.default
            node.declare_parameter(spec.name, default, _descriptor(spec))
        self.values()
        node.add_pre_set_parameters_callback(self._read_texts)
        node.add_on_set_parameters_callback(self._on_set)
        node.add_post_set_parameters_callback(lambda given: changed({one.name for one in given}))

    def values(self) -> ParametersT:
        """Return the value of every parameter."""
        return self._kind.from_names(
            {
                spec.name: _plain_value(self._node.get_parameter(spec.name).value)
                for spec in self._table
            }
        )

    def _read_texts(self, parameters: Iterable[Any]) -> list[Parameter]:
        """Return parameters with the numbers that `ros2 param load` sends as texts: nan, 1e-05."""
        floats = {spec.name for spec in self._table if isinstance(spec.default, (float, tuple))}
        return [_read_text(p) if p.name in floats else p for p in parameters]

    def _on_set(self, parameters: Iterable[Any]) -> SetParametersResult:
        own = {spec.name for spec in self._table}
        proposed = {p.name: _plain_value(p.value) for p in parameters if p.name in own}
        problem = self._kind.refusal(proposed) or self._judge(proposed)
        return SetParametersResult(successful=problem is None, reason=problem or "")


def _descriptor(spec: ParameterSpec) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        name=spec.name,
        description=spec.description,
        read_only=spec.read_only,
        additional_constraints=f"one of {', '.join(spec.choices)}" if spec.choices else "",
    )
    if may_be_unset(spec):  # rclpy takes no NaN where a range is declared
        descriptor.additional_constraints = f"from {spec.low:g} to {spec.high:g}, or NaN"
    elif spec.low is not None and spec.high is not None:
        if isinstance(spec.default, float):
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=spec.low, to_value=spec.high)
            ]
        else:
            descriptor.integer_range = [
                IntegerRange(from_value=int(spec.low), to_value=int(spec.high), step=1)
            ]
    return descriptor


def _read_text(parameter: Parameter) -> Parameter:
    """Return a parameter with numbers for its texts, or as it is: then its type is refused."""
    value = parameter.value
    try:
        if isinstance(value, str):
            return Parameter(parameter.name, value=float(value))
        if parameter.type_ is Parameter.Type.STRING_ARRAY:
            return Parameter(parameter.name, value=[float(text) for text in value])
    except ValueError:
        pass
    return parameter


def _plain_value(value: Any) -> ParameterValue:  # noqa: ANN401
    """Return a value with arrays as tuples of floats; that which stands for "not set" is empty."""
    if isinstance(value, (bool, int, float, str)):
        return value
    components = tuple(float(component) for component in value)
    return () if len(components) == 3 and all(map(math.isnan, components)) else components
