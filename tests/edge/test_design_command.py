# SPDX-License-Identifier: Apache-2.0
"""The commands ``design`` and ``sweep``: answers, reports, and files of designs."""

import shlex
from pathlib import Path

import pytest

from spiral_gripper import load_gripper

pytestmark = pytest.mark.long

# The seven steps alone: closing on these objects takes half a minute.
PAPER = "design --radius-min 11mm --radius-max 30mm --tube '3/8 in x 1/32 in' --paper"
SMALL = "design --radius-min 12mm --radius-max 25mm --tube '9.5 mm x 0.8 mm' --beta 60deg"


def test_a_design_is_closed_on_its_objects_as_wrap_closes_its_file(answer):
    closing = answer(SMALL, "--friction 0.4 --save mine.yaml")["steps"][7]
    onsets = {figure["name"]: figure["value"] for figure in closing["figures"]}
    gripped = answer("wrap mine.yaml --radius 18.5mm")
    # Twelve digits are written.
    assert gripped["pressure"] == pytest.approx(onsets["wrapped from, 0.0185 m"], rel=1e-6)
    assert gripped["friction"] == 0.4


@pytest.mark.parametrize("name", ["70", 'a: "b"'])
def test_a_saved_description_may_have_any_name_and_has_the_friction_of_its_payload(
    said, name, monkeypatch
):
    monkeypatch.setattr("spiral_core.design.payload.carried_mass", lambda *_: (0.02, 6e4))
    said(PAPER, "--payload 10g --friction 0.5 --report a.html --save", shlex.quote(f"{name}.yaml"))
    gripper = load_gripper(f"{name}.yaml")
    assert (gripper.name, gripper.friction_coefficient) == (name, 0.5)
    text = Path("a.html").read_text("utf-8")
    assert "Step 7" in text
    assert 'src="' not in text.replace('src="data:image/png;base64,iVBOR', "")
