# SPDX-License-Identifier: Apache-2.0
"""Two grips by an independent simulation: explicit, in time, with springs for everything.

The 70 degree gripper without weight closes without friction to 1.1 times the stretch that wraps the
object, whose friction then resists a pull away from the base. In a second run without friction the
stretch rises slowly until the coil lets go: the loss. :mod:`benchmarks.explicit` shares neither
code nor discretization with the solver.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from benchmarks.cases import OUTER_RADIUS, SECOND_MOMENT, Array, Vector
from benchmarks.explicit import AXIAL, Coil
from benchmarks.results import Effort, Section, Table, three_digits
from spiral_core import Cylinder, FiberAngles, Obstacle, Rod, RodProblem
from spiral_core import (
    Section as Stiffness,
)
from spiral_core.actuator.fibers import fiber_state
from spiral_core.rod.contact.solve import follow_contact, solve_contact

LENGTH, INNER, YOUNG = 0.36, 4.7625e-3, 0.78e6
ANGLES = FiberAngles(alpha=math.radians(88.0), beta=math.radians(70.0))
CASES = ((0.015, 0.3), (0.020, 0.3))  # radius [m] and friction
ELEMENTS, CLOSED, NEAR_LOSS, HIGHEST = 60, 1.1, 1.3, 1.7
PULL, PULL_STEP = 3e-3, 1e-3
# Steps of the explicit simulation: to close and to rest, for a millimeter of the pull, and for a
# hundredth of the stretch on the way to the loss. It is lost once this part of the contact is gone.
CLOSING_STEPS, PULL_STEPS, RAMP_STEPS = 150_000, 200_000, 60_000
STRETCH_STEP, GONE = 0.01, 0.5


@dataclass(frozen=True, slots=True)
class Found:
    """What one method finds.

    Args:
        contact: part of the length that touches.
        normal: sum of normal forces [N].
        pull: force on the object after the pull [N].
        loss: stretch beyond 1 over that of the wrap at which the coil lets go.
        spent: processor time [s].
    """

    contact: float
    normal: float
    pull: float
    loss: float
    spent: float


def rest_strain(stretch: float) -> Array:
    """Return torsion, 0, curvature (3,) [1/m] of the uniformly stretched 70 degree gripper."""
    return np.array((fiber_state(ANGLES, stretch).twist / INNER, 0.0, (stretch - 1.0) / INNER))


def wrap_stretch(radius: float) -> float:
    """Return the stretch at which the helix just fits a cylinder."""
    low, high = 1.02, 1.3
    for _ in range(60):
        middle = 0.5 * (low + high)
        torsion, _, curvature = rest_strain(middle)
        fits = curvature / (curvature**2 + torsion**2) - OUTER_RADIUS > radius
        low, high = (middle, high) if fits else (low, middle)
    return 0.5 * (low + high)


@dataclass(frozen=True, slots=True)
class Case:
    """The gripper at a cylinder.

    Args:
        radius: of the cylinder [m].
        friction: Coulomb's coefficient.
    """

    radius: float
    friction: float

    def strain(self, fraction: float) -> Array:
        """Return the rest strain (3,) at a fraction of the stretch that wraps."""
        return rest_strain(1.0 + fraction * (wrap_stretch(self.radius) - 1.0))

    @property
    def axis(self) -> Array:
        """Of the cylinder (3,)."""
        fits = self.strain(1.0)
        axis: Array = fits / np.linalg.norm(fits)
        return axis

    def problem(self, fraction: float, friction: float = 0.0, shift: float = 0.0) -> RodProblem:
        """Return the problem for our solver; the cylinder is shifted against its axis [m]."""
        bending = YOUNG * SECOND_MOMENT
        section = Stiffness((2.0 / 3.0 * bending, bending, bending), AXIAL, AXIAL)
        x, y, z = (np.array((0.0, self.radius + OUTER_RADIUS, 0.0)) - shift * self.axis).tolist()
        a, b, c = self.axis.tolist()
        u, v, w = self.strain(fraction).tolist()
        axis: Vector = (a, b, c)
        obstacle = Obstacle.along(Cylinder(self.radius), (x, y, z), axis, friction)
        rod = Rod(LENGTH, section, OUTER_RADIUS, (u, v, w))
        return RodProblem(rod, obstacles=(obstacle,))


def ours(case: Case) -> Found:
    """Return what the solver finds."""
    begin = time.process_time()
    closed = solve_contact(case.problem(CLOSED), elements=ELEMENTS)
    shifts = np.arange(0.0, PULL + 0.5 * PULL_STEP, PULL_STEP).tolist()
    pulled = follow_contact(
        [case.problem(CLOSED, case.friction, shift) for shift in shifts], start=closed
    ).states[-1]
    risen = follow_contact(
        [case.problem(HIGHEST)], start=closed, smallest_increment=2e-3, stop_at_event=True
    )
    loss = math.nan
    if risen.events:
        loss = CLOSED + risen.events[0].position * (HIGHEST - CLOSED)
    return Found(
        float(closed.contact_lengths[0]) / LENGTH,
        float(closed.normal_forces.sum()),
        abs(float(pulled.on_obstacle().force @ case.axis)),
        loss,
        time.process_time() - begin,
    )


def theirs(case: Case, slowness: float = 1.0) -> Found:
    """Return what the explicit simulation finds; ``slowness`` scales the time that it takes."""
    begin = time.process_time()
    coil = _closed(case, slowness)
    _, normal = coil.go(int(slowness * CLOSING_STEPS))
    contact = coil.touching()
    coil.friction, coil.damping = case.friction, 30.0 * coil.damping
    along = 0.0
    for _ in range(round(PULL / PULL_STEP)):
        along, _ = coil.go(int(slowness * PULL_STEPS), move=-PULL_STEP)
    coil, fraction = _closed(case, slowness), NEAR_LOSS
    coil.go(int(slowness * CLOSING_STEPS), case.strain(fraction))
    while coil.touching() > GONE * contact and fraction < HIGHEST:
        fraction += STRETCH_STEP
        coil.go(int(slowness * RAMP_STEPS), case.strain(fraction))
    return Found(contact, normal, abs(along), fraction, time.process_time() - begin)


def _closed(case: Case, slowness: float) -> Coil:
    """Return the explicit coil on its cylinder, closed without friction, lightly damped."""
    stiffness = YOUNG * SECOND_MOMENT * np.array((2.0 / 3.0, 1.0, 1.0))
    coil = Coil(
        LENGTH, stiffness, OUTER_RADIUS, case.radius, case.strain(1.0), OUTER_RADIUS, ELEMENTS
    )
    coil.damping /= 30.0
    coil.go(int(slowness * CLOSING_STEPS), case.strain(CLOSED))
    return coil


def measure(effort: Effort) -> Section:
    """Compare both methods on the two grips; an effort without simulated time is no comparison."""
    slowness = 1.0 if effort.simulated >= 1.0 else 1e-3
    theirs(Case(*CASES[0]), 1e-4)  # compiles
    rows: list[tuple[str, ...]] = []
    ratios, apart = [], []
    for radius, friction in CASES:
        case = Case(radius, friction)
        ours(case)  # loads the kernels
        a, b = ours(case), theirs(case, slowness)
        pairs = (
            ("in contact, of the length", a.contact, b.contact),
            ("normal forces, sum [N]", a.normal, b.normal),
            ("... over the length in contact [N/m]", _line(a), _line(b)),
            ("force after a pull of 3 mm [N]", a.pull, b.pull),
            ("lets go at, over the wrap's stretch", a.loss, b.loss),
        )
        name = f"{1e3 * radius:.0f} mm, friction {friction:g}: "
        rows += [(name + what, f"{x:.3f}", f"{y:.3f}") for what, x, y in pairs]
        rows.append((name + "processor time", *(three_digits(each.spent) for each in (a, b))))
        ratios.append(b.spent / a.spent)
        apart.append(max(abs(y / x - 1.0) for x, y in ((a.normal, b.normal), (a.pull, b.pull))))
    note = (
        f"{ELEMENTS} elements each, the same stiffness against stretch and shear. The explicit "
        "simulation's contact is a penalty, and its coil needs time to fall: the loss, stepped in "
        f"hundredths, comes late. Its time is {min(ratios):.0f} to {max(ratios):.0f} times ours."
    )
    table = Table(
        "Two grips by an explicit simulation", ("what", "ours", "explicit"), tuple(rows), note
    )
    return Section((table,), {"apart": max(apart), "ratio": min(ratios)})


def _line(found: Found) -> float:
    """Return the mean line force [N/m]."""
    return found.normal / (found.contact * LENGTH) if found.contact else 0.0
