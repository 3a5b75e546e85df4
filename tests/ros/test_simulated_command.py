# SPDX-License-Identifier: Apache-2.0
"""`spiral-gripper simulate`, as people start it, watch it, break it and stop it."""

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from ros.harness import DEADLINE
from ros.programs import SIMULATE, wait_for_the_end_of

from spiral_gripper.cli.main import run
from spiral_gripper.cli.ros import side as ros_side
from spiral_gripper.cli.ros import simulate as cli_simulate
from spiral_gripper.cli.ros.simulate import FAULTS
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import Fault
from spiral_gripper_ros.tools.injection import injection_name
from spiral_gripper_ros.tools.simulate import program

# Command and measurement are heard, and the node believes that the object is held.
WRAPPED = r"\d +\d+\.\d\d +perfect wrap  yes"


def read_until(process, pattern):
    """Return the lines up to the first that has a part like a pattern."""
    lines = []
    for line in process.stdout:
        lines.append(line)
        if re.search(pattern, line):
            return lines
    raise AssertionError(f"no {pattern!r} in {''.join(lines)}")


def child_running(process, module):
    """Return the id of the child process that runs a module."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    (found,) = [
        int(child)
        for child in children
        if module in Path(f"/proc/{child}/cmdline").read_bytes().decode().split("\0")
    ]
    return found


def test_it_runs_for_its_duration_and_ends_vented():
    done = subprocess.run(
        [*SIMULATE, "--duration", "1", "--noise", "0.01 mm"],
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "inject leak --namespace" in done.stdout
    assert done.stdout.rstrip().endswith("vented; node and simulator have ended")
    assert "Traceback" not in done.stdout + done.stderr
    assert "\x1b" not in done.stdout


@pytest.mark.slow
def test_a_fault_is_injected_from_another_terminal_and_control_c_ends_it_vented(simulation):
    lines = read_until(simulation, WRAPPED)
    # The command is printed as it is to be pasted.
    (pasted,) = [shlex.split(line) for line in lines if "inject leak" in line]
    injected = subprocess.run(pasted, capture_output=True, text=True, check=False, cwd="/")
    assert injected.returncode == 0, injected.stderr
    assert (injected.stdout, injected.stderr) == ("fault: leak\n", "")
    read_until(simulation, "leak, weak supply")
    os.killpg(simulation.pid, signal.SIGINT)  # as a terminal does: the children get it too
    output = simulation.stdout.read()
    assert simulation.wait(DEADLINE) == 0, output
    assert output.rstrip().endswith("vented; node and simulator have ended")
    assert "Traceback" not in output
    wait_for_the_end_of(simulation.pid)


def test_control_c_at_the_very_start_is_no_failure(simulation):
    read_until(simulation, "inject leak")  # the children have not installed their handlers yet
    os.killpg(simulation.pid, signal.SIGINT)
    output = simulation.stdout.read()
    assert simulation.wait(DEADLINE) == 0, output
    assert "Traceback" not in output


@pytest.mark.slow
def test_a_process_that_ends_by_itself_is_an_error_and_its_log_is_shown(simulation):
    read_until(simulation, WRAPPED)
    os.kill(child_running(simulation, "spiral_gripper_ros.node.main"), signal.SIGKILL)
    output = simulation.stdout.read()
    assert simulation.wait(DEADLINE) == 1
    assert "the node has ended by itself, with exit code -9" in output
    assert "the last command was" in output
    assert "grips radii from" in output  # from the log
    assert "Traceback" not in output


@pytest.mark.parametrize("missing", ros_side.ROS_SIDE)
def test_without_ros_it_says_so_in_one_line(missing, monkeypatch, capsys):
    found = ros_side.find_spec
    monkeypatch.setattr(ros_side, "find_spec", lambda n: None if n == missing else found(n))
    assert run(["simulate"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert f"{missing} is not installed" in captured.err


def test_the_command_takes_what_the_simulator_takes_and_names_what_is_there(tmp_path, monkeypatch):
    assert set(FAULTS) == {fault.value for fault in Fault}
    high = {spec.name: spec.high for spec in RadiusParameters.specs()}
    most = {
        option.name: getattr(option.type, "most", "") for option in cli_simulate.simulate.params
    }
    assert most["radius"] == f"{high['radius']:g} m"
    assert most["noise"] == f"{high['estimate_noise']:g} m"
    assert injection_name("/", Fault.LEAK) == "/simulated_regulator/inject_leak"
    assert injection_name("left/", Fault.LEAK) == "/left/simulated_regulator/inject_leak"
    script = tmp_path / "my tools"
    monkeypatch.setattr(sys, "argv", [str(script)])
    assert program() == "spiral-gripper"
    script.touch(0o755)
    assert shlex.split(program()) == [str(script)]
