"""Stand-ins for what the supervisor is given: a planner whose answers are known by heart."""

from dataclasses import dataclass

from spiral_core import NotGrippableError
from spiral_core.errors import SpiralError


@dataclass(frozen=True)
class FakePlan:
    pressure: float


class FakePlanner:
    """Wraps radii from 10 to 40 mm with 1000 Pa m / radius: 100 kPa to 25 kPa."""

    radius_range = (0.01, 0.04)

    def __init__(self, product: float = 1.0e3) -> None:
        self.product = product
        self.asked: list[float] = []
        self.error: SpiralError | None = None

    def plan(self, radius: float) -> FakePlan:
        self.asked.append(radius)
        if self.error is not None:
            raise self.error
        low, high = self.radius_range
        if not low <= radius <= high:
            raise NotGrippableError(radius, "out of range", -1.0, low if radius < low else high)
        return FakePlan(self.product / radius)
