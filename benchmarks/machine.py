# SPDX-License-Identifier: Apache-2.0
"""The machine that measured, without its name."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

# Of both suites.
LIBRARIES = ("numpy", "scipy", "numba")


def describe(libraries: Iterable[str]) -> dict[str, str]:
    """Return processor, cores, Python and library versions, and the load."""
    versions = {name: _version(name) for name in libraries}
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: version for name, version in versions.items() if version},
        "load of the machine at the start": f"{os.getloadavg()[0]:.1f}",
    }


def _version(name: str) -> str:
    """Return a library's version, or nothing if it is not installed."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def _processor() -> str:
    """Return the processor's name as the system tells it."""
    information = Path("/proc/cpuinfo")
    lines = information.read_text(encoding="utf-8").splitlines() if information.exists() else []
    fields = dict(line.split(":", 1) for line in lines if ":" in line)
    trimmed = {key.strip(): value.strip() for key, value in fields.items()}
    name = trimmed.get("model name", platform.processor())
    family, model = trimmed.get("cpu family"), trimmed.get("model")
    return f"{name} (family {family}, model {model})" if family else name
