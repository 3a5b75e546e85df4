# SPDX-License-Identifier: Apache-2.0
"""Detection of parameters given at start that no node of the process has, such as typing errors.

rclpy ignores such names, and a file for another node, without a warning: a pressure cap in it would
be lost.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from itertools import zip_longest
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

_PARAMETERS = "ros__parameters"


@dataclass(slots=True)
class Findings:
    """Problems of the parameters given at start.

    Args:
        errors: the node must not start.
        warnings: names in sections for every node, which may belong to another one.
    """

    errors: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def judge_given_parameters(
    args: Sequence[str], nodes: Sequence[str], known: Collection[str]
) -> Findings:
    """Return what is wrong with the parameters that a command line gives to some nodes.

    Args:
        args: of the process.
        nodes: full names of the process's nodes.
        known: names of their parameters.

    Example:
        >>> given = ["--ros-args", "-p", "presure_cap:=2e4"]
        >>> judge_given_parameters(given, ["/spiral_gripper"], ["pressure.cap"]).errors
        ['presure_cap is not a parameter of this node; did you mean pressure.cap?']
    """
    findings = Findings()
    for option, value in _options(args):
        if option == "--params-file":
            _judge_file(Path(value), nodes, known, findings)
            continue
        target, separator, name = value.partition(":=")[0].rpartition(":")  # node:name:=value
        own = [node.rpartition("/")[2] for node in nodes]
        if separator and target not in own:
            findings.errors.append(f"{target} is no node of this process: {', '.join(own)}")
        else:
            findings.errors += _unknown([name], known)
    return findings


def _judge_file(
    path: Path, nodes: Sequence[str], known: Collection[str], findings: Findings
) -> None:
    try:
        content = YAML(typ="safe").load(path)
    except (OSError, YAMLError) as error:
        findings.errors.append(f"{path} cannot be read: {error}")
        return
    sections = list(_sections(content, ""))
    applied = [(key, names) for key, names in sections if _applies(key, nodes)]
    if not applied:
        keys = ", ".join(key for key, _ in sections) or "nothing"
        findings.errors.append(
            f"{path} has no parameters for {' or '.join(nodes)}, only for {keys}; "
            f"/**/{nodes[0].rpartition('/')[2]} names the node in any namespace"
        )
    for key, names in applied:
        problems = [f"{path}: {problem}" for problem in _unknown(names, known)]
        is_for_all = set(key) <= {"/", "*"}
        (findings.warnings if is_for_all else findings.errors).extend(problems)


def _options(args: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Return the options of ``--ros-args`` that give parameters, with their values."""
    is_ros = False
    for argument, following in zip_longest(args, args[1:], fillvalue=""):
        if argument in ("--ros-args", "--"):
            is_ros = argument == "--ros-args"
        elif is_ros and argument in ("-p", "--param", "--params-file"):
            yield argument, following


def _sections(content: Any, prefix: str) -> Iterator[tuple[str, list[str]]]:  # noqa: ANN401
    """Return every node's name or pattern in a file, and the names of its parameters."""
    if not isinstance(content, Mapping):
        return
    for key, value in content.items():
        if key == _PARAMETERS:
            yield prefix or "/", list(_names(value))
        else:
            yield from _sections(value, f"{prefix}/{str(key).strip('/')}")


def _names(values: Any, prefix: str = "") -> Iterator[str]:  # noqa: ANN401
    """Return the names of parameters, those of nested namespaces with dots."""
    for name, value in values.items() if isinstance(values, Mapping) else ():
        if isinstance(value, Mapping):
            yield from _names(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}"


def _applies(pattern: str, nodes: Sequence[str]) -> bool:
    """Return whether a section is for one of some nodes; ``**`` stands for any namespaces."""
    name = re.escape(pattern).replace(r"/\*\*", "(/[^/]+)*").replace(r"\*", "[^/]+")
    return any(re.fullmatch(name, node) for node in nodes)


def _unknown(names: Sequence[str], known: Collection[str]) -> list[str]:
    """Return a line for each name that is not known."""
    problems = []
    for name in names:
        if name in known or name == "use_sim_time" or name.startswith("qos_overrides"):
            continue
        near = get_close_matches(name, known, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        problems.append(f"{name} is not a parameter of this node{hint}")
    return problems
