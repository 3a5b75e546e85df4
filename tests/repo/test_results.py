# SPDX-License-Identifier: Apache-2.0
"""What was measured is kept as strict JSON, which knows neither NaN nor infinity."""

import json
import math

import pytest
from repo.source_tree import ROOT

from benchmarks.report import as_json
from benchmarks.results import Section, Table


def strict(text: str) -> object:
    """Return what strict JSON holds."""

    def refuse(constant: str) -> None:
        raise ValueError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize("name", ["summary.json", "ros_summary.json"])
def test_the_results_are_strict_json(name: str) -> None:
    assert strict((ROOT / "benchmarks" / "results" / name).read_text(encoding="utf-8"))


def test_what_is_not_finite_is_written_as_null() -> None:
    goals = Table("goals", ("what",), (("is",),), "")
    values = {"nan": math.nan, "inf": -math.inf, "good": 1.5}
    written = strict(as_json({"machine": "one"}, goals, {"part": Section((goals,), values)}))
    assert isinstance(written, dict)
    assert written["sections"]["part"]["values"] == {"nan": None, "inf": None, "good": 1.5}
    assert written["machine"] == {"machine": "one"}
