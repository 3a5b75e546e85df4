# SPDX-License-Identifier: Apache-2.0
"""Detection of parameters given at start that no node of the process has, such as typing errors.

rclpy ignores such names, and a file for another node, without a warning: a pressure cap in it would
be lost.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from itertools import chain, zip_longest
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


def judge_given_parameters(args: Sequence[str], nodes: Mapping[str, Collection[str]]) -> Findings:
    """Return what is wrong with the parameters that a command line gives to some nodes.

    Args:
        args: of the process.
        nodes: names of the parameters of each of the process's nodes, by the node's full name.

    Example:
        >>> given = ["--ros-args", "-p", "presure_cap:=2e4"]
        >>> judge_given_parameters(given, {"/spiral_gripper": ["pressure.cap"]}).errors
        ['presure_cap is not a parameter of this node; did you mean pressure.cap?']
    """
    findings, own = Findings(), {name.rpartition("/")[2]: known for name, known in nodes.items()}
    for option, value in _options(args):
        if option == "--params-file":
            _judge_file(Path(value), nodes, findings)
            continue
        target, separator, name = value.partition(":=")[0].rpartition(":")  # node:name:=value
        if separator and target not in own:
            findings.errors.append(f"{target} is no node of this process: {', '.join(own)}")
        else:
            findings.errors += _unknown([name], [own[target]] if target else own.values())
    return findings


def _judge_file(path: Path, nodes: Mapping[str, Collection[str]], findings: Findings) -> None:
    try:
        content = YAML(typ="safe").load(path)
    except (OSError, YAMLError) as error:
        findings.errors.append(f"{path} cannot be read: {error}")
        return
    sections = list(_sections(content, ""))
    applied = False
    for key, names in sections:
        tables = [known for node, known in nodes.items() if _applies(key, node)]
        applied = applied or bool(tables)
        problems = [f"{path}: {problem}" for problem in _unknown(names, tables)] if tables else []
        is_for_all = set(key) <= {"/", "*"}
        (findings.warnings if is_for_all else findings.errors).extend(problems)
    if not applied:
        keys = ", ".join(key for key, _ in sections) or "nothing"
        findings.errors.append(
            f"{path} has no parameters for {' or '.join(nodes)}, only for {keys}; "
            f"/**/{next(iter(nodes)).rpartition('/')[2]} names the node in any namespace"
        )


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


def _applies(pattern: str, node: str) -> bool:
    """Return whether a section is for a node; ``**`` stands for any namespaces."""
    name = re.escape(pattern).replace(r"/\*\*", "(/[^/]+)*").replace(r"\*", "[^/]+")
    return re.fullmatch(name, node) is not None


def _unknown(names: Sequence[str], tables: Iterable[Collection[str]]) -> list[str]:
    """Return a line for each name that is in no table."""
    problems, known = [], list(chain(*tables))
    for name in names:
        if name in known or name.startswith("qos_overrides"):
            continue
        near = get_close_matches(name, known, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        problems.append(f"{name} is not a parameter of this node{hint}")
    return problems
