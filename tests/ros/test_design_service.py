# SPDX-License-Identifier: Apache-2.0
"""`design_gripper`, asked from another process: the numbers of the Python call, to the last."""

import contextlib
import math
import os
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml
from geometry_msgs.msg import Vector3
from ros.harness import DEADLINE, DESIGN_DEADLINE, PATIENT, RunningNode, design_request
from ros.records import agrees, told
from std_srvs.srv import Trigger

from spiral_core import (
    DesignRequirement,
    Elastomer,
    MooneyRivlin,
    SpiralError,
    TubeSize,
    design_gripper,
)
from spiral_gripper import load_description
from spiral_gripper_msgs.srv import DesignGripper
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.node.design_service import fill_response, requirement_from_msg

SMALLEST, LARGEST = 0.011, 0.030
HANGING = (9.80665, 0.0, 0.0)
DESCRIPTION = load_description("paper_design_70")


def requirement(**fields):
    return requirement_from_msg(design_request(SMALLEST, LARGEST, **fields), HANGING, DESCRIPTION)


def asked(client, **fields):
    request = design_request(SMALLEST, LARGEST, **fields)
    return client.call(DesignGripper, "design_gripper", request, DESIGN_DEADLINE)


def test_the_responses_about_reports_are_those_on_record():
    """The shipped grippers' constants are of the law for straight fibers."""
    asked = DesignRequirement(
        radius_min=SMALLEST,
        radius_max=LARGEST,
        tubes=(TubeSize("3/8 in x 1/32 in", 4.7625e-3, 0.79375e-3),),
        elastomers=(Elastomer("section latex", MooneyRivlin(95.0e3, 10.0e3), 950.0),),
        fiber_angles_beta=(math.radians(70.0),),
        fiber_angles_gamma=(math.radians(2.0),),
    )
    found = []
    for length_max in (None, 0.2):
        report = design_gripper(replace(asked, length_max=length_max))
        answer = fill_response(DesignGripper.Response(), report)
        # What differs if the gripper is shorter.
        found += [line for line in told(answer).splitlines() if line not in found]
    agrees("designs", "\n".join(found))


def test_a_design_is_the_python_call_to_the_last_digit(active):
    fields = {"fiber_angles_beta": [math.radians(70.0)], "object_length": 0.25}
    answer = asked(active, **fields)
    report = design_gripper(requirement(**fields))
    assert answer == fill_response(DesignGripper.Response(), report)
    assert answer.success


REQUESTS = """
- {}
- {tubing: natural_latex, preference: least_pressure}
- {object_length: 0.2, length_max: 0.5, pressure_max: 1.2e+5, strain_max: 0.4, turns_required: 1.2,
  fiber_angle_alpha: 1.5, end_allowance: 0.03, tube_inner_radii: [4.0e-3, 5.0e-3],
  tube_wall_thicknesses: [1.0e-3, 0.8e-3], fiber_angles_beta: [1.0, 1.25],
  gravity: [{x: 9.7, z: -1.0}], object_axis: [{x: 1.6, z: -1.2}]}
- {end_allowance: 0.0}
- {fiber_angles_gamma: [0.03]}
- {tubing: silicone}
- {tube_inner_radii: [0.004]}
- {tubing: natural_latex, tube_inner_radii: [0.004], tube_wall_thicknesses: [0.001]}
- {preference: cheapest}
- {tube_inner_radii: &many [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1],
  tube_wall_thicknesses: *many, fiber_angles_beta: *many, fiber_angles_gamma: [1, 1, 1, 1]}
- {object_axis: [{}]}
- {gravity: [{x: 51.0}]}
"""


def test_a_request_is_the_requirement_or_the_refusal_on_record():
    found = []
    for request in yaml.safe_load(REQUESTS):
        for vector in {"gravity", "object_axis"} & request.keys():
            request[vector] = [Vector3(**one) for one in request[vector]]
        try:
            found.append(told(requirement(**request)))
        except SpiralError as error:
            found.append(str(error))
    agrees("requirements", "\n".join(found))


def test_a_refusal_is_the_answer_and_no_file_is_opened(active, tmp_path):
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    active.wrap(0.02)
    answer = asked(active, tubing=str(pipe))
    assert not answer.success
    assert "tubing must be a shipped list: natural_latex" in answer.message
    assert active.status.state == State.TRACKING


# --- a design of minutes -----------------------------------------------------------------------


def design_processes(node):
    """Return the process ids of the designs that a node computes, whichever thread began them."""
    found = []
    for task in Path(f"/proc/{node.pid}/task").iterdir():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # both come and go
            found += [
                int(child)
                for child in (task / "children").read_text().split()
                if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()
            ]
    return found


def begin_long_design(client, node):
    """Ask for a design of minutes; return its answer to come, and the process that computes it."""
    angles = np.linspace(0.9, 1.4, 140).tolist()
    request = design_request(SMALLEST, LARGEST, fiber_angles_beta=angles, tubing="natural_latex")
    service = client.create_client(DesignGripper, "design_gripper")
    assert service.wait_for_service(DEADLINE)
    client.wait_until(lambda: not design_processes(node), "the end of earlier ones")
    answer = service.call_async(request)
    client.wait_until(lambda: design_processes(node), "its process")
    return answer, *design_processes(node)


def wait_for_the_end(client, process_id):
    client.wait_until(lambda: not Path(f"/proc/{process_id}").exists(), "its process's end")


def test_the_node_goes_on_during_a_design_that_is_killed_or_canceled(active, shared_node):
    for end, message in (
        (lambda process_id: os.kill(process_id, signal.SIGKILL), "its process was killed"),
        (lambda _: active.call(Trigger, "cancel_design").success, "no design: canceled"),
    ):
        answer, worker = begin_long_design(active, shared_node)
        active.wrap(0.02)
        active.hear_more(50)
        assert active.plan_wrap(0.02).success
        assert not answer.done()
        end(worker)
        active.wait_until(answer.done, "an answer")
        assert not answer.result().success
        assert message in answer.result().message
        wait_for_the_end(active, worker)
    assert not active.call(Trigger, "cancel_design").success


def test_a_design_ends_with_its_node(client, namespace):
    with RunningNode(namespace, PATIENT) as node:
        client.wait_until_active()
        answer, worker = begin_long_design(client, node)
        assert not answer.done()
        assert node.stop() == 0, node.log()
        assert "Traceback" not in node.log()
        wait_for_the_end(client, worker)
