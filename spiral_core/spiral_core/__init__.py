# SPDX-License-Identifier: Apache-2.0
"""Mechanics of pneumatic spiral grippers: pure functions on immutable values, SI units.

Every public name can be imported from here and is loaded when it is first used, so that
``import spiral_core`` stays light. Names are added to ``__init__.pyi``, which type checkers read.
"""

from spiral_core.lazy import public_names

MODULES, __getattr__ = public_names(__name__)
__all__ = sorted(MODULES)  # noqa: PLE0605 - computed, so that no name is stated twice


def __dir__() -> list[str]:
    """Return the public names."""
    return list(__all__)
