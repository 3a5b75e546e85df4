# SPDX-License-Identifier: Apache-2.0
"""The robot model: spheres that cover the tube, a box that holds every shape, a xacro that fits."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from repo.source_tree import ROOT
from ruamel.yaml import YAML

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


@pytest.mark.parametrize("name", ["grip [v2]: a", "1.5", "on", "a # b", "größer"])
def test_a_name_is_text_whatever_it_looks_like(model, name):
    assert as_read(model_as_yaml(replace(model, name=name)))["name"] == name


@pytest.mark.parametrize("radius", [0.006, 0.037])
def test_the_spheres_cover_the_tube_and_not_much_more(radius):
    state, outer = WrapCurve(GRIPPER).wrap_for_radius(radius).state, GRIPPER.tube.outer_radius
    spheres = covering_spheres(state, outer)
    points = tube_mesh(state.positions, outer).vertices
    reach = np.linalg.norm(points[:, None] - spheres[:, :3], axis=2) - spheres[:, 3]
    assert reach.min(axis=1).max() <= 0.0
    assert spheres[:, 3].max() < 1.25 * outer


def test_the_box_holds_every_shape_on_the_way(model):
    for part in (0.0, 0.13, 0.77, 1.0):  # other pressures than it was made of
        positions = solve_shape(GRIPPER, part * model.pressure).state.positions
        # Between two of its pressures a shape may leave the hull of theirs by far less than this.
        assert np.all(positions >= model.swept_low + 0.5 * model.tube_radius)
        assert np.all(positions <= model.swept_high - 0.5 * model.tube_radius)
    assert model.tip == pytest.approx(model.spheres[-1, :3])


def test_the_shipped_model_is_that_of_its_gripper(model):
    shipped = as_read((URDF / "paper_design_70.yaml").read_text("utf-8"))
    now = as_read(model_as_yaml(model))
    assert shipped.keys() == now.keys()
    for name in now.keys() - {"name"}:  # rounded to 10 micrometers, and solved elsewhere
        assert np.array(shipped[name]) == pytest.approx(np.array(now[name]), abs=1.1e-4, rel=1e-4)


def test_the_xacro_uses_what_the_model_has_and_its_links_form_one_tree(model):
    text = (URDF / "spiral_gripper.xacro").read_text("utf-8")
    used = set(re.findall(r"gripper\['(\w+)'\]", text))
    assert used == {"tube_radius", "spheres", "swept_center", "swept_size", "tip"}
    assert used < as_read(model_as_yaml(model)).keys()
    root = ElementTree.fromstring(text)
    params = root.find(".//*[@name='spiral_gripper']").get("params")
    names = re.findall(r"(?:^|\s)\*?(\w+)", params)
    assert all(f"     {name} " in text for name in names)  # every parameter is described
    links = {link.get("name") for link in root.iter("link")}
    children, parents = ([one.get("link") for one in root.iter(end)] for end in ("child", "parent"))
    assert sorted(children) == sorted(links)
    assert set(parents) == {"${parent}", "${prefix}gripper_base"}
