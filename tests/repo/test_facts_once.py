# SPDX-License-Identifier: Apache-2.0
"""Facts that several files must state agree: versions, requirements, interfaces, executables."""

import pkgutil
import re
from importlib import metadata

from repo.source_tree import (
    PACKAGES,
    PYTHON_PACKAGES,
    ROOT,
    external_imports,
    package_xml,
    pyproject,
)
from ruamel.yaml import YAML

# Used by launch files, which are shipped for those who have them: not on PyPI.
NOT_ON_PYPI = {"launch", "launch_ros", "xacro"}
# Imported by name, where they are installed: none is on PyPI.
OPTIONAL = {"control_msgs", "tf2_msgs", "tf2_ros"}
# Used by the studio alone, where it was installed by pip: rosdep has no key for them.
PIP_ONLY = {"trimesh", "viser"}

# What pyproject.toml hands to packaging/ros_metadata.py.
(STATED,) = pyproject()["tool"]["dynamic-metadata"]
EXTRAS = pyproject()["project"]["optional-dependencies"]


def library(line):
    """Return a requirement's import name; what apt and rosdep call it, with the lower bound."""
    name, bound = line.removeprefix("py").split(">=")
    return name.removesuffix(".yaml"), (f"python3-{name}", bound)


LIBRARIES = dict(map(library, STATED["dependencies"] + EXTRAS["plot"] + EXTRAS["regulators"]))
LIBRARIES["matplotlib"] = "python3-matplotlib", "3.6.3"  # Ubuntu 24.04's draws, too


def names(requirements):
    """Return the names in requirement lines, without version bounds."""
    return {re.split(r"[<>=!~;\[ ]", line)[0] for line in requirements}


# What running and what building with ROS needs.
BUILD = pyproject()["tool"]["scikit-build"]["build"]["requires"]
REQUIRED = names(STATED["ros-dependencies"]), names(BUILD)


def wheels(packages):
    """Return the wheels of ROS packages."""
    return {f"ros-jazzy-{name.replace('_', '-')}" for name in packages}


def dependencies(package, *tags):
    """Return what a package.xml names under tags, with the lower bounds."""
    elements = (each for tag in tags for each in package_xml(package).iter(tag))
    return {element.text: element.get("version_gte") for element in elements}


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


def test_package_xml_names_what_is_imported_with_its_lower_bounds_and_its_tests():
    for package in PYTHON_PACKAGES:
        folder = ROOT / package
        paths = *folder.glob("launch/*.py"), *folder.glob("rviz/*")
        shown = "".join(path.read_text("utf-8") for path in paths)
        used = external_imports(package) | {*re.findall(r'(?:package="|Class: )(\w+)["/]', shown)}
        used |= OPTIONAL if package == "spiral_gripper_ros" else set()
        expected = dict(LIBRARIES.get(name, (name, None)) for name in used - PIP_ONLY - {package})
        assert dependencies(package, "depend", "exec_depend") == expected
        tested = dependencies(package, "test_depend").keys()
        assert tested >= {"python3-pytest", "python3-hypothesis"}
        assert 'extras_require={"test": ["pytest"]}' in read(package, "setup.py")  # colcon: tested
        own, tests = read(package, "setup.cfg").partition("testpaths = ")[2].split()[:2]
        assert list((folder / tests).glob("test_*.py"))
        assert (folder / own / "py.typed").is_file()


def test_pyproject_names_what_is_imported():
    imported = set().union(*map(external_imports, PYTHON_PACKAGES))
    assert imported >= LIBRARIES.keys()
    assert names(EXTRAS["studio"]) >= PIP_ONLY
    run, build = REQUIRED
    ros = imported - LIBRARIES.keys() - {*PACKAGES} - NOT_ON_PYPI - PIP_ONLY
    assert wheels(ros) <= run
    assert {*re.findall(r"\bros-(\w+)-", " ".join(run | build))} == {"jazzy"}


def test_cmake_lists_all_interfaces_and_the_packages_they_use():
    cmake = read("spiral_gripper_msgs", "CMakeLists.txt")
    call = re.search(r"rosidl_generate_interfaces\((.*?)DEPENDENCIES(.*?)\)", cmake, re.DOTALL)
    folder = ROOT / "spiral_gripper_msgs"
    texts = {
        path.relative_to(folder).as_posix(): path.read_text("utf-8")
        for kind in ("msg", "srv", "action")
        for path in folder.glob(f"{kind}/*.{kind}")
    }
    assert set(re.findall(r'"(.+?)"', call[1])) == texts.keys()
    text = "".join(texts.values())
    fields = re.findall(r"^(\w+)/\w+(?:\[.*?\])?\s+\w+", text, re.MULTILINE)
    used = set(fields) - {"spiral_gripper_msgs"}
    assert set(call[2].split()) == used == dependencies("spiral_gripper_msgs", "depend").keys()
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
