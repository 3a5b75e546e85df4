# SPDX-License-Identifier: Apache-2.0
"""A design within limits of processor time and memory, for a worker process. No ROS."""

from __future__ import annotations

import math
import resource
import time

from spiral_core.design.procedure import design_gripper
from spiral_core.design.report import DesignReport
from spiral_core.design.requirement import DesignRequirement
from spiral_gripper_ros.planning.worker import EndedError

# A design with one tube and four angles takes seconds, and half a minute more where kernels are not
# compiled yet; the most processor time that is spent on one [s].
LONGEST_DESIGN = 300.0
# Memory that numpy, numba and the kernels do not reach by far [bytes].
LARGEST_MEMORY = 2_000_000_000


def design(requirement: DesignRequirement, longest: float = LONGEST_DESIGN) -> DesignReport:
    """Return the report on a requirement; to be called in a process that ends with it.

    Args:
        requirement: what is asked.
        longest: processor time after which the design is given up [s].

    Raises:
        SpiralError: there is no answer, or it needs too much time or memory.
    """
    begin = time.process_time()
    # The kernel's limits: of memory, and of a step that never ends.
    for limit, most in (
        (resource.RLIMIT_DATA, LARGEST_MEMORY),
        (resource.RLIMIT_CPU, math.ceil(begin + 2.0 * longest)),
    ):
        hard = resource.getrlimit(limit)[1]
        soft = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(limit, (soft, hard))

    def look(*_: object) -> None:
        """Give up between two steps: an exception in the midst of a kernel's return is fatal."""
        if time.process_time() - begin > longest:
            raise TimeoutError

    try:
        return design_gripper(requirement, look)
    except MemoryError:
        why = f"it needs more than {1e-9 * LARGEST_MEMORY:g} GB of memory"
    except TimeoutError:
        why = f"not done within {longest:g} s of processor time"
    raise EndedError(f"no design: {why}")
