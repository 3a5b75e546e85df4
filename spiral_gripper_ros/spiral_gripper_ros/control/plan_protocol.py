"""What the control logic needs to know of plans, and of who makes them."""

from __future__ import annotations

from typing import Protocol, TypeVar


class Plan(Protocol):
    """A planned wrap."""

    @property
    def pressure(self) -> float:
        """Gauge pressure of the perfect wrap [Pa]."""
        ...


PlanT = TypeVar("PlanT", bound=Plan)
PlanT_co = TypeVar("PlanT_co", bound=Plan, covariant=True)


class Planner(Protocol[PlanT_co]):
    """Turns a radius into a plan, for one gripper and one gravity."""

    @property
    def radius_range(self) -> tuple[float, float]:
        """Smallest and largest radius that can be gripped [m]."""
        ...

    def plan(self, radius: float) -> PlanT_co:
        """Return the perfect wrap for a radius [m]; raise a ``SpiralError`` if there is none."""
        ...
