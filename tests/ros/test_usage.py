# SPDX-License-Identifier: Apache-2.0
"""The help of the programs names every parameter, and nothing is started."""

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
    ("main", "specs"),
    [(node, PARAMETERS), (regulator, REGULATOR_PARAMETERS), (simulator, SIMULATED)],
)
def test_help_is_printed_and_no_node_started(main, specs, capsys):
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("usage: spiral_gripper_")
    assert all(f"\n  {spec.name} (" in said and spec.span in said for spec in specs)
