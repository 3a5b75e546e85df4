# SPDX-License-Identifier: Apache-2.0
"""Print requirements that pyproject.toml states, one a line, for the scripts beside this file.

Usage: requirements.py build|run|lower-bounds.  Python 3.10 needs the package tomli for it.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from ros_metadata import for_distribution


def requirements(pyproject: dict[str, Any], what: str) -> list[str]:
    """Return what a build needs, what a run needs, or the oldest versions allowed of the latter."""
    tool = pyproject["tool"]
    (stated,) = tool["dynamic-metadata"]
    if what == "build":
        return for_distribution(tool["scikit-build"]["build"]["requires"])
    if what == "run":
        return for_distribution([*stated["dependencies"], *stated["ros-dependencies"]])
    if what == "lower-bounds":
        extra = pyproject["project"]["optional-dependencies"]["plot"]
        return [line.replace(">=", "==") for line in [*stated["dependencies"], *extra]]
    raise SystemExit(__doc__)


if __name__ == "__main__":
    root = Path(__file__).resolve().parent.parent
    chosen = " ".join(sys.argv[1:])
    with (root / "pyproject.toml").open("rb") as file:
        sys.stdout.write("\n".join(requirements(tomllib.load(file), chosen)) + "\n")
