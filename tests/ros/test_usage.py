# SPDX-License-Identifier: Apache-2.0
"""The help of the programs names every parameter, and nothing is started."""

import re

import pytest

from spiral_gripper_ros.node.main import main as node
from spiral_gripper_ros.parameters.table import PARAMETERS
from spiral_gripper_ros.regulators.main import main as regulator
from spiral_gripper_ros.regulators.parameters import REGULATOR_PARAMETERS
from spiral_gripper_ros.simulation.main import main as simulator
from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters

SIMULATED = SimulatedRegulatorParameters.specs() + RadiusParameters.specs()


@pytest.mark.parametrize(
    ("main", "option", "specs"),
    [
        (node, "-h", PARAMETERS),
        (regulator, "--help", REGULATOR_PARAMETERS),
        (simulator, "--help", SIMULATED),
    ],
)
def test_help_is_printed_and_no_node_started(main, option, specs, capsys):
    assert main([option]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("usage: spiral_gripper_")
    assert captured.err == ""
    told = dict(re.findall(r"^  ([\w.]+) \((.*?)\): ", captured.out, re.MULTILINE))
    assert all(spec.span in told[spec.name] for spec in specs)
    assert all(("fixed" in told[spec.name]) is spec.read_only for spec in specs)
