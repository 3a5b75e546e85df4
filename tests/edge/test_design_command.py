# SPDX-License-Identifier: Apache-2.0
"""The commands ``design`` and ``sweep``: answers, reports, and files of designs."""

import re

import pytest

from spiral_core import DesignRequirement, WrapCurve, design_gripper
from spiral_core.design.evaluation import ClosedObject
from spiral_gripper import (
    convert_from_si,
    load_description,
    load_gripper,
    load_tubing,
    parse_tube_size,
)
from spiral_gripper.files.units import Dimension

pytestmark = pytest.mark.long

NEEDS = [
    "--radius-min", "11 mm", "--radius-max", "30 mm", "--turns", "1.5", "--object-length", "250 mm",
    "--pressure-max", "16 psi", "--strain-max", "0.3",
]  # fmt: skip
TUBE = ["--tube", "3/8 in x 1/32 in"]
# The seven steps alone: closing on these objects takes half a minute.
PAPER = ["design", *NEEDS, *TUBE, "--paper"]
SMALL = [
    "design", "--radius-min", "12 mm", "--radius-max", "25 mm", "--tube", "9.5 mm x 0.8 mm",
    "--beta", "60 deg",
]  # fmt: skip


def test_a_design_is_the_call_in_python_printed_saved_and_reported(answer, said, tmp_path):
    path, html, md = (tmp_path / f"mine.{suffix}" for suffix in ("yaml", "html", "md"))
    document = answer(*PAPER, "--save", str(path), "--report", str(html))
    requirement = DesignRequirement(
        radius_min=0.011,
        radius_max=0.030,
        tubes=(parse_tube_size("3/8 in x 1/32 in"),),
        elastomers=(load_tubing("natural_latex").elastomer,),
        turns_required=1.5,
        object_length=0.25,
        pressure_max=16.0 / convert_from_si(1.0, "psi", Dimension.PRESSURE),
        strain_max=0.3,
    )
    expected, design = design_gripper(requirement).design, document["design"]
    assert document["feasible"] is True
    assert design["length"] == expected.length
    pressure = expected.smallest.pressure
    assert design["smallest"]["pressure"] == pytest.approx(pressure, rel=1e-12)
    assert [step["number"] for step in document["steps"]] == [1, 2, 3, 4, 5, 6, 7]
    assert document["binding"]["constraint"] in {"strain", "object_length"}
    description = load_description(path)
    found = description.gripper
    assert (found.name, found.turns_required) == ("mine", 1.5)
    # Twelve digits are written.
    saved = (found.tube.length, description.actuator.fibers.beta, found.pressure_max)
    figures = [design[name] for name in ("length", "fiber_angle_beta", "pressure_max")]
    assert saved == pytest.approx(figures, rel=1e-11)
    # The search sampled another pressure range: other elements, 1e-4 of the figures.
    assert WrapCurve(found).pressure_from_radius(0.011) == pytest.approx(pressure, rel=1e-4)
    printed = said(*PAPER, "--report", str(md))
    assert re.search("1 tube .* 7 exact design space .*feasible", printed)
    assert "kPa" not in printed  # as the limit was typed
    for report in (html, md):
        text = report.read_text(encoding="utf-8")
        assert re.search("364 mm.*Step 7", text, re.DOTALL)
        assert "data:image/png;base64,iVBOR" in text
        assert "src=" not in text.replace('src="data:', "")


def test_a_design_is_closed_on_its_objects_as_grip_closes_its_file(answer, tmp_path):
    path = tmp_path / "mine.yaml"
    closing = answer(*SMALL, "--friction", "0.4", "--save", str(path))["steps"][7]
    assert (closing["number"], closing["satisfied"]) == (8, True)
    onsets = {figure["name"]: figure["value"] for figure in closing["figures"]}
    assert list(onsets) == [f"wrapped from, {radius} m" for radius in ("0.025", "0.0185", "0.012")]
    assert load_description(path).gripper.friction_coefficient == 0.4
    gripped = answer("wrap", str(path), "--radius", "18.5 mm")
    # Twelve digits are written.
    assert gripped["pressure"] == pytest.approx(onsets["wrapped from, 0.0185 m"], rel=1e-6)


def test_a_design_that_is_not_feasible_is_not_saved_and_says_what_would_do(
    said, tmp_path, monkeypatch
):
    path = tmp_path / "mine.yaml"
    text = said(*PAPER, "--pressure-max", "50 kPa", "--save", str(path), code=2)
    assert "not feasible: pressure limit" in text
    assert "sufficient change: pressure_max = 78.19 kPa instead of 50 kPa" in text
    assert "nothing is saved: not feasible" in text
    assert not path.exists()
    monkeypatch.setattr(
        "spiral_core.design.closing.close_on_objects",
        lambda *_, **__: (ClosedObject(0.025, 40e3), ClosedObject(0.012, reason="it slips")),
    )
    text = said(*SMALL, "--units", "psi,in", code=1)
    assert "8 closing with contact no" in text
    assert "not feasible: objects wrapped with contact: 1, at least 2" in text
    assert "0.4724 in is not wrapped: it slips" in text
    assert "no single change" not in text


@pytest.mark.parametrize("name", ["70", "2026-01-01", "null", 'a: "b"'])
def test_a_saved_description_may_have_any_name_and_has_the_friction_of_its_payload(
    said, name, tmp_path, monkeypatch
):
    monkeypatch.setattr("spiral_core.design.payload.carried_mass", lambda *_: 0.02)
    path = tmp_path / f"{name}.yaml"
    said(*PAPER, "--payload", "10 g", "--friction", "0.5", "--save", str(path))
    gripper = load_gripper(path)
    assert (gripper.name, gripper.friction_coefficient) == (name, 0.5)


def test_sweeps(answer, tmp_path):
    plot = tmp_path / "map.png"
    wanted = [*NEEDS, "--jobs", "1"]
    room = answer(
        "sweep", "map", *wanted, "--angles", "2", "--tube-radii", "2", "--tube-radius-min", "4 mm",
        "--tube-radius-max", "5 mm", "--plot", str(plot),
    )  # fmt: skip
    assert len(room["room"]) == len(room["binding"]) == 2
    assert plot.stat().st_size > 0
    best = answer("sweep", "pareto", *wanted, *TUBE)
    assert {round(point["fiber_angle_beta"], 4) for point in best} <= {1.2217, 1.3963}
