# SPDX-License-Identifier: Apache-2.0
"""`spiral-gripper simulate`, as people start it, watch it, break it and stop it."""

import os
import shlex
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
from ros.programs import PROGRAM, line_with, rest_of, start

from spiral_gripper.cli.main import run
from spiral_gripper.cli.ros import side as ros_side
from spiral_gripper.cli.ros import simulate as cli_simulate
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import Fault
from spiral_gripper_ros.tools.injection import injection_name

# Command and measurement are heard, and the node believes that the object is held.
WRAPPED = r"\d +\d+\.\d\d +perfect wrap  yes"
VENTED = "vented; node and simulator have ended"


def test_it_runs_for_its_duration_and_ends_vented(tmp_path):
    path = shutil.copy(GRIPPERS.path / "prototype_p1.yaml", tmp_path / 'it\'s "1" #🐙: .yaml')
    with start(PROGRAM, "simulate", path, "--duration", "1", "--noise", "0.01 mm") as process:
        code, said = rest_of(process)
    assert (code, said.rstrip().endswith(VENTED), "\x1b" in said) == (0, True, False), said


@pytest.mark.slow
def test_a_fault_is_injected_from_another_terminal_and_control_c_ends_it_vented(simulation):
    # The command is printed as it is to be pasted.
    pasted = shlex.split(line_with(simulation, "inject leak"))
    line_with(simulation, WRAPPED)
    injected = subprocess.run(pasted, capture_output=True, text=True, check=True, cwd="/")
    assert (injected.stdout, injected.stderr) == ("fault: leak\n", "")
    line_with(simulation, "leak, weak supply")
    code, said = rest_of(simulation, signal.SIGINT)
    assert (code, said.rstrip().endswith(VENTED)) == (0, True), said


def test_control_c_at_the_very_start_is_no_failure(simulation):
    line_with(simulation, "inject leak")  # the children have not installed their handlers yet
    assert rest_of(simulation, signal.SIGINT)[0] == 0


def test_nothing_runs_on_after_the_command_was_killed(simulation):
    line_with(simulation, "inject leak")
    simulation.kill()
    rest_of(simulation)


@pytest.mark.slow
def test_a_process_that_ends_by_itself_is_an_error_and_its_log_is_shown(simulation):
    line_with(simulation, WRAPPED)
    children = Path(f"/proc/{simulation.pid}/task/{simulation.pid}/children").read_text()
    os.kill(int(children.split()[1]), signal.SIGKILL)
    code, said = rest_of(simulation)
    assert code == 1
    for words in ("the node has ended by itself, with exit code -9", "the last command was"):
        assert words in said
    assert "grips radii from" in said  # from the log


@pytest.mark.parametrize("missing", ros_side.ROS_SIDE)
def test_without_ros_it_says_so_in_one_line(missing, monkeypatch, capsys):
    found = ros_side.find_spec
    monkeypatch.setattr(ros_side, "find_spec", lambda n: None if n == missing else found(n))
    assert run(["simulate"]) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err.count("\n")) == ("", 1)
    assert f"{missing} is not installed" in captured.err


def test_the_command_takes_what_the_simulator_takes_and_names_what_is_there():
    assert set(cli_simulate.FAULTS) == {fault.value for fault in Fault}
    high = {spec.name: spec.high for spec in RadiusParameters.specs()}
    most = {
        option.name: getattr(option.type, "most", "") for option in cli_simulate.simulate.params
    }
    assert most["radius"] == f"{high['radius']:g} m"
    assert most["noise"] == f"{high['estimate_noise']:g} m"
    for space, full in (("/", ""), ("left/", "/left")):
        assert injection_name(space, Fault.NONE) == f"{full}/simulated_regulator/clear_fault"
