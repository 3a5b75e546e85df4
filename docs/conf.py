# SPDX-License-Identifier: Apache-2.0
"""The documentation as a site: these pages, the reference of the public names, the interfaces.

``make docs`` builds it; a warning is an error. Equations become MathML and the search is in plain
JavaScript, so that the site works from a folder, without the internet.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterable
from importlib import import_module, metadata
from pathlib import Path
from types import ModuleType

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

import spiral_core
import spiral_gripper

HERE = Path(__file__).parent
EXAMPLES = HERE / "reference_examples"  # run by tests/edge/test_reference_examples.py
INTERFACES = HERE.parent / "spiral_gripper_msgs"

project = "spiral_gripper"
copyright = "spiral_gripper contributors"  # noqa: A001 - Sphinx' name
release = metadata.version("spiral-gripper")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = f"spiral_gripper {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
exclude_patterns = ["_site"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_type_aliases = {"Array": "Array", "ArrayLike": "ArrayLike"}
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
napoleon_use_ivar = True
napoleon_use_rtype = False

# One needs a running node, the others write into the repository.
NOT_RUN = {"grasp_with_python", "synthetic_bench_tests", "synthetic_free_swing"}
FOLDERS = {
    "actuator": "The actuator: from pressure to curvature and torsion",
    "rod": "The rod: certified static shapes",
    "wrap": "The wrap: a gripper and the pressure for an object",
    "grip": "The grip: contact, friction, what a gripper holds, and closing in real time",
    "design": "The design procedure",
    "calibration": "Calibration from bench measurements",
    "errors": "Errors",
}


def write_reference(app: Sphinx) -> None:
    """Write the reference pages: one for each folder of the core, the edge, the interfaces."""
    folder = Path(app.srcdir) / "reference"
    folder.mkdir(exist_ok=True)
    for name, title in FOLDERS.items():
        own = (n for n, module in spiral_core.MODULES.items() if module.split(".")[1] == name)
        entries = [_entry(spiral_core, n) for n in _listed(own)]
        _write(folder / f"{name}.rst", title, entries + _of_modules(name))
    entries = [_entry(spiral_gripper, name) for name in _listed(spiral_gripper.__all__)]
    _write(folder / "files.rst", "Gripper files and units", entries)
    blocks = []
    for path in sorted(INTERFACES.glob("*/*.[msa]*")):
        if path.suffix in {".msg", ".srv", ".action"}:
            text = path.read_text(encoding="utf-8").replace("\n", "\n   ")
            head = f"{path.stem} ({path.suffix[1:]})"
            blocks.append(f"{head}\n{'-' * len(head)}\n\n.. code-block:: text\n\n   {text}\n")
    _write(folder / "interfaces.rst", "ROS 2 interfaces", blocks)


def write_gallery(app: Sphinx) -> None:
    """Write the gallery: each example with what it prints and draws; one that fails is an error."""
    folder = Path(app.srcdir) / "figures" / "gallery"
    folder.mkdir(parents=True, exist_ok=True)
    parts = [
        "Gallery",
        "=======",
        "",
        "Examples of the repository, run while this page was built.",
        "",
    ]
    for path in sorted((HERE.parent / "examples").glob("*.py")):
        if path.stem in NOT_RUN:
            continue
        title, _, text = (
            ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        ).partition("\n")
        done = subprocess.run(
            [sys.executable, str(path), str(folder)], capture_output=True, text=True, check=True
        )
        parts += [title, "-" * len(title), text, "", f".. literalinclude:: ../examples/{path.name}"]
        parts += ["   :language: python", "   :start-at: import", "", ".. code-block:: text", ""]
        parts += [f"   {line}" for line in done.stdout.splitlines()] + [""]
        for picture in sorted(folder.glob("*.png")):
            if picture.stem in path.read_text(encoding="utf-8"):
                parts += [f".. image:: figures/gallery/{picture.name}", "   :width: 100%", ""]
    _write(Path(app.srcdir) / "gallery.rst", "", parts)


def _listed(names: Iterable[str]) -> list[str]:
    """Return public names in order: functions first, then the values they take and return."""
    return sorted(names, key=lambda name: (name[0].isupper(), name))


def _of_modules(folder: str) -> list[str]:
    """Return what examples import from the modules of a folder: results, and rarer functions."""
    pattern = rf"^>>> from (spiral_core\.{folder}\b\S*) import (?:\(([^)]*)\)|(.+))$"
    modules = {}
    for path in sorted(EXAMPLES.glob("*.txt")):
        for module, *names in re.findall(pattern, path.read_text(encoding="utf-8"), re.MULTILINE):
            modules |= dict.fromkeys(re.findall(r"\w+", "".join(names)), module)
    title = "In their modules: results, and rarer functions"
    entries = [_entry(import_module(modules[name]), name) for name in _listed(modules)]
    return [f"{title}\n{'-' * len(title)}\n", *entries] if entries else []


def _entry(package: ModuleType, name: str) -> str:
    """Return the directive that documents a public name."""
    value = getattr(package, name)
    kind, options = "data", ""
    if isinstance(value, type) and issubclass(value, Exception):
        kind, options = "exception", "   :members:\n"
    elif isinstance(value, type):
        kind, options = "class", "   :members:\n"
        bases = [one for one in value.__mro__[1:] if one.__module__.startswith("spiral_core")]
        if any(not getattr(base, "_is_protocol", False) for base in bases):
            options += "   :inherited-members:\n"
    elif callable(value):
        kind = "function"
    entry = f".. auto{kind}:: {package.__name__}.{name}\n{options}"
    shown = "" if ">>>" in (value.__doc__ or "") else example_of(name)
    return f"{entry}\n{shown}" if shown else entry


def example_of(name: str) -> str:
    """Return the shortest worked example that uses a public name, as a block of the reference."""
    found = []
    for path in sorted(EXAMPLES.glob("*.txt")):
        pieces = re.split(r"^(.+)\n-+\n", path.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
        (_, setup), *worked = zip(pieces[::2], pieces[1::2], strict=True)
        for title, code in [("", ""), *worked]:
            if re.search(rf"\b{name}\b", code or setup):
                found.append((len(code), title, f"{setup.strip()}\n{code.strip()}".strip()))
    if not found:
        return ""
    _, title, code = min(found)
    block = "\n".join(f"   {line}" for line in code.splitlines())
    return (
        f".. rubric:: Example{f': {title}' if title else ''}\n\n.. code-block:: pycon\n\n{block}\n"
    )


def _write(path: Path, title: str, entries: list[str]) -> None:
    """Write a page if it has changed, so that nothing else is read again."""
    text = "\n".join([title, "=" * len(title), "", *entries] if title else entries)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def visit_math(self: HTML5Translator, node: nodes.math) -> None:
    """Write an equation inside a line."""
    self.body.append(convert(node.astext()))
    raise nodes.SkipNode


def visit_math_block(self: HTML5Translator, node: nodes.math_block) -> None:
    """Write an equation on a line of its own."""
    self.body.append(f'<div class="equation">{convert(node.astext(), display="block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Tell Sphinx of the above."""
    app.connect("builder-inited", write_reference)
    app.connect("builder-inited", write_gallery)
    app.add_node(nodes.math, override=True, html=(visit_math, None))
    app.add_node(nodes.math_block, override=True, html=(visit_math_block, None))
