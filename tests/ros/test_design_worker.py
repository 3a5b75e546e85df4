# SPDX-License-Identifier: Apache-2.0
"""Designs in a process of their own, without ROS."""

import dataclasses
import threading

import pytest

from spiral_core import InvalidInputError, PressureLaw
from spiral_gripper import load_description
from spiral_gripper_ros.planning import design_worker
from spiral_gripper_ros.planning.design_question import DesignQuestion, requirement_from_question
from spiral_gripper_ros.planning.design_worker import DesignProcess
from spiral_gripper_ros.planning.worker_process import EndedError

QUESTION = DesignQuestion(
    object_radius_min=0.011,
    object_radius_max=0.030,
    object_length=0.25,
    length_max=0.0,
    pressure_max=0.0,
    strain_max=0.0,
    turns_required=1.5,
    tubing="",
    tube_inner_radii=(),
    tube_wall_thicknesses=(),
    fiber_angles_beta=(),
    fiber_angle_alpha=0.0,
    fiber_angles_gamma=(),
    end_allowance=0.0,
    gravity=(9.80665, 0.0, 0.0),
    object_axis=None,
    preference="",
)
LONG = dataclasses.replace(
    QUESTION,
    fiber_angles_beta=tuple(0.9 + 0.002 * step for step in range(250)),
    preference="largest_margin",
)


@pytest.fixture
def description():
    return load_description("paper_design_70")


def test_angles_of_the_single_fiber_are_candidates_and_count_as_such(description):
    assert requirement_from_question(QUESTION, description).fiber_angles_gamma == (0.0,)
    section = dataclasses.replace(description.actuator, pressure_law=PressureLaw.SECTION)
    gripper_of_section = dataclasses.replace(description, actuator=section)
    helical = dataclasses.replace(QUESTION, fiber_angles_gamma=(0.0, 0.03))
    assert requirement_from_question(helical, gripper_of_section).fiber_angles_gamma == (0.0, 0.03)
    with pytest.raises(InvalidInputError, match="belong to the uniform pressure law"):
        requirement_from_question(helical, description)
    many = dataclasses.replace(LONG, fiber_angles_gamma=tuple(0.001 * k for k in range(9)))
    with pytest.raises(InvalidInputError, match="combinations of tube and angles must be at most"):
        requirement_from_question(many, gripper_of_section)


def test_a_design_is_answered(description):
    assert DesignProcess().answer(QUESTION, description).feasible


def test_an_error_of_the_question_is_raised_here(description):
    bad = dataclasses.replace(QUESTION, object_radius_min=float("nan"))
    with pytest.raises(InvalidInputError, match="radius_min"):
        DesignProcess().answer(bad, description)


def test_a_design_that_takes_too_long_is_ended(description):
    with pytest.raises(EndedError, match="not done within 1 s of processor time"):
        DesignProcess(longest=1).answer(LONG, description)


def test_a_design_that_is_ended_before_it_starts_is_not_started(description):
    process = DesignProcess()
    process.end("canceled")
    with pytest.raises(EndedError, match="no design: canceled"):
        process.answer(QUESTION, description)


def test_a_design_is_ended_from_another_thread(description):
    process = DesignProcess()
    threading.Timer(2.0, process.end, ["canceled"]).start()
    with pytest.raises(EndedError, match="canceled"):
        process.answer(LONG, description)


def test_a_design_that_needs_too_much_memory_is_an_answer(monkeypatch, description):
    def greedy(_):
        raise MemoryError

    monkeypatch.setattr(design_worker, "design_gripper", greedy)
    outcome = design_worker.design((QUESTION, description))
    assert "more than 2 GB of memory" in str(outcome)
