# SPDX-License-Identifier: Apache-2.0
"""Public names of a package, listed in its ``__init__.pyi`` and loaded when they are first used."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from pkgutil import get_data

_IMPORTED = re.compile(r"^from (\S+) import \(?\s*(\w+) as", re.MULTILINE)


def public_names(package: str) -> tuple[dict[str, str], Callable[[str], object]]:
    """Return the module of each public name, and the package's ``__getattr__``.

    Args:
        package: its ``__name__``.
    """
    stub = (get_data(package, "__init__.pyi") or b"").decode()
    modules = {name: module for module, name in _IMPORTED.findall(stub)}

    def load(name: str) -> object:
        """Load the module that holds a public name, and keep the name in the package."""
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value: object = getattr(import_module(modules[name]), name)
        setattr(import_module(package), name, value)
        return value

    return modules, load
