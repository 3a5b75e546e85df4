# SPDX-License-Identifier: Apache-2.0
"""What every process of this package shares: help, signals, start of ROS, exit code.

Slow imports are left to the program itself, so that an early signal still ends the process cleanly.
"""

from __future__ import annotations

import atexit
import gc
import os
import sys
from collections.abc import Mapping, MutableMapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from spiral_gripper_ros.process.stop_signals import StopSignals

if TYPE_CHECKING:
    from spiral_gripper_ros.parameters.spec import ParameterSpec
    from spiral_gripper_ros.process.guards import GuardedLoop

MadeT = TypeVar("MadeT")

HELP_OPTIONS = frozenset({"-h", "--help"})


class Program(Protocol[MadeT]):
    """The program of one process of this package.

    Attributes:
        executable: the name that it is started by.
        about: what it is, and its topics, for the help text.
    """

    executable: str
    about: str

    def parameters(self) -> Mapping[str, Sequence[ParameterSpec]]:
        """Return its tables of parameters, each under its heading in the help text."""
        ...

    def make(self) -> MadeT:
        """Make the node, after ROS has started: with ``errors``, and others in ``nodes`` if any."""
        ...

    def spin(self, made: MadeT, loop: GuardedLoop, signals: StopSignals, /) -> int:
        """Turn the loop until a stop is requested; return the exit code."""
        ...


def usage(program: Program[MadeT]) -> str:
    """Return the help text, with every parameter."""
    lines = [
        f"usage: {program.executable} [--help] [--ros-args -p NAME:=VALUE ... -r FROM:=TO ...]",
        f"\n{program.about}",
    ]
    for heading, table in program.parameters().items():
        lines.append(f"{heading} (with their defaults and ranges):")
        for spec in table:
            unset = spec.default == () or spec.default != spec.default
            default = "not set" if unset else spec.default
            values = (str(default), spec.span, "fixed at the start" if spec.read_only else "")
            lines.append(f"  {spec.name} ({'; '.join(filter(None, values))}): {spec.description}")
        lines.append("")
    lines.append("`ros2 param describe` describes each parameter of the running node.\n")
    return "\n".join(lines)


def run(program: Program[MadeT], args: list[str] | None) -> int:
    """Show the help that is asked for, or run until SIGINT or SIGTERM.

    Args:
        program: what runs.
        args: the command line's arguments; None: those of this process.

    Returns:
        The process's exit code.
    """
    given = sys.argv[1:] if args is None else args
    if not HELP_OPTIONS.isdisjoint(given):
        sys.stdout.write(usage(program))
        return 0
    signals = StopSignals()
    # What a start makes stays: collections would look through it again and again, and once more
    # before the interpreter ends. Without them start and end take two thirds of their time.
    gc.disable()
    atexit.register(gc.freeze)
    try:
        return _run(program, signals, given)
    except KeyboardInterrupt:
        return 0
    finally:
        gc.enable()
        signals.ignore()


def _run(program: Program[MadeT], signals: StopSignals, given: list[str]) -> int:
    """Start ROS without signal handlers of its own, make what runs and run it.

    An argument that no part of the program reads is refused: it may be a limit that was given
    without ``--ros-args``.
    """
    import rclpy
    from rclpy.exceptions import ParameterException
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.impl.implementation_singleton import rclpy_implementation as rcl
    from rclpy.logging import get_logger
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import remove_ros_args

    from spiral_core.errors import SpiralError
    from spiral_gripper_ros.process.guards import GuardedLoop

    # What ROS raises when it cannot start, or cannot make a node: for lack of keys, say.
    ros_errors = (rcl.RCLError, rcl.RCLInvalidROSArgsError, rcl.UnknownROSArgsError)
    choose_transport(os.environ)
    problem = ""
    try:
        unread = remove_ros_args(["", *given])[1:]
        if unread:
            problem = (
                f"unknown arguments: {' '.join(unread)}; parameters are given as "
                "--ros-args -p NAME:=VALUE, see --help"
            )
        else:
            rclpy.init(args=["", *given], signal_handler_options=SignalHandlerOptions.NO)
    except ros_errors as error:
        problem = f"ROS does not start: {error}"
    if problem:
        sys.stderr.write(f"{program.executable}: {problem}\n")
        return 1
    try:
        try:
            made = program.make()
        except (ParameterException, SpiralError, ValueError, *ros_errors) as error:
            get_logger(program.executable).fatal(f"cannot start: {error}")
            return 1
        nodes: Sequence[Any] = getattr(made, "nodes", (made,))
        executor = SingleThreadedExecutor()
        try:
            if not _parameters_are_known(given, nodes):
                return 1
            gc.enable()
            for node in nodes:
                executor.add_node(node)
            return program.spin(made, GuardedLoop(nodes[0].errors, executor), signals)
        finally:
            executor.shutdown()
            for node in nodes:
                node.destroy_node()
    finally:
        rclpy.try_shutdown()


def choose_transport(environ: MutableMapping[str, str]) -> None:
    """Let Fast DDS use UDP only, unless the environment says otherwise.

    Over shared memory a publication waits when other processes come and go: gaps of 0.3 to 0.7 s
    between commands were measured, with UDP at most 0.1 s.
    """
    profiles = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
    if not any(name in environ for name in profiles):
        environ.setdefault("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")


def _parameters_are_known(given: Sequence[str], nodes: Sequence[Any]) -> bool:
    """Return whether every parameter given at start exists; the log says which does not."""
    from spiral_gripper_ros.parameters.given import judge_given_parameters

    known = {node.get_fully_qualified_name(): node.list_parameters([], 0).names for node in nodes}
    findings = judge_given_parameters(given, known)
    for warning in findings.warnings:
        nodes[0].get_logger().warning(warning)
    for error in findings.errors:
        nodes[0].get_logger().fatal(f"cannot start: {error}")
    return not findings.errors
