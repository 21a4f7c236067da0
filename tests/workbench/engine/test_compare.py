"""Difference of detections and dragged thresholds, against brute force and the detector itself."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.messages import Detection
from ods.workbench.engine.ping.analysis import PingAnalyzer
from ods.workbench.engine.ping.compare import difference
from ods.workbench.engine.ping.thresholds import setting_at, thresholds
from tests.workbench.engine.test_ping_analysis import data, pings, settings


def found(range_m: float, bearing_rad: float, radius_m: float) -> Detection:
    numbers = dict.fromkeys(Detection.__struct_fields__, 0.0)
    wanted: dict[str, Any] = numbers | {"range_m": range_m, "bearing_rad": bearing_rad, "radius_m": radius_m}
    return Detection(**wanted)


circles = st.lists(
    st.builds(found, st.floats(5.0, 9.0), st.floats(-0.4, 0.4), st.floats(0.05, 1.0)), min_size=0, max_size=4
)


@given(circles, circles)
def test_difference_against_brute_force(a: list[Detection], b: list[Detection]) -> None:
    def centre(one: Detection) -> tuple[float, float]:
        return one.range_m * math.cos(one.bearing_rad), one.range_m * math.sin(one.bearing_rad)

    apart = {
        (i, j): math.dist(centre(a[i]), centre(b[j])) / (a[i].radius_m + b[j].radius_m)
        for i, j in itertools.product(range(len(a)), range(len(b)))
    }
    expected = []
    while near := {pair: ratio for pair, ratio in apart.items() if ratio <= 1.0 - 1e-9}:
        best = min(near, key=lambda pair: (near[pair], pair))
        expected.append(best)
        apart = {pair: ratio for pair, ratio in apart.items() if pair[0] != best[0] and pair[1] != best[1]}
    reported = difference(a, b)
    assert reported.both == sorted(expected)
    assert reported.only_a == [i for i in range(len(a)) if i not in {pair[0] for pair in expected}]
    assert reported.only_b == [j for j in range(len(b)) if j not in {pair[1] for pair in expected}]


@pytest.mark.parametrize(
    "stage",
    [
        {"use": "detect.two_level", "high": 6.0, "low": 2.5, "follow": 0.0},
        {"use": "detect.two_level", "high": 4.0, "low": 4.0, "follow": 0.0},
        {"use": "detect.two_level", "high": 3.0, "low": 1.5, "levels": "background"},
        {"use": "detect.two_level", "high": 90.0, "low": 40.0, "levels": "absolute"},
        {"use": "detect.one_level", "level": 5.0, "follow": 0.0},
    ],
)
def test_a_dragged_level_becomes_the_setting_that_puts_it_there(stage: dict[str, Any]) -> None:
    analyzer = PingAnalyzer(data(pings()))
    look = analyzer.analyze(settings([stage]), 0).looks[-1]
    for threshold in thresholds(look, stage):
        assert threshold.draggable
        wanted_db = threshold.level_db + (1.5 if threshold.name != "low" else -1.5)
        value = setting_at(look, stage, wanted_db)
        moved = analyzer.analyze(settings([stage | {threshold.name: value}]), 0).looks[-1]
        assert moved.levels_db is not None
        reached = moved.levels_db[0 if threshold.name == "low" else 1]
        assert reached == pytest.approx(wanted_db, abs=0.12)


def test_levels_that_a_rate_tells_are_not_dragged() -> None:
    stage = {"use": "detect.cfar", "rate": 1e-4}
    look = PingAnalyzer(data(pings(1))).analyze(settings([stage]), 0).looks[-1]
    assert [each.draggable for each in thresholds(look, stage)] == [False, False]
    assert setting_at(look, stage, 3.0) is None
    assert np.isfinite([each.level_db for each in thresholds(look, stage)]).all()
