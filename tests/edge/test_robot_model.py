# SPDX-License-Identifier: Apache-2.0
"""The robot model: spheres that cover the tube, a box that holds every shape, a xacro that fits."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from repo.source_tree import ROOT
from ruamel.yaml import YAML

from spiral_core import NotGrippableError, WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper.reports.robot_model import covering_spheres, model_as_yaml, solve_model
from spiral_gripper.reports.wrap_document import solve_shape

URDF = ROOT / "spiral_gripper_ros/urdf"
GRIPPER = load_gripper("paper_design_70")


@pytest.fixture(scope="module")
def model():
    return solve_model(GRIPPER, 0.02)


def as_read(text):
    return YAML(typ="safe").load(text)


@pytest.mark.parametrize("name", ["grip [v2]: a", "1.5", "on", "a # b", "größer"])
def test_a_name_is_text_whatever_it_looks_like(model, name):
    assert as_read(model_as_yaml(replace(model, name=name)))["name"] == name


@pytest.mark.parametrize("radius", [0.006, 0.02, 0.037])
def test_the_spheres_cover_the_tube_and_not_much_more(radius):
    state, outer = WrapCurve(GRIPPER).wrap_for_radius(radius).state, GRIPPER.tube.outer_radius
    spheres = covering_spheres(state, outer)
    # Points on the tube: around each node, normal to the backbone.
    tangents = np.gradient(state.positions, axis=0)
    across = np.cross(tangents, np.roll(tangents, 1, axis=1) - (0.0, 1.0, 0.3))
    up = np.cross(tangents, across)
    across, up = (side / np.linalg.norm(side, axis=1)[:, None] for side in (across, up))
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    rings = [np.cos(a) * across + np.sin(a) * up for a in angles]
    points = np.concatenate([state.positions + outer * ring for ring in rings])
    reach = np.linalg.norm(points[:, None] - spheres[None, :, :3], axis=2) - spheres[:, 3]
    assert reach.min(axis=1).max() <= 0.0
    assert np.ptp(spheres[:, 3]) == 0.0
    assert outer < spheres[0, 3] < 1.25 * outer
    ends = state.positions[[0, -1]]
    assert spheres[[0, -1], :3] == pytest.approx(ends, abs=1e-12)


def test_the_box_holds_every_shape_on_the_way(model):
    for part in (0.0, 0.13, 0.5, 0.77, 1.0):  # other pressures than it was made of
        positions = solve_shape(GRIPPER, part * model.pressure).state.positions
        # Between two of its pressures a shape may leave the hull of theirs by far less than this.
        assert np.all(positions >= model.swept_low + 0.5 * model.tube_radius)
        assert np.all(positions <= model.swept_high - 0.5 * model.tube_radius)
    assert model.tip == pytest.approx(model.spheres[-1, :3])


def test_the_shipped_model_is_that_of_its_gripper(model):
    shipped = as_read((URDF / "paper_design_70.yaml").read_text(encoding="utf-8"))
    now = as_read(model_as_yaml(model))
    assert shipped.keys() == now.keys()
    assert shipped.pop("name") == now.pop("name")
    for name, value in now.items():  # rounded to 10 micrometers, and solved elsewhere
        expected = pytest.approx(np.asarray(value), abs=1.1e-4, rel=1e-4)
        assert np.asarray(shipped[name]) == expected


def test_the_command_writes_what_the_model_says(model, tmp_path, said):
    file = tmp_path / "mine.yaml"
    said("model", "paper_design_70", "--radius", "20 mm", "--save", str(file))
    assert file.read_text(encoding="utf-8") == model_as_yaml(model)
    with pytest.raises(NotGrippableError):
        solve_model(GRIPPER, 0.06)


def test_the_xacro_uses_what_the_model_has_and_its_links_form_one_tree(model):
    text = (URDF / "spiral_gripper.xacro").read_text(encoding="utf-8")
    used = {part.split("']")[0] for part in text.split("gripper['")[1:]}
    assert used == {"tube_radius", "spheres", "swept_center", "swept_size", "tip"}
    assert used <= as_read(model_as_yaml(model)).keys()
    root = ElementTree.fromstring(text)
    macros = root.iter("{http://www.ros.org/wiki/xacro}macro")
    macro = next(macro for macro in macros if macro.get("name") == "spiral_gripper")
    names = [part.lstrip("*").split(":=")[0] for part in macro.get("params").split()]
    assert all(f"     {name} " in text for name in names)  # every parameter is described
    links = [link.get("name") for link in root.iter("link")]
    joints = list(root.iter("joint"))
    assert sorted(joint.find("child").get("link") for joint in joints) == sorted(links)
    assert len(set(links)) == len(links)
    parents = {joint.find("parent").get("link") for joint in joints}
    assert parents == {"${parent}", "${prefix}gripper_base"}
