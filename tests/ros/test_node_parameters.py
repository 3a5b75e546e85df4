# SPDX-License-Identifier: Apache-2.0
"""Parameters of a node in this process: refused, or in effect at once; another gripper too."""

import math
import os
from pathlib import Path

import pytest
import yaml
from geometry_msgs.msg import Vector3, Vector3Stamped
from rcl_interfaces.msg import Parameter as ParameterMessage
from rclpy.parameter import Parameter, get_parameter_value, parameter_value_to_python
from ros.control_bench import rows
from ros.harness import deliver, serve, tick, tick_until
from ros.local_nodes import change, offer, parameters

from spiral_core import WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.storage import LARGEST_FILE
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.parameters.table import PARAMETERS

RADIUS = 0.02
OTHER = "prototype_p1"
DESCRIPTION = (GRIPPERS.path / f"{OTHER}.yaml").read_text()
UPRIGHT = (0.0, 0.0, -9.80665)


def follow(node, wanted):
    """Offer a radius until the control logic is as it should be; return how it is then."""

    def is_wanted():
        offer(node, RADIUS)
        return wanted(node.runtime.control.snapshot())

    tick_until(node, is_wanted)
    return node.runtime.control.snapshot()


@pytest.mark.usefixtures("wrapped")
def test_what_the_node_dumps_loads_and_the_grip_is_kept(node):
    """As `ros2 param load` does: each value as YAML, read again, set by itself."""
    # A grip that is solved meanwhile would decide the pressure.
    given = {"gravity__vector": [math.nan] * 3, "grip__contact": False}
    change(node, radius__hysteresis=1.0e-5, **given)
    tick(node)
    held = node.published[-1]
    names = [spec.name for spec in PARAMETERS if not spec.read_only]
    values = [
        parameter_value_to_python(p.get_parameter_value()) for p in node.get_parameters(names)
    ]
    dumped = yaml.safe_load(yaml.dump(dict(zip(names, values, strict=True))))
    assert None not in dumped.values()  # `ros2 param dump` would end at one
    for name, value in dumped.items():
        message = ParameterMessage(name=name, value=get_parameter_value(str(value)))
        (result,) = node.set_parameters([Parameter.from_parameter_msg(message)])
        assert result.successful, (name, value, result.reason)
        tick(node)
        assert node.published[-1] == held > 0.0


# Name, value, why it is refused.
BAD = """
radius.timeout .nan out of range
publish.backbone_points 1 out of range
radius.timeout_policy panic one of hold, vent, ramp_down
gravity.vector [0.0,0.0,-981.0] norm at most
frame_id elsewhere read-only
gripper no_such_gripper no gripper has this name
gripper ./nowhere.yaml there is no such file
gripper ./pipe.yaml not a plain file
gripper ./long.yaml more than 2 MB
gripper ./wrong.yaml lenght
gripper ./passwd holds none of a description's fields
gripper . it is a folder
"""


@pytest.mark.usefixtures("wrapped")
def test_a_bad_value_is_refused_with_the_reason_and_changes_nothing(node, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.yaml")  # which does not hold up the node
    os.truncate(os.open("long.yaml", os.O_CREAT | os.O_WRONLY), LARGEST_FILE + 1)
    Path("wrong.yaml").write_text(DESCRIPTION.replace("length:", "lenght:", 1))
    Path("passwd").write_text("root:secret:0:0\n")
    change(node, grip__contact=False)
    tick(node)
    names = [spec.name for spec in PARAMETERS]
    before, held = str(node.get_parameters(names)), node.published[-1]
    for row in rows(BAD):
        name, value, reason = row.split(" ", 2)
        (result,) = node.set_parameters(parameters(**{name: yaml.safe_load(value)}))
        assert (result.successful, reason in result.reason) == (False, True), row
        assert "root:" not in result.reason
    tick(node)
    assert (str(node.get_parameters(names)), node.published[-1]) == (before, held)


def test_another_gripper_vents_and_is_followed_after_rearm_unless_it_cannot_coil(node, tmp_path):
    """Of the same file, which is read anew; its limit is the cap. Gravity that was told is kept."""
    file, limit = tmp_path / "mine.yaml", "pressure_max: 16 psi"
    control = node.runtime.control

    def load(largest):
        file.write_text(DESCRIPTION.replace(limit, f"pressure_max: {largest}", 1))
        change(node, gripper=str(file))
        assert node.published[-1] == 0.0
        tick_until(node, lambda: not node.runtime.loaded.is_loading)
        seen = follow(node, lambda _: True)
        assert node.published[-1] == 0.0
        return seen.state, seen.refusal, serve(node, "rearm", None)

    deliver(node, "gravity", Vector3Stamped(vector=Vector3(z=-9.80665)))
    follow(node, lambda seen: seen.pressure_command > 0.0)
    state, refusal, answer = load("60 kPa")
    assert (state, refusal.reason) == (State.RELEASED, Reason.RECONFIGURED)
    assert answer.success
    assert node.runtime.limits.pressure_cap == pytest.approx(6.0e4)
    other = load_gripper(file)
    for mount in (UPRIGHT, other.gravity):
        curve = WrapCurve(other.with_mount(mount, None))
        wanted = pytest.approx(curve.pressure_from_radius(RADIUS), rel=1e-9)
        follow(node, lambda seen, wanted=wanted: seen.pressure_target == wanted)
        given = parameters(gripper=str(file), gravity__vector=list(map(float, other.gravity)))
        assert node.set_parameters_atomically(given).successful
    state, refusal, answer = load("1 kPa")
    assert (state, refusal.reason) == (State.FAULT, Reason.INTERNAL_ERROR)
    assert "cannot be used" in refusal.text
    assert (answer.success, "turns" in answer.message) == (False, True)
    assert control.snapshot().state is State.FAULT
    state, refusal, answer = load("60 kPa")
    assert (state, answer.success) == (State.FAULT, True)
    follow(node, lambda seen: seen.pressure_command > 0.0)
