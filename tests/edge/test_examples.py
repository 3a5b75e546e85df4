# SPDX-License-Identifier: Apache-2.0
"""The examples run, with pinned figures; the validation page is what its command computes."""

from __future__ import annotations

import math
import re
import runpy
import shlex
from pathlib import Path

import pytest

from benchmarks.hanging_cable import hanging_cable
from spiral_core import Constraint
from spiral_gripper.cli.main import run

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]


def test_paper_design(capsys: pytest.CaptureFixture[str]) -> None:
    found = runpy.run_path(str(ROOT / "examples" / "paper_design.py"))
    design = found["design"]
    assert found["report"].feasible
    assert math.degrees(design.actuator.fibers.beta) == pytest.approx(70.0)
    # The helix model in closed form, to the digits shown.
    assert design.helix_length == pytest.approx(0.36403, abs=5e-6)
    assert design.helix_length == pytest.approx(0.361, rel=0.01)
    # The length's search ends within 3e-3 of the largest radius.
    assert design.length == pytest.approx(0.3728, rel=3e-3)
    assert design.largest.pressure == pytest.approx(44.03e3, rel=3e-3)
    assert design.smallest.pressure == pytest.approx(78.19e3, rel=3e-3)
    printed = capsys.readouterr().out
    assert "beta 70 deg (the paper: 70), helix length 364.0 mm (361)" in printed
    assert "wind at 70 deg: pitch 12.71 mm, 29.3 turns, right-handed" in printed


def test_cable_between_poles(capsys: pytest.CaptureFixture[str]) -> None:
    found = runpy.run_path(str(ROOT / "examples" / "cable_between_poles.py"))
    exact = hanging_cable(
        axial=1e6 * math.pi * 5e-3**2,
        bending=1e6 * math.pi / 4.0 * 5e-3**4,
        weight=found["WEIGHT"],
        length=1.0,
        span=0.8,
        count=50,
    )
    # The reference neglects shear.
    assert found["sag"] == pytest.approx(-exact[:, 2].min(), rel=1e-4)
    pulls = [math.hypot(*state.base_reaction[:3]) for state in found["path"].states]
    assert pulls == sorted(pulls)
    assert not found["path"].events
    printed = capsys.readouterr().out
    assert "span 0.80 m: sags 268.6 mm, pulls 0.460 N at each pole" in printed
    assert "span 0.99 m: sags 93.5 mm, pulls 1.076 N at each pole" in printed


def test_rope_on_a_capstan(capsys: pytest.CaptureFixture[str]) -> None:
    found = runpy.run_path(str(ROOT / "examples" / "rope_on_a_capstan.py"))
    for ratio, state in zip(found["ratios"], found["path"].states, strict=True):
        assert state.stable
        assert math.hypot(*state.forces[-2]) == pytest.approx(0.5 * ratio, rel=1e-6)
    assert not found["path"].events
    printed = capsys.readouterr().out
    assert "2.5 to 1: held; the heavy end is 23.1 mm lower, by stretch" in printed
    assert "the capstan equation allows 2.57 to 1" in printed


def test_coil_on_a_cone(capsys: pytest.CaptureFixture[str]) -> None:
    found = runpy.run_path(str(ROOT / "examples" / "coil_on_a_cone.py"))
    grip, axis = found["grip"], found["AXIS"]
    assert grip.stable
    # Balance: what the cone feels is what holds the base.
    assert grip.on_obstacle().force == pytest.approx(grip.base_reaction[:3], abs=1e-6)
    assert 0.0 < grip.on_obstacle().force @ axis < 0.1 * grip.normal_forces.sum()
    printed = capsys.readouterr().out
    assert "100% curled:  42% of the length touches, 1.06 N in all" in printed


@pytest.fixture(scope="module")
def validation() -> dict:
    """Return the names of docs/validation.py."""
    return runpy.run_path(str(ROOT / "docs" / "validation.py"))


def test_validation_page_is_up_to_date(validation: dict) -> None:
    page = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert page == validation["page"](), "run `make validation`"


def test_the_page_of_grips_has_the_words_of_its_script() -> None:
    script = runpy.run_path(str(ROOT / "docs" / "validate_grip.py"))
    page = (ROOT / "docs" / "validation_grip.md").read_text(encoding="utf-8")
    assert page.startswith(script["HEADER"])
    for name in ("FIG4", "FIG4_VERDICT", "FIG9", "FIG9_NOTE", "FIG10", "INFLUENCE", "WINDOWS"):
        assert script[name] in page, name
    assert page.endswith(script["INFLUENCE_VERDICT"])


def test_every_claim_of_the_paper_has_a_figure_and_a_verdict(validation: dict) -> None:
    rows = validation["claims"]()
    assert len(rows) == 7
    for row in rows:
        assert re.search(r"\d", row.computed), row.claim
        assert row.verdict.startswith(
            ("reproduced", "partly", "not reproduced", "cannot be tested")
        )
    reproduced = [row for row in rows if row.verdict.startswith("reproduced")]
    # Two are not: the measured shapes did not reach us, and alpha = 88 degrees changes more.
    assert len(reproduced) == 5


def test_the_design_page_prints_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    page = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
    code, printed = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", page, re.DOTALL).groups()
    exec(compile(code, "docs/design.md", "exec"), {})
    assert capsys.readouterr().out == printed
    names = re.findall(
        r"^\| ([a-z ]+) \|", page.split("## When no design is feasible")[1], re.MULTILINE
    )
    assert set(names) - {"constraint"} == {constraint.value for constraint in Constraint}


@pytest.mark.slow
def test_the_design_pages_commands_are_accepted(tmp_path: Path, monkeypatch) -> None:
    page = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
    block = re.search(r"```console\n(.*?)```", page, re.DOTALL)[1]
    monkeypatch.chdir(tmp_path)
    for line in block.splitlines():
        program, *arguments = shlex.split(line)
        assert program == "spiral-gripper"
        assert run(arguments) == 0, line
    assert {path.name for path in tmp_path.iterdir()} == {"mine.yaml", "mine.html", "pressure.svg"}


def test_examples_are_few_and_short() -> None:
    files = list((ROOT / "examples").glob("*.py"))
    assert 1 < len(files) <= 8
    lengths = {path.name: len(path.read_text(encoding="utf-8").splitlines()) for path in files}
    assert max(lengths.values()) < 80, lengths
