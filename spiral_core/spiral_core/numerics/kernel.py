# SPDX-License-Identifier: Apache-2.0
"""The one way this package compiles a numerical kernel.

Every compiled function goes through here, so that the options are stated once. numba keeps a cached
kernel for as long as the file that defines it is untouched, even if a kernel that it calls has
changed in another file. It names the cache's file after the kernel's qualified name. Here that name
ends with a digest of all files that kernels are made of: by convention those whose names begin with
an underscore, and ``rod/types.py`` (a test holds the convention).
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar, cast

import numba
from numba.core import event
from numba.core.codegen import get_host_cpu_features

from spiral_core.notice import TOLD

F = TypeVar("F", bound=Callable[..., object])
CORE = Path(__file__).parents[1]
KERNEL_FILES = [Path(__file__), CORE / "rod" / "types.py", *sorted(CORE.rglob("_[!_]*.py"))]
SOURCE_DIGEST = hashlib.sha256(b"".join(path.read_bytes() for path in KERNEL_FILES)).hexdigest()


class _Compilation(event.Listener):
    """Call the functions in ``TOLD``, once, when numba compiles."""

    def on_start(self, event: object) -> None:
        while TOLD:
            TOLD.pop()()

    def on_end(self, event: object) -> None:
        pass


event.register("numba:compile", _Compilation())  # type: ignore[no-untyped-call]


def compiled(function: F, *, inline: bool = False) -> F:
    """Return ``function`` compiled on first use, its machine code cached on disk.

    It runs outside Python's lock, with fused multiply-adds, division as numpy does it and no care
    for the sign of zero. Sums are *not* reordered: results do not depend on the compiler.
    """
    function.__qualname__ = f"{function.__name__}_{SOURCE_DIGEST[:12]}"
    compile_kernel = numba.njit(
        cache=True,
        nogil=True,
        error_model="numpy",
        fastmath={"contract", "nsz"},
        forceinline=inline,
    )
    return cast("F", compile_kernel(function))


def inlined(function: F) -> F:
    """Return ``function`` as :func:`compiled`, but inlined into its callers: for an element's."""
    return compiled(function, inline=True)


def processor_features() -> str:
    """Return what this processor can do, for which kernels are compiled."""
    return str(get_host_cpu_features())  # type: ignore[no-untyped-call]
