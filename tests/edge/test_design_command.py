# SPDX-License-Identifier: Apache-2.0
"""The commands ``design`` and ``sweep``: answers, reports, and files of designs."""

import re
import shlex
from pathlib import Path

import pytest

from spiral_core import DesignRequirement, design_gripper
from spiral_core.design.evaluation import ClosedObject
from spiral_gripper import (
    load_description,
    load_gripper,
    load_tubing,
    parse_tube_size,
)
from spiral_gripper.files.units import Dimension, parse_quantity

pytestmark = pytest.mark.long

NEEDS = (
    "--radius-min 11mm --radius-max 30mm --turns 1.5 --object-length 250mm --pressure-max '16 psi' "
    "--strain-max 0.3"
)
TUBE = "--tube '3/8 in x 1/32 in'"
# The seven steps alone: closing on these objects takes half a minute.
PAPER = f"design {NEEDS} {TUBE} --paper"
SMALL = "design --radius-min 12mm --radius-max 25mm --tube '9.5 mm x 0.8 mm' --beta 60deg"


def test_a_design_is_the_call_in_python_saved_and_reported(answer):
    document = answer(PAPER, "--save mine.yaml --report mine.html")
    requirement = DesignRequirement(
        0.011,
        0.030,
        (parse_tube_size("3/8 in x 1/32 in"),),
        (load_tubing("natural_latex").elastomer,),
        turns_required=1.5,
        object_length=0.25,
        pressure_max=parse_quantity("16 psi", Dimension.PRESSURE),
        strain_max=0.3,
    )
    expected, design = design_gripper(requirement).design, document["design"]
    assert document["feasible"] is True
    figures = (design["length"], design["smallest"]["pressure"])
    assert figures == pytest.approx((expected.length, expected.smallest.pressure), rel=1e-12)
    description = load_description("mine.yaml")
    found = description.gripper
    assert (found.name, found.turns_required) == ("mine", 1.5)
    # Twelve digits are written.
    saved = (found.tube.length, description.actuator.fibers.beta, found.pressure_max)
    figures = [design[name] for name in ("length", "fiber_angle_beta", "pressure_max")]
    assert saved == pytest.approx(figures, rel=1e-11)
    text = Path("mine.html").read_text("utf-8")
    assert re.search("364 mm.*Step 7", text, re.DOTALL)
    assert 'src="' not in text.replace('src="data:image/png;base64,iVBOR', "")


def test_a_design_is_closed_on_its_objects_as_wrap_closes_its_file(answer):
    closing = answer(SMALL, "--friction 0.4 --save mine.yaml")["steps"][7]
    assert (closing["number"], closing["satisfied"]) == (8, True)
    onsets = {figure["name"]: figure["value"] for figure in closing["figures"]}
    assert list(onsets) == [f"wrapped from, {radius} m" for radius in ("0.025", "0.0185", "0.012")]
    gripped = answer("wrap mine.yaml --radius 18.5mm")
    # Twelve digits are written.
    assert gripped["pressure"] == pytest.approx(onsets["wrapped from, 0.0185 m"], rel=1e-6)
    assert gripped["friction"] == 0.4


def test_a_design_that_wraps_too_few_objects_is_not_feasible(said, monkeypatch):
    closed = (ClosedObject(0.025, 40e3), ClosedObject(0.012, reason="it slips"))
    monkeypatch.setattr("spiral_core.design.closing.close_on_objects", lambda *_, **__: closed)
    text = said(SMALL, "--units psi,in", code=1)
    assert "not feasible: objects wrapped with contact: 1, at least 2" in text
    assert "0.4724 in is not wrapped: it slips" in text


@pytest.mark.parametrize("name", ["70", 'a: "b"'])
def test_a_saved_description_may_have_any_name_and_has_the_friction_of_its_payload(
    said, name, monkeypatch
):
    monkeypatch.setattr("spiral_core.design.payload.carried_mass", lambda *_: 0.02)
    said(PAPER, "--payload 10g --friction 0.5 --save", shlex.quote(f"{name}.yaml"))
    gripper = load_gripper(f"{name}.yaml")
    assert (gripper.name, gripper.friction_coefficient) == (name, 0.5)
