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
from spiral_gripper.cli.main import run
from spiral_gripper.reports.robot_model import covering_spheres, model_as_yaml, solve_model
from spiral_gripper.reports.wrap_document import solve_shape

RADIUS = 0.02
URDF = ROOT / "spiral_gripper_ros/urdf"
XACRO = "{http://www.ros.org/wiki/xacro}"


@pytest.fixture(scope="module")
def gripper():
    return load_gripper("paper_design_70")


@pytest.fixture(scope="module")
def model(gripper):
    return solve_model(gripper, RADIUS)


def surface(state, outer):
    """Points (n, 3) on a tube: around each node, normal to the backbone."""
    tangents = np.gradient(state.positions, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    helper = np.where(np.abs(tangents[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    across = np.cross(tangents, helper)
    across /= np.linalg.norm(across, axis=1)[:, None]
    up = np.cross(tangents, across)
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    around = [np.cos(a) * across + np.sin(a) * up for a in angles]
    return np.concatenate([state.positions + outer * ring for ring in around])


@pytest.mark.parametrize("name", ["grip [v2]: a", "1.5", "on", "a # b", "größer"])
def test_a_name_is_text_whatever_it_looks_like(model, name):
    assert YAML(typ="safe").load(model_as_yaml(replace(model, name=name)))["name"] == name


@pytest.mark.parametrize("radius", [0.006, 0.02, 0.037])
def test_the_spheres_cover_the_tube_and_not_much_more(gripper, radius):
    state = WrapCurve(gripper).wrap_for_radius(radius).state
    outer = gripper.tube.outer_radius
    spheres = covering_spheres(state, outer)
    points = surface(state, outer)
    reach = np.linalg.norm(points[:, None] - spheres[None, :, :3], axis=2) - spheres[:, 3]
    assert reach.min(axis=1).max() <= 0.0
    assert np.ptp(spheres[:, 3]) == 0.0
    assert outer < spheres[0, 3] < 1.25 * outer
    assert spheres[0, :3] == pytest.approx(state.positions[0], abs=1e-12)
    assert spheres[-1, :3] == pytest.approx(state.tip_position, abs=1e-12)


def test_the_box_holds_every_shape_on_the_way(gripper, model):
    for part in (0.0, 0.13, 0.5, 0.77, 1.0):  # other pressures than it was made of
        positions = solve_shape(gripper, part * model.pressure).state.positions
        # Between two of its pressures a shape may leave the hull of theirs by far less than this.
        assert np.all(positions >= model.swept_low + 0.5 * model.tube_radius)
        assert np.all(positions <= model.swept_high - 0.5 * model.tube_radius)
    assert model.tip == pytest.approx(model.spheres[-1, :3])


def test_the_shipped_model_is_that_of_its_gripper(model):
    shipped = YAML(typ="safe").load((URDF / "paper_design_70.yaml").read_text(encoding="utf-8"))
    now = YAML(typ="safe").load(model_as_yaml(model))
    assert shipped.keys() == now.keys()
    for name, value in now.items():
        if name == "name":
            assert shipped[name] == value
        else:  # rounded to 10 micrometers, and solved elsewhere
            assert np.asarray(shipped[name]) == pytest.approx(
                np.asarray(value), abs=1.1e-4, rel=1e-4
            )


def test_the_command_writes_what_the_model_says(model, tmp_path, capsys):
    file = tmp_path / "mine.yaml"
    assert run(["model", "paper_design_70", "--radius", "20 mm", "--save", str(file)]) == 0
    assert file.read_text(encoding="utf-8") == model_as_yaml(model)
    assert run(["model", "paper_design_70", "--radius", "60 mm"]) == 2
    assert "cannot be gripped" in capsys.readouterr().err


def test_what_cannot_be_gripped_has_no_model(gripper):
    with pytest.raises(NotGrippableError):
        solve_model(gripper, 0.06)


def test_the_xacro_uses_what_the_model_has_and_every_parameter_is_described(model):
    text = (URDF / "spiral_gripper.xacro").read_text(encoding="utf-8")
    used = {part.split("']")[0] for part in text.split("gripper['")[1:]}
    assert used == {"tube_radius", "spheres", "swept_center", "swept_size", "tip"}
    assert used <= YAML(typ="safe").load(model_as_yaml(model)).keys()
    macro = next(
        m
        for m in ElementTree.fromstring(text).iter(f"{XACRO}macro")
        if m.get("name") == "spiral_gripper"
    )
    names = [part.lstrip("*").split(":=")[0] for part in macro.get("params").split()]
    assert all(f"     {name} " in text for name in names)


def test_links_form_one_tree_below_the_parent():
    root = ElementTree.parse(URDF / "spiral_gripper.xacro").getroot()
    links = [link.get("name") for link in root.iter("link")]
    children = [joint.find("child").get("link") for joint in root.iter("joint")]
    assert sorted(children) == sorted(links)
    assert len(set(links)) == len(links)
    parents = {joint.find("parent").get("link") for joint in root.iter("joint")}
    assert parents == {"${parent}", "${prefix}gripper_base"}
