# SPDX-License-Identifier: Apache-2.0
"""Answers of the command line, recorded before a change and compared after it.

    python -m benchmarks.answers           compare with the recorded ones; exit code 1: one differs
    python -m benchmarks.answers --record  record those of the installed command line

Figures may differ by half a percent, or by a billionth where they are zero; keys may be added, none
may go.
"""

from __future__ import annotations

import argparse
import json
import math
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.progress import track

ROOT = Path(__file__).parents[1]
RECORDED = Path(__file__).parent / "results" / "answers.json"
COMMAND = Path(sys.executable).with_name("spiral-gripper")
TOLERANCE, NEAR_ZERO = 5e-3, 1e-9
UPRIGHT = "--gravity-direction -1 0 0"
TILTED = "--gravity-direction 0.866 0.5 0"
LIMITS = "--length-max '0.6 m' --strain-max 0.2 --pressure-max '90 kPa'"
DATA = "examples/data"
CALIBRATE = f"calibrate {DATA}/my_gripper.yaml --no-save"
QUESTIONS = (
    "wrap paper_design_70 --radius '20 mm'",
    "wrap paper_design_70 --radius '60 mm'",
    f"wrap paper_design_70 --radius '13.5 mm' {UPRIGHT}",
    "wrap prototype_p1 --radius '15 mm' --pressure '70 kPa'",
    f"wrap prototype_p2 --radius '12 mm' {TILTED} --object-axis 1 0 0",
    "shape paper_design_70 --pressure '40 kPa'",
    f"shape prototype_p1 --pressure '60 kPa' {TILTED}",
    "grip paper_design_70 --radius '20 mm'",
    "grip paper_design_70 --radius '13.1 mm' --payload '20 g'",
    f"grip paper_design_70 --radius '12 mm' {UPRIGHT}",
    "grip prototype_p1 --radius '15 mm' --friction 0.5 --every-direction",
    "grip prototype_p2 --radius '20 mm' --frictionless-closing",
    f"grip prototype_p1 --radius '16.5 mm' {TILTED} --object-axis 0 0 1",
    "grip paper_design_70 --radius '30 mm' --gravity-magnitude '0 m/s^2'",
    "design --radius-min '12 mm' --radius-max '25 mm' --tube '9.5 mm x 0.8 mm'",
    "design --radius-min '11 mm' --radius-max '30 mm' --prefer shortest --pressure-max '12 psi'",
    f"design --radius-min '20 mm' --radius-max '47 mm' --turns 1.1 --prefer shortest {LIMITS}",
    "design --radius-min '12 mm' --radius-max '25 mm' --payload '20 g'",
    "close paper_design_70 --radius '20 mm' --rate '20 kPa/s'",
    f"{CALIBRATE} {DATA}/bench_extension.csv {DATA}/bench_twist.csv",
    f"{CALIBRATE} {DATA}/bench_extension.csv {DATA}/bench_object_radius.csv --radius '20 mm'",
    f"{CALIBRATE} {DATA}/free_swing.csv --free-swing",
)


def ask(question: str) -> dict[str, Any]:
    """Return exit code, result and messages of a question to the command line."""
    run = subprocess.run(
        [COMMAND, *shlex.split(question), "--json"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    result = json.loads(run.stdout, parse_float=_short) if run.stdout.strip() else None
    return {"exit code": run.returncode, "result": result}


def _short(number: str) -> float:
    """Return a number to six digits, which is more than is compared."""
    return float(f"{float(number):.6g}")


def differences(before: object, after: object, key: str = "") -> Iterator[str]:
    """Yield what an answer no longer has, or has differently."""
    if isinstance(before, dict) and isinstance(after, dict):
        for name, value in before.items():
            if name in after:
                yield from differences(value, after[name], f"{key}.{name}")
            else:
                yield f"{key}.{name} has gone"
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        largest = max((abs(one) for one in before if _is_number(one)), default=0.0)
        for place, (one, other) in enumerate(zip(before, after, strict=True)):
            if not (_is_number(one) and _is_number(other)):
                yield from differences(one, other, f"{key}[{place}]")
            elif abs(one - other) > TOLERANCE * largest + NEAR_ZERO:
                yield f"{key}[{place}] was {one:.6g}, is {other:.6g}"
    elif isinstance(before, float) and isinstance(after, float):
        if not math.isclose(before, after, rel_tol=TOLERANCE, abs_tol=NEAR_ZERO):
            yield f"{key} was {before:.6g}, is {after:.6g}"
    elif before != after and not (isinstance(before, str) and isinstance(after, str)):
        yield f"{key} was {before!r}, is {after!r}"


def _is_number(value: object) -> bool:
    """Tell numbers from the rest of a result."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def main() -> None:
    """Record or compare."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--record", action="store_true", help="in place of comparing")
    if parser.parse_args().record:
        answers = {question: ask(question) for question in track(QUESTIONS)}
        lines = (f"{json.dumps(one)}: {json.dumps(answer)}" for one, answer in answers.items())
        RECORDED.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
        return
    if not RECORDED.exists():
        parser.error(f"{RECORDED} is not there: run with --record first, before the change")
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    differing = 0
    for question, before in recorded.items():
        found = list(differences(before, ask(question)))
        differing += bool(found)
        print(f"{'differs' if found else 'the same'}: {question}")
        for line in found:
            print(f"    {line}")
    sys.exit(1 if differing else 0)


if __name__ == "__main__":
    main()
