# SPDX-License-Identifier: Apache-2.0
"""The commands ``design`` and ``sweep``: answers, reports, and files of designs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from edge.cli_cases import EXAMPLE, answer

from spiral_core import (
    DesignRequirement,
    design_gripper,
)
from spiral_core.design.evaluation import ClosedObject
from spiral_gripper import (
    convert_from_si,
    load_description,
    load_tubing,
    parse_tube_size,
)
from spiral_gripper.cli.main import run
from spiral_gripper.files.units import Dimension

pytestmark = pytest.mark.long

# The seven steps alone: closing on these objects takes half a minute.
PAPER = [*EXAMPLE, "--paper"]
SMALL = [
    "design", "--radius-min", "12 mm", "--radius-max", "25 mm", "--tube", "9.5 mm x 0.8 mm",
    "--beta", "60 deg",
]  # fmt: skip


def test_design_prints_the_steps_and_the_answer(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(PAPER) == 0
    text = capsys.readouterr().out
    for expected in ("1 tube", "7 exact design space", "70 deg", "364 mm", "feasible"):
        assert expected in text
    assert " psi" in text  # as the limit was typed
    assert "kPa" not in text


def test_design_in_json_is_the_call_in_python(capsys: pytest.CaptureFixture[str]) -> None:
    document = answer(capsys, *PAPER)
    report = design_gripper(
        DesignRequirement(
            radius_min=0.011,
            radius_max=0.030,
            tubes=(parse_tube_size("3/8 in x 1/32 in"),),
            elastomers=(load_tubing("natural_latex").elastomer,),
            turns_required=1.5,
            object_length=0.25,
            pressure_max=16.0 / convert_from_si(1.0, "psi", Dimension.PRESSURE),
            strain_max=0.3,
        )
    )
    assert report.design is not None
    assert document["feasible"] is True
    assert document["design"]["length"] == report.design.length
    assert document["design"]["smallest"]["pressure"] == pytest.approx(
        report.design.smallest.pressure, rel=1e-12
    )
    assert [step["number"] for step in document["steps"]] == [1, 2, 3, 4, 5, 6, 7]
    assert document["design"]["windings"][1]["hand"] == "right"
    assert document["binding"]["constraint"] in {"strain", "object_length"}


def test_a_design_is_closed_on_its_objects_as_grip_closes_its_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "mine.yaml"
    document = answer(capsys, *SMALL, "--friction", "0.4", "--save", str(path))
    closing = document["steps"][7]
    assert (closing["number"], closing["satisfied"]) == (8, True)
    onsets = {figure["name"]: figure["value"] for figure in closing["figures"]}
    assert list(onsets) == [f"wrapped from, {radius} m" for radius in ("0.025", "0.0185", "0.012")]
    assert load_description(path).gripper.friction_coefficient == 0.4
    gripped = answer(capsys, "wrap", str(path), "--radius", "18.5 mm")
    # Twelve digits are written.
    assert gripped["pressure"] == pytest.approx(onsets["wrapped from, 0.0185 m"], rel=1e-6)


def test_a_design_that_contact_does_not_wrap_is_refused(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "spiral_core.design.closing.close_on_objects",
        lambda *_, **__: (ClosedObject(0.025, 40e3), ClosedObject(0.012, reason="it slips")),
    )
    assert run([*SMALL, "--units", "psi,in"]) == 1
    text = " ".join(capsys.readouterr().out.split())
    assert "8 closing with contact no" in text
    assert "not feasible: objects wrapped with contact: 1, at least 2" in text
    assert "0.4724 in is not wrapped: it slips" in text
    assert "no single change" not in text


def test_infeasible_design_exits_with_1_and_says_what_would_do(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run([*PAPER, "--pressure-max", "50 kPa"]) == 1
    text = " ".join(capsys.readouterr().out.split())
    assert "not feasible: pressure limit" in text
    assert "sufficient change: pressure_max = 78.19 kPa instead of 50 kPa" in text


@pytest.mark.parametrize("suffix", [".md", ".html"])
def test_report_holds_steps_figures_and_picture(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"report{suffix}"
    assert run([*PAPER, "--json", "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    assert "Step 7" in text
    assert "364 mm" in text
    assert "data:image/png;base64,iVBOR" in text
    assert "src=" not in text.replace('src="data:', "")


def test_saved_description_is_the_design(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "mine.yaml"
    document = answer(capsys, *PAPER, "--save", str(path))
    description = load_description(path)
    assert description.gripper.name == "mine"
    # Twelve digits are written.
    design, written = document["design"], pytest.approx
    assert description.gripper.tube.length == written(design["length"], rel=1e-11)
    assert description.actuator.fibers.beta == written(design["fiber_angle_beta"], rel=1e-11)
    assert description.gripper.pressure_max == written(design["pressure_max"], rel=1e-11)
    assert description.gripper.turns_required == 1.5
    wrapped = answer(capsys, "wrap", str(path), "--radius", "11 mm", "--tip-criterion")
    # The search sampled another pressure range: other elements, 1e-4 of the figures.
    assert wrapped["pressure"] == pytest.approx(
        document["design"]["smallest"]["pressure"], rel=1e-4
    )


def test_a_saved_description_has_the_friction_that_its_payload_was_judged_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("spiral_core.design.payload.carried_mass", lambda *_: 0.02)
    path = tmp_path / "mine.yaml"
    assert run([*PAPER, "--payload", "10 g", "--friction", "0.5", "--save", str(path)]) == 0
    assert load_description(path).gripper.friction_coefficient == 0.5


@pytest.mark.parametrize("name", ["70", "2026-01-01", "null", 'a: "b"'])
def test_a_saved_description_may_have_any_name(name: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}.yaml"
    assert run([*PAPER, "--save", str(path)]) == 0
    assert load_description(path).gripper.name == name


def test_nothing_is_saved_that_is_not_feasible(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "mine.yaml"
    assert run([*PAPER, "--pressure-max", "50 kPa", "--save", str(path)]) == 2
    assert "nothing is saved: not feasible" in capsys.readouterr().err
    assert not path.exists()


def test_an_existing_file_is_kept(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("mine", encoding="utf-8")
    assert run([*PAPER, "--save", str(path)]) == 2
    assert "exists already and is kept" in capsys.readouterr().err
    assert path.read_text(encoding="utf-8") == "mine"


def test_without_matplotlib_one_line_says_what_to_install(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for module in [name for name in sys.modules if name.split(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.delitem(sys.modules, "spiral_gripper.reports.plots", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    saved = tmp_path / "mine.yaml"
    picture = str(tmp_path / "mine.png")
    assert run([*PAPER, "--save", str(saved), "--plot", picture]) == 2
    assert "spiral-gripper[plot]" in capsys.readouterr().err
    assert saved.exists()


def test_sweeps(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    plot = tmp_path / "map.png"
    wanted = [*EXAMPLE[1:], "--jobs", "1"]
    at = wanted.index("--tube")
    room = answer(
        capsys, "sweep", "map", *wanted[:at], *wanted[at + 2 :], "--angles", "2",
        "--tube-radii", "2", "--tube-radius-min", "4 mm", "--tube-radius-max", "5 mm",
        "--plot", str(plot),
    )  # fmt: skip
    assert len(room["room"]) == len(room["binding"]) == 2
    assert plot.stat().st_size > 0
    best = answer(capsys, "sweep", "pareto", *wanted, "--plot", str(plot))
    assert {round(point["fiber_angle_beta"], 4) for point in best} <= {1.2217, 1.3963}
    assert run(["sweep", "pareto", *wanted]) == 0
    assert "feasible designs (4 candidates)" in capsys.readouterr().out
