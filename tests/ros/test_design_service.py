# SPDX-License-Identifier: Apache-2.0
"""`design_gripper`, asked from another process: the numbers of the Python call, to the last."""

import contextlib
import math
import os
import re
import signal
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import Vector3
from ros.harness import (
    DEADLINE,
    DESIGN_DEADLINE,
    PATIENT,
    RunningNode,
    all_finite,
    design_request,
)
from std_srvs.srv import Trigger

from spiral_core import (
    Constraint,
    DesignRequirement,
    Elastomer,
    InvalidInputError,
    MooneyRivlin,
    Preference,
    SpiralError,
    TubeSize,
    WrapCurve,
    design_gripper,
)
from spiral_gripper import load_description, load_tubing
from spiral_gripper.files.description import parse_description
from spiral_gripper_msgs.srv import DesignGripper
from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.node.design_service import fill_response, question_from_msg
from spiral_gripper_ros.planning.design_question import requirement_from_question

LIMITS = {
    "object_length": 0.25,
    "turns_required": 1.5,
    "pressure_max": 110316.0,
    "strain_max": 0.3,
}


def asked(client, smallest=0.011, largest=0.030, **fields):
    request = design_request(smallest, largest, **fields)
    return client.call(DesignGripper, "design_gripper", request, DESIGN_DEADLINE)


def own_requirement(**changes):
    """Return the requirement that a request without tubes means."""
    description = load_description("paper_design_70")
    tube, gripper = description.actuator.tube, description.gripper
    return DesignRequirement(
        **{
            "radius_min": 0.011,
            "radius_max": 0.030,
            "tubes": (TubeSize("9.525 x 0.794 mm", tube.inner_radius, tube.wall_thickness),),
            "elastomers": (
                Elastomer(
                    gripper.name,
                    description.actuator.material,
                    description.density,
                    description.actuator.pressure_law,
                ),
            ),
            "fiber_angle_alpha": description.actuator.fibers.alpha,
            "pressure_max": gripper.pressure_max,
            **changes,
        }
    )


def assert_same(answer, report):
    """Compare every figure of a response with the report of the Python call: no tolerance."""
    design = report.design
    assert answer.success == report.feasible
    assert answer.message == report.message
    assert answer.binding_constraint == report.binding.constraint.value
    assert (answer.binding_value, answer.binding_limit) == (
        report.binding.value,
        report.binding.bound,
    )
    assert [(c.requested, c.sufficient, c.design) for c in answer.changes] == [
        (c.requested, c.sufficient, c.design) for c in report.relaxations
    ]
    assert (answer.candidates, answer.candidates_solved) == (report.candidates, len(report.tried))
    assert [
        (s.number, s.title, s.satisfied, s.remark, list(s.names), list(s.values), list(s.units))
        for s in answer.steps
    ] == [
        (
            s.number,
            s.title,
            s.satisfied,
            s.remark,
            [f.name for f in s.figures],
            [f.value for f in s.figures],
            [f.unit for f in s.figures],
        )
        for s in report.steps
    ]
    assert answer.design_known == (design is not None)
    if design is None:
        return
    assert (answer.tube, answer.material) == (design.tube.name, design.elastomer.name)
    assert answer.tube_inner_radius == design.tube.inner_radius
    assert answer.tube_wall_thickness == design.tube.wall_thickness
    assert answer.fiber_angle_alpha == design.actuator.fibers.alpha
    assert answer.fiber_angle_beta == design.actuator.fibers.beta
    assert answer.fiber_angle_gamma == design.actuator.single_fibers[0].angle
    assert (answer.length, answer.length_helix) == (design.length, design.helix_length)
    assert answer.cut_length == design.cut_length
    assert [(w.angle, w.pitch, w.turns, w.fiber_length) for w in answer.windings] == [
        (w.angle, w.pitch, w.turns, w.fiber_length) for w in design.windings
    ]
    assert answer.pressure_max == design.gripper.pressure_max
    assert (answer.radius_min, answer.radius_max) == (design.radius_min, design.radius_max)
    for end, grip in (("max", design.largest), ("min", design.smallest)):
        for name in ("strain", "pressure", "turns", "object_length"):
            assert getattr(answer, f"{name}_at_radius_{end}") == getattr(grip, name)
    assert list(answer.chart_radius) == [point.radius for point in design.curve]
    assert list(answer.chart_pressure) == [point.pressure for point in design.curve]
    assert [(m.constraint, m.value, m.bound, m.room, m.met) for m in answer.margins] == [
        (m.constraint.value, m.value, m.bound, m.room, m.is_met) for m in design.margins
    ]


@pytest.fixture(scope="module")
def papers_example(shared):
    """What the node answers to the paper's example."""
    shared.restore()
    return asked(shared, **LIMITS)


def test_the_papers_example_is_the_python_call_to_the_last_digit(papers_example):
    answer = papers_example
    assert_same(answer, design_gripper(own_requirement(**LIMITS)))
    assert answer.success
    assert math.degrees(answer.fiber_angle_beta) == pytest.approx(70.0)
    assert answer.length_helix == pytest.approx(0.361, rel=0.01)
    assert all_finite(answer)


def test_a_whole_request_reaches_the_procedure(active):
    """Each of these fields changes the report of this feasible design."""
    axis, gravity = (0.95, 0.0, -0.3), (9.7, 0.0, -1.0)
    answer = asked(
        active,
        0.012,
        0.025,
        object_length=0.2,
        length_max=0.5,
        pressure_max=1.2e5,
        strain_max=0.4,
        turns_required=1.2,
        tube_inner_radii=[4.0e-3, 5.0e-3],
        tube_wall_thicknesses=[1.0e-3, 0.8e-3],
        fiber_angles_beta=[1.0, 1.25],
        fiber_angle_alpha=1.5,
        end_allowance=0.03,
        gravity=[Vector3(x=gravity[0], y=gravity[1], z=gravity[2])],
        object_axis=[Vector3(x=2.0 * axis[0], y=2.0 * axis[1], z=2.0 * axis[2])],
        preference="least_pressure",
    )
    requirement = own_requirement(
        radius_min=0.012,
        radius_max=0.025,
        object_length=0.2,
        length_max=0.5,
        pressure_max=1.2e5,
        strain_max=0.4,
        turns_required=1.2,
        tubes=(TubeSize("8 x 1 mm", 4.0e-3, 1.0e-3), TubeSize("10 x 0.8 mm", 5.0e-3, 0.8e-3)),
        fiber_angles_beta=(1.0, 1.25),
        fiber_angle_alpha=1.5,
        end_allowance=0.03,
        gravity=gravity,
        object_axis=tuple(component / math.hypot(*axis) for component in axis),
        preference=Preference.LEAST_PRESSURE,
    )
    assert answer.success
    assert_same(answer, design_gripper(requirement))


def test_the_angle_of_the_single_fiber_is_answered():
    """Without a node: the shipped grippers' constants are of the law for straight fibers."""
    gamma = math.radians(2.0)
    elastomer = Elastomer("section latex", MooneyRivlin(95.0e3, 10.0e3), 950.0)
    tubes = (TubeSize("3/8 in x 1/32 in", 4.7625e-3, 0.79375e-3),)
    report = design_gripper(
        DesignRequirement(
            radius_min=0.011,
            radius_max=0.030,
            tubes=tubes,
            elastomers=(elastomer,),
            fiber_angles_beta=(math.radians(70.0),),
            fiber_angles_gamma=(gamma,),
        )
    )
    answer = fill_response(DesignGripper.Response(), report)
    assert answer.fiber_angle_gamma == gamma
    assert_same(answer, report)


def test_a_catalog_by_name(active):
    tubing = load_tubing("natural_latex")
    requirement = own_requirement(
        tubes=tubing.sizes,
        elastomers=(tubing.elastomer,),
        preference=Preference.LARGEST_MARGIN,
        **LIMITS,
    )
    answer = asked(active, tubing="natural_latex", preference="largest_margin", **LIMITS)
    assert_same(answer, design_gripper(requirement))


def test_an_infeasible_request_names_what_binds_and_what_would_do(active):
    answer = asked(active, length_max=0.2)
    assert_same(answer, design_gripper(own_requirement(length_max=0.2)))
    assert not answer.success
    assert answer.description == ""
    assert answer.binding_constraint == Constraint.LENGTH.value
    change = next(c for c in answer.changes if c.field == "object_radius_max")
    assert 0.011 < change.sufficient < 0.030
    assert design_gripper(own_requirement(length_max=0.2, radius_max=change.sufficient)).feasible
    assert all_finite(answer)


def test_the_description_loads_as_the_design(papers_example):
    answer = papers_example
    gripper = parse_description(answer.description, Path("designed.yaml")).gripper
    # Twelve digits are written.
    assert gripper.tube.length == pytest.approx(answer.length, rel=1e-11)
    curve = WrapCurve(gripper)
    # The search sampled another pressure range: other elements, 1e-4 of the figures.
    assert curve.pressure_from_radius(0.011) == pytest.approx(
        answer.pressure_at_radius_min, rel=1e-4
    )


@pytest.mark.parametrize(
    ("smallest", "largest", "fields", "reason"),
    [
        (math.nan, 0.03, {}, "radius_min"),
        (0.03, 0.011, {}, "radius_max"),
        (0.011, -0.03, {}, "radius_max"),
        (0.011, 0.03, {"pressure_max": math.nan}, "pressure_max"),
        (0.011, 0.03, {"strain_max": -0.1}, "strain_max"),
        (0.011, 0.03, {"length_max": -1.0}, "length_max"),
        (0.011, 0.03, {"length_max": 0.0}, "length_max"),
        (0.011, 0.03, {"fiber_angles_beta": [math.nan]}, "beta"),
        (0.011, 0.03, {"fiber_angles_beta": [-0.5], "fiber_angle_alpha": 0.5}, "extend"),
        (0.011, 0.03, {"fiber_angles_gamma": [math.nan]}, "gamma"),
        (0.011, 0.03, {"fiber_angles_gamma": [0.03]}, "constants of the section law"),
        (0.011, 0.03, {"object_axis": [Vector3()]}, "object_axis"),
        (0.011, 0.03, {"tubing": "silicone"}, "natural_latex"),
        (0.011, 0.03, {"tube_inner_radii": [0.004]}, "tube_wall_thicknesses"),
        (
            0.011,
            0.03,
            {
                "tubing": "natural_latex",
                "tube_inner_radii": [0.004],
                "tube_wall_thicknesses": [1e-3],
            },
            "tubing",
        ),
        (0.011, 0.03, {"preference": "cheapest"}, "preference"),
        (0.011, 1e200, {}, "radius_max must be at most 1e+06 m"),
    ],
)
def test_a_request_that_cannot_be_is_refused_with_the_reason(smallest, largest, fields, reason):
    request = design_request(smallest, largest, **fields)
    description = load_description("paper_design_70")

    def design():
        question = question_from_msg(request, (9.81, 0.0, 0.0))
        return design_gripper(requirement_from_question(question, description))

    with pytest.raises(SpiralError, match=re.escape(reason)):
        design()


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"gravity": [Vector3(x=math.inf)]}, "gravity"),  # by the node
        ({"preference": "cheapest"}, "preference"),  # by the process that designs
    ],
)
def test_a_refusal_is_the_answer(active, fields, reason):
    answer = asked(active, **fields)
    assert not answer.success
    assert reason in answer.message
    assert "internal error" not in answer.message
    assert all_finite(answer)


def children_of(process_id):
    """Return the process ids of a process's children (Linux), whichever thread started them."""
    children = []
    for task in Path(f"/proc/{process_id}/task").iterdir():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # threads come and go
            children += (task / "children").read_text().split()
    return [int(child) for child in children]


def design_processes(process_id):
    """Return the process ids of the designs that a node computes."""
    return [
        child
        for child in children_of(process_id)
        if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()
    ]


def begin_long_design(client, node):
    """Ask for a design of minutes; return its answer to come, and the process that computes it."""
    request = DesignGripper.Request(
        object_radius_min=0.011,
        object_radius_max=0.030,
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


@pytest.fixture
def long_design(active, shared_node):
    answer, worker = begin_long_design(active, shared_node)
    yield answer, worker
    active.call(Trigger, "cancel_design")
    wait_for_the_end(active, worker)


def test_a_killed_design_is_answered_and_the_next_is_computed(active, long_design):
    answer, worker = long_design
    os.kill(worker, signal.SIGKILL)
    active.wait_until(answer.done, "an answer")
    assert not answer.result().success
    assert "its process was killed" in answer.result().message
    assert asked(active).success


def test_a_design_can_be_canceled(active, long_design):
    answer, worker = long_design
    assert active.call(Trigger, "cancel_design").success
    active.wait_until(answer.done, "an answer")
    assert answer.result().message == "no design: canceled"
    wait_for_the_end(active, worker)
    assert not active.call(Trigger, "cancel_design").success


def test_the_node_goes_on_commanding_and_planning_during_a_design(active, long_design):
    answer, _ = long_design
    active.wrap(0.02)
    active.hear_more(100)
    assert active.plan_wrap(0.02).success
    assert active.status.state == State.TRACKING
    assert not answer.done()


@pytest.fixture
def own_node(namespace, client):
    with RunningNode(namespace, PATIENT) as node:
        client.wait_until_active()
        yield node


def test_a_design_ends_with_a_node_that_is_killed(client, own_node):
    _, worker = begin_long_design(client, own_node)
    os.kill(own_node.process_id, signal.SIGKILL)
    wait_for_the_end(client, worker)


def test_the_node_stops_in_the_middle_of_a_design(client, own_node):
    answer, worker = begin_long_design(client, own_node)
    assert not answer.done()
    assert own_node.stop() == 0, own_node.log()
    assert "Traceback" not in own_node.log()
    wait_for_the_end(client, worker)


def test_what_is_no_shipped_list_of_tubing_is_never_opened(active, tmp_path):
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    active.wrap(0.02)
    answer = asked(active, tubing=str(pipe))
    assert not answer.success
    assert "tubing must be a shipped list: natural_latex" in answer.message
    assert active.status.state == State.TRACKING


def test_more_combinations_than_can_be_computed_are_refused(active):
    tubes = np.linspace(0.004, 0.005, 200).tolist()
    angles = np.linspace(0.9, 1.4, 200).tolist()
    answer = asked(
        active,
        tube_inner_radii=tubes,
        tube_wall_thicknesses=[1.0e-3] * 200,
        fiber_angles_beta=angles,
    )
    assert not answer.success
    assert "at most 2000, got '200 x 200 x 1'" in answer.message


def test_the_interface_bounds_every_list_of_a_request():
    fields = DesignGripper.Request.get_fields_and_field_types()
    lists = [kind for kind in fields.values() if "sequence" in kind or "string" in kind]
    assert lists
    assert all("," in kind or "string<" in kind for kind in lists), fields


@pytest.mark.parametrize("x", [math.nan, math.inf, 51.0, 1e308])
def test_a_design_for_a_gravity_that_cannot_be_is_refused(x):
    request = DesignGripper.Request(gravity=[Vector3(x=x)])
    with pytest.raises(InvalidInputError, match="gravity must be 3 finite numbers"):
        question_from_msg(request, (0.0, 0.0, -9.81))
