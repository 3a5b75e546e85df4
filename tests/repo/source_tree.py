# SPDX-License-Identifier: Apache-2.0
"""Read the repository as data: its imports, its packages, its build files. For the tests here."""

import ast
import contextlib
import io
import re
import sys
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # pytest brings it

ROOT = Path(__file__).resolve().parents[2]
PYTHON_PACKAGES = ("spiral_core", "spiral_gripper", "spiral_gripper_ros")
PACKAGES = (*PYTHON_PACKAGES, "spiral_gripper_msgs")
# Language and text of a page's blocks.
FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def printed_by_python(text):
    """Run a page's block of Python and return what it prints."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(text, "page", "exec"), {"__name__": "__main__"})
    return output.getvalue()


def modules(package):
    """Return the modules of one of our Python packages: dotted name below the package -> file."""
    folder = ROOT / package / package
    return {
        ".".join(path.relative_to(folder).with_suffix("").parts): path
        for path in sorted(folder.rglob("*.py"))
    }


@cache
def imports(path):
    """Return the dotted names a file imports; ``from a import b`` gives ``a.b``.

    Imports inside functions, and those for type checkers alone, are dependencies too.
    """
    names = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import | ast.ImportFrom):
            above = f"{node.module}." if isinstance(node, ast.ImportFrom) else ""
            names |= {above + alias.name for alias in node.names}
    return names


def internal_imports(package, path):
    """Return the modules of the same package a file imports; ``__init__`` for its namespace."""
    known, found = modules(package), set()
    for name in imports(path):
        top, *rest = name.split(".")
        if top == package:
            within = (".".join(rest[:depth]) for depth in range(len(rest), 0, -1))
            found.add(next((module for module in within if module in known), "__init__"))
    return found


def external_imports(package):
    """Return the top-level names a package imports that are neither its own nor Python's."""
    return foreign(package, *modules(package).values(), *(ROOT / package).glob("launch/*.py"))


def foreign(package, *paths):
    """Return the top-level names files of a package import, neither its own nor Python's."""
    tops = {name.partition(".")[0] for path in paths for name in imports(path)}
    return tops - sys.stdlib_module_names - {package}


def pyproject():
    """Return the parsed ``pyproject.toml``."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


def package_xml(package):
    """Return the root element of a package's ``package.xml``."""
    return ElementTree.parse(ROOT / package / "package.xml").getroot()
