# SPDX-License-Identifier: Apache-2.0
"""The robot model: spheres that cover the tube, a box that holds every shape, a xacro that fits."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose
from repo.source_tree import ROOT
from ruamel.yaml import YAML
from scipy.spatial.distance import cdist

from spiral_core import WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper.reports.meshes import tube_mesh
from spiral_gripper.reports.robot_model import covering_spheres, model_as_yaml, solve_model
from spiral_gripper.reports.wrap_document import solve_shape

URDF = ROOT / "spiral_gripper_ros/urdf"
GRIPPER = load_gripper("paper_design_70")


@pytest.fixture(scope="module")
def model():
    return solve_model(GRIPPER, 0.02)


def as_read(text):
    return YAML(typ="safe").load(text)


def test_a_name_is_text_whatever_it_looks_like(model):
    for name in ["grip [v2]: a", "1.5", "on", "a # b", "größer"]:
        assert as_read(model_as_yaml(replace(model, name=name)))["name"] == name


def test_the_spheres_cover_the_tube_and_not_much_more():
    outer = GRIPPER.tube.outer_radius
    for radius in [0.006, 0.037]:
        state = WrapCurve(GRIPPER).wrap_for_radius(radius).state
        centers, radii = np.split(covering_spheres(state, outer), [3], axis=1)
        away = cdist(tube_mesh(state.positions, outer).vertices, centers)
        assert (away - radii.T).min(axis=1).max() <= 0.0
        assert radii.max() < 1.25 * outer


def test_the_box_holds_every_shape_on_the_way(model):
    for part in (0.0, 0.13, 0.77, 1.0):  # other pressures than it was made of
        positions = solve_shape(GRIPPER, part * model.pressure).state.positions
        # Between two of its pressures a shape may leave the hull of theirs by far less than this.
        assert np.all(positions >= model.swept_low + 0.5 * model.tube_radius)
        assert np.all(positions <= model.swept_high - 0.5 * model.tube_radius)
    assert_allclose(model.tip, model.spheres[-1, :3], 1e-6)


def test_the_shipped_model_is_that_of_its_gripper(model):
    shipped = as_read((URDF / "paper_design_70.yaml").read_text("utf-8"))
    now = as_read(model_as_yaml(model))
    assert shipped.keys() == now.keys()
    for name in now.keys() - {"name"}:  # rounded to 10 micrometers, and solved elsewhere
        assert_allclose(shipped[name], now[name], 1e-4, 1.1e-4)


def test_the_xacro_uses_what_the_model_has_and_its_links_form_one_tree(model):
    text = (URDF / "spiral_gripper.xacro").read_text("utf-8")
    used = set(re.findall(r"gripper\['(\w+)'\]", text))
    named = as_read(model_as_yaml(model)).keys()
    assert used == named - {"name", "length", "pressure", "object_radius"}
    root = ElementTree.fromstring(text)
    params = root.find(".//*[@name='spiral_gripper']").get("params")
    for name in re.findall(r"(?:^|\s)\*?(\w+)", params):
        assert f"     {name} " in text  # every parameter is described
    links, children, parents = (
        [one.get("name") or one.get("link") for one in root.iter(tag)]
        for tag in ("link", "child", "parent")
    )
    assert sorted(children) == sorted(links)
    assert set(parents) == {"${parent}", "${prefix}gripper_base"}
