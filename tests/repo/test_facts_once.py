# SPDX-License-Identifier: Apache-2.0
"""Facts that several files must state agree: versions, requirements, interfaces, executables."""

import pkgutil
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

# import name -> what PyPI calls it
LIBRARIES = {
    **{name: name for name in ("click", "matplotlib", "numba", "numpy", "rich", "scipy")},
    "ruamel": "ruamel.yaml",
    "serial": "pyserial",
}
# Used by launch files, which are shipped for those who have them: not on PyPI.
NOT_ON_PYPI = {"launch", "launch_ros", "xacro"}
# Imported by name, where they are installed: none is on PyPI.
OPTIONAL = {"control_msgs", "tf2_msgs", "tf2_ros"}
# Used by the studio alone, where it was installed by pip: rosdep has no key for them.
PIP_ONLY = {"trimesh", "viser"}


def apt(name):
    """Return what apt and rosdep call what is imported by some name."""
    return f"python3-{LIBRARIES[name].removeprefix('py')}" if name in LIBRARIES else name


# What pyproject.toml hands to packaging/ros_metadata.py.
(STATED,) = pyproject()["tool"]["dynamic-metadata"]
EXTRAS = pyproject()["project"]["optional-dependencies"]


def names(requirements):
    """Return the names in requirement lines, without version bounds."""
    return {re.split(r"[<>=!~;\[ ]", line)[0] for line in requirements}


def dependencies(package, tag):
    """Return what a package.xml names under a tag."""
    return {element.text for element in package_xml(package).iter(tag)}


def read(*parts):
    """Return the text of a file below the root."""
    return ROOT.joinpath(*parts).read_text("utf-8")


def test_version_and_license_are_the_same_everywhere():
    project = pyproject()["project"]
    citation = YAML(typ="safe").load(read("CITATION.cff"))
    facts = [project["version"], project["license"]]
    assert [citation["version"], citation["license"]] == facts
    for package in PACKAGES:
        xml = package_xml(package)
        assert [xml.findtext("version"), xml.findtext("license")] == facts
    assert re.search(r"^## (\S+)", read("CHANGELOG.md"), re.MULTILINE)[1] == facts[0]
    assert metadata.version("spiral-gripper") == facts[0]


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_package_xml_names_what_is_imported_with_its_lower_bounds(package):
    expected = {apt(name) for name in external_imports(package) - PIP_ONLY}
    folder = ROOT / package
    shown = "".join(
        path.read_text("utf-8") for path in (*folder.glob("launch/*.py"), *folder.glob("rviz/*"))
    )
    expected |= set(re.findall(r'(?:package="|Class: )(\w+)["/]', shown))
    expected |= OPTIONAL if package == "spiral_gripper_ros" else set()
    found = dependencies(package, "depend") | dependencies(package, "exec_depend")
    assert found == expected - {package}
    lines = [*STATED["dependencies"], *EXTRAS["plot"], *EXTRAS["regulators"]]
    bounds = dict(line.split(">=") for line in lines)
    by_key = {apt(name): bounds[LIBRARIES[name]] for name in LIBRARIES}
    for element in package_xml(package).iter("exec_depend"):
        assert element.get("version_gte") == by_key.get(element.text), element.text


def test_pyproject_names_what_is_imported():
    imported = set().union(*map(external_imports, PYTHON_PACKAGES))
    libraries = {LIBRARIES[name] for name in imported & LIBRARIES.keys()}
    optional = names(EXTRAS["plot"] + EXTRAS["regulators"])
    assert names(STATED["dependencies"]) == libraries - optional
    assert names(EXTRAS["studio"]) >= PIP_ONLY
    ros = imported - LIBRARIES.keys() - set(PACKAGES) - NOT_ON_PYPI - PIP_ONLY
    run, build = REQUIRED
    assert wheels(ros) <= run
    assert {name.split("-")[1] for name in run | build if name.startswith("ros-")} == {"jazzy"}


def wheels(packages):
    """Return the wheels of ROS packages."""
    return {f"ros-jazzy-{name.replace('_', '-')}" for name in packages}


# What running and what building with ROS needs.
BUILD = pyproject()["tool"]["scikit-build"]["build"]["requires"]
REQUIRED = names(STATED["ros-dependencies"]), names(BUILD)


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_colcon_finds_the_tests_of_each_package_its_types_and_its_name(package):
    own, tests = read(package, "setup.cfg").partition("testpaths = ")[2].split()[:2]
    assert list((ROOT / package / tests).glob("test_*.py"))
    assert 'extras_require={"test": ["pytest"]}' in read(package, "setup.py")  # by this it knows
    assert {"python3-pytest", "python3-hypothesis"} <= dependencies(package, "test_depend")
    assert (ROOT / package / own / "py.typed").is_file()
    assert (ROOT / package / "resource" / package).is_file()


def test_cmake_lists_all_interfaces_and_the_packages_they_use():
    cmake = read("spiral_gripper_msgs", "CMakeLists.txt")
    call = re.search(r"rosidl_generate_interfaces\((.*?)DEPENDENCIES(.*?)\)", cmake, re.DOTALL)
    folder = ROOT / "spiral_gripper_msgs"
    paths = [path for kind in ("msg", "srv", "action") for path in folder.glob(f"{kind}/*.{kind}")]
    listed = {path.relative_to(folder).as_posix() for path in paths}
    assert set(re.findall(r'"(.+?)"', call[1])) == listed
    text = "".join(path.read_text("utf-8") for path in paths)
    fields = re.findall(r"^(\w+)/\w+(?:\[.*?\])?\s+\w+", text, re.MULTILINE)
    used = set(fields) - {"spiral_gripper_msgs"}
    assert set(call[2].split()) == used == dependencies("spiral_gripper_msgs", "depend")
    assert all(wheels(used) <= required for required in REQUIRED)


def test_executables_are_the_same_for_pip_and_colcon():
    scripts, ros = STATED["scripts"], STATED["ros-scripts"]
    for package, expected in (("spiral_gripper", scripts), ("spiral_gripper_ros", ros)):
        found = re.findall(r'"([\w-]+) = ([\w.:]+)"', read(package, "setup.py"))
        assert dict(found) == expected
    cmake = read("packaging", "pip.cmake")
    assert set(re.search(r"foreach\(_executable (.+?)\)", cmake)[1].split()) == ros.keys()
    for target in (scripts | ros).values():
        assert callable(pkgutil.resolve_name(target))
