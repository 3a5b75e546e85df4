# SPDX-License-Identifier: Apache-2.0
"""`design_gripper`, asked from another process: the numbers of the Python call, to the last."""

import contextlib
import math
import os
import re
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from geometry_msgs.msg import Vector3
from ros.harness import DEADLINE, DESIGN_DEADLINE, PATIENT, RunningNode, design_request
from std_srvs.srv import Trigger

from spiral_core import (
    DesignRequirement,
    Elastomer,
    MooneyRivlin,
    Preference,
    SpiralError,
    TubeSize,
    design_gripper,
)
from spiral_gripper import load_description, load_tubing
from spiral_gripper.files.description import parse_description
from spiral_gripper_msgs.srv import DesignGripper
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.node.design_service import FIELD_NAMES, fill_response, requirement_from_msg

SMALLEST, LARGEST = 0.011, 0.030
HANGING = (9.80665, 0.0, 0.0)
DESCRIPTION = load_description("paper_design_70")


def requirement(**fields):
    return requirement_from_msg(design_request(SMALLEST, LARGEST, **fields), HANGING, DESCRIPTION)


def asked(client, **fields):
    request = design_request(SMALLEST, LARGEST, **fields)
    return client.call(DesignGripper, "design_gripper", request, DESIGN_DEADLINE)


def pick(of, path, *default):
    """Return what a path of attributes leads to, for each where there are several."""
    for part in path.split("."):
        of = (
            [getattr(o, part) for o in of] if isinstance(of, tuple) else getattr(of, part, *default)
        )
    return of


def assert_same(message, of, named):
    """Compare a message with its origin: what has the same name, and what is named name=path."""
    own = dict(pair.split("=") for pair in named.split())
    for name in message.get_fields_and_field_types():
        told = getattr(message, name)
        expected = pick(of, own[name]) if name in own else pick(of, name, None)
        if name in OF_PARTS and expected is not None:
            for part, origin in zip(told, expected, strict=True):
                assert_same(part, origin, OF_PARTS[name])
        elif isinstance(expected, str | float | int):
            assert told == FIELD_NAMES.get(expected, expected), name
        elif name in own:
            assert list(told) == expected, name


OF_PARTS = {
    "changes": "",
    "windings": "",
    "steps": "names=figures.name values=figures.value units=figures.unit",
    "margins": "constraint=constraint.value unit=constraint.unit met=is_met",
}
OF_THE_REPORT = """
success=feasible binding_constraint=binding.constraint.value binding_value=binding.value
binding_limit=binding.bound changes=relaxations
"""
OF_THE_DESIGN = """
tube=tube.name tube_inner_radius=tube.inner_radius tube_wall_thickness=tube.wall_thickness
material=elastomer.name length_helix=helix_length pressure_max=gripper.pressure_max
fiber_angle_alpha=actuator.fiber_pair.alpha fiber_angle_beta=actuator.fiber_pair.beta
strain_at_radius_max=largest.strain strain_at_radius_min=smallest.strain
pressure_at_radius_max=largest.pressure pressure_at_radius_min=smallest.pressure
chart_radius=curve.radius chart_pressure=curve.pressure
turns_at_radius_max=largest.turns turns_at_radius_min=smallest.turns
object_length_at_radius_max=largest.object_length object_length_at_radius_min=smallest.object_length
"""


# The shipped grippers' constants are of the law for straight fibers.
@pytest.mark.parametrize("length_max", [None, 0.2])
def test_every_figure_of_a_report_is_in_the_response(length_max):
    report = design_gripper(
        DesignRequirement(
            radius_min=SMALLEST,
            radius_max=LARGEST,
            tubes=(TubeSize("3/8 in x 1/32 in", 4.7625e-3, 0.79375e-3),),
            elastomers=(Elastomer("section latex", MooneyRivlin(95.0e3, 10.0e3), 950.0),),
            fiber_angles_beta=(math.radians(70.0),),
            fiber_angles_gamma=(math.radians(2.0),),
            length_max=length_max,
        )
    )
    answer, design = fill_response(DesignGripper.Response(), report), report.design
    assert_same(answer, report, OF_THE_REPORT)
    assert_same(answer, design, OF_THE_DESIGN)
    assert answer.success is (length_max is None)
    assert answer.design_known
    assert answer.fiber_angle_gamma == math.radians(2.0)
    assert answer.candidates_solved == 1
    assert bool(answer.changes) == (answer.description == "") == (not report.feasible)


def test_a_design_is_the_python_call_to_the_last_digit(active):
    fields = {"fiber_angles_beta": [math.radians(70.0)], "object_length": 0.25}
    answer = asked(active, **fields)
    report = design_gripper(requirement(**fields))
    assert answer == fill_response(DesignGripper.Response(), report)
    assert answer.success
    assert parse_description(answer.description, Path("designed.yaml")).gripper.tube.length > 0.0


NUMBERS = """
{object_length: 0.2, length_max: 0.5, pressure_max: 1.2e+5, strain_max: 0.4, turns_required: 1.2,
fiber_angle_alpha: 1.5, end_allowance: 0.03}
"""


def test_a_request_is_a_requirement_of_the_gripper_but_for_what_it_says():
    actuator, gripper, density = DESCRIPTION.actuator, DESCRIPTION.gripper, DESCRIPTION.density
    tube, law = actuator.tube, actuator.pressure_law
    own = DesignRequirement(
        SMALLEST,
        LARGEST,
        tubes=(TubeSize("9.525 x 0.794 mm", tube.inner_radius, tube.wall_thickness),),
        elastomers=(Elastomer(gripper.name, actuator.material, density, law),),
        fiber_angle_alpha=actuator.fibers.alpha,
        pressure_max=gripper.pressure_max,
        gravity=HANGING,
    )
    assert requirement() == own
    tubing = load_tubing("natural_latex")
    listed = replace(own, tubes=tubing.sizes, elastomers=(tubing.elastomer,))
    assert requirement(tubing="natural_latex") == listed
    numbers = yaml.safe_load(NUMBERS)
    assert requirement(
        tube_inner_radii=[4.0e-3, 5.0e-3],
        tube_wall_thicknesses=[1.0e-3, 0.8e-3],
        fiber_angles_beta=[1.0, 1.25],
        gravity=[Vector3(x=9.7, z=-1.0)],
        object_axis=[Vector3(x=1.6, z=-1.2)],
        preference="least_pressure",
        **numbers,
    ) == replace(
        own,
        tubes=(TubeSize("8 x 1 mm", 4.0e-3, 1.0e-3), TubeSize("10 x 0.8 mm", 5.0e-3, 0.8e-3)),
        fiber_angles_beta=(1.0, 1.25),
        gravity=(9.7, 0.0, -1.0),
        object_axis=(0.8, 0.0, -0.6),
        preference=Preference.LEAST_PRESSURE,
        **numbers,
    )


REFUSED = """
end_allowance must be positive where it is given: {end_allowance: 0.0}
constants of the section law: {fiber_angles_gamma: [0.03]}
natural_latex: {tubing: silicone}
tube_wall_thicknesses: {tube_inner_radii: [0.004]}
tubing: {tubing: natural_latex, tube_inner_radii: [0.004], tube_wall_thicknesses: [0.001]}
preference: {preference: cheapest}
"""
MANY = dict.fromkeys(("tube_inner_radii", "tube_wall_thicknesses", "fiber_angles_beta"), [1.0] * 45)


@pytest.mark.parametrize(
    ("reason", "fields"),
    [
        *yaml.safe_load(REFUSED).items(),
        ("at most 2000, got '45 x 45 x 1'", MANY),
        ("object_axis", {"object_axis": [Vector3()]}),
        ("gravity must be 3 finite numbers", {"gravity": [Vector3(x=51.0)]}),
    ],
)
def test_a_request_that_cannot_be_is_refused_with_the_reason(fields, reason):
    with pytest.raises(SpiralError, match=re.escape(reason)):
        requirement(**fields)


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
    for task in Path(f"/proc/{node.process_id}/task").iterdir():
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
