# SPDX-License-Identifier: Apache-2.0
"""Facts that several files must state agree: versions, requirements, interfaces, executables."""

from __future__ import annotations

import configparser
import importlib
import re
from importlib import metadata

import pytest
from repo.source_tree import (
    PACKAGES,
    PYTHON_PACKAGES,
    ROOT,
    external_imports,
    package_xml,
    pyproject,
)
from ruamel.yaml import YAML

# import name -> (what apt and rosdep call it, what PyPI calls it)
LIBRARIES = {
    "click": ("python3-click", "click"),
    "matplotlib": ("python3-matplotlib", "matplotlib"),
    "numba": ("python3-numba", "numba"),
    "numpy": ("python3-numpy", "numpy"),
    "rich": ("python3-rich", "rich"),
    "ruamel": ("python3-ruamel.yaml", "ruamel.yaml"),
    "scipy": ("python3-scipy", "scipy"),
    "serial": ("python3-serial", "pyserial"),
}
# Used by launch files, which are shipped for those who have them: not on PyPI.
NOT_ON_PYPI = {"launch", "launch_ros", "xacro"}
# Imported by name, where they are installed: none is on PyPI.
OPTIONAL = {"control_msgs", "tf2_msgs", "tf2_ros"}
# Used by the studio alone, where it was installed by pip: rosdep has no key for them.
PIP_ONLY = {"trimesh", "viser"}


def stated() -> dict[str, list[str]]:
    """Return what pyproject.toml hands to packaging/ros_metadata.py."""
    (settings,) = pyproject()["tool"]["dynamic-metadata"]
    return settings


def names(requirements: list[str]) -> set[str]:
    """Return the names in requirement lines, without version bounds."""
    return {re.split(r"[<>=!~;\[ ]", line)[0] for line in requirements}


def dependencies(package: str, *tags: str) -> set[str]:
    """Return what a package.xml names under the given tags."""
    return {element.text or "" for tag in tags for element in package_xml(package).iter(tag)}


def interface_files() -> set[str]:
    """Return the interface definitions, as CMakeLists.txt should name them."""
    folder = ROOT / "spiral_gripper_msgs"
    paths = [p for kind in ("msg", "srv", "action") for p in folder.glob(f"{kind}/*.{kind}")]
    return {path.relative_to(folder).as_posix() for path in paths}


def generate_call() -> tuple[set[str], set[str]]:
    """Return the files and the dependencies of rosidl_generate_interfaces in CMakeLists.txt."""
    text = (ROOT / "spiral_gripper_msgs" / "CMakeLists.txt").read_text(encoding="utf-8")
    call = re.search(r"rosidl_generate_interfaces\((.*?)DEPENDENCIES(.*?)\)", text, re.DOTALL)
    assert call is not None
    return set(re.findall(r'"(.+?)"', call[1])), set(call[2].split())


def test_version_is_the_same_everywhere() -> None:
    version = pyproject()["project"]["version"]
    for package in PACKAGES:
        assert package_xml(package).findtext("version") == version
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (\S+)$", citation, re.MULTILINE)[1] == version
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(r"^## (\S+)", changelog, re.MULTILINE)[1] == version
    assert metadata.version("spiral-gripper") == version


def test_license_is_the_same_everywhere() -> None:
    license_id = pyproject()["project"]["license"]
    for package in PACKAGES:
        assert package_xml(package).findtext("license") == license_id
    assert f"license: {license_id}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    text = (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert license_id == "Apache-2.0"
    assert text.split()[:4] == ["Apache", "License", "Version", "2.0,"]


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_package_xml_names_what_is_imported(package: str) -> None:
    imported = external_imports(package) - PIP_ONLY
    expected = {LIBRARIES.get(name, (name,))[0] for name in imported}
    launch = "".join(path.read_text("utf-8") for path in (ROOT / package).glob("launch/*.py"))
    rviz = "".join(path.read_text("utf-8") for path in (ROOT / package).glob("rviz/*.rviz"))
    expected |= {*re.findall(r'package="(\w+)"', launch), *re.findall(r"Class: (\w+)/", rviz)}
    expected |= OPTIONAL if package == "spiral_gripper_ros" else set()
    assert dependencies(package, "depend", "exec_depend") == expected - {package}


@pytest.mark.parametrize("package", PACKAGES)
def test_package_xml_names_the_authors_and_the_source_of_the_citation(package: str) -> None:
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    (author,), (paper,) = citation["authors"], citation["references"]
    xml = package_xml(package)
    assert [xml.findtext("maintainer"), xml.findtext("author")] == [author["name"]] * 2
    assert xml.find("maintainer").get("email")
    urls = {url.get("type"): url.text for url in xml.iter("url")}
    code = citation.get("repository-code")  # none before the repository is published
    published = {"repository": code, "bugtracker": f"{code}/issues"} if code else {}
    assert urls == {"website": f"https://doi.org/{paper['doi']}"} | published


def test_the_quality_declaration_names_the_platforms_that_are_tested() -> None:
    workflow = YAML(typ="safe").load((ROOT / ".github/workflows/ros.yml").read_text("utf-8"))
    matrix = workflow["jobs"]["apt"]["strategy"]["matrix"]
    page = (ROOT / "QUALITY_DECLARATION.md").read_text(encoding="utf-8")
    (stated,) = re.findall(r"Ubuntu on (.*): CI, with (.*)\. \*\*", page)
    machines = ["aarch64" if runner.endswith("-arm") else "x86-64" for runner in matrix["runner"]]
    assert re.split(", | and ", stated[0]) == machines
    distributions = [distribution.title() for distribution in matrix["distribution"]]
    assert re.split(", | and ", stated[1]) == distributions


@pytest.mark.parametrize("package", PACKAGES)
def test_every_package_has_a_changelog_that_bloom_reads(package: str) -> None:
    """In catkin_pkg's format: the title, then sections of a version and its date, newest first."""
    title, *rest = (ROOT / package / "CHANGELOG.rst").read_text(encoding="utf-8").split("\n", 3)[1:]
    assert title == f"Changelog for package {package}"
    sections = re.findall(r"^(.+)\n-{4,}\n+\* ", rest[-1], re.MULTILINE)
    released = re.compile(r"\d+\.\d+\.\d+ \(\d{4}-\d{2}-\d{2}\)")
    assert sections
    assert all(released.fullmatch(section) for section in sections if section != "Forthcoming")


def test_pyproject_names_what_is_imported() -> None:
    imported = set().union(*(external_imports(package) for package in PYTHON_PACKAGES))
    libraries = {LIBRARIES[name][1] for name in imported & LIBRARIES.keys()}
    extras = pyproject()["project"]["optional-dependencies"]
    optional = names(extras["plot"] + extras["regulators"])
    assert names(stated()["dependencies"]) == libraries - optional
    ros = imported - LIBRARIES.keys() - set(PACKAGES) - NOT_ON_PYPI - PIP_ONLY
    assert names(extras["studio"]) >= PIP_ONLY
    wheels = {f"ros-jazzy-{name.replace('_', '-')}" for name in ros}
    assert wheels <= names(stated()["ros-dependencies"])


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_package_xml_states_the_lower_bounds(package: str) -> None:
    extras = pyproject()["project"]["optional-dependencies"]
    lines = [*stated()["dependencies"], *extras["plot"], *extras["regulators"]]
    bounds = dict(line.split(">=") for line in lines)
    by_key = {key: bounds[name] for key, name in LIBRARIES.values()}
    found = {
        element.text: element.get("version_gte")
        for element in package_xml(package).iter("exec_depend")
        if element.text in by_key
    }
    assert found
    assert found == {key: by_key[key] for key in found}


def test_colcon_finds_the_tests_of_each_package() -> None:
    for package in PYTHON_PACKAGES:
        settings = configparser.ConfigParser()
        settings.read(ROOT / package / "setup.cfg")
        own, tests = settings["tool:pytest"]["testpaths"].split()
        assert (ROOT / package / own).is_dir()
        assert list((ROOT / package / tests).glob("test_*.py"))
        setup = (ROOT / package / "setup.py").read_text(encoding="utf-8")
        assert 'extras_require={"test": ["pytest"]}' in setup  # by this colcon knows
        assert {"python3-pytest", "python3-hypothesis"} <= dependencies(package, "test_depend")


def test_cmake_lists_all_interfaces() -> None:
    files, _ = generate_call()
    assert files == interface_files()


def test_interfaces_name_the_packages_they_use() -> None:
    text = "".join(
        (ROOT / "spiral_gripper_msgs" / name).read_text(encoding="utf-8")
        for name in interface_files()
    )
    fields = re.findall(r"^(\w+)/\w+(?:\[.*?\])?\s+\w+", text, re.MULTILINE)
    used = set(fields) - {"spiral_gripper_msgs"}
    _, cmake = generate_call()
    assert cmake == used
    assert dependencies("spiral_gripper_msgs", "depend") == used
    wheels = {f"ros-jazzy-{name.replace('_', '-')}" for name in used}
    assert wheels <= names(pyproject()["tool"]["scikit-build"]["build"]["requires"])
    assert wheels <= names(stated()["ros-dependencies"])


def test_executables_are_the_same_for_pip_and_colcon() -> None:
    scripts = dict(stated()["ros-scripts"])
    setup = (ROOT / "spiral_gripper_ros" / "setup.py").read_text(encoding="utf-8")
    assert dict(re.findall(r'"(\w+) = ([\w.:]+)"', setup)) == scripts
    edge = (ROOT / "spiral_gripper" / "setup.py").read_text(encoding="utf-8")
    assert dict(re.findall(r'"([\w-]+) = ([\w.:]+)"', edge)) == stated()["scripts"]
    cmake = (ROOT / "packaging" / "pip.cmake").read_text(encoding="utf-8")
    assert set(re.search(r"foreach\(_executable (.+?)\)", cmake)[1].split()) == scripts.keys()
    # An installation that is older than the last new executable has fewer.
    installed = {
        (entry.name, entry.value)
        for entry in metadata.distribution("spiral-gripper").entry_points
        if entry.group == "console_scripts"
    }
    assert installed
    assert installed <= {*scripts.items(), *stated()["scripts"].items()}


def test_executables_lead_to_functions() -> None:
    for target in (stated()["scripts"] | stated()["ros-scripts"]).values():
        module, function = target.split(":")
        assert callable(getattr(importlib.import_module(module), function))


def test_packages_are_typed_and_indexed() -> None:
    for package in PYTHON_PACKAGES:
        assert (ROOT / package / package / "py.typed").is_file()
        assert (ROOT / package / "resource" / package).is_file()
        assert f'"{package}/{package}"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")


def test_root_does_not_stop_colcon() -> None:
    assert not [
        name for name in ("package.xml", "CMakeLists.txt", "setup.py") if (ROOT / name).exists()
    ]


def test_no_environment_of_another_ros_distribution() -> None:
    requirements = [
        *stated()["ros-dependencies"],
        *pyproject()["tool"]["scikit-build"]["build"]["requires"],
    ]
    distributions = {name.split("-")[1] for name in names(requirements) if name.startswith("ros-")}
    assert distributions == {"jazzy"}
