# SPDX-License-Identifier: Apache-2.0
"""The one way this package compiles a numerical kernel.

Every compiled function goes through here, so that the options are stated once: cached on disk (the
second process starts warm), running outside Python's lock, division as numpy does it (no branch on
zero), fused multiply-adds, no care for the sign of zero. Reordering of sums is *not* allowed, so
that results do not depend on the compiler's taste.

numba keeps a cached kernel for as long as the file that defines it is untouched, even if a kernel
that it calls has changed in another file. numba names the cache's file after the kernel's qualified
name. Here that name ends with a digest of the kernel's content: its bytecode, the constants and the
fields of the tuples it names and, through their digests, all kernels it calls.
"""

import builtins
import dis
import hashlib
from collections.abc import Callable
from functools import cache
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np
from numba.core import event
from numba.core.codegen import get_host_cpu_features
from numba.core.registry import CPUDispatcher
from numba.extending import typeof_impl

from spiral_core.notice import TOLD

P = ParamSpec("P")
R = TypeVar("R")

FAST_MATH = {"contract", "nsz"}
# numba's options that leave out a kernel's entries, the one for Python and the one for C.
WITHOUT_ENTRY: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# Of the digest in a file's name: 48 bits tell all versions of a kernel apart.
STAMP_DIGITS = 12


class Inner:
    """A kernel without an entry of its own; called from Python, it runs as Python.

    The entry takes tuples and arrays apart: a third of what a small kernel's compilation costs.
    """

    def __init__(self, kernel: CPUDispatcher) -> None:
        self.kernel = kernel
        self.py_func = kernel.py_func

    def __call__(self, *args: object) -> object:
        """Return what the Python function gives."""
        return self.py_func(*args)


@typeof_impl.register(Inner)
def _type_of_inner(value: Inner, context: object) -> object:
    """Let numba see the kernel where a caller names the object."""
    return typeof_impl(value.kernel, context)


class _Compilation(event.Listener):
    """Tell who wants to know, once, that numba compiles."""

    def on_start(self, event: object) -> None:
        """Tell."""
        while TOLD:
            TOLD.pop()()

    def on_end(self, event: object) -> None:
        """Do nothing."""


event.register("numba:compile", _Compilation())  # type: ignore[no-untyped-call]


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Return ``function`` compiled on first use, its machine code cached on disk."""
    compile_kernel = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
    return cast("Callable[P, R]", compile_kernel(_stamped(function)))


def called(function: Callable[P, R]) -> Callable[P, R]:
    """Return ``function`` compiled for other kernels to call; called from Python it is Python."""
    return _without_entry(function, forceinline=False)


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """Return ``function`` compiled into its callers, as :func:`called`: for a few operations."""
    return _without_entry(function, forceinline=True)


def merged(function: Callable[P, R]) -> Callable[P, R]:
    """Return ``function`` written into its callers before they are compiled.

    A compiled caller holds the machine code of all that it calls. Each level of calls between an
    entry and a large kernel costs the compilation of that kernel once more: levels in between are
    merged.
    """
    compile_kernel = numba.njit(inline="always", error_model="numpy", fastmath=FAST_MATH)
    return cast("Callable[P, R]", compile_kernel(function))


def processor_features() -> str:
    """Return what this processor can do, for which kernels are compiled."""
    return str(get_host_cpu_features())  # type: ignore[no-untyped-call]


@cache
def content_stamp(function: Callable[..., object]) -> str:
    """Return a digest of all that a kernel's machine code depends on, its callees included.

    Raises:
        NameError: the kernel reads a name that is not defined yet; define callees above callers.
    """
    code = function.__code__
    digest = hashlib.sha256(code.co_code)
    digest.update(repr((code.co_consts, code.co_names, code.co_varnames)).encode())
    for name in sorted(_global_names(function)):
        value = function.__globals__[name]
        if isinstance(value, (CPUDispatcher, Inner)):
            digest.update(content_stamp(value.py_func).encode())
        elif isinstance(value, (bool, int, float, str, tuple, np.generic)):
            digest.update(repr(value).encode())
        elif isinstance(value, type):
            digest.update(repr(getattr(value, "_fields", ())).encode())
    return digest.hexdigest()


def _global_names(function: Callable[..., object]) -> set[str]:
    """Return the module-level names that a kernel reads."""
    read = {step.argval for step in dis.get_instructions(function) if step.opname == "LOAD_GLOBAL"}
    missing = read - function.__globals__.keys() - vars(builtins).keys()
    if missing:
        raise NameError(f"{function.__name__} is compiled before {', '.join(sorted(missing))}")
    return read - vars(builtins).keys()


def _without_entry(function: Callable[P, R], *, forceinline: bool) -> Callable[P, R]:
    """Return ``function`` compiled, but with no entry for Python."""
    compile_kernel = numba.njit(
        cache=True,
        forceinline=forceinline,
        error_model="numpy",
        fastmath=FAST_MATH,
        **WITHOUT_ENTRY,
    )
    kind = "i" if forceinline else "c"
    return cast("Callable[P, R]", Inner(compile_kernel(_stamped(function, kind))))


def _stamped(function: Callable[P, R], kind: str = "") -> Callable[P, R]:
    """Return the function with its content in its qualified name, and how it is compiled."""
    stamp = content_stamp(function)[:STAMP_DIGITS]
    function.__qualname__ = f"{function.__name__}_{stamp}{kind}"
    return function
