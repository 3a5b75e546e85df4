# SPDX-License-Identifier: Apache-2.0
"""How often 95 % intervals hold the true constants: ``python -m benchmarks.calibration_coverage``.

Each case is a synthetic bench test of known constants, repeated with fresh random errors (seeded)
and fitted every time. ``docs/calibration.md`` states the range. A few minutes on one core.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import dataclass, replace

import numpy as np

from spiral_core import (
    Actuator,
    CalibrationModel,
    ExtensionReading,
    FiberAngles,
    FreeActuation,
    Gent,
    HyperelasticLaw,
    MooneyRivlin,
    NeoHookean,
    SpiralError,
    Tube,
    Yeoh,
    calibrate,
)

SEED = 20260103
TUBE = Tube(inner_radius=4.7625e-3, wall_thickness=0.79375e-3, length=0.1)


@dataclass(frozen=True, slots=True)
class Case:
    """One bench test: extension of a 100 mm section at evenly spaced pressures.

    Attributes:
        law: the true law; the same law is fitted.
        angles: of the two fiber families [deg].
        highest: pressure of the last reading [Pa].
        readings: how many.
        error: standard error of the extension [m].
        pressure_error: standard error of the pressure [Pa].
        outlier: what one reading, drawn by lot, is off by [m]; the fit is then the robust one.
    """

    law: HyperelasticLaw
    angles: tuple[float, float] = (75.0, -75.0)
    highest: float = 96.0e3
    readings: int = 12
    error: float = 2.0e-4
    pressure_error: float = 0.0
    outlier: float = 0.0

    @property
    def actuator(self) -> Actuator:
        """The true actuator."""
        alpha, beta = (math.radians(angle) for angle in self.angles)
        return Actuator(tube=TUBE, fibers=FiberAngles(alpha, beta), material=self.law)

    def bench_test(self, noise: np.random.Generator) -> list[ExtensionReading]:
        """Return the readings of one bench test."""
        actuation = FreeActuation(self.actuator.without_single_fibers())
        readings = []
        for pressure in np.linspace(self.highest / self.readings, self.highest, self.readings):
            true_pressure = pressure + self.pressure_error * noise.standard_normal()
            extension = TUBE.length * (actuation.stretch_from_pressure(true_pressure) - 1.0)
            extension += self.error * noise.standard_normal()
            readings.append(
                ExtensionReading(
                    float(pressure), float(extension), TUBE.length, self.error, self.pressure_error
                )
            )
        if self.outlier:
            spoiled = int(noise.integers(self.readings))
            extension = readings[spoiled].extension + self.outlier * noise.choice((-1.0, 1.0))
            readings[spoiled] = replace(readings[spoiled], extension=float(extension))
        return readings


MOONEY_RIVLIN = MooneyRivlin(c1=90.0e3, c2=40.0e3)
GENT = Gent(shear_modulus=260.0e3, extension_limit=3.0)
CASES = {
    "neo-Hookean": Case(NeoHookean(c1=130.0e3)),
    "neo-Hookean, 4 readings": Case(NeoHookean(c1=130.0e3), readings=4),
    "neo-Hookean, pressure ± 1 kPa": Case(NeoHookean(c1=130.0e3), pressure_error=1.0e3),
    "Mooney-Rivlin": Case(MOONEY_RIVLIN),
    "Mooney-Rivlin, spiral (88°, 60°)": Case(MOONEY_RIVLIN, angles=(88.0, 60.0)),
    "neo-Hookean, one reading off by 3 mm, robust": Case(NeoHookean(c1=130.0e3), outlier=3.0e-3),
    "Yeoh": Case(Yeoh(c1=130.0e3, c2=-10.0e3, c3=20.0e3)),
    "Gent": Case(GENT, highest=130.0e3),
}


def coverage(case: Case, tests: int) -> tuple[dict[str, float], int, float]:
    """Return the share of intervals that hold each constant, failed fits, and seconds a fit."""
    model, noise = CalibrationModel(case.actuator), np.random.default_rng(SEED)
    hits, failed, elapsed = dict.fromkeys(model.names, 0), 0, 0.0
    for _ in range(tests):
        readings = case.bench_test(noise)
        start = time.perf_counter()
        try:
            fit = calibrate(model, readings, robust=case.outlier > 0.0)
        except SpiralError:
            failed += 1
            continue
        finally:
            elapsed += time.perf_counter() - start
        for name in model.names:
            low, high = fit.interval(name)
            hits[name] += low <= getattr(case.law, name) <= high
    answered = tests - failed
    return {name: count / answered for name, count in hits.items()}, failed, elapsed / tests


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tests", type=int, default=1000, help="bench tests of each case")
    tests = parser.parse_args().tests
    print(f"| bench test ({tests} of each) | intervals that hold the truth | failed |")
    print("| --- | --- | --- |")
    seconds: dict[str, float] = {}
    for name, case in CASES.items():
        shares, failed, seconds[name] = coverage(case, tests)
        cells = ", ".join(f"{key} {100.0 * share:.1f} %" for key, share in shares.items())
        print(f"| {name} | {cells} | {failed} |", flush=True)
    for name, one in seconds.items():
        print(f"{name}: {1e3 * one:.0f} ms a fit")


if __name__ == "__main__":
    main()
