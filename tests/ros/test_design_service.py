# SPDX-License-Identifier: Apache-2.0
"""`design_gripper`, asked from another process: the numbers of the Python call, to the last."""

import contextlib
import math
import os
import re
import signal
from dataclasses import replace
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest
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

LIMITS = {
    "object_length": 0.25,
    "turns_required": 1.5,
    "pressure_max": 110316.0,
    "strain_max": 0.3,
}
SMALLEST, LARGEST = 0.011, 0.030
HANGING = (9.80665, 0.0, 0.0)
DESCRIPTION = load_description("paper_design_70")


def requirement(smallest=SMALLEST, largest=LARGEST, **fields):
    request = design_request(smallest, largest, **fields)
    return requirement_from_msg(request, HANGING, DESCRIPTION)


def asked(client, **fields):
    request = design_request(SMALLEST, LARGEST, **fields)
    return client.call(DesignGripper, "design_gripper", request, DESIGN_DEADLINE)


def assert_same(message, of, **own):
    """Compare what a message says with what its origin has by the same names, or with ``own``."""
    for name in message.get_fields_and_field_types():
        if name in own or isinstance(getattr(of, name, None), str | float | int):
            assert getattr(message, name) == own.get(name, getattr(of, name, None)), name


OF_THE_DESIGN = """
tube=tube.name tube_inner_radius=tube.inner_radius tube_wall_thickness=tube.wall_thickness
material=elastomer.name length_helix=helix_length pressure_max=gripper.pressure_max
fiber_angle_alpha=actuator.fiber_pair.alpha fiber_angle_beta=actuator.fiber_pair.beta
strain_at_radius_max=largest.strain strain_at_radius_min=smallest.strain
pressure_at_radius_max=largest.pressure pressure_at_radius_min=smallest.pressure
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
    binding = report.binding
    assert_same(
        answer,
        report,
        success=length_max is None,
        binding_constraint=binding.constraint.value,
        binding_value=binding.value,
        binding_limit=binding.bound,
        candidates_solved=len(report.tried),
    )
    named = (pair.split("=") for pair in OF_THE_DESIGN.split())
    own = {name: attrgetter(path)(design) for name, path in named}
    assert_same(answer, design, **own, design_known=True, fiber_angle_gamma=math.radians(2.0))
    assert bool(answer.changes) == (answer.description == "") == (not report.feasible)
    for found, of in zip(answer.changes, report.relaxations, strict=True):
        assert_same(found, of, field=FIELD_NAMES.get(of.field, of.field))
    for found, of in zip(answer.windings, design.windings, strict=True):
        assert_same(found, of)
    for found, of in zip(answer.margins, design.margins, strict=True):
        assert_same(
            found, of, constraint=of.constraint.value, unit=of.constraint.unit, met=of.is_met
        )
    for found, of in zip(answer.steps, report.steps, strict=True):
        assert_same(found, of)
        told = list(zip(found.names, found.values, found.units, strict=True))
        assert told == [(one.name, one.value, one.unit) for one in of.figures]
    chart = list(zip(answer.chart_radius, answer.chart_pressure, strict=True))
    assert chart == [(point.radius, point.pressure) for point in design.curve]


def test_a_design_is_the_python_call_to_the_last_digit(active):
    fields = LIMITS | {"fiber_angles_beta": [math.radians(70.0)]}
    answer = asked(active, **fields)
    report = design_gripper(requirement(**fields))
    assert answer == fill_response(DesignGripper.Response(), report)
    assert answer.success
    assert parse_description(answer.description, Path("designed.yaml")).gripper.tube.length > 0.0


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
    text = (
        "object_length=0.2 length_max=0.5 pressure_max=1.2e5 strain_max=0.4 turns_required=1.2 "
        "fiber_angle_alpha=1.5 end_allowance=0.03"
    )
    numbers = {name: float(value) for name, value in (word.split("=") for word in text.split())}
    assert requirement(
        0.012,
        0.025,
        tube_inner_radii=[4.0e-3, 5.0e-3],
        tube_wall_thicknesses=[1.0e-3, 0.8e-3],
        fiber_angles_beta=[1.0, 1.25],
        gravity=[Vector3(x=9.7, z=-1.0)],
        object_axis=[Vector3(x=1.6, z=-1.2)],
        preference="least_pressure",
        **numbers,
    ) == replace(
        own,
        radius_min=0.012,
        radius_max=0.025,
        tubes=(TubeSize("8 x 1 mm", 4.0e-3, 1.0e-3), TubeSize("10 x 0.8 mm", 5.0e-3, 0.8e-3)),
        fiber_angles_beta=(1.0, 1.25),
        gravity=(9.7, 0.0, -1.0),
        object_axis=(0.8, 0.0, -0.6),
        preference=Preference.LEAST_PRESSURE,
        **numbers,
    )


TUBE = {"tube_inner_radii": [0.004], "tube_wall_thicknesses": [1e-3]}
MANY = np.linspace(0.9, 1.4, 45).tolist()


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"length_max": 0.0}, "length_max"),
        ({"end_allowance": 0.0}, "end_allowance must be positive where it is given"),
        ({"fiber_angles_gamma": [0.03]}, "constants of the section law"),
        ({"object_axis": [Vector3()]}, "object_axis"),
        ({"gravity": [Vector3(x=51.0)]}, "gravity must be 3 finite numbers"),
        ({"tubing": "silicone"}, "natural_latex"),
        ({"tube_inner_radii": [0.004]}, "tube_wall_thicknesses"),
        ({"tubing": "natural_latex", **TUBE}, "tubing"),
        ({"preference": "cheapest"}, "preference"),
        (
            dict.fromkeys(("tube_inner_radii", "tube_wall_thicknesses", "fiber_angles_beta"), MANY),
            "at most 2000, got '45 x 45 x 1'",
        ),
    ],
)
def test_a_request_that_cannot_be_is_refused_with_the_reason(fields, reason):
    with pytest.raises(SpiralError, match=re.escape(reason)):
        requirement(**fields)


def test_a_refusal_is_the_answer_and_no_file_is_opened(active, tmp_path):
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    active.wrap(0.02)
    for fields, reason in (
        ({"gravity": [Vector3(x=math.inf)]}, "gravity"),  # by the node
        ({"tubing": str(pipe)}, "tubing must be a shipped list: natural_latex"),
    ):
        answer = asked(active, **fields)
        assert not answer.success
        assert reason in answer.message
        assert "internal error" not in answer.message
    assert active.status.state == State.TRACKING


# --- a design of minutes -----------------------------------------------------------------------


def design_processes(process_id):
    """Return the process ids of the designs that a node computes, whichever thread began them."""
    found = []
    for task in Path(f"/proc/{process_id}/task").iterdir():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # both come and go
            found += [
                int(child)
                for child in (task / "children").read_text().split()
                if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()
            ]
    return found


def begin_long_design(client, node):
    """Ask for a design of minutes; return its answer to come, and the process that computes it."""
    request = design_request(
        SMALLEST,
        LARGEST,
        tube_inner_radii=np.linspace(0.004, 0.005, 8).tolist(),
        tube_wall_thicknesses=[1.0e-3] * 8,
        fiber_angles_beta=np.linspace(0.9, 1.4, 250).tolist(),
        preference="largest_margin",
    )
    service = client.create_client(DesignGripper, "design_gripper")
    assert service.wait_for_service(DEADLINE)
    client.wait_until(lambda: not design_processes(node.process_id), "the end of earlier ones")
    answer = service.call_async(request)
    client.wait_until(lambda: design_processes(node.process_id), "its process")
    (worker,) = design_processes(node.process_id)
    return answer, worker


def wait_for_the_end(client, process_id):
    client.wait_until(lambda: not Path(f"/proc/{process_id}").exists(), "its process's end")


def test_the_node_goes_on_during_a_design_that_is_killed_or_canceled(active, shared_node):
    answer, worker = begin_long_design(active, shared_node)
    active.wrap(0.02)
    active.hear_more(100)
    assert active.plan_wrap(0.02).success
    assert active.status.state == State.TRACKING
    assert not answer.done()
    os.kill(worker, signal.SIGKILL)
    active.wait_until(answer.done, "an answer")
    assert not answer.result().success
    assert "its process was killed" in answer.result().message
    answer, worker = begin_long_design(active, shared_node)
    assert active.call(Trigger, "cancel_design").success
    active.wait_until(answer.done, "an answer")
    assert answer.result().message == "no design: canceled"
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
