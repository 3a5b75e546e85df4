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

from spiral_core import lay_into_coil, solve_grip
from spiral_gripper import load_gripper
from spiral_gripper.reports.meshes import tube_mesh
from spiral_gripper.reports.robot_model import covering_spheres, model_as_yaml, model_of
from spiral_gripper.reports.wrap_document import solve_shape

URDF = ROOT / "spiral_gripper_ros/urdf"
GRIPPER = load_gripper("paper_design_70")


def gripped(radius):
    return solve_grip(lay_into_coil(GRIPPER, radius), (), pressures=())


@pytest.fixture(scope="module")
def model():
    return model_of(gripped(0.02), 0.02)


def as_read(text):
    return YAML(typ="safe").load(text)


def test_a_name_is_text_whatever_it_looks_like(model):
    for name in ["grip [v2]: a", "1.5", "on", "a # b", "größer"]:
        assert as_read(model_as_yaml(replace(model, name=name)))["name"] == name


def test_the_spheres_cover_the_tube_on_its_object_and_not_much_more(model):
    outer = GRIPPER.tube.outer_radius
    for radius in [0.006, 0.02, 0.037]:
        grip = gripped(radius)
        state = grip.window.at(grip.recommended_pressure()).state
        spheres = covering_spheres(state, outer)
        if radius == 0.02:
            assert_allclose(model.spheres, spheres, 1e-6, 1e-7)
        centers, radii = np.split(spheres, [3], axis=1)
        away = cdist(tube_mesh(state.positions, outer).vertices, centers)
        assert (away - radii.T).min(axis=1).max() <= 0.0
        assert radii.max() < 1.25 * outer


def test_the_box_holds_every_shape_on_the_way(model):
    window = gripped(0.02).window
    for part in (0.0, 0.13, 0.77, 0.97, 1.0):  # other pressures than it was made of
        pressure = part * model.pressure
        for state in (solve_shape(GRIPPER, pressure).state, window.at(pressure).state):
            # Between two of its pressures a shape leaves the hull of theirs by less than this.
            assert np.all(state.positions >= model.swept_low + 0.5 * model.tube_radius)
            assert np.all(state.positions <= model.swept_high - 0.5 * model.tube_radius)
    assert_allclose(model.tip, model.spheres[-1, :3], 1e-6)
    # A thick object is in the way: the tube goes where it does not go without.
    thick = gripped(0.037)
    box = model_of(thick, 0.037)
    outer = 0.999 * box.tube_radius
    for point in thick.window.points:
        if point.pressure <= box.pressure:
            assert np.all(point.state.positions >= box.swept_low + outer)
            assert np.all(point.state.positions <= box.swept_high - outer)


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
